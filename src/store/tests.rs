use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::json;
use zarrs::array::Array;
use zarrs::filesystem::FilesystemStore;

use super::layout::node;
use super::*;
use crate::backend::BackendKind;
use crate::machine::Scale;
use crate::measure::{Measurement, QUANTITIES, Quantity, Values};
use crate::output::PROGRAM;
use crate::output::samples::{experiment, machine_experiment, measurement};
use crate::parameters::PARAMETERS;

/// A store of 7 x 5 points in tiles of 2 rows and 3 columns, of which the tiles that `write` names are written.
fn sample(write: impl Fn(usize) -> bool) -> (tempfile::TempDir, MapStore) {
    let folder = tempfile::tempdir().unwrap();
    let experiment = experiment("zeta_k=0:12:7", "h1=2:0:5");
    let store = MapStore::create(&folder.path().join("deep/sample.zarr"), &experiment, [2, 3]).unwrap();
    for (number, tile) in store.tiles().enumerate().filter(|(number, _)| write(*number)) {
        store.write_tile(&tile, &measurements(&tile, number)).unwrap();
    }
    (folder, store)
}

fn measurements(tile: &Tile, number: usize) -> Vec<Measurement> {
    let mut measurements: Vec<Measurement> = tile.indices(7).map(|index| measurement(index as f64 + 0.5)).collect();
    if number == 2 {
        measurements[0] = Measurement::runaway(100.0, BackendKind::GpuF32);
    }
    measurements
}

fn reason(path: &Path) -> String {
    MapStore::open(path).map(|_| ()).unwrap_err().to_string()
}

#[test]
fn tiles_cover_the_map_and_are_cut_at_its_edges() {
    let (_folder, store) = sample(|_| false);
    let tiles: Vec<Tile> = store.tiles().collect();
    assert_eq!(tiles.len(), 9);
    assert_eq!(
        tiles[1],
        Tile {
            row0: 0,
            rows: 2,
            col0: 3,
            cols: 3
        }
    );
    assert_eq!(
        tiles[8],
        Tile {
            row0: 4,
            rows: 1,
            col0: 6,
            cols: 1
        }
    );
    let mut indices: Vec<usize> = tiles.iter().flat_map(|tile| tile.indices(7)).collect();
    indices.sort_unstable();
    assert_eq!(indices, (0..35).collect::<Vec<_>>());
}

#[test]
fn scales_of_a_machine_are_stored_point_by_point() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("machine.zarr");
    let experiment = machine_experiment("interference=1e-9:7e-9:7", "inertia=1e-3:5e-3:5");
    let store = MapStore::create(&path, &experiment, [2, 3]).unwrap();
    for tile in store.tiles() {
        store.write_tile(&tile, &measurements(&tile, 0)).unwrap();
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
    assert_eq!(MapStore::open(&path).unwrap().experiment(), &experiment);
    fs::remove_dir_all(path.join("time_scale")).unwrap();
    assert!(reason(&path).contains("time_scale"));
}

#[test]
fn what_is_written_is_read_back_and_the_rest_is_not_computed() {
    let (_folder, store) = sample(|number| number != 4);
    let store = MapStore::open(store.path()).unwrap();
    assert_eq!(store.tile(), [2, 3]);
    let tiles: Vec<Tile> = store.tiles().collect();
    for (number, tile) in tiles.iter().enumerate() {
        assert_eq!(store.is_finished(tile).unwrap(), number != 4);
    }
    let map = store.read_map().unwrap();
    assert_eq!(&map.experiment, store.experiment());
    assert_eq!(map.column(Quantity::Lyapunov)[34], 34.5);
    for index in tiles[4].indices(7) {
        assert!(!map.is_computed(index) && map.column(Quantity::Lyapunov)[index].is_nan());
    }
    // tile 2 begins at column 6 of row 0
    assert!(map.is_runaway(6) && map.class(6).is_none());
    assert_eq!(map.column(Quantity::RunawayTime)[6], 100.0);
    assert_eq!(map.column(Quantity::Backend)[6], 2.0);
    assert!(map.column(Quantity::Class)[6].is_nan());
}

#[test]
fn a_tile_whose_writing_was_cut_short_is_not_finished() {
    let (_folder, store) = sample(|_| true);
    let tiles: Vec<Tile> = store.tiles().collect();
    fs::remove_file(store.path().join("status/c/2/2")).unwrap();
    assert!(!store.is_finished(&tiles[8]).unwrap());
    assert!(!store.read_map().unwrap().is_computed(34));
    // a resumed run computes it again; to a reader it is damage
    fs::write(store.path().join("status/c/0/1"), [0, 0]).unwrap();
    assert!(!store.is_finished(&tiles[1]).unwrap());
    assert!(
        store
            .read_map()
            .unwrap_err()
            .to_string()
            .contains("`status`, chunk c/0/1")
    );
}

#[test]
fn damaged_values_of_a_finished_tile_are_reported() {
    let (_folder, store) = sample(|_| true);
    fs::write(store.path().join("class/c/0/0"), [9; 6]).unwrap();
    let message = store.read_map().unwrap_err().to_string();
    assert!(message.contains("`class`, chunk c/0/0: 9 is no code"), "{message}");
    fs::write(store.path().join("lyapunov/c/0/0"), [0; 5]).unwrap();
    let message = store.read_map().unwrap_err().to_string();
    assert!(message.contains("`lyapunov`, chunk c/0/0"), "{message}");
    let (_folder, store) = sample(|_| true);
    fs::remove_file(store.path().join("divergence/c/0/0")).unwrap();
    let message = store.read_map().unwrap_err().to_string();
    assert!(
        message.contains("`divergence`, chunk c/0/0: values of finished points are missing"),
        "{message}"
    );
}

#[test]
fn codes_with_a_name_are_read_and_no_others() {
    for info in QUANTITIES {
        let Values::Code(names) = info.values else { continue };
        let (_folder, store) = sample(|_| true);
        let chunk = store.path().join(info.name).join("c/0/0");
        let first_without = names.len() as u8;
        fs::write(&chunk, [first_without - 1; 6]).unwrap();
        assert!(store.read_map().is_ok(), "{}", info.name);
        fs::write(&chunk, [first_without; 6]).unwrap();
        let message = store.read_map().unwrap_err().to_string();
        let expected = format!("`{}`, chunk c/0/0: {first_without} is no code", info.name);
        assert!(message.contains(&expected), "{message}");
    }
}

#[test]
fn attributes_outlive_the_store_that_set_them() {
    let (_folder, mut store) = sample(|_| false);
    store.set_attribute("audit", json!({"points": 32})).unwrap();
    let store = MapStore::open(store.path()).unwrap();
    assert_eq!(store.attribute("audit"), Some(&json!({"points": 32})));
    assert_eq!(store.attribute("devices"), None);
    assert_eq!(store.attribute("program"), Some(&json!(PROGRAM)));
}

#[test]
fn stores_that_are_no_stores_are_refused_with_a_reason() {
    let (folder, store) = sample(|_| false);
    let path = store.path().to_owned();
    assert!(matches!(
        MapStore::create(&path, store.experiment(), [2, 3]),
        Err(StoreError::Exists { .. })
    ));
    assert!(reason(&folder.path().join("none.zarr")).contains("there is no store"));
    assert!(reason(folder.path()).contains("is not a map"));

    let root = fs::read_to_string(path.join("zarr.json")).unwrap();
    for (from, to, expected) in [
        ("tribochaos map", "another map", "is not a map"),
        ("\"format_version\": 1", "\"format_version\": 2", "format version 2"),
        (
            "\"format_version\": 1",
            "\"format_version\": \"x\"",
            "format version \"x\"",
        ),
        ("start = 0.0", "start = 12.0", "two different ends"),
        ("\"experiment\"", "\"experimnet\"", "`experiment` is missing"),
        ("{", "garbage", "damaged"),
        ("\"group\"", "\"array\"", "damaged"),
        ("stop = 12.0", "stop = 13.0", "`zeta_k` does not hold"),
        ("count = 5", "count = 6", "`h1` does not hold"),
    ] {
        assert!(root.contains(from), "{from}: {root}");
        fs::write(path.join("zarr.json"), root.replacen(from, to, 1)).unwrap();
        let message = reason(&path);
        assert!(message.contains(expected), "{to}: {message}");
    }
    fs::write(path.join("zarr.json"), &root).unwrap();
    assert!(MapStore::open(&path).is_ok());

    let array = fs::read_to_string(path.join("period/zarr.json")).unwrap();
    for (text, expected) in [
        ("{".to_owned(), "the array `period`"),
        (array.replace("float64", "float32"), "shape, tiles or type"),
        (array.replace("float64", "float65"), "the array `period`"),
        (array.replace("regular", "irregular"), "the array `period`"),
    ] {
        fs::write(path.join("period/zarr.json"), text).unwrap();
        assert!(reason(&path).contains(expected), "{}", reason(&path));
    }
    fs::remove_dir_all(path.join("period")).unwrap();
    assert!(reason(&path).contains("the array `period`"), "{}", reason(&path));
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let path = folder.path().join("file/sample.zarr");
    let error = MapStore::create(&path, &experiment("zeta_k=0:1:2", "h1=0:1:2"), [1, 1])
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
    let foretold = size_bytes(store.experiment(), store.tile());
    let chunks = |name: &str| {
        let files = walk(&store.path().join(name).join("c"));
        files.iter().map(|file| fs::metadata(file).unwrap().len()).sum::<u64>()
    };
    assert_eq!(chunks("lyapunov") + chunks("status"), 6 * 9 * (8 + 1));
    assert_eq!(foretold, 6 * 9 * (22 * 8 + 4) + 12 * 8);
    assert!(free_space(&folder.path().join("not/there/yet.zarr")).unwrap() > 0);
    assert!(free_space(Path::new("not-there-yet.zarr")).unwrap() > 0);
}

fn walk(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| if path.is_dir() { walk(&path) } else { vec![path] })
        .collect()
}

/// An array named like a dimension would pass for its coordinate.
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
