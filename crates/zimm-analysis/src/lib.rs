//! What a scene shows: stress, temperature, structure, diffusion, and the material functions that come of them, every
//! mean with an error bar that is honest about correlations.
//!
//! An [`Observable`](zimm_core::Observable) measures one frame, an [`Estimator`](zimm_core::Estimator) makes a mean of
//! many. They know nothing of forces, flows or steppers: a frame and what the force loop tallied is all they see.
//!
//! | to measure | from a frame | over time |
//! | --- | --- | --- |
//! | stress, pressure, what they are made of | [`Stress`] | [`BlockAverage`], [`BlockAverages`] |
//! | viscosity, normal stress coefficients | [`Stress`] | [`Viscometer`] |
//! | one viscosity for any homogeneous flow | [`Stress`] | [`FlowViscosity`] |
//! | drag of a bead, from dumbbells in a flow | [`Stress`], [`BondStatistics`] | [`GiesekusDrag`] |
//! | viscosity and relaxation modulus at rest | [`Stress`] | [`GreenKubo`] |
//! | temperature of velocities | [`KineticTemperature`] | [`BlockAverage`] |
//! | temperature of positions | [`ConfigurationalTemperature`] | [`RatioAverage`] |
//! | size and shape of molecules | [`GyrationTensor`], [`SquaredRadius`], [`EndToEnd`] | [`BlockAverage`] |
//! | stretch and orientation of bonds | [`BondStatistics`] | [`BlockAverage`] |
//! | structure of the fluid | [`RadialDistribution`] | [`BlockAverages`] |
//! | diffusion of particles or molecules | [`Unwrapped`], [`CentresOfMass`]; in a flow [`NonAffine`] | [`MeanSquareDisplacement`] |
//! | density, velocity, temperature across the cell | [`Profile`] | [`ProfileAverage`] |
//!
//! Every estimate is a [`Mean`]. Its error is either known ([`StandardError::Plateau`]) or bounded from below
//! ([`StandardError::AtLeast`]), and nobody can read the one for the other. What cannot be computed is an
//! [`AnalysisError`], never a NaN.
//!
//! ```
//! use zimm_analysis::{BlockAverage, KineticTemperature};
//! use zimm_core::{Clock, DVec3, Estimator, Observable, Open, Particles, System};
//!
//! let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?.with_velocities(vec![DVec3::Y, -DVec3::Y])?;
//! let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
//! let (mut thermometer, mut temperature) = (KineticTemperature::default(), BlockAverage::new());
//! for _ in 0..10 {
//!     // ... a step of the system ...
//!     temperature.push(thermometer.measure(&system.frame(), &())?.mean());
//! }
//! assert_eq!(temperature.estimate()?.to_string(), "0.666667 ± at least 0.000000 (no plateau)");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod block_average;
mod blocks;
mod bonds;
mod chain;
mod configurational_temperature;
mod end_to_end;
mod error;
mod flow_viscosity;
mod giesekus_drag;
mod green_kubo;
mod gyration;
mod kinetic_temperature;
mod mean;
mod mean_square_displacement;
mod non_affine;
mod pairs;
mod profile;
mod radial_distribution;
mod ratio_average;
#[cfg(test)]
mod scene;
mod stress;
mod tensor;
mod unwrapped;
mod viscometer;

pub use block_average::{BlockAverage, BlockAverages, BlockLevel};
pub use bonds::{BondMoments, BondStatistics};
pub use configurational_temperature::ConfigurationalTemperature;
pub use end_to_end::EndToEnd;
pub use error::AnalysisError;
pub use flow_viscosity::FlowViscosity;
pub use giesekus_drag::{Drag, GiesekusDrag};
pub use green_kubo::{GreenKubo, Relaxation};
pub use gyration::{GyrationTensor, SquaredRadius};
pub use kinetic_temperature::{KineticTemperature, Temperature};
pub use mean::{Mean, StandardError};
pub use mean_square_displacement::{Diffusion, MeanSquareDisplacement, periodic_correction};
pub use non_affine::NonAffine;
pub use profile::{Layer, LayerMeans, Profile, ProfileAverage};
pub use radial_distribution::RadialDistribution;
pub use ratio_average::RatioAverage;
pub use stress::{Stress, StressBudget};
pub use unwrapped::{CentresOfMass, Unwrapped};
pub use viscometer::{ShearFunctions, Viscometer};
