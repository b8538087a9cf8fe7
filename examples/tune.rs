use tribochaos::backend::cpu::CpuBackend;
use tribochaos::benchmark::{accuracy::References, points, speed::Timing};
use tribochaos::experiment::*;
fn main() {
    let stride: usize = std::env::args().nth(1).map_or(9, |a| a.parse().unwrap());
    let steps: Vec<u32> = std::env::args().skip(2).map(|a| a.parse().unwrap()).collect();
    let t = std::time::Instant::now();
    let refs = References::compute(&points(stride).unwrap());
    println!(
        "{} insensitive of {}, {:?}",
        refs.len(),
        points(stride).unwrap().len(),
        t.elapsed()
    );
    let grid = points(1).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let mut rows = Vec::new();
        for precision in [Precision::F64, Precision::F32] {
            for &n in &steps {
                let settings = Settings { scheme: Some(Scheme::Taylor), steps_per_period: Some(n), ..Settings::default() };
                rows.push((precision, settings));
            }
            rows.push((precision, Settings { scheme: Some(Scheme::Rk4), ..Settings::default() }));
        }
        let mut timings: Vec<_> = rows.iter().map(|(p, s)| Timing::new(CpuBackend::new(*p), s, &grid).unwrap()).collect();
        for _ in 0..5 { for t in &mut timings { t.turn().unwrap(); } }
        for ((p, s), t) in rows.iter().zip(&timings) {
            let e = refs.errors(&mut CpuBackend::new(*p), s).unwrap();
            let [a, b] = t.nanoseconds();
            println!("{p:?} {:?} {}: median {:.1e} 90% {:.1e} 99% {:.1e} worst {:.1e}; plain {a:.0} tangent {b:.0} mean {:.0}", s.scheme(), s.steps_per_period(), e.median(), e.quantile(0.9), e.quantile(0.99), e.quantile(1.0), (a+b)/2.0);
        }
    });
}
