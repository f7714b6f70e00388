//! The solution: its beads and springs, how it begins, and how it is kept.

use crate::Problem;
use crate::options::{Flow, Solvent, Start};
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::path::Path;
use zimm::prelude::*;

pub(crate) const KT: f64 = 1.0;
pub(crate) const DT: f64 = 0.02;
const DENSITY: f64 = 4.0;
const REPULSION: f64 = 18.75;
const REPULSION_OF_GOOD_SOLVENT: f64 = 13.125;
const BATH_RATE: f64 = 5.0;
const SKIN: f64 = 0.35;
pub(crate) const BEADS: u32 = 20;
const LIMIT: f64 = 5.0;
pub(crate) const CONTOUR: f64 = (BEADS - 1) as f64 * LIMIT;
const EXTENSIBILITY: f64 = 50.0;
/// <Q^2> of a spring: 3 Q_0^2 / (b + 5).
pub(crate) const SQUARE_OF_SPRING: f64 = 3.0 * LIMIT * LIMIT / (EXTENSIBILITY + 5.0);
/// Range of the springs' repulsion, and of the distances in the picture.
pub(crate) const SPRINGS_CUTOFF: f64 = 1.0 / 3.0;
/// At which c / c* = 1 is one bead in ten.
const RADIUS_OF_GYRATION: f64 = 2.285;
/// Measured as chains came back from a stretch at c / c* = 0.5: 90 +- 7.
pub(crate) const RELAXATION_TIME: f64 = 90.0;
/// Images of the cell stay this far apart: twice as far as a spring may reach. In fast flow some do.
pub(crate) const IMAGES: f64 = 2.0 * LIMIT;
/// Share of the volume near springs from which their repulsion is more than a hindrance to crossing.
pub(crate) const CROWDED: f64 = 0.5;
pub(crate) const STEPS_PER_CHECKPOINT: u64 = 500;

type Beads = Pairwise<DpdConservative<SpeciesMatrix<2>>, VerletList>;
pub(crate) type Forces = (
    Beads,
    Bonded<Fene>,
    SegmentRepulsion<KumarLarson, VerletList>,
);

/// All that a run begins with. Printed, it is the line by which a checkpoint knows its own; only the time may grow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solution {
    pub(crate) concentration: f64,
    pub(crate) solvent: Solvent,
    pub(crate) flow: Flow,
    pub(crate) rate: f64,
    pub(crate) contact_force: f64,
    pub(crate) images: f64,
    pub(crate) start: Start,
    pub(crate) seed: u64,
}

impl fmt::Display for Solution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            concentration,
            solvent,
            flow,
            rate,
            contact_force,
            images,
            start,
            seed,
        } = self;
        write!(
            f,
            "concentration {concentration} solvent {solvent:?} flow {flow:?} rate {rate} \
             contact force {contact_force} images {images} start {start:?} seed {seed}"
        )
    }
}

impl Solution {
    pub(crate) fn deborah(&self) -> f64 {
        self.rate * RELAXATION_TIME
    }

    pub(crate) fn chains(&self, lattice: &Lattice) -> Result<Molecules, Problem> {
        let overlap = overlap_concentration(BEADS as usize, RADIUS_OF_GYRATION)?;
        let beads = self.concentration * overlap * lattice.volume();
        let chains = (beads / f64::from(BEADS)).round();
        let most = DENSITY * lattice.volume() / f64::from(BEADS);
        if (1.0..=most).contains(&chains) {
            Ok(Molecules::linear(0, chains as u32, BEADS)?)
        } else {
            let why = format!("{chains} chains of {BEADS} beads, but has room for 1 to {most:.0}");
            let concentration = self.concentration;
            Err(format!("--concentration {concentration}: the cell would hold {why}").into())
        }
    }

    pub(crate) fn forces(&self, chains: &Molecules) -> Result<Forces, Problem> {
        let unlike = match self.solvent {
            Solvent::Theta => REPULSION,
            Solvent::Good => REPULSION_OF_GOOD_SOLVENT,
        };
        let repulsion = SpeciesMatrix::new([[REPULSION, unlike], [unlike, REPULSION]])?;
        let beads = DpdConservative::new(repulsion, 1.0)?;
        let law = KumarLarson::with_contact_force(self.contact_force, 10.0, SPRINGS_CUTOFF)?;
        Ok((
            Pairwise::new(beads, VerletList::new(SKIN)?),
            Bonded::new(spring()?, chains.bonds()),
            SegmentRepulsion::new(law, chains.bonds(), VerletList::new(SKIN)?),
        ))
    }

    /// Chains, solvent anywhere, overlaps parted.
    pub(crate) fn begin<B: Periodic>(
        &self,
        space: B,
        chains: &Molecules,
        forces: &mut Forces,
    ) -> Result<System<B>, Problem> {
        let (lattice, mut rng) = (*space.lattice(), start::stream(self.seed));
        let positions = match self.start {
            Start::Coils => {
                let bond = start::BondLength::new(forces.1.spring(), KT)?;
                start::chains(&lattice, chains, |rng| bond.sample(rng), &mut rng)
            }
            Start::Stretched => {
                start::stretched(&lattice, chains, 0.5 * LIMIT * DVec3::X, &mut rng)
            }
        };
        let positions = start::fill(&lattice, positions, DENSITY, &mut rng)?;
        let mut species = chains.species(&[(BEADS, 0)])?;
        species.resize(positions.len(), 1);
        let particles = Particles::new(positions)?.with_species(species)?;
        let velocities = start::velocities(&particles, KT, &mut rng)?;
        let particles = particles.with_velocities(velocities)?;
        let mut system = System::new(space, particles, Clock::new(DT, KT, self.seed)?);
        start::relax(&mut system, forces, 0.03, 100)?;
        Ok(system)
    }

    /// Scene, state and what was measured in one file, which takes the place of the former when it is complete.
    pub(crate) fn keep<B: Periodic>(
        &self,
        path: &Path,
        system: &System<B>,
        forces: &mut impl ForceField<B>,
        measured: &[f64],
    ) -> Result<(), Problem> {
        let part = path.with_extension("part");
        let mut file = BufWriter::new(File::create(&part)?);
        writeln!(file, "{self}")?;
        save(system, forces, &mut file)?;
        for x in measured {
            file.write_all(&x.to_le_bytes())?;
        }
        file.into_inner()?.sync_all()?;
        Ok(fs::rename(part, path)?)
    }

    /// State and measurements of an interrupted run.
    pub(crate) fn go_on<B: Periodic>(
        &self,
        path: &Path,
        space: B,
    ) -> Result<(System<B>, Vec<f64>), Problem> {
        let mut file = BufReader::new(File::open(path)?);
        let (mut found, scene) = (String::new(), self.to_string());
        file.read_line(&mut found)?;
        if found.trim_end() != scene {
            let (name, found) = (path.display(), found.trim_end());
            return Err(format!("{name} is of another run, {found}; this one is {scene}").into());
        }
        let system = load(space, &mut file)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        let eights = bytes.as_chunks().0.iter();
        Ok((
            system,
            eights.map(|eight| f64::from_le_bytes(*eight)).collect(),
        ))
    }
}

pub(crate) fn spring() -> Result<Fene, ParameterError> {
    Fene::with_extensibility(EXTENSIBILITY, LIMIT, KT)
}

pub(crate) fn stepper() -> Result<LoweAndersen<VerletList>, Problem> {
    Ok(LoweAndersen::new(BATH_RATE, 1.0, VerletList::new(SKIN)?)?)
}

pub(crate) fn progress_bar(what: &str, steps: u64) -> ProgressBar {
    let template = format!("{what} [{{bar:40}}] {{percent:>3}} %, {{eta}} left, {{msg}}");
    let style = ProgressStyle::with_template(&template);
    ProgressBar::new(steps).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Springs from bead to bead.
pub(crate) fn spans<B: Periodic>(system: &System<B>, bonds: &[[u32; 2]]) -> Vec<DVec3> {
    let frame = system.frame();
    let position = |id| frame.place(id).map(|place| frame.positions[place]);
    let span = |&[i, j]: &[u32; 2]| {
        let span = position(i)? - position(j)?;
        Some(system.boundary.min_image(span))
    };
    bonds.iter().filter_map(span).collect()
}

/// The share of the volume that is nearer to a spring than half of the range of their repulsion.
pub(crate) fn filled<B: Periodic>(system: &System<B>, bonds: &[[u32; 2]]) -> f64 {
    let tube = std::f64::consts::PI * (0.5 * SPRINGS_CUTOFF).powi(2);
    let lengths = spans(system, bonds).into_iter().map(|span| span.length());
    tube * lengths.sum::<f64>() / system.boundary.lattice().volume()
}

pub(crate) fn trace(stress: DMat3) -> f64 {
    stress.x_axis.x + stress.y_axis.y + stress.z_axis.z
}
