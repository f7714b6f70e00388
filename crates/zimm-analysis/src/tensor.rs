//! Tensors of rank two.

use zimm_core::{DMat3, DVec3};

/// The matrix of products of two vectors' components.
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(b.x * a, b.y * a, b.z * a)
}

/// The sum of the diagonal.
pub(crate) fn trace(m: &DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}
