//! The next state in the making. Steppers work on copies of the columns that move and swap them in at the end, so that
//! a step that fails leaves no trace.

use std::mem::swap;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use zimm_core::{Boundary, DMat3, DVec3, ForceField, IVec3, StepError, System, Tally, for_each_chunk};

/// Working copies of the columns that move.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stage {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) velocities: Vec<DVec3>,
    pub(crate) forces: Vec<DVec3>,
    images: Vec<IVec3>,
}

impl Stage {
    /// Copies the present state. Velocities that are not there are zero, forces that are not there are evaluated.
    pub(crate) fn open<B: Boundary, F: ForceField<B>>(
        &mut self,
        system: &System<B>,
        field: &mut F,
    ) -> Result<(), StepError> {
        let particles = &system.particles;
        self.positions.clone_from_slice_of(particles.positions());
        self.images.clone_from_slice_of(particles.images());
        self.velocities.clone_from_slice_of(particles.velocities());
        self.velocities.resize(particles.len(), DVec3::ZERO);
        if particles.forces().is_empty() {
            let mut frame = system.frame();
            frame.velocities = &self.velocities;
            zero(&mut self.forces, particles.len());
            let step = system.clock.next().step;
            field
                .accumulate(&frame, &mut self.forces, &mut ())
                .map_err(|source| StepError::Force { step, source })
        } else {
            self.forces.clone_from_slice_of(particles.forces());
            Ok(())
        }
    }

    /// Lets particles move freely for a while.
    pub(crate) fn stream<B: Boundary>(&mut self, streaming: &Streaming) {
        let velocities = &self.velocities;
        for_each_chunk(&mut self.positions, |start, chunk| {
            for (r, &c) in chunk.iter_mut().zip(&velocities[start..]) {
                *r = if B::FLOWS {
                    streaming.carry * *r + streaming.reach * c
                } else {
                    *r + streaming.dt * c
                };
            }
        });
        streaming.turn::<B>(&mut self.velocities);
    }

    /// Advances a copy of the boundary by one step and wraps the particles into it.
    pub(crate) fn settle<B: Boundary>(&mut self, system: &System<B>) -> Result<B, StepError> {
        let mut boundary = system.boundary.clone();
        let remap = boundary.advance(system.clock.next().time);
        let positions = &self.positions;
        for_each_chunk(&mut self.images, |start, chunk| {
            for (image, &r) in chunk.iter_mut().zip(&positions[start..]) {
                *image = remap.apply(*image).wrapping_add(boundary.wrap(r).1);
            }
        });
        let found = AtomicBool::new(true);
        for_each_chunk(&mut self.positions, |_, chunk| {
            let mut all = true;
            for r in chunk {
                let (folded, count) = boundary.wrap(*r);
                all &= is_moderate(folded) & is_near(count);
                // A position that cannot be placed is left for the search below.
                *r = if is_near(count) { folded } else { DVec3::NAN };
            }
            if !all {
                found.store(false, Relaxed);
            }
        });
        if found.into_inner() {
            Ok(boundary)
        } else {
            Err(self.not_finite(system, &self.positions))
        }
    }

    /// Evaluates the forces of the new state. `velocities` are those that friction is to see, if not the stage's own.
    pub(crate) fn evaluate<B: Boundary, F: ForceField<B>, T: Tally>(
        &mut self,
        system: &System<B>,
        boundary: &B,
        velocities: Option<&[DVec3]>,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError> {
        let mut frame = system.frame();
        frame.now = system.clock.next();
        frame.boundary = boundary;
        frame.positions = &self.positions;
        frame.velocities = velocities.unwrap_or(&self.velocities);
        frame.images = &self.images;
        zero(&mut self.forces, frame.len());
        let step = frame.now.step;
        field
            .accumulate(&frame, &mut self.forces, tally)
            .map_err(|source| StepError::Force { step, source })
    }

    /// Makes the stage the system's state; the former state becomes the stage.
    pub(crate) fn commit<B: Boundary>(&mut self, system: &mut System<B>, boundary: B) {
        let columns = system.particles.columns_mut();
        swap(columns.positions, &mut self.positions);
        swap(columns.velocities, &mut self.velocities);
        swap(columns.forces, &mut self.forces);
        swap(columns.images, &mut self.images);
        system.boundary = boundary;
        system.clock.tick();
    }
}
