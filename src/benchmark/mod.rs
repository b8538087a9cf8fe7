//! What kernels cost on this machine, and how exact they are.
//!
//! Owns the points that kernels are compared on; prints nothing.

pub mod accuracy;
pub mod cost;
pub mod kernels;
pub mod scaling;

use crate::experiment::Preset;
use crate::grid::{Axis, AxisError, Grid};
use crate::parameters::{Parameter, ParameterSet};

/// Side of the grid.
const SIDE: usize = 64;

/// The grid of 64 x 64 points over zeta_k 0..12 and h1 0..2.
///
/// # Errors
/// None, as long as the table of parameters admits these ranges.
pub fn grid() -> Result<Grid, AxisError> {
    Ok(Grid {
        axes: vec![
            Axis::new(Parameter::ZetaK, 0.0, 12.0, SIDE)?,
            Axis::new(Parameter::H1, 0.0, 2.0, SIDE)?,
        ],
        fixed: ParameterSet::default().into(),
    })
}

/// Every `stride`-th point of the grid. An odd stride meets all of its rows and columns.
///
/// # Errors
/// As [`grid`].
pub fn points(stride: usize) -> Result<Vec<ParameterSet>, AxisError> {
    let grid = grid()?;
    Ok((0..grid.len()).step_by(stride).map(|index| grid.point(index)).collect())
}

/// The paper's preset without wear, over zeta_k 3..4.5 and gamma 1..1.87: the full model where it slides and sticks in
/// every period. Every `stride`-th point of 64 x 16.
///
/// # Errors
/// As [`grid`].
pub fn rubbed_points(stride: usize) -> Result<Vec<ParameterSet>, AxisError> {
    let grid = Grid {
        axes: vec![
            Axis::new(Parameter::ZetaK, 3.0, 4.5, SIDE)?,
            Axis::new(Parameter::Gamma, 1.0, 1.87, SIDE / 4)?,
        ],
        fixed: Preset::Paper.parameters().with(Parameter::KW, 0.0).into(),
    };
    Ok((0..grid.len()).step_by(stride).map(|index| grid.point(index)).collect())
}
