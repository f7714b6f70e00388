//! A step of a scene that has settled allocates nothing.
#![allow(clippy::unwrap_used)]

use std::alloc::{GlobalAlloc, Layout, System as Heap};
use std::sync::{
    Mutex,
    atomic::{AtomicUsize, Ordering::Relaxed},
};
use zimm::prelude::*;

/// Counts what is asked of the heap.
struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

#[allow(unsafe_code)]
// SAFETY: every call goes on to the system's heap as it came; counting touches no memory of it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Relaxed);
        unsafe { Heap.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        unsafe { Heap.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Relaxed);
        unsafe { Heap.realloc(place, layout, size) }
    }
}

#[global_allocator]
static HEAP: Counting = Counting;

/// One scene at a time: the heap is everybody's.
static ALONE: Mutex<()> = Mutex::new(());

/// How many of so many steps allocate, after as many others.
fn steps_that_allocate<B: Boundary, F: ForceField<B>>(
    steps: usize,
    system: &mut System<B>,
    field: &mut F,
    stepper: &mut impl Stepper<B, F>,
) -> usize {
    let mut count = 0;
    for step in 0..2 * steps {
        let before = ALLOCATIONS.load(Relaxed);
        stepper.step(system, field, &mut ()).unwrap();
        count += usize::from(step >= steps && ALLOCATIONS.load(Relaxed) > before);
    }
    println!("{count} of {steps} steps allocate");
    count
}

/// A sheared solution of dumbbells, whose list is made anew every other step.
///
/// Lists grow when they hold more pairs than ever before, which gets rarer and rarer: the bound is that no more than one
/// step in a hundred allocates, where each would by a single buffer that is not kept.
#[test]
fn law_steps_allocate_nothing() {
    const STEPS: usize = 400;
    let _alone = ALONE.lock();
    let dumbbells = Molecules::linear(0, 200, 2).unwrap();
    let space = LeesEdwards::new(DVec3::splat(8.0), Steady::new(0.1).unwrap()).unwrap();
    let mut rng = start::stream(1);
    let mut positions = start::chains(space.lattice(), &dumbbells, |_| 0.5, &mut rng);
    positions.extend(start::uniform(space.lattice(), 1136, &mut rng));
    let particles = Particles::new(positions).unwrap();
    let velocities = start::velocities(&particles, 1.0, &mut rng).unwrap();
    let particles = particles.with_velocities(velocities).unwrap();
    let mut system = System::new(space, particles, Clock::new(0.02, 1.0, 1).unwrap());
    let pairs = Pairwise::new(Dpd::new(25.0, 4.5).unwrap(), VerletList::new(0.3).unwrap());
    let springs = Bonded::new(Fene::new(2.0, 5.0).unwrap(), dumbbells.bonds());
    let mut field = (pairs, springs);
    let mut stepper = GrootWarren::new(0.65).unwrap();
    let count = steps_that_allocate(STEPS, &mut system, &mut field, &mut stepper);
    let builds = field.0.neighbours().builds();
    assert!(builds > 40, "{builds}");
    assert!(count <= STEPS / 100, "{count}");
}

/// Chains with excluded volume that move each other, by the mesh, split noise and implicit springs. Pairs are looked for in
/// every step, and runs of them grow as lists do. Steps are made on a thread of the pool: work that comes from outside is
/// queued by rayon, in blocks of its own.
#[test]
fn law_steps_with_hydrodynamic_interactions_allocate_nothing() {
    const STEPS: usize = 400;
    let _alone = ALONE.lock();
    let chains = Molecules::linear(0, 60, 10).unwrap();
    let space = PeriodicBox::cubic(25.0).unwrap();
    let mut rng = start::stream(1);
    let positions = start::chains(space.lattice(), &chains, |_| 1.5, &mut rng);
    let particles = Particles::new(positions).unwrap();
    let mut system = System::new(space, particles, Clock::new(0.01, 1.0, 1).unwrap());
    let repulsion = NarrowGaussian::new(1.0, 1.0).unwrap();
    let pairs = Pairwise::new(repulsion, VerletList::new(0.5).unwrap());
    let springs = Bonded::new(Fene::new(1.0, 5.0).unwrap(), chains.bonds());
    let mobility = Mesh::new(4.0, 0.5, 1e-3).unwrap();
    let mut stepper = SemiImplicit::new(mobility, SplitNoise::new(1e-3).unwrap());
    let mut field = (springs, pairs);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
    let count = pool
        .unwrap()
        .install(|| steps_that_allocate(STEPS, &mut system, &mut field, &mut stepper));
    assert!(count <= STEPS / 100, "{count}");
}
