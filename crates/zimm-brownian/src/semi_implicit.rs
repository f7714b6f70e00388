//! Springs implicit, everything else explicit.

use crate::{
    Mobility, Root,
    columns::add_scaled,
    flow::Carry,
    implicit::{Implicit, Scene},
    stage::{Stage, zero},
};
use std::mem::swap;
use zimm_core::{
    BondForce, Bonded, Boundary, ForceField, ParameterError, StepError, Stepper, System, Tally,
};

/// How well a prediction is solved with hydrodynamic interactions, relative to its displacements. What is missed is of the
/// order dt^(3/2) even in the first round, and acts through flow and other forces: at the order dt^(5/2), below that of
/// the scheme.
const ROUGH: f64 = 1e-2;

/// Springs that no step overstretches: the trapezoidal rule for springs, Heun's for flow and other forces.
///
/// ```text
/// r* = r + K r          + n + dt/2 M (F_s(r) + F_s(r*)) + dt M F_o(r)
/// r' = r + K (r + r*)/2 + n + dt/2 M (F_s(r) + F_s(r')) + dt/2 M (F_o(r) + F_o(r*))       n = sqrt(2 kT dt) M^(1/2) z
/// ```
///
/// with K = kappa dt, M the mobility at r, F_s the forces of springs and F_o those of everything else. The force field
/// says which is which: [`Bonded`] alone, or a pair of [`Bonded`] and the rest.
///
/// # What is exact and what is not
/// Averages are of second order in dt when M is constant, of first order when it depends on positions.
///
/// Three things hold at any step if M is constant. Linear springs at rest have their exact covariance. Springs of any
/// law have the exact virial at rest, `<Q F> = 3 kT`, and with it the stress. A balance of springs and flow is a fixed
/// point. So the error of long steps is small, also where springs are much faster than the step. FENE dumbbells, with
/// dt in units of zeta / 4H, meet `<Q^2>` at rest to 1 % up to dt = 0.7 for b = 10 and at any dt for b = 50 and 1000;
/// in planar extension at a rate of 10 they meet `<Q^2>` and the stress to 0.7 % at dt = 2 for b = 10, and to 0.1 % for
/// b = 50 and 1000.
///
/// What such steps do not tell is the course in time: modes that are faster than the step are not damped but change
/// sign from step to step. Backward Euler damps them, and so does the L-stable scheme of second order and two stages;
/// both were tried, and leave 2.4 and 2.95 of 3 kT at dt = 1 for b = 50, and 0.5 and 0.8 at dt = 20.
///
/// One thing must be damped. A spring that half its force would throw more than its limit farther than flow and other
/// forces can explain, and that pulls with more than 64 kT, is left out at the beginning of the step and acts at its end
/// alone: it falls back at once from 0.999999 of its limit, where it would bounce between both sides for long. In a
/// steady state this does not happen.
///
/// # How it is solved
/// The length of a single bond solves q + c T(q) = |R|, with one root below the limit if the tension T grows with the
/// length. Larger connected sets of any topology are solved bond by bond while that converges fast, else by Newton's
/// method along the tree of bonds. Both stay below the limit, with 1e-12 of it to spare, and ask a law for its force
/// alone. If its tension does not grow everywhere, as that of a rod, the solution is one near the present lengths.
///
/// With hydrodynamic interactions the equations are solved as for beads that move alone, and what others add is lagged
/// and iterated, with Anderson's mixing. Forces at the end of a step are taken to be those at its beginning, whose product
/// with M is needed anyhow; each further product is of what has changed since, of springs and other forces together.
/// In a semidilute solution a step takes 3 products at dt = 0.005 and 5 at 0.04 to a tolerance of 1e-4, 4 and 7 to 1e-8;
/// of springs alone, 4 at 0.1 and 8 at 1, or 7 and 13.
///
/// # Other forces
/// They are explicit, so a step must not throw beads onto each other. Where they repel each other hard (WCA of
/// 0.83 kT and 2.4 l_H, at overlap), steps to 0.04 lambda_H last; at 0.05 a pair is sooner or later predicted deep inside
/// its repulsion, is thrown apart by thousands of lengths, onto others, and the step ends in
/// [`NotSolved`](zimm_core::StepError::NotSolved). Make such steps shorter.
///
/// # In flows
/// The flow carries the centre of each connected set exactly, as it carries lattice vectors; K acts on what is inside
/// the set. A sudden strain comes first. Bonds are those of nearest images at the beginning of the step; a ring must
/// not go round a periodic cell, and a bond must not end longer than half of it
/// ([`BeyondCell`](zimm_core::ForceError::BeyondCell)).
///
/// Isolated molecules in extension want [`recentre`](zimm_core::recentre): bonds lose their digits to a centre that is
/// far away.
///
/// Ottinger, Stochastic Processes in Polymeric Fluids (1996), for dumbbells, here with an implicit prediction; Somasi,
/// Khomami, Woo, Hur and Shaqfeh, J. Non-Newtonian Fluid Mech. 108, 227 (2002), for chains, bond by bond.
///
/// ```
/// use zimm_boundary::OpenFlow;
/// use zimm_brownian::{Diagonal, FreeDraining, SemiImplicit};
/// use zimm_core::{Bonded, Clock, DVec3, DMat3, Particles, Stepper, System};
/// use zimm_forces::Fene;
///
/// // Planar extension at a Weissenberg number of 2e5, a step of ten strains, a spring at 0.999999 of its limit.
/// let rate = DMat3::from_diagonal(DVec3::new(1e5, -1e5, 0.0));
/// let particles = Particles::new(vec![DVec3::ZERO, 0.999_999 * DVec3::X])?;
/// let mut system = System::new(OpenFlow::new(rate)?, particles, Clock::new(1e-4, 1.0, 1)?);
/// let mut springs = Bonded::new(Fene::with_extensibility(50.0, 1.0, 1.0)?, vec![[0, 1]]);
/// let mut stepper = SemiImplicit::new(FreeDraining::new(4.0)?, Diagonal);
/// stepper.step(&mut system, &mut springs, &mut ())?;
/// let r = system.particles.positions();
/// assert!((r[0] - r[1]).length() < 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SemiImplicit<M, R> {
    mobility: M,
    root: R,
    tolerance: f64,
    stage: Stage,
    implicit: Implicit,
}

impl<M, R> SemiImplicit<M, R> {
    /// The scheme with this mobility and this root of it.
    pub fn new(mobility: M, root: R) -> Self {
        Self {
            mobility,
            root,
            tolerance: 1e-8,
            stage: Stage::default(),
            implicit: Implicit::default(),
        }
    }

    /// Solves to this relative error, of displacements by springs and of what they leave of their limit. It is 1e-8
    /// unless set: far below the statistical error of any run.
    ///
    /// # Errors
    /// If `tolerance` is not between 1e-13 and 0.01.
    pub fn with_tolerance(mut self, tolerance: f64) -> Result<Self, ParameterError> {
        if !(1e-13..=1e-2).contains(&tolerance) {
            let allowed = "between 1e-13 and 0.01";
            return Err(ParameterError::new("tolerance", tolerance, allowed));
        }
        self.tolerance = tolerance;
        Ok(self)
    }

    /// Keeps a mobility and what its root has made of it for so many steps: both are of the configuration at the last step
    /// whose number is a multiple of `steps`, and noise still fits mobility, so that only what changes within a round errs, in
    /// proportion to the time that it lasts. It pays where binding or the root is what costs, as a factorisation does
    /// (`Cholesky`); `BlockLanczos` takes the roots of a round together. A product with the mobility is as dear as before.
    ///
    /// Particles that come, go or change places end a round; a stepper that keeps belongs to one run. A run that goes on from a checkpoint has the same bits if that
    /// is at the beginning of a round, for the configuration at its beginning is not saved.
    ///
    /// # Errors
    /// If `steps` is 0.
    pub fn keeping(mut self, steps: u64) -> Result<Self, ParameterError> {
        self.stage.keep(steps)?;
        Ok(self)
    }

    /// Puts the new positions on the stage, still to be wrapped.
    fn propose<B, S, Rest>(
        &mut self,
        system: &System<B>,
        springs: &Bonded<S>,
        mut rest: Option<&mut Rest>,
    ) -> Result<(), StepError>
    where
        B: Boundary,
        S: BondForce,
        Rest: ForceField<B>,
        M: Mobility<B>,
        R: Root<B, M>,
    {
        let (now, next) = (system.clock.now(), system.clock.next());
        let Self {
            mobility,
            root,
            stage,
            implicit,
            ..
        } = self;
        let scene = Scene {
            law: springs.spring(),
            carry: &Carry::over_step(system),
            dt: now.dt,
            kt: next.kt,
            step: next.step,
            tolerance: self.tolerance,
        };
        let frame = system.frame();
        let half = 0.5 * now.dt;
        stage.shake(system, mobility, root)?;
        implicit
            .know(springs, frame.len())
            .map_err(|source| StepError::Force {
                step: next.step,
                source,
            })?;
        implicit.gather(&scene, &frame, &stage.forces, mobility)?;

        // Half of the forces at the beginning act now. The other half is predicted to be the same, then corrected.
        implicit.others.clear();
        if rest.is_some() {
            stage.forces.clone_into(&mut implicit.others);
            implicit.leave_others();
        }
        implicit.drop_from(&mut stage.forces);
        zero(&mut stage.velocities, frame.len());
        mobility.apply(&stage.forces, &mut stage.velocities);
        add_scaled(&mut stage.noise, half, &stage.velocities);
        implicit.expect(&scene, mobility, &stage.forces, &stage.velocities);
        if B::FLOWS || rest.is_some() {
            implicit.release(&scene, &stage.noise, false);
            implicit.solve(&scene, mobility, ROUGH)?;
        }
        if let Some(rest) = &mut rest {
            implicit.scatter(&mut stage.positions);
            let boundary = stage.settle(system)?;
            stage.evaluate(system, &boundary, *rest, &mut ())?;
            stage.rewind(system);
            swap(&mut stage.forces, &mut implicit.others);
        }
        implicit.release(&scene, &stage.noise, B::FLOWS);
        implicit.solve(&scene, mobility, 0.0)?;
        implicit.scatter(&mut stage.positions);
        Ok(())
    }

    /// Wraps the new positions, evaluates the forces there and makes them the state of the system.
    fn accept<B: Boundary, F: ForceField<B>, T: Tally>(
        &mut self,
        system: &mut System<B>,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError> {
        let boundary = self.stage.settle(system)?;
        let mut heard = tally.fresh();
        self.stage.evaluate(system, &boundary, field, &mut heard)?;
        self.stage.commit(system, boundary);
        tally.absorb(heard);
        Ok(())
    }
}

impl<B: Boundary, S: BondForce, M: Mobility<B>, R: Root<B, M>> Stepper<B, Bonded<S>>
    for SemiImplicit<M, R>
{
    fn step<T: Tally>(
        &mut self,
        system: &mut System<B>,
        field: &mut Bonded<S>,
        tally: &mut T,
    ) -> Result<(), StepError> {
        self.stage.open(system, field)?;
        self.propose(system, field, None::<&mut ()>)?;
        self.accept(system, field, tally)
    }
}

impl<B, S, Rest, M, R> Stepper<B, (Bonded<S>, Rest)> for SemiImplicit<M, R>
where
    B: Boundary,
    S: BondForce,
    Rest: ForceField<B>,
    M: Mobility<B>,
    R: Root<B, M>,
{
    fn step<T: Tally>(
        &mut self,
        system: &mut System<B>,
        field: &mut (Bonded<S>, Rest),
        tally: &mut T,
    ) -> Result<(), StepError> {
        self.stage.open(system, field)?;
        let (springs, rest) = field;
        self.propose(system, springs, Rest::ACTS.then_some(rest))?;
        self.accept(system, field, tally)
    }
}
