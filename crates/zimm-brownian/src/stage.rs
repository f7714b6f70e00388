//! The next state in the making. Steppers work on copies of the columns that move and swap them in at the end, so that
//! a step that fails leaves no trace.

use crate::{Mobility, Root, White};
use std::mem::swap;
use zimm_core::{
    Boundary, DVec3, ForceField, Frame, IVec3, ParameterError, StepError, System, Tally,
    for_each_chunk,
};

/// Working copies of the columns that move, and what moves them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stage {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) forces: Vec<DVec3>,
    pub(crate) velocities: Vec<DVec3>,
    pub(crate) noise: Vec<DVec3>,
    pub(crate) images: Vec<IVec3>,
    kept: Kept,
}

/// For how long a mobility serves.
#[derive(Clone, Debug, Default)]
struct Kept {
    /// More than one if it is kept.
    steps: u64,
    /// The step that it served last.
    last: Option<u64>,
    /// The particles that it was bound for.
    ids: Vec<u32>,
    len: usize,
    /// Whether its root has been taken.
    is_rooted: bool,
}

impl Kept {
    /// Whether what is bound serves this step: the same one tried again, or the next one of the same particles if a
    /// round of steps does not begin with it.
    fn serves<B: Boundary>(&self, frame: &Frame<'_, B>) -> bool {
        let step = frame.now.step;
        let follows = |last| step == last || (step == last + 1 && !step.is_multiple_of(self.steps));
        self.steps > 1
            && self.last.is_some_and(follows)
            && self.len == frame.len()
            && self.ids == frame.ids
    }
}

impl Stage {
    /// Keeps a mobility for so many steps.
    pub(crate) fn keep(&mut self, steps: u64) -> Result<(), ParameterError> {
        if steps == 0 {
            return Err(ParameterError::new("steps", 0.0, "at least 1"));
        }
        self.kept = Kept {
            steps,
            ..Kept::default()
        };
        Ok(())
    }

    /// Copies the present state. Forces that are not there are evaluated.
    pub(crate) fn open<B: Boundary, F: ForceField<B>>(
        &mut self,
        system: &System<B>,
        field: &mut F,
    ) -> Result<(), StepError> {
        self.rewind(system);
        let particles = &system.particles;
        particles.forces().clone_into(&mut self.forces);
        if self.forces.len() != particles.len() {
            zero(&mut self.forces, particles.len());
            let step = system.clock.next().step;
            return field
                .accumulate(&system.frame(), &mut self.forces, &mut ())
                .map_err(|source| StepError::Force { step, source });
        }
        Ok(())
    }

    /// Brings positions and images back to the present state.
    pub(crate) fn rewind<B: Boundary>(&mut self, system: &System<B>) {
        let particles = &system.particles;
        particles.positions().clone_into(&mut self.positions);
        particles.images().clone_into(&mut self.images);
    }

    /// The velocities `M F` and the random displacements of one step, sqrt(2 kT dt) M^(1/2) z, at the present state.
    pub(crate) fn drive<B: Boundary, M: Mobility<B>, R: Root<B, M>>(
        &mut self,
        system: &System<B>,
        mobility: &mut M,
        root: &mut R,
    ) -> Result<(), StepError> {
        self.shake(system, mobility, root)?;
        zero(&mut self.velocities, self.forces.len());
        mobility.apply(&self.forces, &mut self.velocities);
        Ok(())
    }

    /// Binds the mobility to the present state, unless it is kept, and draws the random displacements of one step.
    pub(crate) fn shake<B: Boundary, M: Mobility<B>, R: Root<B, M>>(
        &mut self,
        system: &System<B>,
        mobility: &mut M,
        root: &mut R,
    ) -> Result<(), StepError> {
        let (frame, step) = (system.frame(), system.clock.next().step);
        let kept = &mut self.kept;
        if !kept.serves(&frame) {
            (kept.last, kept.is_rooted) = (None, false);
            mobility
                .bind(&frame)
                .map_err(|source| StepError::Mobility { step, source })?;
            if kept.steps > 1 {
                frame.ids.clone_into(&mut kept.ids);
                kept.len = frame.len();
            }
        }
        kept.last = Some(frame.now.step);
        self.draw(system, mobility, root, &[])
    }

    /// Draws the random displacements of one step, for beads that have been drawn so many times already.
    pub(crate) fn draw<B: Boundary, M: Mobility<B>, R: Root<B, M>>(
        &mut self,
        system: &System<B>,
        mobility: &mut M,
        root: &mut R,
        attempts: &[u32],
    ) -> Result<(), StepError> {
        let (frame, next) = (system.frame(), system.clock.next());
        zero(&mut self.noise, frame.len());
        if next.kt > 0.0 {
            let scale = (2.0 * next.kt * next.dt).sqrt();
            let white = White::new(next, &frame).again(attempts);
            let step = next.step;
            let (noise, is_rooted) = (&mut self.noise, &mut self.kept.is_rooted);
            let done = if std::mem::take(is_rooted) {
                root.again(mobility, &white, scale, noise)
            } else {
                root.add(mobility, &white, scale, noise)
            };
            done.map_err(|source| StepError::Mobility { step, source })?;
            *is_rooted = true;
        }
        Ok(())
    }

    /// Carries every position by the flow over one step, then displaces it: Euler's step.
    pub(crate) fn carry<B: Boundary>(&mut self, system: &System<B>) {
        let (now, next) = (system.clock.now(), system.clock.next());
        let carry = system.boundary.carry(now.time, next.time);
        let (velocities, noise) = (&self.velocities, &self.noise);
        for_each_chunk(&mut self.positions, |start, chunk| {
            for (k, r) in chunk.iter_mut().enumerate() {
                let there = if B::FLOWS { carry * *r } else { *r };
                *r = there + now.dt * velocities[start + k] + noise[start + k];
            }
        });
    }

    /// Advances a copy of the boundary by one step and wraps the particles into it.
    pub(crate) fn settle<B: Boundary>(&mut self, system: &System<B>) -> Result<B, StepError> {
        system
            .settle(&mut self.positions, &mut self.images)
            .map_err(|particle| StepError::NotFinite {
                step: system.clock.next().step,
                particle,
                force: self.forces[particle].to_array(),
            })
    }

    /// Evaluates the forces of the new state.
    pub(crate) fn evaluate<B: Boundary, F: ForceField<B>, T: Tally>(
        &mut self,
        system: &System<B>,
        boundary: &B,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError> {
        let mut frame = system.frame();
        frame.now = system.clock.next();
        frame.boundary = boundary;
        frame.positions = &self.positions;
        frame.images = &self.images;
        zero(&mut self.forces, frame.len());
        let step = frame.now.step;
        field
            .accumulate(&frame, &mut self.forces, tally)
            .map_err(|source| StepError::Force { step, source })?;
        match self.forces.iter().position(|f| !f.is_finite()) {
            None => Ok(()),
            Some(particle) => Err(StepError::NotFinite {
                step,
                particle,
                force: self.forces[particle].to_array(),
            }),
        }
    }

    /// Makes the stage the system's state.
    pub(crate) fn commit<B: Boundary>(&mut self, system: &mut System<B>, boundary: B) {
        let columns = system.particles.columns_mut();
        swap(columns.positions, &mut self.positions);
        swap(columns.forces, &mut self.forces);
        swap(columns.images, &mut self.images);
        system.boundary = boundary;
        system.clock.tick();
    }
}

pub(crate) fn zero(column: &mut Vec<DVec3>, len: usize) {
    column.clear();
    column.resize(len, DVec3::ZERO);
}
