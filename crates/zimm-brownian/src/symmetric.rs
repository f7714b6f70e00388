//! Symmetric positive definite blocks of 3 x 3 numbers.

use zimm_core::{DMat3, DVec3};

/// The factors of a symmetric positive definite matrix, L D L^T. Unlike cofactors they keep their digits when one
/// eigenvalue is much larger than the others, as that of a spring near its limit is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Factors {
    below: [f64; 3],
    inverse: [f64; 3],
}

impl Factors {
    pub(crate) fn new(m: DMat3) -> Self {
        let [xx, xy, xz] = m.x_axis.to_array();
        let [_, yy, yz] = m.y_axis.to_array();
        let (yx, zx) = (xy / xx, xz / xx);
        let (y, zy_raw) = (yy - yx * xy, yz - yx * xz);
        let zy = zy_raw / y;
        let z = m.z_axis.z - zx * xz - zy * zy_raw;
        Self {
            below: [yx, zx, zy],
            inverse: [1.0 / xx, 1.0 / y, 1.0 / z],
        }
    }

    /// The solution of m x = v.
    pub(crate) fn solve(&self, v: DVec3) -> DVec3 {
        let [yx, zx, zy] = self.below;
        let y = v.y - yx * v.x;
        let z = (v.z - zx * v.x - zy * y) * self.inverse[2];
        let y = y * self.inverse[1] - zy * z;
        DVec3::new(v.x * self.inverse[0] - yx * y - zx * z, y, z)
    }

    /// The solution of m X = V, column by column.
    pub(crate) fn solve_columns(&self, v: DMat3) -> DMat3 {
        let [x, y, z] = [v.x_axis, v.y_axis, v.z_axis].map(|column| self.solve(column));
        DMat3::from_cols(x, y, z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extreme_a_stiff_direction_costs_no_digits_across_it() {
        let n = DVec3::new(2.0, -1.0, 2.0) / 3.0;
        let outer = DMat3::from_cols(n.x * n, n.y * n, n.z * n);
        let across = DVec3::new(1.0, 2.0, 0.0) / 5.0_f64.sqrt();
        for stiffness in [0.0, 1.0, 1e6, 1e10] {
            let factors = Factors::new(DMat3::IDENTITY * 2.0 + outer * stiffness);
            let (along, over) = (factors.solve(n), factors.solve(across));
            assert!((along * (2.0 + stiffness) - n).length() < 1e-15 * (2.0 + stiffness));
            assert!((over - 0.5 * across).length() < 1e-16 * (10.0 + stiffness));
        }
    }
}
