//! Schemes in time: each is one [`Stepper`](zimm_core::Stepper).
//!
//! | scheme | equations of motion | order in the time step |
//! | --- | --- | --- |
//! | [`GrootWarren`] | Newton in peculiar velocities (SLLOD), with friction and noise in the forces | 2, with friction 1 |
//! | [`Langevin`] | the same, with friction against the flow and noise on every particle | 2 |
//!
//! Velocities are peculiar, `c = v - kappa r`, and both schemes solve
//!
//! ```text
//! dr/dt = c + kappa r        m dc/dt = F - m kappa c
//! ```
//!
//! (Evans and Morriss 1990, SLLOD). In the laboratory this reads `m dv/dt = F + m (dkappa/dt + kappa kappa) r`. In
//! steady shear `kappa kappa` is zero and the equations are Newton's. In extension `m kappa kappa r` is the force that
//! sustains the flow. When a flow starts or changes, `m dkappa/dt r` sets the whole profile at once.
//!
//! Both schemes share four properties:
//!
//! * Streaming between forces uses the boundary's own deformation, so that particles and lattice are carried alike. It
//!   is exact to rounding while `|kappa| dt` is below 0.05.
//! * Positions are wrapped in every step. Image counts are kept if the particles have them.
//! * A step is taken whole or not at all. On an error the system is as it was, bit for bit, and the tally has heard
//!   nothing.
//! * Nothing that matters is kept between steps but in the system, so that a restart needs the system alone. The bits
//!   of a trajectory are the same on any number of threads.

mod groot_warren;
mod langevin;
mod stage;

pub use groot_warren::GrootWarren;
pub use langevin::Langevin;
