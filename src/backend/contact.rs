//! Data on the contact between bush and shaft during a run.

/// The contact between bush and shaft during a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// tau_c, the time at which the pressure first fell to 0; None if contact held to the end of the run.
    pub lost: Option<f64>,
    pub peak_pressure: f64,
    /// Time of the peak pressure, in tau from the start of the run.
    pub peak_pressure_time: f64,
    /// u_w at the end of the run.
    pub final_wear: f64,
    /// Greatest temperature theta(1, tau) of the shaft's surface.
    pub peak_temperature: f64,
}

impl Contact {
    /// A contact that neither heats nor wears.
    pub const CONSTANT: Self = Self {
        lost: None,
        peak_pressure: 1.0,
        peak_pressure_time: 0.0,
        final_wear: 0.0,
        peak_temperature: 0.0,
    };

    /// A contact about which nothing is known.
    pub const UNKNOWN: Self = Self {
        lost: None,
        peak_pressure: f64::NAN,
        peak_pressure_time: f64::NAN,
        final_wear: f64::NAN,
        peak_temperature: f64::NAN,
    };

    /// Names of the values of [`Contact::status_code`].
    pub const NAMES: &[&str] = &["held", "lost"];

    /// 0 while contact holds, 1 once it is lost.
    pub fn status_code(&self) -> u8 {
        self.lost.is_some().into()
    }

    /// `held` or `lost`.
    pub fn status_name(&self) -> &'static str {
        Self::NAMES[usize::from(self.status_code())]
    }
}
