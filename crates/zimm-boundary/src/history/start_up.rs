use super::ShearHistory;
use zimm_core::ParameterError;

/// Rest, then shear at a constant rate: strain = rate (t - at) from the time `at` on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartUp {
    rate: f64,
    at: f64,
}

impl StartUp {
    /// Shear at `shear_rate`, in inverse time, from the time `at` on.
    ///
    /// # Errors
    /// If the rate or the time is not finite.
    pub fn new(shear_rate: f64, at: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            rate: ParameterError::finite("shear rate", shear_rate)?,
            at: ParameterError::finite("time of start", at)?,
        })
    }
}

impl ShearHistory for StartUp {
    fn strain(&self, time: f64) -> f64 {
        if time < self.at {
            0.0
        } else {
            self.rate * (time - self.at)
        }
    }

    fn rate(&self, time: f64) -> f64 {
        if time < self.at { 0.0 } else { self.rate }
    }
}
