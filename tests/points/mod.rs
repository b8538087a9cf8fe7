//! Points of the parameter space for tests.

use tribochaos::parameters::{Parameter, ParameterSet};

/// `count` points along a line through the plane of zeta_k and h1, which crosses regular and chaotic motion.
pub fn line(count: usize) -> Vec<ParameterSet> {
    (0..count)
        .map(|i| {
            let s = i as f64 / (count - 1) as f64;
            ParameterSet::default()
                .with(Parameter::ZetaK, 0.5 + 7.5 * s)
                .with(Parameter::H1, 0.2 + 1.1 * s)
        })
        .collect()
}
