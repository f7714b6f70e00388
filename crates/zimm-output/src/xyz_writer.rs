use crate::OutputError;
use crate::elements;
use crate::rows::Rows;
use std::io::{BufWriter, Write};
use zimm_core::{Boundary, DMat3, DVec3, Frame, Molecules};

/// Writes frames as extended XYZ: a line with the number of particles, a line of keys, a line for each particle.
///
/// | key | what it holds |
/// | --- | --- |
/// | `Lattice` | the basis vectors a, b, c of the cell, in the directions of the scene; not in open space |
/// | `Origin` | the corner of the cell that is centred on the origin |
/// | `pbc` | `T T T`, or `F F F` in open space |
/// | `Properties` | names, kinds and widths of the columns |
/// | `Time`, `Timestep`, `dt`, `kT`, `seed` | the moment |
/// | `velocity_gradient` | kappa_ij = dv_i / dx_j column by column; only where space flows |
///
/// | column | what it holds |
/// | --- | --- |
/// | `species` | the symbol of the element of atomic number species + 1, for there are tools that know nothing else |
/// | `pos` | position in the primary cell |
/// | `velo` | velocity **in the laboratory**, c + kappa r for the image in the primary cell |
/// | `mass` | mass |
/// | `map_shift` | image counts: without wrapping the particle would be at pos + a n_1 + b n_2 + c n_3 |
/// | `id` | identity, from 0 |
/// | `molecule` | number of the molecule, from 1; 0 for a particle of none |
///
/// Columns that the frame does not have are left out, but for the species. Numbers have as many digits as it takes to
/// read back the same bits. A frame is in the hands of the sink when [`write`](Self::write) returns. Names are those of
/// libAtoms and OVITO.
///
/// ```
/// use zimm_core::{Clock, DVec3, Molecules, Open, Particles, System};
/// use zimm_output::XyzWriter;
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::new(1.0, 0.1, -2e-9)])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 42)?);
///
/// let mut file = Vec::new();
/// let dumbbell = Molecules::linear(0, 1, 2)?;
/// XyzWriter::new(&mut file).with_molecules([dumbbell]).write(&system.frame())?;
/// assert_eq!(
///     String::from_utf8(file)?,
///     "2\n\
///      pbc=\"F F F\" Properties=species:S:1:pos:R:3:molecule:I:1 Time=0.0 Timestep=0 dt=0.01 kT=1.0 seed=42\n\
///      H 0.0 0.0 0.0 1\n\
///      H 1.0 0.1 -2e-9 1\n",
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct XyzWriter<W: Write> {
    sink: BufWriter<W>,
    names: Vec<String>,
    molecules: Vec<Molecules>,
}

impl<W: Write> XyzWriter<W> {
    /// A writer to any sink; it needs no buffer of its own.
    pub fn new(sink: W) -> Self {
        Self {
            sink: BufWriter::new(sink),
            names: elements::names(),
            molecules: Vec::new(),
        }
    }

    /// Tells of molecules too, numbered through in this order.
    pub fn with_molecules(mut self, molecules: impl Into<Vec<Molecules>>) -> Self {
        self.molecules = molecules.into();
        self
    }

    /// Writes one frame.
    ///
    /// # Errors
    /// If the sink fails; or, before anything is written, if the columns of the frame do not fit together or hold what
    /// is not finite.
    pub fn write<B: Boundary>(&mut self, frame: &Frame<'_, B>) -> Result<(), OutputError> {
        let rows = Rows::new(frame, &self.molecules)?;
        let out = &mut self.sink;
        writeln!(out, "{}", frame.len())?;
        if let Some(cell) = frame.boundary.cell() {
            let corner = cell * DVec3::splat(-0.5);
            write!(out, "Lattice=\"{}\" ", matrix(cell))?;
            write!(out, "Origin=\"{}\" pbc=\"T T T\"", vector(corner))?;
        } else {
            write!(out, "pbc=\"F F F\"")?;
        }
        write!(out, " Properties=species:S:1:pos:R:3")?;
        for (present, column) in [
            (!frame.velocities.is_empty(), ":velo:R:3"),
            (!frame.masses.is_empty(), ":mass:R:1"),
            (!frame.images.is_empty(), ":map_shift:I:3"),
            (!frame.ids.is_empty(), ":id:I:1"),
            (rows.has_molecules(), ":molecule:I:1"),
        ] {
            if present {
                write!(out, "{column}")?;
            }
        }
        let now = frame.now;
        write!(out, " Time={:?} Timestep={}", now.time, now.step)?;
        write!(out, " dt={:?} kT={:?} seed={}", now.dt, now.kt, now.seed)?;
        if B::FLOWS {
            let gradient = matrix(frame.boundary.gradient());
            write!(out, " velocity_gradient=\"{gradient}\"")?;
        }
        writeln!(out)?;
        for place in 0..frame.len() {
            let name = &self.names[usize::from(frame.species(place))];
            write!(out, "{name} {}", vector(frame.positions[place]))?;
            if let Some(velocity) = rows.velocity(place) {
                write!(out, " {}", vector(velocity))?;
            }
            if let Some(mass) = frame.masses.get(place) {
                write!(out, " {mass:?}")?;
            }
            if let Some(image) = frame.images.get(place) {
                write!(out, " {} {} {}", image.x, image.y, image.z)?;
            }
            if let Some(id) = frame.ids.get(place) {
                write!(out, " {id}")?;
            }
            if rows.has_molecules() {
                write!(out, " {}", rows.molecule(place))?;
            }
            writeln!(out)?;
        }
        Ok(out.flush()?)
    }
}

fn matrix(m: DMat3) -> impl std::fmt::Display {
    let columns = [m.x_axis, m.y_axis, m.z_axis].map(vector);
    std::fmt::from_fn(move |f| {
        let [a, b, c] = &columns;
        write!(f, "{a} {b} {c}")
    })
}

/// The debug form of a number is the shortest that reads back as the same bits, with an exponent where that is shorter.
fn vector(v: DVec3) -> impl std::fmt::Display {
    std::fmt::from_fn(move |f| write!(f, "{:?} {:?} {:?}", v.x, v.y, v.z))
}
