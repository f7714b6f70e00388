//! A step of a scene that has settled allocates nothing.
#![allow(clippy::unwrap_used)]

use std::alloc::{GlobalAlloc, Layout, System as Heap};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
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

/// A sheared solution of dumbbells, whose list is made anew every other step.
///
/// Lists grow when they hold more pairs than ever before, which gets rarer and rarer: the bound is that no more than one
/// step in a hundred allocates, where each would by a single buffer that is not kept.
#[test]
fn law_steps_allocate_nothing() {
    const STEPS: usize = 400;
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
    for _ in 0..STEPS {
        stepper.step(&mut system, &mut field, &mut ()).unwrap();
    }
    let builds = field.0.neighbours().builds();
    let mut steps_that_allocate = 0;
    for _ in 0..STEPS {
        let before = ALLOCATIONS.load(Relaxed);
        stepper.step(&mut system, &mut field, &mut ()).unwrap();
        steps_that_allocate += usize::from(ALLOCATIONS.load(Relaxed) > before);
    }
    let builds = field.0.neighbours().builds() - builds;
    println!("{steps_that_allocate} of {STEPS} steps allocate; {builds} lists");
    assert!(builds > 20, "{builds}");
    assert!(steps_that_allocate <= STEPS / 100, "{steps_that_allocate}");
}
