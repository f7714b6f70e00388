//! One viscosity for every homogeneous flow.

use crate::tensor::contract;
use crate::{AnalysisError, BlockAverage, Mean};
use zimm_core::{DMat3, Estimator, ParameterError};

/// Averages a stress in a steady homogeneous flow into the viscosity by which it dissipates,
///
/// ```text
/// eta = sigma : A / (A : A),     A = kappa + kappa^T
/// ```
///
/// with tension positive. A Newtonian fluid has the same eta in every flow. In shear it is sigma_xy / rate; in planar
/// extension (sigma_xx - sigma_yy) / 4 rate, a quarter of the usual eta_1; in uniaxial extension a third of Trouton's
/// viscosity; in planar mixed flow, kappa = [[e, g], [0, -e]], it is
/// [2 e (sigma_xx - sigma_yy) + 2 g sigma_xy] / (8 e^2 + 2 g^2) (Hounkonnou, Pierleoni and Ryckaert, J. Chem. Phys.
/// 97, 9335 (1992)).
///
/// ```
/// use zimm_analysis::FlowViscosity;
/// use zimm_core::{DMat3, DVec3, Estimator};
///
/// let extension = DMat3::from_diagonal(DVec3::new(0.5, -0.5, 0.0));
/// let mut viscosity = FlowViscosity::new(extension)?;
/// for _ in 0..2 {
///     viscosity.push(DMat3::from_diagonal(DVec3::new(5.0, -1.0, 2.0)));
/// }
/// assert_eq!(viscosity.estimate()?.value, 3.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct FlowViscosity {
    /// A / (A : A).
    weight: DMat3,
    average: BlockAverage,
}

impl FlowViscosity {
    /// A viscometer for a flow of this velocity gradient.
    ///
    /// # Errors
    /// If the gradient deforms nothing (zero or a mere rotation), or is not finite.
    pub fn new(gradient: DMat3) -> Result<Self, ParameterError> {
        let deformation = gradient + gradient.transpose();
        let square = contract(deformation, deformation);
        ParameterError::positive("square of the rate of deformation", square)?;
        Ok(Self {
            weight: deformation * square.recip(),
            average: BlockAverage::new(),
        })
    }
}

impl Estimator for FlowViscosity {
    type Sample = DMat3;
    type Estimate = Result<Mean, AnalysisError>;

    fn push(&mut self, stress: DMat3) {
        self.average.push(contract(stress, self.weight));
    }

    fn estimate(&self) -> Self::Estimate {
        self.average.estimate()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zimm_core::DVec3;

    /// A Newtonian stress, 2 eta D - p, has viscosity eta in any flow; pressure and rotation do not count.
    #[test]
    fn law_a_newtonian_fluid_has_one_viscosity() {
        for gradient in [
            DMat3::from_cols(DVec3::ZERO, 0.3 * DVec3::X, DVec3::ZERO),
            DMat3::from_diagonal(DVec3::new(2.0, -2.0, 0.0)),
            DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 2.0)),
            DMat3::from_cols(DVec3::X, DVec3::new(3.0, -1.0, 0.0), DVec3::ZERO),
            DMat3::from_cols(
                DVec3::new(0.0, -0.9, 0.2),
                DVec3::new(1.0, 0.0, 0.0),
                DVec3::ZERO,
            ),
        ] {
            let stress =
                (gradient + gradient.transpose()) * 0.7 - DMat3::from_diagonal(DVec3::splat(23.0));
            let mut viscosity = FlowViscosity::new(gradient).unwrap();
            viscosity.push(stress);
            viscosity.push(stress);
            assert!((viscosity.estimate().unwrap().value - 0.7).abs() < 1e-14);
        }
    }

    #[test]
    fn extreme_flows_that_deform_nothing_are_refused() {
        let rotation = DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::ZERO);
        for gradient in [DMat3::ZERO, rotation, DMat3::from_diagonal(DVec3::NAN)] {
            assert!(FlowViscosity::new(gradient).is_err());
        }
    }
}
