//! Springs by nearest image and by identity, and what stops them.

#![allow(clippy::unwrap_used)]

mod common;

use common::Cell;
use zimm_core::{
    BondForce, Bonded, Boundary, Clock, DMat3, DVec3, Energy, ForceError, ForceField, Item, Open,
    Particles, System, Virial,
};

/// F = -H Q / (1 - Q^2/b), the finitely extensible spring of Warner with H = 2 and b = 4.
#[derive(Clone, Copy)]
struct Warner;

impl BondForce for Warner {
    fn force(&self, r2: f64) -> f64 {
        -2.0 / (1.0 - r2 / 4.0)
    }

    fn energy(&self, r2: f64) -> f64 {
        -4.0 * (1.0 - r2 / 4.0).ln()
    }

    fn limit(&self) -> f64 {
        2.0
    }
}

/// F = -Q.
#[derive(Clone, Copy)]
struct Hooke;

impl BondForce for Hooke {
    fn force(&self, _: f64) -> f64 {
        -1.0
    }

    fn energy(&self, r2: f64) -> f64 {
        0.5 * r2
    }
}

fn system<B: Boundary>(boundary: B, positions: Vec<DVec3>) -> System<B> {
    let particles = Particles::new(positions).unwrap();
    System::new(boundary, particles, Clock::new(0.01, 1.0, 0).unwrap())
}

fn brick(x: f64, y: f64, z: f64) -> Cell<false> {
    Cell::at_rest(DMat3::from_diagonal(DVec3::new(x, y, z)))
}

fn forces<B: Boundary, S: BondForce>(
    system: &System<B>,
    spring: S,
    bonds: &[[u32; 2]],
) -> Result<(Vec<DVec3>, Virial, f64), ForceError> {
    let mut forces = vec![DVec3::ZERO; system.particles.len()];
    let mut tally = (Virial::default(), Energy::default());
    Bonded::new(spring, bonds.to_vec()).accumulate(&system.frame(), &mut forces, &mut tally)?;
    Ok((forces, tally.0, tally.1.0))
}

/// At Q = 1 the spring pulls with 2 / (1 - 1/4) = 8/3 and holds -4 ln(3/4).
#[test]
fn limit_a_bond_across_the_border_is_the_nearest_image() {
    let system = system(
        brick(8.0, 8.0, 8.0),
        vec![DVec3::new(3.75, 0.0, 0.0), DVec3::new(-3.25, 0.0, 0.0)],
    );
    let (forces, virial, energy) = forces(&system, Warner, &[[0, 1]]).unwrap();
    assert_eq!(forces, [8.0 / 3.0 * DVec3::X, -8.0 / 3.0 * DVec3::X]);
    assert!((energy + 4.0 * 0.75_f64.ln()).abs() < 1e-15);
    assert_eq!(virial.total(), virial.item(Item::Spring));
    assert_eq!(virial.total().x_axis, -8.0 / 3.0 * DVec3::X);
}

/// After a shear of 1/2 the upper image of the origin of a cube of edge 8 lies at (4, 8, 0).
#[test]
fn limit_a_bond_follows_the_images_of_the_flow() {
    let shear = DMat3::from_cols(DVec3::ZERO, DVec3::X, DVec3::ZERO);
    let cube = DMat3::from_diagonal(DVec3::splat(8.0));
    let mut system = system(Cell::flowing(cube, shear), vec![DVec3::ZERO; 2]);
    system.boundary.advance(0.5);
    system.particles.positions_mut()[1] = DVec3::new(3.5, 7.0, 0.0);
    let (forces, _, _) = forces(&system, Hooke, &[[0, 1]]).unwrap();
    assert!((forces[0] - DVec3::new(-0.5, -1.0, 0.0)).length() < 1e-14);
}

#[test]
fn law_bonds_go_by_identity() {
    let positions = vec![
        DVec3::ZERO,
        DVec3::X,
        DVec3::new(1.0, 1.0, 0.0),
        5.0 * DVec3::Z,
    ];
    let mut system = system(Open, positions);
    let bonds = [[0, 1], [1, 2]];
    let (before, _, _) = forces(&system, Warner, &bonds).unwrap();
    system.particles.permute(&[3, 1, 0, 2]).unwrap();
    let (after, _, _) = forces(&system, Warner, &bonds).unwrap();
    assert_eq!(after, [before[3], before[1], before[0], before[2]]);
}

#[test]
fn law_springs_add_up_and_are_added() {
    let system = system(Open, vec![DVec3::ZERO, DVec3::X]);
    let (both, _, energy) = forces(&system, (Warner, Hooke), &[[0, 1]]).unwrap();
    assert!((both[0] - (8.0 / 3.0 + 1.0) * DVec3::X).length() < 1e-15);
    assert!((energy - (0.5 - 4.0 * 0.75_f64.ln())).abs() < 1e-15);
    assert_eq!((Warner, Hooke).limit(), 2.0);
    let mut sum = vec![DVec3::Y, DVec3::Y];
    let mut field = Bonded::new(Hooke, vec![[0, 1]]);
    field
        .accumulate(&system.frame(), &mut sum, &mut ())
        .unwrap();
    assert_eq!(sum, [DVec3::Y + DVec3::X, DVec3::Y - DVec3::X]);
}

#[test]
fn extreme_an_overstretched_spring_is_an_error() {
    let positions = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 2.5, 0.0)];
    let error = forces(&system(Open, positions), Warner, &[[0, 1], [2, 1]]).unwrap_err();
    let expected = ForceError::Overstretched {
        bond: 1,
        i: 2,
        j: 1,
        length: 2.5,
        limit: 2.0,
    };
    assert_eq!(error, expected);
    for length in [2.0_f64.next_down(), 2.0] {
        let system = system(Open, vec![DVec3::ZERO, length * DVec3::Z]);
        assert_eq!(forces(&system, Warner, &[[0, 1]]).is_ok(), length < 2.0);
    }
    let mut system = system(Open, vec![DVec3::ZERO, DVec3::X]);
    system.particles.positions_mut()[0].x = f64::NAN;
    assert!(forces(&system, Warner, &[[0, 1]]).is_err());
    assert!(forces(&system, Hooke, &[[0, 1]]).is_err());
}

/// The shortest lattice vector is 3, so nearest images are unique below 1.5; the bond is 4 long along the long edge.
#[test]
fn extreme_a_bond_that_the_cell_cannot_resolve_is_an_error() {
    let system = system(brick(3.0, 20.0, 20.0), vec![DVec3::ZERO, 4.0 * DVec3::Y]);
    let expected = ForceError::BeyondCell {
        bond: 0,
        i: 1,
        j: 0,
        length: 4.0,
        reach: 1.5,
    };
    assert_eq!(forces(&system, Hooke, &[[1, 0]]).unwrap_err(), expected);
    let open = self::system(Open, vec![DVec3::ZERO, 4.0 * DVec3::Y]);
    assert!(forces(&open, Hooke, &[[1, 0]]).is_ok());
}

#[test]
fn extreme_a_bond_to_nobody_is_an_error() {
    let mut system = system(Open, vec![DVec3::ZERO, DVec3::X]);
    for _ in 0..2 {
        for bonds in [[[0, 1], [0, 2]], [[0, 1], [2, 0]]] {
            let expected = ForceError::NoSuchParticle {
                bond: 1,
                identity: 2,
                particles: 2,
            };
            assert_eq!(forces(&system, Hooke, &bonds).unwrap_err(), expected);
        }
        system.particles.permute(&[1, 0]).unwrap();
    }
}

#[test]
fn extreme_a_bond_of_no_length_pulls_nowhere() {
    let system = system(Open, vec![DVec3::ONE; 2]);
    let (forces, _, energy) = forces(&system, Warner, &[[0, 1], [1, 1]]).unwrap();
    assert_eq!((forces, energy), (vec![DVec3::ZERO; 2], 0.0));
}
