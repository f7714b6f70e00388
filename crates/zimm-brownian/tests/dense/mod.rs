//! What tests of roots share: systems, the noise of a step, and the root of a matrix that is known exactly.
#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

use zimm_brownian::mobility_laws::Matrix;
use zimm_brownian::{Mobility, White};
use zimm_core::{Boundary, Clock, DVec3, Now, Open, Particles, System};

/// So many beads, of no matter where.
pub(crate) fn beads(count: usize) -> System<Open> {
    at(&(0..count).map(|k| k as f64 * DVec3::X).collect::<Vec<_>>())
}

pub(crate) fn at(positions: &[DVec3]) -> System<Open> {
    let particles = Particles::new(positions.to_vec()).unwrap();
    System::new(Open, particles, Clock::new(0.01, 1.0, 1).unwrap())
}

/// The noise of a step of seed 99.
pub(crate) fn white<B: Boundary>(system: &System<B>, step: u64) -> White<'_> {
    let now = Now {
        seed: 99,
        step,
        ..Now::default()
    };
    White::new(now, &system.frame())
}

/// The exact symmetric root of a matrix, which is a matrix itself, of the noise of a step.
pub(crate) fn exact(root: &mut Matrix, system: &System<Open>, step: u64) -> Vec<DVec3> {
    let white = white(system, step);
    let z: Vec<DVec3> = (0..root.beads()).map(|place| white.bead(place)).collect();
    let mut x = vec![DVec3::ZERO; z.len()];
    Mobility::<Open>::apply(root, &z, &mut x);
    x
}

pub(crate) fn relative_error(found: &[DVec3], exact: &[DVec3]) -> f64 {
    let square = |v: &[DVec3]| v.iter().map(|v| v.length_squared()).sum::<f64>();
    let apart: Vec<DVec3> = found.iter().zip(exact).map(|(a, b)| *a - *b).collect();
    (square(&apart) / square(exact)).sqrt()
}
