//! The ground that every crate of zimm stands on: what a particle, a cell, a pair and a random number are, and the
//! traits through which parts are put together. Force laws, boundaries, steppers and observables live in the leaf
//! crates; each depends on this one and on no other.
//!
//! | to add | implement | null object |
//! | --- | --- | --- |
//! | a non-bonded force law | [`PairForce`] | `()` |
//! | a spring | [`BondForce`] | `()` |
//! | any other force | [`ForceField`] | `()` |
//! | a space or a flow | [`Boundary`], [`Periodic`] | [`Open`] |
//! | a way to find pairs | [`Neighbours`] | `()` |
//! | a scheme in time | [`Stepper`] | `()` |
//! | a listener in the force loop | [`Tally`] | `()` |
//! | a measured quantity | [`Observable`], [`Estimator`] | `()` |
//!
//! Four contracts hold throughout:
//!
//! * **Velocities are peculiar**, `c = v - kappa r`: no image, wrap or remap of the cell ever touches a velocity.
//! * **Noise is addressed, never consumed**: a random number is a pure function of seed, step, domain and identities
//!   (see [`noise`]), so a trajectory depends neither on the order of pairs nor on threads nor on restarts.
//! * **Outputs are added to**, so parts compose by being called one after another; a tuple is a sum.
//! * **The unit type is "not in this scene"** and compiles to nothing.
//!
//! Stress is sigma = -(1/V) <sum m c c + sum r_ij F_ij>, tension positive, with F_ij the force on i from j and
//! r_ij = r_i - r_j. Units are those of the scene; DPD takes r_c = m = kT = 1.

pub mod noise;
#[cfg(feature = "start")]
pub mod start;

mod bonded;
mod boundary;
mod checkpoint;
mod error;
mod field;
mod lattice;
mod measure;
mod molecules;
mod neighbours;
mod pair;
mod pairwise;
mod parallel;
mod particles;
mod stepper;
mod system;
mod tally;
mod verlet;
mod within;

pub use bonded::{BondForce, Bonded};
pub use boundary::{Boundary, Open, Periodic, Remap};
pub use checkpoint::{load, load_file, save, save_file};
pub use error::{
    CheckpointError, ForceError, LatticeError, ListError, MobilityError, ParameterError,
    ParticleError, StepError,
};
pub use field::ForceField;
pub use glam::{DMat3, DVec3, IVec3};
pub use lattice::Lattice;
pub use measure::{Estimator, Observable};
pub use molecules::{Molecules, Topology, recentre};
pub use neighbours::{AllPairs, Neighbours, Row};
pub use pair::{Central, Pair, PairForce, Reads};
pub use pairwise::Pairwise;
pub use parallel::{Cut, each_block, for_each_chunk, for_each_chunk_of, replicas};
pub use particles::{Columns, Particles};
pub use stepper::Stepper;
pub use system::{Ahead, Clock, Frame, Now, System};
pub use tally::{Energy, Item, Tally, Virial};
pub use verlet::VerletList;
pub use within::WithinMolecules;
