//! Trajectories that people's tools read, and that zimm reads back.
//!
//! | format | written by | read back by | who reads it | directions | open space |
//! | --- | --- | --- | --- | --- | --- |
//! | extended XYZ | [`XyzWriter`] | [`XyzReader`] | OVITO, ASE, and whatever reads plain XYZ | of the scene | yes |
//! | LAMMPS dump, text | [`DumpWriter`] | | LAMMPS, OVITO, ASE, VMD, MDAnalysis | turned with the cell | yes |
//!
//! Extended XYZ is the one to keep: nothing is turned, every number comes back with the same bits, and a
//! [`Snapshot`] becomes a scene again ([`Snapshot::into_system`]) that any observable measures after the fact. The dump
//! is for tools that know LAMMPS best. What OVITO and ASE make of both is tested; the other tools are taken at their word.
//!
//! Both write velocities **in the laboratory**, v = c + kappa r, as their readers expect them, for the image of the
//! particle in the primary cell; [`Snapshot::into_system`] takes kappa r off again. A file tells of the scene as it is at
//! the moment, so that image counts are those of the present basis. Both go to any [`Write`](std::io::Write), one
//! frame after another, in memory that does not grow with the run.
//!
//! ```
//! use zimm_core::{Clock, DVec3, Open, Particles, System};
//! use zimm_output::{XyzReader, XyzWriter};
//!
//! let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?.with_velocities(vec![DVec3::Y, -DVec3::Y])?;
//! let mut system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
//!
//! let mut file = Vec::new();
//! let mut trajectory = XyzWriter::new(&mut file);
//! for _ in 0..3 {
//!     // ... a step of the system ...
//!     system.clock.tick();
//!     trajectory.write(&system.frame())?;
//! }
//! drop(trajectory);
//!
//! for (snapshot, step) in XyzReader::new(file.as_slice()).zip(1..) {
//!     let again = snapshot?.into_system(Open)?;
//!     assert_eq!(again.clock.now().step, step);
//!     assert_eq!(again.particles.velocities(), system.particles.velocities());
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod dump_writer;
mod elements;
mod error;
mod lines;
mod rows;
mod snapshot;
mod xyz_reader;
mod xyz_writer;

pub use dump_writer::DumpWriter;
pub use error::OutputError;
pub use snapshot::Snapshot;
pub use xyz_reader::XyzReader;
pub use xyz_writer::XyzWriter;
