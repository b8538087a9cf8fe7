//! The mean lifetime of transient chaos, from the times at which many states have settled.
//!
//! Owns the statistics; follows no orbit.

use super::settling::{End, Fate};

/// A decay is examined only while at least this many states are left.
pub const LEAST_LEFT: usize = 20;

/// The Kolmogorov-Smirnov distance of n values from a uniform distribution, times (sqrt n + 0.12 + 0.11/sqrt n), exceeds this by
/// chance in 5 % of cases (M. A. Stephens, doi:10.1080/01621459.1974.10480196)...
const KOLMOGOROV: f64 = 1.358;

/// ...and the distance of a single value, to which the formula does not apply, exceeds this.
const SINGLE: f64 = 0.975;

/// A later start of the decay is tried if the number of states left is smaller by at least this part.
const FEWER: f64 = 0.01;

/// Some states settle after the time at which a decay first passes the test for exponential. The fit begins when this part of
/// them has settled. States that settle at once, of which the test overlooks a few, are gone by then. The later start does not
/// bias the fit, because an exponential decay has no memory.
const FLUSHED: f64 = 0.1;

/// How many of a number of states are still chaotic over time.
#[derive(Clone, Debug)]
pub struct Survival {
    /// Forcing periods after which states have settled, in rising order.
    settled: Vec<u32>,
    /// States that have not settled at the end.
    pub lasting: usize,
    /// Forcing periods over which the states were followed.
    pub longest: u32,
}

/// How the number of states that are left decays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decay {
    /// In every forcing period each state that is left settles with the same probability.
    Exponential(Fit),
    /// From some time on no state settles.
    Lasting {
        /// Forcing periods after which only the states that last are left.
        start: u32,
        /// States that last.
        left: usize,
        /// Lower bound of the mean lifetime with a confidence of 95 %, in forcing periods. By the rule of three it is a third of
        /// the time that all states together have lasted since `start`.
        least_lifetime: f64,
    },
    /// Neither of these: while at least [`LEAST_LEFT`] states are left, the probability changes from period to period, or the
    /// decaying motion is not chaotic.
    Other,
}

/// The exponential part of a decay. Times are in forcing periods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Where the fit begins: a tenth of the states that settle after the decay first passes the test for exponential are gone.
    pub start: u32,
    /// States that are left there.
    pub left: usize,
    /// The number of them that settle by the end.
    pub escapes: usize,
    /// Mean lifetime of a state.
    pub lifetime: f64,
    /// Standard error of the lifetime.
    pub error: f64,
    /// Kolmogorov-Smirnov distance between the escapes and an exponential decay.
    pub distance: f64,
    /// The distance that an exponential decay exceeds by chance in 5 % of cases.
    pub distance_limit: f64,
}

impl Survival {
    /// The survival of states that have settled after the given numbers of forcing periods, and of `lasting` states that have not
    /// settled by the `longest` time.
    pub fn new(mut settled: Vec<u32>, lasting: usize, longest: u32) -> Self {
        settled.sort_unstable();
        Self {
            settled,
            lasting,
            longest,
        }
    }

    /// The survival of orbits that were followed over `longest` forcing periods; those that were given up are left out.
    pub fn of(fates: &[Fate], longest: u32) -> Self {
        let settled = fates.iter().filter_map(|fate| match fate.end {
            End::Settled(periods) => Some(periods),
            End::Lasting | End::GivenUp => None,
        });
        let lasting = fates.iter().filter(|fate| fate.end == End::Lasting).count();
        Self::new(settled.collect(), lasting, longest)
    }

    /// Number of states, those that have settled and those that last.
    pub fn states(&self) -> usize {
        self.settled.len() + self.lasting
    }

    /// States that are still chaotic after so many forcing periods.
    pub fn left(&self, periods: u32) -> usize {
        self.states() - self.settled.partition_point(|&settled| settled <= periods)
    }

    /// Forcing periods after which the given part of the states has settled; None if fewer settle.
    pub fn settled_by(&self, part: f64) -> Option<u32> {
        let index = ((part * self.states() as f64).ceil() as usize).saturating_sub(1);
        self.settled.get(index).copied()
    }

    /// The start, the times at which the number of states left changes, and the end, each with the number of states left from
    /// then on.
    pub fn steps(&self) -> Vec<(u32, usize)> {
        let mut times: Vec<u32> = [0]
            .iter()
            .chain(&self.settled)
            .chain(&[self.longest])
            .copied()
            .collect();
        times.dedup();
        times.into_iter().map(|time| (time, self.left(time))).collect()
    }

    /// How the number decays, from the first time on at which the decay is [`Decay::Exponential`] or [`Decay::Lasting`].
    pub fn decay(&self) -> Decay {
        let mut tried = f64::INFINITY;
        for (start, left) in self.steps() {
            if left < LEAST_LEFT {
                break;
            }
            if left == self.lasting && start < self.longest {
                return Decay::Lasting {
                    start,
                    left,
                    least_lifetime: left as f64 * f64::from(self.longest - start) / 3.0,
                };
            }
            // a start with nearly the same states gives nothing new
            if left as f64 > (1.0 - FEWER) * tried {
                continue;
            }
            tried = left as f64;
            if self.fit(start).is_some()
                && let Some(fit) = self.fit(self.flushed(start))
            {
                return Decay::Exponential(fit);
            }
        }
        Decay::Other
    }

    /// Forcing periods after which the part [`FLUSHED`] of the states that settle after `start` is gone.
    fn flushed(&self, start: u32) -> u32 {
        let gone = self.settled.partition_point(|&settled| settled <= start);
        let flushed = (FLUSHED * (self.settled.len() - gone) as f64) as usize;
        if flushed == 0 {
            start
        } else {
            self.settled[gone + flushed - 1]
        }
    }

    /// The exponential decay from `start` on, if some state settles later; None if the distance shows that the decay is not
    /// exponential.
    ///
    /// Every period in which a state is left is a trial, which ends the chaos of this state with probability p. The most likely p
    /// is therefore the number of escapes over the number of trials, however many states last. The lifetime is -1/ln(1 - p). If
    /// all trials succeed with the same probability, the successes are spread evenly over the trials in their order, which is the
    /// total time on test.
    fn fit(&self, start: u32) -> Option<Fit> {
        let left = self.left(start);
        let later = &self.settled[self.settled.len() - (left - self.lasting)..];
        let escapes = later.len();
        let trials_until = |done: f64, index: usize, time: u32| done + (left - index) as f64 * f64::from(time - start);
        let trials = trials_until(
            later.iter().map(|&time| f64::from(time - start)).sum(),
            escapes,
            self.longest,
        );
        // if no state lasts, the last trial is always a success
        let free = f64::from(u8::from(self.lasting == 0));
        let part = |count: usize| (count as f64 / (escapes as f64 - free)).min(1.0);
        let (mut distance, mut done, mut index) = (0.0f64, 0.0, 0);
        while index < escapes {
            let time = later[index];
            let next = index + later[index..].partition_point(|&other| other == time);
            // at the end of the period before, and at the end of this one
            for (time, count) in [(time - 1, index), (time, next)] {
                let even = (trials_until(done, index, time) / (trials - free)).min(1.0);
                distance = distance.max((part(count) - even).abs());
            }
            done += (next - index) as f64 * f64::from(time - start);
            index = next;
        }
        let root = (escapes as f64 - free).sqrt();
        let distance_limit = (KOLMOGOROV / (root + 0.12 + 0.11 / root)).min(SINGLE);
        let p = escapes as f64 / trials;
        // a probability of 1 gives no lifetime
        if p >= 1.0 || distance > distance_limit {
            return None;
        }
        let lifetime = -1.0 / (-p).ln_1p();
        Some(Fit {
            start,
            left,
            escapes,
            lifetime,
            error: lifetime * lifetime * p / (escapes as f64 * (1.0 - p)).sqrt(),
            distance,
            distance_limit,
        })
    }
}

impl Fit {
    /// Decimal places of the lifetime that show two digits of its error.
    pub fn decimals(&self) -> usize {
        (1.0 - self.error.log10().floor()).max(0.0) as usize
    }

    /// States that are left after `periods` forcing periods by the fit, for a lifetime that differs from the fitted one by
    /// `errors` standard errors.
    pub fn left_after(&self, periods: f64, errors: f64) -> f64 {
        let lifetime = self.lifetime + errors * self.error;
        // no lifetime is negative
        let rate = if lifetime > 0.0 { 1.0 / lifetime } else { f64::INFINITY };
        self.left as f64 * (-(periods - f64::from(self.start)) * rate).exp()
    }
}

impl Decay {
    /// Forcing periods after which the decay begins; 0 for [`Decay::Other`].
    pub fn start(&self) -> u32 {
        match *self {
            Self::Exponential(Fit { start, .. }) | Self::Lasting { start, .. } => start,
            Self::Other => 0,
        }
    }
}

/// Exponent of the motion before it settles, and the standard error of the exponent, per forcing period, over the states that are
/// left at `start`. None if too few states last long enough.
pub fn exponent(fates: &[Fate], start: u32) -> Option<[f64; 2]> {
    let growths: Vec<[f64; 2]> = fates
        .iter()
        .filter(|fate| match fate.end {
            End::Settled(periods) => periods > start,
            End::Lasting => true,
            End::GivenUp => false,
        })
        .map(|fate| fate.growth)
        .filter(|[_, periods]| *periods > 0.0)
        .collect();
    if growths.len() < LEAST_LEFT {
        return None;
    }
    let [growth, periods] = [0, 1].map(|i| growths.iter().map(|of| of[i]).sum::<f64>());
    let rate = growth / periods;
    // the standard error of a ratio of two sums over independent states
    let squares: f64 = growths
        .iter()
        .map(|[growth, periods]| (growth - rate * periods).powi(2))
        .sum();
    Some([rate, squares.sqrt() / periods])
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;

    /// Random times, in whole periods, of an exponential decay after a delay, and the number of states that last beyond the
    /// longest time.
    fn exponential(seed: u64, states: usize, delay: f64, lifetime: f64, longest: u32) -> (Vec<u32>, usize) {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let mut settled = Vec::new();
        for _ in 0..states {
            let unit = ((generator.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
            let time = (delay - lifetime * unit.ln()).ceil();
            if time <= f64::from(longest) {
                settled.push(time as u32);
            }
        }
        let lasting = states - settled.len();
        (settled, lasting)
    }

    #[track_caller]
    fn fit(decay: Decay) -> Fit {
        match decay {
            Decay::Exponential(fit) => fit,
            other => panic!("{other:?}"),
        }
    }

    /// Two standard errors cover the lifetime in 95 % of cases, however many states last, and for short lifetimes, too.
    #[test]
    fn errors_cover_what_they_claim() {
        const SEEDS: u64 = 400;
        for (states, lifetime, longest) in [
            (1000, 300.0, 4000),
            (1000, 5000.0, 1000),
            (200, 80.0, 2000),
            (500, 2.5, 100),
        ] {
            let decays: Vec<Survival> = (0..SEEDS)
                .map(|seed| {
                    let (settled, lasting) = exponential(seed, states, 0.0, lifetime, longest);
                    Survival::new(settled, lasting, longest)
                })
                .collect();
            let fits: Vec<Fit> = decays.iter().map(|survival| fit(survival.decay())).collect();
            let off = |fit: &Fit| (fit.lifetime - lifetime) / fit.error;
            let covered = fits.iter().filter(|fit| off(fit).abs() < 2.0).count() as f64 / SEEDS as f64;
            assert!((0.92..=0.98).contains(&covered), "{lifetime}: {covered}");
            let bias = fits.iter().map(off).sum::<f64>() / SEEDS as f64;
            assert!(bias.abs() < 0.2, "{lifetime}: {bias}");
            // the test of the shape rejects one in twenty; fewer where a period is long compared with the lifetime
            let from_the_start =
                decays.iter().filter(|survival| survival.fit(0).is_some()).count() as f64 / SEEDS as f64;
            let most = if lifetime < 10.0 { 1.0 } else { 0.99 };
            assert!((0.92..=most).contains(&from_the_start), "{lifetime}: {from_the_start}");
        }
    }

    #[test]
    fn the_error_is_that_of_the_escapes() {
        let (settled, lasting) = exponential(1, 1000, 0.0, 2000.0, 1000);
        let escapes = settled.len();
        let time: u32 = settled.iter().sum::<u32>() + 1000 * lasting as u32;
        let fit = Survival::new(settled, lasting, 1000).fit(0).unwrap();
        // the textbook's values, for continuous time
        let lifetime = f64::from(time) / escapes as f64;
        assert_eq!((fit.escapes, fit.left), (escapes, 1000));
        assert!((fit.lifetime / (lifetime - 0.5) - 1.0).abs() < 1e-4);
        assert!((fit.error / (lifetime / (escapes as f64).sqrt()) - 1.0).abs() < 1e-2);
    }

    #[test]
    fn lifetimes_have_the_digits_that_their_errors_leave() {
        let (settled, lasting) = exponential(1, 1000, 0.0, 2000.0, 1000);
        let fit = Survival::new(settled, lasting, 1000).fit(0).unwrap();
        for (error, decimals) in [(0.034, 3), (5.7, 1), (12.0, 0), (4e5, 0)] {
            assert_eq!(Fit { error, ..fit }.decimals(), decimals);
        }
    }

    #[test]
    fn the_decay_begins_where_it_is_exponential() {
        // half of the states are in a basin's immediate neighbourhood, and the others take 40 periods at least
        let (mut settled, lasting) = exponential(3, 500, 40.0, 200.0, 3000);
        settled.extend((0..500).map(|k| 5 + k % 9));
        let fit = fit(Survival::new(settled, lasting, 3000).decay());
        assert!((40..90).contains(&fit.start) && fit.left > 400, "{fit:?}");
        assert!((fit.lifetime - 200.0).abs() < 3.0 * fit.error, "{fit:?}");
    }

    /// The states that settle at once are too few for the test of the shape, but enough for a bias of one standard error.
    #[test]
    fn a_few_that_settle_at_once_do_not_shorten_the_lifetime() {
        const SEEDS: u64 = 200;
        let off = |seed: u64| {
            let (mut settled, lasting) = exponential(seed, 965, 0.0, 370.0, 4000);
            settled.extend((0..35).map(|k| 5 + k % 9));
            let fit = fit(Survival::new(settled, lasting, 4000).decay());
            (fit.lifetime - 370.0) / fit.error
        };
        let bias = (0..SEEDS).map(off).sum::<f64>() / SEEDS as f64;
        assert!(bias.abs() < 0.25, "{bias}");
    }

    #[test]
    fn what_lasts_has_a_least_lifetime() {
        let lasting = Survival::new(Vec::new(), 300, 1000).decay();
        assert_eq!(
            lasting,
            Decay::Lasting {
                start: 0,
                left: 300,
                least_lifetime: 1e5
            }
        );
        // beside chaos that lasts, other states are on their way to a cycle
        let settled: Vec<u32> = (0..700).map(|k| 10 + k % 20).collect();
        let decay = Survival::new(settled, 300, 1029).decay();
        assert_eq!(decay, lasting_from(29, 300, 1e5));
        // a single late state among them does not count as a decay of the others
        let mut settled: Vec<u32> = (0..699).map(|k| 10 + k % 20).collect();
        settled.push(35);
        assert_eq!(Survival::new(settled, 300, 1035).decay(), lasting_from(35, 300, 1e5));
    }

    fn lasting_from(start: u32, left: usize, least_lifetime: f64) -> Decay {
        Decay::Lasting {
            start,
            left,
            least_lifetime,
        }
    }

    /// If the lifetime is equal to the bound, no state settles in one of twenty decays.
    #[test]
    fn the_least_lifetime_has_a_confidence_of_95_percent() {
        let Decay::Lasting { least_lifetime, .. } = Survival::new(Vec::new(), 100, 300).decay() else {
            panic!("all last")
        };
        let without = (0..2000)
            .filter(|&seed| exponential(seed, 100, 0.0, least_lifetime, 300).0.is_empty())
            .count();
        assert!((70..=130).contains(&without), "{without}");
    }

    #[test]
    fn an_approach_is_no_exponential_decay() {
        let narrow: Vec<u32> = (0..1000).map(|k| 20 + k % 12).collect();
        assert_eq!(Survival::new(narrow, 0, 4000).decay(), Decay::Other);
        let at_once = vec![7; 1000];
        let survival = Survival::new(at_once, 0, 4000);
        assert_eq!(survival.decay(), Decay::Other);
        assert_eq!(survival.settled_by(0.5), Some(7));
        assert_eq!(Survival::new(vec![1; 1000], 0, 4000).decay(), Decay::Other);
        assert_eq!(Survival::new(vec![0; 1000], 0, 4000).decay(), Decay::Other);
    }

    #[test]
    fn steps_are_the_states_that_are_left() {
        let survival = Survival::new(vec![5, 3, 3], 1, 10);
        assert_eq!(survival.steps(), [(0, 4), (3, 2), (5, 1), (10, 1)]);
        assert_eq!((survival.left(2), survival.left(3), survival.left(10)), (4, 2, 1));
        assert_eq!((survival.settled_by(0.75), survival.settled_by(1.0)), (Some(5), None));
    }

    #[test]
    fn the_exponent_is_that_of_the_time_before() {
        let fate = |end, growth| Fate { end, growth };
        let mut fates: Vec<Fate> = (0..100)
            .map(|k| fate(End::Settled(200), [100.0 + f64::from(k % 2), 184.0]))
            .collect();
        let early = vec![fate(End::Settled(30), [-14.0, 14.0]); 100];
        fates.extend(early);
        fates.push(fate(End::GivenUp, [0.0; 2]));
        let [rate, error] = exponent(&fates, 50).unwrap();
        assert!((rate - 100.5 / 184.0).abs() < 1e-12 && (error - 0.05 / 184.0).abs() < 1e-12);
        assert_eq!(exponent(&fates, 200), None);
    }
}
