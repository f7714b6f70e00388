//! Which part of the work goes to pairs and which to waves.

use super::kernel::{Carried, Kernel};
use super::window::Window;
use crate::rpy::pair;
use std::f64::consts::PI;

/// A window, and the cutoff of the pairs that goes with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plan {
    pub(crate) window: Window,
    pub(crate) cutoff: f64,
}

/// What a plan is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Task {
    /// Root-mean-square error of a velocity for independent forces, relative to that of one bead pulled alone in the
    /// cell.
    pub(crate) error: f64,
    pub(crate) radius: f64,
    /// Beads per volume.
    pub(crate) density: f64,
    /// Beads per volume that make the error. Those of different beads add up at random; those of a bead's own images
    /// by shells of up to 48 waves, as those of 48 beads do.
    sources: f64,
    pub(crate) volume: f64,
}

impl Task {
    /// A task from what a frame has. The volume is rounded to a fraction of a per cent, so that the rounding of a cell
    /// that flows does not show in the plan.
    pub(crate) fn new(error: f64, radius: f64, beads: usize, volume: f64) -> Self {
        const STEPS: f64 = 256.0;
        let volume = libm::exp2((libm::log2(volume) * STEPS).round() / STEPS);
        Self {
            error,
            radius,
            density: beads.max(1) as f64 / volume,
            sources: beads.max(48) as f64 / volume,
            volume,
        }
    }

    /// The plan of the least cost.
    ///
    /// Ranges are tried in steps of a quarter of an octave from the one at which a bead has one neighbour, uphill or
    /// downhill as the cost tells, which has a single minimum.
    pub(crate) fn cheapest(&self, cost: impl Fn(&Plan) -> f64) -> Plan {
        let at = |step: i32| {
            let plan =
                self.at_range(libm::exp2(0.25 * f64::from(step)) * libm::cbrt(1.0 / self.density));
            (cost(&plan), plan)
        };
        let (mut step, mut best) = (4, at(4));
        for way in [1, -1] {
            let mut next = at(step + way);
            while next.0 < best.0 {
                (step, best) = (step + way, next);
                next = at(step + way);
            }
        }
        best.1
    }

    /// The kernel of a plan. Its errors are to stay small also where those of all partners of a bead add up.
    pub(crate) fn kernel(&self, plan: &Plan) -> Kernel {
        let partners = 4.0 * PI / 3.0 * plan.cutoff.powi(3) * self.density;
        let error = 0.3 * self.error / partners.max(10.0);
        Kernel::new(plan.window, self.radius, plan.cutoff, error)
    }

    /// The window of a given range, and the cutoff, that deliver the error.
    ///
    /// Squared errors are integrals over all space beyond the cutoff, for beads anywhere. A quarter is for waves beyond
    /// the edge, the rest for pairs beyond the cutoff.
    pub(crate) fn at_range(&self, range: f64) -> Plan {
        let x = self.radius / libm::cbrt(self.volume);
        // The mobility of one bead alone in a cube (Hasimoto 1959), until the bead fills it.
        let own = (1.0 - 2.837 * x + 4.189 * x * x * x).max(if x < 0.4 { 0.0 } else { 0.05 });
        let square = (self.error * own) * (self.error * own) / self.sources;
        let (mut low, mut high) = (1.0, 60.0);
        while high - low > 0.02 {
            let shape = 0.5 * (low + high);
            let window = Window { range, shape };
            if waves_beyond(window, self.radius) < 0.25 * square {
                high = shape;
            } else {
                low = shape;
            }
        }
        let window = Window { range, shape: high };
        let cutoff = cutoff(window, self.radius, 0.75 * square);
        Plan { window, cutoff }
    }
}

/// The squared error of leaving waves beyond the edge out, for one bead per volume.
fn waves_beyond(window: Window, radius: f64) -> f64 {
    const STEPS: usize = 48;
    // Equal steps in edge / k = 1 / (1 + x), from 1 to 0.
    let edge = window.edge();
    let step = 1.0 / STEPS as f64;
    let sum: f64 = (0..STEPS)
        .map(|n| {
            let inverse = 1.0 - (n as f64 + 0.5) * step;
            let k = edge / inverse;
            let weight = window.weight(k, radius) * k;
            weight * weight * k / inverse
        })
        .sum();
    sum * step / (3.0 * PI * PI)
}

/// The distance beyond which the squares of what is left to pairs add up to an error, for one bead per volume.
fn cutoff(window: Window, radius: f64, error: f64) -> f64 {
    const STEPS: f64 = 32.0;
    let step = window.range / STEPS;
    let farthest = 2.0 * (window.range + 2.0 * radius);
    let carried = Carried::new(window, radius, farthest);
    let mut sum = 0.0;
    let mut n = (farthest / step) as usize;
    while n > 1 {
        let r = (n as f64 - 0.5) * step;
        let [iso, dyad, _] = pair(r * r, radius);
        let [iso_waves, dyad_waves] = carried.at(r);
        let (iso, dyad) = (iso - iso_waves, dyad - dyad_waves);
        let trace = 2.0 * iso * iso + (iso + dyad) * (iso + dyad);
        sum += trace / 3.0 * 4.0 * PI * r * r * step;
        if sum > error {
            break;
        }
        n -= 1;
    }
    n as f64 * step
}
