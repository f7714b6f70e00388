//! Particles as columns. A column that a scene does not use is empty.

use crate::ParticleError;
use glam::{DVec3, IVec3};

/// Particles as columns, all of one length or empty.
///
/// An empty `velocities` column means no inertia, an empty `masses` that all are 1, an empty `species` that all are
/// 0, an empty `ids` that a particle's identity is its place, empty `images` that nobody counts crossings, and empty
/// `forces` that they have not been evaluated for these positions.
///
/// ```
/// use zimm_core::{DVec3, Particles};
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?
///     .with_velocities(vec![DVec3::Y, -DVec3::Y])?
///     .with_species(vec![0, 1])?;
/// assert_eq!((particles.len(), particles.mass(1)), (2, 1.0));
/// assert!(particles.images().is_empty());
/// # Ok::<(), zimm_core::ParticleError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) velocities: Vec<DVec3>,
    pub(crate) forces: Vec<DVec3>,
    pub(crate) masses: Vec<f64>,
    pub(crate) species: Vec<u8>,
    pub(crate) images: Vec<IVec3>,
    pub(crate) ids: Vec<u32>,
    pub(crate) slots: Vec<u32>,
}

/// The columns that a stepper moves, borrowed together. Empty columns stay empty.
#[derive(Debug)]
pub struct Columns<'a> {
    /// Positions in the primary cell.
    pub positions: &'a mut Vec<DVec3>,
    /// Peculiar velocities.
    pub velocities: &'a mut Vec<DVec3>,
    /// Forces at these positions.
    pub forces: &'a mut Vec<DVec3>,
    /// Lattice vectors taken off by wrapping.
    pub images: &'a mut Vec<IVec3>,
}

impl Particles {
    /// Particles at these positions and nothing else.
    ///
    /// # Errors
    /// If a position is not finite, or there are more than 2^31 of them.
    pub fn new(positions: Vec<DVec3>) -> Result<Self, ParticleError> {
        let most = 1 << 31;
        if positions.len() > most {
            let particles = positions.len();
            return Err(ParticleError::TooMany { particles, most });
        }
        all_finite("positions", &positions)?;
        Ok(Self {
            positions,
            ..Self::default()
        })
    }

    /// Adds peculiar velocities.
    ///
    /// # Errors
    /// If the column is of another length or not finite.
    pub fn with_velocities(mut self, velocities: Vec<DVec3>) -> Result<Self, ParticleError> {
        self.fits("velocities", velocities.len())?;
        all_finite("velocities", &velocities)?;
        self.velocities = velocities;
        Ok(self)
    }

    /// Adds masses.
    ///
    /// # Errors
    /// If the column is of another length or a mass is not above zero.
    pub fn with_masses(mut self, masses: Vec<f64>) -> Result<Self, ParticleError> {
        self.fits("masses", masses.len())?;
        let wrong = |mass: &f64| !(mass.is_finite() && *mass > 0.0);
        if let Some(particle) = masses.iter().position(wrong) {
            let mass = masses[particle];
            return Err(ParticleError::Mass { particle, mass });
        }
        self.masses = masses;
        Ok(self)
    }

    /// Adds species.
    ///
    /// # Errors
    /// If the column is of another length.
    pub fn with_species(mut self, species: Vec<u8>) -> Result<Self, ParticleError> {
        self.fits("species", species.len())?;
        self.species = species;
        Ok(self)
    }

    /// Adds identities that outlive a change of order: a permutation of 0..n.
    ///
    /// # Errors
    /// If the column is of another length or no permutation.
    pub fn with_ids(mut self, ids: Vec<u32>) -> Result<Self, ParticleError> {
        self.fits("ids", ids.len())?;
        self.slots = invert(&ids)?;
        self.ids = ids;
        Ok(self)
    }

    /// Counts the images that wrapping takes off from now on, for unwrapped positions.
    pub fn counting_images(mut self) -> Self {
        self.images = vec![IVec3::ZERO; self.len()];
        self
    }

    /// Puts the particles into another order: the particle at `order[k]` comes to place k. Identities go along.
    ///
    /// # Errors
    /// If `order` is no permutation of 0..n.
    pub fn permute(&mut self, order: &[u32]) -> Result<(), ParticleError> {
        self.fits("order", order.len())?;
        invert(order)?;
        self.reorder(order);
        Ok(())
    }

    /// The same for what is known to be a permutation.
    pub(crate) fn reorder(&mut self, order: &[u32]) {
        if self.ids.is_empty() {
            self.ids = (0..self.len() as u32).collect();
        }
        permute_column(&mut self.positions, order);
        permute_column(&mut self.velocities, order);
        permute_column(&mut self.forces, order);
        permute_column(&mut self.masses, order);
        permute_column(&mut self.species, order);
        permute_column(&mut self.images, order);
        permute_column(&mut self.ids, order);
        self.slots.resize(self.ids.len(), 0);
        for (place, &id) in (0..).zip(&self.ids) {
            self.slots[id as usize] = place;
        }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Positions in the primary cell.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Positions to be changed; the forces are then forgotten.
    pub fn positions_mut(&mut self) -> &mut [DVec3] {
        self.forces.clear();
        &mut self.positions
    }

    /// Peculiar velocities, or nothing.
    pub fn velocities(&self) -> &[DVec3] {
        &self.velocities
    }

    /// Peculiar velocities to be changed; the forces (friction among them) are then forgotten.
    pub fn velocities_mut(&mut self) -> &mut [DVec3] {
        self.forces.clear();
        &mut self.velocities
    }

    /// Forces at these positions, or nothing if they have not been evaluated.
    pub fn forces(&self) -> &[DVec3] {
        &self.forces
    }

    /// Masses, or nothing if all are 1.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// The mass of one particle.
    #[inline]
    pub fn mass(&self, particle: usize) -> f64 {
        self.masses.get(particle).copied().unwrap_or(1.0)
    }

    /// Species, or nothing if all are 0.
    pub fn species(&self) -> &[u8] {
        &self.species
    }

    /// Image counts, or nothing if they are not kept.
    pub fn images(&self) -> &[IVec3] {
        &self.images
    }

    /// Identities, or nothing if each is its place.
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// The columns that move, for steppers: those of a stepper's own keep every length as it is.
    pub fn columns_mut(&mut self) -> Columns<'_> {
        Columns {
            positions: &mut self.positions,
            velocities: &mut self.velocities,
            forces: &mut self.forces,
            images: &mut self.images,
        }
    }

    fn fits(&self, column: &'static str, found: usize) -> Result<(), ParticleError> {
        let particles = self.len();
        if found == particles {
            Ok(())
        } else {
            Err(ParticleError::Length {
                column,
                found,
                particles,
            })
        }
    }
}

fn all_finite(column: &'static str, values: &[DVec3]) -> Result<(), ParticleError> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(particle) => Err(ParticleError::NotFinite {
            column,
            particle,
            value: values[particle].to_array(),
        }),
    }
}

fn permute_column<A: Copy>(column: &mut Vec<A>, order: &[u32]) {
    if !column.is_empty() {
        *column = order.iter().map(|&k| column[k as usize]).collect();
    }
}

fn invert(permutation: &[u32]) -> Result<Vec<u32>, ParticleError> {
    let particles = permutation.len();
    let mut inverse = vec![u32::MAX; particles];
    for (particle, &identity) in permutation.iter().enumerate() {
        match inverse.get_mut(identity as usize) {
            Some(place) if *place == u32::MAX => *place = particle as u32,
            _ => {
                return Err(ParticleError::Identity {
                    particle,
                    identity,
                    particles,
                });
            }
        }
    }
    Ok(inverse)
}
