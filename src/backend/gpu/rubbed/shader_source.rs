//! The shader of the full model as it is compiled: its pieces put together, and the constants that it takes from the host.
//!
//! Owns which pieces there are and in what order; knows nothing of devices.

use super::super::shader_source::write_out;
use super::layout;
use crate::dynamics::adaptive::PRESSURE_BOUND;
use crate::dynamics::adaptive::events::{CUT, FIRST_PART};
use crate::dynamics::adaptive::kept::ROUGH;
use crate::dynamics::adaptive::orbit::{PASS_BUDGET, SETTLING_PASSES};
use crate::dynamics::adaptive::pass::{LARGE_SPEED, PRESSURE_FLOOR, REJECTED, SAFETY, SHORTEST_STEP};
use crate::dynamics::radau::{ERROR_WEIGHT, MAX_ITERATIONS};
use crate::dynamics::stroboscope::LEAST_WINDOW;
use crate::dynamics::tangent::{COMFORTABLE, SMALLEST_SQUARE};
use crate::lanes::Real;
use crate::model::motion::RUNAWAY_BOUND;

macro_rules! pieces {
    ($($name:literal)*) => {
        /// Name, below `shaders/`, and text of every piece.
        pub const PIECES: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../../../shaders/", $name)))),*];
    };
}

pieces! {
    "shared/one_lane.wgsl"
    "shared/span.wgsl"
    "shared/rubbed_bindings.wgsl"
    "shared/heat_modes.wgsl"
    "shared/runaway.wgsl"
    "shared/order.wgsl"
    "model/friction.wgsl"
    "model/rubbing.wgsl"
    "dynamics/decay.wgsl"
    "dynamics/matrix.wgsl"
    "dynamics/dense.wgsl"
    "dynamics/radau.wgsl"
    "dynamics/adaptive.wgsl"
    "dynamics/adaptive/events.wgsl"
    "dynamics/adaptive/kept.wgsl"
    "dynamics/adaptive/tangent.wgsl"
    "dynamics/adaptive/pass.wgsl"
    "dynamics/adaptive/orbit.wgsl"
    "dynamics/stroboscope.wgsl"
    "kernels/advance_rubbed.wgsl"
}

/// The name of the kernel.
pub const ENTRY_POINT: &str = "advance_rubbed";

/// Most modes over which loops are written out.
const MOST_WRITTEN_OUT: u32 = 33;

/// The pieces in one text, for `modes` heat modes and the lumped one: their number is the length of arrays in the shader,
/// which no `override` constant can be.
pub fn source(modes: u32) -> String {
    let slots = layout::slots(modes) as u32;
    let header = format!("const HEAT_MODES: u32 = {slots}u;\n");
    let text = PIECES.iter().fold(header, |text, (_, piece)| text + piece + "\n");
    if slots > MOST_WRITTEN_OUT {
        return text;
    }
    write_out(&text, "m", "HEAT_MODES", slots)
}

/// Values of the shader's `override` constants, so that each is defined in one place.
pub fn constants(workgroup_size: u32, carries_tangent: bool) -> [(&'static str, f64); 20] {
    [
        ("WORKGROUP_SIZE", f64::from(workgroup_size)),
        ("CARRIES_TANGENT", f64::from(u8::from(carries_tangent))),
        ("RUNAWAY_BOUND", RUNAWAY_BOUND),
        ("SMALLEST_SQUARE", SMALLEST_SQUARE),
        ("COMFORTABLE", COMFORTABLE),
        ("LEAST_WINDOW", f64::from(LEAST_WINDOW)),
        ("ERROR_WEIGHT", ERROR_WEIGHT),
        ("MAX_ITERATIONS", f64::from(MAX_ITERATIONS)),
        ("TICKS", f32::PERIOD_TICKS),
        ("SHORTEST_STEP", f64::from(SHORTEST_STEP)),
        ("PASS_BUDGET", f64::from(PASS_BUDGET)),
        ("SETTLING_PASSES", f64::from(SETTLING_PASSES)),
        ("LARGE_SPEED", LARGE_SPEED),
        ("PRESSURE_BOUND", PRESSURE_BOUND),
        ("CUT", CUT),
        ("FIRST_PART", FIRST_PART),
        ("PRESSURE_FLOOR", PRESSURE_FLOOR),
        ("REJECTED", REJECTED),
        ("SAFETY", SAFETY),
        ("ROUGH", ROUGH),
    ]
}
