//! The range of the soft laws.

use crate::length::{distance, length};
use zimm_core::ParameterError;

/// A cutoff and its inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    cutoff: f64,
    inverse: f64,
}

impl Range {
    pub(super) const UNIT: Self = Self {
        cutoff: 1.0,
        inverse: 1.0,
    };

    pub(super) fn new(cutoff: f64) -> Result<Self, ParameterError> {
        let cutoff = length("cutoff", cutoff)?;
        let inverse = 1.0 / cutoff;
        Ok(Self { cutoff, inverse })
    }

    #[inline(always)]
    pub(super) fn cutoff(&self) -> f64 {
        self.cutoff
    }

    /// The overlap 1 - r / r_c, zero at and beyond the cutoff, and 1 / r.
    #[inline(always)]
    pub(super) fn look(&self, r2: f64) -> (f64, f64) {
        let r = distance(r2);
        // Taking r / r_c from 1 would leave 1e-16 at the cutoff, of which a weak weight makes 1e-4.
        ((self.cutoff - r).max(0.0) * self.inverse, 1.0 / r)
    }
}
