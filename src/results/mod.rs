//! The results of an experiment: one column of values for each quantity.
//!
//! Owns computed data in memory; neither computes nor draws nor stores them.

use std::collections::BTreeMap;

use crate::backend::BackendKind;
use crate::experiment::Experiment;
use crate::machine::Beyond;
use crate::measure::{Class, Measurement, QUANTITIES, Quantity, Status};

/// Values of every quantity at every point of a design, in its order.
#[derive(Clone, Debug)]
pub struct Results {
    /// What the values were computed for.
    pub experiment: Experiment,
    columns: Vec<Vec<f64>>,
}

impl Results {
    /// Results of which nothing is computed yet.
    pub fn new(experiment: Experiment) -> Self {
        let columns = vec![vec![f64::NAN; experiment.design.len()]; Quantity::COUNT];
        Self { experiment, columns }
    }

    /// Values of a quantity, in the order of the design; NaN where not computed or not applicable.
    pub fn column(&self, quantity: Quantity) -> &[f64] {
        &self.columns[quantity as usize]
    }

    /// Values of a quantity in SI units, by the machine of each point, and their unit; None without a machine, or for a pure
    /// number.
    pub fn si_column(&self, quantity: Quantity) -> Option<(Vec<f64>, &'static str)> {
        let scale = quantity.scale();
        let unit = match scale {
            Some(scale) => scale.unit(),
            None if quantity.is_rate() => "1/s",
            None => return None,
        };
        let design = &self.experiment.design;
        let values = self.column(quantity).iter().enumerate();
        let values: Option<Vec<f64>> = values
            .map(|(index, value)| {
                let scales = design.machine(index)?.scales();
                Some(value * scale.map_or(1.0 / scales.time, |scale| scales.of(scale)))
            })
            .collect();
        Some((values?, unit))
    }

    /// Where the model does not hold, because the material of the machine would melt or yield, or the bush would turn too far. For
    /// each limit, by its name: the number of points beyond it, the index of the worst point, and what happens there.
    fn exceedances(&self) -> BTreeMap<&'static str, (usize, usize, Beyond)> {
        let design = &self.experiment.design;
        let (pressures, temperatures) = (
            self.column(Quantity::PeakPressure),
            self.column(Quantity::PeakTemperature),
        );
        let (lowest, highest) = (self.column(Quantity::XMin), self.column(Quantity::XMax));
        let mut kinds = BTreeMap::new();
        for index in 0..design.len() {
            let Some(machine) = design.machine(index) else { break };
            let angle = lowest[index].abs().max(highest[index].abs());
            for beyond in machine.beyond(pressures[index], temperatures[index], angle) {
                let (count, worst, most) = kinds.entry(beyond.name()).or_insert((0, index, beyond));
                *count += 1;
                if beyond.factor() > most.factor() {
                    (*worst, *most) = (index, beyond);
                }
            }
        }
        kinds
    }

    /// The share of the points beyond each limit of the model, with the name of the limit.
    pub fn shares_beyond_limits(&self) -> Vec<(&'static str, f64)> {
        let points = self.experiment.design.len() as f64;
        let exceedances = self.exceedances();
        exceedances
            .iter()
            .map(|(name, (count, ..))| (*name, *count as f64 / points))
            .collect()
    }

    /// A sentence for each limit of the model that is exceeded: at how many points, and what happens at the worst.
    pub fn beyond_limits(&self) -> Vec<String> {
        let design = &self.experiment.design;
        let exceedances = self.exceedances();
        let warnings = exceedances.values().map(|(count, index, beyond)| {
            let share = 100.0 * *count as f64 / design.len() as f64;
            format!(
                "beyond the model's limits at {count} points ({share:.1} %): at {}, the worst, {beyond}",
                design.place(*index)
            )
        });
        warnings.collect()
    }

    /// Values of a quantity, to be set.
    pub fn column_mut(&mut self, quantity: Quantity) -> &mut [f64] {
        &mut self.columns[quantity as usize]
    }

    /// Sets all quantities of a point.
    pub fn set(&mut self, index: usize, measurement: &Measurement) {
        for (info, column) in QUANTITIES.iter().zip(&mut self.columns) {
            column[index] = info.quantity.of(measurement);
        }
    }

    /// Whether a point is computed.
    pub fn is_computed(&self, index: usize) -> bool {
        !self.column(Quantity::Status)[index].is_nan()
    }

    /// The class of a point; None where it is not computed, ran away, is under-resolved, or wears.
    pub fn class(&self, index: usize) -> Option<Class> {
        Class::ALL.get(code(self.column(Quantity::Class)[index])?).copied()
    }

    /// Whether any point was integrated on a GPU.
    pub fn has_gpu_points(&self) -> bool {
        self.column(Quantity::Backend)
            .contains(&f64::from(BackendKind::GpuF32 as u8))
    }

    /// Whether a point was measured.
    pub fn is_ok(&self, index: usize) -> bool {
        self.has_status(index, Status::Ok)
    }

    /// Whether the orbit of a point ran away.
    pub fn is_runaway(&self, index: usize) -> bool {
        self.has_status(index, Status::Runaway { time: f64::NAN })
    }

    /// Whether a point is under-resolved.
    pub fn is_under_resolved(&self, index: usize) -> bool {
        self.has_status(index, Status::UnderResolved)
    }

    fn has_status(&self, index: usize, status: Status) -> bool {
        self.column(Quantity::Status)[index] == f64::from(status.code())
    }
}

fn code(value: f64) -> Option<usize> {
    (!value.is_nan()).then_some(value as usize)
}
