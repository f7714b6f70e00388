use super::FlowHistory;
use zimm_core::ParameterError;

/// Rest, then a constant rate: strain = rate (t - at) from the time `at` on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartUp {
    rate: f64,
    at: f64,
}

impl StartUp {
    /// Flow at `rate`, in inverse time, from the time `at` on.
    ///
    /// # Errors
    /// If the rate or the time is not finite.
    pub fn new(rate: f64, at: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            rate: ParameterError::finite("rate", rate)?,
            at: ParameterError::finite("time of start", at)?,
        })
    }
}

impl FlowHistory for StartUp {
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
