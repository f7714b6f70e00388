//! How long vectors remember.

use crate::blocks::{Blocks, plateau};
use crate::ratio_average::clear_of_zero;
use crate::{AnalysisError, BlockAverages, Mean};
use std::collections::VecDeque;
use std::ops::RangeInclusive;
use zimm_core::{DVec3, Estimator, ParameterError};

/// The autocorrelation of vectors, `C(t) = <x(t) . x(0)>`, averaged over them and over time, and the time in which it
/// decays.
///
/// A sample is one vector a molecule, at equal intervals of time: the amplitudes of a mode
/// ([`RouseModes`](crate::RouseModes)) or end-to-end vectors ([`EndToEnd`](crate::EndToEnd)). No mean is taken off:
/// theirs is zero at rest. Each sample is the end of all lags. It costs `lags` samples in memory and as many products.
///
/// ```
/// use zimm_analysis::Autocorrelation;
/// use zimm_core::{DVec3, Estimator};
///
/// // A vector that turns by an angle of cosine 1/e in two samples.
/// let angle = 0.5 * (-1.0_f64).exp().acos();
/// let mut correlation = Autocorrelation::new(0.1, 2, 0..=2)?;
/// for k in 0..5 {
///     let (sin, cos) = (angle * f64::from(k)).sin_cos();
///     correlation.push(vec![DVec3::new(cos, sin, 0.0)]);
/// }
/// assert!((correlation.relaxation_time()?.value - 0.2).abs() < 1e-14);
/// assert_eq!(correlation.estimate()?.times, [0.0, 0.1, 0.2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Autocorrelation {
    interval: f64,
    lags: usize,
    fit: [usize; 2],
    history: VecDeque<Vec<DVec3>>,
    correlation: BlockAverages,
    /// Of the correlation at the first and the last lag of the fit.
    ends: Blocks<2>,
    samples: u64,
    misfit: Option<AnalysisError>,
}

/// A correlation function. The lists have one entry a lag, from zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Decay {
    /// The lag times.
    pub times: Vec<f64>,
    /// The correlation at each lag, in the square of the vectors' unit; at zero it is their mean square.
    pub correlation: Vec<Mean>,
}

impl Autocorrelation {
    /// Samples come at this interval of time; correlations are kept for lags of 0 to `lags` intervals, and the first and
    /// the last of `fit` give the relaxation time.
    ///
    /// # Errors
    /// If the interval is not above zero, or `fit` is not within 0 to `lags` or holds fewer than two lags.
    pub fn new(
        interval: f64,
        lags: usize,
        fit: RangeInclusive<usize>,
    ) -> Result<Self, ParameterError> {
        let (first, last) = fit.into_inner();
        if last > lags || first >= last {
            let allowed = "within 0 to `lags`, and hold two lags or more";
            return Err(ParameterError::new("fit", last as f64, allowed));
        }
        Ok(Self {
            interval: ParameterError::positive("interval", interval)?,
            lags,
            fit: [first, last],
            history: VecDeque::with_capacity(lags + 1),
            correlation: BlockAverages::new(lags + 1),
            ends: Blocks::default(),
            samples: 0,
            misfit: None,
        })
    }

    /// The time in which the correlation decays between the first lag t_1 of the fit and the last t_2,
    ///
    /// ```text
    /// tau = (t_2 - t_1) / ln(C(t_1) / C(t_2))
    /// ```
    ///
    /// with the error that the fluctuations of both have in common. For a decay by a single exponential from zero on,
    /// t_1 = 0 and t_2 about tau is best; a later t_1 leaves faster decays out.
    ///
    /// # Errors
    /// If samples are fewer than `lags` + 2, of changing length or not finite, or if C(t_2), or the decay from t_1 to
    /// t_2, is closer to zero than four errors.
    pub fn relaxation_time(&self) -> Result<Mean, AnalysisError> {
        self.check()?;
        let [first, last] = self.ends.means()?;
        let error = |w| plateau(&self.ends.errors(w)).0;
        for (value, w) in [(last, [0.0, 1.0]), (first - last, [1.0, -1.0])] {
            clear_of_zero(Mean {
                value,
                error: error(w),
            })?;
        }
        let decay = (first / last).ln();
        let [t1, t2] = self.fit.map(|lag| lag as f64 * self.interval);
        let value = (t2 - t1) / decay;
        if !(value.is_finite() && value > 0.0) {
            return Err(AnalysisError::Denominator {
                mean: decay,
                error: 0.0,
            });
        }
        let error = error([-value / decay / first, value / decay / last]);
        Ok(Mean { value, error })
    }

    fn check(&self) -> Result<(), AnalysisError> {
        if let Some(misfit) = &self.misfit {
            return Err(misfit.clone());
        }
        let needed = self.lags as u64 + 2;
        if self.samples < needed {
            return Err(AnalysisError::TooFew {
                what: "samples",
                found: self.samples,
                needed,
            });
        }
        Ok(())
    }
}

impl Estimator for Autocorrelation {
    type Sample = Vec<DVec3>;
    type Estimate = Result<Decay, AnalysisError>;

    fn push(&mut self, vectors: Vec<DVec3>) {
        let expected = self.history.front().map_or(vectors.len(), Vec::len);
        if vectors.len() != expected || expected == 0 {
            self.misfit.get_or_insert(AnalysisError::Length {
                sample: self.samples,
                found: vectors.len(),
                expected: expected.max(1),
            });
            return;
        }
        self.samples += 1;
        self.history.push_back(vectors);
        if self.history.len() <= self.lags {
            return;
        }
        if let Some(now) = self.history.back() {
            let product = |then: &Vec<DVec3>| {
                let sum: f64 = now.iter().zip(then).map(|(a, b)| a.dot(*b)).sum();
                sum / now.len() as f64
            };
            let products: Vec<f64> = self.history.iter().rev().map(product).collect();
            self.correlation.take(&products);
            self.ends.push(self.fit.map(|lag| products[lag]));
        }
        self.history.pop_front();
    }

    fn estimate(&self) -> Self::Estimate {
        self.check()?;
        Ok(Decay {
            times: (0..=self.lags).map(|k| k as f64 * self.interval).collect(),
            correlation: self.correlation.estimate()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;

    // 400 short runs of one Ornstein-Uhlenbeck vector of unit variance, phi = 0.9, 4096 samples each: about 430
    // correlation times of the squares a run. The time from lags 0 and 8 against -1 / ln 0.9 = 9.491. Seeds 0..400. The
    // square of the pull, (found - exact) / error, has mean 1 if the error is honest, and the errors' own uncertainty of 10
    // to 20 % adds 3 to 12 %; 340 of them know it to 8 %. Bounds 0.75 and 1.4, 4 sigma: an error wrong by 17 % is caught.
    // The bias of second order is below 1 % of the time: bound 2 %, with 0.4 % from the scatter.
    #[test]
    fn limit_relaxation_times_have_honest_errors() {
        let (phi, mut squares, mut sum, mut known) = (0.9_f64, 0.0, 0.0, 0.0);
        let exact = -1.0 / phi.ln();
        for seed in 0..400 {
            let mut random = Random::new(seed);
            let mut correlation = Autocorrelation::new(1.0, 8, 0..=8).unwrap();
            let mut x = random.normal3();
            for _ in 0..4096 {
                correlation.push(vec![x]);
                x = phi * x + (1.0 - phi * phi).sqrt() * random.normal3();
            }
            let found = correlation.relaxation_time().unwrap();
            sum += found.value / exact / 400.0;
            if let Some(error) = found.standard_error() {
                squares += ((found.value - exact) / error).powi(2);
                known += 1.0;
            }
        }
        assert!(known > 300.0, "{known}");
        let pull = squares / known;
        assert!(pull > 0.75 && pull < 1.4, "{pull}");
        assert!((sum - 1.0).abs() < 0.02, "{sum}");
    }

    // Two vectors that turn at different rates: C = (4 cos(k) + cos(3 k)) / 2 at lag k, exactly.
    #[test]
    fn law_lags_are_counted_and_vectors_averaged() {
        let mut correlation = Autocorrelation::new(0.5, 6, 1..=2).unwrap();
        for k in 0..40 {
            let turned = |rate: f64| {
                DVec3::new(
                    (rate * f64::from(k)).cos(),
                    0.0,
                    (rate * f64::from(k)).sin(),
                )
            };
            correlation.push(vec![2.0 * turned(1.0), turned(3.0)]);
        }
        let found = correlation.estimate().unwrap();
        for (k, (time, mean)) in found.times.iter().zip(&found.correlation).enumerate() {
            let k = k as f64;
            assert_eq!(*time, 0.5 * k);
            let exact = 0.5 * (4.0 * k.cos() + (3.0 * k).cos());
            assert!((mean.value - exact).abs() < 1e-12, "{mean} at {k}");
        }
    }

    #[test]
    fn extreme_what_does_not_decay_has_no_time() {
        assert!(Autocorrelation::new(0.0, 3, 0..=3).is_err());
        for (first, last) in [(0, 4), (2, 2), (3, 1)] {
            assert!(Autocorrelation::new(1.0, 3, first..=last).is_err());
        }
        let fresh = Autocorrelation::new(1.0, 2, 0..=2).unwrap();
        let constant = |_| DVec3::X;
        let alternating = |k| if k % 4 < 2 { DVec3::X } else { -DVec3::X };
        let growing = |k| DVec3::X * 2.0_f64.powi(k);
        let zero = |_| DVec3::ZERO;
        let cases: [fn(i32) -> DVec3; 4] = [constant, alternating, growing, zero];
        for vector in cases {
            let mut correlation = fresh.clone();
            for k in 0..64 {
                correlation.push(vec![vector(k)]);
            }
            let found = correlation.relaxation_time();
            assert!(
                matches!(found, Err(AnalysisError::Denominator { .. })),
                "{found:?}"
            );
        }
        let mut noise = fresh.clone();
        let mut random = Random::new(93);
        for found in 0..4 {
            let (what, needed) = ("samples", 4);
            assert_eq!(
                noise.estimate(),
                Err(AnalysisError::TooFew {
                    what,
                    found,
                    needed
                })
            );
            noise.push(vec![random.normal3()]);
        }
        (0..1000).for_each(|_| noise.push(vec![random.normal3()]));
        assert!(matches!(
            noise.relaxation_time(),
            Err(AnalysisError::Denominator { .. })
        ));
        noise.push(vec![DVec3::NAN]);
        assert!(matches!(
            noise.relaxation_time(),
            Err(AnalysisError::NotFinite { .. })
        ));
        noise.push(vec![]);
        assert!(matches!(
            noise.estimate(),
            Err(AnalysisError::Length {
                found: 0,
                expected: 1,
                ..
            })
        ));
    }
}
