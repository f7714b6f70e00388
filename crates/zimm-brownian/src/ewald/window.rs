//! What of a mobility is summed over waves, and what over pairs.

use std::f64::consts::PI;

/// The share H(k) of each wave that is summed over waves; 1 - H is left to pairs.
///
/// ```text
/// H = g - s dg/ds    g = sinh(z) / z * b / sinh(b)    z^2 = b^2 - s    s = (k l)^2    k < b / l, else 0
/// ```
///
/// g is the transform of Kaiser's window: among functions of three-dimensional space that vanish beyond a range l it is
/// nearly the one that has least beyond the wave number b / l (Kaiser 1966; Slepian 1964, for the best). A Gaussian of
/// the same range has as little only beyond nearly twice that wave number, so that it takes up to eight times as many
/// waves for the same error. The operator 1 - s d/ds is Hasimoto's (1959): it makes 1 - H of fourth order in k, so that
/// what is left to pairs is of short range, for a Gaussian it gives the (1 + x) exp(-x) of positively split sums (Fiore,
/// Balboa Usabiaga, Donev and Swan 2017). As g is convex in s, H falls from 1 to nearly nothing at b / l: what waves
/// have and what pairs have are both positive, for beads of any radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    /// l: pairs of points farther apart have nothing left.
    pub(crate) range: f64,
    /// b: the error is of the order exp(-b).
    pub(crate) shape: f64,
}

impl Window {
    /// The wave number from which on there are no waves.
    pub(crate) fn edge(&self) -> f64 {
        self.shape / self.range
    }

    /// H(k), also beyond the edge, where it is what is cut off.
    pub(crate) fn share(&self, k: f64) -> f64 {
        let s = (k * self.range) * (k * self.range);
        let square = self.shape * self.shape - s;
        // g and dg/ds, but for the norm.
        let (g, slope) = if square.abs() < 0.1 {
            let g = 1.0 + square / 6.0 * (1.0 + square / 20.0 * (1.0 + square / 42.0));
            let slope = -(1.0 + square / 10.0 * (1.0 + square / 28.0 * (1.0 + square / 54.0)));
            (g, slope / 6.0)
        } else if square > 0.0 {
            let z = square.sqrt();
            let g = libm::sinh(z) / z;
            (g, (g - libm::cosh(z)) / (2.0 * square))
        } else {
            let z = (-square).sqrt();
            let g = libm::sin(z) / z;
            (g, (g - libm::cos(z)) / (2.0 * square))
        };
        (g - s * slope) * self.shape / libm::sinh(self.shape)
    }

    /// The sum over waves takes M(k) = 1 / zeta V times this times (I - kk / k^2): 6 pi a sinc^2(k a) H(k) / k^2, the
    /// transform of a sphere's surface squared (Wajnryb, Mizerski, Zuk and Szymczak 2013).
    pub(crate) fn weight(&self, k: f64, radius: f64) -> f64 {
        6.0 * PI * radius * self.surface(k, radius) / (k * k)
    }

    /// sinc^2(k a) H(k).
    pub(crate) fn surface(&self, k: f64, radius: f64) -> f64 {
        let x = k * radius;
        let sinc = if x < 1e-4 {
            1.0 - x * x / 6.0
        } else {
            libm::sin(x) / x
        };
        sinc * sinc * self.share(k)
    }
}
