//! Onset and end of chaos on the axis of `lyapunov`: the search, and the report of its results.
//!
//! Owns the words and the object; the library defines what counts as chaos.

use std::fmt::Write as _;

use crate::analysis::onset::{self, CONFIRMING_PERIODS, Definition, Found, MOST_VALUES, Scan, Scanned, Way};
use crate::design::{Axis, Design};
use crate::engine::{self, Backends};
use crate::experiment::{Experiment, Settings};
use crate::machine::units::si;
use crate::picture::{caption, charts};
use serde_json::{Value, json};

use super::{Failure, analysis};

/// A search for chaos, with checked settings.
pub struct Search {
    definition: Definition,
    pub spacing: f64,
    fine: Axis,
}

/// The result of a search.
pub enum Outcome {
    /// Nothing was searched, for this reason.
    Left(&'static str),
    /// Onset and end.
    Searched(Search, Box<[Bound; 2]>),
}

/// Where chaos begins or ends.
#[derive(Clone, Copy)]
pub struct Bound {
    way: Way,
    scanned: Scanned,
    /// Whether the first value of the scan is already chaotic, so that the bound lies outside the fine grid.
    is_beyond: bool,
}

/// The spacing that was asked for, or the default for the axis.
///
/// # Errors
/// If the spacing gives fewer than two values, or too many, in the range of the axis.
fn spacing(asked: Option<f64>, axis: &Axis) -> Result<f64, Failure> {
    let Some(spacing) = asked else {
        return Ok(onset::default_spacing(axis));
    };
    let range = (axis.last() - axis.first()).abs();
    let values = onset::count(axis, spacing);
    // written so that NaN is refused; a spacing as large as the range gives two values
    if !(spacing > 0.0 && values >= 2.0) {
        return Err(Failure::Input(anyhow::anyhow!(
            "--onset-spacing {spacing} is out of range: it must be positive, and no more than the axis' range {}",
            charts::rounded(range)
        )));
    }
    if values > MOST_VALUES as f64 {
        return Err(Failure::Input(anyhow::anyhow!(
            "--onset-spacing {spacing:e} makes {values} values on the axis' range {}, from each initial state (at most \
             {MOST_VALUES}): use {:e} or more, or an axis with a smaller range",
            charts::rounded(range),
            charts::rounded(range / (MOST_VALUES - 1) as f64)
        )));
    }
    Ok(spacing)
}

impl Search {
    /// The search over the axis of an experiment.
    ///
    /// # Errors
    /// If the spacing does not fit the axis, or the machine is not valid at some value of the fine grid.
    pub fn new(asked: Option<f64>, experiment: &Experiment, settings: &Settings) -> Result<Self, Failure> {
        let axis = &experiment.design.axes()[0];
        let spacing = spacing(asked, axis)?;
        let fine = onset::fine_axis(axis, spacing);
        // the machine was checked at the values of the axis, but not between them
        let grid = Design::product(vec![fine.clone()], experiment.design.fixed);
        grid.extents().map_err(Failure::input)?;
        let definition = Definition::new(settings);
        Ok(Self {
            definition,
            spacing,
            fine,
        })
    }

    /// Searches from both ends of the axis.
    ///
    /// # Errors
    /// If the backend fails, or a signal broke the search off.
    pub fn run(
        self,
        experiment: &Experiment,
        starts: &[[f64; 2]],
        backends: &mut Backends,
    ) -> Result<Outcome, Failure> {
        let scan = Scan {
            definition: &self.definition,
            at: &experiment.design.fixed,
            axis: self.fine.clone(),
            starts,
        };
        // an estimate: the values between onset and end are skipped, and the confirming runs come in addition
        let points = self.fine.count() * starts.len();
        let work = engine::instance_periods(&self.definition.settings, points);
        let [up, down] = analysis::compute(work, points, |observer| {
            let Some(up) = scan.first(Way::Up, backends, observer)? else {
                return Ok(None);
            };
            // without an onset there is no end
            let down = if up.found.is_some() {
                scan.first(Way::Down, backends, observer)?
            } else {
                Some(up)
            };
            Ok(down.map(|down| [up, down]))
        })?;
        let bound = |way, scanned: Scanned, extreme: f64| Bound {
            way,
            scanned,
            is_beyond: scanned.found.is_some_and(|found| found.value == extreme),
        };
        let bounds = [
            bound(Way::Up, up, self.fine.first()),
            bound(Way::Down, down, self.fine.last()),
        ];
        Ok(Outcome::Searched(self, Box::new(bounds)))
    }

    /// How chaos was looked for.
    fn method(&self) -> String {
        let settings = &self.definition.settings;
        format!(
            "by {} + {} periods of {} {} steps, confirmed over {CONFIRMING_PERIODS}, on multiples of {}",
            settings.sampling.transient_periods,
            settings.sampling.periods,
            settings.integration.steps_per_period,
            settings.integration.scheme.name(),
            charts::rounded(self.spacing)
        )
    }
}

impl Bound {
    /// The name of the value at which the scan started, for a bound outside the fine grid.
    fn extreme(&self) -> &'static str {
        match self.way {
            Way::Up => "lowest",
            Way::Down => "highest",
        }
    }

    fn verb(&self) -> &'static str {
        match self.way {
            Way::Up => "begins",
            Way::Down => "ends",
        }
    }

    fn words(&self, search: &Search, experiment: &Experiment) -> String {
        let Scanned {
            found,
            passed,
            unmeasured,
        } = self.scanned;
        let Some(found) = found else {
            return match unmeasured {
                0 => "none of the initial states leads to chaos on the axis".to_owned(),
                all if all == passed => "unknown, since nothing was measured".to_owned(),
                some => format!(
                    "none of the initial states leads to chaos where it was measured, which {some} of {passed} points were not"
                ),
            };
        };
        let coordinate = search.fine.coordinate;
        let unit = match experiment.design.fixed.unit(coordinate) {
            "1" => String::new(),
            unit => format!(" {unit}"),
        };
        let value = charts::rounded(found.value);
        let place = if self.is_beyond {
            format!("chaos at the {} value, {coordinate} = {value}{unit}", self.extreme())
        } else {
            let spacing = charts::rounded(search.spacing);
            format!("chaos {} at {coordinate} = {value} +- {spacing}{unit}", self.verb())
        };
        let gaps = if unmeasured > 0 {
            format!("; {unmeasured} of {passed} points before it were not measured")
        } else {
            String::new()
        };
        format!(
            "{place}, from (x, y) = ({}, {}), with exponent {:.4} +- {:.4}, and {:.4} +- {:.4} over {CONFIRMING_PERIODS} \
             periods{gaps}",
            found.start[0],
            found.start[1],
            found.exponent,
            found.error,
            found.again.lyapunov,
            found.again.lyapunov_error,
        )
    }

    fn object(&self, search: &Search) -> Value {
        match self.scanned.found {
            None if self.scanned.unmeasured > 0 => json!("unknown"),
            None => json!("never"),
            Some(_) if self.is_beyond => json!(format!("at_{}", self.extreme())),
            Some(found) => json!({
                "value": charts::rounded(found.value),
                "uncertainty": search.spacing,
                "initial_state": found.start,
                "lyapunov": found.exponent,
                "lyapunov_error": found.error,
                "confirmation": {
                    "periods": CONFIRMING_PERIODS,
                    "lyapunov": found.again.lyapunov,
                    "lyapunov_error": found.again.lyapunov_error,
                },
            }),
        }
    }
}

impl Outcome {
    /// The least value with chaos.
    pub fn least(&self) -> Option<&Found> {
        match self {
            Self::Left(_) => None,
            Self::Searched(_, bounds) => bounds[0].scanned.found.as_ref(),
        }
    }

    /// Where chaos begins and ends within the axis, with the names that pictures give to these values.
    pub fn marks(&self) -> Vec<(&'static str, f64)> {
        let Self::Searched(_, bounds) = self else {
            return Vec::new();
        };
        let within = ["onset", "end"]
            .into_iter()
            .zip(bounds.iter())
            .filter(|(_, bound)| !bound.is_beyond);
        within
            .filter_map(|(name, bound)| Some((name, bound.scanned.found?.value)))
            .collect()
    }

    /// Some lines for people.
    pub fn words(&self, experiment: &Experiment) -> String {
        let (search, bounds) = match self {
            Self::Left(reason) => return format!("onset: not looked for ({reason})"),
            Self::Searched(search, bounds) => (search, bounds),
        };
        let [onset, end] = &**bounds;
        let mut words = format!("onset: {}", onset.words(search, experiment));
        if end.scanned.found.is_some() {
            let _ = write!(words, "\nend:   {}", end.words(search, experiment));
        }
        words + &format!("\n       {}", search.method())
    }

    /// A sentence for the picture's caption; empty where nothing was searched.
    pub fn caption(&self, experiment: &Experiment) -> String {
        let Self::Searched(search, bounds) = self else {
            return String::new();
        };
        let [onset, end] = &**bounds;
        let (at, coordinate) = (&experiment.design.fixed, search.fine.coordinate);
        let grid = format!(
            "over {CONFIRMING_PERIODS} forcing periods and on multiples of {}",
            si(search.spacing, at.unit(coordinate))
        );
        let told = |bound: &Bound| match bound.scanned.found {
            Some(found) if !bound.is_beyond => {
                format!(
                    "{} at {} (dashed)",
                    bound.verb(),
                    caption::assigned(at, coordinate, charts::rounded(found.value))
                )
            }
            _ => format!("is there at the {} value", bound.extreme()),
        };
        match self.least() {
            Some(_) => format!("Chaos, {grid}, {} and {}. ", told(onset), told(end)),
            None if onset.scanned.unmeasured > 0 => format!("No chaos, {grid}, where it was measured. "),
            None => format!("No chaos, {grid}. "),
        }
    }

    /// Onset and end for `--json`.
    pub fn objects(&self) -> [Value; 2] {
        match self {
            Self::Left(_) => [Value::Null, Value::Null],
            Self::Searched(search, bounds) => [0, 1].map(|index| bounds[index].object(search)),
        }
    }
}
