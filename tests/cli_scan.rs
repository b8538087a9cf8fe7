//! Scans from outside: designs of any kind, stores that are gone on with and mended, several processes, and faults that are made for
//! real. After each fault the same command must end with the store that an undisturbed run writes, byte for byte but for the marks,
//! which tell when and on what a unit was computed.

#![cfg(feature = "cli")]

mod program;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use assert_cmd::cargo::cargo_bin;
use serde_json::Value;
use tempfile::TempDir;

use crate::program::{SHORT, fails, object, succeeds, text, tribochaos};

/// 960 points over four parameters.
const AXES: &[&str] = &[
    "--x",
    "zeta_k=3:5:16",
    "--x",
    "h1=0:1.5:10",
    "--x",
    "b=0.8,1,1.2",
    "--x",
    "epsilon=log:0.5:2:2",
];

/// The options of a scan of a second or two, in units of so many points: 60 units of 16.
fn options<'a>(design: &[&'a str], unit_points: &'a str) -> Vec<&'a str> {
    [&["scan"], design, SHORT, &["--unit-points", unit_points]].concat()
}

fn scan(folder: &Path, store: &str, more: &[&str]) -> Output {
    tribochaos(folder, &[&options(AXES, "16")[..], &["--out", store], more].concat())
}

fn spawn(folder: &Path, store: &str, more: &[&str]) -> Child {
    Command::new(cargo_bin!("tribochaos"))
        .current_dir(folder)
        .args([&options(AXES, "16")[..], &["--out", store], more].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// All files of a store by their paths in it; of marks only that they are there.
fn contents(store: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut contents = BTreeMap::new();
    let mut folders = vec![store.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(store).unwrap().to_owned();
            let is_mark = name.starts_with("status/done");
            contents.insert(name, if is_mark { Vec::new() } else { fs::read(&path).unwrap() });
        }
    }
    contents
}

fn assert_same(store: &Path, undisturbed: &Path) {
    let (found, expected) = (contents(store), contents(undisturbed));
    for name in found.keys() {
        assert!(expected.contains_key(name), "{} is there too", name.display());
    }
    for (name, bytes) in expected {
        assert!(found.get(&name) == Some(&bytes), "{} differs", name.display());
    }
}

/// Number of finished units; beside their marks there are claims, and marks that were not written to their end.
fn marks(store: &Path) -> usize {
    let names = fs::read_dir(store.join("status/done")).into_iter().flatten().flatten();
    names.filter(|name| name.path().extension().is_none()).count()
}

/// Waits until the store has so many finished units.
fn wait_for_marks(store: &Path, least: usize) {
    let started = Instant::now();
    while marks(store) < least {
        assert!(started.elapsed() < Duration::from_mins(2), "{} units", marks(store));
        sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_scan_over_four_parameters_is_stored_gone_on_with_and_described() {
    let folder = TempDir::new().unwrap();
    let said = succeeds(&scan(folder.path(), "four.zarr", &[]));
    assert!(said.contains("960 points in ") && said.contains("motion: "), "{said}");
    let again = succeeds(&scan(folder.path(), "four.zarr", &[]));
    assert!(
        again.contains("0 points in ") && again.contains("960 were there already"),
        "{again}"
    );
    let status = object(&tribochaos(folder.path(), &["status", "four.zarr", "--json"]));
    assert_eq!(
        (&status["finished"], &status["points_finished"]),
        (&60.into(), &960.into())
    );
    let motion: u64 = status["motion"]
        .as_object()
        .unwrap()
        .values()
        .map(|count| count.as_u64().unwrap())
        .sum();
    assert_eq!(motion, 960);
    assert_eq!(status["damaged"], Value::Array(Vec::new()));
    let printed = succeeds(&tribochaos(folder.path(), &["status", "four.zarr"]));
    assert!(printed.contains("60 of 60 finished, 0 missing, 0 damaged"), "{printed}");
    // of another experiment, of other quantities, or of no quantity
    fails(
        &scan(folder.path(), "four.zarr", &["--set", "omega_0=2.5"]),
        2,
        "set.omega_0 is 2.0 there and 2.5 here",
    );
    fails(
        &scan(folder.path(), "four.zarr", &["--quantities", "x"]),
        2,
        "does not hold x",
    );
    fails(
        &scan(folder.path(), "four.zarr", &["--quantities", "speed"]),
        2,
        "speed",
    );
    // the experiment that a store holds, with more of it stored
    let from = [
        "scan",
        "four.zarr",
        "--quantities",
        "lyapunov,x_max",
        "--out",
        "again.zarr",
        "--backend",
        "cpu",
    ];
    succeeds(&tribochaos(folder.path(), &from));
    // the motion is known though its class is not stored
    let again = object(&tribochaos(folder.path(), &["status", "again.zarr", "--json"]));
    assert_eq!(again["motion"], status["motion"]);
    let exponents = |store: &str| {
        contents(&folder.path().join(store))
            .into_iter()
            .filter(|(name, _)| name.starts_with("lyapunov/c"))
    };
    let all = |store: &str| exponents(store).map(|(_, bytes)| bytes.len() - 4).sum::<usize>();
    assert_eq!((all("four.zarr"), all("again.zarr")), (8 * 960, 8 * 960));
}

#[test]
fn cuts_and_tables_of_a_scan_hold_its_points() {
    let folder = TempDir::new().unwrap();
    succeeds(&scan(folder.path(), "four.zarr", &[]));
    let slice = |more: &[&str]| tribochaos(folder.path(), &[&["slice", "four.zarr"], more].concat());
    let cut = ["--x", "h1", "--y", "zeta_k", "--at", "b=1.2", "--at", "epsilon=0.5"];
    let said = succeeds(&slice(&[&cut[..], &["--out", "cut"]].concat()));
    for file in ["cut-lyapunov.png", "cut-period.png", "cut-border.csv"] {
        assert!(said.contains(file) && folder.path().join(file).exists(), "{said}");
    }
    // the same points as a map, whose experiment the picture holds
    let map = ["map", "--from", "cut-lyapunov.png", "--out", "map", "--backend", "cpu"];
    succeeds(&tribochaos(folder.path(), &map));
    let table = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(table("cut-border.csv"), table("map-border.csv"));
    for (args, expected) in [
        (
            &["--x", "h1", "--y", "zeta_k", "--at", "b=1"][..],
            "add --at epsilon=VALUE",
        ),
        (
            &["--x", "h1", "--y", "zeta_k", "--at", "b=0.9", "--at", "epsilon=2"],
            "the nearest value is ",
        ),
        (&["--x", "h1", "--y", "h1"], "give two different ones"),
        (&["--x", "h1", "--y", "gamma"], "its axes are zeta_k, h1, b, epsilon"),
        (&["--x", "h1", "--y", "b", "--at", "b=1"], "leave one of the two out"),
        (&[&cut[..], &["--quantity", "x_max", "--out", "cut"]].concat(), "x_max"),
    ] {
        fails(&slice(args), 2, expected);
    }

    succeeds(&tribochaos(folder.path(), &["export", "four.zarr"]));
    let rows: Vec<String> = table("four.csv")
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(str::to_owned)
        .collect();
    assert_eq!(rows.len(), 961);
    assert_eq!(
        rows[0],
        "zeta_k,h1,b,epsilon,lyapunov,lyapunov_error,period,class,status,backend"
    );
    // the last point as `point` has it
    let values: Vec<&str> = rows[960].split(',').collect();
    let point = object(&tribochaos(
        folder.path(),
        &[
            "point",
            "--from",
            "map-lyapunov.png",
            "--set",
            "zeta_k=5",
            "--set",
            "h1=1.5",
            "--set",
            "b=1.2",
            "--set",
            "epsilon=2",
            "--json",
        ],
    ));
    assert_eq!(&values[..4], ["5", "1.5", "1.2", "2"]);
    let exponent: f64 = values[4].parse().unwrap();
    assert!(
        (exponent - point["lyapunov"].as_f64().unwrap()).abs() < 1e-9,
        "{values:?} {point}"
    );
    assert_eq!(values[7], point["class"].as_str().unwrap());
    fails(
        &tribochaos(folder.path(), &["export", "four.zarr"]),
        2,
        "is there already",
    );
    // a table is a list of points again
    let points: Vec<String> = rows
        .iter()
        .map(|row| row.splitn(5, ',').take(4).collect::<Vec<_>>().join(","))
        .collect();
    fs::write(folder.path().join("points.csv"), points.join("\n")).unwrap();
    let design = options(&["--points", "points.csv"], "16");
    let again = [&design[..], &["--out", "again.zarr"]].concat();
    succeeds(&tribochaos(folder.path(), &again));
    succeeds(&tribochaos(folder.path(), &["export", "again.zarr"]));
    let again: Vec<String> = table("again.csv")
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(str::to_owned)
        .collect();
    assert!(again == rows);
}

#[test]
fn points_of_a_table_and_samples_of_a_box_are_scanned() {
    let folder = TempDir::new().unwrap();
    let run = |args: &[&str]| tribochaos(folder.path(), &[&["scan"], args, SHORT].concat());
    fs::write(
        folder.path().join("points.csv"),
        "\u{feff}zeta_k,h1\n3.5,0.5\n4,0.25\n# a note\n4.5,1\n",
    )
    .unwrap();
    succeeds(&run(&["--points", "points.csv", "--out", "points.zarr"]));
    let status = object(&tribochaos(folder.path(), &["status", "points.zarr", "--json"]));
    assert_eq!(status["points_finished"], 3);
    let sample = ["--sample", "sobol:64", "--x", "zeta_k=3:5", "--x", "gamma=log:1e-3:0.1"];
    let printed = succeeds(&run(&[&sample[..], &["--print-experiment"]].concat()));
    assert!(
        printed.contains("method = \"sobol\"") && printed.len() < 3000,
        "{printed}"
    );
    fs::write(folder.path().join("sample.toml"), printed).unwrap();
    succeeds(&run(&["sample.toml", "--out", "sample.zarr"]));
    // what was typed and what was read from the file are the same experiment
    let again = succeeds(&run(&[&sample[..], &["--out", "sample.zarr"]].concat()));
    assert!(again.contains("64 were there already"), "{again}");

    for (table, expected) in [
        ("zeta_k,zeta_k\n1,2\n", "the column zeta_k twice"),
        ("zeta_k,h1\n1,NaN\n", "row 1, column h1"),
        ("zeta_k,h1\n", "is empty"),
        ("zeta_k,damping\n1,2\n", "damping is a quantity of a machine"),
        ("zeta_k,colour\n1,2\n", "colour"),
    ] {
        fs::write(folder.path().join("bad.csv"), table).unwrap();
        fails(&run(&["--points", "bad.csv", "--out", "bad.zarr"]), 2, expected);
    }
    fs::write(folder.path().join("bad.csv"), b"zeta_k,h1\n1,2\n# K\xfchler\n").unwrap();
    fails(
        &run(&["--points", "bad.csv", "--out", "bad.zarr"]),
        2,
        "line 3 is not UTF-8",
    );
    for (args, expected) in [
        (&["--sample", "sobol:0", "--x", "zeta_k=3:5"][..], "from 1 to"),
        (&["--sample", "grid:9", "--x", "zeta_k=3:5"], "is no sample"),
        (&["--sample", "lhs:9"], "--x"),
        (&["--x", "zeta_k="], "zeta_k"),
        (&["--x", "zeta_k=3:5:4", "--part", "4/3"], "no part 4 of 3"),
        (&["--x", "zeta_k=3:5:4", "--part", "0/3"], "no part 0 of 3"),
        (&["--x", "zeta_k=3:5:4", "--part", "2/3"], "none is left for this part"),
        (&[], "nothing to scan"),
    ] {
        fails(&run(&[args, &["--out", "bad.zarr"]].concat()), 2, expected);
    }
    assert!(!folder.path().join("bad.zarr/lyapunov/c").exists());
}

#[test]
fn parts_and_tilings_of_a_scan_make_the_same_results() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    succeeds(&scan(folder.path(), "whole.zarr", &[]));
    for part in ["3/3", "1/3", "2/3"] {
        succeeds(&scan(folder.path(), "parts.zarr", &["--part", part]));
    }
    assert_same(&path("parts.zarr"), &path("whole.zarr"));
    // in units of another size the values are in other chunks: their order is that of the design in both
    let large = [&options(AXES, "160")[..], &["--out", "large.zarr"]].concat();
    succeeds(&tribochaos(folder.path(), &large));
    let exponents = |name: &str| -> Vec<u8> {
        let mut chunks: Vec<(Vec<usize>, Vec<u8>)> = contents(&path(name))
            .into_iter()
            .filter_map(|(file, bytes)| {
                let place = file.strip_prefix("lyapunov/c").ok()?;
                let place = place
                    .iter()
                    .map(|part| part.to_string_lossy().parse().unwrap())
                    .collect();
                Some((place, bytes[..bytes.len() - 4].to_vec()))
            })
            .collect();
        chunks.sort();
        chunks.into_iter().flat_map(|(_, bytes)| bytes).collect()
    };
    assert!(exponents("large.zarr") == exponents("whole.zarr"));
}

#[test]
fn processes_that_are_given_one_store_share_it() {
    let folder = TempDir::new().unwrap();
    let children: Vec<Child> = (0..3)
        .map(|_| spawn(folder.path(), "shared.zarr", &["--json"]))
        .collect();
    for child in children {
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    succeeds(&scan(folder.path(), "alone.zarr", &[]));
    assert_same(&folder.path().join("shared.zarr"), &folder.path().join("alone.zarr"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "no locks are left");
}

/// Kills runs at moments from the first files to the last ones, also two that share the work.
fn kill_at_random(kills: usize, seed: u64) {
    let folder = TempDir::new().unwrap();
    let store = folder.path().join("killed.zarr");
    succeeds(&scan(folder.path(), "whole.zarr", &[]));
    let mut random = seed;
    for kill in 0..kills {
        let before = marks(&store);
        let mut children = vec![spawn(folder.path(), "killed.zarr", &[])];
        if kill % 4 == 3 {
            children.push(spawn(folder.path(), "killed.zarr", &[]));
        }
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        sleep(Duration::from_micros(20_000 + (random >> 33) % 150_000));
        for mut child in children {
            let _ = child.kill();
            let _ = child.wait();
        }
        assert!(marks(&store) >= before, "finished units are lost");
        if marks(&store) == 60 {
            fs::remove_dir_all(&store).unwrap();
        }
    }
    succeeds(&scan(folder.path(), "killed.zarr", &[]));
    assert_same(&store, &folder.path().join("whole.zarr"));
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        2,
        "nothing is left beside the stores"
    );
}

#[test]
fn runs_that_are_killed_lose_nothing() {
    kill_at_random(20, 1);
}

#[test]
#[ignore = "takes minutes"]
fn runs_that_are_killed_two_hundred_times_lose_nothing() {
    kill_at_random(200, 2);
}

#[test]
fn damage_is_named_and_only_damaged_units_are_computed_again() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    succeeds(&scan(folder.path(), "whole.zarr", &[]));
    succeeds(&scan(folder.path(), "s.zarr", &[]));
    let flip = |file: &str| {
        let mut bytes = fs::read(path(file)).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 4;
        fs::write(path(file), bytes).unwrap();
    };
    let verify = |more: &[&str]| tribochaos(folder.path(), &[&["verify", "s.zarr"], more].concat());
    assert!(succeeds(&verify(&[])).contains("60 of 60 finished"));
    // bits of values and of a mark, a cut chunk, a missing one
    flip("s.zarr/lyapunov/c/0/0/3/0");
    flip("s.zarr/status/done/7");
    fs::write(path("s.zarr/class/c/0/1/0/0"), "cut").unwrap();
    fs::remove_file(path("s.zarr/period/c/1/2/9/0")).unwrap();
    let output = verify(&[]);
    fails(
        &output,
        1,
        "4 units of s.zarr are damaged: `tribochaos verify s.zarr --repair`",
    );
    for said in [
        "the array `lyapunov`, chunk c/0/0/3/0",
        "the mark of unit 7",
        "the array `class`, chunk c/0/1/0/0",
        "the array `period`, chunk c/1/2/9/0: it is missing",
    ] {
        assert!(text(&output.stderr).contains(said), "{}", text(&output.stderr));
    }
    assert!(succeeds(&verify(&["--repair"])).contains("4 units were computed again"));
    assert!(succeeds(&verify(&[])).contains("60 of 60 finished"));
    assert_same(&path("s.zarr"), &path("whole.zarr"));
    // the command that computed it does the same
    flip("s.zarr/period/c/1/2/9/0");
    fs::remove_file(path("s.zarr/status/done/3")).unwrap();
    let output = scan(folder.path(), "s.zarr", &[]);
    assert!(succeeds(&output).contains("32 points in "), "{}", text(&output.stdout));
    assert!(
        text(&output.stderr).contains("is damaged (the array `period`"),
        "{}",
        text(&output.stderr)
    );
    assert_same(&path("s.zarr"), &path("whole.zarr"));
    // and metadata
    for file in ["zarr.json", "h1/c/0", "class/zarr.json"] {
        flip(&format!("s.zarr/{file}"));
        let named = format!("its file {file}; the command that computed it writes it anew");
        fails(&verify(&["--repair"]), 2, &named);
        let output = scan(folder.path(), "s.zarr", &[]);
        assert!(
            succeeds(&output).contains("0 points in "),
            "{file}: {}",
            text(&output.stdout)
        );
        assert!(
            text(&output.stderr).contains(&format!("its file {file}")),
            "{}",
            text(&output.stderr)
        );
        assert_same(&path("s.zarr"), &path("whole.zarr"));
    }
    fs::write(path("s.zarr/zarr.json"), "").unwrap();
    fails(
        &scan(folder.path(), "s.zarr", &["--set", "omega_0=2.5"]),
        2,
        "no unit tells that it holds this experiment",
    );
}

#[test]
fn a_store_that_is_taken_away_in_the_middle_is_no_success() {
    let folder = TempDir::new().unwrap();
    let store = folder.path().join("gone.zarr");
    let child = spawn(folder.path(), "gone.zarr", &[]);
    wait_for_marks(&store, 3);
    fs::rename(&store, folder.path().join("moved.zarr")).unwrap();
    let output = child.wait_with_output().unwrap();
    fails(&output, 1, "was removed or replaced while it was written");
    assert!(!store.exists());
    // and a unit that disappears is noticed at the end
    let child = spawn(folder.path(), "gone.zarr", &[]);
    wait_for_marks(&store, 3);
    fs::remove_file(store.join("status/done/0")).unwrap();
    fails(&child.wait_with_output().unwrap(), 1, "unit 0 was finished and is gone");
    succeeds(&scan(folder.path(), "gone.zarr", &[]));
    succeeds(&scan(folder.path(), "whole.zarr", &[]));
    assert_same(&store, &folder.path().join("whole.zarr"));
}

/// On a small disk of its own, which is filled while the scan runs.
#[test]
#[cfg(target_os = "linux")]
fn a_disk_that_fills_up_in_the_middle_costs_nothing_that_is_finished() {
    let folder = TempDir::new().unwrap();
    succeeds(&scan(folder.path(), "whole.zarr", &[]));
    let script = format!(
        "set -e
        mkdir disk && mount -t tmpfs -o size=8m none disk
        {program} {scan} --out disk/full.zarr >/dev/null 2>said & child=$!
        while [ ! -e disk/full.zarr/status/done/2 ]; do sleep 0.01; done
        head -c 8m /dev/zero > disk/filling || true
        code=0; wait $child || code=$?
        [ $code = 1 ]
        grep -q 'cannot be written: .*No space left' said
        rm disk/filling
        {program} {scan} --out disk/full.zarr >/dev/null
        cp -r disk/full.zarr .",
        program = cargo_bin!("tribochaos").display(),
        scan = options(AXES, "16").join(" ")
    );
    let own_mounts = ["--user", "--map-root-user", "--mount"];
    let possible = Command::new("unshare")
        .args(own_mounts)
        .args(["mount", "-t", "tmpfs", "none", "/mnt"])
        .output();
    if !possible.is_ok_and(|output| output.status.success()) {
        let required = std::env::var_os("TRIBOCHAOS_REQUIRE_MOUNT").is_some();
        assert!(!required, "a disk of its own is required");
        eprintln!("skipped: no disk can be mounted");
        return;
    }
    let output = Command::new("unshare")
        .args(own_mounts)
        .args(["bash", "-c", &script])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = fs::read_to_string(folder.path().join("said")).unwrap_or_default();
    assert!(output.status.success(), "{} {said}", text(&output.stderr));
    assert_same(&folder.path().join("full.zarr"), &folder.path().join("whole.zarr"));
}

/// As in a map, an axis goes over what the preset sets; a value of --set stays, and is refused.
#[test]
fn an_axis_of_a_scan_goes_over_the_preset() {
    let folder = TempDir::new().unwrap();
    let args = ["scan", "--preset", "paper", "--x", "gamma=0:1:3", "--dry-run"];
    succeeds(&tribochaos(folder.path(), &args));
    let set = tribochaos(folder.path(), &[&args[..], &["--set", "gamma=1"]].concat());
    fails(&set, 2, "gamma is an axis and set to a value as well");
}
