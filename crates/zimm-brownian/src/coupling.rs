//! What beads do to each other at the end of an implicit step: known from products with the mobility, of as few forces as
//! will do.

use crate::{
    Mobility,
    columns::{add_scaled, rescale},
    mixing::Mixing,
    stage::zero,
};
use zimm_core::{Boundary, DVec3};

/// What beads do to each other in the second half of a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coupling {
    /// Forces at the end of the step as they were known last, and what they move beads by.
    forces: Vec<DVec3>,
    pub(crate) moved: Vec<DVec3>,
    /// Forces of springs at the end of the step as they are known now, and what they move beads by that are alone.
    pub(crate) tension: Vec<DVec3>,
    pub(crate) pulled: Vec<DVec3>,
    /// By what beads alone are too slow, or in the wrong place.
    pub(crate) lagged: Vec<DVec3>,
    /// How much faster beads alone are than they would be.
    pub(crate) factor: f64,
    /// The most that has been seen of what others do to beads, in parts of what beads do by themselves.
    pub(crate) gain: f64,
    /// Whether forces are as they were expected.
    expected: bool,
    pub(crate) residual: Vec<DVec3>,
    change: Vec<DVec3>,
    pub(crate) mixing: Mixing,
}

impl Coupling {
    /// Begins with forces and the velocities that they make; those of springs among them are still to be told.
    pub(crate) fn expect<B: Boundary, M: Mobility<B>>(
        &mut self,
        half: f64,
        mobility: &M,
        forces: &[DVec3],
        velocities: &[DVec3],
    ) {
        (self.factor, self.expected) = (1.0, true);
        self.gain = gain(1.0, mobility, forces, velocities);
        forces.clone_into(&mut self.forces);
        velocities.clone_into(&mut self.moved);
        rescale(&mut self.moved, half);
        zero(&mut self.tension, forces.len());
        zero(&mut self.pulled, forces.len());
    }

    /// What the change of forces does to beads in half a step.
    pub(crate) fn learn<B: Boundary, M: Mobility<B>>(
        &mut self,
        half: f64,
        mobility: &mut M,
        others: &[DVec3],
    ) {
        if std::mem::take(&mut self.expected) {
            return;
        }
        self.tension.clone_into(&mut self.change);
        add_scaled(&mut self.change, -1.0, &self.forces);
        if !others.is_empty() {
            add_scaled(&mut self.change, 1.0, others);
        }
        add_scaled(&mut self.forces, 1.0, &self.change);
        zero(&mut self.residual, self.change.len());
        mobility.apply(&self.change, &mut self.residual);
        add_scaled(&mut self.moved, half, &self.residual);
        let gain = gain(self.factor, mobility, &self.change, &self.residual);
        self.gain = self.gain.max(gain);
    }

    /// Lags what beads alone do not do.
    pub(crate) fn lag(&mut self) {
        self.moved.clone_into(&mut self.lagged);
        add_scaled(&mut self.lagged, -1.0, &self.pulled);
    }

    /// By what the last solution misses.
    pub(crate) fn miss(&mut self) {
        self.moved.clone_into(&mut self.residual);
        add_scaled(&mut self.residual, -1.0, &self.pulled);
        add_scaled(&mut self.residual, -1.0, &self.lagged);
    }

    /// Makes beads alone faster. Their tensions stay, and with them what they are to move.
    pub(crate) fn hasten(&mut self) {
        self.factor *= 2.0;
        rescale(&mut self.pulled, 2.0);
        self.lag();
        self.mixing.forget();
    }
}

/// What others do to beads, in parts of what the beads do by themselves.
fn gain<B: Boundary, M: Mobility<B>>(
    factor: f64,
    mobility: &M,
    forces: &[DVec3],
    velocities: &[DVec3],
) -> f64 {
    let (mut alone, mut apart) = (0.0, 0.0);
    for (place, (force, velocity)) in forces.iter().zip(velocities).enumerate() {
        let by_itself = factor * mobility.alone(place) * *force;
        alone += by_itself.length_squared();
        apart += (*velocity - by_itself).length_squared();
    }
    if alone > 0.0 {
        (apart / alone).sqrt()
    } else {
        0.0
    }
}
