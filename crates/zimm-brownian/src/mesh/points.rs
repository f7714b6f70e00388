//! Which mesh for which cell.

use super::window::Window;
use crate::lattice_sum::Plan;
use std::f64::consts::PI;
use zimm_core::{Lattice, MobilityError};

/// Mesh points along each basis vector: two for the shortest wave, and as many as the window is wide.
pub(super) fn of(
    lattice: &Lattice,
    plan: &Plan,
    window: &Window,
) -> Result<[usize; 3], MobilityError> {
    const MOST: f64 = 1e9;
    let (basis, widest) = (lattice.basis(), window.points() as f64);
    let wanted = [basis.x_axis, basis.y_axis, basis.z_axis]
        .map(|axis| (plan.edge() * axis.length() / PI).ceil().max(widest));
    let total = wanted[0] * wanted[1] * wanted[2];
    if total > MOST {
        return Err(MobilityError::Cell {
            radius: plan.radius,
            quantity: "number of mesh points",
            found: total,
            allowed: "at most 1e9",
        });
    }
    let [n1, n2, n3] = wanted.map(|n| n as usize);
    Ok([best(n1), best(n2), 2 * best(n3.div_ceil(2))])
}

/// The number from `n` on that costs least. A mesh point takes a part of the time for itself and a part for the
/// transform along a line, here in tenths of nanoseconds as measured with rustfft: lengths that have a transform of
/// their own are up to five times faster than those that are put together from small primes alone.
fn best(n: usize) -> usize {
    const OWN: [usize; 7] = [12, 16, 18, 24, 27, 32, 36];
    const POWERS: [usize; 2] = [64, 128];
    let divides = |factor: &usize, n: usize| n.is_multiple_of(*factor);
    let cost = |&n: &usize| {
        let line = match n {
            _ if OWN.contains(&n) => 9,
            _ if POWERS.contains(&n) => 17,
            _ if [6, 8, 9].iter().any(|factor| divides(factor, n)) => 26,
            _ => 42,
        };
        n * (60 + line)
    };
    let smooth = (n..=n + n / 3).filter(|&n| is_smooth(n));
    smooth.min_by_key(cost).unwrap_or(n)
}

/// Whether a number has no prime factor above 7.
fn is_smooth(n: usize) -> bool {
    let mut rest = n;
    for prime in [2, 3, 5, 7] {
        while rest > 0 && rest.is_multiple_of(prime) {
            rest /= prime;
        }
    }
    rest == 1
}
