//! The program from outside: what is typed, what comes out, and with which exit code.

#![cfg(feature = "cli")]

mod program;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;
use tribochaos::experiment::{Integration, Sampling};

use program::{text, tribochaos};

/// Options for a map of a second.
const SMALL: [&str; 10] = [
    "--x",
    "zeta_k=3:5:12",
    "--y",
    "h1=0:1.5:8",
    "--backend",
    "cpu",
    "--transient-periods",
    "60",
    "--periods",
    "64",
];

fn small_map(folder: &Path, more: &[&str]) -> Output {
    tribochaos(folder, &[&["map"], &SMALL[..], more].concat())
}

#[track_caller]
fn assert_refused(output: &Output, reason: &str) {
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains(reason), "{reason} is not in: {stderr}");
}

#[test]
fn a_map_is_computed_stored_drawn_and_drawn_again() {
    let folder = TempDir::new().unwrap();
    let output = small_map(folder.path(), &[]);
    let stdout = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    for said in [
        "96 points",
        "class:",
        "status: ok 96",
        "instance-periods/s",
        "border of chaos: along zeta_k it begins",
        "sum of the exponents",
    ] {
        assert!(stdout.contains(said), "{said} is not in: {stdout}");
    }
    let path = |name: &str| folder.path().join(name);
    for name in [
        "outputs/map-lyapunov.png",
        "outputs/map-period.png",
        "outputs/map-border.csv",
        "outputs/map.zarr",
    ] {
        assert!(path(name).exists(), "{name}");
    }

    // drawn again it is the same picture; with other limits another one
    let before = fs::read(path("outputs/map-lyapunov.png")).unwrap();
    let again = tribochaos(folder.path(), &["render", "outputs/map.zarr"]);
    assert!(again.status.success());
    assert_eq!(fs::read(path("outputs/map-lyapunov.png")).unwrap(), before);
    let limits = [
        "render",
        "outputs/map.zarr",
        "--limits=-0.3:0.3",
        "--colours",
        "purple-green",
        "--out",
        "other/name",
    ];
    assert!(tribochaos(folder.path(), &limits).status.success());
    assert_ne!(fs::read(path("other/name-lyapunov.png")).unwrap(), before);
    let quantity = [
        "render",
        "outputs/map.zarr",
        "--quantity",
        "x_max",
        "--quantity",
        "class",
    ];
    assert!(tribochaos(folder.path(), &quantity).status.success());
    assert!(path("outputs/map-x_max.png").exists() && path("outputs/map-class.png").exists());

    // another style does not replace the map's own picture
    let styled = ["render", "outputs/map.zarr", "--colours", "purple-green"];
    assert_refused(&tribochaos(folder.path(), &styled), "is the map's own picture");
    let named = tribochaos(folder.path(), &[&styled[..], &["--out", "purple"]].concat());
    assert!(named.status.success() && path("purple-lyapunov.png").exists());

    // the picture carries the experiment
    let from = tribochaos(
        folder.path(),
        &[
            "map",
            "--from",
            "other/name-lyapunov.png",
            "--backend",
            "cpu",
            "--print-experiment",
        ],
    );
    let direct = small_map(folder.path(), &["--print-experiment"]);
    assert!(from.status.success());
    assert_eq!(text(&from.stdout), text(&direct.stdout));
}

/// Initial states tell attractors apart; that chaos is on one of two says nothing of where it begins.
#[test]
fn over_initial_states_chaos_has_no_border() {
    let folder = TempDir::new().unwrap();
    let over = SMALL.map(|word| if word.starts_with("h1") { "x0=-1:1:8" } else { word });
    let output = tribochaos(folder.path(), &[&["map"], &over[..]].concat());
    let stdout = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(
        stdout.contains("map-lyapunov.png") && !stdout.contains("border"),
        "{stdout}"
    );
    assert!(!folder.path().join("outputs/map-border.csv").exists());
}

#[test]
fn results_are_resumed_but_those_of_another_experiment_are_not_overwritten() {
    let folder = TempDir::new().unwrap();
    assert!(small_map(folder.path(), &[]).status.success());
    let same = small_map(folder.path(), &[]);
    assert!(text(&same.stdout).contains("in the store already"));
    let other = small_map(folder.path(), &["--set", "b=1.1"]);
    assert_refused(&other, "--force");
    assert!(
        small_map(folder.path(), &["--set", "b=1.1", "--force"])
            .status
            .success()
    );
    // nor is what is no store
    fs::create_dir_all(folder.path().join("thesis.zarr")).unwrap();
    fs::write(folder.path().join("thesis.zarr/chapter1"), "precious").unwrap();
    let output = small_map(folder.path(), &["--out", "thesis", "--force"]);
    assert_refused(&output, "no store");
    assert!(folder.path().join("thesis.zarr/chapter1").exists());
    fs::write(folder.path().join("thesis.zarr/zarr.json"), r#"{"node_type": "group"}"#).unwrap();
    assert_refused(&small_map(folder.path(), &["--out", "thesis", "--force"]), "no store");
    assert!(folder.path().join("thesis.zarr/chapter1").exists());
    fs::write(folder.path().join("table-border.csv"), "mine").unwrap();
    assert_refused(
        &small_map(folder.path(), &["--out", "table"]),
        "table-border.csv is there already",
    );
    // a drawing does not replace another experiment's either
    assert!(
        small_map(folder.path(), &["--set", "b=1.2", "--out", "other"])
            .status
            .success()
    );
    let drawn = tribochaos(folder.path(), &["render", "outputs/map.zarr", "--out", "other"]);
    assert_refused(&drawn, "another experiment");
    // pictures that lost their store are in the way as well
    fs::remove_dir_all(folder.path().join("outputs/map.zarr")).unwrap();
    assert_refused(&small_map(folder.path(), &[]), "another experiment");
}

#[test]
fn the_experiment_is_printed_alone_and_read_back() {
    let folder = TempDir::new().unwrap();
    let printed = tribochaos(folder.path(), &["map", "--set", "omega_0=1.7", "--print-experiment"]);
    assert!(printed.status.success() && printed.stderr.is_empty());
    fs::write(folder.path().join("e.toml"), &printed.stdout).unwrap();
    let again = tribochaos(folder.path(), &["map", "e.toml", "--print-experiment"]);
    assert_eq!(again.stdout, printed.stdout);
    assert!(text(&again.stdout).contains("omega_0 = 1.7"));
    // options override the file, and a parameter that becomes an axis loses its value
    let over = tribochaos(
        folder.path(),
        &[
            "map",
            "e.toml",
            "--x",
            "omega_0=1:2:5",
            "--periods",
            "99",
            "--print-experiment",
        ],
    );
    let over = text(&over.stdout);
    assert!(
        over.contains("periods = 99") && over.contains("zeta_k = 3.9") && !over.contains("omega_0 = "),
        "{over}"
    );
}

#[test]
fn a_dry_run_tells_the_time_and_writes_nothing() {
    let folder = TempDir::new().unwrap();
    let output = small_map(folder.path(), &["--dry-run"]);
    let stdout = text(&output.stdout);
    assert!(output.status.success());
    assert!(
        stdout.contains("about ") && stdout.contains("96 points") && stdout.contains("outputs/map.zarr"),
        "{stdout}"
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

fn point(args: &[&str]) -> Value {
    let folder = TempDir::new().unwrap();
    let output = tribochaos(folder.path(), &[&["point", "--json"], args].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_point_is_one_json_object() {
    let point = point(&["--set", "zeta_k=3.5", "--set", "h1=0.5"]);
    let keys: Vec<&str> = point.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(
        keys,
        [
            "parameters",
            "settings",
            "backend",
            "precision",
            "status",
            "class",
            "lyapunov",
            "lyapunov_error",
            "scheme_error",
            "lyapunov_interval",
            "lyapunov_second",
            "divergence",
            "period",
            "x",
            "y",
            "x_min",
            "x_max",
            "contact_status",
            "contact_time",
            "peak_pressure",
            "peak_pressure_time",
            "final_wear",
            "peak_temperature"
        ]
    );
    assert_eq!(point["class"], "regular");
    assert_eq!(point["period"], 1);
    assert_eq!(point["parameters"]["h1"], 0.5);
    assert!(
        point.get("gram_schmidt_spectrum").is_none(),
        "two answers to one question"
    );
}

#[test]
fn the_paper_s_procedure_is_told_on_request() {
    let point = point(&["--set", "zeta_k=3.5", "--gram-schmidt"]);
    let number = |value: &Value| value.as_f64().unwrap();
    // the paper's scheme with fine steps against the default one
    let spectrum = &point["gram_schmidt_spectrum"];
    assert!((number(&spectrum[0]) - number(&point["lyapunov"])).abs() < 5e-4);
    assert!((number(&spectrum[1]) - number(&point["lyapunov_second"])).abs() < 5e-4);
}

#[test]
fn what_does_not_apply_is_null() {
    // without the cubic drag, which is too stiff at the speed of a runaway
    let point = point(&["--set", "b=-1", "--set", "beta=0", "--set", "x0=2", "--set", "y0=1"]);
    assert_eq!(point["status"], "runaway");
    assert!(point["runaway_time"].as_f64().unwrap() > 0.0);
    for key in [
        "class",
        "lyapunov",
        "lyapunov_error",
        "lyapunov_second",
        "divergence",
        "period",
        "x",
        "x_max",
    ] {
        assert!(point[key].is_null(), "{key}: {}", point[key]);
    }
}

#[test]
fn tangent_vectors_that_overflow_are_no_result() {
    let stiff = [
        "x0=0",
        "y0=0",
        "zeta_k=0",
        "omega_k=0",
        "f_0=0",
        "epsilon=1000",
        "h1=-1000",
    ];
    let arguments: Vec<&str> = stiff.iter().flat_map(|value| ["--set", value]).collect();
    let point = point(&arguments);
    assert_eq!(point["status"], "under_resolved", "{point:#}");
    assert!(
        point["class"].is_null() && point["lyapunov"].is_null() && point["period"].is_null(),
        "{point:#}"
    );
}

#[test]
fn an_orbit_that_was_given_up_has_no_exponents() {
    // fixed steps, in a layer far too steep for them
    let given_up = point(&["--set", "f_0=1000", "--scheme", "rk4"]);
    assert_eq!(given_up["status"], "under_resolved");
    for key in ["lyapunov", "lyapunov_error", "lyapunov_second", "divergence", "x"] {
        assert!(given_up[key].is_null(), "{key}: {}", given_up[key]);
    }
    let output = tribochaos(
        TempDir::new().unwrap().path(),
        &["point", "--set", "f_0=1000", "--scheme", "rk4"],
    );
    let said = text(&output.stdout);
    assert!(
        said.contains("under-resolved")
            && said.contains("the default scheme, tried here, gives")
            && !said.contains("exponent"),
        "{said}"
    );
}

#[test]
fn a_rest_on_the_saddle_is_unstable_and_has_period_one() {
    let point = point(&[
        "--set",
        "x0=0",
        "--set",
        "y0=0",
        "--set",
        "zeta_k=0",
        "--set",
        "omega_k=0",
    ]);
    assert_eq!(
        (point["class"].as_str(), point["period"].as_u64()),
        (Some("unstable"), Some(1)),
        "{point:#}"
    );
}

#[test]
fn the_spectrum_is_that_of_the_initial_state_whose_exponent_is_reported() {
    let values = [
        "--set",
        "zeta_k=3.64",
        "--set",
        "h1=0.3",
        "--initial-states",
        "8",
        "--gram-schmidt",
    ];
    let point = point(&[&values[..], &["--transient-periods", "100", "--periods", "100"]].concat());
    let number = |value: &Value| value.as_f64().unwrap();
    let difference = number(&point["gram_schmidt_spectrum"][0]) - number(&point["lyapunov"]);
    assert!(
        difference.abs() <= 4.0 * number(&point["lyapunov_error"]).max(1e-6),
        "{point:#}"
    );
}

#[test]
fn coexisting_attractors_are_counted() {
    // two wells, hardly driven: the bush rests in one or the other
    let point = point(&[
        "--set",
        "zeta_k=1",
        "--set",
        "h1=1",
        "--initial-states",
        "12",
        "--periods",
        "100",
    ]);
    assert_eq!(point["attractors"], 2, "{point:#}");
    assert_eq!(point["chaotic_fraction"], 0.0);
}

#[test]
fn bad_input_is_refused_with_a_reason_before_any_work() {
    let folder = TempDir::new().unwrap();
    let long = "--x=zeta_k=0:12:60000";
    for (args, reason) in [
        (&["map", "--x", "zetak=0:1:5"][..], "did you mean `zeta_k`"),
        (&["map", "--set", "gravity=1"], "unknown parameter"),
        (
            &["map", "--set", "interferense=1"],
            "`tribochaos machine --help` the quantities of a machine",
        ),
        (&["map", "--x", "zeta_k=1:1:5"], "two different ends"),
        (&["map", "--x", "zeta_k=0:1:1"], "needs 2"),
        (&["map", "--x", "zeta_k=0:nan:10"], "out of range"),
        (&["map", "--x", "zeta_k=0:inf:10"], "out of range"),
        (&["map", "--set", "epsilon_0=0"], "out of range"),
        (&["map", "--set", "omega_0=-2"], "out of range"),
        (&["map", "--set", "b=NaN"], "out of range"),
        (&["map", "--set", "b"], "NAME=VALUE"),
        (&["map", "--set", "zeta_k=3"], "leave one of the two out"),
        (&["map", "--x", "h1=0:1:5"], "two axes are h1"),
        (&["map", "--steps-per-period", "7"], "from 8"),
        (&["map", "--periods", "3"], "from 16"),
        (&["map", "--align-periods", "301"], "from 0 to 300"),
        (&["map", "--scheme", "euler"], "rk4"),
        (&["map", "--backend", "tpu"], "auto"),
        (&["map", "--backend", "gpu", "--precision", "f64"], "f32"),
        (&["map", "--precision", "f32", "--set", "epsilon_0=1e-6"], "too thin"),
        (&["map", "--initial-box=2:-2,0:1"], "lower end first"),
        (&["map", "missing.toml"], "missing.toml"),
        (&["map", "--from", "missing.png"], "missing.png"),
        (&["map", long, "--y", "h1=0:2:40000"], "60000"),
        (&["map", long, "--y", "h1=0:2:40000", "--dry-run"], "60000"),
        (&["map", "--out", "folder/"], "names no file"),
        (&["map", "--adapter", "no such GPU"], "no GPU adapter has"),
        (&["map", "--out", "/proc/nowhere/map"], "/proc/nowhere/map.zarr"),
        (&["map", "--set", "gamma=-1"], "gamma = -1 is out of range"),
        (&["map", "--set", "k_w=-0.01"], "k_w = -0.01 is out of range"),
        (&["map", "--set", "biot=0"], "biot = 0 is out of range"),
        (&["map", "--set", "omega_tilde=0"], "omega_tilde = 0 is out of range"),
        (&["map", "--set", "ramp_rate=0"], "leave it out for none"),
        (&["map", "--x", "ramp_rate=1:inf:5"], "give it finite values"),
        (&["map", "--modes", "0"], "modes = 0 is out of range"),
        (&["map", "--modes", "65"], "from 1 to 64"),
        (&["map", "--tolerance", "1"], "tolerance = 1 is out of range"),
        (&["map", "--preset", "steel"], "`paper`"),
        (
            &["map", "--preset", "paper", "--scheme", "rk4"],
            "neither frictional heat nor wear",
        ),
        (
            &["map", "--preset", "paper", "--set", "h1=1"],
            "leave one of the two out",
        ),
        (&["point", "--set", "gamma=1", "--steps-per-period", "8"], "from 16"),
        (&["render", "missing.zarr"], "missing.zarr"),
        (&["render", "map.png"], ".zarr"),
        (&["point", "--x", "zeta_k=0:1:5"], "--x"),
        (&["point", "--set", "x0=1e9"], "out of range"),
    ] {
        let output = tribochaos(folder.path(), args);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {stderr}");
        assert!(stderr.contains(reason), "{args:?}: {reason} is not in: {stderr}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing was written");
}

#[test]
fn damaged_files_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("unknown.toml"), "[settings]\nsteps = 5\n").unwrap();
    assert_refused(
        &tribochaos(folder.path(), &["map", "unknown.toml"]),
        "unknown field `steps`",
    );

    assert!(small_map(folder.path(), &["--out", "m"]).status.success());
    let picture = fs::read(path("m-period.png")).unwrap();
    fs::write(path("half.png"), &picture[..picture.len() / 2]).unwrap();
    assert_refused(&tribochaos(folder.path(), &["map", "--from", "half.png"]), "half.png");
    fs::write(path("text.png"), "no picture").unwrap();
    assert_refused(&tribochaos(folder.path(), &["map", "--from", "text.png"]), "text.png");
    assert_refused(
        &tribochaos(folder.path(), &["render", "m.zarr", "--limits", "1:0"]),
        "lower one first",
    );

    fs::write(path("m.zarr/zarr.json"), "{").unwrap();
    assert_refused(&tribochaos(folder.path(), &["render", "m.zarr"]), "m.zarr");
    // the command that wrote it mends it
    let mended = small_map(folder.path(), &["--out", "m"]);
    assert!(mended.status.success(), "{}", text(&mended.stderr));
    assert!(
        text(&mended.stderr).contains("was written anew"),
        "{}",
        text(&mended.stderr)
    );
    assert!(
        tribochaos(folder.path(), &["render", "m.zarr", "--json"])
            .status
            .success()
    );
}

#[test]
fn help_shows_the_parameters_and_the_classes() {
    let folder = TempDir::new().unwrap();
    let output = tribochaos(folder.path(), &["map", "--help"]);
    let help = text(&output.stdout);
    for said in [
        "zeta_k",
        "epsilon_0",
        "ωₖ",
        "half-width of the regularised friction layer",
        "L - 3 S > 0, and a disturbance grew by more than e over the",
        "--align-periods",
    ] {
        assert!(help.contains(said), "{said}");
    }
}

/// The default that the help of a command names for an option.
#[track_caller]
fn told(command: &str, option: &str) -> String {
    let output = tribochaos(Path::new("."), &[command, "--help"]);
    let help = text(&output.stdout);
    let words = help.split_whitespace().collect::<Vec<_>>().join(" ");
    let (_, behind) = words.split_once(&format!(" --{option} <")).expect(option);
    let (_, default) = behind.split_once("[default: ").expect(option);
    default.split_once(']').unwrap().0.to_owned()
}

#[test]
fn help_names_the_defaults_that_hold() {
    let folder = TempDir::new().unwrap();
    let (usual, defaults) = (Integration::default(), Sampling::default());
    for (option, default) in [
        (
            "modes",
            format!("{}, and more where heat is conducted slowly", usual.modes),
        ),
        ("tolerance", format!("{:e}", usual.tolerance)),
        ("transient-periods", defaults.transient_periods.to_string()),
        (
            "align-periods",
            format!("{}, or the whole of a shorter transient", defaults.align_periods),
        ),
        ("periods", defaults.periods.to_string()),
        ("renormalise-every", usual.renormalise_every.to_string()),
        ("period-tolerance", format!("{:e}", defaults.period_tolerance)),
        ("max-period", defaults.max_period.to_string()),
        ("initial-states", defaults.initial_states.to_string()),
        ("seed", defaults.seed.to_string()),
    ] {
        for command in ["map", "point", "lyapunov"] {
            assert_eq!(told(command, option), default, "{command} --{option}");
        }
    }
    // by the same words as if nothing had been typed
    let printed =
        |args: &[&str]| text(&tribochaos(folder.path(), &[&["map", "--print-experiment"], args].concat()).stdout);
    let typed: Vec<String> = ["x", "y", "initial-box", "backend"]
        .iter()
        .map(|option| format!("--{option}={}", told("map", option)))
        .collect();
    assert_eq!(
        printed(&typed.iter().map(String::as_str).collect::<Vec<_>>()),
        printed(&[])
    );
    // and those of commands that have others, as their tables hold them
    let phase = ["phase", "--set", "zeta_k=1"];
    let history = ["history", "--samples", "4"];
    let poincare = ["poincare", "--points", "64"];
    let bifurcation = ["bifurcation", "--x", "zeta_k=1:2:2"];
    for (args, option) in [
        (&phase[..], "periods"),
        (&phase, "transient-periods"),
        (&history, "periods"),
        (&poincare, "transient-periods"),
        (&bifurcation, "periods"),
        (&bifurcation, "transient-periods"),
    ] {
        let command = args[0];
        let output = tribochaos(folder.path(), args);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let table = fs::read_to_string(folder.path().join(format!("outputs/{command}.csv"))).unwrap();
        let key = format!("# {} = ", option.replace('-', "_"));
        // options come before settings
        let held = table.lines().find_map(|line| line.strip_prefix(&key)).expect(&key);
        assert_eq!(told(command, option), held, "{command} --{option}");
    }
    // what follows from another option has no default of its own
    let help = text(&tribochaos(folder.path(), &["poincare", "--help"]).stdout);
    assert!(!help.contains("--periods"), "{help}");
}

#[test]
fn errors_are_told_once_and_with_their_line() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("e.toml"), "[set]\nh1 = 0.5\nzetak = 3.9\n").unwrap();
    fs::write(path("m.toml"), "shaft_radius = 1e-3\nbush_radiu = 5e-3\n").unwrap();
    fs::write(path("steel.toml"), "\n\n\nmaterial = \"stele\"\n").unwrap();
    for (args, reason, place) in [
        (&["map", "e.toml"][..], "did you mean `zeta_k`?", "line 3, column 1"),
        (
            &["machine", "m.toml"],
            "did you mean `bush_radius`?",
            "line 2, column 1",
        ),
        (
            &["machine", "steel.toml"],
            "there is no material `stele`",
            "line 4, column 12",
        ),
        (&["map", "missing.toml"], "No such file or directory", "missing.toml"),
        (&["render", "missing.zarr"], "there is no store", "missing.zarr"),
        (
            &["map", "--from", "missing.png"],
            "No such file or directory",
            "missing.png",
        ),
        (&["phase", "--out", "e.toml/q"], "Not a directory", "e.toml/q"),
    ] {
        let output = tribochaos(folder.path(), args);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {stderr}");
        assert_eq!(stderr.matches(reason).count(), 1, "{args:?}: {stderr}");
        assert_eq!(stderr.matches(place).count(), 1, "{args:?}: {stderr}");
    }
}

/// Every file that a command writes holds the experiment, by which the command writes the same again.
#[test]
fn an_experiment_comes_back_from_every_file_of_its_command() {
    let folder = TempDir::new().unwrap();
    let run = |args: &[&str]| {
        let output = tribochaos(folder.path(), args);
        assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    let short = ["--transient-periods", "20", "--periods", "20"];
    let cases: [&[&str]; 7] = [
        &["bifurcation", "--x", "zeta_k=1:2:3", "--show", "y", "--follow", "up"],
        &[
            "lyapunov",
            "--x",
            "h1=0.1,0.2",
            "--start",
            "0.5,0",
            "--limits=-1:1",
            "--no-onset",
        ],
        &["phase", "--at", "zeta_k=3.5,3.9", "--start", "1,0", "--start", "-1,0"],
        &[
            "poincare",
            "--points",
            "64",
            "--window=-2:2,-3:3",
            "--transient-periods",
            "20",
        ],
        &["history", "--periods", "3", "--samples", "8", "--preset", "paper"],
        &[
            "melnikov",
            "--at",
            "h1=0.5",
            "--threshold",
            "zeta_k=1:9",
            "--over",
            "b=1:2:3",
        ],
        &[
            "point",
            "--lifetime",
            "100",
            "--lifetime-periods",
            "100",
            "--set",
            "zeta_k=3.5",
        ],
    ];
    for case in cases {
        let takes_lengths = ["bifurcation", "lyapunov", "phase"].contains(&case[0]);
        let lengths = if takes_lengths { &short[..] } else { &[] };
        let args = [case, lengths, &["--set", "omega_0=1.5", "--out", "drawn"]].concat();
        let printed = run(&[&args[..], &["--print-experiment"]].concat());
        assert!(printed.starts_with(&format!("command = \"{}\"", case[0])), "{printed}");
        assert!(!folder.path().join("drawn.png").exists(), "{case:?} has drawn");
        run(&args);
        for file in ["drawn.png", "drawn.svg", "drawn.csv"] {
            let again = run(&[case[0], "--from", file, "--print-experiment"]);
            assert_eq!(again, printed, "{file} of {case:?}");
        }
        // what was drawn is drawn over by the same, and by nothing else
        run(&[case[0], "--from", "drawn.svg", "--out", "drawn"]);
        let other = tribochaos(
            folder.path(),
            &[case[0], "--from", "drawn.svg", "--set", "omega_0=1.6", "--out", "drawn"],
        );
        assert_refused(&other, "drawn.png shows something else");
        for ending in ["png", "svg", "csv"] {
            fs::remove_file(folder.path().join(format!("drawn.{ending}"))).unwrap();
        }
    }
}

/// Of another command's file its parameters are taken, and what else means the same to both.
#[test]
fn an_experiment_of_another_command_gives_its_parameters() {
    let folder = TempDir::new().unwrap();
    let printed = |args: &[&str]| {
        let output = tribochaos(folder.path(), &[args, &["--print-experiment"]].concat());
        assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
        text(&output.stdout)
    };
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).unwrap();
    let set = [
        "--set",
        "b=1.25",
        "--set",
        "zeta_k=3.5",
        "--scheme",
        "rk4",
        "--periods",
        "99",
    ];
    write(
        "phase.toml",
        printed(&[&["phase", "--start", "1,0"], &set[..]].concat()),
    );
    // lengths of its own, a scheme that means the same, options that mean nothing
    let bifurcation = printed(&["bifurcation", "--from", "phase.toml"]);
    assert!(
        bifurcation.contains("b = 1.25") && bifurcation.contains("rk4"),
        "{bifurcation}"
    );
    assert!(bifurcation.contains("\nperiods = 200\n"), "{bifurcation}");
    assert!(bifurcation.contains("start = [[0.1, 0.0]]"), "{bifurcation}");
    // a map is decided early, and its axes lose the values that they had
    let map = printed(&["map", "--from", "phase.toml"]);
    assert!(
        map.contains("decide_early = true") && map.contains("\nperiods = 99\n"),
        "{map}"
    );
    assert!(!map.contains("zeta_k = ") && !map.contains("command"), "{map}");
    // points of --at are not
    write("several.toml", printed(&["phase", "--at", "h1=0.1,0.2"]));
    assert!(printed(&["map", "--from", "several.toml"]).contains("parameter = \"h1\""));
    assert!(!printed(&["point", "--from", "several.toml"]).contains("points"));
    // as many axes as the command has are taken over
    write("line.toml", printed(&["lyapunov", "--x", "h1=0.1:0.7:4"]));
    assert!(printed(&["bifurcation", "--from", "line.toml"]).contains("parameter = \"h1\""));
    assert!(printed(&["bifurcation", "--from", "line.toml", "--x", "b=1:2:3"]).contains("h1 = 0.5"));
    // an error in a file is told with its place
    write(
        "bad.toml",
        "command = 'phase'\n[options]\nstarts = [[1, 0]]\n".to_owned(),
    );
    let bad = tribochaos(folder.path(), &["phase", "--from", "bad.toml"]);
    assert_refused(&bad, "unknown field `starts`");
    // values go through the same checks as typed ones
    for (command, options, reason) in [
        (
            "history",
            "samples = 0",
            "samples = 0 is out of range: it must be from 4 to 4096",
        ),
        ("bifurcation", "limits = [1.0, -1.0]", "the limits 1:-1 are no range"),
        ("phase", "start = [[1e9, 0.0]]", "x0 = 1000000000 is out of range"),
        (
            "poincare",
            "window = {x = [1.0, 1.0], y = [0.0, 1.0]}",
            "the window has no extent",
        ),
        ("poincare", "points = 0", "points = 0 is out of range"),
        ("melnikov", "tau = [1.0, 0.0]", "tau0 from 1 to 0 is no range"),
        (
            "melnikov",
            "threshold = {coordinate = 'h1', range = [2.0, 1.0]}",
            "needs a range",
        ),
        ("point", "lifetime = 5", "lifetime = 5 is out of range"),
    ] {
        write("bad.toml", format!("command = '{command}'\n[options]\n{options}\n"));
        assert_refused(&tribochaos(folder.path(), &[command, "--from", "bad.toml"]), reason);
    }
    write("bad.csv", "# tribochaos 0.1.0\nx,y\n1,2\n".to_owned());
    let bad = tribochaos(folder.path(), &["phase", "--from", "bad.csv"]);
    assert_refused(&bad, "bad.csv holds no experiment");
}

/// On what a map was computed is no part of it.
#[test]
fn a_store_is_gone_on_with_on_another_device() {
    let folder = TempDir::new().unwrap();
    assert!(small_map(folder.path(), &[]).status.success());
    let other = tribochaos(
        folder.path(),
        &["map", "--from", "outputs/map.zarr", "--audit", "3", "--backend", "auto"],
    );
    assert!(other.status.success(), "{}", text(&other.stderr));
    assert!(text(&other.stdout).contains("in the store already"));
    let other = tribochaos(
        folder.path(),
        &[
            "map",
            "--from",
            "outputs/map.zarr",
            "--precision",
            "f32",
            "--out",
            "outputs/map",
        ],
    );
    assert_refused(&other, "another experiment");
}

/// A map of many units, which takes minutes.
#[cfg(unix)]
const LONG_MAP: [&str; 17] = [
    "map",
    "--x",
    "zeta_k=0:12:2000",
    "--y",
    "h1=0:2:2000",
    "--backend",
    "cpu",
    "--precision",
    "f32",
    "--transient-periods",
    "16",
    "--align-periods",
    "8",
    "--periods",
    "16",
    "--steps-per-period",
    "200",
];

#[cfg(unix)]
fn interrupt(child: &std::process::Child) {
    let id = child.id().to_string();
    let killed = Command::new("kill").args(["-INT", &id]).status().unwrap();
    assert!(killed.success());
}

#[test]
#[cfg(unix)]
fn ctrl_c_keeps_what_is_finished() {
    use std::time::{Duration, Instant};
    let folder = TempDir::new().unwrap();
    let mut child = program::with_signals()
        .current_dir(folder.path())
        .args(LONG_MAP)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let finished = folder.path().join("outputs/map.zarr/status/done/0");
    let started = Instant::now();
    while !finished.exists() {
        assert!(started.elapsed() < Duration::from_mins(2), "no unit was written");
        assert!(
            child.try_wait().unwrap().is_none(),
            "the map ended before it was interrupted"
        );
        std::thread::sleep(Duration::from_millis(20));
    }
    // meanwhile nobody replaces the store
    let replacing = tribochaos(folder.path(), &[&LONG_MAP[..], &["--force"]].concat());
    assert_eq!(replacing.status.code(), Some(2));
    let told = format!("is in use by another process (process {})", child.id());
    assert!(text(&replacing.stderr).contains(&told), "{}", text(&replacing.stderr));
    interrupt(&child);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("goes on from there"));
    assert!(!folder.path().join("outputs/.map.zarr.lock").exists());
    // what is finished can be drawn
    assert!(
        tribochaos(folder.path(), &["render", "outputs/map.zarr"])
            .status
            .success()
    );
}

#[test]
fn heat_and_wear_are_measured_from_the_command_line() {
    let args = ["--preset", "paper", "--set", "zeta_k=3.9", "--periods", "30"];
    let wears = point(&args);
    let number = |value: &Value| value.as_f64().unwrap();
    assert_eq!(wears["contact_status"], "lost");
    assert!((number(&wears["contact_time"]) - 72.0556).abs() < 0.005);
    assert!((number(&wears["final_wear"]) - 30.206).abs() < 0.01);
    assert!((number(&wears["peak_pressure"]) - 95.955).abs() < 0.02);
    assert!((number(&wears["peak_pressure_time"]) - 6.733).abs() < 0.006);
    assert!((number(&wears["peak_temperature"]) - 543.0).abs() < 5.0);
    assert_eq!(wears["lyapunov_interval"], wears["contact_time"]);
    for key in ["class", "period", "lyapunov_second", "divergence", "lyapunov_error"] {
        assert_eq!(wears[key], Value::Null, "{key}");
    }
    let lasts = point(&["--preset", "paper", "--set", "zeta_k=3.5", "--set", "k_w=0"]);
    assert_eq!((&lasts["period"], &lasts["class"]), (&2.into(), &"regular".into()));
    assert!((number(&lasts["lyapunov"]) + 0.0808).abs() < 1e-3);
    assert_eq!(
        (&lasts["contact_status"], &lasts["contact_time"]),
        (&"held".into(), &Value::Null)
    );
}

#[test]
fn a_map_of_wear_is_drawn_and_a_short_transient_is_warned_of() {
    let folder = TempDir::new().unwrap();
    let wear = [
        "map",
        "--preset",
        "paper",
        "--x",
        "zeta_k=1:4:4",
        "--y",
        "k_w=0.01:0.02:3",
        "--periods",
        "30",
        "--out",
        "w",
    ];
    let output = tribochaos(folder.path(), &wear);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).contains("contact: lost"),
        "{}",
        text(&output.stdout)
    );
    for file in ["w-lyapunov.png", "w-contact_time.png", "w-final_wear.png"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
    let heat = [
        "map",
        "--preset",
        "paper",
        "--set",
        "k_w=0",
        "--x",
        "zeta_k=1:4:4",
        "--y",
        "gamma=0:2:3",
        "--dry-run",
        "--out",
        "h",
    ];
    let short = [&heat[..], &["--transient-periods", "2", "--align-periods", "1"]].concat();
    assert!(text(&tribochaos(folder.path(), &short).stderr).contains("too short for its heat to settle"));
    assert!(!text(&tribochaos(folder.path(), &heat).stderr).contains("too short"));
}
