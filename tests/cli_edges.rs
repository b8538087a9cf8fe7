//! The program where things go wrong or are unusual: lost output, signals, unusual axes, results without files.

#![cfg(feature = "cli")]

mod program;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use assert_cmd::cargo::cargo_bin;
use serde_json::Value;
use tempfile::TempDir;

use program::{text, tribochaos};

/// A map of a moment.
const SMALL: [&str; 11] = [
    "map",
    "--x",
    "zeta_k=3:5:6",
    "--y",
    "h1=0.1,0.5,1.2",
    "--backend",
    "cpu",
    "--transient-periods",
    "60",
    "--periods",
    "32",
];

fn small(folder: &Path, more: &[&str]) -> std::process::Output {
    tribochaos(folder, &[&SMALL[..], more].concat())
}

fn object(output: &std::process::Output) -> Value {
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one object")
}

#[test]
fn listed_and_logarithmic_axes_are_computed_stored_drawn_and_resumed() {
    let folder = TempDir::new().unwrap();
    let axes = [
        "map",
        "--x",
        "gamma=log:0.01:1:3",
        "--y",
        "h1=1,0.1",
        "--periods",
        "16",
        "--transient-periods",
        "16",
    ];
    let output = tribochaos(folder.path(), &axes);
    let (said, warned) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "{warned}");
    assert!(
        said.contains("over gamma = 0.01..1, logarithmic (3) by h1 = a list from 0.1 to 1 (2)"),
        "{said}"
    );
    assert!(said.contains("6 points in"), "{said}");
    assert!(folder.path().join("outputs/map-lyapunov.png").exists());
    let again = text(&tribochaos(folder.path(), &axes).stdout);
    assert!(again.contains("all 6 points were in the store already"), "{again}");
    let dry = text(&tribochaos(folder.path(), &[&axes[..], &["--dry-run"]].concat()).stdout);
    assert!(
        dry.contains("0 of 6 points are left") && !dry.contains("about"),
        "{dry}"
    );
    let printed = text(
        &tribochaos(
            folder.path(),
            &["map", "--from", "outputs/map.zarr", "--print-experiment"],
        )
        .stdout,
    );
    assert!(
        printed.contains("spacing = \"log\"") && printed.contains("values = ["),
        "{printed}"
    );
}

#[test]
fn an_object_without_a_name_leaves_nothing_behind() {
    let folder = TempDir::new().unwrap();
    let found = object(&small(folder.path(), &["--json"]));
    assert_eq!(
        (&found["points"], &found["computed"]),
        (&Value::from(18), &Value::from(18))
    );
    let classes = found["classes"].as_object().unwrap().values();
    assert_eq!(classes.filter_map(Value::as_u64).sum::<u64>(), 18);
    for args in [
        &["lyapunov", "--x", "zeta_k=3.5:3.9:3", "--no-onset", "--json"][..],
        &["bifurcation", "--x", "zeta_k=3.5:3.9:3", "--json"],
        &["phase", "--json"],
        &["poincare", "--points", "100", "--json"],
        &["history", "--periods", "2", "--json"],
        &["melnikov", "--json-line"],
        &["melnikov", "--set", "h1=0.7", "--json-line"],
        &["devices", "--json"],
    ] {
        let output = tribochaos(folder.path(), args);
        object(&output);
        let lines = text(&output.stdout).lines().count();
        assert_eq!(lines == 1, args.contains(&"--json-line"), "{args:?}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);

    let found = object(&small(folder.path(), &["--json", "--out", "m"]));
    for file in found["files"].as_array().unwrap() {
        assert!(folder.path().join(file.as_str().unwrap()).exists(), "{file}");
    }
    let found = object(&tribochaos(folder.path(), &["render", "m.zarr", "--json"]));
    assert_eq!(found["status"]["ok"], 18);
}

#[test]
#[cfg(target_os = "linux")]
fn output_that_is_lost_is_an_error() {
    let folder = TempDir::new().unwrap();
    for args in [
        &["point", "--json"][..],
        &["machine", "--template"],
        &["map", "--print-experiment"],
        &["devices"],
        &["--help"],
        &["--version"],
        &["completions", "bash"],
    ] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = Command::new(cargo_bin!("tribochaos"))
            .args(args)
            .current_dir(folder.path())
            .stdout(full)
            .output()
            .unwrap();
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{args:?}: {stderr}");
        assert!(
            stderr.contains("standard output cannot be written"),
            "{args:?}: {stderr}"
        );
    }
    // a reader that closes the pipe is none
    let mut child = Command::new(cargo_bin!("tribochaos"))
        .args(["map", "--help"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

/// Starts a long map in a shell that may ignore a signal, sends the signal, and returns exit code and words.
#[cfg(target_os = "linux")]
fn stopped(folder: &Path, before: &str, signal: &str, patience: Duration) -> (Option<i32>, String) {
    let program = cargo_bin!("tribochaos");
    let args = "map --x zeta_k=3:5:400 --y h1=0:1.5:400 --backend cpu --full-length --scheme rk4 --out m";
    let mut child = Command::new("env")
        .args(["--default-signal=INT,HUP,TERM", "sh", "-c"])
        .arg(format!("{before} exec {} {args}", program.display()))
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let process = child.id().to_string();
    let send = |signal: &str| {
        assert!(
            Command::new("kill")
                .args([signal, &process])
                .status()
                .unwrap()
                .success()
        );
    };
    let begun = Instant::now();
    while !folder.join("m.zarr/zarr.json").exists() {
        assert!(begun.elapsed() < Duration::from_mins(1), "no store");
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(300));
    send(signal);
    let sent = Instant::now();
    while child.try_wait().unwrap().is_none() && sent.elapsed() < patience {
        std::thread::sleep(Duration::from_millis(50));
    }
    if child.try_wait().unwrap().is_none() {
        send("-TERM");
    }
    let output = child.wait_with_output().unwrap();
    (output.status.code(), text(&output.stderr))
}

#[test]
#[cfg(target_os = "linux")]
fn a_signal_is_told_by_its_name_and_one_that_is_ignored_stays_ignored() {
    let folder = TempDir::new().unwrap();
    let (code, said) = stopped(folder.path(), "", "-HUP", Duration::from_mins(2));
    assert!(
        code == Some(129) && said.contains("stopped by SIGHUP"),
        "{code:?}: {said}"
    );
    let folder = TempDir::new().unwrap();
    let (code, said) = stopped(folder.path(), "trap '' HUP;", "-HUP", Duration::from_millis(1500));
    assert!(
        code == Some(143) && said.contains("stopped by SIGTERM"),
        "{code:?}: {said}"
    );
    assert!(said.contains("units are finished and kept in m.zarr"), "{said}");
}

#[test]
fn completions_and_man_pages_are_made() {
    let folder = TempDir::new().unwrap();
    let bash = text(&tribochaos(folder.path(), &["completions", "bash"]).stdout);
    assert!(bash.contains("--onset-spacing"), "{bash}");
    assert!(
        tribochaos(folder.path(), &["completions", "--man", "man"])
            .status
            .success()
    );
    let page = fs::read_to_string(folder.path().join("man/tribochaos-map.1")).unwrap();
    assert!(page.contains("full\\-length"), "{page}");
    assert_eq!(tribochaos(folder.path(), &["completions"]).status.code(), Some(2));
}

#[test]
fn short_help_is_short_and_no_line_of_the_long_one_is_wide() {
    let folder = TempDir::new().unwrap();
    let short = text(&tribochaos(folder.path(), &["map", "-h"]).stdout);
    let long = text(&tribochaos(folder.path(), &["map", "--help"]).stdout);
    assert!(!short.contains("ramp_rate") && long.contains("ramp_rate"));
    let onset = text(&tribochaos(folder.path(), &["lyapunov", "--help"]).stdout);
    assert!(
        onset.contains("The onset of chaos is the least chaotic value"),
        "{onset}"
    );
    let table = long.split("Parameters (").nth(1).unwrap();
    let widest = table.lines().map(|line| line.chars().count()).max().unwrap();
    assert!(widest <= 86, "{widest}");
}

#[test]
fn text_that_is_no_number_is_called_that() {
    let folder = TempDir::new().unwrap();
    let output = tribochaos(folder.path(), &["point", "--set", "h1=abc"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output.stderr).contains("`abc` is no number"),
        "{}",
        text(&output.stderr)
    );
}

/// The shared libraries that a command looks for, by the loader's own account.
#[cfg(all(target_os = "linux", target_env = "gnu", feature = "gpu"))]
fn libraries(folder: &Path, args: &[&str]) -> String {
    let output = Command::new(cargo_bin!("tribochaos"))
        .current_dir(folder)
        .args(args)
        .env("LD_DEBUG", "libs")
        .env("LD_DEBUG_OUTPUT", folder.join("libs"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{args:?} {}", text(&output.stderr));
    let mut told = String::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.file_name().unwrap().to_string_lossy().starts_with("libs.") {
            told += &fs::read_to_string(&path).unwrap();
            fs::remove_file(path).unwrap();
        }
    }
    assert!(told.contains("find library="), "{args:?}");
    told
}

#[test]
#[cfg(all(target_os = "linux", target_env = "gnu", feature = "gpu"))]
fn no_gpu_is_looked_for_where_none_is_needed() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let looks = |args: &[&str]| libraries(folder, args).contains("libvulkan");
    for args in [
        &SMALL[..],
        &["point", "--transient-periods", "60", "--periods", "32"],
        &["render", "outputs/map.zarr"],
        &["status", "outputs/map.zarr"],
        &["verify", "outputs/map.zarr"],
        &[
            "slice",
            "outputs/map.zarr",
            "--x",
            "zeta_k",
            "--y",
            "h1",
            "--out",
            "slice",
        ],
        &["export", "outputs/map.zarr", "--out", "map.csv"],
        &["report", "outputs/map.zarr", "--out", "report.html"],
    ] {
        assert!(!looks(args), "{args:?}");
    }
    assert!(
        looks(&["map", "--dry-run", "--out", "other"]),
        "a map looks for a GPU unless it is told not to"
    );
}

#[test]
fn two_builds_are_timed_in_turn() {
    let folder = TempDir::new().unwrap();
    let program = cargo_bin!("tribochaos").display().to_string();
    let args = ["bench", "--against", &program, "--commands", "point", "--rounds", "3"];
    let output = object(&tribochaos(folder.path(), &[&args[..], &["--json"]].concat()));
    let [row] = &output["commands"].as_array().unwrap()[..] else {
        panic!("{output}")
    };
    let number = |name: &str| row[name].as_f64().unwrap();
    assert!(number("least") <= number("ratio") && number("ratio") <= number("greatest"));
    assert!(number("least") > 0.0 && number("seconds_against") > 0.0);
    let said = text(&tribochaos(folder.path(), &args).stdout);
    assert!(said.contains("3 rounds in turn"), "{said}");
    for (other, expected) in [("nothing", "is not there"), ("/bin/true", "is no tribochaos")] {
        let output = tribochaos(folder.path(), &["bench", "--against", other]);
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains(expected), "{}", text(&output.stderr));
    }
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        0,
        "nothing is left behind"
    );
}
