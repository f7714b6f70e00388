//! Narrow Gaussians.

use crate::{BELOW_ZERO, NO_LENGTH, assert_refused, at, force, gauss_legendre, integral, slope};
use approx::assert_relative_eq;
use proptest::prelude::*;
use zimm_core::{BondForce, Now, PairForce, Reads};
use zimm_forces::{Fene, Hooke, NarrowGaussian};

/// The values of the formula, in libm's exponential: both are good to the last digits over the whole range.
#[test]
fn reference_the_formula_with_another_exponential() {
    let (z, d, kt, c) = (3.0, 0.7, 1.3, 30.0);
    let law = NarrowGaussian::with_cutoff(z, d, kt, c).unwrap();
    assert_eq!(law.cutoff(), c * d);
    assert_eq!(NarrowGaussian::READS, Reads::NOTHING);
    for k in 0..30_000 {
        let r = 1e-3 * f64::from(k) * d;
        let gaussian = libm::exp(-0.5 * r * r / (d * d));
        // The exponent, up to 450, carries a rounding error of its own.
        let tolerance = 1e-15 * (1.0 + r * r / (d * d));
        let f_over_r = kt * z / d.powi(5) * gaussian;
        let found = law.force(&at(r), &Now::default()).total();
        assert_relative_eq!(found, f_over_r, max_relative = tolerance);
        let energy = kt * z / d.powi(3) * gaussian;
        assert_relative_eq!(
            law.energy(&at(r)),
            energy,
            max_relative = tolerance,
            epsilon = 1e-190
        );
    }
}

#[test]
fn law_force_is_minus_the_slope_of_the_energy() {
    let law = NarrowGaussian::with_cutoff(2.0, 0.6, 1.7, 4.5).unwrap();
    for r in [0.01, 0.1, 0.3, 0.6, 1.0, 1.5, 2.0] {
        let expected = -slope(|r| law.energy(&at(r)), r);
        assert_relative_eq!(force(&law, r), expected, max_relative = 1e-7);
    }
}

/// v = (2 pi)^(3/2) z*: what the potential adds up to over all space is that of the delta function.
#[test]
fn limit_the_integral_of_the_energy_is_that_of_the_delta_function() {
    for (z, d) in [(1.0, 1.0), (10.0, 0.1), (0.3, 20.0)] {
        let law = NarrowGaussian::with_cutoff(z, d, 2.0, 12.0).unwrap();
        let shell = |r: f64| 4.0 * std::f64::consts::PI * r * r * law.energy(&at(r));
        let found = integral(shell, 0.0, 12.0 * d, 400);
        let v = (2.0 * std::f64::consts::PI).powf(1.5) * z;
        assert_relative_eq!(found, 2.0 * v, max_relative = 1e-12);
    }
}

/// What the default cutoff leaves: 3.1e-5 of the greatest force, which is at d*, and an energy without a jump.
#[test]
fn limit_the_force_at_the_cutoff() {
    let law = NarrowGaussian::new(10.0, 0.8).unwrap();
    let before = 5.0 * 0.8 * (1.0 - 1e-12);
    let (most, left) = (force(&law, 0.8), force(&law, before));
    assert_relative_eq!(left / most, 5.0 * (-12.0_f64).exp(), max_relative = 1e-9);
    assert!(left / most < 1e-4);
    assert!(
        [0.7, 0.79, 0.81, 0.9]
            .iter()
            .all(|&r| force(&law, r) < most)
    );
    assert!(law.energy(&at(before)).abs() < 1e-14);
    let jump = 1.0 - law.energy(&at(0.0)) * 0.8_f64.powi(3) / 10.0;
    assert_relative_eq!(jump, (-12.5_f64).exp(), max_relative = 1e-9);
}

/// The means of 1, x^2, y^2 and z^2 over directions, weighted by exp(a (x^2 - y^2 - 1)): panels along the axis, the
/// midpoints of a period around it.
fn over_directions(a: f64) -> [f64; 4] {
    const AROUND: usize = 48;
    let around: Vec<f64> = (0..AROUND)
        .map(|k| ((k as f64 + 0.5) / AROUND as f64 * std::f64::consts::FRAC_PI_2).cos())
        .map(|cosine| cosine * cosine)
        .collect();
    let at_height = |z: f64| {
        let flat = 1.0 - z * z;
        let mut sums = [0.0; 4];
        for cos2 in &around {
            let (xx, yy) = (flat * cos2, flat * (1.0 - cos2));
            let weight = (a * (xx - yy - 1.0)).exp();
            for (sum, value) in sums.iter_mut().zip([1.0, xx, yy, z * z]) {
                *sum += weight * value / AROUND as f64;
            }
        }
        sums
    };
    gauss_legendre(0.0, 1.0, 12).fold([0.0; 4], |mut sums, (z, w)| {
        for (sum, value) in sums.iter_mut().zip(at_height(z)) {
            *sum += w * value;
        }
        sums
    })
}

/// FENE (b = 10 and 50) and Hookean dumbbells with excluded volume at rest and in planar extension at rate e, in which
/// the stationary density is exp(-U - spring + e (x^2 - y^2)) in units of kT and (kT / H)^1/2. <QQ>, <Q^2>, <Q^4> and
/// <U>, twelve digits by quadrature elsewhere; with a cutoff of ten ranges nothing is left of the cut, with the default
/// of five, the moments of Q change by less than 3e-5.
#[test]
fn reference_dumbbells_with_excluded_volume() {
    let table = include_str!("../data/C10_dumbbell_ev.csv");
    let mut rows = 0;
    for line in table.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let numbers: Vec<f64> = fields[1..].iter().map(|x| x.parse().unwrap()).collect();
        let [b, z, d, rate] = numbers[..4] else {
            panic!("{line}")
        };
        let (spring, longest): (Box<dyn BondForce>, f64) = if fields[0] == "fene" {
            let fene = Fene::with_extensibility(b, b.sqrt(), 1.0).unwrap();
            (Box::new(fene), b.sqrt())
        } else {
            let variance = 1.0 / (1.0 - 2.0 * rate);
            (Box::new(Hooke::new(1.0).unwrap()), 8.5 * variance.sqrt())
        };
        let laws = [(10.0, 1e-7, 6), (5.0, 3e-5, 5)].map(|(cutoff, tolerance, count)| {
            let law = NarrowGaussian::with_cutoff(z, d, 1.0, cutoff).unwrap();
            (law, tolerance, count)
        });
        let mut sums = [[0.0; 7]; 2];
        for (r, w) in gauss_legendre(0.0, longest, 160) {
            let r2 = r * r;
            let [one, xx, yy, zz] = over_directions(rate * r2);
            let stretch = w * r2 * (rate * r2 - spring.energy(r2)).exp();
            for (sums, (law, ..)) in sums.iter_mut().zip(&laws) {
                let energy = law.energy(&at(r));
                let weight = stretch * (-energy).exp();
                let values = [
                    r2 * xx,
                    r2 * yy,
                    r2 * zz,
                    r2 * one,
                    r2 * r2 * one,
                    energy * one,
                    one,
                ];
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += weight * value;
                }
            }
        }
        for ([moments @ .., norm], (law, tolerance, count)) in sums.iter().zip(&laws) {
            for (moment, expected) in moments.iter().zip(&numbers[4..4 + count]) {
                let off = (moment / norm - expected).abs() / expected.max(1e-3);
                assert!(off < *tolerance, "{line}: off by {off:e} with {law:?}");
            }
        }
        rows += 1;
    }
    assert_eq!(rows, 64);
}

proptest! {
    #[test]
    fn law_nothing_acts_at_and_beyond_the_cutoff(
        z in 0.0..100.0, d in 0.01..50.0, c in 1.0..30.0, beyond in 1.0..1e9,
    ) {
        let law = NarrowGaussian::with_cutoff(z, d, 1.0, c).unwrap();
        for r in [law.cutoff(), beyond * law.cutoff(), 1e150] {
            prop_assert_eq!(law.force(&at(r), &Now::default()).total(), 0.0);
            prop_assert_eq!(law.energy(&at(r)), 0.0);
        }
    }
}

#[test]
fn extreme_parameters() {
    assert_refused("z*", &BELOW_ZERO, |z| NarrowGaussian::new(z, 1.0));
    assert_refused("d*", &NO_LENGTH, |d| NarrowGaussian::new(1.0, d));
    assert_refused("kt", &BELOW_ZERO, |kt| {
        NarrowGaussian::with_cutoff(1.0, 1.0, kt, 5.0)
    });
    assert_refused(
        "cutoff",
        &[0.99, 30.1, -5.0, f64::NAN, f64::INFINITY],
        |c| NarrowGaussian::with_cutoff(1.0, 1.0, 1.0, c),
    );
    let name = |z, d| NarrowGaussian::new(z, d).map_err(|error| error.name).err();
    assert_eq!(name(1e100, 1e-80), Some("energy at contact"));
    assert_eq!(name(1.0, 1e-80), Some("F/r at contact"));
    for (z, d) in [(0.0, 1.0), (1e-300, 1e100), (1e300, 1e3), (1e-200, 1e-90)] {
        let law = NarrowGaussian::new(z, d).unwrap();
        for r in [0.0, 1e-160, d, 5.0 * d, f64::MAX] {
            assert!(law.force(&at(r), &Now::default()).total() >= 0.0);
            assert!(law.energy(&at(r)).is_finite());
        }
    }
}
