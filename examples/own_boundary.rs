//! A boundary of one's own, tested by one line, and a fluid that is run in it for a few seconds.
//!
//! ```text
//! cargo run --release --example own_boundary
//! ```

use std::error::Error;
use zimm::boundary::laws;
use zimm::prelude::*;

/// Planar flow that turns more than it strains, kappa = rate [[0, 1], [-ellipticity, 0]]: round and round on ellipses.
///
/// After a turn every particle is back, so any lattice is, and the deformation is a closed form:
/// exp(kappa t) = cos(w t) + kappa sin(w t) / w in the plane, with w = rate sqrt(ellipticity).
#[derive(Clone)]
struct Vortex {
    gradient: DMat3,
    frequency: f64,
    start: DMat3,
    time: f64,
    lattice: Lattice,
}

impl Vortex {
    fn new(edge: f64, rate: f64, ellipticity: f64) -> Result<Self, LatticeError> {
        let start = DMat3::from_diagonal(DVec3::splat(edge));
        let mut gradient = DMat3::ZERO;
        gradient.y_axis.x = rate;
        gradient.x_axis.y = -rate * ellipticity;
        Ok(Self {
            gradient,
            frequency: rate * ellipticity.sqrt(),
            start,
            time: 0.0,
            lattice: Lattice::new(start)?,
        })
    }
}

impl Boundary for Vortex {
    const FLOWS: bool = true;

    fn min_image(&self, dr: DVec3) -> DVec3 {
        self.lattice.nearest(dr)
    }

    fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
        self.lattice.fold(r)
    }

    fn reach(&self) -> f64 {
        0.5 * self.lattice.shortest()
    }

    fn gradient(&self) -> DMat3 {
        self.gradient
    }

    fn carry(&self, from: f64, to: f64) -> DMat3 {
        let (sin, cos) = (self.frequency * (to - from)).sin_cos();
        DMat3::from_diagonal(DVec3::new(cos, cos, 1.0)) + self.gradient * (sin / self.frequency)
    }

    fn advance(&mut self, to: f64) -> Remap {
        let Ok(lattice) = Lattice::new(self.carry(0.0, to) * self.start) else {
            return Remap::None;
        };
        let carried = self.carry(self.time, to) * self.lattice.basis();
        (self.time, self.lattice) = (to, lattice);
        Remap::between(carried, &lattice)
    }

    fn cell(&self) -> Option<DMat3> {
        Some(self.lattice.basis())
    }
}

impl Periodic for Vortex {
    fn lattice(&self) -> &Lattice {
        &self.lattice
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let space = Vortex::new(8.0, 0.5, 0.25)?;
    laws::check_boundary(&space, 100.0);
    println!("all laws of boundaries hold");

    let (density, kt, dt) = (3, 1.0, 0.02);
    let mut rng = start::stream(1);
    let particles = Particles::new(start::uniform(space.lattice(), density * 512, &mut rng))?;
    let velocities = start::velocities(&particles, kt, &mut rng)?;
    let particles = particles.with_velocities(velocities)?;
    let mut system = System::new(space, particles, Clock::new(dt, kt, 1)?);
    let mut forces = Pairwise::new(Dpd::new(25.0, 4.5)?, VerletList::tuned());
    let mut stepper = GrootWarren::new(0.65)?;
    let (mut temperature, mut stress) = (BlockAverage::new(), BlockAverage::new());
    for step in 0..3000 {
        let mut virial = Virial::default();
        stepper.step(&mut system, &mut forces, &mut virial)?;
        if step >= 500 {
            let frame = system.frame();
            let kinetic = KineticTemperature::default().measure(&frame, &virial)?;
            temperature.push(kinetic.mean());
            stress.push(Stress.measure(&frame, &virial).total().y_axis.x);
        }
    }
    println!("temperature {}, set to {kt}", temperature.estimate()?);
    // Only the strain makes stress, not the turning: eta (1 - ellipticity) times the rate.
    println!("shear stress {}", stress.estimate()?);
    Ok(())
}
