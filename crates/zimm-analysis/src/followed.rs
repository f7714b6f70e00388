//! Displacements relative to the flow, summed from one moment to the next.

use crate::AnalysisError;
use zimm_core::{Boundary, DVec3, Frame};

/// Where things were and how far they have come.
#[derive(Clone, Debug, Default)]
pub(crate) struct Followed {
    last: Option<Last>,
}

#[derive(Clone, Debug)]
struct Last {
    time: f64,
    positions: Vec<DVec3>,
    displacements: Vec<DVec3>,
}

impl Followed {
    /// The displacements up to these positions, any image of them, at the moment of the frame.
    pub(crate) fn to<B: Boundary>(
        &mut self,
        frame: &Frame<'_, B>,
        positions: Vec<DVec3>,
    ) -> Result<Vec<DVec3>, AnalysisError> {
        let mut displacements = vec![DVec3::ZERO; positions.len()];
        if let Some(last) = &self.last {
            if last.positions.len() != positions.len() {
                return Err(AnalysisError::Length {
                    sample: 1,
                    found: positions.len(),
                    expected: last.positions.len(),
                });
            }
            let carry = frame.boundary.carry(last.time, frame.now.time);
            let most = 0.5 * frame.boundary.reach();
            for (particle, (&now, &then)) in positions.iter().zip(&last.positions).enumerate() {
                let moved = frame.boundary.min_image(now - carry * then);
                let distance = moved.length();
                if distance > most {
                    return Err(AnalysisError::TooFar {
                        particle,
                        distance,
                        most,
                    });
                }
                displacements[particle] = last.displacements[particle] + moved;
            }
        }
        self.last = Some(Last {
            time: frame.now.time,
            positions,
            displacements: displacements.clone(),
        });
        Ok(displacements)
    }

    /// Goes on from these positions at the moment of the frame, with no displacement in between.
    pub(crate) fn rebase<B>(&mut self, frame: &Frame<'_, B>, positions: Vec<DVec3>) {
        if let Some(last) = &mut self.last {
            (last.time, last.positions) = (frame.now.time, positions);
        }
    }
}
