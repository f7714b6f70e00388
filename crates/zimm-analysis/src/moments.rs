//! Means and scatter of stretches of a run.

use crate::blocks::{settled, times_independent};
use crate::segments::{Join, grouped};
use crate::{AnalysisError, BlockLevel, Mean};

/// Number, mean and sum of squared deviations of some samples.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    pub(crate) count: u64,
    pub(crate) mean: f64,
    square: f64,
}

impl Moments {
    /// One more sample (Welford 1962).
    pub(crate) fn take(&mut self, sample: f64) {
        self.count += 1;
        let before = sample - self.mean;
        self.mean += before / self.count as f64;
        self.square += before * (sample - self.mean);
    }

    /// The squared error of the mean of independent samples.
    pub(crate) fn squared_error(&self) -> f64 {
        let count = self.count as f64;
        self.square / (count * (count - 1.0))
    }
}

impl Join for Moments {
    /// Chan, Golub and LeVeque (1979).
    fn join(&mut self, later: &Self) {
        let count = self.count + later.count;
        if count == 0 {
            return;
        }
        let apart = later.mean - self.mean;
        let share = later.count as f64 / count as f64;
        self.mean += share * apart;
        self.square += later.square + apart * apart * share * self.count as f64;
        self.count = count;
    }
}

/// The mean of stretches of equal length and of what came after them, with the error that groups of stretches show.
pub(crate) fn mean_of(stretches: &[Moments], open: &Moments) -> Result<Mean, AnalysisError> {
    let mut whole = *open;
    let (mut all, length) = (Moments::default(), stretches.first().map_or(0, |s| s.count));
    stretches.iter().for_each(|stretch| all.join(stretch));
    whole.join(&all);
    if whole.count < 2 {
        return Err(AnalysisError::TooFew {
            what: "samples",
            found: whole.count,
            needed: 2,
        });
    }
    let single = whole.squared_error().sqrt();
    let mut levels = Vec::new();
    for k in 0..stretches.len().max(1).ilog2() {
        let mut scatter = Moments::default();
        for group in grouped(stretches, 1 << k) {
            scatter.take(group.mean);
        }
        // What is not in a group counts as much as what is.
        let share = (scatter.count * (length << k)) as f64 / whole.count as f64;
        let error = (scatter.squared_error() * share).sqrt();
        levels.push(BlockLevel {
            length: length << k,
            blocks: scatter.count,
            error,
            uncertainty: error / (2.0 * (scatter.count as f64 - 1.0)).sqrt(),
        });
    }
    let (error, _) = settled(&levels, whole.count as f64, |level| {
        times_independent(level.error, single)
    });
    Ok(Mean {
        value: whole.mean,
        error,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;
    use crate::{BlockAverage, StandardError};
    use zimm_core::Estimator;

    // Stretches of 64 samples of a correlated series, and some samples beyond, show what blocks of 64, 128, ... of the
    // series do, but for the samples beyond, which the first leave out.
    #[test]
    fn law_stretches_show_what_blocks_do() {
        let (mut random, mut x) = (Random::new(101), 0.0);
        let (mut blocks, mut stretches) = (BlockAverage::new(), vec![Moments::default(); 64]);
        for k in 0..4096 {
            x = 0.6 * x + random.normal();
            blocks.push(3.0 + x);
            stretches[k / 64].take(3.0 + x);
        }
        let (expected, found) = (
            blocks.estimate().unwrap(),
            mean_of(&stretches, &Moments::default()).unwrap(),
        );
        approx::assert_relative_eq!(found.value, expected.value, max_relative = 1e-13);
        let StandardError::Plateau { error, uncertainty } = found.error else {
            panic!("{found}");
        };
        let level = |level: &&BlockLevel| (level.error / error - 1.0).abs() < 1e-12;
        let levels = blocks.levels();
        let level = levels.iter().find(level).unwrap();
        assert!(level.length >= 64, "{level:?}");
        approx::assert_relative_eq!(uncertainty, level.uncertainty, max_relative = 1e-12);
    }

    #[test]
    fn law_joining_is_as_good_as_taking_one_by_one() {
        let series = [3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0, 6.0];
        let moments = |part: &[f64]| {
            let mut moments = Moments::default();
            part.iter().for_each(|&x| moments.take(x));
            moments
        };
        for cut in 0..=series.len() {
            let mut joined = moments(&series[..cut]);
            joined.join(&moments(&series[cut..]));
            let whole = moments(&series);
            assert_eq!(joined.count, 8);
            approx::assert_relative_eq!(joined.mean, whole.mean, max_relative = 1e-14);
            approx::assert_relative_eq!(joined.square, whole.square, max_relative = 1e-13);
        }
    }
}
