//! The mobility of Rotne, Prager and Yamakawa in open space.

use crate::{Entries, Mobility};
use std::ops::Range;
use zimm_core::{
    Boundary, DMat3, DVec3, Frame, MobilityError, Molecules, Neighbours, ParameterError,
    WithinMolecules, each_block,
};

/// Beads in an unbounded solvent, after Rotne and Prager (1969) and Yamakawa (1970): the velocity of a bead for a force
/// on another at the separation r is
///
/// ```text
/// M = 1 / zeta (A I + B rr / r^2)
///
/// A = 3a/4r (1 + 2a^2 / 3r^2)    B = 3a/4r (1 - 2a^2 / r^2)    r >= 2a
/// A = 1 - 9r / 32a               B = 3r / 32a                  r <= 2a
/// ```
///
/// with zeta the friction of a bead and a its radius, zeta = 6 pi eta a in a solvent of viscosity eta. M is positive
/// definite however beads overlap, and singular where two coincide. In units of l_H and zeta / 4H the friction is 4 and
/// the radius sqrt(pi) h*.
///
/// Every product costs N^2 pairs, and there is no storage besides positions. [`Ewald`](crate::Ewald) is for cells.
///
/// ```
/// use zimm_brownian::{Mobility, Rpy};
/// use zimm_core::{Clock, DVec3, Open, Particles, System};
///
/// let particles = Particles::new(vec![DVec3::ZERO, 2.0 * DVec3::X])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut mobility = Rpy::new(4.0, 1.0)?;
/// mobility.bind(&system.frame())?;
/// let mut velocities = [DVec3::ZERO; 2];
/// Mobility::<Open>::apply(&mut mobility, &[DVec3::X, DVec3::ZERO], &mut velocities);
/// assert_eq!(velocities, [0.25 * DVec3::X, 0.25 * 0.625 * DVec3::X]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rpy {
    mobility: f64,
    radius: f64,
    molecules: Option<(Molecules, WithinMolecules)>,
    /// Where the bead at each place stands in the columns below; nothing if at its place.
    slots: Vec<u32>,
    positions: [Vec<f64>; 3],
    forces: [Vec<f64>; 3],
    velocities: Vec<DVec3>,
    arch: pulp::Arch,
}

impl Rpy {
    /// All beads move all others. For spaces without a lattice: in a cell, binding it is an error.
    ///
    /// # Errors
    /// If `friction` or `radius` is not finite and above zero.
    pub fn new(friction: f64, radius: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            mobility: ParameterError::positive("friction", friction)?.recip(),
            radius: ParameterError::positive("radius", radius)?,
            molecules: None,
            slots: Vec::new(),
            positions: Default::default(),
            forces: Default::default(),
            velocities: Vec::new(),
            arch: pulp::Arch::new(),
        })
    }

    /// Beads move those of the same molecule and no others, so that many isolated chains fit into one system; a bead of
    /// no molecule moves by itself. For all spaces: a molecule in a cell is put together along its bonds, each by its
    /// nearest image.
    ///
    /// ```
    /// use zimm_brownian::{Entries, Mobility, Rpy};
    /// use zimm_core::{Clock, DMat3, DVec3, Molecules, Open, Particles, System};
    ///
    /// // Two dumbbells in the same place.
    /// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X, DVec3::ZERO, DVec3::Y])?;
    /// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
    /// let mut mobility = Rpy::new(1.0, 0.4)?.within(Molecules::linear(0, 2, 2)?);
    /// mobility.bind(&system.frame())?;
    /// assert_eq!(Entries::<Open>::entry(&mobility, 0, 2), DMat3::ZERO);
    /// assert_eq!(Entries::<Open>::runs(&mobility), [0..2, 2..4]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn within(mut self, molecules: Molecules) -> Self {
        self.molecules = Some((molecules, WithinMolecules::new(molecules)));
        self
    }

    fn slot(&self, place: usize) -> usize {
        self.slots.get(place).map_or(place, |&slot| slot as usize)
    }

    /// The beads that interact with one, itself among them, as slots.
    fn company(&self, slot: usize) -> Range<usize> {
        let Some((molecules, _)) = self.molecules else {
            return 0..self.positions[0].len();
        };
        let all = molecules.identities();
        let (first, end) = (all.start as usize, all.end as usize);
        if !(first..end).contains(&slot) {
            return slot..slot + 1;
        }
        let beads = molecules.beads() as usize;
        let start = first + (slot - first) / beads * beads;
        start..start + beads
    }

    fn position(&self, slot: usize) -> DVec3 {
        let [x, y, z] = &self.positions;
        DVec3::new(x[slot], y[slot], z[slot])
    }
}

impl<B: Boundary> Mobility<B> for Rpy {
    fn bind(&mut self, frame: &Frame<'_, B>) -> Result<(), MobilityError> {
        self.slots.clear();
        let positions = match &mut self.molecules {
            Some((_, source)) => {
                source.refresh(frame, f64::INFINITY)?;
                self.slots.extend_from_slice(frame.ids);
                Neighbours::<B>::positions(source)
            }
            None if frame.boundary.cell().is_some() => {
                return Err(MobilityError::Cell {
                    radius: self.radius,
                    quantity: "number of lattice vectors",
                    found: 3.0,
                    allowed: "0: this mobility is for unbounded space",
                });
            }
            None => {
                finite("position", frame.positions)?;
                frame.positions
            }
        };
        split(positions, &mut self.positions);
        Ok(())
    }

    fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        const ROWS: usize = 64;
        let mut sorted = std::mem::take(&mut self.velocities);
        sorted.clear();
        sorted.resize(forces.len(), DVec3::ZERO);
        for (place, &force) in forces.iter().enumerate() {
            sorted[self.slot(place)] = force;
        }
        split(&sorted, &mut self.forces);
        let this = &*self;
        let mut blocks: Vec<_> = sorted.chunks_mut(ROWS).collect();
        each_block(&mut blocks, |k, rows| {
            this.arch.dispatch(Product {
                mobility: this,
                start: k * ROWS,
                rows,
            });
        });
        for (place, velocity) in velocities.iter_mut().enumerate() {
            *velocity += this.mobility * sorted[this.slot(place)];
        }
        self.velocities = sorted;
    }

    fn alone(&self, _: usize) -> f64 {
        self.mobility
    }
}

impl<B: Boundary> Entries<B> for Rpy {
    fn entry(&self, i: usize, j: usize) -> DMat3 {
        let (i, j) = (self.slot(i), self.slot(j));
        if !self.company(i).contains(&j) {
            return DMat3::ZERO;
        }
        let r = self.position(i) - self.position(j);
        let [iso, dyad, inverse] = pair(r.length_squared(), self.radius);
        self.mobility * block(r, [iso, dyad * inverse])
    }

    fn runs(&self) -> Vec<Range<usize>> {
        let beads = self.positions[0].len();
        // The last place of the company of each bead: runs end where no company goes on.
        let mut last = vec![0; beads];
        for place in 0..beads {
            let company = &mut last[self.company(self.slot(place)).start];
            *company = place.max(*company);
        }
        let (mut runs, mut start, mut end) = (Vec::new(), 0, 0);
        for place in 0..beads {
            end = last[self.company(self.slot(place)).start].max(end);
            if end == place {
                runs.push(start..place + 1);
                start = place + 1;
            }
        }
        runs
    }
}

/// The velocities of a run of slots; `call` is compiled once for every instruction set and the best one runs.
struct Product<'a> {
    mobility: &'a Rpy,
    start: usize,
    rows: &'a mut [DVec3],
}

const LANES: usize = 8;

impl pulp::NullaryFnOnce for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Rpy {
            radius,
            positions,
            forces,
            ..
        } = self.mobility;
        for (k, velocity) in self.rows.iter_mut().enumerate() {
            let slot = self.start + k;
            let here = self.mobility.position(slot);
            let company = self.mobility.company(slot);
            let [x, y, z] = positions.each_ref().map(|column| &column[company.clone()]);
            let [fx, fy, fz] = forces.each_ref().map(|column| &column[company.clone()]);
            let mut sum = [[0.0; LANES]; 3];
            let mut from = 0;
            while from < company.len() {
                let to = (from + LANES).min(company.len());
                let lanes = |column: &[f64]| {
                    let mut lanes = [0.0; LANES];
                    lanes[..to - from].copy_from_slice(&column[from..to]);
                    lanes
                };
                let r = [lanes(x), lanes(y), lanes(z)];
                let f = [lanes(fx), lanes(fy), lanes(fz)];
                for l in 0..LANES {
                    let d = [here.x - r[0][l], here.y - r[1][l], here.z - r[2][l]];
                    let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                    let [iso, dyad, inverse] = pair(r2, *radius);
                    let along = dyad * inverse * (d[0] * f[0][l] + d[1] * f[1][l] + d[2] * f[2][l]);
                    for c in 0..3 {
                        sum[c][l] += iso * f[c][l] + along * d[c];
                    }
                }
                from = to;
            }
            *velocity = DVec3::from_array(sum.map(|lanes| lanes.iter().sum()));
        }
    }
}

/// A and B of two beads, M = A I + B rr / r^2, in units of the mobility of one alone; and 1 / r^2, which is finite where
/// beads coincide and B vanishes.
#[inline(always)]
pub(crate) fn pair(r2: f64, radius: f64) -> [f64; 3] {
    let inverse = r2.max(1e-300).sqrt().recip();
    let (x, y) = (radius * inverse, r2 * inverse / radius);
    let oseen = 0.75 * x;
    let far = [
        oseen * (1.0 + 2.0 / 3.0 * x * x),
        oseen * (1.0 - 2.0 * x * x),
    ];
    let near = [1.0 - 9.0 / 32.0 * y, 3.0 / 32.0 * y];
    let [iso, dyad] = if y < 2.0 { near } else { far };
    [iso, dyad, inverse * inverse]
}

/// A I + C rr, from A and C.
#[inline(always)]
pub(crate) fn block(r: DVec3, [iso, dyad]: [f64; 2]) -> DMat3 {
    let dyadic = DMat3::from_cols(r.x * r, r.y * r, r.z * r);
    DMat3::from_diagonal(DVec3::splat(iso)) + dyad * dyadic
}

/// Tells of the first of some vectors that is not finite.
pub(crate) fn finite(quantity: &'static str, vectors: &[DVec3]) -> Result<(), MobilityError> {
    // Distances are squared.
    match vectors.iter().position(|v| !v.length_squared().is_finite()) {
        None => Ok(()),
        Some(particle) => Err(MobilityError::NotFinite {
            quantity,
            particle,
            value: vectors[particle].to_array(),
        }),
    }
}

/// Vectors by columns.
pub(crate) fn split(vectors: &[DVec3], columns: &mut [Vec<f64>; 3]) {
    for (c, column) in columns.iter_mut().enumerate() {
        column.clear();
        column.extend(vectors.iter().map(|v| v[c]));
    }
}
