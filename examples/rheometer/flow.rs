//! The flows that the rheometer knows.

use crate::{LIMIT, Problem};
use clap::ValueEnum;
use zimm::prelude::*;

/// A homogeneous flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Flow {
    /// Shear, u_x = rate y.
    Shear,
    /// Planar extension, u = rate (x, -y, 0).
    Extension,
    /// Planar mixed flow of strain rate `rate` and a mixedness.
    Mixed,
    /// Uniaxial extension, u = rate (x, -y/2, -z/2).
    Uniaxial,
}

impl Flow {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Shear => "shear",
            Self::Extension => "extension",
            Self::Mixed => "mixed",
            Self::Uniaxial => "uniaxial",
        }
    }

    /// As it reads in a sentence.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Shear => "shear",
            Self::Extension => "planar extension",
            Self::Mixed => "planar mixed flow",
            Self::Uniaxial => "uniaxial extension",
        }
    }

    /// Rates that show something. Extension stretches vortices that vary along the neutral axis of planar flows: beyond a
    /// rate of 0.3, which is nu (2 pi / L_z)^2 of this fluid in this cell, the fluid would stir itself.
    pub(crate) fn default_rates(self) -> Vec<f64> {
        match self {
            Self::Shear => vec![0.1, 0.2, 0.4, 0.8],
            Self::Extension | Self::Mixed | Self::Uniaxial => vec![0.05, 0.1, 0.2, 0.28],
        }
    }

    /// The customary viscosity of the flow over the one by which it dissipates ([`FlowViscosity`]): eta in shear and mixed
    /// flow, eta_1 = (sigma_xx - sigma_yy) / rate in planar extension, Trouton's
    /// (sigma_xx - (sigma_yy + sigma_zz) / 2) / rate in uniaxial extension.
    pub(crate) fn customary(self) -> f64 {
        match self {
            Self::Shear | Self::Mixed => 1.0,
            Self::Extension => 4.0,
            Self::Uniaxial => 3.0,
        }
    }
}

/// A cube in shear. Springs reach across half of it.
pub(crate) fn shear(rate: f64) -> Result<LeesEdwards<Steady>, Problem> {
    Ok(LeesEdwards::new(
        DVec3::splat(2.0 * LIMIT),
        Steady::new(rate)?,
    )?)
}

/// The smallest cell in which no spring meets an image of itself.
pub(crate) fn extension(rate: f64) -> Result<KraynikReinelt<Steady>, Problem> {
    Ok(KraynikReinelt::box_for_cutoff(LIMIT, Steady::new(rate)?)?)
}

/// The smallest cell in which no spring meets an image of itself.
pub(crate) fn mixed(rate: f64, mixedness: f64) -> Result<PlanarMixed<Steady>, Problem> {
    Ok(PlanarMixed::box_for_cutoff(
        LIMIT,
        mixedness,
        Steady::new(rate)?,
    )?)
}

/// The smallest cell in which no spring meets an image of itself.
pub(crate) fn uniaxial(rate: f64) -> Result<UniaxialExtension<Steady>, Problem> {
    Ok(UniaxialExtension::box_for_cutoff(
        LIMIT,
        Steady::new(rate)?,
    )?)
}
