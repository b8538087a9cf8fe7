//! The tangent vector of the full state.
//!
//! Owns its norm and how it is carried over accepted steps; the derivative of a step is [`radau`]'s. Twin:
//! `shaders/dynamics/adaptive/tangent.wgsl`.

use super::accepted::advanced;
use super::{Orbit, Scratch, System};
use crate::dynamics::matrix::at_nodes;
use crate::dynamics::radau::{self, Heat, Memory, Perturbation, Start, Trial};
use crate::dynamics::tangent::{COMFORTABLE, SMALLEST_SQUARE, Vector};
use crate::lanes::{Mask, Real};

/// A tangent vector of the full state.
#[derive(Clone, Debug)]
pub struct Tangent<R> {
    pub at: Perturbation<R>,
    pub modes: Vec<R>,
    /// Logarithm of the product of all norms by which it was divided since the last call of [`Tangent::normalise`].
    log: R,
    /// Divergence of the flow of (x, y) at constant pressure, integrated over tau since the last call of
    /// [`Tangent::take_divergence`].
    divergence: R,
}

impl<R: Real> Tangent<R> {
    /// The vector with the components (X, Y) and all others 0.
    pub fn start(vector: Vector<R>, modes: usize) -> Self {
        let zero = R::splat(0.0);
        let heat = Heat {
            pressure: zero,
            falloff: zero,
        };
        Self {
            at: Perturbation {
                x: vector.x,
                // the speed of the shaft is not disturbed
                v: zero - vector.y,
                fit: zero,
                heat,
                flux: zero,
            },
            modes: vec![zero; modes],
            log: zero,
            divergence: zero,
        }
    }

    /// Its components (X, Y).
    pub fn in_plane(&self) -> Vector<R> {
        Vector {
            x: self.at.x,
            y: -self.at.v,
        }
    }

    /// The integral of the divergence since the last call.
    pub fn take_divergence(&mut self) -> R {
        std::mem::replace(&mut self.divergence, R::splat(0.0))
    }

    /// Divides the vector by its norm and returns the logarithm of its growth since the last call. With wear, the norm is that of
    /// (X, Y). Without wear, it is that of (X, Y) and the heat modes together. Each mode counts with the pressure that it causes,
    /// which is 0 if gamma is 0.
    #[inline(always)]
    pub fn normalise(&mut self, system: &System<R>) -> R {
        let norm = self.norm(system);
        self.divide(norm);
        std::mem::replace(&mut self.log, R::splat(0.0))
    }

    /// Divides the vector by its norm before it overflows or vanishes: in lanes with a norm far from 1 and `left` not 0.
    #[inline(always)]
    pub(super) fn settle(&mut self, system: &System<R>, left: R) {
        let one = R::splat(1.0);
        let norm = self.norm(system);
        let near = R::splat(1.0 / COMFORTABLE)
            .less(norm)
            .and(norm.less(R::splat(COMFORTABLE)));
        if near.all() {
            return;
        }
        let stays = near.or(left.less(R::splat(0.5)));
        self.divide(R::select(stays, one, norm));
    }

    #[inline(always)]
    fn norm(&self, system: &System<R>) -> R {
        let mut square = self.at.x.mul_add(self.at.x, self.at.v * self.at.v);
        for (mode, weight) in self.modes.iter().zip(&system.weights) {
            let pressure = system.lasts * *mode * *weight;
            square = pressure.mul_add(pressure, square);
        }
        let smallest = R::splat(SMALLEST_SQUARE);
        R::select(square.less(smallest), smallest, square).sqrt()
    }

    #[inline(always)]
    fn divide(&mut self, norm: R) {
        self.log = self.log + norm.ln();
        let inverse = R::splat(1.0) / norm;
        let at = &mut self.at;
        for value in [
            &mut at.x,
            &mut at.v,
            &mut at.fit,
            &mut at.heat.pressure,
            &mut at.heat.falloff,
            &mut at.flux,
        ]
        .into_iter()
        .chain(&mut self.modes)
        {
            *value = *value * inverse;
        }
    }
}

impl<R: Real> Orbit<R> {
    /// Carries a tangent vector over an accepted step.
    #[allow(clippy::too_many_arguments, reason = "the parts of one pass")]
    #[inline(always)]
    pub(super) fn carry(
        system: &System<R>,
        start: &Start<R>,
        trial: &Trial<R>,
        memory: &Memory<R>,
        tangent: &mut Tangent<R>,
        steps: &Scratch<R>,
        h: R,
        accepted: R::Mask,
    ) {
        let mut free = Heat {
            pressure: R::splat(0.0),
            falloff: R::splat(0.0),
        };
        for (m, step) in steps.iter().enumerate() {
            let left = system.weights[m] * step.factor * tangent.modes[m];
            free.pressure = free.pressure + left;
            free.falloff = system.rates[m].mul_add(left, free.falloff);
        }
        let memory = Memory { free, ..*memory };
        let rates = trial.divergence(&system.rubbing);
        let divergence = tangent.divergence + radau::integral(rates) * h;
        tangent.divergence = R::select(accepted, divergence, tangent.divergence);
        let (end, flux) = trial.perturbed(&system.rubbing, start, h, &memory, &tangent.at);
        let flux = radau::parabola(flux);
        let flux = at_nodes!(k => flux[k] * h);
        for (m, step) in steps.iter().enumerate() {
            let mode = advanced(step, tangent.modes[m], flux);
            tangent.modes[m] = R::select(accepted, mode, tangent.modes[m]);
        }
        let old = tangent.at;
        tangent.at = Perturbation {
            x: R::select(accepted, end.x, old.x),
            v: R::select(accepted, end.v, old.v),
            fit: R::select(accepted, end.fit, old.fit),
            heat: Heat {
                pressure: R::select(accepted, end.heat.pressure, old.heat.pressure),
                falloff: R::select(accepted, end.heat.falloff, old.heat.falloff),
            },
            flux: R::select(accepted, end.flux, old.flux),
        };
    }
}
