//! The shaders of the reduced model, one a scheme: their files, kernels and constants.
//!
//! Owns which files there are and in what order; [`Shader`] knows how they are put together.

use super::super::shader_source::{EntryPoint, Kernel, Shader, source_files};
use crate::dynamics::divergence_check::CHECKED_EVERY;
use crate::dynamics::stroboscope::LEAST_WINDOW;
use crate::dynamics::tangent::SMALLEST_SQUARE;
use crate::model::motion::RUNAWAY_BOUND;

pub static RK4: Shader = Shader {
    files: source_files! {
        "shared/span.wgsl"
        "shared/bindings.wgsl"
        "shared/runaway.wgsl"
        "shared/lanes.wgsl"
        "model/friction.wgsl"
        "model/motion.wgsl"
        "dynamics/tangent.wgsl"
        "dynamics/divergence_check.wgsl"
        "dynamics/rk4.wgsl"
        "dynamics/stroboscope.wgsl"
        "kernels/rk4_plain.wgsl"
        "kernels/rk4_tangent.wgsl"
    },
    entry_points: ENTRY_POINTS,
    constants: CONSTANTS,
};

pub static TAYLOR: Shader = Shader {
    files: source_files! {
        "shared/span.wgsl"
        "shared/bindings.wgsl"
        "shared/runaway.wgsl"
        "shared/lanes.wgsl"
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
    },
    entry_points: ENTRY_POINTS,
    constants: CONSTANTS,
};

const ENTRY_POINTS: &[EntryPoint] = &[
    EntryPoint {
        kernel: Kernel::Plain,
        name: "advance_plain",
        switch: ("IS_CHECKED", false),
    },
    EntryPoint {
        kernel: Kernel::Tangent,
        name: "advance_tangent",
        switch: ("IS_CHECKED", false),
    },
    EntryPoint {
        kernel: Kernel::Checked,
        name: "advance_tangent",
        switch: ("IS_CHECKED", true),
    },
];

const CONSTANTS: &[(&str, f64)] = &[
    ("RUNAWAY_BOUND", RUNAWAY_BOUND),
    ("SMALLEST_SQUARE", SMALLEST_SQUARE),
    ("LEAST_WINDOW", LEAST_WINDOW as f64),
    ("CHECKED_EVERY", CHECKED_EVERY as f64),
];
