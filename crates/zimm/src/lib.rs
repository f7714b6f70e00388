//! Polymer solutions in flow, from parts that compose as types.
//!
//! This crate has no code of its own: it re-exports the family's crates behind features and offers a [`prelude`].
//! A scene that wants less turns the default features off and names what it uses; a crate that it does not name is
//! not compiled.
//!
//! | feature | crate | what is in it |
//! | --- | --- | --- |
//! | always | [`core`] | particles, lattices, neighbour lists, addressed noise, the traits |
//! | `forces` | [`forces`] | DPD, Lennard-Jones, springs, springs that repel each other, body forces |
//! | `boundary` | [`boundary`] | open flows, periodic boxes, shear, extension, mixed flow |
//! | `integrators` | [`integrators`] | Groot-Warren velocity Verlet in peculiar velocities, Langevin, Lowe-Andersen, Shardlow's splitting, pairwise BAOAB |
//! | `brownian` | [`brownian`] | Brownian dynamics: free draining, schemes for stiff springs |
//! | `hydrodynamics` | [`brownian`] | Rotne-Prager-Yamakawa mobilities, Ewald sums, a mesh, their square roots (not by default) |
//! | `analysis` | [`analysis`] | stress, temperatures, material functions, averages with error bars, structure |
//! | `output` | [`output`] | trajectories that other tools read, and that are read back |
//! | `rayon` | | threads, with the same bits as without |
//! | `start` | | random initial states |
//!
//! The README holds a scene of 25 lines; the crates' own pages explain each part of it.
//!
//! # Threads
//! Every step shares its work among the threads of the rayon pool that it is in, with the same bits on any number. From a
//! thread outside of a pool each share of work is handed over and waited for, some ten times a step, which costs a sixth of
//! the time on two cores: run a scene inside one, with `rayon::ThreadPoolBuilder::new().build()?.install(|| ...)`. Many small
//! scenes go side by side with [`core::replicas`].

pub use zimm_core as core;

#[cfg(feature = "analysis")]
pub use zimm_analysis as analysis;
#[cfg(feature = "boundary")]
pub use zimm_boundary as boundary;
#[cfg(feature = "brownian")]
pub use zimm_brownian as brownian;
#[cfg(feature = "forces")]
pub use zimm_forces as forces;
#[cfg(feature = "integrators")]
pub use zimm_integrators as integrators;
#[cfg(feature = "output")]
pub use zimm_output as output;

/// Everything that a scene names, in one import.
pub mod prelude {
    #[cfg(feature = "analysis")]
    pub use zimm_analysis::*;
    #[cfg(feature = "boundary")]
    pub use zimm_boundary::*;
    #[cfg(feature = "brownian")]
    pub use zimm_brownian::*;
    pub use zimm_core::*;
    #[cfg(feature = "forces")]
    pub use zimm_forces::*;
    #[cfg(feature = "integrators")]
    pub use zimm_integrators::*;
    #[cfg(feature = "output")]
    pub use zimm_output::*;
}

/// The README's scene, compiled and run.
#[cfg(all(
    doctest,
    feature = "forces",
    feature = "boundary",
    feature = "integrators",
    feature = "analysis",
    feature = "start"
))]
#[doc = include_str!("../../../README.md")]
struct Readme;
