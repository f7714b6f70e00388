//! The mean of a run after it has settled.

use crate::moments::{Moments, mean_of};
use crate::segments::Segments;
use crate::{AnalysisError, Mean};
use zimm_core::Estimator;

/// The mean of a stream of correlated samples without the transient at its beginning, which it finds by itself, and
/// its standard error. Memory does not grow with the run.
///
/// The run is kept as the means of 128 to 255 stretches of equal length. The first d of n are left out for which the
/// squared error of the mean of the others,
///
/// ```text
/// sum_(i > d) (A_i - mean of them)^2 / (n - d)^2
/// ```
///
/// is least: leaving out more costs samples, leaving out less adds the scatter of the transient (the rule MSER of
/// White, Simulation 69, 323, 1997, for means of batches as White, Cobb and Spratt, 2000; with independent stretches
/// it keeps the most independent samples, as Chodera, J. Chem. Theory Comput. 12, 1799, 2016, asks). The rule stops
/// where the transient is as small as the error, so as much again is left out, but no more than half of the run. If d
/// is more than that, the run drifts: there is no answer then.
///
/// The error is that of block averages of the rest, as in [`BlockAverage`](crate::BlockAverage), which serves where
/// the end of the transient is known.
///
/// ```
/// use zimm_analysis::SteadyAverage;
/// use zimm_core::Estimator;
///
/// let mut average = SteadyAverage::new();
/// for k in 0..4096_u64 {
///     let noise = (k * 2_654_435_769 % 1000) as f64 / 1000.0;
///     average.push(noise + 10.0 * (-(k as f64) / 50.0).exp());
/// }
/// assert!((average.estimate()?.value - 0.5).abs() < 0.02);
/// assert!(average.transient()? > 150 && average.transient()? < 1000);
/// # Ok::<(), zimm_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SteadyAverage {
    stretches: Segments<Moments>,
    samples: u64,
    not_finite: Option<u64>,
}

/// Most stretches that are kept apart.
const STRETCHES: usize = 256;

impl Default for SteadyAverage {
    fn default() -> Self {
        Self {
            stretches: Segments::new(STRETCHES),
            samples: 0,
            not_finite: None,
        }
    }
}

impl SteadyAverage {
    /// No samples yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of samples, those of the transient among them.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Number of samples at the beginning that are left out.
    ///
    /// # Errors
    /// If there are fewer than 16 samples, one is not finite, or the run has not settled within its first half.
    pub fn transient(&self) -> Result<u64, AnalysisError> {
        Ok(self.left_out()? as u64 * self.stretches.length())
    }

    /// Number of stretches that are left out.
    fn left_out(&self) -> Result<usize, AnalysisError> {
        if let Some(sample) = self.not_finite {
            let what = "a quantity";
            return Err(AnalysisError::NotFinite { what, sample });
        }
        let stretches = self.stretches.complete();
        let (count, needed) = (stretches.len(), 16);
        if count < needed {
            return Err(AnalysisError::TooFew {
                what: "samples",
                found: self.samples,
                needed: needed as u64,
            });
        }
        // Fewer than a quarter scatter too much to be heard.
        let (mut rest, mut least, mut best) = (Moments::default(), f64::INFINITY, count);
        for (first, stretch) in stretches.iter().enumerate().rev() {
            rest.take(stretch.mean);
            if 4 * rest.count as usize >= count && rest.squared_error() <= least {
                (least, best) = (rest.squared_error(), first);
            }
        }
        if 2 * best > count {
            let samples = self.samples;
            return Err(AnalysisError::NotSettled { samples });
        }
        Ok((2 * best).min(count / 2))
    }
}

impl Estimator for SteadyAverage {
    type Sample = f64;
    type Estimate = Result<Mean, AnalysisError>;

    fn push(&mut self, sample: f64) {
        if self.not_finite.is_none() && !sample.is_finite() {
            self.not_finite = Some(self.samples);
        }
        self.samples += 1;
        self.stretches.add(|open| open.take(sample));
    }

    fn estimate(&self) -> Self::Estimate {
        let first = self.left_out()?;
        let kept = self.stretches.complete().get(first..).unwrap_or_default();
        mean_of(kept, self.stretches.open())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;

    fn average(samples: u64, mut sample: impl FnMut(u64) -> f64) -> SteadyAverage {
        let mut average = SteadyAverage::new();
        (0..samples).for_each(|k| average.push(sample(k)));
        average
    }

    // A step of 3 standard deviations of white noise after 1000 of 8192 samples, 100 runs from seed 110 on. Stretches
    // are 64 samples long; the rule lets pass a stretch that lies mostly beyond the step, or loses a few by chance; as
    // much again is left out. A step of so many errors of a stretch (3 / 0.125 = 24) cannot be missed. The mean of the
    // rest has errors of 0.0122 or less; its scatter over runs is known to 7 %: the mean of 100 within 4 of 0.0013,
    // the step's smallest unseen share, one stretch in 96, would shift it by 0.03.
    #[test]
    fn limit_a_step_is_found() {
        let mut sum = 0.0;
        for seed in 110..210 {
            let mut random = Random::new(seed);
            let step = |k| if k < 1000 { 3.0 } else { 0.0 };
            let found = average(8192, |k| step(k) + random.normal());
            let transient = found.transient().unwrap();
            assert!((1920..=4096).contains(&transient), "{transient}");
            sum += found.estimate().unwrap().value / 100.0;
        }
        assert!(sum.abs() < 4.0 * 0.0013, "{sum}");
    }

    // Nothing to leave out: 200 runs of white noise, from seed 210 on. The share that is lost by chance costs less
    // than a tenth of the samples.
    #[test]
    fn limit_what_is_steady_is_kept() {
        let mut lost = 0;
        for seed in 210..410 {
            let mut random = Random::new(seed);
            lost += average(4096, |_| random.normal()).transient().unwrap();
        }
        assert!(lost < 200 * 4096 / 10, "{lost}");
    }

    #[test]
    fn extreme_a_drift_is_no_transient() {
        let mut random = Random::new(410);
        let drift = average(10_000, |k| 0.001 * k as f64 + random.normal());
        let expected = AnalysisError::NotSettled { samples: 10_000 };
        assert_eq!(drift.transient(), Err(expected.clone()));
        assert_eq!(drift.estimate(), Err(expected));
        let late = average(10_000, |k| f64::from(u8::from(k < 5000)));
        assert!(matches!(
            late.transient(),
            Err(AnalysisError::NotSettled { .. })
        ));
    }

    #[test]
    fn extreme_too_few_or_broken_samples_and_constants_are_told() {
        for samples in 0..16 {
            let found = average(samples, |k| k as f64).estimate();
            assert!(matches!(found, Err(AnalysisError::TooFew { found, .. }) if found == samples));
        }
        let constant = average(1000, |_| 0.1);
        assert_eq!(constant.transient(), Ok(0));
        assert_eq!(constant.estimate().unwrap().standard_error(), Some(0.0));
        let broken = average(100, |k| if k == 50 { f64::NAN } else { 1.0 });
        let found = broken.estimate();
        assert!(matches!(
            found,
            Err(AnalysisError::NotFinite { sample: 50, .. })
        ));
    }
}
