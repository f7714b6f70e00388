//! Normal numbers in elementary operations without branches: the same bits on any processor, and in SIMD lanes.

use std::f64::consts::{LN_2, TAU};

/// Two independent normal numbers, by Box and Muller (1958) on the two halves of a word; the tail ends at 6.7 standard
/// deviations.
#[inline(always)]
pub(super) fn pair(word: u64) -> (f64, f64) {
    let radius = (-2.0 * log((word >> 32) as u32)).sqrt();
    let (sin, cos) = turn(word as u32);
    (radius * cos, radius * sin)
}

/// The logarithm of `(draw + 1/2) / 2^32`.
///
/// That is `e ln 2 + log m` with m in [1/sqrt 2, sqrt 2) and `log m = 2 atanh s`, s = (m - 1) / (m + 1): the series
/// in s^2 < 0.0295 is cut after s^21, at 2^-58 of its first term.
#[inline(always)]
fn log(draw: u32) -> f64 {
    const HALF_SQRT_2: u64 = 0x3fe6_a09e_667f_3bcd;
    const UNIT: f64 = 1.0 / 8_589_934_592.0;
    /// Keeps exponents above zero.
    const OFFSET: u64 = 64;
    let bits = (UNIT * (2.0 * f64::from(draw) + 1.0)).to_bits();
    let exponent = (bits + (OFFSET << 52) - HALF_SQRT_2) >> 52;
    let m = f64::from_bits(bits + (OFFSET << 52) - (exponent << 52));
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let mut series = 1.0 / 21.0;
    for odd in [19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        series = series * s2 + 1.0 / odd;
    }
    let e = f64::from(exponent as u32) - OFFSET as f64;
    e * LN_2 + (2.0 * s + 2.0 * s * (s2 * series))
}

/// Sine and cosine of `2 pi (draw + 1/2) / 2^32`.
///
/// The nearest quarter turn is taken off in integers; the series of what is left, within pi / 4, are cut after the
/// powers 17 and 16, at 1e-19 and 2e-18.
#[inline(always)]
fn turn(draw: u32) -> (f64, f64) {
    const UNIT: f64 = TAU / 8_589_934_592.0;
    const EIGHTH: u32 = 1 << 29;
    // Numbers of quarters, modulo 4, and twice the rest plus 1.
    let quarters = draw.wrapping_add(EIGHTH) >> 30;
    let rest = draw.wrapping_sub(quarters << 30) as i32;
    let angle = UNIT * (2.0 * f64::from(rest) + 1.0);
    let square = angle * angle;
    let (mut sin, mut cos) = (1.0, 1.0);
    for k in [16.0, 14.0, 12.0, 10.0, 8.0, 6.0, 4.0, 2.0] {
        sin = 1.0 - sin * square * (1.0 / (k * (k + 1.0)));
        cos = 1.0 - cos * square * (1.0 / (k * (k - 1.0)));
    }
    sin *= angle;
    let is_odd = quarters & 1 == 1;
    let (sin, cos) = if is_odd { (cos, sin) } else { (sin, cos) };
    let negate = |x: f64, sign: u32| f64::from_bits(x.to_bits() ^ u64::from(sign & 2) << 62);
    (negate(sin, quarters), negate(cos, quarters + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws all over, at the ends, and around where the parts of the two functions meet.
    fn draws() -> impl Iterator<Item = u32> {
        let near = |x: u32| (0..2000).map(move |k| x.wrapping_add(k).wrapping_sub(1000));
        let meets = [
            0,
            1 << 29,
            1 << 30,
            3 << 29,
            1 << 31,
            5 << 29,
            3 << 30,
            7 << 29,
        ];
        let roots = (0..32).map(|k| (2.0_f64.powi(k) / 2.0_f64.sqrt()) as u32);
        let powers = (0..32).map(|k| 1_u32 << k);
        let all = (0..1_000_000_u32).map(|k| k.wrapping_mul(2_654_435_761));
        all.chain(meets.into_iter().chain(roots).chain(powers).flat_map(near))
    }

    /// Against libm, whose functions are good to one unit in the last place: 2 units of the result.
    #[test]
    fn reference_logarithm() {
        for draw in draws() {
            let exact = libm::log((f64::from(draw) + 0.5) / 4_294_967_296.0);
            let found = log(draw);
            assert!(
                (found - exact).abs() <= 4.5e-16 * exact.abs(),
                "{draw}: {found} against {exact}"
            );
        }
    }

    /// The argument of libm is rounded, which costs up to 4.4e-16 near a whole turn.
    #[test]
    fn reference_sine_and_cosine() {
        for draw in draws() {
            let angle = TAU * ((f64::from(draw) + 0.5) / 4_294_967_296.0);
            let (sin, cos) = turn(draw);
            let (exact_sin, exact_cos) = libm::sincos(angle);
            assert!(
                (sin - exact_sin).abs() < 8e-16,
                "{draw}: {sin} against {exact_sin}"
            );
            assert!(
                (cos - exact_cos).abs() < 8e-16,
                "{draw}: {cos} against {exact_cos}"
            );
        }
    }

    /// Sines near zero keep their digits: 2 pi (1/2) / 2^32, and the same before and after each half turn.
    #[test]
    fn limit_sine_near_its_zeros() {
        let small = TAU * 0.5 / 4_294_967_296.0;
        for (draw, sin) in [
            (0, small),
            (u32::MAX, -small),
            (1 << 31, -small),
            ((1 << 31) - 1, small),
        ] {
            assert!((turn(draw).0 / sin - 1.0).abs() < 1e-15);
        }
        for (draw, cos) in [(1 << 30, -small), ((1 << 30) - 1, small), (3 << 30, small)] {
            assert!((turn(draw).1 / cos - 1.0).abs() < 1e-15);
        }
    }
}
