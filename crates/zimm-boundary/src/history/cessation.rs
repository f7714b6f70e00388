use super::ShearHistory;
use zimm_core::ParameterError;

/// Shear at a constant rate, then rest: strain = rate t up to the time `at`, and rate at from then on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cessation {
    rate: f64,
    at: f64,
}

impl Cessation {
    /// Shear at `shear_rate`, in inverse time, up to the time `at`.
    ///
    /// # Errors
    /// If the rate, the time or the strain at that time is not finite.
    pub fn new(shear_rate: f64, at: f64) -> Result<Self, ParameterError> {
        let rate = ParameterError::finite("shear rate", shear_rate)?;
        let at = ParameterError::finite("time of end", at)?;
        ParameterError::finite("strain at the end", rate * at)?;
        Ok(Self { rate, at })
    }
}

impl ShearHistory for Cessation {
    fn strain(&self, time: f64) -> f64 {
        let sheared = if time > self.at { self.at } else { time };
        self.rate * sheared
    }

    fn rate(&self, time: f64) -> f64 {
        if time < self.at { self.rate } else { 0.0 }
    }
}
