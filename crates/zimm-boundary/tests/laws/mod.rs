//! The laws that every boundary obeys, each a function generic over it. A law panics where it does not hold.
//!
//! Bounds are relative to the sizes met on the way, so that the laws hold for cells and deformations of any size.

use zimm_core::{Boundary, DMat3, DVec3, IVec3, Remap};

/// The space as it is at a time.
pub(crate) fn at<B: Boundary>(space: &B, time: f64) -> B {
    let mut space = space.clone();
    space.advance(time);
    space
}

/// A deformation over no time is none, and two in a row are one.
pub(crate) fn carries_compose<B: Boundary>(space: &B, [a, b, c]: [f64; 3]) {
    assert_eq!(space.carry(a, a), DMat3::IDENTITY);
    let (first, second, both) = (space.carry(a, b), space.carry(b, c), space.carry(a, c));
    let error = norm(second * first - both);
    let bound = 1e-13 * norm(first) * norm(second);
    assert!(error <= bound, "{a} to {b} to {c}: {error:e}");
}

/// The gradient is the rate of deformation, at a time when the flow is smooth. The central difference is wrong by
/// 2e-11 of the third power of the rates and, up to a strain of 1e3, by 1e-8 from rounding; the bound is 1e-6.
pub(crate) fn gradient_is_the_rate_of_the_carry<B: Boundary>(space: &B, time: f64) {
    let h = 1e-5;
    let difference = (space.carry(time, time + h) - space.carry(time, time - h)) * (0.5 / h);
    let gradient = at(space, time).gradient();
    let error = norm(difference - gradient);
    let bound = 1e-6 * (1.0 + norm(gradient));
    assert!(error < bound, "gradient {gradient}, found {difference}");
}

/// The state at a time does not depend on the times before it, and the remaps on the way add up.
pub(crate) fn state_is_a_function_of_time<B: Boundary>(
    space: &B,
    [a, b, c]: [f64; 3],
    count: IVec3,
) {
    let (mut direct, mut stopping) = (at(space, a), at(space, a));
    let whole = direct.advance(c);
    let parts = [stopping.advance(b), stopping.advance(c)];
    assert_eq!(direct.cell(), stopping.cell());
    assert_eq!(direct.gradient(), stopping.gradient());
    let stepwise = parts[1].apply(parts[0].apply(count));
    assert_eq!(whole.apply(count), stepwise, "{a} to {b} to {c}");
}

/// The lattice at a later time is the carried lattice, as a set: between the bases there is an integer matrix of
/// determinant +-1, and it is the one that the remap tells.
pub(crate) fn images_are_carried<B: Boundary>(space: &B, from: f64, to: f64) {
    let mut space = at(space, from);
    let carried = space.cell().map(|cell| space.carry(from, to) * cell);
    let remap = matrix(space.advance(to));
    let between = match (carried, space.cell()) {
        (Some(carried), Some(cell)) => cell.inverse() * carried,
        (before, after) => {
            assert_eq!(before, after, "a cell has come or gone");
            DMat3::IDENTITY
        }
    };
    let error = norm(between - remap);
    assert!(
        error < 1e-9 * norm(remap),
        "{between} between the bases, remap {remap}"
    );
    let determinant = remap.determinant().abs();
    assert!((determinant - 1.0).abs() < 1e-6, "{determinant}");
}

/// The volume of the cell changes by the determinant of the deformation.
pub(crate) fn volume_is_carried<B: Boundary>(space: &B, from: f64, to: f64) {
    let volume = |time| {
        at(space, time)
            .cell()
            .map_or(1.0, |h| h.determinant().abs())
    };
    let compressed = if space.cell().is_some() {
        space.carry(from, to).determinant()
    } else {
        1.0
    };
    let ratio = volume(to) / volume(from) / compressed;
    assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
}

/// A particle that follows the flow, wrapped and counted at each of the times, is where it would be without wrapping.
pub(crate) fn counts_follow<B: Boundary>(space: &B, times: &[f64], r: DVec3) {
    let Some(&start) = times.first() else { return };
    let mut space = at(space, start);
    let (mut position, mut count) = space.wrap(r);
    let mut scale = r.length();
    for (&from, &to) in times.iter().zip(&times[1..]) {
        let carried = space.carry(from, to) * position;
        let remap = space.advance(to);
        let (folded, taken) = space.wrap(carried);
        (position, count) = (folded, remap.apply(count) + taken);
        let whole = space.carry(start, to);
        let cell = space.cell().unwrap_or_default();
        scale += norm(whole) * r.length() + norm(cell) * (1.0 + count.as_dvec3().length());
        let error = (position + cell * count.as_dvec3() - whole * r).length();
        assert!(error < 1e-13 * scale, "{start} to {to}: {error:e}");
    }
}

/// Pairs do not feel the basis. Between two times their distance changes by no more than the deformation stretches,
/// remap or not; a pair in reach rides the flow, and its laboratory velocity difference changes by no more than the
/// gradient and the deformation do. With times close together on both sides of a remap this is continuity.
pub(crate) fn pairs_ride_the_flow<B: Boundary>(space: &B, from: f64, to: f64, [r, s]: [DVec3; 2]) {
    let (old, new) = (at(space, from), at(space, to));
    let (carry, back) = (space.carry(from, to), space.carry(to, from));
    let ride = |x: DVec3| new.wrap(carry * old.wrap(x).0).0;
    let before = old.min_image(r - s);
    let after = new.min_image(ride(r) - ride(s));
    let scale = norm(carry) * (norm(old.cell().unwrap_or_default()) + r.length() + s.length());
    let rounding = 1e-13 * scale;
    let strain = |f: DMat3| norm(f - DMat3::IDENTITY);
    let (d, d_after) = (before.length(), after.length());
    assert!(
        d_after <= (1.0 + strain(carry)) * d + rounding,
        "{d} became {d_after}"
    );
    assert!(
        d <= (1.0 + strain(back)) * d_after + rounding,
        "{d} became {d_after}"
    );
    let expected = carry * before;
    if expected.length() < new.reach() * (1.0 - 1e-9) {
        let error = (after - expected).length();
        assert!(error < rounding, "{before} became {after}, not {expected}");
        let (k, k_after) = (old.gradient(), new.gradient());
        let change = (k_after * after - k * before).length();
        let allowed = (norm(k_after - k) + norm(k_after) * strain(carry)) * d;
        assert!(
            change <= allowed + norm(k_after) * rounding,
            "velocity {change:e}"
        );
    }
}

/// Wrapping twice is wrapping once, what is taken off is the count of lattice vectors, and no pair feels it.
pub(crate) fn wrapping_is_invisible<B: Boundary>(space: &B, r: DVec3, s: DVec3) {
    let cell = space.cell().unwrap_or_default();
    let (folded, count) = space.wrap(r);
    let scale = norm(cell) * (1.0 + count.as_dvec3().length()) + r.length() + s.length();
    let (again, none) = space.wrap(folded);
    if none == IVec3::ZERO {
        assert!((again - folded).length() < 1e-14 * scale);
    } else {
        // On a face of the cell, to rounding, either side is right.
        let fraction = (cell.inverse() * folded).abs().max_element();
        assert!((fraction - 0.5).abs() < 1e-12 * scale, "{fraction}");
    }
    let unwrapped = folded + cell * count.as_dvec3();
    assert!((unwrapped - r).length() < 1e-14 * scale);
    let (d, d_wrapped) = (space.min_image(r - s), space.min_image(folded - s));
    let error = (d.length() - d_wrapped.length()).abs();
    assert!(error < 1e-13 * scale, "{d} became {d_wrapped}");
}

/// The reach is half the length of the shortest lattice vector, found among all sums of up to three basis vectors
/// each, and an image separation is never longer than it need be.
pub(crate) fn reach_is_half_the_shortest_vector<B: Boundary>(space: &B, r: DVec3) {
    let Some(cell) = space.cell() else {
        assert_eq!(space.reach(), f64::INFINITY);
        return;
    };
    let near = space.min_image(r);
    let mut shortest = f64::INFINITY;
    for n in (0..343).map(|k| IVec3::new(k % 7 - 3, k / 7 % 7 - 3, k / 49 - 3)) {
        let vector = cell * n.as_dvec3();
        if n != IVec3::ZERO {
            shortest = shortest.min(vector.length());
        }
        let longer = (near + vector).length() * (1.0 + 1e-12);
        assert!(near.length() <= longer, "{near} is not the nearest");
    }
    let ratio = 2.0 * space.reach() / shortest;
    assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
}

/// The matrix that a remap applies to counts.
fn matrix(remap: Remap) -> DMat3 {
    let column = |unit: IVec3| remap.apply(unit).as_dvec3();
    DMat3::from_cols(column(IVec3::X), column(IVec3::Y), column(IVec3::Z))
}

/// Frobenius norm: it bounds every stretch and every product.
fn norm(m: DMat3) -> f64 {
    let squares = m.to_cols_array().map(|x| x * x);
    squares.iter().sum::<f64>().sqrt()
}
