//! Reverse Poiseuille flow as a rheometer: simple fluids against theory and other rheometers, the melts of Fedosov,
//! Karniadakis and Caswell (2010), whose athermal equation of state is in `equation_of_state.rs`.
#![allow(clippy::unwrap_used)]

mod scene;

use scene::{fluid, pairs, run};
use zimm::prelude::*;

/// What a run in a channel was made with, and what it found.
struct Shown {
    average: StressProfileAverage,
    channel: Channel,
}

/// Averages a channel driven along x that is at rest, after `unseen` steps, looking at every `every`th of `steps`.
fn flow<F: ForceField<PeriodicBox>>(
    system: &mut System<PeriodicBox>,
    field: &mut F,
    stepper: &mut GrootWarren,
    (force, layers): (f64, usize),
    (unseen, steps, every): (u32, u32, u32),
) -> Shown {
    let height = system.boundary.lattice().basis().y_axis.y;
    let profile = Profile::new(DVec3::Y, height, layers).unwrap();
    let heard = LayeredVirial::new(&profile);
    let mut observable = StressProfile::new(profile, 1).without(Item::Random);
    let mut average = StressProfileAverage::new(&observable);
    run(stepper, system, field, unseen);
    for _ in 0..steps / every {
        run(stepper, system, field, every - 1);
        let mut heard = heard.fresh();
        stepper.step(system, field, &mut heard).unwrap();
        average.push(observable.measure(&system.frame(), &heard).unwrap());
    }
    let channel = Channel::new(DVec3::X, force).unwrap();
    Shown { average, channel }
}

/// The fluid of Groot and Warren in a channel of height 10, 1080 particles, f = 0.05: rates up to 0.44.
fn groot_warren(time: f64, seed: u64) -> Shown {
    let dt = 0.04;
    let space = PeriodicBox::brick(DVec3::new(6.0, 10.0, 6.0)).unwrap();
    let mut system = fluid(space, 3.0, Clock::new(dt, 1.0, seed).unwrap());
    let drive = ReversePoiseuille::new(0.05, 0, 1).unwrap();
    let mut field = (pairs(Dpd::new(25.0, 4.5).unwrap()), drive);
    let mut stepper = GrootWarren::new(0.65).unwrap();
    let steps = (1500, (time / dt) as u32, 5);
    flow(&mut system, &mut field, &mut stepper, (0.05, 40), steps)
}

/// The same fluid in a cube of edge 6 between Lees and Edwards' images, at a rate of 0.4.
fn by_shear(time: f64, seed: u64) -> Mean {
    let (dt, rate) = (0.04, 0.4);
    let space = LeesEdwards::new(DVec3::splat(6.0), Steady::new(rate).unwrap()).unwrap();
    let mut system = fluid(space, 3.0, Clock::new(dt, 1.0, seed).unwrap());
    let mut field = pairs(Dpd::new(25.0, 4.5).unwrap());
    let (mut stepper, mut viscometer) = (
        GrootWarren::new(0.65).unwrap(),
        Viscometer::new(rate).unwrap(),
    );
    run(&mut stepper, &mut system, &mut field, 500);
    for _ in 0..(time / dt) as u32 / 5 {
        run(&mut stepper, &mut system, &mut field, 4);
        let mut virial = Virial::default();
        stepper.step(&mut system, &mut field, &mut virial).unwrap();
        let stress = Stress.measure(&system.frame(), &virial);
        viscometer.push(stress.without(Item::Random).total());
    }
    viscometer.estimate().unwrap().viscosity
}

/// The same cube at rest.
fn by_rest(time: f64, seed: u64) -> Mean {
    let (dt, every) = (0.04, 5);
    let clock = Clock::new(dt, 1.0, seed).unwrap();
    let mut system = fluid(PeriodicBox::cubic(6.0).unwrap(), 3.0, clock);
    let mut field = pairs(Dpd::new(25.0, 4.5).unwrap());
    let mut stepper = GrootWarren::new(0.65).unwrap();
    let mut green_kubo = GreenKubo::new(f64::from(every) * dt, 216.0, 1.0).unwrap();
    run(&mut stepper, &mut system, &mut field, 500);
    for _ in 0..(time / dt) as u32 / every {
        let mut mean = DMat3::ZERO;
        for _ in 0..every {
            let mut virial = Virial::default();
            stepper.step(&mut system, &mut field, &mut virial).unwrap();
            let stress = Stress.measure(&system.frame(), &virial);
            mean += stress.total() * f64::from(every).recip();
        }
        green_kubo.push(mean);
    }
    green_kubo.viscosity(4.0).unwrap()
}

/// A simple fluid in a channel: as dense everywhere, a parabola, the stress that the force imposes, layer by layer, no
/// normal stress differences, and the viscosity that it has in shear and at rest.
///
/// Seed 1, 800 time units of 1080 particles. Standard errors of a layer: 0.005 in the density of 3, 0.007 in velocities
/// up to 0.56, 0.005 in shear stresses up to 0.36, 0.04 in the normal stress differences; of the viscosity of 0.85 they
/// are 0.01 in the channel, 0.011 in shear (seed 2, 800 time units of 648 particles) and 0.04 at rest (seed 3, 2000).
/// Bounds are 4 of each: 1 % of the density, 5 % of velocity and stress, 6 % of the viscosity in flow and 19 % at rest.
/// A sign lost in folding takes all of the velocity or the stress, a pair counted in one layer instead of shared 20 %.
#[test]
fn limit_newtonian_fluid_in_a_channel_in_shear_and_at_rest() {
    let Shown { average, channel } = groot_warren(800.0, 1);
    let viscosity = channel.viscosity(&average).unwrap();
    for layer in channel.layers(&average).unwrap() {
        let y = layer.distance;
        let off = |found: Mean, expected: f64, bound: f64| {
            let off = found.value - expected;
            assert!(off.abs() < bound, "y = {y}: {found} for {expected}");
        };
        off(layer.density, 3.0, 0.03);
        off(layer.shear, layer.imposed.value, 0.02);
        off(layer.imposed, 0.15 * y, 0.002);
        off(
            layer.velocity,
            0.15 / (2.0 * viscosity.value) * (6.25 - y * y),
            0.03,
        );
        off(layer.first_difference, 0.0, 0.15);
        off(layer.second_difference, 0.0, 0.15);
    }
    let p = channel.velocity_exponent(&average).unwrap();
    let curvature = channel.zero_shear(&average, 1.0).unwrap().viscosity;
    let (in_shear, at_rest) = (by_shear(800.0, 2), by_rest(2000.0, 3));
    println!("viscosity: channel {viscosity}, its curvature {curvature}, exponent {p}");
    println!("shear {in_shear}, rest {at_rest}");
    assert!((p.value - 1.0).abs() < 0.12, "{p}");
    for (one, other, bound) in [
        (viscosity, curvature, 0.08),
        (viscosity, in_shear, 0.06),
        (viscosity, at_rest, 0.17),
        (in_shear, at_rest, 0.17),
    ] {
        assert!(
            (one.value - other.value).abs() < bound,
            "{one} against {other}"
        );
    }
    assert!((viscosity.value - 0.852).abs() < 0.042, "{viscosity}");
}

/// Twenty repeats of each of the three rheometers, seeds 11 to 30: 68 % of estimates come within one error of their mean,
/// 95 % within two. Binomial errors are 10 and 5 %: at least 7 and 15 of 20, and a mean square deviation between 0.35 and
/// 2.2 errors squared, 4 standard errors of it. Errors too small by a factor of 1.5 are caught. The means are to be that of
/// longer runs in shear at this rate, 0.842 +- 0.002, within 4 of their errors (0.0025 in shear and in the channel, 0.015 at
/// rest) and, in the channel, 2 % for a flow that changes over few free paths: found are 0.8305 at this height and, at
/// twice the height, 0.840 +- 0.003.
#[test]
#[ignore = "four minutes; cargo test -p zimm-tests --test reverse_poiseuille -- --ignored --nocapture cover"]
fn law_errors_of_three_rheometers_cover_what_they_say() {
    let channel = |seed| {
        let Shown { average, channel } = groot_warren(320.0, seed);
        channel.viscosity(&average).unwrap()
    };
    let shear = |seed| by_shear(320.0, seed);
    let rest = |seed| by_rest(640.0, seed);
    let rheometers: [(&str, &dyn Fn(u64) -> Mean); 3] =
        [("shear", &shear), ("rest", &rest), ("channel", &channel)];
    for (name, rheometer) in rheometers {
        let runs: Vec<Mean> = (11..=30).map(rheometer).collect();
        let mean = runs.iter().map(|run| run.value).sum::<f64>() / 20.0;
        let deviation = |run: &Mean| (run.value - mean).abs() / run.at_least();
        let within = |errors: f64| runs.iter().filter(|run| deviation(run) < errors).count();
        let square = runs.iter().map(|run| deviation(run).powi(2)).sum::<f64>() / 19.0;
        let told = runs
            .iter()
            .filter(|run| run.standard_error().is_some())
            .count();
        let typical = runs.iter().map(Mean::at_least).sum::<f64>() / 20.0;
        let (one, two) = (within(1.0), within(2.0));
        println!("{name}: mean {mean:.4}, error {typical:.4}, {told} told");
        println!("{name}: {one} and {two} of 20 within one and two, mean square {square:.2}");
        assert!(one >= 7 && two >= 15 && (0.35..2.2).contains(&square));
        let bound = match name {
            "shear" => 0.012,
            "rest" => 0.06,
            _ => 0.027,
        };
        assert!((mean - 0.842).abs() < bound, "{mean}");
    }
}

/// Fedosov's fluid (his Table I) in any space, relaxed: density 3, r_c = 2, a = 25, friction 4.5 of weight
/// (1 - r / r_c)^1/2, chains of so many beads with FENE springs of stiffness 50 and limit 1, dt = 0.005.
type Melt<B> = (System<B>, MeltForces);
type MeltForces = (Pairwise<Dpd<f64, SquareRoot>, VerletList>, Bonded<Fene>);

fn melt<B: Periodic>(space: B, beads: u32, time: f64, seed: u64) -> Melt<B> {
    let count = (3.0 * space.lattice().volume() / f64::from(beads)).round() as u32;
    let chains = Molecules::linear(0, count, beads).unwrap();
    let mut rng = start::stream(seed);
    let positions = start::chains(space.lattice(), &chains, |_| 0.3, &mut rng);
    let particles = Particles::new(positions).unwrap();
    let velocities = start::velocities(&particles, 1.0, &mut rng).unwrap();
    let particles = particles.with_velocities(velocities).unwrap();
    // Overlaps of the random start want short steps.
    let mut system = System::new(space, particles, Clock::new(0.001, 1.0, seed).unwrap());
    let law = Dpd::new(25.0, 4.5).unwrap().with_cutoff(2.0).unwrap();
    let springs = Bonded::new(Fene::new(50.0, 1.0).unwrap(), chains.bonds());
    let pairs = Pairwise::new(law.with_weight(SquareRoot), VerletList::new(0.25).unwrap());
    let mut field = (pairs, springs);
    let mut stepper = GrootWarren::new(0.5).unwrap();
    run(&mut stepper, &mut system, &mut field, 1000);
    system.clock.set_dt(0.005).unwrap();
    run(&mut stepper, &mut system, &mut field, (time / 0.005) as u32);
    (system, field)
}

/// The melt in shear between Lees and Edwards' images.
fn sheared_melt(beads: u32, edge: f64, rate: f64, (unseen, time): (f64, f64)) -> ShearFunctions {
    let space = LeesEdwards::new(DVec3::splat(edge), Steady::new(rate).unwrap()).unwrap();
    let (mut system, mut field) = melt(space, beads, unseen, 1);
    let mut stepper = GrootWarren::new(0.5).unwrap();
    let (mut viscometer, mut pressure) = (Viscometer::new(rate).unwrap(), BlockAverage::new());
    for _ in 0..(time / 0.05) as u32 {
        run(&mut stepper, &mut system, &mut field, 9);
        let mut virial = Virial::default();
        stepper.step(&mut system, &mut field, &mut virial).unwrap();
        let stress = Stress
            .measure(&system.frame(), &virial)
            .without(Item::Random);
        viscometer.push(stress.total());
        pressure.push(stress.pressure());
    }
    let functions = viscometer.estimate().unwrap();
    let ShearFunctions {
        viscosity,
        psi1,
        psi2,
    } = &functions;
    let pressure = pressure.estimate().unwrap();
    println!("N {beads} shear {rate}: eta {viscosity}, Psi_1 {psi1}, Psi_2 {psi2}, P {pressure}");
    functions
}

/// The melt in a channel: edge across the flow, force, time.
fn driven_melt(beads: u32, size: DVec3, force: f64, (unseen, time): (f64, f64)) -> Shown {
    let space = PeriodicBox::brick(size).unwrap();
    let (mut system, (pairs, springs)) = melt(space, beads, 20.0, 1);
    let drive = ReversePoiseuille::new(force, 0, 1).unwrap();
    let mut field = (pairs, springs, drive);
    let mut stepper = GrootWarren::new(0.5).unwrap();
    let steps = ((unseen / 0.005) as u32, (time / 0.005) as u32, 10);
    let layers = 4 * (size.y / 2.0) as usize;
    flow(
        &mut system,
        &mut field,
        &mut stepper,
        (force, layers),
        steps,
    )
}

fn show(beads: u32, force: f64, Shown { average, channel }: &Shown) {
    for l in channel.layers(average).unwrap() {
        let ChannelLayer {
            distance,
            density,
            velocity,
            temperature,
            imposed,
            shear,
            rate,
            ..
        } = &l;
        print!(
            "N {beads} f {force} y {distance:.2} n {density:#} V {velocity:#} T {temperature:#}"
        );
        print!(" tau {imposed:#} computed {shear:#} rate {rate:#}");
        if let Some(ShearFunctions {
            viscosity,
            psi1,
            psi2,
        }) = l.functions
        {
            print!(" eta {viscosity:#} Psi_1 {psi1:#} Psi_2 {psi2:#}");
        }
        println!();
    }
    for share in [0.5, 0.7, 1.0] {
        match channel.zero_shear(average, share) {
            Ok(ZeroShear {
                viscosity,
                psi1,
                psi2,
                relaxation_time,
                ratio,
            }) => println!(
                "N {beads} f {force} share {share}: eta_0 {viscosity}, Psi_1 {psi1}, Psi_2 {psi2}, \
                 lambda_0 {relaxation_time}, ratio {ratio:?}"
            ),
            Err(problem) => println!("N {beads} f {force} share {share}: {problem}"),
        }
    }
    let (p, one) = (
        channel.velocity_exponent(average).unwrap(),
        channel.viscosity(average),
    );
    println!("N {beads} f {force}: p of the velocity {p}, one viscosity {one:?}");
}

/// The fluid of free beads. Published by nobody but found by an independent program: 42.7 +- 1.0 at a rate of 0.1 and
/// 41.2 +- 0.4 at 0.3, pressure 377.0 +- 0.3; kinetic theory of the friction alone says 40.1.
///
/// Seed 1, 80 time units of 1500 beads in the channel, with rates up to 0.2: a standard error of 0.26 (found: 41.5); 60
/// of 648 in shear: 0.06 (found: 41.8). Bounds: 5 % of the numbers above, which is 8 errors and more, and 1.3 (3 %)
/// between both, 4 errors and the little that the fluid may thin.
#[test]
#[ignore = "a minute; cargo test -p zimm-tests --test reverse_poiseuille -- --ignored --nocapture free"]
fn reference_free_beads_of_fedosov() {
    let shown = driven_melt(1, DVec3::new(5.0, 20.0, 5.0), 0.6, (10.0, 80.0));
    show(1, 0.6, &shown);
    let in_channel = shown.channel.viscosity(&shown.average).unwrap();
    let in_shear = sheared_melt(1, 6.0, 0.3, (10.0, 60.0)).viscosity;
    assert!((in_channel.value / 42.0 - 1.0).abs() < 0.05, "{in_channel}");
    assert!((in_shear.value / 41.2 - 1.0).abs() < 0.05, "{in_shear}");
    assert!((in_channel.value - in_shear.value).abs() < 1.3);
}

/// The melt of dumbbells. An independent program found 46.3 +- 0.5 at a rate of 0.3 and 51.1 +- 1.0 at 0.1; published is
/// a zero-shear viscosity of 62.7.
///
/// Seed 1, 150 time units of 648 beads in shear, standard errors of 0.1 and 0.4 (found: 46.1 and 52.9); 200 of 1500 in
/// the channel, whose mean at rates around 0.1 has one of 0.6 (found: 52.7). Bounds: 5 % at 0.3, 7 % at 0.1, where the
/// number to compare with is known to 2 %, and 7 % between shear and channel; free beads would be 18 % below.
#[test]
#[ignore = "two minutes; cargo test -p zimm-tests --test reverse_poiseuille -- --ignored --nocapture dumbbells"]
fn reference_melt_of_dumbbells_of_fedosov() {
    let [fast, slow] = [0.3, 0.1].map(|rate| sheared_melt(2, 6.0, rate, (20.0, 150.0)).viscosity);
    assert!((fast.value / 46.3 - 1.0).abs() < 0.05, "{fast}");
    assert!((slow.value / 51.1 - 1.0).abs() < 0.07, "{slow}");
    let shown = driven_melt(2, DVec3::new(5.0, 20.0, 5.0), 0.6, (20.0, 200.0));
    show(2, 0.6, &shown);
    let rheogram = Rheogram::new(vec![(shown.channel, shown.average)]).unwrap();
    let near = rheogram.of(|points| {
        let near = points
            .iter()
            .filter(|point| (0.07..0.14).contains(&point.rate.value));
        let viscosities: Vec<f64> = near.map(|point| point.functions.viscosity.value).collect();
        Ok(vec![
            viscosities.iter().sum::<f64>() / viscosities.len() as f64,
        ])
    });
    let in_channel = near.unwrap()[0];
    println!("N 2 channel, rates 0.07 to 0.14: eta {in_channel}");
    assert!(
        (in_channel.value / slow.value - 1.0).abs() < 0.07,
        "{in_channel} against {slow}"
    );
}
