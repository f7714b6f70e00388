//! Chains, put together from the types that the options name.

use super::model::{Law, Model};
use super::theory::rouse_times;
use super::{FRICTION, KT};
use crate::Problem;
use crate::options::Hydrodynamics;
use zimm::prelude::*;

/// Relative error of mobilities and of their roots, far below what the noise hides.
const ERROR: f64 = 1e-3;
const SKIN: f64 = 0.5;

/// Chains, what acts on them and what moves them.
pub(crate) struct Scene<B, S, X, M, R> {
    pub(crate) system: System<B>,
    pub(crate) chains: Molecules,
    field: (Bonded<S>, X),
    stepper: SemiImplicit<M, R>,
}

/// What is done with chains of any springs, with and without excluded volume and hydrodynamic interactions.
pub(crate) trait Experiment {
    /// Where it is done.
    type Space: Boundary;
    /// What comes of it.
    type Answer;

    /// Does it.
    fn run<S, X, M, R>(
        &self,
        scene: Scene<Self::Space, S, X, M, R>,
    ) -> Result<Self::Answer, Problem>
    where
        S: BondForce,
        X: ForceField<Self::Space>,
        M: Mobility<Self::Space>,
        R: Root<Self::Space, M>;
}

/// Does an experiment with `count` chains that do not know of each other, in open space, beginning in the equilibrium
/// of their springs.
pub(crate) fn isolated<E: Experiment>(
    experiment: &E,
    model: &Model,
    count: u32,
    space: E::Space,
    clock: Clock,
) -> Result<E::Answer, Problem> {
    let chains = Molecules::linear(0, count, model.beads)?;
    let bond = start::BondLength::new(&model.spring(), KT)?;
    let mut rng = start::stream(clock.now().seed);
    let positions = start::isolated(&chains, |rng| bond.sample(rng), &mut rng);
    let system = System::new(space, Particles::new(positions)?, clock);
    let repulsion = model.excluded_volume();
    let repulsion = repulsion.map(|law| Pairwise::new(law, WithinMolecules::new(chains)));
    let (free, diagonal) = (FreeDraining::new(FRICTION)?, Diagonal);
    match model.hydrodynamics {
        Hydrodynamics::Rpy => {
            let mobility = Rpy::new(FRICTION, model.radius)?.within(chains);
            let stepper = SemiImplicit::new(mobility, Cholesky::new(ERROR)?);
            with_forces(experiment, model, system, chains, repulsion, stepper)
        }
        _ => {
            let stepper = SemiImplicit::new(free, diagonal);
            with_forces(experiment, model, system, chains, repulsion, stepper)
        }
    }
}

/// Does an experiment with chains in a periodic cell, at the concentration of the model.
pub(crate) fn in_cell<E: Experiment>(
    experiment: &E,
    model: &Model,
    space: E::Space,
    clock: Clock,
) -> Result<E::Answer, Problem>
where
    E::Space: Periodic,
{
    let beads = model.bead_concentration()? * space.lattice().volume();
    let count = (beads / f64::from(model.beads)).round().max(1.0) as u32;
    let chains = Molecules::linear(0, count, model.beads)?;
    let bond = start::BondLength::new(&model.spring(), KT)?;
    let mut rng = start::stream(clock.now().seed);
    let positions = start::chains(space.lattice(), &chains, |rng| bond.sample(rng), &mut rng);
    let system = System::new(space, Particles::new(positions)?, clock);
    let list = VerletList::new(SKIN)?;
    let repulsion = model.excluded_volume();
    let repulsion = repulsion.map(|law| Pairwise::new(law, list));
    match model.hydrodynamics {
        Hydrodynamics::Mesh => {
            let mobility = Mesh::new(FRICTION, model.radius, ERROR)?;
            let stepper = SemiImplicit::new(mobility, SplitNoise::new(ERROR)?);
            with_forces(experiment, model, system, chains, repulsion, stepper)
        }
        _ => {
            let mobility = Ewald::new(FRICTION, model.radius, ERROR)?;
            let stepper = SemiImplicit::new(mobility, Lanczos::new(ERROR)?);
            with_forces(experiment, model, system, chains, repulsion, stepper)
        }
    }
}

fn with_forces<E, P, M, R>(
    experiment: &E,
    model: &Model,
    system: System<E::Space>,
    chains: Molecules,
    repulsion: Option<P>,
    stepper: SemiImplicit<M, R>,
) -> Result<E::Answer, Problem>
where
    E: Experiment,
    P: ForceField<E::Space>,
    M: Mobility<E::Space>,
    R: Root<E::Space, M>,
{
    match repulsion {
        None => with_springs(experiment, model, system, chains, (), stepper),
        Some(pairs) => with_springs(experiment, model, system, chains, pairs, stepper),
    }
}

fn with_springs<E, X, M, R>(
    experiment: &E,
    model: &Model,
    system: System<E::Space>,
    chains: Molecules,
    rest: X,
    stepper: SemiImplicit<M, R>,
) -> Result<E::Answer, Problem>
where
    E: Experiment,
    X: ForceField<E::Space>,
    M: Mobility<E::Space>,
    R: Root<E::Space, M>,
{
    let bonds = chains.bonds();
    macro_rules! run {
        ($spring:expr) => {
            experiment.run(Scene {
                system,
                chains,
                field: (Bonded::new($spring, bonds), rest),
                stepper,
            })
        };
    }
    match model.spring() {
        Law::Fene(spring) => run!(spring),
        Law::Hooke(spring) => run!(spring),
        Law::Wlc(spring) => run!(spring),
    }
}

impl<B, S, X, M, R> Scene<B, S, X, M, R>
where
    B: Boundary,
    S: BondForce,
    X: ForceField<B>,
    M: Mobility<B>,
    R: Root<B, M>,
{
    /// The longest relaxation time of Rouse chains of this length.
    pub(crate) fn longest_time(&self) -> f64 {
        rouse_times(self.chains.beads()).next().unwrap_or(1.0)
    }

    /// Goes on to a step, the last one with a tally. Isolated chains are brought back to the origin now and then, from
    /// where the flow would carry them.
    pub(crate) fn go_to<T: Tally + Default>(&mut self, step: u64) -> Result<T, Problem> {
        const BETWEEN: u64 = 10;
        let (system, field) = (&mut self.system, &mut self.field);
        let is_open = system.boundary.cell().is_none();
        while system.clock.next().step < step {
            self.stepper.step(system, field, &mut ())?;
            if is_open && system.clock.now().step.is_multiple_of(BETWEEN) {
                recentre(system, &self.chains)?;
            }
        }
        let mut tally = T::default();
        self.stepper.step(system, field, &mut tally)?;
        if is_open {
            recentre(system, &self.chains)?;
        }
        Ok(tally)
    }

    /// The step that is first at or after a time.
    pub(crate) fn step_at(&self, time: f64) -> u64 {
        (time / self.system.clock.now().dt).ceil() as u64
    }
}
