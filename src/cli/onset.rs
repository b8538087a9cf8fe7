//! Onset and end of chaos on the axis of `lyapunov`: the search, and the report of its results.
//!
//! Owns the words and the object; the library defines what counts as chaos.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::{Failure, analysis};
use crate::analysis::onset::{self, Bound, CONFIRMING_PERIODS, Definition, Found, Scan, Scanned, Way};
use crate::design::Axis;
use crate::engine::{self, Backends};
use crate::experiment::{Experiment, Settings};
use crate::machine::units::si;
use crate::picture::{caption, charts};

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

impl Search {
    /// The search over the axis of an experiment.
    ///
    /// # Errors
    /// If the spacing does not fit the axis, or the machine is not valid at some value of the fine grid.
    pub fn new(asked: Option<f64>, experiment: &Experiment, settings: &Settings) -> Result<Self, Failure> {
        let axis = &experiment.design.axes()[0];
        let spacing = onset::checked_spacing(axis, asked).map_err(Failure::input)?;
        let fine = onset::fine_axis(axis, spacing);
        let definition = Definition::new(settings);
        onset::check_grid(&experiment.design.fixed, &fine).map_err(Failure::input)?;
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
        let bounds = analysis::compute(work, points, |observer| scan.bounds(backends, observer))?;
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

/// What is said of a bound.
struct Told<'a>(&'a Bound);

impl Told<'_> {
    /// The name of the value at which the scan started, for a bound outside the fine grid.
    fn extreme(&self) -> &'static str {
        match self.0.way {
            Way::Up => "lowest",
            Way::Down => "highest",
        }
    }

    fn verb(&self) -> &'static str {
        match self.0.way {
            Way::Up => "begins",
            Way::Down => "ends",
        }
    }

    fn words(&self, search: &Search, experiment: &Experiment) -> String {
        let Scanned {
            found,
            passed,
            unmeasured,
        } = self.0.scanned;
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
        let place = if self.0.is_beyond {
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
        match self.0.scanned.found {
            None if self.0.scanned.unmeasured > 0 => json!("unknown"),
            None => json!("never"),
            Some(_) if self.0.is_beyond => json!(format!("at_{}", self.extreme())),
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
        let mut words = format!("onset: {}", Told(onset).words(search, experiment));
        if end.scanned.found.is_some() {
            let _ = write!(words, "\nend:   {}", Told(end).words(search, experiment));
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
                    Told(bound).verb(),
                    caption::assigned(at, coordinate, charts::rounded(found.value))
                )
            }
            _ => format!("is there at the {} value", Told(bound).extreme()),
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
            Self::Searched(search, bounds) => [0, 1].map(|index| Told(&bounds[index]).object(search)),
        }
    }
}
