//! Checkpoints: the whole state, bit for bit.

use crate::noise::MAPPING_VERSION;
use crate::{Boundary, CheckpointError, Clock, ForceField, ParticleError, Particles, System};
use glam::{DVec3, IVec3};
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::Path;

/// The line ends among these bytes give away a transfer that took the file for text.
const MAGIC: [u8; 8] = *b"zimm\r\n\x1a\n";
/// Version of the layout that [`save`] describes.
const FORMAT: u32 = 1;
/// Bytes before the body: magic, two versions, length of the body.
const HEAD: u64 = 24;
/// Bytes after the body: checksum.
const TAIL: u64 = 8;

/// Writes the whole state, bit for bit: clock, particles with every column that they have, and the cell and velocity
/// gradient that [`load`] is to find again.
///
/// A checkpoint is a barrier. The field forgets its lists, so that the run that goes on and the one that starts again
/// sum their forces in the same order from here and agree in every bit.
///
/// The bytes, little-endian throughout:
///
/// ```text
/// 8     7a 69 6d 6d 0d 0a 1a 0a
/// 4     version of this layout: 1
/// 4     version of the noise mapping
/// 8     length of the body
///       body: time step, thermal energy, seed, step, step and time at which the time step was last set;
///             cell and velocity gradient, column by column;
///             positions, velocities, forces, masses, species, images, identities
/// 8     checksum of all bytes before: FNV-1a in 64 bits (Fowler, Noll and Vo 1991)
/// ```
///
/// Cell, gradient and columns each begin with the number of their entries in 8 bytes; it is zero for what the scene
/// does not have.
///
/// # Errors
/// If `out` fails, or if the state could not be read back, because columns do not fit together or are not finite.
/// In the second case nothing is written.
pub fn save<B: Boundary, F: ForceField<B>>(
    system: &System<B>,
    field: &mut F,
    out: &mut impl Write,
) -> Result<(), CheckpointError> {
    field.forget();
    let body = body_of(system);
    State::from_body(&body)?;
    let mut head = MAGIC.to_vec();
    FORMAT.put(&mut head);
    MAPPING_VERSION.put(&mut head);
    (body.len() as u64).put(&mut head);
    out.write_all(&head)?;
    out.write_all(&body)?;
    out.write_all(&checksum([&head, &body]).to_le_bytes())?;
    Ok(out.flush()?)
}

/// Reads what [`save`] has written, and no byte beyond it. The boundary is put to the time of the checkpoint and has
/// to be the one in which the run was made.
///
/// ```
/// use zimm_core::{Clock, DVec3, Open, Particles, System, load, save};
///
/// let particles = Particles::new(vec![DVec3::X, DVec3::Y])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 42)?);
/// let mut file = Vec::new();
/// save(&system, &mut (), &mut file)?;
///
/// let again = load(Open, &mut file.as_slice())?;
/// assert_eq!(again.particles, system.particles);
/// assert_eq!(again.clock, system.clock);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the bytes are no checkpoint, of another version of the layout or of the noise mapping, cut off, damaged, or if
/// the boundary's cell or velocity gradient differs in any bit at that time.
pub fn load<B: Boundary>(
    mut boundary: B,
    input: &mut impl Read,
) -> Result<System<B>, CheckpointError> {
    let State {
        clock,
        cell,
        gradient,
        particles,
    } = State::from_body(&verified_body(input)?)?;
    let time = clock.now().time;
    boundary.advance(time);
    for (quantity, found, expected) in [
        ("cell", cell_of(&boundary), cell),
        ("velocity gradient", gradient_of(&boundary), gradient),
    ] {
        if !found
            .iter()
            .map(|x| x.to_bits())
            .eq(expected.iter().map(|x| x.to_bits()))
        {
            return Err(CheckpointError::Boundary {
                time,
                quantity,
                found,
                expected,
            });
        }
    }
    Ok(System {
        boundary,
        particles,
        clock,
    })
}

/// Saves to a path. The bytes go to a file beside it whose name has `.part` added, which then takes the place of the
/// former file, so that a save that is interrupted leaves the former file whole.
///
/// # Errors
/// As [`save`], and if the path names no file.
pub fn save_file<B: Boundary, F: ForceField<B>>(
    system: &System<B>,
    field: &mut F,
    path: impl AsRef<Path>,
) -> Result<(), CheckpointError> {
    let path = path.as_ref();
    let mut name = path
        .file_name()
        .ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::InvalidInput,
                format!("{} names no file", path.display()),
            )
        })?
        .to_os_string();
    name.push(".part");
    let part = path.with_file_name(name);
    let mut file = File::create(&part)?;
    let written = save(system, field, &mut file)
        .and_then(|()| Ok(file.sync_all()?))
        .and_then(|()| Ok(fs::rename(&part, path)?));
    if written.is_err() {
        // The reason of the failure is worth more than that of a failed cleaning.
        fs::remove_file(&part).ok();
    }
    written
}

/// Loads from a path.
///
/// # Errors
/// As [`load`], and if there is no such file.
pub fn load_file<B: Boundary>(
    boundary: B,
    path: impl AsRef<Path>,
) -> Result<System<B>, CheckpointError> {
    load(boundary, &mut File::open(path)?)
}

/// Reads head, body and checksum, and answers with the body if all is as it was written. Nothing is allocated that the
/// input does not fill.
fn verified_body(input: &mut impl Read) -> Result<Vec<u8>, CheckpointError> {
    let mut head = Vec::new();
    input.by_ref().take(HEAD).read_to_end(&mut head)?;
    let begins = head.len().min(MAGIC.len());
    if head[..begins] != MAGIC[..begins] {
        let found = head[..begins].to_vec();
        return Err(CheckpointError::Foreign { found });
    }
    let complete = |found: usize, expected: u64| match found as u64 {
        found if found < expected => Err(CheckpointError::Truncated { found, expected }),
        _ => Ok(()),
    };
    complete(head.len(), HEAD)?;
    let mut fields = Reader(&head[begins..]);
    for (quantity, known) in [("layout", FORMAT), ("noise mapping", MAPPING_VERSION)] {
        let found = fields.one()?;
        if found != known {
            return Err(CheckpointError::Version {
                quantity,
                found,
                known,
            });
        }
    }
    let length: u64 = fields.one()?;
    let mut body = Vec::new();
    input
        .by_ref()
        .take(length.saturating_add(TAIL))
        .read_to_end(&mut body)?;
    complete(head.len() + body.len(), length.saturating_add(HEAD + TAIL))?;
    let tail = body.split_off(length as usize);
    let (found, expected) = (checksum([&head, &body]), Reader(&tail).one()?);
    if found == expected {
        Ok(body)
    } else {
        Err(CheckpointError::Damaged { found, expected })
    }
}

/// FNV-1a: each byte is a bijection of the state, so that no single wrong byte can go unseen.
fn checksum(parts: [&[u8]; 2]) -> u64 {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    let bytes = parts.into_iter().flatten();
    bytes.fold(OFFSET, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(PRIME)
    })
}

fn body_of<B: Boundary>(system: &System<B>) -> Vec<u8> {
    let mut body = Vec::new();
    let now = system.clock.now();
    let (epoch_step, epoch_time) = system.clock.epoch();
    now.dt.put(&mut body);
    now.kt.put(&mut body);
    now.seed.put(&mut body);
    now.step.put(&mut body);
    epoch_step.put(&mut body);
    epoch_time.put(&mut body);
    put_column(&mut body, &cell_of(&system.boundary));
    put_column(&mut body, &gradient_of(&system.boundary));
    let particles = &system.particles;
    put_column(&mut body, &particles.positions);
    put_column(&mut body, &particles.velocities);
    put_column(&mut body, &particles.forces);
    put_column(&mut body, &particles.masses);
    put_column(&mut body, &particles.species);
    put_column(&mut body, &particles.images);
    put_column(&mut body, &particles.ids);
    body
}

fn cell_of<B: Boundary>(boundary: &B) -> Vec<f64> {
    boundary
        .cell()
        .map(|h| h.to_cols_array().to_vec())
        .unwrap_or_default()
}

fn gradient_of<B: Boundary>(boundary: &B) -> Vec<f64> {
    boundary.gradient().to_cols_array().to_vec()
}

/// What a body holds.
struct State {
    clock: Clock,
    cell: Vec<f64>,
    gradient: Vec<f64>,
    particles: Particles,
}

impl State {
    fn from_body(body: &[u8]) -> Result<Self, CheckpointError> {
        let mut reader = Reader(body);
        Ok(Self {
            clock: reader.clock()?,
            cell: reader.column()?,
            gradient: reader.column()?,
            particles: reader.particles()?,
        })
    }
}

/// The bytes not yet read.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn one<A: Bytes>(&mut self) -> Result<A, CheckpointError> {
        let found = self.0.len() as u64;
        let expected = A::LENGTH;
        A::get(&mut self.0).ok_or(CheckpointError::Truncated { found, expected })
    }

    /// A count and as many entries; the count is believed only if the bytes are there.
    fn column<A: Bytes>(&mut self) -> Result<Vec<A>, CheckpointError> {
        let count: u64 = self.one()?;
        let (found, expected) = (self.0.len() as u64, count.saturating_mul(A::LENGTH));
        if found < expected {
            return Err(CheckpointError::Truncated { found, expected });
        }
        (0..count).map(|_| self.one()).collect()
    }

    fn clock(&mut self) -> Result<Clock, CheckpointError> {
        let (dt, kt, seed) = (self.one()?, self.one()?, self.one()?);
        let (step, epoch_step, epoch_time) = (self.one()?, self.one()?, self.one()?);
        Ok(Clock::restored(dt, kt, seed, step, epoch_step, epoch_time)?)
    }

    fn particles(&mut self) -> Result<Particles, CheckpointError> {
        let mut particles = Particles::new(self.column()?)?;
        let velocities: Vec<DVec3> = self.column()?;
        let forces: Vec<DVec3> = self.column()?;
        let masses: Vec<f64> = self.column()?;
        let species: Vec<u8> = self.column()?;
        let images: Vec<IVec3> = self.column()?;
        let ids: Vec<u32> = self.column()?;
        if !velocities.is_empty() {
            particles = particles.with_velocities(velocities)?;
        }
        if !masses.is_empty() {
            particles = particles.with_masses(masses)?;
        }
        if !species.is_empty() {
            particles = particles.with_species(species)?;
        }
        if !ids.is_empty() {
            particles = particles.with_ids(ids)?;
        }
        for (column, found) in [("forces", forces.len()), ("images", images.len())] {
            let particles = particles.len();
            if found != 0 && found != particles {
                return Err(ParticleError::Length {
                    column,
                    found,
                    particles,
                }
                .into());
            }
        }
        if let Some(particle) = forces.iter().position(|f| !f.is_finite()) {
            return Err(ParticleError::NotFinite {
                column: "forces",
                particle,
                value: forces[particle].to_array(),
            }
            .into());
        }
        (particles.forces, particles.images) = (forces, images);
        Ok(particles)
    }
}

fn put_column<A: Bytes>(out: &mut Vec<u8>, column: &[A]) {
    (column.len() as u64).put(out);
    for entry in column {
        entry.put(out);
    }
}

/// Fixed little-endian bytes.
trait Bytes: Copy {
    /// How many.
    const LENGTH: u64;

    fn put(self, out: &mut Vec<u8>);

    /// Takes the value off the front, if the bytes suffice.
    fn get(from: &mut &[u8]) -> Option<Self>;
}

macro_rules! bytes_of_numbers {
    ($($number:ty),+) => {$(
        impl Bytes for $number {
            const LENGTH: u64 = size_of::<Self>() as u64;

            fn put(self, out: &mut Vec<u8>) {
                out.extend(self.to_le_bytes());
            }

            fn get(from: &mut &[u8]) -> Option<Self> {
                let (bytes, rest) = from.split_first_chunk()?;
                *from = rest;
                Some(Self::from_le_bytes(*bytes))
            }
        }
    )+};
}
bytes_of_numbers!(u8, u32, i32, u64, f64);

macro_rules! bytes_of_vectors {
    ($($vector:ty: $number:ty),+) => {$(
        impl Bytes for $vector {
            const LENGTH: u64 = 3 * <$number>::LENGTH;

            fn put(self, out: &mut Vec<u8>) {
                self.to_array().into_iter().for_each(|x| x.put(out));
            }

            fn get(from: &mut &[u8]) -> Option<Self> {
                Some(Self::new(Bytes::get(from)?, Bytes::get(from)?, Bytes::get(from)?))
            }
        }
    )+};
}
bytes_of_vectors!(DVec3: f64, IVec3: i32);
