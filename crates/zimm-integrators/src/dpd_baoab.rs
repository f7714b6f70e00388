//! BAOAB with friction between pairs.

use crate::friction::Friction;
use crate::pair_bath::{Sweep, conservative};
use crate::stage::{Stage, Streaming};
use zimm_core::{Boundary, ForceField, Neighbours, PairForce, StepError, Stepper, System, Tally};

/// DPD by the splitting BAOAB, in a flow and with masses: the order of [`Langevin`](crate::Langevin) (Leimkuhler and
/// Matthews 2013), with friction and noise between pairs in the middle of the step.
///
/// One step is half a kick, half a step of streaming, the sweep of friction and noise over all pairs, the other half of
/// streaming, half a kick. The sweep is that of [`Shardlow`](crate::Shardlow), formula for formula, at the positions in
/// the middle of the step.
///
/// Of the schemes here it disturbs structure and dynamics least: positions belong to a potential closer to the true
/// one, and to a time step twice as long for the same error. Velocities pay for it. Those at the end of a step are cold, by
/// `(omega dt)^2 / 4` of a mode `omega`, so that the kinetic temperature tells nothing of the quality of a run; see the
/// table of [the crate](crate#dpd).
///
/// Pairs take turns, images move and momentum is held as in [`LoweAndersen`](crate::LoweAndersen). The field must be
/// conservative as there; its forces are those at the new positions. The tally hears of the impulses at the
/// positions in the middle of the step, over the time step, as [`Item::Dissipative`](zimm_core::Item::Dissipative) and
/// [`Item::Random`](zimm_core::Item::Random).
///
/// ```
/// use zimm_core::{AllPairs, Central, Clock, DVec3, Now, Open, Pair, PairForce, Particles, Reads, Stepper, System};
/// use zimm_integrators::DpdBaoab;
///
/// /// F = -u along the line of centres, up to a distance of 1.
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
///         Central::dissipative(-pair.rv / pair.r2)
///     }
/// }
///
/// // Half a step at a speed of 1, half a step at what friction leaves of it.
/// let particles = Particles::new(vec![DVec3::X, 0.5 * DVec3::X])?.with_velocities(vec![DVec3::X, -DVec3::X])?;
/// let mut system = System::new(Open, particles, Clock::new(0.1, 0.0, 1)?);
/// DpdBaoab::new(Friction, AllPairs::default()).step(&mut system, &mut (), &mut ())?;
/// let left = (-0.2_f64).exp();
/// assert!((system.particles.velocities()[0].x - left).abs() < 1e-15);
/// assert!((system.particles.positions()[0].x - (1.05 + 0.05 * left)).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct DpdBaoab<L, N> {
    bath: Friction<L>,
    sweep: Sweep<N>,
    stage: Stage,
}

impl<L: PairForce, N> DpdBaoab<L, N> {
    /// A scheme with this law of friction and a source to find its pairs with; laws are those of
    /// [`Shardlow::new`](crate::Shardlow::new).
    pub fn new(friction: L, neighbours: N) -> Self {
        Self {
            bath: Friction::new(friction),
            sweep: Sweep::new(neighbours),
            stage: Stage::default(),
        }
    }

    /// Leaves the total peculiar momentum as it comes, rounding included.
    pub fn keeping_momentum(mut self) -> Self {
        self.stage.keeps_momentum = true;
        self
    }
}

impl<B, F, L, N> Stepper<B, F> for DpdBaoab<L, N>
where
    B: Boundary,
    F: ForceField<B>,
    L: PairForce,
    N: Neighbours<B>,
{
    fn step<T: Tally>(
        &mut self,
        system: &mut System<B>,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError> {
        conservative::<B, F>();
        let stage = &mut self.stage;
        let (now, next, ahead) = (system.clock.now(), system.clock.next(), system.ahead());
        let (half, middle) = (0.5 * now.dt, 0.5 * (now.time + next.time));
        let first = Streaming::new(&system.boundary, now.time, middle, half);
        let second = Streaming::new(&system.boundary, middle, next.time, half);
        let mut heard = tally.fresh();

        stage.depart(system, field, false, |flight| {
            flight.kick(half)?;
            flight.stream::<B>(&first);
            Ok(())
        })?;
        let mut boundary = system.boundary.clone();
        boundary.advance(middle);
        let mut moment = next;
        moment.time = middle;
        self.sweep
            .act(&self.bath, stage, system, (&boundary, moment), &mut heard)?;
        stage.go_on(system, |flight| {
            flight.stream::<B>(&second);
            flight.settle(&ahead)
        })?;

        stage.evaluate(system, &ahead.boundary, field, &mut heard)?;
        stage.kick(system, half)?;
        stage.rest::<B, F>(system);
        stage.commit(system, ahead.boundary);
        tally.absorb(heard);
        Ok(())
    }
}
