//! Pairs within molecules, against every pair.

#![allow(clippy::unwrap_used)]

mod common;

use common::Cell;
use zimm_core::{
    AllPairs, Boundary, Central, Clock, DMat3, DVec3, Energy, ForceField, Frame, ListError,
    Molecules, Neighbours, Now, Open, Pair, PairForce, Pairwise, Particles, Reads, System, Tally,
    Virial, WithinMolecules, noise::Domain, noise::Noise,
};

/// F/r = (1 - r / 2) (1 + a sum of the species) - (r.v) (1 - r / 2)^2, with noise; zero from 2 on.
struct Soft;

impl PairForce for Soft {
    const READS: Reads = Reads {
        velocity: true,
        noise: true,
        species: true,
    };

    fn cutoff(&self) -> f64 {
        2.0
    }

    fn force(&self, pair: &Pair, _: &Now) -> Central {
        let w = (1.0 - 0.5 * pair.r2.sqrt()).max(0.0);
        Central {
            conservative: w * (1.0 + f64::from(pair.species[0] + pair.species[1])),
            dissipative: -w * w * pair.rv,
            random: w * pair.noise.uniform(Domain::user(3)),
        }
    }

    fn energy(&self, pair: &Pair) -> f64 {
        pair.r2
    }
}

/// A random walk of short steps for each molecule, solvent in front and behind; folded into the boundary's cell.
fn scene<B: Boundary>(boundary: B, molecules: &Molecules, behind: u32) -> System<B> {
    let noise = Noise::new(31, 0);
    let n = molecules.identities().end + behind;
    let normal = |id: u32, domain| noise.site(id).normal3(Domain::user(domain));
    let mut positions: Vec<DVec3> = (0..n).map(|id| 3.0 * normal(id, 1)).collect();
    for beads in molecules.iter() {
        for [i, j] in molecules.links().filter(|[i, j]| i < j) {
            let (i, j) = (beads.start + i, beads.start + j);
            positions[j as usize] = positions[i as usize] + 0.5 * normal(j, 2);
        }
    }
    let particles = Particles::new(positions)
        .unwrap()
        .with_velocities((0..n).map(|id| normal(id, 4)).collect())
        .unwrap()
        .with_species((0..n).map(|id| (id % 3) as u8).collect())
        .unwrap();
    System::new(boundary, particles, Clock::new(0.1, 1.0, 5).unwrap())
}

fn evaluate<B: Boundary, N: Neighbours<B>, T: Tally + Default>(
    system: &System<B>,
    neighbours: N,
) -> (Vec<DVec3>, T) {
    let mut forces = vec![DVec3::ZERO; system.particles.len()];
    let mut heard = T::default();
    Pairwise::new(Soft, neighbours)
        .accumulate(&system.frame(), &mut forces, &mut heard)
        .unwrap();
    (forces, heard)
}

fn assert_close(found: &[DVec3], expected: &[DVec3]) {
    assert_eq!(found.len(), expected.len());
    assert!(expected.iter().any(|f| f.length() > 0.1));
    for (f, g) in found.iter().zip(expected) {
        assert!(
            (*f - *g).length() < 1e-12 * (1.0 + g.length()),
            "{f} against {g}"
        );
    }
}

fn sheared(edge: f64) -> Cell<true> {
    let gradient = DMat3::from_cols(DVec3::ZERO, 0.7 * DVec3::X, DVec3::ZERO);
    let basis = edge * DMat3::from_cols(DVec3::X, DVec3::new(0.3, 1.0, 0.0), DVec3::Z);
    Cell::flowing(basis, gradient)
}

/// One molecule of 30 beads and nobody else: forces, virial and energy, in open space, and across the faces of a cell
/// of twice its size.
#[test]
fn law_the_pairs_of_one_molecule_are_all_pairs() {
    fn check<B: Boundary>(boundary: B, molecules: Molecules) {
        let mut system = scene(boundary, &molecules, 0);
        for offset in [DVec3::ZERO, DVec3::splat(9.9)] {
            for r in system.particles.positions_mut() {
                *r = system.boundary.wrap(*r + offset).0;
            }
            let (all, (all_virial, all_energy)): (_, (Virial, Energy)) =
                evaluate(&system, AllPairs::default());
            let (within, (virial, energy)): (_, (Virial, Energy)) =
                evaluate(&system, WithinMolecules::new(molecules));
            assert_close(&within, &all);
            let off = (virial.total() - all_virial.total()).to_cols_array();
            assert!(off.iter().all(|x| x.abs() < 1e-10), "{off:?}");
            assert!((energy.0 - all_energy.0).abs() < 1e-10 * energy.0);
        }
    }
    for molecules in [
        Molecules::linear(0, 1, 30).unwrap(),
        Molecules::star(0, 1, 5, 6).unwrap(),
        Molecules::ring(0, 1, 30).unwrap(),
    ] {
        check(Open, molecules);
        check(sheared(20.0), molecules);
    }
}

/// Several molecules among solvent are several molecules by themselves, whatever the order of places.
#[test]
fn law_molecules_do_not_see_each_other() {
    let combs = Molecules::comb(4, 5, 6, 2, 2).unwrap();
    let mut system = scene(sheared(15.0), &combs, 3);
    let mut expected = vec![DVec3::ZERO; system.particles.len()];
    for beads in combs.iter() {
        let (forces, ()) = evaluate(&system, OneOf(beads.clone(), AllPairs::default()));
        for id in beads {
            expected[id as usize] = forces[id as usize];
        }
    }
    let (forces, ()) = evaluate(&system, WithinMolecules::new(combs));
    assert_close(&forces, &expected);
    let n = system.particles.len() as u32;
    let order: Vec<u32> = (0..n).map(|k| (5 * k + 3) % n).collect();
    system.particles.permute(&order).unwrap();
    let (permuted, ()) = evaluate(&system, WithinMolecules::new(combs));
    for (place, force) in permuted.iter().enumerate() {
        let id = system.frame().id(place) as usize;
        assert!((*force - forces[id]).length() < 1e-12 * (1.0 + force.length()));
    }
}

/// All pairs of which both are in a range of places.
struct OneOf(std::ops::Range<u32>, AllPairs);

impl<B: Boundary> Neighbours<B> for OneOf {
    fn refresh(&mut self, frame: &Frame<'_, B>, cutoff: f64) -> Result<bool, ListError> {
        self.1.refresh(frame, cutoff)
    }

    fn order(&self) -> &[u32] {
        Neighbours::<B>::order(&self.1)
    }

    fn positions(&self) -> &[DVec3] {
        Neighbours::<B>::positions(&self.1)
    }

    fn blocks(&self) -> usize {
        1
    }

    fn visit(&self, block: usize, mut each: impl FnMut(zimm_core::Row<'_>)) {
        Neighbours::<B>::visit(&self.1, block, |row| {
            if self.0.contains(&row.i) && self.0.contains(&row.js[0]) {
                each(row);
            }
        });
    }
}

/// A source that has seen one order of places notices another.
#[test]
fn law_a_new_order_of_places_is_seen() {
    let chains = Molecules::linear(1, 4, 6).unwrap();
    let mut system = scene(Open, &chains, 2);
    let mut field = Pairwise::new(Soft, WithinMolecules::new(chains));
    for stride in [1, 5, 11] {
        let n = system.particles.len() as u32;
        let order: Vec<u32> = (0..n).map(|k| (stride * k) % n).collect();
        system.particles.permute(&order).unwrap();
        let mut forces = vec![DVec3::ZERO; n as usize];
        field
            .accumulate(&system.frame(), &mut forces, &mut ())
            .unwrap();
        let (fresh, ()) = evaluate(&system, WithinMolecules::new(chains));
        assert_eq!(forces, fresh);
    }
}

/// 600 chains of 20 beads are six blocks, one chain of 700 is fourteen; every pair is visited once.
#[test]
fn law_blocks_hold_every_pair_once_and_threads_change_no_bit() {
    for (molecules, blocks) in [
        (Molecules::linear(3, 600, 20).unwrap(), 6),
        (Molecules::linear(0, 1, 700).unwrap(), 14),
        (Molecules::linear(0, 9000, 3).unwrap(), 1),
        (Molecules::linear(0, 100, 1).unwrap(), 1),
    ] {
        let system = scene(Open, &molecules, 2);
        let mut source = WithinMolecules::new(molecules);
        let visit = |source: &WithinMolecules| {
            let mut pairs = Vec::new();
            for block in 0..Neighbours::<Open>::blocks(source) {
                Neighbours::<Open>::visit(source, block, |row| {
                    pairs.extend(row.js.iter().map(|&j| [row.i, j]));
                });
            }
            pairs
        };
        assert!(visit(&source).is_empty());
        source.refresh(&system.frame(), 1.0).unwrap();
        assert_eq!(Neighbours::<Open>::blocks(&source), blocks);
        let expected: Vec<[u32; 2]> = molecules
            .iter()
            .flat_map(|ids| {
                ids.clone()
                    .flat_map(move |i| (i + 1..ids.end).map(move |j| [i, j]))
            })
            .collect();
        assert!(visit(&source) == expected);
    }
    let chains = Molecules::linear(3, 600, 20).unwrap();
    let system = scene(sheared(30.0), &chains, 2);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let (forces, (virial, Energy(energy))): (_, (Virial, Energy)) =
                evaluate(&system, WithinMolecules::new(chains));
            (forces, virial.total(), energy)
        })
    };
    let one = run(1);
    assert!(run(2) == one && run(5) == one);
}

/// A molecule larger than the cell is the molecule that its bonds make, and never meets its own images.
#[test]
fn extreme_a_molecule_larger_than_its_cell_does_not_meet_its_images() {
    let rod = Molecules::linear(0, 1, 40).unwrap();
    let along = DVec3::new(1.0, 0.6, 0.0);
    let positions = (0..40).map(|k| f64::from(k) * along).collect();
    let particles = Particles::new(positions).unwrap();
    let clock = Clock::new(0.1, 1.0, 5).unwrap();
    let open = System::new(Open, particles.clone(), clock);
    let boxed = System::new(Cell::at_rest(DMat3::IDENTITY * 5.0), particles, clock);
    let (expected, ()) = evaluate(&open, WithinMolecules::new(rod));
    let (found, ()) = evaluate(&boxed, WithinMolecules::new(rod));
    assert_close(&found, &expected);
}

#[test]
fn extreme_what_cannot_be_told_is_an_error() {
    let pair = Molecules::linear(0, 1, 2).unwrap();
    let refresh = |apart: f64, molecules, cutoff: f64, edge: f64| {
        let particles = Particles::new(vec![DVec3::ZERO, apart * DVec3::X]).unwrap();
        let mut system = System::new(
            Cell::at_rest(DMat3::IDENTITY * edge),
            particles,
            Clock::new(0.1, 1.0, 5).unwrap(),
        );
        if apart == 1.25 {
            system.particles.positions_mut()[1].x = f64::NAN;
        }
        WithinMolecules::new(molecules).refresh(&system.frame(), cutoff)
    };
    assert_eq!(refresh(1.0, pair, 1e9, 5.0), Ok(true));
    assert_eq!(refresh(1.0, pair, f64::INFINITY, 5.0), Ok(true));
    assert_eq!(
        refresh(2.5, pair, 1.0, 5.0),
        Err(ListError::BeyondCell {
            i: 0,
            j: 1,
            length: 2.5,
            reach: 2.5
        })
    );
    let trimer = Molecules::linear(0, 1, 3).unwrap();
    let (identity, particles) = (2, 2);
    assert_eq!(
        refresh(1.0, trimer, 1.0, 5.0),
        Err(ListError::NoSuchParticle {
            identity,
            particles
        })
    );
    assert!(matches!(
        refresh(1.25, pair, 1.0, 5.0),
        Err(ListError::NotFinite { particle: 1, .. })
    ));
    for cutoff in [-1.0, f64::NAN] {
        assert!(matches!(
            refresh(1.0, pair, cutoff, 5.0),
            Err(ListError::Cutoff { .. })
        ));
    }
}
