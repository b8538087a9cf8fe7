//! `status` and `verify`: what a store has, what it lacks, and what is damaged.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::anyhow;
use clap::Args;
use serde_json::json;

use super::json::JsonArgs;
use super::progress::{self, Progress};
use super::stores;
use super::{Failure, words};
use crate::engine::{self, Condition, Sink, choice};
use crate::results::Tally;
use crate::store::{Lock, Store, Use};

#[derive(Args)]
pub struct StatusArgs {
    /// The store, NAME.zarr
    store: PathBuf,
    #[command(flatten)]
    json: JsonArgs,
}

#[derive(Args)]
pub struct VerifyArgs {
    /// The store, NAME.zarr
    store: PathBuf,
    /// Compute damaged units again
    #[arg(long)]
    repair: bool,
    /// No other process uses the store: for file systems without locks
    #[arg(long)]
    alone: bool,
    #[command(flatten)]
    json: JsonArgs,
}

/// What there is in a store.
pub struct Survey {
    units: usize,
    whole: usize,
    /// Which units are damaged, and what is wrong.
    pub damaged: Vec<(usize, String)>,
    points: usize,
    pub tally: Tally,
    /// Devices, with the points that each has computed and the time that it took.
    pub devices: Vec<(String, u64, f64)>,
}

impl Survey {
    /// Reads all of the store.
    pub fn of(store: &Store) -> Result<Self, Failure> {
        let mut survey = Self {
            units: store.units(),
            whole: 0,
            damaged: Vec::new(),
            points: store.experiment().design.len(),
            tally: Tally::default(),
            devices: Vec::new(),
        };
        for unit in 0..survey.units {
            match store.check_unit(unit).map_err(Failure::run)? {
                Condition::Missing => {}
                Condition::Damaged { what } => survey.damaged.push((unit, what)),
                Condition::Whole(tally) => {
                    survey.whole += 1;
                    survey.tally.add(&tally);
                    if let Some(mark) = store.mark(unit).map_err(Failure::run)? {
                        survey.add_device(mark.device, tally.points(), mark.seconds);
                    }
                }
            }
        }
        Ok(survey)
    }

    fn add_device(&mut self, device: String, points: u64, seconds: f64) {
        if let Some(known) = self.devices.iter_mut().find(|(name, ..)| *name == device) {
            known.1 += points;
            known.2 += seconds;
        } else {
            self.devices.push((device, points, seconds));
        }
    }

    /// Units that are not there.
    fn missing(&self) -> usize {
        self.units - self.whole - self.damaged.len()
    }

    /// Seconds that one process takes for the rest, at the rate of all units so far; None before anything is known.
    fn seconds_left(&self) -> Option<f64> {
        let seconds: f64 = self.devices.iter().map(|(.., seconds)| seconds).sum();
        let done = self.tally.points();
        (done > 0 && seconds > 0.0).then(|| (self.points as u64 - done) as f64 * seconds / done as f64)
    }

    fn object(&self) -> serde_json::Value {
        let devices = self
            .devices
            .iter()
            .map(|(device, points, seconds)| json!({"device": device, "points": points, "seconds": seconds}));
        json!({
            "units": self.units,
            "finished": self.whole,
            "missing": self.missing(),
            "damaged": self.damaged.iter().map(|(unit, what)| json!({"unit": unit, "what": what})).collect::<Vec<_>>(),
            "points": self.points,
            "points_finished": self.tally.points(),
            "motion": self.tally,
            "devices": devices.collect::<Vec<_>>(),
            "seconds_left": self.seconds_left(),
        })
    }

    fn print(&self) {
        print_line!(
            "units:  {} of {} finished, {} missing, {} damaged",
            self.whole,
            self.units,
            self.missing(),
            self.damaged.len()
        );
        print_line!("points: {} of {}", self.tally.points(), self.points);
        if self.tally.points() > 0 {
            print_line!("motion: {}", words::kinds(&self.tally));
        }
        for (device, points, seconds) in &self.devices {
            print_line!(
                "device: {device}: {points} points, {:.0} points/s",
                *points as f64 / seconds.max(1e-9)
            );
        }
        if let Some(seconds) = self.seconds_left().filter(|&seconds| seconds > 0.0) {
            let left = words::duration(Duration::from_secs_f64(seconds));
            print_line!("left:   about {left} of one process such as those so far");
        }
    }
}

pub fn status(args: &StatusArgs) -> Result<(), Failure> {
    let store = Store::open(&args.store).map_err(Failure::input)?;
    let survey = Survey::of(&store)?;
    if args.json.wanted() {
        args.json.print(&survey.object());
        return Ok(());
    }
    print_line!("{}", words::plan(store.experiment()));
    survey.print();
    for (unit, what) in &survey.damaged {
        print_line!("damaged: unit {unit}: {what}");
    }
    Ok(())
}

pub fn verify(args: &VerifyArgs) -> Result<(), Failure> {
    let store = Store::open(&args.store).map_err(Failure::input)?;
    let survey = Survey::of(&store)?;
    for (unit, what) in &survey.damaged {
        eprintln!("unit {unit} is damaged: {what}");
    }
    let damaged = survey.damaged.len();
    if damaged > 0 && args.repair {
        repair(args, store, &survey)?;
    }
    if args.json.wanted() {
        let mut object = survey.object();
        object["repaired"] = args.repair.into();
        args.json.print(&object);
    } else {
        survey.print();
        if damaged > 0 && args.repair {
            print_line!("{damaged} units were computed again");
        }
    }
    if damaged > 0 && !args.repair {
        return Err(Failure::Run(anyhow!(
            "{damaged} units of {} are damaged: `tribochaos verify {0} --repair` computes them again",
            args.store.display()
        )));
    }
    Ok(())
}

/// Computes the damaged units again, and no others.
fn repair(args: &VerifyArgs, store: Store, survey: &Survey) -> Result<(), Failure> {
    let lock = if args.alone {
        None
    } else {
        Some(Lock::of_store(&args.store, Use::Together).map_err(Failure::input)?)
    };
    let mut store = store.writing(lock).map_err(Failure::input)?;
    let experiment = store.experiment().clone();
    let mut backends = choice::choose(&experiment).map_err(Failure::backend)?.backends;
    progress::catch_signals();
    let units: Vec<usize> = survey.damaged.iter().map(|(unit, _)| *unit).collect();
    let points = units.iter().map(|&unit| store.points(unit).len()).sum();
    let progress = Progress::new(engine::instance_periods(&experiment.settings, points), points, false);
    engine::run_on(
        std::slice::from_mut(&mut backends),
        &experiment,
        &mut store,
        &units,
        &mut |event| progress.hear(event),
    )
    .map(|_| ())
    .map_err(|error| stores::unfinished(error, &args.store))
}
