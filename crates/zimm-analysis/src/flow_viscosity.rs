//! One viscosity for every homogeneous flow.

use crate::tensor::contract;
use crate::{AnalysisError, BlockAverage, Mean};
use zimm_core::{DMat3, DVec3, Estimator, ParameterError};

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
/// 97, 9335 (1992)). Where a number is wanted that is the eta of shear and the eta_1 of planar extension,
/// [`smooth`](Self::smooth) joins them.
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

    /// Another viscosity of planar mixed flow, kappa = [[e, g], [0, -e]], which joins sigma_xy / g in shear (e = 0) and
    /// eta_1 = (sigma_xx - sigma_yy) / e in planar extension (g = 0) without a factor of 4 between them:
    ///
    /// ```text
    /// eta = [sqrt(chi) (sigma_xx - sigma_yy) + (1 - chi) sigma_xy] / [G (sqrt(chi) + 1 - chi)]
    /// ```
    ///
    /// with the strain rate G and the mixedness chi of Fuller and Leal, e = G sqrt(chi) and g = G (1 - chi) (Jain,
    /// thesis, Monash University 2013, eq. 4.30). It is (1 + chi)^2 / (sqrt(chi) + 1 - chi) times the viscosity of
    /// [`new`](Self::new), so that even a Newtonian fluid shows a dependence on chi.
    ///
    /// ```
    /// use zimm_analysis::FlowViscosity;
    /// use zimm_core::{DMat3, DVec3, Estimator};
    ///
    /// // The Newtonian stress of eta = 2 in planar extension at rate 0.5: eta_1 is 4 eta.
    /// let mut viscosity = FlowViscosity::smooth(0.5, 0.0)?;
    /// for _ in 0..2 {
    ///     viscosity.push(DMat3::from_diagonal(DVec3::new(2.0, -2.0, 0.0)));
    /// }
    /// assert_eq!(viscosity.estimate()?.value, 8.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If a rate is below zero, not finite, or both are zero.
    pub fn smooth(extension_rate: f64, shear_rate: f64) -> Result<Self, ParameterError> {
        let e = ParameterError::non_negative("extension rate", extension_rate)?;
        let g = ParameterError::non_negative("shear rate", shear_rate)?;
        let total = ParameterError::positive("sum of the rates", e + g)?;
        let strain_rate = 0.5 * (g.hypot(2.0 * e) + g);
        let a = DMat3::from_cols(
            DVec3::new(2.0 * e, g, 0.0),
            DVec3::new(g, -2.0 * e, 0.0),
            DVec3::ZERO,
        );
        // e (xx - yy) + g xy = A : sigma / 2 over G (e + g).
        let weight = a * (0.5 / strain_rate / total);
        let average = BlockAverage::new();
        Ok(Self { weight, average })
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
    use crate::scene::{planar, planar_mixed};

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

    fn found(mut viscosity: FlowViscosity, stress: DMat3) -> f64 {
        viscosity.push(stress);
        viscosity.push(stress);
        viscosity.estimate().unwrap().value
    }

    // Hookean dumbbells in units of l_H and lambda_H: eta = 1 / (1 - 4 e^2) whatever the shear; the moments are
    // <yy> = 1 / (1 + 2 e), <xy> = g <yy>, <xx> = (1 + 2 g <xy>) / (1 - 2 e). In (e, g) = (0.2, 1): 1.190476.
    #[test]
    fn limit_hookean_dumbbells_in_mixed_flow() {
        for (e, g) in [(0.2, 1.0), (0.3, 3.0), (0.0, 2.0), (0.45, 0.0)] {
            let yy = 1.0 / (1.0 + 2.0 * e);
            let xy = g * yy;
            let stress = planar((1.0 + 2.0 * g * xy) / (1.0 - 2.0 * e), xy, yy, 7.0);
            let eta = found(FlowViscosity::new(planar_mixed(e, g)).unwrap(), stress);
            approx::assert_relative_eq!(eta, 1.0 / (1.0 - 4.0 * e * e), max_relative = 1e-12);
        }
    }

    // The two viscosities differ by (1 + chi)^2 / (sqrt(chi) + 1 - chi); rates 1 and 1 are chi = 0.381966, G = 1.618034.
    #[test]
    fn law_two_viscosities_of_mixed_flow() {
        let stress = planar(3.1, 1.7, -0.4, 7.0);
        for chi in [1e-12_f64, 0.01, 0.381_966_011_250_105, 0.7, 1.0] {
            let strain_rate = 1.618_033_988_749_895;
            let (e, g) = (strain_rate * chi.sqrt(), strain_rate * (1.0 - chi));
            let smooth = found(FlowViscosity::smooth(e, g).unwrap(), stress);
            let dissipative = found(FlowViscosity::new(planar_mixed(e, g)).unwrap(), stress);
            let factor = (1.0 + chi).powi(2) / (chi.sqrt() + 1.0 - chi);
            approx::assert_relative_eq!(smooth, factor * dissipative, max_relative = 1e-12);
        }
        approx::assert_relative_eq!(
            found(FlowViscosity::smooth(0.0, 0.5).unwrap(), stress),
            1.7 / 0.5,
            max_relative = 1e-14
        );
        approx::assert_relative_eq!(
            found(FlowViscosity::smooth(0.5, 0.0).unwrap(), stress),
            3.5 / 0.5,
            max_relative = 1e-14
        );
        for (e, g) in [(0.0, 0.0), (-0.1, 1.0), (0.1, -1.0), (f64::NAN, 1.0)] {
            assert!(FlowViscosity::smooth(e, g).is_err());
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
