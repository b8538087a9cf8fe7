//! Standard errors that can be believed.

use tribochaos::experiment::{Precision, Sampling, Settings};
use tribochaos::measure::Class;
use tribochaos::parameters::{Parameter, ParameterSet};

use crate::common::{Random, from_state, measure, pinned_settings, point};

/// 96 orbits on one attractor scatter as each of them claims: the ratio's own standard error is 1/sqrt(2*95) = 0.07,
/// the claims may be too large (the largest of three estimates is taken, and in 300 periods chaos in bands, for which that is right, cannot
/// be told from other chaos) but not much too small.
#[test]
fn the_standard_error_of_a_chaotic_exponent_is_the_scatter_of_repeated_runs() {
    let chaotic = point(&[(Parameter::ZetaK, 3.9), (Parameter::H1, 0.5)]);
    let mut random = Random::new(5);
    // all near one state of the attractor: elsewhere some lead to a coexisting cycle
    let orbits: Vec<ParameterSet> = (0..96)
        .map(|_| from_state(chaotic, [random.uniform(0.65, 0.75), random.uniform(0.05, 0.15)]))
        .collect();
    for (periods, most) in [(300, 1.8), (1000, 1.3)] {
        let settings = Settings {
            sampling: Sampling {
                periods,
                ..pinned_settings().sampling
            },
            ..pinned_settings()
        };
        let measured = measure(Precision::F64, &settings, &orbits);
        let count = measured.len() as f64;
        assert!(measured.iter().all(|m| m.class == Some(Class::Chaotic)));
        let mean = measured.iter().map(|m| m.lyapunov).sum::<f64>() / count;
        let scatter = (measured.iter().map(|m| (m.lyapunov - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt();
        let claimed = (measured.iter().map(|m| m.lyapunov_error.powi(2)).sum::<f64>() / count).sqrt();
        let ratio = claimed / scatter;
        assert!(
            (0.7..most).contains(&ratio),
            "{periods} periods: claimed {claimed}, scatter {scatter}"
        );
    }
}
