//! Smooth functions on [0, 1] as polynomials, and integrals over [0, 1].

use std::f64::consts::PI;

/// A polynomial in t = 2 s - 1 that interpolates a smooth function of s in [0, 1].
#[derive(Clone, Debug, Default)]
pub(crate) struct Series {
    /// Coefficients, the highest power first.
    powers: Vec<f64>,
}

impl Series {
    /// Interpolates `f` in Chebyshev's nodes and drops what is below `error` times the largest coefficient, or below
    /// rounding. `most` terms must be enough to resolve `f`; far more would be left to rounding.
    pub(crate) fn fit(most: usize, error: f64, f: impl Fn(f64) -> f64) -> Self {
        let angle = |k: usize| PI * (k as f64 + 0.5) / most as f64;
        let values: Vec<f64> = (0..most)
            .map(|k| f(0.5 + 0.5 * libm::cos(angle(k))))
            .collect();
        // The angle of the m-th polynomial in the k-th node, from 0 to 2 pi without rounding.
        let quarters = |m: usize, k: usize| (m * (2 * k + 1) % (4 * most)) as f64;
        let cosine = |m, k| libm::cos(0.5 * PI * quarters(m, k) / most as f64);
        let coefficient = |m: usize| {
            let terms = values.iter().enumerate();
            let sum: f64 = terms.map(|(k, v)| v * cosine(m, k)).sum();
            sum * if m == 0 { 1.0 } else { 2.0 } / most as f64
        };
        let mut chebyshev: Vec<f64> = (0..most).map(coefficient).collect();
        let largest = chebyshev.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let least = error.max(0.25 * f64::EPSILON) * largest;
        let keep = chebyshev.iter().rposition(|c| c.abs() > least);
        chebyshev.truncate(keep.unwrap_or(0) + 1);
        Self {
            powers: powers(&chebyshev),
        }
    }

    /// Number of terms.
    pub(crate) fn terms(&self) -> usize {
        self.powers.len()
    }

    /// Coefficients, the highest power first, of at least so many terms.
    pub(crate) fn padded(&self, terms: usize) -> Vec<f64> {
        let missing = terms.saturating_sub(self.terms());
        let zeros = std::iter::repeat_n(0.0, missing);
        zeros.chain(self.powers.iter().copied()).collect()
    }

    /// The value at `s`.
    pub(crate) fn at(&self, s: f64) -> f64 {
        self.at_each(&[s])[0]
    }

    /// The values at several `s`, by Horner's rule.
    #[inline(always)]
    pub(crate) fn at_each<const L: usize>(&self, s: &[f64; L]) -> [f64; L] {
        let mut sum = [0.0; L];
        for &power in &self.powers {
            for (sum, s) in sum.iter_mut().zip(s) {
                *sum = *sum * (2.0 * s - 1.0) + power;
            }
        }
        sum
    }
}

/// A sum of Chebyshev polynomials as a sum of powers, the highest first.
fn powers(chebyshev: &[f64]) -> Vec<f64> {
    let n = chebyshev.len();
    let (mut before, mut this) = (vec![0.0; n], vec![0.0; n]);
    // Sums and what rounding took off them: a lattice sum adds the same error thousands of times.
    let mut sums = vec![[0.0; 2]; n];
    this[0] = 1.0;
    for (m, c) in chebyshev.iter().enumerate() {
        for ([sum, lost], power) in sums.iter_mut().zip(&this) {
            let (old, term) = (*sum, c * power);
            *sum = old + term;
            let kept = *sum - old;
            *lost += (old - (*sum - kept)) + (term - kept);
        }
        let factor = if m == 0 { 1.0 } else { 2.0 };
        let next = (0..n).map(|p| {
            let raised = if p == 0 { 0.0 } else { factor * this[p - 1] };
            raised - before[p]
        });
        let next: Vec<f64> = next.collect();
        before = std::mem::replace(&mut this, next);
        if m == 0 {
            before = vec![0.0; n];
            before[0] = 1.0;
        }
    }
    sums.iter().rev().map(|[sum, lost]| sum + lost).collect()
}

/// Nodes and weights of Gauss and Legendre's rule on [0, 1].
pub(crate) fn gauss(n: usize) -> Vec<(f64, f64)> {
    let order = n as f64;
    let node = |i: usize| {
        let mut x = libm::cos(PI * (i as f64 + 0.75) / (order + 0.5));
        let mut weight = 0.0;
        for _ in 0..8 {
            let (mut before, mut this) = (1.0, x);
            for k in 2..=n {
                let k = k as f64;
                (before, this) = (this, ((2.0 * k - 1.0) * x * this - (k - 1.0) * before) / k);
            }
            let square = (1.0 - x) * (1.0 + x);
            let slope = order * (before - x * this) / square;
            weight = 1.0 / (square * slope * slope);
            x -= this / slope;
        }
        (0.5 * (x + 1.0), weight)
    };
    let rule: Vec<(f64, f64)> = (0..n).map(node).collect();
    // Takes off what rounding has put into all weights alike.
    let sum: f64 = rule.iter().map(|(_, weight)| weight).sum();
    rule.into_iter().map(|(x, w)| (x, w / sum)).collect()
}
