//! Schemes in time: each is one [`Stepper`](zimm_core::Stepper).
//!
//! | scheme | equations of motion | order in the time step |
//! | --- | --- | --- |
//! | [`GrootWarren`] | Newton in peculiar velocities (SLLOD), with friction and noise in the forces | 2, with friction 1 |
//! | [`Shardlow`] | the same, with friction and noise between pairs in the stepper | 2 |
//! | [`DpdBaoab`] | the same, with friction and noise between pairs in the stepper | 2 |
//! | [`LoweAndersen`] | the same, with relative velocities of pairs drawn anew | 2 |
//! | [`Langevin`] | the same, with friction against the flow and noise on every particle | 2 |
//!
//! Velocities are peculiar, `c = v - kappa r`, and all schemes solve
//!
//! ```text
//! dr/dt = c + kappa r        m dc/dt = F - m kappa c
//! ```
//!
//! (Evans and Morriss 1990, SLLOD). In the laboratory this reads `m dv/dt = F + m (dkappa/dt + kappa kappa) r`. In
//! steady shear `kappa kappa` is zero and the equations are Newton's. In extension `m kappa kappa r` is the force that
//! sustains the flow. When a flow starts or changes, `m dkappa/dt r` sets the whole profile at once.
//!
//! All schemes share four properties:
//!
//! * Streaming between forces uses the boundary's own deformation, so that particles and lattice are carried alike. It
//!   is exact to rounding while `|kappa| dt` is below 0.05.
//! * Positions are wrapped in every step. Image counts are kept if the particles have them.
//! * A step is taken whole or not at all. On an error the system is as it was, bit for bit, and the tally has heard
//!   nothing.
//! * Nothing that matters is kept between steps but in the system, so that a restart needs the system alone. The bits
//!   of a trajectory are the same on any number of threads.
//!
//! # DPD
//!
//! What a time step of 0.05 does to the fluid of Groot and Warren (density 3, a = 25, gamma = 4.5; 1536 particles, 300 time
//! units; in the last digit errors of 2, of 1 in U/N). Positions have a temperature of their own, the configurational one
//! (Rugh 1997), that tells how close the structure is to the true one; so does the energy U per particle.
//!
//! | scheme | kinetic T | T of positions | U/N | diffusivity | CPU time of a step |
//! | --- | --- | --- | --- | --- | --- |
//! | [`GrootWarren`], lambda = 1/2 | 1.043 | 1.094 | 4.596 | 0.312 | 1 |
//! | [`GrootWarren`], lambda = 0.65 | 1.004 | 1.058 | 4.575 | 0.298 | 1 |
//! | [`Shardlow`] | 1.015 | 1.079 | 4.584 | 0.300 | 3.5 |
//! | [`DpdBaoab`] | 0.970 | 1.015 | 4.549 | 0.288 | 3.5 |
//! | [`LoweAndersen`], rate 5 | 1.004 | 1.102 | 4.592 | its own | 2 |
//! | exact | 1 | 1 | 4.544 | 0.290 | |
//!
//! A soft repulsion at this friction errs as its Verlet scheme does, whatever the bath. With Groot and Warren's scheme the
//! friction errs as well, the more the stronger it is; the pair baths stay exact there, and the scheme of Lowe and
//! Andersen is made for it.

mod dpd_baoab;
mod friction;
mod groot_warren;
mod langevin;
mod lowe_andersen;
mod pair_bath;
mod shardlow;
mod stage;

pub use dpd_baoab::DpdBaoab;
pub use groot_warren::GrootWarren;
pub use langevin::Langevin;
pub use lowe_andersen::LoweAndersen;
pub use shardlow::Shardlow;
