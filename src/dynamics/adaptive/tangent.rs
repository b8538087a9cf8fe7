//! Tangent vectors of the full state.
//!
//! Owns its norm and how it is carried over accepted steps; the derivative of a step is [`radau`]'s. Twin:
//! `shaders/dynamics/adaptive/tangent.wgsl`.

use super::accepted::advanced;
use super::{Orbit, Scratch, System};
use crate::dynamics::matrix::at_nodes;
use crate::dynamics::radau::{self, Heat, Memory, Perturbation, Start, Trial};
use crate::dynamics::tangent::{COMFORTABLE, Growth, SMALLEST_SQUARE};
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
    /// A vector at an orbit's present state. Its components are X, Y, and the perturbations of the pressures that the heat modes
    /// cause; those that `components` leaves out are 0.
    pub fn at(orbit: &Orbit<R>, system: &System<R>, components: &[R]) -> Self {
        let zero = R::splat(0.0);
        let component = |n: usize| components.get(n).copied().unwrap_or(zero);
        let (x, y) = (component(0), component(1));
        let modes = 0..system.mode_count();
        let heat = system.heat(modes.clone().map(|m| component(2 + m)));
        let modes = modes.map(|m| system.mode(m, component(2 + m))).collect();
        // the speed of the shaft is not disturbed
        let v = zero - y;
        let start = orbit.begin(system);
        let slope = system.rubbing.friction_slope(&start.piece, start.v);
        let by_v = start.pressure * slope.mul_add(start.v, start.friction);
        let by_pressure = start.contact * start.friction * start.v;
        Self {
            at: Perturbation {
                x,
                v,
                fit: zero,
                heat,
                flux: by_v.mul_add(v, by_pressure * heat.pressure),
            },
            modes,
            log: zero,
            divergence: zero,
        }
    }

    /// Its components, as in [`Tangent::at`], in one lane. What it was divided by since the last call of [`Tangent::normalise`] is
    /// multiplied back in.
    pub fn components(&self, system: &System<R>, lane: usize) -> impl Iterator<Item = f64> {
        let factor = self.log.lane(lane).exp();
        let pressures = self.modes.iter().zip(&system.weights);
        let pressures = pressures.map(move |(mode, weight)| mode.lane(lane) * weight.lane(lane));
        self.in_plane(lane)
            .into_iter()
            .chain(pressures)
            .map(move |component| component * factor)
    }

    /// Its components (X, Y) in one lane.
    pub fn in_plane(&self, lane: usize) -> [f64; 2] {
        [self.at.x.lane(lane), -self.at.v.lane(lane)]
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

    /// Orthonormalises the first vector, and the second one if there is one, by Gram and Schmidt (3.5). The metric is that of
    /// [`Tangent::normalise`]. Returns the logarithms of their growth since the last call. Without a second vector, the second is
    /// NaN.
    #[inline(always)]
    pub fn orthonormalise(vectors: &mut [Self], system: &System<R>) -> Growth<R> {
        let [first, others @ ..] = vectors else {
            panic!("no vector to normalise");
        };
        let mut growth = Growth {
            first: first.normalise(system),
            second: R::splat(f64::NAN),
        };
        if let [second, ..] = others {
            let along = first.dot(second, system);
            second.subtract(along, first);
            growth.second = second.normalise(system);
        }
        growth
    }

    /// The scalar product of two vectors.
    #[inline(always)]
    fn dot(&self, other: &Self, system: &System<R>) -> R {
        let mut dot = self.at.x.mul_add(other.at.x, self.at.v * other.at.v);
        for (m, weight) in system.weights.iter().enumerate() {
            let weight = system.lasts * *weight;
            dot = (weight * self.modes[m]).mul_add(weight * other.modes[m], dot);
        }
        dot
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
        let square = self.dot(self, system);
        let smallest = R::splat(SMALLEST_SQUARE);
        R::select(square.less(smallest), smallest, square).sqrt()
    }

    #[inline(always)]
    fn divide(&mut self, norm: R) {
        self.log = self.log + norm.ln();
        let inverse = R::splat(1.0) / norm;
        for value in self.at.parts().into_iter().chain(&mut self.modes) {
            *value = *value * inverse;
        }
    }

    /// Subtracts a multiple of another vector.
    #[inline(always)]
    fn subtract(&mut self, factor: R, other: &mut Self) {
        let parts = self.at.parts().into_iter().chain(&mut self.modes);
        for (value, other) in parts.zip(other.at.parts().into_iter().chain(&mut other.modes)) {
            *value = *value - factor * *other;
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
