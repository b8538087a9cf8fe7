//! The border of chaos from outside: what is written, what is gone on with, and what is refused.

#![cfg(feature = "cli")]

mod program;

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::program::{SHORT, fails, object, text, tribochaos};

fn threshold(folder: &Path, more: &[&str]) -> Output {
    let sides = ["threshold", "--x", "zeta_k=3:5", "--y", "h1=0:1.5", "--first", "8"];
    tribochaos(folder, &[&sides[..], SHORT, more].concat())
}

/// The same command computes nothing anew, one with a smaller width only what it needs besides; other experiments are not touched.
#[test]
fn a_search_is_gone_on_with() {
    let folder = tempfile::tempdir().unwrap();
    let json = |width: &str, more: &[&str]| {
        let asked = ["--width", width, "--out", "border", "--json"];
        threshold(folder.path(), &[&asked[..], more].concat())
    };
    let first = object(&json("0.05", &[]));
    assert_eq!(first["computed_now"], first["points"]);
    assert_eq!(first["points_of_grid"], 33.0 * 33.0);
    let table = fs::read(folder.path().join("border-border.csv")).unwrap();
    let picture = fs::read(folder.path().join("border-lyapunov.png")).unwrap();

    let again = object(&json("0.05", &[]));
    assert_eq!(again["computed_now"], 0);
    assert_eq!(fs::read(folder.path().join("border-border.csv")).unwrap(), table);
    assert_eq!(fs::read(folder.path().join("border-lyapunov.png")).unwrap(), picture);

    let finer = object(&json("0.02", &[]));
    let points = |object: &Value, name: &str| object[name].as_u64().unwrap();
    assert_eq!(
        points(&finer, "computed_now") + points(&first, "points"),
        points(&finer, "points")
    );
    let boxes = |object: &Value| object["boxes"].as_array().unwrap().len();
    assert_eq!((boxes(&first), boxes(&finer)), (3, 4));
    assert!(
        first["dimension"].is_null() && finer["dimension"].is_null(),
        "four widths tell no dimension"
    );
    let finest = object(&json("0.01", &[]));
    assert!(finest["dimension"]["value"].as_f64().unwrap() > 0.8, "{finest}");

    fails(
        &json("0.02", &["--set", "omega_0=2.5"]),
        2,
        "belongs to another experiment",
    );
    fs::remove_file(folder.path().join("border-lyapunov.png")).unwrap();
    fs::remove_file(folder.path().join("border-border.csv")).unwrap();
    fails(
        &json("0.02", &["--set", "omega_0=2.5"]),
        2,
        "omega_0 is 2.0 there and 2.5 here",
    );
    let replaced = object(&json("0.05", &["--set", "omega_0=2.5", "--force"]));
    assert_eq!(replaced["computed_now"], replaced["points"]);
    // no round of the first search is left in the way of a smaller width
    object(&json("0.02", &["--set", "omega_0=2.5"]));

    let map = ["map", "--x", "zeta_k=3:5:5", "--y", "h1=0:1.5:5", "--out", "map"];
    assert!(tribochaos(folder.path(), &[&map[..], SHORT].concat()).status.success());
    fails(
        &threshold(folder.path(), &["--width", "0.05", "--out", "map"]),
        2,
        "belongs to another experiment",
    );
}

/// Lines of the table lie between a chaotic point of a round and another one, as far apart as a finest cell.
#[test]
fn three_sides_have_lines_in_planes() {
    let folder = tempfile::tempdir().unwrap();
    let asked = [
        "--z",
        "b=log:0.5:2",
        "--first",
        "4",
        "--width",
        "0.1",
        "--out",
        "border",
        "--quiet",
    ];
    let sides = ["threshold", "--x", "zeta_k=3:5", "--y", "h1=0:1.5"];
    let output = tribochaos(folder.path(), &[&sides[..], SHORT, &asked].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    assert!(said.contains("b = 0.5..2, logarithmic: from 1/4 to 1/16"), "{said}");
    assert!(said.contains("of the 4913 points"), "{said}");
    assert!(folder.path().join("border.png").exists() && folder.path().join("border.svg").exists());
    let table = fs::read_to_string(folder.path().join("border-border.csv")).unwrap();
    let mut rows = table.lines().filter(|line| !line.starts_with('#'));
    assert_eq!(rows.next(), Some("line,zeta_k,h1,b,along,half_width"));
    let rows: Vec<Vec<f64>> = rows
        .map(|row| row.split(',').map(|value| value.parse().unwrap()).collect())
        .collect();
    assert!(rows.len() > 20);
    for row in &rows {
        let half = [1.0 / 16.0, 0.75 / 16.0][row[4] as usize - 1];
        assert!((row[5] - half).abs() < 1e-12, "{row:?}");
        let plane = 16.0 * (row[3] / 0.5).ln() / 4f64.ln();
        assert!((plane - plane.round()).abs() < 1e-9, "{row:?}");
    }
    // a line lies in one plane
    let planes = rows.windows(2).filter(|pair| pair[0][0] == pair[1][0]);
    assert!(planes.clone().count() > 10 && planes.into_iter().all(|pair| pair[0][3] == pair[1][3]));
}

#[test]
fn bad_boxes_and_widths_are_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |more: &[&str], reason| {
        let sides = ["threshold", "--out", "border"];
        fails(&tribochaos(folder.path(), &[&sides[..], more].concat()), 2, reason);
    };
    refused(&["--width", "0"], "the width 0 is out of range");
    refused(&["--width", "0.5"], "below 0.03125");
    refused(&["--first", "1"], "at least 2");
    refused(&["--x", "h1=0:1"], "two sides");
    refused(&["--x", "h1=1:0"], "h1");
    refused(&["--x", "zeta_k=0:1:5"], "NAME=START:STOP");
    refused(&["--set", "k_w=0.1"], "the contact wears");
    refused(&["--z", "b=0.5:1", "--overlay", "melnikov"], "--overlay");
    refused(&["--x", "zetta_k=0:1"], "did you mean");
    let few = threshold(
        folder.path(),
        &["--width", "0.01", "--most-points", "100", "--out", "border"],
    );
    assert_eq!(few.status.code(), Some(1));
    assert!(
        text(&few.stderr).contains("at most 100 may be"),
        "{}",
        text(&few.stderr)
    );
}
