//! Steps ask for no memory once they run.
#![allow(
    unsafe_code,
    reason = "what allocates can be counted by an allocator alone"
)]
#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

use std::alloc::{GlobalAlloc, Layout, System as Heap};
use std::cell::Cell;
use zimm_boundary::{OpenFlow, PeriodicBox};
use zimm_brownian::{Diagonal, FreeDraining, SemiImplicit};
use zimm_core::{Bonded, Boundary, Clock, DMat3, DVec3, Open, Particles, Stepper, System};
use zimm_forces::Fene;

thread_local! {
    static ASKED: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ASKED.with(|asked| asked.set(asked.get() + 1));
        unsafe { Heap.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        unsafe { Heap.dealloc(at, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Requests in 50 steps, after 50 others: the columns have grown by then.
fn requests<B: Boundary>(space: B, length: u32) -> usize {
    let beads = 10 * length;
    let bonds = (1..beads).filter(|k| k % length > 0).map(|k| [k - 1, k]);
    let mut springs = Bonded::new(Fene::new(1.0, 50.0_f64.sqrt()).unwrap(), bonds.collect());
    let positions = (0..beads).map(|k| f64::from(k % length) * DVec3::X);
    let particles = Particles::new(positions.collect()).unwrap();
    let mut system = System::new(space, particles, Clock::new(0.05, 1.0, 1).unwrap());
    let mut stepper = SemiImplicit::new(FreeDraining::new(4.0).unwrap(), Diagonal);
    let mut run = || {
        for _ in 0..50 {
            stepper.step(&mut system, &mut springs, &mut ()).unwrap();
        }
    };
    run();
    let before = ASKED.with(Cell::get);
    run();
    ASKED.with(Cell::get) - before
}

#[test]
fn law_a_semi_implicit_step_asks_for_no_memory() {
    let shear = DMat3::from_cols(DVec3::ZERO, DVec3::X, DVec3::ZERO);
    for length in [2, 10] {
        assert_eq!(requests(Open, length), 0);
        assert_eq!(requests(OpenFlow::new(shear).unwrap(), length), 0);
        assert_eq!(requests(PeriodicBox::cubic(30.0).unwrap(), length), 0);
    }
}
