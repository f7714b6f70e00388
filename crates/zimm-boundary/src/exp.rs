//! The exponential of a matrix.

use zimm_core::DMat3;

/// `exp(a)` by scaling, a Taylor series and squaring. Not finite if the result or a^3 overflows.
///
/// The number of halvings goes by the sizes of a^2 and a^3, not by that of a (Al-Mohy and Higham 2009, theorem 4.2:
/// the k-th power is no larger than the k-th power of max(|a^2|^(1/2), |a^3|^(1/3)) for k > 1). A matrix far from
/// normal, as that of strong shear with a little extension, is then not scaled beyond what its eigenvalues ask for,
/// and a nilpotent one is not scaled at all: its series ends and the result is exact.
pub(crate) fn exp(a: DMat3) -> DMat3 {
    let (mut square, mut cube) = (size(a * a), size(a * a * a));
    if !(square + cube).is_finite() {
        return DMat3::NAN;
    }
    let (mut scale, mut halvings) = (1.0, 0);
    while square > 0.25 || cube > 0.125 {
        square *= 0.25;
        cube *= 0.125;
        scale *= 0.5;
        halvings += 1;
    }
    let mut result = series(scale * a);
    for _ in 0..halvings {
        result *= result;
    }
    result
}

/// The Taylor series for sizes up to 1/2: the first term left out is below 0.5^15 / 15! = 3e-17.
fn series(a: DMat3) -> DMat3 {
    const ORDER: u32 = 14;
    (1..=ORDER).rev().fold(DMat3::IDENTITY, |tail, k| {
        DMat3::IDENTITY + a * tail * f64::from(k).recip()
    })
}

/// Sum of magnitudes: a norm that bounds products, and that lets no NaN pass.
pub(crate) fn size(m: DMat3) -> f64 {
    m.to_cols_array().iter().map(|x| x.abs()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use zimm_core::DVec3;

    fn rows(rows: [[f64; 3]; 3]) -> DMat3 {
        DMat3::from_cols_array_2d(&rows).transpose()
    }

    fn assert_near(found: DMat3, expected: DMat3, tolerance: f64) {
        let error = size(found - expected) / size(expected);
        assert!(
            error <= tolerance,
            "{found} instead of {expected}: {error:e}"
        );
    }

    #[test]
    fn limit_nilpotent_matrices_are_exact() {
        let shear = |s| rows([[0.0, s, 0.0], [0.0; 3], [0.0; 3]]);
        for s in [0.0, 1e-12, 0.3, -7.1, 1e6, 1e300] {
            assert_eq!(exp(shear(s)), DMat3::IDENTITY + shear(s));
        }
        let (a, b, c) = (3.0, -5.0, 0.25);
        let twice = rows([[0.0, a, b], [0.0, 0.0, c], [0.0; 3]]);
        let expected = rows([[1.0, a, b + 0.5 * a * c], [0.0, 1.0, c], [0.0, 0.0, 1.0]]);
        assert_eq!(exp(twice), expected);
    }

    /// The relative error of e^x is eps |x|, that of rounding x itself; each diagonal entry is held to a few of it.
    #[test]
    fn limit_diagonal_matrices_entry_by_entry() {
        for d in [
            DVec3::new(1e-9, -0.4, 0.3),
            DVec3::new(1.0, -1.0, 0.0),
            DVec3::new(30.0, -10.0, -20.0),
            DVec3::new(700.0, -700.0, 3.0),
        ] {
            let found = exp(DMat3::from_diagonal(d));
            for k in 0..3 {
                let error = (found.col(k)[k] / libm::exp(d[k]) - 1.0).abs();
                let bound = 4.0 * f64::EPSILON * (1.0 + d.abs().max_element());
                assert!(error < bound, "{d}: {error:e}");
            }
        }
    }

    #[test]
    fn limit_rotations() {
        for (axis, angle) in [
            (DVec3::Z, 0.1),
            (DVec3::new(1.0, -2.0, 2.0) / 3.0, 2.5),
            (DVec3::new(2.0, 3.0, 6.0) / 7.0, 1000.0),
        ] {
            let (x, y, z) = (angle * axis).into();
            let spin = rows([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]);
            let bound = 4.0 * f64::EPSILON * (1.0 + angle);
            assert_near(exp(spin), DMat3::from_axis_angle(axis, angle), bound);
        }
    }

    /// Planar mixed flow [[e, g], [0, -e]]: diagonal exp(+-e), corner g sinh(e) / e. For g >> e, halving by the size
    /// of the matrix would lose log10(g / e) digits.
    #[test]
    fn limit_planar_mixed_flow_entry_by_entry() {
        for (e, g) in [(0.3, 1.0), (1.0, -4.0), (0.01, 1e6), (5.0, 1e3)] {
            let found = exp(rows([[e, g, 0.0], [0.0, -e, 0.0], [0.0; 3]]));
            let bound = 8.0 * f64::EPSILON * (1.0 + e);
            for (entry, expected) in [
                (found.x_axis.x, libm::exp(e)),
                (found.y_axis.y, libm::exp(-e)),
                (found.y_axis.x, g * libm::sinh(e) / e),
            ] {
                assert!(
                    (entry / expected - 1.0).abs() < bound,
                    "{e} {g}: {entry} {expected}"
                );
            }
            assert_eq!((found.x_axis.y, found.z_axis), (0.0, DVec3::Z));
        }
    }

    /// A Jordan block of size three: e^x [[1, 1, 1/2], [0, 1, 1], [0, 0, 1]].
    #[test]
    fn limit_jordan_block() {
        for x in [-3.0, 0.7, 12.0] {
            let block = rows([[x, 1.0, 0.0], [0.0, x, 1.0], [0.0, 0.0, x]]);
            let expected = rows([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]]);
            let bound = 8.0 * f64::EPSILON * (1.0 + x.abs());
            assert_near(exp(block), libm::exp(x) * expected, bound);
        }
    }

    proptest! {
        #[test]
        fn law_inverse_and_determinant(entries in proptest::array::uniform9(-1.5..1.5)) {
            let a = DMat3::from_cols_array(&entries);
            let (forth, back) = (exp(a), exp(-a));
            let condition = size(forth) * size(back);
            prop_assert!(size(forth * back - DMat3::IDENTITY) < 1e-14 * condition);
            let trace = a.x_axis.x + a.y_axis.y + a.z_axis.z;
            let volume = forth.determinant() / libm::exp(trace);
            prop_assert!((volume - 1.0).abs() < 1e-14 * condition, "{volume}");
        }
    }

    #[test]
    fn extreme_what_is_not_finite_ends() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200] {
            assert!(!exp(DMat3::from_diagonal(DVec3::new(x, -x, 0.0))).is_finite());
        }
        let collapse = exp(DMat3::from_diagonal(DVec3::splat(-1e60)));
        assert_eq!(collapse, DMat3::ZERO);
    }
}
