//! `devices`: lists the devices that can compute, and checks whether a GPU computes correctly.

use anyhow::anyhow;
use clap::Args;
use serde_json::{Value, json};

use super::json::JsonArgs;
use super::{Failure, progress, words};
use crate::backend::cpu::{self, CpuBackend, InstructionSet};
use crate::backend::gpu::{GpuBackend, GpuContext, adapters};
use crate::backend::{Backend, twins};
use crate::design::Axis;
use crate::engine::{Backends, audit, choice};
use crate::experiment::{Precision, Request};
use crate::map::ParameterMap;
use crate::output::PROGRAM;

#[derive(Args)]
pub struct DevicesArgs {
    /// Compare a GPU with the CPU: random instances over a short run, and a small map audited in f64. The report is meant to be
    /// sent to the developers
    #[arg(long)]
    check: bool,
    /// Part of the name of the adapter to check [default: the first, hardware before software]
    #[arg(long, value_name = "NAME", requires = "check")]
    adapter: Option<String>,
    #[command(flatten)]
    json: JsonArgs,
}

pub fn run(args: &DevicesArgs) -> Result<(), Failure> {
    if args.check {
        if args.json.wanted() {
            return Err(Failure::Input(anyhow!(
                "the report of --check is a text to be sent as it is: leave --json out"
            )));
        }
        return check(args.adapter.as_deref());
    }
    if args.json.wanted() {
        args.json.print(&object()?);
        return Ok(());
    }
    print_line!("CPU, {}", cpu::threads());
    for (rank, set) in InstructionSet::available().into_iter().enumerate() {
        let used = if rank == 0 { "  (used)" } else { "" };
        print_line!(
            "  {}: {} lanes of f64, {} of f32{used}",
            set.name(),
            set.lanes(Precision::F64),
            set.lanes(Precision::F32)
        );
    }
    let adapters = adapters();
    print_line!("GPU adapters: {}", if adapters.is_empty() { "none" } else { "" });
    for adapter in &adapters {
        print_line!("  {adapter}");
    }
    let experiment = Request::default().resolve().expect("the default experiment is valid");
    let choice = choice::choose(&experiment).map_err(Failure::backend)?;
    print_line!("auto picks {}:\n  {}", choice.backends.active().device(), choice.reason);
    Ok(())
}

fn object() -> Result<Value, Failure> {
    let sets = InstructionSet::available().into_iter().map(|set| {
        json!({
            "name": set.name(),
            "lanes_f64": set.lanes(Precision::F64),
            "lanes_f32": set.lanes(Precision::F32),
        })
    });
    let experiment = Request::default().resolve().map_err(Failure::input)?;
    let choice = choice::choose(&experiment).map_err(Failure::backend)?;
    Ok(json!({
        "program": PROGRAM,
        "threads": rayon::current_num_threads(),
        "instruction_sets": sets.collect::<Vec<_>>(),
        "adapters": adapters().iter().map(ToString::to_string).collect::<Vec<_>>(),
        "auto": { "device": choice.backends.active().device(), "reason": choice.reason },
    }))
}

fn check(adapter: Option<&str>) -> Result<(), Failure> {
    let open = || {
        GpuContext::open(adapter, true)
            .map(GpuBackend::new)
            .map_err(Failure::backend)
    };
    let mut gpu = open()?;
    print_line!("{PROGRAM}, {} {}", std::env::consts::OS, std::env::consts::ARCH);
    print_line!("{}", gpu.context().description());
    let mut cpu = CpuBackend::new(Precision::F32);
    let twins = twins::compare(&mut gpu, &mut cpu).map_err(Failure::backend)?;
    print_line!("twins:  {} random instances against {}", twins.instances, cpu.device());
    for (what, [median, largest]) in [("state", twins.state), ("growth", twins.growth)] {
        print_line!("        {what:<7} differs by {median:.1e} in the median, {largest:.1e} at most");
    }

    let mut request = Request {
        axes: Some(vec![
            Axis::even("zeta_k", 0.0, 6.0, 24).map_err(Failure::input)?,
            Axis::even("h1", 0.0, 1.5, 24).map_err(Failure::input)?,
        ]),
        ..Request::default()
    };
    request.sampling.transient_periods = 150;
    request.sampling.periods = 150;
    let experiment = request.resolve().expect("the experiment is valid");
    let mut map = ParameterMap::new(experiment).expect("it has two axes");
    let indices: Vec<usize> = (0..map.experiment.design.len()).collect();
    progress::catch_signals();
    let observer = &mut |_: crate::engine::Event<'_>| progress::until_stopped();
    let interrupted = || Failure::Interrupted("the check is not finished".into());
    let measurements = Backends::new(Box::new(gpu), None)
        .measure(&map.experiment.design, &map.experiment.settings, &indices, observer)
        .map_err(Failure::backend)?
        .ok_or_else(interrupted)?;
    for (index, measurement) in measurements.iter().enumerate() {
        map.set(index, measurement);
    }
    let audit = audit::audit(&map, indices.len(), observer)
        .map_err(Failure::backend)?
        .ok_or_else(interrupted)?;
    print_text!("{}", words::audit(&audit));
    if twins.agree() && audit.passes() {
        print_line!("the GPU computes rightly");
        Ok(())
    } else {
        Err(Failure::Run(anyhow!(
            "the GPU does not agree with the CPU: use --backend cpu, and send this report"
        )))
    }
}
