//! The shader of the full model: its files, kernels and constants.
//!
//! Owns which files there are and in what order; [`Shader`] knows how they are put together.

use super::super::shader_source::{EntryPoint, Kernel, Shader, source_files};
use crate::dynamics::adaptive::PRESSURE_BOUND;
use crate::dynamics::adaptive::accepted::ROUGH;
use crate::dynamics::adaptive::events::{CUT, STRETCH};
use crate::dynamics::adaptive::pass::{LARGE_SPEED, LONGER, PRESSURE_FLOOR, REJECTED, SAFETY, SHORTEST_STEP};
use crate::dynamics::adaptive::period::{PASS_BUDGET, SETTLING_PASSES};
use crate::dynamics::radau::{ERROR_WEIGHT, MAX_ITERATIONS};
use crate::dynamics::stroboscope::LEAST_WINDOW;
use crate::dynamics::tangent::{COMFORTABLE, SMALLEST_SQUARE};
use crate::lanes::Real;
use crate::model::motion::RUNAWAY_BOUND;

pub static RADAU: Shader = Shader {
    files: source_files! {
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
        "dynamics/adaptive/accepted.wgsl"
        "dynamics/adaptive/tangent.wgsl"
        "dynamics/adaptive/pass.wgsl"
        "dynamics/adaptive/orbit.wgsl"
        "dynamics/stroboscope.wgsl"
        "kernels/advance_rubbed.wgsl"
    },
    entry_points: &[
        EntryPoint {
            kernel: Kernel::Plain,
            name: "advance_rubbed",
            switch: ("CARRIES_TANGENT", false),
        },
        EntryPoint {
            kernel: Kernel::Tangent,
            name: "advance_rubbed",
            switch: ("CARRIES_TANGENT", true),
        },
    ],
    constants: &[
        ("RUNAWAY_BOUND", RUNAWAY_BOUND),
        ("SMALLEST_SQUARE", SMALLEST_SQUARE),
        ("COMFORTABLE", COMFORTABLE),
        ("LEAST_WINDOW", LEAST_WINDOW as f64),
        ("ERROR_WEIGHT", ERROR_WEIGHT),
        ("MAX_ITERATIONS", MAX_ITERATIONS as f64),
        ("TICKS", f32::PERIOD_TICKS),
        ("SHORTEST_STEP", SHORTEST_STEP as f64),
        ("PASS_BUDGET", PASS_BUDGET as f64),
        ("SETTLING_PASSES", SETTLING_PASSES as f64),
        ("LARGE_SPEED", LARGE_SPEED),
        ("PRESSURE_BOUND", PRESSURE_BOUND),
        ("CUT", CUT),
        ("PRESSURE_FLOOR", PRESSURE_FLOOR),
        ("REJECTED", REJECTED),
        ("SAFETY", SAFETY),
        ("LONGER", LONGER),
        ("STRETCH", STRETCH),
        ("ROUGH", ROUGH),
    ],
};
