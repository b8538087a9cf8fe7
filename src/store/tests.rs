use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use serde_json::json;
use zarrs::array::Array;
use zarrs::filesystem::FilesystemStore;

use super::layout::node;
use super::*;
use crate::backend::BackendKind;
use crate::design::{Axis, Coordinate, Points, Varied};
use crate::engine::{Condition, Origin, Sink};
use crate::experiment::{Experiment, Request};
use crate::machine::Scale;
use crate::measure::{Measurement, QUANTITIES, Quantity};
use crate::output::PROGRAM;
use crate::output::samples::{experiment, machine_experiment, measurement};
use crate::parameters::PARAMETERS;

/// Quantities of the sample.
const HELD: [Quantity; 4] = [
    Quantity::Lyapunov,
    Quantity::Period,
    Quantity::RunawayTime,
    Quantity::Class,
];

fn origin() -> Origin {
    Origin {
        device: "a processor".to_owned(),
        elapsed: Duration::from_millis(1500),
    }
}

fn create(path: &Path, experiment: &Experiment, unit: usize) -> Store {
    Store::create(path, experiment, &HELD, unit)
        .unwrap()
        .writing(Some(Lock::of_store(path, Use::Together).unwrap()))
        .unwrap()
}

fn sample_experiment() -> Experiment {
    experiment("zeta_k=0:12:7", "h1=2:0:5")
}

/// A store of 7 x 5 points in units of two rows. Only the units for which `write` is true are written.
fn sample(write: impl Fn(usize) -> bool) -> (tempfile::TempDir, Store) {
    let folder = tempfile::tempdir().unwrap();
    let mut store = create(&folder.path().join("deep/sample.zarr"), &sample_experiment(), 15);
    for unit in (0..store.units()).filter(|&unit| write(unit)) {
        let measurements = measurements(&store, unit);
        store.write(unit, &measurements, &origin()).unwrap();
    }
    (folder, store)
}

fn measurements(store: &Store, unit: usize) -> Vec<Measurement> {
    let mut measurements: Vec<Measurement> = store
        .points(unit)
        .map(|index| measurement(index as f64 + 0.5))
        .collect();
    if unit == 2 {
        measurements[0] = Measurement::runaway(100.0, BackendKind::GpuF32);
    }
    measurements
}

fn reason(path: &Path) -> String {
    Store::open(path).map(|_| ()).unwrap_err().to_string()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = entries
        .flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] })
        .collect();
    files.sort();
    files
}

#[test]
fn what_is_written_is_read_back_and_the_rest_is_not_computed() {
    let (_folder, store) = sample(|unit| unit != 1);
    let store = Store::open(store.path()).unwrap();
    assert_eq!(store.experiment(), &sample_experiment());
    assert_eq!(store.quantities().len(), HELD.len() + 1, "and the status");
    for unit in 0..3 {
        assert_eq!(Sink::is_finished(&store, unit).unwrap(), unit != 1);
    }
    let results = store.read().unwrap();
    assert_eq!(results.value(Quantity::Lyapunov, 34), 34.5);
    assert!(results.column(Quantity::X).is_none());
    for index in 14..28 {
        assert!(!results.is_computed(index) && results.value(Quantity::Lyapunov, index).is_nan());
    }
    assert!(results.is_runaway(28) && results.class(28).is_none());
    assert_eq!(results.value(Quantity::RunawayTime, 28), 100.0);
    let mark = store.mark(2).unwrap().unwrap();
    assert_eq!(
        (mark.seconds, mark.tally.kinds()),
        (1.5, vec![("chaotic", 6), ("runaway", 1)])
    );
    assert_eq!(store.devices().unwrap(), ["a processor"]);
}

#[test]
fn designs_of_any_number_of_axes_and_lists_of_points_are_stored() {
    let folder = tempfile::tempdir().unwrap();
    let axes = ["zeta_k=3:5:4", "h1=0:1:3", "gamma=log:0.01:1:5", "k_w=0,0.01"];
    let axes = axes.map(|axis| Axis::parse(axis).unwrap());
    let rows: Vec<Vec<f64>> = (0..11).map(|row| vec![f64::from(row), 0.1 * f64::from(row)]).collect();
    let coordinates = ["zeta_k", "h1"].map(|name| Coordinate::from_name(name).unwrap());
    let points = Points::new(coordinates.to_vec(), &rows).unwrap();
    for (name, varied) in [
        ("four.zarr", Varied::Axes(axes.to_vec())),
        ("points.zarr", Varied::Points(points)),
    ] {
        let experiment = Request::default().resolve_over(varied).unwrap();
        let mut store = create(&folder.path().join(name), &experiment, 7);
        for unit in 0..store.units() {
            let measurements: Vec<_> = store.points(unit).map(|index| measurement(index as f64)).collect();
            store.write(unit, &measurements, &origin()).unwrap();
        }
        let results = Store::open(store.path()).unwrap().read().unwrap();
        assert_eq!(results.experiment, experiment);
        let expected = (0..experiment.design.len()).map(|index| index as f64);
        assert!(results.values(Quantity::Lyapunov).eq(expected), "{name}");
    }
}

#[test]
fn scales_of_a_machine_are_stored_point_by_point() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("machine.zarr");
    let experiment = machine_experiment("interference=1e-9:7e-9:7", "inertia=1e-3:5e-3:5");
    let mut store = create(&path, &experiment, 15);
    for unit in 0..store.units() {
        let measurements = measurements(&store, unit);
        store.write(unit, &measurements, &origin()).unwrap();
    }
    let storage = Arc::new(FilesystemStore::new(&path).unwrap());
    for scale in Scale::ALL {
        let array = Array::open(storage.clone(), &node(scale.name())).unwrap();
        assert_eq!(array.attributes()["units"], scale.unit());
        let values: Vec<f64> = array.retrieve_array_subset(&array.subset_all()).unwrap();
        for (index, value) in values.iter().enumerate() {
            let machine = experiment.design.machine(index).unwrap();
            assert_eq!(*value, machine.scales().of(scale), "{scale:?} {index}");
        }
    }
    let units = |name: &str| Array::open(storage.clone(), &node(name)).unwrap().attributes()["units"].clone();
    assert_eq!((units("interference"), units("inertia")), (json!("m"), json!("kg m")));
}

/// Every file, at its first and last byte and in between; also cut short, and removed.
#[test]
fn any_change_of_any_file_is_noticed_and_named() {
    let (_folder, store) = sample(|_| true);
    let path = store.path().to_owned();
    let whole = |path: &Path| -> Result<(), String> {
        let store = Store::open(path).map_err(|error| error.to_string())?;
        for unit in 0..store.units() {
            match store.check_unit(unit) {
                Ok(Condition::Whole(_)) => {}
                other => return Err(format!("{other:?}")),
            }
        }
        store.read().map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(whole(&path), Ok(()));
    for file in files(&path) {
        let bytes = fs::read(&file).unwrap();
        let places = [0, bytes.len() / 3, bytes.len() / 2, bytes.len() - 1];
        for (place, bit) in places.into_iter().zip([0, 3, 6, 1]) {
            let mut changed = bytes.clone();
            changed[place] ^= 1 << bit;
            fs::write(&file, &changed).unwrap();
            assert!(whole(&path).is_err(), "bit {bit} of byte {place} of {}", file.display());
        }
        fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
        assert!(whole(&path).is_err(), "{} cut", file.display());
        fs::remove_file(&file).unwrap();
        assert!(whole(&path).is_err(), "{} removed", file.display());
        fs::write(&file, &bytes).unwrap();
    }
    assert_eq!(whole(&path), Ok(()));
    // a chunk that is sound, but another unit's
    fs::copy(path.join("lyapunov/c/0/0"), path.join("lyapunov/c/1/0")).unwrap();
    let store = Store::open(&path).unwrap();
    let Condition::Damaged { what } = store.check_unit(1).unwrap() else {
        panic!("it is damaged")
    };
    assert!(what.contains("`lyapunov`, chunk c/1/0"), "{what}");
}

/// Values first, then the mark: what a crash leaves between them is not finished.
#[test]
fn a_unit_without_its_mark_is_missing_and_written_again() {
    let (_folder, mut store) = sample(|_| true);
    let before: Vec<_> = files(store.path())
        .into_iter()
        .map(|file| (fs::read(&file).unwrap(), file))
        .collect();
    fs::remove_file(store.path().join("status/done/1")).unwrap();
    fs::write(store.path().join("period/c/1/0"), [1, 2, 3]).unwrap();
    assert_eq!(store.check_unit(1).unwrap(), Condition::Missing);
    assert!(!store.read().unwrap().is_computed(20));
    let measurements = measurements(&store, 1);
    store.write(1, &measurements, &origin()).unwrap();
    for (bytes, file) in before {
        assert_eq!(fs::read(&file).unwrap(), bytes, "{}", file.display());
    }
}

#[test]
fn damaged_metadata_is_written_anew_for_the_same_experiment_only() {
    for file in ["zarr.json", "period/zarr.json", "zeta_k/c/0"] {
        let (_folder, store) = sample(|unit| unit != 0);
        let path = store.path().to_owned();
        drop(store);
        fs::write(path.join(file), "{").unwrap();
        assert!(reason(&path).contains("is damaged"), "{file}");
        let other = experiment("zeta_k=0:12:7", "h1=2:0:6");
        for (experiment, quantities) in [(&other, &HELD[..]), (&sample_experiment(), &HELD[1..])] {
            let lost = Store::mend(&path, experiment, quantities).map(|_| ()).unwrap_err();
            assert!(matches!(lost, StoreError::Lost { .. }), "{lost}");
        }
        let store = Store::mend(&path, &sample_experiment(), &HELD).unwrap();
        let whole: Vec<bool> = (0..3).map(|unit| Sink::is_finished(&store, unit).unwrap()).collect();
        assert_eq!(whole, [false, true, true], "{file}");
        assert_eq!(store.read().unwrap().value(Quantity::Lyapunov, 34), 34.5);
        assert_eq!(
            fs::read_dir(path.parent().unwrap()).unwrap().count(),
            1,
            "nothing is left beside it"
        );
    }
}

#[test]
fn units_of_another_experiment_are_not_taken_for_its_own() {
    let (folder, store) = sample(|_| true);
    let other = create(
        &folder.path().join("other.zarr"),
        &experiment("zeta_k=0:11:7", "h1=2:0:5"),
        15,
    );
    for part in [
        "lyapunov/c/0",
        "period/c/0",
        "runaway_time/c/0",
        "class/c/0",
        "status/c/0",
    ] {
        fs::create_dir_all(other.path().join(part)).unwrap();
        fs::copy(store.path().join(part).join("0"), other.path().join(part).join("0")).unwrap();
    }
    fs::copy(store.path().join("status/done/0"), other.path().join("status/done/0")).unwrap();
    let Condition::Damaged { what } = other.check_unit(0).unwrap() else {
        panic!("it belongs to another experiment")
    };
    assert!(what.contains("another experiment"), "{what}");
}

#[test]
fn a_unit_is_claimed_by_one_at_a_time() {
    let (_folder, store) = sample(|_| false);
    let again = Store::open(store.path())
        .unwrap()
        .writing(Some(Lock::of_store(store.path(), Use::Together).unwrap()));
    let again = again.unwrap();
    let claim = store.claim(1).unwrap().unwrap();
    assert!(again.claim(1).unwrap().is_none());
    assert!(again.claim(2).unwrap().is_some());
    drop(claim);
    assert!(again.claim(1).unwrap().is_some());
    assert_eq!(fs::read_dir(store.path().join("status/done")).unwrap().count(), 0);
}

#[test]
fn a_store_that_is_taken_away_is_not_made_anew() {
    let (folder, mut store) = sample(|unit| unit == 0);
    let measurements = measurements(&store, 1);
    let path = store.path().to_owned();
    fs::remove_dir_all(&path).unwrap();
    let error = store.write(1, &measurements, &origin()).unwrap_err().to_string();
    assert!(error.contains("was removed or replaced"), "{error}");
    assert!(!path.exists() && !Sink::is_finished(&store, 0).unwrap());
    // nor is another one that has taken its place written
    let other = create(&path, &sample_experiment(), 15);
    assert!(store.write(1, &measurements, &origin()).is_err());
    assert!(store.claim(1).is_err());
    assert_eq!(other.check_unit(1).unwrap(), Condition::Missing);
    drop(folder);
}

#[test]
fn attributes_outlive_the_store_that_set_them() {
    let (_folder, mut store) = sample(|_| false);
    store.set_attribute("audit", json!({"points": 32})).unwrap();
    let store = Store::open(store.path()).unwrap();
    assert_eq!(store.attribute("audit"), Some(&json!({"points": 32})));
    assert_eq!(store.attribute("devices"), None);
    assert_eq!(store.attribute("program"), Some(&json!(PROGRAM)));
}

#[test]
fn stores_that_are_no_stores_are_refused_with_a_reason() {
    let (folder, store) = sample(|_| false);
    let path = store.path().to_owned();
    assert!(matches!(
        Store::create(&path, store.experiment(), &HELD, 15),
        Err(StoreError::Exists { .. })
    ));
    assert!(reason(&folder.path().join("none.zarr")).contains("there is no store"));
    assert!(reason(folder.path()).contains("is not a store"));
    let root = fs::read_to_string(path.join("zarr.json")).unwrap();
    for (from, to, expected) in [
        ("tribochaos results", "other results", "is damaged"),
        ("\"format_version\": 2", "\"format_version\": 3", "format version 3"),
        (
            "\"format_version\": 2",
            "\"format_version\": \"x\"",
            "format version \"x\"",
        ),
        ("stop = 12.0", "stop = 13.0", "is damaged"),
        ("\"experiment\"", "\"experimnet\"", "is damaged"),
        ("{", "garbage", "is damaged"),
    ] {
        assert!(root.contains(from), "{from}: {root}");
        fs::write(path.join("zarr.json"), root.replacen(from, to, 1)).unwrap();
        let message = reason(&path);
        assert!(message.contains(expected), "{to}: {message}");
    }
}

/// A store that version 0.1 of the program wrote.
#[test]
fn stores_of_the_first_version_are_read_and_not_gone_on_with() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/stores/version_1.zarr");
    let store = Store::open(&path).unwrap();
    assert_eq!(store.quantities().len(), QUANTITIES.len());
    let results = store.read().unwrap();
    assert!((0..12).all(|index| results.is_ok(index)));
    let exponents: Vec<f64> = results.values(Quantity::Lyapunov).collect();
    let expected = fs::read_to_string(path.with_extension("txt")).unwrap();
    let expected: Vec<f64> = expected.lines().map(|line| line.parse().unwrap()).collect();
    assert_eq!(exponents, expected);
    let refused = store.writing(None).map(|_| ()).unwrap_err();
    assert!(matches!(refused, StoreError::Older { .. }));
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let path = folder.path().join("file/sample.zarr");
    let error = Store::create(&path, &sample_experiment(), &HELD, 1)
        .map(|_| ())
        .unwrap_err();
    assert!(
        matches!(error, StoreError::Write { .. }) && error.to_string().contains("sample.zarr"),
        "{error}"
    );
}

#[test]
fn the_size_is_foretold_and_the_free_space_of_a_place_to_be_is_known() {
    let (folder, store) = sample(|_| true);
    let foretold = size_bytes(store.experiment(), &HELD, 15);
    let sizes = |part: &str| -> u64 {
        let in_part = files(store.path())
            .into_iter()
            .filter(|file| file.to_string_lossy().contains(part));
        in_part.map(|file| fs::metadata(file).unwrap().len()).sum()
    };
    // 14 points in each of three units, with a checksum on each chunk; the marks are smaller than foretold
    let (values, checksums) = (14 * 3 * (8 + 4 + 4 + 1 + 1), 4 * 3 * 5);
    assert_eq!(sizes("/c/") - sizes("zeta_k/c") - sizes("h1/c"), values + checksums);
    assert!(sizes("/done/") < 3 * 1024);
    assert_eq!(foretold, values + 3 * 1024 + 8 * (7 + 5));
    assert!(free_space(&folder.path().join("not/there/yet.zarr")).unwrap() > 0);
    assert!(free_space(Path::new("not-there-yet.zarr")).unwrap() > 0);
}

/// Of the default map there are 156 bytes a point in stores of the first version.
#[test]
fn the_default_map_takes_less_than_half_of_what_it_took() {
    let experiment = Request::default().resolve().unwrap();
    assert_eq!(point_bytes(&experiment, &Quantity::of_map(&experiment)), 63);
    assert_eq!(point_bytes(&experiment, &Quantity::of_scan(&experiment)), 19);
}

/// Readers would take an array with the name of a dimension for the coordinate of that dimension.
#[test]
fn no_quantity_is_named_like_a_parameter() {
    for info in QUANTITIES {
        assert!(
            PARAMETERS.iter().all(|parameter| parameter.name != info.name),
            "{}",
            info.name
        );
    }
}
