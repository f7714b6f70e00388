//! How the sum is split into waves and pairs.

use super::plan::Plan;
use super::series::{Series, gauss};
use crate::rpy::pair;
use std::f64::consts::PI;

/// Enough terms for every series here.
const TERMS: usize = 40;

/// The two parts of the mobility, both for a mobility of one of a bead alone.
///
/// The wave part keeps the fraction
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
#[derive(Clone, Debug, Default)]
pub(crate) struct Kernel {
    plan: Plan,
    /// psi as a function of x^2.
    psi: Series,
    alpha: f64,
    /// The wave part in real space, (isotropic I + dyadic r r), as functions of (r / range)^2.
    isotropic: Series,
    dyadic: Series,
}

impl Kernel {
    /// Both parts of a split.
    pub(crate) fn new(plan: Plan) -> Self {
        let (c, edge) = (plan.sharpness, plan.edge());
        let (quarter, ka) = (0.25 * c * c, edge * plan.radius);
        let error = 1e-2 * plan.error;
        let (highest, slope) = bessel(quarter);
        let kept = |s: f64| bessel(quarter * (1.0 - s)).0 / highest;
        let psi = Series::fit(TERMS, 1e-3 * error, kept);
        let alpha = quarter * slope / highest - ka * ka / 3.0;
        // Nodes x and weights of integrals over the band.
        let nodes: Vec<(f64, f64)> = gauss(32 + c as usize)
            .into_iter()
            .map(|(x, w)| (x, w * kept(x * x) * (1.0 + alpha * x * x)))
            .collect();
        let integral = |part: fn(f64) -> f64, power: i32| {
            // The second power is multiplied by r^2, (c / K)^2 at most.
            Series::fit(TERMS, error * c.powi(-power), |s| {
                let z = c * s.sqrt();
                let terms = nodes.iter().map(|&(x, w)| w * x.powi(power) * part(x * z));
                3.0 * ka / PI * edge.powi(power) * terms.sum::<f64>()
            })
        };
        let (isotropic, dyadic) = (integral(isotropic, 0), integral(dyadic, 2));
        Self {
            plan,
            psi,
            alpha,
            isotropic,
            dyadic,
        }
    }

    /// The split.
    pub(crate) fn plan(&self) -> &Plan {
        &self.plan
    }

    /// What the pair part leaves to a bead alone.
    pub(crate) fn alone(&self) -> f64 {
        1.0 - self.isotropic.at(0.0)
    }

    /// The fractions W of waves of these k^2; zero beyond the edge.
    #[inline(always)]
    pub(crate) fn waves<const L: usize>(&self, k2: &[f64; L]) -> [f64; L] {
        let unit = 1.0 / (self.plan.edge() * self.plan.edge());
        let mut s = *k2;
        for s in &mut s {
            *s = (*s * unit).min(1.0);
        }
        let mut kept = self.psi.at_each(&s);
        for ((kept, s), k2) in kept.iter_mut().zip(&s).zip(k2) {
            let inside = if k2 * unit <= 1.0 { 1.0 } else { 0.0 };
            *kept *= (1.0 + self.alpha * s) * inside;
        }
        kept
    }

    /// The pair part `f I + g r r` at distances of these squares, within the range.
    #[inline(always)]
    pub(crate) fn pairs<const L: usize>(&self, r2: &[f64; L]) -> [[f64; L]; 2] {
        let unit = 1.0 / (self.plan.range * self.plan.range);
        let mut s = *r2;
        for s in &mut s {
            *s *= unit;
        }
        let (mut f, mut g) = (self.isotropic.at_each(&s), self.dyadic.at_each(&s));
        for ((f, g), r2) in f.iter_mut().zip(g.iter_mut()).zip(r2) {
            let [isotropic, dyadic, inverse] = pair(*r2, self.plan.radius);
            *f = isotropic - *f;
            *g = dyadic * inverse - *g;
        }
        [f, g]
    }
}

/// I0(2 sqrt(y)) and its derivative with respect to y.
pub(crate) fn bessel(y: f64) -> (f64, f64) {
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
    use super::super::plan::{sharpness_of, widest_band};
    use super::*;

    const TOLERANCES: [f64; 7] = [1e-1, 1e-2, 1e-3, 1e-6, 1e-9, 1e-11, 1e-13];

    /// The kernel of a tolerance for beads of a radius, at so many times the shortest range.
    fn kernel(tolerance: f64, radius: f64, times: f64) -> Kernel {
        let sharpness = sharpness_of(tolerance);
        Kernel::new(Plan {
            radius,
            range: times * radius * sharpness / widest_band(sharpness),
            sharpness,
            error: tolerance,
        })
    }

    /// Overlapping, touching and far; in the middle of the range and short of its end.
    #[test]
    fn law_parts_add_up_to_the_kernel() {
        // The wave part in real space by a rule of ten times as many nodes, from W itself.
        for tolerance in TOLERANCES {
            let a = 0.3;
            let kernel = kernel(tolerance, a, 1.2);
            let (range, edge) = (kernel.plan.range, kernel.plan.edge());
            for r in [1e-9, 1e-3, 0.1, 0.5999, 0.6001, 0.5 * range, 0.99 * range] {
                let (mut f, mut g) = (0.0, 0.0);
                for (x, w) in gauss(400) {
                    let k = x * edge;
                    let [kept] = kernel.waves(&[k * k]);
                    let [j0, j1_z, j2_z2] = spherical_bessel(k * r);
                    let factor = w * edge * 3.0 * a / PI * kept;
                    f += factor * (j0 - j1_z);
                    g += factor * k * k * j2_z2;
                }
                let [[pair_f], [pair_g]] = kernel.pairs(&[r * r]);
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
            for times in [1e3, 10.0, 2.0, 1.01, 0.99] {
                let radius = 0.3;
                let kernel = kernel(tolerance, radius, times);
                for m in 1..1000 {
                    let k = m as f64 * 1e-3 * kernel.plan.edge();
                    let [kept] = kernel.waves(&[k * k]);
                    let ka = k * radius;
                    let whole = (libm::sin(ka) / ka).powi(2);
                    let below = -1e-4 * tolerance - 1e-13;
                    let good = kept >= below && whole - kept >= below;
                    assert!(good, "{tolerance} {ka}: {kept} of {whole}");
                }
            }
        }
    }

    #[test]
    fn law_pair_part_ends_within_the_tolerance() {
        for tolerance in TOLERANCES {
            let kernel = kernel(tolerance, 0.3, 1.2);
            let range = kernel.plan.range;
            let [[f], [g]] = kernel.pairs(&[range * range]);
            let ends = f.abs().max((f + g * range * range).abs());
            assert!(ends < 2.0 * tolerance, "{tolerance}: {f} {g}");
            assert!(
                ends > 1e-3 * tolerance,
                "{tolerance}: the range is longer than it need be"
            );
        }
    }
}
