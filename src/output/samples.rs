//! Made-up maps for the tests of tables, stores and pictures.

use crate::backend::{BackendKind, Contact};
use crate::design::Axis;
use crate::experiment::{Experiment, Request};
use crate::map::ParameterMap;
use crate::measure::{Class, Measurement, Status};

pub fn experiment(x: &str, y: &str) -> Experiment {
    let request = Request {
        axes: Some(vec![Axis::parse(x).unwrap(), Axis::parse(y).unwrap()]),
        ..Request::default()
    };
    request.resolve().unwrap()
}

/// As [`experiment`], with the machine of the template, which has the dimensionless values of the paper's preset.
#[cfg(any(feature = "pictures", feature = "store"))]
pub fn machine_experiment(x: &str, y: &str) -> Experiment {
    use crate::machine::{Description, TEMPLATE};
    let request = Request {
        axes: Some(vec![Axis::parse(x).unwrap(), Axis::parse(y).unwrap()]),
        machine: Some(Description::from_toml(TEMPLATE).unwrap()),
        ..Request::default()
    };
    request.resolve().unwrap()
}

/// A measurement that is recognised by its exponent.
pub fn measurement(lyapunov: f64) -> Measurement {
    let class = if lyapunov > 0.0 { Class::Chaotic } else { Class::Regular };
    Measurement {
        status: Status::Ok,
        class: Some(class),
        lyapunov,
        period: (lyapunov < 0.0).then_some(3),
        attractors: 1,
        unsettled_fraction: 0.0,
        lyapunov_error: 0.01,
        lyapunov_second: lyapunov - 0.5,
        divergence: 2.0 * lyapunov - 0.5,
        lyapunov_birkhoff: lyapunov,
        lyapunov_interval: 100.0,
        contact: Contact::CONSTANT,
        x: 0.5,
        y: -0.5,
        x_min: -1.0,
        x_max: 1.5,
        ..Measurement::runaway(0.0, BackendKind::CpuF64)
    }
}

/// A map with the given exponents; x varies fastest. NaN stands for a runaway. Points beyond the end of the list are not computed.
pub fn map(x: &str, y: &str, exponents: &[f64]) -> ParameterMap {
    let mut map = ParameterMap::new(experiment(x, y)).unwrap();
    for (index, &lyapunov) in exponents.iter().enumerate() {
        let runaway = Measurement::runaway(50.0, BackendKind::CpuF64);
        map.set(
            index,
            &if lyapunov.is_nan() {
                runaway
            } else {
                measurement(lyapunov)
            },
        );
    }
    map
}
