//! Every boundary of this crate obeys the laws of boundaries, and the laws notice boundaries that do not.

#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

mod laws;

use proptest::prelude::*;
use zimm_boundary::{
    Cessation, LeesEdwards, OpenFlow, Oscillation, PeriodicBox, ShearHistory, StartUp, Steady,
    StepStrain,
};
use zimm_core::{Boundary, DMat3, DVec3, IVec3, Remap};

fn vector(limit: f64) -> impl Strategy<Value = DVec3> {
    proptest::array::uniform3(-limit..limit).prop_map(DVec3::from_array)
}

fn edges() -> impl Strategy<Value = DVec3> {
    proptest::array::uniform3(2.0..20.0).prop_map(DVec3::from_array)
}

fn gradient() -> impl Strategy<Value = DMat3> {
    proptest::array::uniform9(-0.5..0.5).prop_map(|entries| DMat3::from_cols_array(&entries))
}

fn triclinic() -> impl Strategy<Value = PeriodicBox> {
    let basis =
        proptest::array::uniform9(-8.0..8.0).prop_map(|entries| DMat3::from_cols_array(&entries));
    basis
        .prop_filter("spans a volume", |h| h.determinant().abs() > 10.0)
        .prop_map(|h| PeriodicBox::triclinic(h).unwrap())
}

/// What the laws are tried with.
#[derive(Clone, Debug)]
struct Trial {
    times: [f64; 3],
    r: DVec3,
    s: DVec3,
    count: IVec3,
}

fn trial(latest: f64) -> impl Strategy<Value = Trial> {
    let times = proptest::array::uniform3(0.0..latest);
    let count = proptest::array::uniform3(-1000..1000).prop_map(IVec3::from_array);
    (times, vector(100.0), vector(100.0), count).prop_map(|(times, r, s, count)| Trial {
        times,
        r,
        s,
        count,
    })
}

/// All laws but those that need a smooth flow.
fn obeys<B: Boundary>(space: &B, trial: &Trial) {
    let &Trial { times, r, s, count } = trial;
    let [a, b, c] = times;
    laws::carries_compose(space, times);
    laws::state_is_a_function_of_time(space, times, count);
    laws::images_are_carried(space, a, b);
    laws::volume_is_carried(space, a, c);
    laws::counts_follow(space, &times, r);
    laws::pairs_ride_the_flow(space, b, c, [r, s]);
    let now = laws::at(space, b);
    laws::wrapping_is_invisible(&now, r, s);
    laws::reach_is_half_the_shortest_vector(&now, s);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn law_open_flow(kappa in gradient(), trial in trial(3.0)) {
        let space = OpenFlow::new(kappa).unwrap();
        obeys(&space, &trial);
        laws::gradient_is_the_rate_of_the_carry(&space, trial.times[0]);
    }

    #[test]
    fn law_brick_at_rest(edges in edges(), trial in trial(100.0)) {
        obeys(&PeriodicBox::brick(edges).unwrap(), &trial);
    }

    #[test]
    fn law_triclinic_at_rest(space in triclinic(), trial in trial(100.0)) {
        obeys(&space, &trial);
        laws::gradient_is_the_rate_of_the_carry(&space, trial.times[0]);
    }

    #[test]
    fn law_steady_shear(edges in edges(), rate in -10.0..10.0, trial in trial(100.0)) {
        let space = LeesEdwards::new(edges, Steady::new(rate).unwrap()).unwrap();
        obeys(&space, &trial);
        laws::gradient_is_the_rate_of_the_carry(&space, trial.times[0]);
    }

    #[test]
    fn law_start_up_and_cessation(edges in edges(), rate in -3.0..3.0, at in 0.0..20.0, trial in trial(20.0)) {
        obeys(&LeesEdwards::new(edges, StartUp::new(rate, at).unwrap()).unwrap(), &trial);
        obeys(&LeesEdwards::new(edges, Cessation::new(rate, at).unwrap()).unwrap(), &trial);
    }

    #[test]
    fn law_step_strain(edges in edges(), strain in -10.0..10.0, at in 0.0..20.0, trial in trial(20.0)) {
        obeys(&LeesEdwards::new(edges, StepStrain::new(strain, at).unwrap()).unwrap(), &trial);
    }

    #[test]
    fn law_oscillation(edges in edges(), amplitude in 0.0..5.0, omega in 0.1..5.0, trial in trial(20.0)) {
        let space = LeesEdwards::new(edges, Oscillation::new(amplitude, omega).unwrap()).unwrap();
        obeys(&space, &trial);
        laws::gradient_is_the_rate_of_the_carry(&space, trial.times[0]);
    }

    /// A thousand steps with dozens of remaps on the way.
    #[test]
    fn law_counts_follow_on_a_long_way(edges in edges(), rate in -10.0..10.0, r in vector(1000.0)) {
        let times: Vec<f64> = (0..1000).map(|step| f64::from(step) * 0.01).collect();
        laws::counts_follow(&LeesEdwards::new(edges, Steady::new(rate).unwrap()).unwrap(), &times, r);
        laws::counts_follow(&LeesEdwards::new(edges, Oscillation::new(rate, 2.0).unwrap()).unwrap(), &times, r);
    }

    /// Every remap between strains 0 and 6 is closed in on until 1e-9 of strain is left. The laws then hold to 1e-9 of
    /// the edges, where an image lost or a velocity shifted would show as a whole L_x or rate L_y.
    #[test]
    fn law_pairs_feel_no_remap(edges in edges(), rate in 0.5..2.0, r in vector(30.0), s in vector(30.0)) {
        let space = LeesEdwards::new(edges, Steady::new(rate).unwrap()).unwrap();
        let steps = 600;
        let time = |step: i32| 6.0 / rate * f64::from(step) / f64::from(steps);
        let mut remaps = 0;
        for step in 0..steps {
            if let Some([before, after]) = close_in(&space, time(step), time(step + 1)) {
                remaps += 1;
                laws::pairs_ride_the_flow(&space, before, after, [r, s]);
                let near = space.reach() * (s - r).normalize();
                laws::pairs_ride_the_flow(&space, before, after, [r, r + 0.9 * near]);
            }
        }
        // At each strain of (k + 1/2) L_x / L_y the tilt is folded, and the basis changes.
        let folds = (6.0 * edges.y / edges.x + 0.5).floor();
        prop_assert!(f64::from(remaps) >= folds.min(100.0), "{remaps} remaps, {folds} folds");
    }
}

/// Two times, 1e-9 apart in strain, between which the basis changes, if it does between the times given.
fn close_in(space: &LeesEdwards<Steady>, mut from: f64, mut to: f64) -> Option<[f64; 2]> {
    let changes = |from, to| laws::at(space, from).advance(to) != Remap::None;
    if !changes(from, to) {
        return None;
    }
    while space.history().strain(to - from) > 1e-9 {
        let middle = 0.5 * (from + to);
        if changes(from, middle) {
            to = middle;
        } else {
            from = middle;
        }
    }
    Some([from, to])
}

/// A shear of rate 1 in a cube of 4, wrong in one respect.
#[derive(Clone)]
struct Wrong {
    space: LeesEdwards<Steady>,
    fault: Fault,
}

#[derive(Clone, PartialEq)]
enum Fault {
    Nothing,
    RemapLost,
    LatticeLags,
    GradientOff,
    ReachOff,
    ImageNotNearest,
    PathDependent,
}

impl Wrong {
    fn with(fault: Fault) -> Self {
        let space = LeesEdwards::new(DVec3::splat(4.0), Steady::new(1.0).unwrap()).unwrap();
        Self { space, fault }
    }

    fn is(&self, fault: Fault) -> f64 {
        if self.fault == fault { 1.0 } else { 0.0 }
    }
}

impl Boundary for Wrong {
    const FLOWS: bool = true;

    fn min_image(&self, dr: DVec3) -> DVec3 {
        self.space.min_image(dr) + self.is(Fault::ImageNotNearest) * 4.0 * DVec3::Z
    }

    fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
        self.space.wrap(r)
    }

    fn reach(&self) -> f64 {
        (1.0 + 0.02 * self.is(Fault::ReachOff)) * self.space.reach()
    }

    fn gradient(&self) -> DMat3 {
        (1.0 + 0.02 * self.is(Fault::GradientOff)) * self.space.gradient()
    }

    fn carry(&self, from: f64, to: f64) -> DMat3 {
        self.space.carry(from, to)
    }

    fn advance(&mut self, to: f64) -> Remap {
        let lag = 1.0
            - 0.02 * self.is(Fault::LatticeLags)
            - 0.5 * self.is(Fault::PathDependent) * self.space.tilt();
        let remap = self.space.advance(to * lag);
        if self.fault == Fault::RemapLost {
            Remap::None
        } else {
            remap
        }
    }

    fn cell(&self) -> Option<DMat3> {
        self.space.cell()
    }
}

/// Times with one remap between the second and the third.
fn plain_trial() -> Trial {
    Trial {
        times: [0.1, 0.3, 0.9],
        r: DVec3::new(5.0, 7.5, -3.0),
        s: DVec3::new(0.3, 0.1, 0.2),
        count: IVec3::new(3, -2, 1),
    }
}

#[test]
fn law_the_laws_accept_what_has_no_fault() {
    let space = Wrong::with(Fault::Nothing);
    obeys(&space, &plain_trial());
    laws::gradient_is_the_rate_of_the_carry(&space, 0.3);
}

#[test]
#[should_panic = "0.3 to 0.9"]
fn law_a_lost_remap_is_noticed_by_counts() {
    laws::counts_follow(
        &Wrong::with(Fault::RemapLost),
        &[0.3, 0.9],
        DVec3::new(5.0, 7.5, -3.0),
    );
}

#[test]
#[should_panic = "between the bases"]
fn law_a_lost_remap_is_noticed_between_bases() {
    laws::images_are_carried(&Wrong::with(Fault::RemapLost), 0.3, 0.9);
}

#[test]
#[should_panic = "between the bases"]
fn law_a_lattice_that_lags_is_noticed() {
    laws::images_are_carried(&Wrong::with(Fault::LatticeLags), 0.1, 0.3);
}

#[test]
#[should_panic = "gradient"]
fn law_a_gradient_off_by_two_percent_is_noticed() {
    laws::gradient_is_the_rate_of_the_carry(&Wrong::with(Fault::GradientOff), 0.3);
}

#[test]
#[should_panic = "1.02"]
fn law_a_reach_off_by_two_percent_is_noticed() {
    laws::reach_is_half_the_shortest_vector(&Wrong::with(Fault::ReachOff), DVec3::ONE);
}

#[test]
#[should_panic = "is not the nearest"]
fn law_an_image_that_is_not_the_nearest_is_noticed() {
    laws::reach_is_half_the_shortest_vector(&Wrong::with(Fault::ImageNotNearest), DVec3::ONE);
}

#[test]
#[should_panic = "assertion"]
fn law_dependence_on_the_path_is_noticed() {
    laws::state_is_a_function_of_time(
        &Wrong::with(Fault::PathDependent),
        [0.1, 0.3, 0.9],
        IVec3::X,
    );
}

#[test]
fn extreme_boxes_that_are_none_are_refused() {
    for edge in [
        0.0,
        -1.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e-200,
        1e200,
    ] {
        assert!(PeriodicBox::cubic(edge).is_err(), "{edge}");
    }
    for edge in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let edges = DVec3::select(axis.cmpgt(DVec3::ZERO), DVec3::splat(edge), DVec3::ONE);
            assert!(PeriodicBox::brick(edges).is_err(), "{edges}");
        }
    }
    assert!(PeriodicBox::brick(DVec3::new(1.0, -1.0, -1.0)).is_err());
    assert!(PeriodicBox::triclinic(DMat3::ZERO).is_err());
    assert!(
        PeriodicBox::triclinic(DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::X - DVec3::Y)).is_err()
    );
    assert!(PeriodicBox::triclinic(DMat3::NAN).is_err());
}

#[test]
fn extreme_gradients_that_are_not_finite_are_refused() {
    for rate in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let shear = DMat3::from_cols(DVec3::ZERO, rate * DVec3::X, DVec3::ZERO);
        assert!(OpenFlow::new(shear).is_err(), "{rate}");
    }
    assert!(OpenFlow::new(DMat3::ZERO).is_ok());
}

/// A left-handed basis, a needle and a plate: volumes, reach and wrapping are right.
#[test]
fn extreme_shapes_at_rest() {
    let mirrored = DMat3::from_cols(DVec3::Y, DVec3::X, DVec3::Z);
    for space in [
        PeriodicBox::triclinic(mirrored).unwrap(),
        PeriodicBox::brick(DVec3::new(1e9, 1.0, 1.0)).unwrap(),
        PeriodicBox::brick(DVec3::new(1e9, 1e9, 1.0)).unwrap(),
        PeriodicBox::brick(DVec3::new(1e-30, 1e-30, 1e30)).unwrap(),
    ] {
        let cell = space.cell().unwrap();
        let r = cell * DVec3::new(0.3, 1.4, -2.2);
        laws::wrapping_is_invisible(&space, r, DVec3::ZERO);
        laws::reach_is_half_the_shortest_vector(&space, r);
    }
}
