//! Pairs of segments that may be near each other.

use zimm_core::{Boundary, DVec3, ForceError, Frame, Neighbours, for_each_chunk};

/// A bond as it lies now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// Places of its beads in the frame.
    pub(super) beads: [u32; 2],
    pub(super) middle: DVec3,
    /// From the first bead to the nearest image of the second.
    pub(super) span: DVec3,
    length: f64,
}

/// A piece of a segment; a point, its middle, stands for it in the source of pairs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) segment: u32,
    /// Identities of the segment's beads.
    pub(super) beads: [u32; 2],
    number: u32,
    /// Number of pieces of the segment.
    pub(super) of: u32,
}

impl Piece {
    /// Where its middle lies on the segment, from -1/2 to 1/2.
    #[inline(always)]
    pub(super) fn place(&self) -> f64 {
        (f64::from(self.number) + 0.5) / f64::from(self.of) - 0.5
    }

    /// Whether a place on the segment lies on this piece of it: true for one piece only.
    #[inline(always)]
    pub(super) fn holds(&self, place: f64) -> bool {
        let number = ((place + 0.5) * f64::from(self.of)) as u32;
        self.of == 1 || number.min(self.of - 1) == self.number
    }
}

/// What is near a piece.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rod {
    /// Of the segment.
    pub(super) span: DVec3,
    /// Pieces further apart than the sum of these are out of range.
    pub(super) reach: f64,
}

/// All pairs of segments, in all images, that come closer than a range, each found once, from any source of pairs of
/// points.
///
/// Segments are cut into pieces no longer than `longest`, and pieces whose middles are closer than range + `longest`
/// are candidates. No pair can be missed: the two places of closest approach lie on pieces whose middles are each
/// within half a piece of them. Since one long segment has many pieces instead of making all others look as far as it
/// reaches, cost is linear in the number of segments whatever their lengths. Of the candidates that a pair of segments
/// has, it counts where its closest approach lies.
///
/// Cuts stay as they are while no piece gets too long, so that the source need not start anew at every step.
#[derive(Clone, Debug)]
pub(super) struct SegmentList<N> {
    pub(super) source: N,
    pub(super) segments: Vec<Segment>,
    pub(super) pieces: Vec<Piece>,
    points: Vec<DVec3>,
    longest: f64,
    /// Mean length of the segments when they were cut.
    mean: f64,
    /// Pieces in the source's order.
    pub(super) sorted: Vec<Piece>,
    /// In the source's order.
    pub(super) rods: Vec<Rod>,
}

/// Longest piece at least, in mean lengths of segments: the number of pieces is a small multiple of that of segments.
const SHARE: f64 = 0.7;
/// Longest piece when the cuts are made, in longest pieces allowed.
const FRESH: f64 = 0.85;

impl<N> SegmentList<N> {
    pub(super) fn new(source: N) -> Self {
        Self {
            source,
            segments: Vec::new(),
            pieces: Vec::new(),
            points: Vec::new(),
            longest: 0.0,
            mean: 0.0,
            sorted: Vec::new(),
            rods: Vec::new(),
        }
    }

    /// Brings segments and candidates to now; answers whether the source's order or rows have changed.
    pub(super) fn refresh<B: Boundary>(
        &mut self,
        frame: &Frame<'_, B>,
        bonds: &[[u32; 2]],
        range: f64,
    ) -> Result<bool, ForceError>
    where
        N: Neighbours<B>,
    {
        self.lay(frame, bonds)?;
        let room = frame.boundary.reach() - range;
        if !self.cuts_serve(room) {
            self.cut(bonds, range, room);
            self.source.forget();
        }
        let (segments, pieces) = (&self.segments, &self.pieces);
        self.points.resize(pieces.len(), DVec3::ZERO);
        for_each_chunk(&mut self.points, |start, chunk| {
            for (point, piece) in chunk.iter_mut().zip(&pieces[start..]) {
                let segment = &segments[piece.segment as usize];
                let here = segment.middle + piece.place() * segment.span;
                *point = frame.boundary.wrap(here).0;
            }
        });
        let mut points = *frame;
        points.positions = &self.points;
        (points.velocities, points.masses, points.species) = (&[], &[], &[]);
        (points.images, points.ids) = (&[], &[]);
        let changed = self.source.refresh(&points, range + self.longest)?;
        if changed {
            let order = self.source.order().iter();
            self.sorted.clear();
            self.sorted
                .extend(order.map(|&point| pieces[point as usize]));
            self.rods.resize(self.sorted.len(), Rod::default());
        }
        let sorted = &self.sorted;
        for_each_chunk(&mut self.rods, |start, chunk| {
            for (rod, piece) in chunk.iter_mut().zip(&sorted[start..]) {
                let Segment { span, length, .. } = segments[piece.segment as usize];
                let reach = 0.5 * (range + length / f64::from(piece.of) * (1.0 + 1e-9));
                *rod = Rod { span, reach };
            }
        });
        Ok(changed)
    }

    pub(super) fn forget<B: Boundary>(&mut self)
    where
        N: Neighbours<B>,
    {
        self.pieces.clear();
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
                beads: [first as u32, second as u32],
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
        let short = |piece: &Piece| {
            self.segments[piece.segment as usize].length <= f64::from(piece.of) * self.longest
        };
        let mean = self.mean_length();
        !self.pieces.is_empty()
            && self.longest <= room
            && (0.5 * self.mean..=2.0 * self.mean).contains(&mean)
            && self.pieces.iter().all(short)
    }

    /// Cuts segments. If the cell has no room for half a range, pieces are that long all the same, and the source
    /// answers with an error.
    fn cut(&mut self, bonds: &[[u32; 2]], range: f64, room: f64) {
        self.mean = self.mean_length();
        let least = SHARE * self.mean;
        let mut lengths: Vec<f64> = self.segments.iter().map(|segment| segment.length).collect();
        lengths.sort_unstable_by(|one, other| other.total_cmp(one));
        let cuts = |length: f64, longest: f64| (length / (FRESH * longest)).ceil().max(1.0);
        // Candidates go with the square of the number of pieces and the cube of how far they look.
        let candidates = |longest: f64| {
            let number: f64 = lengths.iter().map(|&length| cuts(length, longest)).sum();
            number * number * (range + longest).powi(3)
        };
        let choices = lengths.iter().step_by(lengths.len().div_ceil(16).max(1));
        // Lengths that differ by rounding shall not be cut for that.
        let choices = choices.map(|&length| (1.001 * length / FRESH).max(least));
        self.longest = choices
            .map(|longest| (longest, candidates(longest)))
            .min_by(|one, other| one.1.total_cmp(&other.1))
            .map_or(0.0, |(longest, _)| longest)
            .min(room)
            .max(0.5 * range);
        self.pieces.clear();
        for ((number, segment), &beads) in (0..).zip(&self.segments).zip(bonds) {
            let of = cuts(segment.length, self.longest) as u32;
            self.pieces.extend((0..of).map(|k| Piece {
                segment: number,
                beads,
                number: k,
                of,
            }));
        }
    }
}
