//! What several tests need.

#![allow(
    dead_code,
    clippy::unwrap_used,
    reason = "a test may panic, and does not need everything here"
)]

use serde_json::Value;
use zimm_core::{Boundary, DMat3, DVec3, Lattice};

pub(crate) use zimm_boundary::laws::at;

pub(crate) fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Whether a vector is one of the lattice, to a share of its length and of 1.
pub(crate) fn holds_vector<B: Boundary>(space: &B, vector: DVec3, tolerance: f64) -> bool {
    space.min_image(vector).length() < tolerance * (1.0 + vector.length())
}

/// Points spread evenly over the cell, the same at every call: multiples of the powers of the root of x^4 = x + 1
/// modulo 1.
pub(crate) fn scattered(lattice: &Lattice, count: usize) -> Vec<DVec3> {
    let step = DVec3::new(
        0.819_172_513_396_164_4,
        0.671_043_606_703_789_2,
        0.549_700_477_901_970_4,
    );
    (1..=count)
        .map(|k| lattice.fold(lattice.basis() * (k as f64 * step)).0)
        .collect()
}

/// Frobenius norm.
pub(crate) fn norm(m: DMat3) -> f64 {
    m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt()
}
