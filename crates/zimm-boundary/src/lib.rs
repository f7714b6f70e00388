//! Spaces and flows: what surrounds the particles, and what carries them.
//!
//! Every space here is one [`Boundary`](zimm_core::Boundary). A homogeneous flow `u = kappa r` carries particles and
//! lattice by the same matrix, so the basis of the cell may be changed at will: distances, forces, velocity differences
//! and stresses do not feel it. Every space is a closed-form function of time. It does not drift, and a restart needs
//! the time alone.
//!
//! | space | lattice | flow | images, in edges of a cube of the same volume, stay apart |
//! | --- | --- | --- | --- |
//! | [`Open`](zimm_core::Open) (in the core) | none | none | |
//! | [`OpenFlow`] | none | any velocity gradient | |
//! | [`PeriodicBox`] | any | none | 1 |
//! | [`LeesEdwards`] | sheared brick | simple shear | 1 |
//! | [`KraynikReinelt`] | turned square | planar extension | 0.946, or more with a longer neutral edge |
//! | [`PlanarMixed`] | sheared, chosen by mixedness | shear and planar extension | by mixedness |
//! | [`UniaxialExtension`] | of a cubic field, turning | uniaxial and biaxial extension | 1.027 |
//! | [`TriaxialFlow`] | turned cube | extension along any three axes | 0.905 if the axes are perpendicular |
//!
//! Flows take their rate from a history: kappa(t) = rate(t) K, with K the shape of the flow.
//!
//! | history | strain at time t | rate |
//! | --- | --- | --- |
//! | `()` | 0 | 0 |
//! | [`Steady`] | `rate t` | constant |
//! | [`StartUp`] | `rate (t - at)` after `at`, 0 before | jumps up |
//! | [`Cessation`] | `rate t` before `at`, `rate at` after | jumps down |
//! | [`StepStrain`] | `strain` after `at`, 0 before | 0 |
//! | [`Oscillation`] | `amplitude sin(omega t)` | `amplitude omega cos(omega t)` |
//! | [`Then`] | one history, then another | that of each |
//!
//! A history of one's own is one [`FlowHistory`]: two formulas, the strain being the exact integral of the rate. A
//! boundary of one's own is tested by the `laws` of the feature `proptest` with one line.
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

mod error;
mod exp;
mod history;
mod kraynik_reinelt;
mod lattice_flow;
mod lees_edwards;
mod mixed_rates;
mod open_flow;
mod periodic_box;
mod planar_map;
mod planar_mixed;
mod triaxial;
mod uniaxial;

#[cfg(feature = "proptest")]
pub mod laws;

pub use error::FlowError;
pub use history::{Cessation, FlowHistory, Oscillation, StartUp, Steady, StepStrain, Then};
pub use kraynik_reinelt::{KraynikReinelt, PlanarExtension};
pub use lattice_flow::LatticeFlow;
pub use lees_edwards::LeesEdwards;
pub use mixed_rates::MixedRates;
pub use open_flow::OpenFlow;
pub use periodic_box::PeriodicBox;
pub use planar_map::PlanarMap;
pub use planar_mixed::{MixedFlow, PlanarMixed};
pub use triaxial::{Triaxial, TriaxialFlow};
pub use uniaxial::{Uniaxial, UniaxialExtension};
