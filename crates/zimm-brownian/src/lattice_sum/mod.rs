//! What all sums over a lattice share: how they are split, and the part that is summed over pairs.

mod cells;
mod kernel;
mod near;
mod plan;
mod series;

pub(crate) use kernel::{Kernel, bessel};
pub(crate) use near::Near;
pub(crate) use plan::{Plan, sharpness_of};
pub(crate) use series::Series;
#[cfg(test)]
pub(crate) use series::gauss;
