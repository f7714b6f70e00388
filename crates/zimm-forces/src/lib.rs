//! The force laws of zimm. Each is one formula in one file: loops, images, stress and neighbour lists are the business
//! of the drivers in `zimm-core`, which also holds the traits that a law of your own implements.
//!
//! Between any two particles ([`PairForce`](zimm_core::PairForce), driven by [`Pairwise`](zimm_core::Pairwise)), with
//! x = 1 - r / r_c inside the cutoff and 0 outside:
//!
//! | law | force on i along r_ij / r | source |
//! | --- | --- | --- |
//! | [`Dpd`] | the sum of the next three, with one square root | Groot and Warren 1997 |
//! | [`DpdConservative`] | a_ij x | Groot and Warren 1997 |
//! | [`DpdDissipative`] | -gamma w_D (r_ij . v_ij) / r, w_D = x^s | Espanol and Warren 1995 |
//! | [`DpdRandom`] | (2 gamma kT / dt)^1/2 w_R theta_ij, w_R = w_D^1/2 | Espanol and Warren 1995 |
//! | [`LennardJones`] | 24 epsilon (2 (sigma / r)^12 - (sigma / r)^6) / r | Lennard-Jones 1931 |
//! | [`Wca`] | the same, its repulsive part only | Weeks, Chandler and Andersen 1971 |
//! | [`NarrowGaussian`] | (kT z* / d*^5) r exp(-r^2 / 2 d*^2) | Prakash and Ottinger 1999 |
//!
//! Along a bond ([`BondForce`](zimm_core::BondForce), driven by [`Bonded`](zimm_core::Bonded)):
//!
//! | law | tension at length Q | source |
//! | --- | --- | --- |
//! | [`Hooke`] | H Q | Rouse 1953 |
//! | [`Fraenkel`] | H (Q - l) | Fraenkel 1952 |
//! | [`Fene`] | H Q / (1 - Q^2 / Q_0^2) | Warner 1972 |
//! | [`MarkoSiggia`] | (H Q_0 / 6) (4 q - 1 + 1 / (1 - q)^2), q = Q / Q_0 | Marko and Siggia 1995 |
//!
//! Between any two bonds as straight segments ([`SegmentForce`], driven by [`SegmentRepulsion`]):
//!
//! | law | force at distance D | source |
//! | --- | --- | --- |
//! | [`PanManke`] | 3 a (1 - 3 D / r_c) | Pan and Manke 2003 |
//! | [`KumarLarson`] | A alpha exp(-alpha D) | Kumar and Larson 2001 |
//! | [`Phantom`] | none, but tallies hear of it | |
//!
//! On every particle ([`ForceField`](zimm_core::ForceField)):
//!
//! | law | force | source |
//! | --- | --- | --- |
//! | [`ConstantForce`] | the same on all | |
//! | [`Pulled`] | the same on some, its opposite shared by all others | |
//! | [`ReversePoiseuille`] | opposite in the two halves of the cell | Backer et al. 2005 |
//!
//! What DPD is made of can be exchanged: coefficients ([`Coefficient`]: a number or a [`SpeciesMatrix`]), weights
//! ([`Weight`]: [`Quadratic`], [`SquareRoot`], [`Power`]) and noise ([`Distribution`]: [`Uniform`], [`Normal`]).
//!
//! Units are those of the scene. Lengths given to a law lie between 1e-100 and 1e100, so that no power of them
//! overflows; particles closer than 1e-100 feel no soft force, for they have no direction.

mod constant_force;
mod dpd;
mod fene;
mod fraenkel;
mod hooke;
mod length;
mod lennard_jones;
mod marko_siggia;
mod narrow_gaussian;
mod pulled;
mod reverse_poiseuille;
mod segment_repulsion;
mod wca;

pub use constant_force::ConstantForce;
pub use dpd::{
    Coefficient, Distribution, Dpd, DpdConservative, DpdDissipative, DpdRandom, Normal, Power,
    Quadratic, SpeciesError, SpeciesMatrix, SquareRoot, Uniform, Weight,
};
pub use fene::Fene;
pub use fraenkel::Fraenkel;
pub use hooke::Hooke;
pub use lennard_jones::LennardJones;
pub use marko_siggia::MarkoSiggia;
pub use narrow_gaussian::NarrowGaussian;
pub use pulled::Pulled;
pub use reverse_poiseuille::ReversePoiseuille;
pub use segment_repulsion::{
    Approach, KumarLarson, PanManke, Phantom, SegmentForce, SegmentRepulsion,
};
pub use wca::Wca;
