//! `point --lifetime`: how long chaos lasts from many initial states.

use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::analysis::{self, Claim, OutArgs};
use super::request::{self, Checked};
use super::{Failure, si};
use crate::analysis::lifetime::{Decay, LEAST_LEFT, Survival, exponent};
use crate::analysis::settling::{self, End, NEAR};
use crate::design::Coordinate;
use crate::engine::{Backends, Event, initial_states};
use crate::experiment::{Experiment, InitialBox, Request, Sampling};
use crate::machine::Scale;
use crate::output::PROGRAM;
use crate::parameters::Parameter;
use crate::picture::caption;
use crate::picture::charts::{self, survival};
use crate::picture::sheet::Sheet;

#[derive(Args, Clone, Copy, Serialize, Deserialize)]
#[command(next_help_heading = "Lifetime of chaos")]
#[serde(deny_unknown_fields)]
pub struct LifetimeArgs {
    /// Estimate how long chaos lasts: many initial states from the initial box are followed, and the time is recorded at which
    /// each settles on a regular attractor. Writes a drawing and a table
    #[arg(long, value_name = "STATES", num_args = 0..=1, default_missing_value = "1000",
          value_parser = clap::value_parser!(u32).range(100..=100_000))]
    pub lifetime: Option<u32>,
    /// Forcing periods over which the states are followed [default: 4000]
    #[arg(long, value_name = "PERIODS", requires = "lifetime", value_parser = clap::value_parser!(u32).range(100..=200_000))]
    lifetime_periods: Option<u32>,
}

impl Checked for LifetimeArgs {
    fn check(&self) -> Result<(), String> {
        request::in_range("lifetime", self.lifetime, 100..=100_000)?;
        request::in_range("lifetime_periods", self.lifetime_periods, 100..=200_000)
    }
}

const DEFAULT_PERIODS: u32 = 4000;

/// Most work of an estimate: a quarter of an hour on two cores.
const MOST_INSTANCE_PERIODS: u64 = 1_000_000_000;

/// The initial states to follow, the number of periods, and the files for the results.
pub struct Plan {
    starts: Vec<[f64; 2]>,
    longest: u32,
    files: Claim,
}

impl LifetimeArgs {
    /// The plan, or None without `--lifetime`; checks that its files may be written.
    ///
    /// # Errors
    /// If there is no chaos that could end, it would take too long, or the files are those of something else.
    pub fn plan(&self, experiment: &Experiment, written: &Request, out: &OutArgs) -> Result<Option<Plan>, Failure> {
        let Some(states) = self.lifetime else {
            return Ok(None);
        };
        experiment.check_lasting().map_err(Failure::input)?;
        if !experiment.design.point(0).is_driven() {
            return Err(Failure::Input(anyhow::anyhow!(
                "without a drive (zeta_k = 0, or no friction) there is no chaos whose lifetime could be told: leave --lifetime out"
            )));
        }
        let longest = self.lifetime_periods.unwrap_or(DEFAULT_PERIODS);
        let instance_periods = u64::from(states) * u64::from(longest);
        if instance_periods > MOST_INSTANCE_PERIODS {
            return Err(Failure::Input(anyhow::anyhow!(
                "{states} states over {longest} periods are {instance_periods} periods to go through (at most \
                 {MOST_INSTANCE_PERIODS}): give --lifetime fewer states, or --lifetime-periods less"
            )));
        }
        // `offsets` leaves out the first state, which is (x0, y0) and not from the box
        let starts = initial_states::offsets(&Sampling {
            initial_states: states + 1,
            ..experiment.settings.sampling
        });
        let files = Claim::new(out, "outputs/lifetime", &[""], written)?;
        Ok(Some(Plan { starts, longest, files }))
    }
}

/// The result of the estimate.
pub struct Estimate {
    survival: Survival,
    decay: Decay,
    /// Exponent of the motion before it settles, per unit of tau, and its standard error.
    exponent: Option<[f64; 2]>,
    /// Whether the exponent is more than three standard errors above zero.
    is_chaotic: bool,
    given_up: usize,
    files: Claim,
}

impl Plan {
    /// Follows the states, and draws.
    pub fn carry_out(self, experiment: &Experiment, backends: &mut Backends) -> Result<Estimate, Failure> {
        let Self {
            starts,
            longest,
            mut files,
        } = self;
        let settings = &experiment.settings;
        let at = experiment.design.point(0);
        let periods = u64::from(longest + settling::confirming(settings));
        let fates = analysis::compute(starts.len() as u64 * periods, starts.len(), |observer| {
            let mut hear = |periods| observer(Event::Advanced(periods));
            settling::follow(backends.active_mut(), settings, &at, &starts, longest, &mut hear)
        })?;
        let given_up = fates.iter().filter(|fate| fate.end == End::GivenUp).count();
        let survival = Survival::of(&fates, longest);
        if survival.states() < LEAST_LEFT {
            return Err(Failure::Run(anyhow::anyhow!(
                "{given_up} of {} initial states were given up as under-resolved, and tell no lifetime: set \
                 parameters at which `tribochaos point` measures one",
                starts.len()
            )));
        }
        let decay = survival.decay();
        let exponent = exponent(&fates, decay.start()).map(|of| of.map(|rate| rate / at.forcing_period()));
        let is_chaotic = exponent.is_some_and(|[rate, error]| rate > 3.0 * error);
        // a regular approach to an attractor has no lifetime of chaos, whatever the distribution of its times
        let decay = if is_chaotic { decay } else { Decay::Other };

        let InitialBox { x, y } = settings.sampling.initial_box;
        let left_out = match given_up {
            0 => String::new(),
            given_up => format!("{given_up} states that were given up as under-resolved are left out. "),
        };
        let kind = backends.active().kind();
        let numerics = format!(
            "{} initial states, drawn uniformly from (x, y) = {} to {} (seed {}), followed over {longest} forcing periods. A state \
             has settled once it stays within {NEAR} of the cycle on which it ends. {left_out}{}, {}. {PROGRAM}.",
            starts.len(),
            charts::start([x[0], y[0]]),
            charts::start([x[1], y[1]]),
            settings.sampling.seed,
            caption::scheme(settings),
            caption::integrated_on([kind].into_iter())
        );
        let start: [Coordinate; 2] = [Parameter::X0.into(), Parameter::Y0.into()];
        let caption = vec![caption::fixed(&experiment.design.fixed, &start), numerics];
        let sheet = Sheet::single(survival::survival(&survival, &decay), caption);
        files.draw("", &sheet, "Lifetime of chaos of the bush-shaft system")?;
        let rows = survival.steps().into_iter().map(|(time, left)| {
            let fitted = match decay {
                Decay::Exponential(fit) if time >= fit.start => fit.left_after(f64::from(time), 0.0),
                _ => f64::NAN,
            };
            let states = survival.states() as f64;
            [f64::from(time), left as f64, left as f64 / states, fitted / states]
        });
        files.table(
            "",
            &["states that have not settled after so many forcing periods, until the next row; fitted: their fraction by the \
               exponential fit"
                .to_owned()],
            ["periods", "states", "fraction", "fitted"],
            rows,
        )?;
        Ok(Estimate {
            survival,
            decay,
            exponent,
            is_chaotic,
            given_up,
            files,
        })
    }
}

impl Estimate {
    /// Reports the estimate: within `object`, or as text after that of `print`.
    pub fn tell(&self, experiment: &Experiment, object: Value, print: impl FnOnce()) {
        self.files.tell(
            experiment,
            || self.within(object, experiment),
            || {
                print();
                self.print(experiment);
            },
        );
    }

    fn within(&self, mut object: Value, experiment: &Experiment) -> Value {
        let period = experiment.design.point(0).forcing_period();
        let decay = match self.decay {
            Decay::Exponential(fit) => json!({
                "decay": "exponential",
                "lifetime": fit.lifetime,
                "lifetime_error": fit.error,
                "lifetime_tau": period * fit.lifetime,
                "start": fit.start,
                "left": fit.left,
                "escapes": fit.escapes,
                "ks_distance": fit.distance,
                "ks_limit": fit.distance_limit,
            }),
            Decay::Lasting {
                start,
                left,
                least_lifetime,
            } => json!({
                "decay": "none",
                "least_lifetime": least_lifetime,
                "start": start,
                "left": left,
            }),
            Decay::Other => json!({ "decay": if self.is_chaotic { "not exponential" } else { "no chaos" } }),
        };
        object["lifetime"] = decay;
        let of = &mut object["lifetime"];
        of["states"] = self.survival.states().into();
        of["periods"] = self.survival.longest.into();
        of["lasting"] = self.survival.lasting.into();
        of["under_resolved"] = self.given_up.into();
        of["half_settled_by"] = self.survival.settled_by(0.5).into();
        of["all_settled_by"] = self.survival.settled_by(1.0).into();
        of["is_chaotic"] = self.is_chaotic.into();
        of["exponent"] = self.exponent.map(|[rate, _]| rate).into();
        of["exponent_error"] = self.exponent.map(|[_, error]| error).into();
        if let (Decay::Exponential(fit), Some(machine)) = (self.decay, experiment.design.fixed.machine()) {
            object["si"]["lifetime_s"] = (machine.scales().time * period * fit.lifetime).into();
        }
        object
    }

    fn print(&self, experiment: &Experiment) {
        let survival = &self.survival;
        let (states, longest) = (survival.states(), survival.longest);
        let at = &experiment.design.fixed;
        let period = experiment.design.point(0).forcing_period();
        print_line!();
        match self.decay {
            Decay::Exponential(fit) => {
                let digits = fit.decimals();
                print_line!(
                    "mean lifetime       {:.digits$} +- {:.digits$} forcing periods{}",
                    fit.lifetime,
                    fit.error,
                    si::behind(at, period * fit.lifetime, Scale::Time)
                );
                print_line!(
                    "                    from period {} on, where {} of {states} initial states are left: {} settle, {} last \
                     beyond {longest}",
                    fit.start,
                    fit.left,
                    fit.escapes,
                    survival.lasting
                );
            }
            Decay::Other => print_line!(
                "lifetime of chaos   none: {}; of {states} initial states half have settled after {}, all after {}",
                if self.is_chaotic {
                    "the states do not decay exponentially"
                } else {
                    "the states settle without chaos"
                },
                by(survival.settled_by(0.5), longest),
                by(survival.settled_by(1.0), longest)
            ),
            Decay::Lasting {
                start,
                left,
                least_lifetime,
            } => print_line!(
                "mean lifetime       above {least_lifetime:.2e} forcing periods{} with 95 % confidence: of {states} initial states \
                 {left} are left at period {start}, and none settles until {longest}",
                si::behind(at, period * least_lifetime, Scale::Time)
            ),
        }
        if let Some([rate, error]) = self.exponent {
            print_line!("exponent until then {rate:.6} +- {error:.6}  (of the motion before it settles)");
        }
        if self.given_up > 0 {
            print_line!("left out            {} initial states, under-resolved", self.given_up);
        }
    }
}

/// When states have settled.
fn by(periods: Option<u32>, longest: u32) -> String {
    periods.map_or(format!("more than {longest} periods"), |periods| {
        format!("{periods} periods")
    })
}
