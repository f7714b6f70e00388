//! Initial states: uniform in any cell, spread out, thermal, isotropic, molecules in equilibrium.

#![allow(clippy::unwrap_used)]

mod common;

use common::Cell;
use zimm_core::{
    AllPairs, BondForce, Bonded, Central, Clock, DMat3, DVec3, ForceField, Lattice, Molecules, Now,
    Pair, PairForce, Pairwise, ParameterError, Particles, StepError, System, start,
};

/// Mean and its distance from the expectation in standard errors of independent samples.
fn sigmas(samples: &[f64], expected: f64, variance: f64) -> f64 {
    let n = samples.len() as f64;
    (samples.iter().sum::<f64>() / n - expected) / (variance / n).sqrt()
}

fn tilted() -> Lattice {
    let basis = [
        DVec3::new(5.0, 0.0, 0.0),
        DVec3::new(2.0, 4.0, 0.0),
        DVec3::new(-1.0, 1.5, 6.0),
    ];
    Lattice::new(DMat3::from_cols(basis[0], basis[1], basis[2])).unwrap()
}

/// Fractional coordinates are uniform over -1/2..1/2: mean 0, variance 1/12, variance of the square 1/180. 100 000
/// positions, seed 1, five sigma: a density that tilts by 2 % across the cell is caught.
#[test]
fn reference_uniform_positions_fill_the_cell_evenly() {
    let lattice = tilted();
    let positions = start::uniform(&lattice, 100_000, &mut start::stream(1));
    let fractions: Vec<DVec3> = positions.iter().map(|&r| lattice.inverse() * r).collect();
    for axis in 0..3 {
        let along: Vec<f64> = fractions.iter().map(|s| s[axis]).collect();
        let squares: Vec<f64> = along.iter().map(|s| s * s).collect();
        let crossed: Vec<f64> = fractions
            .iter()
            .map(|s| s[axis] * s[(axis + 1) % 3])
            .collect();
        assert!(along.iter().all(|s| s.abs() <= 0.5 + 1e-12));
        assert!(sigmas(&along, 0.0, 1.0 / 12.0).abs() < 5.0);
        assert!(sigmas(&squares, 1.0 / 12.0, 1.0 / 180.0).abs() < 5.0);
        assert!(sigmas(&crossed, 0.0, 1.0 / 144.0).abs() < 5.0);
    }
}

fn least_distance(lattice: &Lattice, positions: &[DVec3]) -> f64 {
    let mut least = f64::INFINITY;
    for (k, &r) in positions.iter().enumerate() {
        for &other in &positions[..k] {
            least = least.min(lattice.nearest(r - other).length());
        }
    }
    least
}

#[test]
fn limit_a_cube_number_in_a_cube_is_simple_cubic() {
    let lattice = Lattice::brick(DVec3::splat(7.0)).unwrap();
    let positions = start::grid(&lattice, 343);
    assert_eq!(positions.len(), 343);
    assert!((least_distance(&lattice, &positions) - 1.0).abs() < 1e-12);
    let sum: DVec3 = positions.iter().sum();
    assert!(sum.length() < 1e-10);
}

/// A brick of edges 2, 4, 8 divides into 4 x 8 x 16 cubes of edge 1/2.
#[test]
fn limit_a_brick_is_cut_into_cubes() {
    let lattice = Lattice::brick(DVec3::new(2.0, 4.0, 8.0)).unwrap();
    let positions = start::grid(&lattice, 512);
    assert!((least_distance(&lattice, &positions) - 0.5).abs() < 1e-12);
}

/// Any number in any cell: everybody inside, and nobody closer than six tenths of the mean spacing.
#[test]
fn law_a_grid_keeps_particles_apart() {
    for lattice in [tilted(), Lattice::brick(DVec3::new(6.0, 6.0, 6.0)).unwrap()] {
        for count in [0, 1, 2, 3, 7, 100, 126, 217, 513] {
            let positions = start::grid(&lattice, count);
            assert_eq!(positions.len(), count);
            let spacing = (lattice.volume() / count as f64).cbrt();
            assert!(
                least_distance(&lattice, &positions) >= 0.6 * spacing,
                "{count}"
            );
            let inside = |r: &DVec3| (lattice.inverse() * *r).abs().max_element() < 0.5;
            assert!(positions.iter().all(inside));
        }
    }
}

/// Two species of masses 1 and 4 at kt = 1.7, 50 000 particles, seed 2. m c^2 / kt of one component has mean
/// 1 - m / M and variance 2, its square mean 3 and variance 96; the bound of five sigma is a temperature wrong by 2 %.
#[test]
fn reference_velocities_are_thermal_and_momentum_is_zero() {
    let (n, kt) = (50_000, 1.7);
    let masses: Vec<f64> = (0..n).map(|k| if k % 2 == 0 { 1.0 } else { 4.0 }).collect();
    let particles = Particles::new(vec![DVec3::ZERO; n]).unwrap();
    let particles = particles.with_masses(masses.clone()).unwrap();
    let velocities = start::velocities(&particles, kt, &mut start::stream(2)).unwrap();
    let momentum: DVec3 = velocities.iter().zip(&masses).map(|(&c, &m)| m * c).sum();
    assert!(momentum.length() < 1e-9);
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        for species in 0..2 {
            let scaled: Vec<f64> = (species..n)
                .step_by(2)
                .map(|k| velocities[k].dot(axis) * (masses[k] / kt).sqrt())
                .collect();
            let squares: Vec<f64> = scaled.iter().map(|x| x * x).collect();
            let fourths: Vec<f64> = scaled.iter().map(|x| x.powi(4)).collect();
            assert!(sigmas(&scaled, 0.0, 1.0).abs() < 5.0);
            assert!(sigmas(&squares, 1.0, 2.0).abs() < 5.0);
            assert!(sigmas(&fourths, 3.0, 96.0).abs() < 5.0);
        }
    }
}

/// Removing the motion of the centre of mass takes away three of the 3 N degrees of freedom, no more: with N = 4 the
/// mean of the kinetic energy is 3/2 (N - 1) kt = 4.5 kt with variance 4.5. 20 000 systems, seed 3, five sigma: 1.7 %.
#[test]
fn reference_kinetic_energy_has_lost_three_degrees_of_freedom() {
    let mut rng = start::stream(3);
    let particles = Particles::new(vec![DVec3::ZERO; 4]).unwrap();
    let particles = particles.with_masses(vec![1.0, 2.0, 3.0, 10.0]).unwrap();
    let energies: Vec<f64> = (0..20_000)
        .map(|_| {
            let velocities = start::velocities(&particles, 1.0, &mut rng).unwrap();
            let energy = |(k, c): (usize, &DVec3)| 0.5 * particles.mass(k) * c.length_squared();
            velocities.iter().enumerate().map(energy).sum()
        })
        .collect();
    assert!(sigmas(&energies, 4.5, 4.5).abs() < 5.0);
}

#[test]
fn extreme_velocities_of_nobody_of_one_and_at_no_temperature() {
    let mut rng = start::stream(4);
    let particles = |n| Particles::new(vec![DVec3::ZERO; n]).unwrap();
    let velocities = |n, kt, rng: &mut _| start::velocities(&particles(n), kt, rng);
    assert_eq!(velocities(0, 1.0, &mut rng), Ok(vec![]));
    assert_eq!(velocities(1, 1.0, &mut rng), Ok(vec![DVec3::ZERO]));
    assert_eq!(velocities(3, 0.0, &mut rng), Ok(vec![DVec3::ZERO; 3]));
    let error = ParameterError::new("kt", -1.0, "finite and not below zero");
    assert_eq!(velocities(3, -1.0, &mut rng), Err(error));
}

/// 10 000 trimers with bonds of length 0.8, seed 5. A component of an isotropic unit vector has mean 0, variance 1/3,
/// and its square variance 4/45; bonds are independent, so <u1.u2> is 0 with variance 1/3. Five sigma: 1.5 % in each.
#[test]
fn reference_bonds_are_isotropic_and_independent() {
    let lattice = tilted();
    let molecules = Molecules::linear(0, 10_000, 3).unwrap();
    let positions = start::chains(&lattice, &molecules, |_| 0.8, &mut start::stream(5));
    assert_eq!(positions.len(), 30_000);
    let bond = |[i, j]: [u32; 2]| (positions[j as usize] - positions[i as usize]) / 0.8;
    let bonds: Vec<DVec3> = molecules.bonds().into_iter().map(bond).collect();
    assert!(bonds.iter().all(|u| (u.length() - 1.0).abs() < 1e-12));
    for axis in 0..3 {
        let along: Vec<f64> = bonds.iter().map(|u| u[axis]).collect();
        let squares: Vec<f64> = along.iter().map(|u| u * u).collect();
        assert!(sigmas(&along, 0.0, 1.0 / 3.0).abs() < 5.0);
        assert!(sigmas(&squares, 1.0 / 3.0, 4.0 / 45.0).abs() < 5.0);
    }
    let turns: Vec<f64> = bonds.chunks(2).map(|pair| pair[0].dot(pair[1])).collect();
    assert!(sigmas(&turns, 0.0, 1.0 / 3.0).abs() < 5.0);
}

#[test]
fn law_bond_lengths_are_the_callers() {
    let lattice = tilted();
    let molecules = Molecules::linear(0, 3, 4).unwrap();
    let mut length = 0.0;
    let growing = |_: &mut _| {
        length += 0.1;
        length
    };
    let positions = start::chains(&lattice, &molecules, growing, &mut start::stream(6));
    for (k, [i, j]) in molecules.bonds().into_iter().enumerate() {
        let found = (positions[j as usize] - positions[i as usize]).length();
        assert!((found - 0.1 * (k + 1) as f64).abs() < 1e-12);
    }
}

#[test]
fn law_the_same_stream_gives_the_same_state() {
    let draw = |seed| start::uniform(&tilted(), 10, &mut start::stream(seed));
    assert_eq!(draw(7), draw(7));
    assert_ne!(draw(7), draw(8));
}

/// U = H (Q - l)^2 / 2: Hooke's spring if l = 0, Fraenkel's if not.
struct Linear {
    stiffness: f64,
    natural: f64,
}

impl BondForce for Linear {
    fn force(&self, _: f64) -> f64 {
        0.0
    }

    fn energy(&self, r2: f64) -> f64 {
        0.5 * self.stiffness * (r2.sqrt() - self.natural).powi(2)
    }
}

const HOOKE: Linear = Linear {
    stiffness: 1.0,
    natural: 0.0,
};

/// U = -(b / 2) ln(1 - Q^2 / b), in units of kT and (kT / H)^1/2.
struct Fene(f64);

impl BondForce for Fene {
    fn force(&self, r2: f64) -> f64 {
        -1.0 / (1.0 - r2 / self.0)
    }

    fn energy(&self, r2: f64) -> f64 {
        -0.5 * self.0 * (-r2.min(self.0) / self.0).ln_1p()
    }

    fn limit(&self) -> f64 {
        self.0.sqrt()
    }
}

/// Marko and Siggia's law of stiffness 1 and this contour length.
struct Worm(f64);

impl BondForce for Worm {
    fn force(&self, _: f64) -> f64 {
        0.0
    }

    fn energy(&self, r2: f64) -> f64 {
        r2 / 6.0 * (2.0 + 1.0 / (1.0 - (r2.sqrt() / self.0).min(1.0)))
    }

    fn limit(&self) -> f64 {
        self.0
    }
}

/// The integral of f over 0..1 by midpoints, after p = t^2 (3 - 2 t), which takes the edge off both ends.
fn over_fractions(f: impl Fn(f64) -> f64) -> f64 {
    let n = 40_000;
    let term = |k: usize| {
        let t = (k as f64 + 0.5) / n as f64;
        6.0 * t * (1.0 - t) * f(t * t * (3.0 - 2.0 * t))
    };
    (0..n).map(term).sum::<f64>() / n as f64
}

fn moment(bond: &start::BondLength, power: i32) -> f64 {
    over_fractions(|p| bond.quantile(p).powi(power))
}

fn assert_near(found: f64, expected: f64, relative: f64) {
    let off = (found / expected - 1.0).abs();
    assert!(off < relative, "{found} against {expected}: {off:e}");
}

/// Q^2 / b follows Beta(3/2, b/2 + 1), so <Q^2> = 3 b / (b + 5) and <Q^4> = 15 b^2 / ((b + 5) (b + 7)); numbers of 25
/// digits for <Q> and <Q^6> at b = 5, 10, 50 and 1000. No noise: the table's whole quantile function is integrated.
#[test]
fn reference_fene_bonds_follow_the_beta_law() {
    for b in [1.1, 2.0, 5.0, 10.0, 50.0, 1e3, 1e6] {
        let bond = start::BondLength::new(&Fene(b), 1.0).unwrap();
        // Below b = 2 the density ends steeply.
        let tolerance = if b < 2.0 { 2e-6 } else { 1e-7 };
        assert_near(moment(&bond, 2), 3.0 * b / (b + 5.0), tolerance);
        let fourth = 15.0 * b * b / ((b + 5.0) * (b + 7.0));
        assert_near(moment(&bond, 4), fourth, 5.0 * tolerance);
        assert!(bond.quantile(1.0) <= b.sqrt());
    }
    for (b, mean, sixth) in [
        (5.0, 1.156_896_578_506_649_7, 7.8125),
        (10.0, 1.324_821_402_551_01, 21.671_826_625_387),
        (50.0, 1.528_437_454_862_11, 70.959_370_691_752_5),
        (1000.0, 1.592_190_615_067_814_7, 102.825_919_200_185_92),
    ] {
        let bond = start::BondLength::new(&Fene(b), 1.0).unwrap();
        assert_near(moment(&bond, 1), mean, 1e-7);
        assert_near(moment(&bond, 6), sixth, 2e-6);
    }
}

/// <Q^2> = 3 kT / H and <Q^4> = 15 (kT / H)^2 at any scale; with a natural length l and s = kT / H,
/// <Q> = l (l^2 + 3 s) / (l^2 + s), <Q^2> = (l^4 + 6 l^2 s + 3 s^2) / (l^2 + s) and <(Q - l)^2> =
/// s (l^2 + 3 s) / (l^2 + s) if s is far below l^2.
#[test]
fn limit_bonds_of_linear_springs_at_any_scale() {
    for (stiffness, kt) in [(1.0, 1.0), (1e30, 2.0), (3e-40, 1e-5)] {
        let natural = 0.0;
        let spring = Linear { stiffness, natural };
        let bond = start::BondLength::new(&spring, kt).unwrap();
        let s: f64 = kt / stiffness;
        assert_near(moment(&bond, 2), 3.0 * s, 1e-7);
        assert_near(moment(&bond, 4), 15.0 * s * s, 5e-7);
    }
    for (stiffness, l) in [(100.0, 1.0), (1e6, 1.0), (1e12, 1.0), (1e-3, 1e6)] {
        let natural = l;
        let spring = Linear { stiffness, natural };
        let bond = start::BondLength::new(&spring, 1.0).unwrap();
        let (l2, s) = (l * l, 1.0 / stiffness);
        assert_near(moment(&bond, 1), l * (l2 + 3.0 * s) / (l2 + s), 2e-7);
        let second = (l2 * l2 + 6.0 * l2 * s + 3.0 * s * s) / (l2 + s);
        assert_near(moment(&bond, 2), second, 2e-7);
        let variance = over_fractions(|p| (bond.quantile(p) - l).powi(2));
        let exact = s * (l2 + 3.0 * s) / (l2 + s);
        assert_near(variance, exact, 1e-5);
    }
}

/// Up to the quantile of a fraction Simpson's rule finds that fraction.
#[test]
fn law_quantiles_invert_the_cumulative_distribution() {
    fn check(spring: &impl BondForce, kt: f64, longest: f64) {
        let density = |r: f64| r * r * (-spring.energy(r * r) / kt).exp();
        let mass = |to: f64| {
            let n = 100_000;
            let h = to / f64::from(n);
            let weight = |k| f64::from(if k % 2 == 1 { 4 } else { 2 });
            let inner: f64 = (1..n).map(|k| weight(k) * density(f64::from(k) * h)).sum();
            (inner + density(to)) * h / 3.0
        };
        let bond = start::BondLength::new(spring, kt).unwrap();
        let whole = mass(longest);
        for p in [1e-6, 1e-3, 0.1, 0.3, 0.5, 0.7, 0.9, 0.999] {
            assert!((mass(bond.quantile(p)) / whole - p).abs() < 1e-7);
        }
    }
    check(&Worm(3.0), 1.0, 3.0);
    check(&Worm(3.0), 0.3, 3.0);
    check(&Worm(0.5), 1.0, 0.5);
    check(&Fene(10.0), 1.0, 10_f64.sqrt());
    check(&HOOKE, 0.5, 6.0);
    check(&(Fene(20.0), HOOKE), 1.0, 20_f64.sqrt());
    // Two wells of which the inner one is hardly visited.
    check(&DoubleWell, 0.2, 4.0);
}

/// U = (Q^2 - 1)^2 (Q^2 - 4)^2 / 20: wells at 1 and 2.
struct DoubleWell;

impl BondForce for DoubleWell {
    fn force(&self, _: f64) -> f64 {
        0.0
    }

    fn energy(&self, r2: f64) -> f64 {
        ((r2 - 1.0) * (r2 - 4.0)).powi(2) / 20.0
    }
}

#[test]
fn extreme_springs_without_a_distribution_are_refused() {
    let name = |error: ParameterError| error.name;
    for kt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(
            start::BondLength::new(&HOOKE, kt).map_err(name).err(),
            Some("kt")
        );
    }
    // No spring holds nothing together.
    assert_eq!(
        start::BondLength::new(&(), 1.0).map_err(name).err(),
        Some("longest bond")
    );
    for limit in [0.0, -4.0, f64::NAN] {
        assert_eq!(
            start::BondLength::new(&Worm(limit), 1.0)
                .map_err(name)
                .err(),
            Some("limit of the spring")
        );
    }
    let (stiffness, natural) = (f64::NAN, 0.0);
    let nowhere = start::BondLength::new(&Linear { stiffness, natural }, 1.0);
    assert_eq!(
        nowhere.map_err(name).err(),
        Some("greatest logarithm of the density")
    );
    // A rod, to the last bit.
    let (stiffness, natural) = (1e40, 1.0);
    let rod = start::BondLength::new(&Linear { stiffness, natural }, 1.0).unwrap();
    assert!((rod.quantile(0.1) - 1.0).abs() < 1e-14 && (rod.quantile(0.9) - 1.0).abs() < 1e-14);
    for p in [-1.0, 2.0] {
        assert!(start::BondLength::new(&Fene(5.0), 1.0).unwrap().quantile(p) <= 5_f64.sqrt());
    }
}

/// The mean and its standard error of independent samples, checked against an expectation within five of them; the
/// standard error must be below `resolved` of the expectation.
fn assert_mean(samples: &[f64], expected: f64, resolved: f64) {
    let n = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / n;
    let variance = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let error = (variance / n).sqrt();
    assert!(
        error < resolved * expected,
        "not resolved: {mean} +- {error}"
    );
    assert!(
        (mean - expected).abs() < 5.0 * error,
        "{mean} +- {error} against {expected}"
    );
}

/// <Q^2> and <Q^4> of FENE bonds of b = 50, 200 000 samples, seed 11, five standard errors of 0.16 and 0.3 %: what is
/// drawn is what is tabulated, and a law wrong by 2 % is caught.
#[test]
fn reference_drawn_bonds_have_the_moments_of_their_law() {
    let bond = start::BondLength::new(&Fene(50.0), 1.0).unwrap();
    let mut rng = start::stream(11);
    let squares: Vec<f64> = (0..200_000)
        .map(|_| bond.sample(&mut rng).powi(2))
        .collect();
    assert_mean(&squares, 150.0 / 55.0, 0.002);
    let fourths: Vec<f64> = squares.iter().map(|q2| q2 * q2).collect();
    assert_mean(&fourths, 11.961_722_488_038_278, 0.004);
}

/// `count` molecules of Hookean bonds of <Q^2> = 3, each a slice.
fn gaussian(molecules: &Molecules, seed: u64) -> Vec<DVec3> {
    let bond = start::BondLength::new(&HOOKE, 1.0).unwrap();
    start::isolated(molecules, |rng| bond.sample(rng), &mut start::stream(seed))
}

fn of_each(
    molecules: &Molecules,
    positions: &[DVec3],
    measure: impl Fn(&[DVec3]) -> f64,
) -> Vec<f64> {
    let beads = molecules.beads() as usize;
    positions.chunks(beads).map(measure).collect()
}

/// The mean square distance from the mean position, which is the origin.
fn squared_radius(molecule: &[DVec3]) -> f64 {
    let centre: DVec3 = molecule.iter().sum();
    assert!(centre.length() < 1e-11);
    molecule.iter().map(|r| r.length_squared()).sum::<f64>() / molecule.len() as f64
}

/// <R_e^2> = 3 (N - 1) and <R_g^2> = (N^2 - 1) / (2 N). 40 000 chains of N = 2 and 10, seed 12, five standard errors of
/// 0.4 and 0.25 %: one bond too many or too few, or a bond wrong by 2 %, is caught.
#[test]
fn limit_sizes_of_gaussian_chains() {
    for beads in [2, 10] {
        let chains = Molecules::linear(0, 40_000, beads).unwrap();
        let (positions, n) = (gaussian(&chains, 12), f64::from(beads));
        let ends = |r: &[DVec3]| (r[r.len() - 1] - r[0]).length_squared();
        assert_mean(&of_each(&chains, &positions, ends), 3.0 * (n - 1.0), 0.005);
        let radii = of_each(&chains, &positions, squared_radius);
        assert_mean(&radii, (n * n - 1.0) / (2.0 * n), 0.005);
    }
}

/// A Brownian bridge: the beads n and m of a ring of N are 3 k (N - k) / N apart in mean square, k = |n - m|, the same
/// for all pairs, and <R_g^2> = (N^2 - 1) / (4 N). 20 000 rings, seed 13, standard errors of 0.6 and 0.4 %, five of
/// them; an open walk or one that closes with a long last bond is off by tens of per cent.
#[test]
fn limit_gaussian_rings_are_brownian_bridges() {
    for beads in [3_usize, 10] {
        let rings = Molecules::ring(0, 20_000, beads as u32).unwrap();
        let (positions, n) = (gaussian(&rings, 13), beads as f64);
        for from in 0..beads {
            for k in [1, 2, beads / 2] {
                let apart = |r: &[DVec3]| (r[(from + k) % beads] - r[from]).length_squared();
                let exact = 3.0 * k as f64 * (n - k as f64) / n;
                assert_mean(&of_each(&rings, &positions, apart), exact, 0.01);
            }
        }
        let radii = of_each(&rings, &positions, squared_radius);
        assert_mean(&radii, (n * n - 1.0) / (4.0 * n), 0.005);
    }
}

/// Stars of f arms of m beads and a centre, N = f m + 1: cutting the k-th bond from outside leaves k beads, so by
/// Kramers' theorem, <R_g^2> = 3 / N^2 sum over bonds of k (N - k) = 3 (f / N^2) (N m (m + 1) / 2 - m (m + 1) (2 m + 1)
/// / 6), which tends to Zimm and Stockmayer's (3 f - 2) / f^2 of the linear chain (J. Chem. Phys. 17, 1301, 1949).
/// Combs by the same theorem. 20 000 of each, seed 14, standard errors of 0.35 %, five of them.
#[test]
fn limit_sizes_of_gaussian_stars_and_combs() {
    let star = |f: f64, m: f64| {
        let n = f * m + 1.0;
        3.0 * f / (n * n) * m * (m + 1.0) * (n / 2.0 - (2.0 * m + 1.0) / 6.0)
    };
    let ratio = star(5.0, 1e6) / (0.5 * 5e6);
    assert!((ratio - 13.0 / 25.0).abs() < 1e-5);
    for (arms, length) in [(1, 3), (3, 4), (6, 2)] {
        let stars = Molecules::star(0, 20_000, arms, length).unwrap();
        let radii = of_each(&stars, &gaussian(&stars, 14), squared_radius);
        assert_mean(&radii, star(f64::from(arms), f64::from(length)), 0.005);
    }
    // Teeth of 2 on beads 1, 4 and 7 of 9: 15 beads. Beads on one side of each bond of the backbone: 1, 4, 5, 6, 9, 10,
    // 11, 14; of each tooth: 2, 1.
    let combs = Molecules::comb(0, 20_000, 9, 3, 2).unwrap();
    let sides = [1, 4, 5, 6, 9, 10, 11, 14, 2, 1, 2, 1, 2, 1];
    let sum: f64 = sides.iter().map(|k| f64::from(k * (15 - k))).sum();
    let radii = of_each(&combs, &gaussian(&combs, 15), squared_radius);
    assert_mean(&radii, 3.0 / 225.0 * sum, 0.005);
}

/// S(k) = (1/N) |sum exp(i k.r)|^2 of discrete Gaussian chains is (1/N) sum_ij exp(-k^2 |i - j| / 2): numbers for N = 10
/// and 20. 40 000 chains with three directions of k each, seed 16, standard errors of at most 0.6 %, five of them.
#[test]
fn reference_structure_factor_of_gaussian_chains() {
    let numbers = [
        (10, [9.837042, 6.899972, 3.304728, 1.276832]),
        (20, [19.351298, 10.153815, 3.691236, 1.294934]),
    ];
    for (beads, expected) in numbers {
        let chains = Molecules::linear(0, 40_000, beads).unwrap();
        let positions = gaussian(&chains, 16);
        for (k, exact) in [0.1, 0.5, 1.0, 2.0].into_iter().zip(expected) {
            let factor = |molecule: &[DVec3]| {
                let (mut cosines, mut sines) = (DVec3::ZERO, DVec3::ZERO);
                for r in molecule {
                    let phase = k * *r;
                    cosines += DVec3::new(phase.x.cos(), phase.y.cos(), phase.z.cos());
                    sines += DVec3::new(phase.x.sin(), phase.y.sin(), phase.z.sin());
                }
                (cosines.length_squared() + sines.length_squared()) / f64::from(3 * beads)
            };
            let factors = of_each(&chains, &positions, factor);
            assert_mean(&factors, exact, 0.006);
        }
    }
}

/// Every bond has the length that was drawn for it, also those that branch; in a cell as in open space.
#[test]
fn law_stars_and_combs_grow_along_their_bonds() {
    let star = Molecules::star(0, 3, 4, 3).unwrap();
    let comb = Molecules::comb(0, 3, 7, 2, 2).unwrap();
    for molecules in [star, comb] {
        let mut rng = start::stream(17);
        for positions in [
            start::chains(&tilted(), &molecules, |_| 0.8, &mut rng),
            start::isolated(&molecules, |_| 0.8, &mut rng),
        ] {
            assert_eq!(positions.len(), molecules.identities().len());
            for [i, j] in molecules.bonds() {
                let bond = positions[j as usize] - positions[i as usize];
                assert!((bond.length() - 0.8).abs() < 1e-12);
            }
        }
    }
    assert!(
        start::isolated(
            &Molecules::ring(0, 0, 3).unwrap(),
            |_| 0.8,
            &mut start::stream(1)
        )
        .is_empty()
    );
}

#[test]
fn law_stretched_molecules_lie_along_their_bonds() {
    let (lattice, bond) = (tilted(), DVec3::new(1.5, -0.5, 0.25));
    let straight = |molecules: Molecules| {
        let beads = start::stretched(&lattice, &molecules, bond, &mut start::stream(3));
        assert_eq!(beads.len(), molecules.identities().len());
        let span = |[i, j]: [u32; 2]| beads[j as usize] - beads[i as usize];
        molecules.bonds().into_iter().map(span).collect::<Vec<_>>()
    };
    for molecules in [
        Molecules::linear(0, 3, 20).unwrap(),
        Molecules::star(0, 2, 3, 4).unwrap(),
        Molecules::comb(0, 2, 9, 3, 2).unwrap(),
    ] {
        let spans = straight(molecules);
        assert!(spans.iter().all(|span| span.abs_diff_eq(bond, 1e-12)));
    }
    // Out and back; the two beads farthest from the first lie upon each other if their number is odd.
    for beads in [6, 7] {
        let spans = straight(Molecules::ring(0, 1, beads).unwrap());
        let factors: Vec<f64> = spans.iter().map(|span| (span.x / bond.x).round()).collect();
        let expected = if beads == 6 {
            vec![1.0, 1.0, 1.0, -1.0, -1.0, -1.0]
        } else {
            vec![1.0, 1.0, 1.0, 0.0, -1.0, -1.0, -1.0]
        };
        assert_eq!(factors, expected);
    }
    assert_eq!(straight(Molecules::linear(0, 4, 1).unwrap()), []);
}

/// The first positions stay, the others are uniform: the fourth of 20 000 fractions in a quarter of the cell has a
/// standard error of 0.31 % of all, bound of 4. Seed 5.
#[test]
fn law_a_cell_is_filled_up_to_its_density() {
    let lattice = tilted();
    let fill = |given, density| {
        start::fill(
            &lattice,
            vec![DVec3::splat(9.0); given],
            density,
            &mut start::stream(5),
        )
    };
    let filled = fill(100, 20_100.0 / lattice.volume()).unwrap();
    assert_eq!(filled.len(), 20_100);
    assert!(filled[..100].iter().all(|&r| r == DVec3::splat(9.0)));
    let quarter = filled[100..]
        .iter()
        .filter(|&&r| (lattice.inverse() * r).y < -0.25);
    let share = quarter.count() as f64 / 20_000.0;
    assert!((share - 0.25).abs() < 4.0 * 0.0031);
    assert_eq!(fill(100, 100.0 / lattice.volume()).unwrap().len(), 100);
    for (given, density) in [(100, 0.5), (0, 0.0), (0, -1.0), (0, f64::NAN), (0, 1e30)] {
        assert!(fill(given, density).is_err(), "{given} at {density}");
    }
}

/// F = 1e-3 r^-13 below 1.
struct Hard;

impl PairForce for Hard {
    fn cutoff(&self) -> f64 {
        1.0
    }

    fn force(&self, pair: &Pair, _: &Now) -> Central {
        Central::conservative(1e-3 * pair.r2.powi(-7))
    }
}

/// 15 chains of 10 beads whose bonds are all at 0.95 of their limit, at random in a cell with 250 hard particles: forces
/// up to 1e20 and more, some 20 afterwards, and no bond broken. A
/// move without a cap ends 1e15 away.
#[test]
fn extreme_overlaps_part_and_bonds_hold() {
    let edge = 256_f64.cbrt();
    let lattice = Lattice::brick(DVec3::splat(edge)).unwrap();
    let molecules = Molecules::linear(0, 15, 10).unwrap();
    let mut rng = start::stream(11);
    let positions = start::chains(&lattice, &molecules, |_| 1.9, &mut rng);
    let positions = start::fill(&lattice, positions, 400.0 / 256.0, &mut rng).unwrap();
    let cell = Cell::at_rest(DMat3::from_diagonal(DVec3::splat(edge)));
    let particles = Particles::new(positions).unwrap().counting_images();
    let mut system = System::new(cell, particles, Clock::new(0.005, 1.0, 1).unwrap());
    let springs = Bonded::new(Fene(4.0), molecules.bonds());
    let mut field = (Pairwise::new(Hard, AllPairs::default()), springs);
    let strongest = |system: &System<Cell<false>>,
                     field: &mut (Pairwise<Hard, _>, Bonded<Fene>)| {
        let mut forces = vec![DVec3::ZERO; system.particles.len()];
        let accepted = field.accumulate(&system.frame(), &mut forces, &mut ());
        accepted.unwrap();
        forces.iter().map(|f| f.length()).fold(0.0, f64::max)
    };
    let before = strongest(&system, &mut field);
    start::relax(&mut system, &mut field, 0.03, 150).unwrap();
    let after = strongest(&system, &mut field);
    println!("strongest force {before:.1e}, then {after:.1e}");
    assert!(before > 1e10 && after < 1e3);
}

/// One iteration is a step from rest, cut at `farthest`; nothing else changes.
#[test]
fn law_one_iteration_is_a_step_from_rest() {
    let cell = || Cell::at_rest(DMat3::from_diagonal(DVec3::splat(4.0)));
    let scene = |apart: f64| {
        let particles = Particles::new(vec![DVec3::ZERO, apart * DVec3::X])
            .unwrap()
            .with_velocities(vec![DVec3::Y, DVec3::Z])
            .unwrap()
            .with_masses(vec![1.0, 2.0])
            .unwrap();
        System::new(cell(), particles, Clock::new(0.1, 1.0, 1).unwrap())
    };
    let field = || Pairwise::new(Hard, AllPairs::default());
    let mut system = scene(0.5);
    start::relax(&mut system, &mut field(), 1.0, 1).unwrap();
    // F = 8.192, dt^2 / 2 = 0.005.
    let positions = system.particles.positions();
    assert!((positions[0].x + 0.04096).abs() < 1e-15 && (positions[1].x - 0.52048).abs() < 1e-15);
    assert_eq!(system.particles.velocities(), [DVec3::Y, DVec3::Z]);
    assert_eq!(system.clock.now().step, 0);
    let mut system = scene(0.5);
    start::relax(&mut system, &mut field(), 0.01, 1).unwrap();
    let positions = system.particles.positions();
    assert!((positions[0].x + 0.01).abs() < 1e-15 && (positions[1].x - 0.51).abs() < 1e-15);

    let refused = start::relax(&mut scene(0.5), &mut field(), f64::NAN, 1);
    assert!(matches!(refused, Err(StepError::Parameter { step: 0, .. })));
    let refused = start::relax(&mut scene(1e-60), &mut field(), 0.1, 1);
    assert!(matches!(
        refused,
        Err(StepError::NotFinite { particle: 0, .. })
    ));
    let mut broken = Bonded::new(Fene(0.16), vec![[0, 1]]);
    let refused = start::relax(&mut scene(0.5), &mut broken, 0.1, 1);
    assert!(matches!(refused, Err(StepError::Force { step: 0, .. })));
}
