//! The drive's clock for schemes of fixed step.
//!
//! Owns sin z, with z the phase of the drive, at every stage of every step of a forcing period. A period has a whole number of
//! steps, so that one table serves every instance, whatever its omega_0, and time never grows into a large sum.

use std::f64::consts::TAU;

use crate::lanes::Real;

/// sin z at the middle and the end of each step of a period; the start is the end of the step before.
#[derive(Clone, Debug)]
pub struct DriveTable<S> {
    steps: Vec<[S; 2]>,
}

impl<S: Copy> DriveTable<S> {
    pub fn new<R: Real<Scalar = S>>(steps_per_period: u32) -> Self {
        let half_steps = f64::from(2 * steps_per_period);
        let sin = |half_step: u32| R::scalar((TAU * f64::from(half_step) / half_steps).sin());
        Self {
            steps: (0..steps_per_period)
                .map(|step| [sin(2 * step + 1), sin((2 * step + 2) % (2 * steps_per_period))])
                .collect(),
        }
    }

    /// [middle, end] for each step.
    #[inline(always)]
    pub fn steps(&self) -> &[[S; 2]] {
        &self.steps
    }
}
