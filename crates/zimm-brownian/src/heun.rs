//! Heun's explicit scheme: second order for smooth forces.

use crate::columns::{add_scaled, rescale};
use crate::stage::{Stage, zero};
use crate::{Diagonal, FreeDraining, Mobility};
use zimm_core::{
    Boundary, DMat3, DVec3, ForceField, StepError, Stepper, System, Tally, for_each_chunk,
};

/// Heun's scheme for free-draining beads in a flow, of second order in dt for averages:
///
/// ```text
/// s  = E r + dt E M F(r) + n                         n = sqrt(2 kT dt) E' M^(1/2) z
/// r' = E r + dt/2 (E M F(r) + M F(s)) + n
/// ```
///
/// with E the deformation of the flow over the step and E' over its second half.
///
/// Seen from the flow, y = E^-1 r obeys dy = E^-1 (M F dt + sqrt(2 kT) M^(1/2) dW), with noise that depends on time
/// alone. For such an equation Heun's scheme is of weak order two with any normal noise whose covariance is that of the
/// integrated noise to third order in dt; the midpoint rule gives it. So the force at the beginning is carried
/// by the whole flow, noise by half of it, and the force at the end not at all.
///
/// Two evaluations of the forces a step. For smooth forces: a spring that the predicted positions s or the new ones
/// would stretch beyond its limit is an error ([`zimm_core::ForceError::Overstretched`]); the system is then as it was.
/// A mobility that depends on positions makes noise of another kind, for which the scheme is not of second order, so it
/// does not take one:
///
/// ```compile_fail,E0308
/// # use zimm_brownian::Heun;
/// let stepper = Heun::new(());
/// ```
///
/// ```
/// use zimm_brownian::{FreeDraining, Heun};
/// use zimm_core::{Bonded, Clock, DVec3, Open, Particles, Stepper, System};
/// use zimm_forces::Hooke;
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?;
/// let mut system = System::new(Open, particles, Clock::new(0.1, 0.0, 1)?);
/// let mut springs = Bonded::new(Hooke::new(1.0)?, vec![[0, 1]]);
/// Heun::new(FreeDraining::new(4.0)?).step(&mut system, &mut springs, &mut ())?;
/// // Without noise the bond decays by 1 - dt/2 + dt^2/8.
/// let bond = system.particles.positions()[1] - system.particles.positions()[0];
/// assert!((bond.x - 0.95125).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Heun {
    mobility: FreeDraining,
    stage: Stage,
    first: Vec<DVec3>,
}

impl Heun {
    /// The scheme with this mobility.
    pub fn new(mobility: FreeDraining) -> Self {
        Self {
            mobility,
            stage: Stage::default(),
            first: Vec::new(),
        }
    }
}

impl<B: Boundary, F: ForceField<B>> Stepper<B, F> for Heun {
    fn step<T: Tally>(
        &mut self,
        system: &mut System<B>,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError> {
        let (stage, mobility) = (&mut self.stage, &mut self.mobility);
        let (now, next) = (system.clock.now(), system.clock.next());
        let half_way = 0.5 * (now.time + next.time);
        let whole = system.boundary.carry(now.time, next.time);
        let half = system.boundary.carry(half_way, next.time);

        stage.open(system, field)?;
        stage.drive(system, mobility, &mut Diagonal)?;
        if B::FLOWS {
            deform(&mut stage.velocities, whole);
            deform(&mut stage.noise, half);
        }
        stage.velocities.clone_into(&mut self.first);
        stage.carry(system);
        let predicted = stage.settle(system)?;
        stage.evaluate(system, &predicted, field, &mut ())?;

        zero(&mut stage.velocities, stage.forces.len());
        Mobility::<B>::apply(mobility, &stage.forces, &mut stage.velocities);
        add_scaled(&mut stage.velocities, 1.0, &self.first);
        rescale(&mut stage.velocities, 0.5);
        stage.rewind(system);
        stage.carry(system);
        let boundary = stage.settle(system)?;
        let mut heard = tally.fresh();
        stage.evaluate(system, &boundary, field, &mut heard)?;
        stage.commit(system, boundary);
        tally.absorb(heard);
        Ok(())
    }
}

fn deform(column: &mut [DVec3], by: DMat3) {
    for_each_chunk(column, |_, chunk| {
        for v in chunk {
            *v = by * *v;
        }
    });
}
