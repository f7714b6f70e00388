//! Spaces and flows: what surrounds the particles, and what carries them.
//!
//! Every space here is one [`Boundary`](zimm_core::Boundary). A homogeneous flow `u = kappa r` carries particles and
//! lattice by the same matrix, so the basis of the cell may be changed at will: distances, forces, velocity differences
//! and stresses do not feel it. Every space is a closed-form function of time. It does not drift, and a restart needs
//! the time alone.
//!
//! | space | lattice | flow | built from |
//! | --- | --- | --- | --- |
//! | [`Open`](zimm_core::Open) (in the core) | none | none | nothing |
//! | [`OpenFlow`] | none | any constant velocity gradient | `kappa` |
//! | [`PeriodicBox`] | any | none | an edge, three edges, or three vectors |
//! | [`LeesEdwards`] | sheared brick | simple shear, the rate a function of time | three edges and a history |
//!
//! | history of shear | strain at time t | rate |
//! | --- | --- | --- |
//! | `()` | 0 | 0 |
//! | [`Steady`] | `rate t` | constant |
//! | [`StartUp`] | `rate (t - at)` after `at`, 0 before | jumps up |
//! | [`Cessation`] | `rate t` before `at`, `rate at` after | jumps down |
//! | [`StepStrain`] | `strain` after `at`, 0 before | 0 |
//! | [`Oscillation`] | `amplitude sin(omega t)` | `amplitude omega cos(omega t)` |
//!
//! A history of one's own is one [`ShearHistory`]: two formulas, the strain being the exact integral of the rate.
//!
//! ```
//! use zimm_boundary::{LeesEdwards, Steady};
//! use zimm_core::{Boundary, DVec3};
//!
//! let mut space = LeesEdwards::new(DVec3::new(10.0, 8.0, 10.0), Steady::new(0.5)?)?;
//! space.advance(1.0);
//! // The image above has moved by 0.5 * 1.0 * 8, and it moves at 0.5 * 8.
//! let image = DVec3::new(4.0, 8.0, 0.0);
//! assert_eq!(space.min_image(image), DVec3::ZERO);
//! assert_eq!(space.gradient() * image, DVec3::new(4.0, 0.0, 0.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod exp;
mod history;
mod lees_edwards;
mod open_flow;
mod periodic_box;

pub use history::{Cessation, Oscillation, ShearHistory, StartUp, Steady, StepStrain};
pub use lees_edwards::LeesEdwards;
pub use open_flow::OpenFlow;
pub use periodic_box::PeriodicBox;
