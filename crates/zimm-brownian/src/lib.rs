//! Brownian dynamics: overdamped beads in a flowing solvent.
//!
//! ```text
//! dr_i = (kappa r_i + sum_j M_ij F_j) dt + sqrt(2 kT) sum_j B_ij dW_j        M = B B^T
//! ```
//!
//! | part | trait | what there is |
//! | --- | --- | --- |
//! | how beads move each other | [`Mobility`], [`Entries`] | [`FreeDraining`]; `()`: nothing moves |
//! | noise that goes with it | [`Root`] | [`Diagonal`]; `()`: no noise |
//! | scheme in time | [`Stepper`](zimm_core::Stepper) | [`EulerMaruyama`] |
//!
//! # Units
//! Anything goes that is consistent. Bead-spring chains are usually told in l_H = sqrt(kT / H), kT and
//! lambda_H = zeta / 4H, with H the stiffness of a spring and zeta the friction of a bead: kt = 1, stiffness 1, and a
//! friction of 4. The bead radius is then a = sqrt(pi) h*.

mod euler;
mod free_draining;
mod mobility;
mod stage;

pub use euler::EulerMaruyama;
pub use free_draining::{Diagonal, FreeDraining};
pub use mobility::{Entries, Mobility, Root, White};
