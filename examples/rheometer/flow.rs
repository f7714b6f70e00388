//! The flows that the rheometer knows.

use clap::ValueEnum;
use zimm::prelude::*;

/// A flow, homogeneous but for the last.
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
    /// Reverse Poiseuille flow: body forces to and fro, and all rates of shear up to the largest in one run.
    Rpf,
}

impl Flow {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Shear => "shear",
            Self::Extension => "extension",
            Self::Mixed => "mixed",
            Self::Uniaxial => "uniaxial",
            Self::Rpf => "rpf",
        }
    }

    /// As it reads in a sentence.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Shear => "shear",
            Self::Extension => "planar extension",
            Self::Mixed => "planar mixed flow",
            Self::Uniaxial => "uniaxial extension",
            Self::Rpf => "reverse Poiseuille flow",
        }
    }

    /// The customary viscosity of the flow over the one by which it dissipates ([`FlowViscosity`]): eta in shear and mixed
    /// flow, eta_1 = (sigma_xx - sigma_yy) / rate in planar extension, Trouton's
    /// (sigma_xx - (sigma_yy + sigma_zz) / 2) / rate in uniaxial extension.
    pub(crate) fn customary(self) -> f64 {
        match self {
            Self::Shear | Self::Mixed | Self::Rpf => 1.0,
            Self::Extension => 4.0,
            Self::Uniaxial => 3.0,
        }
    }

    /// The velocity gradient at rate 1, of reverse Poiseuille flow the local one.
    pub(crate) fn shape(self, mixedness: f64) -> DMat3 {
        let diagonal = |x, y, z| DMat3::from_diagonal(DVec3::new(x, y, z));
        match self {
            Self::Shear | Self::Rpf => DMat3::from_cols(DVec3::ZERO, DVec3::X, DVec3::ZERO),
            Self::Extension => diagonal(1.0, -1.0, 0.0),
            Self::Uniaxial => diagonal(1.0, -0.5, -0.5),
            Self::Mixed => {
                let rates = MixedRates::from_strain_rate(1.0, mixedness);
                let (e, g) = (rates.extension_rate, rates.shear_rate);
                DMat3::from_cols(e * DVec3::X, DVec3::new(g, -e, 0.0), DVec3::ZERO)
            }
        }
    }
}
