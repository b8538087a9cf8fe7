//! `poincare`: the stroboscopic section of an attractor.

use std::fmt::Write as _;
use std::time::Instant;

use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::analysis::{self, Claim, OutArgs};
use super::request::{self, Checked, ExperimentArgs};
use super::{Failure, words};
use crate::analysis::section;
use crate::design::Coordinate;
use crate::engine::Event;
use crate::experiment::{InitialBox, Request};
use crate::output::PROGRAM;
use crate::picture::layer::Layer;
use crate::picture::sheet::{SINGLE, Sheet};
use crate::picture::{caption, charts};

/// The name of the command in files.
const COMMAND: &str = "poincare";

/// Many orbits that begin within 1e-3 of (x0, y0) share the work; on a chaotic attractor they separate within some tens of
/// periods. The default transient is 500 periods; the number of measured periods follows from --points.
#[derive(Args)]
#[command(after_long_help = request::parameter_table())]
pub struct PoincareArgs {
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    experiment: ExperimentArgs,
    #[command(flatten)]
    out: OutArgs,
}

#[derive(Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Options {
    /// States at drive phase 0 in the section [default: 1000000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MOST_POINTS))]
    points: Option<u64>,
    /// Part of the plane to draw, as X_MIN:X_MAX,Y_MIN:Y_MAX [default: all that is reached]
    #[arg(long, value_name = "BOX", value_parser = window, allow_hyphen_values = true)]
    window: Option<InitialBox>,
}

const POINTS: u64 = 1_000_000;
const MOST_POINTS: u64 = 200_000_000;

impl Checked for Options {
    fn check(&self) -> Result<(), String> {
        request::in_range("points", self.points, 1..=MOST_POINTS)?;
        self.window.as_ref().map_or(Ok(()), check_window)
    }
}

fn window(text: &str) -> Result<InitialBox, String> {
    let window = request::initial_box(text)?;
    check_window(&window).map(|()| window)
}

fn check_window(window: &InitialBox) -> Result<(), String> {
    if window.x[0] < window.x[1] && window.y[0] < window.y[1] {
        Ok(())
    } else {
        Err("the window has no extent: write X_MIN:X_MAX,Y_MIN:Y_MAX, lower ends first".to_owned())
    }
}

/// Most pixels of a cycle: 32 for a cycle of up to 32 periods, and as many more for states at the edges of pixels.
const MOST_CYCLE_PIXELS: usize = 64;

/// The defaults of this command.
pub fn defaults() -> Request {
    let mut defaults = Request::of_analysis();
    defaults.sampling.transient_periods = section::TRANSIENT_PERIODS;
    defaults
}

/// Options of experiments that are refused here.
pub const HIDDEN: &[&str] = &["periods"];

#[expect(
    clippy::too_many_lines,
    reason = "the code follows the command from its options to its files"
)]
pub fn run(args: &PoincareArgs) -> Result<(), Failure> {
    if args.experiment.periods.is_some() {
        return Err(Failure::Input(anyhow::anyhow!(
            "the measured periods of a section follow from --points: leave --periods out"
        )));
    }
    let mut request = args.experiment.request(Some(COMMAND), &defaults(), [])?;
    let options = request::options(&args.options, &request)?;
    let asked = options.points.unwrap_or(POINTS);
    let plan = section::Plan::new(asked);
    let orbits = plan.orbits;
    request.sampling.periods = plan.measured_periods();
    let experiment = analysis::resolve(&request)?;
    experiment.check_lasting().map_err(Failure::input)?;
    let written = request::written(COMMAND, &experiment, &options);
    if args.experiment.subject.prints(&written) {
        return Ok(());
    }
    let settings = &experiment.settings;
    let at = &experiment.design.fixed;
    let mut files = Claim::new(&args.out, "outputs/poincare", &[""], &written)?;
    let mut backends = analysis::choose(&experiment)?.backends;

    let started = Instant::now();
    let periods = settings.sampling.transient_periods + settings.sampling.periods;
    let work = u64::from(orbits) * u64::from(periods);
    let section::Section { mut points, runaways } = analysis::compute(work, orbits as usize, |observer| {
        let mut hear = |periods| observer(Event::Advanced(periods));
        section::section(backends.active_mut(), settings, at.parameters(), orbits, &mut hear)
    })?;
    let integrated_on = caption::integrated_on([backends.active().kind()].into_iter());
    if points.is_empty() {
        return Err(Failure::Run(anyhow::anyhow!(
            "all {orbits} orbits ran away or were given up as under-resolved, and there is nothing to draw: `tribochaos point` \
             tells which of the two"
        )));
    }
    points.truncate(usize::try_from(asked).unwrap_or(usize::MAX));

    let [x, y] = options
        .window
        .map_or([None; 2], |window| [Some(window.x), Some(window.y)]);
    let panel = charts::section("", &points, x, y, SINGLE);
    let (occupied, outside) = match &panel.layers[..] {
        [Layer::Density(density)] => (density.occupied(), density.outside()),
        _ => (0, 0),
    };
    let inside = points.len() - outside;
    // the window may show only a part of the attractor, so the whole of it decides whether it is a cycle
    let whole = charts::section("", &points, None, None, SINGLE);
    let is_cycle = matches!(&whole.layers[..], [Layer::Density(density)] if density.occupied() <= MOST_CYCLE_PIXELS);
    let mut numerics = format!(
        "{} states of {orbits} orbits begun within 0.001 of (x₀, y₀), after {} forcing periods. {}, {integrated_on}. ",
        points.len(),
        settings.sampling.transient_periods,
        caption::scheme(settings)
    );
    if outside > 0 {
        let _ = write!(numerics, "{outside} states lie outside the window. ");
    }
    if runaways > 0 {
        let _ = write!(
            numerics,
            "{runaways} orbits ran away or were given up as under-resolved. "
        );
    }
    let caption = vec![
        caption::fixed(at, &[] as &[Coordinate]),
        format!("{numerics}{PROGRAM}."),
    ];
    files.draw(
        "",
        &Sheet::single(panel, caption),
        "Stroboscopic section of the bush-shaft system",
    )?;
    files.table(
        "",
        &["states at drive phase 0".to_owned()],
        ["x", "y"],
        points.iter().copied(),
    )?;
    let object = || {
        json!({
            "parameters": analysis::parameters(at.parameters()),
            "points": points.len(),
            "orbits": orbits,
            "runaways": runaways,
            "in_window": inside,
            "pixels": occupied,
        })
    };
    files.tell(&experiment, object, || {
        print_line!(
            "{} states in {}, {inside} of them in the frame, on {occupied} pixels",
            points.len(),
            words::duration(started.elapsed())
        );
        if inside == 0 {
            print_line!(
                "no state lies in the window: all lie within --window {:.4}:{:.4},{:.4}:{:.4}",
                whole.x.low,
                whole.x.high,
                whole.y.low,
                whole.y.high
            );
        }
        if is_cycle {
            print_line!("all states lie on so few pixels that they are those of a cycle, not of a chaotic attractor");
        }
    });
    Ok(())
}
