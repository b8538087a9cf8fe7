//! The store opens in Python's xarray as a labelled data set. Where Python or xarray is missing the test is skipped,
//! unless TRIBOCHAOS_REQUIRE_PYTHON is set.

#![cfg(feature = "store")]

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use tribochaos::backend::BackendKind;
use tribochaos::design::{Axis, Coordinate, Points, Varied};
use tribochaos::engine::{Origin, Sink};
use tribochaos::experiment::Request;
use tribochaos::machine::{Description, TEMPLATE};
use tribochaos::measure::{Class, Measurement, Quantity, Status};
use tribochaos::store::Store;

fn has_xarray() -> bool {
    let found = Command::new("python3").args(["-c", "import xarray, zarr"]).output();
    let is_there = found.as_ref().is_ok_and(|output| output.status.success());
    if !is_there {
        let required = std::env::var_os("TRIBOCHAOS_REQUIRE_PYTHON").is_some();
        assert!(!required, "python3 with xarray and zarr is required: {found:?}");
        eprintln!("skipped: python3 with xarray and zarr is not there");
    }
    is_there
}

fn check(script: &str, store: &Path) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(script);
    let output = Command::new("python3").arg(script).arg(store).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn xarray_opens_the_store_of_a_machine() {
    if !has_xarray() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("machine.zarr");
    let experiment = Request {
        axes: Some(vec![
            Axis::parse("interference=1e-9:3e-9:3").unwrap(),
            Axis::parse("damping=0:778:2").unwrap(),
        ]),
        machine: Some(Description::from_toml(TEMPLATE).unwrap()),
        ..Request::default()
    };
    let experiment = experiment.resolve().unwrap();
    let store = Store::create(&path, &experiment, &Quantity::of_map(&experiment), 6).unwrap();
    write(store, |_| true);
    check("xarray_opens_machine.py", &path);
}

#[test]
fn xarray_opens_the_store() {
    if !has_xarray() {
        return;
    }

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sample.zarr");
    // an axis and quantities whose names are alike: x0, x, x_min
    let y = Axis::parse("x0=1:-1:5").unwrap();
    let experiment = Request {
        axes: Some(vec![Axis::parse("zeta_k=0:12:7").unwrap(), y]),
        ..Request::default()
    }
    .resolve()
    .unwrap();
    let store = Store::create(&path, &experiment, &Quantity::all(), 14).unwrap();
    write(store, |unit| unit > 0);
    check("xarray_opens.py", &path);
}

#[test]
fn xarray_opens_the_store_of_a_list_of_points() {
    if !has_xarray() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points.zarr");
    let rows: Vec<[f64; 2]> = (0..34).map(|row| [f64::from(row) / 10.0, 0.5]).collect();
    let coordinates = ["zeta_k", "h1"].map(|name| Coordinate::from_name(name).unwrap());
    let points = Points::new(coordinates.to_vec(), &rows).unwrap();
    let experiment = Request::default().resolve_over(Varied::Points(points)).unwrap();
    let store = Store::create(&path, &experiment, &[Quantity::Lyapunov], 10).unwrap();
    write(store, |_| true);
    check("xarray_opens_points.py", &path);
}

#[test]
fn xarray_selects_by_decimals() {
    if !has_xarray() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("decimals.zarr");
    let experiment = Request {
        axes: Some(vec![
            Axis::parse("zeta_k=3:5:201").unwrap(),
            Axis::parse("h1=0:1.5:301").unwrap(),
        ]),
        ..Request::default()
    };
    let experiment = experiment.resolve().unwrap();
    Store::create(&path, &experiment, &[Quantity::Lyapunov], 301 * 201).unwrap();
    check("xarray_selects.py", &path);
}

/// Writes units of a store.
fn write(store: Store, is_written: impl Fn(usize) -> bool) {
    let mut store = store.writing(None).unwrap();
    let origin = Origin {
        device: "a processor".to_owned(),
        elapsed: Duration::from_secs(1),
    };
    for unit in (0..store.units()).filter(|&unit| is_written(unit)) {
        let measurements: Vec<Measurement> = store.points(unit).map(measurement).collect();
        store.write(unit, &measurements, &origin).unwrap();
    }
}

/// Known to `xarray_opens.py`: the exponent tells the point's index; the last point ran away.
fn measurement(index: usize) -> Measurement {
    if index == 34 {
        return Measurement::runaway(100.0, BackendKind::GpuF32);
    }
    Measurement {
        status: Status::Ok,
        class: Some(Class::Regular),
        lyapunov: -(index as f64) / 8.0,
        period: index.is_multiple_of(2).then_some(4),
        x: 0.25,
        ..Measurement::runaway(0.0, BackendKind::CpuF64)
    }
}
