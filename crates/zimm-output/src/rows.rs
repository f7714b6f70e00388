//! What every format tells of a particle.

use zimm_core::{Boundary, DMat3, DVec3, Frame, Molecules, ParticleError};

/// A frame whose columns fit together and are finite, one particle after another.
pub(crate) struct Rows<'a, B> {
    pub(crate) frame: &'a Frame<'a, B>,
    gradient: DMat3,
    molecules: &'a [Molecules],
}

impl<'a, B: Boundary> Rows<'a, B> {
    pub(crate) fn new(
        frame: &'a Frame<'a, B>,
        molecules: &'a [Molecules],
    ) -> Result<Self, ParticleError> {
        let particles = frame.len();
        for (column, found) in [
            ("velocities", frame.velocities.len()),
            ("masses", frame.masses.len()),
            ("species", frame.species.len()),
            ("images", frame.images.len()),
            ("ids", frame.ids.len()),
        ] {
            if found != 0 && found != particles {
                return Err(ParticleError::Length {
                    column,
                    found,
                    particles,
                });
            }
        }
        let rows = Self {
            frame,
            gradient: frame.boundary.gradient(),
            molecules,
        };
        for place in 0..particles {
            let mass = frame.mass(place);
            for (column, value) in [
                ("positions", frame.positions[place]),
                ("velocities", rows.velocity(place).unwrap_or(DVec3::ZERO)),
                ("masses", DVec3::splat(mass)),
            ] {
                if !value.is_finite() {
                    return Err(ParticleError::NotFinite {
                        column,
                        particle: place,
                        value: value.to_array(),
                    });
                }
            }
        }
        Ok(rows)
    }

    /// The velocity in the laboratory.
    pub(crate) fn velocity(&self, place: usize) -> Option<DVec3> {
        let peculiar = *self.frame.velocities.get(place)?;
        Some(if B::FLOWS {
            peculiar + self.gradient * self.frame.positions[place]
        } else {
            peculiar
        })
    }

    /// Whether there is anything to tell of molecules.
    pub(crate) fn has_molecules(&self) -> bool {
        !self.molecules.is_empty()
    }

    /// The number of a particle's molecule, from 1, through all kinds; 0 if it belongs to none.
    pub(crate) fn molecule(&self, place: usize) -> u32 {
        let (id, mut before) = (self.frame.id(place), 0);
        for kind in self.molecules {
            let identities = kind.identities();
            if identities.contains(&id) {
                return before + (id - identities.start) / kind.beads() + 1;
            }
            before += kind.count();
        }
        0
    }
}
