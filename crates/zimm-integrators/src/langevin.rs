//! Underdamped Langevin dynamics.

use crate::stage::{Flight, Stage, Streaming};
use zimm_core::{
    Boundary, DVec3, ForceField, Frame, Now, ParameterError, StepError, Stepper, System, Tally,
    noise,
};

/// Langevin dynamics by the splitting BAOAB (Leimkuhler and Matthews 2013), in a flow and with masses.
///
/// ```text
/// dr/dt = c + kappa r        m dc/dt = F - m kappa c - m Gamma c + sqrt(2 m Gamma kT) dW/dt
/// ```
///
/// Friction of rate `Gamma` (one over time) acts against the flow. One step is half a kick, half a step of streaming,
/// the exact solution of friction and noise over `dt`, the other half of streaming, half a kick. Averages are of
/// second order in `dt`; for a harmonic force those of positions are exact, and `<m c^2>` is `kT (1 - (omega dt)^2 / 4)`
/// per component.
///
/// The temperature is the clock's `kt`. The noise of a particle depends on seed, step and identity alone
/// ([`noise::Domain::LANGEVIN`]). Momentum is not conserved, and hydrodynamics is screened beyond
/// `sqrt(viscosity / (mass density Gamma))`. A friction rate of zero is velocity Verlet.
///
/// A new state counts as not finite in the same cases as in [`GrootWarren`](crate::GrootWarren).
///
/// ```
/// use zimm_core::{Clock, DVec3, Open, Particles, Stepper, System};
/// use zimm_integrators::Langevin;
///
/// // Free particles forget a common velocity at the friction rate.
/// let particles = Particles::new(vec![DVec3::ZERO; 2])?.with_velocities(vec![DVec3::X; 2])?;
/// let mut system = System::new(Open, particles, Clock::new(0.1, 0.0, 1)?);
/// let mut stepper = Langevin::new(0.5)?;
/// for _ in 0..20 {
///     stepper.step(&mut system, &mut (), &mut ())?;
/// }
/// assert!((system.particles.velocities()[0].x - (-1.0_f64).exp()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Langevin {
    friction: f64,
    stage: Stage,
}

impl Langevin {
    /// A scheme with this friction rate.
    ///
    /// # Errors
    /// If `friction` is below zero.
    pub fn new(friction: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            friction: ParameterError::non_negative("friction", friction)?,
            stage: Stage::default(),
        })
    }
}

impl<B: Boundary, F: ForceField<B>> Stepper<B, F> for Langevin {
    fn step<T: Tally>(
        &mut self,
        system: &mut System<B>,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError> {
        let stage = &mut self.stage;
        let (now, next, ahead) = (system.clock.now(), system.clock.next(), system.ahead());
        let (half, middle) = (0.5 * now.dt, 0.5 * (now.time + next.time));
        let first = Streaming::new(&system.boundary, now.time, middle, half);
        let second = Streaming::new(&system.boundary, middle, next.time, half);
        let bath = Bath::new(self.friction, system.clock.next());

        stage.depart(system, field, false, |flight| {
            flight.kick(half)?;
            flight.stream::<B>(&first);
            bath.rub(&system.frame(), flight);
            flight.stream::<B>(&second);
            flight.settle(&ahead)
        })?;

        let mut heard = tally.fresh();
        stage.evaluate(system, &ahead.boundary, field, &mut heard)?;
        stage.kick(system, half)?;
        stage.commit(system, ahead.boundary);
        tally.absorb(heard);
        Ok(())
    }
}

/// Friction and noise over one time step: an Ornstein-Uhlenbeck process, solved exactly.
struct Bath {
    noise: noise::Noise,
    memory: f64,
    energy: f64,
}

impl Bath {
    fn new(friction: f64, next: Now) -> Self {
        Self {
            noise: next.noise(),
            memory: libm::exp(-friction * next.dt),
            energy: next.kt * -libm::expm1(-2.0 * friction * next.dt),
        }
    }

    fn rub<B: Boundary>(&self, frame: &Frame<'_, B>, flight: &mut Flight<'_>) {
        const RUN: usize = 256;
        let mut kicks = [DVec3::ZERO; RUN];
        let runs = flight.velocities.chunks_mut(RUN);
        for (start, velocities) in (flight.start..).step_by(RUN).zip(runs) {
            let kicks = &mut kicks[..velocities.len()];
            noise::fill_normal3(kicks, |k| {
                let site = self.noise.site(frame.id(start + k));
                site.word(noise::Domain::LANGEVIN)
            });
            for ((place, c), &mut kick) in (start..).zip(velocities).zip(kicks) {
                *c = self.memory * *c + (self.energy / frame.mass(place)).sqrt() * kick;
            }
        }
    }
}
