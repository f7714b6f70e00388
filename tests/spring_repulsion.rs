//! Springs that repel each other: in every flow, without a thermostat, on threads.
#![allow(clippy::unwrap_used)]

mod scene;

use rayon::ThreadPoolBuilder;
use scene::{pairs, run};
use zimm::prelude::*;

/// U = k (1 - 2 D)^4 up to 1/2: smooth where the others are cut, and turned over a distance that particles take several
/// steps to cross.
#[derive(Clone, Copy)]
struct Smooth(f64);

impl SegmentForce for Smooth {
    fn cutoff(&self) -> f64 {
        0.5
    }

    fn force(&self, distance: f64) -> f64 {
        8.0 * self.0 * (1.0 - 2.0 * distance).powi(3)
    }

    fn energy(&self, distance: f64) -> f64 {
        self.0 * (1.0 - 2.0 * distance).powi(4)
    }

    fn smallest(&self) -> f64 {
        0.05
    }
}

type Repulsion<L> = SegmentRepulsion<L, VerletList>;

fn repulsion<L>(law: L, molecules: &Molecules) -> Repulsion<L> {
    SegmentRepulsion::new(law, molecules.bonds(), VerletList::new(0.3).unwrap())
}

/// Linear chains of bonds of one length at random, without solvent, at thermal velocities.
fn chains<B: Periodic>(
    space: B,
    (count, beads): (u32, u32),
    bond: f64,
    clock: Clock,
) -> (System<B>, Molecules) {
    let molecules = Molecules::linear(0, count, beads).unwrap();
    let mut rng = start::stream(clock.now().seed);
    let positions = start::chains(space.lattice(), &molecules, |_| bond, &mut rng);
    let particles = Particles::new(positions).unwrap();
    let velocities = start::velocities(&particles, 1.0, &mut rng).unwrap();
    let particles = particles.with_velocities(velocities).unwrap();
    (System::new(space, particles, clock), molecules)
}

// --- flows ----------------------------------------------------------------------------------------------------------

/// Forces and energy, by the force field.
fn listed<B: Periodic>(frame: &Frame<'_, B>, field: &mut Repulsion<Smooth>) -> (Vec<DVec3>, f64) {
    let mut forces = vec![DVec3::ZERO; frame.len()];
    let mut energy = Energy::default();
    field.accumulate(frame, &mut forces, &mut energy).unwrap();
    (forces, energy.0)
}

/// Forces and energy, of all pairs of segments in all images near by.
fn all_pairs<B: Periodic>(
    frame: &Frame<'_, B>,
    bonds: &[[u32; 2]],
    law: Smooth,
) -> (Vec<DVec3>, f64) {
    let mut forces = vec![DVec3::ZERO; frame.len()];
    let (mut energy, b) = (0.0, law.smallest());
    let segments: Vec<(DVec3, DVec3)> = bonds
        .iter()
        .map(|&[i, j]| {
            let here = frame.positions[i as usize];
            let span = frame.boundary.min_image(frame.positions[j as usize] - here);
            (here + 0.5 * span, span)
        })
        .collect();
    let basis = frame.boundary.lattice().basis();
    for (k, (&first, &(p, r))) in bonds.iter().zip(&segments).enumerate() {
        for (&second, &(q, u)) in bonds[k + 1..].iter().zip(&segments[k + 1..]) {
            let shared = first.iter().any(|bead| second.contains(bead));
            let near = frame.boundary.min_image(p - q);
            for n in 0..27 {
                let image = IVec3::new(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
                let middles = near + basis * image.as_dvec3();
                let Approach { s, t, apart } = Approach::between(middles, r, u, b);
                let distance = (apart.length_squared() + b * b * (1.0 + s * s + t * t)).sqrt();
                let touch = shared && Approach::between(middles, r, u, 0.0).apart.length() < 1e-10;
                if distance < law.cutoff() && !touch {
                    let force = law.force(distance) / distance * apart;
                    let beads = [first[0], first[1], second[0], second[1]];
                    let shares = [0.5 - s, 0.5 + s, t - 0.5, -0.5 - t];
                    for (bead, share) in beads.into_iter().zip(shares) {
                        forces[bead as usize] += share * force;
                    }
                    energy += law.energy(distance);
                }
            }
        }
    }
    (forces, energy)
}

fn difference(a: &(Vec<DVec3>, f64), b: &(Vec<DVec3>, f64)) -> f64 {
    let forces = a.0.iter().zip(&b.0).map(|(a, b)| (*a - *b).length());
    forces.fold((a.1 - b.1).abs(), f64::max)
}

/// Chains carried by the flow and pushed at random: at every step, and just before and after each change of basis,
/// forces and energy are those of all pairs; across each change they are the same to rounding. Answers how many changes
/// there were.
fn flows<B: Periodic>(space: B, dt: f64, steps: u32) -> u32 {
    let clock = Clock::new(dt, 1.0, 4).unwrap();
    let (mut system, molecules) = chains(space.clone(), (8, 6), 1.1, clock);
    let bonds = molecules.bonds();
    let mut field = repulsion(Smooth(5.0), &molecules);
    let (mut time, mut remaps, mut acting) = (0.0, 0, 0);
    let mut rng = start::stream(9);
    let mut go = |system: &mut System<B>, to: f64, push: f64| {
        let carry = system.boundary.carry(time, to);
        system.boundary.advance(to);
        let pushes = start::velocities(&system.particles, push, &mut rng).unwrap();
        let boundary = system.boundary.clone();
        for (r, push) in system.particles.positions_mut().iter_mut().zip(pushes) {
            *r = boundary.wrap(carry * *r + push).0;
        }
        // Springs that do not let the flow stretch them.
        for &[i, j] in bonds.iter().filter(|_| push > 0.0) {
            let [i, j] = [i as usize, j as usize];
            let positions = system.particles.positions_mut();
            let span = boundary.min_image(positions[j] - positions[i]);
            let back = 0.5 * (1.0 - (1.5 / span.length()).min(1.0)) * span;
            positions[i] = boundary.wrap(positions[i] + back).0;
            positions[j] = boundary.wrap(positions[j] - back).0;
        }
        time = to;
        let mut frame = system.frame();
        frame.now.time = to;
        let found = listed(&frame, &mut field);
        let error = difference(&found, &all_pairs(&frame, &bonds, Smooth(5.0)));
        assert!(error < 1e-9, "{error:e} at {to}");
        acting += u32::from(found.1 > 0.5);
        found
    };
    let after = |from: f64, to: f64| {
        let mut there = space.clone();
        there.advance(from);
        there.advance(to)
    };
    for step in 0..steps {
        let [mut from, mut to] = [step, step + 1].map(|k| dt * f64::from(k));
        let end = to;
        if after(from, to) != Remap::None {
            while to - from > 1e-13 * end {
                let middle = 0.5 * (from + to);
                if after(from, middle) != Remap::None {
                    to = middle;
                } else {
                    from = middle;
                }
            }
            let before = go(&mut system, from, 0.0);
            let error = difference(&before, &go(&mut system, to, 0.0));
            assert!(error < 1e-9, "{error:e} across the change of basis at {to}");
            remaps += 1;
        }
        go(&mut system, end, 3e-4);
    }
    println!("{remaps} changes of basis; springs in contact at {acting} frames");
    assert!(acting > steps / 2);
    remaps
}

#[test]
fn law_repulsion_does_not_see_remaps() {
    let steady = |rate| Steady::new(rate).unwrap();
    let shear = LeesEdwards::new(DVec3::new(6.0, 5.0, 5.5), steady(1.0)).unwrap();
    assert!(flows(shear, 0.03, 150) > 2);
    let planar = KraynikReinelt::new(6.0, 5.0, steady(1.0)).unwrap();
    assert!(flows(planar, 0.03, 150) > 2);
    let mixed = PlanarMixed::new(6.0, 5.0, 0.3, steady(1.0)).unwrap();
    assert!(flows(mixed, 0.03, 150) > 2);
}

// --- dynamics -------------------------------------------------------------------------------------------------------

type Melt<L> = (
    Pairwise<DpdConservative, VerletList>,
    Bonded<Fene>,
    Repulsion<L>,
);

fn melt<L>(law: L, molecules: &Molecules) -> Melt<L> {
    let springs = Bonded::new(Fene::new(10.0, 2.0).unwrap(), molecules.bonds());
    let soft = DpdConservative::new(18.75, 1.0).unwrap();
    (pairs(soft), springs, repulsion(law, molecules))
}

/// Kinetic and potential energy at each step over a time.
fn energies<B: Boundary, F: ForceField<B>>(
    system: &System<B>,
    field: &mut F,
    dt: f64,
    time: f64,
) -> Vec<f64> {
    let mut system = system.clone();
    system.clock.set_dt(dt).unwrap();
    let mut stepper = GrootWarren::new(0.5).unwrap();
    let each = (0..(time / dt).round() as u32).map(|_| {
        let mut potential = Energy::default();
        stepper.step(&mut system, field, &mut potential).unwrap();
        let velocities = system.particles.velocities().iter();
        potential.0 + 0.5 * velocities.map(|c| c.length_squared()).sum::<f64>()
    });
    each.collect()
}

/// Chains that repel each other, without a thermostat: halving the time step quarters the error of the energy, and the
/// energy does not drift.
///
/// 25 chains of 12 beads, 275 springs in a cell of 75, brought to equilibrium by friction and noise. An energy that is
/// not that of the forces, or a force that jumps, does not converge at second order. Seed 6.
#[test]
fn law_energy_is_conserved() {
    let clock = Clock::new(0.005, 1.0, 6).unwrap();
    let (mut system, molecules) = chains(PeriodicBox::cubic(4.2).unwrap(), (25, 12), 0.5, clock);
    let mut field = melt(Smooth(10.0), &molecules);
    run(
        &mut Langevin::new(2.0).unwrap(),
        &mut system,
        &mut field,
        1000,
    );
    let mut virial = Virial::default();
    let mut forces = vec![DVec3::ZERO; system.particles.len()];
    field
        .2
        .accumulate(&system.frame(), &mut forces, &mut virial)
        .unwrap();
    println!(
        "virial of the repulsion {}",
        virial.item(Item::SpringRepulsion)
    );
    let error = |energies: &[f64]| {
        let mean = energies.iter().sum::<f64>() / energies.len() as f64;
        let squares = energies.iter().map(|e| (e - mean).powi(2));
        (squares.sum::<f64>() / energies.len() as f64).sqrt()
    };
    let errors = [0.002, 0.001, 0.0005].map(|dt| error(&energies(&system, &mut field, dt, 0.5)));
    println!("energy errors {errors:?}");
    for pair in errors.windows(2) {
        assert!(
            (pair[0] / pair[1] - 4.0).abs() < 0.6,
            "{}",
            pair[0] / pair[1]
        );
    }
    let long = energies(&system, &mut field, 0.002, 4.0);
    let half = long.len() / 2;
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let drift = mean(&long[half..]) - mean(&long[..half]);
    println!(
        "drift {drift:.1e} in a time of 2, fluctuation {:.1e}",
        error(&long)
    );
    assert!(drift.abs() < 0.05);
}

/// The same bits on any number of threads, and after a restart.
#[test]
fn law_bits_do_not_depend_on_threads_or_restarts() {
    let space = || LeesEdwards::new(DVec3::splat(21.0), Steady::new(0.3).unwrap()).unwrap();
    let start = || {
        let clock = Clock::new(0.005, 1.0, 12).unwrap();
        let (system, molecules) = chains(space(), (840, 12), 1.1, clock);
        let springs = Bonded::new(Fene::new(2.0, 5.0).unwrap(), molecules.bonds());
        (system, (springs, repulsion(Smooth(10.0), &molecules)))
    };
    type Field = (Bonded<Fene>, Repulsion<Smooth>);
    let go = |system: &mut System<LeesEdwards<Steady>>, field: &mut Field, steps: u32| {
        let mut stepper = Langevin::new(1.0).unwrap();
        let mut bits = Vec::new();
        for _ in 0..steps {
            let mut heard = (Virial::default(), Energy::default());
            stepper.step(system, field, &mut heard).unwrap();
            bits.extend(heard.0.total().to_cols_array().map(f64::to_bits));
            bits.push(heard.1.0.to_bits());
        }
        let positions = system.particles.positions().iter();
        bits.extend(positions.flat_map(|r| r.to_array().map(f64::to_bits)));
        bits
    };
    let on = |threads: usize| {
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let (mut system, mut field) = start();
            let first = go(&mut system, &mut field, 60);
            let mut file = Vec::new();
            save(&system, &mut field, &mut file).unwrap();
            assert!(field.1.neighbours().builds() > 2);
            assert!(Neighbours::<LeesEdwards<Steady>>::blocks(field.1.neighbours()) > 2);
            (first, go(&mut system, &mut field, 60), file)
        })
    };
    let (first, second, file) = on(1);
    for threads in [2, 5] {
        let (again, on, _) = on(threads);
        assert!(first == again && second == on);
    }
    let mut again = load(space(), &mut file.as_slice()).unwrap();
    assert!(second == go(&mut again, &mut start().1, 60));
}

// --- cost -----------------------------------------------------------------------------------------------------------

/// Chains of 20 beads at half the density of a DPD fluid, 1.9 springs per unit of volume, as random walks.
fn solution(segments: u32) -> (System<PeriodicBox>, Molecules) {
    let chains_of_20 = segments / 19;
    let edge = (f64::from(chains_of_20) * 20.0 / 2.0).cbrt();
    let clock = Clock::new(0.01, 1.0, 3).unwrap();
    chains(
        PeriodicBox::cubic(edge).unwrap(),
        (chains_of_20, 20),
        1.1,
        clock,
    )
}

/// The number of candidates per segment does not grow with their number, nor when one spring is long.
#[test]
fn law_cost_is_linear_in_the_number_of_segments() {
    let candidates = |segments: u32, long: bool| {
        let (mut system, molecules) = solution(segments);
        if long {
            let far = 0.45 * system.boundary.reach() * DVec3::X;
            let positions = system.particles.positions_mut();
            positions[1] = positions[0] + 2.0 * far;
        }
        let mut field = repulsion(Smooth(1.0), &molecules);
        let mut forces = vec![DVec3::ZERO; system.particles.len()];
        field
            .accumulate(&system.frame(), &mut forces, &mut ())
            .unwrap();
        field.neighbours().candidates() as f64 / f64::from(segments)
    };
    let [few, many] = [1000, 20_000].map(|n| candidates(n, false));
    let long = candidates(20_000, true);
    println!("candidates per segment: {few:.1}, {many:.1}; with a long spring {long:.1}");
    assert!((few / many - 1.0).abs() < 0.05 && (long / many - 1.0).abs() < 0.02);
}
