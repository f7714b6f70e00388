//! Particles, clock and system: what they hold, what they refuse, and image counts across changes of basis.

#![allow(clippy::unwrap_used)]

mod common;

use common::Cell;
use proptest::prelude::*;
use zimm_core::{
    Boundary, Clock, DMat3, DVec3, IVec3, Lattice, Open, ParameterError, ParticleError, Particles,
    Periodic, Remap, System, start,
};

fn three() -> Particles {
    Particles::new(vec![DVec3::X, DVec3::Y, DVec3::Z]).unwrap()
}

fn clock() -> Clock {
    Clock::new(0.1, 1.0, 7).unwrap()
}

#[test]
fn law_an_empty_column_stands_for_its_default() {
    let system = System::new(Open, three(), clock());
    let frame = system.frame();
    assert_eq!((frame.mass(2), frame.species(2), frame.id(2)), (1.0, 0, 2));
    assert_eq!((frame.place(2), frame.place(3)), (Some(2), None));
    assert_eq!(frame.unwrapped(0), None);
    assert!(frame.velocities.is_empty() && frame.images.is_empty() && !frame.is_empty());
}

#[test]
fn law_a_permutation_takes_every_column_along() {
    let mut particles = three()
        .with_velocities(vec![DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z])
        .unwrap()
        .with_masses(vec![1.0, 2.0, 3.0])
        .unwrap()
        .with_species(vec![4, 5, 6])
        .unwrap()
        .counting_images();
    particles.columns_mut().images[2] = IVec3::ONE;
    *particles.columns_mut().forces = vec![DVec3::X, DVec3::Y, DVec3::Z];
    particles.permute(&[2, 0, 1]).unwrap();
    assert_eq!(particles.ids(), [2, 0, 1]);
    particles.permute(&[1, 2, 0]).unwrap();
    assert_eq!(particles.ids(), [0, 1, 2]);
    particles.permute(&[1, 0, 2]).unwrap();
    assert_eq!(particles.positions(), [DVec3::Y, DVec3::X, DVec3::Z]);
    assert_eq!(
        particles.velocities(),
        [DVec3::NEG_Y, DVec3::NEG_X, DVec3::NEG_Z]
    );
    assert_eq!(particles.forces(), [DVec3::Y, DVec3::X, DVec3::Z]);
    assert_eq!(particles.masses(), [2.0, 1.0, 3.0]);
    assert_eq!(particles.species(), [5, 4, 6]);
    assert_eq!(particles.images(), [IVec3::ZERO, IVec3::ZERO, IVec3::ONE]);
    let system = System::new(Open, particles, clock());
    let places = [0, 1, 2, 3].map(|id| system.frame().place(id));
    assert_eq!(places, [Some(1), Some(0), Some(2), None]);
}

#[test]
fn law_forces_are_forgotten_when_what_they_depend_on_may_change() {
    let mut particles = three().with_velocities(vec![DVec3::ZERO; 3]).unwrap();
    let forces = vec![DVec3::ONE; 3];
    particles.columns_mut().forces.clone_from(&forces);
    assert_eq!(particles.forces(), forces);
    particles.positions_mut();
    assert!(particles.forces().is_empty());
    particles.columns_mut().forces.clone_from(&forces);
    particles.velocities_mut();
    assert!(particles.forces().is_empty());
}

#[test]
fn extreme_columns_of_another_length_are_refused() {
    let length = |column, found| {
        Err(ParticleError::Length {
            column,
            found,
            particles: 3,
        })
    };
    assert_eq!(
        three().with_velocities(vec![DVec3::ZERO; 2]),
        length("velocities", 2)
    );
    assert_eq!(three().with_masses(vec![]), length("masses", 0));
    assert_eq!(three().with_species(vec![0; 4]), length("species", 4));
    assert_eq!(three().with_ids(vec![0, 1]), length("ids", 2));
    assert_eq!(
        three().permute(&[0, 1]),
        length("order", 2).map(|_: Particles| ())
    );
}

#[test]
fn extreme_values_that_are_not_finite_are_refused() {
    for bad in [f64::INFINITY, f64::NEG_INFINITY] {
        let vector = DVec3::new(1.0, bad, 0.0);
        let error = |column, particle| {
            Err(ParticleError::NotFinite {
                column,
                particle,
                value: [1.0, bad, 0.0],
            })
        };
        assert_eq!(
            Particles::new(vec![DVec3::ZERO, vector]),
            error("positions", 1)
        );
        let velocities = vec![DVec3::ZERO, DVec3::ZERO, vector];
        assert_eq!(three().with_velocities(velocities), error("velocities", 2));
    }
    assert!(Particles::new(vec![DVec3::NAN]).is_err());
    assert!(three().with_velocities(vec![DVec3::NAN; 3]).is_err());
}

#[test]
fn extreme_masses_that_are_not_above_zero_are_refused() {
    for mass in [0.0, -1.0, f64::INFINITY] {
        let error = Err(ParticleError::Mass { particle: 1, mass });
        assert_eq!(three().with_masses(vec![1.0, mass, 1.0]), error);
    }
    assert!(three().with_masses(vec![1.0, 1.0, f64::NAN]).is_err());
}

#[test]
fn extreme_identities_that_are_no_permutation_are_refused() {
    let error = |particle, identity| ParticleError::Identity {
        particle,
        identity,
        particles: 3,
    };
    assert_eq!(three().with_ids(vec![0, 2, 0]), Err(error(2, 0)));
    assert_eq!(three().with_ids(vec![0, 3, 1]), Err(error(1, 3)));
    assert_eq!(
        three().with_ids(vec![u32::MAX, 0, 1]),
        Err(error(0, u32::MAX))
    );
    let mut particles = three();
    assert_eq!(particles.permute(&[1, 1, 2]), Err(error(1, 1)));
    assert_eq!(particles, three());
}

#[test]
fn extreme_clocks_that_do_not_run_are_refused() {
    let refused = |dt, kt| Clock::new(dt, kt, 0).unwrap_err().name;
    assert_eq!((refused(0.0, 1.0), refused(-0.1, 1.0)), ("dt", "dt"));
    assert_eq!(
        (refused(f64::NAN, 1.0), refused(f64::INFINITY, 1.0)),
        ("dt", "dt")
    );
    assert_eq!((refused(0.1, -1.0), refused(0.1, f64::NAN)), ("kt", "kt"));
    assert!(Clock::new(0.1, 0.0, 0).is_ok());
    let error = ParameterError::new("dt", -1.0, "finite and above zero");
    assert_eq!(clock().set_dt(-1.0), Err(error));
}

#[test]
fn law_time_is_counted_and_not_summed() {
    let mut clock = clock();
    for _ in 0..100_000 {
        clock.tick();
    }
    assert_eq!(
        (clock.now().step, clock.now().time),
        (100_000, 100_000.0 * 0.1)
    );
    clock.set_dt(0.025).unwrap();
    assert_eq!(clock.now().time, 100_000.0 * 0.1);
    assert_eq!(clock.next().time, 100_000.0 * 0.1 + 0.025);
    assert_eq!(
        (clock.now().dt, clock.now().seed, clock.next().step),
        (0.025, 7, 100_001)
    );
}

/// Unwrapped positions follow the flow through every change of basis: x(t) = exp(kappa t) x(0).
fn check_unwrapped(
    basis: DMat3,
    gradient: DMat3,
    dt: f64,
    steps: usize,
    seed: u64,
) -> Result<u32, TestCaseError> {
    let mut rng = start::stream(seed);
    let boundary = Cell::flowing(basis, gradient);
    let positions: Vec<DVec3> = start::uniform(boundary.lattice(), 20, &mut rng)
        .iter()
        .map(|&r| 3.0 * r)
        .collect();
    let particles = Particles::new(positions.clone()).unwrap().counting_images();
    let mut system = System::new(boundary, particles, Clock::new(dt, 1.0, 0).unwrap());
    let mut changes = 0;
    for _ in 0..steps {
        let before = system.clock.now().time;
        system.clock.tick();
        let now = system.clock.now().time;
        let carry = system.boundary.carry(before, now);
        let remap = system.boundary.advance(now);
        changes += u32::from(remap != Remap::None);
        let columns = system.particles.columns_mut();
        for (r, count) in columns.positions.iter_mut().zip(columns.images) {
            let (folded, taken) = system.boundary.wrap(carry * *r);
            *r = folded;
            *count = remap.apply(*count) + taken;
        }
        let carry = system.boundary.carry(0.0, now);
        let scale = 1e-11 * carry.to_cols_array().map(f64::abs).iter().sum::<f64>();
        for (k, &start) in positions.iter().enumerate() {
            let found = system.frame().unwrapped(k).unwrap();
            let expected = carry * start;
            prop_assert!(
                (found - expected).length() < scale * start.length(),
                "{found} not {expected}"
            );
        }
    }
    Ok(changes)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(50))]

    #[test]
    fn law_unwrapped_positions_go_through_changes_of_basis(
        entries in [-3.0..3.0, -3.0..3.0, -3.0..3.0, -3.0..3.0, -3.0..3.0, -3.0..3.0, -3.0..3.0, -3.0..3.0, -3.0..3.0],
        rate in -3.0..3.0,
        seed: u64,
    ) {
        let basis = DMat3::from_cols_array(&entries);
        prop_assume!(basis.determinant().abs() > 1.0);
        let shear = DMat3::from_cols(DVec3::ZERO, rate * DVec3::X, DVec3::ZERO);
        check_unwrapped(basis, shear, 0.05, 60, seed)?;
    }
}

/// A brick of edges 4, 5, 6 in shear changes its basis at strains of 0.4, 1.2, 2.0, .., five times up to 4.
#[test]
fn law_a_sheared_brick_changes_its_basis_whenever_it_has_slid_by_a_cell() {
    let brick = DMat3::from_diagonal(DVec3::new(4.0, 5.0, 6.0));
    let shear = DMat3::from_cols(DVec3::ZERO, DVec3::X, DVec3::ZERO);
    assert_eq!(check_unwrapped(brick, shear, 0.01, 395, 1).unwrap(), 5);
    assert_eq!(check_unwrapped(brick, -shear, 0.01, 395, 1).unwrap(), 5);
}

/// The cell of Kraynik and Reinelt comes back to itself at a Hencky strain of ln((3 + sqrt 5) / 2) = 0.962.
#[test]
fn law_unwrapped_positions_go_through_planar_extension() {
    let angle = ((5.0_f64.sqrt() - 1.0) / 2.0).atan();
    let cell = DMat3::from_rotation_z(angle) * DMat3::from_diagonal(DVec3::splat(5.0));
    let extension = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 0.0));
    assert!(check_unwrapped(cell, extension, 0.02, 200, 2).unwrap() >= 4);
}

#[test]
fn law_a_remap_is_the_change_of_basis() {
    let lattice = Lattice::brick(DVec3::new(2.0, 3.0, 4.0)).unwrap();
    assert_eq!(Remap::between(lattice.basis(), &lattice), Remap::None);
    assert_eq!(
        Remap::None.apply(IVec3::new(1, -2, 3)),
        IVec3::new(1, -2, 3)
    );
    // b2 = (2, 3, 0) is a1 + a2: a count of n2 along it is n2 along both.
    let carried = DMat3::from_cols(2.0 * DVec3::X, DVec3::new(2.0, 3.0, 0.0), 4.0 * DVec3::Z);
    let remap = Remap::between(carried, &lattice);
    assert_eq!(remap.apply(IVec3::new(1, -2, 3)), IVec3::new(-1, -2, 3));
    let count = IVec3::new(i32::MAX, 0, i32::MIN);
    assert_eq!(remap.apply(count), count);
}

#[test]
fn law_wrapping_at_rest_counts_the_cells_crossed() {
    let brick = DMat3::from_diagonal(DVec3::new(2.0, 3.0, 4.0));
    let positions = vec![DVec3::new(7.25, -9.5, 0.25)];
    let particles = Particles::new(positions).unwrap().counting_images();
    let system = System::new(Cell::at_rest(brick), particles, clock());
    assert_eq!(
        system.particles.positions(),
        [DVec3::new(-0.75, -0.5, 0.25)]
    );
    assert_eq!(system.particles.images(), [IVec3::new(4, -3, 0)]);
}

#[test]
fn law_a_system_begins_in_the_primary_cell_at_its_time() {
    let positions = vec![DVec3::new(7.0, -9.5, 0.25), DVec3::ZERO];
    let particles = Particles::new(positions.clone()).unwrap().counting_images();
    let shear = DMat3::from_cols(DVec3::ZERO, DVec3::X, DVec3::ZERO);
    let brick = DMat3::from_diagonal(DVec3::new(2.0, 3.0, 4.0));
    let mut clock = clock();
    (0..3).for_each(|_| clock.tick());
    let system = System::new(Cell::flowing(brick, shear), particles, clock);
    let tilt = system.boundary.cell().unwrap().y_axis;
    assert!((tilt - DVec3::new(0.9, 3.0, 0.0)).length() < 1e-14);
    assert_eq!(system.particles.images()[0].y, -3);
    for (k, &r) in positions.iter().enumerate() {
        let folded = system.boundary.lattice().inverse() * system.particles.positions()[k];
        assert!(folded.abs().max_element() <= 0.5);
        assert!((system.frame().unwrapped(k).unwrap() - r).length() < 1e-14);
    }
}
