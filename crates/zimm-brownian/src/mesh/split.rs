//! How the sum is split into waves and pairs.

use super::series::{Series, gauss};
use crate::rpy::pair;
use std::f64::consts::PI;

/// Enough terms for every series here.
const TERMS: usize = 48;

/// The wave part of the mobility keeps the fraction
///
/// ```text
/// W(k) = psi(x) (1 + alpha x^2),  psi(x) = I0(c sqrt(1 - x^2)) / I0(c),  x = k/K < 1
/// ```
///
/// of Stokes' kernel and no wave beyond K. With alpha such that W = 1 - a^2 k^2/3 + O(k^4) it is the mobility of
/// spheres of radius a but for short waves, and what remains for the pairs ends at r = c/K to an error of about e^-c.
/// As long as 0 <= W <= sinc^2(ka), the kernel of Rotne, Prager and Yamakawa (Wajnryb et al., J. Fluid Mech. 731, R3,
/// 2013), both parts are positive, as in the split of Fiore, Balboa Usabiaga, Donev and Swan (2017). The function of
/// Kaiser and Bessel in the place of their Gaussian nearly halves K at the same range and error.
#[derive(Clone, Debug)]
pub(super) struct Split {
    sharpness: f64,
    error: f64,
    curvature: f64,
    /// psi as a function of x^2.
    psi: Series,
    /// Nodes x and weights of integrals over the band.
    nodes: Vec<(f64, f64)>,
}

/// The product of range and band edge, c = K r, for which the pair part beyond its range is `tail`: the root mean
/// square over all space, in units of a r^-1/2, within a factor of 1.5 from 0.1 to 1e-12.
pub(super) fn sharpness(tail: f64) -> f64 {
    let mut c = 10.0_f64;
    for _ in 0..60 {
        c = (libm::log(2.65 / tail) + 1.3 * libm::log(c)).max(5.0);
    }
    c
}

/// The largest K a for which both parts are positive, from a scan of c from 5 to 40.
pub(super) fn band(sharpness: f64) -> f64 {
    3.0 - 12.0 / (sharpness * sharpness)
}

impl Split {
    /// The split of a sharpness c, evaluated to within `error`.
    pub(super) fn new(sharpness: f64, error: f64) -> Self {
        let quarter = 0.25 * sharpness * sharpness;
        let (highest, slope) = bessel(quarter);
        Self {
            sharpness,
            error,
            curvature: quarter * slope / highest,
            psi: Series::fit(TERMS, 1e-3 * error, |s| {
                bessel(quarter * (1.0 - s)).0 / highest
            }),
            nodes: gauss(32 + sharpness as usize),
        }
    }

    /// The product of range and band edge.
    pub(super) fn sharpness(&self) -> f64 {
        self.sharpness
    }

    /// The two kernels for beads of a radius and pairs up to a range.
    pub(super) fn kernel(&self, radius: f64, range: f64) -> Kernel {
        let edge = self.sharpness / range;
        let ka = edge * radius;
        let alpha = self.curvature - ka * ka / 3.0;
        let kept = |x: f64| self.psi.at(x * x) * (1.0 + alpha * x * x);
        let nodes = self.nodes.iter().map(|&(x, w)| (x, w * kept(x)));
        let nodes: Vec<(f64, f64)> = nodes.collect();
        let integral = |part: fn(f64) -> f64, power: i32| {
            // The second power is multiplied by r^2, (c / K)^2 at most.
            let error = self.error * self.sharpness.powi(-power);
            Series::fit(TERMS, error, |s| {
                let z = self.sharpness * s.sqrt();
                let terms = nodes.iter().map(|&(x, w)| w * x.powi(power) * part(x * z));
                3.0 * ka / PI * edge.powi(power) * terms.sum::<f64>()
            })
        };
        Kernel {
            radius,
            range,
            edge,
            psi: self.psi.clone(),
            alpha,
            isotropic: integral(isotropic, 0),
            dyadic: integral(dyadic, 2),
        }
    }
}

/// The two kernels, both for a mobility of one of a bead alone.
#[derive(Clone, Debug)]
pub(super) struct Kernel {
    radius: f64,
    range: f64,
    edge: f64,
    psi: Series,
    alpha: f64,
    /// The wave part in real space, (isotropic I + dyadic r r), as functions of (r / range)^2.
    isotropic: Series,
    dyadic: Series,
}

impl Kernel {
    /// The largest wave number of the wave part.
    pub(super) fn edge(&self) -> f64 {
        self.edge
    }

    /// The largest distance of the pair part.
    pub(super) fn range(&self) -> f64 {
        self.range
    }

    /// What the pair part leaves to a bead alone.
    pub(super) fn alone(&self) -> f64 {
        1.0 - self.isotropic.at(0.0)
    }

    /// The fractions W of waves of these k^2; zero beyond the edge.
    #[inline(always)]
    pub(super) fn waves<const L: usize>(&self, k2: &[f64; L]) -> [f64; L] {
        let unit = 1.0 / (self.edge * self.edge);
        let mut s = *k2;
        for s in &mut s {
            *s = (*s * unit).min(1.0);
        }
        let mut kept = self.psi.at_each(&s);
        for ((kept, s), k2) in kept.iter_mut().zip(&s).zip(k2) {
            let inside = if k2 * unit <= 1.0 { 1.0 } else { 0.0 };
            *kept = (*kept * (1.0 + self.alpha * s)).max(0.0) * inside;
        }
        kept
    }

    /// The pair part `f I + g r r` at distances of these squares, within the range.
    #[inline(always)]
    pub(super) fn pairs<const L: usize>(&self, r2: &[f64; L]) -> ([f64; L], [f64; L]) {
        let unit = 1.0 / (self.range * self.range);
        let mut s = *r2;
        for s in &mut s {
            *s *= unit;
        }
        let (mut f, mut g) = (self.isotropic.at_each(&s), self.dyadic.at_each(&s));
        for ((f, g), r2) in f.iter_mut().zip(g.iter_mut()).zip(r2) {
            let [isotropic, dyadic, inverse] = pair(*r2, self.radius);
            *f = isotropic - *f;
            *g = dyadic * inverse - *g;
        }
        (f, g)
    }
}

/// I0(2 sqrt(y)) and its derivative with respect to y.
pub(super) fn bessel(y: f64) -> (f64, f64) {
    let (mut term, mut value, mut slope, mut k) = (1.0, 1.0, 0.0, 0.0);
    while term > 1e-18 * value {
        k += 1.0;
        slope += term / k;
        term *= y / (k * k);
        value += term;
    }
    (value, slope)
}

/// j0(z) - j1(z)/z: the part in front of I of a wave, averaged over its directions.
fn isotropic(z: f64) -> f64 {
    let [j0, j1_z, _] = spherical_bessel(z);
    j0 - j1_z
}

/// j2(z)/z^2: the part in front of z z of a wave, averaged over its directions.
fn dyadic(z: f64) -> f64 {
    spherical_bessel(z)[2]
}

/// j0(z), j1(z)/z, j2(z)/z^2.
fn spherical_bessel(z: f64) -> [f64; 3] {
    if z < 1.5 {
        // The power series: sum of (-z^2/2)^m / (m! (2n+2m+1)!!).
        return [0, 1, 2].map(|n| {
            let mut term = [1.0, 1.0 / 3.0, 1.0 / 15.0][n];
            let mut sum = term;
            for m in 1..14 {
                term *= -0.5 * z * z / (m * (2 * n + 2 * m + 1)) as f64;
                sum += term;
            }
            sum
        });
    }
    let (sin, cos) = libm::sincos(z);
    let j0 = sin / z;
    let j1_z = (j0 - cos) / (z * z);
    [j0, j1_z, (3.0 * j1_z - j0) / (z * z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOLERANCES: [f64; 6] = [1e-1, 1e-2, 1e-3, 1e-6, 1e-9, 1e-11];

    /// A split, and the shortest range for beads of radius 1.
    fn split(tolerance: f64) -> (Split, f64) {
        let c = sharpness(tolerance);
        (Split::new(c, 1e-2 * tolerance), c / band(c))
    }

    /// Overlapping, touching and far; in the middle of the range and short of its end.
    #[test]
    fn law_parts_add_up_to_the_kernel() {
        // The wave part in real space by a rule of ten times as many nodes, from W itself.
        for tolerance in TOLERANCES {
            let (split, shortest) = split(tolerance);
            let a = 0.3;
            let range = 1.2 * a * shortest;
            let kernel = split.kernel(a, range);
            for r in [1e-9, 1e-3, 0.1, 0.5999, 0.6001, 0.5 * range, 0.99 * range] {
                let (mut f, mut g) = (0.0, 0.0);
                for (x, w) in gauss(400) {
                    let k = x * kernel.edge();
                    let [kept] = kernel.waves(&[k * k]);
                    let [j0, j1_z, j2_z2] = spherical_bessel(k * r);
                    let factor = w * kernel.edge() * 3.0 * a / PI * kept;
                    f += factor * (j0 - j1_z);
                    g += factor * k * k * j2_z2;
                }
                let ([pair_f], [pair_g]) = kernel.pairs(&[r * r]);
                let rpy = if r < 2.0 * a {
                    [1.0 - 9.0 * r / (32.0 * a), 3.0 * r / (32.0 * a)]
                } else {
                    let x = a / r;
                    [0.75 * x + 0.5 * x * x * x, 0.75 * x - 1.5 * x * x * x]
                };
                let errors = [pair_f + f - rpy[0], (pair_g + g) * r * r - rpy[1]];
                for error in errors {
                    assert!(
                        error.abs() < 0.03 * tolerance + 1e-13,
                        "{tolerance} {r}: {errors:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn law_both_parts_are_positive() {
        for tolerance in TOLERANCES {
            let (split, shortest) = split(tolerance);
            for radius in [1e-3, 0.1, 0.5, 0.99, 1.01] {
                let kernel = split.kernel(radius, shortest);
                for m in 1..1000 {
                    let k = m as f64 * 1e-3 * kernel.edge();
                    let [kept] = kernel.waves(&[k * k]);
                    let ka = k * radius;
                    let whole = (libm::sin(ka) / ka).powi(2);
                    let good = kept >= 0.0 && whole - kept >= -1e-4 * tolerance - 1e-13;
                    assert!(good, "{tolerance} {ka}: {kept} of {whole}");
                }
            }
        }
    }

    #[test]
    fn law_pair_part_ends_within_the_tolerance() {
        for tolerance in TOLERANCES {
            let (split, shortest) = split(tolerance);
            let a = 0.3;
            let range = 1.2 * a * shortest;
            let ([f], [g]) = split.kernel(a, range).pairs(&[range * range]);
            let ends = f.abs().max((f + g * range * range).abs());
            assert!(ends < 2.0 * tolerance, "{tolerance}: {f} {g}");
            assert!(
                ends > 1e-3 * tolerance,
                "{tolerance}: the range is longer than it need be"
            );
        }
    }
}
