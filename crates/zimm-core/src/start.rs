//! Initial states: where particles are and how they move before anything has happened.
//!
//! These numbers are drawn in sequence from a generator of the caller's, [`stream`] or any other; nothing here is
//! addressed as the [`noise`](crate::noise) of a run is.
//!
//! ```
//! use zimm_core::{DVec3, Lattice, Molecules, Particles, start};
//!
//! // 100 dumbbells of length 0.8 in 800 particles of solvent, at thermal velocities.
//! let mut rng = start::stream(42);
//! let lattice = Lattice::brick(DVec3::splat(7.0))?;
//! let dumbbells = Molecules::linear(0, 100, 2)?;
//! let mut positions = start::chains(&lattice, &dumbbells, |_| 0.8, &mut rng);
//! positions.extend(start::uniform(&lattice, 800, &mut rng));
//! let particles = Particles::new(positions)?;
//! let velocities = start::velocities(&particles, 1.0, &mut rng)?;
//! let particles = particles.with_velocities(velocities)?;
//! assert_eq!(particles.len(), 1000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::{Lattice, Molecules, ParameterError, Particles};
use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal, StandardUniform, UnitSphere};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A generator for what is drawn in sequence: xoshiro256++ (Blackman and Vigna 2021), the same for the same seed.
pub fn stream(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

/// Positions drawn independently, with the same density everywhere in the cell.
pub fn uniform(lattice: &Lattice, count: usize, rng: &mut impl Rng) -> Vec<DVec3> {
    (0..count).map(|_| anywhere(lattice, rng)).collect()
}

/// Positions spread over a grid in fractional coordinates: simple cubic if the cell is a cube and `count` a cube
/// number. The grid has the most equal spacings that give every particle a site of its own; sites left over are
/// spread as well.
pub fn grid(lattice: &Lattice, count: usize) -> Vec<DVec3> {
    let basis = lattice.basis();
    let edges = [basis.x_axis, basis.y_axis, basis.z_axis].map(DVec3::length);
    let mut sites = [1_usize; 3];
    while sites.iter().product::<usize>() < count {
        let spacing = |k: usize| edges[k] / sites[k] as f64;
        let widest = (1..3).fold(0, |widest, k| {
            if spacing(k) > spacing(widest) {
                k
            } else {
                widest
            }
        });
        sites[widest] += 1;
    }
    let [a, b, c] = sites;
    let stride = (a * b * c) as f64 / count as f64;
    (0..count)
        .map(|k| {
            let site = (k as f64 * stride) as usize;
            let place = [site / (b * c), site / c % b, site % c].map(|n| n as f64 + 0.5);
            basis * (DVec3::from_array(place) / DVec3::new(a as f64, b as f64, c as f64) - 0.5)
        })
        .collect()
}

/// Chains of beads, each a random walk of independent, isotropic bonds from a first bead anywhere in the cell. Bead
/// after bead and molecule after molecule, as [`Molecules`] counts them. The walks are not folded into the cell.
///
/// `bond` draws the length of each bond; `|_| 0.8` makes all alike.
pub fn chains<R: Rng>(
    lattice: &Lattice,
    molecules: &Molecules,
    mut bond: impl FnMut(&mut R) -> f64,
    rng: &mut R,
) -> Vec<DVec3> {
    let mut positions = Vec::new();
    for beads in molecules.iter() {
        let mut bead = anywhere(lattice, rng);
        positions.push(bead);
        for _ in beads.skip(1) {
            let direction = DVec3::from_array(UnitSphere.sample(rng));
            bead += bond(rng) * direction;
            positions.push(bead);
        }
    }
    positions
}

/// Peculiar velocities drawn from Maxwell and Boltzmann's distribution, `<c c> = (kt / m) I`, less the velocity of the
/// centre of mass, so that the total momentum is zero to rounding.
///
/// The kinetic energy is not scaled to a value: it fluctuates as it does in the ensemble, about 3/2 (N - 1) kt.
///
/// # Errors
/// If `kt` is below zero.
pub fn velocities(
    particles: &Particles,
    kt: f64,
    rng: &mut impl Rng,
) -> Result<Vec<DVec3>, ParameterError> {
    let kt = ParameterError::non_negative("kt", kt)?;
    let mut velocities: Vec<DVec3> = (0..particles.len())
        .map(|k| {
            let [x, y, z] = std::array::from_fn(|_| StandardNormal.sample(rng));
            (kt / particles.mass(k)).sqrt() * DVec3::new(x, y, z)
        })
        .collect();
    let (mut momentum, mut mass) = (DVec3::ZERO, 0.0);
    for (k, &velocity) in velocities.iter().enumerate() {
        momentum += particles.mass(k) * velocity;
        mass += particles.mass(k);
    }
    for velocity in &mut velocities {
        *velocity -= momentum / mass;
    }
    Ok(velocities)
}

fn anywhere(lattice: &Lattice, rng: &mut impl Rng) -> DVec3 {
    let fraction: [f64; 3] = std::array::from_fn(|_| StandardUniform.sample(rng));
    lattice.basis() * (DVec3::from_array(fraction) - 0.5)
}
