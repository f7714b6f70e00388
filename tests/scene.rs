//! The scenes that the tests share; none of them uses all.
#![allow(dead_code, unreachable_pub)]

use zimm::prelude::*;

/// Particles at random with thermal velocities of kT = 1, some of them joined to dumbbells.
///
/// The first `2 dumbbells` identities are the beads; `bond` is the length that dumbbells start with.
pub fn scene<B: Periodic>(
    boundary: B,
    density: f64,
    (dumbbells, bond): (u32, f64),
    clock: Clock,
) -> (System<B>, Molecules) {
    let lattice = *boundary.lattice();
    let count = (density * lattice.volume()).round() as usize;
    let molecules = Molecules::linear(0, dumbbells, 2).unwrap();
    let mut rng = start::stream(clock.now().seed);
    let mut positions = start::chains(&lattice, &molecules, |_| bond, &mut rng);
    let solvent = count - positions.len();
    positions.extend(start::uniform(&lattice, solvent, &mut rng));
    let particles = Particles::new(positions).unwrap();
    let velocities = start::velocities(&particles, 1.0, &mut rng).unwrap();
    let particles = particles
        .with_velocities(velocities)
        .unwrap()
        .counting_images();
    (System::new(boundary, particles, clock), molecules)
}

/// A simple fluid.
pub fn fluid<B: Periodic>(boundary: B, density: f64, clock: Clock) -> System<B> {
    scene(boundary, density, (0, 0.0), clock).0
}

/// A law between all pairs, with a list whose skin suits DPD.
pub fn pairs<L: PairForce>(law: L) -> Pairwise<L, VerletList> {
    Pairwise::new(law, VerletList::new(0.35).unwrap())
}

/// Steps that are not looked at.
pub fn run<B: Boundary, F: ForceField<B>>(
    stepper: &mut impl Stepper<B, F>,
    system: &mut System<B>,
    field: &mut F,
    steps: u32,
) {
    for _ in 0..steps {
        stepper.step(system, field, &mut ()).unwrap();
    }
}

/// The total peculiar momentum.
pub fn momentum<B>(system: &System<B>) -> DVec3 {
    let particles = &system.particles;
    let each = particles.velocities().iter().enumerate();
    each.map(|(k, &c)| particles.mass(k) * c).sum()
}
