//! What kernels cost on this machine, and how exact they are.
//!
//! Owns the points that kernels are compared on; prints nothing.

pub mod accuracy;
pub mod cost;
pub mod kernels;
pub mod scaling;

use crate::design::{Axis, AxisError, Design};
use crate::experiment::Preset;
use crate::parameters::{Parameter, ParameterSet};

/// Points along an axis of the reduced model's grid.
const SIDE: usize = 64;

/// The reduced model's plane, zeta_k 0..12 by h1 0..2, with so many columns and rows.
fn plane(columns: usize, rows: usize) -> Result<Design, AxisError> {
    Ok(Design::product(
        vec![
            Axis::even(Parameter::ZetaK, 0.0, 12.0, columns)?,
            Axis::even(Parameter::H1, 0.0, 2.0, rows)?,
        ],
        ParameterSet::default().into(),
    ))
}

fn every(design: &Design, stride: usize) -> Vec<ParameterSet> {
    (0..design.len())
        .step_by(stride)
        .map(|index| design.point(index))
        .collect()
}

/// Every `stride`-th point of the grid of 64 x 64 points over zeta_k 0..12 and h1 0..2. An odd stride meets all of its rows
/// and columns.
///
/// # Errors
/// None, as long as the table of parameters admits these ranges.
pub fn points(stride: usize) -> Result<Vec<ParameterSet>, AxisError> {
    Ok(every(&plane(SIDE, SIDE)?, stride))
}

/// The paper's preset without wear, over zeta_k 3..4.5 and gamma 1..1.87: the full model where it slides and sticks in
/// every period. Every `stride`-th point of 64 x 16.
///
/// # Errors
/// As [`points`].
pub fn rubbed_points(stride: usize) -> Result<Vec<ParameterSet>, AxisError> {
    let design = Design::product(
        vec![
            Axis::even(Parameter::ZetaK, 3.0, 4.5, SIDE)?,
            Axis::even(Parameter::Gamma, 1.0, 1.87, SIDE / 4)?,
        ],
        Preset::Paper.parameters().with(Parameter::KW, 0.0).into(),
    );
    Ok(every(&design, stride))
}

/// [`rubbed_points`] of the full model (`rubbed`), or [`points`] of the reduced one.
fn points_of_model(rubbed: bool, stride: usize) -> Vec<ParameterSet> {
    let points = if rubbed { rubbed_points(stride) } else { points(stride) };
    points.expect("the table of parameters admits the benchmark's ranges")
}

/// The value that the given part of the values does not exceed; NaN if there are none.
fn quantile(values: impl IntoIterator<Item = f64>, part: f64) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    // NaN sorts as the largest value
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    let place = (last as f64 * part).round() as usize;
    values.get(place).copied().unwrap_or(f64::NAN)
}

/// The median of some values; NaN if there are none.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    quantile(values, 0.5)
}
