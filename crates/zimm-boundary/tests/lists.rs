//! Neighbour lists miss no pair in any flow: against all pairs at every step, at rates up to 10, and just before and
//! after each change of basis.

#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

mod common;

use common::{at, scattered};
use proptest::prelude::*;
use zimm_boundary::laws;
use zimm_core::{
    AllPairs, Clock, DVec3, Frame, Neighbours, Particles, Periodic, Remap, System, VerletList,
};

/// The pairs of a source that are in range, by place in the frame, lower place first.
fn pairs<B: Periodic, N: Neighbours<B>>(source: &N, cutoff: f64) -> Vec<([u32; 2], DVec3)> {
    let mut found = Vec::new();
    for block in 0..source.blocks() {
        source.visit(block, |row| {
            for &j in row.js {
                let positions = source.positions();
                let r = positions[row.i as usize] + row.shift - positions[j as usize];
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

/// Distances within 1e-9 of the cutoff may round to either side.
fn none_missed<B: Periodic>(list: &mut VerletList, frame: &Frame<'_, B>, cutoff: f64) {
    let mut all = AllPairs::default();
    list.refresh(frame, cutoff).unwrap();
    all.refresh(frame, cutoff).unwrap();
    let found = pairs::<B, _>(list, cutoff * (1.0 + 1e-9));
    let all = pairs::<B, _>(&all, cutoff);
    let sure = all
        .iter()
        .filter(|(_, r)| r.length() < cutoff * (1.0 - 1e-9));
    let mut rest = found.iter();
    for (pair, r) in sure {
        let seen = rest.find(|(other, _)| other == pair);
        assert!(seen.is_some(), "{pair:?} at {r} is missing");
        let error = seen.map_or(f64::INFINITY, |(_, near)| (*near - *r).length());
        assert!(error < 1e-9, "{pair:?}: {error:e}");
    }
    let twice = found.windows(2).any(|two| two[0].0 == two[1].0);
    assert!(!twice, "a pair twice");
}

/// Steps of a strain of up to 0.1, particles carried and pushed a little; wherever the basis changes within a step, the
/// list is looked at 1e-9 of a step before and after as well.
fn run<B: Periodic>(space: &B, start: f64, share: f64) {
    let cutoff = share * at(space, start).reach();
    let positions = scattered(at(space, start).lattice(), 100);
    let dt = 0.01;
    let mut system = System::new(
        space.clone(),
        Particles::new(positions).unwrap(),
        Clock::new(dt, 1.0, 0).unwrap(),
    );
    let mut list = VerletList::new(0.3 * cutoff).unwrap();
    let mut time = start;
    system.boundary.advance(start);
    let mut go = |system: &mut System<B>, to: f64, push: f64| {
        let carry = system.boundary.carry(time, to);
        let remap = system.boundary.advance(to);
        for (k, r) in system.particles.positions_mut().iter_mut().enumerate() {
            let direction = DVec3::new(
                (7.0 * k as f64).sin(),
                (5.0 * k as f64).cos(),
                (3.0 * k as f64).sin(),
            );
            *r = system.boundary.wrap(carry * *r + push * direction).0;
        }
        time = to;
        if cutoff < 0.99 * system.boundary.reach() {
            let mut frame = system.frame();
            // The clock of the frame is that of the boundary.
            frame.now.time = to;
            none_missed(&mut list, &frame, cutoff);
        }
        remap
    };
    for step in 0..30 {
        let [mut from, mut to] = [step, step + 1].map(|k| start + dt * f64::from(k));
        let end = to;
        if at(space, from).advance(to) != Remap::None {
            while to - from > 1e-9 * dt {
                let middle = 0.5 * (from + to);
                if at(space, from).advance(middle) != Remap::None {
                    to = middle;
                } else {
                    from = middle;
                }
            }
            go(&mut system, from, 0.0);
            go(&mut system, to, 0.0);
        }
        go(&mut system, end, 0.01 * cutoff);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10))]

    #[test]
    fn law_no_pair_is_missed(
        shear in laws::lees_edwards(),
        planar in laws::kraynik_reinelt(),
        mixed in laws::planar_mixed(),
        uniaxial in laws::uniaxial(),
        triaxial in laws::triaxial(),
        start in 0.0..20.0,
        share in 0.3..0.98,
    ) {
        run(&shear, start, share);
        run(&planar, start, share);
        run(&mixed, start, share);
        run(&uniaxial, start, share);
        run(&triaxial, start, share);
    }
}
