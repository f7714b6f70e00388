//! The drag coefficient of a bead, from dumbbells in steady shear.

use crate::tensor::trace;
use crate::{AnalysisError, Mean, RatioAverage};
use zimm_core::{DMat3, Estimator, ParameterError};

/// The drag coefficient zeta of a bead from dumbbells in steady shear u = rate y e_x, by comparing Kramers' stress
/// with Giesekus', tau_p = (n zeta / 4) `<QQ>_(1)` (Bird, Curtiss, Armstrong and Hassager 1987, sec. 13.3):
///
/// ```text
/// zeta = 4 <F_x Q_y> / (rate <Q_y Q_y>)          from the shear component
/// zeta = 2 (<F . Q> - 3 kT) / (rate <Q_x Q_y>)   from the trace
/// ```
///
/// Q is the connector and F the whole force in it: the spring's tension and, with a minus sign, whatever repulsion
/// acts between the two beads. Both hold for any spring; they agree when the drag is isotropic and constant.
///
/// A sample is `[<QF>, <QQ>]`, means over the dumbbells of a frame. From the stress of the springs alone `<QF>` is
/// (V / n) [`item(Item::Spring)`](crate::StressBudget::item) with n dumbbells, and `<QQ>` is
/// [`BondMoments::stretch`](crate::BondMoments::stretch).
#[derive(Clone, Debug)]
pub struct GiesekusDrag {
    rate: f64,
    kt: f64,
    shear: RatioAverage,
    trace: RatioAverage,
}

/// The drag coefficient by two routes, in mass over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drag {
    /// From the shear component.
    pub shear: Mean,
    /// From the trace.
    pub trace: Mean,
}

impl GiesekusDrag {
    /// For this shear rate and thermal energy.
    ///
    /// # Errors
    /// If the rate is zero or not finite, or `kt` is not above zero.
    pub fn new(rate: f64, kt: f64) -> Result<Self, ParameterError> {
        ParameterError::positive("magnitude of the shear rate", rate.abs())?;
        Ok(Self {
            rate,
            kt: ParameterError::positive("kt", kt)?,
            shear: RatioAverage::new(),
            trace: RatioAverage::new(),
        })
    }
}

impl Estimator for GiesekusDrag {
    type Sample = [DMat3; 2];
    type Estimate = Result<Drag, AnalysisError>;

    fn push(&mut self, [qf, qq]: [DMat3; 2]) {
        let work = trace(&qf) - 3.0 * self.kt;
        let symmetric = |m: DMat3| 0.5 * (m.y_axis.x + m.x_axis.y);
        self.shear
            .push([4.0 * symmetric(qf), self.rate * qq.y_axis.y]);
        self.trace.push([2.0 * work, self.rate * symmetric(qq)]);
    }

    fn estimate(&self) -> Self::Estimate {
        Ok(Drag {
            shear: self.shear.estimate()?,
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
            let mut drag = GiesekusDrag::new(rate, 1.0).unwrap();
            for _ in 0..2 {
                drag.push([tensor(xx, 1.0, 1.0, xy), tensor(0.0, qyy, 0.0, qxy)]);
            }
            let Drag { shear, trace } = drag.estimate().unwrap();
            approx::assert_relative_eq!(shear.value, 4.0, max_relative = 1e-12);
            approx::assert_relative_eq!(trace.value, 4.0, max_relative = 1e-12);
        }
    }

    #[test]
    fn extreme_dumbbells_that_are_not_sheared_have_no_drag() {
        let mut drag = GiesekusDrag::new(0.1, 1.0).unwrap();
        for _ in 0..2 {
            drag.push([DMat3::IDENTITY, DMat3::IDENTITY]);
        }
        assert!(matches!(
            drag.estimate(),
            Err(AnalysisError::Denominator { .. })
        ));
        assert!(GiesekusDrag::new(0.0, 1.0).is_err());
        assert!(GiesekusDrag::new(1.0, 0.0).is_err());
    }
}
