//! The laws that every boundary obeys, as checks, and strategies to try them with (feature `proptest`).
//!
//! A boundary of one's own is tested by one line, and by another if it promises that images stay apart:
//!
//! ```
//! use zimm_boundary::{KraynikReinelt, Steady, laws};
//!
//! let space = KraynikReinelt::new(10.0, 12.0, Steady::new(1.0)?)?;
//! laws::check_boundary(&space, 20.0);
//! laws::check_reach(&space, 20.0, 0.5 * space.min_image_distance());
//! # Ok::<(), zimm_boundary::FlowError>(())
//! ```
//!
//! The environment variable `PROPTEST_CASES` says how many random cases are tried, 256 if it is not set. A law panics
//! where it does not hold; the checks then look for the simplest case in which it does not, and name it. The laws can
//! also be called one by one.
//!
//! Bounds are relative to the sizes met on the way, so that the laws hold for cells and deformations of any size.

use crate::{KraynikReinelt, LeesEdwards, PlanarMixed, Steady, TriaxialFlow, UniaxialExtension};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use zimm_core::{Boundary, DMat3, DVec3, IVec3, Lattice, Remap};

/// Tries all laws at random times between 0 and `until`, with random particles.
///
/// Steps of any length are tried, up to those that stretch by a thousand.
///
/// # Panics
/// If a law does not hold, with the law and the case.
pub fn check_boundary<B: Boundary>(space: &B, until: f64) {
    check(&trial(), |trial| obeys(space, until, trial));
}

/// Looks for a random time between 0 and `until` at which the reach is below `promised`.
///
/// # Panics
/// If there is one.
pub fn check_reach<B: Boundary>(space: &B, until: f64, promised: f64) {
    check(&(0.0..1.0), |share| {
        reach_is_at_least(space, share * until, promised)
    });
}

fn check<S: Strategy>(cases: &S, law: impl Fn(&S::Value)) {
    let config = Config {
        failure_persistence: None,
        ..Config::default()
    };
    let result = TestRunner::new(config).run(cases, |case| {
        law(&case);
        Ok(())
    });
    assert!(result.is_ok(), "{result:?}");
}

/// What the laws are tried with; made by [`trial`].
#[derive(Clone, Debug)]
pub struct Trial {
    shares: [f64; 3],
    r: DVec3,
    s: DVec3,
    count: IVec3,
}

/// Random times, positions and image counts, to be scaled to a boundary.
pub fn trial() -> impl Strategy<Value = Trial> {
    let shares = proptest::array::uniform3(0.0..1.0);
    let count = proptest::array::uniform3(-1000..1000).prop_map(IVec3::from_array);
    (shares, vector(5.0), vector(5.0), count).prop_map(|(shares, r, s, count)| Trial {
        shares,
        r,
        s,
        count,
    })
}

/// All laws, at times up to `until`.
///
/// # Panics
/// If one does not hold.
pub fn obeys<B: Boundary>(space: &B, until: f64, trial: &Trial) {
    let Trial { shares, count, .. } = *trial;
    let extent = space.cell().map_or(1.0, norm);
    let [r, s] = [trial.r, trial.s].map(|x| extent * x);
    let a = until * shares[0];
    let b = later(space, a, until * shares[1].powi(3));
    let c = later(space, b, until * shares[2].powi(3));
    carries_compose(space, [a, b, c]);
    gradient_is_the_rate_of_the_carry(space, a, until);
    state_is_a_function_of_time(space, [a, b, c], count);
    images_are_carried(space, a, b);
    volume_is_carried(space, a, b);
    counts_follow(space, &[a, b, c], r);
    pairs_ride_the_flow(space, b, c, [r, s]);
    no_remap_is_felt(space, a, b, [r, s]);
    let now = at(space, b);
    wrapping_is_invisible(&now, r, s);
    reach_is_half_the_shortest_vector(&now, r);
}

/// A time after `from`, by so much or as much less as it takes for the deformation to be moderate.
fn later<B: Boundary>(space: &B, from: f64, mut by: f64) -> f64 {
    const MOST: f64 = 1e3;
    let moderate = |to| norm(space.carry(from, to)) < MOST && norm(space.carry(to, from)) < MOST;
    for _ in 0..64 {
        if moderate(from + by) {
            break;
        }
        by *= 0.5;
    }
    from + by
}

/// The space as it is at a time.
pub fn at<B: Boundary>(space: &B, time: f64) -> B {
    let mut space = space.clone();
    space.advance(time);
    space
}

/// A deformation over no time is none, and two in a row are one.
///
/// # Panics
/// If not. Strains are rounded at their size, so the bound grows with the rates and the times.
pub fn carries_compose<B: Boundary>(space: &B, [a, b, c]: [f64; 3]) {
    assert_eq!(space.carry(a, a), DMat3::IDENTITY);
    let (first, second, both) = (space.carry(a, b), space.carry(b, c), space.carry(a, c));
    let error = norm(second * first - both);
    let bound = roundings(space, &[a, b, c]) * norm(first) * norm(second);
    assert!(
        error <= bound,
        "{a} to {b} to {c}: {error:e} beyond {bound:e}"
    );
}

/// The gradient is the rate of deformation: a central difference of the carry agrees with it, up to what the gradient
/// changes meanwhile. Sudden strains, in which the gradient has no part, are passed over.
///
/// # Panics
/// If not, to 1e-6 of the rate or of one strain in the time `until`.
pub fn gradient_is_the_rate_of_the_carry<B: Boundary>(space: &B, time: f64, until: f64) {
    let gradient = at(space, time).gradient();
    let scale = norm(gradient) + until.recip();
    let h = 1e-5 / scale;
    let change = space.carry(time, time + h) - space.carry(time, time - h);
    if norm(change) > 0.01 {
        return;
    }
    let difference = change * (0.5 / h);
    let varies = [time - h, time + h].map(|t| norm(at(space, t).gradient() - gradient));
    let error = norm(difference - gradient);
    let bound = 1e-6 * scale + varies[0] + varies[1] + roundings(space, &[time]) / h;
    assert!(error < bound, "gradient {gradient}, found {difference}");
}

/// The state at a time does not depend on the times before it, and the remaps on the way add up.
///
/// # Panics
/// If not, in any bit.
pub fn state_is_a_function_of_time<B: Boundary>(space: &B, [a, b, c]: [f64; 3], count: IVec3) {
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
///
/// # Panics
/// If not.
pub fn images_are_carried<B: Boundary>(space: &B, from: f64, to: f64) {
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
    let rounding = 1e-15 * norm(remap).powi(3);
    assert!((determinant - 1.0).abs() < 1e-6 + rounding, "{determinant}");
}

/// The volume of the cell changes by the determinant of the deformation.
///
/// # Panics
/// If not.
pub fn volume_is_carried<B: Boundary>(space: &B, from: f64, to: f64) {
    let volume = |time| at(space, time).cell().map(|h| h.determinant().abs());
    let (Some(before), Some(after)) = (volume(from), volume(to)) else {
        return;
    };
    let carry = space.carry(from, to);
    let error = (after / before - carry.determinant()).abs();
    let bound = roundings(space, &[from, to]) * norm(carry).powi(3);
    assert!(error < bound, "{before} became {after}");
}

/// A particle that follows the flow, wrapped and counted at each of the times, is where it would be without wrapping.
///
/// # Panics
/// If not.
pub fn counts_follow<B: Boundary>(space: &B, times: &[f64], r: DVec3) {
    let (Some(&start), Some(&end)) = (times.first(), times.last()) else {
        return;
    };
    let mut space = at(space, start);
    let (mut position, mut count) = space.wrap(r);
    let mut scale = 0.0;
    for (&from, &to) in times.iter().zip(&times[1..]) {
        let carried = space.carry(from, to) * position;
        // What is rounded here is carried on to the end.
        scale += norm(space.carry(from, end))
            * (position.length() + norm_of_cell(&space) * count.as_dvec3().length());
        let remap = space.advance(to);
        let (folded, taken) = space.wrap(carried);
        (position, count) = (folded, remap.apply(count) + taken);
    }
    let whole = space.carry(start, end) * r;
    let cell = space.cell().unwrap_or_default();
    scale += whole.length() + norm_of_cell(&space) * (1.0 + count.as_dvec3().length());
    let error = (position + cell * count.as_dvec3() - whole).length();
    let bound = roundings(&space, times) * scale;
    assert!(
        error < bound,
        "{start} to {end}: {error:e} beyond {bound:e}"
    );
}

/// Pairs do not feel the basis. Between two times their distance changes by no more than the deformation stretches,
/// remap or not; a pair in reach rides the flow, and its laboratory velocity difference changes by no more than the
/// gradient and the deformation do. With times close together on both sides of a remap this is continuity.
///
/// # Panics
/// If they do.
pub fn pairs_ride_the_flow<B: Boundary>(space: &B, from: f64, to: f64, [r, s]: [DVec3; 2]) {
    let (old, new) = (at(space, from), at(space, to));
    let (carry, back) = (space.carry(from, to), space.carry(to, from));
    let ride = |x: DVec3| new.wrap(carry * old.wrap(x).0).0;
    let before = old.min_image(r - s);
    let after = new.min_image(ride(r) - ride(s));
    let size = norm(carry) * (norm_of_cell(&old) + r.length() + s.length());
    let rounding = roundings(space, &[from, to]) * size;
    let strain = |f: DMat3| norm(f - DMat3::IDENTITY);
    let (d, d_after) = (before.length(), after.length());
    assert!(
        d_after <= (1.0 + strain(carry)) * d + rounding,
        "{d} became {d_after}"
    );
    assert!(
        d <= (1.0 + strain(back)) * d_after + rounding * norm(back),
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

/// If the basis changes between two times, the change is closed in on until 1e-9 of strain is left, and
/// [pairs ride the flow](pairs_ride_the_flow) through it: their distance and velocity go on to 1e-9, where an image lost
/// or a velocity shifted would show as a whole lattice vector.
///
/// # Panics
/// If they do not.
pub fn no_remap_is_felt<B: Boundary>(space: &B, mut from: f64, mut to: f64, [r, s]: [DVec3; 2]) {
    let changes = |from, to| at(space, from).advance(to) != Remap::None;
    if !changes(from, to) {
        return;
    }
    for _ in 0..60 {
        if norm(space.carry(from, to) - DMat3::IDENTITY) < 1e-9 {
            break;
        }
        let middle = 0.5 * (from + to);
        if changes(from, middle) {
            to = middle;
        } else {
            from = middle;
        }
    }
    pairs_ride_the_flow(space, from, to, [r, s]);
    let reach = at(space, from).reach();
    if reach.is_finite() {
        let near = 0.9 * reach * (s - r).normalize_or_zero();
        pairs_ride_the_flow(space, from, to, [r, r + near]);
    }
}

/// Wrapping twice is wrapping once, what is taken off is the count of lattice vectors, and no pair feels it.
///
/// # Panics
/// If not.
pub fn wrapping_is_invisible<B: Boundary>(space: &B, r: DVec3, s: DVec3) {
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

/// The reach is half the length of the shortest lattice vector, found among all sums of up to three vectors of a
/// reduced basis each, and an image separation is never longer than it need be.
///
/// # Panics
/// If not.
pub fn reach_is_half_the_shortest_vector<B: Boundary>(space: &B, r: DVec3) {
    let Some(cell) = space.cell() else {
        assert_eq!(space.reach(), f64::INFINITY);
        return;
    };
    let lattice = Lattice::new(cell);
    assert!(lattice.is_ok(), "{cell} is no cell");
    let cell = lattice.map_or(cell, |lattice| lattice.basis());
    let near = space.min_image(r);
    let mut shortest = f64::INFINITY;
    for n in (0..343).map(|k| IVec3::new(k % 7 - 3, k / 7 % 7 - 3, k / 49 - 3)) {
        let vector = cell * n.as_dvec3();
        if n != IVec3::ZERO {
            shortest = shortest.min(vector.length());
        }
        let longer = (near + vector).length() + 1e-12 * norm(cell);
        assert!(near.length() <= longer, "{near} is not the nearest");
    }
    let ratio = 2.0 * space.reach() / shortest;
    assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
}

/// The reach at a time is not below what was promised, to 1e-10.
///
/// # Panics
/// If it is.
pub fn reach_is_at_least<B: Boundary>(space: &B, time: f64, promised: f64) {
    let reach = at(space, time).reach();
    assert!(
        reach >= promised * (1.0 - 1e-10),
        "reach {reach} at time {time}, {promised} promised"
    );
}

/// A vector with components up to a limit.
pub fn vector(limit: f64) -> impl Strategy<Value = DVec3> {
    proptest::array::uniform3(-limit..limit).prop_map(DVec3::from_array)
}

/// Edges of a brick, 2 to 20.
pub fn edges() -> impl Strategy<Value = DVec3> {
    proptest::array::uniform3(2.0..20.0).prop_map(DVec3::from_array)
}

/// Three vectors that span a volume, in any shape, tilt and handedness.
pub fn basis() -> impl Strategy<Value = DMat3> {
    (frame(), edges(), oblique()).prop_map(|(frame, edges, oblique)| {
        let brick = DMat3::from_diagonal(edges);
        frame * oblique * brick
    })
}

/// A velocity gradient with entries up to a limit; of any kind, also one that changes volume.
pub fn gradient(limit: f64) -> impl Strategy<Value = DMat3> {
    matrix_of(limit)
}

/// Three axes that are perpendicular to each other, of either handedness.
pub fn frame() -> impl Strategy<Value = DMat3> {
    let angles = proptest::array::uniform3(0.0..std::f64::consts::TAU);
    (angles, proptest::bool::ANY).prop_map(|([a, b, c], mirrored)| {
        let turned =
            DMat3::from_rotation_z(a) * DMat3::from_rotation_x(b) * DMat3::from_rotation_z(c);
        let last = if mirrored {
            -turned.z_axis
        } else {
            turned.z_axis
        };
        DMat3::from_cols(turned.x_axis, turned.y_axis, last)
    })
}

/// Axes of volume 1 at angles down to some 20 degrees to each other.
pub fn oblique() -> impl Strategy<Value = DMat3> {
    vector(1.5).prop_map(|shear| {
        let second = DVec3::new(shear.x, 1.0, 0.0);
        DMat3::from_cols(DVec3::X, second, DVec3::new(shear.y, shear.z, 1.0))
    })
}

/// A rate of either sign, up to 10 per time.
pub fn rate() -> impl Strategy<Value = Steady> {
    (-10.0..10.0).prop_filter_map("finite", |rate| Steady::new(rate).ok())
}

/// A mixedness between 1e-3 and 1, small ones as likely as large ones.
pub fn mixedness() -> impl Strategy<Value = f64> {
    (0.0_f64..3.0).prop_map(|power| libm::pow(10.0, -power))
}

/// Any shear cell.
pub fn lees_edwards() -> impl Strategy<Value = LeesEdwards<Steady>> {
    (edges(), rate()).prop_filter_map("a cell", |(edges, rate)| LeesEdwards::new(edges, rate).ok())
}

/// Any planar extension, in any orientation.
pub fn kraynik_reinelt() -> impl Strategy<Value = KraynikReinelt<Steady>> {
    (edges(), rate(), frame()).prop_filter_map("a cell", |(edges, rate, frame)| {
        KraynikReinelt::new(edges.x, edges.z, rate)
            .ok()?
            .oriented(frame)
            .ok()
    })
}

/// Any planar mixed flow, in any orientation.
pub fn planar_mixed() -> impl Strategy<Value = PlanarMixed<Steady>> {
    (edges(), mixedness(), rate(), frame()).prop_filter_map(
        "a cell",
        |(edges, mixedness, rate, frame)| {
            let space = PlanarMixed::new(edges.x, edges.z, mixedness, rate);
            space.ok()?.oriented(frame).ok()
        },
    )
}

/// Any uniaxial or biaxial extension, in any orientation.
pub fn uniaxial() -> impl Strategy<Value = UniaxialExtension<Steady>> {
    (edges(), rate(), frame()).prop_filter_map("a cell", |(edges, rate, frame)| {
        UniaxialExtension::new(edges.x, rate)
            .ok()?
            .oriented(frame)
            .ok()
    })
}

/// Any extension along any three axes, oblique ones among them.
pub fn triaxial() -> impl Strategy<Value = TriaxialFlow<Steady>> {
    (edges(), vector(1.0), oblique(), rate(), frame()).prop_filter_map(
        "a cell",
        |(edges, stretch, axes, rate, frame)| {
            let stretch = DVec3::new(stretch.x, stretch.y, -(stretch.x + stretch.y));
            let space = TriaxialFlow::new(edges.x, stretch, axes, rate);
            space.ok()?.oriented(frame).ok()
        },
    )
}

fn matrix_of(limit: f64) -> impl Strategy<Value = DMat3> {
    proptest::array::uniform9(-limit..limit).prop_map(|entries| DMat3::from_cols_array(&entries))
}

/// The matrix that a remap applies to counts.
fn matrix(remap: Remap) -> DMat3 {
    let column = |unit: IVec3| remap.apply(unit).as_dvec3();
    DMat3::from_cols(column(IVec3::X), column(IVec3::Y), column(IVec3::Z))
}

/// What rounding may do to something of size 1 at any of these times: some hundred units in the last place of it and
/// of the strain, which is about the rate times the time, and as many times more as the cell is flat.
fn roundings<B: Boundary>(space: &B, times: &[f64]) -> f64 {
    let at_one = |&time: &f64| {
        let now = at(space, time);
        let flatness = now.cell().map_or(1.0, |h| norm(h) * norm(h.inverse()));
        (1e-13 + 2e-15 * norm(now.gradient()) * time.abs()) * flatness
    };
    times.iter().map(at_one).fold(0.0, f64::max)
}

fn norm_of_cell<B: Boundary>(space: &B) -> f64 {
    space.cell().map_or(0.0, norm)
}

/// Frobenius norm: it bounds every stretch and every product.
fn norm(m: DMat3) -> f64 {
    let squares = m.to_cols_array().map(|x| x * x);
    squares.iter().sum::<f64>().sqrt()
}
