//! Lennard-Jones and WCA.

use crate::{NO_LENGTH, NOT_POSITIVE, assert_refused, at, force, integral, slope};
use approx::assert_relative_eq;
use proptest::prelude::*;
use zimm_core::{Central, Now, Pair, PairForce, Reads};
use zimm_forces::{LennardJones, Wca};

#[test]
fn law_force_is_minus_the_slope_of_the_energy() {
    let (lj, wca) = (
        LennardJones::new(0.7, 1.3, 3.0).unwrap(),
        Wca::new(0.7, 1.3).unwrap(),
    );
    for r in [0.9, 1.1, 1.3, 1.4, 1.45] {
        let expected = -slope(|r| wca.energy(&at(r)), r);
        assert_relative_eq!(force(&wca, r), expected, max_relative = 1e-7);
    }
    for r in [0.9, 1.3, 1.4, 1.6, 2.0, 2.9] {
        let expected = -slope(|r| lj.energy(&at(r)), r);
        assert_relative_eq!(force(&lj, r), expected, max_relative = 1e-7);
    }
}

/// The minimum is -epsilon deep and lies at 2^1/6 sigma; there, and only there, the two laws differ by epsilon.
#[test]
fn limit_wca_is_lennard_jones_lifted() {
    let (epsilon, sigma) = (0.83333, 2.415229);
    let wca = Wca::new(epsilon, sigma).unwrap();
    let lj = LennardJones::new(epsilon, sigma, 1e4 * sigma).unwrap();
    let bottom = 2.0_f64.powf(1.0 / 6.0) * sigma;
    // Table E.1 of Jain's thesis gives the cutoff 2.711003 for this sigma.
    assert!((wca.cutoff() - 2.711003).abs() < 1e-6);
    assert_relative_eq!(wca.cutoff(), bottom, max_relative = 1e-15);
    assert_relative_eq!(lj.energy(&at(bottom)), -epsilon, max_relative = 1e-14);
    for r in [0.8 * sigma, sigma, 1.05 * sigma, 1.12 * sigma] {
        let lifted = lj.energy(&at(r)) + epsilon;
        assert_relative_eq!(
            wca.energy(&at(r)),
            lifted,
            max_relative = 1e-10,
            epsilon = 1e-14
        );
        assert_relative_eq!(force(&wca, r), force(&lj, r), max_relative = 1e-10);
    }
}

/// The second virial coefficient of the whole law in closed form, B_2 / (2 pi sigma^3 / 3) = -sum_j 2^(j - 3/2)
/// Gamma((2j - 1) / 4) T^(-(2j + 1) / 4) / j!, and its zero at Boyle's temperature 3.417928. The law is cut at 60
/// sigma, which leaves out 4e-5 at T = 1.
#[test]
fn limit_second_virial_coefficient() {
    let law = LennardJones::new(1.0, 1.0, 60.0).unwrap();
    for t in [1.0_f64, 2.0, 3.417_928, 10.0] {
        let mut factorial = 1.0;
        let mut exact = 0.0;
        for j in 0..60 {
            let n = f64::from(j);
            factorial *= n.max(1.0);
            let gamma = libm::tgamma((2.0 * n - 1.0) / 4.0);
            exact -= 2.0_f64.powf(n - 1.5) * gamma * t.powf(-(2.0 * n + 1.0) / 4.0) / factorial;
        }
        let f = |r: f64| -3.0 * r * r * (-law.energy(&at(r)) / t).exp_m1();
        let measured = integral(f, 0.0, 3.0, 1000) + integral(f, 3.0, 60.0, 1000);
        assert!(
            (measured - exact).abs() < 1e-4,
            "{t}: {measured} against {exact}"
        );
    }
}

/// Hirschfelder, Curtiss and Bird (1954): B* = -2.5381 at T* = 1, and the energy is shifted to zero at the cutoff by
/// the textbook value 0.016316891136 for 2.5 sigma.
#[test]
fn reference_lennard_jones_numbers() {
    let law = LennardJones::new(1.0, 1.0, 60.0).unwrap();
    let f = |r: f64| -3.0 * r * r * (-law.energy(&at(r))).exp_m1();
    let measured = integral(f, 0.0, 3.0, 1000) + integral(f, 3.0, 60.0, 1000);
    assert!((measured + 2.5381).abs() < 2e-4, "{measured}");
    let cut = LennardJones::new(1.0, 1.0, 2.5).unwrap();
    assert!((cut.energy(&at(1.0)) - 0.016316891136).abs() < 1e-12);
    assert!(cut.energy(&at(2.5 * (1.0 - 1e-9))).abs() < 1e-9);
}

proptest! {
    #[test]
    fn law_nothing_acts_at_and_beyond_the_cutoff(
        epsilon in 0.1..10.0, sigma in 0.01..50.0, ratio in 0.8..4.0, beyond in 1.0..3.0,
    ) {
        let lj = LennardJones::new(epsilon, sigma, ratio * sigma).unwrap();
        let wca = Wca::new(epsilon, sigma).unwrap();
        for factor in [1.0, beyond] {
            let (far, further) = (at(factor * lj.cutoff()), at(factor * wca.cutoff()));
            prop_assert_eq!(lj.force(&far, &Now::default()).total(), 0.0);
            prop_assert_eq!(lj.energy(&far), 0.0);
            prop_assert_eq!(wca.force(&further, &Now::default()).total(), 0.0);
            prop_assert_eq!(wca.energy(&further), 0.0);
        }
    }

    #[test]
    fn law_tuple_is_the_sum(r in 0.7..3.0) {
        let laws = (LennardJones::new(0.7, 1.3, 2.5).unwrap(), Wca::new(0.4, 0.9).unwrap());
        let now = Now::default();
        let sum: Central = laws.0.force(&at(r), &now) + laws.1.force(&at(r), &now);
        prop_assert_eq!(laws.force(&at(r), &now), sum);
        prop_assert_eq!(laws.energy(&at(r)), laws.0.energy(&at(r)) + laws.1.energy(&at(r)));
        prop_assert_eq!(laws.cutoff(), 2.5);
    }
}

#[test]
fn law_reads_nothing() {
    assert_eq!(LennardJones::READS, Reads::NOTHING);
    assert_eq!(Wca::READS, Reads::NOTHING);
}

#[test]
fn extreme_overlaps_are_infinite_and_never_nan() {
    fn check(law: impl PairForce) {
        for r2 in [0.0, 5e-324, 1e-300, 1e-100, 1e-30, 1e-3, f64::MAX] {
            let pair = Pair {
                r2,
                ..Pair::default()
            };
            let (force, energy) = (law.force(&pair, &Now::default()).total(), law.energy(&pair));
            assert!(force >= 0.0 && energy >= 0.0, "{r2}: {force} {energy}");
        }
        let zero = Pair::default();
        assert_eq!(law.force(&zero, &Now::default()).total(), f64::INFINITY);
        assert_eq!(law.energy(&zero), f64::INFINITY);
    }
    check(LennardJones::new(1.0, 1.0, 2.5).unwrap());
    check(Wca::new(1.0, 1.0).unwrap());
}

#[test]
fn extreme_parameters_are_refused() {
    assert_refused("epsilon", &NOT_POSITIVE, |e| LennardJones::new(e, 1.0, 2.5));
    assert_refused("sigma", &NO_LENGTH, |s| LennardJones::new(1.0, s, 2.5));
    assert_refused("cutoff", &NO_LENGTH, |rc| LennardJones::new(1.0, 1.0, rc));
    assert_refused("epsilon", &NOT_POSITIVE, |e| Wca::new(e, 1.0));
    assert_refused("sigma", &NO_LENGTH, |s| Wca::new(1.0, s));
    assert!(LennardJones::new(1.0, 1e100, 1e100).is_ok());
    let error = LennardJones::new(1.0, 1e100, 1e-100).unwrap_err();
    assert_eq!(error.name, "energy at the cutoff");
}
