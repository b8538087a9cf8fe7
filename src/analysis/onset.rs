//! Where chaos begins over one parameter, and where it ends.
//!
//! Owns their definition and the scan for them; measures through [`crate::engine`].
//!
//! A fine grid over the whole range of an axis is scanned, whatever values the axis itself has. The onset is the first value with
//! chaos from some initial state. Three conditions define chaos here: the exponent is above a bound; the class is neither regular
//! nor quasi-periodic; and the motion is chaotic in a much longer run as well. The condition on the class excludes slowly
//! attracting cycles and quasi-periodic motion, whose exponents over a finite window may be above the bound far from chaos. The
//! longer run excludes chaos that ends. Chaos is not monotone in a parameter, so that the range is scanned, never bisected.

use crate::backend::BackendError;
use crate::design::{Axis, Coordinate, Design, DesignError, Fixed};
use crate::engine::{Backends, Observer};
use crate::experiment::{Sampling, Scheme, Settings};
use crate::machine::units::rounded;
use crate::measure::{Class, Measurement, Status};
use crate::parameters::Parameter;

/// The most values of the fine grid: more take hours.
pub const MOST_VALUES: usize = 100_000;

/// Forcing periods over which chaos is confirmed.
pub const CONFIRMING_PERIODS: u32 = 2000;

/// The spacing of the grid by which docs/theory-and-paper.md defines the onset in zeta_k.
const ZETA_K_SPACING: f64 = 0.0025;

/// Values of the fine grid that are measured at a time. In a chunk with chaos, the values after the first chaotic one are
/// measured in vain.
const CHUNK: usize = 256;

/// Candidates that are confirmed at a time: as many as the CPU's lanes compute in the time of one.
const CONFIRMED_TOGETHER: usize = 32;

/// What counts as chaos.
#[derive(Clone, Debug, PartialEq)]
pub struct Definition {
    /// Least exponent, per unit of tau.
    pub least_exponent: f64,
    /// How exponents are measured at first; chaos is confirmed over [`CONFIRMING_PERIODS`].
    pub settings: Settings,
}

impl Definition {
    /// An exponent above 0.005 over 100 periods after 380 periods, with the friction layer resolved. For this, rk4 has at least
    /// 4000 fixed steps in a period; the steps of the other schemes end at the layer's boundaries.
    pub fn new(settings: &Settings) -> Self {
        let mut settings = Settings {
            sampling: Sampling {
                transient_periods: 380,
                align_periods: 50,
                periods: 100,
                decide_early: false,
                initial_states: 1,
                ..settings.sampling
            },
            ..*settings
        };
        if settings.integration.scheme == Scheme::Rk4 {
            let steps = settings.integration.steps_per_period.max(4000);
            settings.integration.steps_per_period = steps;
            settings.integration.renormalise_every = steps / 4;
        }
        Self {
            least_exponent: 0.005,
            settings,
        }
    }

    /// Whether the motion may be chaotic. Undecided motion counts, too: over 100 periods the error is as large as the exponent,
    /// so that many points are undecided.
    fn is_chaos(&self, measurement: &Measurement) -> bool {
        matches!(measurement.class, Some(Class::Chaotic | Class::Undecided))
            && measurement.lyapunov > self.least_exponent
    }

    /// Whether the motion is chaotic over [`CONFIRMING_PERIODS`], which leave few points undecided.
    fn is_confirmed(&self, again: &Measurement) -> bool {
        again.class == Some(Class::Chaotic) && self.is_chaos(again)
    }
}

/// The default spacing of the fine grid. For zeta_k it is 0.0025, or more if 0.0025 gives more than [`MOST_VALUES`] values. For
/// other coordinates, and for a range of zeta_k shorter than 0.0025, it is the round number (1, 2 or 5 times a power of ten) at
/// or just below a thousandth of the range.
pub fn default_spacing(axis: &Axis) -> f64 {
    let range = (axis.last() - axis.first()).abs();
    if axis.coordinate != Coordinate::from(Parameter::ZetaK) || range < ZETA_K_SPACING {
        return round_below(range / 1000.0);
    }
    if range / ZETA_K_SPACING < MOST_VALUES as f64 {
        return ZETA_K_SPACING;
    }
    // there is always a round number between the least spacing and two and a half times this spacing
    round_below(2.5 * range / MOST_VALUES as f64)
}

/// The greatest of 1, 2, 5 times a power of ten that is no more than `most`.
fn round_below(most: f64) -> f64 {
    let exponent = most.log10().floor();
    let number = |factor: u8| format!("{factor}e{exponent}").parse().expect("it is a number");
    [5, 2, 1]
        .map(number)
        .into_iter()
        .find(|round| *round <= most * (1.0 + 1e-9))
        // where the logarithm was rounded up
        .unwrap_or(most)
}

/// How many values the fine grid has at most.
pub fn count(axis: &Axis, spacing: f64) -> f64 {
    let [low, high] = axis.ends();
    ((high - low) / spacing + TOLERANCE).floor() + 1.0
}

/// The spacing that was asked for, or the default for the axis.
///
/// # Errors
/// If the spacing gives fewer than two values, or too many, in the range of the axis.
pub fn checked_spacing(axis: &Axis, asked: Option<f64>) -> Result<f64, SpacingError> {
    let Some(spacing) = asked else {
        return Ok(default_spacing(axis));
    };
    let range = rounded((axis.last() - axis.first()).abs());
    let values = count(axis, spacing);
    // written so that NaN is refused; a spacing as large as the range gives two values
    if !(spacing > 0.0 && values >= 2.0) {
        return Err(SpacingError::Range { spacing, range });
    }
    if values > MOST_VALUES as f64 {
        return Err(SpacingError::TooFine {
            spacing,
            values,
            range,
            least: rounded(range / (MOST_VALUES - 1) as f64),
        });
    }
    Ok(spacing)
}

/// Why a spacing does not fit an axis.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum SpacingError {
    #[error("--onset-spacing {spacing} is out of range: it must be positive, and no more than the axis' range {range}")]
    Range { spacing: f64, range: f64 },
    #[error(
        "--onset-spacing {spacing:e} makes {values} values on the axis' range {range}, from each initial state (at most \
         {MOST_VALUES}): use {least:e} or more, or an axis with a smaller range"
    )]
    TooFine {
        spacing: f64,
        values: f64,
        range: f64,
        least: f64,
    },
}

/// Part of a spacing by which an end of the range may differ from a multiple that counts as equal to it.
const TOLERANCE: f64 = 1e-6;

/// The multiples of the spacing within the range of an axis, its ends included, in rising order.
///
/// # Panics
/// If there is no multiple in the range, which may happen if the spacing exceeds the range.
pub fn fine_axis(axis: &Axis, spacing: f64) -> Axis {
    let [low, high] = axis.ends();
    let first = (low / spacing - TOLERANCE).ceil();
    let last = (high / spacing + TOLERANCE).floor();
    assert!(first <= last, "no multiple of {spacing} from {low} to {high}");
    // multiples of a short decimal are short decimals; the floating-point product may differ in its last digits
    let multiple = |factor: f64| -> f64 { format!("{:.12e}", factor * spacing).parse().expect("it is a number") };
    let [start, stop] = [first, last].map(|factor| multiple(factor).clamp(low, high));
    Axis::fine(axis.coordinate, start, stop, (last - first) as usize + 1)
}

/// Checks a fine grid.
///
/// # Errors
/// If a machine is not valid at some value: it was checked at those of the axis, and not between them.
pub fn check_grid(at: &Fixed, fine: &Axis) -> Result<(), DesignError> {
    Design::product(vec![fine.clone()], *at).extents().map(|_| ())
}

/// Initial states (x, y) that are tried where a user chooses none.
pub const STARTS: [[f64; 2]; 3] = [[0.1, 0.0], [1.0, 0.0], [-1.0, 0.0]];

/// A value of the fine grid with chaos.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// In the unit of the axis.
    pub value: f64,
    /// The initial state (x, y) that leads to chaos there, the first of several.
    pub start: [f64; 2],
    /// The exponent over the definition's periods, per unit of tau.
    pub exponent: f64,
    /// Its standard error.
    pub error: f64,
    /// The measurement over [`CONFIRMING_PERIODS`].
    pub again: Measurement,
}

/// The result of a scan.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scanned {
    /// The first value with chaos in the direction of the scan.
    pub found: Option<Found>,
    /// Number of points, each a value and an initial state, that were passed before it.
    pub passed: usize,
    /// Of these, those that ran away or are under-resolved.
    pub unmeasured: usize,
}

/// The direction of a scan along the fine grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From the least value to the greatest.
    Up,
    /// From the greatest value to the least.
    Down,
}

/// What is scanned for chaos.
pub struct Scan<'a> {
    /// What counts as chaos.
    pub definition: &'a Definition,
    /// All that is not on the axis.
    pub at: &'a Fixed,
    /// The fine grid, as [`fine_axis`] makes it.
    pub axis: Axis,
    /// Initial states (x, y), tried at every value.
    pub starts: &'a [[f64; 2]],
}

/// A value of the fine grid and an initial state, by their indices.
#[derive(Clone, Copy)]
struct Point {
    value: usize,
    start: usize,
}

/// Where chaos begins or ends.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    /// The direction in which it was looked for.
    pub way: Way,
    /// What was found.
    pub scanned: Scanned,
    /// Whether the first value of the scan is already chaotic, so that the bound lies outside the fine grid.
    pub is_beyond: bool,
}

impl Scan<'_> {
    /// Onset and end: the first values with chaos from both ends of the axis. None if the observer broke it off.
    ///
    /// # Errors
    /// If the backend fails and no fall-back is left.
    pub fn bounds(
        &self,
        backends: &mut Backends,
        observer: &mut Observer<'_>,
    ) -> Result<Option<[Bound; 2]>, BackendError> {
        let Some(up) = self.first(Way::Up, backends, observer)? else {
            return Ok(None);
        };
        // without an onset there is no end
        let down = if up.found.is_some() {
            self.first(Way::Down, backends, observer)?
        } else {
            Some(up)
        };
        let bound = |way, scanned: Scanned, extreme: f64| Bound {
            way,
            scanned,
            is_beyond: scanned.found.is_some_and(|found| found.value == extreme),
        };
        Ok(down.map(|down| {
            [
                bound(Way::Up, up, self.axis.first()),
                bound(Way::Down, down, self.axis.last()),
            ]
        }))
    }

    /// The first value, going up or down, with chaos from some initial state. Chaos that does not last for [`CONFIRMING_PERIODS`]
    /// is passed over. None if the observer broke it off.
    ///
    /// # Errors
    /// If the backend fails and no fall-back is left.
    pub fn first(
        &self,
        way: Way,
        backends: &mut Backends,
        observer: &mut Observer<'_>,
    ) -> Result<Option<Scanned>, BackendError> {
        let mut order: Vec<usize> = (0..self.axis.count()).collect();
        if way == Way::Down {
            order.reverse();
        }
        let mut scanned = Scanned::default();
        for chunk in order.chunks(CHUNK) {
            let starts = 0..self.starts.len();
            let points: Vec<Point> = chunk
                .iter()
                .flat_map(|&value| starts.clone().map(move |start| Point { value, start }))
                .collect();
            let settings = &self.definition.settings;
            let Some(measured) = self.measure(&points, settings, backends, observer)? else {
                return Ok(None);
            };
            let Some(lasting) = self.first_lasting(&points, &measured, backends, observer)? else {
                return Ok(None);
            };
            let passed = lasting.map_or(points.len(), |(place, _)| place);
            scanned.passed += passed;
            scanned.unmeasured += measured[..passed].iter().filter(|m| m.status != Status::Ok).count();
            if let Some((place, again)) = lasting {
                scanned.found = Some(Found {
                    value: self.axis.value(points[place].value),
                    start: self.starts[points[place].start],
                    exponent: measured[place].lyapunov,
                    error: measured[place].lyapunov_error,
                    again,
                });
                break;
            }
        }
        Ok(Some(scanned))
    }

    /// The index of the first point with lasting chaos, and its measurement over the longer run. The outer None means that the
    /// observer broke it off.
    #[expect(clippy::option_option, reason = "broken off is not the same as nothing found")]
    fn first_lasting(
        &self,
        points: &[Point],
        measured: &[Measurement],
        backends: &mut Backends,
        observer: &mut Observer<'_>,
    ) -> Result<Option<Option<(usize, Measurement)>>, BackendError> {
        let longer = Settings {
            sampling: Sampling {
                periods: CONFIRMING_PERIODS,
                ..self.definition.settings.sampling
            },
            ..self.definition.settings
        };
        let candidates: Vec<usize> = (0..points.len())
            .filter(|&place| self.definition.is_chaos(&measured[place]))
            .collect();
        for places in candidates.chunks(CONFIRMED_TOGETHER) {
            let together: Vec<Point> = places.iter().map(|&place| points[place]).collect();
            let Some(again) = self.measure(&together, &longer, backends, observer)? else {
                return Ok(None);
            };
            let mut both = places.iter().copied().zip(again);
            if let Some(lasting) = both.find(|(_, again)| self.definition.is_confirmed(again)) {
                return Ok(Some(Some(lasting)));
            }
        }
        Ok(Some(None))
    }

    /// Measurements of points, in their order; None if the observer broke it off.
    fn measure(
        &self,
        points: &[Point],
        settings: &Settings,
        backends: &mut Backends,
        observer: &mut Observer<'_>,
    ) -> Result<Option<Vec<Measurement>>, BackendError> {
        let mut measured = vec![None; points.len()];
        for (start, &state) in self.starts.iter().enumerate() {
            let places: Vec<usize> = (0..points.len())
                .filter(|&place| points[place].start == start)
                .collect();
            let values: Vec<usize> = places.iter().map(|&place| points[place].value).collect();
            let design = Design::product(vec![self.axis.clone()], self.at.from_state(state));
            let Some(measurements) = backends.measure(&design, settings, &values, observer)? else {
                return Ok(None);
            };
            for (place, measurement) in places.into_iter().zip(measurements) {
                measured[place] = Some(measurement);
            }
        }
        Ok(Some(
            measured.into_iter().map(|m| m.expect("each has a start")).collect(),
        ))
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::backend::cpu::CpuBackend;
    use crate::engine::initial_states::offsets;
    use crate::experiment::Precision;
    use crate::parameters::ParameterSet;

    fn axis(text: &str) -> Axis {
        Axis::parse(text).unwrap()
    }

    #[test]
    fn spacings_are_round_whatever_the_axis_step() {
        for (text, expected) in [
            ("zeta_k=3:5:7", 0.0025),
            ("zeta_k=5:3:201", 0.0025),
            // too narrow, and too wide
            ("zeta_k=3.801:3.803:5", 2e-6),
            ("zeta_k=0:900:5", 0.02),
            ("h1=0:2:101", 0.002),
            ("h1=0:1.5:3", 0.001),
            ("b=0.2:0.9:3", 0.0005),
            ("epsilon_0=1e-9:2e-8:5", 1e-11),
        ] {
            let (axis, spacing) = (axis(text), default_spacing(&axis(text)));
            assert_eq!(spacing, expected, "{text}");
            assert!(count(&axis, spacing) <= MOST_VALUES as f64, "{text}");
        }
    }

    #[test]
    fn the_fine_grid_is_of_multiples_within_the_range() {
        for (text, spacing, ends, count) in [
            ("zeta_k=3:5:7", 0.0025, [3.0, 5.0], 801),
            ("zeta_k=5:3:7", 0.0025, [3.0, 5.0], 801),
            ("zeta_k=3.001:3.009:2", 0.0025, [3.0025, 3.0075], 3),
            ("zeta_k=3.8025:3.805:2", 0.0025, [3.8025, 3.805], 2),
            ("h1=0.1:0.3:5", 0.2, [0.2, 0.2], 1),
        ] {
            let fine = fine_axis(&axis(text), spacing);
            assert_eq!(([fine.first(), fine.last()], fine.count()), (ends, count), "{text}");
        }
        // multiples are short decimals, bit for bit, whatever the range
        let value = fine_axis(&axis("zeta_k=0:12:2"), 0.0025).value(1521);
        assert_eq!(
            (value, fine_axis(&axis("zeta_k=3:5:2"), 0.0025).value(321)),
            (3.8025, 3.8025)
        );
    }

    /// A scan of a few values.
    fn scan<'a>(
        definition: &'a Definition,
        at: &'a Fixed,
        axis: &str,
        spacing: f64,
        starts: &'a [[f64; 2]],
    ) -> Scan<'a> {
        Scan {
            definition,
            at,
            axis: fine_axis(&Axis::parse(axis).unwrap(), spacing),
            starts,
        }
    }

    fn parts() -> (Definition, Fixed, Backends) {
        let at = ParameterSet::default().with(Parameter::ZetaK, 3.9).into();
        let backends = Backends::new(Box::new(CpuBackend::new(Precision::F64)), None);
        (Definition::new(&Settings::default()), at, backends)
    }

    #[test]
    fn the_first_value_with_chaos_is_found_with_its_initial_state() {
        let (definition, at, mut backends) = parts();
        let starts = [[0.1, 0.0], [1.0, 0.0]];
        let mut first = |axis, spacing, way| {
            let carry_on = &mut |_: crate::engine::Event<'_>| ControlFlow::Continue(());
            let scan = scan(&definition, &at, axis, spacing, &starts);
            scan.first(way, &mut backends, carry_on).unwrap().unwrap()
        };
        let up = first("zeta_k=3.79:3.9:2", 0.0025, Way::Up);
        let found = up.found.unwrap();
        assert_eq!((found.value, found.start), (3.8025, [1.0, 0.0]));
        // five values from two states, and the first state at the sixth
        assert_eq!((up.passed, up.unmeasured), (11, 0));
        assert!(found.again.lyapunov_error < 0.5 * found.error);
        let down = first("h1=0.5:0.64:2", 0.02, Way::Down);
        assert_eq!(down.found.unwrap().value, 0.6);
    }

    /// Beyond the boundary of its attractor, chaos lasts for some hundreds of periods. In a measurement over a hundred periods,
    /// some of many initial states still show chaos.
    #[test]
    fn chaos_that_ends_is_passed() {
        let (definition, at, mut backends) = parts();
        let starts = offsets(&Sampling {
            initial_states: 65,
            ..Sampling::default()
        });
        let scan = scan(&definition, &at, "h1=-0.015:-0.01:2", 0.015, &starts);
        let carry_on = &mut |_: crate::engine::Event<'_>| ControlFlow::Continue(());
        let points: Vec<Point> = (0..starts.len()).map(|start| Point { value: 0, start }).collect();
        let brief = scan.measure(&points, &definition.settings, &mut backends, carry_on);
        assert!(brief.unwrap().unwrap().iter().any(|m| definition.is_chaos(m)));
        let scanned = scan.first(Way::Up, &mut backends, carry_on).unwrap().unwrap();
        assert!(scanned.found.is_none() && scanned.passed == 64, "{scanned:?}");
    }

    #[test]
    fn a_scan_is_broken_off() {
        let (definition, at, mut backends) = parts();
        let scan = scan(&definition, &at, "zeta_k=3:5:2", 0.5, &[[0.1, 0.0]]);
        let stop = &mut |_: crate::engine::Event<'_>| ControlFlow::Break(());
        assert!(scan.first(Way::Down, &mut backends, stop).unwrap().is_none());
    }
}
