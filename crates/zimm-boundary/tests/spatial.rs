//! Extension in three dimensions against reference numbers, closed forms and hostile input.

#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

mod common;

use common::{at, holds_vector, json, norm, number};
use proptest::prelude::*;
use zimm_boundary::{
    FlowError, LatticeFlow, Oscillation, Steady, TriaxialFlow, UniaxialExtension, laws,
};
use zimm_core::{Boundary, DMat3, DVec3, LatticeError, Periodic, Remap};

fn uniaxial(edge: f64) -> UniaxialExtension<Steady> {
    UniaxialExtension::new(edge, Steady::new(1.0).unwrap()).unwrap()
}

fn triaxial(stretch: DVec3, axes: DMat3) -> TriaxialFlow<Steady> {
    TriaxialFlow::new(1.0, stretch, axes, Steady::new(1.0).unwrap()).unwrap()
}

fn vector(row: &serde_json::Value) -> DVec3 {
    DVec3::new(number(&row[0]), number(&row[1]), number(&row[2]))
}

/// The generalised cell of Kraynik and Reinelt in uniaxial, biaxial, planar and ellipsoidal extension up to a Hencky
/// strain of 10 along each axis: the vectors of the remapped cells are ours, the shortest as short.
#[test]
fn reference_triaxial_trajectories() {
    let table = json(include_str!("data/triaxial_trajectory.json"));
    let bound = number(&table["Dmin_bound"]);
    let rows = table["trajectory"].as_array().unwrap();
    for row in rows {
        let space = triaxial(vector(&row["stretch_direction"]), DMat3::IDENTITY);
        assert!((space.min_image_distance() - bound).abs() < 1e-15);
        let space = at(&space, number(&row["strain"]));
        for k in 0..3 {
            assert!(
                holds_vector(&space, vector(&row["cell"][k]), 1e-13),
                "{row}"
            );
        }
        let error = space.lattice().shortest() - number(&row["shortest"]);
        assert!(error.abs() < 1e-13, "{row}: {error:e}");
        assert!((space.lattice().volume() - 1.0).abs() < 1e-14);
    }
    assert_eq!(rows.len(), 252);
    // The least distances that a scan up to a strain of 400 has seen, in double precision, are of our lattices as well.
    for (name, seen) in table["observed_minima_strain_0_400"].as_object().unwrap() {
        let (flow, axis) = name.rsplit_once("_axis").unwrap();
        let along = match flow {
            "uniaxial" => DVec3::new(1.0, -0.5, -0.5),
            "biaxial" => DVec3::new(-1.0, 0.5, 0.5),
            "planar" => DVec3::new(1.0, -1.0, 0.0),
            _ => DVec3::new(1.0, -0.65, -0.35),
        };
        let at_axis = (0..axis.parse().unwrap()).fold(along, |d, _| DVec3::new(d.z, d.x, d.y));
        let space = at(
            &triaxial(at_axis, DMat3::IDENTITY),
            number(&seen["at_strain"]),
        );
        let error = space.lattice().shortest() - number(&seen["min_shortest"]);
        assert!(error.abs() < 1e-12, "{name}: {error:e}");
    }
}

/// The turning cell up to a Hencky strain of 5, and the closest that images come.
#[test]
fn reference_uniaxial_trajectory() {
    let table = json(include_str!("data/uniaxial_trajectory.json"));
    let space = uniaxial(1.0);
    assert!((space.min_image_distance() - number(&table["Dmin_bound"])).abs() < 1e-15);
    let rows = table["trajectory"].as_array().unwrap();
    for row in rows {
        let space = at(&space, number(&row["strain"]));
        for k in 0..3 {
            assert!(
                holds_vector(&space, vector(&row["cell"][k]), 1e-13),
                "{row}"
            );
        }
        let error = space.lattice().shortest() - number(&row["shortest"]);
        assert!(error.abs() < 1e-13, "{row}: {error:e}");
    }
    assert_eq!(rows.len(), 21);
    // x^3 = x + 1: after the period each basis vector is the next one, turned.
    let [period, angle] = ["eps_p", "phi"].map(|name| number(&table[name]));
    let turn = DMat3::from_rotation_x(angle);
    let [a, b, c] = [0, 1, 2].map(|k| vector(&table["Lr"][k]));
    for (old, new) in [(a, b), (b, c), (c, a + b)] {
        assert!((turn * (space.carry(0.0, period) * old) - new).length() < 1e-15);
    }
    let scan = |j: u32| {
        at(&space, period * f64::from(j) / 1000.0)
            .lattice()
            .shortest()
    };
    let least = (0..1000).map(scan).fold(f64::INFINITY, f64::min);
    assert!(
        (0.0..1e-6).contains(&(least - space.min_image_distance())),
        "{least}"
    );
}

/// Ten thousand periods at twenty steps each, and as much of triaxial flow: volumes, sets of images, beads in the cell,
/// images apart.
#[test]
fn law_nothing_drifts_in_ten_thousand_periods() {
    long_run(uniaxial(1.0), 0.281_199_574_322_961_84 / 20.0);
    long_run(triaxial(DVec3::new(1.0, -0.3, -0.7), DMat3::IDENTITY), 0.05);
    let oblique = DMat3::from_cols(
        DVec3::X,
        DVec3::new(0.5, 1.0, 0.0),
        DVec3::new(0.1, -0.3, 1.0),
    );
    long_run(triaxial(DVec3::new(0.7, 0.3, -1.0), oblique), 0.05);
}

fn long_run<F: Clone + Send + Sync>(mut space: LatticeFlow<F, Steady>, step: f64) {
    let mut beads = common::scattered(space.lattice(), 20);
    let (mut time, mut remaps) = (0.0, 0);
    for k in 1..=200_000 {
        let to = step * f64::from(k);
        let carry = space.carry(time, to);
        let carried = carry * space.lattice().basis();
        if space.advance(to) != Remap::None {
            remaps += 1;
        }
        let between = space.lattice().inverse() * carried;
        let whole = DMat3::from_cols_array(&between.to_cols_array().map(f64::round));
        assert!(norm(between - whole) < 1e-9 && whole.determinant().abs() == 1.0);
        assert!((space.lattice().volume() - 1.0).abs() < 1e-12);
        assert!(space.lattice().shortest() > space.min_image_distance() * (1.0 - 1e-12));
        for bead in &mut beads {
            *bead = space.wrap(carry * *bead).0;
            assert!((space.lattice().inverse() * *bead).abs().max_element() <= 0.5 + 1e-12);
        }
        time = to;
    }
    assert!(remaps > 5_000, "{remaps}");
    // The same at once.
    let mut direct = space.clone();
    direct.advance(0.0);
    direct.advance(time);
    assert_eq!(direct.cell(), space.cell());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Along oblique axes images come as close as is said, and no closer: a scan of 20 000 strains of a flow whose two
    /// parts have periods without a common multiple comes within a few percent.
    #[test]
    fn law_images_along_oblique_axes(a in laws::vector(1.0), b in laws::vector(1.0), c in laws::vector(1.0)) {
        let axes = DMat3::from_cols(a, b, c);
        prop_assume!(axes.determinant().abs() > 0.3 * a.length() * b.length() * c.length());
        let space = triaxial(DVec3::new(1.0, 0.618, -1.618), axes);
        let scan = |j: u32| at(&space, 0.037 * f64::from(j)).lattice().shortest();
        let least = (0..20_000).map(scan).fold(f64::INFINITY, f64::min);
        let ratio = least / space.min_image_distance();
        prop_assert!((1.0 - 1e-12..1.03).contains(&ratio), "{ratio}");
    }

    #[test]
    fn law_boxes_for_a_cutoff(cutoff in 0.1..10.0, frame in laws::frame()) {
        let history = Oscillation::new(30.0, 1.0).unwrap();
        let uniaxial = UniaxialExtension::box_for_cutoff(cutoff, history).unwrap();
        let stretch = DVec3::new(0.2, 0.5, -0.7);
        let triaxial = TriaxialFlow::box_for_cutoff(cutoff, stretch, frame, history).unwrap();
        for step in 0..500 {
            let time = 0.0137 * f64::from(step);
            prop_assert!(at(&uniaxial, time).reach() >= cutoff);
            prop_assert!(at(&triaxial, time).reach() >= cutoff);
        }
        for distance in [uniaxial.min_image_distance(), triaxial.min_image_distance()] {
            prop_assert!((distance / (2.0 * cutoff) - 1.0 - 1e-12).abs() < 1e-14);
        }
    }
}

/// Perpendicular axes in any order, length and handedness: the closed form, sqrt(3) 7^(-1/3).
#[test]
fn limit_images_along_perpendicular_axes() {
    let expected = 3.0_f64.sqrt() * 7.0_f64.powf(-1.0 / 3.0);
    for axes in [
        DMat3::IDENTITY,
        DMat3::from_cols(2.0 * DVec3::Y, -0.1 * DVec3::X, 1e3 * DVec3::Z),
        DMat3::from_rotation_x(0.3) * DMat3::from_rotation_z(1.1),
    ] {
        let space = triaxial(DVec3::new(1.0, -0.3, -0.7), axes);
        assert!((space.min_image_distance() - expected).abs() < 1e-14);
        assert!((space.lattice().volume() - 1.0).abs() < 1e-14);
    }
    // Two perpendicular axes in a plane and one at an angle to one of them: planar mixed flow has such, and the product of
    // the factors 1 + c of each pair is what images lose.
    let mut before = expected;
    for step in 1..10 {
        let tilt = 0.15 * f64::from(step);
        let axes = DMat3::from_cols(DVec3::X, DVec3::new(tilt.sin(), tilt.cos(), 0.0), DVec3::Z);
        let space = triaxial(DVec3::new(1.0, -1.0, 0.0), axes);
        // |x y z| = 1 / (7 cos tilt): min of x^2 + y^2 - 2 x y sin tilt is 2 x y (1 - sin tilt), then that of the sum
        // with z^2.
        let product = (1.0 - tilt.sin()) / (7.0 * tilt.cos());
        let closed = 3.0_f64.sqrt() * product.powf(1.0 / 3.0);
        assert!(
            (space.min_image_distance() / closed - 1.0).abs() < 1e-13,
            "{tilt}"
        );
        assert!(space.min_image_distance() < before);
        before = space.min_image_distance();
    }
}

/// Shear added to uniaxial extension, u = (x + 0.4 y, -y / 2, -z / 2) and more: the gradient asked for by its axes.
#[test]
fn limit_gradient_along_oblique_axes() {
    let mut kappa = DMat3::from_diagonal(DVec3::new(1.0, -0.4, -0.6));
    (kappa.y_axis.x, kappa.z_axis.x, kappa.z_axis.y) = (0.4, -0.2, 0.3);
    // Upper triangular, so the axes come by substitution.
    let second = DVec3::new(-0.4 / 1.4, 1.0, 0.0);
    let y = -0.3 / 0.2;
    let third = DVec3::new((0.2 - 0.4 * y) / 1.6, y, 1.0);
    let axes = DMat3::from_cols(DVec3::X, second, third);
    let space = triaxial(DVec3::new(1.0, -0.4, -0.6), axes);
    assert!(norm(space.gradient() - kappa) < 1e-14);
}

#[test]
fn extreme_parameters_are_refused() {
    for edge in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            UniaxialExtension::new(edge, ()),
            Err(FlowError::Parameter(_))
        ));
        assert!(UniaxialExtension::box_for_cutoff(edge, ()).is_err());
        let stretch = DVec3::new(1.0, -0.5, -0.5);
        assert!(TriaxialFlow::new(edge, stretch, DMat3::IDENTITY, ()).is_err());
        assert!(TriaxialFlow::box_for_cutoff(edge, stretch, DMat3::IDENTITY, ()).is_err());
    }
    for stretch in [
        DVec3::ONE,
        DVec3::new(1.0, -0.5, -0.5 + 1e-9),
        DVec3::new(f64::NAN, 0.0, 0.0),
        DVec3::new(f64::INFINITY, f64::NEG_INFINITY, 0.0),
    ] {
        let refused = TriaxialFlow::new(1.0, stretch, DMat3::IDENTITY, ()).unwrap_err();
        assert!(
            matches!(refused, FlowError::Compressible { .. }),
            "{refused}"
        );
    }
    for axes in [
        DMat3::ZERO,
        DMat3::NAN,
        DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::X + DVec3::Y),
        DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::X + 1e-11 * DVec3::Z),
    ] {
        let refused = TriaxialFlow::new(1.0, DVec3::new(1.0, -0.5, -0.5), axes, ()).unwrap_err();
        let FlowError::Lattice(LatticeError::Degenerate { .. }) = refused else {
            panic!("{refused}")
        };
    }
}

/// No rates at all, rates along one of the maps alone, and axes so oblique that images nearly meet.
#[test]
fn extreme_flows() {
    let rest = triaxial(DVec3::ZERO, DMat3::IDENTITY);
    assert_eq!(at(&rest, 100.0).cell(), rest.cell());
    let log = |k: f64| -2.0 * (2.0 * (k * std::f64::consts::PI / 7.0).cos()).ln();
    let alone = DVec3::new(log(1.0), log(2.0), -log(1.0) - log(2.0));
    let space = triaxial(alone, DMat3::IDENTITY);
    for (old, new) in [(0.3, 1.3), (-0.2, 40.8)] {
        let between = at(&space, old).lattice().inverse() * at(&space, new).lattice().basis();
        let whole = DMat3::from_cols_array(&between.to_cols_array().map(f64::round));
        assert!(norm(between - whole) < 1e-13);
    }
    for tilt in [1e-2, 1e-4, 1e-6] {
        let axes = DMat3::from_cols(DVec3::X, DVec3::new(1.0, tilt, 0.0), DVec3::Z);
        let space = triaxial(DVec3::new(1.0, -0.5, -0.5), axes);
        for step in 0..200 {
            let now = at(&space, 0.1 * f64::from(step));
            assert!(
                2.0 * now.reach() > now.min_image_distance() * (1.0 - 1e-6),
                "{tilt}"
            );
        }
    }
}
