//! The results of an experiment: one column of values for each quantity.
//!
//! Owns computed data in memory; neither computes nor draws nor stores them.

mod column;
pub mod labels;
mod tally;

use std::collections::BTreeMap;

pub use self::column::{Column, NO_CODE};
pub use self::tally::Tally;

use crate::backend::BackendKind;
use crate::experiment::Experiment;
use crate::machine::Beyond;
use crate::measure::{Class, Measurement, QUANTITIES, Quantity, Status};

/// Values of quantities at every point of a design, in the order of the design.
#[derive(Clone, Debug)]
pub struct Results {
    /// The experiment of which these are the results.
    pub experiment: Experiment,
    /// In the order of [`QUANTITIES`]; None for those that the results do not hold.
    columns: Vec<Option<Column>>,
}

impl Results {
    /// Results of every quantity, in which no point is computed yet.
    pub fn new(experiment: Experiment) -> Self {
        Self::of(experiment, &Quantity::all())
    }

    /// Results of some quantities and of the status, in which no point is computed yet.
    pub fn of(experiment: Experiment, quantities: &[Quantity]) -> Self {
        let points = experiment.design.len();
        let mut columns = vec![None; Quantity::COUNT];
        for info in Quantity::held(quantities) {
            columns[info.quantity as usize] = Some(Column::new(info.values, points));
        }
        Self { experiment, columns }
    }

    /// The quantities that the results hold.
    pub fn quantities(&self) -> Vec<Quantity> {
        let mut quantities = Quantity::all();
        quantities.retain(|&quantity| self.column(quantity).is_some());
        quantities
    }

    /// The values of a quantity, if the results hold it.
    pub fn column(&self, quantity: Quantity) -> Option<&Column> {
        self.columns[quantity as usize].as_ref()
    }

    /// Takes the values of a quantity out of the results, if they hold it.
    pub fn take(&mut self, quantity: Quantity) -> Option<Column> {
        self.columns[quantity as usize].take()
    }

    /// The value of a quantity at a point; NaN where it is not computed, does not apply, or is not held.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn value(&self, quantity: Quantity, index: usize) -> f64 {
        self.column(quantity).map_or(f64::NAN, |column| column.value(index))
    }

    /// The values of a quantity in the order of the design; NaN where [`Results::value`] is.
    pub fn values(&self, quantity: Quantity) -> impl ExactSizeIterator<Item = f64> + Clone + '_ {
        (0..self.experiment.design.len()).map(move |index| self.value(quantity, index))
    }

    /// Values of a quantity in SI units, and their unit. Each point is converted with the scales of its own machine. None without
    /// a machine, or for a pure number.
    pub fn si_column(&self, quantity: Quantity) -> Option<(Vec<f64>, &'static str)> {
        let scale = quantity.scale();
        let unit = match scale {
            Some(scale) => scale.unit(),
            None if quantity.is_rate() => "1/s",
            None => return None,
        };
        let design = &self.experiment.design;
        let values: Option<Vec<f64>> = self
            .column(quantity)?
            .values()
            .enumerate()
            .map(|(index, value)| {
                let scales = design.machine(index)?.scales();
                Some(value * scale.map_or(1.0 / scales.time, |scale| scales.of(scale)))
            })
            .collect();
        Some((values?, unit))
    }

    /// The limits of the model that are exceeded: the material of the machine would melt or yield, or the bush would turn too
    /// far. For each limit, by its name: the number of points beyond it, the index of the worst point, and what happens there.
    fn exceedances(&self) -> BTreeMap<&'static str, (usize, usize, Beyond)> {
        let design = &self.experiment.design;
        let mut kinds = BTreeMap::new();
        for index in 0..design.len() {
            let Some(machine) = design.machine(index) else { break };
            let [pressure, temperature, lowest, highest] = [
                Quantity::PeakPressure,
                Quantity::PeakTemperature,
                Quantity::XMin,
                Quantity::XMax,
            ]
            .map(|quantity| self.value(quantity, index));
            for beyond in machine.beyond(pressure, temperature, lowest.abs().max(highest.abs())) {
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

    /// A sentence for each limit of the model that is exceeded: at how many points, and what happens at the worst point.
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

    /// Sets all quantities of a point.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn set(&mut self, index: usize, measurement: &Measurement) {
        for (info, column) in QUANTITIES.iter().zip(&mut self.columns) {
            if let Some(column) = column {
                column.set(index, info.quantity.of(measurement));
            }
        }
    }

    /// Puts computed values of a quantity in place, from point `first` on. A quantity that the results do not hold is left aside.
    ///
    /// # Panics
    /// If the values reach beyond the last point.
    pub fn replace(&mut self, quantity: Quantity, first: usize, values: &Column) {
        if let Some(column) = &mut self.columns[quantity as usize] {
            column.replace(first, values);
        }
    }

    /// Sets the value of a quantity at a point. A quantity that the results do not hold is left aside.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn set_value(&mut self, quantity: Quantity, index: usize, value: f64) {
        if let Some(column) = &mut self.columns[quantity as usize] {
            column.set(index, value);
        }
    }

    /// Whether a point is computed.
    pub fn is_computed(&self, index: usize) -> bool {
        !self.value(Quantity::Status, index).is_nan()
    }

    /// The class of a point. None if the point is not computed, its orbit ran away, it is under-resolved, or its contact wears.
    pub fn class(&self, index: usize) -> Option<Class> {
        Class::ALL.get(code(self.value(Quantity::Class, index))?).copied()
    }

    /// Whether any point was integrated on a GPU.
    pub fn has_gpu_points(&self) -> bool {
        let gpu = f64::from(BackendKind::GpuF32 as u8);
        self.values(Quantity::Backend).any(|backend| backend == gpu)
    }

    /// Whether a point was measured: it is computed, its orbit did not run away, and it is not under-resolved.
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
        self.value(Quantity::Status, index) == f64::from(status.code())
    }
}

fn code(value: f64) -> Option<usize> {
    (!value.is_nan()).then_some(value as usize)
}
