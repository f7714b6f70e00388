//! Shardlow's splitting.

use crate::friction::Friction;
use crate::pair_bath::{Sweep, verlet_and_sweep};
use crate::stage::Stage;
use zimm_core::{Boundary, ForceField, Neighbours, PairForce, StepError, Stepper, System, Tally};

/// DPD by Shardlow's splitting S1 (SIAM J. Sci. Comput. 24, 1267, 2003), in a flow and with masses: velocity Verlet for
/// the conservative forces, and friction and noise pair by pair.
///
/// Every step ends with a sweep over all pairs in range of the friction. With `gamma` the friction of the pair, that is
/// F = -gamma u along the line of centres `e`, each pair in its turn gets the exact solution over one time step:
///
/// ```text
/// u = e . (c_i - c_j + kappa r_ij)                    mu = m_i m_j / (m_i + m_j)
/// u' = w u + (kT / mu)^1/2 (1 - w^2)^1/2 xi           w = exp(-gamma dt / mu), xi normal
/// m_i c_i += mu (u' - u) e                            m_j c_j -= mu (u' - u) e
/// ```
///
/// Maxwell's distribution is left alone whatever the friction and the time step. Shardlow solves for `u'` by the
/// trapezoidal rule, which agrees to `(gamma dt)^2` and overshoots beyond `gamma dt = 2 mu`; he begins a step with the
/// sweep, so that his velocities are those before the last one. Structure and dynamics err as those of velocity
/// Verlet do, see the table of [the crate](crate#dpd).
///
/// Pairs take turns, images move and momentum is held as in [`LoweAndersen`](crate::LoweAndersen). The field must be
/// conservative as there. The tally hears of the impulses at the new positions, over the time step, as
/// [`Item::Dissipative`](zimm_core::Item::Dissipative) and [`Item::Random`](zimm_core::Item::Random).
///
/// ```
/// use zimm_core::{AllPairs, Central, Clock, DVec3, Now, Open, Pair, PairForce, Particles, Reads, Stepper, System};
/// use zimm_integrators::Shardlow;
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
/// // Two unit masses that part at speed 2, without noise.
/// let particles = Particles::new(vec![DVec3::X, 0.5 * DVec3::X])?.with_velocities(vec![DVec3::X, -DVec3::X])?;
/// let mut system = System::new(Open, particles, Clock::new(0.1, 0.0, 1)?);
/// Shardlow::new(Friction, AllPairs::default()).step(&mut system, &mut (), &mut ())?;
/// let [a, b] = [0, 1].map(|k| system.particles.velocities()[k].x);
/// assert!((a - b - 2.0 * (-0.2_f64).exp()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Shardlow<L, N> {
    bath: Friction<L>,
    sweep: Sweep<N>,
    stage: Stage,
}

impl<L: PairForce, N> Shardlow<L, N> {
    /// A scheme with this law of friction and a source to find its pairs with.
    ///
    /// The law reads velocities and no noise, or this does not compile: the stepper makes the noise that balances it.
    /// Its force is proportional to the velocity. Only the friction of the law is used.
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

impl<B, F, L, N> Stepper<B, F> for Shardlow<L, N>
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
        let scene = (system, field, tally);
        verlet_and_sweep(&self.bath, &mut self.sweep, &mut self.stage, scene)
    }
}
