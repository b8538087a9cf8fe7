//! The commands for analyses from outside: what is typed, what comes out, and with which exit code.

#![cfg(feature = "cli")]

mod program;

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use program::{drawing, table, text, tribochaos};

#[track_caller]
fn assert_refused(folder: &Path, args: &[&str], reason: &str) {
    let output = tribochaos(folder, args);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {stderr}");
    assert!(stderr.contains(reason), "{args:?}: {reason} is not in: {stderr}");
}

#[track_caller]
fn run(folder: &Path, args: &[&str]) -> String {
    let output = drawing(folder, args);
    assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// The object that a command prints, after checking that the files it names are there.
#[track_caller]
fn object(folder: &Path, args: &[&str]) -> Value {
    let object: Value = serde_json::from_str(&run(folder, args)).unwrap();
    let files = object["files"].as_array().unwrap();
    assert!(!files.is_empty());
    for file in files {
        assert!(folder.join(file.as_str().unwrap()).is_file(), "{file}");
    }
    object
}

#[test]
fn melnikov_gives_the_threshold_and_the_extremes() {
    let folder = TempDir::new().unwrap();
    let found = object(folder.path(), &["melnikov", "--set", "h1=0.5", "--json"]);
    assert!((found["threshold"].as_f64().unwrap() - 3.6933).abs() < 6e-5);
    assert_eq!(found["threshold_parameter"], "zeta_k");
    assert_eq!(found["changes_sign"], true);
    let (names, rows) = table(&folder.path().join("outputs/melnikov.csv"));
    assert_eq!(names, "tau_0,melnikov");
    let least = rows.iter().map(|row| row[1]).fold(f64::INFINITY, f64::min);
    assert!((least - found["minimum"].as_f64().unwrap()).abs() < 1e-3);

    let args = [
        "melnikov",
        "--at",
        "zeta_k=3.2,3.81",
        "--set",
        "h1=0",
        "--threshold",
        "zeta_k=3:5",
        "--over",
        "h1=0:1:3",
        "--out",
        "two",
    ];
    let said = run(folder.path(), &args);
    assert!(
        said.contains("zeta_k = 3.304714") && said.contains("yes: chaos may occur"),
        "{said}"
    );
    let (names, rows) = table(&folder.path().join("two-threshold.csv"));
    assert_eq!(names, "h1,zeta_k_threshold,changes_sign_below,changes_sign_above");
    for (row, expected) in rows.iter().zip([3.3047, 3.6933, 3.9609]) {
        assert!((row[1] - expected).abs() < 6e-5);
        assert_eq!(row[2..], [0.0, 1.0]);
    }
}

/// Damping hinders chaos: M changes sign below a threshold in h1, not above one.
#[test]
fn melnikov_finds_where_the_change_of_sign_ends() {
    let folder = TempDir::new().unwrap();
    let args = ["melnikov", "--threshold", "h1=0:3"];
    let said = run(folder.path(), &[&args[..], &["--set", "zeta_k=3.9"]].concat());
    assert!(said.contains("M changes sign below h1 = 0.874028"), "{said}");
    let over = ["--over", "zeta_k=3.2:3.9:8", "--out", "over", "--json"];
    let found = object(folder.path(), &[&args[..], &over].concat());
    assert_eq!(found["threshold_kind"], "ceases");
    let curve = &found["curve"];
    assert_eq!((&curve["ceases"], &curve["never"]), (&6.into(), &2.into()));
    let (_, rows) = table(&folder.path().join("over-threshold.csv"));
    assert_eq!(rows[7][2..], [1.0, 0.0]);
    assert!((rows[7][1] - found["threshold"].as_f64().unwrap()).abs() < 1e-9);
    let svg = fs::read_to_string(folder.path().join("over-threshold.svg")).unwrap();
    assert!(!svg.contains("from here upward"), "the one curve is that of an end");
}

#[test]
fn melnikov_says_that_a_curve_is_empty() {
    let folder = TempDir::new().unwrap();
    for (range, place) in [("zeta_k=0:1", "nowhere"), ("zeta_k=5:6", "everywhere")] {
        let args = ["melnikov", "--threshold", range, "--over", "h1=0:1:3", "--force"];
        let output = tribochaos(folder.path(), &args);
        let said = format!("at 3 of 3 values M changes sign {place} for zeta_k from");
        assert!(text(&output.stdout).contains(&said), "{}", text(&output.stdout));
        let warned = text(&output.stderr);
        assert!(
            warned.contains("the curve is empty") && warned.contains(place),
            "{warned}"
        );
    }
}

#[test]
fn melnikov_refuses_what_has_no_meaning() {
    let folder = TempDir::new().unwrap();
    for (args, reason) in [
        (&["--set", "b=-1"][..], "b > 0"),
        (&["--set", "gamma=1.87"], "set gamma = 0 and k_w = 0"),
        (&["--threshold", "epsilon_0"], "does not depend on epsilon_0"),
        (&["--threshold", "zeta_k=2:1"], "lower one first"),
        (&["--over", "zeta_k=0:1:3"], "over zeta_k itself"),
        (&["--over", "epsilon=0.1:0.2:3"], "does not depend on epsilon"),
        (&["--at", "x0=1,2"], "does not depend on x0"),
        (&["--at", "epsilon_0=0.1,0.2"], "does not depend on epsilon_0"),
        (
            &["--threshold", "damping=0:1"],
            "a quantity of a machine, and there is none",
        ),
        (&["--at", "zeta_k="], "V1,V2"),
        (&["--at", "zeta_k=1,2", "--set", "zeta_k=3"], "leave one of the two out"),
        (&["--tau", "2:1"], "lower end first"),
        (&["--out", "folder/"], "names no file"),
    ] {
        assert_refused(folder.path(), &[&["melnikov"], args].concat(), reason);
    }
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        0,
        "nothing is left behind"
    );
}

#[test]
fn phase_draws_orbits_and_does_not_overwrite_others() {
    let folder = TempDir::new().unwrap();
    let args = ["phase", "--at", "zeta_k=3.5,3.9", "--transient-periods", "60"];
    run(folder.path(), &args);
    let (names, rows) = table(&folder.path().join("outputs/phase.csv"));
    assert_eq!(names, "x0,y0,zeta_k,tau,x,y,stroboscopic");
    assert_eq!(rows.iter().filter(|row| row[6] == 1.0).count(), 2 * 33);
    let svg = fs::read_to_string(folder.path().join("outputs/phase.svg")).unwrap();
    assert!(svg.contains("<svg") && svg.contains("3.9"));
    // the same again is allowed, another one is not
    run(folder.path(), &args);
    let other = ["phase", "--transient-periods", "60"];
    assert_refused(folder.path(), &other, "--force");
    run(folder.path(), &[&other[..], &["--force"]].concat());
    for (args, reason) in [
        (&["--start", "1"][..], "write X,Y"),
        (&["--start", "1,2000"], "out of range"),
        (&["--start", "1,0", "--set", "x0=1"], "leave x0, y0"),
        (&["--initial-states", "100"], "too many for one picture"),
        (&["--periods", "2"], "from 16"),
        (&["--set", "k_w=0.01"], "set k_w = 0"),
        (&["--at", "k_w=0,0.01"], "set k_w = 0"),
        (&["--at", "gamma=0,1.87", "--scheme", "taylor"], "leave --scheme out"),
    ] {
        assert_refused(folder.path(), &[&["phase", "--out", "p"], args].concat(), reason);
    }
}

/// The number of different states at drive phase 0, to three digits, of each value in the table.
fn stroboscopic_states(rows: &[Vec<f64>], value: f64) -> usize {
    let states = rows.iter().filter(|row| row[2] == value && row[6] == 1.0);
    let rounded = states.map(|row| [row[4], row[5]].map(|state| (state * 1e3).round() as i64));
    rounded.collect::<std::collections::BTreeSet<_>>().len()
}

#[test]
fn phase_carries_heat() {
    let folder = TempDir::new().unwrap();
    // the paper's figure 5.1: a subharmonic and a periodic motion
    let args = ["phase", "--preset", "paper", "--set", "k_w=0", "--at", "zeta_k=3.5,3.9"];
    let short = ["--transient-periods", "150", "--periods", "16", "--json"];
    let found = object(folder.path(), &[&args[..], &short].concat());
    assert!(
        found["orbits"]
            .as_array()
            .unwrap()
            .iter()
            .all(|orbit| orbit["status"] == "ok")
    );
    let (_, rows) = table(&folder.path().join("outputs/phase.csv"));
    assert_eq!(rows.iter().filter(|row| row[6] == 1.0).count(), 2 * 17);
    assert_eq!(
        (stroboscopic_states(&rows, 3.5), stroboscopic_states(&rows, 3.9)),
        (2, 1)
    );
    assert_eq!(
        (rows[0][3], rows[0][0]),
        (0.0, 0.0),
        "tau begins with what is shown, x0 is the preset's"
    );

    // the scheme is that of the values, whatever is set
    let args = ["phase", "--set", "zeta_k=3.9", "--at", "gamma=0,1.87", "--out", "gamma"];
    run(folder.path(), &[&args[..], &short].concat());
    let svg = fs::read_to_string(folder.path().join("gamma.svg")).unwrap();
    assert!(svg.contains("Radau"));
}

#[test]
fn phase_tells_how_an_orbit_ended() {
    let folder = TempDir::new().unwrap();
    let stiff = "--set f_0=1000 --set epsilon_0=1e-3 --set omega_k=0 --at zeta_k=0.2";
    for (args, ending) in [
        // too stiff for taylor, which leaves it to radau
        (format!("{stiff} --out t"), ""),
        (format!("{stiff} --out s --scheme radau"), ""),
        // without the cubic spring the saddle repels for ever
        (
            "--set b=-1 --out r --scheme radau".to_owned(),
            "from (0.1, 0) ran away at tau = ",
        ),
    ] {
        let typed: Vec<&str> = args.split(' ').collect();
        let output = tribochaos(folder.path(), &[&["phase"], &typed[..]].concat());
        let stderr = text(&output.stderr);
        assert!(output.status.success(), "{args}: {stderr}");
        assert!(
            stderr.contains(ending) && stderr.is_empty() == ending.is_empty(),
            "{args}: {stderr}"
        );
    }
}

#[test]
fn poincare_counts_its_states() {
    let folder = TempDir::new().unwrap();
    let args = ["poincare", "--points", "5000", "--transient-periods", "120", "--json"];
    let found = object(folder.path(), &args);
    assert_eq!(
        (found["points"].as_u64(), found["runaways"].as_u64()),
        (Some(5000), Some(0))
    );
    assert!(found["pixels"].as_u64().unwrap() > 500);
    assert_eq!(table(&folder.path().join("outputs/poincare.csv")).1.len(), 5000);
    for (args, reason) in [
        (&["--periods", "100"][..], "leave --periods out"),
        (&["--points", "0"], "0"),
        (&["--window", "1:0,0:1"], "no extent"),
        (&["--set", "k_w=0.01"], "set k_w = 0"),
    ] {
        assert_refused(folder.path(), &[&["poincare", "--out", "p"], args].concat(), reason);
    }
    // nothing to draw is a failure of the run
    let runaway = tribochaos(
        folder.path(),
        &["poincare", "--set", "b=-1", "--points", "1000", "--out", "r"],
    );
    assert_eq!(runaway.status.code(), Some(1));
    assert!(text(&runaway.stderr).contains("ran away"));
}

#[test]
fn poincare_tells_a_window_beside_the_attractor_from_a_cycle() {
    let folder = TempDir::new().unwrap();
    let small = ["poincare", "--points", "2000", "--transient-periods", "200"];
    for (args, missed, cycle) in [
        (&["--window", "5:6,5:6", "--out", "beside"][..], true, false),
        (&["--set", "zeta_k=3.5", "--out", "cycle"], false, true),
        (
            &["--set", "zeta_k=3.5", "--window", "5:6,5:6", "--out", "both"],
            true,
            true,
        ),
    ] {
        let said = run(folder.path(), &[&small[..], args].concat());
        assert_eq!(
            said.contains("no state lies in the window: all lie within --window "),
            missed,
            "{said}"
        );
        assert_eq!(said.contains("those of a cycle"), cycle, "{said}");
    }
}

#[test]
fn bifurcation_shows_states_over_an_axis() {
    let folder = TempDir::new().unwrap();
    let small = [
        "--x",
        "zeta_k=3.4:3.6:9",
        "--transient-periods",
        "80",
        "--periods",
        "16",
    ];
    let args = [
        &["bifurcation", "--json", "--start", "0.1,0", "--start", "-1,0"],
        &small[..],
    ]
    .concat();
    let found = object(folder.path(), &args);
    assert_eq!(found["states"], 9 * 2 * 16);
    let (names, rows) = table(&folder.path().join("outputs/bifurcation.csv"));
    assert_eq!((names.as_str(), rows.len()), ("zeta_k,x,y", 9 * 2 * 16));
    let followed = [
        &["bifurcation", "--follow", "down", "--show", "y", "--out", "down"],
        &small[..],
    ]
    .concat();
    assert!(run(folder.path(), &followed).contains("144 states over 9 values"));
    for (args, reason) in [
        (&["--follow", "sideways"][..], "up and down"),
        (&["--x", "x0=0:1:5"], "--start"),
        (&["--x", "zeta_k=0:12:1000000"], "too many"),
        (
            &["--x", "zeta_k=3:4:9", "--set", "zeta_k=2"],
            "leave one of the two out",
        ),
        (&["--limits", "1:0"], "lower one first"),
        (&["--show", "z"], "z"),
        (&["--set", "k_w=0.01"], "set k_w = 0"),
        (&["--follow", "up", "--set", "gamma=1.87"], "not the heat of the shaft"),
    ] {
        assert_refused(folder.path(), &[&["bifurcation", "--out", "b"], args].concat(), reason);
    }
}

#[test]
fn lyapunov_finds_onset_and_end_and_names_the_initial_state() {
    let folder = TempDir::new().unwrap();
    let args = ["lyapunov", "--x", "zeta_k=3.7:3.9:21", "--json"];
    let found = object(folder.path(), &args);
    let onset = &found["onset"];
    assert_eq!(
        (&onset["value"], &onset["uncertainty"]),
        (&3.8025.into(), &0.0025.into())
    );
    assert_eq!(onset["initial_state"], serde_json::json!([1.0, 0.0]));
    assert_eq!(found["end"], "at_highest");
    let error = |of: &Value| of["lyapunov_error"].as_f64().unwrap();
    // the definition's own error is as large as its exponent
    assert!(error(&onset["confirmation"]) < 0.5 * error(onset));
    let (names, rows) = table(&folder.path().join("outputs/lyapunov.csv"));
    assert!(names.starts_with("x0,y0,zeta_k,lambda_1,lambda_1_error,lambda_2,lambda_2_error,lambda_3"));
    assert_eq!(rows.len(), 3 * 21);
    assert!(
        rows.iter().all(|row| (row[3] + row[5] - row[8]).abs() < 1e-3),
        "sum = divergence"
    );
    let svg = fs::read_to_string(folder.path().join("outputs/lyapunov.svg")).unwrap();
    for words in [
        "each from 3 initial states",
        "the first at the least value with chaos",
        "(dashed)",
        "highest value",
    ] {
        assert!(svg.contains(words), "{words}");
    }

    let said = |args: &[&str]| {
        run(
            folder.path(),
            &[&["lyapunov", "--start", "1,0", "--force"], args].concat(),
        )
    };
    let everywhere = said(&["--x", "zeta_k=4.5:4.6:3", "--onset-spacing", "0.05"]);
    assert!(
        everywhere.contains("onset: chaos at the lowest value, zeta_k = 4.5, from (x, y) = (1, 0)")
            && everywhere.contains("end:   chaos at the highest value, zeta_k = 4.6"),
        "{everywhere}"
    );
    // damping ends chaos, whichever way the axis runs
    let ends = said(&["--x", "h1=0.64:0.5:3", "--onset-spacing", "0.02"]);
    assert!(
        ends.contains("onset: chaos at the lowest value, h1 = 0.5")
            && ends.contains("end:   chaos ends at h1 = 0.6 +- 0.02"),
        "{ends}"
    );
    let nowhere = said(&["--x", "zeta_k=1:2:5", "--onset-spacing", "0.1"]);
    assert!(
        nowhere.contains("onset: none of the initial states leads to chaos on the axis") && !nowhere.contains("end:"),
        "{nowhere}"
    );
    let worn = said(&["--set", "k_w=0.01", "--x", "zeta_k=3.5:3.9:2", "--periods", "16"]);
    assert!(
        worn.contains("onset: not looked for (with wear all motion is transient"),
        "{worn}"
    );
}

/// The axis tells the range alone.
#[test]
fn lyapunov_finds_one_onset_however_many_values_its_axis_has() {
    let folder = TempDir::new().unwrap();
    let bounds = |x: &str| {
        let args = ["lyapunov", "--x", x, "--start", "1,0", "--json", "--force"];
        let found = object(folder.path(), &args);
        (found["onset"].clone(), found["end"].clone())
    };
    let first = bounds("zeta_k=3:5:51");
    assert_eq!(first.0["value"], 3.8025);
    for x in ["zeta_k=3:5:201", "zeta_k=3:5:7", "zeta_k=5:3:2"] {
        assert_eq!(bounds(x), first, "{x}");
    }
}

#[test]
fn lyapunov_refuses_what_it_cannot_search_before_any_work() {
    let folder = TempDir::new().unwrap();
    for (args, reason) in [
        (
            &["--onset-spacing", "0"][..],
            "--onset-spacing 0 is out of range: it must be positive",
        ),
        (&["--onset-spacing", "nan"], "it must be positive"),
        (
            &["--x", "zeta_k=3:4:5", "--onset-spacing", "1.1"],
            "no more than the axis' range 1",
        ),
        (
            &["--x", "zeta_k=3:5:21", "--onset-spacing", "1e-9"],
            "--onset-spacing 1e-9 makes 2000000001 values on the axis' range 2, from each initial state (at most 100000)",
        ),
        (
            &["--x", "x0=0:1:5"],
            "x0 is varied: give initial states by --start, or use `map`",
        ),
        (&["--x", "y0=0:1:5"], "--start"),
        (&["--limits", "1:0"], "lower one first"),
        (
            &["--x", "zeta_k=3:5:100000"],
            "300000 exponents (100000 values from 3 initial states) are too many (at most 200000)",
        ),
    ] {
        assert_refused(folder.path(), &[&["lyapunov", "--out", "l"], args].concat(), reason);
    }
    // the whole range makes two values
    let widest = ["lyapunov", "--x", "zeta_k=0.5:0.75:2", "--onset-spacing", "0.25"];
    assert!(run(folder.path(), &widest).contains("on multiples of 0.25"));
}

#[test]
fn lyapunov_claims_nothing_of_points_that_were_not_measured() {
    let folder = TempDir::new().unwrap();
    // fixed steps, in a layer far too steep for them
    let args = [
        "lyapunov",
        "--set",
        "f_0=1000",
        "--scheme",
        "rk4",
        "--x",
        "zeta_k=3:4:3",
        "--onset-spacing",
        "0.5",
    ];
    let said = run(folder.path(), &args);
    assert!(
        said.contains("9 of 9 exponents were not measured, since their points are under-resolved")
            && said.contains("`tribochaos point` tells")
            && said.contains("onset: unknown, since nothing was measured"),
        "{said}"
    );
    let (_, rows) = table(&folder.path().join("outputs/lyapunov.csv"));
    assert!(rows.len() == 9 && rows.iter().all(|row| row[3..].iter().all(|value| value.is_nan())));
    let found = object(folder.path(), &[&args[..], &["--json"]].concat());
    assert_eq!(
        (&found["onset"], &found["under_resolved"], &found["runaways"]),
        (&"unknown".into(), &9.into(), &0.into())
    );

    let some = [
        "lyapunov",
        "--set",
        "zeta_k=1",
        "--x",
        "b=-1:1:3",
        "--onset-spacing",
        "1",
        "--out",
        "some",
    ];
    let said = run(folder.path(), &some);
    assert!(
        said.contains("none of the initial states leads to chaos where it was measured, which 6 of 9 points were not"),
        "{said}"
    );
    let svg = fs::read_to_string(folder.path().join("some.svg")).unwrap();
    assert!(svg.contains("Values without exponents: 2 ran away"));
}

#[test]
fn lyapunov_begins_where_a_preset_says() {
    let folder = TempDir::new().unwrap();
    let args = [
        "lyapunov",
        "--preset",
        "paper",
        "--x",
        "zeta_k=3.5:3.9:2",
        "--periods",
        "16",
    ];
    let found = object(folder.path(), &[&args[..], &["--json"]].concat());
    assert_eq!(found["starts"], serde_json::json!([[0.0, 0.0]]));
    let (names, rows) = table(&folder.path().join("outputs/lyapunov.csv"));
    // of finite time, without errors and classes
    assert_eq!((names.as_str(), rows.len()), ("x0,y0,zeta_k,lambda_1,lambda_3", 2));
    let svg = fs::read_to_string(folder.path().join("outputs/lyapunov.svg")).unwrap();
    assert!(svg.contains("16 forcing periods from the start") && !svg.contains("standard errors"));
    // --start goes over it
    let typed = ["--start", "0.1,0", "--out", "typed", "--json"];
    let found = object(folder.path(), &[&args[..], &typed].concat());
    assert_eq!(found["starts"], serde_json::json!([[0.1, 0.0]]));
    let help = text(&tribochaos(folder.path(), &["lyapunov", "--help"]).stdout);
    assert!(
        help.split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
            .contains("else 0.1,0 and 1,0 and -1,0")
    );
}

#[test]
fn lyapunov_names_the_exponents_that_there_are() {
    let folder = TempDir::new().unwrap();
    let args = [
        "lyapunov",
        "--set",
        "gamma=0.002",
        "--x",
        "zeta_k=3.5:3.6:2",
        "--start",
        "0.1,0",
    ];
    run(
        folder.path(),
        &[&args[..], &["--transient-periods", "30", "--periods", "16"]].concat(),
    );
    let (names, rows) = table(&folder.path().join("outputs/lyapunov.csv"));
    // with heat the divergence is not the sum of these exponents
    assert_eq!(
        names,
        "x0,y0,zeta_k,lambda_1,lambda_1_error,lambda_2,lambda_2_error,lambda_3,class"
    );
    assert!(rows.iter().flatten().all(|value| value.is_finite()));
    let svg = fs::read_to_string(folder.path().join("outputs/lyapunov.svg")).unwrap();
    assert!(svg.contains("λ₁ (bands: ± 2 standard errors)") && svg.contains("λ₂"));
}

#[test]
fn theory_is_drawn_over_maps_where_it_has_a_curve() {
    let folder = TempDir::new().unwrap();
    let settings = ["--backend", "cpu", "--transient-periods", "60", "--periods", "64"];
    let map = |axes: &[&'static str], out: &'static str| {
        [&["map", "--overlay", "melnikov", "--out", out], axes, &settings[..]].concat()
    };
    run(folder.path(), &map(&["--x", "zeta_k=3:5:8", "--y", "h1=0:1.5:6"], "m"));
    let with = fs::read(folder.path().join("m-lyapunov.png")).unwrap();
    run(folder.path(), &["render", "m.zarr"]);
    let without = fs::read(folder.path().join("m-lyapunov.png")).unwrap();
    assert_ne!(with, without);
    run(
        folder.path(),
        &["render", "m.zarr", "--overlay", "melnikov", "--out", "n"],
    );
    assert_eq!(fs::read(folder.path().join("n-lyapunov.png")).unwrap(), with);
    run(folder.path(), &map(&["--x", "omega_0=1:3:8", "--y", "h1=0:1.5:6"], "f"));
    for (x, y, reason) in [
        ("epsilon=0.05:0.2:3", "x0=0:1:3", "neither on epsilon nor on x0"),
        ("zeta_k=0:1:3", "h1=0:1:3", "nowhere"),
    ] {
        assert_refused(folder.path(), &map(&["--x", x, "--y", y], "q"), reason);
    }
    assert!(!folder.path().join("q.zarr").exists(), "refused before any work");
}

#[test]
fn reproduce_computes_what_is_not_current() {
    let folder = TempDir::new().unwrap();
    let args = ["reproduce", "--figure", "4.1", "--quick"];
    let said = run(folder.path(), &args);
    assert!(
        said.contains("| 4.1 | zeta_k from which M changes sign, h1 = 0.5 | 3.50 to 3.90 | 3.6933 | within |"),
        "{said}"
    );
    let path = |name: &str| folder.path().join("outputs/paper-quick").join(name);
    for name in [
        "figure-4.1.png",
        "figure-4.1.svg",
        "figure-4.1a.csv",
        "figure-4.1.json",
        "table.md",
    ] {
        assert!(path(name).is_file(), "{name}");
    }
    assert!(run(folder.path(), &args).contains("figure 4.1 is current"));
    fs::remove_file(path("figure-4.1.png")).unwrap();
    assert!(run(folder.path(), &args).contains("wrote outputs/paper-quick/figure-4.1.png"));

    // what was changed is no longer what was computed
    let picture = fs::read(path("figure-4.1.png")).unwrap();
    for (name, other) in [
        ("figure-4.1.png", &picture[..1000]),
        ("figure-4.1.svg", b"<svg/>"),
        ("figure-4.1b.csv", b"tau_0,M\n"),
    ] {
        fs::write(path(name), other).unwrap();
        assert!(run(folder.path(), &args).contains("wrote"), "{name}");
    }
    assert_eq!(fs::read(path("figure-4.1.png")).unwrap(), picture);

    // quick figures do not take the place of full ones unasked
    let full = ["reproduce", "--figure", "4.1"];
    run(folder.path(), &full);
    assert!(run(folder.path(), &args).contains("figure 4.1 is current"));
    assert!(run(folder.path(), &full).contains("figure 4.1 is current"));
    let over = [&args[..], &["--out", "outputs/paper"]].concat();
    assert_refused(folder.path(), &over, "holds the full figure 4.1");
    run(folder.path(), &[&over[..], &["--force"]].concat());

    assert_refused(folder.path(), &["reproduce", "--figure", "9.9"], "3.1, 3.2, 4.1");
    fs::write(folder.path().join("file"), "").unwrap();
    assert_refused(
        folder.path(),
        &["reproduce", "--out", "file/paper"],
        "cannot write file/paper/table.md",
    );
    assert_refused(folder.path(), &["reproduce", "--out", "file"], "is a file");
}

#[test]
fn bench_tells_what_kernels_cost_and_how_exact_they_are() {
    let folder = TempDir::new().unwrap();
    let said = run(
        folder.path(),
        &[
            "bench",
            "--backend",
            "cpu",
            "--scheme",
            "taylor",
            "--precision",
            "f64",
            "--json",
        ],
    );
    let object: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(object["default_scheme"], "taylor");
    let kernels = object["kernels"].as_array().unwrap();
    // one for every instruction set of this machine, the fastest first
    assert!(!kernels.is_empty());
    for kernel in kernels {
        assert_eq!(
            (
                &kernel["model"],
                &kernel["backend"],
                &kernel["precision"],
                &kernel["scheme"]
            ),
            (&"reduced".into(), &"cpu".into(), &"f64".into(), &"taylor".into())
        );
        assert!(kernel["lanes"].as_u64().unwrap() >= 2 && kernel["modes"].is_null());
        assert!(kernel["device"].as_str().unwrap().starts_with("CPU"));
        let number = |name: &str| kernel[name].as_f64().unwrap();
        assert!(number("ns_motion_alone") > 0.0 && number("ns_with_vectors") > 0.0);
        let mean = 0.5 * (number("ns_motion_alone") + number("ns_with_vectors"));
        assert!((number("ns_per_instance_period") - mean).abs() < 1e-6 * mean);
        assert!(number("exponent_error_median") <= 1e-7 && number("exponent_error_p99") <= 2e-5);
    }
    assert_refused(
        folder.path(),
        &["bench", "--backend", "gpu", "--precision", "f64"],
        "a GPU has only f32",
    );
    assert_refused(folder.path(), &["bench", "--tolerance", "1"], "tolerance");
}

#[test]
fn an_axis_goes_over_the_preset() {
    let folder = TempDir::new().unwrap();
    let args = [
        "bifurcation",
        "--preset",
        "paper",
        "--set",
        "k_w=0",
        "--x",
        "gamma=0.1:0.2:3",
    ];
    let short = ["--transient-periods", "4", "--periods", "16", "--out", "preset"];
    run(folder.path(), &[&args[..], &short].concat());
    let (names, rows) = table(&folder.path().join("preset.csv"));
    assert_eq!(names, "gamma,x,y");
    assert!((rows[0][0] - 0.1).abs() < 1e-12 && rows.iter().any(|row| (row[0] - 0.2).abs() < 1e-12));
}

#[test]
fn a_place_that_cannot_be_written_is_refused_before_any_work() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("file"), "precious").unwrap();
    // minutes of work each, were it begun
    for args in [
        &["lyapunov", "--x", "zeta_k=3:5:20000"][..],
        &["bifurcation", "--x", "zeta_k=3:5:20000"],
        &["phase", "--periods", "1000000"],
        &["poincare", "--points", "100000000"],
        &["melnikov", "--over", "h1=0:2:100000"],
        &["history", "--periods", "7000"],
        &["map", "--periods", "10000"],
        &["map", "--periods", "10000", "--dry-run"],
    ] {
        let args = [args, &["--out", "file/new/q"]].concat();
        assert_refused(folder.path(), &args, "cannot write file/new/q");
    }
    assert_refused(
        folder.path(),
        &["phase", "--out", "/proc/q"],
        "cannot write /proc/q.png",
    );
    assert_eq!(fs::read(folder.path().join("file")).unwrap(), b"precious");
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        1,
        "nothing is left behind"
    );
}

#[test]
fn point_tells_the_lifetime_of_chaos() {
    let folder = TempDir::new().unwrap();
    let at = [
        "point",
        "--set",
        "zeta_k=4.67",
        "--set",
        "h1=0.28",
        "--lifetime-periods",
        "1000",
    ];
    let found = object(folder.path(), &[&at[..], &["--lifetime", "300", "--json"]].concat());
    let lifetime = &found["lifetime"];
    let number = |name: &str| lifetime[name].as_f64().unwrap();
    assert_eq!(
        (found["status"].as_str(), lifetime["decay"].as_str()),
        (Some("ok"), Some("exponential"))
    );
    assert!((140.0..200.0).contains(&number("lifetime")) && number("ks_distance") < number("ks_limit"));
    assert!((number("lifetime_tau") / number("lifetime") - std::f64::consts::PI).abs() < 1e-9);
    let (names, rows) = table(&folder.path().join("outputs/lifetime.csv"));
    assert_eq!(names, "periods,states,fraction,fitted");
    assert_eq!(rows[0][..3], [0.0, 300.0, 1.0]);
    let last = &rows[rows.len() - 1];
    assert_eq!(last[..2], [1000.0, number("lasting")]);
    let from = rows.iter().find(|row| row[0] == number("start")).unwrap();
    assert_eq!((from[1], from[3]), (number("left"), from[2]));

    let said = run(folder.path(), &[&at[..], &["--lifetime", "300"]].concat());
    assert!(said.contains("class ") && said.contains("mean lifetime") && said.contains("wrote outputs/lifetime.png"));
    assert_refused(
        folder.path(),
        &[&at[..], &["--lifetime", "400"]].concat(),
        "shows something else",
    );
}

#[test]
fn point_says_where_chaos_has_no_lifetime() {
    let folder = TempDir::new().unwrap();
    let of = |zeta_k: &str| {
        let args = [
            "point",
            "--set",
            zeta_k,
            "--lifetime",
            "100",
            "--lifetime-periods",
            "300",
            "--force",
        ];
        run(folder.path(), &args)
    };
    let lasting = of("zeta_k=3.9");
    assert!(
        lasting.contains("with 95 % confidence") && lasting.contains("none settles until 300"),
        "{lasting}"
    );
    let regular = of("zeta_k=3.5");
    assert!(regular.contains("the states settle without chaos"), "{regular}");
}

#[test]
fn lifetimes_without_a_meaning_are_refused() {
    let folder = TempDir::new().unwrap();
    for (args, reason) in [
        (&["--lifetime", "10"][..], "100..=100000"),
        (&["--lifetime", "--lifetime-periods", "10"], "100..=200000"),
        (&["--lifetime-periods", "1000"], "--lifetime"),
        (&["--out", "x"], "--lifetime"),
        (&["--lifetime", "100000", "--lifetime-periods", "20000"], "fewer states"),
        (&["--lifetime", "--set", "zeta_k=0"], "without a drive"),
        (&["--lifetime", "--preset", "paper"], "set k_w = 0"),
        (&["--lifetime", "--out", "folder/"], "names no file"),
    ] {
        assert_refused(folder.path(), &[&["point"], args].concat(), reason);
    }
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        0,
        "nothing is left behind"
    );
}
