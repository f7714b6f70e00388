//! What theory says of the same dumbbells: free-draining FENE dumbbells of extensibility b = 50, without excluded volume.
//! De is lambda_H times the rate with lambda_H = zeta / 4H. At rest, <Q^2> = 3 Q_0^2 / (b + 5).
//!
//! In steady shear, the Fokker-Planck equation solved by a Galerkin expansion up to De = 10, Brownian dynamics beyond
//! (errors below 0.7 %). In extension the distribution is known, (1 - Q^2 / b)^(b/2) exp(Q . kappa Q) in units of
//! l_H = (kT / H)^1/2 and lambda_H, and is integrated.

use super::EXTENSIBILITY;
use crate::flow::Flow;
use std::f64::consts::FRAC_PI_2;

/// Material functions of a dilute solution at one Deborah number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dumbbell {
    /// Polymer viscosity over n kT lambda_H, the customary one of the flow.
    pub(crate) viscosity: f64,
    /// (sigma_xx - sigma_yy) / rate^2 over n kT lambda_H^2.
    pub(crate) psi1: f64,
    /// <Q^2> / Q_0^2.
    pub(crate) extension: f64,
}

/// <Q^2> / Q_0^2 at rest.
pub(crate) const EXTENSION_AT_REST: f64 = 3.0 / 55.0;

/// The Deborah numbers that theory spans.
const RANGE: std::ops::RangeInclusive<f64> = 0.01..=300.0;
const RANGE_OF_EXTENSION: std::ops::RangeInclusive<f64> = 0.01..=3.0;

/// De, viscosity, psi1, extension.
const TABLE: [[f64; 4]; 12] = [
    [0.01, 0.909086, 1.594876, 0.054548],
    [0.1, 0.908594, 1.592822, 0.054801],
    [0.3, 0.904690, 1.576621, 0.056806],
    [0.5, 0.897254, 1.546132, 0.060640],
    [1.0, 0.867474, 1.428647, 0.076186],
    [2.0, 0.790527, 1.154911, 0.117667],
    [3.0, 0.718335, 0.931668, 0.158242],
    [5.0, 0.607907, 0.644687, 0.223443],
    [10.0, 0.452078, 0.338962, 0.322592],
    [30.0, 0.2539, 0.0987, 0.4654],
    [100.0, 0.1236, 0.02175, 0.5743],
    [300.0, 0.06200, 0.005187, 0.6385],
];

/// Where the reference comes from.
pub(crate) fn source(flow: Flow) -> &'static str {
    match flow {
        Flow::Shear | Flow::Rpf => "by the Fokker-Planck equation (De <= 10) or Brownian dynamics",
        Flow::Extension | Flow::Uniaxial => "exact",
        Flow::Mixed => "not known in closed form for this flow",
    }
}

/// The reference at a Deborah number, if there is one.
pub(crate) fn dumbbell(flow: Flow, deborah: f64) -> Option<Dumbbell> {
    match flow {
        Flow::Shear | Flow::Rpf => RANGE.contains(&deborah).then(|| sheared(deborah)),
        Flow::Extension | Flow::Uniaxial => RANGE_OF_EXTENSION
            .contains(&deborah)
            .then(|| extended(flow, deborah)),
        Flow::Mixed => None,
    }
}

/// Averages over the distribution by Simpson's rule along Q and its angle with z, and the midpoint rule over a
/// quarter around z.
fn extended(flow: Flow, deborah: f64) -> Dumbbell {
    const LENGTHS: u32 = 160;
    const HEIGHTS: u32 = 40;
    const ANGLES: u32 = 32;
    let rates = match flow {
        Flow::Uniaxial => [1.0, -0.5, -0.5],
        _ => [1.0, -1.0, 0.0],
    };
    let simpson = |k: u32, n: u32| match k {
        0 => 1.0,
        k if k == n => 1.0,
        k => f64::from(2 + 2 * (k % 2)),
    };
    // Integrals of 1, Q^2, x F_x, y F_y and z F_z.
    let mut sums = [0.0; 5];
    for k in 0..LENGTHS {
        let share = f64::from(k) / f64::from(LENGTHS);
        let r2 = EXTENSIBILITY * share * share;
        let left = 1.0 - share * share;
        for m in 0..=HEIGHTS {
            let cosine = f64::from(m) / f64::from(HEIGHTS);
            for n in 0..ANGLES {
                let quarter = (f64::from(n) + 0.5) / f64::from(ANGLES);
                let (sin, cos) = (FRAC_PI_2 * quarter).sin_cos();
                let across = 1.0 - cosine * cosine;
                let squares = [across * cos * cos, across * sin * sin, cosine * cosine];
                let flow: f64 = squares.iter().zip(rates).map(|(s, rate)| s * rate).sum();
                // What is most likely is taken off the exponent, so that nothing overflows.
                let exponent =
                    0.5 * EXTENSIBILITY * left.ln() + deborah * r2 * flow - deborah * EXTENSIBILITY;
                let weight = simpson(k, LENGTHS) * simpson(m, HEIGHTS) * r2 * exponent.exp();
                let forces = squares.map(|square| square * r2 / left);
                let values = [1.0, r2, forces[0], forces[1], forces[2]];
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += weight * value;
                }
            }
        }
    }
    let [xx, yy, zz] = [2, 3, 4].map(|k| sums[k] / sums[0]);
    let difference = match flow {
        Flow::Uniaxial => xx - 0.5 * (yy + zz),
        _ => xx - yy,
    };
    Dumbbell {
        viscosity: difference / deborah,
        psi1: (xx - yy) / (deborah * deborah),
        extension: sums[1] / sums[0] / EXTENSIBILITY,
    }
}

/// From the four entries of the table around it.
fn sheared(deborah: f64) -> Dumbbell {
    let above = TABLE.partition_point(|row| row[0] < deborah);
    let first = above.saturating_sub(2).min(TABLE.len() - 4);
    let [viscosity, psi1, extension] = interpolated(&TABLE[first..first + 4], deborah);
    Dumbbell {
        viscosity,
        psi1,
        extension,
    }
}

/// The polynomial through these entries: logarithms against log(1 + De^2), because all three are even functions of De
/// and end in power laws.
fn interpolated(entries: &[[f64; 4]], deborah: f64) -> [f64; 3] {
    let abscissa = |deborah: f64| (deborah * deborah).ln_1p();
    let x = abscissa(deborah);
    let mut sums = [0.0; 3];
    for (i, entry) in entries.iter().enumerate() {
        let here = abscissa(entry[0]);
        let mut weight = 1.0;
        for (j, other) in entries.iter().enumerate() {
            if i != j {
                let there = abscissa(other[0]);
                weight *= (x - there) / (here - there);
            }
        }
        for (sum, value) in sums.iter_mut().zip(&entry[1..]) {
            *sum += weight * value.ln();
        }
    }
    sums.map(f64::exp)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_the_table_is_met_at_its_entries() {
        for [deborah, viscosity, psi1, extension] in TABLE {
            let found = dumbbell(Flow::Shear, deborah).unwrap();
            assert!((found.viscosity / viscosity - 1.0).abs() < 1e-12);
            assert!((found.psi1 / psi1 - 1.0).abs() < 1e-12);
            assert!((found.extension / extension - 1.0).abs() < 1e-12);
        }
    }

    /// Planar extension: quadrature to 6 digits, with viscosity eta_1. Uniaxial extension: 3 b / (b + 5) at small rates.
    #[test]
    fn reference_extension_is_exact() {
        for (deborah, extension, viscosity) in [
            (0.1, 0.055592, 3.74301),
            (0.5, 0.103803, 8.65682),
            (1.0, 0.466321, 45.6058),
            (3.0, 0.825953, 82.2606),
        ] {
            let found = dumbbell(Flow::Extension, deborah).unwrap();
            assert!(
                (found.extension / extension - 1.0).abs() < 1e-4,
                "{found:?}"
            );
            assert!(
                (found.viscosity / viscosity - 1.0).abs() < 1e-4,
                "{found:?}"
            );
        }
        let found = dumbbell(Flow::Uniaxial, 0.01).unwrap();
        assert!(
            (found.viscosity / (150.0 / 55.0) - 1.0).abs() < 0.01,
            "{found:?}"
        );
        assert!((found.extension / EXTENSION_AT_REST - 1.0).abs() < 1e-3);
    }

    /// Small-rate series of Bird, Curtiss, Armstrong and Hassager (1987): eta* = b / (b + 5) [1 - 0.054822 De^2],
    /// Psi_1* = 2 b^2 / ((b + 5)(b + 7)) [1 - 0.130401 De^2]. The next terms, 0.0119 De^4 and 0.0354 De^4 of the whole,
    /// are below 6e-5 here.
    #[test]
    fn limit_small_rates_follow_the_series() {
        for deborah in [0.02, 0.05, 0.15, 0.2] {
            let found = dumbbell(Flow::Shear, deborah).unwrap();
            let square: f64 = deborah * deborah;
            let viscosity = 50.0 / 55.0 * (1.0 - 0.054822 * square);
            let psi1 = 5000.0 / (55.0 * 57.0) * (1.0 - 0.130401 * square);
            assert!(
                (found.viscosity / viscosity - 1.0).abs() < 1e-4,
                "{deborah}"
            );
            assert!((found.psi1 / psi1 - 1.0).abs() < 1e-4, "{deborah}");
        }
    }

    /// Every entry from 0.3 to 30, left out and interpolated from two on either side, is met within 0.7 % (0.3 % up to
    /// De = 5): a wrong digit in the third place shows, and between entries the error is some ten times smaller.
    #[test]
    fn law_entries_fit_their_neighbours() {
        for k in 2..TABLE.len() - 2 {
            let others = [TABLE[k - 2], TABLE[k - 1], TABLE[k + 1], TABLE[k + 2]];
            let found = interpolated(&others, TABLE[k][0]);
            let most = if TABLE[k][0] > 5.0 { 7e-3 } else { 3e-3 };
            for (found, entry) in found.iter().zip(&TABLE[k][1..]) {
                assert!(
                    (found / entry - 1.0).abs() < most,
                    "De = {}: {found} {entry}",
                    TABLE[k][0]
                );
            }
        }
    }

    #[test]
    fn extreme_nothing_is_said_outside_the_table() {
        for deborah in [0.0, -1.0, 0.0099, 300.1, f64::NAN, f64::INFINITY] {
            for flow in [Flow::Shear, Flow::Extension, Flow::Uniaxial, Flow::Mixed] {
                assert_eq!(dumbbell(flow, deborah), None);
            }
        }
    }
}
