//! What DPD's noise is drawn from.

use zimm_core::noise::{Domain, Site};

/// The distribution of theta_ij: mean zero, variance one.
pub trait Distribution: Sync {
    /// The number that belongs to a pair at a step.
    fn draw(&self, noise: Site) -> f64;
}

/// Uniform between -3^1/2 and 3^1/2: indistinguishable from normal in DPD and several times faster (Groot and Warren
/// 1997).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Uniform;

impl Distribution for Uniform {
    #[inline(always)]
    fn draw(&self, noise: Site) -> f64 {
        noise.uniform(Domain::DPD)
    }
}

/// The normal distribution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Normal;

impl Distribution for Normal {
    #[inline(always)]
    fn draw(&self, noise: Site) -> f64 {
        noise.normal(Domain::DPD)
    }
}
