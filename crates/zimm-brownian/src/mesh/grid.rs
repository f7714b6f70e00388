//! Beads on a mesh: spreading and gathering.

use super::window::Window;
use crate::pieces::each_piece;
use zimm_core::{DVec3, Lattice};

/// Planes of the mesh that one task spreads to.
const SLAB: usize = 8;
/// Beads that one task gathers for.
const GATHERED: usize = 512;

/// Where a bead lies on the mesh.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bead {
    /// The first mesh point under its window.
    first: [u32; 3],
    /// How far that is behind the edge of the window.
    behind: [f64; 3],
}

/// Three components on a mesh in rows along the last basis vector: plane, row, component, point. Rows are longer than
/// the mesh, so that a window that crosses the end of the cell is written in one go.
#[derive(Clone, Debug, Default)]
pub(super) struct Grid {
    pub(super) points: [usize; 3],
    /// Length of a row.
    pub(super) row: usize,
    pub(super) values: Vec<f64>,
    /// Places of beads in the order in which they lie on the mesh.
    order: Vec<u32>,
    beads: Vec<Bead>,
    /// Where the beads of every first plane begin, and those of every row.
    starts: Vec<u32>,
    rows: Vec<u32>,
    unsorted: Vec<Bead>,
    /// Forces or sums in that order.
    column: Vec<DVec3>,
    arch: pulp::Arch,
}

impl Grid {
    /// Lays beads onto the mesh and sorts them along it.
    pub(super) fn bind(
        &mut self,
        points: [usize; 3],
        lattice: &Lattice,
        window: &Window,
        positions: &[DVec3],
    ) {
        self.points = points;
        self.row = points[2] + lanes(window);
        let [n1, n2, _] = points;
        self.values.resize(n1 * n2 * 3 * self.row, 0.0);
        let place = |r: &DVec3| {
            let mut bead = Bead::default();
            let fractions = lattice.inverse() * *r;
            for d in 0..3 {
                let fraction = fractions[d] - fractions[d].floor();
                let (first, behind) = window.place(points[d] as f64 * fraction);
                bead.first[d] = first.rem_euclid(points[d] as i64) as u32;
                bead.behind[d] = behind;
            }
            bead
        };
        let Self {
            order,
            beads,
            starts,
            rows,
            unsorted,
            ..
        } = self;
        unsorted.clear();
        unsorted.extend(positions.iter().map(place));
        let key = |bead: &Bead| bead.first[0] as usize * n2 + bead.first[1] as usize;
        rows.clear();
        rows.resize(n1 * n2 + 1, 0);
        for bead in &*unsorted {
            rows[key(bead) + 1] += 1;
        }
        for k in 1..rows.len() {
            rows[k] += rows[k - 1];
        }
        starts.clear();
        starts.extend(rows.iter().step_by(n2));
        order.resize(unsorted.len(), 0);
        beads.resize(unsorted.len(), Bead::default());
        for (place, bead) in unsorted.iter().enumerate() {
            let start = &mut rows[key(bead)];
            order[*start as usize] = place as u32;
            beads[*start as usize] = *bead;
            *start += 1;
        }
    }

    /// Length of a plane.
    pub(super) fn plane(&self) -> usize {
        self.points[1] * 3 * self.row
    }

    /// Makes the mesh the sum of the windows of all beads times their forces.
    pub(super) fn spread(&mut self, window: &Window, forces: &[DVec3]) {
        let mut sorted = std::mem::take(&mut self.column);
        sorted.clear();
        sorted.extend(self.order.iter().map(|&place| forces[place as usize]));
        if lanes(window) == 8 {
            self.spread_lanes::<8>(window, &sorted);
        } else {
            self.spread_lanes::<16>(window, &sorted);
        }
        self.column = sorted;
    }

    fn spread_lanes<const L: usize>(&mut self, window: &Window, forces: &[DVec3]) {
        let arch = self.arch;
        let mut values = std::mem::take(&mut self.values);
        let mut slabs = vec![(); self.points[0].div_ceil(SLAB)];
        each_piece(
            &mut values,
            SLAB * self.plane(),
            &mut slabs,
            |k, slab, ()| {
                arch.dispatch(Spread::<L> {
                    grid: self,
                    window,
                    forces,
                    first: k * SLAB,
                    slab,
                });
            },
        );
        self.values = values;
    }

    /// Adds the sums of the mesh under the windows of all beads, times a factor.
    pub(super) fn gather(&mut self, window: &Window, factor: f64, velocities: &mut [DVec3]) {
        let mut sums = std::mem::take(&mut self.column);
        sums.resize(self.order.len(), DVec3::ZERO);
        if lanes(window) == 8 {
            self.gather_lanes::<8>(window, &mut sums);
        } else {
            self.gather_lanes::<16>(window, &mut sums);
        }
        for (&place, sum) in self.order.iter().zip(&sums) {
            velocities[place as usize] += factor * *sum;
        }
        self.column = sums;
    }

    fn gather_lanes<const L: usize>(&self, window: &Window, velocities: &mut [DVec3]) {
        let arch = self.arch;
        let mut chunks = vec![(); velocities.len().div_ceil(GATHERED)];
        each_piece(velocities, GATHERED, &mut chunks, |k, velocities, ()| {
            arch.dispatch(Gather::<L> {
                grid: self,
                window,
                first: k * GATHERED,
                velocities,
            });
        });
    }
}

/// Lanes that hold the points of a window.
fn lanes(window: &Window) -> usize {
    if window.points() <= 8 { 8 } else { 16 }
}

/// Spreads to one slab of planes; `call` is compiled once for every instruction set and the best one runs. Every mesh
/// point sums its beads in the mesh's order.
struct Spread<'a, const L: usize> {
    grid: &'a Grid,
    window: &'a Window,
    forces: &'a [DVec3],
    first: usize,
    slab: &'a mut [f64],
}

impl<const L: usize> pulp::NullaryFnOnce for Spread<'_, L> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            grid,
            window,
            forces,
            first,
            slab,
        } = self;
        slab.fill(0.0);
        let [n1, n2, _] = grid.points;
        let (row, wide) = (grid.row, window.points());
        let planes = slab.len() / grid.plane();
        for ahead in 0..n1.min(planes + wide - 1) {
            let plane = (first + n1 + ahead + 1 - wide) % n1;
            let run = grid.starts[plane] as usize..grid.starts[plane + 1] as usize;
            for (bead, force) in grid.beads[run.clone()].iter().zip(&forces[run]) {
                let force = force.to_array();
                let [x, y, z] = window.each_weights::<L>(bead.behind);
                for under in 0..planes {
                    let step = (first + under + n1 - plane) % n1;
                    if step >= wide {
                        continue;
                    }
                    for (m, y) in y[..wide].iter().enumerate() {
                        let along = bead.first[1] as usize + m;
                        let along = if along >= n2 { along - n2 } else { along };
                        let weight = x[step] * y;
                        let from = (under * n2 + along) * 3 * row + bead.first[2] as usize;
                        for (c, force) in force.iter().enumerate() {
                            let here = &mut slab[from + c * row..];
                            if let Some(here) = here.first_chunk_mut::<L>() {
                                let height = weight * force;
                                for (here, z) in here.iter_mut().zip(&z) {
                                    *here += height * z;
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Gathers for some beads; compiled as [`Spread`] is.
struct Gather<'a, const L: usize> {
    grid: &'a Grid,
    window: &'a Window,
    first: usize,
    velocities: &'a mut [DVec3],
}

impl<const L: usize> pulp::NullaryFnOnce for Gather<'_, L> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            grid,
            window,
            first,
            velocities,
        } = self;
        let [n1, n2, _] = grid.points;
        let (row, wide) = (grid.row, window.points());
        for (k, velocity) in velocities.iter_mut().enumerate() {
            let bead = grid.beads[first + k];
            let [x, y, z] = window.each_weights::<L>(bead.behind);
            let mut sums = [[0.0; L]; 3];
            for (l, x) in x[..wide].iter().enumerate() {
                let plane = bead.first[0] as usize + l;
                let plane = if plane >= n1 { plane - n1 } else { plane };
                for (m, y) in y[..wide].iter().enumerate() {
                    let along = bead.first[1] as usize + m;
                    let along = if along >= n2 { along - n2 } else { along };
                    let weight = x * y;
                    let from = (plane * n2 + along) * 3 * row + bead.first[2] as usize;
                    for (c, sum) in sums.iter_mut().enumerate() {
                        let here = &grid.values[from + c * row..];
                        if let Some(here) = here.first_chunk::<L>() {
                            for (sum, here) in sum.iter_mut().zip(here) {
                                *sum += weight * here;
                            }
                        }
                    }
                }
            }
            let total = |sum: [f64; L]| -> f64 { sum.iter().zip(&z).map(|(s, z)| s * z).sum() };
            *velocity = DVec3::from_array(sums.map(total));
        }
    }
}
