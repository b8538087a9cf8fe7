//! The command `history` from outside: what is typed, what comes out, and with which exit code.

#![cfg(feature = "cli")]

mod program;

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use program::{drawing, table, text};

fn history(folder: &Path, args: &[&str]) -> Output {
    drawing(folder, &[&["history"], args].concat())
}

#[track_caller]
fn run(folder: &Path, args: &[&str]) -> (String, String) {
    let output = history(folder, args);
    let stderr = text(&output.stderr);
    assert!(output.status.success(), "{args:?}: {stderr}");
    (text(&output.stdout), stderr)
}

#[track_caller]
fn assert_near(value: &Value, expected: f64, relative: f64) {
    let value = value.as_f64().unwrap();
    assert!(
        (value / expected - 1.0).abs() < relative,
        "{value}, expected {expected}"
    );
}

#[test]
fn the_preset_loses_contact_in_table_picture_and_summary() {
    let folder = TempDir::new().unwrap();
    let (said, warned) = run(folder.path(), &["--preset", "paper", "--json"]);
    assert_eq!(warned, "");
    let found: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(
        (&found["status"], &found["contact_status"]),
        (&"ok".into(), &"lost".into())
    );
    for (key, expected, relative) in [
        ("contact_time", 72.0556, 1e-3),
        ("final_wear", 30.206, 1e-3),
        ("peak_pressure", 95.955, 1e-3),
        ("peak_pressure_time", 6.733, 1e-3),
        ("peak_temperature", 543.0, 0.02),
    ] {
        assert_near(&found[key], expected, relative);
    }
    for file in found["files"].as_array().unwrap() {
        assert!(folder.path().join(file.as_str().unwrap()).is_file(), "{file}");
    }
    let (names, rows) = table(&folder.path().join("outputs/history.csv"));
    assert_eq!(names, "tau,x,y,v,pressure,wear,temperature");
    assert_eq!(rows.len(), 30 * 128 + 1);
    let lost = found["contact_time"].as_f64().unwrap();
    for row in &rows {
        assert!(if row[0] < lost { row[4] > 0.0 } else { row[4] == 0.0 }, "{row:?}");
    }
    let svg = fs::read_to_string(folder.path().join("outputs/history.svg")).unwrap();
    // between them the subscript of tau_c
    assert!(svg.contains(">contact lost at τ<") && svg.contains("> = 72.05"));
}

#[test]
fn without_heat_and_wear_the_pressure_is_1() {
    let folder = TempDir::new().unwrap();
    let args = ["--periods", "3", "--samples", "16", "--out", "reduced"];
    let (said, _) = run(folder.path(), &args);
    assert!(
        said.contains("contact             held") && said.contains("wrote reduced.png"),
        "{said}"
    );
    let (_, rows) = table(&folder.path().join("reduced.csv"));
    assert_eq!(rows.len(), 3 * 16 + 1);
    assert!(rows.iter().all(|row| row[4..] == [1.0, 0.0, 0.0]));
    // where the initial state is that of the defaults
    assert_eq!(rows[0][..3], [0.0, 0.1, 0.0]);

    // the same again is allowed, another one is not
    run(folder.path(), &args);
    let other = ["--periods", "4", "--out", "reduced"];
    let refused = history(folder.path(), &other);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("--force"));
    run(folder.path(), &[&other[..], &["--force"]].concat());
}

#[test]
fn the_length_of_a_transient_is_no_matter_of_a_history() {
    let folder = TempDir::new().unwrap();
    let hot = [
        "--preset",
        "paper",
        "--set",
        "k_w=0",
        "--set",
        "zeta_k=3.5",
        "--periods",
        "2",
    ];
    let (_, warned) = run(folder.path(), &hot);
    assert_eq!(warned, "");
}

#[test]
fn a_run_that_is_given_up_shows_what_there_is() {
    let folder = TempDir::new().unwrap();
    // without the cubic spring the saddle repels for ever
    let (said, warned) = run(folder.path(), &["--set", "b=-1", "--json", "--out", "r"]);
    let found: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(found["status"], "runaway");
    assert!(
        warned.contains("given up after tau = ") && warned.contains("the motion ran away"),
        "{warned}"
    );
    let (_, rows) = table(&folder.path().join("r.csv"));
    assert!(!rows.is_empty() && rows.len() < 30 * 128);
    assert!(rows.iter().flatten().all(|value| value.is_finite()));
    assert!(
        fs::read_to_string(folder.path().join("r.svg"))
            .unwrap()
            .contains("Given up after")
    );
}

#[test]
fn what_has_no_meaning_is_refused_before_any_work() {
    let folder = TempDir::new().unwrap();
    for (args, reason) in [
        (&["--samples", "0"][..], "4..=4096"),
        (&["--periods", "0"], "from 1 to 7812"),
        (&["--periods", "100000"], "from 1 to 7812 with 128 samples"),
        (&["--set", "gamma=-1"], "out of range"),
        (&["--set", "biot=0"], "out of range"),
        (&["--set", "gama=1"], "gamma"),
        (&["--preset", "steel"], "no preset `steel`"),
        (&["--modes", "0"], "modes = 0"),
        (&["--tolerance", "1"], "tolerance = 1"),
        (&["--scheme", "rk4"], "leave --scheme out"),
        (&["--precision", "f32"], "in f64"),
        (&["--backend", "gpu"], "on the CPU"),
        (&["--transient-periods", "5"], "leave --transient-periods out"),
        (&["--initial-states", "2"], "one initial state"),
        (&["--out", "folder/"], "names no file"),
    ] {
        let output = history(folder.path(), args);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {stderr}");
        assert!(stderr.contains(reason), "{args:?}: {reason} is not in: {stderr}");
    }
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        0,
        "nothing is left behind"
    );
}
