//! The window that spreads a bead over mesh points: Kaiser and Bessel's.

use crate::lattice_sum::{Series, bessel};
use std::f64::consts::PI;

/// Most mesh points that a bead is spread over in each direction.
pub(super) const WIDEST: usize = 16;

/// The window
///
/// ```text
/// w(u) = I0(beta sqrt(1 - (2u/P)^2)) / I0(beta),  |u| < P/2
/// ```
///
/// of P mesh points, u in mesh spacings. Its Fourier transform is P sinh(q) / (q I0(beta)) with
/// q^2 = beta^2 - (P theta/2)^2. (Kaiser 1966; for meshes Beatty, Nishimura and Pauly, IEEE Trans. Med. Imaging 24,
/// 799, 2005.)
#[derive(Clone, Debug)]
pub(super) struct Window {
    points: usize,
    beta: f64,
    /// I0(beta).
    highest: f64,
    /// Polynomials of the points' weights, power by power, the highest first.
    powers: Vec<[f64; WIDEST]>,
}

impl Window {
    /// The window of this many points, its weights good to `error`.
    pub(super) fn new(points: usize, error: f64) -> Self {
        // Between 1.1 and 1.3 the error for a band that fills the mesh hardly changes.
        let beta = 0.6 * PI * points as f64;
        let half = 0.5 * points as f64;
        let quarter = 0.25 * beta * beta;
        let highest = bessel(quarter).0;
        let weight = |u: f64| {
            let x = u / half;
            bessel(quarter * (1.0 - x * x).max(0.0)).0 / highest
        };
        let fit = |j| Series::fit(points + 8, error, |t| weight(t + j as f64 - half));
        let fits: Vec<Series> = (0..points).map(fit).collect();
        let terms = fits.iter().map(Series::terms).max().unwrap_or(1);
        let padded: Vec<Vec<f64>> = fits.iter().map(|fit| fit.padded(terms)).collect();
        let mut powers = vec![[0.0; WIDEST]; terms];
        for (j, fit) in padded.iter().enumerate() {
            for (power, &coefficient) in powers.iter_mut().zip(fit) {
                power[j] = coefficient;
            }
        }
        Self {
            points,
            beta,
            highest,
            powers,
        }
    }

    /// Number of mesh points in each direction.
    pub(super) fn points(&self) -> usize {
        self.points
    }

    /// The first point under the window of a bead at mesh coordinate `s`, and how far behind the window's edge it is.
    #[inline(always)]
    pub(super) fn place(&self, s: f64) -> (i64, f64) {
        let edge = s - 0.5 * self.points as f64;
        let first = edge.floor() + 1.0;
        (first as i64, first - edge)
    }

    /// The weights of the points, beginning `t` behind the edge; zero beyond the last.
    #[inline(always)]
    pub(super) fn weights<const L: usize>(&self, t: f64) -> [f64; L] {
        let x = 2.0 * t - 1.0;
        let mut sum = [0.0; L];
        for power in &self.powers {
            for (sum, power) in sum.iter_mut().zip(power) {
                *sum = *sum * x + power;
            }
        }
        sum
    }

    /// The weights along three directions.
    #[inline(always)]
    pub(super) fn each_weights<const L: usize>(&self, [x, y, z]: [f64; 3]) -> [[f64; L]; 3] {
        [self.weights(x), self.weights(y), self.weights(z)]
    }

    /// The Fourier transform at `theta` radians a mesh spacing.
    pub(super) fn transform(&self, theta: f64) -> f64 {
        let points = self.points as f64;
        let square = self.beta * self.beta - 0.25 * points * points * theta * theta;
        let q = square.abs().sqrt();
        let sinc = if q < 1e-6 {
            1.0
        } else if square > 0.0 {
            libm::sinh(q) / q
        } else {
            libm::sin(q) / q
        };
        points * sinc / self.highest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice_sum::gauss;

    #[test]
    fn law_transform_is_that_of_the_window() {
        for points in [4, 5, 9, 13, 15] {
            let window = Window::new(points, 1e-14);
            for theta in [0.0, 0.4, 1.0, PI, 4.0, 6.0] {
                // The window's points tile its support: the integral is a sum over points of integrals over t.
                let mut integral = 0.0;
                for (t, weight) in gauss(24) {
                    let weights: [f64; WIDEST] = window.weights(t);
                    for (j, w) in weights[..points].iter().enumerate() {
                        let u = t + j as f64 - 0.5 * points as f64;
                        integral += weight * w * libm::cos(theta * u);
                    }
                }
                let error = (integral - window.transform(theta)).abs();
                assert!(
                    error < 1e-13 * window.transform(0.0),
                    "{points} {theta}: {error}"
                );
            }
        }
    }
}
