//! Springs implicit, everything else explicit.

use crate::{
    Mobility, Root,
    columns::add_scaled,
    flow::Carry,
    implicit::{Implicit, Scene},
    stage::{Stage, zero},
};
use zimm_core::{
    BondForce, Bonded, Boundary, ForceField, ParameterError, StepError, Stepper, System, Tally,
};

/// TODO docs
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

    /// TODO
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
        implicit.gather(&scene, &frame, mobility)?;

        // Half of the forces at the beginning act now. Of those that are not of springs, the other half is predicted
        // to be the same, then corrected.
        let others = rest.is_some().then(|| {
            let mut others = stage.forces.clone();
            implicit.take_from(&mut others);
            others
        });
        implicit.drop_from(&mut stage.forces);
        zero(&mut stage.velocities, frame.len());
        mobility.apply(&stage.forces, &mut stage.velocities);
        add_scaled(&mut stage.noise, half, &stage.velocities);
        if B::FLOWS || rest.is_some() {
            let mut predicted = stage.noise.clone();
            if let Some(others) = others {
                zero(&mut stage.velocities, frame.len());
                mobility.apply(&others, &mut stage.velocities);
                add_scaled(&mut predicted, half, &stage.velocities);
            }
            implicit.release(&scene, &predicted, false);
            implicit.solve(&scene, mobility)?;
        }
        if let Some(rest) = &mut rest {
            implicit.scatter(&mut stage.positions);
            let boundary = stage.settle(system)?;
            stage.evaluate(system, &boundary, *rest, &mut ())?;
            stage.rewind(system);
            zero(&mut stage.velocities, frame.len());
            mobility.apply(&stage.forces, &mut stage.velocities);
            add_scaled(&mut stage.noise, half, &stage.velocities);
        }
        implicit.release(&scene, &stage.noise, B::FLOWS);
        implicit.solve(&scene, mobility)?;
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
        let mut heard = T::default();
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
        self.propose(system, &field.0, Some(&mut field.1))?;
        self.accept(system, field, tally)
    }
}
