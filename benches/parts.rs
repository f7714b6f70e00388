//! What the parts of a DPD step cost, for 3 000 and 24 000 particles, and the repulsion between springs, for 1 000 to
//! 16 000 segments.
#![allow(missing_docs, clippy::expect_used)]

#[allow(dead_code)]
mod scene;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use scene::Forces;
use zimm::prelude::*;

const EDGES: [f64; 2] = [10.0, 20.0];

fn parts(criterion: &mut Criterion) {
    let dpd = || Dpd::new(25.0, 4.5).expect("legal parameters");
    let mut group = criterion.benchmark_group("dpd");
    group.sample_size(20);
    for edge in EDGES {
        let particles = (scene::DENSITY * edge.powi(3)) as u64;
        group.throughput(Throughput::Elements(particles));
        group.bench_function(BenchmarkId::new("forces", particles), |bencher| {
            let mut forces = Forces::new(edge, dpd());
            bencher.iter(|| forces.evaluate());
        });
        group.bench_function(
            BenchmarkId::new("forces and virial", particles),
            |bencher| {
                let mut forces = Forces::new(edge, dpd());
                bencher.iter(|| forces.tallied::<Virial>());
            },
        );
        group.bench_function(BenchmarkId::new("list and forces", particles), |bencher| {
            let mut forces = Forces::new(edge, dpd());
            bencher.iter(|| forces.evaluate_with_new_list());
        });
        group.bench_function(BenchmarkId::new("step", particles), |bencher| {
            let (mut system, mut field) = scene::equilibrated(scene::cube(edge));
            let mut stepper = GrootWarren::new(0.65).expect("legal lambda");
            bencher.iter(|| {
                stepper
                    .step(&mut system, &mut field, &mut ())
                    .expect("a stable fluid")
            });
        });
    }
    group.finish();
}

/// Melt of chains of 20 whose springs repel each other within 0.8, the state of the workload `srp`: time for a segment, and
/// a whole step with and without.
fn segments(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("spring repulsion");
    group.sample_size(10);
    for segments in [1_000, 4_000, 16_000] {
        let mut melt = scene::Melt::new(segments);
        group.throughput(Throughput::Elements(u64::from(segments)));
        group.bench_function(BenchmarkId::new("forces", segments), |bencher| {
            bencher.iter(|| melt.repulsion());
        });
        group.bench_function(BenchmarkId::new("step", segments), |bencher| {
            bencher.iter(|| melt.step());
        });
        group.bench_function(BenchmarkId::new("step without it", segments), |bencher| {
            bencher.iter(|| melt.step_without());
        });
    }
    group.finish();
}

criterion_group!(benches, parts, segments);
criterion_main!(benches);
