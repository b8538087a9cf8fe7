//! How much of a slice one dispatch carries out.
//!
//! Owns the arithmetic that keeps dispatches long enough to be worth their overhead, and short enough for drivers: they take a
//! device for hung if it does not answer for about two seconds. The backend knows what a dispatch is.

use std::time::Duration;

use super::layout::Span;
use crate::backend::Slice;

/// Duration that a dispatch should have.
const TARGET: Duration = Duration::from_millis(75);
/// A dispatch that lasts longer makes the next ones shorter.
const LONGEST: Duration = Duration::from_millis(100);
/// Steps of the first dispatch: few enough for it to be short on any device.
const FIRST_STEPS: u64 = 1 << 22;
/// After a dispatch that was too short, the next one has at most this many times its steps: a clock that rises, or a driver that
/// compiles during the first dispatch, makes single timings doubtful.
const FASTEST_GROWTH: f64 = 8.0;

/// What is known of the cost of a model's periods before the first dispatch.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    pub steps_per_period: u32,
    /// Most periods of a dispatch, however short they are.
    pub most_periods: u32,
    /// Whether steps of the next batch take as long as those of this batch.
    pub is_lasting: bool,
}

/// The batch that is dispatched in parts.
#[derive(Clone, Copy, Debug)]
pub struct Load {
    pub pace: Pace,
    pub instances: u32,
    /// Instances that a workgroup carries.
    pub workgroup_instances: u32,
    /// The device's limit of workgroups in a dispatch.
    pub max_workgroups: u32,
}

impl Load {
    /// Steps of one workgroup over `periods` periods.
    fn workgroup_steps(&self, periods: u32) -> u64 {
        u64::from(self.workgroup_instances) * u64::from(self.pace.steps_per_period) * u64::from(periods)
    }
}

/// Learns from every dispatch how many steps the next one may have.
#[derive(Clone, Debug)]
pub struct Pacer {
    /// Steps, summed over instances.
    steps: u64,
}

impl Default for Pacer {
    fn default() -> Self {
        Self { steps: FIRST_STEPS }
    }
}

impl Pacer {
    /// Advances a batch by a slice in as many dispatches as that takes; `dispatch` returns how long each of them took.
    ///
    /// # Errors
    /// The first error of `dispatch`.
    pub fn dispatch<E>(
        &mut self,
        load: &Load,
        slice: &Slice,
        mut dispatch: impl FnMut(Span) -> Result<Duration, E>,
    ) -> Result<(), E> {
        let mut done = 0;
        while done < slice.periods {
            let periods = self.periods(load, (slice.periods - done).min(load.pace.most_periods));
            let mut first_instance = 0;
            while first_instance < load.instances {
                let instances = self.instances(load, periods, load.instances - first_instance);
                let elapsed = dispatch(Span {
                    first_instance,
                    instances,
                    first: slice.first + done,
                    periods,
                    elapsed: slice.elapsed + done,
                    watched: u32::from(slice.stage.is_watched()),
                })?;
                self.record(load, periods, instances, elapsed);
                first_instance += instances;
            }
            done += periods;
        }
        Ok(())
    }

    /// By how many of the `left` periods the whole batch is advanced next: at least one, in as many dispatches as that takes.
    fn periods(&self, load: &Load, left: u32) -> u32 {
        let workgroups = load.instances.div_ceil(load.workgroup_instances);
        let periods = self.steps / (u64::from(workgroups.max(1)) * load.workgroup_steps(1));
        periods.clamp(1, left.into()) as u32
    }

    /// How many of the `left` instances the next dispatch advances by `periods`. They are whole workgroups. All dispatches get
    /// nearly equal numbers of them, since a small last one would leave the device idle.
    fn instances(&self, load: &Load, periods: u32, left: u32) -> u32 {
        let most = (self.steps / load.workgroup_steps(periods)).clamp(1, load.max_workgroups.into()) as u32;
        let workgroups = left.div_ceil(load.workgroup_instances);
        let ranges = workgroups.div_ceil(most);
        (workgroups.div_ceil(ranges) * load.workgroup_instances).min(left)
    }

    /// Learns that a dispatch of `instances` instances over `periods` periods took `elapsed`.
    fn record(&mut self, load: &Load, periods: u32, instances: u32, elapsed: Duration) {
        let steps = f64::from(periods) * f64::from(instances) * f64::from(load.pace.steps_per_period);
        let factor = TARGET.as_secs_f64() / elapsed.as_secs_f64().max(1e-9);
        if elapsed > LONGEST {
            self.steps = (steps * factor) as u64;
        } else {
            // a dispatch that was short because there was little work does not lower the number of steps
            self.steps = self.steps.max((steps * factor.min(FASTEST_GROWTH)) as u64);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::Stage;

    const LOAD: Load = Load {
        pace: Pace {
            steps_per_period: 628,
            most_periods: u32::MAX,
            is_lasting: true,
        },
        instances: 100_000,
        workgroup_instances: 64,
        max_workgroups: 65535,
    };

    /// Advances a batch; returns the size and the duration of each dispatch on a device that takes `seconds_a_step`.
    fn run(pacer: &mut Pacer, load: &Load, periods: u32, seconds_a_step: f64) -> Vec<(u32, u32, f64)> {
        let mut dispatches = Vec::new();
        let (mut done, mut first_instance) = (0, 0);
        let slice = Slice {
            stage: Stage::Transient,
            first: 0,
            periods,
            elapsed: 0,
        };
        let whole = pacer.dispatch(load, &slice, |span| {
            assert_eq!((span.first, span.first_instance), (done, first_instance));
            first_instance += span.instances;
            assert!(first_instance <= load.instances);
            if first_instance == load.instances {
                first_instance = 0;
                done += span.periods;
            }
            let steps = f64::from(span.periods) * f64::from(span.instances) * f64::from(load.pace.steps_per_period);
            let seconds = steps * seconds_a_step;
            dispatches.push((span.periods, span.instances, seconds));
            Ok::<_, std::convert::Infallible>(Duration::from_secs_f64(seconds))
        });
        assert_eq!((whole, done, first_instance), (Ok(()), periods, 0));
        dispatches
    }

    #[test]
    fn dispatches_settle_between_the_bounds_on_slow_and_fast_devices() {
        for seconds_a_step in [2e-8, 2e-9, 1e-10, 3e-12] {
            let mut pacer = Pacer::default();
            run(&mut pacer, &LOAD, 4000, seconds_a_step);
            let settled = run(&mut pacer, &LOAD, 4000, seconds_a_step);
            let longest = settled.iter().map(|dispatch| dispatch.2).fold(0.0, f64::max);
            let mean = settled.iter().map(|dispatch| dispatch.2).sum::<f64>() / settled.len() as f64;
            assert!(longest <= LONGEST.as_secs_f64(), "{seconds_a_step}: {longest}");
            assert!(mean > 0.04, "{seconds_a_step}: {mean}");
        }
    }

    #[test]
    fn no_dispatch_is_long_on_a_slow_device_nor_when_it_slows_down() {
        let mut pacer = Pacer::default();
        let longest = |dispatches: &[(u32, u32, f64)]| dispatches.iter().map(|dispatch| dispatch.2).fold(0.0, f64::max);
        assert!(longest(&run(&mut pacer, &LOAD, 100, 2e-8)) < 0.1);
        let slowed = run(&mut pacer, &LOAD, 100, 1e-7);
        assert!(longest(&slowed) < 0.5 && longest(&slowed[1..]) < 0.1);
    }

    #[test]
    fn a_dispatch_short_for_want_of_work_does_not_shrink_the_next() {
        let mut pacer = Pacer::default();
        run(&mut pacer, &LOAD, 400, 1e-9);
        let before = pacer.steps;
        let small = Load { instances: 3, ..LOAD };
        pacer.record(&small, 1, 3, Duration::from_millis(20));
        assert_eq!(pacer.steps, before);
    }

    #[test]
    fn ranges_keep_to_the_device_s_limit_and_are_nearly_equal() {
        let load = Load {
            instances: 200_001,
            workgroup_instances: 1,
            ..LOAD
        };
        let pacer = Pacer { steps: 1 << 40 };
        let counts: Vec<u32> = run(&mut pacer.clone(), &load, 1, 1e-12)
            .iter()
            .map(|dispatch| dispatch.1)
            .collect();
        assert_eq!(counts, [50001, 50000, 50000, 50000]);
    }

    #[test]
    fn even_one_workgroup_s_period_is_dispatched_when_nothing_smaller_is_possible() {
        let pacer = Pacer { steps: 1 };
        assert_eq!(pacer.periods(&LOAD, 16), 1);
        assert_eq!(pacer.instances(&LOAD, 1, LOAD.instances), 64);
        assert_eq!(pacer.instances(&LOAD, 1, 5), 5);
    }
}
