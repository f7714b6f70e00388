//! Ratios of means over an ensemble of independent trajectories.

use crate::ratio_average::ratio;
use crate::trajectories::Trajectories;
use crate::{AnalysisError, Mean};
use zimm_core::Estimator;

/// The ratio of two means over an ensemble of independent trajectories, `R = <a> / <b>`, and its standard error from
/// the trajectory means of `a - R b`: [`RatioAverage`](crate::RatioAverage) with the error of
/// [`EnsembleAverage`](crate::EnsembleAverage).
///
/// A sample is `(trajectory, [a, b])`. A denominator closer to zero than four of its errors is refused.
///
/// ```
/// use zimm_analysis::EnsembleRatio;
/// use zimm_core::Estimator;
///
/// let mut ratio = EnsembleRatio::new();
/// for trajectory in 0..10 {
///     let below = 5.0 + trajectory as f64;
///     ratio.push((trajectory, [0.5 * below, below]));
/// }
/// let mean = ratio.estimate()?;
/// assert!((mean.value - 0.5).abs() < 1e-15 && mean.at_least() < 1e-15);
/// # Ok::<(), zimm_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct EnsembleRatio {
    trajectories: Trajectories<2>,
}

impl EnsembleRatio {
    /// No samples yet.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Estimator for EnsembleRatio {
    type Sample = (u64, [f64; 2]);
    type Estimate = Result<Mean, AnalysisError>;

    fn push(&mut self, (trajectory, sample): (u64, [f64; 2])) {
        self.trajectories.push(trajectory, sample);
    }

    fn estimate(&self) -> Self::Estimate {
        ratio(self.trajectories.means()?, |w| self.trajectories.error(w))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;

    // a = 2 b + x, b = 4 + y, where x and y are Ornstein-Uhlenbeck processes of unit variance, phi = 0.8, in 100
    // trajectories of 40 samples from the stationary state: R = 2, and its error is that of x over 4 whatever b does.
    // The variance of a mean of x is (9 - 1.0) / 40 with the tail 2 0.8 (1 - 0.8^40) / (40 0.04) = 1.0; the error of R
    // is sqrt(0.2 / 100) / 4 = 0.0112, known to 7 % from 100 trajectories. Seed 72; bounds 4 sigma. Without the
    // covariance the error would be 2.2 times that.
    #[test]
    fn limit_common_fluctuations_cancel() {
        let mut random = Random::new(72);
        let mut ratio = EnsembleRatio::new();
        for trajectory in 0..100 {
            let (mut x, mut y) = (random.normal(), random.normal());
            for _ in 0..40 {
                let below = 4.0 + y;
                ratio.push((trajectory, [2.0 * below + x, below]));
                x = 0.8 * x + 0.6 * random.normal();
                y = 0.8 * y + 0.6 * random.normal();
            }
        }
        let (found, error) = (ratio.estimate().unwrap(), 0.25 * 0.002_f64.sqrt());
        assert!((found.value - 2.0).abs() < 4.0 * error, "{found}");
        let relative = found.standard_error().unwrap() / error;
        assert!((relative - 1.0).abs() < 0.28, "{found}");
    }

    #[test]
    fn extreme_a_denominator_close_to_zero_is_refused() {
        let mut ratio = EnsembleRatio::new();
        assert!(matches!(
            ratio.estimate(),
            Err(AnalysisError::TooFew { .. })
        ));
        for trajectory in 0..10 {
            ratio.push((trajectory, [1.0, trajectory as f64 - 4.0]));
        }
        assert!(matches!(
            ratio.estimate(),
            Err(AnalysisError::Denominator { .. })
        ));
    }
}
