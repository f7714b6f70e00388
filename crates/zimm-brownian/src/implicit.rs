//! All molecules of a scene on their way through an implicit step: gathered from their cells, solved, put back.

use crate::{
    Mobility,
    columns::{norm, rescale},
    connected::{Block, Part, blocks},
    coupling::Coupling,
    flow::Carry,
    one_bond::lengths,
    relaxation::{Problem, Relaxation, Unsolved, end, safe},
    stage::zero,
};
use std::array::from_fn;
use zimm_core::{
    BondForce, Bonded, Boundary, DVec3, ForceError, Frame, ParameterError, StepError, each_block,
};

/// Bonds solved side by side where each is a molecule.
const LANES: usize = 8;
const ROUNDS: usize = 200;

/// What a step is about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scene<'a, S> {
    pub(crate) law: &'a S,
    pub(crate) carry: &'a Carry,
    pub(crate) dt: f64,
    pub(crate) kt: f64,
    pub(crate) step: u64,
    pub(crate) tolerance: f64,
}

/// The molecules, in blocks that are worked at in parallel.
#[derive(Clone, Debug, Default)]
pub(crate) struct Implicit {
    bonds: Vec<[u32; 2]>,
    particles: usize,
    works: Vec<Work>,
    /// What acts at the end of the step beside springs.
    pub(crate) others: Vec<DVec3>,
    coupling: Coupling,
}

/// The columns of one block, slot by slot. Positions are relative to the centre of the set, which goes with the flow.
#[derive(Clone, Debug, Default)]
struct Work {
    block: Block,
    places: Vec<u32>,
    /// Mobility of each bead alone.
    mobilities: Vec<f64>,
    /// That times the time its springs act.
    pull: Vec<f64>,
    /// Present positions, after any sudden strain.
    start: Vec<DVec3>,
    /// Forces of springs, all of them.
    springs: Vec<DVec3>,
    /// Forces of springs that are too strong to be taken at the beginning of the step; nothing, if none is.
    dropped: Vec<DVec3>,
    /// Positions at the end of the step but for the springs there.
    free: Vec<DVec3>,
    /// Those with what is lagged of the forces of other beads.
    target: Vec<DVec3>,
    /// The solution.
    solution: Vec<DVec3>,
    /// Lattice vectors, carried, from the whole molecule to where its beads are.
    images: Vec<DVec3>,
    /// Carried centre of each set, and the largest coordinate there.
    centres: Vec<(DVec3, f64)>,
    relaxation: Relaxation,
    outcome: Option<Unsolved>,
    torn: Option<ParameterError>,
}

impl Implicit {
    /// Sorts the bonds, if they are others than last time.
    pub(crate) fn know<S>(
        &mut self,
        bonded: &Bonded<S>,
        particles: usize,
    ) -> Result<(), ForceError> {
        if self.particles != particles || self.bonds != bonded.bonds() {
            let blocks = blocks(bonded.bonds(), particles)?;
            let work = |block| Work {
                block,
                ..Work::default()
            };
            self.works = blocks.into_iter().map(work).collect();
            bonded.bonds().clone_into(&mut self.bonds);
            self.particles = particles;
        }
        Ok(())
    }

    /// Gathers the molecules and the forces of their springs; `forces` are all that act now.
    pub(crate) fn gather<B: Boundary, S: BondForce, M: Mobility<B>>(
        &mut self,
        scene: &Scene<'_, S>,
        frame: &Frame<'_, B>,
        forces: &[DVec3],
        mobility: &M,
    ) -> Result<(), StepError> {
        for work in &mut self.works {
            let place = |&identity: &u32| frame.place(identity).unwrap_or(0) as u32;
            work.places.clear();
            work.places.extend(work.block.identities.iter().map(place));
            work.mobilities.clear();
            let alone = work.places.iter().map(|&p| mobility.alone(p as usize));
            work.mobilities.extend(alone);
        }
        each_block(&mut self.works, |_, work| {
            work.gather(scene, frame, forces);
        });
        match self.works.iter_mut().find_map(|work| work.torn.take()) {
            None => Ok(()),
            Some(source) => Err(StepError::Parameter {
                step: scene.step,
                source,
            }),
        }
    }

    /// Takes springs that are too strong off the forces on all beads; what is left may act at the beginning of the
    /// step.
    pub(crate) fn drop_from(&self, forces: &mut [DVec3]) {
        for work in &self.works {
            for (&place, dropped) in work.places.iter().zip(&work.dropped) {
                forces[place as usize] -= *dropped;
            }
        }
    }

    /// Takes all springs off the other forces.
    pub(crate) fn leave_others(&mut self) {
        for work in &self.works {
            for (&place, spring) in work.places.iter().zip(&work.springs) {
                self.others[place as usize] -= *spring;
            }
        }
    }

    /// Positions at the end of the step but for the springs there, from displacements by noise and explicit forces.
    /// The flow inside a molecule is that of its present configuration, or the mean of this and the last solution.
    pub(crate) fn release<S: BondForce>(
        &mut self,
        scene: &Scene<'_, S>,
        displacements: &[DVec3],
        corrected: bool,
    ) {
        let rate = scene.carry.rate;
        each_block(&mut self.works, |_, work| {
            work.free.clear();
            let slots = work.places.iter().zip(&work.start).zip(&work.solution);
            work.free.extend(slots.map(|((&place, &start), &solution)| {
                let inside = if corrected {
                    0.5 * (start + solution)
                } else {
                    start
                };
                start + rate * inside + displacements[place as usize]
            }));
        });
    }

    /// Takes forces for those at the end of the step until more is known: those of springs that are not too strong, and
    /// the others; `velocities` are what they move beads at. Nothing is carried over from the last step, so that a run
    /// may stop and go on.
    pub(crate) fn expect<B: Boundary, S, M: Mobility<B>>(
        &mut self,
        scene: &Scene<'_, S>,
        mobility: &M,
        forces: &[DVec3],
        velocities: &[DVec3],
    ) {
        if M::DIAGONAL {
            return;
        }
        let half = 0.5 * scene.dt;
        let coupling = &mut self.coupling;
        coupling.expect(half, mobility, forces, velocities);
        for work in &self.works {
            for (k, &place) in work.places.iter().enumerate() {
                let place = place as usize;
                let dropped = work.dropped.get(k).copied().unwrap_or_default();
                let tension = work.springs[k] - dropped;
                coupling.tension[place] = tension;
                coupling.pulled[place] = half * work.mobilities[k] * tension;
            }
        }
    }

    /// Lets springs and others act on the released beads, to the scene's tolerance of what springs do and to `rough` of
    /// all displacements.
    pub(crate) fn solve<B: Boundary, S: BondForce, M: Mobility<B>>(
        &mut self,
        scene: &Scene<'_, S>,
        mobility: &mut M,
        rough: f64,
    ) -> Result<(), StepError> {
        if M::DIAGONAL {
            let lagged = &mut self.coupling.lagged;
            lagged.clear();
            if !self.others.is_empty() {
                zero(lagged, self.particles);
                mobility.apply(&self.others, lagged);
                rescale(lagged, 0.5 * scene.dt);
            }
            self.coupling.factor = 1.0;
            self.solve_alone(scene)
        } else {
            self.solve_together(scene, mobility, rough)
        }
    }

    /// Positions of all beads, still to be wrapped.
    pub(crate) fn scatter(&self, positions: &mut [DVec3]) {
        for work in &self.works {
            for (part, (centre, _)) in work.block.parts.iter().zip(&work.centres) {
                for k in part.beads.clone() {
                    let place = work.places[k] as usize;
                    positions[place] = *centre + work.solution[k] + work.images[k];
                }
            }
        }
    }

    /// Solves as if every bead moved by its own force alone, by a factor faster than it would; what is lagged is added to
    /// the displacements.
    fn solve_alone<S: BondForce>(&mut self, scene: &Scene<'_, S>) -> Result<(), StepError> {
        let Coupling { lagged, factor, .. } = &self.coupling;
        let time = 0.5 * scene.dt * factor;
        each_block(&mut self.works, |_, work| work.solve(scene, time, lagged));
        match self.works.iter().find_map(|work| work.outcome) {
            None => Ok(()),
            Some(unsolved) => Err(StepError::NotSolved {
                step: scene.step,
                iterations: unsolved.iterations,
                reached: unsolved.reached,
                asked: scene.tolerance,
            }),
        }
    }

    /// Solves with all forces moving all beads. Each round solves for beads alone and lags the difference, which takes
    /// one product, of what has changed of the forces since the last; none if that is too little to matter. It converges
    /// if beads alone move at least half as fast as any set of forces of the same size moves them, so they are made to
    /// move faster when it does not.
    fn solve_together<B: Boundary, S: BondForce, M: Mobility<B>>(
        &mut self,
        scene: &Scene<'_, S>,
        mobility: &mut M,
        rough: f64,
    ) -> Result<(), StepError> {
        let (mut best, mut since, mut reached) = (f64::INFINITY, 0, f64::NAN);
        self.coupling.mixing.forget();
        for round in 0..ROUNDS {
            self.coupling.learn(0.5 * scene.dt, mobility, &self.others);
            let coupling = &mut self.coupling;
            if round == 0 {
                coupling.lag();
            } else {
                coupling.miss();
                let error = norm(&coupling.residual);
                reached = error / norm(&coupling.pulled).max(f64::MIN_POSITIVE);
                if error <= self.enough(scene, rough) {
                    return Ok(());
                }
                if reached.is_nan() {
                    break;
                }
                let coupling = &mut self.coupling;
                if error < 0.5 * best {
                    (best, since) = (error, 0);
                } else {
                    since += 1;
                }
                if since == 12 {
                    coupling.hasten();
                    (best, since) = (f64::INFINITY, 0);
                } else {
                    coupling
                        .mixing
                        .mix(&mut coupling.lagged, &coupling.residual);
                }
            }
            self.solve_alone(scene)?;
            let wrong = self.hear();
            if wrong <= self.enough(scene, rough) {
                return Ok(());
            }
        }
        Err(StepError::NotSolved {
            step: scene.step,
            iterations: ROUNDS,
            reached,
            asked: scene.tolerance,
        })
    }
}

impl Implicit {
    /// How small an error need be: a part of what springs do, and a rough part of all displacements.
    fn enough<S>(&self, scene: &Scene<'_, S>, rough: f64) -> f64 {
        let coupling = &self.coupling;
        let springs = norm(&coupling.pulled) / coupling.factor;
        let all = |work: &Work| -> f64 {
            let apart = work.solution.iter().zip(&work.start);
            apart.map(|(a, b)| (*a - *b).length_squared()).sum()
        };
        let all = if rough > 0.0 {
            self.works.iter().map(all).sum::<f64>().sqrt()
        } else {
            0.0
        };
        scene.tolerance * springs + rough * all
    }

    /// Hears of the forces of springs in the last solution. How wrong it can be, judged by what others did to beads so
    /// far: what the change of forces has done is not known yet.
    fn hear(&mut self) -> f64 {
        /// How much more others may do to beads than they have been seen to.
        const MORE: f64 = 2.0;
        let Coupling {
            moved,
            tension,
            pulled,
            lagged,
            gain,
            ..
        } = &mut self.coupling;
        let (mut known, mut unknown) = (0.0, 0.0);
        for work in &self.works {
            for (k, &place) in work.places.iter().enumerate() {
                let place = place as usize;
                let now = work.solution[k] - work.target[k];
                known += (moved[place] - pulled[place] - lagged[place]).length_squared();
                unknown += (now - pulled[place]).length_squared();
                pulled[place] = now;
                tension[place] = now / work.pull[k];
            }
        }
        known.sqrt() + MORE * *gain * unknown.sqrt()
    }
}

impl Work {
    fn gather<B: Boundary, S: BondForce>(
        &mut self,
        scene: &Scene<'_, S>,
        frame: &Frame<'_, B>,
        forces: &[DVec3],
    ) {
        let beads = self.places.len();
        self.start.clear();
        let places = self.places.iter().map(|&place| place as usize);
        self.start
            .extend(places.map(|place| frame.positions[place]));
        zero(&mut self.images, beads);
        zero(&mut self.springs, beads);
        self.dropped.clear();
        self.centres.clear();
        for number in 0..self.block.parts.len() {
            let part = self.block.parts[number].clone();
            if frame.boundary.cell().is_some() {
                self.unfold(scene, frame, &part);
            }
            let whole = &self.start[part.beads.clone()];
            let sum: DVec3 = whole.iter().sum();
            let centre = sum * (1.0 / whole.len() as f64);
            self.pull(scene, forces, &part, centre);

            for r in &mut self.start[part.beads.clone()] {
                *r = scene.carry.strain(*r - centre);
            }
            let there = scene.carry.whole * centre;
            let images = self.images[part.beads].iter();
            let apart = images.fold(DVec3::ZERO, |most, r| most.max(r.abs()));
            let extent = (there.abs() + apart).max_element();
            self.centres.push((there, extent));
        }
        self.solution.clone_from(&self.start);
    }

    /// Puts a set together that the cell has cut.
    fn unfold<B: Boundary, S>(&mut self, scene: &Scene<'_, S>, frame: &Frame<'_, B>, part: &Part) {
        let first = part.beads.start;
        let whole = &mut self.start[part.beads.clone()];
        for (k, &[i, j]) in self.block.links[part.links.clone()].iter().enumerate() {
            let (i, j) = (i as usize, j as usize);
            if k + 1 < whole.len() {
                let here = whole[j];
                let wrapped = frame.positions[self.places[first + i] as usize];
                whole[j] = whole[i] + frame.boundary.min_image(here - wrapped);
                self.images[first + j] = scene.carry.whole * (here - whole[j]);
            } else {
                let along = whole[i] - whole[j];
                let nearest = frame.boundary.min_image(along);
                if (along - nearest).length() > 1e-6 * frame.boundary.reach() {
                    let name = "length along its ring of a bond that closes it";
                    let allowed = "that of its nearest image";
                    self.torn = Some(ParameterError::new(name, along.length(), allowed));
                }
            }
        }
    }

    /// The forces of springs, and those that half a step of the trapezoidal rule would throw too far.
    fn pull<S: BondForce>(
        &mut self,
        scene: &Scene<'_, S>,
        forces: &[DVec3],
        part: &Part,
        centre: DVec3,
    ) {
        let whole = &self.start[part.beads.clone()];
        let mobilities = &self.mobilities[part.beads.clone()];
        let springs = &mut self.springs[part.beads.clone()];
        let limit = scene.law.limit();
        let bonds = self.block.links[part.links.clone()].iter().map(|&[i, j]| {
            let (i, j) = (i as usize, j as usize);
            let bond = whole[i] - whole[j];
            let force = scene.law.force(bond.length_squared()) * bond;
            let c = 0.5 * scene.dt * (mobilities[i] + mobilities[j]);
            (i, j, c, bond, force)
        });
        let mut far = false;
        for (i, j, c, _, force) in bonds.clone() {
            springs[i] += force;
            springs[j] -= force;
            far |= (c * force).length_squared() > limit * limit;
        }
        if !far {
            return;
        }
        // No balance of flow and other forces needs a tension of more than half of this.
        let places = self.places[part.beads.clone()].iter();
        let mut drive = 0.0;
        for (k, &place) in places.enumerate() {
            let carried = scene.carry.rate * (whole[k] - centre);
            let others = forces[place as usize] - springs[k];
            drive += carried.length() / (scene.dt * mobilities[k]) + others.length();
        }
        self.dropped.resize(self.places.len(), DVec3::ZERO);
        let dropped = &mut self.dropped[part.beads.clone()];
        for (i, j, c, bond, force) in bonds {
            let strong = force.dot(bond).abs() > 64.0 * scene.kt;
            if strong && c * force.length() > limit + 2.0 * c * drive {
                dropped[i] += force;
                dropped[j] -= force;
            }
        }
    }

    /// Solves for beads that move alone, with springs acting for a `time`.
    fn solve<S: BondForce>(&mut self, scene: &Scene<'_, S>, time: f64, lagged: &[DVec3]) {
        self.pull.clear();
        let pull = |mobility: &f64| (mobility * time).max(1e-300);
        self.pull.extend(self.mobilities.iter().map(pull));
        self.target.clone_from(&self.free);
        if !lagged.is_empty() {
            for (target, &place) in self.target.iter_mut().zip(&self.places) {
                *target += lagged[place as usize];
            }
        }
        self.outcome = None;
        let (pairs, others) = (self.block.pairs, self.block.parts.len());
        let mut first = 0;
        while first < pairs {
            let count = LANES.min(pairs - first);
            let solved = if count == LANES {
                self.solve_pairs::<LANES, S>(scene, first)
            } else {
                (first..pairs).all(|pair| self.solve_pairs::<1, S>(scene, pair))
            };
            if !solved {
                (first..first + count).for_each(|part| self.solve_part(scene, part));
            }
            first += count;
        }
        (pairs..others).for_each(|part| self.solve_part(scene, part));
    }

    /// Solves for pairs side by side; false if one of them is not solved.
    fn solve_pairs<const W: usize, S: BondForce>(
        &mut self,
        scene: &Scene<'_, S>,
        first: usize,
    ) -> bool {
        let beads = 2 * first..2 * (first + W);
        let free = &self.target[beads.clone()];
        let pull = &self.pull[beads.clone()];
        let solution = &mut self.solution[beads];
        let centres = &self.centres[first..first + W];
        let bonds: [DVec3; W] = from_fn(|w| free[2 * w] - free[2 * w + 1]);
        let displacement = bonds.map(DVec3::length);
        let limit = scene.law.limit();
        let c: [f64; W] = from_fn(|w| pull[2 * w] + pull[2 * w + 1]);
        let guess: [f64; W] = from_fn(|w| (solution[2 * w] - solution[2 * w + 1]).length());
        let ends = [end(scene.law); W];
        let found = lengths(scene.law, c, displacement, ends, guess, scene.tolerance);
        let Some(mut found) = found else {
            return false;
        };
        for w in 0..W {
            let (a, b) = (2 * w, 2 * w + 1);
            let middle = (pull[b] * free[a] + pull[a] * free[b]) * (1.0 / c[w]);
            let extent = centres[w].1 + middle.abs().max_element() + found[w];
            found[w] = found[w].min(limit * safe(scene.law, extent));
        }
        for w in 0..W {
            let pulled = if displacement[w] > 0.0 {
                (1.0 - found[w] / displacement[w]) / c[w] * bonds[w]
            } else {
                bonds[w]
            };
            solution[2 * w] = free[2 * w] - pull[2 * w] * pulled;
            solution[2 * w + 1] = free[2 * w + 1] + pull[2 * w + 1] * pulled;
        }
        true
    }

    fn solve_part<S: BondForce>(&mut self, scene: &Scene<'_, S>, number: usize) {
        let Part { beads, links } = self.block.parts[number].clone();
        let free = &mut self.target[beads.clone()];
        let solution = &mut self.solution[beads.clone()];
        if links.is_empty() {
            solution.copy_from_slice(free);
            return;
        }
        // Springs do not move the mean position weighed by friction. Digits are kept for what is relative to it.
        let pull = &self.pull[beads];
        let (middle, before) = (middle(free, pull), middle(solution, pull));
        free.iter_mut().for_each(|r| *r -= middle);
        solution.iter_mut().for_each(|r| *r -= before);
        let largest = |most: f64, r: &DVec3| most.max(r.abs().max_element());
        let reach = free.len() as f64 * scene.law.limit();
        let extent = free.iter().fold(0.0, largest).min(reach);
        let problem = Problem {
            law: scene.law,
            links: &self.block.links[links],
            free,
            pull,
            tolerance: scene.tolerance,
            extent,
        };
        if let Err(unsolved) = self.relaxation.solve(&problem, solution) {
            self.outcome = Some(unsolved);
        }
        let there = self.centres[number].1 + middle.abs().max_element() + extent;
        let safe = safe(scene.law, there);
        let fits = problem.fits(safe, solution);
        let scale = if fits { 1.0 } else { safe };
        solution.iter_mut().for_each(|r| *r = middle + scale * *r);
        free.iter_mut().for_each(|r| *r += middle);
    }
}

/// The mean position, weighed by friction.
fn middle(positions: &[DVec3], pull: &[f64]) -> DVec3 {
    let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
    for (r, pull) in positions.iter().zip(pull) {
        sum += *r / *pull;
        weights += 1.0 / pull;
    }
    sum / weights
}
