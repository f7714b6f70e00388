//! Velocity Verlet of Groot and Warren.

use crate::stage::{Stage, Streaming};
use zimm_core::{Boundary, ForceField, ParameterError, StepError, Stepper, System, Tally};

/// Velocity Verlet with predicted velocities (Groot and Warren 1997, eq. 22), in a flow and with masses.
///
/// Without a flow one step is
///
/// ```text
/// r(t + dt) = r + dt c + dt^2 f / 2m
/// f(t + dt) = f(r(t + dt), c + lambda dt f / m)
/// c(t + dt) = c + dt (f + f(t + dt)) / 2m
/// ```
///
/// In a flow the middle part, where particles move freely, follows the flow exactly: half a kick by the old force,
/// streaming, half a kick by the new one.
///
/// Friction sees the predicted velocities, and so does the force that is kept. For forces that read no velocities lambda
/// makes no difference, and the scheme is velocity Verlet: reversible and of second order. With friction averages are
/// of first order, and lambda tunes the temperature: the DPD fluid of density 3, `a = 25`, `gamma = 4.5` at `dt = 0.04`
/// runs 2.9 % hot with `lambda = 1/2` and 0.1 % with 0.65.
///
/// If the forces of a field sum to zero by construction ([`ForceField::CONSERVES_MOMENTUM`]), **the total peculiar
/// momentum is held at zero**: it is taken off in step 1 and in every hundredth step from there. At rest this only
/// removes rounding and whatever the initial velocities had; in extension, where a momentum grows as
/// `exp(rate t)` along the contracting axis, a run of many strains could not do without (Todd and Daivis 2000).
/// [`keeping_momentum`](Self::keeping_momentum) leaves it alone.
///
/// A new state counts as not finite as well if the square of a position or velocity overflows, or if a particle
/// moves 2^26 times the reach of the cell in one step, which would leave its position with half of its digits.
///
/// ```
/// use zimm_core::{BondForce, Bonded, Clock, DVec3, Open, Particles, Stepper, System};
/// use zimm_integrators::GrootWarren;
///
/// struct Hooke;
///
/// impl BondForce for Hooke {
///     fn force(&self, _: f64) -> f64 {
///         -1.0
///     }
///
///     fn energy(&self, r2: f64) -> f64 {
///         0.5 * r2
///     }
/// }
///
/// // Two unit masses on a spring of stiffness 1 swing with a frequency of sqrt 2.
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?;
/// let mut system = System::new(Open, particles, Clock::new(0.01, 0.0, 1)?);
/// let mut springs = Bonded::new(Hooke, vec![[0, 1]]);
/// let mut stepper = GrootWarren::new(0.5)?;
/// for _ in 0..100 {
///     stepper.step(&mut system, &mut springs, &mut ())?;
/// }
/// let [a, b] = [0, 1].map(|k| system.particles.positions()[k].x);
/// assert!((b - a - 2.0_f64.sqrt().cos()).abs() < 2e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct GrootWarren {
    lambda: f64,
    stage: Stage,
}

impl GrootWarren {
    /// A scheme that predicts velocities `lambda` of a step ahead.
    ///
    /// # Errors
    /// If `lambda` is not in [0, 1].
    pub fn new(lambda: f64) -> Result<Self, ParameterError> {
        if !(0.0..=1.0).contains(&lambda) {
            return Err(ParameterError::new("lambda", lambda, "in [0, 1]"));
        }
        Ok(Self {
            lambda,
            stage: Stage::default(),
        })
    }

    /// Leaves the total peculiar momentum as it comes, rounding included.
    pub fn keeping_momentum(mut self) -> Self {
        self.stage.keeps_momentum = true;
        self
    }
}

impl<B: Boundary, F: ForceField<B>> Stepper<B, F> for GrootWarren {
    fn step<T: Tally>(
        &mut self,
        system: &mut System<B>,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError> {
        let stage = &mut self.stage;
        let (now, next, ahead) = (system.clock.now(), system.clock.next(), system.ahead());
        let streaming = Streaming::new(&system.boundary, now.time, next.time, now.dt);
        let half = 0.5 * now.dt;

        let predicts = F::READS.velocity && self.lambda != 0.5;
        stage.depart(system, field, predicts, |flight| {
            flight.kick(half)?;
            if predicts {
                flight.predict::<B>((self.lambda - 0.5) * now.dt, &streaming);
            }
            flight.stream::<B>(&streaming);
            flight.settle(&ahead)
        })?;

        let mut heard = tally.fresh();
        stage.evaluate(system, &ahead.boundary, field, &mut heard)?;
        stage.kick(system, half)?;
        stage.rest::<B, F>(system);
        stage.commit(system, ahead.boundary);
        tally.absorb(heard);
        Ok(())
    }
}
