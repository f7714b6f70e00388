//! The drag coefficient of a bead, from dumbbells in a steady flow.

use crate::tensor::{contract, trace, traceless};
use crate::{AnalysisError, Mean, RatioAverage};
use zimm_core::{DMat3, Estimator, ParameterError};

/// The drag coefficient zeta of a bead from dumbbells in a steady homogeneous flow u = kappa r, by comparing Kramers'
/// stress with Giesekus', tau_p = (n zeta / 4) `<QQ>_(1)` (Bird, Curtiss, Armstrong and Hassager 1987, sec. 13.3):
///
/// ```text
/// zeta = 2 <QF> : A / (kappa <QQ> : A)                  along the deformation, A = kappa + kappa^T
/// zeta = 2 (<F . Q> - 3 kT) / tr(kappa <QQ>)            from the trace
/// ```
///
/// In shear of a rate these are 4 <F_x Q_y> / (rate <Q_y Q_y>) and 2 (<F . Q> - 3 kT) / (rate <Q_x Q_y>).
///
/// Q is the connector and F the whole force in it: the spring's tension and, with a minus sign, whatever repulsion
/// acts between the two beads. In a solvent of particles that repulsion is the mean force, kT d ln g / dr with g of the
/// fluid, not the bare force between the beads: the solvent pushes them together and all but cancels it, so that the
/// tension alone is much nearer. Both hold for any spring; they agree when the drag is isotropic and constant.
///
/// A sample is `[<QF>, <QQ>]`, means over the dumbbells of a frame. From the stress of the springs alone `<QF>` is
/// (V / n) [`item(Item::Spring)`](crate::StressBudget::item) with n dumbbells, and `<QQ>` is
/// [`BondMoments::stretch`](crate::BondMoments::stretch).
#[derive(Clone, Debug)]
pub struct GiesekusDrag {
    gradient: DMat3,
    kt: f64,
    deformation: RatioAverage,
    trace: RatioAverage,
}

/// The drag coefficient by two routes, in mass over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drag {
    /// From the components along the deformation.
    pub deformation: Mean,
    /// From the trace.
    pub trace: Mean,
}

impl GiesekusDrag {
    /// For this velocity gradient, traceless, and thermal energy.
    ///
    /// # Errors
    /// If the gradient deforms nothing, changes the volume or is not finite, or `kt` is not above zero.
    pub fn new(gradient: DMat3, kt: f64) -> Result<Self, ParameterError> {
        let a = gradient + gradient.transpose();
        let square = ParameterError::positive("square of the rate of deformation", contract(a, a))?;
        Ok(Self {
            gradient: traceless(gradient, square.sqrt())?,
            kt: ParameterError::positive("kt", kt)?,
            deformation: RatioAverage::new(),
            trace: RatioAverage::new(),
        })
    }
}

impl Estimator for GiesekusDrag {
    type Sample = [DMat3; 2];
    type Estimate = Result<Drag, AnalysisError>;

    fn push(&mut self, [qf, qq]: [DMat3; 2]) {
        let a = self.gradient + self.gradient.transpose();
        let carried = self.gradient * qq;
        self.deformation
            .push([2.0 * contract(qf, a), contract(carried, a)]);
        let work = trace(&qf) - 3.0 * self.kt;
        self.trace.push([2.0 * work, trace(&carried)]);
    }

    fn estimate(&self) -> Self::Estimate {
        Ok(Drag {
            deformation: self.deformation.estimate()?,
            trace: self.trace.estimate()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zimm_core::DVec3;

    // Moments of FENE dumbbells, b = 50, in shear, in units of l_H, lambda_H and kT, where zeta = 4: a spectral
    // solution of the Fokker-Planck equation, good to 1e-13. Rates 1 and 3.
    #[test]
    fn reference_fene_dumbbells_have_the_drag_they_were_given() {
        for (rate, qxy, qyy, xx, xy) in [
            (
                1.0,
                7.14323321581909e-01,
                8.67473714804384e-01,
                2.42864664316381,
                8.67473714804381e-01,
            ),
            (
                3.0,
                1.39750463952796,
                7.18334578096644e-01,
                9.38502783716779,
                2.15500373428992,
            ),
        ] {
            let tensor = |x: f64, y: f64, z: f64, shear: f64| {
                DMat3::from_cols(
                    DVec3::new(x, shear, 0.0),
                    DVec3::new(shear, y, 0.0),
                    DVec3::new(0.0, 0.0, z),
                )
            };
            let shear = DMat3::from_cols(DVec3::ZERO, rate * DVec3::X, DVec3::ZERO);
            let mut drag = GiesekusDrag::new(shear, 1.0).unwrap();
            for _ in 0..2 {
                drag.push([tensor(xx, 1.0, 1.0, xy), tensor(0.0, qyy, 0.0, qxy)]);
            }
            let Drag { deformation, trace } = drag.estimate().unwrap();
            approx::assert_relative_eq!(deformation.value, 4.0, max_relative = 1e-12);
            approx::assert_relative_eq!(trace.value, 4.0, max_relative = 1e-12);
        }
    }

    // Hookean dumbbells in planar extension at De = 0.3 in the same units: <xx> = 1 / (1 - 2 De), <yy> = 1 / (1 + 2 De),
    // <zz> = 1, and F = Q.
    #[test]
    fn limit_hookean_dumbbells_in_extension() {
        let de = 0.3;
        let extension = DMat3::from_diagonal(DVec3::new(de, -de, 0.0));
        let stretch = DVec3::new(1.0 / (1.0 - 2.0 * de), 1.0 / (1.0 + 2.0 * de), 1.0);
        let mut drag = GiesekusDrag::new(extension, 1.0).unwrap();
        for _ in 0..2 {
            drag.push([DMat3::from_diagonal(stretch); 2]);
        }
        let Drag { deformation, trace } = drag.estimate().unwrap();
        approx::assert_relative_eq!(deformation.value, 4.0, max_relative = 1e-12);
        approx::assert_relative_eq!(trace.value, 4.0, max_relative = 1e-12);
    }

    #[test]
    fn extreme_dumbbells_that_are_not_deformed_have_no_drag() {
        let shear = DMat3::from_cols(DVec3::ZERO, 0.1 * DVec3::X, DVec3::ZERO);
        let mut drag = GiesekusDrag::new(shear, 1.0).unwrap();
        for _ in 0..2 {
            drag.push([DMat3::IDENTITY, DMat3::IDENTITY]);
        }
        assert!(matches!(
            drag.estimate(),
            Err(AnalysisError::Denominator { .. })
        ));
        assert!(GiesekusDrag::new(DMat3::ZERO, 1.0).is_err());
        assert!(GiesekusDrag::new(DMat3::IDENTITY, 1.0).is_err());
        assert!(GiesekusDrag::new(shear, 0.0).is_err());
    }
}
