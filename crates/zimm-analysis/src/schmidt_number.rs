//! How much faster momentum spreads than particles.

use crate::independent::of_independent;
use crate::ratio_average::clear_of_zero;
use crate::{AnalysisError, Mean};
use zimm_core::ParameterError;

/// The Schmidt number of a fluid of mass density rho, with its error:
///
/// ```text
/// Sc = eta / (rho D)
/// ```
///
/// Some 1 in gases and in DPD by its first recipe, 1000 in water. Viscosity and diffusion coefficient are from
/// independent runs, and D is that of large cells: [`periodic_correction`](crate::periodic_correction) is some ten per
/// cent in a cell of edge 6.
///
/// ```
/// use zimm_analysis::{Mean, StandardError, schmidt_number};
///
/// let mean = |value, error| Mean { value, error: StandardError::Plateau { error, uncertainty: 0.0 } };
/// let schmidt = schmidt_number(mean(28.6, 0.6), 4.0, mean(0.0108, 0.0003))?;
/// assert_eq!(format!("{schmidt:#}"), "662(23)");
/// # Ok::<(), zimm_analysis::AnalysisError>(())
/// ```
///
/// # Errors
/// If the density is not above zero, the viscosity is not finite, or D is closer to zero than four errors.
pub fn schmidt_number(
    viscosity: Mean,
    density: f64,
    diffusion: Mean,
) -> Result<Mean, AnalysisError> {
    let density = ParameterError::positive("density", density)?;
    ParameterError::finite("viscosity", viscosity.value)?;
    ParameterError::finite("diffusion coefficient", diffusion.value)?;
    clear_of_zero(diffusion)?;
    let per_viscosity = 1.0 / (density * diffusion.value);
    let value = viscosity.value * per_viscosity;
    let slope = -value / diffusion.value;
    Ok(of_independent(
        value,
        [(per_viscosity, viscosity), (slope, diffusion)],
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::StandardError;
    use crate::scene::known;

    // Published for the fluid of Lowe and Andersen, density 4, in a cell of edge 6: eta = 6.61, 28.6 and 63.7, D =
    // 0.0463, 0.0108 and 0.0060 give 36, 660 and 2650. Relative errors of 3 and 4 % make 5 %.
    #[test]
    fn reference_schmidt_numbers_of_lowe_and_andersen() {
        for (eta, diffusion, published) in [
            (6.61, 0.0463, 36.0),
            (28.6, 0.0108, 660.0),
            (63.7, 0.0060, 2650.0),
        ] {
            let (eta, diffusion) = (known(eta, 0.03 * eta), known(diffusion, 0.04 * diffusion));
            let found = schmidt_number(eta, 4.0, diffusion).unwrap();
            assert!((found.value / published - 1.0).abs() < 0.01, "{found}");
            let error = found.standard_error().unwrap() / found.value;
            approx::assert_relative_eq!(error, 0.05, max_relative = 1e-12);
        }
    }

    #[test]
    fn extreme_a_fluid_that_does_not_diffuse_has_none() {
        let eta = known(1.0, 0.1);
        assert!(schmidt_number(eta, 0.0, known(0.1, 0.001)).is_err());
        assert!(schmidt_number(eta, 4.0, known(0.1, 0.03)).is_err());
        assert!(schmidt_number(eta, 4.0, known(f64::NAN, 0.03)).is_err());
        assert!(schmidt_number(known(f64::INFINITY, 0.1), 4.0, known(0.1, 0.001)).is_err());
        let short = Mean {
            value: 0.1,
            error: StandardError::AtLeast(0.001),
        };
        let found = schmidt_number(eta, 4.0, short).unwrap();
        assert_eq!(found.standard_error(), None);
    }
}
