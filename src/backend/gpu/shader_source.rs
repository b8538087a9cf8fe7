//! Shaders as they are compiled: files put together in one text, and the constants taken from the host.
//!
//! Owns how a text and its constants come about; which files a shader is made of, each model tells. Knows nothing of devices.

use std::fmt::Write as _;

use super::{reduced, rubbed};
use crate::experiment::Scheme;

/// Name, below `shaders/`, and text of a file.
pub type SourceFile = (&'static str, &'static str);

/// The files of these names, below `shaders/`.
macro_rules! source_files {
    ($($name:literal)*) => {
        &[$(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $name)))),*]
    };
}
pub(super) use source_files;

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

    /// The types and functions that the other files are written in.
    pub fn file(self) -> SourceFile {
        let [file] = match self {
            Self::One => source_files!("shared/one_lane.wgsl"),
            Self::Two => source_files!("shared/two_lanes.wgsl"),
        };
        *file
    }
}

/// What a thread carries: lengths of arrays in a shader, which no `override` constant can be, and of loops in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    pub lanes: Lanes,
    /// Heat modes of an instance, without the lumped one; None where the model has no heat.
    pub modes: Option<u32>,
}

/// Heat modes over which loops are written out, at most, the lumped one among them.
const MOST_WRITTEN_OUT: u32 = 33;

/// A kernel of a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// The motion alone.
    Plain,
    /// Motion and a tangent vector.
    Tangent,
    /// Motion and both tangent vectors, through checked periods.
    Checked,
}

/// Where a kernel begins in its shader.
#[derive(Clone, Copy, Debug)]
pub(super) struct EntryPoint {
    pub kernel: Kernel,
    pub name: &'static str,
    /// The constant by which kernels of one name differ, and its value.
    pub switch: (&'static str, bool),
}

/// The shader of a scheme.
#[derive(Clone, Copy, Debug)]
pub struct Shader {
    /// All but that of the lanes, which comes first.
    pub files: &'static [SourceFile],
    pub(super) entry_points: &'static [EntryPoint],
    /// The `override` constants that all of its kernels share, so that each is defined in one place.
    pub(super) constants: &'static [(&'static str, f64)],
}

impl Shader {
    pub fn of(scheme: Scheme) -> &'static Self {
        match scheme {
            Scheme::Rk4 => &reduced::shader_source::RK4,
            Scheme::Taylor => &reduced::shader_source::TAYLOR,
            Scheme::Radau => &rubbed::shader_source::RADAU,
        }
    }

    /// The files in one text, for threads of this shape.
    pub fn source(&self, shape: Shape) -> String {
        let slots = shape.modes.map(rubbed::layout::slots);
        let header = slots.map_or_else(String::new, |slots| format!("const HEAT_MODES: u32 = {slots}u;\n"));
        let files = std::iter::once(shape.lanes.file()).chain(self.files.iter().copied());
        let text = files.fold(header, |text, (_, file)| text + file + "\n");
        let text = write_out(&text, "lane", "LANES", shape.lanes.count());
        match slots {
            Some(slots) if slots <= MOST_WRITTEN_OUT => write_out(&text, "m", "HEAT_MODES", slots),
            _ => text,
        }
    }

    pub fn kernels(&self) -> impl Iterator<Item = Kernel> {
        self.entry_points.iter().map(|entry_point| entry_point.kernel)
    }

    /// The name of a kernel.
    ///
    /// # Panics
    /// As the next function, if the shader has no such kernel.
    pub fn entry_point(&self, kernel: Kernel) -> &'static str {
        self.find(kernel).name
    }

    /// Values of all `override` constants.
    pub fn constants(&self, kernel: Kernel, workgroup_size: u32) -> Vec<(&'static str, f64)> {
        let (switch, is_on) = self.find(kernel).switch;
        let own = [
            ("WORKGROUP_SIZE", f64::from(workgroup_size)),
            (switch, f64::from(u8::from(is_on))),
        ];
        own.into_iter().chain(self.constants.iter().copied()).collect()
    }

    fn find(&self, kernel: Kernel) -> &EntryPoint {
        let mut entry_points = self.entry_points.iter();
        let found = entry_points.find(|entry_point| entry_point.kernel == kernel);
        found.expect("the shader has this kernel")
    }
}

/// Writes the loops of `variable` from 0 to `end`, which is `count`, out: drivers do not do so themselves, and keep what is
/// indexed by a variable in memory instead of registers.
fn write_out(text: &str, variable: &str, end: &str, count: u32) -> String {
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
