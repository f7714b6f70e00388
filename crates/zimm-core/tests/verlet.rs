//! The Verlet list against all pairs: none missed, none twice, at every step of every motion.

#![allow(clippy::unwrap_used)]

mod common;

use common::Cell;
use proptest::prelude::*;
use rand_distr::{Distribution, StandardUniform, UnitBall};
use zimm_core::{
    AllPairs, Boundary, Clock, DMat3, DVec3, Lattice, ListError, Neighbours, Particles, Periodic,
    System, VerletList, start,
};

/// A pair by place in the frame, lower place first, and its separation.
type Found = ([u32; 2], DVec3);

/// The pairs of a source within the cutoff.
fn pairs<B: Periodic, N: Neighbours<B>>(source: &N, cutoff: f64) -> Vec<Found> {
    let mut found = Vec::new();
    for block in 0..source.blocks() {
        source.visit(block, |row| {
            for &j in row.js {
                let [here, there] = [row.i, j].map(|k| source.positions()[k as usize]);
                let r = here + row.shift - there;
                let [i, j] = [row.i, j].map(|k| source.order()[k as usize]);
                if r.length() < cutoff {
                    found.push(if i < j { ([i, j], r) } else { ([j, i], -r) });
                }
            }
        });
    }
    found.sort_by_key(|&(pair, _)| pair);
    found
}

/// The same from nearest images, for many particles: those whose lattice planes are further apart than the cutoff are
/// left out before their image is looked for.
fn pairs_by_images<B: Periodic>(system: &System<B>, cutoff: f64) -> Vec<Found> {
    let (lattice, positions) = (system.boundary.lattice(), system.particles.positions());
    let (inverse, widths) = (lattice.inverse(), lattice.widths());
    let mut found = Vec::new();
    for i in 0..positions.len() {
        for j in i + 1..positions.len() {
            let apart = positions[i] - positions[j];
            let s = inverse * apart;
            if ((s - s.round()).abs() * widths).max_element() > cutoff {
                continue;
            }
            let r = system.boundary.min_image(apart);
            if r.length() < cutoff {
                found.push(([i as u32, j as u32], r));
            }
        }
    }
    found
}

/// The same pairs, each once, at the same separation. Distances within 1e-9 of the cutoff may round to either side.
fn same(mut found: Vec<Found>, mut expected: Vec<Found>, cutoff: f64) -> Result<(), TestCaseError> {
    for pairs in [&mut found, &mut expected] {
        pairs.retain(|(_, r)| (r.length() - cutoff).abs() > 1e-9);
    }
    let names = |pairs: &[Found]| pairs.iter().map(|&(pair, _)| pair).collect::<Vec<_>>();
    prop_assert_eq!(names(&found), names(&expected));
    for (&(pair, r), &(_, nearest)) in found.iter().zip(&expected) {
        let off = (r - nearest).length();
        prop_assert!(off < 1e-10, "{pair:?}: {r} against {nearest}");
    }
    Ok(())
}

/// Refreshes the list and compares it with all pairs, their errors included.
fn same_as_all_pairs<B: Periodic>(
    list: &mut VerletList,
    system: &System<B>,
    cutoff: f64,
) -> Result<(), TestCaseError> {
    let (mut all, frame) = (AllPairs::default(), system.frame());
    let expected = all.refresh(&frame, cutoff).map(|_| ());
    let answer = list.refresh(&frame, cutoff).map(|_| ());
    prop_assert_eq!(&answer, &expected);
    let most = frame.boundary.reach();
    if cutoff > most {
        let images = 2.0 * most;
        let wide = ListError::Cutoff {
            cutoff,
            images,
            most,
        };
        prop_assert_eq!(answer, Err(wide));
        return Ok(());
    }
    prop_assert_eq!(answer, Ok(()));
    same(
        pairs::<B, _>(list, cutoff),
        pairs::<B, _>(&all, cutoff),
        cutoff,
    )
}

/// One step: everything is carried by the flow, then jumps at random up to `jump`, then is folded.
fn advance<B: Periodic>(system: &mut System<B>, jump: f64, rng: &mut impl rand::Rng) {
    let before = system.clock.now().time;
    system.clock.tick();
    let now = system.clock.now().time;
    let carry = system.boundary.carry(before, now);
    system.boundary.advance(now);
    for r in system.particles.positions_mut() {
        let kick = jump * DVec3::from_array(UnitBall.sample(rng));
        *r = system.boundary.wrap(carry * *r + kick).0;
    }
}

fn vector(limit: f64) -> impl Strategy<Value = DVec3> {
    [-limit..limit, -limit..limit, -limit..limit].prop_map(DVec3::from_array)
}

fn matrix(limit: f64) -> impl Strategy<Value = DMat3> {
    [vector(limit), vector(limit), vector(limit)].prop_map(|[a, b, c]| DMat3::from_cols(a, b, c))
}

/// Cells of any shape and tilt: edges 2 to 8, vectors spanning at least a tenth of their box.
fn basis() -> impl Strategy<Value = DMat3> {
    matrix(6.0).prop_filter("spans a volume", |h| {
        h.determinant().abs() > 0.1 * h.x_axis.length() * h.y_axis.length() * h.z_axis.length()
    })
}

/// Shear, planar extension, and any incompressible flow, at rates up to 10.
fn gradient() -> impl Strategy<Value = DMat3> {
    let shear =
        (-10.0..10.0).prop_map(|rate| DMat3::from_cols(DVec3::ZERO, rate * DVec3::X, DVec3::ZERO));
    let extension =
        (-10.0..10.0).prop_map(|rate| DMat3::from_diagonal(DVec3::new(rate, -rate, 0.0)));
    let any = matrix(5.0).prop_map(|m| {
        let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
        m - DMat3::from_diagonal(DVec3::splat(trace / 3.0))
    });
    prop_oneof![shear, extension, any]
}

#[derive(Clone, Debug)]
struct Scene {
    basis: DMat3,
    particles: usize,
    clustered: bool,
    skin: f64,
    jump: f64,
    /// Of the largest cutoff that the cell allows.
    cutoff: f64,
    seed: u64,
}

fn scene() -> impl Strategy<Value = Scene> {
    (
        basis(),
        prop_oneof![Just(0_usize), Just(1), Just(2), 3_usize..60, 60_usize..300],
        any::<bool>(),
        prop_oneof![Just(0.0), 0.0..2.0],
        prop_oneof![Just(0.0), 0.0..0.05, 0.0..0.5],
        prop_oneof![Just(1.0), 0.2..1.0],
        any::<u64>(),
    )
        .prop_map(
            |(basis, particles, clustered, skin, jump, cutoff, seed)| Scene {
                basis,
                particles,
                clustered,
                skin,
                jump,
                cutoff,
                seed,
            },
        )
}

impl Scene {
    /// Particles anywhere, or on three points close to each other of which one lies in a corner of the cell.
    fn positions(&self, lattice: &Lattice, rng: &mut impl rand::Rng) -> Vec<DVec3> {
        let mut positions = start::uniform(lattice, self.particles, rng);
        if self.clustered {
            let corner = lattice.basis() * DVec3::splat(0.5);
            for (k, r) in positions.iter_mut().enumerate() {
                *r = corner + 0.1 * (k % 3) as f64 * DVec3::new(1.0, 1.0, -1.0);
            }
        }
        positions
    }

    fn run<B: Periodic>(&self, boundary: B, dt: f64, steps: usize) -> Result<(), TestCaseError> {
        let mut rng = start::stream(self.seed);
        let positions = self.positions(boundary.lattice(), &mut rng);
        let cutoff = self.cutoff * boundary.reach();
        let particles = Particles::new(positions).unwrap();
        let mut system = System::new(boundary, particles, Clock::new(dt, 1.0, 0).unwrap());
        let mut list = VerletList::new(self.skin).unwrap();
        for _ in 0..steps {
            same_as_all_pairs(&mut list, &system, cutoff)?;
            if cutoff > system.boundary.reach() {
                break;
            }
            let part: f64 = StandardUniform.sample(&mut rng);
            advance(&mut system, part * self.jump, &mut rng);
        }
        Ok(())
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(120))]

    #[test]
    fn law_no_pair_is_missed_at_rest(scene in scene()) {
        scene.run(Cell::at_rest(scene.basis), 0.01, 12)?;
    }

    /// Strain goes up by as much as 0.2 a step.
    #[test]
    fn law_no_pair_is_missed_in_flow(scene in scene(), gradient in gradient(), dt in 0.001..0.02) {
        scene.run(Cell::flowing(scene.basis, gradient), dt, 20)?;
    }
}

fn shear(rate: f64) -> DMat3 {
    DMat3::from_cols(DVec3::ZERO, rate * DVec3::X, DVec3::ZERO)
}

fn planar_extension(rate: f64) -> DMat3 {
    DMat3::from_diagonal(DVec3::new(rate, -rate, 0.0))
}

fn cube(edge: f64) -> DMat3 {
    DMat3::from_diagonal(DVec3::splat(edge))
}

fn system<B: Periodic>(boundary: B, positions: Vec<DVec3>, dt: f64) -> System<B> {
    let particles = Particles::new(positions).unwrap();
    System::new(boundary, particles, Clock::new(dt, 1.0, 0).unwrap())
}

/// Four periods of the square cell of Kraynik and Reinelt (1992), which planar extension maps onto itself whenever
/// the strain has grown by ln((3 + sqrt 5) / 2); its sides lie at atan((sqrt 5 - 1) / 2) to the axes.
#[test]
fn law_no_pair_is_missed_in_planar_extension_without_end() {
    let mut rng = start::stream(1);
    let angle = ((5.0_f64.sqrt() - 1.0) / 2.0).atan();
    let boundary = Cell::flowing(
        DMat3::from_rotation_z(angle) * cube(9.0),
        planar_extension(10.0),
    );
    let positions = start::uniform(boundary.lattice(), 1200, &mut rng);
    let mut system = system(boundary, positions, 0.01);
    let mut list = VerletList::new(0.3).unwrap();
    for _ in 0..40 {
        assert!(system.boundary.reach() > 4.0);
        list.refresh(&system.frame(), 1.0).unwrap();
        let found = pairs::<Cell<true>, _>(&list, 1.0);
        same(found, pairs_by_images(&system, 1.0), 1.0).unwrap();
        advance(&mut system, 0.03, &mut rng);
    }
    assert!(list.builds() < 40);
}

#[test]
fn law_no_pair_is_missed_by_several_blocks_of_work() {
    let mut rng = start::stream(2);
    let boundary = Cell::flowing(cube(13.0), shear(1.0));
    let positions = start::uniform(boundary.lattice(), 7000, &mut rng);
    let mut system = system(boundary, positions, 0.1);
    let mut list = VerletList::new(0.4).unwrap();
    for _ in 0..3 {
        list.refresh(&system.frame(), 1.0).unwrap();
        assert!(Neighbours::<Cell<true>>::blocks(&list) > 1);
        let found = pairs::<Cell<true>, _>(&list, 1.0);
        same(found, pairs_by_images(&system, 1.0), 1.0).unwrap();
        advance(&mut system, 0.05, &mut rng);
    }
    assert!(list.builds() < 3);
}

/// Cells from a hundred to 1e12 times as wide as the cutoff, where positions in single precision tell nothing of a pair;
/// half of the partners are just within the cutoff, across faces and edges of the cell among others, half just beyond.
#[test]
fn extreme_no_pair_is_missed_in_huge_cells() {
    for edge in [1e2, 1e4, 1e6, 1e9, 1e12] {
        let mut rng = start::stream(8);
        let boundary = Cell::at_rest(cube(edge));
        let mut positions = start::uniform(boundary.lattice(), 100, &mut rng);
        for r in positions.iter_mut().take(50) {
            r.x = 0.5 * edge - 0.3;
        }
        for k in 0..100 {
            let towards = DVec3::from_array(rand_distr::UnitSphere.sample(&mut rng));
            let distance = if k % 2 == 0 { 0.999 } else { 1.001 };
            positions.push(boundary.wrap(positions[k] + distance * towards).0);
        }
        let system = system(boundary, positions, 1.0);
        let mut list = VerletList::new(0.0).unwrap();
        list.refresh(&system.frame(), 1.0).unwrap();
        let found = pairs::<Cell<false>, _>(&list, 1.0);
        let expected = pairs_by_images(&system, 1.0);
        assert_eq!(expected.len(), 50, "{edge}");
        let named = |pairs: &[Found]| pairs.iter().map(|pair| pair.0).collect::<Vec<_>>();
        assert_eq!(named(&found), named(&expected), "{edge}");
    }
}

#[test]
fn law_candidates_are_the_pairs_within_cutoff_and_skin() {
    let mut rng = start::stream(3);
    let boundary = Cell::at_rest(cube(6.0));
    let positions = start::uniform(boundary.lattice(), 400, &mut rng);
    let system = system(boundary, positions, 1.0);
    let (mut all, mut list) = (AllPairs::default(), VerletList::new(0.7).unwrap());
    all.refresh(&system.frame(), 1.9).unwrap();
    list.refresh(&system.frame(), 1.2).unwrap();
    assert_eq!(list.candidates(), pairs::<Cell<false>, _>(&all, 1.9).len());
}

/// Steps of strain 0.01 that the list of cutoff 1 and skin 0.5 outlives when particles are carried and nothing else.
fn strain_steps_of_one_list(gradient: DMat3, most: u64) -> u64 {
    let boundary = Cell::flowing(cube(8.0), gradient);
    let positions = start::uniform(boundary.lattice(), 200, &mut start::stream(4));
    let mut system = system(boundary, positions.clone(), 0.01);
    let mut list = VerletList::new(0.5).unwrap();
    for step in 0..=most {
        list.refresh(&system.frame(), 1.0).unwrap();
        if list.builds() == 2 {
            return step - 1;
        }
        system.clock.tick();
        let time = system.clock.now().time;
        system.boundary.advance(time);
        let carry = system.boundary.carry(0.0, time);
        for (r, &start) in system.particles.positions_mut().iter_mut().zip(&positions) {
            *r = system.boundary.wrap(carry * start).0;
        }
    }
    most
}

/// The least stretch s of a shear gamma is sqrt(1 + gamma^2/4) - gamma/2, of an extension by eps exp(-eps); it falls
/// to 1/1.5 at gamma = 5/6 and eps = ln 1.5 = 0.405. A rotation stretches nothing.
#[test]
fn limit_a_list_lives_until_the_flow_has_used_up_its_skin() {
    assert_eq!(strain_steps_of_one_list(shear(1.0), 200), 83);
    assert_eq!(strain_steps_of_one_list(planar_extension(1.0), 200), 40);
    let rotation = DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::ZERO);
    assert_eq!(strain_steps_of_one_list(rotation, 400), 400);
}

#[test]
fn limit_a_list_lives_until_two_displacements_have_used_up_its_skin() {
    let builds = |moves: [f64; 2]| {
        let boundary = Cell::at_rest(cube(8.0));
        let positions = vec![DVec3::ZERO, DVec3::splat(2.0), DVec3::splat(-2.0)];
        let mut system = system(boundary, positions, 1.0);
        let mut list = VerletList::new(0.5).unwrap();
        list.refresh(&system.frame(), 1.0).unwrap();
        system.particles.positions_mut()[0].y += moves[0];
        system.particles.positions_mut()[2].z -= moves[1];
        list.refresh(&system.frame(), 1.0).unwrap();
        list.builds()
    };
    assert_eq!(builds([0.0, 0.0]), 1);
    assert_eq!(builds([0.499, 0.0]), 1);
    assert_eq!(builds([0.501, 0.0]), 2);
    assert_eq!(builds([0.3, 0.199]), 1);
    assert_eq!(builds([0.3, 0.201]), 2);
}

#[test]
fn law_a_list_is_made_anew_for_another_cutoff_another_number_and_when_it_forgets() {
    let boundary = Cell::at_rest(cube(8.0));
    let three = system(boundary.clone(), vec![DVec3::ZERO; 3], 1.0);
    let two = system(boundary, vec![DVec3::ZERO; 2], 1.0);
    let mut list = VerletList::new(1.0).unwrap();
    let mut refresh = |system: &System<Cell<false>>, cutoff, forget| {
        if forget {
            Neighbours::<Cell<false>>::forget(&mut list);
        }
        let changed = list.refresh(&system.frame(), cutoff).unwrap();
        (changed, list.builds())
    };
    assert_eq!(refresh(&three, 1.0, false), (true, 1));
    assert_eq!(refresh(&three, 1.0, false), (false, 1));
    assert_eq!(refresh(&three, 0.9, false), (true, 2));
    assert_eq!(refresh(&two, 0.9, false), (true, 3));
    assert_eq!(refresh(&two, 0.9, true), (true, 4));
}

#[test]
fn extreme_a_cutoff_wider_than_the_cell_or_below_zero_is_an_error() {
    let tilted = DMat3::from_cols(4.0 * DVec3::X, DVec3::new(1.0, 2.0, 0.0), 9.0 * DVec3::Z);
    let system = system(Cell::at_rest(tilted), vec![DVec3::ZERO; 2], 1.0);
    let images = 5.0_f64.sqrt();
    let mut list = VerletList::new(0.5).unwrap();
    assert_eq!(list.refresh(&system.frame(), images / 2.0), Ok(true));
    for cutoff in [1.2, f64::INFINITY, -0.5] {
        let most = images / 2.0;
        let wide = ListError::Cutoff {
            cutoff,
            images,
            most,
        };
        assert_eq!(list.refresh(&system.frame(), cutoff), Err(wide));
    }
    assert!(list.refresh(&system.frame(), f64::NAN).is_err());
}

#[test]
fn extreme_a_position_that_is_not_finite_is_an_error_that_names_the_particle() {
    let boundary = Cell::at_rest(cube(8.0));
    let positions = start::uniform(boundary.lattice(), 50, &mut start::stream(5));
    let mut system = system(boundary, positions, 1.0);
    let good = system.particles.positions()[31];
    let mut list = VerletList::new(0.5).unwrap();
    for _ in 0..2 {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            system.particles.positions_mut()[31].y = bad;
            match list.refresh(&system.frame(), 1.0) {
                Err(ListError::NotFinite { particle, position }) => {
                    assert_eq!(particle, 31);
                    assert_eq!(
                        position.map(f64::to_bits),
                        [good.x, bad, good.z].map(f64::to_bits)
                    );
                }
                other => panic!("{other:?}"),
            }
        }
        // The second time a list exists already when the position goes bad.
        system.particles.positions_mut()[31] = good;
        same_as_all_pairs(&mut list, &system, 1.0).unwrap();
    }
}

#[test]
fn extreme_a_skin_below_zero_is_refused() {
    assert!(VerletList::new(-0.1).is_err());
    assert!(VerletList::new(f64::NAN).is_err());
    assert!(VerletList::new(f64::INFINITY).is_err());
}
