//! The Groot-Warren fluid between Lees and Edwards' images: as homogeneous as without them, and as viscous as it is.
#![allow(clippy::unwrap_used)]

mod scene;

use scene::{fluid, pairs, run};
use zimm::prelude::*;

type Shear = LeesEdwards<Steady>;

fn sheared(edge: f64, rate: f64) -> Shear {
    LeesEdwards::new(DVec3::splat(edge), Steady::new(rate).unwrap()).unwrap()
}

fn dpd() -> Pairwise<Dpd, VerletList> {
    pairs(Dpd::new(25.0, 4.5).unwrap())
}

/// Where the boundary is does not matter: all forces, friction and noise among them, are the same after every particle
/// has been moved by the same vector, peculiar velocities as they are. Friction that misses the velocity of an image
/// is wrong by gamma rate L_y = 27 for pairs across the boundary.
#[test]
fn law_forces_do_not_know_where_the_boundary_is() {
    let mut system = fluid(sheared(6.0, 1.0), 3.0, Clock::new(0.01, 1.0, 4).unwrap());
    let (mut field, mut stepper) = (dpd(), GrootWarren::new(0.65).unwrap());
    run(&mut stepper, &mut system, &mut field, 237);
    let forces = |system: &System<Shear>| {
        let mut forces = vec![DVec3::ZERO; system.particles.len()];
        dpd()
            .accumulate(&system.frame(), &mut forces, &mut ())
            .unwrap();
        forces
    };
    let here = forces(&system);
    for shift in [DVec3::new(0.7, 2.9, -1.1), DVec3::new(-3.0, 0.4, 2.2)] {
        let mut moved = system.clone();
        for r in moved.particles.positions_mut() {
            *r = system.boundary.wrap(*r + shift).0;
        }
        for (a, b) in forces(&moved).iter().zip(&here) {
            assert!((*a - *b).length() < 1e-9, "{a} against {b}");
        }
    }
}

/// Stress and temperature of a run, looked at every 0.2 time units after 20 unseen ones.
struct Shown {
    temperature: Mean,
    conservative_pressure: Mean,
    functions: Option<ShearFunctions>,
}

fn show<B: Periodic>(space: B, rate: f64, time: f64, seed: u64) -> Shown {
    let dt = 0.04;
    let mut system = fluid(space, 3.0, Clock::new(dt, 1.0, seed).unwrap());
    let (mut field, mut stepper) = (dpd(), GrootWarren::new(0.65).unwrap());
    run(&mut stepper, &mut system, &mut field, (20.0 / dt) as u32);
    let (mut temperature, mut pressure) = (BlockAverage::new(), BlockAverage::new());
    let mut viscometer = Viscometer::new(rate).ok();
    for _ in 0..(time / 0.2) as u32 {
        run(&mut stepper, &mut system, &mut field, 4);
        let mut virial = Virial::default();
        stepper.step(&mut system, &mut field, &mut virial).unwrap();
        let frame = system.frame();
        let t = KineticTemperature::default()
            .measure(&frame, &virial)
            .unwrap();
        temperature.push(t.mean());
        let stress = Stress.measure(&frame, &virial);
        let sigma = stress.item(Item::Conservative);
        pressure.push(-(sigma.x_axis.x + sigma.y_axis.y + sigma.z_axis.z) / 3.0);
        if let Some(viscometer) = &mut viscometer {
            viscometer.push(stress.total());
        }
    }
    let shown = Shown {
        temperature: temperature.estimate().unwrap(),
        conservative_pressure: pressure.estimate().unwrap(),
        functions: viscometer.map(|viscometer| viscometer.estimate().unwrap()),
    };
    println!(
        "rate {rate} seed {seed}: T {}, conservative P {}",
        shown.temperature, shown.conservative_pressure
    );
    if let Some(ShearFunctions {
        viscosity,
        psi1,
        psi2,
    }) = &shown.functions
    {
        println!("viscosity {viscosity}, Psi_1 {psi1}, Psi_2 {psi2}");
    }
    shown
}

/// A tilted lattice at rest is as good as a straight one, through the code that streams: 0.37 of strain before the
/// start and none after.
///
/// Seeds 1 and 2, 500 time units of 648 particles: standard errors 0.0017 in T and 0.0022 in the conservative pressure,
/// bounds 4 sqrt 2 of them. A pair missed or seen twice at the boundary in a hundred would shift the pressure by 0.02.
#[test]
fn law_an_offset_at_rest_changes_nothing() {
    let straight = show(PeriodicBox::cubic(6.0).unwrap(), 0.0, 500.0, 1);
    let offset = StepStrain::new(0.37, -1.0).unwrap();
    let tilted = show(
        LeesEdwards::new(DVec3::splat(6.0), offset).unwrap(),
        0.0,
        500.0,
        2,
    );
    let differ = |a: Mean, b: Mean| (a.value - b.value).abs();
    assert!(differ(straight.temperature, tilted.temperature) < 0.01);
    assert!(differ(straight.conservative_pressure, tilted.conservative_pressure) < 0.0125);
}

/// Published: 0.82, with a standard error of 0.04, to be met to 10 %.
///
/// Seed 1, 600 time units of 3000 particles: standard error 0.02, bound 4 of them (10 %); long runs make 0.852(4) of it.
#[test]
fn reference_viscosity_in_shear() {
    let shown = show(sheared(10.0, 0.1), 0.1, 600.0, 1);
    let viscosity = shown.functions.unwrap().viscosity.value;
    assert!((viscosity - 0.82).abs() < 0.08, "{viscosity}");
}

/// The viscosity of the fluid at rest, from the fluctuations of the stress in all steps, and in slow shear.
///
/// Seed 1, 20 000 time units of 648 particles at rest and 4000 of 3000 particles in shear: standard errors 0.013 and
/// 0.008. Bounds: 4 of both, 0.06 (7 %), and two errors of the published 0.82 +- 0.04.
#[test]
#[ignore = "three minutes; cargo test -p zimm-tests --test shear -- --ignored --nocapture"]
fn law_viscosities_in_shear_and_at_rest_agree() {
    let dt = 0.04;
    let clock = Clock::new(dt, 1.0, 1).unwrap();
    let mut system = fluid(PeriodicBox::cubic(6.0).unwrap(), 3.0, clock);
    let (mut field, mut stepper) = (dpd(), GrootWarren::new(0.65).unwrap());
    run(&mut stepper, &mut system, &mut field, 500);
    let (steps, samples) = (5, 100_000);
    let mut green_kubo = GreenKubo::new(f64::from(steps) * dt, 216.0, 1.0).unwrap();
    for _ in 0..samples {
        let mut mean = DMat3::ZERO;
        for _ in 0..steps {
            let mut virial = Virial::default();
            stepper.step(&mut system, &mut field, &mut virial).unwrap();
            let stress = Stress.measure(&system.frame(), &virial);
            mean += stress.total() * f64::from(steps).recip();
        }
        green_kubo.push(mean);
    }
    let relaxation = green_kubo.estimate().unwrap();
    for (time, viscosity) in relaxation
        .times
        .iter()
        .zip(&relaxation.viscosity)
        .take_while(|(time, _)| **time < 10.0)
        .step_by(4)
    {
        println!("time {time:.1} viscosity {viscosity}");
    }
    // The modulus has decayed by 6 time units; longer lags add noise alone.
    let at_rest = green_kubo.viscosity(6.0).unwrap();
    println!("viscosity at rest {at_rest}");
    let at_rest = at_rest.value;
    let in_shear = show(sheared(10.0, 0.1), 0.1, 4000.0, 1);
    let in_shear = in_shear.functions.unwrap().viscosity.value;
    assert!(
        (at_rest - in_shear).abs() < 0.06,
        "{at_rest} against {in_shear}"
    );
    assert!((in_shear - 0.82).abs() < 0.08, "{in_shear}");
}

/// Across the cell, and across its boundary at both ends: density, peculiar velocity and temperature are the same in
/// every layer.
///
/// Seed 6, 800 time units of 864 particles at a rate of 0.5, 4 in velocity from end to end. Standard errors of a layer:
/// 0.0038 in density, 0.007 in velocity, 0.0029 in temperature. Bounds are 4 of them: 0.5 % of the density, 0.7 % of
/// the velocity difference, 1.2 % of the temperature. In the two layers at the boundary together they are 0.7 of that.
#[test]
fn law_no_kink_at_the_boundary() {
    let space = LeesEdwards::new(DVec3::new(6.0, 8.0, 6.0), Steady::new(0.5).unwrap()).unwrap();
    let mut system = fluid(space, 3.0, Clock::new(0.04, 1.0, 6).unwrap());
    let (mut field, mut stepper) = (dpd(), GrootWarren::new(0.65).unwrap());
    run(&mut stepper, &mut system, &mut field, 500);
    let mut profile = Profile::new(DVec3::Y, 8.0, 16).unwrap();
    let mut average = ProfileAverage::new(&profile);
    for _ in 0..4000 {
        run(&mut stepper, &mut system, &mut field, 5);
        average.push(profile.measure(&system.frame(), &()).unwrap());
    }
    let layers = average.estimate().unwrap();
    let quantity = |pick: fn(&LayerMeans) -> f64, expected: Option<f64>, error: f64| {
        let values: Vec<f64> = layers.iter().map(pick).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let off: Vec<f64> = values
            .iter()
            .map(|x| x - expected.unwrap_or(mean))
            .collect();
        let worst = off.iter().fold(0.0, |worst: f64, x| worst.max(x.abs()));
        let edge = 0.5 * (off[0] + off[15]).abs();
        println!("mean {mean:.4}, worst layer {worst:.4}, boundary {edge:.4}, error {error}");
        assert!(worst < 4.0 * error && edge < 4.0 * 0.7 * error);
    };
    quantity(|layer| layer.density.value, Some(3.0), 0.0038);
    quantity(|layer| layer.velocity[0].value, Some(0.0), 0.007);
    quantity(|layer| layer.velocity[1].value, Some(0.0), 0.007);
    quantity(|layer| layer.temperature.value, None, 0.0029);
}
