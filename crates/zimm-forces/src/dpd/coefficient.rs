//! Coefficients that may depend on the species of a pair.

use thiserror::Error;
use zimm_core::ParameterError;

/// A coefficient of a pair: one number for all ([`f64`]) or a table by species ([`SpeciesMatrix`]).
pub trait Coefficient: Sync {
    /// Whether species are looked at; those of a scene that does not are never loaded.
    const READS_SPECIES: bool;

    /// The coefficient between two species, the same in either order.
    fn between(&self, species: [u8; 2]) -> f64;

    /// Says whether every value is finite and not below zero; `name` is for the error.
    ///
    /// # Errors
    /// If one is not.
    fn check(&self, name: &'static str) -> Result<(), ParameterError>;
}

impl Coefficient for f64 {
    const READS_SPECIES: bool = false;

    #[inline(always)]
    fn between(&self, _: [u8; 2]) -> f64 {
        *self
    }

    fn check(&self, name: &'static str) -> Result<(), ParameterError> {
        ParameterError::non_negative(name, *self).map(|_| ())
    }
}

/// A symmetric table of coefficients between `N` species, finite and not below zero.
///
/// A species that the table does not list has the coefficient NaN, and a stepper refuses the forces that come of it;
/// [`covers`](Self::covers) says beforehand which particle it would be. An entry is found by comparing with all, in
/// SIMD lanes: cheap for a handful of species.
///
/// ```
/// use zimm_forces::{Coefficient, SpeciesMatrix};
///
/// let a = SpeciesMatrix::new([[25.0, 40.0], [40.0, 30.0]])?;
/// assert_eq!((a.between([1, 0]), a.between([1, 1])), (40.0, 30.0));
/// assert!(a.covers(&[0, 1, 2]).is_err());
/// # Ok::<(), zimm_forces::SpeciesError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeciesMatrix<const N: usize> {
    rows: [[f64; N]; N],
}

impl<const N: usize> SpeciesMatrix<N> {
    /// A table from its rows: `rows[i][j]` is the coefficient between species i and j.
    ///
    /// # Errors
    /// If an entry is not finite or below zero, or the table is not symmetric.
    pub fn new(rows: [[f64; N]; N]) -> Result<Self, SpeciesError> {
        for (i, row) in rows.iter().enumerate() {
            for (j, &value) in row.iter().enumerate() {
                ParameterError::non_negative("coefficient", value)
                    .map_err(|source| SpeciesError::Entry { i, j, source })?;
                let mirrored = rows[j][i];
                if value != mirrored {
                    return Err(SpeciesError::Asymmetric {
                        i,
                        j,
                        value,
                        mirrored,
                    });
                }
            }
        }
        Ok(Self { rows })
    }

    /// Says whether the table lists the species of every particle.
    ///
    /// # Errors
    /// Names the first particle whose species is not listed.
    pub fn covers(&self, species: &[u8]) -> Result<(), SpeciesError> {
        for (particle, &species) in species.iter().enumerate() {
            if usize::from(species) >= N {
                return Err(SpeciesError::Unlisted {
                    particle,
                    species,
                    listed: N,
                });
            }
        }
        Ok(())
    }
}

impl<const N: usize> Coefficient for SpeciesMatrix<N> {
    const READS_SPECIES: bool = true;

    #[inline(always)]
    fn between(&self, species: [u8; 2]) -> f64 {
        let [i, j] = species.map(usize::from);
        let (low, high) = (i.min(j), i.max(j));
        // Comparing with every entry keeps the force loop in SIMD lanes, which a look-up in memory would not.
        let mut found = f64::NAN;
        for (a, row) in self.rows.iter().enumerate() {
            for (b, &value) in row.iter().enumerate().skip(a) {
                found = if (low, high) == (a, b) { value } else { found };
            }
        }
        found
    }

    fn check(&self, _: &'static str) -> Result<(), ParameterError> {
        Ok(())
    }
}

/// Why a table of species cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SpeciesError {
    /// An entry that is no coefficient.
    #[error("species {i} and {j}: {source}")]
    Entry {
        /// Row of the entry.
        i: usize,
        /// Column of the entry.
        j: usize,
        /// What was found.
        source: ParameterError,
    },
    /// The force would not be equal and opposite.
    #[error("the entry of species {i} and {j} is {value}, but that of {j} and {i} is {mirrored}")]
    Asymmetric {
        /// Row of the entry.
        i: usize,
        /// Column of the entry.
        j: usize,
        /// What was found.
        value: f64,
        /// What was found with row and column exchanged.
        mirrored: f64,
    },
    /// A particle of a species that the table does not list.
    #[error("particle {particle} is of species {species}, but the table lists {listed}")]
    Unlisted {
        /// The particle.
        particle: usize,
        /// Its species.
        species: u8,
        /// Number of species listed.
        listed: usize,
    },
}
