//! Where steps end: at the boundaries of the friction layer, and where contact is lost or comes back.
//!
//! Owns the search for these ends and the passage to the next piece of the friction law; takes no steps. Twin:
//! `shaders/dynamics/adaptive/events.wgsl`.

use super::{Control, Orbit};
use crate::dynamics::decay::single;
use crate::dynamics::dense::Cubic;
use crate::dynamics::matrix::at_nodes;
use crate::dynamics::radau::{NODES, Start, Trial};
use crate::lanes::{Mask, Real};
use crate::model::rubbing::{NO_LAYER, Rubbing};

/// A step is cut if it ends farther than this beyond a boundary of the friction layer, in units of [`Control::reach`]. The cut
/// step aims at one reach beyond the boundary. A lane on its way out passes to the next piece as soon as it is less than one
/// reach before the boundary. Between these limits v may turn back without switching to and fro.
pub const CUT: f64 = 4.0;

/// A step may be this many times as long as its error allows, if it then ends at a boundary of the friction layer. A boundary that is
/// farther, but nearer than two steps, is reached in two steps of equal length.
pub const STRETCH: f64 = 1.1;

/// Stands for infinity: the bound of a sliding velocity that meets no boundary.
pub(super) const FAR: f64 = 1e30;

impl<R: Real> Orbit<R> {
    #[inline(always)]
    pub(super) fn piece_of(&self, rubbing: &Rubbing<R>) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        R::select((-rubbing.epsilon_0).less(self.v), one, zero)
            + R::select(zero.less(self.v), one, zero)
            + R::select(rubbing.epsilon_0.less(self.v), one, zero)
    }

    /// The part of the trial that stays on its piece of the friction law and in its state of contact, and whether this is the
    /// whole trial.
    #[inline(always)]
    pub(super) fn cut(
        &self,
        rubbing: &Rubbing<R>,
        control: &Control<R>,
        start: &Start<R>,
        trial: &Trial<R>,
        sliding: &Cubic<R>,
    ) -> (R, R::Mask) {
        let [low, high] = self.bounds(rubbing);
        let reach = control.reach * rubbing.epsilon_0;
        let margin = R::splat(CUT) * reach;
        let (above, stays_below) = stays(sliding, trial.v, high + margin, high + reach);
        let fallen = at_nodes!(i => -trial.v[i]);
        let (below, stays_above) = stays(&sliding.negative(), fallen, margin - low, reach - low);

        // a signal that rises above 0 where contact changes: -p in contact; in the gap, the pressure that there would be in
        // contact
        let gap = self.contact.less(R::splat(0.5));
        let before = R::select(gap, self.fit + self.heat.pressure, -start.pressure);
        let signals = at_nodes!(i => R::select(gap, trial.if_closed[i], -trial.pressure[i]));
        let allowed = contact_tolerance(self.fit);
        let (lasting, lasts) = stays(&Cubic::new(before, signals), signals, allowed, allowed * R::splat(0.5));
        (above.min(below).min(lasting), stays_below.and(stays_above).and(lasts))
    }

    /// The boundaries of the piece of the friction law that v is on. In the gap, and without dry friction, there are none.
    #[inline(always)]
    fn bounds(&self, rubbing: &Rubbing<R>) -> [R; 2] {
        let (half, far) = (R::splat(0.5), R::splat(FAR));
        let free = self
            .contact
            .less(half)
            .or(R::splat(0.5 * NO_LAYER).less(rubbing.epsilon_0));
        let lowest = free.or(self.piece.less(half));
        let highest = free.or(R::splat(2.5).less(self.piece));
        let low = (self.piece - R::splat(2.0)) * rubbing.epsilon_0;
        [
            R::select(lowest, -far, low),
            R::select(highest, far, low + rubbing.epsilon_0),
        ]
    }

    /// Moves a lane to the next piece if it has reached it. `before` is v at the start of the last step.
    #[inline(always)]
    pub(super) fn switch(&mut self, rubbing: &Rubbing<R>, control: &Control<R>, before: R) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let [low, high] = self.bounds(rubbing);
        let reach = control.reach * rubbing.epsilon_0;
        let up = (high - reach).less(self.v).and(before.less(self.v));
        let down = self.v.less(low + reach).and(self.v.less(before));
        self.piece = self.piece + R::select(up, one, zero) - R::select(down, one, zero);
    }

    /// The length of the next step, which is to end at the next boundary of the friction layer if v reaches it soon, and else is
    /// `free`. The last step had the length `ticks`; `sliding` is v in it.
    #[inline(always)]
    pub(super) fn landing(
        &self,
        rubbing: &Rubbing<R>,
        control: &Control<R>,
        sliding: &Cubic<R>,
        ticks: R,
        free: R,
    ) -> R {
        let [low, high] = self.bounds(rubbing);
        let reach = control.reach * rubbing.epsilon_0;
        let ahead = ticks * sliding.beyond([low - reach, high + reach]);
        // two equal steps, in place of a whole one and a very short one
        let half = R::splat(0.5) * ahead;
        let next = R::select(half.less(free), half, free);
        R::select(ahead.less(R::splat(STRETCH) * free), ahead, next)
    }
}

/// Whether a quantity stays below `allowed` during a step, also between the nodes. `values` are its values at the nodes, and
/// `cubic` goes through them. The first result is 1 if it stays, else the part of the step after which the quantity reaches
/// `aim`.
#[inline(always)]
fn stays<R: Real>(cubic: &Cubic<R>, values: [R; 3], allowed: R, aim: R) -> (R, R::Mask) {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let surely = cubic.stays_below(allowed);
    if surely.all() {
        return (one, surely);
    }
    let [first, second, last] = at_nodes!(i => values[i].less(allowed));
    let (highest, top) = cubic.maximum();
    let stays = surely.or(first.and(second).and(last).and(highest.less(allowed)));
    // `to` is the first node beyond, or the maximum between the nodes; `from` is the node before it, or the start
    let [c1, c2] = [NODES[0], NODES[1]].map(R::splat);
    let from = R::select(first, R::select(second, R::select(last, zero, c2), c1), zero);
    let to = R::select(first, R::select(second, R::select(last, top, one), c2), c1);
    let crossing = cubic.crossing(aim, from, to).max(R::splat(1e-3));
    (R::select(stays, one, crossing), stays)
}

/// A pressure that is below zero by no more than this counts as zero: p is a difference of numbers as large as the worn depth.
#[inline(always)]
fn contact_tolerance<R: Real>(fit: R) -> R {
    let unit = if single::<R>() { 4e-6 } else { 1e-6 };
    R::splat(unit) * (fit.abs() + R::splat(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(f: impl Fn(f64) -> f64, allowed: f64, aim: f64) -> (f64, bool) {
        let values = NODES.map(&f);
        stays(&Cubic::new(f(0.0), values), values, allowed, aim)
    }

    #[test]
    fn a_step_below_the_level_is_taken_whole() {
        assert_eq!(ends(|s| -1.0 + 0.5 * s, 0.0, -0.1), (1.0, true));
        // the Bezier points reach above the level; the cubic does not
        assert_eq!(ends(|s| -0.01 - 4.0 * (s - 0.4).powi(2), 0.0, -0.005), (1.0, true));
    }

    #[test]
    fn a_step_ends_where_a_quantity_first_comes_to_its_aim() {
        for crossing in [0.05, 0.3, 0.9] {
            let (part, stays) = ends(|s| s - crossing, 0.02, 0.01);
            assert!(!stays && (part - crossing - 0.01).abs() < 1e-12, "{crossing}: {part}");
        }
    }

    #[test]
    fn a_dip_between_the_nodes_ends_a_step() {
        // below the level at the start and at all three nodes (0.155, 0.645, 1), above it around the turn
        for (turn, width) in [(0.4, 0.2), (0.83, 0.15)] {
            let dip = |s: f64| width * width - (s - turn).powi(2);
            assert!(dip(0.0) < 0.0 && NODES.into_iter().all(|node| dip(node) < 0.0));
            let (part, stays) = ends(dip, 0.002, 0.001);
            assert!(!stays, "turn at {turn}");
            let expected = turn - (width * width - 0.001_f64).sqrt();
            assert!((part - expected).abs() < 1e-2, "turn at {turn}: {part} for {expected}");
        }
    }
}
