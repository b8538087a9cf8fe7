//! The shaders as they are compiled, one a scheme and a number of lanes: pieces put together, and the constants taken from
//! the host.
//!
//! Owns which pieces there are and in what order; knows nothing of devices.

use std::fmt::Write as _;

use crate::dynamics::divergence_check::CHECKED_EVERY;
use crate::dynamics::stroboscope::LEAST_WINDOW;
use crate::dynamics::tangent::SMALLEST_SQUARE;
use crate::experiment::Scheme;
use crate::model::motion::RUNAWAY_BOUND;

/// Name, below `shaders/`, and text of a piece.
pub type Piece = (&'static str, &'static str);

macro_rules! piece {
    ($name:literal) => {
        ($name, include_str!(concat!("../../../shaders/", $name)))
    };
}

/// Instances that a thread carries at once, each in a lane of the numbers that it computes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lanes {
    One,
    Two,
}

impl Lanes {
    pub const ALL: [Self; 2] = [Self::One, Self::Two];

    /// What suits an adapter.
    ///
    /// Hardware hides how long a thread's operations take behind other threads, and would only run out of registers with
    /// more instances in each. A program that plays a GPU has no other threads to turn to: with two lanes llvmpipe is 1.4
    /// times as fast in `taylor` and 1.5 times in `rk4`. With four, `taylor` spills where it carries vectors, and kernels take
    /// two to four times as long to compile as with one.
    pub fn suiting(is_software: bool) -> Self {
        if is_software { Self::Two } else { Self::One }
    }

    pub fn count(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Two => 2,
        }
    }

    /// The types and functions that the other pieces are written in.
    pub fn piece(self) -> Piece {
        match self {
            Self::One => piece!("shared/one_lane.wgsl"),
            Self::Two => piece!("shared/two_lanes.wgsl"),
        }
    }
}

/// The shader of a scheme.
#[derive(Clone, Copy, Debug)]
pub struct Shader {
    /// All but that of the lanes.
    pub pieces: &'static [Piece],
}

macro_rules! shader {
    ($shader:ident: $($name:literal)*) => {
        static $shader: Shader = Shader {
            pieces: &[$(piece!($name)),*],
        };
    };
}

shader! {
    RK4:
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
}

shader! {
    TAYLOR:
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

    /// The pieces in one text, for threads of so many lanes.
    pub fn source(&self, lanes: Lanes) -> String {
        let pieces = std::iter::once(lanes.piece()).chain(self.pieces.iter().copied());
        let text = pieces.fold(String::new(), |text, (_, piece)| text + piece + "\n");
        write_out(&text, "lane", "LANES", lanes.count())
    }

    /// Every scheme's.
    pub fn all() -> impl Iterator<Item = (Scheme, &'static Self)> {
        Scheme::ALL
            .into_iter()
            .filter_map(|scheme| Some((scheme, Self::of(scheme)?)))
    }
}

/// Writes the loops of `variable` from 0 to `end`, which is `count`, out: drivers do not do so themselves, and keep what is
/// indexed by a variable in memory instead of registers.
pub(super) fn write_out(text: &str, variable: &str, end: &str, count: u32) -> String {
    let start = format!("for (var {variable} = 0u; {variable} < {end}; {variable}++) {{\n");
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once(&start) {
        out += before;
        let indentation = before.rsplit('\n').next().unwrap_or_default();
        let brace = format!("\n{indentation}}}\n");
        let (body, after) = after.split_once(&brace).expect("a loop has an end");
        for value in 0..count {
            let _ = write!(
                out,
                "{{ const {variable} = {value}u;\n{body}\n{indentation}}}\n{indentation}"
            );
        }
        rest = after;
    }
    out + rest
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
            ("LEAST_WINDOW", f64::from(LEAST_WINDOW)),
            ("CHECKED_EVERY", f64::from(CHECKED_EVERY)),
            ("IS_CHECKED", f64::from(u8::from(self == Self::Checked))),
        ]
    }
}
