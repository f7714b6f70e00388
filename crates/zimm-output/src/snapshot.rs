use crate::OutputError;
use zimm_core::{Boundary, Clock, DMat3, DVec3, IVec3, Now, Particles, System};

/// A frame as a file tells it. Columns that the file does not have are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// The moment.
    pub now: Now,
    /// The basis of the cell (columns), or nothing in open space.
    pub cell: Option<DMat3>,
    /// The velocity gradient, `kappa_ij = dv_i / dx_j`.
    pub gradient: DMat3,
    /// Positions in the primary cell.
    pub positions: Vec<DVec3>,
    /// Velocities **in the laboratory**.
    pub velocities: Vec<DVec3>,
    /// Masses, or nothing if all are 1.
    pub masses: Vec<f64>,
    /// Species.
    pub species: Vec<u8>,
    /// Image counts.
    pub images: Vec<IVec3>,
    /// Identities, or nothing if each is its place.
    pub ids: Vec<u32>,
    /// Number of each particle's molecule, from 1; 0 for a particle of none.
    pub molecules: Vec<u32>,
}

impl Snapshot {
    /// The position that a particle would have had without wrapping, if images were counted. In a flow this is the
    /// image of the particle in the lattice as it is now.
    pub fn unwrapped(&self, place: usize) -> Option<DVec3> {
        let position = *self.positions.get(place)?;
        match self.cell {
            None => Some(position),
            Some(cell) => Some(position + cell * self.images.get(place)?.as_dvec3()),
        }
    }

    /// The scene that was written, for any observable to measure. The boundary is put to the time of the frame and has
    /// to be the one in which the run was made; velocities become peculiar, which rounds them in a flow.
    ///
    /// This is for looking at, not for going on: that is what checkpoints are for.
    ///
    /// # Errors
    /// If cell or velocity gradient of the boundary differ from those of the frame by more than a millionth of their
    /// largest entry, or the columns do not fit together.
    pub fn into_system<B: Boundary>(self, mut boundary: B) -> Result<System<B>, OutputError> {
        let clock = Clock::showing(self.now)?;
        boundary.advance(self.now.time);
        same(
            self.now.time,
            "cell",
            entries(boundary.cell()),
            entries(self.cell),
        )?;
        same(
            self.now.time,
            "velocity gradient",
            entries(Some(boundary.gradient())),
            entries(Some(self.gradient)),
        )?;
        let mut velocities = self.velocities;
        if B::FLOWS {
            let gradient = boundary.gradient();
            for (v, &r) in velocities.iter_mut().zip(&self.positions) {
                *v -= gradient * r;
            }
        }
        let mut particles = Particles::new(self.positions)?;
        if !velocities.is_empty() {
            particles = particles.with_velocities(velocities)?;
        }
        if !self.masses.is_empty() {
            particles = particles.with_masses(self.masses)?;
        }
        if !self.species.is_empty() {
            particles = particles.with_species(self.species)?;
        }
        if !self.ids.is_empty() {
            particles = particles.with_ids(self.ids)?;
        }
        if !self.images.is_empty() {
            particles = particles.counting_images();
            let images = particles.columns_mut().images;
            if images.len() != self.images.len() {
                return Err(zimm_core::ParticleError::Length {
                    column: "images",
                    found: self.images.len(),
                    particles: images.len(),
                }
                .into());
            }
            images.copy_from_slice(&self.images);
        }
        Ok(System {
            boundary,
            particles,
            clock,
        })
    }
}

fn entries(matrix: Option<DMat3>) -> Vec<f64> {
    matrix
        .map(|m| m.to_cols_array().to_vec())
        .unwrap_or_default()
}

fn same(
    time: f64,
    quantity: &'static str,
    found: Vec<f64>,
    expected: Vec<f64>,
) -> Result<(), OutputError> {
    let largest = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-6 * largest;
    if found.len() == expected.len() && found.iter().zip(&expected).all(near) {
        Ok(())
    } else {
        Err(OutputError::Boundary {
            time,
            quantity,
            found,
            expected,
        })
    }
}
