//! Instances of the full model in the lanes of the scheme that carries them.
//!
//! Owns how a run begins or goes on; advances nothing.

use super::{HeatedState, Instance};
use crate::dynamics::adaptive::{Orbit, Peaks, System, Tangent};
use crate::lanes::Real;

/// What a run begins with, in the lanes of a number type.
pub(super) struct Begun<R: Real> {
    pub orbit: Orbit<R>,
    pub peaks: Peaks<R>,
    pub tangents: Vec<Tangent<R>>,
}

impl<R: Real> Begun<R> {
    /// The instances that `instance` gives for each lane, with this number of tangent vectors.
    pub fn new<'a>(system: &System<R>, vectors: usize, instance: impl Fn(usize) -> &'a Instance) -> Self {
        let [x, y] = [0, 1].map(|n| R::from_lanes(|lane| instance(lane).state[n]));
        let mut orbit = Orbit::start(system, x, y);
        let mut peaks = Peaks::start(&orbit);
        if (0..R::LANES).any(|lane| instance(lane).heated.is_some()) {
            (orbit, peaks) = gone_on(system, orbit, &peaks, &|lane| instance(lane).heated.as_deref());
        }
        let tangents = (0..vectors)
            .map(|vector| {
                let component = |n| R::from_lanes(|lane| instance(lane).component(vector, n));
                let components: Vec<R> = (0..2 + system.mode_count()).map(component).collect();
                Tangent::at(&orbit, system, &components)
            })
            .collect();
        Self { orbit, peaks, tangents }
    }
}

/// The orbit and the peaks with what lanes have that go on.
fn gone_on<'a, R: Real>(
    system: &System<R>,
    start: Orbit<R>,
    peaks: &Peaks<R>,
    heated: &dyn Fn(usize) -> Option<&'a HeatedState>,
) -> (Orbit<R>, Peaks<R>) {
    let value = |at_start: R, of: &dyn Fn(&HeatedState) -> f64| {
        R::from_lanes(|lane| heated(lane).map_or(at_start.lane(lane), of))
    };
    let zero = R::splat(0.0);
    let modes = (0..system.mode_count()).map(|m| system.mode(m, value(zero, &|heated| heated.pressures[m])));
    let modes = modes.collect();
    let periods = value(zero, &|heated| heated.periods);
    let contact = value(start.contact, &|heated| f64::from(u8::from(heated.is_in_contact)));
    let step = value(start.step, &|heated| heated.step * R::PERIOD_TICKS);
    let peaks = Peaks {
        pressure: value(peaks.pressure, &|heated| heated.contact.peak_pressure),
        pressure_time: [zero, value(zero, &|heated| heated.contact.peak_pressure_time)],
        temperature: value(peaks.temperature, &|heated| heated.contact.peak_temperature),
        lost: [
            value(peaks.lost[0], &|heated| heated.contact.lost.map_or(-1.0, |_| 0.0)),
            value(peaks.lost[1], &|heated| heated.contact.lost.unwrap_or(0.0)),
        ],
    };
    (start.resumed(system, periods, modes, contact, step), peaks)
}
