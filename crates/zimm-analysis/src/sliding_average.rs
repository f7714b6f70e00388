//! The mean of the last while.

use crate::moments::{Moments, mean_of};
use crate::{AnalysisError, Mean};
use std::collections::VecDeque;
use zimm_core::{Estimator, ParameterError};

/// The mean of the last samples of a stream, as many as a window holds, and its standard error: for a look at how a
/// quantity settles or drifts. Memory grows neither with the run nor with the window.
///
/// The window is kept as the means of 64 stretches, and moves on by one of them at a time; so it holds the samples
/// asked for and up to 1/64 more. Errors are those of [`BlockAverage`](crate::BlockAverage) on the samples in it.
///
/// ```
/// use zimm_analysis::SlidingAverage;
/// use zimm_core::Estimator;
///
/// let mut average = SlidingAverage::new(3)?;
/// for sample in [10.0, 1.0, 2.0, 6.0] {
///     average.push(sample);
/// }
/// assert_eq!(average.estimate()?.value, 3.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SlidingAverage {
    stretches: VecDeque<Moments>,
    open: Moments,
    /// Most stretches kept, and the samples in each.
    most: usize,
    length: u64,
    samples: u64,
    not_finite: Option<u64>,
}

impl SlidingAverage {
    /// Over a window of this many samples.
    ///
    /// # Errors
    /// If the window holds fewer than two samples.
    pub fn new(window: u64) -> Result<Self, ParameterError> {
        if window < 2 {
            let allowed = "2 samples or more";
            return Err(ParameterError::new("window", window as f64, allowed));
        }
        let length = window.div_ceil(64);
        let most = window.div_ceil(length) as usize;
        Ok(Self {
            stretches: VecDeque::with_capacity(most + 1),
            open: Moments::default(),
            most,
            length,
            samples: 0,
            not_finite: None,
        })
    }
}

impl Estimator for SlidingAverage {
    type Sample = f64;
    type Estimate = Result<Mean, AnalysisError>;

    fn push(&mut self, sample: f64) {
        if !sample.is_finite() {
            self.not_finite.get_or_insert(self.samples);
        }
        self.samples += 1;
        self.open.take(sample);
        if self.open.count == self.length {
            self.stretches.push_back(std::mem::take(&mut self.open));
            if self.stretches.len() > self.most {
                self.stretches.pop_front();
            }
        }
    }

    fn estimate(&self) -> Self::Estimate {
        if let Some(sample) = self.not_finite {
            let what = "a quantity";
            return Err(AnalysisError::NotFinite { what, sample });
        }
        let stretches: Vec<Moments> = self.stretches.iter().copied().collect();
        mean_of(&stretches, &self.open)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // The mean of the ramp k over the last samples is half of the first and the last in the window.
    #[test]
    fn law_the_window_moves_on_and_keeps_its_length() {
        for window in [2, 3, 63, 64, 65, 1000, 6400] {
            let mut average = SlidingAverage::new(window).unwrap();
            for k in 0..20_000_u64 {
                average.push(k as f64);
                if k == 0 {
                    assert!(average.estimate().is_err());
                    continue;
                }
                let held =
                    (2.0 * (k as f64 - average.estimate().unwrap().value) + 1.0).round() as u64;
                if k < window {
                    assert_eq!(held, k + 1);
                } else {
                    let most = window + 2 * window.div_ceil(64);
                    assert!((window..most).contains(&held), "{held} of {window} at {k}");
                }
            }
        }
    }

    #[test]
    fn extreme_bad_windows_and_samples_are_errors() {
        assert!(SlidingAverage::new(0).is_err());
        assert!(SlidingAverage::new(1).is_err());
        let mut average = SlidingAverage::new(u64::MAX).unwrap();
        average.push(1.0);
        average.push(2.0);
        assert_eq!(average.estimate().unwrap().value, 1.5);
        average.push(f64::INFINITY);
        let found = average.estimate();
        assert!(matches!(
            found,
            Err(AnalysisError::NotFinite { sample: 2, .. })
        ));
    }
}
