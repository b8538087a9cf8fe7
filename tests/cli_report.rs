//! What is told of a store as a whole, from outside: the report, and tables as Parquet.

#![cfg(feature = "cli")]

mod program;

use std::fs;
use std::path::Path;
use std::process::Output;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use serde_json::Value;

use crate::program::{SHORT, fails, succeeds, tribochaos};

fn scan(folder: &Path, more: &[&str]) -> Output {
    tribochaos(folder, &[&["scan", "--quiet"], SHORT, more].concat())
}

const THREE: &[&str] = &["--x", "zeta_k=3:5:12", "--x", "h1=0:1.5:8", "--x", "b=log:0.5:2:3"];

#[test]
fn a_report_tells_what_its_store_holds() {
    let folder = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| tribochaos(folder.path(), args);
    succeeds(&scan(folder.path(), &[THREE, &["--out", "three.zarr"]].concat()));
    succeeds(&run(&["export", "three.zarr"]));
    let table = fs::read_to_string(folder.path().join("three.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .filter(|line| !line.starts_with('#'))
        .skip(1)
        .map(|line| line.split(',').collect())
        .collect();
    let chaotic = |row: &&Vec<&str>| row[6] == "chaotic";
    assert_eq!(rows.len(), 12 * 8 * 3);

    let told: Value = serde_json::from_str(&succeeds(&run(&["report", "three.zarr", "--json"]))).unwrap();
    assert!(
        !folder.path().join("three-report").exists(),
        "an object alone leaves no files"
    );
    assert_eq!(told["share_of_chaos"]["chaotic"], rows.iter().filter(chaotic).count());
    let coordinates = told["coordinates"].as_array().unwrap();
    assert_eq!(coordinates.len(), 3);
    for (place, coordinate) in coordinates.iter().enumerate() {
        for bin in coordinate["bins"].as_array().unwrap() {
            let value = bin["value"].as_f64().unwrap();
            let of_bin = rows
                .iter()
                .filter(|row| (row[place].parse::<f64>().unwrap() - value).abs() < 1e-9);
            assert_eq!(bin["points"], of_bin.clone().count());
            assert_eq!(bin["chaotic"], of_bin.filter(chaotic).count());
        }
        let [first, total] = ["first", "total"].map(|name| coordinate["sensitivity_of_chaos"][name].as_f64().unwrap());
        assert!(0.0 <= first && first <= total + 1e-12 && total <= 1.0, "{coordinate}");
    }

    let said = succeeds(&run(&["report", "three.zarr", "--at", "zeta_k=3.1", "--out", "told"]));
    for name in [
        "shares.png",
        "shares.svg",
        "shares.csv",
        "pairs.png",
        "pairs.svg",
        "report.md",
        "report.html",
    ] {
        assert!(folder.path().join("told").join(name).exists(), "{name}");
        assert!(said.contains(name), "{said}");
    }
    let page = fs::read_to_string(folder.path().join("told/report.md")).unwrap();
    for part in [
        "## Which coordinates matter",
        "zeta_k = 3.1, h1 = 0.75, b = 1",
        "AVX2|SSE2|NEON|lanes",
        "pairs.png",
    ] {
        assert!(part.split('|').any(|part| page.contains(part)), "{part}: {page}");
    }
    let web = fs::read_to_string(folder.path().join("told/report.html")).unwrap();
    assert!(
        web.contains("<td>zeta_k</td>") && web.contains("<img src=\"shares.png\""),
        "{web}"
    );

    // the same store again, another one, and what is not there
    succeeds(&run(&["report", "three.zarr", "--out", "told"]));
    succeeds(&scan(
        folder.path(),
        &[THREE, &["--set", "omega_0=1.8", "--out", "other.zarr"]].concat(),
    ));
    fails(
        &run(&["report", "other.zarr", "--out", "told"]),
        2,
        "another experiment",
    );
    fails(
        &run(&["report", "three.zarr", "--at", "zeta_k=6"]),
        2,
        "which has 3 to 5",
    );
    fails(
        &run(&["report", "three.zarr", "--at", "alpha=0.1"]),
        2,
        "alpha does not vary",
    );
    succeeds(&scan(
        folder.path(),
        &[THREE, &["--quantities", "lyapunov", "--out", "bare.zarr"]].concat(),
    ));
    fails(&run(&["report", "bare.zarr"]), 2, "does not hold class");
}

#[test]
fn a_report_of_a_sample_tells_what_it_cannot_know() {
    let folder = tempfile::tempdir().unwrap();
    let sample = [
        "--sample",
        "sobol:256",
        "--x",
        "zeta_k=3:5",
        "--x",
        "gamma=0:0",
        "--out",
        "s.zarr",
    ];
    fails(&scan(folder.path(), &sample), 2, "gamma");
    let sample = [
        "--sample",
        "sobol:256",
        "--x",
        "zeta_k=3:5",
        "--x",
        "h1=log:0.1:1.5",
        "--out",
        "s.zarr",
    ];
    succeeds(&scan(folder.path(), &sample));
    succeeds(&tribochaos(folder.path(), &["report", "s.zarr"]));
    let page = fs::read_to_string(folder.path().join("s-report/report.md")).unwrap();
    assert!(
        page.contains("Total indices cannot be told") && page.contains(" ± "),
        "{page}"
    );
}

/// A column that does not vary, and a single point.
#[test]
fn designs_without_extent_have_a_report() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("points.csv"), "zeta_k,h1\n3,0.5\n4,0.5\n").unwrap();
    succeeds(&scan(folder.path(), &["--points", "points.csv", "--out", "two.zarr"]));
    succeeds(&tribochaos(folder.path(), &["report", "two.zarr"]));
    fs::write(folder.path().join("point.csv"), "zeta_k,h1\n3,0.5\n").unwrap();
    succeeds(&scan(folder.path(), &["--points", "point.csv", "--out", "one.zarr"]));
    succeeds(&tribochaos(folder.path(), &["report", "one.zarr"]));
    let page = fs::read_to_string(folder.path().join("one-report/report.md")).unwrap();
    assert!(
        page.contains("all points are alike") && !page.contains("shares.png"),
        "{page}"
    );
    // another list of as many points has another identity
    fails(
        &tribochaos(folder.path(), &["report", "one.zarr", "--out", "two-report"]),
        2,
        "another experiment",
    );
    fs::write(folder.path().join("other.csv"), "zeta_k,h1\n3.1,0.5\n4.1,0.5\n").unwrap();
    succeeds(&scan(folder.path(), &["--points", "other.csv", "--out", "other.zarr"]));
    fails(
        &tribochaos(folder.path(), &["report", "other.zarr", "--out", "two-report"]),
        2,
        "another experiment",
    );
    fails(
        &tribochaos(folder.path(), &["report", "other.zarr", "--out", "other.csv"]),
        2,
        "is no folder",
    );
    // a rate without end
    fs::write(
        folder.path().join("rates.csv"),
        "zeta_k,ramp_rate\n3,inf\n4,10\n3.5,1\n",
    )
    .unwrap();
    succeeds(&scan(folder.path(), &["--points", "rates.csv", "--out", "rates.zarr"]));
    succeeds(&tribochaos(folder.path(), &["report", "rates.zarr"]));
    let page = fs::read_to_string(folder.path().join("rates-report/report.md")).unwrap();
    assert!(page.contains("ramp_rate = 5.5") && !page.contains("NaN"), "{page}");
}

#[test]
fn a_store_is_exported_as_parquet_with_the_values_of_its_csv() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(&scan(folder.path(), &[THREE, &["--out", "three.zarr"]].concat()));
    succeeds(&tribochaos(
        folder.path(),
        &["export", "three.zarr", "--out", "three.csv"],
    ));
    succeeds(&tribochaos(
        folder.path(),
        &["export", "three.zarr", "--out", "three.parquet"],
    ));
    let table = fs::read_to_string(folder.path().join("three.csv")).unwrap();
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let reader = SerializedFileReader::new(fs::File::open(folder.path().join("three.parquet")).unwrap()).unwrap();
    let schema = reader.metadata().file_metadata().schema_descr();
    let columns: Vec<&str> = schema.columns().iter().map(|column| column.name()).collect();
    assert_eq!(columns, names);
    let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 12 * 8 * 3);
    let place = |name: &str| names.iter().position(|other| *other == name).unwrap();
    for (line, row) in lines.zip(rows) {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields[0].parse::<f64>().unwrap(), row.get_double(0).unwrap());
        let exponent = place("lyapunov");
        assert_eq!(
            fields[exponent].parse::<f64>().unwrap(),
            row.get_double(exponent).unwrap()
        );
        assert_eq!(fields[place("class")], row.get_string(place("class")).unwrap());
        let period = place("period");
        assert_eq!(fields[period].parse::<f32>().ok(), row.get_float(period).ok());
    }
    fails(
        &tribochaos(folder.path(), &["export", "three.zarr", "--out", "three.xlsx"]),
        2,
        ".csv or .parquet",
    );
}
