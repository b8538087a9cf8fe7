//! The values of a store: written unit by unit, checked, and read back.
//!
//! Owns what makes a unit finished: all of its values are on the disk, then its mark. Neither creates a store nor opens one.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::ops::Range;

use super::checksum::checksum;
use super::chunk;
use super::error::StoreError;
use super::lock::Lock;
use super::mark::{Found, Mark};
use super::store::{Content, Store, StoredArray};
use crate::engine::{Claim, Condition, Origin, Sink, SinkError};
use crate::measure::{Measurement, Quantity};
use crate::results::{Column, Results, Tally, labels};

/// The values of a unit, by their quantities.
type Columns = Vec<(Quantity, Column)>;

impl Store {
    /// The chunk of a unit, the slowest dimension first.
    fn chunk(&self, unit: usize) -> Vec<u64> {
        self.units.place(unit).into_iter().rev().map(|at| at as u64).collect()
    }

    /// The mark of a unit; None without one, and in a store of an earlier version.
    ///
    /// # Errors
    /// [`StoreError::Read`], or [`StoreError::Damaged`] if it is not what was written.
    pub fn mark(&self, unit: usize) -> Result<Option<Mark>, StoreError> {
        match Mark::read(self.path(), unit) {
            Ok(Found::Nothing) => Ok(None),
            Ok(Found::Mark(mark)) => Ok(Some(mark)),
            Ok(Found::Damaged) => Err(self.damaged(&format!("the mark of unit {unit}"))),
            Err(error) => Err(StoreError::read(self.path(), &error)),
        }
    }

    /// Writes the measurements of a unit. Its mark comes last: what has none is not finished.
    ///
    /// # Errors
    /// [`StoreError::TakenAway`] if the store is no longer at its path, [`StoreError::Write`].
    ///
    /// # Panics
    /// If the number of measurements is not that of the unit's points.
    pub fn write_unit(&self, unit: usize, measurements: &[Measurement], origin: &Origin) -> Result<(), StoreError> {
        let points = self.units.points(unit);
        assert_eq!(measurements.len(), points.len(), "one measurement for each point");
        self.check_root()?;
        let failed = |error: &io::Error| {
            if self.root.is_there() {
                StoreError::write(self.path(), error)
            } else {
                self.taken_away()
            }
        };
        Mark::remove(self.path(), unit).map_err(|error| failed(&error))?;
        let place = self.chunk(unit);
        let mut chunks = BTreeMap::new();
        for StoredArray { content, array } in &self.arrays {
            let values = match *content {
                Content::Quantity(quantity) => {
                    let mut column = Column::new(quantity.info().values, points.len());
                    for (index, measurement) in measurements.iter().enumerate() {
                        column.set(index, quantity.of(measurement));
                    }
                    column
                }
                Content::Scale(scale) => labels::scale_values(&self.experiment, scale, points.clone()),
            };
            let bytes =
                chunk::encode(array, &place, &values).map_err(|error| StoreError::write(self.path(), &error))?;
            let sum = chunk::write(self.path(), array, &place, &bytes).map_err(|error| failed(&error))?;
            chunks.insert(content.name().to_owned(), sum);
        }
        let mark = Mark {
            experiment: self.experiment_sum.clone(),
            block: self.units.block().to_vec(),
            chunks,
            device: origin.device.clone(),
            seconds: origin.elapsed.as_secs_f64(),
            tally: Tally::of(measurements),
        };
        self.check_root()?;
        mark.write(self.path(), unit).map_err(|error| failed(&error))?;
        self.check_root()
    }

    /// The values of a unit, by their quantities; None if it is not finished.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] if they are not what was written, [`StoreError::Read`].
    pub fn read_unit(&self, unit: usize) -> Result<Option<Columns>, StoreError> {
        if self.version() == 1 {
            return self.read_unit_1(unit);
        }
        let found = self.read_marked(unit)?;
        Ok(found.map(|(_, columns)| columns))
    }

    /// The mark of a unit and its values.
    fn read_marked(&self, unit: usize) -> Result<Option<(Mark, Columns)>, StoreError> {
        let Some(mark) = self.mark(unit)? else {
            return Ok(None);
        };
        if mark.experiment != self.experiment_sum {
            return Err(self.damaged(&format!("unit {unit} belongs to another experiment")));
        }
        let (place, points) = (self.chunk(unit), self.units.points(unit).len());
        let mut columns = Vec::new();
        for StoredArray { content, array } in &self.arrays {
            let file = chunk::path(self.path(), array, &place);
            let bytes = match fs::read(&file) {
                Ok(bytes) => bytes,
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    return Err(self.damaged_chunk(*content, &place, "it is missing"));
                }
                Err(error) => return Err(StoreError::read(&file, &error)),
            };
            if mark.chunks.get(content.name()) != Some(&checksum(&bytes)) {
                return Err(self.damaged_chunk(*content, &place, "its checksum is not that of what was written"));
            }
            let column = chunk::decode(array, &place, bytes, points);
            let column = column.map_err(|error| self.damaged_chunk(*content, &place, &error.to_string()))?;
            if let Content::Quantity(quantity) = *content {
                columns.push((quantity, column));
            }
        }
        Ok(Some((mark, columns)))
    }

    /// The values of a unit in a store of the first version. Such a store has no marks: a unit is finished if every point has a status.
    fn read_unit_1(&self, unit: usize) -> Result<Option<Columns>, StoreError> {
        let (place, points) = (self.chunk(unit), self.units.points(unit).len());
        let mut columns = Vec::new();
        for StoredArray { content, array } in &self.arrays {
            let Content::Quantity(quantity) = *content else {
                continue;
            };
            let mut column = Column::new(quantity.info().values, points);
            match fs::read(chunk::path(self.path(), array, &place)) {
                Ok(bytes) => {
                    let stored = chunk::decode(array, &place, bytes, points)
                        .map_err(|error| self.damaged_chunk(*content, &place, &error.to_string()))?;
                    for (index, value) in stored.values().enumerate() {
                        column.set(index, value);
                    }
                }
                // a chunk of which nothing applies was not written
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(StoreError::read(self.path(), &error)),
            }
            columns.push((quantity, column));
        }
        let column = |of| {
            &columns
                .iter()
                .find(|(quantity, _)| *quantity == of)
                .expect("it is stored")
                .1
        };
        let (status, exponents) = (column(Quantity::Status), column(Quantity::Lyapunov));
        if status.values().any(f64::is_nan) {
            return Ok(None);
        }
        if (0..points).any(|index| status.value(index) == 0.0 && exponents.value(index).is_nan()) {
            let content = Content::Quantity(Quantity::Lyapunov);
            return Err(self.damaged_chunk(content, &place, "values of finished points are missing"));
        }
        Ok(Some(columns))
    }

    /// All results; points of units that are not finished are not computed.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] if values of a finished unit are not what was written, [`StoreError::Read`].
    pub fn read(&self) -> Result<Results, StoreError> {
        self.read_some(&self.quantities())
    }

    /// As [`Store::read`], but of these quantities and the status alone.
    ///
    /// # Errors
    /// As [`Store::read`].
    pub fn read_some(&self, quantities: &[Quantity]) -> Result<Results, StoreError> {
        let mut results = Results::of(self.experiment.clone(), quantities);
        for unit in 0..self.units.count() {
            for (quantity, column) in self.read_unit(unit)?.into_iter().flatten() {
                results.replace(quantity, self.units.points(unit).start, &column);
            }
        }
        Ok(results)
    }

    /// The devices on which the units were computed, in the order of the units.
    ///
    /// # Errors
    /// [`StoreError::Read`] or [`StoreError::Damaged`].
    pub fn devices(&self) -> Result<Vec<String>, StoreError> {
        let mut devices = Vec::new();
        for unit in 0..self.units.count() {
            if let Some(mark) = self.mark(unit)?
                && !devices.contains(&mark.device)
            {
                devices.push(mark.device);
            }
        }
        Ok(devices)
    }

    /// What the store holds of a unit: every value is read and compared with its checksum.
    ///
    /// # Errors
    /// [`StoreError::Read`] if the file system does not let it be read.
    pub fn check_unit(&self, unit: usize) -> Result<Condition, StoreError> {
        let found = if self.version() == 1 {
            self.read_unit_1(unit).map(|columns| columns.as_ref().map(tally))
        } else {
            // the mark tells the motion; the store need not hold the class
            self.read_marked(unit).map(|found| found.map(|(mark, _)| mark.tally))
        };
        match found {
            Ok(None) => Ok(Condition::Missing),
            Ok(Some(tally)) => Ok(Condition::Whole(tally)),
            Err(StoreError::Damaged { what, .. }) => Ok(Condition::Damaged { what }),
            Err(error) => Err(error),
        }
    }

    fn check_root(&self) -> Result<(), StoreError> {
        if self.root.is_there() {
            Ok(())
        } else {
            Err(self.taken_away())
        }
    }

    fn taken_away(&self) -> StoreError {
        StoreError::TakenAway {
            path: self.path().to_owned(),
        }
    }

    fn damaged(&self, what: &str) -> StoreError {
        StoreError::Damaged {
            path: self.path().to_owned(),
            what: what.to_owned(),
        }
    }

    fn damaged_chunk(&self, content: Content, chunk: &[u64], reason: &str) -> StoreError {
        let place: Vec<String> = chunk.iter().map(u64::to_string).collect();
        self.damaged(&format!(
            "the array `{}`, chunk c/{}: {reason}",
            content.name(),
            place.join("/")
        ))
    }

    /// Whether all files of a finished unit are there, as far as their names and sizes tell.
    fn has_files(&self, unit: usize) -> bool {
        let place = self.chunk(unit);
        self.arrays.iter().all(|StoredArray { array, .. }| {
            let points = self.units.block_points() as u64;
            let size = array.data_type().fixed_size().unwrap_or(0) as u64 * points;
            fs::metadata(chunk::path(self.path(), array, &place)).is_ok_and(|file| file.len() >= size)
        })
    }
}

/// Points by their kind of motion, from the values of a store of the first version, which has all quantities.
fn tally(columns: &Columns) -> Tally {
    let codes = |of| {
        let column = columns.iter().find(|(quantity, _)| *quantity == of);
        let (_, column) = column.expect("it is stored");
        column.values().map(|code| (!code.is_nan()).then_some(code as usize))
    };
    Tally::counted(codes(Quantity::Status).flatten().zip(codes(Quantity::Class)))
}

impl Sink for Store {
    fn units(&self) -> usize {
        self.units.count()
    }

    fn points(&self, unit: usize) -> Range<usize> {
        self.units.points(unit)
    }

    fn condition(&self, unit: usize) -> Result<Condition, SinkError> {
        let condition = self.check_unit(unit)?;
        if self.lock.is_some() && matches!(condition, Condition::Whole(_)) {
            Lock::clear_unit(self.path(), unit);
        }
        Ok(condition)
    }

    fn is_finished(&self, unit: usize) -> Result<bool, SinkError> {
        let is_marked = self.version() == 1 || self.mark(unit)?.is_some();
        Ok(is_marked && self.root.is_there() && self.has_files(unit))
    }

    fn claim(&self, unit: usize) -> Result<Option<Claim>, SinkError> {
        if self.lock.is_none() {
            return Ok(Some(Claim::new(())));
        }
        self.check_root()?;
        Ok(Lock::of_unit(self.path(), unit)?.map(Claim::new))
    }

    fn write(&mut self, unit: usize, measurements: &[Measurement], origin: &Origin) -> Result<(), SinkError> {
        Ok(self.write_unit(unit, measurements, origin)?)
    }
}
