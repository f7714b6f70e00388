//! Where pairs come from.

use crate::{Boundary, Frame, ListError};
use glam::DVec3;

/// Candidates around one particle that share one lattice vector: the separation of `i` and `j` is
/// `positions[i] + shift - positions[j]`.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// Index of the first particle, in the source's order.
    pub i: u32,
    /// Lattice vector to be added to the first particle's position.
    pub shift: DVec3,
    /// Indices of the others, in the source's order.
    pub js: &'a [u32],
}

/// A source of candidate pairs. Every pair within the cutoff is among them, each once.
///
/// A source keeps the particles in an order of its own, chosen for locality, and positions in whatever images suit
/// it; drivers work in that order and give the result back by [`order`](Self::order).
pub trait Neighbours<B: Boundary>: Sync {
    /// Makes the source valid for this frame; answers whether the order or the rows have changed.
    ///
    /// # Errors
    /// If pairs within `cutoff` cannot be told from their images, or a position is not finite.
    fn refresh(&mut self, frame: &Frame<'_, B>, cutoff: f64) -> Result<bool, ListError>;

    /// The place in the frame of each particle, in the source's order.
    fn order(&self) -> &[u32];

    /// Positions now, in the source's order, in the images that the rows' shifts are for.
    fn positions(&self) -> &[DVec3];

    /// Number of blocks of work; a function of the problem, never of the machine.
    fn blocks(&self) -> usize;

    /// Calls `each` for every row of one block, always in the same order. Mark it `#[inline(always)]`: the driver's loop is
    /// compiled for the widest lanes, and what it calls is not.
    fn visit(&self, block: usize, each: impl FnMut(Row<'_>));

    /// Forgets the past: the next refresh starts anew.
    fn forget(&mut self) {}
}

/// Nobody has neighbours: the null source.
impl<B: Boundary> Neighbours<B> for () {
    fn refresh(&mut self, _: &Frame<'_, B>, _: f64) -> Result<bool, ListError> {
        Ok(false)
    }

    fn order(&self) -> &[u32] {
        &[]
    }

    fn positions(&self) -> &[DVec3] {
        &[]
    }

    fn blocks(&self) -> usize {
        0
    }

    fn visit(&self, _: usize, _: impl FnMut(Row<'_>)) {}
}

/// Every pair, looked at anew each time: for few particles, for open space, and as the reference for other sources.
#[derive(Clone, Debug, Default)]
pub struct AllPairs {
    order: Vec<u32>,
    positions: Vec<DVec3>,
    pairs: Vec<(u32, u32, DVec3)>,
}

impl<B: Boundary> Neighbours<B> for AllPairs {
    fn refresh(&mut self, frame: &Frame<'_, B>, cutoff: f64) -> Result<bool, ListError> {
        cutoff_fits(frame.boundary, cutoff)?;
        if let Some(particle) = frame.positions.iter().position(|r| !r.is_finite()) {
            return Err(not_finite(particle, frame.positions[particle]));
        }
        self.order = (0..frame.len() as u32).collect();
        self.positions = frame.positions.to_vec();
        self.pairs.clear();
        for i in 0..frame.len() {
            for j in i + 1..frame.len() {
                let apart = frame.positions[i] - frame.positions[j];
                let nearest = frame.boundary.min_image(apart);
                if nearest.length_squared() < cutoff * cutoff {
                    self.pairs.push((i as u32, j as u32, nearest - apart));
                }
            }
        }
        Ok(true)
    }

    fn order(&self) -> &[u32] {
        &self.order
    }

    fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    fn blocks(&self) -> usize {
        1
    }

    #[inline(always)]
    fn visit(&self, _: usize, mut each: impl FnMut(Row<'_>)) {
        for (i, j, shift) in &self.pairs {
            each(Row {
                i: *i,
                shift: *shift,
                js: std::slice::from_ref(j),
            });
        }
    }
}

pub(crate) fn cutoff_fits<B: Boundary>(boundary: &B, cutoff: f64) -> Result<(), ListError> {
    let most = boundary.reach();
    if (0.0..=most).contains(&cutoff) {
        Ok(())
    } else {
        Err(ListError::Cutoff {
            cutoff,
            images: 2.0 * most,
            most,
        })
    }
}

pub(crate) fn not_finite(particle: usize, position: DVec3) -> ListError {
    ListError::NotFinite {
        particle,
        position: position.to_array(),
    }
}
