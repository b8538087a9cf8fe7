//! The values of a store: written tile by tile, and read back as a map.
//!
//! Owns which tiles count as finished, and what a finished one must hold; neither creates a store nor opens one.

use std::fmt::Display;

use super::error::StoreError;
use super::layout::{NO_CODE, axes};
use super::map_store::MapStore;
use super::tile::{self, Tile};
use crate::design::Axis;
use crate::engine::{Sink, SinkError};
use crate::map::ParameterMap;
use crate::measure::{Measurement, QUANTITIES, Quantity, QuantityInfo, Values};

/// Quantities that have a value at every point whose status is ok.
const NEVER_NAN: [Quantity; 8] = [
    Quantity::Lyapunov,
    Quantity::LyapunovInterval,
    Quantity::X,
    Quantity::Y,
    Quantity::XMin,
    Quantity::XMax,
    Quantity::ContactStatus,
    Quantity::Backend,
];

/// Quantities that have one besides if the contact pressure is constant.
const NEVER_NAN_REDUCED: [Quantity; 2] = [Quantity::LyapunovSecond, Quantity::Divergence];

/// Quantities that have one besides if nothing wears.
const NEVER_NAN_LASTING: [Quantity; 3] = [Quantity::LyapunovError, Quantity::LyapunovBirkhoff, Quantity::Class];

impl MapStore {
    /// All tiles, row by row; those at the far edges are cut to the map.
    pub fn tiles(&self) -> impl Iterator<Item = Tile> + '_ {
        (0..self.units()).map(|unit| self.unit(unit))
    }

    fn unit(&self, unit: usize) -> Tile {
        tile::tile(axes(&self.experiment).map(Axis::count), self.tile, unit)
    }

    /// Writes the measurements of a tile, x fastest. A tile counts as finished only once all of it is on disk.
    ///
    /// # Errors
    /// [`StoreError::Write`].
    ///
    /// # Panics
    /// If the number of measurements is not that of the tile's points.
    pub fn write_tile(&self, tile: &Tile, measurements: &[Measurement]) -> Result<(), StoreError> {
        assert_eq!(
            measurements.len(),
            tile.len(),
            "one measurement for each point of the tile"
        );
        let failed = |error: zarrs::array::ArrayError| StoreError::Write {
            path: self.path.clone(),
            reason: error.to_string(),
        };
        let [x, _] = axes(&self.experiment);
        let padded = |scale: &dyn Fn(usize) -> f64| self.padded(tile, tile.indices(x.count()).map(scale), f64::NAN);
        let chunk = self.chunk(tile);
        self.scales.write(&self.experiment, &chunk, padded).map_err(failed)?;
        // The status goes last, since it is what tells a finished tile.
        let others = QUANTITIES.iter().filter(|info| info.quantity != Quantity::Status);
        for info in others.chain([Quantity::Status.info()]) {
            let values = measurements.iter().map(|measurement| info.quantity.of(measurement));
            let array = &self.arrays[info.quantity as usize];
            let stored = match info.values {
                Values::Number => array.store_chunk(&self.chunk(tile), self.padded(tile, values, f64::NAN)),
                Values::Code(_) => {
                    let codes = values.map(|code| if code.is_nan() { NO_CODE } else { code as u8 });
                    array.store_chunk(&self.chunk(tile), self.padded(tile, codes, NO_CODE))
                }
            };
            stored.map_err(failed)?;
        }
        Ok(())
    }

    /// Whether every point of a tile is on disk.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] if the file system does not let the tile be read.
    pub fn is_finished(&self, tile: &Tile) -> Result<bool, StoreError> {
        match self.arrays[Quantity::Status as usize].retrieve_chunk::<Vec<u8>>(&self.chunk(tile)) {
            Ok(chunk) => Ok(self.unpadded(tile, &chunk).all(|code| code != NO_CODE)),
            Err(zarrs::array::ArrayError::StorageError(error)) => Err(self.damaged(Quantity::Status, tile, &error)),
            // A write that was cut short leaves a chunk that cannot be decoded: the tile is to be computed again.
            Err(_) => Ok(false),
        }
    }

    /// The map, with NaN at the points of tiles that are not finished.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] if values of a finished tile cannot be read.
    #[expect(clippy::missing_panics_doc, reason = "a store has two axes")]
    pub fn read_map(&self) -> Result<ParameterMap, StoreError> {
        let mut map = ParameterMap::new(self.experiment.clone()).expect("a store has two axes");
        let columns = map.x_axis().count();
        for tile in self.tiles() {
            // what is there but cannot be decoded is damage here, though a resumed run may compute it again
            self.read_tile(Quantity::Status.info(), &tile)?;
            if !self.is_finished(&tile)? {
                continue;
            }
            for info in QUANTITIES {
                let values = self.read_tile(info, &tile)?;
                let column = map.column_mut(info.quantity);
                for (index, value) in tile.indices(columns).zip(values) {
                    column[index] = value;
                }
            }
            // every point whose status is ok has numbers: a chunk that is missing reads as NaN
            // but for the second exponent of a limit cycle, whose one exponent is the divergence
            let lost = |quantity: Quantity| {
                let [status, lyapunov, divergence, values] =
                    [Quantity::Status, Quantity::Lyapunov, Quantity::Divergence, quantity].map(|of| map.column(of));
                let has_it = |index| quantity != Quantity::LyapunovSecond || lyapunov[index] != divergence[index];
                tile.indices(columns)
                    .any(|index| status[index] == 0.0 && values[index].is_nan() && has_it(index))
            };
            let reduced = !self.experiment.settings.integration.scheme.carries_heat();
            let mut numbers = NEVER_NAN
                .into_iter()
                .chain(NEVER_NAN_REDUCED.into_iter().filter(|_| reduced))
                .chain(NEVER_NAN_LASTING.into_iter().filter(|_| !self.experiment.wears()));
            if let Some(quantity) = numbers.find(|quantity| lost(*quantity)) {
                return Err(self.damaged(quantity, &tile, &"values of finished points are missing"));
            }
        }
        Ok(map)
    }

    fn read_tile(&self, info: &QuantityInfo, tile: &Tile) -> Result<Vec<f64>, StoreError> {
        let (array, chunk) = (&self.arrays[info.quantity as usize], self.chunk(tile));
        match info.values {
            Values::Number => {
                let values: Vec<f64> = array
                    .retrieve_chunk(&chunk)
                    .map_err(|error| self.damaged(info.quantity, tile, &error))?;
                Ok(self.unpadded(tile, &values).collect())
            }
            Values::Code(names) => {
                let codes: Vec<u8> = array
                    .retrieve_chunk(&chunk)
                    .map_err(|error| self.damaged(info.quantity, tile, &error))?;
                self.unpadded(tile, &codes)
                    .map(|code| match code {
                        NO_CODE => Ok(f64::NAN),
                        code if usize::from(code) < names.len() => Ok(code.into()),
                        code => Err(self.damaged(info.quantity, tile, &format!("{code} is no code"))),
                    })
                    .collect()
            }
        }
    }

    fn chunk(&self, tile: &Tile) -> [u64; 2] {
        [(tile.row0 / self.tile[0]) as u64, (tile.col0 / self.tile[1]) as u64]
    }

    /// A tile's values as a whole chunk: Zarr stores the chunks at the far edges in full.
    fn padded<T: Copy>(&self, tile: &Tile, values: impl Iterator<Item = T>, fill: T) -> Vec<T> {
        let mut chunk = vec![fill; self.tile[0] * self.tile[1]];
        for (index, value) in self.chunk_indices(tile).zip(values) {
            chunk[index] = value;
        }
        chunk
    }

    fn unpadded<'a, T: Copy>(&self, tile: &Tile, chunk: &'a [T]) -> impl Iterator<Item = T> + 'a {
        self.chunk_indices(tile).map(|index| chunk[index])
    }

    fn chunk_indices(&self, tile: &Tile) -> impl Iterator<Item = usize> + use<> {
        Tile {
            row0: 0,
            col0: 0,
            ..*tile
        }
        .indices(self.tile[1])
    }

    fn damaged(&self, quantity: Quantity, tile: &Tile, reason: &dyn Display) -> StoreError {
        let (name, [row, col]) = (quantity.info().name, self.chunk(tile));
        let what = format!("the array `{name}`, chunk c/{row}/{col}: {reason}");
        StoreError::Damaged {
            path: self.path.clone(),
            what,
        }
    }
}

impl Sink for MapStore {
    fn units(&self) -> usize {
        tile::count(axes(&self.experiment).map(Axis::count), self.tile)
    }

    fn points(&self, unit: usize) -> Vec<usize> {
        let [x, _] = axes(&self.experiment);
        self.unit(unit).indices(x.count()).collect()
    }

    fn is_finished(&self, unit: usize) -> Result<bool, SinkError> {
        Ok(Self::is_finished(self, &self.unit(unit))?)
    }

    fn write(&mut self, unit: usize, measurements: &[Measurement], device: &str) -> Result<(), SinkError> {
        self.write_tile(&self.unit(unit), measurements)?;
        let mut devices = self.devices();
        if !devices.iter().any(|known| known == device) {
            devices.push(device.to_owned());
            self.set_attribute("devices", devices.into())?;
        }
        Ok(())
    }
}
