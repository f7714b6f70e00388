//! The same bits on any number of threads, and after a restart.
#![allow(clippy::unwrap_used)]

mod scene;

use rayon::ThreadPoolBuilder;
use scene::scene;
use zimm::prelude::*;

type Shear = LeesEdwards<Steady>;
type Field = (Pairwise<Dpd, VerletList>, Bonded<Fene>);

fn space() -> Shear {
    LeesEdwards::new(DVec3::new(16.0, 15.0, 14.0), Steady::new(0.5).unwrap()).unwrap()
}

/// 10 080 particles, 1000 of them in dumbbells, in shear: several blocks of pairs and several chunks of particles.
fn start() -> (System<Shear>, Field) {
    let (system, molecules) = scene(space(), 3.0, (500, 0.5), Clock::new(0.02, 1.0, 8).unwrap());
    assert_eq!(system.particles.len(), 10_080);
    let springs = Bonded::new(Fene::new(2.0, 5.0).unwrap(), molecules.bonds());
    let dpd = Dpd::new(25.0, 4.5).unwrap();
    (system, (Pairwise::new(dpd, VerletList::tuned()), springs))
}

/// Takes steps and answers every bit of the state and of the virials and energies on the way.
fn go(system: &mut System<Shear>, field: &mut Field, steps: u32) -> Vec<u64> {
    let mut stepper = GrootWarren::new(0.65).unwrap();
    let mut numbers = Vec::new();
    for _ in 0..steps {
        let mut heard = (Virial::default(), Energy::default());
        stepper.step(system, field, &mut heard).unwrap();
        for item in Item::ALL {
            numbers.extend(heard.0.item(item).to_cols_array());
        }
        numbers.push(heard.1.0);
    }
    let particles = &system.particles;
    for column in [
        particles.positions(),
        particles.velocities(),
        particles.forces(),
    ] {
        numbers.extend(column.iter().flat_map(|v| v.to_array()));
    }
    numbers.extend(
        particles
            .images()
            .iter()
            .flat_map(|n| n.as_dvec3().to_array()),
    );
    numbers.push(system.clock.now().time);
    numbers.into_iter().map(f64::to_bits).collect()
}

fn on_threads(threads: usize) -> Vec<u64> {
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    pool.install(|| {
        let (mut system, mut field) = start();
        let bits = go(&mut system, &mut field, 200);
        // Lists were made anew on the way, and the basis of the cell changed: 2 strains of 15/16 L_x.
        assert!(field.0.neighbours().builds() > 5);
        assert!(system.particles.images().iter().any(|n| n.x != 0));
        bits
    })
}

#[test]
fn law_bits_do_not_depend_on_threads() {
    let one = on_threads(1);
    assert!(one == on_threads(2));
    assert!(one == on_threads(5));
}

/// A run that writes a checkpoint and goes on agrees with one that starts from it, in every bit, on another
/// number of threads.
#[test]
fn law_bits_do_not_depend_on_restarts() {
    let (mut system, mut field) = start();
    go(&mut system, &mut field, 103);
    let mut file = Vec::new();
    save(&system, &mut field, &mut file).unwrap();
    let on = go(&mut system, &mut field, 97);

    let (_, mut fresh) = start();
    let mut again = load(space(), &mut file.as_slice()).unwrap();
    let pool = ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let restarted = pool.install(|| go(&mut again, &mut fresh, 97));
    assert!(on == restarted);
    assert_eq!(again.clock, system.clock);
    assert_eq!(again.particles, system.particles);
}
