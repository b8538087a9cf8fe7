//! Experiments that a program makes step by step.

use super::{Device, Experiment, ExperimentError, IntegrationRequest, Preset, Request, Sampling};
use crate::design::{Axis, Coordinate, Points};
use crate::machine::Description;

/// An experiment that is being made: see [`Experiment::builder`].
#[derive(Clone, Debug)]
pub struct Builder {
    request: Request,
}

impl Experiment {
    /// Begins an experiment. Without axes and points it is a single point, with default values for the parameters that are not set.
    pub fn builder() -> Builder {
        Builder {
            request: Request::default(),
        }
    }
}

impl Builder {
    /// Adds an axis. The first axis varies fastest.
    #[must_use]
    pub fn axis(mut self, axis: Axis) -> Self {
        self.request.axes.get_or_insert_default().push(axis);
        self
    }

    /// Takes points one by one instead of axes.
    #[must_use]
    pub fn points(mut self, points: Points) -> Self {
        self.request.points = Some(points);
        self
    }

    /// Sets a parameter, or a quantity of the machine, by its name.
    ///
    /// # Errors
    /// If neither a parameter nor a quantity has that name; the error gives the nearest name.
    pub fn set(mut self, name: &str, value: f64) -> Result<Self, ExperimentError> {
        let coordinate = Coordinate::from_name(name)?;
        self.request.set.insert(coordinate.name().to_owned(), value);
        Ok(self)
    }

    /// Sets the values of a preset.
    #[must_use]
    pub fn preset(mut self, preset: Preset) -> Self {
        self.request.set_preset(preset);
        self
    }

    /// Takes a machine in SI units, from which most parameters follow.
    #[must_use]
    pub fn machine(mut self, machine: Description) -> Self {
        self.request.machine = Some(machine);
        self
    }

    /// Sets how the points are integrated.
    #[must_use]
    pub fn integration(mut self, integration: impl Into<IntegrationRequest>) -> Self {
        self.request.integration = integration.into();
        self
    }

    /// Sets what is sampled of the points.
    #[must_use]
    pub fn sampling(mut self, sampling: Sampling) -> Self {
        self.request.sampling = sampling;
        self
    }

    /// Sets the device that computes the points.
    #[must_use]
    pub fn device(mut self, device: Device) -> Self {
        self.request.device = device;
        self
    }

    /// The experiment.
    ///
    /// # Errors
    /// As [`Request::resolve`].
    pub fn build(self) -> Result<Experiment, ExperimentError> {
        if self.request.axes.is_none() && self.request.points.is_none() {
            return self.request.resolve_point();
        }
        self.request.resolve()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_built_is_what_a_file_would_ask_for() {
        let built = Experiment::builder()
            .axis(Axis::even("zeta_k", 3.0, 5.0, 3).unwrap())
            .axis(Axis::listed("h1", [0.1, 0.5]).unwrap())
            .set("omega_0", 1.5)
            .unwrap()
            .build()
            .unwrap();
        let file = "axes = [{parameter = 'zeta_k', start = 3, stop = 5, count = 3}, {parameter = 'h1', values = [0.1, 0.5]}]\n\
                    set = {omega_0 = 1.5}";
        assert_eq!(built, Request::from_toml(file).unwrap().resolve().unwrap());
        assert_eq!(Experiment::builder().build().unwrap().design.len(), 1);
        let error = Experiment::builder().set("omega0", 1.0).unwrap_err().to_string();
        assert!(error.contains("did you mean `omega_0`"), "{error}");
    }
}
