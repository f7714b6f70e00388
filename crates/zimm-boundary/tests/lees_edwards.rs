//! Lees-Edwards boundaries against reference numbers, closed forms and hostile input.

#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

use proptest::prelude::*;
use zimm_boundary::{FlowHistory, LeesEdwards, Oscillation, StartUp, Steady, StepStrain};
use zimm_core::{Boundary, DVec3, IVec3, Periodic, Remap};

fn steady(edges: DVec3, rate: f64) -> LeesEdwards<Steady> {
    LeesEdwards::new(edges, Steady::new(rate).unwrap()).unwrap()
}

fn at<H: FlowHistory>(space: &LeesEdwards<H>, time: f64) -> LeesEdwards<H> {
    let mut space = space.clone();
    space.advance(time);
    space
}

/// strain, L_x, L_y, tilt_total, tilt_centred, n_remap, shortest_xy. The strains are decimals, rounded when read: the
/// tilt total is then known to 2e-14.
#[test]
fn reference_sheared_rectangles() {
    let table = include_str!("data/lees_edwards_brick.csv");
    let mut rows = 0;
    let mut walk: Option<(f64, LeesEdwards<Steady>, f64)> = None;
    for line in table.lines().skip(1) {
        let numbers: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let [strain, x, y, total, centred, folds, shortest] = numbers[..] else {
            panic!("{line}")
        };
        let start = steady(DVec3::new(x, y, 50.0), 1.0);
        let mut space = start.clone();
        let remap = space.advance(strain);
        assert!((space.tilt() - centred).abs() < 1e-13, "{line}");
        assert_eq!(((total - space.tilt()) / x).round(), folds, "{line}");
        assert!(
            (space.lattice().shortest() - shortest).abs() < 1e-13,
            "{line}"
        );
        // The image above at the start is now displaced by the whole of the tilt.
        let above = space.lattice().basis() * remap.apply(IVec3::Y).as_dvec3();
        assert!(
            (above - DVec3::new(total, y, 0.0)).length() < 1e-12,
            "{line}: {above}"
        );
        // Where L_y is no less than L_x the tilted basis is reduced as it is: a change of basis is a fold.
        if y >= x {
            let (_, walker, changes) = walk.get_or_insert_with(|| (x, start.clone(), 0.0));
            if strain == 0.0 {
                (*walker, *changes) = (start, 0.0);
            }
            *changes += f64::from(u8::from(walker.advance(strain) != Remap::None));
            assert_eq!(*changes, folds, "{line}");
        }
        rows += 1;
    }
    assert_eq!(rows, 183);
}

/// Two particles at rest in the cell, face to face across the boundary along y: their images move past each other at
/// rate L_y less than they do in the cell. All numbers are exact in binary.
#[test]
fn limit_velocity_across_the_boundary() {
    let (edges, rate) = (DVec3::new(10.0, 8.0, 6.0), 0.5);
    for time in [0.0, 0.25, 3.0, 17.5, 1e6] {
        let space = at(&steady(edges, rate), time);
        let kappa = space.gradient();
        let apart = DVec3::new(0.5, 7.5, 0.0);
        let nearest = space.min_image(apart);
        assert_eq!(nearest.y, -0.5);
        let (in_cell, across) = (kappa * apart, kappa * nearest);
        assert_eq!(in_cell - across, DVec3::new(rate * edges.y, 0.0, 0.0));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// The laboratory velocity of a particle that is wrapped changes by a whole number of rate L_y, its peculiar
    /// velocity by nothing; so does the difference of a pair that is seen in another image.
    #[test]
    fn law_images_move_at_whole_multiples_of_rate_times_height(
        edges in [2.0..20.0, 2.0..20.0, 2.0..20.0],
        rate in -5.0..5.0,
        time in 0.0..50.0,
        r in [-30.0..30.0, -30.0..30.0, -30.0..30.0],
    ) {
        let (edges, r) = (DVec3::from_array(edges), DVec3::from_array(r));
        let space = at(&steady(edges, rate), time);
        let kappa = space.gradient();
        for image in [space.wrap(r).0, space.min_image(r)] {
            let rows = ((r.y - image.y) / edges.y).round();
            let change = kappa * (r - image);
            let expected = DVec3::new(rows * rate * edges.y, 0.0, 0.0);
            prop_assert!((change - expected).length() < 1e-12, "{change} {expected}");
        }
    }

    /// A scan of 400 strains over a whole period of the lattice against the closed form.
    #[test]
    fn law_min_image_distance_is_the_least(edges in [0.5..20.0, 0.5..20.0, 0.5..20.0]) {
        let edges = DVec3::from_array(edges);
        let space = steady(edges, 1.0);
        let period = edges.x / edges.y;
        let reach = |k: u32| at(&space, period * f64::from(k) / 400.0).reach();
        let least = 2.0 * (0..=400).map(reach).fold(f64::INFINITY, f64::min);
        prop_assert!((least / space.min_image_distance() - 1.0).abs() < 1e-12);
        prop_assert_eq!(2.0 * space.reach(), space.min_image_distance());
    }
}

/// Edges and strains are exact in binary: the tilt at a million strains is that of the part beyond whole ones, to the
/// last bit, and so is the lattice.
#[test]
fn extreme_strain_of_a_million_leaves_the_cell_exact() {
    let space = steady(DVec3::new(10.0, 10.0, 7.0), 1.0);
    for whole in [1e3, 1e6, 1e9, 1e12] {
        for part in [0.0, 0.25, -0.375, 0.4375] {
            let (near, far) = (at(&space, part), at(&space, whole + part));
            assert_eq!(far.tilt(), near.tilt());
            assert_eq!(far.lattice(), near.lattice());
        }
    }
    // In steps of a thousand, up to a million: the same, and the volume with it.
    let mut walker = space.clone();
    for step in 1..=1000 {
        walker.advance(1000.0 * f64::from(step) + 0.25);
    }
    assert_eq!(walker.lattice(), at(&space, 0.25).lattice());
    assert_eq!(walker.lattice().volume(), 700.0);
}

/// The deforming brick, whose side goes from -45 to 45 degrees: at the strains 0, 1 and 2 of that the cells are bases of
/// one lattice, related by [[1, 0], [1, 1]] and [[1, 0], [2, 1]].
#[test]
fn reference_brick_at_45_degrees() {
    let start = steady(DVec3::splat(10.0), 1.0);
    let cells = [-1.0, 0.0, 1.0].map(|tilt| DVec3::new(10.0 * tilt, 10.0, 0.0));
    for (strain, n) in [(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)] {
        let space = at(&start, strain);
        assert_eq!(space.lattice().basis(), start.lattice().basis());
        let carried = space.carry(0.0, strain) * cells[0];
        assert_eq!(carried, n * 10.0 * DVec3::X + cells[0]);
        for cell in cells {
            assert_eq!(space.min_image(cell), DVec3::ZERO);
        }
    }
}

#[test]
fn limit_cells_at_rest_and_after_a_step() {
    let edges = DVec3::new(10.0, 8.0, 6.0);
    let rest = LeesEdwards::new(edges, ()).unwrap();
    assert_eq!(at(&rest, 3.0).lattice().basis(), rest.lattice().basis());
    assert_eq!(rest.gradient().determinant(), 0.0);

    // A step at time zero falls into the first step of a run, moves everything by one matrix, and streams nothing.
    let mut step = LeesEdwards::new(edges, StepStrain::new(0.25, 0.0).unwrap()).unwrap();
    assert_eq!(step.tilt(), 0.0);
    let carried = step.carry(0.0, 0.01) * DVec3::new(1.0, 3.0, 2.0);
    assert_eq!(carried, DVec3::new(1.75, 3.0, 2.0));
    assert_eq!(step.advance(0.01), Remap::None);
    assert_eq!((step.tilt(), step.gradient()), (2.0, rest.gradient()));

    // A quarter of a period: the full amplitude, and no rate.
    let wave = Oscillation::new(0.25, 1.0).unwrap();
    let quarter = at(
        &LeesEdwards::new(edges, wave).unwrap(),
        std::f64::consts::FRAC_PI_2,
    );
    assert!((quarter.tilt() - 2.0).abs() < 1e-15);
    assert!(quarter.gradient().y_axis.x.abs() < 1e-16);

    // Shear that began before time zero has tilted the cell by then.
    let early = LeesEdwards::new(edges, StartUp::new(0.5, -1.0).unwrap()).unwrap();
    assert_eq!(early.tilt(), 4.0);
}

#[test]
fn extreme_edges_are_refused() {
    for edge in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308] {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let edges = DVec3::select(
                axis.cmpgt(DVec3::ZERO),
                DVec3::splat(edge),
                DVec3::splat(10.0),
            );
            assert!(LeesEdwards::new(edges, ()).is_err(), "{edges}");
        }
    }
    assert!(LeesEdwards::new(DVec3::new(1.0, -1.0, -1.0), ()).is_err());
    // Flat along the gradient: at half an L_x of tilt such a cell would span no volume.
    assert!(LeesEdwards::new(DVec3::new(1e11, 1.0, 1.0), ()).is_err());
}

/// Flat cells at many strains: they stay lattices of the right volume, and images no closer than the edges. A tilt
/// known to 1e-16 L_x moves the shortest vectors, which may be sums of sqrt(L_x / L_y) rows, by 1e-16 (L_x / L_y)^(3/2)
/// of L_y: the bound on the volume of a cell 1e6 flat is 1e-7.
#[test]
fn extreme_flat_cells() {
    for edges in [
        DVec3::new(1e6, 1.0, 1.0),
        DVec3::new(1.0, 1e6, 1.0),
        DVec3::new(1.0, 1.0, 1e-6),
        DVec3::new(1.0, 1.0, 1e9),
        DVec3::new(1e-30, 1e-30, 1e-30),
    ] {
        let mut space = steady(edges, 1.0);
        for step in 1..2000 {
            let time = 0.731 * f64::from(step) * edges.x / edges.y;
            space.advance(time);
            let volume = space.lattice().volume() / edges.element_product();
            assert!((volume - 1.0).abs() < 1e-7, "{edges}: {volume}");
            assert!(
                2.0 * space.reach() >= space.min_image_distance() * (1.0 - 1e-7),
                "{edges}"
            );
        }
    }
}

#[test]
fn extreme_rates() {
    let edges = DVec3::new(10.0, 8.0, 6.0);
    for rate in [0.0, -3.0, 1e-300, 1e12] {
        let mut space = steady(edges, rate);
        for step in 1..100 {
            space.advance(0.01 * f64::from(step));
            assert!((space.lattice().volume() / 480.0 - 1.0).abs() < 1e-13);
            assert_eq!(space.gradient().y_axis.x, rate);
        }
    }
}

#[test]
fn extreme_times_leave_a_cell() {
    let start = steady(DVec3::new(10.0, 8.0, 6.0), 1.0);
    for time in [1e15, -1e15, 1e100, 1e300] {
        let space = at(&start, time);
        assert!((space.lattice().volume() / 480.0 - 1.0).abs() < 1e-13);
        assert!(2.0 * space.reach() >= space.min_image_distance());
    }
    // What is not finite, or overflows, leaves the space where it was.
    for time in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
        let mut space = at(&start, 0.3);
        let before = space.clone();
        assert_eq!(space.advance(time), Remap::None);
        assert_eq!(space, before);
        assert!(time == f64::MAX || !space.carry(0.3, time).is_finite());
        space.advance(0.4);
        assert_eq!(space, at(&start, 0.4));
        // So it does where the strain has come to its end and would be finite.
        if !time.is_finite() {
            let step = StepStrain::new(0.25, 0.0).unwrap();
            let mut space = at(&LeesEdwards::new(DVec3::ONE, step).unwrap(), 1.0);
            let before = space.clone();
            assert_eq!(space.advance(time), Remap::None);
            assert_eq!(space, before);
        }
    }
}

/// A history that breaks its promise of a finite strain is refused at the start, and ignored later.
#[test]
fn extreme_history_that_is_not_finite() {
    #[derive(Clone)]
    struct Pole {
        at: f64,
    }
    impl FlowHistory for Pole {
        fn strain(&self, time: f64) -> f64 {
            (time - self.at).recip()
        }

        fn rate(&self, time: f64) -> f64 {
            -(time - self.at).powi(-2)
        }
    }
    assert!(LeesEdwards::new(DVec3::ONE, Pole { at: 0.0 }).is_err());
    let mut space = LeesEdwards::new(DVec3::ONE, Pole { at: 1.0 }).unwrap();
    let lattice = *space.lattice();
    assert_eq!(space.advance(1.0), Remap::None);
    assert_eq!(space.lattice(), &lattice);
}
