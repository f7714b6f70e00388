//! The chain that is simulated, as theory sees it.

use crate::options::{Hydrodynamics, Molecule, Spring};
use std::f64::consts::PI;
use zimm::prelude::*;

/// A bead-spring chain in units of kT, l_H and lambda_H.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Model {
    /// Number of beads.
    pub(crate) beads: u32,
    spring: Law,
    excluded_volume: Option<NarrowGaussian>,
    /// How beads move each other.
    pub(crate) hydrodynamics: Hydrodynamics,
    /// Radius of a bead.
    pub(crate) radius: f64,
    /// c / c* of chains in a cell.
    pub(crate) concentration: f64,
}

/// A spring law, for where the type does not matter.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Law {
    Fene(Fene),
    Hooke(Hooke),
    Wlc(MarkoSiggia),
}

impl Law {
    fn law(&self) -> &dyn BondForce {
        match self {
            Self::Fene(law) => law,
            Self::Hooke(law) => law,
            Self::Wlc(law) => law,
        }
    }
}

impl BondForce for Law {
    fn force(&self, r2: f64) -> f64 {
        self.law().force(r2)
    }

    fn energy(&self, r2: f64) -> f64 {
        self.law().energy(r2)
    }

    fn limit(&self) -> f64 {
        self.law().limit()
    }
}

impl Model {
    /// What the options ask for.
    pub(crate) fn new(molecule: &Molecule) -> Result<Self, ParameterError> {
        let limit = molecule.extensibility.sqrt();
        let gaussian = |z| NarrowGaussian::new(z, molecule.excluded_volume_range);
        Ok(Self {
            beads: molecule.beads,
            spring: match molecule.spring {
                Spring::Fene => Law::Fene(Fene::new(1.0, limit)?),
                Spring::Hooke => Law::Hooke(Hooke::new(1.0)?),
                Spring::Wlc => Law::Wlc(MarkoSiggia::new(1.0, limit)?),
            },
            excluded_volume: molecule
                .excluded_volume
                .filter(|z| *z > 0.0)
                .map(gaussian)
                .transpose()?,
            hydrodynamics: molecule.hi,
            radius: PI.sqrt() * molecule.hstar,
            concentration: molecule.concentration,
        })
    }

    pub(crate) fn spring(&self) -> Law {
        self.spring
    }

    pub(crate) fn excluded_volume(&self) -> Option<NarrowGaussian> {
        self.excluded_volume
    }

    /// Beads per volume of chains in a cell. The overlap concentration is that of chains without excluded volume.
    pub(crate) fn bead_concentration(&self) -> Result<f64, ParameterError> {
        let n = f64::from(self.beads);
        let radius = ((n * n - 1.0) / (6.0 * n) * self.mean_square_bond()).sqrt();
        Ok(self.concentration * overlap_concentration(self.beads as usize, radius)?)
    }

    /// Mean square length of a spring alone at rest: Simpson's rule.
    fn mean_square_bond(&self) -> f64 {
        const PANELS: u32 = 2000;
        let longest = self.spring.limit().min(12.0);
        let (mut norm, mut square) = (0.0, 0.0);
        for k in 1..PANELS {
            let r2 = (longest * f64::from(k) / f64::from(PANELS)).powi(2);
            let weight = f64::from(1 + k % 2) * r2 * (-self.spring.energy(r2)).exp();
            (norm, square) = (norm + weight, square + weight * r2);
        }
        square / norm
    }

    /// Whether beads do not feel each other through the solvent.
    pub(crate) fn is_free_draining(&self) -> bool {
        self.hydrodynamics == Hydrodynamics::None
    }

    /// Whether chains are in a cell with others.
    pub(crate) fn is_in_cell(&self) -> bool {
        matches!(
            self.hydrodynamics,
            Hydrodynamics::Ewald | Hydrodynamics::Mesh
        )
    }

    pub(crate) fn is_rouse(&self) -> bool {
        let hookean = matches!(self.spring, Law::Hooke(_));
        hookean && self.excluded_volume.is_none() && self.is_free_draining()
    }

    /// Potential energy of two bonded beads.
    pub(crate) fn energy(&self, r2: f64) -> f64 {
        self.spring.energy(r2) + self.repulsion(r2, |law, pair| law.energy(pair))
    }

    /// Force between two bonded beads over their distance, negative when attractive.
    pub(crate) fn force(&self, r2: f64) -> f64 {
        let now = Now::default();
        self.spring.force(r2) + self.repulsion(r2, |law, pair| law.force(pair, &now).total())
    }

    fn repulsion(&self, r2: f64, part: impl Fn(&NarrowGaussian, &Pair) -> f64) -> f64 {
        let pair = Pair {
            r2,
            ..Pair::default()
        };
        self.excluded_volume.map_or(0.0, |law| part(&law, &pair))
    }

    /// A length beyond which no dumbbell is found in a potential flow of this greatest rate, if it is held at all.
    pub(crate) fn longest(&self, rate: f64) -> Option<f64> {
        let limit = self.spring.limit();
        let softness = 1.0 - 2.0 * rate;
        if limit.is_finite() {
            Some(limit)
        } else {
            (softness > 0.0).then(|| 12.0 / softness.sqrt())
        }
    }
}
