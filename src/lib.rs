//! Chaos-threshold maps of a rubbing oscillator: the bush-shaft system of J. Awrejcewicz and Y. Pyryev, "Regular and
//! chaotic motion of a bush-shaft system with tribological processes", Mathematical Problems in Engineering 2006,
//! article 86594.
//!
//! A map, in ten lines:
//!
#![cfg_attr(all(feature = "pictures", feature = "store"), doc = "```no_run")]
#![cfg_attr(not(all(feature = "pictures", feature = "store")), doc = "```ignore")]
//! use tribochaos::{Axis, Experiment, ParameterMap, Quantity};
//!
//! let experiment = Experiment::builder()
//!     .axis(Axis::even("zeta_k", 3.0, 5.0, 300)?)
//!     .axis(Axis::even("h1", 0.0, 1.5, 200)?)
//!     .set("omega_0", 2.0)?
//!     .build()?;
//! let map = ParameterMap::try_from(tribochaos::run(&experiment)?)?;
//! tribochaos::draw(&map, Quantity::Lyapunov, "map.png")?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What a user calls
//!
//! | to | call |
//! | --- | --- |
//! | make an experiment | [`Experiment::builder`], with [`Axis`], [`Points`], [`Preset`] and machines ([`Description`]); [`Request::from_toml`] reads a file |
//! | run it | [`run`] into memory; [`run_into`] into a [`Store`], or into a [`Sink`] of your own, with an observer that may stop it |
//! | look at the results | [`Results`]: a column for each [`Quantity`], and the [`Class`] of a point; [`ParameterMap`]: the same over two axes, with [`map::border`] |
//! | draw them | [`draw`]; with another style [`picture::draw`] |
//! | store and open them | [`Store::create`], [`Store::open`] |
//! | follow a point over time | [`analysis::history`] |
//! | find onsets, sections, thresholds | [`analysis`] |
//!
//! The folder `examples/` has five short programs. All other items are parts of those in the table. The modules `lanes`,
//! `dynamics`, `backend`, `output`, `studies` and `cli` are public only for this project's own tests, benchmarks and program, and may
//! change at any time.
//!
//! # Features
//!
//! All are on by default. Without them the library has no heavy dependency; it computes on the CPU and keeps the results in
//! memory.
//!
//! - `gpu`: computing on a GPU by wgpu;
//! - `pictures`: maps and charts as PNG and SVG;
//! - `store`: maps on disk as Zarr;
//! - `parquet`: tables as Parquet;
//! - `cli`: the program; it needs the others.
//!
//! # Layers
//!
//! From the lowest layer to the highest. A layer uses only layers that are listed before it:
//!
//! - [`parameters`], [`machine`], [`design`]: the dimensionless quantities of the system, a machine in SI units that gives
//!   them, and axes over either;
//! - [`lanes`], [`model`]: numbers and physics;
//! - [`experiment`], [`dynamics`]: what is computed, and the algorithms over the physics;
//! - [`backend`]: batches of instances on the CPU or a GPU;
//! - [`measure`]: what is measured of a point, and when its run can end early;
//! - [`results`], [`map`]: columns over a design; results over two axes, and the border of chaos;
//! - [`engine`]: divides an experiment into units, measures them one by one and gives them to a sink; the audit;
//! - [`analysis`]: orbits, bifurcation diagrams, sections, exponents over a line, thresholds, lifetimes of chaos;
//! - [`output`]: files that are written completely or not at all, and tables of numbers;
//! - [`store`]: maps on disk as Zarr;
//! - [`picture`]: maps and charts as PNG and SVG;
//! - [`studies`]: benchmarks, and the paper's figures and numbers, computed anew;
//! - [`cli`]: the program's commands.

pub mod analysis;
#[doc(hidden)]
pub mod backend;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod design;
#[doc(hidden)]
pub mod dynamics;
pub mod engine;
pub mod experiment;
#[doc(hidden)]
pub mod lanes;
pub mod machine;
pub mod map;
pub mod measure;
pub mod model;
#[doc(hidden)]
pub mod output;
pub mod parameters;
#[cfg(feature = "pictures")]
pub mod picture;
pub mod results;
#[cfg(feature = "store")]
pub mod store;
#[doc(hidden)]
pub mod studies;

pub use self::design::{Axis, Points};
pub use self::engine::{Sink, run, run_into};
pub use self::experiment::{Device, Experiment, Integration, Preset, Request, Sampling, Scheme, Settings};
pub use self::machine::Description;
pub use self::map::ParameterMap;
pub use self::measure::{Class, Measurement, Quantity, Status};
pub use self::results::Results;
#[cfg(feature = "store")]
pub use self::store::Store;

/// Compiles the programs on the manual's page about the library, as a part of the tests.
#[cfg(all(doctest, feature = "pictures"))]
#[doc = include_str!("../docs/library.md")]
struct LibraryPage;

/// Draws a quantity of a map into a PNG file that carries the experiment.
///
/// # Errors
/// If the picture cannot be drawn or written.
#[cfg(feature = "pictures")]
pub fn draw(
    map: &ParameterMap,
    quantity: Quantity,
    path: impl AsRef<std::path::Path>,
) -> Result<(), picture::png::PngError> {
    picture::draw(map, quantity, &picture::Style::default(), path.as_ref())
}
