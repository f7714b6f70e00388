//! Tensors of rank two.

use zimm_core::{DMat3, DVec3, ParameterError};

/// The matrix of products of two vectors' components.
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(b.x * a, b.y * a, b.z * a)
}

/// The sum of the diagonal.
pub(crate) fn trace(m: &DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// A velocity gradient that keeps volumes, against a size that it is to be measured by.
pub(crate) fn traceless(gradient: DMat3, size: f64) -> Result<DMat3, ParameterError> {
    let growth = trace(&gradient);
    if growth.abs() > 1e-10 * size {
        return Err(ParameterError::new("trace of the gradient", growth, "zero"));
    }
    Ok(gradient)
}

/// a : b, the sum of products of all components.
pub(crate) fn contract(a: DMat3, b: DMat3) -> f64 {
    a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis) + a.z_axis.dot(b.z_axis)
}
