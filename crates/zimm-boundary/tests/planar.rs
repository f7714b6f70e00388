//! Planar extension and mixed flow against reference numbers, closed forms and hostile input.

#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

mod common;

use common::{at, holds_vector, json, norm, number, scattered};
use proptest::prelude::*;
use zimm_boundary::{
    Cessation, FlowError, FlowHistory, KraynikReinelt, LatticeFlow, LeesEdwards, MixedRates,
    PlanarMap, PlanarMixed, StartUp, Steady, Then, laws,
};
use zimm_core::{Boundary, DMat3, DVec3, IVec3, Periodic, Remap};

/// ln((3 + sqrt 5) / 2).
const CLASSIC_PERIOD: f64 = 0.962_423_650_119_206_9;

fn extension(edge: f64) -> KraynikReinelt<Steady> {
    KraynikReinelt::new(edge, edge, Steady::new(1.0).unwrap()).unwrap()
}

/// The flow of a shear rate and an extension rate of 1, in a cell of unit area; `None` takes the best map.
fn mixed(shear_per_extension: f64, map: Option<PlanarMap>) -> PlanarMixed<Steady> {
    let rates = MixedRates {
        shear_rate: shear_per_extension,
        extension_rate: 1.0,
    };
    let history = Steady::new(rates.strain_rate()).unwrap();
    let map = map.unwrap_or(PlanarMap::best(rates.mixedness()));
    PlanarMixed::with_map(map, 1.0, 2.0, rates.mixedness(), history).unwrap()
}

/// How long before the time at which our cell starts that of Hunt et al. does, at an extension rate of 1: theirs is as
/// long along the one axis as along the other, with axes of the lengths 1 and sqrt(1 + s^2), ours is shortest.
fn head_start(mixedness: f64) -> f64 {
    0.25 * (0.25 * (1.0 + mixedness).powi(2) / mixedness).ln()
}

fn vector(row: &serde_json::Value) -> DVec3 {
    DVec3::new(number(&row[0]), number(&row[1]), 0.0)
}

/// The published angles and periods (Kraynik and Reinelt 1992; Todd and Daivis 1998).
#[test]
fn reference_magic_angles() {
    for (trace, n11, period, angle) in [
        (3, 2, 0.962424, 31.7175),
        (6, 5, 1.762747, 22.5),
        (11, 10, 2.389526, 16.8450),
        (15, 10, 2.703576, 35.1731),
        (15, 13, 2.703576, 21.1368),
    ] {
        let map = PlanarMap::square(trace, n11).unwrap();
        assert!((map.hencky_period() - period).abs() < 1e-6);
        let space = KraynikReinelt::with_map(map, 1.0, 1.0, ()).unwrap();
        let side = DMat3::from_rotation_z(f64::to_radians(angle)) * DVec3::X;
        assert!(space.min_image(side).length() < 1e-6, "{trace} {n11}");
    }
}

/// All square lattices with k up to 120: maps, periods, angles, how close images come, and that the maps are those that
/// the flow makes.
#[test]
fn reference_square_lattices() {
    let mut rows = 0;
    for line in include_str!("data/planar_square_lattices.csv")
        .lines()
        .skip(1)
    {
        let numbers: Vec<f64> = line
            .split(',')
            .take(12)
            .map(|x| x.parse().unwrap())
            .collect();
        let [k, n11, n12, n21, n22, stretch, period, angle, .., closest] = numbers[..] else {
            panic!("{line}")
        };
        let map = PlanarMap::square(k as i64, n11 as i64).unwrap();
        let found = map.rows().map(|row| row.map(|n| n as f64));
        assert_eq!(found, [[n11, n12], [n21, n22]]);
        assert!((map.hencky_period() / period - 1.0).abs() < 1e-15, "{line}");
        assert!(
            (map.min_image_distance(1.0) - closest).abs() < 1e-15,
            "{line}"
        );

        let space = KraynikReinelt::with_map(map, 1.0, 2.0, Steady::new(1.0).unwrap()).unwrap();
        let sides = DMat3::from_rotation_z(angle);
        for side in [sides.x_axis, sides.y_axis] {
            assert!(space.min_image(side).length() < 1e-15, "{line}");
        }
        let carried = space.carry(0.0, period) * sides;
        let mapped = sides * DMat3::from_cols_array(&[n11, n12, 0.0, n21, n22, 0.0, 0.0, 0.0, 1.0]);
        for (a, b) in carried
            .to_cols_array()
            .into_iter()
            .zip(mapped.to_cols_array())
        {
            assert!((a - b).abs() < 1e-14 * stretch, "{line}");
        }
        let scan = |j: u32| 2.0 * at(&space, period * f64::from(j) / 1000.0).reach();
        let least = (0..1000).map(scan).fold(f64::INFINITY, f64::min);
        assert!(
            (-1e-14..1e-3).contains(&(least / closest - 1.0)),
            "{line}: {least}"
        );
        rows += 1;
    }
    assert_eq!(rows, 47);
}

/// The best lattice of each trace up to 40, most of them not square.
#[test]
fn reference_best_lattices_of_each_trace() {
    let table = json(include_str!("data/planar_best_lattices.json"));
    let rows = table["rows"].as_array().unwrap();
    for row in rows {
        let entry = |name: &str| row[name].as_i64().unwrap();
        let map =
            PlanarMap::new([[entry("N11"), entry("N12")], [entry("N21"), entry("N22")]]).unwrap();
        assert_eq!(map.trace(), entry("k"));
        assert!((map.hencky_period() / number(&row["eps_p"]) - 1.0).abs() < 1e-15);
        let square = map.min_image_distance(1.0).powi(2);
        assert!((square - number(&row["Dmin2"])).abs() < 1e-15, "{row}");
        let space = KraynikReinelt::with_map(map, 1.0, 1.0, Steady::new(1.0).unwrap()).unwrap();
        let period = map.hencky_period();
        let scan = |j: u32| 2.0 * at(&space, period * f64::from(j) / 1000.0).reach();
        let least = (0..1000).map(scan).fold(f64::INFINITY, f64::min);
        let closest = space.min_image_distance();
        assert!(
            (-1e-14..1e-3).contains(&(least / closest - 1.0)),
            "{row}: {least}"
        );
    }
    assert_eq!(rows.len(), 38);
}

/// The cells of Hunt, Bernardi and Todd, k = 3, and the best ones up to trace 40, for ten ratios of shear rate to
/// extension rate up to 100.
#[test]
fn reference_mixed_lattices() {
    let table = json(include_str!("data/planar_mixed_lattices.json"));
    for row in table["rows"].as_array().unwrap() {
        let ratio = number(&row["gamma_over_eps"]);
        let space = mixed(ratio, Some(PlanarMap::CLASSIC));
        let mixedness = space.mixedness();
        assert!((mixedness / number(&row["chi"]) - 1.0).abs() < 1e-14);
        let strain_rate = space.history().rate(0.0);
        assert!((strain_rate / number(&row["Gamma_over_eps"]) - 1.0).abs() < 1e-14);
        assert_eq!(space.map().rows(), [[2, -1], [-1, 1]]);
        assert!((space.min_image_distance() - number(&row["Dmin"])).abs() < 1e-14);

        // Hunt's basis is of vectors of our lattice, of unit area, and returns as told.
        let start = at(&space, -head_start(mixedness));
        let [a, b] = [0, 1].map(|k| vector(&row["L0"][k]));
        for side in [a, b] {
            assert!(holds_vector(&start, side, 1e-13), "{ratio}: {side}");
        }
        assert!(((a.x * b.y - a.y * b.x) - 1.0).abs() < 1e-12 * a.length() * b.length());
        let carry = space.carry(0.0, number(&row["eps_tau"]));
        for (side, mapped) in [(a, 2.0 * a - b), (b, b - a)] {
            let error = (carry * side - mapped).length();
            assert!(
                error < 1e-13 * norm(carry) * side.length(),
                "{ratio}: {error:e}"
            );
        }

        let best = mixed(ratio, None).min_image_distance();
        assert!(
            best >= number(&row["best"]["Dmin"]) - 1e-14,
            "{ratio}: {best}"
        );
        for named in ["best", "robinson"] {
            let rows = [0, 1].map(|k| [0, 1].map(|l| row[named]["N"][k][l].as_i64().unwrap()));
            let [[a, b], [c, d]] = rows;
            // The table does not say which of two mirror images it means.
            let distance = [[[a, b], [c, d]], [[a, -b], [-c, d]]]
                .map(|rows| PlanarMap::new(rows).unwrap().min_image_distance(mixedness));
            let found = distance[0].max(distance[1]);
            assert!(
                (found - number(&row[named]["Dmin"])).abs() < 1e-14,
                "{ratio}"
            );
        }
    }
}

/// Cells of Hunt et al. at ten times up to 7.77 periods, remapped and not: all of their vectors are ours, and the
/// shortest one is as short.
#[test]
fn reference_mixed_trajectory() {
    let table = json(include_str!("data/planar_mixed_trajectory.json"));
    let rows = table["rows"].as_array().unwrap();
    for row in rows {
        let space = mixed(number(&row["gamma_over_eps"]), Some(PlanarMap::CLASSIC));
        let time = CLASSIC_PERIOD * number(&row["t_over_tau"]) - head_start(space.mixedness());
        let space = at(&space, time);
        for name in ["cell_unremapped", "cell_remapped"] {
            for k in 0..2 {
                assert!(holds_vector(&space, vector(&row[name][k]), 1e-13), "{row}");
            }
        }
        let error = space.lattice().shortest() - number(&row["shortest_vector"]);
        assert!(error.abs() < 1e-13, "{row}: {error:e}");
    }
    assert_eq!(rows.len(), 40);
}

/// The least distance between opposite faces over a period: 0.4472 and 0.7071 of the edge in the cell that is carried
/// and never reduced, and, reduced at each time, the numbers published for mixed flow. Images are 0.9457 apart.
#[test]
fn reference_heights_of_the_cell() {
    let space = extension(1.0);
    let start = DMat3::from_rotation_z(31.717474411461005_f64.to_radians());
    let mut least = DVec3::INFINITY;
    let (mut widths, mut shortest) = (f64::INFINITY, f64::INFINITY);
    for j in 0..=4000 {
        let time = CLASSIC_PERIOD * f64::from(j) / 4000.0;
        let rows = (space.carry(0.0, time) * start).inverse().transpose();
        least = least.min(DVec3::new(
            rows.x_axis.length().recip(),
            rows.y_axis.length().recip(),
            1.0,
        ));
        let now = at(&space, time);
        widths = now.lattice().widths().min_element().min(widths);
        shortest = now.lattice().shortest().min(shortest);
        assert!((now.lattice().volume() - 1.0).abs() < 1e-15);
    }
    let (low, high) = (least.x.min(least.y), least.x.max(least.y));
    assert!((low - 0.2_f64.sqrt()).abs() < 1e-12 && (high - 0.5_f64.sqrt()).abs() < 1e-12);
    assert!((widths - 0.8633).abs() < 6e-5 && (shortest - 0.9457).abs() < 5e-5);

    for (ratio, height) in [
        (0.1, 0.8488),
        (0.25, 0.8265),
        (0.5, 0.7890),
        (1.0, 0.7166),
        (1.5, 0.6526),
        (2.0, 0.5985),
        (3.0, 0.5157),
        (5.0, 0.4135),
        (10.0, 0.2973),
        (20.0, 0.2112),
        (50.0, 0.1337),
        (100.0, 0.0946),
    ] {
        let space = mixed(ratio, Some(PlanarMap::CLASSIC));
        let width = |j: u32| {
            let time = CLASSIC_PERIOD * f64::from(j) / 4000.0;
            at(&space, time).lattice().widths().min_element()
        };
        let least = (0..4000).map(width).fold(f64::INFINITY, f64::min);
        assert!((least - height).abs() < 1e-4, "{ratio}: {least}");
    }
}

/// D = L (4 chi / 5)^(1/4) for the lattice with k = 3, at every ratio of the rates.
#[test]
fn limit_classic_lattice_in_mixed_flow() {
    for ratio in [0.0, 0.1, 0.5, 1.0, 2.0, 5.0, 20.0, 100.0] {
        let space = mixed(ratio, Some(PlanarMap::CLASSIC));
        let expected = (0.8 * space.mixedness()).powf(0.25);
        assert!((space.min_image_distance() - expected).abs() < 1e-15);
    }
}

#[test]
fn reference_strain_rate_and_mixedness() {
    for (extension_rate, shear_rate, mixedness, strain_rate) in [
        (1.0, 1.0, 0.381966, 1.618034),
        (0.7, 3.0, 0.049217, 3.155295),
        (1.0, 0.0, 1.0, 1.0),
        (0.0, 2.0, 0.0, 2.0),
    ] {
        let rates = MixedRates {
            shear_rate,
            extension_rate,
        };
        assert!((rates.mixedness() - mixedness).abs() < 1e-6);
        assert!((rates.strain_rate() - strain_rate).abs() < 1e-6);
    }
}

proptest! {
    #[test]
    fn law_rates_convert_to_and_fro(mixedness in laws::mixedness(), strain_rate in 0.1..10.0) {
        let rates = MixedRates::from_strain_rate(strain_rate, mixedness);
        prop_assert!((rates.mixedness() / mixedness - 1.0).abs() < 1e-14);
        prop_assert!((rates.strain_rate() / strain_rate - 1.0).abs() < 1e-14);
        // Fuller and Leal's form, turned by atan(sqrt(chi)).
        let mut form = DMat3::ZERO;
        (form.y_axis.x, form.x_axis.y) = (strain_rate, strain_rate * mixedness);
        let turn = DMat3::from_rotation_z(mixedness.sqrt().atan());
        let turned = turn.transpose() * form * turn;
        let space = PlanarMixed::new(1.0, 1.0, mixedness, Steady::new(strain_rate).unwrap()).unwrap();
        let error = (space.gradient() - turned).to_cols_array().map(f64::abs);
        prop_assert!(error.into_iter().fold(0.0, f64::max) < 1e-14 * strain_rate);
    }

    /// Rates of either sign give the velocity gradient asked for.
    #[test]
    fn law_rates_of_either_sign(shear_rate in -5.0..5.0, extension_rate in -2.0..2.0) {
        let rates = MixedRates { shear_rate, extension_rate };
        prop_assume!(rates.mixedness() > 2e-5);
        let space = PlanarMixed::from_rates(10.0, 10.0, rates).unwrap();
        let mut expected = DMat3::from_diagonal(DVec3::new(extension_rate, -extension_rate, 0.0));
        expected.y_axis.x = shear_rate;
        let error = (space.gradient() - expected).to_cols_array().map(f64::abs);
        prop_assert!(error.into_iter().fold(0.0, f64::max) < 1e-14 * (shear_rate.abs() + 1.0));
    }

    /// A box made for a cutoff holds it at all times, and no smaller one of its kind does.
    #[test]
    fn law_boxes_for_a_cutoff(cutoff in 0.1..10.0, mixedness in laws::mixedness()) {
        let history = Steady::new(1.0).unwrap();
        let planar = KraynikReinelt::box_for_cutoff(cutoff, history).unwrap();
        fits(&planar, planar.map().hencky_period(), cutoff)?;
        let mixed = PlanarMixed::box_for_cutoff(cutoff, mixedness, history).unwrap();
        fits(&mixed, mixed.map().hencky_period() / mixedness.sqrt(), cutoff)?;
    }
}

fn fits<F: Clone + Send + Sync>(
    space: &LatticeFlow<F, Steady>,
    period: f64,
    cutoff: f64,
) -> Result<(), TestCaseError> {
    let distance = space.min_image_distance();
    prop_assert!((distance / (2.0 * cutoff) - 1.0 - 1e-12).abs() < 1e-14);
    let reach = |j: u32| at(space, period * f64::from(j) / 500.0).reach();
    let least = (0..500).map(reach).fold(f64::INFINITY, f64::min);
    prop_assert!(least >= cutoff);
    prop_assert!(least < 1.1 * cutoff, "{least} against {cutoff}");
    Ok(())
}

/// At mixedness 1 the two cells are one, and on the way there nothing jumps: the lattices differ by what the shear of
/// 1 - chi does in a period.
#[test]
fn limit_mixedness_one_is_kraynik_reinelt() {
    let planar = extension(10.0);
    let space =
        |mixedness| PlanarMixed::new(10.0, 10.0, mixedness, Steady::new(1.0).unwrap()).unwrap();
    for step in 0..100 {
        let time = 0.17 * f64::from(step);
        let (a, b) = (at(&planar, time), at(&space(1.0), time));
        assert_eq!((a.cell(), a.gradient()), (b.cell(), b.gradient()));
    }
    assert_eq!(space(1.0).min_image_distance(), planar.min_image_distance());
    for power in [3, 6, 9, 12] {
        let little = 0.1_f64.powi(power);
        let near = space(1.0 - little);
        let change = near.min_image_distance() / planar.min_image_distance() - 1.0;
        assert!(change.abs() < little, "{change:e}");
        for step in 0..100 {
            let time = 0.017 * f64::from(step);
            let (a, b) = (at(&planar, time), at(&near, time));
            let basis = a.lattice().basis();
            for side in [basis.x_axis, basis.y_axis, basis.z_axis] {
                assert!(b.min_image(side).length() < 30.0 * little);
            }
        }
    }
}

/// Towards shear the flow becomes that of Lees and Edwards, the cell cannot: images come as close as Segre's bound says.
#[test]
fn limit_mixedness_zero_is_shear_without_its_cell() {
    let shear = LeesEdwards::new(DVec3::ONE, Steady::new(1.0).unwrap()).unwrap();
    for power in 1..=5 {
        let mixedness = 0.1_f64.powi(power).max(1.0001e-5);
        let space = PlanarMixed::new(1.0, 1.0, mixedness, Steady::new(1.0).unwrap()).unwrap();
        let (a, b) = (space.carry(0.0, 2.0), shear.carry(0.0, 2.0));
        assert!(norm(a - b) < 5.0 * mixedness.sqrt());
        let bound = (2.0 * (mixedness / (1.0 + 4.0 * mixedness)).sqrt()).sqrt();
        assert!((space.min_image_distance() / bound - 1.0).abs() < 1e-5);
    }
    for mixedness in [0.0, 1e-12, 0.99e-5] {
        let refused = PlanarMixed::new(1.0, 1.0, mixedness, ()).unwrap_err();
        assert!(matches!(
            refused,
            FlowError::NearlyShear { least: 1e-5, .. }
        ));
        assert!(refused.to_string().contains("Lees-Edwards"), "{refused}");
    }
}

/// D^2 is at most 2 sqrt(chi / (1 + 4 chi)) of the area (Segre 1945), which is reached where 1 / chi is an integer; and
/// as a function of chi it has no jumps.
#[test]
fn limit_best_lattices_in_mixed_flow() {
    let distance = |mixedness: f64| PlanarMap::best(mixedness).min_image_distance(mixedness);
    let bound = |mixedness: f64| (2.0 * (mixedness / (1.0 + 4.0 * mixedness)).sqrt()).sqrt();
    for t in 1..1000 {
        let mixedness = f64::from(t).recip();
        assert!((distance(mixedness) / bound(mixedness) - 1.0).abs() < 1e-14);
    }
    let mut before = distance(1.0);
    for step in 0..40_000 {
        let mixedness = 10_f64.powf(-f64::from(step) * 1e-4);
        let here = distance(mixedness);
        assert!(here <= bound(mixedness) * (1.0 + 1e-14));
        assert!(here > 0.92 * bound(mixedness), "{mixedness}: {here}");
        assert!((here / before - 1.0).abs() < 2e-4, "a jump at {mixedness}");
        before = here;
    }
}

/// No lattice whose continued fraction has a period of up to six quotients (three of up to 4 and three of up to 40)
/// keeps images further apart by more than the 2e-4 that are given away. Here the least values of the form come from
/// the continued fraction itself: those of one sign are sqrt(k^2 - 4) / (a_i + [0; a_i+1, ...] + [0; a_i-1, ...]).
#[test]
fn law_no_periodic_lattice_is_better() {
    fn continued(quotients: &[f64], from: usize, step: usize) -> f64 {
        let n = quotients.len();
        (1..=30).rev().fold(0.0, |tail, k| {
            1.0 / (quotients[(from + step * k) % n] + tail)
        })
    }
    fn square(quotients: &[f64], mixedness: f64) -> f64 {
        let n = quotients.len();
        let mut most = [0.0_f64; 2];
        for k in 0..n {
            let sum = quotients[k] + continued(quotients, k, 1) + continued(quotients, k, n - 1);
            most[k % 2] = most[k % 2].max(sum);
        }
        2.0 * (mixedness.sqrt() / most[0]).min(1.0 / (mixedness.sqrt() * most[1]))
    }
    for mixedness in [1.0, 0.9, 0.7, 0.6, 0.45, 0.38, 0.28, 0.17, 0.11, 0.06, 0.03] {
        let best = PlanarMap::best(mixedness)
            .min_image_distance(mixedness)
            .powi(2);
        let turns = 1.0 / mixedness;
        let odd: Vec<f64> = (1..=40)
            .map(f64::from)
            .filter(|b| (b - turns).abs() < 3.0)
            .collect();
        let pairs: Vec<[f64; 2]> = (1..=4)
            .flat_map(|a| odd.iter().map(move |&b| [f64::from(a), b]))
            .collect();
        for one in &pairs {
            assert!(square(one, mixedness) < best * (1.0 + 4e-4));
            for two in &pairs {
                assert!(square(&[*one, *two].concat(), mixedness) < best * (1.0 + 4e-4));
                for three in &pairs {
                    let found = square(&[*one, *two, *three].concat(), mixedness);
                    assert!(
                        found < best * (1.0 + 4e-4),
                        "{mixedness}: {one:?} {two:?} {three:?}"
                    );
                }
            }
        }
    }
}

/// 500 particles in the cell just before and just after each of the changes of basis in a period: the same neighbours
/// at the same distances, and the same virial of a soft repulsion. Between the two is 1e-12 of strain.
#[test]
fn law_nothing_changes_at_a_remap() {
    let edge = 10.0;
    let space = extension(edge);
    let changes = |from, to| at(&space, from).advance(to) != Remap::None;
    let mut remaps = 0;
    for step in 0..100 {
        let [mut from, mut to] = [step, step + 1].map(|k| CLASSIC_PERIOD * f64::from(k) / 100.0);
        if !changes(from, to) {
            continue;
        }
        while to - from > 1e-12 {
            let middle = 0.5 * (from + to);
            if changes(from, middle) {
                to = middle;
            } else {
                from = middle;
            }
        }
        same_at(&space, from, to, 0.47 * edge);
        remaps += 1;
    }
    assert!(remaps > 0);
}

fn same_at(space: &KraynikReinelt<Steady>, from: f64, to: f64, range: f64) {
    let near = |space: &KraynikReinelt<Steady>, points: &[DVec3]| {
        let mut found = Vec::new();
        let mut virial = DMat3::ZERO;
        for i in 0..points.len() {
            for j in i + 1..points.len() {
                let r = space.min_image(points[i] - points[j]);
                if r.length() < range {
                    found.push((i, j, r.length()));
                }
                let force = (3.0 - r.length()).max(0.0);
                virial += force * DMat3::from_cols(r.x * r, r.y * r, r.z * r);
            }
        }
        (found, virial)
    };
    let (before, after) = (at(space, from), at(space, to));
    let points = scattered(before.lattice(), 500);
    let carry = space.carry(from, to);
    let moved: Vec<DVec3> = points.iter().map(|&r| after.wrap(carry * r).0).collect();
    let ((pairs, virial), (pairs_after, virial_after)) =
        (near(&before, &points), near(&after, &moved));
    assert!(pairs.len() > 40_000 && norm(virial) > 10.0);
    assert_eq!(pairs.len(), pairs_after.len());
    for ((i, j, d), (i_after, j_after, d_after)) in pairs.into_iter().zip(pairs_after) {
        assert_eq!((i, j), (i_after, j_after));
        assert!((d - d_after).abs() < 1e-10);
    }
    assert!(norm(virial - virial_after) < 1e-10 * norm(virial));
}

/// The Hencky strain modulo the period in integers, in units of 1e-20; the strain has to be a multiple of 2^-40.
fn exact_phase(hencky: f64, period: i128) -> f64 {
    const UNIT: i128 = 100_000_000_000_000_000_000;
    let bits = (hencky * f64::from(2).powi(40)) as i128;
    let strain = bits * (UNIT >> 40) + ((bits * (UNIT % (1 << 40))) >> 40);
    let phase = (strain + period / 2).rem_euclid(period) - period / 2;
    phase as f64 / UNIT as f64
}

/// Ten thousand periods, twenty steps each: the lattice is that of the closed form, in which integers know the phase to
/// 1e-16 and hyperbolic functions the deformation, to 1e-9 of it. The volume is that of the start, the set of images is
/// the same after each step, remap or not, and beads that are carried stay in the cell. Periods have 20 digits, roots
/// of the mixedness and strains are exact in binary.
#[test]
fn law_nothing_drifts_in_ten_thousand_periods() {
    for (root, trace, period) in [
        (1.0, 3, 96_242_365_011_920_689_500),
        (0.5, 6, 176_274_717_403_908_605_047),
        (0.25, 18, 288_727_095_035_762_068_499),
        (0.125, 66, 418_942_509_452_220_258_849),
    ] {
        let mixedness = root * root;
        let mut space = PlanarMixed::new(1.0, 1.5, mixedness, Steady::new(1.0).unwrap()).unwrap();
        assert_eq!(space.map().trace(), trace);
        let start = space.lattice().basis();
        let mut beads = scattered(space.lattice(), 20);
        let mut counts = vec![IVec3::ZERO; beads.len()];
        // A twentieth of a period in Hencky strain, as a multiple of 2^-40.
        let step = (space.map().hencky_period() / 20.0 * 1e6).floor() / f64::from(1 << 20);
        let (mut time, mut remaps) = (0.0, 0);
        for k in 1..=200_000 {
            let hencky = step * f64::from(k);
            let to = hencky / root;
            let before = space.clone();
            let carry = space.carry(time, to);
            let remap = space.advance(to);
            remaps += u32::from(remap != Remap::None);
            let mut phase = DMat3::IDENTITY;
            let exact = exact_phase(hencky, period);
            (phase.x_axis.x, phase.y_axis.y) = (exact.exp(), (-exact).exp());
            phase.y_axis.x = (1.0 - mixedness) / root * exact.sinh();
            assert_same_lattice(space.lattice().basis(), phase * start, 1e-9);
            assert_same_lattice(
                space.lattice().basis(),
                carry * before.lattice().basis(),
                1e-9,
            );
            assert!((space.lattice().volume() / 1.5 - 1.0).abs() < 1e-12);
            for (bead, count) in beads.iter_mut().zip(&mut counts) {
                let (folded, taken) = space.wrap(carry * *bead);
                // Counts of what diverges have no meaning after a while, and do no harm.
                (*bead, *count) = (folded, remap.apply(*count).wrapping_add(taken));
                let fraction = (space.lattice().inverse() * *bead).abs().max_element();
                assert!(fraction <= 0.5 + 1e-12);
            }
            time = to;
        }
        assert!(remaps >= 9_000, "{remaps}");
    }
}

/// Between two bases of a lattice there is an integer matrix of determinant +-1.
fn assert_same_lattice(a: DMat3, b: DMat3, tolerance: f64) {
    let between = a.inverse() * b;
    let whole = between.to_cols_array().map(f64::round);
    let error = norm(between - DMat3::from_cols_array(&whole));
    assert!(error < tolerance * norm(between), "{between}: {error:e}");
    assert_eq!(DMat3::from_cols_array(&whole).determinant().abs(), 1.0);
}

/// Steps in which a dumbbell is carried and its spring relaxes towards the length 1, all rates 1, the spring's 3; the
/// bond settles at x = 3 / (3 - 1) of its natural length, and exactly so in these steps at the value given.
struct Dumbbell {
    beads: [DVec3; 2],
}

impl Dumbbell {
    const STEP: f64 = CLASSIC_PERIOD / 50.0;

    /// The fixed point of x -> e^h (x - 3 h (x - 1)).
    fn settled() -> f64 {
        let (grow, pull) = (Self::STEP.exp(), 3.0 * Self::STEP);
        grow * pull / (1.0 - grow * (1.0 - pull))
    }

    /// One step, given the vector from the second bead to the first.
    fn step(&mut self, bond: DVec3, carry: DMat3) {
        let pull = 1.5 * Self::STEP * (bond - DVec3::X);
        let [first, second] = self.beads;
        self.beads = [carry * (first - pull), carry * (second + pull)];
    }
}

/// The naive scheme keeps the coordinates of beads as the flow carries them: they grow by e^0.96 = 2.6 a period, and after
/// ln(2 / (2^-52 L / 2)) / 0.96 = 36 periods for L = 15 a box is no more than a unit in their last place. Bonds are then
/// noise, without any sign of an error. Wrapped into the cell, beads and bonds are as good after ten thousand periods.
#[test]
fn extreme_coordinates_that_are_never_wrapped_blow_up() {
    let edge = 15.0;
    let mut space = extension(edge);
    let beads = [
        DVec3::new(0.5 * edge, 1.0, 1.0),
        DVec3::new(0.5 * edge - 1.0, 1.0, 1.0),
    ];
    let (mut naive, mut wrapped) = (Dumbbell { beads }, Dumbbell { beads });
    let settled = Dumbbell::settled();
    let mut first_wrong = None;
    for k in 1..=500_000 {
        let [from, to] = [k - 1, k].map(|k| Dumbbell::STEP * f64::from(k));
        let carry = space.carry(from, to);
        if first_wrong.is_none() {
            let bond = naive.beads[0] - naive.beads[1];
            naive.step(bond, carry);
            let period = k / 50;
            if k > 1000 && (bond.length() - settled).abs() > 0.1 * settled {
                first_wrong = Some(period);
            }
        }
        let bond = space.min_image(wrapped.beads[0] - wrapped.beads[1]);
        if k > 1000 {
            assert!((bond.length() - settled).abs() < 1e-11, "{k}: {bond}");
        }
        wrapped.step(bond, carry);
        space.advance(to);
        wrapped.beads = wrapped.beads.map(|bead| space.wrap(bead).0);
        assert!(wrapped.beads[0].length() < 1.1 * edge);
    }
    let period = first_wrong.unwrap();
    assert!((25..=36).contains(&period), "wrong after {period} periods");
}

/// Stopped, started again, slowed down and reversed, the lattice is that of the strain.
#[test]
fn law_histories_keep_the_lattice() {
    let steady = PlanarMixed::new(10.0, 8.0, 0.3, Steady::new(1.0).unwrap()).unwrap();
    let stop = Cessation::new(1.0, 7.0).unwrap();
    let again = Then::new(stop, 9.0, Steady::new(0.25).unwrap()).unwrap();
    let back = Then::new(again, 13.0, Steady::new(-2.0).unwrap()).unwrap();
    let space = PlanarMixed::new(10.0, 8.0, 0.3, back).unwrap();
    for (time, strain) in [
        (5.0, 5.0),
        (7.0, 7.0),
        (8.5, 7.0),
        (9.0, 7.0),
        (11.0, 7.5),
        (13.0, 8.0),
        (16.0, 2.0),
    ] {
        assert_eq!(at(&space, time).cell(), at(&steady, strain).cell());
    }

    let late = PlanarMixed::new(10.0, 8.0, 0.3, StartUp::new(1.0, 4.0).unwrap()).unwrap();
    assert_eq!(at(&late, 9.0).cell(), at(&steady, 5.0).cell());
    let resumed = at(&steady, 5.0)
        .resumed(steady.shape(), Steady::new(0.5).unwrap())
        .unwrap();
    assert_eq!(resumed.cell(), at(&steady, 5.0).cell());
    assert_eq!(at(&resumed, 7.0).cell(), at(&steady, 6.0).cell());
    assert_eq!(at(&resumed, 7.0).gradient(), 0.5 * steady.shape());
}

/// A lattice made for one flow is refused to others, and the refusal says which.
#[test]
fn extreme_flows_that_do_not_return_the_lattice() {
    let space = at(
        &PlanarMixed::new(10.0, 8.0, 0.3, Steady::new(1.0).unwrap()).unwrap(),
        2.0,
    );
    let planar = KraynikReinelt::new(10.0, 8.0, ()).unwrap();
    let turned = space
        .clone()
        .oriented(DMat3::from_rotation_z(1e-6))
        .unwrap();
    let nearly = PlanarMixed::new(10.0, 8.0, 0.3 + 1e-9, ()).unwrap();
    for shape in [
        planar.shape(),
        turned.shape(),
        nearly.shape(),
        -space.shape(),
        DMat3::NAN,
    ] {
        let refused = space.resumed(shape, Steady::new(1.0).unwrap()).unwrap_err();
        let FlowError::OtherFlow { found, expected } = &refused else {
            panic!("{refused}")
        };
        assert_eq!(expected[..], space.shape().to_cols_array());
        assert!(
            found
                .iter()
                .zip(shape.to_cols_array())
                .all(|(a, b)| a.to_bits() == b.to_bits())
        );
        assert!(refused.to_string().contains("would not be reproduced"));
    }
    // Extension at mixedness 1 is one flow under both names.
    let same = PlanarMixed::new(10.0, 8.0, 1.0, ()).unwrap();
    assert!(planar.resumed(same.shape(), ()).is_ok());
}

#[test]
fn extreme_parameters_are_refused() {
    for mixedness in [-1e-9, -0.5, -1.0, f64::NEG_INFINITY] {
        let refused = PlanarMixed::new(10.0, 10.0, mixedness, ()).unwrap_err();
        assert_eq!(refused, FlowError::Elliptic { mixedness });
        assert!(refused.to_string().contains("elliptic"));
        assert!(PlanarMixed::box_for_cutoff(1.0, mixedness, ()).is_err());
    }
    for mixedness in [1.0 + 1e-9, f64::NAN, f64::INFINITY] {
        let FlowError::Parameter(refused) =
            PlanarMixed::new(10.0, 10.0, mixedness, ()).unwrap_err()
        else {
            panic!("{mixedness}")
        };
        assert_eq!(refused.name, "mixedness");
    }
    for edge in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let name = |result: Result<KraynikReinelt<()>, FlowError>| match result.unwrap_err() {
            FlowError::Parameter(refused) => refused.name,
            other => panic!("{other}"),
        };
        assert_eq!(
            name(KraynikReinelt::new(edge, 1.0, ())),
            "edge in the plane"
        );
        assert_eq!(name(KraynikReinelt::new(1.0, edge, ())), "neutral edge");
        assert!(KraynikReinelt::box_for_cutoff(edge, ()).is_err());
        assert!(PlanarMixed::new(edge, 1.0, 0.5, ()).is_err());
        assert!(PlanarMixed::box_for_cutoff(edge, 0.5, ()).is_err());
    }
    assert!(KraynikReinelt::new(1e-200, 1e200, ()).is_err());
    for (shear_rate, extension_rate) in [
        (0.0, 0.0),
        (f64::NAN, 1.0),
        (1.0, f64::INFINITY),
        (1.0, 0.0),
    ] {
        let rates = MixedRates {
            shear_rate,
            extension_rate,
        };
        assert!(PlanarMixed::from_rates(10.0, 10.0, rates).is_err());
    }
    let axes = DMat3::from_cols(DVec3::X, DVec3::Y + 1e-9 * DVec3::X, DVec3::Z);
    for frame in [axes, 2.0 * DMat3::IDENTITY, DMat3::NAN, DMat3::ZERO] {
        let refused = extension(1.0).oriented(frame).unwrap_err();
        assert!(matches!(refused, FlowError::Axes { .. }), "{refused}");
    }
}

#[test]
fn extreme_maps_that_are_none() {
    for (trace, n11, square) in [
        (4, 2, 3),
        (5, 1, 3),
        (3, 3, -1),
        (2, 1, 0),
        (7, 1, 5),
        (-3, -2, 1),
    ] {
        let refused = PlanarMap::square(trace, n11).unwrap_err();
        if square > 0 && trace < 0 {
            assert!(matches!(refused, FlowError::NoMap { .. }));
        } else {
            assert_eq!(refused, FlowError::NotSquare { trace, n11, square });
        }
    }
    assert!(PlanarMap::square(i64::MAX, i64::MAX / 2).is_err());
    assert!(PlanarMap::square(i64::MIN, i64::MAX).is_err());
    for rows in [
        [[1, 0], [0, 1]],
        [[1, 1], [0, 1]],
        [[2, 1], [1, 2]],
        [[1, 1], [1, 0]],
        [[-2, 1], [1, -1]],
        [[i64::MAX, i64::MAX], [i64::MIN, i64::MIN]],
    ] {
        assert!(matches!(PlanarMap::new(rows), Err(FlowError::NoMap { .. })));
    }
    // Large maps have finite distances, or cells that are refused.
    for rows in [
        [[999_999_999, 1], [999_999_998, 1]],
        [[500_000_000, 1], [249_999_999_999_999_999, 500_000_000]],
        [[1, 1_000_000], [998, 998_000_001]],
    ] {
        let map = PlanarMap::new(rows).unwrap();
        assert!((0.0..0.95).contains(&map.min_image_distance(1.0)));
        if let Ok(space) = KraynikReinelt::with_map(map, 1.0, 1.0, Steady::new(1.0).unwrap()) {
            assert!(2.0 * at(&space, 3.0).reach() > 0.99 * space.min_image_distance());
        }
    }
}

/// At rates up to 10 and in steps of several periods the cell is that of the strain; what is not finite leaves it.
#[test]
fn extreme_times_and_steps() {
    let space = KraynikReinelt::new(10.0, 8.0, Steady::new(10.0).unwrap()).unwrap();
    for time in [1e3, -1e3, 1e6, 1e12, 1e300] {
        let far = at(&space, time);
        assert!((far.lattice().volume() / 800.0 - 1.0).abs() < 1e-14);
        assert!(2.0 * far.reach() >= far.min_image_distance() * (1.0 - 1e-14));
    }
    let start = at(&space, 0.3);
    for time in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
        let mut space = start.clone();
        assert_eq!(space.advance(time), Remap::None);
        assert_eq!(space, start);
    }
    // Twenty of Hencky strain in one step: counts still follow exactly, e^20 = 5e8 of them.
    let mut stepped = start.clone();
    let remap = stepped.advance(2.3);
    let mut walked = start.clone();
    let mut count = IVec3::new(1, -1, 2);
    for k in 1..=200 {
        count = walked.advance(0.3 + 0.01 * f64::from(k)).apply(count);
    }
    walked.advance(2.3);
    assert_eq!(walked.cell(), stepped.cell());
    assert_eq!(remap.apply(IVec3::new(1, -1, 2)), count);
}

/// Almost shear, down to the least mixedness that is allowed: periods of up to 3600 strains, through which the cell is
/// exact to 1e-8 only. The set of images goes on, and images keep apart as promised.
#[test]
fn extreme_almost_shear() {
    for mixedness in [1e-4, 1e-5] {
        let space = PlanarMixed::new(10.0, 10.0, mixedness, Steady::new(1.0).unwrap()).unwrap();
        let period = space.map().hencky_period() / mixedness.sqrt();
        for step in 0..3000 {
            let time = period * f64::from(step) / 1000.0;
            let (now, then) = (at(&space, time), at(&space, time + 0.4));
            let carried = space.carry(time, time + 0.4) * now.lattice().basis();
            assert_same_lattice(then.lattice().basis(), carried, 1e-8);
            assert!((now.lattice().volume() / 1000.0 - 1.0).abs() < 1e-8);
            assert!(2.0 * now.reach() > space.min_image_distance() * (1.0 - 1e-8));
        }
    }
}
