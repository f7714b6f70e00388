//! All pairs of images within a cutoff, whatever the cell: also cutoffs beyond the size of the cell.

use crate::rpy::split;
use std::ops::Range;
use zimm_core::{DMat3, DVec3, IVec3, Lattice};

/// Beads sorted along cells that are cut in fractional coordinates. The last axis is cut finely: cells along it lie next
/// to each other in memory, so that candidates in one column of cells are one range.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cells {
    basis: DMat3,
    widths: DVec3,
    counts: IVec3,
    reach: IVec3,
    cutoff: f64,
    starts: Vec<u32>,
    /// The place of each bead, in the order of cells.
    pub(crate) order: Vec<u32>,
    cells: Vec<IVec3>,
    /// Positions in the primary cell, in the order of cells.
    positions: Vec<DVec3>,
    columns: [Vec<f64>; 3],
    located: Vec<(IVec3, DVec3)>,
    next: Vec<u32>,
}

impl Cells {
    pub(crate) fn sort(&mut self, lattice: &Lattice, positions: &[DVec3], cutoff: f64) {
        const CUT: DVec3 = DVec3::new(1.0, 1.0, 4.0);
        let most = (4 * positions.len() + 64) as f64;
        self.widths = lattice.widths();
        let mut counts = (self.widths / cutoff * CUT).floor().max(DVec3::ONE);
        let wanted = counts.element_product();
        if wanted > most {
            counts = (counts * libm::cbrt(most / wanted)).floor().max(DVec3::ONE);
        }
        self.basis = lattice.basis();
        self.cutoff = cutoff;
        self.counts = counts.as_ivec3();
        self.reach = (cutoff * counts / self.widths).ceil().as_ivec3();

        let locate = |r: DVec3| {
            let (folded, _) = lattice.fold(r);
            let cell = ((lattice.inverse() * folded + 0.5) * counts).floor();
            let cell = cell.clamp(DVec3::ZERO, counts - 1.0).as_ivec3();
            (cell, folded)
        };
        self.located.clear();
        self.located.extend(positions.iter().map(|&r| locate(r)));
        self.starts.clear();
        self.starts
            .resize(self.counts.element_product() as usize + 1, 0);
        for &(cell, _) in &self.located {
            let index = index(self.counts, cell) + 1;
            self.starts[index] += 1;
        }
        for c in 1..self.starts.len() {
            self.starts[c] += self.starts[c - 1];
        }
        self.next.clone_from(&self.starts);
        self.order.resize(positions.len(), 0);
        self.cells.resize(positions.len(), IVec3::ZERO);
        self.positions.resize(positions.len(), DVec3::ZERO);
        for (place, &(cell, folded)) in self.located.iter().enumerate() {
            let next = &mut self.next[index(self.counts, cell)];
            let k = *next as usize;
            *next += 1;
            self.order[k] = place as u32;
            self.cells[k] = cell;
            self.positions[k] = folded;
        }
        split(&self.positions, &mut self.columns);
    }

    fn index(&self, cell: IVec3) -> usize {
        index(self.counts, cell)
    }

    /// Appends the partners of one bead, each unordered pair of images once, a bead's own images among them.
    #[inline(always)]
    pub(crate) fn gather(&self, i: usize, pairs: &mut Pairs) {
        let own = self.cells[i];
        for da in 0..=self.reach.x {
            for db in if da == 0 { 0 } else { -self.reach.y }..=self.reach.y {
                let (a, image_a) = wrap(own.x + da, self.counts.x);
                let (b, image_b) = wrap(own.y + db, self.counts.y);
                let column = self.index(IVec3::new(a, b, 0));
                let half = da == 0 && db == 0;
                let highest = own.z + self.reach.z;
                let mut c = if half { own.z } else { own.z - self.reach.z };
                while c <= highest {
                    let (first, image_c) = wrap(c, self.counts.z);
                    let last = (first + highest - c).min(self.counts.z - 1);
                    let mut from = self.starts[column + first as usize] as usize;
                    let to = self.starts[column + last as usize + 1] as usize;
                    if half && c == own.z {
                        from = i + 1;
                    }
                    let image = DVec3::new(image_a, image_b, image_c);
                    let here = self.positions[i] - self.basis * image;
                    self.within(here, from..to, pairs);
                    c += last - first + 1;
                }
            }
        }
    }

    /// Appends the candidates in range. Every one is written; only those in range are kept.
    #[inline(always)]
    fn within(&self, here: DVec3, candidates: Range<usize>, pairs: &mut Pairs) {
        let limit = self.cutoff * self.cutoff;
        let [x, y, z] = &self.columns;
        let start = pairs.start;
        let mut from = candidates.start;
        while from < candidates.end {
            let to = candidates.end.min(from + RUN);
            let (x, y, z) = (&x[from..to], &y[from..to], &z[from..to]);
            let mut squares = [0.0; RUN];
            for (((square, x), y), z) in squares.iter_mut().zip(x).zip(y).zip(z) {
                let (dx, dy, dz) = (here.x - x, here.y - y, here.z - z);
                *square = dx * dx + dy * dy + dz * dz;
            }
            pairs.make_room(RUN);
            let len = pairs.len;
            let partners = &mut pairs.partners[len..len + RUN];
            let apart = &mut pairs.apart[len..len + RUN];
            let mut kept = 0;
            for (l, square) in squares[..to - from].iter().enumerate() {
                partners[kept % RUN] = l as u32;
                kept += usize::from(*square < limit);
            }
            for (partner, apart) in partners.iter_mut().zip(apart).take(kept) {
                let l = *partner as usize;
                *apart = [here.x - x[l], here.y - y[l], here.z - z[l], 0.0];
                let j = from + l;
                let behind = if j < start { self.order.len() } else { 0 };
                *partner = (j + behind - start) as u32;
            }
            pairs.len = len + kept;
            from = to;
        }
    }

    /// The beads that the partners of a range are among, and the range itself: the first, and how many from there on,
    /// round the end of the column.
    pub(crate) fn company(&self, beads: &Range<usize>) -> [usize; 2] {
        let (Some(first), Some(last)) = (
            self.cells.get(beads.start),
            self.cells[beads.clone()].last(),
        ) else {
            return [0; 2];
        };
        let plane = |x: i32| self.starts[self.index(IVec3::new(x, 0, 0))] as usize;
        let (start, beyond) = (plane(first.x), last.x + self.reach.x + 1);
        if beyond - first.x >= self.counts.x {
            return [start, self.order.len()];
        }
        let (beyond, image) = wrap(beyond, self.counts.x);
        [
            start,
            plane(beyond) + image as usize * self.order.len() - start,
        ]
    }

    /// Calls `each` with every image of a separation within the cutoff, that of zero length too.
    pub(crate) fn images(&self, lattice: &Lattice, r: DVec3, mut each: impl FnMut(DVec3)) {
        let (near, _) = lattice.fold(r);
        let most = (self.cutoff / self.widths + 0.5).floor().as_ivec3();
        for a in -most.x..=most.x {
            for b in -most.y..=most.y {
                for c in -most.z..=most.z {
                    let image = near + self.basis * IVec3::new(a, b, c).as_dvec3();
                    if image.length_squared() < self.cutoff * self.cutoff {
                        each(image);
                    }
                }
            }
        }
    }
}

/// Candidates are looked at in runs of this many.
const RUN: usize = 32;

/// Pairs of the beads of a range, one bead after another.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pairs {
    start: usize,
    /// Where each bead's run ends.
    pub(crate) ends: Vec<u32>,
    len: usize,
    /// Numbers of partners, counted from a bead on and round the end of the column.
    partners: Vec<u32>,
    /// Separations r_i - r_j, and room for one number.
    apart: Vec<[f64; 4]>,
}

impl Pairs {
    /// Finds the pairs of a range; partners are counted from `start` on.
    #[inline(always)]
    pub(crate) fn fill(&mut self, cells: &Cells, start: usize, beads: Range<usize>) {
        self.start = start;
        self.ends.clear();
        self.len = 0;
        for i in beads {
            cells.gather(i, self);
            self.ends.push(self.len as u32);
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    pub(crate) fn partners(&self) -> &[u32] {
        &self.partners[..self.len]
    }

    pub(crate) fn apart(&self) -> &[[f64; 4]] {
        &self.apart[..self.len]
    }

    pub(crate) fn apart_mut(&mut self) -> &mut [[f64; 4]] {
        &mut self.apart[..self.len]
    }

    #[inline(always)]
    fn make_room(&mut self, more: usize) {
        if self.partners.len() < self.len + more {
            let len = 2 * self.len + more;
            self.partners.resize(len, 0);
            self.apart.resize(len, [0.0; 4]);
        }
    }
}

fn index(counts: IVec3, cell: IVec3) -> usize {
    ((cell.x * counts.y + cell.y) * counts.z + cell.z) as usize
}

fn wrap(cell: i32, count: i32) -> (i32, f64) {
    (cell.rem_euclid(count), f64::from(cell.div_euclid(count)))
}
