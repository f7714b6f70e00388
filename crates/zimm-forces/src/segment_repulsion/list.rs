//! Pairs of segments that may be near each other.

use zimm_core::{Boundary, DMat3, DVec3, ForceError, Frame, Neighbours};

/// A bond as it lies now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// Places of its beads in the frame.
    pub(super) beads: [usize; 2],
    pub(super) middle: DVec3,
    /// From the first bead to the nearest image of the second.
    pub(super) span: DVec3,
    length: f64,
}

/// A piece of a segment; a point, its middle, stands for it in the source of pairs.
#[derive(Clone, Copy, Debug)]
struct Piece {
    segment: u32,
    number: u32,
    /// Where its middle lies on the segment, from -1/2 to 1/2.
    place: f64,
    half_length: f64,
}

/// Two pieces that may be in range.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pieces: [u32; 2],
}

/// Two segments in the images in which two of their pieces are nearest to each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting<'a> {
    pub(super) segments: [&'a Segment; 2],
    /// From the middle of the second to that of the first: the same bits for all candidates of the pair.
    pub(super) middles: DVec3,
}

/// The space that segments meet in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Space<'a, B> {
    boundary: &'a B,
    basis: DMat3,
    inverse: DMat3,
    reach_squared: f64,
}

impl<'a, B: Boundary> Space<'a, B> {
    pub(super) fn new(boundary: &'a B) -> Self {
        let basis = boundary.cell().unwrap_or(DMat3::IDENTITY);
        Self {
            boundary,
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
}

/// All pairs of segments, in all images, that come closer than a range, each found once, from any source of pairs of
/// points.
///
/// Segments are cut into pieces no longer than `longest`, and pieces whose middles are closer than range + `longest`
/// are candidates. No pair can be missed: the two places of closest approach lie on pieces whose middles are each
/// within half a piece of them. Since one long segment has many pieces instead of making all others look as far as it
/// reaches, and pieces are about as long as the mean segment, cost is linear in the number of segments whatever their
/// lengths. Of the candidates that a pair of segments has, it counts where its closest approach lies.
///
/// Cuts stay as they are while no piece gets too long, so that the source need not start anew at every step.
#[derive(Clone, Debug)]
pub(super) struct SegmentList<N> {
    source: N,
    segments: Vec<Segment>,
    /// Number of pieces of each segment.
    cuts: Vec<u32>,
    pieces: Vec<Piece>,
    points: Vec<DVec3>,
    longest: f64,
    /// Mean length of the segments when they were cut.
    mean: f64,
    candidates: Vec<Candidate>,
    /// Whether the candidates are of former cuts.
    stale: bool,
}

/// Longest piece, in mean lengths of segments.
const SHARE: f64 = 0.8;
/// Longest piece when the cuts are made, in longest pieces allowed.
const FRESH: f64 = 0.85;

impl<N> SegmentList<N> {
    pub(super) fn new(source: N) -> Self {
        Self {
            source,
            segments: Vec::new(),
            cuts: Vec::new(),
            pieces: Vec::new(),
            points: Vec::new(),
            longest: 0.0,
            mean: 0.0,
            candidates: Vec::new(),
            stale: true,
        }
    }

    pub(super) fn source(&self) -> &N {
        &self.source
    }

    pub(super) fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// Brings segments and candidates to now.
    pub(super) fn refresh<B: Boundary>(
        &mut self,
        frame: &Frame<'_, B>,
        bonds: &[[u32; 2]],
        range: f64,
    ) -> Result<(), ForceError>
    where
        N: Neighbours<B>,
    {
        self.lay(frame, bonds)?;
        let room = frame.boundary.reach() - range;
        if !self.cuts_serve(room) {
            self.cut(range, room);
            self.source.forget();
            self.stale = true;
        }
        self.points.clear();
        for piece in &mut self.pieces {
            let number = piece.segment as usize;
            let segment = &self.segments[number];
            piece.half_length = 0.5 * segment.length / f64::from(self.cuts[number]);
            let point = segment.middle + piece.place * segment.span;
            self.points.push(frame.boundary.wrap(point).0);
        }
        let mut points = *frame;
        points.positions = &self.points;
        (points.velocities, points.masses, points.species) = (&[], &[], &[]);
        (points.images, points.ids) = (&[], &[]);
        if self.source.refresh(&points, range + self.longest)? || self.stale {
            self.gather::<B>();
            self.stale = false;
        }
        Ok(())
    }

    pub(super) fn forget<B: Boundary>(&mut self)
    where
        N: Neighbours<B>,
    {
        self.cuts.clear();
        self.source.forget();
    }

    /// Finds where the segments lie.
    fn lay<B: Boundary>(
        &mut self,
        frame: &Frame<'_, B>,
        bonds: &[[u32; 2]],
    ) -> Result<(), ForceError> {
        let (particles, reach) = (frame.len(), frame.boundary.reach());
        self.segments.clear();
        for (bond, &[i, j]) in bonds.iter().enumerate() {
            let missing = |identity| ForceError::NoSuchParticle {
                bond,
                identity,
                particles,
            };
            let first = frame.place(i).ok_or_else(|| missing(i))?;
            let second = frame.place(j).ok_or_else(|| missing(j))?;
            let here = frame.positions[first];
            let span = frame.boundary.min_image(frame.positions[second] - here);
            let length = span.length();
            let resolved = length < reach;
            if !resolved {
                return Err(ForceError::BeyondCell {
                    bond,
                    i,
                    j,
                    length,
                    reach,
                });
            }
            self.segments.push(Segment {
                beads: [first, second],
                middle: here + 0.5 * span,
                span,
                length,
            });
        }
        Ok(())
    }

    fn mean_length(&self) -> f64 {
        let lengths = self.segments.iter().map(|segment| segment.length);
        lengths.sum::<f64>() / self.segments.len().max(1) as f64
    }

    /// Whether no piece is too long, for the cell or for the range of candidates, and their number is still a multiple
    /// of that of segments.
    fn cuts_serve(&self, room: f64) -> bool {
        let short =
            |(segment, &cuts): (&Segment, &u32)| segment.length <= f64::from(cuts) * self.longest;
        let mean = self.mean_length();
        self.cuts.len() == self.segments.len()
            && self.longest <= room
            && (0.5 * self.mean..=2.0 * self.mean).contains(&mean)
            && self.segments.iter().zip(&self.cuts).all(short)
    }

    /// Cuts segments. If the cell has no room for half a range, pieces are that long all the same, and the source
    /// answers with an error.
    fn cut(&mut self, range: f64, room: f64) {
        self.mean = self.mean_length();
        self.longest = (SHARE * self.mean).max(range).min(room).max(0.5 * range);
        self.cuts.clear();
        self.pieces.clear();
        for (number, segment) in (0..).zip(&self.segments) {
            let cuts = (segment.length / (FRESH * self.longest)).ceil().max(1.0) as u32;
            self.cuts.push(cuts);
            self.pieces.extend((0..cuts).map(|k| Piece {
                segment: number,
                number: k,
                place: (f64::from(k) + 0.5) / f64::from(cuts) - 0.5,
                half_length: 0.0,
            }));
        }
    }

    /// Whether a place on a segment lies on this piece of it: true for one piece only.
    #[inline(always)]
    fn holds(&self, piece: &Piece, place: f64) -> bool {
        let cuts = self.cuts[piece.segment as usize];
        let number = ((place + 0.5) * f64::from(cuts)) as u32;
        number.min(cuts - 1) == piece.number
    }

    fn gather<B: Boundary>(&mut self)
    where
        N: Neighbours<B>,
    {
        self.candidates.clear();
        let (order, pieces) = (self.source.order(), &self.pieces);
        let candidates = &mut self.candidates;
        for block in 0..self.source.blocks() {
            self.source.visit(block, |row| {
                let first = order[row.i as usize];
                let segment = pieces[first as usize].segment;
                for &j in row.js {
                    let second = order[j as usize];
                    if pieces[second as usize].segment != segment {
                        let pieces = [first, second];
                        candidates.push(Candidate { pieces });
                    }
                }
            });
        }
    }

    /// The segments of a candidate, if its pieces may be in range and the segments do not share a bead.
    #[inline(always)]
    pub(super) fn meeting<B: Boundary>(
        &self,
        candidate: Candidate,
        space: &Space<'_, B>,
        range: f64,
    ) -> Option<Meeting<'_>> {
        let [a, b] = candidate.pieces.map(|point| self.points[point as usize]);
        let seen = space.boundary.min_image(a - b);
        let [one, other] = candidate.pieces.map(|point| &self.pieces[point as usize]);
        let most = range + (one.half_length + other.half_length) * (1.0 + 1e-9);
        if seen.length_squared() > most * most {
            return None;
        }
        let [first, second] = [one, other].map(|piece| &self.segments[piece.segment as usize]);
        let middles = space.image(
            first.middle - second.middle,
            seen - one.place * first.span + other.place * second.span,
        );
        for (m, bead) in [-0.5, 0.5].into_iter().zip(first.beads) {
            for (n, other) in [-0.5, 0.5].into_iter().zip(second.beads) {
                if bead == other && space.is_zero(middles + m * first.span - n * second.span) {
                    return None;
                }
            }
        }
        Some(Meeting {
            segments: [first, second],
            middles,
        })
    }

    /// Whether two places of closest approach lie on the pieces of this candidate: true for one candidate of the pair.
    #[inline(always)]
    pub(super) fn owns(&self, candidate: Candidate, places: [f64; 2]) -> bool {
        let [first, second] = candidate.pieces.map(|point| &self.pieces[point as usize]);
        self.holds(first, places[0]) && self.holds(second, places[1])
    }
}
