//! What a step costs in a cell that flows, beside the same step in a cube at rest: the Groot-Warren fluid of 24 000
//! particles. Steps of a flow are taken all through the periods of its cell.
#![allow(missing_docs, clippy::expect_used)]

#[allow(dead_code)]
mod scene;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use zimm::prelude::*;

const EDGE: f64 = 20.0;
/// A cell of the same volume, flat enough along the neutral axis for a fluid in extension not to stir itself.
const PLANE: f64 = 28.284;
const NEUTRAL: f64 = 10.0;

fn flows(criterion: &mut Criterion) {
    let rate = || Steady::new(0.1).expect("legal rate");
    let mut group = criterion.benchmark_group("step");
    group.sample_size(20);
    group.throughput(Throughput::Elements((scene::DENSITY * EDGE.powi(3)) as u64));
    let mut bench = |name, mut step: Box<dyn FnMut()>| {
        group.bench_function(name, |bencher| bencher.iter(&mut step));
    };
    bench("cube at rest", steps_in(scene::cube(EDGE)));
    bench(
        "shear, Lees-Edwards",
        steps_in(LeesEdwards::new(DVec3::splat(EDGE), rate()).expect("legal box")),
    );
    bench(
        "planar extension, Kraynik-Reinelt",
        steps_in(KraynikReinelt::new(PLANE, NEUTRAL, rate()).expect("legal box")),
    );
    bench(
        "planar mixed flow, mixedness 0.3",
        steps_in(PlanarMixed::new(PLANE, NEUTRAL, 0.3, rate()).expect("legal box")),
    );
    group.finish();
}

fn steps_in<B: Periodic + 'static>(boundary: B) -> Box<dyn FnMut()> {
    let (mut system, mut field) = scene::equilibrated(boundary);
    let mut stepper = GrootWarren::new(0.65).expect("legal lambda");
    Box::new(move || {
        stepper
            .step(&mut system, &mut field, &mut ())
            .expect("a stable fluid");
    })
}

criterion_group!(benches, flows);
criterion_main!(benches);
