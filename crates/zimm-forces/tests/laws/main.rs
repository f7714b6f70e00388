//! Every law against theory, quadrature or published numbers.
#![cfg(test)]

mod body_forces;
mod dpd;
mod dpd_fluid;
mod hard_pairs;
mod narrow_gaussian;
mod springs;

use zimm_core::{Now, Pair, PairForce, ParameterError};

/// A pair at a distance, at rest and without noise.
fn at(r: f64) -> Pair {
    Pair {
        r2: r * r,
        ..Pair::default()
    }
}

/// The force of a pair law at a distance.
fn force(law: &impl PairForce, r: f64) -> f64 {
    r * law.force(&at(r), &Now::default()).total()
}

/// Derivative by the central difference of fourth order.
fn slope(f: impl Fn(f64) -> f64, x: f64) -> f64 {
    let h = 1e-4 * x;
    (8.0 * (f(x + h) - f(x - h)) - (f(x + 2.0 * h) - f(x - 2.0 * h))) / (12.0 * h)
}

/// Nodes and weights of Gauss and Legendre's rule of five points on equal panels.
fn gauss_legendre(from: f64, to: f64, panels: usize) -> impl Iterator<Item = (f64, f64)> {
    const NODES: [(f64, f64); 5] = [
        (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
        (-0.538_469_310_105_683, 0.478_628_670_499_366_5),
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683, 0.478_628_670_499_366_5),
        (0.906_179_845_938_664, 0.236_926_885_056_189_1),
    ];
    let half = 0.5 * (to - from) / panels as f64;
    (0..panels).flat_map(move |k| {
        let centre = from + (2 * k + 1) as f64 * half;
        NODES.map(|(x, w)| (centre + half * x, half * w))
    })
}

/// The integral by that rule.
fn integral(f: impl Fn(f64) -> f64, from: f64, to: f64, panels: usize) -> f64 {
    gauss_legendre(from, to, panels)
        .map(|(x, w)| w * f(x))
        .sum()
}

/// A parameter is refused at each of these values, by name and with the number in the error.
fn assert_refused<T>(
    name: &str,
    values: &[f64],
    construct: impl Fn(f64) -> Result<T, ParameterError>,
) {
    for &value in values {
        match construct(value) {
            Ok(_) => panic!("{name} = {value} was accepted"),
            Err(error) => {
                assert_eq!(error.name, name);
                assert_eq!(error.found.to_bits(), value.to_bits());
                assert!(error.to_string().contains(&value.to_string()), "{error}");
            }
        }
    }
}

const NOT_POSITIVE: [f64; 4] = [0.0, -1.0, f64::NAN, f64::INFINITY];
const BELOW_ZERO: [f64; 3] = [-1.0, f64::NAN, f64::INFINITY];
const NO_LENGTH: [f64; 6] = [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-200, 1e200];
