//! Texts about a map: before its run, after it, and about its audit.

use std::fmt::Write as _;
use std::time::Duration;

use serde_json::{Value, json};

use crate::design::{Coordinate, Spacing, Varied};
use crate::engine::audit::Audit;
use crate::engine::choice::Choice;
use crate::engine::{self, Backends, Work};
use crate::experiment::{Experiment, Scheme, Settings};
use crate::machine::units::si;
use crate::map::{self, ParameterMap};
use crate::measure::{Class, Quantity, is_scheme_to_blame};
use crate::results::Tally;

/// The plan of an experiment, in one line.
pub fn plan(experiment: &Experiment) -> String {
    let settings = &experiment.settings;
    let axes = experiment.design.axes();
    let mut plan = String::from(if axes.len() == 2 { "map" } else { "scan" });
    let value = |coordinate: Coordinate, value: f64| match coordinate {
        Coordinate::Parameter(_) => value.to_string(),
        Coordinate::Si(_) => si(value, experiment.design.fixed.unit(coordinate)),
    };
    if let Varied::Points(points) = &experiment.design.varied {
        let ends = points.coordinates().iter().zip(points.ends());
        let ends = ends.map(|(&coordinate, [least, greatest])| {
            let [least, greatest] = [least, greatest].map(|end| value(coordinate, rounded(end)));
            format!("{coordinate} = {least}..{greatest}")
        });
        let _ = write!(plan, " over points in {}", ends.collect::<Vec<_>>().join(", "));
    }
    for (place, axis) in std::iter::once("over").chain(std::iter::repeat("by")).zip(axes) {
        let value = |end: f64| value(axis.coordinate, end);
        let values = match axis.spacing() {
            Spacing::Even { start, stop, .. } => format!("{}..{}", value(*start), value(*stop)),
            Spacing::Logarithmic { start, stop, .. } => format!("{}..{}, logarithmic", value(*start), value(*stop)),
            Spacing::Listed(_) => {
                let [least, greatest] = axis.ends();
                format!("a list from {} to {}", value(least), value(greatest))
            }
        };
        let _ = write!(plan, " {place} {} = {values} ({})", axis.coordinate, axis.count());
    }
    let _ = write!(
        plan,
        ": {} points{}, {} of {} {} steps{}",
        experiment.design.len(),
        if settings.sampling.initial_states > 1 {
            format!(" x {} initial states", settings.sampling.initial_states)
        } else {
            String::new()
        },
        if experiment.wears() {
            format!("{} periods from the start", settings.sampling.periods)
        } else {
            format!(
                "{} + {} periods",
                settings.sampling.transient_periods, settings.sampling.periods
            )
        },
        settings.integration.steps_per_period,
        settings.integration.scheme.name(),
        if experiment.decides_early() {
            ", unless decided early"
        } else {
            ""
        }
    );
    plan
}

pub fn device(choice: &Choice) -> String {
    format!("on {} ({})", choice.backends.active().device(), choice.reason)
}

/// On what something runs that may run on several devices at once, and why.
pub fn devices(backends: &[Backends], reason: &str) -> String {
    let device = backends[0].active().device();
    match backends.len() {
        1 => format!("on {device} ({reason})"),
        count => format!("on {count} GPUs, the first of them {device} ({reason})"),
    }
}

/// Why points are under-resolved by a scheme, and what may resolve them.
pub fn remedy(settings: &Settings) -> &'static str {
    match settings.integration.scheme {
        Scheme::Taylor => {
            "neither taylor nor radau in f64, to which taylor leaves what is too stiff for it, could follow the motion; no \
             setting is known that does"
        }
        Scheme::Radau => {
            "the motion needs shorter steps, or more of them in a period, than there may be, or a number overflowed; \
             `tribochaos history` shows how far it goes"
        }
        Scheme::Rk4 => {
            "fixed steps do not resolve the motion; `tribochaos point` tells what the default scheme makes of a point"
        }
    }
}

/// Where the scheme's share in the errors comes from, or what makes it smaller.
pub fn finer(settings: &Settings) -> &'static str {
    match settings.integration.scheme {
        Scheme::Taylor => "it is what the sum of the exponents misses of the divergence, and rounding",
        Scheme::Radau => "a smaller --tolerance makes it smaller",
        Scheme::Rk4 => "more --steps-per-period make it smaller, and the default scheme has hardly any",
    }
}

/// A duration as people say it.
pub fn duration(duration: Duration) -> String {
    let seconds = duration.as_secs_f64();
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// Points of a map by class and status.
struct Counts {
    /// In the order of [`Class::ALL`].
    classes: [usize; Class::ALL.len()],
    computed: usize,
    runaway: usize,
    under_resolved: usize,
}

impl Counts {
    fn of(map: &ParameterMap) -> Self {
        let points = map.experiment.design.len();
        let count = |is: &dyn Fn(usize) -> bool| (0..points).filter(|&index| is(index)).count();
        Self {
            classes: Class::ALL.map(|class| count(&|index| map.class(index) == Some(class))),
            computed: count(&|index| map.is_computed(index)),
            runaway: count(&|index| map.is_runaway(index)),
            under_resolved: count(&|index| map.is_under_resolved(index)),
        }
    }

    fn ok(&self) -> usize {
        self.computed - self.runaway - self.under_resolved
    }
}

/// A map for `--json`: its experiment, its points by class and status, and the share beyond the model's limits.
pub fn object(map: &ParameterMap) -> Value {
    let counts = Counts::of(map);
    let classes: serde_json::Map<String, Value> = Class::ALL
        .into_iter()
        .zip(counts.classes)
        .map(|(class, count)| (class.name().to_owned(), count.into()))
        .collect();
    let beyond: serde_json::Map<String, Value> = map
        .shares_beyond_limits()
        .into_iter()
        .map(|(limit, share)| (limit.to_owned(), share.into()))
        .collect();
    json!({
        "experiment": map.experiment.to_toml(),
        "points": map.experiment.design.len(),
        "computed": counts.computed,
        "classes": classes,
        "status": { "ok": counts.ok(), "runaway": counts.runaway, "under_resolved": counts.under_resolved },
        "share_beyond_limits": beyond,
    })
}

/// The summary of a computed map; `work` was done in `elapsed` on `devices`.
#[expect(
    clippy::too_many_lines,
    reason = "the code follows the report from its first line to its last"
)]
pub fn summary(map: &ParameterMap, work: &Work, elapsed: Duration, devices: &[String]) -> String {
    let mut text = String::new();
    let settings = &map.experiment.settings;
    let points = map.experiment.design.len();
    if work.points == 0 {
        let _ = writeln!(
            text,
            "all {points} points were in the store already; --force computes them again"
        );
    } else {
        let rate = work.instance_periods as f64 / elapsed.as_secs_f64();
        let took = duration(elapsed);
        let devices = devices.join(", then ");
        let _ = writeln!(
            text,
            "{} points in {took}: {rate:.2e} instance-periods/s on {devices}",
            work.points
        );
        if map.experiment.decides_early() {
            let full = engine::instance_periods(settings, work.points) as f64;
            let _ = writeln!(
                text,
                "        decided early: {:.1} % of the instance-periods that runs at full length take",
                100.0 * work.instance_periods as f64 / full
            );
        }
    }
    let share = |count: usize| format!("{count} ({:.1} %)", 100.0 * count as f64 / points as f64);
    let counts = Counts::of(map);
    let names = Class::ALL.into_iter().zip(counts.classes);
    let classes: Vec<String> = names
        .map(|(class, count)| format!("{} {}", class.name(), share(count)))
        .collect();
    let _ = writeln!(text, "class:  {}", classes.join(", "));
    let counted = |quantity, code| map.values(quantity).filter(|&value| value == code).count();
    if map.experiment.wears() {
        let transient = (0..points)
            .filter(|&index| map.is_computed(index) && map.class(index).is_none())
            .count()
            .saturating_sub(counts.runaway + counts.under_resolved);
        let _ = writeln!(text, "        transient, since the contact wears: {}", share(transient));
        let lost = counted(Quantity::ContactStatus, 1.0);
        let held = counted(Quantity::ContactStatus, 0.0);
        let _ = writeln!(text, "contact: lost {}, held to the end {}", share(lost), share(held));
    }
    let _ = writeln!(
        text,
        "status: ok {}, runaway {}, under-resolved {}",
        share(counts.ok()),
        share(counts.runaway),
        share(counts.under_resolved)
    );
    let defect = map
        .values(Quantity::Lyapunov)
        .zip(map.values(Quantity::LyapunovSecond))
        .zip(map.values(Quantity::Divergence))
        .enumerate()
        .filter(|(index, _)| !map.is_under_resolved(*index))
        .map(|(_, ((first, second), divergence))| (first + second - divergence).abs())
        .fold(0.0, f64::max);
    if !settings.integration.scheme.carries_heat() {
        let _ = writeln!(
            text,
            "check:  sum of the exponents = mean divergence to {defect:.1e} at every resolved point"
        );
    }
    let blamed = map
        .values(Quantity::SchemeError)
        .zip(map.values(Quantity::LyapunovError))
        .filter(|&(scheme, error)| is_scheme_to_blame(scheme, error))
        .count();
    if blamed > 0 {
        let _ = writeln!(
            text,
            "scheme: at {} points most of the exponent's error is the scheme's: {}",
            share(blamed),
            finer(settings)
        );
    }
    let under_resolved = counts.under_resolved;
    if under_resolved > 0 {
        let _ = writeln!(
            text,
            "warning: {under_resolved} points are under-resolved: {}",
            remedy(settings)
        );
    }
    if map::has_border(&map.experiment) {
        let border = map::border(map);
        let along = [0, 1].map(|along| {
            let count = |begins| {
                let changes = border.iter();
                changes
                    .filter(|change| change.along == along && change.begins == begins)
                    .count()
            };
            let axis = map.experiment.design.axes()[along].coordinate;
            format!(
                "along {axis} it begins {} times and ends {} times",
                count(true),
                count(false)
            )
        });
        let _ = writeln!(text, "border of chaos: {}", along.join(", "));
    }
    text
}

pub fn audit(audit: &Audit) -> String {
    let mut text = format!(
        "audit:  {} points again on the CPU in f64: {} of the same class, {} with the same exponent within its error\n",
        audit.points(),
        audit.same_class(),
        audit.same_exponent()
    );
    for row in &audit.classes {
        let _ = writeln!(
            text,
            "        {:<14} {:>3} points, same class {:>3}, same exponent {:>3}, largest difference {:.1e}",
            row.class.map_or("transient", Class::name),
            row.points,
            row.same_class,
            row.same_exponent,
            row.largest_difference
        );
    }
    text
}

/// A number to six digits, for people.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// How many points there are of each kind of motion.
pub fn kinds(tally: &Tally) -> String {
    let points = tally.points().max(1) as f64;
    let kinds = tally.kinds();
    let kinds = kinds.iter().map(|(name, count)| {
        format!(
            "{} {count} ({:.1} %)",
            name.replace('_', "-"),
            100.0 * *count as f64 / points
        )
    });
    kinds.collect::<Vec<_>>().join(", ")
}
