//! The driver of pair laws against a double loop over nearest images.

#![allow(clippy::unwrap_used)]

mod common;

use common::Cell;
use rand_distr::{Distribution, StandardUniform};
use zimm_core::{
    AllPairs, Boundary, Central, Clock, DMat3, DVec3, Energy, ForceField, Item, Lattice, Now, Pair,
    PairForce, Pairwise, Particles, Periodic, Reads, System, Tally, VerletList, Virial,
    noise::Domain, start,
};

/// A soft fluid of two species with friction and noise: w = 1 - r,
/// F/r = (a_ij w - gamma w^2 (r.v)/r + sigma w theta dt^(-1/2)) / r.
#[derive(Clone, Debug)]
struct Soft;

impl Soft {
    const GAMMA: f64 = 4.5;

    fn strength(species: [u8; 2]) -> f64 {
        20.0 + 5.0 * f64::from(species[0] + species[1])
    }
}

impl PairForce for Soft {
    const READS: Reads = Reads {
        velocity: true,
        noise: true,
        species: true,
    };

    fn cutoff(&self) -> f64 {
        1.0
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, now: &Now) -> Central {
        let r = pair.r2.sqrt();
        let w = (1.0 - r).max(0.0);
        let sigma = (2.0 * Self::GAMMA * now.kt / now.dt).sqrt();
        Central {
            conservative: Self::strength(pair.species) * w / r,
            dissipative: -Self::GAMMA * w * w * pair.rv / pair.r2,
            random: sigma * w * pair.noise.uniform(Domain::DPD) / r,
        }
    }

    fn energy(&self, pair: &Pair) -> f64 {
        0.5 * Self::strength(pair.species) * (1.0 - pair.r2.sqrt()).max(0.0).powi(2)
    }
}

/// A fluid of density 3 at temperature one with two species.
fn fluid<B: Periodic>(boundary: B, particles: usize, seed: u64) -> System<B> {
    let mut rng = start::stream(seed);
    let positions = start::uniform(boundary.lattice(), particles, &mut rng);
    let particles = Particles::new(positions).unwrap();
    let velocities = start::velocities(&particles, 1.0, &mut rng).unwrap();
    let species = (0..particles.len()).map(|k| (k % 3 == 0) as u8).collect();
    let particles = particles.with_velocities(velocities).unwrap();
    let particles = particles.with_species(species).unwrap();
    let mut clock = Clock::new(0.01, 1.0, seed).unwrap();
    clock.tick();
    System::new(boundary, particles, clock)
}

fn tilted(volume: f64) -> DMat3 {
    let edge = volume.cbrt();
    edge * DMat3::from_cols(
        DVec3::X,
        DVec3::new(0.4, 1.0, 0.0),
        DVec3::new(-0.2, 0.3, 1.0),
    )
}

fn shear(rate: f64) -> DMat3 {
    DMat3::from_cols(DVec3::ZERO, rate * DVec3::X, DVec3::ZERO)
}

/// Forces and virial by the definitions, with no driver: F_ij = (F/r)(r_ij, v_ij, noise of i and j) r_ij over nearest
/// images, with v_ij = c_i - c_j + kappa r_ij. The third column bounds the size of the terms of each force.
///
/// Pairs whose nearest lattice planes are more than the cutoff apart are left out before their image is looked for.
fn double_loop<B: Periodic>(system: &System<B>) -> (Vec<DVec3>, [DMat3; 3], Vec<f64>) {
    let (frame, law) = (system.frame(), Soft);
    let mut forces = vec![DVec3::ZERO; frame.len()];
    let mut sizes = vec![0.0; frame.len()];
    let mut virial = [DMat3::ZERO; 3];
    let lattice = frame.boundary.lattice();
    let (inverse, widths) = (lattice.inverse(), lattice.widths());
    let noise = frame.now.noise();
    for i in 0..frame.len() {
        for j in i + 1..frame.len() {
            let apart = frame.positions[i] - frame.positions[j];
            let s = inverse * apart;
            if ((s - s.round()).abs() * widths).max_element() > 1.0 {
                continue;
            }
            let r = frame.boundary.min_image(apart);
            if r.length_squared() >= 1.0 {
                continue;
            }
            let v = frame.velocities[i] - frame.velocities[j] + frame.boundary.gradient() * r;
            let pair = Pair {
                r2: r.length_squared(),
                rv: r.dot(v),
                noise: noise.site(frame.id(i)) + noise.site(frame.id(j)),
                species: [frame.species(i), frame.species(j)],
            };
            let f = law.force(&pair, &frame.now);
            forces[i] += f.total() * r;
            forces[j] -= f.total() * r;
            for (sum, part) in virial
                .iter_mut()
                .zip([f.conservative, f.dissipative, f.random])
            {
                let outer = DMat3::from_cols(r.x * r, r.y * r, r.z * r);
                *sum += part * outer;
            }
            let size = [f.conservative, f.dissipative, f.random]
                .map(f64::abs)
                .iter()
                .sum::<f64>()
                * r.length();
            sizes[i] += size;
            sizes[j] += size;
        }
    }
    (forces, virial, sizes)
}

fn forces_of<B: Boundary, T: Tally + Default>(
    field: &mut impl ForceField<B>,
    system: &System<B>,
) -> (Vec<DVec3>, T) {
    let mut forces = vec![DVec3::ZERO; system.particles.len()];
    let mut tally = T::default();
    field
        .accumulate(&system.frame(), &mut forces, &mut tally)
        .unwrap();
    (forces, tally)
}

/// Equal to 1e-12 of the terms that each force is a sum of.
fn assert_close(found: &[DVec3], expected: &[DVec3], sizes: &[f64]) {
    for (k, ((f, g), size)) in found.iter().zip(expected).zip(sizes).enumerate() {
        assert!(
            (*f - *g).length() <= 1e-12 * size,
            "particle {k}: {f} against {g}"
        );
    }
}

/// Streams, jumps a little and lets time go on by one step.
fn advance<B: Periodic>(system: &mut System<B>, rng: &mut impl rand::Rng) {
    let before = system.clock.now().time;
    system.clock.tick();
    let now = system.clock.now().time;
    let carry = system.boundary.carry(before, now);
    system.boundary.advance(now);
    for r in system.particles.positions_mut() {
        let jump: [f64; 3] = std::array::from_fn(|_| StandardUniform.sample(rng));
        let jump = 0.1 * (DVec3::from_array(jump) - 0.5);
        *r = system.boundary.wrap(carry * *r + jump).0;
    }
}

fn check_against_double_loop<B: Periodic>(mut system: System<B>, steps: usize) {
    let mut rng = start::stream(9);
    let mut lists = Pairwise::new(Soft, VerletList::new(0.3).unwrap());
    for _ in 0..steps {
        let (expected, virial, sizes) = double_loop(&system);
        let (forces, heard): (_, Virial) = forces_of(&mut lists, &system);
        assert_close(&forces, &expected, &sizes);
        let size: f64 = sizes.iter().sum();
        for (item, expected) in [Item::Conservative, Item::Dissipative, Item::Random]
            .iter()
            .zip(virial)
        {
            let off = (heard.item(*item) - expected).to_cols_array();
            assert!(
                off.iter().all(|x| x.abs() < 1e-12 * size),
                "{item:?}: {off:?}"
            );
        }
        assert_eq!(heard.item(Item::Spring), DMat3::ZERO);
        let total: DVec3 = forces.iter().sum();
        assert!(total.length() < 1e-12 * size, "total force {total}");
        advance(&mut system, &mut rng);
    }
    assert!(lists.neighbours().builds() > 1 && lists.neighbours().builds() < steps as u64);
}

#[test]
fn law_all_pairs_and_lists_give_the_same_forces() {
    let system = fluid(Cell::flowing(tilted(400.0), shear(3.0)), 1200, 2);
    let (expected, _, sizes) = double_loop(&system);
    let (from_all, ()) = forces_of(&mut Pairwise::new(Soft, AllPairs::default()), &system);
    assert_close(&from_all, &expected, &sizes);
}

#[test]
fn law_forces_and_virial_are_those_of_the_double_loop_at_rest() {
    check_against_double_loop(fluid(Cell::at_rest(tilted(400.0)), 1200, 1), 12);
}

#[test]
fn law_forces_and_virial_are_those_of_the_double_loop_in_flow() {
    check_against_double_loop(fluid(Cell::flowing(tilted(400.0), shear(3.0)), 1200, 2), 12);
    let gradient = DMat3::from_cols(
        DVec3::new(1.0, 0.5, 0.0),
        DVec3::new(2.0, -1.5, 0.3),
        0.5 * DVec3::Z,
    );
    check_against_double_loop(fluid(Cell::flowing(tilted(400.0), gradient), 1200, 3), 12);
}

#[test]
fn law_forces_are_those_of_the_double_loop_over_several_blocks() {
    check_against_double_loop(fluid(Cell::flowing(tilted(2100.0), shear(3.0)), 6300, 4), 4);
}

/// Twelve thousand particles are four blocks of work and several chunks of every column.
#[test]
fn law_the_same_bits_on_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let mut system = fluid(Cell::flowing(tilted(4000.0), shear(1.0)), 12_000, 5);
            let mut field = Pairwise::new(Soft, VerletList::new(0.3).unwrap());
            let mut rng = start::stream(10);
            let mut bits = Vec::new();
            for _ in 0..6 {
                let (forces, (virial, energy)): (_, (Virial, Energy)) =
                    forces_of(&mut field, &system);
                bits.extend(forces.iter().flat_map(|f| f.to_array()).map(f64::to_bits));
                bits.extend(virial.total().to_cols_array().map(f64::to_bits));
                bits.push(energy.0.to_bits());
                advance(&mut system, &mut rng);
            }
            assert!(field.neighbours().builds() > 1 && field.neighbours().builds() < 6);
            bits
        })
    };
    let one = run(1);
    assert!(run(2) == one);
    assert!(run(5) == one);
}

/// More particles than one chunk of a column.
#[test]
fn extreme_nobody_has_neighbours_however_many_there_are() {
    let system = fluid(Cell::at_rest(tilted(3000.0)), 9000, 5);
    let (forces, ()) = forces_of(&mut Pairwise::new(Soft, ()), &system);
    assert!(forces.iter().all(|&f| f == DVec3::ZERO));
}

/// The tally's presence is not to be seen in the forces.
#[test]
fn law_a_tally_changes_no_bit() {
    let system = fluid(Cell::flowing(tilted(400.0), shear(1.0)), 1200, 6);
    let mut field = Pairwise::new(Soft, VerletList::new(0.3).unwrap());
    let (silent, ()) = forces_of(&mut field, &system);
    let (heard, _): (_, (Virial, Energy)) = forces_of(&mut field, &system);
    assert_eq!(silent, heard);
}

#[test]
fn law_forces_belong_to_identities_not_to_places() {
    let mut system = fluid(Cell::flowing(tilted(1200.0), shear(1.0)), 3600, 7);
    let sizes = double_loop(&system).2;
    let mut field = Pairwise::new(Soft, VerletList::new(0.3).unwrap());
    let (before, ()) = forces_of(&mut field, &system);
    // Seven shares no factor with 3600, so this is a permutation.
    let order: Vec<u32> = (0..3600).map(|k| (7 * k + 5) % 3600).collect();
    system.particles.permute(&order).unwrap();
    for mut field in [field, Pairwise::new(Soft, VerletList::new(0.3).unwrap())] {
        let (permuted, ()) = forces_of(&mut field, &system);
        let mut after = vec![DVec3::ZERO; 3600];
        for (place, force) in permuted.iter().enumerate() {
            after[system.frame().id(place) as usize] = *force;
        }
        assert_close(&after, &before, &sizes);
    }
}

#[test]
fn law_forces_are_added_and_parts_of_a_sum_add_up() {
    let system = fluid(Cell::at_rest(tilted(100.0)), 300, 8);
    let sizes = double_loop(&system).2;
    let field = || Pairwise::new(Soft, VerletList::new(0.3).unwrap());
    let (once, _): (_, ()) = forces_of(&mut field(), &system);
    let (twice, _): (_, ()) = forces_of(
        &mut (field(), Pairwise::new(Soft, AllPairs::default())),
        &system,
    );
    let doubled: Vec<DVec3> = once.iter().map(|&f| 2.0 * f).collect();
    assert_close(&twice, &doubled, &sizes);
    let (both, _): (_, ()) = forces_of(
        &mut Pairwise::new((Soft, Soft), AllPairs::default()),
        &system,
    );
    assert_close(&both, &doubled, &sizes);
}

/// The energy of a strained cell, E(eps): positions and lattice times 1 + eps.
fn energy_at_strain(basis: DMat3, fractions: &[DVec3], strain: DMat3) -> f64 {
    let strained = (DMat3::IDENTITY + strain) * basis;
    let boundary = Cell::at_rest(strained);
    let positions = fractions.iter().map(|&s| strained * s).collect();
    let species = (0..fractions.len()).map(|k| (k % 3 == 0) as u8).collect();
    let particles = Particles::new(positions)
        .unwrap()
        .with_species(species)
        .unwrap();
    let system = System::new(boundary, particles, Clock::new(0.01, 1.0, 0).unwrap());
    let (_, Energy(energy)) = forces_of(&mut Pairwise::new(Soft, AllPairs::default()), &system);
    energy
}

/// dE / d eps_ab = - sum F_a r_b: the conservative virial is minus the derivative of the energy. The energy has a
/// kink in its second derivative at the cutoff, so the central difference of step 1e-6 is good to about 1e-6.
#[test]
fn law_the_virial_is_the_derivative_of_the_energy_by_strain() {
    let basis = tilted(100.0);
    let lattice = Lattice::new(basis).unwrap();
    let positions = start::uniform(&lattice, 300, &mut start::stream(11));
    let fractions: Vec<DVec3> = positions.iter().map(|&r| basis.inverse() * r).collect();
    let mut system = fluid(Cell::at_rest(basis), 300, 0);
    system.particles.positions_mut().copy_from_slice(&positions);
    let (_, virial): (_, Virial) = forces_of(
        &mut Pairwise::new(Soft, VerletList::new(0.2).unwrap()),
        &system,
    );
    let conservative = virial.item(Item::Conservative);
    let scale = conservative.x_axis.x.abs();
    const STEP: f64 = 1e-6;
    for row in 0..3 {
        for column in 0..3 {
            let mut strain = DMat3::ZERO;
            strain.col_mut(column)[row] = STEP;
            let rise = energy_at_strain(basis, &fractions, strain)
                - energy_at_strain(basis, &fractions, -strain);
            let derivative = rise / (2.0 * STEP);
            let expected = -conservative.col(row)[column];
            assert!(
                (derivative - expected).abs() < 2e-6 * scale,
                "{row}{column}: {derivative}, {expected}"
            );
        }
    }
    let items = Item::ALL
        .iter()
        .fold(DMat3::ZERO, |sum, &item| sum + virial.item(item));
    assert!(
        (items - virial.total())
            .to_cols_array()
            .iter()
            .all(|x| x.abs() < 1e-12 * scale)
    );
    assert!(
        virial.item(Item::Dissipative) != DMat3::ZERO && virial.item(Item::Random) != DMat3::ZERO
    );
}

/// Rows are separations, columns are forces.
#[test]
fn law_the_virial_is_separation_times_force() {
    let mut virial = Virial::default();
    virial.hear(Item::Spring, DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y, &|| 0.0);
    assert_eq!(virial.item(Item::Spring).y_axis, 2.0 * DVec3::X);
    assert_eq!(
        virial.total(),
        DMat3::from_cols(DVec3::ZERO, 2.0 * DVec3::X, DVec3::ZERO)
    );
}

#[test]
fn extreme_nobody_one_alone_and_nobody_in_range() {
    for particles in [0, 1] {
        let system = fluid(Cell::at_rest(tilted(100.0)), particles, 12);
        let mut field = Pairwise::new(Soft, VerletList::new(0.3).unwrap());
        let (forces, Energy(energy)) = forces_of(&mut field, &system);
        assert_eq!((forces, energy), (vec![DVec3::ZERO; particles], 0.0));
    }
}
