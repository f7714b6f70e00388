//! Springs.

use crate::{NO_LENGTH, NOT_POSITIVE, assert_refused, integral, slope};
use approx::assert_relative_eq;
use zimm_core::{BondForce, Bonded, Clock, DVec3, ForceError, ForceField, Open, Particles, System};
use zimm_forces::{Fene, Fraenkel, Hooke, MarkoSiggia};

fn tension(spring: &impl BondForce, r: f64) -> f64 {
    -r * spring.force(r * r)
}

fn slope_is_tension(spring: &impl BondForce, lengths: &[f64]) {
    for &r in lengths {
        let expected = slope(|r| spring.energy(r * r), r);
        assert_relative_eq!(
            tension(spring, r),
            expected,
            max_relative = 1e-7,
            epsilon = 1e-9
        );
    }
}

#[test]
fn law_tension_is_the_slope_of_the_energy() {
    slope_is_tension(&Hooke::new(1.7).unwrap(), &[0.1, 1.0, 10.0]);
    slope_is_tension(&Fraenkel::new(1.7, 2.0).unwrap(), &[0.1, 1.0, 2.0, 10.0]);
    slope_is_tension(&Fene::new(1.7, 3.0).unwrap(), &[0.01, 0.5, 1.5, 2.5, 2.9]);
    slope_is_tension(
        &MarkoSiggia::new(1.7, 3.0).unwrap(),
        &[0.01, 0.5, 1.5, 2.5, 2.9],
    );
    let both = (
        Fene::new(1.7, 3.0).unwrap(),
        Fraenkel::new(0.4, 1.0).unwrap(),
    );
    slope_is_tension(&both, &[0.5, 1.5, 2.5]);
    assert_eq!(both.limit(), 3.0);
    assert_eq!(both.force(4.0), both.0.force(4.0) + both.1.force(4.0));
}

/// The mean of g(Q) over the canonical distribution of a free bond, Q^2 exp(-U / kT).
fn mean(spring: &impl BondForce, kt: f64, longest: f64, g: impl Fn(f64) -> f64) -> f64 {
    let weight = |r: f64| r * r * (-spring.energy(r * r) / kt).exp();
    let top = integral(|r| g(r) * weight(r), 0.0, longest, 2000);
    top / integral(weight, 0.0, longest, 2000)
}

/// Equipartition: <Q . F> = 3 kT for every spring. Force and energy enter separately.
#[test]
fn law_equipartition() {
    fn check(spring: impl BondForce, longest: f64) {
        for kt in [0.5, 1.0, 2.0] {
            let virial = mean(&spring, kt, longest, |r| r * tension(&spring, r));
            assert_relative_eq!(virial, 3.0 * kt, max_relative = 1e-9);
        }
    }
    check(Hooke::new(1.7).unwrap(), 20.0);
    check(Fraenkel::new(30.0, 1.0).unwrap(), 5.0);
    check(Fene::with_extensibility(50.0, 5.0, 1.0).unwrap(), 5.0);
    check(
        MarkoSiggia::with_persistence_length(0.1, 2.0, 1.0).unwrap(),
        2.0,
    );
}

/// Free FENE springs: <Q^2> = 3 Q_0^2 / (b + 5), <Q^4> = 15 Q_0^4 / ((b + 5)(b + 7)). Linear ones: <Q^2> = 3 kT / H.
#[test]
fn limit_mean_squares() {
    for (b, q0, kt) in [(10.0, 1.0, 1.0), (50.0, 5.0, 1.0), (400.0, 2.0, 0.5)] {
        let spring = Fene::with_extensibility(b, q0, kt).unwrap();
        assert_relative_eq!(spring.extensibility(kt), b, max_relative = 1e-15);
        let (q2, q4) = (q0 * q0, q0 * q0 * q0 * q0);
        assert_relative_eq!(
            mean(&spring, kt, q0, |r| r * r),
            3.0 * q2 / (b + 5.0),
            max_relative = 1e-10
        );
        assert_relative_eq!(
            mean(&spring, kt, q0, |r| r * r * r * r),
            15.0 * q4 / ((b + 5.0) * (b + 7.0)),
            max_relative = 1e-10
        );
    }
    let spring = Hooke::new(1.7).unwrap();
    assert_relative_eq!(
        mean(&spring, 0.8, 20.0, |r| r * r),
        2.4 / 1.7,
        max_relative = 1e-10
    );
}

/// To second order in q = Q / Q_0 the stiffness is H (1 + q^2) for FENE and H (1 + q/2 + 2 q^2 / 3) for the worm-like
/// chain.
#[test]
fn limit_small_extensions() {
    let (h, q0) = (1.7, 3.0);
    let (fene, wlc) = (Fene::new(h, q0).unwrap(), MarkoSiggia::new(h, q0).unwrap());
    assert_eq!((fene.force(0.0), fene.energy(0.0)), (-h, 0.0));
    assert_eq!((wlc.force(0.0), wlc.energy(0.0)), (-h, 0.0));
    for q in [1e-4, 1e-3, 1e-2] {
        let r2 = (q * q0) * (q * q0);
        let third = 6.0 * q * q * q;
        let fene_stiffness = -fene.force(r2) / h;
        assert!((fene_stiffness - 1.0 - q * q).abs() < third + 1e-15);
        let wlc_stiffness = -wlc.force(r2) / h;
        assert!((wlc_stiffness - 1.0 - q / 2.0 - 2.0 * q * q / 3.0).abs() < third + 1e-15);
        let hooke = 0.5 * h * r2;
        assert!((fene.energy(r2) / hooke - 1.0 - q * q / 2.0).abs() < third);
        assert!((wlc.energy(r2) / hooke - 1.0 - q / 3.0 - q * q / 3.0).abs() < third);
    }
}

/// Towards full extension the tension grows as H Q_0 / (2 (1 - q)) for FENE, kT / (4 P (1 - q)^2) for the chain.
#[test]
fn limit_full_extension() {
    let fene = Fene::new(1.7, 3.0).unwrap();
    let (persistence, contour, kt) = (0.05, 2.0, 1.3);
    let wlc = MarkoSiggia::with_persistence_length(persistence, contour, kt).unwrap();
    let left = 1e-6;
    assert_relative_eq!(
        tension(&fene, 3.0 * (1.0 - left)),
        1.7 * 3.0 / (2.0 * left),
        max_relative = 1e-5
    );
    assert_relative_eq!(
        tension(&wlc, contour * (1.0 - left)),
        kt / (4.0 * persistence * left * left),
        max_relative = 1e-5
    );
}

/// Clarke's thesis (2008): Q_0 = 8 and b = 50 give H = 0.78125, Q_0 = 5 gives 2. Fedosov, Karniadakis and Caswell
/// (2010), Table IV: k_s = 100, r_max = 2, so b = 400 at kT = 1.
#[test]
fn reference_fene_units() {
    let stiffness = |q0| Fene::with_extensibility(50.0, q0, 1.0).unwrap().stiffness();
    assert_eq!((stiffness(8.0), stiffness(5.0)), (0.78125, 2.0));
    assert_eq!(Fene::new(100.0, 2.0).unwrap().extensibility(1.0), 400.0);
}

/// The interpolation formula as Marko and Siggia (1995) print it, in persistence lengths, and its energy by quadrature.
#[test]
fn reference_worm_like_chain() {
    let (persistence, contour, kt) = (0.053, 1.6, 0.9);
    let spring = MarkoSiggia::with_persistence_length(persistence, contour, kt).unwrap();
    let printed = |r: f64| {
        let q = r / contour;
        kt / persistence * (1.0 / (4.0 * (1.0 - q) * (1.0 - q)) - 0.25 + q)
    };
    assert_eq!(spring.limit(), contour);
    assert_relative_eq!(
        spring.stiffness(),
        1.5 * kt / (persistence * contour),
        max_relative = 1e-15
    );
    for q in [0.01, 0.1, 0.5, 0.9, 0.99] {
        let r = q * contour;
        assert_relative_eq!(tension(&spring, r), printed(r), max_relative = 1e-12);
        assert_relative_eq!(
            spring.energy(r * r),
            integral(printed, 0.0, r, 2000),
            max_relative = 1e-10
        );
    }
}

#[test]
fn extreme_springs_at_their_limit() {
    fn check(spring: impl BondForce, stiffness: f64) {
        let limit2 = spring.limit() * spring.limit();
        let just_below = limit2.next_down();
        let (force, energy) = (spring.force(just_below), spring.energy(just_below));
        assert!(force.is_finite() && force < -1e10 * stiffness, "{force}");
        assert!(energy.is_finite() && energy > 10.0, "{energy}");
        for r2 in [limit2, limit2.next_up(), 2.0 * limit2, f64::MAX] {
            assert_eq!(spring.force(r2), f64::NEG_INFINITY);
            assert_eq!(spring.energy(r2), f64::INFINITY);
        }
    }
    for limit in [1e-100, 0.1, 1.0, 1.99, 3.3, 1e100] {
        let stiffness = 2.0 / (limit * limit);
        check(Fene::new(stiffness, limit).unwrap(), stiffness);
        check(MarkoSiggia::new(stiffness, limit).unwrap(), stiffness);
    }
}

#[test]
fn extreme_bonds_of_coincident_and_torn_beads() {
    fn bond(spring: impl BondForce, length: f64) -> Result<Vec<DVec3>, ForceError> {
        let particles = Particles::new(vec![DVec3::ZERO, length * DVec3::Y]).unwrap();
        let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1).unwrap());
        let mut forces = vec![DVec3::ZERO; 2];
        let mut field = Bonded::new(spring, vec![[0, 1]]);
        ForceField::accumulate(&mut field, &system.frame(), &mut forces, &mut ())?;
        Ok(forces)
    }
    let still = [DVec3::ZERO; 2];
    assert_eq!(bond(Hooke::new(1.0).unwrap(), 0.0).unwrap(), still);
    assert_eq!(bond(Fraenkel::new(1e9, 1.0).unwrap(), 0.0).unwrap(), still);
    assert_eq!(bond(Fene::new(1.0, 2.0).unwrap(), 0.0).unwrap(), still);
    assert_eq!(
        bond(MarkoSiggia::new(1.0, 2.0).unwrap(), 0.0).unwrap(),
        still
    );
    let almost = bond(Fraenkel::new(8.0, 1.0).unwrap(), 1e-30).unwrap();
    assert_relative_eq!(almost[0].y, -8.0, max_relative = 1e-12);
    for length in [2.0, 5.0] {
        for result in [
            bond(Fene::new(1.0, 2.0).unwrap(), length),
            bond(MarkoSiggia::new(1.0, 2.0).unwrap(), length),
        ] {
            assert!(matches!(result, Err(ForceError::Overstretched { .. })));
        }
    }
}

#[test]
fn extreme_parameters_are_refused() {
    assert_refused("stiffness", &NOT_POSITIVE, Hooke::new);
    assert_refused("stiffness", &NOT_POSITIVE, |h| Fraenkel::new(h, 1.0));
    assert_refused("natural length", &NO_LENGTH, |l| Fraenkel::new(1.0, l));
    assert_refused("stiffness", &NOT_POSITIVE, |h| Fene::new(h, 1.0));
    assert_refused("limit", &NO_LENGTH, |l| Fene::new(1.0, l));
    assert_refused("b", &NOT_POSITIVE, |b| {
        Fene::with_extensibility(b, 1.0, 1.0)
    });
    assert_refused("limit", &NO_LENGTH, |l| {
        Fene::with_extensibility(50.0, l, 1.0)
    });
    assert_refused("kt", &NOT_POSITIVE, |kt| {
        Fene::with_extensibility(50.0, 1.0, kt)
    });
    assert_refused("stiffness", &NOT_POSITIVE, |h| MarkoSiggia::new(h, 1.0));
    assert_refused("limit", &NO_LENGTH, |l| MarkoSiggia::new(1.0, l));
    assert_refused("persistence length", &NO_LENGTH, |p| {
        MarkoSiggia::with_persistence_length(p, 1.0, 1.0)
    });
    assert_refused("contour length", &NO_LENGTH, |l| {
        MarkoSiggia::with_persistence_length(0.1, l, 1.0)
    });
    assert_refused("kt", &NOT_POSITIVE, |kt| {
        MarkoSiggia::with_persistence_length(0.1, 1.0, kt)
    });
}
