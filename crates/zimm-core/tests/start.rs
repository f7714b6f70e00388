//! Initial states: uniform in any cell, spread out, thermal, isotropic.

#![allow(clippy::unwrap_used)]

use zimm_core::{DMat3, DVec3, Lattice, Molecules, ParameterError, Particles, start};

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

#[test]
fn law_molecules_follow_each_other() {
    let molecules = Molecules::linear(5, 3, 2).unwrap();
    assert!(molecules.iter().eq([5..7, 7..9, 9..11]));
    assert_eq!(molecules.iter().len(), 3);
    assert_eq!(molecules.bonds(), [[5, 6], [7, 8], [9, 10]]);
    assert!(Molecules::linear(0, 4, 1).unwrap().bonds().is_empty());
    assert_eq!(Molecules::linear(9, 0, 5).unwrap().iter().len(), 0);
}

#[test]
fn extreme_molecules_without_beads_or_names_are_refused() {
    let most = 1 << 31;
    assert_eq!(Molecules::linear(0, 3, 0).unwrap_err().name, "beads");
    assert!(Molecules::linear(most - 6, 2, 3).is_ok());
    let error = Molecules::linear(most - 5, 2, 3).unwrap_err();
    assert_eq!(
        (error.name, error.found),
        ("last identity", f64::from(most))
    );
    assert!(Molecules::linear(u32::MAX, u32::MAX, u32::MAX).is_err());
}
