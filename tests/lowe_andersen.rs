//! Baths that act on pairs: the Lowe-Andersen fluid of Clarke (PhD thesis, MIT 2008; density 4, a = 18.75), and the fluid
//! of Groot and Warren by splitting.
#![allow(clippy::unwrap_used)]

mod scene;

use rayon::ThreadPoolBuilder;
use scene::{fluid, momentum, pairs, run, scene};
use zimm::prelude::*;

type Repulsion = Pairwise<DpdConservative, VerletList>;

fn repulsion(a: f64) -> Repulsion {
    pairs(DpdConservative::new(a, 1.0).unwrap())
}

fn list() -> VerletList {
    VerletList::new(0.35).unwrap()
}

fn lowe_andersen(rate: f64) -> LoweAndersen<VerletList> {
    LoweAndersen::new(rate, 1.0, list()).unwrap()
}

fn friction() -> DpdDissipative {
    DpdDissipative::new(4.5, Quadratic, 1.0).unwrap()
}

/// A fluid and for how long to look at it.
struct Run {
    density: f64,
    repulsion: f64,
    dt: f64,
    time: f64,
    seed: u64,
}

/// Clarke's fluid.
const CLARKE: Run = Run {
    density: 4.0,
    repulsion: 18.75,
    dt: 0.01,
    time: 60.0,
    seed: 3,
};

/// What it shows; stresses are averaged over all steps.
struct Shown {
    temperature: Mean,
    configurational: Mean,
    pressure: Mean,
    conservative: Mean,
    energy_per_particle: Mean,
    diffusion: Mean,
    /// Viscosity, and the share of the bath in it.
    viscosity: Option<[Mean; 2]>,
}

impl Run {
    /// Runs 20 time units unseen and looks every 0.2 from there, if that is a number of steps.
    fn go<B: Periodic>(
        &self,
        space: B,
        rate: f64,
        mut stepper: impl Stepper<B, Repulsion>,
    ) -> Shown {
        let clock = Clock::new(self.dt, 1.0, self.seed).unwrap();
        let mut system = fluid(space, self.density, clock);
        let mut field = repulsion(self.repulsion);
        // The random start is hot.
        system.clock.set_dt(0.01).unwrap();
        run(&mut stepper, &mut system, &mut field, 1000);
        system.clock.set_dt(self.dt).unwrap();
        run(
            &mut stepper,
            &mut system,
            &mut field,
            (10.0 / self.dt) as u32,
        );

        let n = system.particles.len() as f64;
        let a = self.repulsion;
        let mut positions =
            ConfigurationalTemperature::new(1.0, list(), |r| [-a * (1.0 - r), a]).unwrap();
        let interval = (0.2 / self.dt).round() as u32;
        let lag = 4.0 * f64::from(interval) * self.dt;
        let mut diffusion = MeanSquareDisplacement::new(lag, 5..=15).unwrap();
        let mut averages: [BlockAverage; 4] = Default::default();
        let mut configurational = RatioAverage::new();
        let mut viscometers = [Viscometer::new(rate), Viscometer::new(rate)];
        for sample in 0..(self.time / 0.2) as u32 {
            let (mut total, mut conservative, mut bath) = (DMat3::ZERO, DMat3::ZERO, DMat3::ZERO);
            let mut heard = (Virial::default(), Energy::default());
            for _ in 0..interval {
                heard = Default::default();
                stepper.step(&mut system, &mut field, &mut heard).unwrap();
                let stress = Stress.measure(&system.frame(), &heard);
                let share = f64::from(interval).recip();
                total += share * stress.total();
                conservative += share * stress.item(Item::Conservative);
                for item in [Item::Dissipative, Item::Random, Item::Impulse] {
                    bath += share * stress.item(item);
                }
            }
            let frame = system.frame();
            let temperature = KineticTemperature::default().measure(&frame, &heard);
            let mean = |stress: DMat3| -(stress.x_axis.x + stress.y_axis.y + stress.z_axis.z) / 3.0;
            let numbers = [
                temperature.unwrap().mean(),
                mean(total),
                mean(conservative),
                heard.1.0 / n,
            ];
            for (average, number) in averages.iter_mut().zip(numbers) {
                average.push(number);
            }
            configurational.push(positions.measure(&frame, &heard).unwrap());
            for (viscometer, stress) in viscometers.iter_mut().zip([total, bath]) {
                if let Ok(viscometer) = viscometer {
                    viscometer.push(stress);
                }
            }
            if sample % 4 == 0 {
                diffusion.push(Unwrapped.measure(&frame, &heard).unwrap());
            }
        }
        let [temperature, pressure, conservative, energy_per_particle] =
            averages.map(|average| average.estimate().unwrap());
        let viscosity = match viscometers {
            [Ok(total), Ok(bath)] => Some([total, bath].map(|v| v.estimate().unwrap().viscosity)),
            _ => None,
        };
        let shown = Shown {
            temperature,
            configurational: configurational.estimate().unwrap(),
            pressure,
            conservative,
            energy_per_particle,
            diffusion: diffusion.estimate().unwrap().coefficient,
            viscosity,
        };
        println!(
            "dt {} rate {rate}: T {temperature}, of positions {}, P {pressure}, conservative {conservative}, U/N \
             {energy_per_particle}, D {}",
            self.dt, shown.configurational, shown.diffusion
        );
        if let Some([viscosity, bath]) = shown.viscosity {
            println!("viscosity {viscosity}, of the bath {bath}");
        }
        shown
    }
}

fn cube() -> PeriodicBox {
    PeriodicBox::cubic(6.0).unwrap()
}

fn sheared(rate: f64) -> LeesEdwards<Steady> {
    LeesEdwards::new(DVec3::splat(6.0), Steady::new(rate).unwrap()).unwrap()
}

/// Published in the cell of 864 particles: T = 0.999 +- 0.002, P = 32.63 +- 0.05, of which 28.64 +- 0.02 conservative,
/// whatever the rate of redrawing; D = 0.046 and 0.0108 at rates of 10 and 40, to be met to 12 %.
///
/// Seed 3, 60 time units. Standard errors: T 0.0018, P 0.05 and 0.07, conservative 0.007 and 0.010; D 2 %, and the published
/// ones 5 to 10 %. Bounds are 4 of the larger ones: T 0.8 %, P 0.9 %, conservative 0.15 %.
#[test]
fn reference_fluid_at_rest() {
    for (gamma, diffusion) in [(10.0, 0.0463), (40.0, 0.0108)] {
        let shown = CLARKE.go(cube(), 0.0, lowe_andersen(gamma));
        assert!((shown.temperature.value - 1.0).abs() < 0.008);
        assert!((shown.conservative.value - 28.64).abs() < 0.044);
        assert!((shown.pressure.value - 32.63).abs() < 0.3);
        assert!((shown.diffusion.value / diffusion - 1.0).abs() < 0.12);
    }
}

/// Published at a shear rate of 0.3: 29.1 +- 0.3 at a rate of redrawing of 40. Theory, which leaves out the forces and what
/// pairs do to each other within a step, has 26.8.
///
/// Seed 3, 60 time units: standard error 0.27 (0.9 %), bound of 10 % for both; T 0.0013. A bath that sees peculiar
/// velocities, or images without the velocity of the flow, has a viscosity of 0.4.
#[test]
fn reference_viscosity() {
    let shown = CLARKE.go(sheared(0.3), 0.3, lowe_andersen(40.0));
    let [viscosity, bath] = shown.viscosity.unwrap().map(|mean| mean.value);
    assert!((viscosity / 29.1 - 1.0).abs() < 0.1, "{viscosity}");
    assert!(bath / viscosity > 0.97);
    assert!((shown.temperature.value - 1.0).abs() < 0.008);
}

/// Published at a shear rate of 0.1: 6.6 +- 0.4, 28.6 +- 1.2 and 63.7 +- 1.5 at rates of redrawing of 10, 40 and 80, and the
/// same at 0.3 to 5 %: no shear thinning.
///
/// Seed 3, 1200 and 400 time units: standard errors 0.08, 0.15, 0.23 at 0.1 and less at 0.3, T 0.0004 and 0.0007. Bounds are
/// those of the published numbers, twice their standard errors, for the highest rate 5 %: with 0.8 of all pairs redrawn
/// in a step the order of turns shows, which is at random here and was that of a list there.
#[test]
#[ignore = "five minutes; cargo test -p zimm-tests --test lowe_andersen -- --ignored --nocapture"]
fn reference_viscosities_and_no_shear_thinning() {
    for (gamma, published, bound) in [(10.0, 6.6, 0.4), (40.0, 28.6, 1.2), (80.0, 63.7, 3.2)] {
        let viscosity = |rate: f64, time| {
            let run = Run { time, ..CLARKE };
            let shown = run.go(sheared(rate), rate, lowe_andersen(gamma));
            assert!((shown.temperature.value - 1.0).abs() < 0.005);
            shown.viscosity.unwrap()[0].value
        };
        let (slow, fast) = (viscosity(0.1, 1200.0), viscosity(0.3, 400.0));
        println!("rate of redrawing {gamma}: {slow} and {fast}, published {published}");
        assert!((slow - published).abs() < bound);
        assert!((fast / slow - 1.0).abs() < 0.05);
        let theory = std::f64::consts::PI * 16.0 * gamma / 75.0;
        assert!((slow / theory - 1.0).abs() < 0.2);
    }
}

/// Planar extension in a cell that returns: eta_1 = (sigma_xx - sigma_yy) / rate = 4 eta, through more than ten changes of
/// basis, at the temperature of the bath. Theory and shear: eta = 6.7 at a rate of redrawing of 10.
///
/// Seed 3, 400 time units at a rate of 0.05 (20 strains): the standard error is printed and 5 % of 4 eta at most; bound 10 %.
#[test]
#[ignore = "two minutes; cargo test -p zimm-tests --test lowe_andersen -- --ignored --nocapture"]
fn reference_extensional_viscosity() {
    let (rate, dt) = (0.05, 0.01);
    let space = KraynikReinelt::new(8.0, 5.0, Steady::new(rate).unwrap()).unwrap();
    let mut system = fluid(space, 4.0, Clock::new(dt, 1.0, 3).unwrap());
    let (mut field, mut stepper) = (repulsion(18.75), lowe_andersen(10.0));
    run(&mut stepper, &mut system, &mut field, 1000);
    let (mut temperature, mut viscosity) = (BlockAverage::new(), BlockAverage::new());
    for _ in 0..40_000 {
        let mut virial = Virial::default();
        stepper.step(&mut system, &mut field, &mut virial).unwrap();
        let frame = system.frame();
        let stress = Stress.measure(&frame, &virial).total();
        viscosity.push((stress.x_axis.x - stress.y_axis.y) / rate);
        let kinetic = KineticTemperature::default().measure(&frame, &virial);
        temperature.push(kinetic.unwrap().mean());
    }
    let (viscosity, temperature) = (
        viscosity.estimate().unwrap(),
        temperature.estimate().unwrap(),
    );
    println!("eta_1 {viscosity}, T {temperature}");
    assert!((viscosity.value / (4.0 * 6.65) - 1.0).abs() < 0.1);
    assert!((temperature.value - 1.0).abs() < 0.005);
    assert!(momentum(&system).length() < 1e-9);
}

/// Every pair redrawn in every step, in cells that remap many times: the temperature holds, momentum is zero.
#[test]
fn extreme_all_pairs_in_cells_that_return() {
    fn check<B: Periodic>(space: B) {
        let dt = 0.02;
        let mut system = fluid(space, 4.0, Clock::new(dt, 1.0, 5).unwrap());
        let (mut field, mut stepper) = (repulsion(18.75), lowe_andersen(1.0 / dt));
        run(&mut stepper, &mut system, &mut field, 100);
        let (mut temperature, mut remaps) = (0.0, 0);
        for _ in 0..500 {
            let before = system.boundary.cell().unwrap();
            stepper.step(&mut system, &mut field, &mut ()).unwrap();
            let change = system.boundary.cell().unwrap() - before;
            remaps += u32::from(change.to_cols_array().iter().any(|x| x.abs() > 1.0));
            let kinetic = KineticTemperature::default().measure(&system.frame(), &());
            temperature += kinetic.unwrap().mean() / 500.0;
        }
        println!("T {temperature}, {remaps} changes of basis");
        assert!(remaps >= 2);
        assert!((temperature - 1.0).abs() < 0.05, "{temperature}");
        assert!(momentum(&system).length() < 1e-9);
    }
    let rate = Steady::new(0.2).unwrap();
    check(KraynikReinelt::new(6.0, 4.0, rate).unwrap());
    let rates = MixedRates::from_strain_rate(0.15, 0.5);
    check(PlanarMixed::from_rates(7.0, 4.0, rates).unwrap());
}

/// Pressure, energy and diffusion of the fluid of Groot and Warren: P = 23.653 and U / N = 4.544 by Monte Carlo,
/// D = 0.286 +- 0.01 published in this cell.
///
/// Seed 3, 648 particles, 200 time units at dt = 0.04. Standard errors: T 0.0025, P 0.012, conservative 0.005, U/N
/// 0.0025, D 0.004. The time step adds to those of T 0.006 and -0.019, to U/N 0.022 and 0.004, to D 0.003 in Shardlow's
/// scheme and in BAOAB. Bounds are 4 errors and that: 1.6 and 3 % in T, 0.1 % in P, 0.7 and 0.3 % in U/N, 6 % in D.
#[test]
fn reference_dpd_by_splitting() {
    let run = Run {
        density: 3.0,
        repulsion: 25.0,
        dt: 0.04,
        time: 200.0,
        seed: 3,
    };
    let shardlow = run.go(cube(), 0.0, Shardlow::new(friction(), list()));
    let baoab = run.go(cube(), 0.0, DpdBaoab::new(friction(), list()));
    for (shown, temperature, energy) in [(shardlow, 0.016, 0.032), (baoab, 0.03, 0.014)] {
        assert!((shown.temperature.value - 1.0).abs() < temperature);
        assert!((shown.energy_per_particle.value - 4.544).abs() < energy);
        assert!((3.0 + shown.conservative.value - 23.653).abs() < 0.03);
        assert!((shown.diffusion.value - 0.286).abs() < 0.017);
    }
}

/// Positions at a time step of 0.08 have a temperature too high by 5 % with BAOAB and by 25 % with Shardlow's scheme.
///
/// Seed 3, 648 particles, 100 time units: standard errors 0.004 and 0.005.
#[test]
fn reference_positions_at_a_long_time_step() {
    let run = Run {
        density: 3.0,
        repulsion: 25.0,
        dt: 0.08,
        time: 100.0,
        seed: 3,
    };
    let shardlow = run.go(cube(), 0.0, Shardlow::new(friction(), list()));
    let baoab = run.go(cube(), 0.0, DpdBaoab::new(friction(), list()));
    assert!((shardlow.configurational.value - 1.25).abs() < 0.03);
    assert!((baoab.configurational.value - 1.05).abs() < 0.02);
}

/// Published viscosity of the fluid of Groot and Warren: 0.82 +- 0.04; velocity Verlet has 0.852(4) in long runs.
///
/// Seed 3, 648 particles, 3000 time units at a rate of 0.3: standard errors 0.007, bound 0.04 (5 %) to that number.
#[test]
#[ignore = "two minutes; cargo test -p zimm-tests --test lowe_andersen -- --ignored --nocapture"]
fn reference_viscosity_by_splitting() {
    let run = Run {
        density: 3.0,
        repulsion: 25.0,
        dt: 0.04,
        time: 3000.0,
        seed: 3,
    };
    let shardlow = run.go(sheared(0.3), 0.3, Shardlow::new(friction(), list()));
    let baoab = run.go(sheared(0.3), 0.3, DpdBaoab::new(friction(), list()));
    for shown in [shardlow, baoab] {
        let viscosity = shown.viscosity.unwrap()[0].value;
        assert!((viscosity - 0.852).abs() < 0.04, "{viscosity}");
    }
}

type Shear = LeesEdwards<Steady>;
type Solution = (Repulsion, Bonded<Fene>);

fn brick() -> Shear {
    LeesEdwards::new(DVec3::new(16.0, 15.0, 14.0), Steady::new(1.0).unwrap()).unwrap()
}

/// 10 080 particles, 1000 of them in dumbbells, in shear: several blocks of pairs and several chunks of particles.
fn solution() -> (System<Shear>, Solution) {
    let (system, molecules) = scene(brick(), 3.0, (500, 0.5), Clock::new(0.02, 1.0, 8).unwrap());
    let springs = Bonded::new(Fene::new(2.0, 5.0).unwrap(), molecules.bonds());
    (system, (repulsion(25.0), springs))
}

/// Takes steps and answers every bit of the state and of the virials on the way.
fn bits(
    mut stepper: impl Stepper<Shear, Solution>,
    system: &mut System<Shear>,
    field: &mut Solution,
    steps: u32,
) -> Vec<u64> {
    let mut numbers = Vec::new();
    for _ in 0..steps {
        let mut heard = Virial::default();
        stepper.step(system, field, &mut heard).unwrap();
        for item in Item::ALL {
            numbers.extend(heard.item(item).to_cols_array());
        }
    }
    let particles = &system.particles;
    for column in [
        particles.positions(),
        particles.velocities(),
        particles.forces(),
    ] {
        numbers.extend(column.iter().flat_map(|v| v.to_array()));
    }
    numbers.into_iter().map(f64::to_bits).collect()
}

/// On 1, 2 and 5 threads; and a run that writes a checkpoint and goes on agrees with one that starts from it, with a
/// stepper that knows nothing of the past, on another number of threads.
fn bits_depend_on_the_system_alone<S: Stepper<Shear, Solution>>(make: impl Fn() -> S + Sync) {
    let on = |threads: usize, work: &(dyn Fn() -> Vec<u64> + Sync)| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(work)
    };
    let from_the_start = || {
        let (mut system, mut field) = solution();
        bits(make(), &mut system, &mut field, 40)
    };
    let one = on(1, &from_the_start);
    assert!(one == on(2, &from_the_start));
    assert!(one == on(5, &from_the_start));

    let (mut system, mut field) = solution();
    let mut stepper = make();
    // Some steps, so that lists are neither new nor of the same age.
    run(&mut stepper, &mut system, &mut field, 37);
    let mut file = Vec::new();
    save(&system, &mut field, &mut file).unwrap();
    let gone_on = bits(stepper, &mut system, &mut field, 23);
    let restarted = on(3, &|| {
        let (_, mut fresh) = solution();
        let mut again = load(brick(), &mut file.as_slice()).unwrap();
        bits(make(), &mut again, &mut fresh, 23)
    });
    assert!(gone_on == restarted);
}

#[test]
fn law_bits_of_lowe_andersen_depend_on_the_system_alone() {
    bits_depend_on_the_system_alone(|| lowe_andersen(20.0));
}

#[test]
fn law_bits_of_shardlow_depend_on_the_system_alone() {
    bits_depend_on_the_system_alone(|| Shardlow::new(friction(), list()));
}

#[test]
fn law_bits_of_dpd_baoab_depend_on_the_system_alone() {
    bits_depend_on_the_system_alone(|| DpdBaoab::new(friction(), list()));
}
