//! What the program says of a point, held against the reference.
//!
//! Owns the verdicts:
//!
//! - **agreeing**: the exponent L differs by at most 3 sqrt(stated error^2 + reference's error^2) + 1e-4 max(1, |L|); or both ran
//!   away, at times that differ by at most 1e-3, and by what an error of the state of 1e-6 (f32: 1e-4) moves that time by, from
//!   those at which |x| + |y| was within a thousandth of the bound. The reference starts where the program does. Where that does
//!   not agree it starts from the program's last stroboscopic state: different attractors may be a tiny difference apart. Where
//!   chaos may be transient, the program runs on for 3000 + 1000 periods, and the reference from there;
//! - **refused**: status under-resolved;
//! - **turned away**: the backend does not take the point, and says so with an error before it begins;
//! - **undecided**: class undecided, whatever its exponent; or a runaway after the program's run had ended;
//! - **wrong**: all else;
//! - **unknown**: the reference itself gave up.

use tribochaos::backend::{Backend, BackendKind};
use tribochaos::experiment::{Sampling, Settings};
use tribochaos::measure::{Class, Measurement, Status};
use tribochaos::parameters::{Parameter, ParameterSet};

use super::attractor::{Effort, Truth, follow};
use super::common::measure_on;
use super::points;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    Agreeing,
    Refused,
    TurnedAway,
    Undecided,
    Wrong,
    Unknown,
}

impl Verdict {
    pub const ALL: [Self; 6] = [
        Self::Agreeing,
        Self::Refused,
        Self::TurnedAway,
        Self::Undecided,
        Self::Wrong,
        Self::Unknown,
    ];
}

/// Where the program's motion went on from.
#[derive(Clone, Copy)]
enum From {
    Start,
    LastState,
}

/// The reference's result for a point, from its initial state.
pub fn truth(point: &ParameterSet) -> Truth {
    truth_within(point, Effort::USUAL.tolerance)
}

fn truth_within(point: &ParameterSet, tolerance: f64) -> Truth {
    follow(
        &points::bush(point),
        [point[Parameter::X0], point[Parameter::Y0]],
        &Effort {
            tolerance,
            ..Effort::USUAL
        },
    )
}

/// The reference's tolerance where it and the program differ: it has to stand by its result.
const DISPUTED: f64 = 1e-9;

/// The verdict on a measurement, and the result of the reference that decided it.
pub fn judge(
    backend: &mut dyn Backend,
    settings: &Settings,
    point: &ParameterSet,
    m: &Measurement,
    truth: &Truth,
) -> (Verdict, Truth) {
    let mut truth = *truth;
    let mut first = compare(settings, point, m, &truth, From::Start);
    if first == Verdict::Wrong {
        truth = truth_within(point, DISPUTED);
        first = compare(settings, point, m, &truth, From::Start);
    }
    // a runaway that was missed, unless it is chaos that decides about it
    let certain = matches!(truth, Truth::Runaway { sensitivity, .. } if error_of_state(m) * sensitivity < 1.0);
    if first != Verdict::Wrong || m.status != Status::Ok || certain {
        return (first, truth);
    }
    let from = |m: &Measurement| follow(&points::bush(point), [m.x, m.y], &Effort::USUAL);
    let there = from(m);
    let second = compare(settings, point, m, &there, From::LastState);
    if second != Verdict::Wrong {
        return (second, there);
    }
    if !may_be_transient(m, &truth) && !may_be_transient(m, &there) {
        return (Verdict::Wrong, there);
    }
    let settings = Settings {
        sampling: Sampling {
            transient_periods: 3000,
            periods: 1000,
            decide_early: false,
            ..settings.sampling
        },
        ..*settings
    };
    let later = measure_on(backend, &settings, &[*point])[0];
    if later.status != Status::Ok {
        return (compare(&settings, point, &later, &truth, From::Start), truth);
    }
    let there = from(&later);
    (compare(&settings, point, &later, &there, From::LastState), there)
}

fn may_be_transient(m: &Measurement, truth: &Truth) -> bool {
    let late = match truth {
        Truth::Mean { .. } => true,
        Truth::Cycle { settled, .. } => *settled > 64,
        Truth::Runaway { .. } | Truth::GivenUp => false,
    };
    late || m.class == Some(Class::Chaotic)
}

/// The error of a state that a run may have come to.
fn error_of_state(m: &Measurement) -> f64 {
    if m.backend == BackendKind::CpuF64 { 1e-6 } else { 1e-4 }
}

fn compare(settings: &Settings, point: &ParameterSet, m: &Measurement, truth: &Truth, from: From) -> Verdict {
    let run = settings.sampling.transient_periods + settings.sampling.periods;
    // periods that were integrated for it include looks at cycles, and other schemes
    let ran = f64::from(m.integrated_periods.min(run)) * point.forcing_period();
    match (m.status, *truth) {
        (Status::UnderResolved, _) => Verdict::Refused,
        (_, Truth::GivenUp) => Verdict::Unknown,
        (Status::Runaway { time: said }, Truth::Runaway { times, sensitivity }) => {
            let within = 1e-3 + error_of_state(m) * sensitivity;
            agreeing((times.earliest - within..=times.latest + within).contains(&said))
        }
        (Status::Runaway { .. }, _) => Verdict::Wrong,
        (Status::Ok, Truth::Runaway { times, .. }) => match from {
            From::Start if times.time <= ran => Verdict::Wrong,
            From::Start | From::LastState => Verdict::Undecided,
        },
        (Status::Ok, Truth::Cycle { lyapunov, error, .. } | Truth::Mean { lyapunov, error, .. }) => {
            if m.class == Some(Class::Undecided) {
                return Verdict::Undecided;
            }
            // an error that is NaN agrees with nothing
            let allowed = 3.0 * m.lyapunov_error.hypot(error) + 1e-4 * lyapunov.abs().max(1.0);
            agreeing((m.lyapunov - lyapunov).abs() <= allowed)
        }
    }
}

fn agreeing(is: bool) -> Verdict {
    if is { Verdict::Agreeing } else { Verdict::Wrong }
}
