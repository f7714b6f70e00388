//! The length of one spring at the end of an implicit step.

use std::array::from_fn;
use zimm_core::BondForce;

const MOST: usize = 240;

/// Lengths `q` at which springs of tension `T` balance a displacement: `q + c T(q) = R`, for `W` bonds side by side.
///
/// A spring whose tension grows with its length has exactly one such length. Whatever the law, that which is found is
/// between zero and `ends`, which no spring passes. `guess` is where to look first.
///
/// With T = k q the equation is solved as q = R / (1 + c k): k may have a pole at the limit of the law, but the right
/// hand side has none. The method is the secant's inside a bracket that shrinks, halved now and then.
///
/// `None` if the lengths are not found to a relative `tolerance`, that is of the length and of its distance from the
/// end. For a displacement that is not a number the guess is given back.
#[inline(always)]
pub(crate) fn lengths<const W: usize, S: BondForce>(
    law: &S,
    c: [f64; W],
    displacement: [f64; W],
    ends: [f64; W],
    guess: [f64; W],
    tolerance: f64,
) -> Option<[f64; W]> {
    let (mut low, mut high) = ([0.0; W], ends);
    let mut q: [f64; W] = from_fn(|w| guess[w].min(displacement[w]).min(ends[w]));
    let mut slope = [1.0; W];
    let (mut q_before, mut h_before) = ([f64::NAN; W], [f64::NAN; W]);
    // One while a length is looked for, zero after that: numbers, so that bonds share vector registers.
    let mut open = [1.0; W];
    for round in 0..MOST {
        let halve = round % 8 == 7;
        for w in 0..W {
            let (at, opened) = (q[w], open[w]);
            let stiffening = 1.0 - c[w] * law.force(at * at);
            let h = at - displacement[w] / stiffening;
            let attracts = stiffening > 0.0;
            let short = if attracts { h } else { -1.0 };
            let below = if short < 0.0 { at } else { low[w] };
            let above = if short < 0.0 { high[w] } else { at };

            let rise = (h - h_before[w]) / (at - q_before[w]);
            let steep = if rise > 0.0 { rise } else { slope[w] };
            let secant = at - h / steep;
            let middle = 0.5 * (below + above);
            let farther = 2.0 * at + displacement[w];
            let half = if above < f64::INFINITY {
                middle
            } else {
                farther
            };
            let raised = if secant > below { secant } else { half };
            let inside = if secant < above { raised } else { half };
            let usable = if attracts { inside } else { half };
            let next = if halve { half } else { usable };

            // Not only the displacement is to be met, but also the length, and what it leaves of the law.
            let asked = tolerance * at.min(ends[w] - at) + 2.0 * f64::EPSILON * at;
            let missed = if h.abs() > tolerance * at {
                opened
            } else {
                0.0
            };
            let unsure = if (secant - at).abs() > asked {
                opened
            } else {
                missed
            };
            let misses = if attracts { unsure } else { opened };
            let room = above - below;
            let wide = room > f64::EPSILON * at;
            let remains = if wide { misses } else { 0.0 };
            // The last secant still improves a length.
            let better = secant.min(ends[w]);
            let last = if misses > 0.0 { at } else { better };
            let found = if opened > 0.0 { last } else { at };
            (q_before[w], h_before[w], slope[w]) = (at, h, steep);
            (low[w], high[w]) = (below, above);
            q[w] = if remains > 0.0 { next } else { found };
            open[w] = remains;
        }
        if open.iter().sum::<f64>() == 0.0 {
            return Some(q);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use zimm_core::ParameterError;
    use zimm_forces::{Fene, Fraenkel, Hooke, MarkoSiggia};

    /// A repulsion of hard cores, c / q^12, to be added to a spring.
    struct Core;

    impl BondForce for Core {
        fn force(&self, r2: f64) -> f64 {
            1.0 / (r2 * r2 * r2).powi(2) / r2
        }

        fn energy(&self, _: f64) -> f64 {
            0.0
        }
    }

    /// Over 24 decades of stiffness and displacement, from guesses anywhere, the balance holds to rounding: to 1e-9 of
    /// the displacement where the length can move, and at the last number below the end where it cannot.
    fn check<S: BondForce>(name: &str, law: &S, limit: f64) {
        let end = limit * (1.0 - 1e-12);
        let powers = [-12, -6, -3, -1, 0, 1, 2, 4, 8, 12].map(|power| 10_f64.powi(power));
        for c in powers {
            for displacement in powers.map(|power| 0.7 * power) {
                for guess in [0.0, 1e-9, 0.3, 0.999_999, 1.0].map(|part| part * end.min(10.0)) {
                    let found = lengths(law, [c], [displacement], [end], [guess], 1e-10);
                    let [q] = found.unwrap_or_else(|| {
                        panic!("{name}: no length for c = {c}, R = {displacement}, guess {guess}")
                    });
                    assert!((0.0..=end).contains(&q), "{name}: length {q}");
                    let side = |q: f64| q - c * law.force(q * q) * q - displacement;
                    // The balance changes its sign within the tolerance of the length and of its distance to the end,
                    // or four units in the last place.
                    let width = 1e-9 * q.min(limit - q) + 4.0 * f64::EPSILON * q;
                    let (short, long) = (side(q - width), side((q + width).min(end)));
                    let rounding = 1e-13 * (q + c * (law.force(q * q) * q).abs() + displacement);
                    let balanced = short <= rounding && long >= -rounding;
                    assert!(
                        balanced || q > end * (1.0 - 1e-11),
                        "{name}: c = {c}, R = {displacement}, guess {guess}: length {q}, off by {short} and {long}"
                    );
                }
            }
        }
    }

    #[test]
    fn extreme_a_balanced_length_is_found_whatever_law_stiffness_and_guess()
    -> Result<(), ParameterError> {
        check("Hooke", &Hooke::new(1.0)?, f64::INFINITY);
        check("Fraenkel", &Fraenkel::new(1.0, 2.0)?, f64::INFINITY);
        for limit in [1.0, 7.0, 1000.0] {
            check("Fene", &Fene::new(1.0, limit)?, limit);
            check("MarkoSiggia", &MarkoSiggia::new(1.0, limit)?, limit);
        }
        check("Kremer and Grest's", &(Fene::new(30.0, 1.5)?, Core), 1.5);
        Ok(())
    }

    /// q (1 + c / (1 - q^2 / b)) = R, the cubic of the FENE spring: at b = 4, c = 1/2 and R = 1.75 its root is 1.
    #[test]
    fn limit_the_root_of_a_cubic_in_one_lane_of_four() {
        let fene = Fene::new(1.0, 2.0).unwrap();
        let (c, displacement) = ([0.5, 0.6, 0.0, 0.5], [5.0 / 3.0, 0.0, 1.0, 1e6]);
        let found = lengths(&fene, c, displacement, [2.0; 4], [0.1; 4], 1e-12).unwrap();
        assert!((found[0] - 1.0).abs() < 1e-14);
        assert_eq!((found[1], found[2]), (0.0, 1.0));
        assert!((found[3] - 2.0 + 1e-6).abs() < 1e-11);
    }
}
