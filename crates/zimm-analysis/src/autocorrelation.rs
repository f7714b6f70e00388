//! How long things remember.

use crate::ladder::{Ladder, Node, Rule};
use crate::ratio_average::clear_of_zero;
use crate::{AnalysisError, Mean};
use std::marker::PhantomData;
use std::ops::RangeInclusive;
use zimm_core::{DVec3, Estimator, ParameterError};

/// What can be compared with itself at a later time: numbers, and how many things they belong to.
///
/// The product of two signals is the sum of the products of their components over the number of things: numbers and
/// arrays of numbers are one thing with so many components, lists hold one thing an entry.
pub trait Signal {
    /// Appends the components.
    fn components(&self, out: &mut Vec<f64>);

    /// Number of things that a product is averaged over.
    fn things(&self) -> usize {
        1
    }
}

impl Signal for f64 {
    fn components(&self, out: &mut Vec<f64>) {
        out.push(*self);
    }
}

impl Signal for DVec3 {
    fn components(&self, out: &mut Vec<f64>) {
        out.extend(self.to_array());
    }
}

impl<const D: usize> Signal for [f64; D] {
    fn components(&self, out: &mut Vec<f64>) {
        out.extend(self);
    }
}

impl<S: Signal> Signal for Vec<S> {
    fn components(&self, out: &mut Vec<f64>) {
        self.iter().for_each(|signal| signal.components(out));
    }

    fn things(&self) -> usize {
        self.iter().map(S::things).sum()
    }
}

/// The autocorrelation of a signal, `C(t) = <x(t) . x(0)>`, its integral, and the time in which it decays, over lags
/// from one sample to a quarter of the run, however long that is, in memory that grows as its logarithm.
///
/// A sample is a [`Signal`], at equal intervals of time: a stress, the velocities of all particles
/// ([`Velocities`](crate::Velocities)), the amplitudes of a mode ([`RouseModes`](crate::RouseModes)), end-to-end
/// vectors ([`EndToEnd`](crate::EndToEnd)); from a running scene, or from a file. No mean is taken off: push
/// fluctuations.
///
/// This is the multiple-tau correlator of Ramirez, Sukumaran, Vorselaars and Likhtman (J. Chem. Phys. 133, 154103,
/// 2010), with levels of p = 16 samples that are means of m = 2 of the level before. The first p lags are exact.
/// Beyond, at a lag t kept to a resolution B = t m / p to t / p, what is shown is the correlation averaged over t - B
/// to t + B with weights that form a triangle: `C + C'' B^2 / 12`. That is at most 0.07 % of C(0) for an exponential,
/// but 5 % for an oscillation after one period that takes 16 samples or more; larger p make it smaller by (16 / p)^2
/// ([`with_levels`](Self::with_levels)). **Integrals have no such bias**: they are those of all samples.
///
/// Errors come from the scatter of 64 to 128 stretches of the run, or 2 or 4 of them together, once they are so long
/// that they are independent; until then they are lower bounds. It takes runs of some hundred times the time that is
/// to be seen.
///
/// ```
/// use zimm_analysis::Autocorrelation;
/// use zimm_core::{DVec3, Estimator};
///
/// // A vector that turns by an angle of cosine 1/e in two samples.
/// let angle = 0.5 * (-1.0_f64).exp().acos();
/// let mut correlation = Autocorrelation::new(0.1)?;
/// for k in 0..12 {
///     let (sin, cos) = (angle * f64::from(k)).sin_cos();
///     correlation.push(DVec3::new(cos, sin, 0.0));
/// }
/// assert!((correlation.relaxation_time(0.0..=0.2)?.value - 0.2).abs() < 1e-14);
/// let decay = correlation.estimate()?;
/// assert_eq!(decay.times, [0.0, 0.1, 0.2, 0.30000000000000004]);
/// assert!((decay.correlation[1].value - angle.cos()).abs() < 1e-14);
/// assert!((decay.integral[1].value - 0.05 * (1.0 + angle.cos())).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Autocorrelation<S> {
    interval: f64,
    ladder: Ladder<Product, 1>,
    components: Vec<f64>,
    expected: Option<[usize; 2]>,
    misfit: Option<AnalysisError>,
    signal: PhantomData<S>,
}

/// A correlation function. The lists have one entry a lag, from zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Decay {
    /// The lag times.
    pub times: Vec<f64>,
    /// The correlation at each lag, in the square of the signal's unit; at zero it is the mean square.
    pub correlation: Vec<Mean>,
    /// The integral of the correlation from zero up to each lag.
    pub integral: Vec<Mean>,
}

#[derive(Clone, Debug)]
struct Product;

impl Rule<1> for Product {
    const AVERAGES: bool = true;

    /// In four sums, which a processor can work on at once.
    fn compare(now: &[f64], then: &[f64]) -> [f64; 1] {
        let (now, last) = now.as_chunks::<4>();
        let (then, before) = then.as_chunks::<4>();
        let mut sums = [0.0; 4];
        for (a, b) in now.iter().zip(then) {
            for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
                *sum += a * b;
            }
        }
        let rest: f64 = last.iter().zip(before).map(|(a, b)| a * b).sum();
        [(sums[0] + sums[2]) + (sums[1] + sums[3]) + rest]
    }
}

impl<S: Signal> Autocorrelation<S> {
    /// Samples come at this interval of time.
    ///
    /// # Errors
    /// If the interval is not above zero.
    pub fn new(interval: f64) -> Result<Self, ParameterError> {
        Self::with_levels(interval, 16, 2)
    }

    /// With levels of `p` samples, each the mean of `m` of the level before. A sample costs p m / (m - 1) products,
    /// and a level the memory of p samples.
    ///
    /// # Errors
    /// If the interval is not above zero, m is below 2, or p is not a multiple of m and at least twice as large.
    pub fn with_levels(interval: f64, p: usize, m: usize) -> Result<Self, ParameterError> {
        if m < 2 {
            return Err(ParameterError::new("m", m as f64, "2 or more"));
        }
        if p < 2 * m || !p.is_multiple_of(m) {
            let allowed = "a multiple of m, twice as large or more";
            return Err(ParameterError::new("p", p as f64, allowed));
        }
        Ok(Self {
            interval: ParameterError::positive("interval", interval)?,
            ladder: Ladder::new(p, m),
            components: Vec::new(),
            expected: None,
            misfit: None,
            signal: PhantomData,
        })
    }

    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.ladder.samples()
    }

    /// The integral of the correlation from zero to the first lag at or beyond a time, by the trapezoidal rule between
    /// all samples (beyond the first p lags, averaged over the resolution at its end). For a correlation that has
    /// decayed by then it is the integral to infinity.
    ///
    /// Later times add noise alone: the squared error grows with the time. Where the error is a quarter of the value,
    /// values that come out low have errors that do too, and one error covers the truth in 62 % of all runs, 1.96 errors
    /// in 90 % (Ornstein-Uhlenbeck process); where it is a seventh these are 65 and 95 %.
    ///
    /// # Errors
    /// If the run is shorter than four times that time, or samples are not finite or of changing length.
    pub fn integral(&self, until: f64) -> Result<Mean, AnalysisError> {
        let means = self.linear(until, |nodes| vec![self.weights(nodes)])?;
        means.first().copied().ok_or(self.nothing())
    }

    /// The Fourier transform of the correlation, `[integral of C(t) cos(w t), integral of C(t) sin(w t)]` from zero to
    /// the first lag at or beyond a time, for each of these angular frequencies w.
    ///
    /// The correlation is taken as linear between the first p lags and within the resolution of each later one, and
    /// what is so taken is transformed exactly. For samples much closer than the decay, exp(-t / tau) comes out right
    /// to 0.01 % at w tau = 1 and 0.7 % at 10; at zero frequency it is the [`integral`](Self::integral).
    ///
    /// # Errors
    /// As [`integral`](Self::integral).
    pub fn transform(
        &self,
        frequencies: &[f64],
        until: f64,
    ) -> Result<Vec<[Mean; 2]>, AnalysisError> {
        let both = |nodes: &[Node], w: f64| {
            let rows = transforms(nodes, w * self.interval).into_iter();
            rows.map(|row| row.iter().map(|x| x * self.interval).collect())
        };
        let means = self.linear(until, |nodes| {
            let rows = frequencies.iter().flat_map(|&w| both(nodes, w));
            rows.collect()
        })?;
        Ok(means.as_chunks::<2>().0.to_vec())
    }

    /// The time in which the correlation decays between the first lag t_1 at or beyond the start of the fit and the
    /// first, t_2, at or beyond its end,
    ///
    /// ```text
    /// tau = (t_2 - t_1) / ln(C(t_1) / C(t_2))
    /// ```
    ///
    /// with the error that the fluctuations of both have in common. For a decay by a single exponential from zero on,
    /// t_1 = 0 and t_2 about tau is best; a later t_1 leaves faster decays out.
    ///
    /// # Errors
    /// As [`integral`](Self::integral), and if t_1 is not below t_2, or C(t_2), or the decay from t_1 to t_2, is
    /// closer to zero than four errors.
    pub fn relaxation_time(&self, fit: RangeInclusive<f64>) -> Result<Mean, AnalysisError> {
        self.check()?;
        let [first, last] =
            [fit.start(), fit.end()].map(|time| self.ladder.lag_from(time / self.interval));
        let (first, last) = (first?, last?);
        if first >= last {
            let allowed = "a time that starts one lag or more before it ends";
            return Err(ParameterError::new("fit", *fit.start(), allowed).into());
        }
        let duration = self.time(last) - self.time(first);
        let of = |c: &[[f64; 1]]| {
            let ([from], [to]) = (c[first], c[last]);
            vec![to, from - to, duration / (from / to).ln()]
        };
        let found = self.ladder.estimate(last + 1, of, |_| last + 1);
        let [to, decay, time] = found[..] else {
            return Err(self.nothing());
        };
        clear_of_zero(to)?;
        clear_of_zero(decay)?;
        if time.value.is_finite() && time.value > 0.0 {
            Ok(time)
        } else {
            Err(AnalysisError::Denominator {
                mean: decay.value,
                error: decay.at_least(),
            })
        }
    }

    fn time(&self, lag: usize) -> f64 {
        self.interval * self.ladder.position(lag) as f64
    }

    /// What each mean counts in the integral up to the last node.
    fn weights(&self, nodes: &[Node]) -> Vec<f64> {
        let ends = [0, nodes.len().saturating_sub(1)];
        let weight = |(k, node): (usize, &Node)| {
            let half = ends.iter().filter(|&&end| end == k).count();
            node.weight * node.width * self.interval * (1.0 - 0.5 * half as f64)
        };
        nodes.iter().enumerate().map(weight).collect()
    }

    /// Sums of the means with weights that `rows` gives for the lags up to a time.
    fn linear(
        &self,
        until: f64,
        rows: impl FnOnce(&[Node]) -> Vec<Vec<f64>>,
    ) -> Result<Vec<Mean>, AnalysisError> {
        self.check()?;
        let last = self.ladder.lag_from(until / self.interval)?;
        let rows = rows(&self.ladder.nodes(last));
        let of = |c: &[[f64; 1]]| rows.iter().map(|row| sum(row, c)).collect();
        let means = self.ladder.estimate(last + 1, of, |_| last + 1);
        Ok(means.into_iter().map(|mean| self.each(mean)).collect())
    }

    /// Of one of the things that the signal is made of.
    fn each(&self, mean: Mean) -> Mean {
        let [_, things] = self.expected.unwrap_or([1, 1]);
        mean.times(1.0 / things as f64)
    }

    fn check(&self) -> Result<(), AnalysisError> {
        self.misfit.clone().map_or(Ok(()), Err)
    }

    fn nothing(&self) -> AnalysisError {
        AnalysisError::TooFew {
            what: "samples",
            found: self.samples(),
            needed: 2,
        }
    }
}

fn sum(weights: &[f64], means: &[[f64; 1]]) -> f64 {
    weights.iter().zip(means).map(|(w, [c])| w * c).sum()
}

/// What each mean counts in the cosine and the sine transform at an angle w a sample, up to the last node.
fn transforms(nodes: &[Node], w: f64) -> [Vec<f64>; 2] {
    let mut rows = [vec![0.0; nodes.len()], vec![0.0; nodes.len()]];
    let mut add = |k: usize, [cosine, sine]: [f64; 2]| {
        for (row, part) in rows.iter_mut().zip([cosine, sine]) {
            row[k] += part;
        }
    };
    let last = nodes.len().saturating_sub(1);
    for (k, node) in nodes.iter().enumerate() {
        let theta = w * node.width;
        let (sin, cos) = (w * node.position).sin_cos();
        let reach = node.width * node.weight;
        let (even, odd) = falling(theta);
        let (after, before) = (f64::from(k < last), f64::from(k > 0));
        let (even, odd) = (even * (after + before), odd * (after - before));
        add(
            k,
            [
                reach * (cos * even - sin * odd),
                reach * (sin * even + cos * odd),
            ],
        );
        let beside = |k: usize| nodes.get(k).is_some_and(|other| other.width == node.width);
        let lower = k - usize::from(k > 0 && beside(k - 1));
        let upper = k + usize::from(beside(k + 1));
        if node.width > 1.0 && upper > lower && k < last {
            let slope = 2.0 * reach * humped(theta) / (upper - lower) as f64;
            add(upper, [-slope * sin, slope * cos]);
            add(lower, [slope * sin, -slope * cos]);
        }
    }
    rows
}

/// The integrals of (1 - x) cos(theta x) and (1 - x) sin(theta x) from 0 to 1.
fn falling(theta: f64) -> (f64, f64) {
    let half = 0.5 * theta;
    let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
    let square = theta * theta;
    let odd = if theta.abs() < 0.1 {
        theta / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)))
    } else {
        (theta - theta.sin()) / square
    };
    (0.5 * sinc * sinc, odd)
}

/// The integral of (1 - x) x sin(theta x) from 0 to 1.
fn humped(theta: f64) -> f64 {
    let square = theta * theta;
    if theta.abs() < 0.3 {
        theta / 12.0 * (1.0 - square / 15.0 * (1.0 - square * 3.0 / 112.0))
    } else {
        (2.0 * (1.0 - theta.cos()) - theta * theta.sin()) / (square * theta)
    }
}

impl<S: Signal> Estimator for Autocorrelation<S> {
    type Sample = S;
    type Estimate = Result<Decay, AnalysisError>;

    fn push(&mut self, signal: S) {
        self.components.clear();
        signal.components(&mut self.components);
        let found = [self.components.len(), signal.things()];
        let expected = *self.expected.get_or_insert(found);
        if found != expected || found.contains(&0) {
            self.misfit.get_or_insert(AnalysisError::Length {
                sample: self.ladder.samples(),
                found: found[1],
                expected: expected[1].max(1),
            });
            return;
        }
        self.ladder.push(&self.components);
    }

    fn estimate(&self) -> Self::Estimate {
        self.check()?;
        let lags = self.ladder.lags()?;
        let rows: Vec<Vec<f64>> = (0..lags)
            .map(|last| self.weights(&self.ladder.nodes(last)))
            .collect();
        let of = |c: &[[f64; 1]]| {
            let integrals = rows.iter().map(|row| sum(row, c));
            c.iter().map(|[c]| *c).chain(integrals).collect()
        };
        let found = self.ladder.estimate(lags, of, |i| i % lags + 1);
        let mut found = found.into_iter().map(|mean| self.each(mean));
        Ok(Decay {
            times: (0..lags).map(|lag| self.time(lag)).collect(),
            correlation: found.by_ref().take(lags).collect(),
            integral: found.collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;

    // 400 short runs of one Ornstein-Uhlenbeck vector of unit variance, phi = 0.9, 4096 samples each: about 430
    // correlation times of the squares a run. The time from lags 0 and 8 against -1 / ln 0.9 = 9.491. Seeds 0..400.
    // The square of the pull, (found - exact) / error, has mean 1 if the error is honest, and the errors' own
    // uncertainty of 10 to 20 % adds 3 to 12 %; 340 of them know it to 8 %. Bounds 0.75 and 1.4, 4 sigma: an error
    // wrong by 17 % is caught. The bias of second order is below 1 % of the time: bound 2 %, with 0.4 % from the
    // scatter.
    #[test]
    fn limit_relaxation_times_have_honest_errors() {
        let (phi, mut squares, mut sum, mut known) = (0.9_f64, 0.0, 0.0, 0.0);
        let exact = -1.0 / phi.ln();
        for seed in 0..400 {
            let mut random = Random::new(seed);
            let mut correlation = Autocorrelation::new(1.0).unwrap();
            let mut x = random.normal3();
            for _ in 0..4096 {
                correlation.push(vec![x]);
                x = phi * x + (1.0 - phi * phi).sqrt() * random.normal3();
            }
            let found = correlation.relaxation_time(0.0..=8.0).unwrap();
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
        let mut correlation = Autocorrelation::new(0.5).unwrap();
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

    // A vector that turns by theta a sample: C = cos(k theta) at lag k, times the square of the length of the mean of
    // B unit vectors, sin(B theta / 2) / (B sin(theta / 2)), where it is made of means of B samples.
    #[test]
    fn limit_means_shorten_what_turns_as_they_should() {
        for (p, m, theta) in [(16, 2, 0.01_f64), (8, 4, 0.05), (30, 3, 2.0)] {
            let mut correlation = Autocorrelation::with_levels(1.0, p, m).unwrap();
            for k in 0..20_000 {
                let (sin, cos) = (theta * f64::from(k)).sin_cos();
                correlation.push([3.0 * cos, 3.0 * sin]);
            }
            let found = correlation.estimate().unwrap();
            assert!(found.times.len() > 3 * p && found.times.last() > Some(&2500.0));
            for (k, (lag, mean)) in found.times.iter().zip(&found.correlation).enumerate() {
                let level = if k < p { 0 } else { 1 + (k - p) / (p - p / m) };
                let width = (m as f64).powi(level as i32);
                let shorter = (0.5 * width * theta).sin() / (width * (0.5 * theta).sin());
                let exact = 9.0 * (lag * theta).cos() * shorter * shorter;
                assert!(
                    (mean.value - exact).abs() < 1e-9,
                    "{mean} at {lag}: {exact}"
                );
            }
        }
    }

    // exp(-t) and exp(-t) cos(3 t), sampled every 0.01 without noise, averaged as the levels do it. The largest bias
    // of the exponential, relative to C(0), is that of the docs. Transforms up to t = 40 against 1 / (1 + i w)
    // (Maxwell's fluid: G' = w^2 / (1 + w^2), G'' = w / (1 + w^2)) and its like with 1 + 3 i. The trapezoidal rule is
    // off by interval^2 / 12 = 8.3e-6 at zero frequency, by no more than that for all the means. At w = 1 and 10 what
    // the levels blur is the error: it must be below 0.01 % and 0.7 % of Maxwell's moduli, and below 0.1 % and 2 % of
    // |C| where C turns by 3 in its time.
    #[test]
    fn limit_transforms_of_exponentials() {
        let interval = 0.01;
        let ladder = Ladder::<Product, 1>::new(16, 2);
        let last = (0..)
            .find(|&k| ladder.position(k) as f64 * interval >= 40.0)
            .unwrap();
        let nodes = ladder.nodes(last);
        for (turn, bounds) in [(0.0, [9e-6, 5e-5, 7e-4]), (3.0, [9e-6, 1.5e-4, 2.2e-3])] {
            // The mean of exp(-s t) over what two samples of means of B intervals are apart.
            let mean = |node: &Node| {
                let s = [0.5 * interval, 0.5 * interval * turn];
                let sinh = |[a, b]: [f64; 2]| [a.sinh() * b.cos(), a.cosh() * b.sin()];
                let ([a, b], [c, d]) = (sinh(s.map(|x| x * node.width)), sinh(s));
                let under = (c * c + d * d) * node.width;
                let [x, y] = [(a * c + b * d) / under, (b * c - a * d) / under];
                let square = [x * x - y * y, 2.0 * x * y];
                let t = node.position * interval;
                let (sin, cos) = (turn * t).sin_cos();
                (-t).exp() * (square[0] * cos + square[1] * sin)
            };
            let means: Vec<[f64; 1]> = nodes.iter().map(|node| [mean(node)]).collect();
            if turn == 0.0 {
                let bias = |(node, [c]): (&Node, &[f64; 1])| c - (-node.position * interval).exp();
                let most = nodes.iter().zip(&means).map(bias).fold(0.0, f64::max);
                assert!(most > 0.0004 && most < 0.0007, "{most}");
            }
            for (w, bound) in [0.0, 1.0, 10.0].into_iter().zip(bounds) {
                let found =
                    transforms(&nodes, w * interval).map(|row| sum(&row, &means) * interval);
                // Re of 1 / (1 + i (w - turn)) and of its image, halved.
                let each = |w: f64| [1.0, w].map(|x| 0.5 * x / (1.0 + w * w));
                let (plus, minus) = (each(w - turn), each(w + turn));
                for k in [0, 1] {
                    let exact = plus[k] + minus[k];
                    assert!((found[k] - exact).abs() < bound, "{} for {exact}", found[k]);
                }
            }
        }
    }

    // By quadrature with the midpoint rule, to 3e-9.
    #[test]
    fn law_half_a_hat_is_transformed_exactly() {
        for theta in [
            0.0, 1e-8, 1e-3, 0.0999, 0.1001, 0.299, 0.301, 1.0, 7.0, -3.0,
        ] {
            let n = 20_000;
            let (mut even, mut odd, mut hump) = (0.0, 0.0, 0.0);
            for k in 0..n {
                let x = (f64::from(k) + 0.5) / f64::from(n);
                hump += (1.0 - x) * x * (theta * x).sin() / f64::from(n);
                even += (1.0 - x) * (theta * x).cos() / f64::from(n);
                odd += (1.0 - x) * (theta * x).sin() / f64::from(n);
            }
            let found = falling(theta);
            assert!((found.0 - even).abs() < 3e-9, "{theta}: {} {even}", found.0);
            assert!((found.1 - odd).abs() < 3e-9, "{theta}: {} {odd}", found.1);
            assert!((humped(theta) - hump).abs() < 3e-9, "{theta}: {hump}");
        }
    }

    #[test]
    fn extreme_what_does_not_decay_has_no_time() {
        assert!(Autocorrelation::<f64>::new(0.0).is_err());
        for (p, m) in [(16, 1), (15, 2), (2, 2), (0, 2)] {
            assert!(Autocorrelation::<f64>::with_levels(1.0, p, m).is_err());
        }
        let fresh = Autocorrelation::new(1.0).unwrap();
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
            let found = correlation.relaxation_time(0.0..=2.0);
            assert!(
                matches!(found, Err(AnalysisError::Denominator { .. })),
                "{found:?}"
            );
        }
        let mut noise = fresh.clone();
        let mut random = Random::new(93);
        for found in 0..8 {
            let (what, needed) = ("samples", if found < 2 { 2 } else { 8 });
            let expected = AnalysisError::TooFew {
                what,
                found,
                needed,
            };
            assert_eq!(noise.integral(2.0), Err(expected));
            noise.push(vec![random.normal3()]);
        }
        assert!(noise.integral(2.0).is_ok());
        assert!(noise.integral(f64::NAN).is_err());
        assert!(matches!(
            noise.relaxation_time(2.0..=2.0),
            Err(AnalysisError::Parameter(_))
        ));
        (0..1000).for_each(|_| noise.push(vec![random.normal3()]));
        assert!(matches!(
            noise.relaxation_time(0.0..=2.0),
            Err(AnalysisError::Denominator { .. })
        ));
        noise.push(vec![DVec3::NAN]);
        assert!(matches!(
            noise.relaxation_time(0.0..=2.0),
            Err(AnalysisError::NotFinite { sample: 1008, .. })
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
