//! Machines in SI units from outside: what is typed, what comes out, and with which exit code.

#![cfg(feature = "cli")]

mod program;

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use program::{drawing, text, tribochaos};

#[track_caller]
fn done(output: &Output) -> String {
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

#[track_caller]
fn json(output: &Output) -> Value {
    serde_json::from_str(&done(output)).unwrap()
}

/// A folder with the template as `m.toml`.
fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    let template = tribochaos(folder.path(), &["machine", "--template"]);
    assert!(template.stderr.is_empty());
    fs::write(folder.path().join("m.toml"), done(&template)).unwrap();
    folder
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[track_caller]
fn assert_near(value: &Value, expected: f64, tolerance: f64) {
    let value = number(value);
    assert!((value / expected - 1.0).abs() < tolerance, "{value}, not {expected}");
}

/// Without heat and wear: eta = 1, Kw = 0.
const COLD: [&str; 4] = ["--set", "wear_energy_share=1", "--set", "wear_coefficient=0"];

/// A map of a second over two quantities.
const MAP: [&str; 11] = [
    "map",
    "--machine",
    "m.toml",
    "--x",
    "shaft_speed_amplitude=50:500:6",
    "--y",
    "interference=1e-9:40e-9:4",
    "--backend",
    "cpu",
    "--periods",
    "30",
];

#[test]
fn the_template_is_the_paper_s_preset_and_sensitivities_are_told() {
    let folder = folder();
    let object = json(&tribochaos(folder.path(), &["machine", "m.toml", "--json"]));
    for (name, expected) in [
        ("zeta_k", 3.9),
        ("epsilon", 0.1),
        ("gamma", 1.868),
        ("biot", 10.0),
        ("b", 1.0),
    ] {
        assert_near(&object["parameters"][name], expected, 3e-3);
    }
    assert_eq!(object["parameters"].as_object().unwrap().len(), 13);
    assert_near(&object["scales"]["time_s"], 0.01695, 1e-3);
    assert_near(&object["k_star_n_per_m2"], 9.18e5, 1e-12);
    assert_near(&object["sensitivities"]["interference"]["epsilon"], 1.0, 1e-12);
    assert_near(&object["sensitivities"]["inertia"]["time_scale"], 0.5, 1e-12);
    assert_eq!(object["machine"]["material"], "paper_steel");
    assert!(object["warnings"].to_string().contains("interference = 1 nm"));

    let output = tribochaos(folder.path(), &["machine", "m.toml", "--set", "shaft_speed_mean=0"]);
    let words = done(&output);
    assert!(words.contains("t*               16.958 ms") && words.contains("P*               365.38 kPa"));
    // omega_k is 0: no percentages of it
    let row = words
        .lines()
        .find(|line| line.trim_start().starts_with("inertia"))
        .unwrap();
    let cells: Vec<&str> = row.split_whitespace().collect();
    assert_eq!(cells[1..5], ["0.50", "-0.50", "0.50", "-"], "{row}");
    assert!(text(&output.stderr).contains("warning: interference"));

    // the length of the contact is in three groups, and moves no other
    fs::write(
        folder.path().join("whole.toml"),
        format!(
            "length = 0.02\n{}",
            fs::read_to_string(folder.path().join("m.toml")).unwrap()
        ),
    )
    .unwrap();
    let whole = done(&tribochaos(folder.path(), &["machine", "whole.toml"]));
    let rows: Vec<&str> = whole
        .lines()
        .filter(|line| line.trim_start().starts_with("length "))
        .collect();
    assert_eq!(rows.len(), 2, "{whole}");
    assert!(!rows.iter().any(|row| row.contains("0.00")), "{rows:?}");

    let materials = done(&tribochaos(folder.path(), &["machine", "--materials"]));
    assert!(materials.starts_with("paper_steel") && materials.contains("Callister"));
    let materials = json(&tribochaos(folder.path(), &["machine", "--materials", "--json"]));
    assert_eq!(materials[0]["thermal_conductivity"], 21.0);
}

#[test]
fn a_point_tells_its_results_in_si_units_and_what_cannot_be() {
    let folder = folder();
    let at_rest = ["--machine", "m.toml", "--set", "x0=0", "--periods", "30"];
    let point = json(&tribochaos(
        folder.path(),
        &[&["point", "--json"], &at_rest[..]].concat(),
    ));
    let si = &point["si"];
    let (time, pressure) = (0.016_958_234, 365_384.615);
    assert_near(&si["contact_time_s"], time * number(&point["contact_time"]), 1e-6);
    assert_near(
        &si["peak_pressure_pa"],
        pressure * number(&point["peak_pressure"]),
        1e-6,
    );
    assert_near(&si["final_wear_m"], 1e-9 * number(&point["final_wear"]), 1e-9);
    assert_near(
        &si["peak_temperature_rise_k"],
        0.054_945_055 * number(&point["peak_temperature"]),
        1e-6,
    );
    assert_near(&si["lyapunov_per_s"], number(&point["lyapunov"]) / time, 1e-6);
    assert_near(&si["forcing_frequency_hz"], 118.0 / std::f64::consts::TAU, 1e-12);
    // as the paper's preset: contact lost at 72.06, wear 30.2
    assert_near(&point["contact_time"], 72.06, 2e-3);
    assert_near(&point["final_wear"], 30.2, 5e-3);
    let printed = tribochaos(folder.path(), &[&["point"], &at_rest[..]].concat());
    assert!(done(&printed).contains("(1.2211 s)"));
    // the shaft holds; that the wells of this machine lie at 1 rad shows
    let stderr = text(&printed.stderr);
    assert!(
        stderr.matches("beyond the model's limits").count() == 1
            && stderr.contains("beyond the model's limits: the bush would turn by 2.5"),
        "{stderr}"
    );

    // twice the speed: beyond yield
    let tight = [&["point", "--json", "--set", "shaft_speed_amplitude=450"], &at_rest[..]].concat();
    let output = tribochaos(folder.path(), &tight);
    assert!(
        text(&output.stderr).contains("beyond the model's limits: the contact pressure would be"),
        "{}",
        text(&output.stderr)
    );
    assert!(json(&output)["warnings"].to_string().contains("yields at 205 MPa"));

    let cold = json(&tribochaos(
        folder.path(),
        &[
            &[
                "point",
                "--json",
                "--machine",
                "m.toml",
                "--set",
                "shaft_speed_amplitude=206",
            ],
            &COLD[..],
        ]
        .concat(),
    ));
    assert_eq!((&cold["class"], &cold["period"]), (&"regular".into(), &1.into()));
    assert_near(&cold["si"]["motion_frequency_hz"], 118.0 / std::f64::consts::TAU, 1e-12);
}

#[test]
fn a_map_over_quantities_is_stored_with_its_machine_and_drawn_in_si() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let output = tribochaos(folder.path(), &MAP);
    assert!(
        done(&output)
            .contains("over shaft_speed_amplitude = 50 rad/s..500 rad/s (6) by interference = 1 nm..40 nm (4)"),
        "{}",
        text(&output.stdout)
    );
    assert!(
        text(&output.stderr).contains("beyond the model's limits at "),
        "{}",
        text(&output.stderr)
    );
    assert!(
        !path("outputs/map-border.csv").exists(),
        "where all wears there is no chaos"
    );
    let cold = [&MAP[..], &COLD, &["--transient-periods", "30", "--out", "cold"]].concat();
    done(&tribochaos(folder.path(), &cold));
    let table = fs::read_to_string(path("cold-border.csv")).unwrap();
    assert!(
        table.contains("in rad/s; interference: interference of shaft and bush, radial, in m")
            && table.contains("\nalong,shaft_speed_amplitude,interference,half_width,chaos"),
        "{table}"
    );

    // the same goes on, another machine does not
    assert!(done(&tribochaos(folder.path(), &MAP)).contains("in the store already"));
    let other = tribochaos(folder.path(), &[&MAP[..], &["--set", "damping=777"]].concat());
    assert_eq!(other.status.code(), Some(2));
    assert!(text(&other.stderr).contains("another experiment"));

    let printed = done(&tribochaos(
        folder.path(),
        &[&MAP[..], &["--print-experiment"]].concat(),
    ));
    let from = ["map", "--from", "outputs/map-lyapunov.png", "--backend", "cpu"];
    let from = [&from[..], &["--print-experiment"]].concat();
    assert_eq!(done(&tribochaos(folder.path(), &from)), printed);
    fs::write(path("e.toml"), &printed).unwrap();
    assert_eq!(
        done(&tribochaos(folder.path(), &["map", "e.toml", "--print-experiment"])),
        printed
    );
    assert!(printed.contains("[machine]") && printed.contains("parameter = \"interference\""));
    assert!(!printed.contains("\ninterference = ") && !printed.contains("zeta_k"));

    // a file's parameters give way to a machine that is typed
    let plain = done(&tribochaos(
        folder.path(),
        &["map", "--set", "x0=0.3", "--print-experiment"],
    ));
    fs::write(path("plain.toml"), plain).unwrap();
    let with = [
        "map",
        "plain.toml",
        "--machine",
        "m.toml",
        "--x",
        "damping=1:2:3",
        "--y",
        "inertia=1:2:3",
    ];
    let with = done(&tribochaos(
        folder.path(),
        &[&with[..], &COLD[..], &["--print-experiment"]].concat(),
    ));
    assert!(with.contains("x0 = 0.3") && !with.contains("gamma"), "{with}");

    let pressure = [
        "render",
        "outputs/map.zarr",
        "--quantity",
        "peak_pressure",
        "--limits",
        "0:1e9",
    ];
    assert!(done(&tribochaos(folder.path(), &pressure)).contains("map-peak_pressure.png"));
}

#[test]
fn analyses_run_over_quantities_of_a_machine() {
    let folder = folder();
    let run = |args: &[&str]| {
        let args = [args, &["--machine", "m.toml", "--json"], &COLD[..]].concat();
        json(&drawing(folder.path(), &args))
    };
    let short = ["--transient-periods", "60", "--periods", "40"];
    let amplitude = ["--x", "shaft_speed_amplitude=180:240:4"];

    let line = run(&[&["lyapunov", "--no-onset"], &amplitude[..], &short[..]].concat());
    assert_eq!(line["axis"]["parameter"], "shaft_speed_amplitude");
    let table = fs::read_to_string(folder.path().join("outputs/lyapunov.csv")).unwrap();
    assert!(
        table.contains("# shaft_speed_amplitude in rad/s; exponents per unit of tau"),
        "{table}"
    );
    let rows: Vec<&str> = table.lines().filter(|line| line.starts_with("0.1,0,200,")).collect();
    // the same point by its dimensionless values
    let machine = json(&tribochaos(
        folder.path(),
        &[
            &["machine", "m.toml", "--json", "--set", "shaft_speed_amplitude=200"],
            &COLD[..],
        ]
        .concat(),
    ));
    let parameters = machine["parameters"].as_object().unwrap();
    let set: Vec<String> = parameters
        .iter()
        .map(|(name, value)| format!("{name}={value}"))
        .collect();
    let set: Vec<&str> = set.iter().flat_map(|value| ["--set", value]).collect();
    let point = json(&tribochaos(
        folder.path(),
        &[&["point", "--json"], &short[..], &set[..]].concat(),
    ));
    let exponent: f64 = rows[0].split(',').nth(3).unwrap().parse().unwrap();
    assert_eq!(point["lyapunov"], exponent);

    assert_eq!(
        run(&[&["bifurcation"], &amplitude[..], &short[..]].concat())["states"],
        160
    );
    let phase = run(&[&["phase", "--at", "shaft_speed_amplitude=150,206"], &short[..]].concat());
    let zeta = |index: usize| number(&phase["orbits"][index]["parameters"]["zeta_k"]);
    assert!((zeta(1) / zeta(0) - 206.0 / 150.0).abs() < 1e-12);
    assert_eq!(phase["machine"]["damping"], 778.0);
    assert_eq!(
        run(&["poincare", "--points", "2000", "--transient-periods", "20"])["points"],
        2000
    );

    let overlay = [
        "map",
        "--x",
        "shaft_speed_amplitude=100:300:4",
        "--y",
        "damping=0:1000:3",
        "--overlay",
        "melnikov",
    ];
    let overlay = [&overlay[..], &short[..], &["--machine", "m.toml"], &COLD[..]].concat();
    done(&tribochaos(folder.path(), &overlay));
}

/// Thresholds are looked for in quantities of the machine, and told in their units.
#[test]
fn melnikovs_thresholds_of_a_machine_are_in_si() {
    let folder = folder();
    let melnikov = |args: &[&'static str]| {
        let args = [&["melnikov", "--machine", "m.toml", "--force"], &COLD[..], args].concat();
        drawing(folder.path(), &args)
    };
    let found = json(&melnikov(&["--json", "--over", "damping=0:1000:3"]));
    assert_near(&found["threshold"], 218.05, 1e-4);
    assert_eq!(
        (&found["threshold_parameter"], &found["threshold_unit"]),
        (&"shaft_speed_amplitude".into(), &"rad/s".into())
    );
    assert_near(&found["threshold_dimensionless"]["zeta_k"], 3.6977, 1e-4);
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let table = read("outputs/melnikov-threshold.csv");
    assert!(
        table.contains("# damping in N s/m²; shaft_speed_amplitude in rad/s; empty:")
            && table.contains("\ndamping,shaft_speed_amplitude_threshold,"),
        "{table}"
    );
    // the same range as in the default, and the other way round
    let typed = done(&melnikov(&["--threshold", "shaft_speed_amplitude=0:1000"]));
    assert!(
        typed.contains("M changes sign above shaft_speed_amplitude = 218.05 rad/s (zeta_k = 3.6977"),
        "{typed}"
    );
    let end = json(&melnikov(&["--json", "--threshold", "damping=0:3000"]));
    assert_eq!(end["threshold_kind"], "ceases");
    let back = json(&melnikov(&[
        "--json",
        "--threshold",
        "interference=1e-10:1e-8",
        "--over",
        "inertia=6e-3:8e-3:3",
    ]));
    assert_eq!(back["threshold_unit"], "m");
    assert!(back["threshold"].is_f64(), "{back}");
    for (args, reason) in [
        (
            &["--threshold", "h1=0:3"][..],
            "h1 follows from the machine: set damping",
        ),
        (&["--threshold", "damping"], "--threshold damping=LOW:HIGH, in N s/m²"),
        (
            &["--threshold", "heat_transfer=1:2"],
            "does not depend on heat_transfer",
        ),
        (&["--threshold", "spring_length=0.02:0.04"], "k* = -"),
        (&["--over", "length=1:2:3"], "does not depend on length"),
    ] {
        let output = melnikov(args);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {stderr}");
        assert!(stderr.contains(reason), "{args:?}: {reason} is not in: {stderr}");
    }
}

#[test]
fn a_history_of_a_machine_has_columns_in_si() {
    let folder = folder();
    let args = [
        "history",
        "--machine",
        "m.toml",
        "--periods",
        "3",
        "--samples",
        "8",
        "--json",
    ];
    let object = json(&drawing(folder.path(), &args));
    assert!(object["si"]["contact_time_s"].is_null());
    let table = fs::read_to_string(folder.path().join("outputs/history.csv")).unwrap();
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(
        names[7..],
        [
            "time_s",
            "angular_speed_rad_per_s",
            "sliding_speed_m_per_s",
            "pressure_pa",
            "wear_m",
            "temperature_rise_k"
        ]
    );
    let last: Vec<f64> = lines
        .next_back()
        .unwrap()
        .split(',')
        .map(|cell| cell.parse().unwrap())
        .collect();
    for (si, dimensionless, scale) in [
        (7, 0, 0.016_958_234),
        (8, 2, 1.0 / 0.016_958_234),
        (9, 3, 0.058_968_404),
        (10, 4, 365_384.615),
        (11, 5, 1e-9),
        (12, 6, 0.054_945_055),
    ] {
        assert!(
            (last[si] / (scale * last[dimensionless]) - 1.0).abs() < 1e-6,
            "{}",
            names[si]
        );
    }
    let svg = fs::read_to_string(folder.path().join("outputs/history.svg")).unwrap();
    assert!(svg.contains("(MPa)") && svg.contains("time t (ms)"));
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn bad_machines_are_refused_with_a_reason_before_any_work() {
    let folder = folder();
    let before = fs::read_dir(folder.path()).unwrap().count();
    let template = fs::read_to_string(folder.path().join("m.toml")).unwrap();
    let bad = TempDir::new().unwrap();
    let file = |name: &str, text: &str| {
        let path = bad.path().join(name);
        fs::write(&path, text).unwrap();
        path.to_string_lossy().into_owned()
    };
    let empty = file("empty.toml", "");
    let unknown = file("unknown.toml", &template.replace("damping", "dampning"));
    let alloy = file("alloy.toml", &template.replace("paper_steel", "mithril"));
    let broken = file("broken.toml", "shaft_radius = ");
    let slack = file("slack.toml", &template.replace("31.25e-3", "24e-3"));
    let negative = file(
        "negative.toml",
        &template.replace("interference = 1e-9", "interference = -1e-9"),
    );
    let m = "m.toml";
    for (args, reason) in [
        (&["machine"][..], "--template"),
        (&["machine", "missing.toml"], "cannot read missing.toml"),
        (&["machine", &empty], "lacks shaft_radius"),
        (&["machine", &unknown], "did you mean `damping`"),
        (&["machine", &alloy], "there is no material `mithril`"),
        (&["machine", &broken], "broken.toml"),
        (&["machine", &slack], "must be above 0.025000 m, by 1.00e-3 m more"),
        (&["machine", &negative], "interference = -0.000000001 m is out of range"),
        (&["machine", m, "--set", "wear_energy_share=1.5"], "from 0 to 1"),
        (
            &["machine", m, "--set", "gamma=1"],
            "gamma follows from the machine: set wear_energy_share",
        ),
        (
            &["machine", m, "--set", "inertia=NaN"],
            "inertia = NaN kg m is out of range",
        ),
        (&["machine", m, "--set", "interference=1e-4"], "epsilon = "),
        (&["point", "--set", "damping=3"], "give one by --machine"),
        (
            &["point", "--machine", m, "--set", "zeta_k=3"],
            "set shaft_speed_amplitude",
        ),
        (&["point", "--machine", m, "--preset", "paper"], "cannot be used with"),
        (&["map", "--machine", m], "zeta_k follows from the machine"),
        (
            &["map", "--x", "damping=1:2:3"],
            "damping is a quantity of a machine, and there is none",
        ),
        (
            &[
                "map",
                "--machine",
                m,
                "--x",
                "damping=1:2:3",
                "--y",
                "spring_length=0.02:0.04:5",
            ],
            "at damping = 1 N s/m², spring_length = 35 mm: k* = -",
        ),
        (
            &[
                "map",
                "--machine",
                m,
                "--x",
                "damping=1:2:3",
                "--y",
                "inertia=1:2:3",
                "--set",
                "damping=1",
            ],
            "leave one of the two out",
        ),
        (
            &["map", "--machine", m, "--x", "damping=1:1:3", "--y", "inertia=1:2:3"],
            "two different ends",
        ),
        (
            &["map", "--machine", m, "--x", "damping=1:2:3", "--y", "inertia=0:2:3"],
            "inertia = 0 kg m is out of range",
        ),
        (
            &["map", "--machine", m, "--x", "damping=1:2:3", "--y", "length=1:2:3"],
            "length belongs to whole parts",
        ),
        (&["lyapunov", "--machine", m], "zeta_k follows from the machine"),
        (&["phase", "--machine", m], "wear_coefficient = 0"),
        (&["phase", "--machine", m, "--at", "spring_length=0.02,0.04"], "k* = -"),
        (&["melnikov", "--machine", m], "wear_energy_share = 1"),
        (
            &["history", "--machine", m, "--set", "spring_free_length=0.02"],
            "k* = -",
        ),
    ] {
        let output = tribochaos(folder.path(), args);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {stderr}");
        assert!(stderr.contains(reason), "{args:?}: {reason} is not in: {stderr}");
    }
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        before,
        "nothing was written"
    );
}

#[test]
fn a_bush_that_turns_too_far_is_told_once() {
    let folder = folder();
    let far = [&["--machine", "m.toml", "--set", "x0=1.9"][..], &COLD].concat();
    let point = tribochaos(
        folder.path(),
        &[
            &["point"],
            &far[..],
            &["--set", "damping=0", "--periods", "16", "--transient-periods", "0"],
        ]
        .concat(),
    );
    done(&point);
    let warned = |output: &Output| text(&output.stderr).matches("the bush would turn by").count();
    assert_eq!(warned(&point), 1, "{}", text(&point.stderr));
    let history = tribochaos(folder.path(), &[&["history"], &far[..], &["--periods", "2"]].concat());
    done(&history);
    assert_eq!(warned(&history), 1, "{}", text(&history.stderr));
    let axes = [
        "map",
        "--x",
        "shaft_speed_amplitude=200:800:4",
        "--y",
        "damping=100:800:3",
        "--out",
        "far",
    ];
    let map = tribochaos(folder.path(), &[&axes[..], &far, &["--backend", "cpu"]].concat());
    done(&map);
    assert_eq!(warned(&map), 1, "{}", text(&map.stderr));
}

/// The machines of `examples/machines` can be built, as far as the program can tell, and go chaotic.
#[test]
fn machines_that_can_be_built_go_chaotic() {
    let folder = TempDir::new().unwrap();
    let machines = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/machines");
    let mut count = 0;
    for file in fs::read_dir(machines).unwrap() {
        let file = file.unwrap().path();
        let file = file.to_str().unwrap();
        let output = tribochaos(folder.path(), &["point", "--machine", file, "--json"]);
        assert_eq!(text(&output.stderr), "", "{file}");
        let point: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(point["class"], "chaotic", "{file}");
        let [exponent, error] = ["lyapunov", "lyapunov_error"].map(|name| point[name].as_f64().unwrap());
        assert!(exponent > 8.0 * error, "{file}: {exponent} +- {error}");
        count += 1;
    }
    assert_eq!(count, 2);
}
