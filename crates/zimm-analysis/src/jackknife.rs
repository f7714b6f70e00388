//! Functions of many means of the same run.

use crate::segments::{Join, Segments, grouped};
use crate::{AnalysisError, Mean, StandardError};
use std::io::{self, Read, Write};
use zimm_core::Estimator;

/// The means of many quantities that are sampled together, and the error of any function of them, however they are
/// correlated with each other and in time.
///
/// The run is kept as the sums of 32 to 63 blocks of equal length: when there are 64, each pair becomes one block of
/// twice the length, so memory does not grow. The error of a function F is that of the jackknife,
///
/// ```text
/// error^2 = (B - 1) / B  sum_b (F_b - F_mean)^2,    F_b = F(means without block b)
/// ```
///
/// (Efron and Tibshirani, An Introduction to the Bootstrap, 1993, sec. 11.5), to first order in the fluctuations.
/// Blocks are taken for independent unless groups of two or four of them show an error that is greater by two of its
/// own uncertainties; the largest is then a lower bound, as it is with fewer than 16 blocks. Samples of a block that
/// is not complete, up to 3 % of the run, wait until it is.
///
/// ```
/// use zimm_analysis::Jackknife;
/// use zimm_core::Estimator;
///
/// let mut runs = Jackknife::new(2);
/// for k in 0..40 {
///     let noise = f64::from(k * 17 % 41) / 41.0 - 0.5;
///     runs.push(vec![6.0 + noise, 2.0 + noise]);
/// }
/// let ratio = &runs.of(|means| Ok(vec![means[0] / means[1]]))?[0];
/// assert!((ratio.value - 3.0).abs() < 4.0 * ratio.at_least());
/// # Ok::<(), zimm_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Jackknife {
    width: usize,
    /// The sums of the samples of each block.
    blocks: Segments<Vec<f64>>,
    samples: u64,
    misfit: Option<AnalysisError>,
}

/// Blocks at which pairs of them are joined.
const MOST: usize = 64;
/// Fewest blocks whose scatter is called an error.
const FEWEST: usize = 16;
/// Fewest groups of blocks that may speak against it.
const FEWEST_HEARD: usize = 8;
/// Blocks in a group.
const GROUPS: [usize; 3] = [1, 2, 4];
/// Uncertainties by which the error may grow from blocks to groups.
const GROWTH: f64 = 2.0;

impl Jackknife {
    /// No samples yet of this many quantities.
    pub fn new(quantities: usize) -> Self {
        Self {
            width: quantities,
            blocks: Segments::new(MOST),
            samples: 0,
            misfit: None,
        }
    }

    /// Number of samples, those that wait included.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Writes the state, bit for bit, so that a long run can go on from it: numbers of 8 bytes, little-endian.
    ///
    /// # Errors
    /// If writing fails, or a sample was no good: that is the end of the statistic.
    pub fn save(&self, out: &mut impl Write) -> io::Result<()> {
        if let Some(misfit) = &self.misfit {
            return Err(io::Error::new(io::ErrorKind::InvalidData, misfit.clone()));
        }
        let complete = self.blocks.complete();
        let (length, filled) = (self.blocks.length(), self.blocks.filled());
        let head = [self.width as u64, complete.len() as u64, length, filled];
        for number in head.into_iter().chain([self.samples]) {
            out.write_all(&number.to_le_bytes())?;
        }
        for x in complete.iter().flatten().chain(self.blocks.open()) {
            out.write_all(&x.to_le_bytes())?;
        }
        Ok(())
    }

    /// Takes up the state that [`save`](Self::save) wrote and forgets its own.
    ///
    /// # Errors
    /// If reading fails, or the state is not one of as many quantities.
    pub fn restore(&mut self, input: &mut impl Read) -> io::Result<()> {
        let mut eight = || {
            let mut bytes = [0; 8];
            input.read_exact(&mut bytes).map(|()| bytes)
        };
        let mut head = [0; 5];
        for number in &mut head {
            *number = u64::from_le_bytes(eight()?);
        }
        let [width, blocks, length, filled, samples] = head;
        let seen = blocks
            .checked_mul(length)
            .and_then(|n| n.checked_add(filled));
        let fits = width == self.width as u64 && blocks < MOST as u64 && filled < length;
        if !fits || seen != Some(samples) {
            let why = format!(
                "no statistic of {} quantities: {width} in {blocks} blocks of {length}",
                self.width
            );
            return Err(io::Error::new(io::ErrorKind::InvalidData, why));
        }
        let mut row = || -> io::Result<Vec<f64>> {
            let numbers = (0..width).map(|_| Ok(f64::from_le_bytes(eight()?)));
            numbers.collect()
        };
        let mut rows = Vec::new();
        for _ in 0..blocks {
            rows.push(row()?);
        }
        let open = if filled > 0 { row()? } else { Vec::new() };
        *self = Self {
            width: self.width,
            blocks: Segments::resumed(MOST, (rows, length), (open, filled)),
            samples,
            misfit: None,
        };
        Ok(())
    }

    /// The values of a function of the means, each with its error.
    ///
    /// # Errors
    /// If there are fewer than two blocks, a sample was not finite or of another length, the function fails or gives
    /// what is not finite.
    pub fn of(
        &self,
        function: impl Fn(&[f64]) -> Result<Vec<f64>, AnalysisError>,
    ) -> Result<Vec<Mean>, AnalysisError> {
        Self::joint(&[self], |means| {
            function(means.first().map_or(&[], Vec::as_slice))
        })
    }

    /// The values of a function of the means of several independent runs.
    pub(crate) fn joint(
        runs: &[&Self],
        function: impl Fn(&[Vec<f64>]) -> Result<Vec<f64>, AnalysisError>,
    ) -> Result<Vec<Mean>, AnalysisError> {
        let function = |means: &[Vec<f64>]| {
            let values = function(means)?;
            match values.iter().all(|x| x.is_finite()) {
                true => Ok(values),
                false => Err(AnalysisError::NotFinite {
                    what: "a function of the means",
                    sample: runs.iter().map(|run| run.samples).sum(),
                }),
            }
        };
        let mut means = Vec::new();
        for run in runs {
            means.push(run.means()?);
        }
        let values = function(&means)?;
        let blocks = runs.iter().map(|run| run.blocks.complete().len());
        let fewest = blocks.min().unwrap_or(0);
        let mut errors = Vec::new();
        for size in GROUPS {
            let groups = fewest / size;
            if size > 1 && groups < FEWEST_HEARD {
                break;
            }
            let mut squares = vec![0.0; values.len()];
            for (k, run) in runs.iter().enumerate() {
                let whole = means[k].clone();
                run.leave_out(size, |without| {
                    means[k] = without;
                    function(&means)
                })?
                .into_iter()
                .zip(&mut squares)
                .for_each(|(square, sum)| *sum += square);
                means[k] = whole;
            }
            errors.push((groups, squares));
        }
        let error = |k: usize| {
            let mut levels = errors.iter().map(|(groups, squares)| {
                (squares[k].sqrt(), (2.0 * (*groups as f64 - 1.0)).sqrt())
            });
            let (error, scale) = levels.next().unwrap_or((0.0, 1.0));
            let grown = |&(longer, scale): &(f64, f64)| longer - error > GROWTH * error / scale;
            let most = levels.filter(grown).map(|(e, _)| e).fold(error, f64::max);
            if most > error || fewest < FEWEST {
                StandardError::AtLeast(most)
            } else {
                let uncertainty = error / scale;
                StandardError::Plateau { error, uncertainty }
            }
        };
        let with_error = |(k, &value)| Mean {
            value,
            error: error(k),
        };
        Ok(values.iter().enumerate().map(with_error).collect())
    }

    /// The means of all complete blocks.
    fn means(&self) -> Result<Vec<f64>, AnalysisError> {
        if let Some(misfit) = &self.misfit {
            return Err(misfit.clone());
        }
        let blocks = self.blocks.complete();
        if blocks.len() < 2 {
            return Err(AnalysisError::TooFew {
                what: "samples",
                found: self.samples,
                needed: 2,
            });
        }
        Ok(over(
            total(blocks),
            blocks.len() as f64 * self.blocks.length() as f64,
        ))
    }

    /// (G - 1) / G times the sum of squared deviations of a function as each of G groups of blocks is left out.
    fn leave_out(
        &self,
        size: usize,
        mut function: impl FnMut(Vec<f64>) -> Result<Vec<f64>, AnalysisError>,
    ) -> Result<Vec<f64>, AnalysisError> {
        let groups = grouped(self.blocks.complete(), size);
        let (all, count) = (total(&groups), groups.len() as f64);
        let samples = (count - 1.0) * size as f64 * self.blocks.length() as f64;
        let mut found = Vec::new();
        for group in &groups {
            let without = all.iter().zip(group).map(|(all, one)| all - one);
            found.push(function(over(without.collect(), samples))?);
        }
        let centre = over(total(&found), count);
        let mut squares = vec![0.0; centre.len()];
        for values in &found {
            for ((square, x), c) in squares.iter_mut().zip(values).zip(&centre) {
                *square += (x - c).powi(2) * (count - 1.0) / count;
            }
        }
        Ok(squares)
    }
}

impl Estimator for Jackknife {
    type Sample = Vec<f64>;
    type Estimate = Result<Vec<Mean>, AnalysisError>;

    fn push(&mut self, sample: Vec<f64>) {
        let problem = if sample.len() != self.width {
            Some(AnalysisError::Length {
                sample: self.samples,
                found: sample.len(),
                expected: self.width,
            })
        } else if !sample.iter().all(|x| x.is_finite()) {
            let what = "a quantity";
            let sample = self.samples;
            Some(AnalysisError::NotFinite { what, sample })
        } else {
            None
        };
        if let Some(problem) = problem {
            self.misfit.get_or_insert(problem);
        }
        self.samples += 1;
        self.blocks.add(|open| open.join(&sample));
    }

    fn estimate(&self) -> Self::Estimate {
        self.of(|means| Ok(means.to_vec()))
    }
}

/// Sums, quantity by quantity; nothing is zero.
impl Join for Vec<f64> {
    fn join(&mut self, later: &Self) {
        if self.is_empty() {
            self.clone_from(later);
        } else {
            self.iter_mut().zip(later).for_each(|(sum, x)| *sum += x);
        }
    }
}

fn total(rows: &[Vec<f64>]) -> Vec<f64> {
    let mut total = Vec::new();
    rows.iter().for_each(|row| total.join(row));
    total
}

fn over(mut sums: Vec<f64>, count: f64) -> Vec<f64> {
    sums.iter_mut().for_each(|sum| *sum /= count);
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;

    /// A ratio of means of 2 and 1 whose numerator and denominator follow autoregressive processes, x' = c x + noise,
    /// with stationary variances of 0.04 and a correlation of 1/2 between them.
    fn ratio(random: &mut Random, samples: u32, c: f64) -> Mean {
        let mut jackknife = Jackknife::new(2);
        let mut draw = || {
            let (a, b) = (random.normal(), random.normal());
            [a, 0.5 * a + 0.75_f64.sqrt() * b]
        };
        let mut x = draw();
        for _ in 0..samples {
            let noise = draw();
            for (x, noise) in x.iter_mut().zip(noise) {
                *x = c * *x + (1.0 - c * c).sqrt() * noise;
            }
            jackknife.push(vec![2.0 + 0.2 * x[0], 1.0 + 0.2 * x[1]]);
        }
        jackknife.of(|means| Ok(vec![means[0] / means[1]])).unwrap()[0]
    }

    // 600 runs each, seed 41: of 40 samples without memory, of 2500 with a correlation time of 10 samples, and of 400,
    // which are too few. The ratio has a standard deviation of 0.2 sqrt(1 + 4 - 2) (tau / samples)^(1/2), tau = (1 + c)
    // / (1 - c); that of 600 deviations is known to 3 %, bound 12 %. Where the error is known, 68 % of the runs are to
    // lie within one, 95 % within two: binomial errors 1.9 and 0.9 %, bounds 4 of them and what 32 blocks entail.
    #[test]
    fn limit_errors_of_a_ratio_cover_what_they_say() {
        let mut random = Random::new(41);
        for (samples, c, known) in [
            (40, 0.0, 0.85),
            (2500, 9.0 / 11.0, 0.85),
            (400, 9.0 / 11.0, 0.3),
        ] {
            let runs: Vec<Mean> = (0..600).map(|_| ratio(&mut random, samples, c)).collect();
            let exact = 0.2 * (3.0 * (1.0 + c) / (1.0 - c) / f64::from(samples)).sqrt();
            let off = |run: &Mean| (run.value - 2.0).abs();
            let square = runs.iter().map(|run| off(run).powi(2)).sum::<f64>() / 600.0;
            assert!(
                (square.sqrt() / exact - 1.0).abs() < 0.12,
                "{samples}: {square}"
            );
            let told: Vec<_> = runs
                .iter()
                .filter(|run| run.standard_error().is_some())
                .collect();
            let share = told.len() as f64 / 600.0;
            let within = |errors: f64| {
                let hits = told.iter().filter(|run| off(run) < errors * run.at_least());
                hits.count() as f64 / told.len() as f64
            };
            let (one, two) = (within(1.0), within(2.0));
            println!("{samples} samples: told {share:.2}, within one {one:.3}, two {two:.3}");
            if known > 0.5 {
                assert!(share > known, "{share}");
                assert!(
                    (one - 0.68).abs() < 0.08 && (two - 0.945).abs() < 0.04,
                    "{one} {two}"
                );
            }
        }
    }

    #[test]
    fn law_memory_does_not_grow_and_no_complete_block_is_lost() {
        let mut jackknife = Jackknife::new(3);
        for k in 0..10_000_u32 {
            jackknife.push(vec![f64::from(k), 1.0, -2.0]);
            assert!(jackknife.blocks.complete().len() < MOST);
        }
        let blocks = &jackknife.blocks;
        let seen = blocks.complete().len() as u64 * blocks.length();
        assert!(jackknife.samples() == 10_000 && seen > 9_700, "{seen}");
        let means = jackknife.estimate().unwrap();
        assert!((means[0].value - 0.5 * (seen - 1) as f64).abs() < 1e-8);
        assert!((means[1].value, means[2].value) == (1.0, -2.0));
        // A drift is no stationary mean: groups of blocks tell.
        assert_eq!(means[0].standard_error(), None);
    }

    #[test]
    fn law_a_state_comes_back_bit_for_bit() {
        let mut random = Random::new(44);
        let mut jackknife = Jackknife::new(2);
        for samples in [0, 1, 70, 1000] {
            for _ in 0..samples {
                jackknife.push(vec![random.normal(), random.normal()]);
            }
            let mut file = Vec::new();
            jackknife.save(&mut file).unwrap();
            let mut again = Jackknife::new(2);
            again.restore(&mut file.as_slice()).unwrap();
            assert_eq!(
                (again.blocks.complete(), again.samples),
                (jackknife.blocks.complete(), jackknife.samples)
            );
            assert_eq!(again.estimate(), jackknife.estimate());
            assert!(Jackknife::new(3).restore(&mut file.as_slice()).is_err());
            assert!(again.restore(&mut &file[..file.len() - 1]).is_err());
            file[16] ^= 1;
            assert!(again.restore(&mut file.as_slice()).is_err() || samples == 0);
        }
        jackknife.push(vec![]);
        assert!(jackknife.save(&mut Vec::new()).is_err());
    }

    // The mean of two independent runs, one of twice the scatter: (x + y) / 2 with variances 1/40 and 4/40 has an error
    // of 0.177; that of 20 blocks each is known to 10 %.
    #[test]
    fn law_runs_are_independent() {
        let mut random = Random::new(43);
        let (mut one, mut two) = (Jackknife::new(1), Jackknife::new(1));
        for _ in 0..40 {
            one.push(vec![random.normal()]);
            two.push(vec![2.0 * random.normal()]);
        }
        let both = Jackknife::joint(&[&one, &two], |means| {
            Ok(vec![0.5 * (means[0][0] + means[1][0])])
        });
        let [one, two] = [one, two].map(|run| run.estimate().unwrap()[0].at_least());
        let found = both.unwrap()[0];
        assert!((found.at_least() - 0.5 * one.hypot(two)).abs() < 1e-12);
        assert!((found.at_least() / 0.177 - 1.0).abs() < 0.4, "{found}");
    }

    #[test]
    fn extreme_samples_and_functions_that_are_no_good_are_errors() {
        let of = |samples: &[Vec<f64>]| {
            let mut jackknife = Jackknife::new(2);
            samples
                .iter()
                .for_each(|sample| jackknife.push(sample.clone()));
            jackknife
        };
        let good = vec![1.0, 2.0];
        assert!(of(&[]).estimate().is_err() && of(std::slice::from_ref(&good)).estimate().is_err());
        let few = of(&[good.clone(), good.clone()]).estimate().unwrap();
        assert_eq!((few[0].value, few[0].standard_error()), (1.0, None));
        let short = of(&[good.clone(), vec![1.0], good.clone()]).estimate();
        assert!(matches!(
            short,
            Err(AnalysisError::Length { sample: 1, .. })
        ));
        let nan = of(&[good.clone(), good.clone(), vec![1.0, f64::NAN]]).estimate();
        assert!(matches!(
            nan,
            Err(AnalysisError::NotFinite { sample: 2, .. })
        ));
        let divided = of(&[good.clone(), good]).of(|means| Ok(vec![1.0 / (means[0] - 1.0)]));
        assert!(matches!(divided, Err(AnalysisError::NotFinite { .. })));
    }
}
