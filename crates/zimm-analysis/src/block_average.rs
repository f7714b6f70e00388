//! Means of correlated samples, with an error that knows whether it is one.

use crate::blocks::{Blocks, plateau};
use crate::{AnalysisError, Mean};
use zimm_core::Estimator;

/// The mean of a stream of correlated samples and its standard error, by block averages (Flyvbjerg and Petersen,
/// J. Chem. Phys. 91, 461, 1989). Memory grows as the logarithm of the number of samples.
///
/// The error of the mean, computed from blocks of 1, 2, 4, ... samples as if blocks were independent, grows with the
/// length of the blocks until it levels off. The error is taken from the shortest blocks that
///
/// * are at least 16,
/// * are so long that their correlation biases the error less than their number scatters it: L^3 > 2 n c^2 with
///   c = (error_L / error_1)^2 (Wolff, Comput. Phys. Commun. 156, 143, 2004, eq. 47; Lee et al., Phys. Rev. E 83,
///   066706, 2011, eq. 14),
/// * show no less than longer ones do, down to 8 blocks, and no more than those of a quarter of the length, within
///   the scatter (1.5 and 2 standard deviations): a slow mode of small amplitude shows there and nowhere else.
///
/// If there are none, the run is too short for its correlations: the estimate then holds a lower bound and says so
/// ([`StandardError::AtLeast`](crate::StandardError::AtLeast)). A plateau takes 100 to 200 independent samples. The
/// error is then known to 10 or 20 %, which is part of the estimate. No method sees a mode that is slower than the
/// run is long.
///
/// ```
/// use zimm_analysis::BlockAverage;
/// use zimm_core::Estimator;
///
/// let mut average = BlockAverage::new();
/// assert!(average.estimate().is_err());
/// for k in 0..4096_u64 {
///     average.push((k * 2_654_435_769 % 1000) as f64 / 1000.0);
/// }
/// let mean = average.estimate()?;
/// assert!((mean.value - 0.5).abs() < 0.01);
/// assert!(mean.standard_error().is_some());
/// # Ok::<(), zimm_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct BlockAverage {
    blocks: Blocks<1>,
}

/// The error of the mean as blocks of one length show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockLevel {
    /// Samples in a block.
    pub length: u64,
    /// Number of blocks.
    pub blocks: u64,
    /// Error of the mean if these blocks were independent.
    pub error: f64,
    /// One standard deviation of that error if these blocks were independent.
    pub uncertainty: f64,
}

impl BlockAverage {
    /// No samples yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.blocks.samples()
    }

    /// Number of independent samples that would have the same error, if the error is known.
    pub fn effective_samples(&self) -> Option<f64> {
        let levels = self.levels();
        let single = levels.first()?;
        let (_, chosen) = plateau(&levels);
        let correlated = (chosen?.error / single.error).powi(2);
        let effective = self.samples() as f64 / correlated;
        effective.is_finite().then_some(effective)
    }

    /// The error at every block length, for a look at the plateau.
    pub fn levels(&self) -> Vec<BlockLevel> {
        self.blocks.errors([1.0])
    }
}

impl Estimator for BlockAverage {
    type Sample = f64;
    type Estimate = Result<Mean, AnalysisError>;

    fn push(&mut self, sample: f64) {
        self.blocks.push([sample]);
    }

    fn estimate(&self) -> Self::Estimate {
        let [value] = self.blocks.means()?;
        let (error, _) = plateau(&self.levels());
        Ok(Mean { value, error })
    }
}

/// The means of several streams that are sampled together.
///
/// ```
/// use zimm_analysis::BlockAverages;
/// use zimm_core::Estimator;
///
/// let mut averages = BlockAverages::new(2);
/// averages.push(vec![1.0, 10.0]);
/// averages.push(vec![3.0, 30.0]);
/// let means = averages.estimate()?;
/// assert_eq!((means[0].value, means[1].value), (2.0, 20.0));
/// # Ok::<(), zimm_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Debug)]
pub struct BlockAverages {
    averages: Vec<BlockAverage>,
    samples: u64,
    misfit: Option<AnalysisError>,
}

impl BlockAverages {
    /// No samples yet of this many streams.
    pub fn new(streams: usize) -> Self {
        Self {
            averages: vec![BlockAverage::new(); streams],
            samples: 0,
            misfit: None,
        }
    }

    /// The streams one by one.
    pub fn streams(&self) -> &[BlockAverage] {
        &self.averages
    }

    pub(crate) fn take(&mut self, sample: &[f64]) {
        if sample.len() == self.averages.len() {
            for (average, &x) in self.averages.iter_mut().zip(sample) {
                average.push(x);
            }
        } else {
            self.misfit.get_or_insert(AnalysisError::Length {
                sample: self.samples,
                found: sample.len(),
                expected: self.averages.len(),
            });
        }
        self.samples += 1;
    }
}

impl Estimator for BlockAverages {
    type Sample = Vec<f64>;
    type Estimate = Result<Vec<Mean>, AnalysisError>;

    fn push(&mut self, sample: Vec<f64>) {
        self.take(&sample);
    }

    fn estimate(&self) -> Self::Estimate {
        match &self.misfit {
            Some(misfit) => Err(misfit.clone()),
            None => self.averages.iter().map(BlockAverage::estimate).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::StandardError;
    use crate::scene::Random;

    /// What repeated runs of a process of known error show: share of runs with a plateau, shares of those whose mean
    /// is within 1 and 1.96 errors of the truth, and the mean square error found over the true one.
    struct Coverage {
        reached: f64,
        one: f64,
        two: f64,
        ratio: f64,
    }

    /// Runs x_k = fast noise + slow mode: `white` times white noise, plus `slow` times a process of unit variance
    /// whose autocorrelation is phi^k, in a stationary state (an Ornstein-Uhlenbeck process at equal times).
    fn coverage(white: f64, slow: f64, phi: f64, samples: u64, repeats: u64) -> Coverage {
        let (n, innovation) = (samples as f64, (1.0 - phi * phi).sqrt());
        let tail = 2.0 * phi * (1.0 - phi.powi(samples as i32)) / (n * (1.0 - phi).powi(2));
        let exact = (white * white + slow * slow * ((1.0 + phi) / (1.0 - phi) - tail)) / n;
        let (mut reached, mut one, mut two, mut square) = (0.0, 0.0, 0.0, 0.0);
        for seed in 0..repeats {
            let mut random = Random::new(seed);
            let mut average = BlockAverage::new();
            let mut mode = random.normal();
            for _ in 0..samples {
                average.push(white * random.normal() + slow * mode);
                mode = phi * mode + innovation * random.normal();
            }
            let mean = average.estimate().unwrap();
            if let Some(error) = mean.standard_error() {
                reached += 1.0;
                square += error * error / exact;
                one += (mean.value.abs() < error) as u8 as f64;
                two += (mean.value.abs() < 1.96 * error) as u8 as f64;
            }
        }
        Coverage {
            reached: reached / repeats as f64,
            one: one / reached,
            two: two / reached,
            ratio: (square / reached).sqrt(),
        }
    }

    // Seeds 0..2000, or as many as there are runs. With 2000 runs the binomial errors of the shares are 1.04 % and 0.49
    // %. Nominal shares are 68.3 % and 95 %; about 25 blocks (Student's t) take 1 % off both, the blocks' correlation
    // another 1 % at most. Bounds: 4 sigma and those 2 %, which an error bar wrong by 13 % breaks (dP / d ln error =
    // 0.48). The error itself, averaged over runs, is good to 1 % statistically and 6 % by design; wrong by 10 % is
    // caught.
    fn assert_honest(found: &Coverage) {
        assert!(found.reached > 0.8, "plateau in {}", found.reached);
        assert!((found.one - 0.683).abs() < 0.062, "68 %: {}", found.one);
        assert!((found.two - 0.950).abs() < 0.040, "95 %: {}", found.two);
        assert!((found.ratio - 1.0).abs() < 0.08, "error {}", found.ratio);
    }

    #[test]
    fn limit_white_noise_is_covered() {
        assert_honest(&coverage(1.0, 0.0, 0.0, 1000, 2000));
    }

    // The Ornstein-Uhlenbeck process A' = A - 0.9 A dt + normal sqrt(dt), dt = 0.01, for T = 20 000 (2 000 000 samples).
    // Its variance is dt / (1 - (1 - 0.9 dt)^2) = 0.55807, the plateau of its error 1 / (0.9 sqrt(T)) = 0.007857, 15
    // times the error of independent samples. Four runs, seeds 77 to 80. Blocks of 4096 samples are 37 correlation times
    // long and show 1 - 1/37 of the squared plateau; 1952 of them know it to sqrt(2 / 1952) = 3.2 %, bound 4 of that: 6.4 %
    // of the error. The error chosen is known less well, and must be within 4 of its own uncertainty, below 15 %. The
    // variance, as the mean of A^2, has an error of 0.75 % from 36 000 independent samples: bound 3 %.
    #[test]
    fn limit_the_plateau_of_an_ornstein_uhlenbeck_process() {
        let (dt, samples, runs) = (0.01_f64, 2_000_000, 4);
        let exact = dt / (1.0 - (1.0 - 0.9 * dt).powi(2));
        approx::assert_relative_eq!(exact, 0.558_07, max_relative = 1e-5);
        let plateau = 1.0 / (0.9 * (samples as f64 * dt).sqrt());
        let (mut variance, mut square) = (0.0, 0.0);
        for seed in 77..77 + runs {
            let mut random = Random::new(seed);
            let mut average = BlockAverage::new();
            let mut a = exact.sqrt() * random.normal();
            for _ in 0..samples {
                average.push(a);
                variance += a * a / (samples * runs) as f64;
                a += -0.9 * a * dt + dt.sqrt() * random.normal();
            }
            let level = average.levels()[12];
            assert_eq!(level.length, 4096);
            square += (level.error / plateau).powi(2) / runs as f64;
            let mean = average.estimate().unwrap();
            assert!(mean.value.abs() < 4.0 * plateau, "{mean}");
            let StandardError::Plateau { error, uncertainty } = mean.error else {
                panic!("{mean}");
            };
            assert!(uncertainty < 0.15 * plateau, "{uncertainty}");
            assert!((error - plateau).abs() < 4.0 * uncertainty, "{error}");
        }
        assert!((variance / exact - 1.0).abs() < 0.03, "{variance}");
        assert!((square - 0.973).abs() < 0.128, "{square}");
    }

    // Integrated autocorrelation time (1 + phi) / (1 - phi) = 19 samples: 431 independent ones.
    #[test]
    fn limit_an_autoregressive_process_is_covered() {
        assert_honest(&coverage(0.0, 1.0, 0.9, 8192, 2000));
    }

    // All but 4 % of the variance is fast noise, 8/9 of the squared error a slow mode (199 samples for an independent
    // one, 329 of them). Blocks chosen by their growth over single samples alone understate this error by 15 %.
    #[test]
    fn limit_a_slow_mode_under_fast_noise_is_covered() {
        assert_honest(&coverage(1.0, 0.2, 0.99, 65_536, 500));
    }

    // Successive samples are anticorrelated, phi = -0.7: single samples would show 2.4 times the true error.
    #[test]
    fn limit_an_anticorrelated_process_is_covered() {
        assert_honest(&coverage(0.0, 1.0, -0.7, 4096, 1000));
    }

    // 105 independent samples, 19 apart: 16 blocks are then not long enough for their correlations, though their error
    // happens to look flat in one of five runs. 1000 runs; a plateau in more than 3 % would be a false promise.
    #[test]
    fn extreme_a_plateau_by_chance_is_none() {
        let found = coverage(0.0, 1.0, 0.9, 2000, 1000);
        assert!(found.reached < 0.03, "plateau in {}", found.reached);
    }

    // 5 independent samples (phi = 0.98: 99 samples each) of 512: the error cannot be known. 500 runs; a plateau in
    // more than one in a hundred would be a false promise.
    #[test]
    fn extreme_a_short_correlated_series_has_no_plateau() {
        let found = coverage(0.0, 1.0, 0.98, 512, 500);
        assert!(found.reached < 0.01, "plateau in {}", found.reached);
    }

    #[test]
    fn law_levels_are_those_of_the_blocks() {
        let series = [3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0, 6.0, 5.0];
        let mut average = BlockAverage::new();
        series.iter().for_each(|&x| average.push(x));
        for (k, level) in average.levels().iter().enumerate() {
            let blocks: Vec<f64> = series
                .chunks_exact(1 << k)
                .map(|c| c.iter().sum::<f64>() / c.len() as f64)
                .collect();
            let n = blocks.len() as f64;
            let mean = blocks.iter().sum::<f64>() / n;
            let square: f64 = blocks.iter().map(|b| (b - mean) * (b - mean)).sum();
            let error = (square / (n * (n - 1.0))).sqrt();
            assert_eq!((level.length, level.blocks), (1 << k, blocks.len() as u64));
            approx::assert_relative_eq!(level.error, error, max_relative = 1e-14);
            approx::assert_relative_eq!(
                level.uncertainty,
                error / (2.0 * (n - 1.0)).sqrt(),
                max_relative = 1e-14
            );
        }
        assert_eq!(average.levels().len(), 3);
    }

    // 431 independent samples of 8192, known to twice the relative error of the error (10 % to 18 %): bound 60 %.
    #[test]
    fn limit_effective_samples_are_those_of_the_correlation_time() {
        let mut random = Random::new(3);
        let mut average = BlockAverage::new();
        let mut x = random.normal();
        for _ in 0..8192 {
            average.push(x);
            x = 0.9 * x + 0.19_f64.sqrt() * random.normal();
        }
        let effective = average.effective_samples().unwrap();
        assert!((effective / 431.0 - 1.0).abs() < 0.6, "{effective}");
    }

    #[test]
    fn extreme_too_little_is_an_error_and_no_number() {
        let mut average = BlockAverage::new();
        for found in 0..2 {
            let (what, needed) = ("samples", 2);
            assert_eq!(
                average.estimate(),
                Err(AnalysisError::TooFew {
                    what,
                    found,
                    needed
                })
            );
            assert_eq!(
                (average.effective_samples(), average.levels().len()),
                (None, 0)
            );
            average.push(1.0);
        }
        let mean = average.estimate().unwrap();
        assert_eq!((mean.value, mean.error), (1.0, StandardError::AtLeast(0.0)));
    }

    #[test]
    fn extreme_a_sample_that_is_not_finite_is_reported() {
        let mut average = BlockAverage::new();
        for x in [1.0, 2.0, f64::NAN, 3.0, f64::INFINITY] {
            average.push(x);
        }
        let found = average.estimate();
        assert!(
            matches!(found, Err(AnalysisError::NotFinite { sample: 2, .. })),
            "{found:?}"
        );
    }

    #[test]
    fn extreme_a_constant_has_no_error_and_a_large_offset_no_effect() {
        let (mut constant, mut shifted, mut plain) = (
            BlockAverage::new(),
            BlockAverage::new(),
            BlockAverage::new(),
        );
        let mut random = Random::new(9);
        for _ in 0..1024 {
            let x = random.normal();
            constant.push(0.1);
            plain.push(x);
            shifted.push(x + 1e8);
        }
        let mean = constant.estimate().unwrap();
        assert_eq!((mean.value, mean.standard_error()), (0.1, Some(0.0)));
        let (plain, shifted) = (plain.estimate().unwrap(), shifted.estimate().unwrap());
        approx::assert_relative_eq!(plain.at_least(), shifted.at_least(), max_relative = 1e-6);
    }

    #[test]
    fn extreme_samples_of_changing_length_are_reported() {
        let mut averages = BlockAverages::new(2);
        averages.push(vec![1.0, 2.0]);
        averages.push(vec![1.0]);
        let (sample, found, expected) = (1, 1, 2);
        assert_eq!(
            averages.estimate(),
            Err(AnalysisError::Length {
                sample,
                found,
                expected
            })
        );
    }
}
