//! Samples compared with those before them, over lags that grow with the run, in memory that hardly does.

use crate::blocks::{settled, times_independent};
use crate::segments::{Join, Segments, grouped};
use crate::{AnalysisError, BlockLevel, Mean};
use std::marker::PhantomData;

/// How two samples are compared, and what stands for several in a coarser level.
pub(crate) trait Rule<const D: usize> {
    /// The mean of several samples stands for them; if not, the last of them does.
    const AVERAGES: bool;

    fn compare(now: &[f64], then: &[f64]) -> [f64; D];
}

/// Levels of `p` samples each. The first holds the last `p` samples as they came; each sample of the next stands for
/// `m` of the one before (Ramirez, Sukumaran, Vorselaars and Likhtman, J. Chem. Phys. 133, 154103, 2010). Every new
/// sample of a level is compared with those before it in its level: lags 0 to p - 1 in the first, p/m to p - 1 times
/// m^l in level l, so that lags follow one another without gaps.
///
/// What comparisons show is summed over the whole run and over stretches of it. The scatter of stretches is the error
/// of anything that is made of the means.
#[derive(Clone, Debug)]
pub(crate) struct Ladder<R, const D: usize> {
    p: usize,
    m: usize,
    levels: Vec<Level>,
    whole: Vec<Spread<D>>,
    stretches: Segments<Sums<D>>,
    samples: u64,
    not_finite: Option<u64>,
    rule: PhantomData<R>,
}

/// The last samples of one level.
#[derive(Clone, Debug)]
struct Level {
    /// Up to p samples one after another; the newest replaces the oldest.
    kept: Vec<f64>,
    newest: usize,
    count: usize,
    collected: Vec<f64>,
    collecting: usize,
}

/// Mean and sum of squared deviations of the comparisons at one lag.
#[derive(Clone, Debug)]
struct Spread<const D: usize> {
    count: u64,
    mean: [f64; D],
    square: [f64; D],
}

/// Sums of comparisons over a stretch, one entry a lag.
#[derive(Clone, Debug, Default)]
struct Sums<const D: usize> {
    lags: Vec<(u64, Values<D>)>,
}

#[derive(Clone, Copy, Debug)]
struct Values<const D: usize>([f64; D]);

impl<const D: usize> Default for Values<D> {
    fn default() -> Self {
        Self([0.0; D])
    }
}

impl<const D: usize> Join for Sums<D> {
    fn join(&mut self, later: &Self) {
        if self.lags.len() < later.lags.len() {
            self.lags.resize(later.lags.len(), Default::default());
        }
        for (mine, theirs) in self.lags.iter_mut().zip(&later.lags) {
            mine.0 += theirs.0;
            for (a, b) in mine.1.0.iter_mut().zip(theirs.1.0) {
                *a += b;
            }
        }
    }
}

/// A lag that counts in an integral: where it is and how far it reaches to both sides, in samples, and its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) position: f64,
    pub(crate) width: f64,
    pub(crate) weight: f64,
}

/// Most stretches that are kept apart.
const STRETCHES: usize = 128;
/// A run shows lags up to this part of its length.
const PARTS: u64 = 4;

impl<R: Rule<D>, const D: usize> Ladder<R, D> {
    /// `m` of at least 2, and `p` a multiple of it, at least twice as large.
    pub(crate) fn new(p: usize, m: usize) -> Self {
        Self {
            p,
            m,
            levels: Vec::new(),
            whole: Vec::new(),
            stretches: Segments::new(STRETCHES),
            samples: 0,
            not_finite: None,
            rule: PhantomData,
        }
    }

    /// Takes a sample, of the same length as all before it.
    pub(crate) fn push(&mut self, sample: &[f64]) {
        if self.not_finite.is_none() && !sample.iter().all(|x| x.is_finite()) {
            self.not_finite = Some(self.samples);
        }
        self.samples += 1;
        let (p, m) = (self.p, self.m);
        let (levels, whole) = (&mut self.levels, &mut self.whole);
        self.stretches.add(|open| {
            let mut first = 0;
            let mut coarse: Option<Vec<f64>> = None;
            for l in 0.. {
                if l == levels.len() {
                    levels.push(Level::new(p, sample.len()));
                }
                let Some(level) = levels.get_mut(l) else {
                    break;
                };
                level.keep(coarse.as_deref().unwrap_or(sample), p);
                let skipped = if l == 0 { 0 } else { p / m };
                let now = level.at(0, p);
                for back in skipped..level.count {
                    let found = R::compare(now, level.at(back, p));
                    let lag = first + back - skipped;
                    if lag >= whole.len() {
                        whole.resize(lag + 1, Spread::default());
                    }
                    if lag >= open.lags.len() {
                        open.lags.resize(lag + 1, Default::default());
                    }
                    whole[lag].take(found);
                    let (count, sums) = &mut open.lags[lag];
                    *count += 1;
                    for (sum, x) in sums.0.iter_mut().zip(found) {
                        *sum += x;
                    }
                }
                first += p - skipped;
                match level.collect::<R, D>(m, p) {
                    Some(next) => coarse = Some(next),
                    None => break,
                }
            }
        });
    }

    pub(crate) fn samples(&self) -> u64 {
        self.samples
    }

    /// Level of a lag and its number in that level.
    fn rung(&self, lag: usize) -> (u32, usize) {
        if lag < self.p {
            return (0, lag);
        }
        let each = self.p - self.p / self.m;
        let above = lag - self.p;
        ((1 + above / each) as u32, self.p / self.m + above % each)
    }

    /// Length of a lag in samples.
    pub(crate) fn position(&self, lag: usize) -> u64 {
        let (level, number) = self.rung(lag);
        self.width(level).saturating_mul(number as u64)
    }

    fn width(&self, level: u32) -> u64 {
        (self.m as u64).saturating_pow(level)
    }

    /// Number of lags that the run shows: those of a quarter of its length or less.
    ///
    /// # Errors
    /// If there are fewer than two samples, or one is not finite.
    pub(crate) fn lags(&self) -> Result<usize, AnalysisError> {
        if let Some(sample) = self.not_finite {
            let what = "a quantity";
            return Err(AnalysisError::NotFinite { what, sample });
        }
        if self.samples < 2 {
            return Err(AnalysisError::TooFew {
                what: "samples",
                found: self.samples,
                needed: 2,
            });
        }
        let longest = self.samples / PARTS;
        let shown = (0..self.whole.len()).take_while(|&lag| self.position(lag) <= longest);
        Ok(shown.count())
    }

    /// The first lag of at least this many samples.
    ///
    /// # Errors
    /// If the run does not show it.
    pub(crate) fn lag_from(&self, position: f64) -> Result<usize, AnalysisError> {
        // A length that was divided by its unit is a whole number but for rounding.
        let least = position * (1.0 - 1e-12);
        self.shown(self.first(|found| found as f64 >= least))
    }

    /// The last lag of at most this many samples.
    ///
    /// # Errors
    /// If the run does not show it.
    pub(crate) fn lag_until(&self, position: u64) -> Result<usize, AnalysisError> {
        self.shown(self.first(|found| found > position).saturating_sub(1))
    }

    /// The first lag whose length is of a kind; lengths beyond 2^64 are none.
    fn first(&self, is: impl Fn(u64) -> bool) -> usize {
        let all = 0..self.p * u64::BITS as usize;
        let end = all.end;
        all.into_iter()
            .find(|&lag| is(self.position(lag)))
            .unwrap_or(end)
    }

    /// A lag if the run shows it.
    fn shown(&self, lag: usize) -> Result<usize, AnalysisError> {
        if lag < self.lags()? {
            return Ok(lag);
        }
        Err(AnalysisError::TooFew {
            what: "samples",
            found: self.samples,
            needed: PARTS.saturating_mul(self.position(lag)),
        })
    }

    /// The lags of an integral from zero up to the lag `last` of the function that the means are values of.
    ///
    /// In each level the integrand is linear between its lags. A level hands over to the next on its last m steps,
    /// where its weight falls as that of the next one rises: then a mean over m by m comparisons weighs each as it
    /// should, and the integral is that of all lags, by the trapezoidal rule, averaged over its upper end within one
    /// step of the last level. Nothing is lost by the means.
    pub(crate) fn nodes(&self, last: usize) -> Vec<Node> {
        let (highest, _) = self.rung(last);
        (0..=last)
            .map(|lag| {
                let (level, number) = self.rung(lag);
                let width = self.width(level) as f64;
                let beyond = number.saturating_sub(self.p - self.m) as f64;
                let weight = if level == highest {
                    1.0
                } else {
                    1.0 - beyond / self.m as f64
                };
                Node {
                    position: width * number as f64,
                    width,
                    weight,
                }
            })
            .collect()
    }

    /// What `of` makes of the means at the first `lags` lags, with errors. Entry i of it depends on the first
    /// `uses(i)` of them.
    ///
    /// Errors are those of the jackknife: `of` is evaluated without each of 64 to 128 stretches of the run, and
    /// without each group of 2, 4 and 8. The length of groups is chosen as by [`settled`], by the lag that is
    /// correlated longest.
    pub(crate) fn estimate(
        &self,
        lags: usize,
        of: impl Fn(&[[f64; D]]) -> Vec<f64>,
        uses: impl Fn(usize) -> usize,
    ) -> Vec<Mean> {
        let means: Vec<[f64; D]> = self.whole.iter().take(lags).map(|s| s.mean).collect();
        let values = of(&means);
        let (mut levels, mut correlated) = (Vec::new(), Vec::new());
        for k in 0..4 {
            let groups = grouped(self.stretches.complete(), 1 << k);
            if groups.len() < 2 {
                break;
            }
            let length = self.stretches.length() << k;
            let each = self.jackknife(&groups, length, &means, |means| means.concat());
            correlated.push(self.correlated(&each));
            levels.push((
                length,
                groups.len() as u64,
                self.jackknife(&groups, length, &means, &of),
            ));
        }
        let mean = |(i, value): (usize, f64)| {
            let level = |(length, blocks, errors): &(u64, u64, Vec<f64>)| BlockLevel {
                length: *length,
                blocks: *blocks,
                error: errors[i],
                uncertainty: errors[i] / (2.0 * (*blocks as f64 - 1.0)).sqrt(),
            };
            let shown: Vec<BlockLevel> = levels.iter().map(level).collect();
            let longest = uses(i).clamp(1, lags.max(1)) - 1;
            let (error, _) = settled(&shown, self.samples as f64, |level| {
                let k = level.length.ilog2() - self.stretches.length().ilog2();
                correlated[k as usize][longest]
            });
            Mean { value, error }
        };
        values.into_iter().enumerate().map(mean).collect()
    }

    /// The errors of what `of` makes of the means, from its values without each group of stretches.
    fn jackknife(
        &self,
        groups: &[Sums<D>],
        length: u64,
        means: &[[f64; D]],
        of: impl Fn(&[[f64; D]]) -> Vec<f64>,
    ) -> Vec<f64> {
        let without: Vec<Vec<f64>> = groups
            .iter()
            .map(|group| {
                let mut left = means.to_vec();
                for ((mean, whole), (count, sums)) in
                    left.iter_mut().zip(&self.whole).zip(&group.lags)
                {
                    let rest = whole.count.saturating_sub(*count) as f64;
                    if rest > 0.0 {
                        for (mean, sum) in mean.iter_mut().zip(sums.0) {
                            *mean += (*count as f64 * *mean - sum) / rest;
                        }
                    }
                }
                of(&left)
            })
            .collect();
        let blocks = groups.len() as f64;
        let whole = self.samples as f64 / length as f64;
        let rest = 1.0 - 1.0 / whole;
        (0..without.first().map_or(0, Vec::len))
            .map(|i| {
                let mean = without.iter().map(|f| f[i]).sum::<f64>() / blocks;
                let square: f64 = without.iter().map(|f| (f[i] - mean).powi(2)).sum();
                (square / (blocks - 1.0) * rest * rest * whole).sqrt()
            })
            .collect()
    }

    /// The most samples for an independent one at any lag up to each, from the errors of all means.
    fn correlated(&self, errors: &[f64]) -> Vec<f64> {
        let mut most: f64 = 1.0;
        errors
            .chunks_exact(D)
            .zip(&self.whole)
            .enumerate()
            .map(|(lag, (errors, whole))| {
                let width = self.width(self.rung(lag).0) as f64;
                for (&error, independent) in errors.iter().zip(whole.errors()) {
                    most = most.max(width * times_independent(error, independent));
                }
                most
            })
            .collect()
    }
}

impl Level {
    fn new(p: usize, dimension: usize) -> Self {
        Self {
            kept: vec![0.0; p * dimension],
            newest: p - 1,
            count: 0,
            collected: vec![0.0; dimension],
            collecting: 0,
        }
    }

    fn keep(&mut self, sample: &[f64], p: usize) {
        self.newest = (self.newest + 1) % p;
        self.count = (self.count + 1).min(p);
        let start = self.newest * sample.len();
        self.kept[start..start + sample.len()].copy_from_slice(sample);
    }

    /// The sample this many before the newest.
    fn at(&self, back: usize, p: usize) -> &[f64] {
        let dimension = self.collected.len();
        let place = (self.newest + p - back) % p;
        &self.kept[place * dimension..(place + 1) * dimension]
    }

    /// Takes the newest sample on towards one of the next level, and gives that when it is complete.
    fn collect<R: Rule<D>, const D: usize>(&mut self, m: usize, p: usize) -> Option<Vec<f64>> {
        self.collecting += 1;
        let complete = self.collecting == m;
        if R::AVERAGES {
            let start = self.newest * self.collected.len();
            for (sum, x) in self.collected.iter_mut().zip(&self.kept[start..]) {
                *sum += x;
            }
        }
        if !complete {
            return None;
        }
        self.collecting = 0;
        if !R::AVERAGES {
            return Some(self.at(0, p).to_vec());
        }
        let mean = self.collected.iter().map(|sum| sum / m as f64).collect();
        self.collected.fill(0.0);
        Some(mean)
    }
}

impl<const D: usize> Default for Spread<D> {
    fn default() -> Self {
        Self {
            count: 0,
            mean: [0.0; D],
            square: [0.0; D],
        }
    }
}

impl<const D: usize> Spread<D> {
    /// One more comparison (Welford 1962).
    fn take(&mut self, found: [f64; D]) {
        self.count += 1;
        let weight = 1.0 / self.count as f64;
        for ((mean, square), x) in self.mean.iter_mut().zip(&mut self.square).zip(found) {
            let before = x - *mean;
            *mean += weight * before;
            *square += before * (x - *mean);
        }
    }

    /// The errors of the means if comparisons were independent.
    fn errors(&self) -> [f64; D] {
        let freedom = self.count.max(2) as f64 - 1.0;
        self.square
            .map(|square| (square / freedom / self.count.max(1) as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;
    use zimm_core::Estimator;

    #[derive(Clone, Debug)]
    struct Pairs<const AVERAGES: bool>;

    impl<const AVERAGES: bool> Rule<2> for Pairs<AVERAGES> {
        const AVERAGES: bool = AVERAGES;

        fn compare(now: &[f64], then: &[f64]) -> [f64; 2] {
            [now[0] * then[0], now[1] - 2.0 * then[1]]
        }
    }

    /// Every mean from its definition: level by level, all pairs of samples of one level at a distance.
    fn brute_force<R: Rule<2>>(series: &[[f64; 2]], p: usize, m: usize) -> Vec<[f64; 2]> {
        let (mut level, mut first, mut means) = (series.to_vec(), 0, Vec::new());
        while !level.is_empty() {
            for distance in (first..p).take_while(|&distance| distance < level.len()) {
                let pairs = level.iter().skip(distance).zip(&level);
                let found: Vec<_> = pairs.map(|(now, then)| R::compare(now, then)).collect();
                let sum = |k: usize| found.iter().map(|x| x[k]).sum::<f64>();
                means.push([0, 1].map(|k| sum(k) / found.len() as f64));
            }
            let chunks = level.chunks_exact(m);
            level = chunks
                .map(|chunk| {
                    let mean = |k: usize| chunk.iter().map(|x| x[k]).sum::<f64>() / m as f64;
                    if R::AVERAGES {
                        [mean(0), mean(1)]
                    } else {
                        chunk[m - 1]
                    }
                })
                .collect();
            first = p / m;
        }
        means
    }

    fn as_by_brute_force<R: Rule<2>>(p: usize, m: usize) {
        let mut random = Random::new(98);
        let series: Vec<[f64; 2]> = (0..777)
            .map(|_| [random.normal(), random.normal()])
            .collect();
        let mut ladder = Ladder::<R, 2>::new(p, m);
        series.iter().for_each(|sample| ladder.push(sample));
        let (lags, expected) = (ladder.lags().unwrap(), brute_force::<R>(&series, p, m));
        assert!(ladder.position(lags - 1) <= 194 && ladder.position(lags) > 194);
        let found = ladder.estimate(lags, |means| means.concat(), |_| lags);
        for (found, expected) in found.iter().zip(expected.iter().flatten()) {
            assert!((found.value - expected).abs() < 1e-13);
        }
    }

    #[test]
    fn law_means_are_those_of_all_pairs() {
        for (p, m) in [(4, 2), (16, 2), (9, 3), (12, 4)] {
            as_by_brute_force::<Pairs<true>>(p, m);
            as_by_brute_force::<Pairs<false>>(p, m);
        }
    }

    // The error without each stretch is that of independent stretches of the mean, if what is asked for is a mean: lag
    // zero of 1024 samples, 64 stretches of 16, 32 of 32, ... Their errors are the levels of a block average from 16
    // on.
    #[test]
    fn law_errors_of_a_mean_are_those_of_its_blocks() {
        let (mut random, mut blocks) = (Random::new(99), crate::BlockAverage::new());
        let mut ladder = Ladder::<Pairs<true>, 2>::new(16, 2);
        for _ in 0..1024 {
            let sample = [random.normal(), random.normal()];
            blocks.push(sample[0] * sample[0]);
            ladder.push(&sample);
        }
        let (stretches, means) = (&ladder.stretches, [ladder.whole[0].mean]);
        for k in 0..4 {
            let groups = grouped(stretches.complete(), 1 << k);
            let length = stretches.length() << k;
            let errors = ladder.jackknife(&groups, length, &means, |means| means.concat());
            let level = blocks.levels()[k + 4];
            assert_eq!((level.length, level.blocks), (length, groups.len() as u64));
            approx::assert_relative_eq!(errors[0], level.error, max_relative = 1e-12);
        }
    }

    // Any function of the lag, averaged as the levels do it, and integrated up to any lag, against the trapezoidal sum
    // over single samples, averaged over one step of the last level to both sides.
    #[test]
    fn law_integrals_lose_nothing_by_the_means() {
        for (p, m) in [(4, 2), (16, 2), (9, 3), (12, 4)] {
            let ladder = Ladder::<Pairs<true>, 2>::new(p, m);
            let mut random = Random::new(100);
            let raw: Vec<f64> = (0..5000).map(|_| random.normal()).collect();
            let (mut level, mut means) = (raw.clone(), raw[..p].to_vec());
            while level.len() > p * m {
                let mean = |k: usize| {
                    let each = |j: usize| {
                        let share = (m - j.abs_diff(m)) as f64 / (m * m) as f64;
                        share * level[(k * m + j).abs_diff(m)]
                    };
                    (1..2 * m).map(each).sum()
                };
                level = (0..level.len() / m - 1).map(mean).collect();
                means.extend(level.iter().take(p).skip(p / m));
            }
            for last in 1..means.len().min(60) {
                let nodes = ladder.nodes(last);
                let end = *nodes.last().unwrap();
                let part = |(k, node): (usize, &Node)| {
                    let half = if k == 0 || k == last { 0.5 } else { 1.0 };
                    half * node.weight * node.width * means[k]
                };
                let found: f64 = nodes.iter().enumerate().map(part).sum();
                let share = |(k, c): (usize, &f64)| {
                    let within = 0.5 + 0.5 * (end.position - k as f64) / end.width;
                    within.clamp(0.0, 1.0) * c
                };
                let exact: f64 = raw.iter().enumerate().map(share).sum::<f64>() - 0.5 * raw[0];
                assert!(
                    (found - exact).abs() < 1e-11,
                    "{p} {m} {last}: {found} {exact}"
                );
            }
        }
    }
}
