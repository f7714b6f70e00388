//! What a scene shows: stress, temperature, structure, diffusion, and the material functions that come of them, every
//! mean with an error bar that is honest about correlations.
//!
//! An [`Observable`](zimm_core::Observable) measures one frame, an [`Estimator`](zimm_core::Estimator) makes a mean of
//! many. They know nothing of forces, flows or steppers: a frame and what the force loop tallied is all they see.
//!
//! | to measure | from a frame | over time |
//! | --- | --- | --- |
//! | **stress** | | |
//! | stress, pressure, what they are made of | [`Stress`] | [`BlockAverage`], [`BlockAverages`] |
//! | polymer stress in Brownian dynamics, also in open space | [`ChainStress`] | as below |
//! | the same in steady flow with less noise, without hydrodynamics | [`GiesekusStress`] | as below |
//! | viscosity, normal stress coefficients | any of these | [`Viscometer`] |
//! | one viscosity for any homogeneous flow | any of these | [`FlowViscosity`] |
//! | extinction angle | any of these, or an orientation | [`ExtinctionAngle`] |
//! | drag of a bead, from dumbbells in a flow | [`Stress`], [`BondStatistics`] | [`GiesekusDrag`] |
//! | viscosity and relaxation modulus at rest | [`Stress`] | [`GreenKubo`] |
//! | **temperature** | | |
//! | temperature of velocities | [`KineticTemperature`] | [`BlockAverage`] |
//! | temperature of positions | [`ConfigurationalTemperature`] | [`RatioAverage`] |
//! | **molecules** | | |
//! | size and shape | [`GyrationTensor`], [`SquaredRadius`], [`EndToEnd`], [`Extent`] | [`BlockAverage`] |
//! | stretch, orientation, order | [`BondStatistics`], [`BondMoments::of`] | [`BlockAverage`] |
//! | modes and relaxation times | [`RouseModes`], [`EndToEnd`] | [`Autocorrelation`] |
//! | springs that passed through each other, distances between springs | [`Crossings`], [`SpringDistribution`] | [`BlockAverage`] |
//! | form factor | [`FormFactor`] | [`BlockAverages`] |
//! | **structure and transport** | | |
//! | structure of the fluid | [`RadialDistribution`] | [`BlockAverages`] |
//! | diffusion where momentum is conserved | [`Unwrapped`], [`CentresOfMass`]; in a flow [`NonAffine`] | [`MeanSquareDisplacement`] |
//! | diffusion in Brownian dynamics, at rest or in a flow | [`Displacement`] | [`MeanSquareDisplacement`] |
//! | density, velocity, temperature across the cell | [`Profile`] | [`ProfileAverage`] |
//!
//! One long run is averaged by blocks ([`BlockAverage`], [`RatioAverage`]), many short ones by trajectories
//! ([`EnsembleAverage`], [`EnsembleRatio`]). Means of several runs are joined by [`Mean::combined`] and extrapolated, to
//! long chains, large cells or small steps, by [`PolynomialFit`]. [`overlap_concentration`] and [`cell_edge`] say how
//! large a cell of a solution is.
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

mod autocorrelation;
mod block_average;
mod blocks;
mod bonds;
mod chain;
mod chain_stress;
mod configurational_temperature;
mod crossings;
mod displacement;
mod end_to_end;
mod ensemble_average;
mod ensemble_ratio;
mod error;
mod extent;
mod extinction_angle;
mod flow_viscosity;
mod followed;
mod form_factor;
mod giesekus_drag;
mod giesekus_stress;
mod green_kubo;
mod gyration;
mod kinetic_temperature;
mod mean;
mod mean_square_displacement;
mod non_affine;
mod overlap;
mod pairs;
mod polynomial_fit;
mod profile;
mod radial_distribution;
mod ratio_average;
mod rouse_modes;
#[cfg(test)]
mod scene;
mod stress;
mod tensor;
mod trajectories;
mod unwrapped;
mod viscometer;

pub use autocorrelation::{Autocorrelation, Decay};
pub use block_average::{BlockAverage, BlockAverages, BlockLevel};
pub use bonds::{BondMoments, BondStatistics};
pub use chain_stress::ChainStress;
pub use configurational_temperature::ConfigurationalTemperature;
pub use crossings::{Crossings, SpringDistances, SpringDistribution};
pub use displacement::Displacement;
pub use end_to_end::EndToEnd;
pub use ensemble_average::EnsembleAverage;
pub use ensemble_ratio::EnsembleRatio;
pub use error::AnalysisError;
pub use extent::Extent;
pub use extinction_angle::ExtinctionAngle;
pub use flow_viscosity::FlowViscosity;
pub use form_factor::FormFactor;
pub use giesekus_drag::{Drag, GiesekusDrag};
pub use giesekus_stress::GiesekusStress;
pub use green_kubo::{GreenKubo, Relaxation};
pub use gyration::{GyrationTensor, SquaredRadius};
pub use kinetic_temperature::{KineticTemperature, Temperature};
pub use mean::{Mean, StandardError};
pub use mean_square_displacement::{Diffusion, MeanSquareDisplacement, periodic_correction};
pub use non_affine::NonAffine;
pub use overlap::{cell_edge, overlap_concentration};
pub use polynomial_fit::PolynomialFit;
pub use profile::{Layer, LayerMeans, Profile, ProfileAverage};
pub use radial_distribution::RadialDistribution;
pub use ratio_average::RatioAverage;
pub use rouse_modes::RouseModes;
pub use stress::{Stress, StressBudget};
pub use unwrapped::{CentresOfMass, Unwrapped};
pub use viscometer::{ShearFunctions, Viscometer};
