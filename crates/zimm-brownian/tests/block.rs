//! Square roots for several steps at once: against dense roots of any spectrum, Lanczos' method, the distribution of the
//! noise, and hostile input.
#![cfg(feature = "hydrodynamics")]
#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

mod dense;

use dense::{at, beads, exact, relative_error, white};
use std::cell::Cell;
use zimm_boundary::PeriodicBox;
use zimm_brownian::mobility_laws::{self as laws, Matrix};
use zimm_brownian::{BlockLanczos, Ewald, Lanczos, Mobility, Root, Rpy, SemiImplicit, White};
use zimm_core::noise::{Domain, Noise};
use zimm_core::{
    Bonded, Boundary, Clock, DVec3, Frame, MobilityError, Molecules, Open, Particles, Stepper,
    System,
};
use zimm_forces::Fene;

/// The roots of so many steps, of which the first is a multiple of that number.
fn block<B: Boundary, M: Mobility<B>>(
    root: &mut BlockLanczos,
    columns: u64,
    mobility: &mut M,
    system: &System<B>,
    first: u64,
) -> Result<Vec<Vec<DVec3>>, MobilityError> {
    mobility.bind(&system.frame())?;
    let mut roots = vec![vec![DVec3::ZERO; system.particles.len()]; columns as usize];
    root.add(mobility, &white(system, first), 1.0, &mut roots[0])?;
    for (step, x) in (first..).zip(&mut roots).skip(1) {
        root.again(mobility, &white(system, step), 1.0, x)?;
    }
    Ok(roots)
}

fn alone<B: Boundary, M: Mobility<B>, R: Root<B, M>>(
    root: &mut R,
    mobility: &mut M,
    system: &System<B>,
    step: u64,
) -> Result<Vec<DVec3>, MobilityError> {
    mobility.bind(&system.frame())?;
    let mut x = vec![DVec3::ZERO; system.particles.len()];
    root.add(mobility, &white(system, step), 1.0, &mut x)?;
    Ok(x)
}

/// Spectra of so many eigenvalues, by name.
fn spectra(order: usize) -> Vec<(String, Vec<f64>)> {
    let share = |k: usize| k as f64 / (order - 1) as f64;
    let mut all: Vec<(String, Vec<f64>)> = Vec::new();
    let mut push = |name: String, value: &dyn Fn(usize) -> f64| {
        all.push((name, (0..order).map(value).collect()));
    };
    for condition in [1e2_f64, 1e4, 1e6] {
        push(format!("equally spaced to {condition:e}"), &|k| {
            condition.recip() + (1.0 - condition.recip()) * share(k)
        });
        push(format!("equal ratios to {condition:e}"), &|k| {
            condition.powf(-share(k))
        });
        push(format!("five apart at {condition:e}"), &|k| match k {
            0..5 => (1.0 + k as f64) / condition,
            _ => 0.5 + share(k),
        });
        push(format!("one apart at {condition:e}"), &|k| match k {
            0 => condition.recip(),
            _ => 0.5 + share(k),
        });
        push(format!("three high to {condition:e}"), &|k| match k {
            0..3 => 1.0,
            _ => (1.0 + share(k)) / condition,
        });
    }
    let vanishing = |k| if k < 5 { 0.0 } else { 0.5 + share(k) };
    push("five vanish".into(), &vanishing);
    push("one vanishes".into(), &|k| {
        if k == 0 { 0.0 } else { 0.5 + share(k) }
    });
    push("all alike".into(), &|_| 3.0);
    all
}

// The error asked for is delivered in every column: against the exact dense root, two blocks each. A singular matrix cannot
// be known better than to the root of the rounding, so there 1e-10 is an error that says how far it came.
#[test]
fn law_the_error_asked_for_is_delivered() {
    for (name, values) in spectra(120) {
        let (mut mobility, mut root) = Matrix::with_spectrum(&values, 7).unwrap();
        let system = beads(mobility.beads());
        for (tolerance, columns) in [1e-2, 1e-3, 1e-6, 1e-10]
            .into_iter()
            .flat_map(|tolerance| [2, 4, 8, 16].map(|columns| (tolerance, columns)))
        {
            let mut several = BlockLanczos::new(tolerance, columns as usize).unwrap();
            for first in [0, 100] {
                let found = block(&mut several, columns, &mut mobility, &system, first);
                if name.contains("vanish") && tolerance < 1e-8 {
                    let Err(MobilityError::NotConverged { reached, asked, .. }) = found else {
                        panic!("{name}: {found:?}");
                    };
                    assert!(reached > asked && reached < 1e-4, "{name}: {reached:e}");
                    continue;
                }
                assert!(several.error() <= tolerance);
                for (step, found) in (first..).zip(&found.unwrap()) {
                    let error = relative_error(found, &exact(&mut root, &system, step));
                    assert!(
                        error < tolerance,
                        "{name}, {columns} columns: {error:e} for {tolerance:e}"
                    );
                }
            }
        }
    }
}

/// A chain of so many beads, some of which overlap.
fn walk(count: u32, bond: f64) -> Vec<DVec3> {
    let noise = Noise::new(8, 0);
    let mut r = DVec3::ZERO;
    let step = |identity| noise.site(identity).normal3(Domain::user(1)).normalize();
    (0..count)
        .map(|identity| {
            r += bond * step(identity);
            r
        })
        .collect()
}

fn rpy() -> Rpy {
    Rpy::new(4.0, 0.443_113).unwrap()
}

// What `again` hands out is the root of the noise of its own step, by Lanczos' method alone; a step that was not foreseen
// begins a block, and so does noise that is drawn again. Noise of other steps is another: roots of two steps differ by some
// sqrt(2) of their lengths.
#[test]
fn law_each_step_has_the_root_of_its_own_noise() {
    let system = at(&walk(60, 0.7));
    let count = Cell::new(0);
    let (mut mobility, mut plain) = (Counted(rpy(), &count), rpy());
    let mut lanczos = Lanczos::new(1e-9).unwrap();
    let mut several = BlockLanczos::new(1e-8, 5).unwrap();
    let found = block(&mut several, 5, &mut mobility, &system, 20).unwrap();
    assert_eq!(count.get(), several.products());
    for (step, found) in (20..).zip(&found) {
        let expected = alone(&mut lanczos, &mut plain, &system, step).unwrap();
        assert!(relative_error(found, &expected) < 2e-8, "step {step}");
        let other = alone(&mut lanczos, &mut plain, &system, step + 1).unwrap();
        assert!(relative_error(found, &other) > 1.0, "step {step}");
    }
    let mut is_kept = |white: &White<'_>| {
        let before = count.get();
        let mut found = vec![DVec3::ONE; 60];
        Root::<Open, _>::again(&mut several, &mut mobility, white, -2.0, &mut found).unwrap();
        let mut expected = vec![DVec3::ONE; 60];
        Root::<Open, _>::add(&mut lanczos, &mut plain, white, -2.0, &mut expected).unwrap();
        assert!(relative_error(&found, &expected) < 2e-8);
        count.get() == before
    };
    assert!(is_kept(&white(&system, 22)));
    assert!(is_kept(&white(&system, 20).later(4)));
    assert!(!is_kept(&white(&system, 25)));
    assert!(is_kept(&white(&system, 29)));
    assert!(!is_kept(&white(&system, 24)));
    assert!(!is_kept(&white(&system, 26).again(&[1; 60])));
}

/// Begins a block at every fifth vector.
struct Rounds(BlockLanczos, usize);

impl<M: Mobility<Open>> Root<Open, M> for Rounds {
    fn add(
        &mut self,
        mobility: &mut M,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        self.1 += 1;
        if self.1 % 5 == 1 {
            self.0.add(mobility, white, scale, displacements)
        } else {
            self.0.again(mobility, white, scale, displacements)
        }
    }
}

// Five beads that overlap, 2e4 samples: the bounds are stated in `laws`, and amplitudes wrong by 0.7 % are found. Columns are
// independent, since modes are over all samples: five columns that are alike would leave a fifth of the samples.
#[test]
fn law_noise_has_the_covariance_of_the_mobility() {
    let system = at(&walk(5, 0.6));
    let rounds = |tolerance| Rounds(BlockLanczos::new(tolerance, 5).unwrap(), 0);
    laws::noise_has_the_covariance(&mut rounds(1e-4), &mut rpy(), &system, 20_000);
    laws::scales_and_adds(
        &mut BlockLanczos::new(1e-10, 5).unwrap(),
        &mut rpy(),
        &system,
        1e-10,
    );
    laws::squares_to_the_mobility(&mut rounds(1e-10), &mut rpy(), &system, 1e-10);
}

// A block that fills the space, columns that depend on each other, and nobody: 1, 2 and 5 beads, up to 40 columns.
#[test]
fn extreme_more_columns_than_dimensions() {
    for order in [3, 6, 15] {
        let values: Vec<f64> = (0..order).map(|k| 1e-4_f64.powf(k as f64 / 14.0)).collect();
        let (mut mobility, mut root) = Matrix::with_spectrum(&values, 5).unwrap();
        let system = beads(order / 3);
        for columns in [1, 2, 3, 4, 7, 16, 40] {
            let mut several = BlockLanczos::new(1e-9, columns as usize).unwrap();
            let found = block(&mut several, columns, &mut mobility, &system, 0).unwrap();
            assert!(several.products() <= order, "{}", several.products());
            for (step, found) in (0..).zip(&found) {
                let error = relative_error(found, &exact(&mut root, &system, step));
                assert!(error < 1e-9, "{order}, {columns} columns: {error:e}");
            }
        }
    }
    let mut several = BlockLanczos::new(1e-3, 4).unwrap();
    assert_eq!(
        block(&mut several, 4, &mut rpy(), &at(&[]), 0),
        Ok(vec![vec![]; 4])
    );
}

// Ten beads in one place, with five others about: 27 eigenvalues vanish. Coincident beads move alike.
#[test]
fn extreme_coincident_beads() {
    let mut positions = walk(15, 0.5);
    positions[..10].fill(DVec3::ONE);
    let system = at(&positions);
    for tolerance in [1e-2, 1e-4, 1e-6] {
        for columns in [1, 4, 16, 30] {
            let mut several = BlockLanczos::new(tolerance, columns as usize).unwrap();
            let found = block(&mut several, columns, &mut rpy(), &system, 0).unwrap();
            for x in &found {
                let apart = x[..10].iter().map(|y| (*y - x[0]).length());
                assert!(apart.fold(0.0, f64::max) < 20.0 * tolerance);
                assert!(x.iter().all(|x| x.length() > 1e-3));
            }
        }
    }
    let mut rounds = Rounds(BlockLanczos::new(1e-4, 5).unwrap(), 0);
    let few = at(&positions[8..12]);
    laws::noise_has_the_covariance(&mut rounds, &mut rpy(), &few, 10_000);
}

#[test]
fn extreme_mobilities_that_are_none() {
    let system = beads(10);
    let draw = |mobility: &mut Matrix, columns: u64| {
        let mut several = BlockLanczos::new(1e-3, columns as usize).unwrap();
        block(&mut several, columns, mobility, &system, 0)
    };
    for columns in [1, 4, 30, 40] {
        let mut values = vec![1.0; 30];
        values[4] = -0.1;
        let (mut indefinite, _) = Matrix::with_spectrum(&values, 3).unwrap();
        let failed = draw(&mut indefinite, columns);
        let Err(MobilityError::NotPositive { found, .. }) = failed else {
            panic!("{failed:?}");
        };
        assert!(found < -0.01 && found > -10.0, "{found}");
        let failed = draw(&mut Matrix::new(&[-1.0; 900]).unwrap(), columns);
        assert!(
            matches!(failed, Err(MobilityError::NotPositive { .. })),
            "{failed:?}"
        );

        for entry in [f64::NAN, f64::INFINITY] {
            let failed = draw(&mut Matrix::new(&[entry; 900]).unwrap(), columns);
            assert!(
                matches!(failed, Err(MobilityError::NotFinite { .. })),
                "{failed:?}"
            );
        }

        let still = draw(&mut Matrix::new(&[0.0; 900]).unwrap(), columns).unwrap();
        assert!(still.iter().flatten().all(|x| *x == DVec3::ZERO));
        let mut several = BlockLanczos::new(1e-3, columns as usize).unwrap();
        let still = block(&mut several, columns, &mut (), &system, 0).unwrap();
        assert!(still.iter().flatten().all(|x| *x == DVec3::ZERO));
    }
}

/// A mobility that says how well it is known.
struct Known(Matrix, f64);

impl Mobility<Open> for Known {
    fn bind(&mut self, frame: &Frame<'_, Open>) -> Result<(), MobilityError> {
        self.0.bind(frame)
    }

    fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        Mobility::<Open>::apply(&mut self.0, forces, velocities);
    }

    fn accuracy(&self) -> f64 {
        self.1
    }

    fn alone(&self, place: usize) -> f64 {
        Mobility::<Open>::alone(&self.0, place)
    }
}

// Eigenvalues below zero within the accuracy of a mobility are zero; those farther below are refused, as all are where the
// mobility is exact.
#[test]
fn extreme_eigenvalues_below_zero_within_the_accuracy() {
    let system = beads(10);
    for (least, accuracy, is_root) in [
        (-4e-6, 1e-3, true),
        (-9e-4, 1e-3, true),
        (-4e-6, 0.0, false),
        (-1e-2, 1e-3, false),
        (-0.5, 1e-3, false),
    ] {
        let mut values: Vec<f64> = (1..=24).map(|k| 0.1 * f64::from(k)).collect();
        values.extend([least, 0.5 * least, 0.0, 1e-9, 1e-5, 1e-3]);
        let (matrix, _) = Matrix::with_spectrum(&values, 5).unwrap();
        for value in &mut values {
            *value = value.max(0.0);
        }
        let (_, mut root) = Matrix::with_spectrum(&values, 5).unwrap();
        let mut mobility = Known(matrix, accuracy);
        for columns in [1, 4, 16] {
            let mut several = BlockLanczos::new(1e-4, columns as usize).unwrap();
            let found = block(&mut several, columns, &mut mobility, &system, 0);
            if is_root {
                for (step, found) in (0..).zip(&found.unwrap()) {
                    let error = relative_error(found, &exact(&mut root, &system, step));
                    assert!(error < 3.0 * f64::sqrt(-least), "{least:e}: {error:e}");
                }
                continue;
            }
            let Err(MobilityError::NotPositive { found, .. }) = found else {
                panic!("{least:e}, {columns} columns: {found:?}");
            };
            assert!(found < 0.0, "{found}");
        }
    }
}

// Mobilities in units that make them tiny or huge.
#[test]
fn extreme_units() {
    let system = beads(10);
    for unit in [1e-60, 1e-9, 1e12, 1e60] {
        let values: Vec<f64> = (1..=30).map(|k| unit * f64::from(k)).collect();
        let (mut mobility, mut root) = Matrix::with_spectrum(&values, 3).unwrap();
        let mut several = BlockLanczos::new(1e-8, 3).unwrap();
        let found = block(&mut several, 3, &mut mobility, &system, 0).unwrap();
        for (step, found) in (0..).zip(&found) {
            let exact = exact(&mut root, &system, step);
            assert!(relative_error(found, &exact) < 1e-8, "{unit:e}");
        }
    }
}

#[test]
fn extreme_what_cannot_be_had_is_an_error() {
    for tolerance in [0.0, -1.0, 1e-15, 1.0, f64::NAN, f64::INFINITY] {
        assert!(BlockLanczos::new(tolerance, 4).is_err(), "{tolerance}");
    }
    assert!(BlockLanczos::new(1e-3, 0).is_err());
    assert!(BlockLanczos::new(1e-3, 4).unwrap().within(3).is_err());
    let values: Vec<f64> = (0..60)
        .map(|k| 10.0_f64.powf(-0.1 * f64::from(k)))
        .collect();
    let (mut mobility, _) = Matrix::with_spectrum(&values, 3).unwrap();
    let mut several = BlockLanczos::new(1e-6, 4).unwrap().within(16).unwrap();
    let failed = block(&mut several, 4, &mut mobility, &beads(20), 0);
    let Err(MobilityError::NotConverged {
        iterations,
        reached,
        asked,
    }) = failed
    else {
        panic!("{failed:?}");
    };
    assert_eq!((iterations, asked, several.products()), (4, 1e-6, 16));
    assert!(reached > 1e-6 && reached < 1.0);
}

/// Counts products with a mobility.
struct Counted<'a, M>(M, &'a Cell<usize>);

impl<B: Boundary, M: Mobility<B>> Mobility<B> for Counted<'_, M> {
    fn bind(&mut self, frame: &Frame<'_, B>) -> Result<(), MobilityError> {
        self.0.bind(frame)
    }

    fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        self.1.set(self.1.get() + 1);
        self.0.apply(forces, velocities);
    }

    fn accuracy(&self) -> f64 {
        self.0.accuracy()
    }

    fn alone(&self, place: usize) -> f64 {
        self.0.alone(place)
    }
}

/// Twenty steps of two chains, the mobility kept for so many: where beads are, and products with the mobility.
fn travel<B: Boundary, M: Mobility<B>>(
    space: &B,
    mobility: M,
    kept: u64,
    root: impl for<'a> Root<B, Counted<'a, M>>,
) -> (Vec<DVec3>, usize) {
    let chains = Molecules::linear(0, 2, 20).unwrap();
    let positions = [walk(20, 1.6), walk(20, 1.6)].concat();
    let shifted = positions.iter().enumerate();
    let positions = shifted.map(|(k, r)| *r + (k / 20) as f64 * DVec3::new(3.0, 1.0, 0.5));
    let particles = Particles::new(positions.collect()).unwrap();
    let clock = Clock::new(0.02, 1.0, 4).unwrap();
    let mut system = System::new(space.clone(), particles, clock);
    let spring = Fene::new(1.0, 50.0_f64.sqrt()).unwrap();
    let mut springs = Bonded::new(spring, chains.bonds());
    let count = Cell::new(0);
    let stepper = SemiImplicit::new(Counted(mobility, &count), root);
    let mut stepper = stepper.keeping(kept).unwrap();
    for _ in 0..20 {
        stepper.step(&mut system, &mut springs, &mut ()).unwrap();
    }
    let rest = system.particles.positions().to_vec();
    (rest, count.get())
}

// Trajectories are those of Lanczos' method to the tolerance, kept or not; kept, with fewer products. Beads move by some
// 1e0 in twenty steps, of which an error of 1e-8 leaves 1e-6 at most.
#[test]
fn law_a_stepper_goes_where_lanczos_method_takes_it() {
    fn check<B: Boundary, M: Mobility<B>>(space: &B, mobility: impl Fn() -> M) {
        let lanczos = || Lanczos::new(1e-9).unwrap();
        let several = || BlockLanczos::new(1e-8, 8).unwrap();
        let near = |a: &[DVec3], b: &[DVec3]| {
            let apart = a.iter().zip(b).map(|(a, b)| (*a - *b).length());
            let worst = apart.fold(0.0, f64::max);
            assert!(worst < 1e-6, "{worst:e}");
        };
        let (expected, _) = travel(space, mobility(), 1, lanczos());
        near(&expected, &travel(space, mobility(), 1, several()).0);
        let (expected, singly) = travel(space, mobility(), 8, lanczos());
        let (found, together) = travel(space, mobility(), 8, several());
        near(&expected, &found);
        assert!(
            10 * together < 9 * singly,
            "{together} products, one by one {singly}"
        );
    }
    check(&Open, rpy);
    let space = PeriodicBox::cubic(15.0).unwrap();
    check(&space, || Ewald::new(4.0, 0.443_113, 1e-4).unwrap());
}

// More beads than a slab holds; two and three threads against one.
#[cfg(feature = "rayon")]
#[test]
fn law_the_same_bits_on_any_number_of_threads() {
    use zimm_brownian::FreeDraining;
    const BEADS: usize = 5000;
    let species = (0..BEADS).map(|k| (k % 7) as u8).collect();
    let particles = Particles::new(vec![DVec3::ZERO; BEADS]).unwrap();
    let particles = particles.with_species(species).unwrap();
    let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1).unwrap());
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let frictions = [1.0, 2.0, 3.0, 5.0, 8.0, 13.0, 21.0];
            let free = FreeDraining::new(1.0).unwrap();
            let mut free = free.with_species(&frictions).unwrap();
            let mut several = BlockLanczos::new(1e-4, 3).unwrap();
            block(&mut several, 3, &mut free, &system, 0).unwrap()
        })
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(3));
}

/// Not a test: products for a root and what comes of them.
#[test]
#[ignore = "prints a table; cargo test -p zimm-brownian --features hydrodynamics --test block -- --ignored --nocapture"]
fn table_of_products() {
    println!(
        "{:30} {:>6} {:>5} {:>9} {:>9} {:>9} | {:>9} {:>9} {:>9}",
        "spectrum",
        "asked",
        "cols",
        "products",
        "estimate",
        "error",
        "Lanczos",
        "estimate",
        "error"
    );
    for (name, values) in spectra(300) {
        let (mut mobility, mut root) = Matrix::with_spectrum(&values, 7).unwrap();
        let system = beads(mobility.beads());
        for tolerance in [1e-2, 1e-3, 1e-6, 1e-10] {
            let mut lanczos = Lanczos::new(tolerance).unwrap();
            let single = alone(&mut lanczos, &mut mobility, &system, 0);
            let error = single.map_or(f64::NAN, |x| {
                relative_error(&x, &exact(&mut root, &system, 0))
            });
            let by_lanczos = format!(
                "{:9} {:9.1e} {error:9.1e}",
                lanczos.iterations(),
                lanczos.error()
            );
            for columns in [1, 4, 8, 16] {
                let mut several = BlockLanczos::new(tolerance, columns as usize).unwrap();
                let found = block(&mut several, columns, &mut mobility, &system, 0);
                let worst = found.map_or(f64::NAN, |found| {
                    let errors = (0..)
                        .zip(&found)
                        .map(|(step, x)| relative_error(x, &exact(&mut root, &system, step)));
                    errors.fold(0.0, f64::max)
                });
                println!(
                    "{name:30} {tolerance:6.0e} {columns:5} {:9.1} {:9.1e} {worst:9.1e} | {by_lanczos}",
                    several.products() as f64 / columns as f64,
                    several.error(),
                );
            }
        }
    }
}
