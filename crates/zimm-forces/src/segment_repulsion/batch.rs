//! Pairs of segments in batches.

use super::list::{Piece, Rod, Segment, SegmentList};
use super::{Approach, SegmentForce};
use crate::length;
use std::marker::PhantomData;
use zimm_core::{Boundary, DMat3, DVec3, Item, Neighbours, Row, Tally};

/// What pulls on a piece: forces, and forces times their places on the segment.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pull {
    pub(super) force: DVec3,
    pub(super) moment: DVec3,
}

/// What every block reads.
pub(super) struct View<'a, L> {
    law: &'a L,
    smallest: f64,
    cutoff_squared: f64,
    segments: &'a [Segment],
    /// In the source's order, as all that follows.
    positions: &'a [DVec3],
    rods: &'a [Rod],
    pieces: &'a [Piece],
    /// Whether some segment has more than one piece.
    cut: bool,
    basis: DMat3,
    inverse: DMat3,
    reach_squared: f64,
}

impl<'a, L: SegmentForce> View<'a, L> {
    pub(super) fn new<B: Boundary, N: Neighbours<B>>(
        law: &'a L,
        list: &'a SegmentList<N>,
        boundary: &B,
    ) -> Self {
        let basis = boundary.cell().unwrap_or(DMat3::IDENTITY);
        Self {
            law,
            smallest: law.smallest(),
            cutoff_squared: law.cutoff() * law.cutoff(),
            segments: &list.segments,
            positions: list.source.positions(),
            rods: &list.rods,
            pieces: &list.sorted,
            cut: list.pieces.len() > list.segments.len(),
            basis,
            inverse: basis.inverse(),
            reach_squared: boundary.reach() * boundary.reach(),
        }
    }

    /// Whether a separation that is a lattice vector up to rounding is zero.
    #[inline(always)]
    fn is_zero(&self, lattice_vector: DVec3) -> bool {
        lattice_vector.length_squared() < self.reach_squared
    }

    /// The image of a separation that `seen` is, up to rounding.
    #[inline(always)]
    fn image(&self, separation: DVec3, seen: DVec3) -> DVec3 {
        let shift = seen - separation;
        if self.is_zero(shift) {
            separation
        } else {
            separation + self.basis * (self.inverse * shift).round()
        }
    }

    /// Whether two pieces are of one segment, or of segments that share a bead where their places s and t are `apart`.
    #[inline(always)]
    fn joined(&self, [i, j]: [usize; 2], [s, t]: [f64; 2], apart: DVec3) -> bool {
        let (one, other) = (self.pieces[i], self.pieces[j]);
        let shared = |m: usize, n: usize| {
            let ends = (m as f64 - 0.5 - s) * self.rods[i].span;
            let other_ends = (n as f64 - 0.5 - t) * self.rods[j].span;
            one.beads[m] == other.beads[n] && self.is_zero(apart + ends - other_ends)
        };
        one.segment == other.segment || shared(0, 0) || shared(0, 1) || shared(1, 0) || shared(1, 1)
    }
}

const BATCH: usize = 512;
/// Candidates are looked at in runs of this many; a batch with less room is worked off first.
const RUN: usize = 64;

type Column = [f64; BATCH];
type Vectors = [Column; 3];

/// Pairs of pieces that may be in range of each other, by columns.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    len: usize,
    i: [u32; BATCH],
    j: [u32; BATCH],
    /// From the middle of the second segment to that of the first; then of the places of closest approach.
    apart: Vectors,
    first: Vectors,
    second: Vectors,
    s: Column,
    t: Column,
    squared: Column,
    /// The pairs in range.
    hits: [u32; BATCH],
    distance: Column,
    /// Over the distance.
    force: Column,
}

impl Default for Batch {
    fn default() -> Self {
        let (column, vectors, indices) = ([0.0; BATCH], [[0.0; BATCH]; 3], [0; BATCH]);
        Self {
            len: 0,
            i: indices,
            j: indices,
            apart: vectors,
            first: vectors,
            second: vectors,
            s: column,
            t: column,
            squared: column,
            hits: indices,
            distance: column,
            force: column,
        }
    }
}

#[inline(always)]
fn get(vectors: &Vectors, k: usize) -> DVec3 {
    DVec3::new(vectors[0][k], vectors[1][k], vectors[2][k])
}

#[inline(always)]
fn set(vectors: &mut Vectors, k: usize, v: DVec3) {
    (vectors[0][k], vectors[1][k], vectors[2][k]) = (v.x, v.y, v.z);
}

/// One block of rows; `call` is compiled once for every instruction set and the best one runs.
pub(super) struct BlockOfWork<'a, B, L, N, T> {
    pub(super) view: &'a View<'a, L>,
    pub(super) source: &'a N,
    pub(super) block: usize,
    pub(super) batch: &'a mut Batch,
    pub(super) pulls: &'a mut [Pull],
    pub(super) heard: &'a mut T,
    pub(super) boundary: PhantomData<B>,
}

impl<B: Boundary, L: SegmentForce, N: Neighbours<B>, T: Tally> pulp::NullaryFnOnce
    for BlockOfWork<'_, B, L, N, T>
{
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            view,
            source,
            block,
            batch,
            pulls,
            heard,
            ..
        } = self;
        batch.len = 0;
        source.visit(
            block,
            #[inline(always)]
            |row| {
                for js in row.js.chunks(RUN) {
                    if batch.len + RUN > BATCH {
                        batch.work_off(view, pulls, heard);
                    }
                    batch.take(view, &row, js);
                }
            },
        );
        batch.work_off(view, pulls, heard);
    }
}

impl Batch {
    /// Adds the candidates whose pieces may be in range. Every candidate is written; only those are kept.
    #[inline(always)]
    fn take<L: SegmentForce>(&mut self, view: &View<'_, L>, row: &Row<'_>, js: &[u32]) {
        let rod = view.rods[row.i as usize];
        let here = view.positions[row.i as usize] + row.shift;
        let start = self.len;
        let mut len = start;
        for &j in js {
            let apart = here - view.positions[j as usize];
            let most = rod.reach + view.rods[j as usize].reach;
            self.j[len] = j;
            set(&mut self.apart, len, apart);
            len += (apart.length_squared() <= most * most) as usize;
        }
        self.len = len;
        for k in start..len {
            self.i[k] = row.i;
            set(&mut self.first, k, rod.span);
            set(&mut self.second, k, view.rods[self.j[k] as usize].span);
        }
        if view.cut {
            for k in start..len {
                self.put_together(view, k);
            }
        }
    }

    /// Goes from pieces to their segments, if these are cut: with the same bits for all candidates of two segments, so
    /// that one of them owns the closest approach.
    #[inline(always)]
    fn put_together<L: SegmentForce>(&mut self, view: &View<'_, L>, k: usize) {
        let [i, j] = [self.i[k], self.j[k]];
        let [one, other] = [i, j].map(|piece| view.pieces[piece as usize]);
        if one.of == 1 && other.of == 1 {
            return;
        }
        let [first, second] = [one, other].map(|piece| &view.segments[piece.segment as usize]);
        let seen = get(&self.apart, k) - one.place() * first.span + other.place() * second.span;
        let middles = view.image(first.middle - second.middle, seen);
        if one.segment <= other.segment {
            set(&mut self.apart, k, middles);
        } else {
            set(&mut self.apart, k, -middles);
            (self.i[k], self.j[k]) = (j, i);
            set(&mut self.first, k, second.span);
            set(&mut self.second, k, first.span);
        }
    }

    /// Evaluates the pairs collected, adds their pulls and empties the batch.
    #[inline(always)]
    fn work_off<L: SegmentForce, T: Tally>(
        &mut self,
        view: &View<'_, L>,
        pulls: &mut [Pull],
        heard: &mut T,
    ) {
        let len = self.len.min(BATCH);
        let b = view.smallest;
        for k in 0..len {
            let (first, second) = (get(&self.first, k), get(&self.second, k));
            let Approach { s, t, apart } = Approach::between(get(&self.apart, k), first, second, b);
            (self.s[k], self.t[k]) = (s, t);
            set(&mut self.apart, k, apart);
            self.squared[k] = apart.length_squared() + b * b * (1.0 + s * s + t * t);
        }
        let mut hits = 0;
        for k in 0..len {
            self.hits[hits] = k as u32;
            hits += (self.squared[k] < view.cutoff_squared) as usize;
        }
        let mut counted = 0;
        for hit in 0..hits {
            let k = self.hits[hit] as usize;
            let pair = [self.i[k], self.j[k]].map(|piece| piece as usize);
            let places = [self.s[k], self.t[k]];
            let [one, other] = pair.map(|piece| view.pieces[piece]);
            let counts = one.holds(places[0])
                && other.holds(places[1])
                && !view.joined(pair, places, get(&self.apart, k));
            self.hits[counted] = k as u32;
            self.distance[counted] = length::distance(self.squared[k]);
            counted += counts as usize;
        }
        for hit in 0..counted {
            let distance = self.distance[hit];
            self.force[hit] = view.law.force(distance) / distance;
        }
        for hit in 0..counted {
            let k = self.hits[hit] as usize;
            let [i, j] = [self.i[k], self.j[k]].map(|piece| piece as usize);
            let (s, t, apart) = (self.s[k], self.t[k], get(&self.apart, k));
            let force = self.force[hit] * apart;
            pulls[i].force += force;
            pulls[i].moment += s * force;
            pulls[j].force -= force;
            pulls[j].moment -= t * force;
            let at = view.positions[i] + (s - view.pieces[i].place()) * view.rods[i].span;
            let energy = || view.law.energy(self.distance[hit]);
            heard.hear(Item::SpringRepulsion, at, apart, force, &energy);
        }
        self.len = 0;
    }
}
