//! What tests of periodic mobilities share: systems at a time, products, numbers of reference files.
#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

use serde_json::Value;
use zimm_brownian::Mobility;
use zimm_core::{Boundary, Clock, DVec3, Particles, System};

pub(crate) fn at<B: Boundary>(space: B, positions: &[DVec3]) -> System<B> {
    at_time(space, positions, 0.0)
}

pub(crate) fn at_time<B: Boundary>(space: B, positions: &[DVec3], time: f64) -> System<B> {
    let particles = Particles::new(positions.to_vec()).unwrap();
    let mut clock = Clock::new(if time > 0.0 { time } else { 1.0 }, 1.0, 1).unwrap();
    if time > 0.0 {
        clock.tick();
    }
    System::new(space, particles, clock)
}

pub(crate) fn product<B: Boundary>(
    mobility: &mut impl Mobility<B>,
    system: &System<B>,
    forces: &[DVec3],
) -> Vec<DVec3> {
    mobility.bind(&system.frame()).unwrap();
    let mut velocities = vec![DVec3::ZERO; forces.len()];
    mobility.apply(forces, &mut velocities);
    velocities
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    let number = |x: &Value| x.as_f64().unwrap();
    value.as_array().unwrap().iter().map(number).collect()
}

pub(crate) fn vectors(value: &Value) -> Vec<DVec3> {
    numbers(value).chunks(3).map(DVec3::from_slice).collect()
}
