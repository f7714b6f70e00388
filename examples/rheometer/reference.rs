//! What theory says of the same dumbbells.
//!
//! Free-draining FENE dumbbells of extensibility b = 50 in steady shear, without excluded volume: the
//! Fokker-Planck equation solved by a Galerkin expansion up to De = 10, Brownian dynamics beyond (errors below 0.7 %).
//! De is lambda_H times the shear rate with lambda_H = zeta / 4H. At rest, <Q^2> = 3 Q_0^2 / (b + 5).

/// Material functions of a dilute solution at one Deborah number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dumbbell {
    /// Polymer viscosity over n kT lambda_H.
    pub(crate) viscosity: f64,
    /// First normal stress coefficient over n kT lambda_H^2.
    pub(crate) psi1: f64,
    /// <Q^2> / Q_0^2.
    pub(crate) extension: f64,
}

/// <Q^2> / Q_0^2 at rest.
pub(crate) const EXTENSION_AT_REST: f64 = 3.0 / 55.0;

/// The Deborah numbers that the table spans.
pub(crate) const RANGE: std::ops::RangeInclusive<f64> = 0.01..=300.0;

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

/// The reference at a Deborah number, from the four entries around it; nothing outside the table.
pub(crate) fn dumbbell(deborah: f64) -> Option<Dumbbell> {
    if !RANGE.contains(&deborah) {
        return None;
    }
    let above = TABLE.partition_point(|row| row[0] < deborah);
    let first = above.saturating_sub(2).min(TABLE.len() - 4);
    let [viscosity, psi1, extension] = interpolated(&TABLE[first..first + 4], deborah);
    Some(Dumbbell {
        viscosity,
        psi1,
        extension,
    })
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
            let found = dumbbell(deborah).unwrap();
            assert!((found.viscosity / viscosity - 1.0).abs() < 1e-12);
            assert!((found.psi1 / psi1 - 1.0).abs() < 1e-12);
            assert!((found.extension / extension - 1.0).abs() < 1e-12);
        }
    }

    /// Small-rate series of Bird, Curtiss, Armstrong and Hassager (1987): eta* = b / (b + 5) [1 - 0.054822 De^2],
    /// Psi_1* = 2 b^2 / ((b + 5)(b + 7)) [1 - 0.130401 De^2]. The next terms, 0.0119 De^4 and 0.0354 De^4 of the whole,
    /// are below 6e-5 here.
    #[test]
    fn limit_small_rates_follow_the_series() {
        for deborah in [0.02, 0.05, 0.15, 0.2] {
            let found = dumbbell(deborah).unwrap();
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
            assert_eq!(dumbbell(deborah), None);
        }
    }
}
