//! `bifurcation`: stroboscopic states over one parameter.

use std::fmt::Write as _;
use std::time::Instant;

use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::analysis::{self, Claim, OutArgs, StartArgs};
use super::request::{self, AskedAxis, Checked, ExperimentArgs};
use super::{Failure, words};
use crate::analysis::bifurcation::{self, Columns, diagram};
use crate::design::Axis;
use crate::engine::Event;
use crate::experiment::Request;
use crate::output::PROGRAM;
use crate::parameters::Parameter;
use crate::picture::caption;
use crate::picture::charts::{self, Component};
use crate::picture::sheet::{SINGLE, Sheet};

/// The name of the command in files.
const COMMAND: &str = "bifurcation";

/// By default, every column has the states at drive phase 0 of 200 periods, after a transient of 300 periods.
#[derive(Args)]
#[command(after_long_help = request::parameter_table())]
pub struct BifurcationArgs {
    /// The parameter and its values, ends included [default: zeta_k=0:12:2400]
    #[arg(long, value_name = "NAME=START:STOP:COUNT", value_parser = request::axis)]
    x: Option<Axis>,
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
    /// State that is drawn [default: x]
    #[arg(long, value_name = "x|y", value_parser = request::named::<Component>)]
    show: Option<Component>,
    /// Begin each column where the previous one ended, while the parameter rises (up) or falls (down). The two diagrams differ
    /// where attractors coexist [default: begin every column at the same initial states]
    #[arg(long, value_name = "up|down", value_parser = follow)]
    follow: Option<Columns>,
    /// Ends of the drawn state's axis [default: from the data]
    #[arg(long, value_name = "LOW:HIGH", value_parser = request::limits, allow_hyphen_values = true)]
    limits: Option<[f64; 2]>,
    #[command(flatten)]
    #[serde(default, skip_serializing_if = "StartArgs::is_empty")]
    start: StartArgs,
}

impl Checked for Options {
    fn check(&self) -> Result<(), String> {
        self.limits.map_or(Ok(()), request::check_limits)?;
        self.start.check()
    }
}

fn follow(text: &str) -> Result<Columns, String> {
    match text {
        "up" => Ok(Columns::FollowUp),
        "down" => Ok(Columns::FollowDown),
        _ => Err(format!("`{text}` is no direction: up and down are")),
    }
}

/// The defaults of this command.
pub fn defaults() -> Request {
    let mut defaults = Request::of_analysis();
    defaults.sampling.periods = bifurcation::PERIODS;
    defaults
}

#[expect(
    clippy::too_many_lines,
    reason = "the code follows the command from its options to its files"
)]
pub fn run(args: &BifurcationArgs) -> Result<(), Failure> {
    let axis = AskedAxis {
        typed: args.x.as_ref(),
        default: analysis::default_axis(2400),
    };
    let request = args.experiment.request(Some(COMMAND), &defaults(), [axis])?;
    let mut options = request::options(&args.options, &request)?;
    let experiment = analysis::resolve(&request)?;
    options.start.start = args
        .options
        .start
        .resolve(&options.start, &args.experiment, &experiment)?;
    let written = request::written(COMMAND, &experiment, &options);
    if args.experiment.subject.prints(&written) {
        return Ok(());
    }
    let (settings, axis, starts) = (&experiment.settings, &experiment.design.axes()[0], &options.start.start);
    let columns = options.follow.unwrap_or(Columns::Fresh);
    experiment.check_lasting().map_err(Failure::input)?;
    bifurcation::check(&experiment, columns, starts.len()).map_err(Failure::input)?;
    let mut files = Claim::new(&args.out, "outputs/bifurcation", &[""], &written)?;
    let mut backends = analysis::choose(&experiment)?.backends;

    let started = Instant::now();
    let instances = (axis.count() * starts.len()) as u64;
    let periods = u64::from(settings.sampling.transient_periods + settings.sampling.periods);
    let diagram = analysis::compute(instances * periods, axis.count(), |observer| {
        diagram(
            backends.active_mut(),
            settings,
            &experiment.design.fixed,
            axis,
            starts,
            columns,
            &mut |periods| observer(Event::Advanced(periods)),
        )
    })?;
    let integrated_on = caption::integrated_on([backends.active().kind()].into_iter());

    let panel = charts::bifurcation(
        "",
        &diagram,
        options.show.unwrap_or(Component::X),
        options.limits,
        SINGLE,
    );
    let outside = charts::outside(&panel);
    let manner = match columns {
        Columns::Fresh => "each value from",
        Columns::FollowUp => "followed upward from",
        Columns::FollowDown => "followed downward from",
    };
    let mut numerics = format!(
        "{} values, {manner} (x, y) = {}; {} states each after {} forcing periods. {}, {integrated_on}. ",
        axis.count(),
        analysis::starts_in_words(starts),
        settings.sampling.periods,
        settings.sampling.transient_periods,
        caption::scheme(settings)
    );
    if outside > 0 {
        let _ = write!(
            numerics,
            "{outside} of {} states lie outside the frame. ",
            diagram.len()
        );
    }
    if diagram.runaways > 0 {
        let _ = write!(
            numerics,
            "{} orbits ran away or were given up as under-resolved. ",
            diagram.runaways
        );
    }
    let shown = [axis.coordinate, Parameter::X0.into(), Parameter::Y0.into()];
    let caption = vec![
        caption::fixed(&experiment.design.fixed, &shown),
        format!("{numerics}{PROGRAM}."),
    ];
    files.draw(
        "",
        &Sheet::single(panel, caption),
        "Bifurcation diagram of the bush-shaft system",
    )?;
    let rows = diagram.columns.iter().enumerate().flat_map(|(index, column)| {
        let value = axis.value(index);
        column.iter().map(move |&[x, y]| [value, x, y])
    });
    files.table(
        "",
        &[analysis::unit_note(
            &experiment,
            &[axis.coordinate],
            "states at drive phase 0",
        )],
        [axis.coordinate.name(), "x", "y"],
        rows,
    )?;
    let object = || {
        json!({
            "parameters": analysis::parameters(experiment.design.fixed.parameters()),
            "axis": axis,
            "columns": columns,
            "starts": starts,
            "states": diagram.len(),
            "runaways": diagram.runaways,
        })
    };
    files.tell(&experiment, object, || {
        print_line!(
            "{} states over {} values in {}",
            diagram.len(),
            axis.count(),
            words::duration(started.elapsed())
        );
        if diagram.runaways > 0 {
            print_line!(
                "{} orbits ran away or were given up as under-resolved",
                diagram.runaways
            );
        }
    });
    Ok(())
}
