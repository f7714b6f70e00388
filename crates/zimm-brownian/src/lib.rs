//! Brownian dynamics: overdamped beads in a flowing solvent.
//!
//! ```text
//! dr_i = (kappa r_i + sum_j M_ij F_j) dt + sqrt(2 kT) sum_j B_ij dW_j        M = B B^T
//! ```
//!
//! | part | trait | what there is |
//! | --- | --- | --- |
//! | how beads move each other | [`Mobility`], [`Entries`] | [`FreeDraining`]; `Rpy` in open space; `Ewald` and `Mesh` in cells, `Auto` chooses between them; `()`: nothing moves |
//! | noise that goes with it | [`Root`] | [`Diagonal`] for free draining, [`Lanczos`] and [`Chebyshev`] for any mobility, `BlockLanczos` for one that is kept for several steps, `Cholesky` for those with entries, `SplitNoise` for `Mesh`, `AutoNoise` for `Auto`; `()`: no noise |
//! | scheme in time | [`Stepper`](zimm_core::Stepper) | [`SemiImplicit`] for stiff springs; [`EulerMaruyama`], [`Heun`], [`Rejection`] |
//!
//! # Units
//! Anything goes that is consistent. Bead-spring chains are usually told in l_H = sqrt(kT / H), kT and
//! lambda_H = zeta / 4H, with H the stiffness of a spring and zeta the friction of a bead: kt = 1, stiffness 1, and a
//! friction of 4. The bead radius is then a = sqrt(pi) h*.

#[cfg(feature = "hydrodynamics")]
mod auto;
#[cfg(feature = "hydrodynamics")]
mod block_lanczos;
mod chebyshev;
#[cfg(feature = "hydrodynamics")]
mod cholesky;
mod columns;
mod connected;
mod coupling;
mod euler;
#[cfg(feature = "hydrodynamics")]
mod ewald;
mod flow;
mod free_draining;
mod heun;
mod implicit;
#[cfg(feature = "hydrodynamics")]
mod kirkwood;
mod lanczos;
#[cfg(feature = "hydrodynamics")]
mod lattice_sum;
#[cfg(feature = "hydrodynamics")]
mod mesh;
mod mixing;
mod mobility;
#[cfg(feature = "laws")]
pub mod mobility_laws;
mod one_bond;
#[cfg(feature = "hydrodynamics")]
mod pieces;
mod rejection;
mod relaxation;
mod ritz;
#[cfg(feature = "hydrodynamics")]
mod rpy;
mod semi_implicit;
mod stage;
mod symmetric;
mod tridiagonal;

#[cfg(feature = "hydrodynamics")]
pub use auto::{Auto, AutoNoise};
#[cfg(feature = "hydrodynamics")]
pub use block_lanczos::BlockLanczos;
pub use chebyshev::Chebyshev;
#[cfg(feature = "hydrodynamics")]
pub use cholesky::Cholesky;
pub use euler::EulerMaruyama;
#[cfg(feature = "hydrodynamics")]
pub use ewald::Ewald;
pub use free_draining::{Diagonal, FreeDraining};
pub use heun::Heun;
#[cfg(feature = "hydrodynamics")]
pub use kirkwood::Kirkwood;
pub use lanczos::Lanczos;
#[cfg(feature = "hydrodynamics")]
pub use mesh::{Mesh, SplitNoise};
pub use mobility::{Entries, Mobility, Root, White};
pub use rejection::Rejection;
#[cfg(feature = "hydrodynamics")]
pub use rpy::Rpy;
pub use semi_implicit::SemiImplicit;
