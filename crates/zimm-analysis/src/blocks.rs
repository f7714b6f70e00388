//! Blocks of blocks: the moments of a stream at every block length 1, 2, 4, ..., and where their error levels off.

use crate::{AnalysisError, BlockLevel, StandardError};

/// Moments of blocks of `D` quantities at every power of two; memory grows as the logarithm of the stream.
#[derive(Clone, Debug)]
pub(crate) struct Blocks<const D: usize> {
    levels: Vec<Level<D>>,
    samples: u64,
    not_finite: Option<u64>,
}

#[derive(Clone, Debug)]
struct Level<const D: usize> {
    blocks: u64,
    mean: [f64; D],
    /// Sums of products of deviations from the mean.
    moments: [[f64; D]; D],
    /// A block that waits for the next one to make a block of twice the length.
    waiting: Option<[f64; D]>,
}

impl<const D: usize> Default for Blocks<D> {
    fn default() -> Self {
        Self {
            levels: Vec::new(),
            samples: 0,
            not_finite: None,
        }
    }
}

impl<const D: usize> Blocks<D> {
    pub(crate) fn push(&mut self, sample: [f64; D]) {
        if self.not_finite.is_none() && !sample.iter().all(|x| x.is_finite()) {
            self.not_finite = Some(self.samples);
        }
        self.samples += 1;
        let mut block = sample;
        for level in &mut self.levels {
            level.take(block);
            match level.waiting.take() {
                None => {
                    level.waiting = Some(block);
                    return;
                }
                Some(first) => block = std::array::from_fn(|k| 0.5 * (first[k] + block[k])),
            }
        }
        self.levels.push(Level::new(block));
    }

    pub(crate) fn samples(&self) -> u64 {
        self.samples
    }

    /// The means of all samples.
    pub(crate) fn means(&self) -> Result<[f64; D], AnalysisError> {
        if let Some(sample) = self.not_finite {
            let what = "a quantity";
            return Err(AnalysisError::NotFinite { what, sample });
        }
        match self.levels.first() {
            Some(level) if level.blocks > 1 => Ok(level.mean),
            _ => Err(AnalysisError::TooFew {
                what: "samples",
                found: self.samples,
                needed: 2,
            }),
        }
    }

    /// The error of the mean of sum_k w_k x_k, as every block length shows it.
    pub(crate) fn errors(&self, w: [f64; D]) -> Vec<BlockLevel> {
        let several = self
            .levels
            .iter()
            .enumerate()
            .filter(|(_, level)| level.blocks > 1);
        several
            .map(|(k, level)| {
                let freedom = (level.blocks - 1) as f64;
                let error = (level.moment(w) / (level.blocks as f64 * freedom)).sqrt();
                BlockLevel {
                    length: 1 << k,
                    blocks: level.blocks,
                    error,
                    uncertainty: error / (2.0 * freedom).sqrt(),
                }
            })
            .collect()
    }
}

impl<const D: usize> Level<D> {
    fn new(first: [f64; D]) -> Self {
        Self {
            blocks: 1,
            mean: first,
            moments: [[0.0; D]; D],
            waiting: Some(first),
        }
    }

    /// One more block (Welford 1962).
    fn take(&mut self, block: [f64; D]) {
        self.blocks += 1;
        let weight = 1.0 / self.blocks as f64;
        let before: [f64; D] = std::array::from_fn(|k| block[k] - self.mean[k]);
        for (mean, deviation) in self.mean.iter_mut().zip(before) {
            *mean += weight * deviation;
        }
        for (row, deviation) in self.moments.iter_mut().zip(before) {
            for (k, moment) in row.iter_mut().enumerate() {
                *moment += deviation * (block[k] - self.mean[k]);
            }
        }
    }

    /// Sum of squared deviations of sum_k w_k x_k.
    fn moment(&self, w: [f64; D]) -> f64 {
        let mut sum = 0.0;
        for (row, a) in self.moments.iter().zip(w) {
            for (moment, b) in row.iter().zip(w) {
                sum += a * moment * b;
            }
        }
        sum.max(0.0)
    }
}

/// Fewest blocks that an error is taken from.
const FEWEST: u64 = 16;
/// Fewest blocks that may speak against a plateau.
const FEWEST_HEARD: u64 = 8;
/// Standard deviations by which the error may grow towards longer blocks.
const GROWTH: f64 = 1.5;
/// Standard deviations by which it may have grown since blocks of a quarter of the length.
const RISE: f64 = 2.0;

/// The error of the mean from its errors at all block lengths from one sample on, and the length chosen;
/// [`crate::BlockAverage`] says how.
pub(crate) fn plateau(levels: &[BlockLevel]) -> (StandardError, Option<BlockLevel>) {
    let Some(single) = levels.first() else {
        return (StandardError::AtLeast(0.0), None);
    };
    settled(levels, single.blocks as f64, |level| {
        times_independent(level.error, single.error)
    })
}

/// By how much the squared error exceeds that of independent samples.
pub(crate) fn times_independent(error: f64, independent: f64) -> f64 {
    if independent > 0.0 {
        (error / independent) * (error / independent)
    } else {
        1.0
    }
}

/// The error of the mean of this many samples from the errors that blocks of several lengths show, each twice as long
/// as the one before; `correlated` is the number of samples for an independent one, as a length shows it.
pub(crate) fn settled(
    levels: &[BlockLevel],
    samples: f64,
    correlated: impl Fn(&BlockLevel) -> f64,
) -> (StandardError, Option<BlockLevel>) {
    let heard = levels
        .iter()
        .take_while(|level| level.blocks >= FEWEST_HEARD)
        .count();
    let long = |k: usize| is_long(&levels[k], samples, correlated(&levels[k]));
    let ahead = |k: usize| {
        levels[k + 1..heard]
            .iter()
            .all(|longer| grows(&levels[k], longer) <= GROWTH)
    };
    let behind = |k: usize| k < 2 || grows(&levels[k - 2], &levels[k]) <= RISE;
    let chosen = (0..heard)
        .take_while(|&k| levels[k].blocks >= FEWEST)
        .find(|&k| long(k) && ahead(k) && behind(k))
        .map(|k| levels[k]);
    let error = match chosen {
        Some(BlockLevel {
            error, uncertainty, ..
        }) => StandardError::Plateau { error, uncertainty },
        None => {
            let counted = levels.iter().take(heard.max(1));
            StandardError::AtLeast(counted.fold(0.0, |most, level| level.error.max(most)))
        }
    };
    (error, chosen)
}

/// Whether blocks are so long that their correlation biases the error less than their number scatters it.
fn is_long(level: &BlockLevel, samples: f64, correlated: f64) -> bool {
    let (length, correlated) = (level.length as f64, correlated.max(1.0));
    length * length * length > 2.0 * samples * correlated * correlated
}

/// By how many standard deviations the squared error grows from one length to a longer one. Longer blocks are made of
/// the shorter, so the scatter of the ratio is that of the longer less that of the shorter.
fn grows(level: &BlockLevel, longer: &BlockLevel) -> f64 {
    let (before, after) = (level.error * level.error, longer.error * longer.error);
    let scatter = (2.0 / longer.blocks as f64 - 2.0 / level.blocks as f64).sqrt();
    if before > 0.0 {
        (after / before - 1.0) / scatter
    } else {
        0.0
    }
}
