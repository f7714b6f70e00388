//! Topologies, species along molecules, and molecules brought back to the origin.

#![allow(clippy::unwrap_used)]

mod common;

use common::Cell;
use proptest::prelude::*;
use zimm_core::{
    Boundary, Clock, DMat3, DVec3, IVec3, Molecules, Particles, System, Topology, noise::Domain,
    recentre,
};

#[test]
fn law_molecules_follow_each_other() {
    let molecules = Molecules::linear(5, 3, 2).unwrap();
    assert!(molecules.iter().eq([5..7, 7..9, 9..11]));
    assert_eq!(molecules.iter().len(), 3);
    assert_eq!(molecules.bonds(), [[5, 6], [7, 8], [9, 10]]);
    assert!(Molecules::linear(0, 4, 1).unwrap().bonds().is_empty());
    assert_eq!(Molecules::linear(9, 0, 5).unwrap().iter().len(), 0);
}

#[test]
fn extreme_molecules_without_beads_or_names_are_refused() {
    let most = 1 << 31;
    assert_eq!(Molecules::linear(0, 3, 0).unwrap_err().name, "beads");
    assert!(Molecules::linear(most - 6, 2, 3).is_ok());
    let error = Molecules::linear(most - 5, 2, 3).unwrap_err();
    assert_eq!(
        (error.name, error.found),
        ("last identity", f64::from(most))
    );
    assert!(Molecules::linear(u32::MAX, u32::MAX, u32::MAX).is_err());
}

fn any() -> impl Strategy<Value = Molecules> {
    let linear = (1..30_u32).prop_map(|beads| Molecules::linear(7, 3, beads));
    let ring = (3..30_u32).prop_map(|beads| Molecules::ring(7, 3, beads));
    let star = (1..9_u32, 1..9_u32).prop_map(|(arms, length)| Molecules::star(7, 3, arms, length));
    let comb = (1..9_u32, 0..9_u32, 1..5_u32)
        .prop_map(|(spacing, more, tooth)| Molecules::comb(7, 3, spacing + more, spacing, tooth));
    prop_oneof![linear, ring, star, comb].prop_map(Result::unwrap)
}

proptest! {
    /// Every bond but the last of a ring reaches the next bead from one that was there before.
    #[test]
    fn law_bonds_walk_a_tree(molecules in any()) {
        let beads = molecules.beads();
        let links: Vec<[u32; 2]> = molecules.links().collect();
        let (tree, closing) = links.split_at(beads as usize - 1);
        for (k, &[parent, bead]) in tree.iter().enumerate() {
            prop_assert_eq!(bead, k as u32 + 1);
            prop_assert!(parent < bead);
            prop_assert_eq!(molecules.parent(bead), Some(parent));
        }
        prop_assert_eq!(molecules.parent(0), None);
        if molecules.topology() == Topology::Ring {
            prop_assert_eq!(closing, &[[beads - 1, 0]]);
        } else {
            prop_assert!(closing.is_empty());
        }
        let bonds = molecules.bonds();
        for (start, bonds) in molecules.iter().zip(bonds.chunks(links.len().max(1))) {
            for (bond, link) in bonds.iter().zip(&links) {
                prop_assert_eq!(bond.map(|id| id - start.start), *link);
            }
        }
        prop_assert_eq!(bonds.len(), 3 * links.len());
        prop_assert_eq!(molecules.identities(), 7..7 + 3 * beads);
    }

    /// The functionality of beads is what the topology says.
    #[test]
    fn law_functionalities(molecules in any()) {
        let mut bonds_of = vec![0_u32; molecules.beads() as usize];
        for bead in molecules.links().flatten() {
            bonds_of[bead as usize] += 1;
        }
        let with = |n: u32| bonds_of.iter().filter(|&&bonds| bonds == n).count() as u32;
        match molecules.topology() {
            Topology::Linear if molecules.beads() > 1 => prop_assert_eq!(with(1), 2),
            Topology::Ring => prop_assert_eq!(with(2), molecules.beads()),
            Topology::Star { arms, length } => {
                prop_assert_eq!(bonds_of[0], arms);
                prop_assert_eq!(molecules.beads(), 1 + arms * length);
            }
            Topology::Comb { backbone, spacing, tooth } => {
                let teeth = (molecules.beads() - backbone) / tooth;
                prop_assert_eq!(teeth * tooth + backbone, molecules.beads());
                let roots: Vec<u32> = molecules
                    .links()
                    .filter(|[from, to]| *from < backbone && *to >= backbone)
                    .map(|[from, _]| from)
                    .collect();
                prop_assert_eq!(roots.len() as u32, teeth);
                // The free backbone is shorter than the spacing at either end.
                prop_assert_eq!(roots[0], spacing / 2);
                prop_assert!(roots.windows(2).all(|pair| pair[1] - pair[0] == spacing));
                prop_assert!(backbone - 1 - roots[roots.len() - 1] < spacing);
            }
            _ => {}
        }
    }
}

#[test]
fn extreme_topologies_that_are_none_are_refused() {
    let name =
        |molecules: Result<Molecules, zimm_core::ParameterError>| molecules.unwrap_err().name;
    assert_eq!(name(Molecules::ring(0, 1, 2)), "beads");
    assert_eq!(name(Molecules::star(0, 1, 0, 2)), "arms");
    assert_eq!(name(Molecules::star(0, 1, 2, 0)), "beads of an arm");
    assert_eq!(name(Molecules::comb(0, 1, 5, 0, 2)), "spacing of teeth");
    assert_eq!(name(Molecules::comb(0, 1, 5, 2, 0)), "beads of a tooth");
    assert_eq!(
        name(Molecules::comb(0, 1, 4, 5, 2)),
        "beads of the backbone"
    );
    let most = u32::MAX;
    assert_eq!(name(Molecules::ring(0, most, most)), "last identity");
    assert_eq!(name(Molecules::star(0, 1, most, most)), "last identity");
    assert_eq!(
        name(Molecules::star(most, most, most, most)),
        "last identity"
    );
    assert_eq!(name(Molecules::comb(0, 1, most, 1, most)), "last identity");
    assert_eq!(
        name(Molecules::comb(0, most, most, most, most)),
        "last identity"
    );
    assert!(Molecules::star(0, 1, most, 1).is_err());
    assert!(Molecules::star(0, 1, (1 << 31) - 1, 1).is_ok());
}

#[test]
fn law_species_repeat_along_molecules() {
    let stars = Molecules::star(0, 2, 2, 2).unwrap();
    let species = stars.species(&[(1, 9), (0, 3), (4, 2)]).unwrap();
    assert_eq!(species, [9, 2, 2, 2, 2, 9, 2, 2, 2, 2]);
    for runs in [
        &[(4, 0)][..],
        &[(3, 0), (3, 1)],
        &[],
        &[(u32::MAX, 0), (6, 1)],
    ] {
        let error = stars.species(runs).unwrap_err();
        assert_eq!(error.name, "beads in all runs");
    }
}

/// Open space that streams.
#[derive(Clone, Copy, Debug)]
struct Extension(f64);

impl Boundary for Extension {
    const FLOWS: bool = true;

    fn min_image(&self, dr: DVec3) -> DVec3 {
        dr
    }

    fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
        (r, IVec3::ZERO)
    }

    fn gradient(&self) -> DMat3 {
        self.0 * DMat3::from_diagonal(DVec3::new(1.0, -1.0, 0.0))
    }
}

fn system<B: Boundary>(boundary: B, particles: Particles) -> System<B> {
    System::new(boundary, particles, Clock::new(0.01, 1.0, 21).unwrap())
}

/// A Rouse chain of four beads at 0.3 of the rate that would tear it, by Euler's scheme in positions, beside the same
/// noise in bonds alone, which no centre of mass can harm. After 1000 strains the centre would be at e^1000: with
/// recentring, bonds agree to 1e-12; without, they are gone after 60 strains.
#[test]
fn extreme_bonds_keep_their_digits_over_a_thousand_strains() {
    const N: usize = 4;
    let (rate, dt) = (0.3 * 0.585_786_437_626_905 / 4.0, 0.1);
    let steps_per_strain = (1.0 / (rate * dt)) as u64;
    let kappa = Extension(rate).gradient();
    let chain = Molecules::linear(0, 1, N as u32).unwrap();
    let forces = |q: &[DVec3]| -> [DVec3; N] {
        std::array::from_fn(|k| {
            let ahead = q.get(k).copied().unwrap_or_default();
            let behind = k.checked_sub(1).map_or(DVec3::ZERO, |k| q[k]);
            ahead - behind
        })
    };
    let bonds = |r: &[DVec3]| -> Vec<DVec3> { r.windows(2).map(|r| r[1] - r[0]).collect() };
    let off_after = |strains: u64, centred: bool| {
        let positions = (0..N).map(|k| k as f64 * DVec3::ONE).collect();
        let mut system = system(Extension(rate), Particles::new(positions).unwrap());
        let mut reference = vec![DVec3::ONE; N - 1];
        for _ in 0..strains * steps_per_strain {
            let noise = system.clock.now().noise();
            let kick = |k: usize| (0.5 * dt).sqrt() * noise.site(k as u32).normal3(Domain::user(1));
            let force = forces(&bonds(system.particles.positions()));
            for (k, r) in system.particles.positions_mut().iter_mut().enumerate() {
                *r += dt * (kappa * *r + 0.25 * force[k]) + kick(k);
            }
            let force = forces(&reference);
            for (k, q) in reference.iter_mut().enumerate() {
                let drift = kappa * *q + 0.25 * (force[k + 1] - force[k]);
                *q += dt * drift + kick(k + 1) - kick(k);
            }
            system.clock.tick();
            if centred {
                recentre(&mut system, &chain).unwrap();
            }
        }
        let found = bonds(system.particles.positions());
        let offs = found
            .iter()
            .zip(&reference)
            .map(|(q, p)| (*q - *p).length());
        // f64::max would pass over what is not a number.
        offs.fold(0.0, |most, off| if off <= most { most } else { off })
    };
    assert!(off_after(1000, true) < 1e-12);
    let lost = off_after(60, false);
    assert!(lost.is_nan() || lost > 1e-2, "{lost}");
}

/// Bonds, velocities and forces stay; masses weigh; particles of no molecule stay; so does the order of places.
#[test]
fn law_recentring_moves_molecules_as_a_whole() {
    let positions: Vec<DVec3> = (0..7)
        .map(|k| DVec3::new(f64::from(k * k), 3.0, -1.0))
        .collect();
    let forces: Vec<DVec3> = (0..7).map(|k| f64::from(k) * DVec3::Y).collect();
    let mut particles = Particles::new(positions)
        .unwrap()
        .with_velocities(vec![DVec3::Z; 7])
        .unwrap()
        .with_masses((1..8).map(f64::from).collect())
        .unwrap();
    *particles.columns_mut().forces = forces;
    particles.permute(&[6, 1, 4, 3, 5, 2, 0]).unwrap();
    let before = system(Extension(0.0), particles);
    let mut after = before.clone();
    // Two trimers behind one particle of solvent.
    let trimers = Molecules::linear(1, 2, 3).unwrap();
    recentre(&mut after, &trimers).unwrap();
    assert_eq!(after.particles.forces(), before.particles.forces());
    assert_eq!(after.particles.velocities(), before.particles.velocities());
    let (old, new) = (before.frame(), after.frame());
    let at =
        |frame: &zimm_core::Frame<'_, Extension>, id| frame.positions[frame.place(id).unwrap()];
    assert_eq!(at(&old, 0), at(&new, 0));
    for beads in trimers.iter() {
        let mass = |id| new.mass(new.place(id).unwrap());
        let moment: DVec3 = beads.clone().map(|id| mass(id) * at(&new, id)).sum();
        assert!(moment.length() < 1e-12);
        for id in beads.skip(1) {
            let (q, p) = (
                at(&new, id) - at(&new, id - 1),
                at(&old, id) - at(&old, id - 1),
            );
            assert!((q - p).length() < 1e-13);
        }
    }
}

#[test]
fn extreme_recentring_in_a_cell_or_of_nobody_is_refused() {
    let three = || Particles::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y]).unwrap();
    let trimer = Molecules::linear(0, 1, 3).unwrap();
    fn refused<B: Boundary>(boundary: B, particles: Particles, molecules: &Molecules) {
        let mut system = system(boundary, particles.clone());
        let error = recentre(&mut system, molecules).unwrap_err();
        assert_eq!(error.name, "number of lattice vectors");
        assert_eq!(system.particles, particles);
    }
    let (basis, gradient) = (5.0 * DMat3::IDENTITY, Extension(1.0).gradient());
    refused(Cell::at_rest(basis), three(), &trimer);
    refused(Cell::flowing(basis, gradient), three(), &trimer);
    let mut open = system(Extension(1.0), three());
    let error = recentre(&mut open, &Molecules::linear(1, 1, 3).unwrap()).unwrap_err();
    assert_eq!((error.name, error.found), ("last identity", 3.0));
    recentre(&mut open, &Molecules::linear(3, 0, 3).unwrap()).unwrap();
    assert_eq!(open.particles, three());
}
