//! Whole maps: a GPU's against the CPU's, one whose GPU is lost on the way, several initial states, and the audit.

#![cfg(feature = "gpu")]

mod gpu_context;

use std::ops::{ControlFlow, Range};
use std::sync::Mutex;
use std::time::Instant;

use tribochaos::backend::BackendKind;
use tribochaos::backend::cpu::CpuBackend;
use tribochaos::backend::gpu::{GpuBackend, GpuContext};
use tribochaos::design::Axis;
use tribochaos::engine::{
    self, Backends, Cause, Claim, Condition, Event, Origin, Sink, SinkError, Table, audit, estimate,
};
use tribochaos::experiment::{Experiment, Precision, Request, Sampling, Settings};
use tribochaos::map::ParameterMap;
use tribochaos::measure::{Class, Measurement, Quantity};
use tribochaos::results::{Results, Tally};
use tribochaos::store::Store;

fn experiment(x: &str, y: &str, settings: Settings) -> Experiment {
    let request = Request {
        axes: Some(vec![Axis::parse(x).unwrap(), Axis::parse(y).unwrap()]),
        integration: settings.integration.into(),
        sampling: settings.sampling,
        ..Request::default()
    };
    request.resolve().unwrap()
}

/// Short runs, which settle on most cycles.
fn brief() -> Settings {
    Settings {
        sampling: Sampling {
            transient_periods: 60,
            align_periods: 20,
            periods: 64,
            ..Sampling::default()
        },
        ..Settings::default()
    }
}

fn cpu(precision: Precision) -> Backends {
    Backends::new(Box::new(CpuBackend::new(precision)), None)
}

fn carry_on(_: Event<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn compute(backends: &mut Backends, experiment: &Experiment) -> Vec<Measurement> {
    let indices: Vec<usize> = (0..experiment.design.len()).collect();
    backends
        .measure(&experiment.design, &experiment.settings, &indices, &mut carry_on)
        .unwrap()
        .expect("nothing breaks the run off")
}

fn map(experiment: &Experiment, measurements: &[Measurement]) -> ParameterMap {
    let mut map = ParameterMap::new(experiment.clone()).unwrap();
    for (index, measurement) in measurements.iter().enumerate() {
        map.set(index, measurement);
    }
    map
}

/// Number of points of a class in `a`, and how many of them are of another class in `b`; points that `b` leaves undecided
/// count only where `strict`.
fn disagreement(class: Class, a: &[Measurement], b: &[Measurement], strict: bool) -> (usize, usize) {
    let counts = |b: &Measurement| strict || b.class != Some(Class::Undecided);
    let of_class: Vec<_> = a
        .iter()
        .zip(b)
        .filter(|(a, b)| a.class == Some(class) && counts(b))
        .collect();
    assert!(!of_class.is_empty(), "{class:?} does not occur");
    (
        of_class.len(),
        of_class.iter().filter(|(a, b)| a.class != b.class).count(),
    )
}

#[test]
fn classes_of_a_gpu_map_are_those_of_the_f64_map() {
    let Some(context) = gpu_context::open() else { return };
    // long enough for most chaotic transients to end: when one ends is chance, in f64 as in f32
    let settings = Settings {
        sampling: Sampling {
            transient_periods: 1500,
            periods: 600,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let experiment = experiment("zeta_k=0:6:64", "h1=0:1.5:64", settings);
    let reference = compute(&mut cpu(Precision::F64), &experiment);
    let gpu = compute(
        &mut Backends::new(Box::new(GpuBackend::new(context)), None),
        &experiment,
    );
    // there are few quasi-periodic points: some stand at the bound of the average, and are undecided or regular in one map
    for (class, strict) in [
        (Class::Chaotic, true),
        (Class::Regular, true),
        (Class::QuasiPeriodic, false),
    ] {
        for (a, b) in [(&reference, &gpu), (&gpu, &reference)] {
            let (points, different) = disagreement(class, a, b, strict);
            let allowed = (0.02 * points as f64).max(3.0);
            assert!(different as f64 <= allowed, "{class:?}: {different} of {points}");
        }
    }
    for measurements in [&reference, &gpu] {
        let undecided = measurements
            .iter()
            .filter(|m| m.class == Some(Class::Undecided))
            .count();
        assert!(undecided as f64 <= 0.04 * measurements.len() as f64, "{undecided}");
        let defect = measurements
            .iter()
            .map(|m| m.divergence_defect().abs())
            .fold(0.0, f64::max);
        assert!(defect < 1e-4, "{defect}");
    }
    assert!(gpu.iter().all(|m| m.backend == BackendKind::GpuF32));
    let audit = audit::audit(&map(&experiment, &gpu), 32, &mut carry_on)
        .unwrap()
        .unwrap();
    assert_eq!(audit.points(), 32);
    assert_eq!(audit.classes[0].class, Some(Class::Chaotic));
    assert!(audit.passes(), "{audit:?}");
}

#[test]
fn a_map_whose_gpu_is_lost_is_finished_on_the_cpu() {
    let Some(context) = gpu_context::open() else { return };
    let settings = Settings {
        sampling: Sampling {
            transient_periods: 120,
            periods: 64,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    // three batches of a software adapter
    let experiment = experiment("zeta_k=0:3:160", "h1=0.3:1.5:120", settings);
    let undisturbed = compute(&mut cpu(Precision::F64), &experiment);

    let device = context.device().clone();
    let gpu = GpuBackend::new(context);
    let batch = tribochaos::backend::Backend::batch_size(&gpu, &Settings::default());
    if batch >= experiment.design.len() {
        eprintln!("skipped: the GPU takes the whole map as one batch");
        return;
    }
    let mut backends = Backends::new(Box::new(gpu), Some(Box::new(CpuBackend::new(Precision::F64))));
    let indices: Vec<usize> = (0..experiment.design.len()).collect();
    let work = tribochaos::engine::instance_periods(&experiment.settings, batch);
    let (mut done, mut fell_back) = (0, Vec::new());
    let mut observer = |event: Event<'_>| {
        match event {
            Event::Advanced(instance_periods) => {
                done += instance_periods;
                // in the middle of the second batch
                if done > work * 3 / 2 && fell_back.is_empty() {
                    device.destroy();
                }
            }
            Event::FellBack { error, device } => fell_back.push(format!("{error}; {device}")),
            _ => {}
        }
        ControlFlow::Continue(())
    };
    let measurements = backends
        .measure(&experiment.design, &experiment.settings, &indices, &mut observer)
        .unwrap()
        .unwrap();

    assert_eq!(fell_back.len(), 1);
    assert!(
        fell_back[0].contains("lost") && fell_back[0].contains("CPU"),
        "{fell_back:?}"
    );
    assert_eq!(measurements.len(), experiment.design.len());
    for (index, (m, reference)) in measurements.iter().zip(&undisturbed).enumerate() {
        let kind = if index < batch {
            BackendKind::GpuF32
        } else {
            BackendKind::CpuF64
        };
        assert_eq!(m.backend, kind, "point {index}");
        let tolerance = (3.0 * m.lyapunov_error.hypot(reference.lyapunov_error)).max(1e-3);
        assert!(
            (m.lyapunov - reference.lyapunov).abs() <= tolerance,
            "point {index}: {m:?} {reference:?}"
        );
    }
    assert_eq!(
        map(&experiment, &measurements).value(Quantity::Backend, 0),
        f64::from(BackendKind::GpuF32 as u8)
    );
}

/// A store whose GPU is lost keeps what the GPU finished. The CPU computes the rest, and the store tells which device computed what.
#[test]
fn a_store_whose_gpu_is_lost_is_finished_on_the_cpu() {
    let Some(context) = gpu_context::open() else { return };
    let experiment = experiment("zeta_k=3:5:40", "h1=0.3:1.5:24", brief());
    let folder = tempfile::tempdir().unwrap();
    let quantities = [Quantity::Lyapunov, Quantity::Backend];
    let mut store = Store::create(&folder.path().join("lost.zarr"), &experiment, &quantities, 96).unwrap();
    let units: Vec<usize> = (0..store.units()).collect();
    let device = context.device().clone();
    let mut backends = [Backends::new(
        Box::new(GpuBackend::new(context)),
        Some(Box::new(CpuBackend::new(Precision::F64))),
    )];
    let (mut finished, mut fell_back) = (0, 0);
    let work = engine::run_on(&mut backends, &experiment, &mut store, &units, &mut |event| {
        match event {
            Event::Finished(_) => {
                finished += 1;
                if finished == 4 {
                    device.destroy();
                }
            }
            Event::FellBack { .. } => fell_back += 1,
            _ => {}
        }
        ControlFlow::Continue(())
    });
    assert_eq!((work.unwrap().points, finished, fell_back), (960, units.len(), 1));

    let store = Store::open(store.path()).unwrap();
    let results = store.read().unwrap();
    let on = |kind: BackendKind| {
        let devices = results.values(Quantity::Backend);
        devices.filter(|&device| device == f64::from(kind as u8)).count()
    };
    let by_gpu: usize = units[..4].iter().map(|&unit| store.points(unit).count()).sum();
    assert_eq!(
        (on(BackendKind::GpuF32), on(BackendKind::CpuF64)),
        (by_gpu, 960 - by_gpu)
    );
}

#[test]
fn the_largest_exponent_of_several_initial_states_is_reported() {
    let several = Settings {
        sampling: Sampling {
            initial_states: 6,
            transient_periods: 100,
            periods: 100,
            ..Sampling::default()
        },
        ..Settings::default()
    };
    let one = Settings {
        sampling: Sampling {
            initial_states: 1,
            ..several.sampling
        },
        ..several
    };
    let [several, one] = [several, one]
        .map(|settings| experiment("zeta_k=3:4.5:6", "h1=0.1:0.9:4", settings))
        .map(|experiment| compute(&mut cpu(Precision::F64), &experiment));
    for (several, one) in several.iter().zip(&one) {
        // (x0, y0) is one of them
        assert!(several.lyapunov >= one.lyapunov);
        assert!(several.attractors <= 6);
        assert!(
            several.attractors > 0 || several.unsettled_fraction == 1.0,
            "{several:?}"
        );
        assert!((0.0..=1.0).contains(&several.chaotic_fraction));
    }
    assert!(several.iter().any(|m| m.attractors > 1) && several.iter().any(|m| m.chaotic_fraction > 0.0));
}

#[test]
fn the_estimate_of_a_map_with_wear_is_about_what_it_takes() {
    let mut request = Request {
        axes: Some(vec![
            Axis::parse("zeta_k=0:8:40").unwrap(),
            Axis::parse("k_w=0.001:0.02:30").unwrap(),
        ]),
        ..Request::default()
    };
    request.set.insert("gamma".into(), 1.87);
    request.set.insert("h1".into(), 0.5);
    request.sampling.periods = 60;
    let experiment = request.resolve().unwrap();
    let mut backends = cpu(Precision::F64);
    let estimate = estimate::seconds(&mut backends, &experiment).unwrap();
    let started = Instant::now();
    compute(&mut backends, &experiment);
    let ratio = estimate / started.elapsed().as_secs_f64();
    // the machine may be shared
    assert!((0.3..3.0).contains(&ratio), "{ratio}");
}

/// Two devices take units in turn, whichever is free: the results are those of one.
#[test]
fn two_devices_share_the_units_and_make_the_results_of_one() {
    let (Some(first), Some(second)) = (gpu_context::open(), gpu_context::open()) else {
        return;
    };
    let experiment = experiment("zeta_k=3:5:40", "h1=0.3:1.5:24", brief());
    let run = |contexts: Vec<GpuContext>| {
        let mut backends: Vec<Backends> = contexts
            .into_iter()
            .map(|context| Backends::new(Box::new(GpuBackend::new(context)), None))
            .collect();
        let mut table = Table::new(experiment.clone(), 96);
        let units: Vec<usize> = (0..table.units()).collect();
        let (mut finished, mut points) = (0, 0);
        let work = engine::run_on(&mut backends, &experiment, &mut table, &units, &mut |event| {
            if let Event::Finished(tally) = event {
                finished += 1;
                points += tally.points();
            }
            ControlFlow::Continue(())
        });
        assert_eq!((work.unwrap().points, finished, points), (960, 10, 960));
        table.into_results()
    };
    let third = gpu_context::open().unwrap();
    let (one, two) = (run(vec![third]), run(vec![first, second]));
    for quantity in one.quantities() {
        let bits = |results: &Results| results.values(quantity).map(f64::to_bits).collect::<Vec<_>>();
        assert!(bits(&one) == bits(&two), "{quantity:?}");
    }
}

/// What one of two devices ends, ends for both, and what is finished stays.
#[test]
fn a_run_on_two_devices_that_is_broken_off_keeps_what_is_finished() {
    let mut experiment = experiment("zeta_k=3:5:40", "h1=0.3:1.5:24", Settings::default());
    experiment.settings.sampling.decide_early = false;
    let mut backends = [cpu(Precision::F64), cpu(Precision::F64)];
    let mut table = Table::new(experiment.clone(), 32);
    let units: Vec<usize> = (0..table.units()).collect();
    let mut finished = 0;
    let error = engine::run_on(&mut backends, &experiment, &mut table, &units, &mut |event| {
        finished += usize::from(matches!(event, Event::Finished(_)));
        if finished == 4 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    })
    .unwrap_err();
    assert!(matches!(error.cause, Cause::Stopped));
    // the other device may have ended a unit at the same moment
    assert!((4..=5).contains(&error.finished) && error.units == 30, "{error:?}");
    let results = table.into_results();
    let computed = (0..960).filter(|&index| results.is_computed(index)).count();
    assert_eq!(computed, error.finished * 32);
}

/// A sink in which another process finishes each unit between the first look at it and the claim.
struct Overtaken {
    table: Table,
    finished: Mutex<Vec<bool>>,
}

impl Sink for Overtaken {
    fn units(&self) -> usize {
        self.table.units()
    }

    fn points(&self, unit: usize) -> Range<usize> {
        self.table.points(unit)
    }

    fn condition(&self, unit: usize) -> Result<Condition, SinkError> {
        let is_finished = self.finished.lock().unwrap()[unit];
        Ok(if is_finished {
            Condition::Whole(Tally::default())
        } else {
            Condition::Missing
        })
    }

    fn is_finished(&self, unit: usize) -> Result<bool, SinkError> {
        Ok(self.finished.lock().unwrap()[unit])
    }

    fn claim(&self, unit: usize) -> Result<Option<Claim>, SinkError> {
        self.finished.lock().unwrap()[unit] = true;
        Ok(Some(Claim::new(())))
    }

    fn write(&mut self, unit: usize, _: &[Measurement], _: &Origin) -> Result<(), SinkError> {
        Err(format!("unit {unit} was there").into())
    }
}

#[test]
fn what_another_process_finishes_before_the_claim_is_not_computed_again() {
    let experiment = experiment("zeta_k=3:5:8", "h1=0.3:1.5:8", Settings::default());
    let table = Table::new(experiment.clone(), 16);
    let mut sink = Overtaken {
        finished: Mutex::new(vec![false; table.units()]),
        table,
    };
    let (mut found, mut backends) = (0, [cpu(Precision::F64)]);
    let work = engine::run_on(&mut backends, &experiment, &mut sink, &[0, 1, 2, 3], &mut |event| {
        found += usize::from(matches!(event, Event::Found { .. }));
        ControlFlow::Continue(())
    });
    assert_eq!((work.unwrap().points, found), (0, 4));
}

/// A sink that has no room left.
struct Full(Table);

impl Sink for Full {
    fn units(&self) -> usize {
        self.0.units()
    }

    fn points(&self, unit: usize) -> Range<usize> {
        self.0.points(unit)
    }

    fn condition(&self, _: usize) -> Result<Condition, SinkError> {
        Ok(Condition::Missing)
    }

    fn is_finished(&self, _: usize) -> Result<bool, SinkError> {
        Ok(false)
    }

    fn claim(&self, _: usize) -> Result<Option<Claim>, SinkError> {
        Ok(Some(Claim::new(())))
    }

    fn write(&mut self, _: usize, _: &[Measurement], _: &Origin) -> Result<(), SinkError> {
        Err("no room is left".to_owned().into())
    }
}

/// A failure stops the workers beside the one that failed: their stop is no reason to tell.
#[test]
fn a_run_that_fails_beside_others_tells_why() {
    let experiment = experiment("zeta_k=3:5:16", "h1=0.3:1.5:16", brief());
    for workers in [1, 2] {
        let mut backends: Vec<_> = (0..workers).map(|_| cpu(Precision::F64)).collect();
        for _ in 0..4 {
            let mut sink = Full(Table::new(experiment.clone(), 16));
            let units: Vec<usize> = (0..sink.units()).collect();
            let error = engine::run_on(&mut backends, &experiment, &mut sink, &units, &mut carry_on).unwrap_err();
            assert!(matches!(error.cause, Cause::Sink(_)), "{error}");
        }
    }
}
