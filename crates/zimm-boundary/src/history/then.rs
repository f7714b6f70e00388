use super::FlowHistory;
use zimm_core::ParameterError;

/// One history up to the time `at`, another from then on: the strain goes on from where it was.
///
/// Both histories keep their own time: a rate of 2 from the time 10 on is `Then::new(first, 10.0, Steady::new(2.0)?)`.
/// What the first would have done from the time `at` on and the second before it is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Then<A, B> {
    first: A,
    at: f64,
    next: B,
}

impl<A: FlowHistory, B: FlowHistory> Then<A, B> {
    /// `first` before the time `at`, `next` from then on.
    ///
    /// # Errors
    /// If the time, or the strain of either history at that time, is not finite.
    pub fn new(first: A, at: f64, next: B) -> Result<Self, ParameterError> {
        let at = ParameterError::finite("time of change", at)?;
        ParameterError::finite("strain at the change", first.strain(at) - next.strain(at))?;
        Ok(Self { first, at, next })
    }
}

impl<A: FlowHistory, B: FlowHistory> FlowHistory for Then<A, B> {
    fn strain(&self, time: f64) -> f64 {
        if time < self.at {
            self.first.strain(time)
        } else {
            self.first.strain(self.at) + (self.next.strain(time) - self.next.strain(self.at))
        }
    }

    fn rate(&self, time: f64) -> f64 {
        if time < self.at {
            self.first.rate(time)
        } else {
            self.next.rate(time)
        }
    }
}
