//! A force law of one's own, in a fluid of one's own: soft spheres of U = A (1 - r^2)^3.
//!
//! ```text
//! cargo run --release --example own_force            about two seconds
//! ```
//!
//! The law is a struct and two formulas. Images, neighbour lists, threads and stress come from the library.

use std::error::Error;
use std::f64::consts::PI;
use zimm::prelude::*;

/// U = A (1 - r^2)^3 for r < 1, smooth everywhere and finite at contact.
struct SoftSphere {
    height: f64,
}

impl PairForce for SoftSphere {
    fn cutoff(&self) -> f64 {
        1.0
    }

    /// F/r = -U'(r)/r = 6 A (1 - r^2)^2.
    #[inline(always)]
    fn force(&self, pair: &Pair, _: &Now) -> Central {
        let x = (1.0 - pair.r2).max(0.0);
        Central::conservative(6.0 * self.height * x * x)
    }

    fn energy(&self, pair: &Pair) -> f64 {
        self.height * (1.0 - pair.r2).max(0.0).powi(3)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let (height, density, edge, kt) = (2.0, 3.0, 6.0, 1.0);
    let space = PeriodicBox::cubic(edge)?;
    let mut rng = start::stream(1);
    let positions = start::uniform(
        space.lattice(),
        (density * edge * edge * edge) as usize,
        &mut rng,
    );
    let particles = Particles::new(positions)?;
    let velocities = start::velocities(&particles, kt, &mut rng)?;
    let particles = particles.with_velocities(velocities)?;

    // A tuple of laws is their sum: DPD without its own repulsion is the thermostat.
    let law = (SoftSphere { height }, Dpd::new(0.0, 4.5)?);
    let mut forces = Pairwise::new(law, VerletList::tuned());
    let mut system = System::new(space, particles, Clock::new(0.02, kt, 1)?);
    let mut stepper = GrootWarren::new(0.65)?;

    let (mut temperature, mut pressure) = (BlockAverage::new(), BlockAverage::new());
    for step in 0..30_000 {
        let mut virial = Virial::default();
        stepper.step(&mut system, &mut forces, &mut virial)?;
        if step >= 1000 {
            let frame = system.frame();
            temperature.push(KineticTemperature::default().measure(&frame, &())?.mean());
            pressure.push(Stress.measure(&frame, &virial).pressure());
        }
    }
    // Without correlations, P = rho kT + (rho^2 / 2) int U d^3r; soft repulsion leaves a little less.
    let mean_field = density * kt + 0.5 * density * density * height * 64.0 * PI / 315.0;
    println!("temperature  {:.4}  (set to {kt})", temperature.estimate()?);
    println!(
        "pressure     {:.3}  (mean field: {mean_field:.3})",
        pressure.estimate()?
    );
    Ok(())
}
