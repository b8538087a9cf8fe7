//! The Radau IIA scheme of order 5 for a bush rubbed under changing pressure: one trial step.
//!
//! Owns the collocation equations, their solution and their linearisation; [`super::adaptive`] decides which trials are accepted,
//! and how long they are. Twin: `shaders/dynamics/radau.wgsl`.
//!
//! The sliding velocity v is the stiff variable (rate eps p F'(v), up to 6e4 where p = 1e4). Newton's method solves for v at the
//! three nodes of the step. The angle follows by the scheme's quadrature. The pressure follows exactly: the heat modes are
//! linear, and their source, the heat flux, is the parabola through its values at the nodes. The pressure at the step's end is
//! therefore linear in these values. The pressure at the two inner nodes comes from Hermite interpolation, so that it is linear
//! in them as well; the pressure is smooth where single fast modes are not. The source of the scheme is E. Hairer and G. Wanner,
//! Solving Ordinary Differential Equations II, section IV.5.

#![allow(
    clippy::needless_range_loop,
    reason = "arrays are walked side by side: indices say so best"
)]

use super::decay::{self, Decay};
use super::matrix::{Matrix, Vector, apply, at_nodes, dot, inverse, product};
use crate::lanes::{Mask, Real};
use crate::model::friction::Piece;
use crate::model::rubbing::Rubbing;

const SQRT_6: f64 = 2.449_489_742_783_178;

/// Nodes of a step of length 1.
pub const NODES: [f64; 3] = [(4.0 - SQRT_6) / 10.0, (4.0 + SQRT_6) / 10.0, 1.0];

/// INTEGRALS[i][j]: the j-th cardinal polynomial of the nodes integrated from 0 to node i.
const INTEGRALS: [[f64; 3]; 3] = [
    [
        (88.0 - 7.0 * SQRT_6) / 360.0,
        (296.0 - 169.0 * SQRT_6) / 1800.0,
        (-2.0 + 3.0 * SQRT_6) / 225.0,
    ],
    [
        (296.0 + 169.0 * SQRT_6) / 1800.0,
        (88.0 + 7.0 * SQRT_6) / 360.0,
        (-2.0 - 3.0 * SQRT_6) / 225.0,
    ],
    [(16.0 - SQRT_6) / 36.0, (16.0 + SQRT_6) / 36.0, 1.0 / 9.0],
];

/// CARDINAL[j][k]: coefficient of s^k in the j-th cardinal polynomial of the nodes.
const CARDINAL: [[f64; 3]; 3] = [cardinal(0), cardinal(1), cardinal(2)];

const fn cardinal(j: usize) -> [f64; 3] {
    let (a, b) = (NODES[(j + 1) % 3], NODES[(j + 2) % 3]);
    let scale = 1.0 / ((NODES[j] - a) * (NODES[j] - b));
    [a * b * scale, -(a + b) * scale, scale]
}

/// Hermite's cubics at the two inner nodes: weights of the value and the slope at the start, and at the end.
const HERMITE: [[f64; 4]; 2] = [hermite(NODES[0]), hermite(NODES[1])];

const fn hermite(c: f64) -> [f64; 4] {
    [
        (2.0 * c - 3.0) * c * c + 1.0,
        ((c - 2.0) * c + 1.0) * c,
        (3.0 - 2.0 * c) * c * c,
        (c - 1.0) * c * c,
    ]
}

/// The derivatives of Hermite's cubics, likewise.
const HERMITE_SLOPE: [[f64; 4]; 2] = [hermite_slope(NODES[0]), hermite_slope(NODES[1])];

const fn hermite_slope(c: f64) -> [f64; 4] {
    [
        (6.0 * c - 6.0) * c,
        (3.0 * c - 4.0) * c + 1.0,
        (6.0 - 6.0 * c) * c,
        (3.0 * c - 2.0) * c,
    ]
}

/// Weight of the embedded error estimate, 1/(the real eigenvalue of INTEGRALS' inverse).
pub const ERROR_WEIGHT: f64 = 0.274_888_829_595_677_6;

/// Most iterations of Newton's method; a trial that needs more has failed.
pub const MAX_ITERATIONS: u32 = 5;

#[inline(always)]
fn constants<R: Real, const N: usize>(values: [f64; N]) -> [R; N] {
    let mut out = [R::splat(0.0); N];
    for n in 0..N {
        out[n] = R::splat(values[n]);
    }
    out
}

/// The coefficients in time of the quadratic with these values at the nodes.
#[inline(always)]
pub fn parabola<R: Real>(values: Vector<R>) -> Vector<R> {
    at_nodes!(k => dot(at_nodes!(j => R::splat(CARDINAL[j][k])), values))
}

/// The integrals from 0 to each node of the quadratic with these values at the nodes.
#[inline(always)]
fn integrals<R: Real>(values: Vector<R>) -> Vector<R> {
    at_nodes!(i => dot(constants(INTEGRALS[i]), values))
}

/// The integral of this quadratic from 0 to the step's end.
#[inline(always)]
pub fn integral<R: Real>(values: Vector<R>) -> R {
    dot(constants(INTEGRALS[2]), values)
}

/// The thermal part of the pressure, sum w_m q_m, and the rate at which it falls off without a heat flux, sum w_m r_m q_m.
#[derive(Clone, Copy, Debug)]
pub struct Heat<R> {
    pub pressure: R,
    pub falloff: R,
}

/// The sums over the heat modes at the end of a step, as linear functions of the heat flux's coefficients in time.
#[derive(Clone, Copy, Debug)]
pub struct Memory<R> {
    /// The part that comes from the state at the start alone.
    pub free: Heat<R>,
    /// The factors of the coefficients of the flux.
    pub pressure: Vector<R>,
    pub falloff: Vector<R>,
}

/// One heat mode over a step.
pub type ModeStep<R> = Decay<R>;

impl<R: Real> Memory<R> {
    /// Sums over the modes for a step of length `h`; keeps the decay of each mode in `steps`.
    #[inline(always)]
    pub fn new(h: R, rates: &[R], inverse_rates: &[R], weights: &[R], modes: &[R], steps: &mut [ModeStep<R>]) -> Self {
        let (zero, inverse_h) = (R::splat(0.0), R::splat(1.0) / h);
        let mut free = Heat {
            pressure: zero,
            falloff: zero,
        };
        let (mut pressure, mut falloff) = ([zero; 3], [zero; 3]);
        for m in 0..rates.len() {
            let step = decay::decay(rates[m] * h, inverse_rates[m] * inverse_h);
            let (left, faster) = (step.factor * modes[m], weights[m] * rates[m]);
            free.pressure = weights[m].mul_add(left, free.pressure);
            free.falloff = faster.mul_add(left, free.falloff);
            for k in 0..3 {
                pressure[k] = weights[m].mul_add(step.moments[k], pressure[k]);
                falloff[k] = faster.mul_add(step.moments[k], falloff[k]);
            }
            steps[m] = step;
        }
        Self {
            free,
            pressure: at_nodes!(k => pressure[k] * h),
            falloff: at_nodes!(k => falloff[k] * h),
        }
    }

    /// The sums at the end, given the flux's coefficients in time.
    #[inline(always)]
    pub fn end(&self, flux: Vector<R>) -> Heat<R> {
        Heat {
            pressure: self.free.pressure + dot(self.pressure, flux),
            falloff: self.free.falloff + dot(self.falloff, flux),
        }
    }
}

/// The state at the start of a trial.
#[derive(Clone, Copy, Debug)]
pub struct Start<R> {
    pub x: R,
    pub v: R,
    pub shaft_speed: R,
    /// h_U - u_w.
    pub fit: R,
    pub heat: Heat<R>,
    /// 1 in contact, 0 in the gap.
    pub contact: R,
    /// The piece of the friction law that the trial follows.
    pub piece: Piece<R>,
    /// p, F(v), the acceleration and the heat flux here.
    pub pressure: R,
    pub friction: R,
    pub acceleration: R,
    pub flux: R,
}

impl<R: Real> Start<R> {
    #[allow(clippy::too_many_arguments, reason = "the parts of a state")]
    #[inline(always)]
    pub fn new(
        rubbing: &Rubbing<R>,
        piece: Piece<R>,
        x: R,
        v: R,
        shaft_speed: R,
        fit: R,
        heat: Heat<R>,
        contact: R,
    ) -> Self {
        let pressure = contact * (fit + heat.pressure);
        let friction = rubbing.friction(&piece, v);
        let rubbed = pressure * friction;
        Self {
            x,
            v,
            shaft_speed,
            fit,
            heat,
            contact,
            piece,
            pressure,
            friction,
            acceleration: rubbing.acceleration(x, shaft_speed - v, rubbed),
            flux: rubbed * v,
        }
    }
}

/// What drives a trial: its length, and at each node how much the shaft's speed and the fit h_U have grown since the
/// start.
#[derive(Clone, Copy, Debug)]
pub struct Drive<R> {
    pub h: R,
    pub speed: Vector<R>,
    pub fit: Vector<R>,
}

/// A solved trial: values at the nodes, and the linearisation there.
#[derive(Clone, Copy, Debug)]
pub struct Trial<R: Real> {
    pub converged: R::Mask,
    pub x: Vector<R>,
    pub v: Vector<R>,
    /// p; and the pressure that there would be in contact, which decides whether contact returns.
    pub pressure: Vector<R>,
    pub if_closed: Vector<R>,
    pub friction: Vector<R>,
    pub acceleration: Vector<R>,
    /// Q = F(v) v p.
    pub flux: Vector<R>,
    /// d(friction)/dv.
    slope: Vector<R>,
    /// Inverse of d(residual)/d(v).
    newton: Matrix<R>,
    /// dp/d(p at fixed heat and wear): the response of the pressure, which itself causes heat and wear.
    response: Matrix<R>,
    /// dp/dv.
    by_v: Matrix<R>,
}

/// The thermal pressure at the nodes, as an offset and the weights of the flux at the nodes; at the two inner nodes by Hermite's
/// cubics.
struct InnerHeat<R> {
    offset: Vector<R>,
    by_flux: Matrix<R>,
}

impl<R: Real> InnerHeat<R> {
    #[inline(always)]
    fn new(rubbing: &Rubbing<R>, h: R, start: Heat<R>, start_flux: R, memory: &Memory<R>) -> Self {
        // factors of the flux at node j, instead of those of the coefficient of s^k
        let end = at_nodes!(j => dot(constants(CARDINAL[j]), memory.pressure));
        let end_falloff = at_nodes!(j => dot(constants(CARDINAL[j]), memory.falloff));
        let start_slope = h * rubbing.two_gamma.mul_add(start_flux, -start.falloff);
        let own = h * rubbing.two_gamma;
        let mut offset = at_nodes!(_i => memory.free.pressure);
        let mut by_flux = at_nodes!(_i => end);
        for i in 0..2 {
            let [value_0, slope_0, value_1, slope_1]: [R; 4] = constants(HERMITE[i]);
            offset[i] = value_0.mul_add(
                start.pressure,
                slope_0.mul_add(
                    start_slope,
                    value_1.mul_add(memory.free.pressure, -(slope_1 * h * memory.free.falloff)),
                ),
            );
            by_flux[i] = at_nodes!(j => value_1.mul_add(end[j], -(slope_1 * h * end_falloff[j])));
            by_flux[i][2] = slope_1.mul_add(own, by_flux[i][2]);
        }
        Self { offset, by_flux }
    }
}

/// Solves a trial. The iteration begins with the accelerations `guess` at the nodes. `closeness` is the largest last correction
/// of Newton's method, relative to the larger of |v| and the friction layer's width.
#[inline(always)]
pub fn solve<R: Real>(
    rubbing: &Rubbing<R>,
    start: &Start<R>,
    drive: &Drive<R>,
    memory: &Memory<R>,
    guess: Vector<R>,
    closeness: R,
) -> Trial<R> {
    let (zero, one, h) = (R::splat(0.0), R::splat(1.0), drive.h);
    let heat = InnerHeat::new(rubbing, h, start.heat, start.flux, memory);
    let closed = at_nodes!(i => start.fit + drive.fit[i] + heat.offset[i]);
    let by_flux = at_nodes!(i => at_nodes!(j => start.contact * heat.by_flux[i][j]));
    let weights = at_nodes!(i => at_nodes!(j => h * R::splat(INTEGRALS[i][j])));
    let wear = start.contact * rubbing.k_w;
    let worn = at_nodes!(i => at_nodes!(j => wear * weights[i][j]));
    let speed = at_nodes!(i => start.shaft_speed + drive.speed[i]);
    let target = at_nodes!(i => start.v + drive.speed[i]);

    let integrated = apply(&weights, guess);
    let mut v = at_nodes!(i => target[i] - integrated[i]);
    let mut correction = [zero; 3];
    let mut trial = Trial {
        converged: one.less(zero),
        x: [start.x; 3],
        v,
        pressure: [zero; 3],
        if_closed: closed,
        friction: [zero; 3],
        acceleration: guess,
        flux: [zero; 3],
        slope: [zero; 3],
        newton: weights,
        response: weights,
        by_v: weights,
    };
    for _ in 0..MAX_ITERATIONS {
        let y = at_nodes!(i => speed[i] - v[i]);
        let travelled = apply(&weights, y);
        trial.x = at_nodes!(i => start.x + travelled[i]);
        trial.friction = at_nodes!(i => rubbing.friction(&start.piece, v[i]));
        trial.slope = at_nodes!(i => rubbing.friction_slope(&start.piece, v[i]));
        // p = response times closed, since the flux and the wear at the nodes are linear in p
        let slid = at_nodes!(j => v[j].abs());
        let cooled = at_nodes!(j => -(trial.friction[j] * v[j]));
        let mut system = weights;
        for i in 0..3 {
            for j in 0..3 {
                let own = if i == j { one } else { zero };
                system[i][j] = by_flux[i][j].mul_add(cooled[j], worn[i][j].mul_add(slid[j], own));
            }
        }
        trial.response = inverse(&system);
        trial.pressure = apply(&trial.response, at_nodes!(i => start.contact * closed[i]));
        let rubbed = at_nodes!(i => trial.pressure[i] * trial.friction[i]);
        trial.acceleration = at_nodes!(i => rubbing.acceleration(trial.x[i], y[i], rubbed[i]));
        let integrated = apply(&weights, trial.acceleration);
        let residual = at_nodes!(i => v[i] - target[i] + integrated[i]);

        let by_heat = at_nodes!(j => trial.slope[j].mul_add(v[j], trial.friction[j]) * trial.pressure[j]);
        let by_wear = at_nodes!(j => R::select(v[j].less(zero), trial.pressure[j], -trial.pressure[j]));
        let source = at_nodes!(i => at_nodes!(j => by_flux[i][j].mul_add(by_heat[j], worn[i][j] * by_wear[j])));
        trial.by_v = product(&trial.response, &source);
        let mut by_v = trial.by_v;
        for i in 0..3 {
            let (rubbed, stiffness) = (rubbing.epsilon * trial.friction[i], rubbing.stiffness(trial.x[i]));
            by_v[i] = at_nodes!(j => rubbed.mul_add(by_v[i][j], -(stiffness * weights[i][j])));
            by_v[i][i] = by_v[i][i] + (rubbing.epsilon * trial.pressure[i]).mul_add(trial.slope[i], rubbing.damping);
        }
        let mut jacobian = product(&weights, &by_v);
        for i in 0..3 {
            jacobian[i][i] = jacobian[i][i] + one;
        }
        trial.newton = inverse(&jacobian);
        correction = apply(&trial.newton, residual);
        let corrected = at_nodes!(i => v[i] - correction[i]);
        let [first, second, last] = at_nodes!(i => {
            let scale = corrected[i].abs().max(rubbing.layer);
            correction[i].abs().less(closeness * scale)
        });
        trial.converged = first.and(second).and(last);
        trial.v = corrected;
        if trial.converged.all() {
            break;
        }
        // a lane that has converged waits where it is, so that it does not depend on the others
        v = at_nodes!(i => R::select(trial.converged, v[i], corrected[i]));
    }
    // the quantities that depend on v were evaluated before the last correction: they follow it here up to its square
    let by_v = apply(&trial.by_v, correction);
    let travelled = apply(&weights, correction);
    let v = trial.v;
    trial.x = at_nodes!(i => trial.x[i] + travelled[i]);
    trial.pressure = at_nodes!(i => trial.pressure[i] - by_v[i]);
    trial.friction = at_nodes!(i => trial.friction[i] - trial.slope[i] * correction[i]);
    let rubbed = at_nodes!(i => trial.pressure[i] * trial.friction[i]);
    trial.flux = at_nodes!(i => rubbed[i] * v[i]);
    trial.acceleration = at_nodes!(i => rubbing.acceleration(trial.x[i], speed[i] - v[i], rubbed[i]));
    trial
}

/// A perturbation of the motion: of x, v, the fit h_U - u_w, and the sums of the heat modes.
#[derive(Clone, Copy, Debug)]
pub struct Perturbation<R> {
    pub x: R,
    pub v: R,
    pub fit: R,
    pub heat: Heat<R>,
    /// Perturbation of the heat flux at the step's start.
    pub flux: R,
}

impl<R> Perturbation<R> {
    /// All of its numbers, each of which is a linear function of the perturbation.
    #[inline(always)]
    pub fn parts(&mut self) -> [&mut R; 6] {
        [
            &mut self.x,
            &mut self.v,
            &mut self.fit,
            &mut self.heat.pressure,
            &mut self.heat.falloff,
            &mut self.flux,
        ]
    }
}

impl<R: Real> Trial<R> {
    /// The sum S of w_m r_m q_m, to which the surface temperature is proportional, at the nodes. It follows from the balance of
    /// heat, (w . q)' = 2 gamma Q - S.
    #[inline(always)]
    pub fn falloff(&self, rubbing: &Rubbing<R>, start: &Start<R>, h: R, end: Heat<R>) -> Vector<R> {
        let start_slope = h * rubbing.two_gamma.mul_add(start.flux, -start.heat.falloff);
        let end_slope = h * rubbing.two_gamma.mul_add(self.flux[2], -end.falloff);
        let inverse_h = R::splat(1.0) / h;
        let mut falloff = [end.falloff; 3];
        for i in 0..2 {
            let [value_0, slope_0, value_1, slope_1]: [R; 4] = constants(HERMITE_SLOPE[i]);
            let slope = value_0.mul_add(
                start.heat.pressure,
                slope_0.mul_add(start_slope, value_1.mul_add(end.pressure, slope_1 * end_slope)),
            );
            falloff[i] = rubbing.two_gamma.mul_add(self.flux[i], -(slope * inverse_h));
        }
        falloff
    }

    /// The divergence of the flow of (x, y) at the nodes, at constant pressure: -eps p F'(v) - eps h1.
    #[inline(always)]
    pub fn divergence(&self, rubbing: &Rubbing<R>) -> Vector<R> {
        at_nodes!(i => -(rubbing.epsilon * self.pressure[i]).mul_add(self.slope[i], rubbing.damping))
    }

    /// Pressure lost by wear over the step.
    #[inline(always)]
    pub fn worn(&self, rubbing: &Rubbing<R>, h: R) -> R {
        let rate = at_nodes!(i => self.v[i].abs() * self.pressure[i]);
        rubbing.k_w * h * integral(rate)
    }

    /// Carries a perturbation over the step, by the derivative of the step itself. Returns the perturbation at the end, without
    /// its heat modes, and that of the flux at the nodes, which drives the modes.
    #[inline(always)]
    pub fn perturbed(
        &self,
        rubbing: &Rubbing<R>,
        start: &Start<R>,
        h: R,
        memory: &Memory<R>,
        at: &Perturbation<R>,
    ) -> (Perturbation<R>, Vector<R>) {
        // perturbed heat modes obey the same linear map: `memory` has the free sums of the perturbed modes; `response` and `by_v`
        // already contain the effect of the flux
        let offset = InnerHeat::new(rubbing, h, at.heat, at.flux, memory).offset;
        let free = apply(&self.response, at_nodes!(i => start.contact * (offset[i] + at.fit)));
        let pull = at_nodes!(i => {
            let rubbed = rubbing.epsilon * self.friction[i];
            // the perturbation of x at the nodes, without the effect of that of v there
            rubbing.stiffness(self.x[i]).mul_add(at.x, rubbed * free[i])
        });
        let integrated = integrals(pull);
        let v = apply(&self.newton, at_nodes!(i => at.v - h * integrated[i]));
        let by_v = apply(&self.by_v, v);
        let pressure = at_nodes!(i => free[i] + by_v[i]);
        let flux = at_nodes!(i => {
            let sliding = self.friction[i] * self.v[i];
            let by_heat = self.slope[i].mul_add(self.v[i], self.friction[i]) * self.pressure[i];
            sliding.mul_add(pressure[i], by_heat * v[i])
        });
        let zero = R::splat(0.0);
        let worn = at_nodes!(i => {
            let pressed = R::select(self.v[i].less(zero), -self.pressure[i], self.pressure[i]);
            self.v[i].abs().mul_add(pressure[i], pressed * v[i])
        });
        let end = Perturbation {
            // x' = y and the shaft is not perturbed
            x: at.x - h * integral(v),
            v: v[2],
            fit: at.fit - rubbing.k_w * h * integral(worn),
            heat: memory.end(parabola(flux)),
            flux: flux[2],
        };
        (end, flux)
    }
}
