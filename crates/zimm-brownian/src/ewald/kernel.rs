//! The velocity of one bead for a force on another, but for what waves carry.

use super::series::{Series, WIDTH};
use super::window::Window;
use crate::rpy::pair;
use std::f64::consts::PI;

/// The part of a mobility that is summed over pairs: the whole, as in open space, less what waves carry, in units of the
/// mobility of a bead alone.
///
/// What waves carry is smooth. It is an integral over wave numbers, evaluated by a quadrature that is exact to rounding,
/// and kept as a series in r^2:
///
/// ```text
/// W(r) = 3a / pi  int_0^edge  sinc^2(ka) H(k) [ (j0 - j1 / kr) I + j2 rr / r^2 ] dk
/// ```
///
/// so that nothing is lost to cancellation where beads overlap or coincide.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kernel {
    radius: f64,
    waves: Series,
    /// What pairs have of a bead's own mobility.
    own: f64,
}

impl Kernel {
    /// The kernel for pairs up to a cutoff, to an absolute error.
    pub(crate) fn new(window: Window, radius: f64, cutoff: f64, error: f64) -> Self {
        let error = error.max(1e-17);
        let carried = Carried::new(window, radius, cutoff);
        let nodes = 24 + (window.edge() * cutoff) as usize;
        let waves = Series::fit(cutoff * cutoff, nodes, error, |r2| carried.at(r2.sqrt()));
        Self {
            radius,
            waves,
            own: 1.0 - carried.at(0.0)[0],
        }
    }

    /// What pairs have of a bead's own mobility.
    pub(crate) fn own(&self) -> f64 {
        self.own
    }

    /// A and C of A I + C rr, from r^2.
    #[inline(always)]
    pub(crate) fn evaluate(&self, r2: &[f64; WIDTH]) -> [[f64; WIDTH]; 2] {
        let mut result = self.waves.evaluate(r2);
        for l in 0..WIDTH {
            let [iso, dyad, inverse] = pair(r2[l], self.radius);
            result[0][l] = iso - result[0][l];
            result[1][l] = (dyad - result[1][l]) * inverse;
        }
        result
    }
}

/// What waves carry from one bead to another.
#[derive(Clone, Debug)]
pub(crate) struct Carried {
    /// Wave numbers, and what each has.
    nodes: Vec<[f64; 2]>,
}

impl Carried {
    /// For separations up to `farthest`.
    pub(crate) fn new(window: Window, radius: f64, farthest: f64) -> Self {
        let edge = window.edge();
        let turns = edge * (farthest + 2.0 * radius) + window.shape;
        let nodes = gauss_legendre(24 + (0.5 * turns) as usize)
            .into_iter()
            .map(|[x, weight]| {
                let k = 0.5 * edge * (1.0 + x);
                let weight = 0.5 * edge * weight * 3.0 * radius / PI;
                [k, weight * window.surface(k, radius)]
            })
            .collect();
        Self { nodes }
    }

    /// A and B of A I + B rr / r^2 at a distance.
    pub(crate) fn at(&self, r: f64) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for &[k, share] in &self.nodes {
            let [iso, dyad] = transverse(k * r);
            sum[0] += share * iso;
            sum[1] += share * dyad * (k * r) * (k * r);
        }
        sum
    }
}

/// j0(x) - j1(x) / x and j2(x) / x^2: the average of (I - kk / k^2) exp(i k r) over directions of k.
fn transverse(x: f64) -> [f64; 2] {
    let square = x * x;
    if x > 1.0 {
        let (sin, cos) = libm::sincos(x);
        let (j0, j1) = (sin / x, (sin / x - cos) / square);
        return [j0 - j1, (3.0 * j1 - j0) / square];
    }
    // j_n(x) / x^n = sum_m (-x^2 / 2)^m / (m! (2n + 2m + 1)!!)
    let bessel = |n: f64, first: f64| {
        let (mut term, mut sum) = (first, first);
        for m in 1..12 {
            let m = f64::from(m);
            term *= -square / (2.0 * m * (2.0 * (n + m) + 1.0));
            sum += term;
        }
        sum
    };
    [
        bessel(0.0, 1.0) - bessel(1.0, 1.0 / 3.0),
        bessel(2.0, 1.0 / 15.0),
    ]
}

/// Nodes and weights of Gauss and Legendre's quadrature on [-1, 1], by Newton's method.
fn gauss_legendre(count: usize) -> Vec<[f64; 2]> {
    let n = count as f64;
    let mut rule: Vec<[f64; 2]> = (0..count)
        .map(|k| {
            let mut x = libm::cos(PI * (k as f64 + 0.75) / (n + 0.5));
            let mut weight = 0.0;
            for _ in 0..8 {
                let (mut last, mut value) = (1.0, x);
                for j in 2..=count {
                    let j = j as f64;
                    let next = ((2.0 * j - 1.0) * x * value - (j - 1.0) * last) / j;
                    (last, value) = (value, next);
                }
                let square = (1.0 - x) * (1.0 + x);
                let slope = n * (last - x * value) / square;
                weight = 2.0 / (square * slope * slope);
                x -= value / slope;
            }
            [x, weight]
        })
        .collect();
    // Takes off what rounding has put into all weights alike.
    let sum: f64 = rule.iter().map(|[_, weight]| weight).sum();
    for [_, weight] in &mut rule {
        *weight *= 2.0 / sum;
    }
    rule
}
