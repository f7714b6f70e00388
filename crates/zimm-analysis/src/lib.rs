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
//! | drag of a bead, from diffusion | [`Unwrapped`], [`CentresOfMass`] | [`MeanSquareDisplacement`], [`einstein_drag`] |
//! | how the drag depends on the stress | [`Stress`], [`BondStatistics`] | [`GiesekusAnisotropy`] |
//! | viscosity, relaxation modulus, moduli of oscillatory shear at rest | [`Stress`] | [`GreenKubo`] |
//! | **temperature** | | |
//! | temperature of velocities | [`KineticTemperature`] | [`BlockAverage`] |
//! | temperature of positions | [`ConfigurationalTemperature`] | [`RatioAverage`] |
//! | **molecules** | | |
//! | size and shape | [`GyrationTensor`], [`SquaredRadius`], [`EndToEnd`], [`Extent`], [`ContourLength`] | [`BlockAverage`] |
//! | stretch, orientation, order | [`BondStatistics`], [`BondMoments::of`] | [`BlockAverage`] |
//! | modes and relaxation times | [`RouseModes`], [`EndToEnd`] | [`Autocorrelation`] |
//! | longest relaxation time, after a flow has stopped | [`EndToEnd`] | [`StretchRelaxation`] |
//! | springs that passed through each other, distances between springs | [`Crossings`], [`SpringDistribution`] | [`BlockAverage`] |
//! | form factor | [`FormFactor`] | [`BlockAverages`] |
//! | **structure and transport** | | |
//! | structure of the fluid | [`RadialDistribution`] | [`BlockAverages`] |
//! | diffusion where momentum is conserved | [`Unwrapped`], [`CentresOfMass`]; in a flow [`NonAffine`] | [`MeanSquareDisplacement`] |
//! | diffusion in Brownian dynamics, at rest or in a flow | [`Displacement`] | [`MeanSquareDisplacement`] |
//! | velocities and how long they last; diffusion from them | [`Velocities`] | [`Autocorrelation`] |
//! | Schmidt number | a viscosity and a diffusion coefficient | [`schmidt_number`] |
//! | density, velocity, temperature across the cell | [`Profile`] | [`ProfileAverage`] |
//! | stress and concentrations across the cell | [`StressProfile`] of a [`LayeredVirial`] | [`StressProfileAverage`] |
//! | material functions in reverse Poiseuille flow | as above | [`Channel`], [`Rheogram`] |
//!
//! One long run is averaged by blocks ([`BlockAverage`], [`RatioAverage`]), many short ones by trajectories
//! ([`EnsembleAverage`], [`EnsembleRatio`]), a run with a transient by [`SteadyAverage`], the last while of it by
//! [`SlidingAverage`]. All take samples one by one and keep next to nothing of them. [`Mean::more_samples`] says how much
//! longer to run. Means of several runs are joined by [`Mean::combined`] and extrapolated, to
//! long chains, large cells or small steps, by [`PolynomialFit`]. [`overlap_concentration`] and [`cell_edge`] say how
//! large a cell of a solution is.
//!
//! Flow curves are fitted by [`PowerLaw`], [`Ellis`] and [`Carreau`] and shifted onto each other by [`Superposition`]. The
//! error of any function of many means of a run is told by [`Jackknife`].
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
mod channel;
mod configurational_temperature;
mod contour_length;
mod crossings;
mod displacement;
mod einstein_drag;
mod end_to_end;
mod ensemble_average;
mod ensemble_ratio;
mod error;
mod extent;
mod extinction_angle;
mod flow_curve;
mod flow_viscosity;
mod followed;
mod form_factor;
mod giesekus_anisotropy;
mod giesekus_drag;
mod giesekus_stress;
mod green_kubo;
mod gyration;
mod independent;
mod jackknife;
mod kinetic_temperature;
mod ladder;
mod layered_virial;
mod mean;
mod mean_square_displacement;
mod minimum;
mod moments;
mod non_affine;
mod overlap;
mod pairs;
mod polynomial_fit;
mod profile;
mod radial_distribution;
mod ratio_average;
mod rheogram;
mod rouse_modes;
#[cfg(test)]
mod scene;
mod schmidt_number;
mod segments;
mod sliding_average;
mod steady_average;
mod stress;
mod stress_profile;
mod stretch_relaxation;
mod superposition;
mod tensor;
mod trajectories;
mod unwrapped;
mod velocities;
mod viscometer;

pub use autocorrelation::{Autocorrelation, Decay, Signal};
pub use block_average::{BlockAverage, BlockAverages, BlockLevel};
pub use bonds::{BondMoments, BondStatistics};
pub use chain_stress::ChainStress;
pub use channel::{Channel, ChannelLayer, ZeroShear};
pub use configurational_temperature::ConfigurationalTemperature;
pub use contour_length::ContourLength;
pub use crossings::{Crossings, SpringDistances, SpringDistribution};
pub use displacement::Displacement;
pub use einstein_drag::einstein_drag;
pub use end_to_end::EndToEnd;
pub use ensemble_average::EnsembleAverage;
pub use ensemble_ratio::EnsembleRatio;
pub use error::AnalysisError;
pub use extent::Extent;
pub use extinction_angle::ExtinctionAngle;
pub use flow_curve::{Carreau, Ellis, FlowPoint, PowerLaw};
pub use flow_viscosity::FlowViscosity;
pub use form_factor::FormFactor;
pub use giesekus_anisotropy::GiesekusAnisotropy;
pub use giesekus_drag::{Drag, GiesekusDrag};
pub use giesekus_stress::GiesekusStress;
pub use green_kubo::{GreenKubo, Moduli, Relaxation};
pub use gyration::{GyrationTensor, SquaredRadius};
pub use jackknife::Jackknife;
pub use kinetic_temperature::{KineticTemperature, Temperature};
pub use layered_virial::LayeredVirial;
pub use mean::{Mean, StandardError};
pub use mean_square_displacement::{Diffusion, MeanSquareDisplacement, periodic_correction};
pub use non_affine::NonAffine;
pub use overlap::{cell_edge, overlap_concentration};
pub use polynomial_fit::PolynomialFit;
pub use profile::{Layer, LayerMeans, Profile, ProfileAverage};
pub use radial_distribution::RadialDistribution;
pub use ratio_average::RatioAverage;
pub use rheogram::Rheogram;
pub use rouse_modes::RouseModes;
pub use schmidt_number::schmidt_number;
pub use sliding_average::SlidingAverage;
pub use steady_average::SteadyAverage;
pub use stress::{Stress, StressBudget};
pub use stress_profile::{StressLayer, StressLayerMeans, StressProfile, StressProfileAverage};
pub use stretch_relaxation::{StretchRelaxation, StretchTime};
pub use superposition::Superposition;
pub use unwrapped::{CentresOfMass, Unwrapped};
pub use velocities::Velocities;
pub use viscometer::{ShearFunctions, Viscometer};
