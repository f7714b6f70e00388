//! Every boundary of this crate obeys the laws of boundaries, and the laws notice boundaries that do not.

#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

use proptest::prelude::*;
use zimm_boundary::{
    Cessation, FlowHistory, KraynikReinelt, LatticeFlow, LeesEdwards, OpenFlow, Oscillation,
    PeriodicBox, PlanarMixed, StartUp, Steady, StepStrain, Then, TriaxialFlow, UniaxialExtension,
    laws,
};
use zimm_core::{Boundary, DMat3, DVec3, IVec3, Remap};

/// All laws, and the promise about images, up to a time.
fn holds<F, H>(space: &LatticeFlow<F, H>, until: f64, trial: &laws::Trial, share: f64)
where
    F: Clone + Send + Sync,
    H: FlowHistory,
{
    laws::obeys(space, until, trial);
    laws::reach_is_at_least(space, share * until, 0.5 * space.min_image_distance());
}

proptest! {
    #[test]
    fn law_open_flow(kappa in laws::gradient(0.5), trial in laws::trial()) {
        laws::obeys(&OpenFlow::new(kappa).unwrap(), 3.0, &trial);
        let wave = Oscillation::new(0.7, 2.0).unwrap();
        laws::obeys(&OpenFlow::with_history(kappa, wave).unwrap(), 3.0, &trial);
    }

    #[test]
    fn law_brick_at_rest(edges in laws::edges(), trial in laws::trial()) {
        laws::obeys(&PeriodicBox::brick(edges).unwrap(), 100.0, &trial);
    }

    #[test]
    fn law_triclinic_at_rest(basis in laws::basis(), trial in laws::trial()) {
        laws::obeys(&PeriodicBox::triclinic(basis).unwrap(), 100.0, &trial);
    }

    #[test]
    fn law_lees_edwards(space in laws::lees_edwards(), trial in laws::trial(), share in 0.0..1.0) {
        laws::obeys(&space, 100.0, &trial);
        laws::reach_is_at_least(&space, 100.0 * share, 0.5 * space.min_image_distance());
    }

    #[test]
    fn law_kraynik_reinelt(space in laws::kraynik_reinelt(), trial in laws::trial(), share in 0.0..1.0) {
        holds(&space, 100.0, &trial, share);
    }

    #[test]
    fn law_planar_mixed(space in laws::planar_mixed(), trial in laws::trial(), share in 0.0..1.0) {
        holds(&space, 100.0, &trial, share);
    }

    #[test]
    fn law_uniaxial(space in laws::uniaxial(), trial in laws::trial(), share in 0.0..1.0) {
        holds(&space, 100.0, &trial, share);
    }

    #[test]
    fn law_triaxial(space in laws::triaxial(), trial in laws::trial(), share in 0.0..1.0) {
        holds(&space, 100.0, &trial, share);
    }
}

/// Every history in shear and in the flows of each kind of lattice.
fn with_history<H: FlowHistory>(history: &H, edges: DVec3, trial: &laws::Trial, share: f64) {
    let until = 20.0;
    laws::obeys(
        &LeesEdwards::new(edges, history.clone()).unwrap(),
        until,
        trial,
    );
    let planar = KraynikReinelt::new(edges.x, edges.z, history.clone()).unwrap();
    holds(&planar, until, trial, share);
    let mixed = PlanarMixed::new(edges.x, edges.z, 0.1, history.clone()).unwrap();
    holds(&mixed, until, trial, share);
    let uniaxial = UniaxialExtension::new(edges.x, history.clone()).unwrap();
    holds(&uniaxial, until, trial, share);
    let stretch = DVec3::new(0.6, -1.0, 0.4);
    let triaxial = TriaxialFlow::new(edges.x, stretch, DMat3::IDENTITY, history.clone()).unwrap();
    holds(&triaxial, until, trial, share);
}

proptest! {
    #[test]
    fn law_histories(
        edges in laws::edges(),
        rate in -3.0..3.0,
        at in 0.0..20.0,
        omega in 0.1..5.0,
        trial in laws::trial(),
        share in 0.0..1.0,
    ) {
        let steady = Steady::new(rate).unwrap();
        with_history(&(), edges, &trial, share);
        with_history(&StartUp::new(rate, at).unwrap(), edges, &trial, share);
        with_history(&Cessation::new(rate, at).unwrap(), edges, &trial, share);
        with_history(&StepStrain::new(rate, at).unwrap(), edges, &trial, share);
        with_history(&Oscillation::new(rate, omega).unwrap(), edges, &trial, share);
        with_history(&Then::new(steady, at, Steady::new(omega).unwrap()).unwrap(), edges, &trial, share);
    }

    /// A thousand steps with dozens of remaps on the way: of shear up to a strain of 100, of the others up to 10, which
    /// stretches by 2e4.
    #[test]
    fn law_counts_follow_on_a_long_way(
        shear in laws::lees_edwards(),
        planar in laws::kraynik_reinelt(),
        mixed in laws::planar_mixed(),
        uniaxial in laws::uniaxial(),
        triaxial in laws::triaxial(),
        r in laws::vector(20.0),
    ) {
        let times: Vec<f64> = (0..=1000).map(|step| 0.001 * f64::from(step)).collect();
        let times_of = |last: f64| -> Vec<f64> { times.iter().map(|t| last * t).collect() };
        laws::counts_follow(&shear, &times_of(10.0), r);
        laws::counts_follow(&planar, &times, r);
        laws::counts_follow(&mixed, &times, r);
        laws::counts_follow(&uniaxial, &times, r);
        laws::counts_follow(&triaxial, &times_of(0.5), r);
    }
}

/// A shear of rate 1 in a cube of 4, wrong in one respect.
#[derive(Clone)]
struct Wrong {
    space: LeesEdwards<Steady>,
    fault: Fault,
}

#[derive(Clone, Debug, PartialEq)]
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

#[test]
fn law_the_laws_accept_what_has_no_fault() {
    laws::check_boundary(&Wrong::with(Fault::Nothing), 2.0);
    laws::check_reach(&Wrong::with(Fault::Nothing), 2.0, 2.0);
}

/// The checks find each fault by themselves.
#[test]
fn law_the_checks_find_every_fault() {
    for fault in [
        Fault::RemapLost,
        Fault::LatticeLags,
        Fault::GradientOff,
        Fault::ReachOff,
        Fault::ImageNotNearest,
        Fault::PathDependent,
    ] {
        let space = Wrong::with(fault);
        let check = std::panic::catch_unwind(|| laws::check_boundary(&space, 2.0));
        assert!(check.is_err(), "{:?} went unseen", space.fault);
    }
    let promise = || laws::check_reach(&Wrong::with(Fault::Nothing), 2.0, 2.04);
    assert!(std::panic::catch_unwind(promise).is_err());
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
    laws::gradient_is_the_rate_of_the_carry(&Wrong::with(Fault::GradientOff), 0.3, 1.0);
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
