//! The laws of dissipative particle dynamics, pair by pair.

use crate::{BELOW_ZERO, NO_LENGTH, NOT_POSITIVE, assert_refused, at, force, slope};
use approx::assert_relative_eq;
use proptest::prelude::*;
use zimm_core::noise::{Domain, Noise};
use zimm_core::{
    AllPairs, Central, Clock, DVec3, ForceField, Now, Open, Pair, PairForce, Pairwise, Particles,
    Reads, System,
};
use zimm_forces::{
    Coefficient, Distribution, Dpd, DpdConservative, DpdDissipative, DpdRandom, Normal, Power,
    Quadratic, SpeciesError, SpeciesMatrix, SquareRoot, Uniform, Weight,
};

const TABLE: [[f64; 3]; 3] = [[25.0, 30.0, 10.0], [30.0, 20.0, 40.0], [10.0, 40.0, 0.0]];

fn moving(r: f64, speed: f64, key: u64) -> Pair {
    let noise = Noise::new(key, 3);
    Pair {
        rv: r * speed,
        noise: noise.site(4) + noise.site(9),
        species: [0, 1],
        ..at(r)
    }
}

fn now(dt: f64, kt: f64) -> Now {
    Now {
        dt,
        kt,
        ..Now::default()
    }
}

#[test]
fn law_force_is_minus_the_slope_of_the_energy() {
    for cutoff in [0.7, 1.0, 2.0] {
        let law = DpdConservative::new(25.0, cutoff).unwrap();
        let whole = Dpd::new(25.0, 4.5).unwrap().with_cutoff(cutoff).unwrap();
        for part in [0.01, 0.3, 0.5, 0.9, 0.99] {
            let r = part * cutoff;
            let expected = -slope(|r| law.energy(&at(r)), r);
            assert_relative_eq!(force(&law, r), expected, max_relative = 1e-9);
            assert_eq!(law.energy(&at(r)), whole.energy(&at(r)));
        }
    }
}

fn balances(weight: impl Weight + Copy, s: f64) {
    assert_eq!(weight.exponent(), s);
    let (gamma, kt, dt, cutoff, speed) = (4.5, 0.7, 0.02, 1.3, 1.7);
    let law = Dpd::new(0.0, gamma)
        .and_then(|law| law.with_cutoff(cutoff))
        .unwrap()
        .with_weight(weight);
    for r in [1e-3, 0.2, 0.65, 1.0, 1.299] {
        let pair = moving(r, speed, 7);
        let Central {
            dissipative,
            random,
            ..
        } = law.force(&pair, &now(dt, kt));
        let friction = -r * dissipative / speed;
        let amplitude = r * random / pair.noise.uniform(Domain::DPD);
        let exact = gamma * (1.0 - r / cutoff).powf(s);
        assert_relative_eq!(friction, exact, max_relative = 1e-12);
        assert_relative_eq!(
            amplitude * amplitude * dt,
            2.0 * kt * friction,
            max_relative = 1e-12
        );
    }
}

#[test]
fn law_fluctuation_balances_dissipation() {
    balances(Quadratic, 2.0);
    balances(SquareRoot, 0.5);
    for s in [0.25, 0.5, 1.0, 2.0, 3.7] {
        balances(Power::new(s).unwrap(), s);
    }
}

/// Seed 11, 200 000 independent pairs at overlap 1/2 with gamma = 2, kT = dt = 1, so that the force has the variance
/// 2 gamma kT w_R^2 / dt = 1. Standard error of the mean 0.0022; of the variance ((kurtosis - 1) / n)^1/2 = 0.0020
/// (uniform), 0.0032 (normal). Bounds are 5 sigma: an amplitude wrong by 1 % (variance by 2 %) is caught.
fn has_unit_variance(distribution: impl Distribution, kurtosis: f64) {
    let samples = 200_000;
    let law = DpdRandom::new(2.0, Quadratic, distribution, 1.0).unwrap();
    let (mut sum, mut squares) = (0.0, 0.0);
    for step in 0..samples {
        let noise = Noise::new(11, step);
        let pair = Pair {
            noise: noise.site(1) + noise.site(2),
            ..at(0.5)
        };
        let f = 0.5 * law.force(&pair, &now(1.0, 1.0)).random;
        sum += f;
        squares += f * f;
    }
    let n = samples as f64;
    let (mean, variance) = (sum / n, squares / n);
    assert!(mean.abs() < 5.0 * n.recip().sqrt(), "mean {mean}");
    let error = ((kurtosis - 1.0) / n).sqrt();
    assert!((variance - 1.0).abs() < 5.0 * error, "variance {variance}");
}

#[test]
fn law_noise_has_mean_zero_and_its_variance() {
    has_unit_variance(Uniform, 1.8);
    has_unit_variance(Normal, 3.0);
}

fn vanishes_outside(law: impl PairForce, pair: Pair) {
    let zero = law.force(&pair, &now(0.01, 1.0));
    assert_eq!(
        [zero.conservative, zero.dissipative, zero.random],
        [0.0; 3],
        "{pair:?}"
    );
    assert_eq!(law.energy(&pair), 0.0);
}

proptest! {
    #[test]
    fn law_nothing_acts_at_and_beyond_the_cutoff(cutoff in 0.01..50.0, beyond in 1.0..3.0, key: u64) {
        for r in [cutoff, beyond * cutoff] {
            let pair = moving(r, 3.0, key);
            let law = Dpd::new(25.0, 4.5).unwrap().with_cutoff(cutoff).unwrap();
            vanishes_outside(law, pair);
            vanishes_outside(law.with_weight(SquareRoot).with_distribution(Normal), pair);
            vanishes_outside(law.with_weight(Power::new(0.01).unwrap()), pair);
            vanishes_outside(DpdConservative::new(25.0, cutoff).unwrap(), pair);
            vanishes_outside(DpdDissipative::new(4.5, SquareRoot, cutoff).unwrap(), pair);
            vanishes_outside(DpdRandom::new(4.5, SquareRoot, Uniform, cutoff).unwrap(), pair);
        }
    }

    #[test]
    fn law_whole_is_the_sum_of_its_parts(
        r in 0.0..1.6, speed in -5.0..5.0, key: u64, a in 0.0..100.0, gamma in 0.0..50.0, cutoff in 0.5..1.5,
        dt in 0.001..0.1, kt in 0.0..3.0,
    ) {
        let (pair, now) = (moving(r, speed, key), now(dt, kt));
        let whole = Dpd::new(a, gamma).unwrap().with_cutoff(cutoff).unwrap()
            .with_weight(SquareRoot).with_distribution(Normal);
        let parts = (
            DpdConservative::new(a, cutoff).unwrap(),
            DpdDissipative::new(gamma, SquareRoot, cutoff).unwrap(),
            DpdRandom::new(gamma, SquareRoot, Normal, cutoff).unwrap(),
        );
        prop_assert_eq!(whole.force(&pair, &now), parts.force(&pair, &now));
        prop_assert_eq!(whole.energy(&pair), parts.energy(&pair));
        prop_assert_eq!(whole.cutoff(), parts.cutoff());
        let sum = parts.0.force(&pair, &now).conservative
            + parts.1.force(&pair, &now).dissipative
            + parts.2.force(&pair, &now).random;
        prop_assert_eq!(whole.force(&pair, &now).total(), sum);
    }
}

fn reads<L: PairForce>(_: &L) -> [bool; 3] {
    let Reads {
        velocity,
        noise,
        species,
    } = L::READS;
    [velocity, noise, species]
}

#[test]
fn law_reads_are_exact() {
    let table = SpeciesMatrix::new(TABLE).unwrap();
    let whole = Dpd::new(25.0, 4.5).unwrap();
    let mixture = Dpd::new(table, 4.5).unwrap();
    let soft = DpdConservative::new(25.0, 1.0).unwrap();
    let soft_mixture = DpdConservative::new(table, 1.0).unwrap();
    let friction = DpdDissipative::new(4.5, Quadratic, 1.0).unwrap();
    let noise = DpdRandom::new(4.5, Quadratic, Uniform, 1.0).unwrap();

    // A column that is declared moves the force, one that is not does not.
    fn check(law: &impl PairForce, expected: [bool; 3]) {
        assert_eq!(reads(law), expected);
        let pair = moving(0.5, 1.0, 5);
        let changed = [
            Pair { rv: 0.1, ..pair },
            Pair {
                noise: moving(0.5, 1.0, 6).noise,
                ..pair
            },
            Pair {
                species: [1, 1],
                ..pair
            },
        ];
        for (pair_now, read) in changed.iter().zip(expected) {
            let moved = law.force(pair_now, &now(0.01, 1.0)) != law.force(&pair, &now(0.01, 1.0));
            assert_eq!(moved, read);
        }
    }
    check(&whole, [true, true, false]);
    check(&mixture, [true, true, true]);
    check(&soft, [false, false, false]);
    check(&soft_mixture, [false, false, true]);
    check(&friction, [true, false, false]);
    check(&noise, [false, true, false]);
}

#[test]
fn law_particles_can_be_exchanged() {
    let table = SpeciesMatrix::new(TABLE).unwrap();
    let forces = |order: [usize; 2]| {
        let positions = [DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.4, -0.1, 0.5)];
        let velocities = [DVec3::new(1.0, -2.0, 0.5), DVec3::new(0.3, 0.9, -1.1)];
        let particles = Particles::new(order.map(|k| positions[k]).to_vec())
            .and_then(|p| p.with_velocities(order.map(|k| velocities[k]).to_vec()))
            .and_then(|p| p.with_species(order.map(|k| [0, 1][k]).to_vec()))
            .and_then(|p| p.with_ids(order.map(|k| k as u32).to_vec()))
            .unwrap();
        let system = System::new(Open, particles, Clock::new(0.01, 1.0, 3).unwrap());
        let mut field = Pairwise::new(Dpd::new(table, 4.5).unwrap(), AllPairs::default());
        let mut forces = vec![DVec3::ZERO; 2];
        field
            .accumulate(&system.frame(), &mut forces, &mut ())
            .unwrap();
        order.map(|k| forces[k])
    };
    let (kept, exchanged) = (forces([0, 1]), forces([1, 0]));
    assert!(kept[0].length() > 1.0);
    assert_eq!(kept[0], -kept[1]);
    assert_eq!(kept, exchanged);
}

#[test]
fn law_table_is_looked_up_by_species() {
    let table = SpeciesMatrix::new(TABLE).unwrap();
    for (i, row) in TABLE.iter().enumerate() {
        for (j, &value) in row.iter().enumerate() {
            let pair = Pair {
                species: [i as u8, j as u8],
                ..at(0.5)
            };
            let law = Dpd::new(table, 0.0).unwrap();
            assert_eq!(0.5 * law.force(&pair, &Now::default()).total(), 0.5 * value);
            assert_eq!(law.energy(&pair), 0.125 * value);
        }
    }
}

/// Fedosov, Karniadakis and Caswell (2010), Table I: r_c = 2, a = 25, gamma = 4.5, sigma = 3, w_R = (1 - r/r_c)^0.25,
/// dt = 0.005. At r = 1 the weights are 2^-1/4 and 2^-1/2.
#[test]
fn reference_fedosov_melt() {
    let law = Dpd::new(25.0, 4.5)
        .and_then(|law| law.with_cutoff(2.0))
        .unwrap()
        .with_weight(SquareRoot);
    assert_eq!(law.sigma(1.0), 3.0);
    let pair = moving(1.0, 2.0, 1);
    let theta = pair.noise.uniform(Domain::DPD);
    let force = law.force(&pair, &now(0.005, 1.0));
    assert_relative_eq!(force.conservative, 12.5, max_relative = 1e-15);
    assert_relative_eq!(
        force.dissipative,
        -9.0 * std::f64::consts::FRAC_1_SQRT_2,
        max_relative = 1e-15
    );
    assert_relative_eq!(
        force.random / theta,
        3.0 * 0.840_896_415_253_714_5 * 200.0_f64.sqrt(),
        max_relative = 1e-14
    );
}

#[test]
fn extreme_no_friction_no_temperature() {
    let law = Dpd::new(0.0, 0.0).unwrap();
    let total = law.force(&moving(0.5, 1.0, 1), &now(0.01, 0.0)).total();
    assert_eq!(total, 0.0);
    assert_eq!(law.diffusivity_estimate(3.0, 1.0), f64::INFINITY);
    let cold = Dpd::new(0.0, 4.5).unwrap();
    assert_eq!(
        cold.force(&moving(0.5, 1.0, 1), &now(0.01, 0.0)).random,
        0.0
    );
}

#[test]
fn extreme_coincident_particles_stay_finite() {
    for gamma in [4.5, 1e30] {
        for separation in [0.0, 1e-320, 1e-160, 1e-100, 1e-20] {
            let particles = Particles::new(vec![DVec3::ZERO, separation * DVec3::X])
                .and_then(|p| p.with_velocities(vec![DVec3::X, -DVec3::X]))
                .unwrap();
            let system = System::new(Open, particles, Clock::new(0.01, 1.0, 3).unwrap());
            let law = Dpd::new(25.0, gamma).unwrap().with_weight(SquareRoot);
            let mut field = Pairwise::new(law, AllPairs::default());
            let mut forces = vec![DVec3::ZERO; 2];
            field
                .accumulate(&system.frame(), &mut forces, &mut ())
                .unwrap();
            let bound = if separation == 0.0 {
                0.0
            } else {
                25.0 + 2.0 * gamma + 20.0 * (2.0 * gamma).sqrt()
            };
            assert!(
                forces[0].length() <= bound,
                "{separation}: {:?} above {bound}",
                forces[0]
            );
        }
    }
    let whole = Dpd::new(25.0, 4.5).unwrap();
    assert_eq!(whole.energy(&at(0.0)), 12.5);
}

#[test]
fn extreme_parameters_are_refused() {
    let law = Dpd::new(25.0, 4.5).unwrap();
    assert_refused("a", &BELOW_ZERO, |a| Dpd::new(a, 4.5));
    assert_refused("gamma", &BELOW_ZERO, |gamma| Dpd::new(25.0, gamma));
    assert_refused("cutoff", &NO_LENGTH, |cutoff| law.with_cutoff(cutoff));
    assert_refused("a", &BELOW_ZERO, |a| DpdConservative::new(a, 1.0));
    assert_refused("cutoff", &NO_LENGTH, |rc| DpdConservative::new(25.0, rc));
    assert_refused("gamma", &BELOW_ZERO, |gamma| {
        DpdDissipative::new(gamma, Quadratic, 1.0)
    });
    assert_refused("cutoff", &NO_LENGTH, |rc| {
        DpdDissipative::new(4.5, Quadratic, rc)
    });
    assert_refused("gamma", &BELOW_ZERO, |gamma| {
        DpdRandom::new(gamma, Quadratic, Uniform, 1.0)
    });
    assert_refused("cutoff", &NO_LENGTH, |rc| {
        DpdRandom::new(4.5, Quadratic, Uniform, rc)
    });
    assert_refused("s", &NOT_POSITIVE, Power::new);
}

#[test]
fn extreme_tables_that_are_none() {
    let entry = SpeciesMatrix::new([[1.0, -2.0], [-2.0, 1.0]]).unwrap_err();
    assert!(matches!(entry, SpeciesError::Entry { i: 0, j: 1, .. }));
    assert!(entry.to_string().contains("-2"), "{entry}");
    let nan = SpeciesMatrix::new([[1.0, 2.0], [2.0, f64::NAN]]).unwrap_err();
    assert!(matches!(nan, SpeciesError::Entry { i: 1, j: 1, .. }));
    assert_eq!(
        SpeciesMatrix::new([[1.0, 2.0], [3.0, 1.0]]).unwrap_err(),
        SpeciesError::Asymmetric {
            i: 0,
            j: 1,
            value: 2.0,
            mirrored: 3.0
        }
    );
}

#[test]
fn extreme_species_that_are_not_listed() {
    let table = SpeciesMatrix::new(TABLE).unwrap();
    assert_eq!(table.covers(&[]), Ok(()));
    assert_eq!(table.covers(&[0, 2, 1]), Ok(()));
    assert_eq!(
        table.covers(&[0, 2, 3, 255]).unwrap_err(),
        SpeciesError::Unlisted {
            particle: 2,
            species: 3,
            listed: 3
        }
    );
    for species in [[3, 0], [0, 3], [255, 255], [2, 255]] {
        assert!(table.between(species).is_nan(), "{species:?}");
    }
}
