//! The shaders as they are compiled, one a scheme: pieces put together, and the constants taken from the host.
//!
//! Owns which pieces there are and in what order; knows nothing of devices.

use crate::dynamics::divergence_check::CHECKED_EVERY;
use crate::dynamics::stroboscope::MAX_PERIOD;
use crate::dynamics::tangent::SMALLEST_SQUARE;
use crate::experiment::Scheme;
use crate::measurement::RUNAWAY_BOUND;

/// The shader of a scheme.
#[derive(Clone, Copy, Debug)]
pub struct Shader {
    /// Name, below `shaders/`, and text of every piece.
    pub pieces: &'static [(&'static str, &'static str)],
    /// The pieces in one text.
    pub source: &'static str,
}

macro_rules! shader {
    ($shader:ident: $($name:literal)*) => {
        static $shader: Shader = Shader {
            pieces: &[$(($name, include_str!(concat!("../../../shaders/", $name)))),*],
            source: concat!($(include_str!(concat!("../../../shaders/", $name)), "\n"),*),
        };
    };
}

shader! {
    RK4:
    "shared/span.wgsl"
    "shared/bindings.wgsl"
    "shared/runaway.wgsl"
    "model/friction.wgsl"
    "model/motion.wgsl"
    "dynamics/tangent.wgsl"
    "dynamics/divergence_check.wgsl"
    "dynamics/rk4.wgsl"
    "dynamics/stroboscope.wgsl"
    "kernels/rk4_plain.wgsl"
    "kernels/rk4_tangent.wgsl"
}

shader! {
    TAYLOR:
    "shared/span.wgsl"
    "shared/bindings.wgsl"
    "shared/runaway.wgsl"
    "model/friction.wgsl"
    "model/motion.wgsl"
    "dynamics/tangent.wgsl"
    "dynamics/divergence_check.wgsl"
    "generated/taylor.wgsl"
    "dynamics/taylor.wgsl"
    "dynamics/taylor/growth.wgsl"
    "dynamics/stroboscope.wgsl"
    "kernels/taylor_plain.wgsl"
    "kernels/taylor_tangent.wgsl"
}

impl Shader {
    /// The shader of a scheme; None if it has no kernels on a GPU.
    pub fn of(scheme: Scheme) -> Option<&'static Self> {
        match scheme {
            Scheme::Rk4 => Some(&RK4),
            Scheme::Taylor => Some(&TAYLOR),
            Scheme::Radau => None,
        }
    }

    /// Every scheme's.
    pub fn all() -> impl Iterator<Item = (Scheme, &'static Self)> {
        Scheme::ALL
            .into_iter()
            .filter_map(|scheme| Some((scheme, Self::of(scheme)?)))
    }
}

/// A kernel of a scheme's shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// The motion alone.
    Plain,
    /// Motion and a tangent vector.
    Tangent,
    /// Motion and both tangent vectors, through checked periods.
    Checked,
}

impl Kernel {
    pub const ALL: [Self; 3] = [Self::Plain, Self::Tangent, Self::Checked];

    pub fn entry_point(self) -> &'static str {
        match self {
            Self::Plain => "advance_plain",
            Self::Tangent | Self::Checked => "advance_tangent",
        }
    }

    /// Values of the shader's `override` constants, so that each is defined in one place.
    pub fn constants(self, workgroup_size: u32) -> [(&'static str, f64); 6] {
        [
            ("WORKGROUP_SIZE", f64::from(workgroup_size)),
            ("RUNAWAY_BOUND", RUNAWAY_BOUND),
            ("SMALLEST_SQUARE", SMALLEST_SQUARE),
            ("MAX_PERIOD", MAX_PERIOD as f64),
            ("CHECKED_EVERY", f64::from(CHECKED_EVERY)),
            ("IS_CHECKED", f64::from(u8::from(self == Self::Checked))),
        ]
    }
}
