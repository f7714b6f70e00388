//! Which mesh for which cell.

use super::split::{band, sharpness};
use std::f64::consts::PI;
use zimm_core::{DMat3, DVec3, Lattice, MobilityError};

/// A mesh and a range for one lattice: a pure function of the lattice, the number of beads and the tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plan {
    /// Mesh points along each basis vector.
    pub(super) points: [usize; 3],
    /// The product of the range and the largest wave number.
    pub(super) sharpness: f64,
    /// The range of the pair part.
    pub(super) range: f64,
    /// The inverse basis; its rows are the reciprocal vectors without 2 pi.
    pub(super) inverse: DMat3,
    /// The basis.
    pub(super) basis: DMat3,
    /// Distances between opposite faces of the cell.
    pub(super) widths: DVec3,
}

impl Plan {
    /// The plan that balances the cost of pairs and waves.
    pub(super) fn new(
        lattice: &Lattice,
        beads: usize,
        radius: f64,
        tolerance: f64,
        window: usize,
    ) -> Result<Self, MobilityError> {
        const WIDEST: f64 = 3.0;
        const MOST: f64 = 1e9;
        let (basis, widths) = (lattice.basis(), lattice.widths());
        let widest = radius / widths.min_element();
        if widest > WIDEST {
            return Err(MobilityError::Cell {
                radius,
                quantity: "radius over the narrowest width of the cell",
                found: widest,
                allowed: "at most 3",
            });
        }
        let (sharpness, range) = balance(lattice, beads, radius, tolerance);
        let edge = sharpness / range;
        let wanted = [basis.x_axis, basis.y_axis, basis.z_axis]
            .map(|axis| (edge * axis.length() / PI).ceil().max(window as f64));
        let total = wanted[0] * wanted[1] * wanted[2];
        if total > MOST {
            return Err(MobilityError::Cell {
                radius,
                quantity: "number of mesh points",
                found: total,
                allowed: "at most 1e9",
            });
        }
        let [n1, n2, n3] = wanted.map(|n| n as usize);
        Ok(Self {
            points: [smooth(n1), smooth(n2), 2 * smooth(n3.div_ceil(2))],
            sharpness,
            range,
            inverse: lattice.inverse(),
            basis,
            widths,
        })
    }
}

/// The sharpness of the split and the range of pairs.
fn balance(lattice: &Lattice, beads: usize, radius: f64, tolerance: f64) -> (f64, f64) {
    /// Range in mean distances between beads, over the root of the sharpness, at which pairs and waves cost the same
    /// in a step with noise.
    const BALANCE: f64 = 0.45;
    /// Errors may add up a little more than those of independent sources.
    const SAFETY: f64 = 1.5;
    /// The same where a bead is in reach of its own images: theirs add up in full, by shells of up to 48.
    const IMAGES: f64 = 48.0;
    let basis = lattice.basis();
    let lengths = [basis.x_axis, basis.y_axis, basis.z_axis].map(|axis| axis.length());
    let longest = lengths.into_iter().fold(0.0, f64::max);
    let apart = libm::cbrt(lattice.volume() / beads.max(1) as f64);
    let mut c = sharpness(tolerance);
    let wanted = (BALANCE * c.sqrt() * apart).min(0.6 * longest);
    for _ in 0..4 {
        let range = wanted.max(c * radius / band(c));
        // The error from all sources out of range, relative to a bead's own velocity.
        let sources = (range / apart).powi(3).sqrt() * radius / range;
        let own = range > 0.5 * lattice.shortest();
        let safety = if own { IMAGES } else { SAFETY };
        c = sharpness(tolerance / (safety * sources.max(0.2)));
    }
    // In steps, so that rounding of the volume does not show.
    let c = 0.25 * (4.0 * c).ceil();
    (c, coarse(wanted.max(c * radius / band(c))))
}

/// Rounds down to seven binary digits after the first, so that rounding of the volume does not show.
fn coarse(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & !((1 << 45) - 1))
}

/// The least number from `n` on that has no prime factor above 7.
fn smooth(n: usize) -> usize {
    let is_smooth = |&n: &usize| {
        let mut rest = n;
        for prime in [2, 3, 5, 7] {
            while rest.is_multiple_of(prime) {
                rest /= prime;
            }
        }
        rest == 1
    };
    (n.max(1)..).find(is_smooth).unwrap_or(n)
}
