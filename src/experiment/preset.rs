//! Sets of parameter values by name.

use crate::parameters::{Parameter, ParameterSet};

/// A named set of values, from which a request starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Section 5 of the paper. The paper does not give biot, omega_tilde, the fit and the initial state: they are reconstructed
    /// as the values that reproduce the paper's figures.
    Paper,
}

impl Preset {
    /// Finds a preset by its name; `paper` is the only one.
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

    /// The values that the preset sets; other parameters keep theirs.
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
