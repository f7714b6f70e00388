//! The scheme of Lowe and Andersen.

use crate::pair_bath::{Exchange, PairBath, Sweep, verlet_and_sweep};
use crate::stage::Stage;
use zimm_core::noise::Domain;
use zimm_core::{
    Boundary, ForceField, Item, Neighbours, Now, Pair, ParameterError, StepError, Stepper, System,
    Tally,
};

/// Lowe-Andersen dynamics (Lowe, Europhys. Lett. 47, 145, 1999): velocity Verlet, and a bath that redraws the relative
/// velocities of pairs, in a flow and with masses.
///
/// Every step ends with the bath. A pair closer than `cutoff` takes part with the probability `rate dt`. The velocity at
/// which it parts along its line of centres `e = r_ij / r` is then drawn anew from Maxwell's distribution, and both
/// particles get the same impulse with opposite signs:
///
/// ```text
/// u = e . (c_i - c_j + kappa r_ij)        mu = m_i m_j / (m_i + m_j)
/// u' = (kT / mu)^1/2 xi                   xi normal
/// m_i c_i += mu (u' - u) e                m_j c_j -= mu (u' - u) e
/// ```
///
/// `u` is the velocity in the laboratory, so the bath works against the flow, and in the nearest image. Momentum is
/// conserved; Maxwell's distribution is left alone whatever the time step, so the temperature errs by what the forces do.
/// For masses of 1 and a small `rate dt`, the bath makes
///
/// ```text
/// viscosity   eta = pi rho^2 rate r_c^5 / 75        (and rho D / 2 and what the forces do)
/// diffusion   D = 9 kT / (2 pi rho rate r_c^3)      (without the help of the fluid, which adds some 20 %)
/// ```
///
/// and the Schmidt number grows as the square of the rate. Beyond `rate dt = 0.3` the pairs of a particle get into each
/// other's way within a step, and the viscosity is higher than that: by 7 % at 0.4, by 15 % at 0.8.
///
/// Pairs take turns in an order that noise draws anew for every step, and each sees what those before it have done. The
/// order has no direction in space. It belongs to the identities, so that threads, the source of pairs and restarts do
/// not show in a single bit.
///
/// The forces of the field must be conservative; friction or noise in the field do not compile. The forces kept with the
/// particles, and heard of by the tally, are those of the field at the new positions. The tally also hears of every
/// redrawn pair at the new positions, as [`Item::Impulse`](zimm_core::Item::Impulse) with the force `mu (u' - u) e / dt`:
/// nearly all of the viscosity.
///
/// The source of pairs is the bath's own, besides that of the field. The total momentum is held at zero as in
/// [`GrootWarren`](crate::GrootWarren), where it is told what counts as a state that is not finite.
///
/// ```
/// use zimm_core::{AllPairs, Clock, DVec3, Open, Particles, Stepper, System};
/// use zimm_integrators::LoweAndersen;
///
/// // At kT = 0 and rate dt = 1 a pair that meets stays together.
/// let particles = Particles::new(vec![DVec3::ZERO, 0.5 * DVec3::X])?
///     .with_velocities(vec![2.0 * DVec3::X, DVec3::ZERO])?;
/// let mut system = System::new(Open, particles, Clock::new(0.1, 0.0, 1)?);
/// let mut stepper = LoweAndersen::new(10.0, 1.0, AllPairs::default())?.keeping_momentum();
/// stepper.step(&mut system, &mut (), &mut ())?;
/// assert_eq!(system.particles.velocities(), [DVec3::X, DVec3::X]);
///
/// // A rate dt above 1 is no probability.
/// system.clock.set_dt(0.2)?;
/// assert!(stepper.step(&mut system, &mut (), &mut ()).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// A field with friction of its own:
///
/// ```compile_fail,E0080
/// # use zimm_core::{AllPairs, Central, Clock, Now, Open, Pair, PairForce, Pairwise, Particles, Reads, Stepper, System};
/// # use zimm_integrators::LoweAndersen;
/// struct Friction;
///
/// impl PairForce for Friction {
///     const READS: Reads = Reads { velocity: true, ..Reads::NOTHING };
///
///     fn cutoff(&self) -> f64 {
///         1.0
///     }
///
///     fn force(&self, pair: &Pair, _: &Now) -> Central {
///         Central::dissipative(-pair.rv)
///     }
/// }
///
/// let mut system = System::new(Open, Particles::default(), Clock::new(0.01, 1.0, 1)?);
/// let mut field = Pairwise::new(Friction, AllPairs::default());
/// LoweAndersen::new(10.0, 1.0, AllPairs::default())?.step(&mut system, &mut field, &mut ())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct LoweAndersen<N> {
    bath: Redraw,
    sweep: Sweep<N>,
    stage: Stage,
}

impl<N> LoweAndersen<N> {
    /// A bath that redraws pairs closer than `cutoff` at a `rate` (one over time), and the source to find them with.
    ///
    /// # Errors
    /// If `rate` is below zero or `cutoff` is not above it. A time step so long that `rate dt` is above 1 is an error of
    /// the step, [`StepError::Parameter`].
    pub fn new(rate: f64, cutoff: f64, neighbours: N) -> Result<Self, ParameterError> {
        let bath = Redraw {
            rate: ParameterError::non_negative("rate", rate)?,
            cutoff: ParameterError::positive("cutoff", cutoff)?,
        };
        Ok(Self {
            bath,
            sweep: Sweep::new(neighbours),
            stage: Stage::default(),
        })
    }

    /// Leaves the total peculiar momentum as it comes, rounding included.
    pub fn keeping_momentum(mut self) -> Self {
        self.stage.keeps_momentum = true;
        self
    }
}

impl<B: Boundary, F: ForceField<B>, N: Neighbours<B>> Stepper<B, F> for LoweAndersen<N> {
    fn step<T: Tally>(
        &mut self,
        system: &mut System<B>,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError> {
        let scene = (system, field, tally);
        verlet_and_sweep(&self.bath, &mut self.sweep, &mut self.stage, scene)
    }
}

/// The bath: parting velocities are drawn anew at a rate.
#[derive(Clone, Copy, Debug)]
struct Redraw {
    rate: f64,
    cutoff: f64,
}

impl PairBath for Redraw {
    const ITEMS: [Item; 2] = [Item::Impulse; 2];

    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    fn share(&self, now: &Now) -> Result<f64, ParameterError> {
        let share = self.rate * now.dt;
        if share <= 1.0 {
            Ok(share)
        } else {
            Err(ParameterError::new("rate dt", share, "at most 1"))
        }
    }

    #[inline(always)]
    fn exchange(&self, pair: &Pair, mass: f64, now: &Now) -> Exchange {
        Exchange {
            loss: 1.0,
            kick: (now.kt / mass).sqrt() * pair.noise.normal(Domain::PAIR_KICK),
        }
    }
}
