//! Does composition cost anything? The tuple `(Dpd, Wca)` against one law with both formulas fused by hand, in the
//! same loop over the same pairs. The ratio of the two times is to stay within 3 %.
#![allow(missing_docs, clippy::expect_used)]

#[allow(dead_code)]
mod scene;

use criterion::{Criterion, criterion_group, criterion_main};
use zimm::core::noise::Domain;
use zimm::prelude::*;

const EDGE: f64 = 12.0;
const SIGMA: f64 = 0.4;

#[derive(Clone, Copy)]
struct Fused {
    a: f64,
    gamma: f64,
    epsilon: f64,
}

impl PairForce for Fused {
    const READS: Reads = Reads {
        velocity: true,
        noise: true,
        species: false,
    };

    fn cutoff(&self) -> f64 {
        1.0
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, now: &Now) -> Central {
        let r = pair.r2.sqrt().max(1e-100);
        let inverse = 1.0 / r;
        let overlap = (1.0 - r).max(0.0);
        let amplitude = (2.0 * self.gamma * now.kt / now.dt).sqrt();
        let s2 = SIGMA * SIGMA / pair.r2;
        let s6 = s2 * s2 * s2;
        let repulsion = 24.0 * self.epsilon * (2.0 * s6 * s6 - s6) / pair.r2;
        let within = pair.r2 < SIGMA * SIGMA * 1.259_921_049_894_873_2;
        Central {
            conservative: self.a * overlap * inverse + if within { repulsion } else { 0.0 },
            dissipative: -self.gamma * (overlap * overlap) * (inverse * inverse) * pair.rv,
            random: amplitude * overlap * inverse * pair.noise.uniform(Domain::DPD),
        }
    }
}

fn composition(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("composition");
    let dpd = Dpd::new(25.0, 4.5).expect("legal parameters");
    let wca = Wca::new(1.0, SIGMA).expect("legal parameters");
    let fused = Fused {
        a: 25.0,
        gamma: 4.5,
        epsilon: 1.0,
    };
    group.bench_function("tuple of Dpd and Wca", |bencher| {
        let mut forces = scene::Forces::new(EDGE, (dpd, wca));
        bencher.iter(|| forces.evaluate());
    });
    group.bench_function("fused by hand", |bencher| {
        let mut forces = scene::Forces::new(EDGE, fused);
        bencher.iter(|| forces.evaluate());
    });
    group.finish();
}

criterion_group!(benches, composition);
criterion_main!(benches);
