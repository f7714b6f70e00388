//! Successive states of a run, on which parts of a step are tried one by one.

use crate::timing::seconds;
use crate::{Problem, scene};
use zimm::prelude::*;

/// The fluid of Groot and Warren in a cell, settled.
pub(crate) fn fluid<B: Periodic>(space: B, quick: bool) -> Result<Film<B>, Problem> {
    let (mut system, field) = scene::equilibrated(space);
    Film::shoot(
        &mut system,
        &mut (field, ()),
        &mut GrootWarren::new(0.65)?,
        quick,
    )
}

/// States one step apart. The list of the run that was filmed was made at the second of them, and would have been made
/// anew after the last.
pub(crate) struct Film<B> {
    states: Vec<System<B>>,
    /// Steps that a list lives.
    pub(crate) life: f64,
}

impl<B: Periodic> Film<B> {
    /// Films a run for twenty steps at least, and for half a million of particles' steps unless it is to be quick.
    pub(crate) fn shoot<L: PairForce, R: ForceField<B>>(
        system: &mut System<B>,
        field: &mut (Pairwise<L, VerletList>, R),
        stepper: &mut GrootWarren,
        quick: bool,
    ) -> Result<Self, Problem> {
        const LEAST: usize = 20;
        const WORK: usize = 500_000;
        let work = if quick { 0 } else { WORK };
        let length = (work / system.particles.len()).max(LEAST);
        let mut first = 0;
        let mut states = Vec::new();
        loop {
            let made = field.0.neighbours().builds();
            let before = system.clone();
            stepper.step(system, field, &mut ())?;
            let is_new = field.0.neighbours().builds() > made;
            if is_new && states.is_empty() {
                first = made + 1;
                states.push(before);
            } else if is_new && states.len() > length {
                break;
            }
            if !states.is_empty() {
                states.push(system.clone());
            }
        }
        let lists = field.0.neighbours().builds() - first;
        Ok(Self {
            life: (states.len() - 1) as f64 / lists as f64,
            states,
        })
    }

    /// The same film of particles with other columns.
    pub(crate) fn with(
        &self,
        change: impl Fn(Particles) -> Result<Particles, ParticleError>,
    ) -> Result<Self, Problem> {
        let mut states = self.states.clone();
        for state in &mut states {
            state.particles = change(state.particles.clone())?;
        }
        Ok(Self { states, ..*self })
    }

    /// The particles of the first state.
    pub(crate) fn first(&self) -> &Particles {
        &self.states[0].particles
    }

    /// How many there are.
    pub(crate) fn particles(&self) -> usize {
        self.first().len()
    }

    /// Particles of all states whose forces are evaluated when the film is played.
    pub(crate) fn heard(&self) -> usize {
        (self.states.len() - 1) * self.particles()
    }

    /// The forces at one state.
    pub(crate) fn forces_once(
        &self,
        field: &mut impl ForceField<B>,
    ) -> Result<Vec<DVec3>, Problem> {
        let mut forces = vec![DVec3::ZERO; self.particles()];
        field.accumulate(&self.states[1].frame(), &mut forces, &mut ())?;
        Ok(forces)
    }

    /// Forces at every state.
    pub(crate) fn forces<F: ForceField<B>, T: Tally>(
        &self,
        field: &mut F,
        tally: &mut T,
    ) -> Result<f64, Problem> {
        let mut forces = vec![DVec3::ZERO; self.particles()];
        self.play(&self.states[1..], |system| {
            Ok(field.accumulate(&system.frame(), &mut forces, tally)?)
        })
    }

    /// The list alone, which looks at every state so many times.
    pub(crate) fn list(
        &self,
        list: &mut VerletList,
        cutoff: f64,
        looks: usize,
    ) -> Result<f64, Problem> {
        self.play(&self.states[1..], |system| {
            for _ in 0..looks {
                list.refresh(&system.frame(), cutoff)?;
            }
            Ok(())
        })
    }

    /// Whole steps, each from a state of the film to the next.
    pub(crate) fn steps<F: ForceField<B>, T: Tally>(
        &self,
        field: &mut F,
        stepper: &mut impl Stepper<B, F>,
        tally: &mut T,
    ) -> Result<f64, Problem> {
        let before = &self.states[..self.states.len() - 1];
        self.play(before, |system| Ok(stepper.step(system, field, tally)?))
    }

    /// Times something at one state after the other, in nanoseconds for a particle. Each is copied to the same place
    /// before, so that it is in the caches as in a run.
    fn play(
        &self,
        states: &[System<B>],
        mut each: impl FnMut(&mut System<B>) -> Result<(), Problem>,
    ) -> Result<f64, Problem> {
        let mut system = self.states[0].clone();
        let mut time = 0.0;
        for state in states {
            system.boundary.clone_from(&state.boundary);
            system.clock = state.clock;
            let (from, to) = (&state.particles, system.particles.columns_mut());
            from.positions().clone_into(to.positions);
            from.velocities().clone_into(to.velocities);
            from.forces().clone_into(to.forces);
            from.images().clone_into(to.images);
            time += seconds(|| each(&mut system))?;
        }
        Ok(1e9 * time / (states.len() * self.particles()) as f64)
    }
}
