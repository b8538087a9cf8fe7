use std::time::Instant;
use tribochaos::backend::cpu::CpuBackend;
use tribochaos::backend::gpu::{GpuBackend, GpuContext};
use tribochaos::backend::{Backend, Slice, Stage};
use tribochaos::experiment::{Precision, Scheme, Settings};
use tribochaos::parameters::{Parameter, ParameterSet};

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let mode = args[1].as_str();
    let modes: u32 = args[2].parse().unwrap();
    let count: usize = args[3].parse().unwrap();
    let (lo, hi): (f64, f64) = (args[4].parse().unwrap(), args[5].parse().unwrap());
    let k_w: f64 = args[6].parse().unwrap();
    let periods: u32 = args[7].parse().unwrap();
    let settings = Settings { scheme: Some(Scheme::Radau), modes, periods, ..Settings::default() };
    let instances: Vec<ParameterSet> = (0..count)
        .map(|i| {
            ParameterSet::default()
                .with(Parameter::Gamma, 1.87).with(Parameter::KW, k_w).with(Parameter::H1, 0.5)
                .with(Parameter::Biot, 10.0).with(Parameter::OmegaTilde, 0.1)
                .with(Parameter::X0, 0.0).with(Parameter::Y0, 0.0)
                .with(Parameter::ZetaK, lo + (hi - lo) * i as f64 / (count.max(2) - 1) as f64)
        })
        .collect();
    let mut gpu = GpuBackend::new(GpuContext::open(None, true).unwrap());
    if mode == "speed" {
        for (stage, name) in [(Stage::Transient, "plain"), (Stage::Align, "tangent")] {
            gpu.load(&settings, &instances[..64]).unwrap();
            gpu.advance(&Slice { stage, first: 0, periods: 1, elapsed: 0 }).unwrap();
            gpu.load(&settings, &instances).unwrap();
            let at = Instant::now();
            let c = cpu_time();
            gpu.advance(&Slice { stage, first: 0, periods, elapsed: 0 }).unwrap();
            println!("cpu {:.0}", (cpu_time() - c) * 1e9 / count as f64 / f64::from(periods));
            println!("{name}: {:.0} ns an instance-period", at.elapsed().as_nanos() as f64 / count as f64 / f64::from(periods));
        }
        return;
    }
    let mut cpu = CpuBackend::new(Precision::F64);
    for backend in [&mut gpu as &mut dyn Backend, &mut cpu] {
        let at = Instant::now();
        backend.load(&settings, &instances).unwrap();
        let mut e = 0;
        let mut first = 0;
        let stages: &[(Stage, u32)] = if k_w > 0.0 { &[(Stage::Measure, periods)] } else { &[(Stage::Transient, 50), (Stage::Align, 50), (Stage::Measure, periods)] };
        for &(stage, n) in stages {
            backend.advance(&Slice { stage, first: 0, periods: n, elapsed: e }).unwrap();
            e += n;
            let _ = &mut first;
        }
        let sums = backend.collect().unwrap();
        for ((set, end), sums) in instances.iter().zip(backend.end_states().unwrap()).zip(sums) {
            let c = end.contact;
            let time = c.lost.unwrap_or(f64::from(periods) * set.forcing_period());
            println!("{:.4} lost {:?} wear {:.5} p {:.4}@{:.4} T {:.3} x {:.5} {:.5} [{:.5},{:.5}] lam {:.5} ur {} ra {:?} cand {:x}", set[Parameter::ZetaK], c.lost, c.final_wear, c.peak_pressure, c.peak_pressure_time, c.peak_temperature, end.x, end.y, end.x_min, end.x_max, sums.growth[0]/time, end.under_resolved, end.runaway_period, end.candidates);
        }
        println!("{:?}", at.elapsed());
    }
}

fn cpu_time() -> f64 {
    let s = std::fs::read_to_string("/proc/self/stat").unwrap();
    let f: Vec<&str> = s.rsplit(')').next().unwrap().split_whitespace().collect();
    (f[11].parse::<f64>().unwrap() + f[12].parse::<f64>().unwrap()) / 100.0
}
