//! The scales of a machine in a store: what leads from its dimensionless values to SI units, point by point.
//!
//! Owns their arrays, which are for other readers: a map is read without them.

use std::sync::Arc;

use zarrs::array::{Array, ArrayError};
use zarrs::filesystem::FilesystemStore;

use super::layout::{self, node, plain_metadata};
use crate::experiment::Experiment;
use crate::machine::Scale;

/// One for each of [`Scale::ALL`]; none without a machine.
pub struct ScaleArrays(Vec<Array<FilesystemStore>>);

fn scales_of(experiment: &Experiment) -> &'static [Scale] {
    if experiment.design.fixed.machine().is_some() {
        &Scale::ALL
    } else {
        &[]
    }
}

impl ScaleArrays {
    pub fn create(
        storage: &Arc<FilesystemStore>,
        experiment: &Experiment,
        tile: [usize; 2],
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let (x, y) = (&experiment.design.axes()[0], &experiment.design.axes()[1]);
        let mut arrays = Vec::new();
        for &scale in scales_of(experiment) {
            let array = layout::scale(scale, x, y, tile).build(storage.clone(), &node(scale.name()))?;
            array.store_metadata_opt(&plain_metadata())?;
            arrays.push(array);
        }
        Ok(Self(arrays))
    }

    pub fn open(storage: &Arc<FilesystemStore>, experiment: &Experiment) -> Result<Self, String> {
        let open = |scale: &Scale| {
            Array::open(storage.clone(), &node(scale.name()))
                .map_err(|error| format!("the array `{}`: {error}", scale.name()))
        };
        let arrays = scales_of(experiment).iter().map(open).collect::<Result<_, _>>()?;
        Ok(Self(arrays))
    }

    /// Writes a chunk: `padded` makes it of the values of the scale at its points.
    pub fn write(
        &self,
        experiment: &Experiment,
        chunk: &[u64; 2],
        padded: impl Fn(&dyn Fn(usize) -> f64) -> Vec<f64>,
    ) -> Result<(), ArrayError> {
        for (array, scale) in self.0.iter().zip(Scale::ALL) {
            let machine = |index: usize| experiment.design.machine(index);
            let values = padded(&|index| machine(index).map_or(f64::NAN, |machine| machine.scales().of(scale)));
            array.store_chunk(chunk, values)?;
        }
        Ok(())
    }

    /// Bytes for a point.
    pub fn size(experiment: &Experiment) -> u64 {
        8 * scales_of(experiment).len() as u64
    }
}
