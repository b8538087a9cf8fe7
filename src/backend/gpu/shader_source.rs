//! Shaders as they are compiled: files put together in one text, and the constants taken from the host.
//!
//! Owns how a text and its constants are made; each model tells which files its shader consists of. Knows nothing of devices.

use std::fmt::Write as _;

use super::layout;

/// Name of a file, as a path below `shaders/`, and its text.
pub type SourceFile = (&'static str, &'static str);

/// The files of these names, below `shaders/`.
macro_rules! source_files {
    ($($name:literal)*) => {
        &[$(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $name)))),*]
    };
}
pub(super) use source_files;

/// How many instances a thread carries at once: each is in one lane of the vectors that the thread computes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lanes {
    One,
    Two,
}

impl Lanes {
    pub const ALL: [Self; 2] = [Self::One, Self::Two];

    /// The number of lanes that suits an adapter.
    ///
    /// Hardware hides the latency of a thread's operations behind other threads. With more instances in a thread it would only
    /// run out of registers. A program that acts as a GPU has no other threads for this: with two lanes, llvmpipe is 1.4 times
    /// as fast in `taylor` and 1.5 times in `rk4`. With four lanes, `taylor` spills registers where it carries tangent vectors,
    /// and kernels take two to four times as long to compile as with one.
    pub fn suiting(is_software: bool) -> Self {
        if is_software { Self::Two } else { Self::One }
    }

    pub fn count(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Two => 2,
        }
    }

    /// The file of the types and functions that the other files are written in.
    pub fn file(self) -> SourceFile {
        let [file] = match self {
            Self::One => source_files!("shared/one_lane.wgsl"),
            Self::Two => source_files!("shared/two_lanes.wgsl"),
        };
        *file
    }
}

/// Sizes of a thread's data: the lengths of arrays in a shader, and of loops over them. No `override` constant can be the length
/// of such an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    pub lanes: Lanes,
    /// Heat modes of an instance, without the lumped one; None where the model has no heat.
    pub modes: Option<u32>,
}

/// Loops over heat modes are unrolled if there are no more modes than this, with the lumped one.
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
    /// The constant by which kernels with the same name differ, and its value.
    pub switch: (&'static str, bool),
}

/// The shader of a scheme.
#[derive(Clone, Copy, Debug)]
pub struct Shader {
    /// All files except that of the lanes, which comes first.
    pub files: &'static [SourceFile],
    pub(super) entry_points: &'static [EntryPoint],
    /// The `override` constants that all of its kernels share, so that each is defined in one place.
    pub(super) constants: &'static [(&'static str, f64)],
}

impl Shader {
    /// The files in one text, for threads of this shape.
    pub fn source(&self, shape: Shape) -> String {
        let slots = shape.modes.map(layout::slots);
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
    /// If the shader has no such kernel; so does [`Shader::constants`].
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

/// Unrolls the loops of `variable` from 0 to `end`, a constant of the value `count`. Drivers do not unroll them, and keep an
/// array that is indexed by a variable in memory instead of registers.
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
