//! The program as the tests from outside run it, and the tables that it writes.

#![allow(dead_code, reason = "every test file uses some of the helpers, none uses all")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use assert_cmd::cargo::cargo_bin;

/// The shortest lengths of runs, on the CPU.
pub const SHORT: &[&str] = &[
    "--backend",
    "cpu",
    "--transient-periods",
    "60",
    "--align-periods",
    "20",
    "--periods",
    "64",
];

/// What a command that ends well prints.
pub fn succeeds(output: &Output) -> String {
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

/// A command ends with this exit code, and says this.
pub fn fails(output: &Output, code: i32, expected: &str) {
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{said}");
    assert!(said.contains(expected), "{said}");
}

/// The object that a command that ends well prints.
pub fn object(output: &Output) -> serde_json::Value {
    serde_json::from_str(&succeeds(output)).unwrap()
}

pub fn tribochaos(folder: &Path, args: &[&str]) -> Output {
    Command::new(cargo_bin!("tribochaos"))
        .current_dir(folder)
        .args(args)
        .output()
        .unwrap()
}

/// The program with the signals that stop it as they are by default: one that is ignored, as in a job in the background, stays
/// ignored in the program.
pub fn with_signals() -> Command {
    if !cfg!(target_os = "linux") {
        return Command::new(cargo_bin!("tribochaos"));
    }
    let mut command = Command::new("env");
    command
        .arg("--default-signal=INT,HUP,TERM")
        .arg(cargo_bin!("tribochaos"));
    command
}

/// As [`tribochaos`], with files under their usual names: an object alone leaves none. `bench` never writes any.
pub fn drawing(folder: &Path, args: &[&str]) -> Output {
    if !args.contains(&"--json") || args.contains(&"--out") || args[0] == "bench" {
        return tribochaos(folder, args);
    }
    let name = if args.contains(&"--lifetime") {
        "lifetime"
    } else {
        args[0]
    };
    let out = format!("outputs/{name}");
    tribochaos(folder, &[args, &["--out", &out]].concat())
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Names and rows of a table.
pub fn table(path: &Path) -> (String, Vec<Vec<f64>>) {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines().skip_while(|line| line.starts_with('#'));
    let names = lines.next().unwrap().to_owned();
    let number = |field: &str| field.parse().unwrap_or(f64::NAN);
    (names, lines.map(|line| line.split(',').map(number).collect()).collect())
}
