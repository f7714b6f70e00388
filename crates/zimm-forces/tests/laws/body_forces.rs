//! Body forces.

use crate::assert_refused;
use proptest::prelude::*;
use zimm_core::{
    Boundary, Clock, DMat3, DVec3, Energy, ForceField, IVec3, Lattice, Open, Particles, Periodic,
    System, Virial,
};
use zimm_forces::{ConstantForce, ReversePoiseuille};

/// A periodic space at rest that leaves positions where they are put.
#[derive(Clone)]
struct Unwrapped(Lattice);

impl Boundary for Unwrapped {
    fn min_image(&self, dr: DVec3) -> DVec3 {
        self.0.nearest(dr)
    }

    fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
        (r, IVec3::ZERO)
    }
}

impl Periodic for Unwrapped {
    fn lattice(&self) -> &Lattice {
        &self.0
    }
}

fn forces<B: Boundary>(
    field: &mut impl ForceField<B>,
    space: B,
    positions: Vec<DVec3>,
) -> Vec<DVec3> {
    let mut forces = vec![DVec3::ZERO; positions.len()];
    let particles = Particles::new(positions).unwrap();
    let system = System::new(space, particles, Clock::new(0.01, 1.0, 1).unwrap());
    let mut heard = (Virial::default(), Energy::default());
    field
        .accumulate(&system.frame(), &mut forces, &mut heard)
        .unwrap();
    assert_eq!(heard, (Virial::default(), Energy::default()));
    forces
}

fn triclinic() -> Lattice {
    let basis = DMat3::from_cols(
        DVec3::new(5.0, 0.3, -0.2),
        DVec3::new(1.1, 4.0, 0.4),
        DVec3::new(-0.7, 0.9, 6.0),
    );
    Lattice::new(basis).unwrap()
}

proptest! {
    #[test]
    fn law_reverse_poiseuille_conserves_momentum(
        positions in prop::collection::vec([-20.0..20.0, -20.0..20.0, -20.0..20.0], 1..60),
    ) {
        let positions: Vec<_> = positions.into_iter().map(DVec3::from_array).collect();
        let mut drive = ReversePoiseuille::new(0.3, 2, 0).unwrap();
        let felt = forces(&mut drive, Unwrapped(triclinic()), positions);
        let total: DVec3 = felt.iter().sum();
        prop_assert!(total.length() < 1e-13, "{}", total);
        prop_assert!(felt.iter().all(|f| f.x == 0.0 && f.y == 0.0 && f.z.abs() < 0.6));
    }

    #[test]
    fn law_reverse_poiseuille_is_the_same_for_all_images(
        s in [0.01..0.49, -0.49..0.49, -0.49..0.49], other in [-0.49..-0.01, -0.49..0.49, -0.49..0.49],
        shift in [-3..4, -3..4, -3..4],
    ) {
        let lattice = triclinic();
        let here = lattice.basis() * DVec3::from_array(s);
        let image = here + lattice.basis() * IVec3::from_array(shift).as_dvec3();
        let there = lattice.basis() * DVec3::from_array(other);
        let mut drive = ReversePoiseuille::new(0.3, 1, 0).unwrap();
        for r in [here, image] {
            let felt = forces(&mut drive, Unwrapped(lattice), vec![r, there]);
            prop_assert_eq!(felt, [0.3 * DVec3::Y, -0.3 * DVec3::Y]);
        }
    }
}

/// Three particles in one half and one in the other: the mean, f / 2, is taken off.
#[test]
fn limit_unequal_halves() {
    let space = || Unwrapped(Lattice::brick(DVec3::new(4.0, 8.0, 4.0)).unwrap());
    let positions = [3.9, 0.1, 2.0, -2.0].map(|y| DVec3::new(1.0, y, -1.0));
    let mut drive = ReversePoiseuille::new(2.0, 0, 1).unwrap();
    let felt = forces(&mut drive, space(), positions.to_vec());
    assert_eq!(felt, [1.0, 1.0, 1.0, -3.0].map(|f| f * DVec3::X));
    let felt = forces(&mut drive, space(), positions[2..].to_vec());
    assert_eq!(felt, [2.0 * DVec3::X, -2.0 * DVec3::X]);
}

#[test]
fn law_constant_force_is_added_to_all() {
    let push = DVec3::new(0.1, -0.2, 0.3);
    let mut gravity = ConstantForce::new(push).unwrap();
    let positions = vec![DVec3::ZERO, DVec3::ONE, 7.0 * DVec3::X];
    let felt = forces(&mut (gravity, gravity), Open, positions);
    assert_eq!(felt, [2.0 * push; 3]);
    assert_eq!(forces(&mut gravity, Open, Vec::new()), []);
}

#[test]
fn law_momentum_is_declared() {
    const {
        assert!(!<ConstantForce as ForceField<Open>>::CONSERVES_MOMENTUM);
        assert!(<ReversePoiseuille as ForceField<Unwrapped>>::CONSERVES_MOMENTUM);
    }
}

#[test]
fn extreme_no_particles() {
    let mut drive = ReversePoiseuille::new(0.3, 0, 1).unwrap();
    assert_eq!(forces(&mut drive, Unwrapped(triclinic()), Vec::new()), []);
}

#[test]
fn extreme_parameters_are_refused() {
    let not_finite = [f64::NAN, f64::INFINITY];
    assert_refused("force", &not_finite, |f| ReversePoiseuille::new(f, 0, 1));
    assert_refused("driving axis", &[3.0, 1e9], |axis| {
        ReversePoiseuille::new(1.0, axis as usize, 0)
    });
    assert_refused("gradient axis", &[2.0, 3.0], |axis| {
        ReversePoiseuille::new(1.0, 2, axis as usize)
    });
    assert_refused("x component of the force", &not_finite, |x| {
        ConstantForce::new(DVec3::new(x, 0.0, 0.0))
    });
    assert_refused("z component of the force", &not_finite, |z| {
        ConstantForce::new(DVec3::new(0.0, 0.0, z))
    });
}
