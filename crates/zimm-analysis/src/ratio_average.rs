//! Ratios of means, with the covariance of numerator and denominator in the error.

use crate::blocks::{Blocks, plateau};
use crate::{AnalysisError, Mean, StandardError};
use zimm_core::Estimator;

/// The ratio of two means of the same run, `R = <a> / <b>`, and its standard error.
///
/// A sample is `[a, b]`. The error is that of `<a - R b> / <b>`, to first order in the fluctuations, from block
/// averages as in [`BlockAverage`](crate::BlockAverage): what a and b have in common cancels as it should.
///
/// A denominator closer to zero than four of its errors is refused.
///
/// ```
/// use zimm_analysis::RatioAverage;
/// use zimm_core::Estimator;
///
/// let mut ratio = RatioAverage::new();
/// ratio.push([1.0, 2.0]);
/// ratio.push([2.0, 4.0]);
/// ratio.push([2.5, 5.0]);
/// assert_eq!(ratio.estimate()?.value, 0.5);
/// assert_eq!(ratio.estimate()?.at_least(), 0.0);
/// # Ok::<(), zimm_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct RatioAverage {
    blocks: Blocks<2>,
}

impl RatioAverage {
    /// No samples yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.blocks.samples()
    }
}

impl Estimator for RatioAverage {
    type Sample = [f64; 2];
    type Estimate = Result<Mean, AnalysisError>;

    fn push(&mut self, sample: [f64; 2]) {
        self.blocks.push(sample);
    }

    fn estimate(&self) -> Self::Estimate {
        ratio(self.blocks.means()?, |w| plateau(&self.blocks.errors(w)).0)
    }
}

/// The ratio of two means, where `error` tells the error of the mean of w_0 a + w_1 b.
pub(crate) fn ratio(
    [numerator, denominator]: [f64; 2],
    error: impl Fn([f64; 2]) -> StandardError,
) -> Result<Mean, AnalysisError> {
    clear_of_zero(Mean {
        value: denominator,
        error: error([0.0, 1.0]),
    })?;
    let value = numerator / denominator;
    let error = error([1.0 / denominator, -value / denominator]);
    Ok(Mean { value, error })
}

/// Refuses to divide by a mean closer to zero than four of its errors.
pub(crate) fn clear_of_zero(below: Mean) -> Result<(), AnalysisError> {
    const CLEAR_OF_ZERO: f64 = 4.0;
    let (mean, error) = (below.value, below.at_least());
    if mean == 0.0 || mean.abs() < CLEAR_OF_ZERO * error {
        Err(AnalysisError::Denominator { mean, error })
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;

    // a = 2 b + x with b = 4 + y and x, y independent normal: R = 2 and its error is that of x over 4,
    // 0.25 / sqrt(4096) = 0.0039, whatever b does; without covariances it would be 3.3 times that. Seed 1, bound on the
    // mean 4 sigma (0.8 % of R), on the error 45 % (about 25 blocks or more: 3 of its standard deviations).
    #[test]
    fn limit_common_fluctuations_cancel() {
        let mut random = Random::new(1);
        let mut ratio = RatioAverage::new();
        for _ in 0..4096 {
            let below = 4.0 + random.normal();
            ratio.push([2.0 * below + random.normal(), below]);
        }
        let found = ratio.estimate().unwrap();
        let error = 0.25 / 4096.0_f64.sqrt();
        assert!((found.value - 2.0).abs() < 4.0 * error, "{found}");
        assert!(
            (found.standard_error().unwrap() / error - 1.0).abs() < 0.45,
            "{found}"
        );
    }

    #[test]
    fn extreme_a_denominator_close_to_zero_is_refused() {
        let mut random = Random::new(2);
        let mut ratio = RatioAverage::new();
        for _ in 0..1024 {
            ratio.push([1.0, random.normal()]);
        }
        assert!(matches!(
            ratio.estimate(),
            Err(AnalysisError::Denominator { .. })
        ));
        let mut zero = RatioAverage::new();
        zero.push([1.0, 0.0]);
        zero.push([1.0, 0.0]);
        assert!(matches!(
            zero.estimate(),
            Err(AnalysisError::Denominator { mean: 0.0, .. })
        ));
    }
}
