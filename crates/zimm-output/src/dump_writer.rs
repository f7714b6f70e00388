use crate::OutputError;
use crate::rows::Rows;
use std::io::{BufWriter, Write};
use zimm_core::{Boundary, DMat3, DVec3, Frame, IVec3, Molecules};

/// Writes frames as a LAMMPS dump in text form.
///
/// LAMMPS wants a cell whose first vector is along x and whose second is in the plane of x and y, right-handed:
///
/// ```text
///     | lx xy xz |
/// H = |  0 ly yz |        lx, ly, lz > 0
///     |  0  0 lz |
/// ```
///
/// So every frame is turned as a whole: the basis that is written, the reduced one of the frame, positions and
/// velocities. Distances and angles within a frame stay what they are. In shear the flow stays along x. In the other
/// flows the cell turns in the laboratory, hence the laboratory turns in the dump; directions in space are to be had
/// from [`XyzWriter`](crate::XyzWriter). The third vector of a left-handed basis is written with the other sign, and so
/// are the counts of images along it. A cell at rest without tilt is written as a brick, any other as triclinic, with
/// `xy xz yz`. Open space is written as bounds of type `s`, shrunk to fit the particles.
///
/// | column | what it holds |
/// | --- | --- |
/// | `id` | identity, from 1 |
/// | `mol` | number of the molecule, from 1; 0 for a particle of none |
/// | `type` | species, from 1 |
/// | `mass` | mass |
/// | `x y z` | position in the primary cell |
/// | `ix iy iz` | image counts |
/// | `vx vy vz` | velocity **in the laboratory**, c + kappa r for the image in the primary cell |
///
/// Columns that the frame does not have are left out, but for identity and type. `ITEM: TIME` tells the time. A frame is
/// in the hands of the sink when [`write`](Self::write) returns.
///
/// ```
/// use zimm_core::{Clock, DVec3, Open, Particles, System};
/// use zimm_output::DumpWriter;
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::new(1.0, 0.1, -2e-9)])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 42)?);
///
/// let mut file = Vec::new();
/// DumpWriter::new(&mut file).write(&system.frame())?;
/// assert!(String::from_utf8(file)?.ends_with(
///     "ITEM: BOX BOUNDS ss ss ss\n\
///      0.0 1.0\n\
///      0.0 0.1\n\
///      -2e-9 0.0\n\
///      ITEM: ATOMS id type x y z\n\
///      1 1 0.0 0.0 0.0\n\
///      2 1 1.0 0.1 -2e-9\n",
/// ));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct DumpWriter<W: Write> {
    sink: BufWriter<W>,
    molecules: Vec<Molecules>,
}

impl<W: Write> DumpWriter<W> {
    /// A writer to any sink; it needs no buffer of its own.
    pub fn new(sink: W) -> Self {
        Self {
            sink: BufWriter::new(sink),
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
        writeln!(out, "ITEM: TIME\n{:?}", frame.now.time)?;
        writeln!(out, "ITEM: TIMESTEP\n{}", frame.now.step)?;
        writeln!(out, "ITEM: NUMBER OF ATOMS\n{}", frame.len())?;
        let turned = frame.boundary.cell().map(Turned::new);
        match turned {
            None => write_bounds(out, frame.positions)?,
            Some(turned) => turned.write_bounds(out, B::FLOWS)?,
        }
        write!(out, "ITEM: ATOMS id")?;
        for (present, columns) in [
            (rows.has_molecules(), "mol"),
            (true, "type"),
            (!frame.masses.is_empty(), "mass"),
            (true, "x y z"),
            (!frame.images.is_empty(), "ix iy iz"),
            (!frame.velocities.is_empty(), "vx vy vz"),
        ] {
            if present {
                write!(out, " {columns}")?;
            }
        }
        writeln!(out)?;
        let Turned {
            rotation, mirror, ..
        } = turned.unwrap_or(Turned::NOT);
        for place in 0..frame.len() {
            write!(out, "{}", u64::from(frame.id(place)) + 1)?;
            if rows.has_molecules() {
                write!(out, " {}", rows.molecule(place))?;
            }
            write!(out, " {}", u16::from(frame.species(place)) + 1)?;
            if let Some(mass) = frame.masses.get(place) {
                write!(out, " {mass:?}")?;
            }
            let r = rotation * frame.positions[place];
            write!(out, " {:?} {:?} {:?}", r.x, r.y, r.z)?;
            if let Some(&image) = frame.images.get(place) {
                let image = image.wrapping_mul(mirror);
                write!(out, " {} {} {}", image.x, image.y, image.z)?;
            }
            if let Some(velocity) = rows.velocity(place) {
                let v = rotation * velocity;
                write!(out, " {:?} {:?} {:?}", v.x, v.y, v.z)?;
            }
            writeln!(out)?;
        }
        Ok(out.flush()?)
    }
}

/// Open space has the bounds of what is in it.
fn write_bounds(out: &mut impl Write, positions: &[DVec3]) -> std::io::Result<()> {
    let first = positions.first().copied().unwrap_or(DVec3::ZERO);
    let low = positions.iter().fold(first, |low, &r| low.min(r));
    let high = positions.iter().fold(first, |high, &r| high.max(r));
    writeln!(out, "ITEM: BOX BOUNDS ss ss ss")?;
    for axis in 0..3 {
        writeln!(out, "{:?} {:?}", low[axis], high[axis])?;
    }
    Ok(())
}

/// How a frame is turned to bring its cell into LAMMPS' form.
#[derive(Clone, Copy, Debug)]
struct Turned {
    /// From the scene to the dump.
    rotation: DMat3,
    /// The cell in the dump.
    cell: DMat3,
    /// Signs of the basis vectors.
    mirror: IVec3,
}

impl Turned {
    const NOT: Self = Self {
        rotation: DMat3::IDENTITY,
        cell: DMat3::IDENTITY,
        mirror: IVec3::ONE,
    };

    fn new(basis: DMat3) -> Self {
        let [a, b] = [basis.x_axis, basis.y_axis];
        let (c, mirror) = if basis.determinant() < 0.0 {
            (-basis.z_axis, IVec3::new(1, 1, -1))
        } else {
            (basis.z_axis, IVec3::ONE)
        };
        let x = a / a.length();
        let xy = b.dot(x);
        let across = b - x * xy;
        let y = across / across.length();
        let z = x.cross(y);
        Self {
            rotation: DMat3::from_cols(x, y, z).transpose(),
            cell: DMat3::from_cols(
                DVec3::X * a.length(),
                DVec3::new(xy, across.length(), 0.0),
                DVec3::new(c.dot(x), c.dot(y), c.dot(z)),
            ),
            mirror,
        }
    }

    /// The smallest brick around the cell, centred on the origin, and the tilts.
    fn write_bounds(&self, out: &mut impl Write, flows: bool) -> std::io::Result<()> {
        let [a, b, c] = [self.cell.x_axis, self.cell.y_axis, self.cell.z_axis];
        let corner = -0.5 * (a + b + c);
        let (xy, xz, yz) = (b.x, c.x, c.y);
        let tilts = [[0.0, xy, xz, xy + xz], [0.0, yz, 0.0, yz], [0.0; 4]];
        let brick = !flows && [xy, xz, yz] == [0.0; 3];
        let kind = if brick { "" } else { " xy xz yz" };
        writeln!(out, "ITEM: BOX BOUNDS{kind} pp pp pp")?;
        for (axis, (tilts, tilt)) in tilts.into_iter().zip([xy, xz, yz]).enumerate() {
            let low = corner[axis] + tilts.into_iter().fold(0.0, f64::min);
            let high =
                corner[axis] + self.cell.col(axis)[axis] + tilts.into_iter().fold(0.0, f64::max);
            if brick {
                writeln!(out, "{low:?} {high:?}")?;
            } else {
                writeln!(out, "{low:?} {high:?} {tilt:?}")?;
            }
        }
        Ok(())
    }
}
