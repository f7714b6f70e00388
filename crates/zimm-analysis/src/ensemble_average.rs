//! Means over an ensemble of independent trajectories.

use crate::trajectories::Trajectories;
use crate::{AnalysisError, Mean};
use zimm_core::Estimator;

/// The mean over an ensemble of independent trajectories, or of independent groups of chains, and its standard error
/// from the mean A_i of each of the M trajectories,
///
/// ```text
/// A = (1/M) sum_i A_i,   error = sqrt( sum_i (A_i - A)^2 / (M (M - 1)) )
/// ```
///
/// A sample is `(trajectory, value)`, the trajectory by any number; samples of different trajectories may come in any
/// order. Nothing is assumed of correlations in time, so a single late sample of each trajectory is as good as a
/// thousand correlated ones. Each trajectory counts once however many samples it has.
///
/// Below 8 trajectories the error is itself too uncertain to be one, and is called a lower bound.
///
/// ```
/// use zimm_analysis::EnsembleAverage;
/// use zimm_core::Estimator;
///
/// let mut stretch = EnsembleAverage::new();
/// for trajectory in 0..10 {
///     for sample in 0..3 {
///         stretch.push((trajectory, trajectory as f64 + 0.1 * sample as f64));
///     }
/// }
/// let mean = stretch.estimate()?;
/// assert!((mean.value - 4.6).abs() < 1e-14);
/// assert_eq!(format!("{mean:#}"), "4.6(10)");
/// # Ok::<(), zimm_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct EnsembleAverage {
    trajectories: Trajectories<1>,
}

impl EnsembleAverage {
    /// No samples yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of trajectories that have samples.
    pub fn trajectories(&self) -> usize {
        self.trajectories.count()
    }
}

impl Estimator for EnsembleAverage {
    type Sample = (u64, f64);
    type Estimate = Result<Mean, AnalysisError>;

    fn push(&mut self, (trajectory, sample): (u64, f64)) {
        self.trajectories.push(trajectory, [sample]);
    }

    fn estimate(&self) -> Self::Estimate {
        let [value] = self.trajectories.means()?;
        let error = self.trajectories.error([1.0]);
        Ok(Mean { value, error })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::StandardError;
    use crate::scene::Random;

    // Ornstein-Uhlenbeck processes x' = 0.9 x + sqrt(0.19) normal, 20 trajectories of 50 samples (about three
    // correlation times) from the stationary state. Their means are normal, so value over error is Student's t with 19
    // degrees of freedom whatever the correlations: 67.01 % of runs within 1 error, 95.00 % within 2.0930. 4000 runs,
    // seed 71: binomial errors 0.74 % and 0.34 %, bounds 4 of them. An error wrong by 6 % is caught, the error of
    // independent samples (a fourth) by far. The mean square error has the exact variance (1/20) (1 / 50) (19 - tail):
    // known to sqrt(2 / 19 / 4000) = 0.5 %, bound 4 of it.
    #[test]
    fn limit_an_ornstein_uhlenbeck_process_is_covered() {
        let (runs, trajectories, samples, phi) = (4000, 20, 50, 0.9_f64);
        let mut random = Random::new(71);
        let n = f64::from(samples);
        let tail = 2.0 * phi * (1.0 - phi.powi(samples)) / (n * (1.0 - phi).powi(2));
        let exact = ((1.0 + phi) / (1.0 - phi) - tail) / n / f64::from(trajectories);
        let (mut one, mut most, mut square) = (0, 0, 0.0);
        for _ in 0..runs {
            let mut average = EnsembleAverage::new();
            for trajectory in 0..trajectories {
                let mut x = random.normal();
                for _ in 0..samples {
                    average.push((trajectory as u64, x));
                    x = phi * x + (1.0 - phi * phi).sqrt() * random.normal();
                }
            }
            let mean = average.estimate().unwrap();
            let error = mean.standard_error().unwrap();
            one += i32::from(mean.value.abs() < error);
            most += i32::from(mean.value.abs() < 2.0930 * error);
            square += error * error / exact / f64::from(runs);
        }
        let share = |count| f64::from(count) / f64::from(runs);
        assert!((share(one) - 0.6701).abs() < 0.030, "{}", share(one));
        assert!((share(most) - 0.9500).abs() < 0.014, "{}", share(most));
        assert!((square - 1.0).abs() < 0.021, "{square}");
    }

    #[test]
    fn law_order_and_number_of_samples_do_not_show() {
        let (mut even, mut mixed) = (EnsembleAverage::new(), EnsembleAverage::new());
        for trajectory in 0..10 {
            even.push((trajectory, (trajectory * trajectory) as f64));
        }
        for sample in 0..3 {
            for trajectory in (0..10).rev().filter(|t| sample == 0 || t % 3 == sample) {
                mixed.push((trajectory, (trajectory * trajectory) as f64));
            }
        }
        assert_eq!(even.trajectories(), 10);
        let (even, mixed) = (even.estimate().unwrap(), mixed.estimate().unwrap());
        approx::assert_relative_eq!(even.value, 28.5, max_relative = 1e-14);
        approx::assert_relative_eq!(mixed.value, even.value, max_relative = 1e-14);
        // Sum of squared deviations of 0, 1, 4, ..., 81: 15 333 - 10 28.5^2 = 7210.5, over 90.
        let exact = (7210.5_f64 / 90.0).sqrt();
        approx::assert_relative_eq!(even.at_least(), exact, max_relative = 1e-13);
        approx::assert_relative_eq!(mixed.at_least(), exact, max_relative = 1e-13);
    }

    #[test]
    fn extreme_too_few_or_broken_trajectories_are_told() {
        let mut average = EnsembleAverage::new();
        for trajectory in 0..8 {
            let estimate = average.estimate();
            match trajectory {
                0 | 1 => assert!(matches!(estimate, Err(AnalysisError::TooFew { .. }))),
                _ => assert!(matches!(estimate.unwrap().error, StandardError::AtLeast(_))),
            }
            average.push((trajectory, trajectory as f64));
        }
        assert!(average.estimate().unwrap().standard_error().is_some());
        average.push((3, f64::NAN));
        let found = average.estimate();
        assert!(matches!(
            found,
            Err(AnalysisError::NotFinite { sample: 8, .. })
        ));
    }
}
