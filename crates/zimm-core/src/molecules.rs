//! Which identities make up which molecule, and how its beads are joined.

use crate::{Boundary, ParameterError, Particles, System};
use glam::DVec3;
use std::ops::Range;

/// Molecules of one kind, each a run of consecutive identities, one run after the other.
///
/// Beads of a molecule are numbered from 0. Each but the first is joined to a bead of a lower number, its
/// [`parent`](Self::parent), so that a molecule can be walked, grown or unwrapped in the order of its beads. A ring has
/// one bond more, from its last bead to its first.
///
/// ```
/// use zimm_core::Molecules;
///
/// // Two trimers behind ten particles of solvent.
/// let trimers = Molecules::linear(10, 2, 3)?;
/// assert_eq!(trimers.bonds(), [[10, 11], [11, 12], [13, 14], [14, 15]]);
/// assert!(trimers.iter().eq([10..13, 13..16]));
///
/// let ring = Molecules::ring(0, 1, 3)?;
/// assert_eq!(ring.bonds(), [[0, 1], [1, 2], [2, 0]]);
///
/// // Three arms of two beads around bead 0.
/// let star = Molecules::star(0, 1, 3, 2)?;
/// assert_eq!(star.bonds(), [[0, 1], [1, 2], [0, 3], [3, 4], [0, 5], [5, 6]]);
///
/// // A backbone of six beads, on every third of which is a tooth of one bead.
/// let comb = Molecules::comb(0, 1, 6, 3, 1)?;
/// assert_eq!(comb.bonds(), [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [1, 6], [4, 7]]);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Molecules {
    first: u32,
    count: u32,
    beads: u32,
    topology: Topology,
}

/// How the beads of one molecule are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Topology {
    /// Each bead and the next.
    Linear,
    /// Each bead and the next, the last and the first.
    Ring,
    /// A centre, bead 0, then one arm after another, each from the centre outwards.
    Star {
        /// Number of arms.
        arms: u32,
        /// Beads of each arm; the centre belongs to none.
        length: u32,
    },
    /// A backbone, then one tooth after another, each from the backbone outwards.
    Comb {
        /// Beads of the backbone.
        backbone: u32,
        /// The first tooth is on bead `spacing / 2` of the backbone, rounded down, the others follow at this distance.
        spacing: u32,
        /// Beads of each tooth.
        tooth: u32,
    },
}

impl Molecules {
    /// Linear molecules of `beads` beads each, the first of which is the particle of identity `first`.
    ///
    /// # Errors
    /// If a molecule has no bead, or the last identity is not below 2^31.
    pub fn linear(first: u32, count: u32, beads: u32) -> Result<Self, ParameterError> {
        let beads = at_least_one("beads", beads)?;
        Self::new(first, count, u64::from(beads), Topology::Linear)
    }

    /// Rings of `beads` beads.
    ///
    /// # Errors
    /// If a ring has fewer than three beads, or the last identity is not below 2^31.
    pub fn ring(first: u32, count: u32, beads: u32) -> Result<Self, ParameterError> {
        if beads < 3 {
            let found = f64::from(beads);
            return Err(ParameterError::new("beads", found, "at least 3"));
        }
        Self::new(first, count, u64::from(beads), Topology::Ring)
    }

    /// Stars of `arms` arms of `length` beads each, and a bead in the centre. Bead 0 is the centre; the arms follow one
    /// after another, each from the centre outwards.
    ///
    /// # Errors
    /// If a star has no arm or no bead in an arm, or the last identity is not below 2^31.
    pub fn star(first: u32, count: u32, arms: u32, length: u32) -> Result<Self, ParameterError> {
        at_least_one("arms", arms)?;
        at_least_one("beads of an arm", length)?;
        let beads = 1 + u64::from(arms) * u64::from(length);
        Self::new(first, count, beads, Topology::Star { arms, length })
    }

    /// Combs: a backbone of `backbone` beads, and a tooth of `tooth` beads on every bead number `spacing / 2` (rounded
    /// down) `+ k spacing` of it. The backbone comes first; the teeth follow one after another, each from the backbone
    /// outwards.
    ///
    /// # Errors
    /// If the spacing or a tooth has no bead, the backbone is shorter than the spacing, or the last identity is not
    /// below 2^31.
    pub fn comb(
        first: u32,
        count: u32,
        backbone: u32,
        spacing: u32,
        tooth: u32,
    ) -> Result<Self, ParameterError> {
        at_least_one("spacing of teeth", spacing)?;
        at_least_one("beads of a tooth", tooth)?;
        if backbone < spacing {
            let (name, found) = ("beads of the backbone", f64::from(backbone));
            let allowed = "at least the spacing of the teeth";
            return Err(ParameterError::new(name, found, allowed));
        }
        let teeth = (backbone - spacing / 2).div_ceil(spacing);
        let topology = Topology::Comb {
            backbone,
            spacing,
            tooth,
        };
        let beads = u64::from(backbone) + u64::from(teeth) * u64::from(tooth);
        Self::new(first, count, beads, topology)
    }

    fn new(first: u32, count: u32, beads: u64, topology: Topology) -> Result<Self, ParameterError> {
        const MOST: u64 = 1 << 31;
        let end = u64::from(count)
            .saturating_mul(beads)
            .saturating_add(u64::from(first));
        match u32::try_from(beads) {
            Ok(beads) if end <= MOST => Ok(Self {
                first,
                count,
                beads,
                topology,
            }),
            _ => {
                let name = "last identity";
                Err(ParameterError::new(name, end as f64 - 1.0, "below 2^31"))
            }
        }
    }

    /// Number of molecules.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Beads of each molecule.
    pub fn beads(&self) -> u32 {
        self.beads
    }

    /// How the beads of each molecule are joined.
    pub fn topology(&self) -> Topology {
        self.topology
    }

    /// The identities of all beads of all molecules.
    pub fn identities(&self) -> Range<u32> {
        self.first..self.first + self.count * self.beads
    }

    /// The identities of each molecule.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Range<u32>> + use<> {
        let Self {
            first,
            count,
            beads,
            ..
        } = *self;
        (0..count).map(move |molecule| {
            let start = first + molecule * beads;
            start..start + beads
        })
    }

    /// The bead of a lower number that a bead of a molecule is joined to; bead 0 has none. Beads are numbered from 0 in
    /// each molecule.
    #[inline]
    pub fn parent(&self, bead: u32) -> Option<u32> {
        let before = bead.checked_sub(1)?;
        Some(match self.topology {
            Topology::Star { length, .. } if before.is_multiple_of(length) => 0,
            Topology::Comb {
                backbone,
                spacing,
                tooth,
            } if bead >= backbone && (bead - backbone).is_multiple_of(tooth) => {
                spacing / 2 + (bead - backbone) / tooth * spacing
            }
            _ => before,
        })
    }

    /// The bonds of one molecule, between beads numbered from 0. Each reaches a new bead, the second, from an old one,
    /// but for the last of a ring, which goes from the last bead to the first.
    pub fn links(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let molecules = *self;
        let closing = match self.topology {
            Topology::Ring => Some([self.beads - 1, 0]),
            _ => None,
        };
        (1..self.beads)
            .filter_map(move |bead| Some([molecules.parent(bead)?, bead]))
            .chain(closing)
    }

    /// The pairs of identities that are joined, molecule after molecule, each in the order of [`links`](Self::links).
    pub fn bonds(&self) -> Vec<[u32; 2]> {
        self.iter()
            .flat_map(|beads| {
                self.links()
                    .map(move |[i, j]| [beads.start + i, beads.start + j])
            })
            .collect()
    }

    /// The species of all beads of all molecules in the order of identities, for block copolymers: runs of beads along
    /// each molecule, each run a number of beads and their species.
    ///
    /// ```
    /// # use zimm_core::Molecules;
    /// let diblocks = Molecules::linear(0, 2, 5)?;
    /// assert_eq!(diblocks.species(&[(3, 0), (2, 1)])?, [0, 0, 0, 1, 1, 0, 0, 0, 1, 1]);
    /// # Ok::<(), zimm_core::ParameterError>(())
    /// ```
    ///
    /// # Errors
    /// If the runs do not add up to the beads of a molecule.
    pub fn species(&self, runs: &[(u32, u8)]) -> Result<Vec<u8>, ParameterError> {
        let beads: u64 = runs.iter().map(|&(beads, _)| u64::from(beads)).sum();
        if beads != u64::from(self.beads) {
            let (name, allowed) = ("beads in all runs", "the beads of a molecule");
            return Err(ParameterError::new(name, beads as f64, allowed));
        }
        let one: Vec<u8> = runs
            .iter()
            .flat_map(|&(beads, species)| std::iter::repeat_n(species, beads as usize))
            .collect();
        Ok(one.repeat(self.count as usize))
    }
}

/// Moves every molecule of an isolated-chain scene so that its centre of mass is at the origin.
///
/// In a homogeneous flow this changes nothing else: forces within a molecule and peculiar velocities are the same
/// wherever it is. Without it the centre of mass runs away as exp(rate t) in an extension, and the digits of the bonds
/// are lost to it. Forces that have been evaluated stay valid, so there must be none between molecules and none that
/// depend on the place. Particles of no molecule stay where they are.
///
/// ```
/// use zimm_core::{Clock, DVec3, Molecules, Open, Particles, System, recentre};
///
/// let particles = Particles::new(vec![DVec3::X, 3.0 * DVec3::X])?;
/// let mut system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// recentre(&mut system, &Molecules::linear(0, 1, 2)?)?;
/// assert_eq!(system.particles.positions(), [-DVec3::X, DVec3::X]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the space has a cell, or a molecule a bead that does not exist. Nothing is moved then.
pub fn recentre<B: Boundary>(
    system: &mut System<B>,
    molecules: &Molecules,
) -> Result<(), ParameterError> {
    if system.boundary.cell().is_some() {
        let (name, allowed) = (
            "number of lattice vectors",
            "0: isolated molecules have no cell",
        );
        return Err(ParameterError::new(name, 3.0, allowed));
    }
    let end = molecules.identities().end;
    if end as usize > system.particles.len() {
        let (name, allowed) = ("last identity", "below the number of particles");
        return Err(ParameterError::new(name, f64::from(end) - 1.0, allowed));
    }
    let Particles {
        positions,
        masses,
        slots,
        ..
    } = &mut system.particles;
    let place = |id: u32| {
        slots
            .get(id as usize)
            .map_or(id as usize, |&slot| slot as usize)
    };
    for beads in molecules.iter() {
        let (mut mass, mut moment) = (0.0, DVec3::ZERO);
        for place in beads.clone().map(place) {
            let weight = masses.get(place).copied().unwrap_or(1.0);
            mass += weight;
            moment += weight * positions[place];
        }
        let centre = moment / mass;
        for place in beads.map(place) {
            positions[place] -= centre;
        }
    }
    Ok(())
}

fn at_least_one(name: &'static str, found: u32) -> Result<u32, ParameterError> {
    if found > 0 {
        Ok(found)
    } else {
        Err(ParameterError::new(name, 0.0, "at least 1"))
    }
}
