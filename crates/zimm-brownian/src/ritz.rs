//! The square root of a tridiagonal matrix from Lanczos' method, and how far it is from the root of the whole.

use crate::tridiagonal::Tridiagonal;
use std::f64::consts::PI;

/// Eigenvalues of the tridiagonal matrix, which are nearly those of the mobility, and what follows from them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ritz {
    spectrum: Tridiagonal,
    values: Vec<f64>,
    beta: f64,
    floor: f64,
    beyond: f64,
    nodes: Vec<[f64; 2]>,
    all: Vec<usize>,
    weights: Vec<f64>,
}

impl Ritz {
    /// Decomposes T, of which `beta` is the next entry beside the diagonal. Returns the relative error of
    /// |z| V T^(1/2) e_1 that is to be expected for normal z of `3 beads` components. Eigenvalues no farther than
    /// `accuracy` below zero are zero.
    pub(crate) fn error(
        &mut self,
        diagonal: &[f64],
        off: &[f64],
        beta: f64,
        beads: usize,
        accuracy: f64,
    ) -> f64 {
        self.beta = beta;
        let last = diagonal.len() - 1;
        let ends = [0, last.saturating_sub(1), last];
        self.spectrum.decompose(diagonal, off, &ends);
        let rounding = self.rounding();
        self.values.clear();
        let values = self.spectrum.values().iter();
        self.values.extend(values.map(|value| value.max(rounding)));
        // The square of |M^(1/2) z| / |z|.
        let size = diagonal[0];
        let moved = |value: f64| {
            let positive = value.max(0.0);
            let below = (positive - value - accuracy).max(0.0);
            (positive + below + rounding).sqrt() - positive.sqrt()
        };
        let ends = self.spectrum.values().iter().zip(self.spectrum.vectors());
        let squares = ends.map(|(value, end)| (end[0] * moved(*value)).powi(2));
        let highest = self.spectrum.values().iter().zip(self.spectrum.vectors());
        let highest = highest.max_by(|a, b| a.0.total_cmp(b.0));
        self.beyond = beta * highest.map_or(0.0, |(_, end)| end[2].abs());
        self.floor = (squares.sum::<f64>() / size).sqrt();
        (self.truncation(off, beads) / size).sqrt() + self.floor
    }

    /// How far from zero rounding may bring an eigenvalue.
    pub(crate) fn rounding(&self) -> f64 {
        const UNITS: f64 = 8.0;
        UNITS * f64::EPSILON * self.most()
    }

    /// The part of the error that no iteration mends: rounding, and eigenvalues that are truly below zero, which are
    /// taken for zero.
    pub(crate) fn floor(&self) -> f64 {
        self.floor
    }

    /// The least eigenvalue met.
    pub(crate) fn least(&self) -> f64 {
        self.spectrum
            .values()
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min)
    }

    /// The greatest eigenvalue met.
    pub(crate) fn most(&self) -> f64 {
        self.spectrum.values().iter().copied().fold(0.0, f64::max)
    }

    /// How much more the greatest eigenvalue may be than the greatest met: the residual of its eigenvector.
    pub(crate) fn beyond(&self) -> f64 {
        self.beyond
    }

    /// T^(1/2) e_1.
    pub(crate) fn weights(&mut self, diagonal: &[f64], off: &[f64]) -> &[f64] {
        let Self {
            spectrum,
            all,
            weights,
            ..
        } = self;
        all.clear();
        all.extend(0..diagonal.len());
        spectrum.decompose(diagonal, off, all);
        weights.clear();
        weights.resize(diagonal.len(), 0.0);
        for (value, vector) in spectrum.values().iter().zip(spectrum.vectors()) {
            let factor = value.max(0.0).sqrt() * vector[0];
            for (weight, component) in weights.iter_mut().zip(vector) {
                *weight += factor * component;
            }
        }
        weights
    }

    /// The square of |x - M^(1/2) z| / |z| to be expected.
    ///
    /// With `A^(1/2) = 1/pi int (1 - s / (A + s)) s^(-1/2) ds` the error is `h(M) v` exactly, where v is the next basis
    /// vector and
    ///
    /// ```text
    /// h(t) = w g(t)    g(t) = 1/pi int s^(1/2) / (t + s) prod_k t_k / (t_k + s) ds    w = prod_k b_k / prod_k t_k
    /// ```
    ///
    /// with t_k the eigenvalues and b_k the entries beside the diagonal of T, `beta` among them. An eigenvector at zero
    /// that has the share u in z / |z| has the share u / w in v, so an unknown one cannot have more than w; that it has
    /// so little is as probable as w times the length of z. If its eigenvalue is below all that were met, the share is
    /// not above that of the first, either (separation theorem of Chebyshev, Markov and Stieltjes). Over the rest of the
    /// spectrum v is taken to be spread as the two basis vectors before it are, with some to spare.
    fn truncation(&mut self, off: &[f64], beads: usize) -> f64 {
        const SPREAD: f64 = 6.0;
        if self.beta == 0.0 {
            return 0.0;
        }
        let logs = |values: &[f64]| values.iter().map(|x| libm::log(*x)).sum::<f64>();
        let w = libm::exp(logs(off) + libm::log(self.beta) - logs(&self.values));
        self.set_nodes();
        let nodes = &self.nodes;
        let g = |t: f64| {
            nodes
                .iter()
                .map(|[s, weight]| weight / (t + s))
                .sum::<f64>()
        };
        let length = (3.0 * beads as f64).sqrt();
        let ends = || self.values.iter().zip(self.spectrum.vectors());
        let (_, first) = ends().fold((f64::INFINITY, 0.0), |least, (value, end)| {
            if *value < least.0 {
                (*value, end[0])
            } else {
                least
            }
        });
        let unmet = (first * first).min(w * w * (w * length).min(1.0)) * g(0.0).powi(2);
        let spread = |end: &[f64]| end[1] * end[1] + end[2] * end[2];
        let met: f64 = ends()
            .map(|(value, end)| spread(end) * (w * g(*value)).powi(2))
            .sum();
        unmet + SPREAD * met
    }

    /// Where the integral over s is taken, and `ds s^(1/2) / pi prod t_k / (t_k + s)` there. The trapezoidal rule in
    /// log s with a step of 2 is good to 1e-4.
    fn set_nodes(&mut self) {
        const STEP: f64 = 2.0;
        const MARGIN: f64 = 14.0;
        let narrowest = self
            .values
            .iter()
            .map(|value| value.recip())
            .sum::<f64>()
            .recip();
        let widest = self.values.iter().copied().fold(0.0, f64::max);
        let span = libm::log(widest / narrowest) + 2.0 * MARGIN;
        let start = libm::log(narrowest) - MARGIN;
        let values = &self.values;
        self.nodes.clear();
        self.nodes.extend((0..=(span / STEP) as usize).map(|k| {
            let s = libm::exp(start + STEP * k as f64);
            let product: f64 = values.iter().map(|value| value / (value + s)).product();
            [s, STEP / PI * s * s.sqrt() * product]
        }));
    }
}
