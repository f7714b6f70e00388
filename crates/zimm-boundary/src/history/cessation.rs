use super::FlowHistory;
use zimm_core::ParameterError;

/// A constant rate, then rest: strain = rate t up to the time `at`, and rate at from then on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cessation {
    rate: f64,
    at: f64,
}

impl Cessation {
    /// Flow at `rate`, in inverse time, up to the time `at`.
    ///
    /// # Errors
    /// If the rate, the time or the strain at that time is not finite.
    pub fn new(rate: f64, at: f64) -> Result<Self, ParameterError> {
        let rate = ParameterError::finite("rate", rate)?;
        let at = ParameterError::finite("time of end", at)?;
        ParameterError::finite("strain at the end", rate * at)?;
        Ok(Self { rate, at })
    }
}

impl FlowHistory for Cessation {
    fn strain(&self, time: f64) -> f64 {
        let until = if time > self.at { self.at } else { time };
        self.rate * until
    }

    fn rate(&self, time: f64) -> f64 {
        if time < self.at { self.rate } else { 0.0 }
    }
}
