//! Where coils begin to overlap.

use std::f64::consts::PI;
use zimm_core::ParameterError;

/// The overlap concentration c*, in beads per volume: that of beads in the sphere of the radius of gyration of an
/// isolated chain at rest,
///
/// ```text
/// c* = N / ((4 pi / 3) R_g^3),   R_g = sqrt(<R_g^2>)
/// ```
///
/// ```
/// # use zimm_analysis::{cell_edge, overlap_concentration};
/// // 27 chains of 20 beads at c* in a theta solvent: <R_g^2> = 9.975 for Hookean springs of <Q^2> = 3.
/// let c = overlap_concentration(20, 9.975_f64.sqrt())?;
/// assert!((c - 0.15155).abs() < 1e-5);
/// assert!((cell_edge(27 * 20, c)? - 15.3).abs() < 0.05);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
///
/// # Errors
/// If there are no beads or the radius is not above zero.
pub fn overlap_concentration(beads: usize, radius_of_gyration: f64) -> Result<f64, ParameterError> {
    let beads = ParameterError::positive("beads", beads as f64)?;
    let radius = ParameterError::positive("radius of gyration", radius_of_gyration)?;
    Ok(beads / (4.0 * PI / 3.0 * radius * radius * radius))
}

/// The edge of the cube that holds so many beads, of all chains together, at a concentration in beads per volume. For
/// c/c* times the overlap concentration it is R_g (4 pi chains / (3 c/c*))^(1/3), whatever the length of the chains.
///
/// # Errors
/// If there are no beads or the concentration is not above zero.
pub fn cell_edge(beads: usize, concentration: f64) -> Result<f64, ParameterError> {
    let beads = ParameterError::positive("beads", beads as f64)?;
    let concentration = ParameterError::positive("concentration", concentration)?;
    Ok((beads / concentration).cbrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    // Dumbbells with R_g by quadrature: FENE with b = 50 and excluded volume z* = 10, d* = 1 (R_g = 1.200857, c* =
    // 0.275719; 300 of them at c*: edge 12.959), Hookean with z = 1.7 (0.945100, 0.565598).
    #[test]
    fn reference_dumbbells_with_excluded_volume() {
        let c = overlap_concentration(2, 1.200_857).unwrap();
        assert_relative_eq!(c, 0.275_719, max_relative = 5e-6);
        assert_relative_eq!(cell_edge(600, c).unwrap(), 12.959, max_relative = 5e-5);
        let c = overlap_concentration(2, 0.945_100).unwrap();
        assert_relative_eq!(c, 0.565_598, max_relative = 5e-6);
    }

    // Cells of chains in a theta solvent as published (Jain, thesis, Monash University 2013, table 6.1): c/c*, beads a
    // chain, edge to three digits, chains; <R_g^2> = (N^2 - 1) / (2 N). They went by measured radii, good to 1 % or so.
    #[test]
    fn reference_published_cells() {
        for (ratio, n, edge, chains) in [
            (0.1, 10_u32, 23.4, 28),
            (1.0, 20, 15.1, 27),
            (4.0, 16, 13.4, 103),
        ] {
            let square = f64::from(n * n - 1) / f64::from(2 * n);
            let c = ratio * overlap_concentration(n as usize, square.sqrt()).unwrap();
            let found = cell_edge(n as usize * chains, c).unwrap();
            assert_relative_eq!(found, edge, max_relative = 0.013);
        }
    }

    #[test]
    fn extreme_nothing_has_no_concentration() {
        assert!(overlap_concentration(0, 1.0).is_err());
        assert!(overlap_concentration(2, 0.0).is_err());
        assert!(overlap_concentration(2, f64::NAN).is_err());
        assert!(cell_edge(0, 1.0).is_err());
        assert!(cell_edge(1, f64::INFINITY).is_err());
    }
}
