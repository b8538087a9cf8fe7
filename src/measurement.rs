//! What is measured of one instance, how it is classified, and the table of quantities.
//!
//! Owns the meaning of every number that leaves the program; knows nothing of how it was integrated or is stored.

use serde::{Deserialize, Serialize};

use crate::machine::Scale;
pub use crate::model::motion::RUNAWAY_BOUND;

/// How the integration of an instance ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Status {
    Ok,
    /// The state became non-finite, or left |x| + |y| < [`RUNAWAY_BOUND`], or the thermal pressure reached
    /// [`PRESSURE_BOUND`](crate::dynamics::adaptive::PRESSURE_BOUND).
    Runaway {
        /// The end of the forcing period in which it happened, in units of tau from the start of the run.
        time: f64,
    },
    /// The sum of the exponents misses the mean divergence by more than [`DEFECT_BOUND`], a number overflowed, or the
    /// scheme gave up: the step, or the interval between renormalisations, is too long for the stiffness met.
    UnderResolved,
}

/// Largest difference between the sum of the exponents and the mean divergence, relative to that...
pub const DEFECT_BOUND: f64 = 1e-2;

/// ...or, where there is hardly any, per unit of tau: f32 leaves as much.
pub const DEFECT_FLOOR: f64 = 1e-3;

/// A scheme's share in an error is not worth a word below this, per unit of tau.
const SCHEME_FLOOR: f64 = 1e-3;

/// Whether most of an exponent's error is the scheme's, and more than [`SCHEME_FLOOR`].
pub fn is_scheme_to_blame(scheme_error: f64, error: f64) -> bool {
    scheme_error > SCHEME_FLOOR.max(0.5 * error)
}

/// The kind of motion; [`Class::of`] defines it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    Chaotic,
    Regular,
    QuasiPeriodic,
    Undecided,
    /// On a cycle, or at rest, where it stays although disturbances grow: no attractor.
    Unstable,
}

/// Where and in which number type an instance was integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BackendKind {
    CpuF64,
    CpuF32,
    GpuF32,
}

/// The weighted Birkhoff average of a quasi-periodic orbit's exponent lies within this of zero...
pub const QUASI_PERIODIC_BOUND: f64 = 1e-3;

/// ...and its standard error below this. The growth along such an orbit only swings, so that its mean converges fast;
/// where it does not, an average near zero is chance.
pub const QUASI_PERIODIC_ERROR: f64 = 5e-3;

/// A standard error below this means the same growth in every period: the orbit is on its cycle. Where the growth is
/// positive it began on an unstable cycle and never left it, which is neither chaos nor an attractor.
pub const CONSTANT_GROWTH: f64 = 1e-6;

/// Over the measurement of a chaotic orbit a disturbance grows at least by e to this power. A mean growth that is less, however
/// steady, cannot be told from the slow convergence of an orbit on the line of a bifurcation.
pub const CHAOTIC_GROWTH: f64 = 1.0;

/// The cycle on which an orbit was found at the end of its run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle {
    /// In forcing periods.
    pub period: u32,
    /// Growth rate of the tangent vector along the cycle: negative if it attracts.
    pub growth_rate: f64,
}

impl Class {
    pub const ALL: [Self; 5] = [
        Self::Chaotic,
        Self::Regular,
        Self::QuasiPeriodic,
        Self::Undecided,
        Self::Unstable,
    ];

    /// Classifies an orbit by its maximal exponent `lyapunov` with standard error `error`, taken over `interval`, the cycle
    /// found at its end, and the weighted Birkhoff average of the exponent. In this order:
    ///
    /// - regular: settled on a cycle that attracts (a chaotic transient may have come before);
    /// - unstable: on a cycle along which disturbances grow, at the same rate in every period;
    /// - chaotic: `lyapunov - 3 error > 0`, and `lyapunov interval >` [`CHAOTIC_GROWTH`];
    /// - regular: `lyapunov + 3 error < 0`, or on a cycle with `lyapunov` not above 0;
    /// - quasi-periodic: `|birkhoff| <` [`QUASI_PERIODIC_BOUND`] and `error <` [`QUASI_PERIODIC_ERROR`];
    /// - undecided: all else.
    pub fn of(lyapunov: f64, error: f64, interval: f64, cycle: Option<Cycle>, birkhoff: f64) -> Self {
        // a laminar phase of chaos can pass for a cycle, but does not attract
        let is_constant = error < CONSTANT_GROWTH;
        if cycle.is_some_and(|cycle| cycle.growth_rate < 0.0) {
            Self::Regular
        } else if cycle.is_some_and(|cycle| is_constant && cycle.growth_rate > QUASI_PERIODIC_BOUND) {
            Self::Unstable
        } else if lyapunov - 3.0 * error > 0.0 && lyapunov * interval > CHAOTIC_GROWTH {
            Self::Chaotic
        } else if lyapunov + 3.0 * error < 0.0 || (cycle.is_some() && lyapunov <= 0.0) {
            Self::Regular
        } else if cycle.is_none() && birkhoff.abs() < QUASI_PERIODIC_BOUND && error < QUASI_PERIODIC_ERROR {
            Self::QuasiPeriodic
        } else {
            Self::Undecided
        }
    }

    pub fn name(self) -> &'static str {
        CLASS_NAMES[self as usize]
    }
}

const CONTACT_NAMES: &[&str] = &["held", "lost"];
const CLASS_NAMES: &[&str] = &["chaotic", "regular", "quasi_periodic", "undecided", "unstable"];
const STATUS_NAMES: &[&str] = &["ok", "runaway", "under_resolved"];
const BACKEND_NAMES: &[&str] = &["cpu_f64", "cpu_f32", "gpu_f32"];

impl Status {
    pub fn name(self) -> &'static str {
        STATUS_NAMES[self.code() as usize]
    }

    fn code(self) -> u8 {
        match self {
            Self::Ok => 0,
            Self::Runaway { .. } => 1,
            Self::UnderResolved => 2,
        }
    }
}

impl BackendKind {
    pub fn name(self) -> &'static str {
        BACKEND_NAMES[self as usize]
    }

    /// Spacing of the number type above 1.
    pub fn epsilon(self) -> f64 {
        match self {
            Self::CpuF64 => f64::EPSILON,
            Self::CpuF32 | Self::GpuF32 => f32::EPSILON.into(),
        }
    }

    pub fn device_class(self) -> &'static str {
        match self {
            Self::CpuF64 | Self::CpuF32 => "cpu",
            Self::GpuF32 => "gpu",
        }
    }

    pub fn precision(self) -> &'static str {
        match self {
            Self::CpuF64 => "f64",
            Self::CpuF32 | Self::GpuF32 => "f32",
        }
    }
}

/// What a run has shown of the contact between bush and shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// tau_c, when the pressure first fell to 0; None where contact held to the end of the run.
    pub lost: Option<f64>,
    pub peak_pressure: f64,
    /// When, in tau from the start of the run.
    pub peak_pressure_time: f64,
    /// u_w at the end of the run.
    pub final_wear: f64,
    /// Greatest temperature theta(1, tau) of the shaft's surface.
    pub peak_temperature: f64,
}

impl Contact {
    /// A contact that neither heats nor wears.
    pub const CONSTANT: Self = Self {
        lost: None,
        peak_pressure: 1.0,
        peak_pressure_time: 0.0,
        final_wear: 0.0,
        peak_temperature: 0.0,
    };

    /// Nothing is known of it.
    const UNKNOWN: Self = Self {
        lost: None,
        peak_pressure: f64::NAN,
        peak_pressure_time: f64::NAN,
        final_wear: f64::NAN,
        peak_temperature: f64::NAN,
    };

    /// `held` or `lost`.
    pub fn status_name(&self) -> &'static str {
        CONTACT_NAMES[usize::from(self.lost.is_some())]
    }
}

/// What is measured of one point. Numbers are NaN where they do not apply: where the orbit ran away, and but for the
/// contact's where it is under-resolved.
#[derive(Clone, Copy, Debug)]
pub struct Measurement {
    pub status: Status,
    /// None unless the status is ok and the motion lasts: where the contact wears, all motion is transient.
    pub class: Option<Class>,
    /// Maximal exponent, the larger of the two non-trivial ones, per unit of tau. With wear it is one of finite time: the
    /// growth of sqrt(X^2 + Y^2) from (X, Y, rest) = (1, 0, 0), from the start until contact is lost, or to the end.
    pub lyapunov: f64,
    /// Its standard error, by batch means, and the scheme's share; NaN for an exponent of finite time.
    pub lyapunov_error: f64,
    /// The scheme's share in it: ten times what the sum of the exponents misses of the divergence, rounding, and by how much the exponent
    /// misses that of a finer scheme. NaN where nothing is known of it: with heat where the motion is on no cycle, and with wear.
    pub scheme_error: f64,
    /// The smaller of the two non-trivial exponents; equal to the maximal one where the tangent vectors rotate. NaN with
    /// heat or wear, whose tangent space has more dimensions, and on a limit cycle without a drive, where it is the trivial
    /// zero along the flow that is left out.
    pub lyapunov_second: f64,
    /// Its standard error, by batch means.
    pub lyapunov_second_error: f64,
    /// Mean divergence of the flow, which the sum of the two exponents equals. NaN with heat or wear.
    pub divergence: f64,
    /// Weighted Birkhoff average of the maximal exponent; NaN for an exponent of finite time.
    pub lyapunov_birkhoff: f64,
    /// Length of the interval over which the exponent is taken, in tau.
    pub lyapunov_interval: f64,
    /// Least number of forcing periods after which the motion repeats; None unless settled on a cycle that attracts
    /// strongly enough for the run to have reached it.
    pub period: Option<u32>,
    /// Last stroboscopic state, at drive phase 0.
    pub x: f64,
    pub y: f64,
    /// Extremes of x over the measured periods.
    pub x_min: f64,
    pub x_max: f64,
    /// Fraction of the initial states whose motion is chaotic.
    pub chaotic_fraction: f64,
    /// Number of distinct attractors on which initial states have settled.
    pub attractors: u32,
    /// Fraction of the initial states whose motion is bounded but has settled on no attractor.
    pub unsettled_fraction: f64,
    pub contact: Contact,
    pub backend: BackendKind,
    /// Where the orbit began: (x0, y0).
    pub initial_state: [f64; 2],
    /// Forcing periods that were integrated for the point, of all its initial states.
    pub integrated_periods: u32,
}

impl Measurement {
    /// The measurement of an orbit that ran away at `time`.
    pub fn runaway(time: f64, backend: BackendKind) -> Self {
        Self::unmeasured(Status::Runaway { time }, backend)
    }

    /// The measurement of an orbit of which nothing is known.
    pub fn unmeasured(status: Status, backend: BackendKind) -> Self {
        Self {
            status,
            class: None,
            lyapunov: f64::NAN,
            lyapunov_error: f64::NAN,
            scheme_error: f64::NAN,
            lyapunov_second: f64::NAN,
            lyapunov_second_error: f64::NAN,
            divergence: f64::NAN,
            lyapunov_birkhoff: f64::NAN,
            lyapunov_interval: f64::NAN,
            period: None,
            x: f64::NAN,
            y: f64::NAN,
            x_min: f64::NAN,
            x_max: f64::NAN,
            chaotic_fraction: 0.0,
            attractors: 0,
            unsettled_fraction: 0.0,
            contact: Contact::UNKNOWN,
            backend,
            initial_state: [f64::NAN; 2],
            integrated_periods: 0,
        }
    }

    /// Whether it is that of a limit cycle, without a drive, whose one exponent is the mean divergence.
    pub fn is_on_limit_cycle(&self) -> bool {
        self.lyapunov_second.is_nan() && self.lyapunov == self.divergence
    }

    /// Whether the orbit has shown where it ends: on a cycle that was found, or on chaos or a torus for as long as it was
    /// measured. Without a found cycle a regular orbit is still on its way.
    pub fn has_settled(&self) -> bool {
        match self.class {
            Some(Class::Regular) => self.period.is_some() || self.is_on_limit_cycle(),
            Some(Class::Chaotic | Class::QuasiPeriodic) => true,
            Some(Class::Undecided | Class::Unstable) | None => false,
        }
    }

    /// Difference between the sum of the exponents and the mean divergence: the program's check of itself. NaN with heat
    /// or wear.
    pub fn divergence_defect(&self) -> f64 {
        self.lyapunov + self.lyapunov_second - self.divergence
    }
}

/// A quantity that a map holds for every point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    Lyapunov,
    LyapunovError,
    SchemeError,
    LyapunovSecond,
    Divergence,
    LyapunovBirkhoff,
    LyapunovInterval,
    Period,
    X,
    Y,
    XMin,
    XMax,
    ChaoticFraction,
    Attractors,
    UnsettledFraction,
    ContactStatus,
    ContactTime,
    PeakPressure,
    PeakPressureTime,
    FinalWear,
    PeakTemperature,
    RunawayTime,
    IntegratedPeriods,
    Class,
    Status,
    Backend,
}

/// How a quantity's values are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// A number; NaN where it does not apply.
    Number,
    /// An index into these names; NaN where it does not apply.
    Code(&'static [&'static str]),
}

/// What the table says of one quantity.
#[derive(Clone, Copy, Debug)]
pub struct QuantityInfo {
    pub quantity: Quantity,
    pub name: &'static str,
    /// For axes and colour bars.
    pub label: &'static str,
    pub units: &'static str,
    pub values: Values,
}

macro_rules! quantity_table {
    ($($quantity:ident $name:literal $label:literal $units:literal $values:expr;)*) => {
        /// Every quantity, in the order of [`Quantity`].
        pub const QUANTITIES: &[QuantityInfo] = &[$(QuantityInfo {
            quantity: Quantity::$quantity, name: $name, label: $label, units: $units, values: $values,
        }),*];
    };
}

quantity_table! {
    Lyapunov         "lyapunov"          "maximal Lyapunov exponent λ₁"            "1/tau" Values::Number;
    LyapunovError    "lyapunov_error"    "standard error of λ₁"                    "1/tau" Values::Number;
    SchemeError      "scheme_error"      "scheme's share in the error of λ₁"       "1/tau" Values::Number;
    LyapunovSecond   "lyapunov_second"   "second Lyapunov exponent λ₂"             "1/tau" Values::Number;
    Divergence       "divergence"        "mean divergence"                         "1/tau" Values::Number;
    LyapunovBirkhoff "lyapunov_birkhoff" "weighted Birkhoff average of λ₁"         "1/tau" Values::Number;
    LyapunovInterval "lyapunov_interval" "interval over which λ₁ is taken"         "tau"   Values::Number;
    Period           "period"            "period of the motion / forcing period"   "1"     Values::Number;
    X                "x"                 "last stroboscopic angle x"               "1"     Values::Number;
    Y                "y"                 "last stroboscopic angular speed y"       "1"     Values::Number;
    XMin             "x_min"             "least angle x"                           "1"     Values::Number;
    XMax             "x_max"             "greatest angle x"                        "1"     Values::Number;
    ChaoticFraction  "chaotic_fraction"  "fraction of initial states with chaos"   "1"     Values::Number;
    Attractors       "attractors"        "number of distinct attractors"           "1"     Values::Number;
    UnsettledFraction "unsettled_fraction" "fraction of initial states not settled" "1"    Values::Number;
    ContactStatus    "contact_status"    "whether contact is lost"                 "1"     Values::Code(CONTACT_NAMES);
    ContactTime      "contact_time"      "time at which contact is lost"           "tau"   Values::Number;
    PeakPressure     "peak_pressure"     "greatest contact pressure p"             "1"     Values::Number;
    PeakPressureTime "peak_pressure_time" "time of the greatest pressure"          "tau"   Values::Number;
    FinalWear        "final_wear"        "wear at the end of the run"              "1"     Values::Number;
    PeakTemperature  "peak_temperature"  "greatest surface temperature θ(1, τ)"    "1"     Values::Number;
    RunawayTime      "runaway_time"      "time of runaway"                         "tau"   Values::Number;
    IntegratedPeriods "integrated_periods" "forcing periods integrated"            "1"     Values::Number;
    Class            "class"             "kind of motion"                          "1"     Values::Code(CLASS_NAMES);
    Status           "status"            "how the integration ended"               "1"     Values::Code(STATUS_NAMES);
    Backend          "backend"           "where the point was integrated"          "1"     Values::Code(BACKEND_NAMES);
}

impl Quantity {
    pub const COUNT: usize = QUANTITIES.len();

    /// What leads from the quantity to one in SI units, of quantities that a machine gives a dimension.
    pub fn scale(self) -> Option<Scale> {
        match self {
            Self::ContactTime | Self::PeakPressureTime | Self::RunawayTime | Self::LyapunovInterval => {
                Some(Scale::Time)
            }
            Self::PeakPressure => Some(Scale::Pressure),
            Self::FinalWear => Some(Scale::Length),
            Self::PeakTemperature => Some(Scale::Temperature),
            _ => None,
        }
    }

    /// Whether it is taken per unit of tau, as exponents are.
    pub fn is_rate(self) -> bool {
        self.info().units == "1/tau"
    }

    /// For axes and colour bars in SI units.
    pub fn si_label(self) -> &'static str {
        match self {
            Self::PeakPressure => "greatest contact pressure P",
            Self::PeakTemperature => "greatest rise of the surface temperature, T − T₀",
            _ => self.info().label,
        }
    }

    /// What a map of instances that wear, or that do not, is drawn of unless asked otherwise.
    pub fn drawn(wears: bool) -> &'static [Self] {
        if wears {
            &[Self::Lyapunov, Self::ContactTime, Self::FinalWear]
        } else {
            &[Self::Lyapunov, Self::Period]
        }
    }

    /// The quantity's row of the table.
    pub fn info(self) -> &'static QuantityInfo {
        &QUANTITIES[self as usize]
    }

    /// The quantity's value in a measurement; codes are indices into their names.
    pub fn of(self, measurement: &Measurement) -> f64 {
        let m = measurement;
        match self {
            Self::Lyapunov => m.lyapunov,
            Self::LyapunovError => m.lyapunov_error,
            Self::SchemeError => m.scheme_error,
            Self::LyapunovSecond => m.lyapunov_second,
            Self::Divergence => m.divergence,
            Self::LyapunovBirkhoff => m.lyapunov_birkhoff,
            Self::LyapunovInterval => m.lyapunov_interval,
            Self::Period => m.period.map_or(f64::NAN, f64::from),
            Self::X => m.x,
            Self::Y => m.y,
            Self::XMin => m.x_min,
            Self::XMax => m.x_max,
            Self::ChaoticFraction => m.chaotic_fraction,
            Self::Attractors => f64::from(m.attractors),
            Self::UnsettledFraction => m.unsettled_fraction,
            Self::ContactStatus => match m.status {
                Status::Runaway { .. } => f64::NAN,
                Status::Ok | Status::UnderResolved => f64::from(u8::from(m.contact.lost.is_some())),
            },
            Self::ContactTime => m.contact.lost.unwrap_or(f64::NAN),
            Self::PeakPressure => m.contact.peak_pressure,
            Self::PeakPressureTime => m.contact.peak_pressure_time,
            Self::FinalWear => m.contact.final_wear,
            Self::PeakTemperature => m.contact.peak_temperature,
            Self::RunawayTime => match m.status {
                Status::Runaway { time } => time,
                Status::Ok | Status::UnderResolved => f64::NAN,
            },
            Self::IntegratedPeriods => f64::from(m.integrated_periods),
            Self::Class => m.class.map_or(f64::NAN, |class| f64::from(class as u8)),
            Self::Status => f64::from(m.status.code()),
            Self::Backend => f64::from(m.backend as u8),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_in_the_order_of_their_enums() {
        for (index, info) in QUANTITIES.iter().enumerate() {
            assert_eq!(info.quantity as usize, index);
            assert_eq!(serde_json::to_value(info.quantity).unwrap(), info.name);
        }
        for class in Class::ALL {
            assert_eq!(serde_json::to_value(class).unwrap(), class.name());
        }
        for backend in [BackendKind::CpuF64, BackendKind::CpuF32, BackendKind::GpuF32] {
            assert_eq!(serde_json::to_value(backend).unwrap(), backend.name());
        }
    }

    #[test]
    fn classes_follow_their_definition() {
        let cycle = |growth_rate| Some(Cycle { period: 3, growth_rate });
        assert_eq!(Class::of(0.1, 0.01, 800.0, None, 0.1), Class::Chaotic);
        assert_eq!(
            Class::of(0.1, 0.01, 800.0, cycle(0.02), 0.1),
            Class::Chaotic,
            "laminar phase"
        );
        assert_eq!(
            Class::of(0.1, 0.01, 800.0, cycle(-0.2), 0.1),
            Class::Regular,
            "after a chaotic transient"
        );
        assert_eq!(
            Class::of(1.0, 0.0, 800.0, cycle(1.0), 1.0),
            Class::Unstable,
            "equilibrium that is never left"
        );
        assert_eq!(Class::of(-0.1, 0.01, 800.0, None, -0.1), Class::Regular);
        assert_eq!(Class::of(-0.001, 0.01, 800.0, cycle(0.001), -0.001), Class::Regular);
        assert_eq!(Class::of(1e-4, 1e-3, 800.0, None, 9e-4), Class::QuasiPeriodic);
        assert_eq!(
            Class::of(1e-4, 1e-2, 800.0, None, 9e-4),
            Class::Undecided,
            "an average near zero by chance"
        );
        assert_eq!(Class::of(0.01, 0.01, 800.0, None, 0.01), Class::Undecided);
        assert_eq!(
            Class::of(5e-4, 1e-5, 800.0, cycle(5e-4), 5e-4),
            Class::Undecided,
            "no regular motion has a positive exponent"
        );
    }
}
