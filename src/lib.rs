//! Chaos-threshold maps of a rubbing oscillator: the bush-shaft system of J. Awrejcewicz and Y. Pyryev, "Regular and
//! chaotic motion of a bush-shaft system with tribological processes", Mathematical Problems in Engineering 2006,
//! article 86594.
//!
//! From the bottom to the top; nothing knows of what stands below it in this list:
//!
//! - [`parameters`], [`machine`], [`design`]: the dimensionless quantities of the system, a machine in SI units that gives
//!   them, and axes over either;
//! - [`lanes`], [`model`]: numbers and physics;
//! - [`experiment`], [`dynamics`]: what is computed, and the algorithms over the physics;
//! - [`backend`]: batches of instances on the CPU or a GPU;
//! - [`measure`]: what is measured of a point, and when that is known;
//! - [`map`]: measurements over two axes, and the border of chaos;
//! - [`benchmark`]: points to time kernels on, and how exact they are;
//! - [`sweep`]: from a grid to measurements, and the audit of maps;
//! - [`analysis`]: orbits, bifurcation diagrams, sections, exponents over a line, thresholds, lifetimes of chaos;
//! - [`output`]: stores, pictures and tables;
//! - [`paper`]: the paper's figures and numbers, computed anew.
//!
//! One point, ten lines:
//!
//! ```
//! use tribochaos::backend::cpu::CpuBackend;
//! use tribochaos::experiment::{Precision, Settings};
//! use tribochaos::measure::{Class, measure_batch};
//! use tribochaos::parameters::{Parameter, ParameterSet};
//!
//! let point = ParameterSet::default().with(Parameter::ZetaK, 3.5).with(Parameter::H1, 0.5);
//! let mut backend = CpuBackend::new(Precision::F64);
//! let carry_on = &mut |_| std::ops::ControlFlow::Continue(());
//! let measured = measure_batch(&mut backend, &Settings::default(), &[point], carry_on)?.unwrap();
//! assert_eq!(measured[0].class, Some(Class::Regular));
//! assert!((measured[0].lyapunov + 0.2318).abs() < 1e-3);
//! # Ok::<(), tribochaos::backend::BackendError>(())
//! ```

pub mod analysis;
pub mod backend;
pub mod benchmark;
pub mod design;
pub mod dynamics;
pub mod experiment;
pub mod lanes;
pub mod machine;
pub mod map;
pub mod measure;
pub mod model;
pub mod output;
pub mod paper;
pub mod parameters;
pub mod sweep;
