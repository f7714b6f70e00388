//! Euler's scheme for springs of finite length, by drawing again what would overstretch them.

use crate::{
    Mobility, Root,
    connected::{Part, blocks},
    stage::Stage,
};
use zimm_core::{
    BondForce, Bonded, Boundary, ForceError, ForceField, ParameterError, StepError, Stepper,
    System, Tally,
};

/// Euler and Maruyama's scheme with rejection: a molecule one of whose springs would be stretched beyond its limit is
/// moved again with new noise, until it fits (Jain 2013, section 5.8).
///
/// What is drawn again is the noise of the whole molecule, that is of all beads that are joined to the spring by
/// others; other molecules keep theirs. With hydrodynamic interactions the root of the mobility is then applied
/// anew, so that others are displaced a little differently as well, and are looked at again.
///
/// It is here to be compared with, for two reasons. Moves that are drawn until they fit leave fewer springs near their
/// full length than there should be: without a force, the density is multiplied by the probability that a move fits
/// at once. And new noise does not help a spring so near its limit that its own pull throws it across and beyond: that
/// ends as an error. Time steps of 1e-4 are needed where implicit schemes take 1e-2.
///
/// ```
/// use zimm_brownian::{Diagonal, FreeDraining, Rejection};
/// use zimm_core::{Bonded, Clock, DVec3, Open, Particles, Stepper, System};
/// use zimm_forces::Fene;
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?;
/// let mut system = System::new(Open, particles, Clock::new(0.05, 1.0, 1)?);
/// let mut springs = Bonded::new(Fene::new(1.0, 5.0_f64.sqrt())?, vec![[0, 1]]);
/// let mut stepper = Rejection::new(FreeDraining::new(4.0)?, Diagonal, &springs);
/// for _ in 0..1000 {
///     stepper.step(&mut system, &mut springs, &mut ())?;
/// }
/// assert!(stepper.rejections() > 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rejection<M, R> {
    mobility: M,
    root: R,
    bonds: Vec<[u32; 2]>,
    limit: f64,
    most: u32,
    /// By identity: the number of its molecule.
    molecules: Vec<usize>,
    /// By place: how often the noise was drawn again in this step.
    attempts: Vec<u32>,
    rejected: Vec<bool>,
    rejections: u64,
    stage: Stage,
}

impl<M, R> Rejection<M, R> {
    /// The scheme for molecules that are held together by these springs. A step is an error if a molecule has to be
    /// drawn again more than 1000 times.
    pub fn new<S: BondForce>(mobility: M, root: R, springs: &Bonded<S>) -> Self {
        Self {
            mobility,
            root,
            bonds: springs.bonds().to_vec(),
            limit: springs.spring().limit(),
            most: 1000,
            molecules: Vec::new(),
            attempts: Vec::new(),
            rejected: Vec::new(),
            rejections: 0,
            stage: Stage::default(),
        }
    }

    /// At most so many attempts for a molecule after the first.
    ///
    /// # Errors
    /// If `attempts` is 2^31 or more.
    pub fn within(mut self, attempts: u32) -> Result<Self, ParameterError> {
        const MOST: u32 = 1 << 31;
        if attempts >= MOST {
            let found = f64::from(attempts);
            return Err(ParameterError::new("attempts", found, "below 2^31"));
        }
        self.most = attempts;
        Ok(self)
    }

    /// Moves of molecules that were rejected so far.
    pub fn rejections(&self) -> u64 {
        self.rejections
    }

    /// Numbers the molecules of so many particles.
    fn sort(&mut self, particles: usize) -> Result<(), ForceError> {
        if self.molecules.len() == particles {
            return Ok(());
        }
        let blocks = blocks(&self.bonds, particles)?;
        self.molecules.resize(particles, 0);
        let molecules = blocks.iter().flat_map(|block| {
            let beads = |part: &Part| &block.identities[part.beads.clone()];
            block.parts.iter().map(beads)
        });
        for (number, beads) in molecules.enumerate() {
            for &identity in beads {
                self.molecules[identity as usize] = number;
            }
        }
        Ok(())
    }

    /// Counts another attempt for every bead of the molecules that are overstretched. A spring that is, if there is one.
    fn reject<B: Boundary>(&mut self, system: &System<B>, boundary: &B) -> Option<ForceError> {
        let frame = system.frame();
        let mut found = None;
        self.rejected.clear();
        self.rejected.resize(self.molecules.len(), false);
        for (bond, &[i, j]) in self.bonds.iter().enumerate() {
            let (Some(first), Some(second)) = (frame.place(i), frame.place(j)) else {
                continue;
            };
            let positions = &self.stage.positions;
            let r = boundary.min_image(positions[first] - positions[second]);
            if r.length_squared() >= self.limit * self.limit {
                let molecule = self.molecules[i as usize];
                self.rejections += u64::from(!self.rejected[molecule]);
                self.rejected[molecule] = true;
                found = Some(ForceError::Overstretched {
                    bond,
                    i,
                    j,
                    length: r.length(),
                    limit: self.limit,
                });
            }
        }
        for (identity, &molecule) in (0..).zip(&self.molecules) {
            if self.rejected[molecule]
                && let Some(place) = frame.place(identity)
            {
                self.attempts[place] += 1;
            }
        }
        found
    }
}

impl<B: Boundary, F: ForceField<B>, M: Mobility<B>, R: Root<B, M>> Stepper<B, F>
    for Rejection<M, R>
{
    fn step<T: Tally>(
        &mut self,
        system: &mut System<B>,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError> {
        let step = system.clock.next().step;
        self.sort(system.particles.len())
            .map_err(|source| StepError::Force { step, source })?;
        self.attempts.clear();
        self.attempts.resize(system.particles.len(), 0);
        self.stage.open(system, field)?;
        self.stage
            .drive(system, &mut self.mobility, &mut self.root)?;
        let mut attempt = 0;
        let boundary = loop {
            self.stage.carry(system);
            let boundary = self.stage.settle(system)?;
            let Some(source) = self.reject(system, &boundary) else {
                break boundary;
            };
            if attempt == self.most {
                return Err(StepError::Force { step, source });
            }
            attempt += 1;
            let (mobility, root) = (&mut self.mobility, &mut self.root);
            self.stage.draw(system, mobility, root, &self.attempts)?;
            self.stage.rewind(system);
        };
        let stage = &mut self.stage;
        let mut heard = tally.fresh();
        stage.evaluate(system, &boundary, field, &mut heard)?;
        stage.commit(system, boundary);
        tally.absorb(heard);
        Ok(())
    }
}
