//! The mesh against independent reference numbers, laws and hostile input.
#![cfg(feature = "hydrodynamics")]
#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

mod common;

use common::{at, at_time, numbers, product, vectors};
use serde_json::Value;
use zimm_boundary::{KraynikReinelt, LeesEdwards, PeriodicBox, PlanarMixed, Steady};
use zimm_brownian::{
    Auto, Ewald, Lanczos, Mesh, Mobility, Root, SplitNoise, White, mobility_laws as laws,
};
use zimm_core::noise::{Domain, Noise};
use zimm_core::{
    Boundary, Clock, DMat3, DVec3, IVec3, MobilityError, Now, Particles, Periodic, System,
};

/// The moment of some step of some run.
fn moment(seed: u64, step: u64) -> Now {
    Now {
        seed,
        step,
        ..Now::default()
    }
}

/// A cell whose basis vectors are the rows of a file.
fn cell(rows: &[f64]) -> PeriodicBox {
    let basis: [f64; 9] = rows.try_into().unwrap();
    PeriodicBox::triclinic(DMat3::from_cols_array(&basis)).unwrap()
}

fn cases(text: &str) -> Vec<Value> {
    let file: Value = serde_json::from_str(text).unwrap();
    file["cases"].as_array().unwrap().clone()
}

fn all_matrices() -> Vec<Value> {
    [
        include_str!("data/mobility_small.json"),
        include_str!("data/mobility_20_beads.json"),
        include_str!("data/mobility_extreme.json"),
    ]
    .into_iter()
    .flat_map(cases)
    .collect()
}

/// The matrix of a bound mobility, column by column.
fn matrix<B: Boundary>(mobility: &mut impl Mobility<B>, beads: usize) -> Vec<Vec<f64>> {
    let column = |k: usize| {
        let mut forces = vec![DVec3::ZERO; beads];
        forces[k / 3][k % 3] = 1.0;
        let mut velocities = vec![DVec3::ZERO; beads];
        mobility.apply(&forces, &mut velocities);
        velocities.iter().flat_map(|u| u.to_array()).collect()
    };
    (0..3 * beads).map(column).collect()
}

fn stored(case: &Value) -> Vec<Vec<f64>> {
    let lower = numbers(&case["M_lower"]);
    let size = 3 * case["n"].as_u64().unwrap() as usize;
    let entry = |p: usize, q: usize| {
        let (p, q) = (p.max(q), p.min(q));
        lower[p * (p + 1) / 2 + q]
    };
    (0..size)
        .map(|p| (0..size).map(|q| entry(p, q)).collect())
        .collect()
}

fn length(columns: &[Vec<f64>]) -> f64 {
    let squares = columns.iter().flatten().map(|x| x * x);
    squares.sum::<f64>().sqrt()
}

fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let minus = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
    a.iter().zip(b).map(minus).collect()
}

/// Beads anywhere in a cube of this edge, and forces on them.
fn random(beads: usize, edge: f64, seed: u64) -> (Vec<DVec3>, Vec<DVec3>) {
    let noise = Noise::new(seed, 0);
    let place = |k| {
        let site = noise.site(k as u32);
        let uniform = |d| site.uniform(Domain::user(d)) / 12.0_f64.sqrt();
        edge * DVec3::new(uniform(1), uniform(2), uniform(3))
    };
    let force = |k| noise.site(k as u32).normal3(Domain::user(4));
    (
        (0..beads).map(place).collect(),
        (0..beads).map(force).collect(),
    )
}

fn relative(found: &[DVec3], exact: &[DVec3]) -> f64 {
    let square = |x: DVec3| x.length_squared();
    let error: f64 = found.iter().zip(exact).map(|(a, b)| square(*a - *b)).sum();
    (error / exact.iter().map(|x| square(*x)).sum::<f64>()).sqrt()
}

// 15-digit matrices of 2 to 20 beads in cubic, sheared, Kraynik-Reinelt, mixed-flow, 1:2:5, slab and left-handed cells,
// dilute (a/L = 0.001), dense (volume fractions 0.4 and 2), touching, overlapping and coincident.
#[test]
fn reference_matrices_to_the_tolerance() {
    for case in all_matrices() {
        let positions = vectors(&case["pos"]);
        let radius = case["a"].as_f64().unwrap();
        let system = at(cell(&numbers(&case["box"])), &positions);
        let exact = stored(&case);
        for tolerance in [1e-2, 1e-3, 1e-6, 1e-9, 1e-10] {
            let mut mesh = Mesh::new(1.0, radius, tolerance).unwrap();
            mesh.bind(&system.frame()).unwrap();
            let found = matrix::<PeriodicBox>(&mut mesh, positions.len());
            let error = length(&difference(&found, &exact)) / length(&exact);
            assert!(
                error < tolerance,
                "{}: {error:e}, not {tolerance:e}",
                case["id"]
            );
        }
    }
}

#[test]
fn reference_product_to_the_tolerance() {
    for case in cases(include_str!("data/product_300_beads.json")) {
        let (positions, forces) = (vectors(&case["pos"]), vectors(&case["F"]));
        let system = at(cell(&numbers(&case["box"])), &positions);
        let exact = vectors(&case["U"]);
        for tolerance in [
            1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11,
        ] {
            let mut mesh = Mesh::new(1.0, case["a"].as_f64().unwrap(), tolerance).unwrap();
            let error = relative(&product(&mut mesh, &system, &forces), &exact);
            assert!(error < tolerance, "{error:e}, not {tolerance:e}");
            assert!(
                error > 0.02 * tolerance,
                "{error:e} is more than was paid for"
            );
        }
    }
}

// One bead in primitive cells of cubic lattices, also so large that images overlap: 18-digit numbers.
#[test]
fn reference_lattices_of_one_bead() {
    for line in include_str!("data/self_mobility.csv").lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |k: usize| fields[k].parse::<f64>().unwrap();
        let rows = match fields[0] {
            "SC" => DMat3::IDENTITY,
            "BCC" => {
                0.5 * DMat3::from_cols_array(&[-1.0, 1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0, -1.0])
            }
            _ => 0.5 * DMat3::from_cols_array(&[0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0]),
        };
        let system = at(PeriodicBox::triclinic(rows).unwrap(), &[DVec3::ZERO]);
        let exact = number(4);
        for tolerance in [1e-3, 1e-9] {
            let mut mesh = Mesh::new(1.0, number(1), tolerance).unwrap();
            let found = product(&mut mesh, &system, &[DVec3::Y])[0];
            let error = (found - exact * DVec3::Y).length();
            assert!(error < tolerance, "{line}: {error:e}");
        }
    }
}

// The direct sum has another split, other lists and no mesh. Times through the periods of three flows, on both sides
// of remaps; 400 beads, 2 % of them overlapping.
#[test]
fn law_agrees_with_the_direct_sum_in_flow() {
    fn check<B: Periodic>(space: B) {
        let (positions, forces) = random(400, 24.0, 5);
        for time in [0.0, 0.2, 0.4999, 0.5001, 0.7, 0.9] {
            let system = at_time(space.clone(), &positions, time);
            let mut direct = Ewald::new(1.0, 0.9, 1e-8).unwrap();
            let exact = product(&mut direct, &system, &forces);
            for tolerance in [1e-3, 1e-6] {
                let mut mesh = Mesh::new(1.0, 0.9, tolerance).unwrap();
                let error = relative(&product(&mut mesh, &system, &forces), &exact);
                assert!(error < tolerance, "{time}: {error:e}, not {tolerance:e}");
            }
        }
    }
    let steady = |rate| Steady::new(rate).unwrap();
    check(LeesEdwards::new(DVec3::splat(24.0), steady(1.0)).unwrap());
    check(KraynikReinelt::new(24.0, 24.0, steady(1.0)).unwrap());
    check(PlanarMixed::new(24.0, 24.0, 0.25, steady(1.0)).unwrap());
}

#[test]
fn law_of_mobilities() {
    for case in all_matrices() {
        let id = case["id"].as_str().unwrap();
        if !["kr_t0.9", "pmf_g2_t0.25", "dense_phi2", "box_1_2_5"].contains(&id) {
            continue;
        }
        let system = at(cell(&numbers(&case["box"])), &vectors(&case["pos"]));
        let radius = case["a"].as_f64().unwrap();
        laws::check_mobility(&mut Mesh::new(4.0, radius, 1e-3).unwrap(), &system, 1e-3);
        laws::check_mobility(&mut Mesh::new(4.0, radius, 1e-9).unwrap(), &system, 1e-9);
    }
}

// An amplitude of the noise that is wrong by 4 / sqrt(3 N samples) shows: 1 % for 10^4 samples and 5 beads, 0.7 % for
// 20 beads.
#[test]
fn law_of_split_noise() {
    for case in all_matrices() {
        let id = case["id"].as_str().unwrap();
        let wanted = [
            "cubic_n2_overlap",
            "pmf_g2_t0.25",
            "kr_t0.9_n20",
            "contact_coincident",
        ];
        if !wanted.contains(&id) {
            continue;
        }
        let system = at(cell(&numbers(&case["box"])), &vectors(&case["pos"]));
        let mut mesh = Mesh::new(4.0, case["a"].as_f64().unwrap(), 1e-4).unwrap();
        let mut root = SplitNoise::new(1e-4).unwrap();
        let samples = if case["n"] == 20 { 5000 } else { 10_000 };
        laws::noise_has_the_covariance(&mut root, &mut mesh, &system, samples);
    }
}

// Iterations for the pairs do not grow with the number of beads; those for the whole do. Beads do not overlap: a cubic
// array, displaced.
#[test]
fn law_iterations_do_not_grow_with_the_system() {
    let iterations = |side: i32| {
        let spacing = 3.5;
        let edge = spacing * f64::from(side);
        let beads = (side * side * side) as usize;
        let jitter = random(beads, 1.0, 3).0;
        let site = |k: usize| {
            IVec3::new(
                k as i32 % side,
                k as i32 / side % side,
                k as i32 / side / side,
            )
        };
        let positions: Vec<DVec3> = (0..beads)
            .map(|k| spacing * site(k).as_dvec3() + jitter[k])
            .collect();
        let system = at(PeriodicBox::cubic(edge).unwrap(), &positions);
        let mut mesh = Mesh::new(1.0, 1.0, 1e-3).unwrap();
        let (mut root, mut whole) = (SplitNoise::new(1e-3).unwrap(), Lanczos::new(1e-3).unwrap());
        mesh.bind(&system.frame()).unwrap();
        let frame = system.frame();
        let white = White::new(moment(1, 1), &frame);
        let mut noise = vec![DVec3::ZERO; beads];
        Root::<PeriodicBox, _>::add(&mut root, &mut mesh, &white, 1.0, &mut noise).unwrap();
        Root::<PeriodicBox, _>::add(&mut whole, &mut mesh, &white, 1.0, &mut noise).unwrap();
        (root.iterations(), whole.iterations())
    };
    let (small, large) = (iterations(5), iterations(20));
    assert!(large.0 <= small.0 + 1, "{small:?} {large:?}");
    assert!(large.1 > small.1 + 1, "{small:?} {large:?}");
}

#[test]
fn law_history_does_not_show() {
    let (positions, forces) = random(200, 15.0, 8);
    let system = at(PeriodicBox::cubic(15.0).unwrap(), &positions);
    let other = at(
        PeriodicBox::brick(DVec3::new(9.0, 31.0, 17.0)).unwrap(),
        &positions[..70],
    );
    let mut fresh = Mesh::new(1.0, 0.7, 1e-4).unwrap();
    let mut used = fresh.clone();
    product(&mut used, &other, &forces[..70]);
    assert_eq!(
        product(&mut fresh, &system, &forces),
        product(&mut used, &system, &forces)
    );
}

#[cfg(feature = "rayon")]
#[test]
fn law_threads_do_not_show() {
    let (positions, forces) = random(3000, 40.0, 9);
    let system = at(PeriodicBox::cubic(40.0).unwrap(), &positions);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let mut mesh = Mesh::new(1.0, 1.0, 1e-3).unwrap();
            let mut moved = product(&mut mesh, &system, &forces);
            let frame = system.frame();
            let white = White::new(moment(1, 1), &frame);
            let mut root = SplitNoise::new(1e-3).unwrap();
            Root::<PeriodicBox, _>::add(&mut root, &mut mesh, &white, 1.0, &mut moved).unwrap();
            moved
        })
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
}

#[test]
fn extreme_parameters_are_refused() {
    for tolerance in [0.0, 1e-12, 1e-17, 0.2, f64::NAN, -1.0] {
        assert!(Mesh::new(1.0, 1.0, tolerance).is_err(), "{tolerance}");
    }
    for wrong in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        assert!(Mesh::new(wrong, 1.0, 1e-3).is_err());
        assert!(Mesh::new(1.0, wrong, 1e-3).is_err());
    }
    assert!(SplitNoise::new(1e-17).is_err());
}

#[test]
fn extreme_cells_are_refused() {
    let bind = |radius: f64, edges: DVec3| {
        let system = at(PeriodicBox::brick(edges).unwrap(), &[DVec3::ZERO]);
        Mesh::new(1.0, radius, 1e-3).unwrap().bind(&system.frame())
    };
    assert!(bind(2.9, DVec3::new(10.0, 10.0, 1.0)).is_ok());
    let refused = bind(3.1, DVec3::new(10.0, 10.0, 1.0));
    assert!(
        matches!(refused, Err(MobilityError::Cell { found, .. }) if (found - 3.1).abs() < 1e-12)
    );
    let refused = bind(1e-3, DVec3::new(1e-2, 1e-2, 1e9));
    assert!(
        matches!(refused, Err(MobilityError::Cell { .. })),
        "{refused:?}"
    );
}

#[test]
fn extreme_beads() {
    let space = PeriodicBox::cubic(10.0).unwrap();
    // None.
    let system = at(space, &[]);
    assert!(product(&mut Mesh::new(1.0, 1.0, 1e-3).unwrap(), &system, &[]).is_empty());
    // Ten at one point move as one.
    let system = at(space, &[DVec3::new(1.0, 2.0, 4.999_999); 10]);
    let mut mesh = Mesh::new(1.0, 1.0, 1e-9).unwrap();
    let mut forces = [DVec3::ZERO; 10];
    forces[3] = DVec3::X;
    for velocity in product(&mut mesh, &system, &forces) {
        assert!((velocity - 0.720_459_042_256_724_4 * DVec3::X).length() < 1e-9);
    }
    // Lost ones are named.
    let mut system = at(space, &[DVec3::ZERO; 3]);
    system.particles.columns_mut().positions[2].y = f64::NAN;
    let refused = mesh.bind(&system.frame());
    assert!(matches!(
        refused,
        Err(MobilityError::NotFinite { particle: 2, .. })
    ));
}

/// Below and above the crossover, the choice gives the velocities of what it chose, bit for bit.
#[test]
fn law_the_choice_is_one_of_the_two() {
    fn moved<M: Mobility<PeriodicBox>>(mobility: M, count: usize) -> Vec<DVec3> {
        let mut mobility = mobility;
        let space = PeriodicBox::brick(DVec3::splat(30.0)).unwrap();
        let spiral = |k: usize| {
            let k = k as f64;
            DVec3::new(k.sin(), k.cos(), (0.7 * k).sin()) * (14.0 * (0.13 * k).cos())
        };
        let particles = Particles::new((0..count).map(spiral).collect()).unwrap();
        let clock = Clock::new(0.01, 1.0, 1).unwrap();
        let system = System::new(space, particles, clock);
        mobility.bind(&system.frame()).unwrap();
        let mut velocities = vec![DVec3::ZERO; count];
        mobility.apply(system.particles.positions(), &mut velocities);
        velocities
    }
    let auto = |count| moved(Auto::new(4.0, 0.5, 1e-3).unwrap(), count);
    let direct = |count| moved(Ewald::new(4.0, 0.5, 1e-3).unwrap(), count);
    let mesh = |count| moved(Mesh::new(4.0, 0.5, 1e-3).unwrap(), count);
    assert_eq!(auto(50), direct(50));
    assert_eq!(auto(2000), mesh(2000));
    assert_ne!(direct(50), mesh(50));
}
