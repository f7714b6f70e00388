use super::FlowHistory;
use zimm_core::ParameterError;

/// A constant rate, always: strain = rate t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steady {
    rate: f64,
}

impl Steady {
    /// Flow at `rate`, in inverse time; of either sign.
    ///
    /// # Errors
    /// If the rate is not finite.
    pub fn new(rate: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            rate: ParameterError::finite("rate", rate)?,
        })
    }
}

impl FlowHistory for Steady {
    fn strain(&self, time: f64) -> f64 {
        self.rate * time
    }

    fn rate(&self, _: f64) -> f64 {
        self.rate
    }
}
