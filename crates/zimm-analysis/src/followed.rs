//! Displacements relative to the flow, summed from one moment to the next.

use crate::AnalysisError;
use zimm_core::{Boundary, DVec3, Frame};

/// Where things were at a moment.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    pub(crate) time: f64,
    pub(crate) positions: Vec<DVec3>,
}

impl Places {
    /// How far each has come relative to the flow, to these positions, any image of them, at the moment of the frame.
    pub(crate) fn moved<B: Boundary>(
        &self,
        frame: &Frame<'_, B>,
        positions: &[DVec3],
    ) -> Result<Vec<DVec3>, AnalysisError> {
        if self.positions.len() != positions.len() {
            return Err(AnalysisError::Length {
                sample: 1,
                found: positions.len(),
                expected: self.positions.len(),
            });
        }
        let carry = frame.boundary.carry(self.time, frame.now.time);
        let most = 0.5 * frame.boundary.reach();
        let step = |(particle, (&now, &then)): (usize, (&DVec3, &DVec3))| {
            let moved = frame.boundary.min_image(now - carry * then);
            let distance = moved.length();
            let near = distance <= most;
            if near {
                Ok(moved)
            } else {
                Err(AnalysisError::TooFar {
                    particle,
                    distance,
                    most,
                })
            }
        };
        let columns = positions.iter().zip(&self.positions);
        columns.enumerate().map(step).collect()
    }
}

/// Where things were and how far they have come.
#[derive(Clone, Debug, Default)]
pub(crate) struct Followed {
    last: Option<(Places, Vec<DVec3>)>,
}

impl Followed {
    /// The displacements up to these positions, any image of them, at the moment of the frame.
    pub(crate) fn to<B: Boundary>(
        &mut self,
        frame: &Frame<'_, B>,
        positions: Vec<DVec3>,
    ) -> Result<Vec<DVec3>, AnalysisError> {
        let displacements = match &self.last {
            None => vec![DVec3::ZERO; positions.len()],
            Some((last, before)) => {
                let moved = last.moved(frame, &positions)?;
                before
                    .iter()
                    .zip(moved)
                    .map(|(d, step)| *d + step)
                    .collect()
            }
        };
        let time = frame.now.time;
        self.last = Some((Places { time, positions }, displacements.clone()));
        Ok(displacements)
    }

    /// Goes on from these positions at the moment of the frame, with no displacement in between.
    pub(crate) fn rebase<B>(&mut self, frame: &Frame<'_, B>, positions: Vec<DVec3>) {
        let time = frame.now.time;
        if let Some((last, _)) = &mut self.last {
            *last = Places { time, positions };
        }
    }
}
