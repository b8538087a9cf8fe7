//! Sets of parameter values by name.

use crate::parameters::{Parameter, ParameterSet};

/// A set of values by name, which a request starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Section 5 of the paper. It leaves out biot, omega_tilde, the fit and the initial state: these are reconstructed, as
    /// the values with which the paper's figures come out.
    Paper,
}

impl Preset {
    /// `paper` is the only name.
    pub fn from_name(name: &str) -> Option<Self> {
        (name == "paper").then_some(Self::Paper)
    }

    /// The default parameters with the preset's values.
    pub fn parameters(self) -> ParameterSet {
        let mut set = ParameterSet::default();
        for &(parameter, value) in self.values() {
            set[parameter] = value;
        }
        set
    }

    /// What the preset sets; other parameters keep their values.
    pub fn values(self) -> &'static [(Parameter, f64)] {
        match self {
            Self::Paper => &[
                (Parameter::H1, 0.5),
                (Parameter::Gamma, 1.87),
                (Parameter::KW, 0.01),
                (Parameter::Biot, 10.0),
                (Parameter::OmegaTilde, 0.1),
                (Parameter::RampRate, f64::INFINITY),
                (Parameter::X0, 0.0),
                (Parameter::Y0, 0.0),
            ],
        }
    }
}
