//! Pair forces and springs are equal and opposite: total momentum is a constant of the motion, in shear as at rest.
#![allow(clippy::unwrap_used)]

mod scene;

use scene::{momentum, pairs, run, scene};
use zimm::prelude::*;

/// Largest total peculiar momentum per particle, looked at every 100 steps, of dumbbells in a sheared DPD fluid.
///
/// The box is as small as the law allows, so that the number of steps costs little: 32 particles, 4 of them in
/// dumbbells.
fn largest_momentum(mut stepper: GrootWarren, steps: u32) -> f64 {
    let space = LeesEdwards::new(DVec3::splat(2.2), Steady::new(0.5).unwrap()).unwrap();
    let clock = Clock::new(0.02, 1.0, 3).unwrap();
    let (mut system, molecules) = scene(space, 3.0, (2, 0.5), clock);
    let springs = Bonded::new(Fene::new(50.0, 1.0).unwrap(), molecules.bonds());
    let mut field = (pairs(Dpd::new(25.0, 4.5).unwrap()), springs);
    let mut largest = 0.0_f64;
    for _ in 0..steps / 100 {
        run(&mut stepper, &mut system, &mut field, 100);
        largest = largest.max(momentum(&system).length() / system.particles.len() as f64);
    }
    println!("largest momentum per particle in {steps} steps: {largest:.2e}");
    largest
}

/// Without any removal only rounding moves the total: some 1e8 roundings of 1e-16 times forces of 10 and a time step
/// of 0.02, and along x what the shear makes of those along y. A pair force that is not equal and opposite to 1e-9
/// of itself shows.
#[test]
fn law_forces_conserve_momentum() {
    let stepper = GrootWarren::new(0.65).unwrap().keeping_momentum();
    assert!(largest_momentum(stepper, 100_000) < 1e-10);
}

#[test]
fn law_momentum_is_held_at_zero() {
    assert!(largest_momentum(GrootWarren::new(0.65).unwrap(), 100_000) < 1e-13);
}

#[test]
#[ignore = "half a minute; cargo test -p zimm-tests --test momentum -- --ignored --nocapture"]
fn law_momentum_stays_below_1e_9_over_a_million_steps() {
    let keeping = GrootWarren::new(0.65).unwrap().keeping_momentum();
    assert!(largest_momentum(keeping, 1_000_000) < 1e-9);
    assert!(largest_momentum(GrootWarren::new(0.65).unwrap(), 1_000_000) < 1e-9);
}
