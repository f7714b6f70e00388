//! The square root from a series in Chebyshev polynomials.

use crate::columns::{add_scaled, dot, norm};
use crate::{Lanczos, Mobility, Root, White, lanczos::not_finite, stage::zero};
use zimm_core::{Boundary, DVec3, MobilityError, ParameterError, for_each_chunk};

/// The symmetric square root of any mobility, M^(1/2) z, as a series in Chebyshev polynomials of M (Fixman 1986,
/// Macromolecules 19, 1204).
///
/// The series converges between two bounds, outside of which it is of no use, so the bounds are measured: by
/// [`Lanczos`]' method, which takes the first root, every hundredth thereafter, and every one for which the
/// bounds turn out to be wrong. Within bounds no column of the series is longer than z, and is about 0.7 times as long;
/// one that is longer gives an eigenvalue outside away. The order follows from the bounds and the error that is asked
/// for.
///
/// Four columns of memory and four scalar products, whatever the order; but more products with the mobility than by
/// Lanczos' method, a quarter more at a condition number of 20, half as many again at 1000, and ever more where a few
/// eigenvalues are far from the others. Where it would be more than four times as many, Lanczos' method takes the root.
///
/// Bounds are kept from root to root. A run that starts again from a checkpoint measures them anew, so it agrees with
/// one that went on to the error that is asked for, not in all bits.
#[derive(Clone, Debug)]
pub struct Chebyshev {
    lanczos: Lanczos,
    series: Option<Series>,
    roots: usize,
    products: usize,
    columns: [Vec<DVec3>; 3],
    sum: Vec<DVec3>,
}

impl Chebyshev {
    /// The root to a relative error |x - M^(1/2) z| / |M^(1/2) z| of `tolerance`.
    ///
    /// # Errors
    /// If `tolerance` is not between 1e-12, what double precision can give, and 1.
    pub fn new(tolerance: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            lanczos: Lanczos::new(tolerance)?,
            series: None,
            roots: 0,
            products: 0,
            columns: Default::default(),
            sum: Vec::new(),
        })
    }

    /// Products with the mobility that the last root took.
    pub fn products(&self) -> usize {
        self.products
    }

    /// The root by Lanczos' method, and bounds from it.
    fn measure<B: Boundary, M: Mobility<B>>(
        &mut self,
        mobility: &mut M,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        const BELOW: f64 = 0.7;
        const ABOVE: f64 = 1.05;
        (self.series, self.roots) = (None, 0);
        self.lanczos.add(mobility, white, scale, displacements)?;
        self.products += self.lanczos.iterations();
        let ritz = &self.lanczos.ritz;
        let high = ABOVE * (ritz.most() + ritz.beyond());
        // What is smaller does not show at the error asked for.
        let least = high * (0.25 * self.lanczos.tolerance()).powi(2);
        // The series ends at zero; what is taken for zero is to be no farther below than that allows.
        let low = (BELOW * ritz.least()).max(-4.0 * ritz.least()).max(least);
        let longest = 4 * self.lanczos.iterations();
        self.series = Series::new([low, high], longest, displacements.len());
        Ok(())
    }

    /// Sums the series into `self.sum`. Whether the bounds have held and it was long enough.
    fn sum<B: Boundary, M: Mobility<B>>(
        &mut self,
        mobility: &mut M,
        white: &White<'_>,
        len: usize,
    ) -> Result<bool, MobilityError> {
        // What the series may leave within its bounds; the rest is for what is not quite within.
        let tolerance = 0.25 * self.lanczos.tolerance();
        let Some(series) = self.series.as_ref().filter(|series| series.beads == len) else {
            return Ok(false);
        };
        let [last, term, next] = &mut self.columns;
        white.fill(last, len);
        let length = norm(last);
        series.times(mobility, last, term);
        self.products += 1;
        // |M^(1/2) z|^2 = z . M z.
        let form = series.center * length * length + series.half * dot(last, term);
        if !form.is_finite() {
            return Err(not_finite(term));
        }
        let Some(order) = series.order(tolerance * form.max(0.0).sqrt() / length) else {
            return Ok(false);
        };
        zero(&mut self.sum, len);
        add_scaled(&mut self.sum, series.coefficients[0], last);
        for &coefficient in &series.coefficients[1..order] {
            add_scaled(&mut self.sum, coefficient, term);
            series.times(mobility, term, next);
            self.products += 1;
            for_each_chunk(next, |start, chunk| {
                for (next, last) in chunk.iter_mut().zip(&last[start..]) {
                    *next = 2.0 * *next - *last;
                }
            });
            std::mem::swap(last, term);
            std::mem::swap(term, next);
        }
        add_scaled(&mut self.sum, series.coefficients[order], term);
        Ok(norm(last).max(norm(term)) <= series.longest() * length)
    }
}

impl<B: Boundary, M: Mobility<B>> Root<B, M> for Chebyshev {
    fn add(
        &mut self,
        mobility: &mut M,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        const MOST: usize = 100;
        self.products = 0;
        self.roots += 1;
        if self.roots < MOST && self.sum(mobility, white, displacements.len())? {
            add_scaled(displacements, scale, &self.sum);
            return Ok(());
        }
        self.measure(mobility, white, scale, displacements)
    }
}

/// The square root between two bounds, as a series.
#[derive(Clone, Debug)]
struct Series {
    center: f64,
    half: f64,
    coefficients: Vec<f64>,
    /// The sum of the coefficients' sizes from each one on.
    tails: Vec<f64>,
    beads: usize,
}

impl Series {
    /// The series between these bounds, if no more than `longest` terms of it can be wanted.
    fn new([low, high]: [f64; 2], longest: usize, beads: usize) -> Option<Self> {
        let (center, half) = (0.5 * (high + low), 0.5 * (high - low));
        let coefficients = coefficients(center / half, high.sqrt())?;
        let mut tails = coefficients.clone();
        let mut tail = 0.0;
        for size in tails.iter_mut().rev() {
            tail += size.abs();
            *size = tail;
        }
        tails.truncate(longest);
        Some(Self {
            center,
            half,
            coefficients,
            tails,
            beads,
        })
    }

    /// The highest order that is wanted for an error of at most `error` times the length of z.
    fn order(&self, error: f64) -> Option<usize> {
        let beyond = self.tails.iter().position(|tail| *tail <= error)?;
        Some(beyond.saturating_sub(1).max(1))
    }

    /// `image = Y v`, where Y is the mobility with its spectrum brought between -1 and 1.
    fn times<B: Boundary, M: Mobility<B>>(
        &self,
        mobility: &mut M,
        v: &[DVec3],
        image: &mut Vec<DVec3>,
    ) {
        zero(image, v.len());
        mobility.apply(v, image);
        let (center, scale) = (self.center, self.half.recip());
        for_each_chunk(image, |start, chunk| {
            for (image, v) in chunk.iter_mut().zip(&v[start..]) {
                *image = scale * (*image - center * *v);
            }
        });
    }

    /// How long a column can be, in lengths of z, if the bounds are right. A mean of squared cosines, weighted by the
    /// squares of normal numbers: 1/2, and three standard deviations.
    fn longest(&self) -> f64 {
        let components = 3.0 * self.beads as f64;
        (0.5 + 3.0 / components.sqrt()).min(1.0).sqrt()
    }
}

/// Coefficients of sqrt(x + y) in Chebyshev polynomials of y, half of the first, scaled to be `top` at y = 1.
///
/// From 2 (x + y) f' = f the coefficients d of f' obey
///
/// ```text
/// (1 - 1/2k) d_(k-1) + 2 x d_k + (1 + 1/2k) d_(k+1) = 0        2k c_k = d_(k-1) - d_(k+1)        c_0 = 2 x d_0 + 2 d_1
/// ```
///
/// of which they are the solution that decays, found from its far end (Miller's algorithm). Nothing, if there are more
/// than a hundred thousand above rounding.
fn coefficients(x: f64, top: f64) -> Option<Vec<f64>> {
    const MOST: f64 = 1e5;
    const ROUNDING: f64 = 40.0;
    let rate = libm::log(x + (x * x - 1.0).sqrt());
    let count = ROUNDING / rate + 2.0;
    if !(count > 0.0 && count < MOST) {
        return None;
    }
    let count = count as usize;
    let mut d = vec![0.0; count + 2];
    d[count] = 1.0;
    for k in (1..=count).rev() {
        let half = 0.5 / k as f64;
        d[k - 1] = -(2.0 * x * d[k] + (1.0 + half) * d[k + 1]) / (1.0 - half);
    }
    let rest = (1..count).map(|k| (d[k - 1] - d[k + 1]) / (2 * k) as f64);
    let mut c: Vec<f64> = std::iter::once(x * d[0] + d[1]).chain(rest).collect();
    let scale = top / c.iter().sum::<f64>();
    for c in &mut c {
        *c *= scale;
    }
    Some(c)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(c: &[f64], y: f64) -> f64 {
        let terms = c
            .iter()
            .enumerate()
            .map(|(k, c)| c * (k as f64 * y.acos()).cos());
        terms.sum()
    }

    // The series is the function: at any point of the interval, for condition numbers from 1.1 to 1e6.
    #[test]
    fn limit_the_series_is_the_square_root() {
        for condition in [1.1_f64, 10.0, 1e3, 1e6] {
            let x = (condition + 1.0) / (condition - 1.0);
            let c = coefficients(x, (x + 1.0).sqrt()).unwrap_or_default();
            for k in 0..=100 {
                let y = f64::from(k) / 50.0 - 1.0;
                let error = value(&c, y) - (x + y).sqrt();
                assert!(
                    error.abs() < 1e-12,
                    "condition {condition}, y {y}: {error:e}"
                );
            }
        }
    }

    // Errors of the truncated series are those of its tail at the lower bound, where all terms have one sign; the
    // relative errors at 1, 2 and 3 times sqrt(condition) + 1 terms decay as exp(-2 n / sqrt(condition)).
    #[test]
    fn limit_the_tail_is_the_error() {
        for condition in [100.0, 1000.0] {
            let series = Series::new([1.0, condition], 10_000, 1).unwrap_or_else(|| unreachable!());
            for error in [1e-2, 1e-4, 1e-8] {
                let order = series.order(error).unwrap_or_default();
                let kept = &series.coefficients[..=order];
                let worst = (0..=1000)
                    .map(|k| f64::from(k) / 500.0 - 1.0)
                    .map(|y| (value(kept, y) - (series.center + series.half * y).sqrt()).abs())
                    .fold(0.0, f64::max);
                assert!(
                    worst <= error && worst > 0.3 * error,
                    "{worst:e} for {error:e}"
                );
                let shorter = &series.coefficients[..order];
                let at_low = (value(shorter, -1.0) - 1.0).abs();
                assert!(at_low > error, "{at_low:e} with one term less");
            }
        }
    }
}
