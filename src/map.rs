//! A parameter map: axes, one column of values for each quantity, and where they came from.
//!
//! Owns computed data in memory; neither computes nor draws nor stores them.

use std::collections::BTreeMap;

use crate::experiment::Experiment;
use crate::grid::Axis;
use crate::machine::Beyond;
use crate::measurement::{BackendKind, Class, Measurement, QUANTITIES, Quantity};

/// Values of every quantity at every point of a two-dimensional grid; x varies fastest.
#[derive(Clone, Debug)]
pub struct ParameterMap {
    pub experiment: Experiment,
    columns: Vec<Vec<f64>>,
}

impl ParameterMap {
    /// A map in which nothing is computed yet.
    ///
    /// # Panics
    /// If the experiment has not two axes.
    pub fn new(experiment: Experiment) -> Self {
        assert_eq!(experiment.grid.axes.len(), 2, "a map has two axes");
        let columns = vec![vec![f64::NAN; experiment.grid.len()]; Quantity::COUNT];
        Self { experiment, columns }
    }

    pub fn x_axis(&self) -> &Axis {
        &self.experiment.grid.axes[0]
    }

    pub fn y_axis(&self) -> &Axis {
        &self.experiment.grid.axes[1]
    }

    /// Values of a quantity, x fastest; NaN where not computed or not applicable.
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
        let grid = &self.experiment.grid;
        let values = self.column(quantity).iter().enumerate();
        let values: Option<Vec<f64>> = values
            .map(|(index, value)| {
                let scales = grid.machine(index)?.scales();
                Some(value * scale.map_or(1.0 / scales.time, |scale| scales.of(scale)))
            })
            .collect();
        Some((values?, unit))
    }

    /// Where the results are fiction, since the material of the machine would melt or yield, or the bush turn too far for the
    /// model: by the limit's name at how many points, the index of the worst, and what happens there.
    fn fiction(&self) -> BTreeMap<&'static str, (usize, usize, Beyond)> {
        let grid = &self.experiment.grid;
        let (pressures, temperatures) = (
            self.column(Quantity::PeakPressure),
            self.column(Quantity::PeakTemperature),
        );
        let (lowest, highest) = (self.column(Quantity::XMin), self.column(Quantity::XMax));
        let mut kinds = BTreeMap::new();
        for index in 0..grid.len() {
            let Some(machine) = grid.machine(index) else { break };
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

    /// As shares of the points: by the limit's name, `melting` or `yield`.
    pub fn fiction_shares(&self) -> Vec<(&'static str, f64)> {
        let points = self.experiment.grid.len() as f64;
        let fiction = self.fiction();
        fiction
            .iter()
            .map(|(name, (count, ..))| (*name, *count as f64 / points))
            .collect()
    }

    /// Each kind of fiction as a sentence: at how many points, and the worst.
    pub fn beyond_limits(&self) -> Vec<String> {
        let grid = &self.experiment.grid;
        let fiction = self.fiction();
        let warnings = fiction.values().map(|(count, index, beyond)| {
            let share = 100.0 * *count as f64 / grid.len() as f64;
            format!(
                "fiction at {count} points ({share:.1} %): at {}, the worst, {beyond}",
                grid.place(*index)
            )
        });
        warnings.collect()
    }

    pub fn column_mut(&mut self, quantity: Quantity) -> &mut [f64] {
        &mut self.columns[quantity as usize]
    }

    pub fn set(&mut self, index: usize, measurement: &Measurement) {
        for (info, column) in QUANTITIES.iter().zip(&mut self.columns) {
            column[index] = info.quantity.of(measurement);
        }
    }

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

    pub fn is_ok(&self, index: usize) -> bool {
        self.column(Quantity::Status)[index] == 0.0
    }

    pub fn is_runaway(&self, index: usize) -> bool {
        self.column(Quantity::Status)[index] == 1.0
    }

    pub fn is_under_resolved(&self, index: usize) -> bool {
        self.column(Quantity::Status)[index] == 2.0
    }
}

fn code(value: f64) -> Option<usize> {
    (!value.is_nan()).then_some(value as usize)
}

/// The first upward change to chaos along a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onset {
    /// The row's value on the y axis.
    pub y: f64,
    pub kind: OnsetKind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OnsetKind {
    /// Chaos begins at `x`, give or take `half_width`: between the last point that is decided and not chaotic, and the
    /// first chaotic one.
    At { x: f64, half_width: f64 },
    /// Chaotic at the row's first decided point: the onset lies outside the map.
    BeforeFirst,
    /// No point of the row is chaotic.
    Never,
    /// Not every point up to the onset is computed.
    Incomplete,
}

/// The threshold of chaos: for every row, where x rises (whichever way its axis runs), the first change from motion
/// that is not chaotic to chaos. Undecided and runaway points inside the bracket widen it.
pub fn threshold(map: &ParameterMap) -> Vec<Onset> {
    let (x_axis, y_axis) = (map.x_axis(), map.y_axis());
    let mut order: Vec<usize> = (0..x_axis.count).collect();
    if x_axis.step() < 0.0 {
        order.reverse();
    }
    (0..y_axis.count)
        .map(|row| Onset {
            y: y_axis.value(row),
            kind: onset_of_row(map, row, &order),
        })
        .collect()
}

fn onset_of_row(map: &ParameterMap, row: usize, columns: &[usize]) -> OnsetKind {
    let axis = map.x_axis();
    let mut last_other = None;
    for &column in columns {
        let index = row * axis.count + column;
        if !map.is_computed(index) {
            return OnsetKind::Incomplete;
        }
        match map.class(index) {
            Some(Class::Chaotic) => {
                let Some(before) = last_other else {
                    return OnsetKind::BeforeFirst;
                };
                let (low, high) = (axis.value(before), axis.value(column));
                return OnsetKind::At {
                    x: 0.5 * (low + high),
                    half_width: 0.5 * (high - low).abs(),
                };
            }
            Some(Class::Regular | Class::QuasiPeriodic) => last_other = Some(column),
            Some(Class::Undecided | Class::Unstable) | None => {}
        }
    }
    OnsetKind::Never
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Request;

    fn row(classes: &[Option<Class>], x: &str) -> OnsetKind {
        let mut request = Request {
            x: Axis::parse(x).unwrap(),
            ..Request::default()
        };
        request.y.count = 2;
        let mut map = ParameterMap::new(request.resolve().unwrap());
        for (index, class) in classes.iter().enumerate() {
            let measurement = Measurement {
                class: *class,
                ..Measurement::runaway(0.0, BackendKind::CpuF64)
            };
            map.set(index, &measurement);
        }
        threshold(&map)[0].kind
    }

    #[test]
    fn the_threshold_is_the_middle_of_the_bracket() {
        let (c, r, u) = (Some(Class::Chaotic), Some(Class::Regular), Some(Class::Undecided));
        assert_eq!(
            row(&[r, r, c, r, c], "zeta_k=0:4:5"),
            OnsetKind::At {
                x: 1.5,
                half_width: 0.5
            }
        );
        assert_eq!(
            row(&[r, u, c, r, c], "zeta_k=0:4:5"),
            OnsetKind::At {
                x: 1.0,
                half_width: 1.0
            }
        );
        assert_eq!(
            row(&[r, None, c, r, c], "zeta_k=0:4:5"),
            OnsetKind::At {
                x: 1.0,
                half_width: 1.0
            }
        );
        assert_eq!(row(&[c, r, c, r, c], "zeta_k=0:4:5"), OnsetKind::BeforeFirst);
        assert_eq!(row(&[r, r, u, r, r], "zeta_k=0:4:5"), OnsetKind::Never);
        assert_eq!(row(&[r, r], "zeta_k=0:4:5"), OnsetKind::Incomplete);
        assert_eq!(
            row(&[c, c, c, r, r], "zeta_k=4:0:5"),
            OnsetKind::At {
                x: 1.5,
                half_width: 0.5
            }
        );
    }
}
