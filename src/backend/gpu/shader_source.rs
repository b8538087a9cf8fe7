//! The shader as it is compiled: its pieces put together, and the constants that it takes from the host.
//!
//! Owns which pieces there are and in what order; knows nothing of devices.

use crate::dynamics::stroboscope::MAX_PERIOD;
use crate::dynamics::tangent::SMALLEST_SQUARE;
use crate::measurement::RUNAWAY_BOUND;

macro_rules! pieces {
    ($($name:literal)*) => {
        /// Name, below `shaders/`, and text of every piece.
        pub const PIECES: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../../shaders/", $name)))),*];

        /// The pieces in one text.
        pub const SOURCE: &str = concat!($(include_str!(concat!("../../../shaders/", $name)), "\n"),*);
    };
}

pieces! {
    "shared/bindings.wgsl"
    "shared/runaway.wgsl"
    "model/friction.wgsl"
    "model/motion.wgsl"
    "dynamics/tangent.wgsl"
    "dynamics/rk4.wgsl"
    "dynamics/stroboscope.wgsl"
    "kernels/advance_plain.wgsl"
    "kernels/advance_tangent.wgsl"
}

/// A kernel of [`SOURCE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// The motion alone.
    Plain,
    /// Motion and tangent vectors.
    Tangent,
}

impl Kernel {
    pub const ALL: [Self; 2] = [Self::Plain, Self::Tangent];

    pub fn entry_point(self) -> &'static str {
        match self {
            Self::Plain => "advance_plain",
            Self::Tangent => "advance_tangent",
        }
    }
}

/// Values of the shader's `override` constants, so that each is defined in one place.
pub fn constants(workgroup_size: u32) -> [(&'static str, f64); 4] {
    [
        ("WORKGROUP_SIZE", f64::from(workgroup_size)),
        ("RUNAWAY_BOUND", RUNAWAY_BOUND),
        ("SMALLEST_SQUARE", SMALLEST_SQUARE),
        ("MAX_PERIOD", MAX_PERIOD as f64),
    ]
}
