use tribochaos::backend::cpu::CpuBackend;
use tribochaos::backend::gpu::{GpuBackend, GpuContext};
use tribochaos::backend::{Backend, Slice, Stage};
use tribochaos::experiment::{Precision, Preset, Scheme, Settings};
use tribochaos::parameters::{Parameter, ParameterSet};
fn main() {
    let set = Preset::Paper.values().iter().fold(ParameterSet::default(), |s, &(p, v)| s.with(p, v)).with(Parameter::ZetaK, 0.0).with(Parameter::KW, 0.0);
    let sets = [
        set.with(Parameter::RampRate, 0.1).with(Parameter::Y0, -5.0),
        set.with(Parameter::RampRate, 0.1).with(Parameter::Y0, -5.0).with(Parameter::KW, 0.01),
        set.with(Parameter::ZetaK, 3.5).with(Parameter::RampRate, 0.1),
        set.with(Parameter::ZetaK, 3.0).with(Parameter::B, -0.5),
        set.with(Parameter::ZetaK, 3.0).with(Parameter::B, 0.0).with(Parameter::Epsilon, 0.0),
    ];
    for tolerance in [1e-4, 1e-6, 1e-8] {
        let settings = Settings { scheme: Some(Scheme::Radau), modes: 8, periods: 40, tolerance, ..Settings::default() };
        let mut backends: Vec<Box<dyn Backend>> = vec![Box::new(CpuBackend::new(Precision::F64)), Box::new(CpuBackend::new(Precision::F32)), Box::new(GpuBackend::new(GpuContext::open(None, true).unwrap()))];
        for backend in &mut backends { for n in [2u32, 5, 10, 20, 30, 40] { let sets = &sets[3..]; backend.load(&settings, sets).unwrap(); backend.advance(&Slice { stage: Stage::Measure, first: 0, periods: n, elapsed: 0 }).unwrap(); let e = backend.end_states().unwrap()[0]; println!("   {n} {:e} {:e} {:?} {:?} {:?}", e.x, e.y, e.runaway_period, e.under_resolved, e.contact); }
            backend.load(&settings, &sets).unwrap();
            backend.advance(&Slice { stage: Stage::Measure, first: 0, periods: 1, elapsed: 0 }).unwrap();
            for e in &backend.end_states().unwrap()[..3] { println!("{tolerance:e} {} {:.5} {:.5} {:?}", backend.device(), e.x, e.y, e.contact); }
            backend.advance(&Slice { stage: Stage::Measure, first: 1, periods: 39, elapsed: 1 }).unwrap();
            for e in &backend.end_states().unwrap()[3..] { println!("   {:e} {:?} {:?}", e.x, e.runaway_period, e.under_resolved); }
        }
    }
}
