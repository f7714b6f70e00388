//! Langevin dynamics against exact moments.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{Cell, Trap, crowd};
use zimm_core::{Clock, DVec3, Open, Particles, Stepper, System};
use zimm_integrators::{GrootWarren, Langevin};

fn at_origin(n: usize, mass: f64, dt: f64, kt: f64) -> System<Open> {
    let particles = Particles::new(vec![DVec3::ZERO; n]).unwrap();
    let particles = particles.with_masses(vec![mass; n]).unwrap();
    System::new(Open, particles, Clock::new(dt, kt, 11).unwrap())
}

fn mean_square(column: &[DVec3]) -> f64 {
    column.iter().map(|v| v.length_squared()).sum::<f64>() / (3.0 * column.len() as f64)
}

/// BAOAB in a harmonic trap: <x^2> = kT / k at any time step, <c^2> = (kT / m) (1 - (omega dt)^2 / 4).
///
/// Seed 11. 10 000 particles, 60 samples 6 time units apart; correlations of squares fall as exp(-2.2 t) at the
/// latest, so samples are independent: 1.8e6 numbers, standard error sqrt(2 / 1.8e6) = 0.105 %. Bound 4 sigma =
/// 0.42 %. The correction to <c^2> is 6 % here; an error of 1 % in noise, friction or kicks is caught.
#[test]
fn limit_harmonic_trap() {
    let (stiffness, mass, dt, kt) = (3.0, 2.0, 0.4, 1.5);
    let mut system = at_origin(10_000, mass, dt, kt);
    let mut stepper = Langevin::new(2.0).unwrap();
    let mut trap = Trap { stiffness };
    let (mut x2, mut c2) = (0.0, 0.0);
    for sample in 0..62 {
        for _ in 0..15 {
            stepper.step(&mut system, &mut trap, &mut ()).unwrap();
        }
        if sample >= 2 {
            x2 += mean_square(system.particles.positions()) / 60.0;
            c2 += mean_square(system.particles.velocities()) / 60.0;
        }
    }
    let (x2_expected, c2_expected) = (
        kt / stiffness,
        kt / mass * (1.0 - stiffness / mass * dt * dt / 4.0),
    );
    println!(
        "<x2> {:.5}, <c2> {:.5} of expected",
        x2 / x2_expected,
        c2 / c2_expected
    );
    assert!(
        (x2 / x2_expected - 1.0).abs() < 0.0042,
        "{x2} against {x2_expected}"
    );
    assert!(
        (c2 / c2_expected - 1.0).abs() < 0.0042,
        "{c2} against {c2_expected}"
    );
}

/// Free particles from rest: <c^2> = (kT / m) (1 - exp(-2 Gamma t)) exactly, and <x^2> from the same recursion in
/// moments that the scheme makes, x' = x + (dt / 2) (c + c'). At long times D = (kT / m Gamma) h coth h, h = Gamma dt / 2.
///
/// Seed 11, 100 000 particles: 3e5 numbers, standard error sqrt(2 / 3e5) = 0.26 %, bound 4 sigma = 1.04 %.
#[test]
fn limit_free_particles() {
    let (friction, mass, dt, kt, steps) = (1.5, 2.0, 0.2, 0.8, 60);
    let mut system = at_origin(100_000, mass, dt, kt);
    let mut stepper = Langevin::new(friction).unwrap();
    for _ in 0..steps {
        stepper.step(&mut system, &mut (), &mut ()).unwrap();
    }
    let memory: f64 = (-friction * dt).exp();
    let fresh = kt / mass * (1.0 - memory * memory);
    let (mut xx, mut xc, mut cc) = (0.0, 0.0, 0.0);
    for _ in 0..steps {
        let next = memory * memory * cc + fresh;
        let both = cc + 2.0 * memory * cc + next;
        xx += dt * (xc + memory * xc) + 0.25 * dt * dt * both;
        xc = memory * xc + 0.5 * dt * (memory * cc + next);
        cc = next;
    }
    let exact = kt / mass * (1.0 - (-2.0 * friction * dt * f64::from(steps)).exp());
    assert!((cc / exact - 1.0).abs() < 1e-12);
    let x2 = mean_square(system.particles.positions()) / xx;
    let c2 = mean_square(system.particles.velocities()) / cc;
    println!("<x2> {x2:.5}, <c2> {c2:.5} of expected");
    assert!((x2 - 1.0).abs() < 0.0104, "{x2}");
    assert!((c2 - 1.0).abs() < 0.0104, "{c2}");
}

/// Free particles in shear: the friction is against the flow, so <c_x c_y> = -(kT / m) (rate dt / 2) coth(Gamma dt),
/// which is -(kT / m) rate / 2 Gamma as dt -> 0, and <c_y c_y> = kT / m.
///
/// Seed 5. 20 000 particles, 40 samples 10 steps apart. Correlations of products fall by exp(-2 Gamma 10 dt) = 2e-7.
/// The variance of c_x c_y is <c_x c_x> <c_y c_y> + <c_x c_y>^2 = 0.3, so the standard error is sqrt(0.3 / 8e5) = 6.1e-4;
/// expected -0.1417, bound 4 sigma = 2.5e-3, that is 1.7 %.
#[test]
fn limit_covariance_in_shear() {
    let (friction, rate, dt, kt, mass, n) = (2.5, 1.2, 0.3, 1.0, 2.0, 20_000);
    let particles = Particles::new(vec![DVec3::ZERO; n]).unwrap();
    let particles = particles.with_masses(vec![mass; n]).unwrap();
    let mut system = System::new(
        Cell::new(2.0, rate),
        particles,
        Clock::new(dt, kt, 5).unwrap(),
    );
    let mut stepper = Langevin::new(friction).unwrap();
    let (mut xy, mut yy) = (0.0, 0.0);
    for sample in 0..42 {
        for _ in 0..10 {
            stepper.step(&mut system, &mut (), &mut ()).unwrap();
        }
        if sample >= 2 {
            let velocities = system.particles.velocities();
            xy += velocities.iter().map(|c| c.x * c.y).sum::<f64>() / (40.0 * n as f64);
            yy += velocities.iter().map(|c| c.y * c.y).sum::<f64>() / (40.0 * n as f64);
        }
    }
    let expected = -kt / mass * 0.5 * rate * dt / (friction * dt).tanh();
    println!("xy {xy:.5} against {expected:.5}, yy {yy:.5}");
    assert!((xy - expected).abs() < 2.5e-3, "{xy} against {expected}");
    // sqrt(2 / 8e5) = 0.16 %, 4 sigma = 0.64 %.
    assert!((yy * mass / kt - 1.0).abs() < 0.0064, "{yy}");
}

/// Without friction this is velocity Verlet.
#[test]
fn limit_no_friction_is_velocity_verlet() {
    let (mut one, mut field) = crowd(0.5, 0.01);
    let mut other = one.clone();
    let mut langevin = Langevin::new(0.0).unwrap();
    let mut verlet = GrootWarren::new(0.5).unwrap().keeping_momentum();
    for _ in 0..50 {
        langevin.step(&mut one, &mut field, &mut ()).unwrap();
        verlet.step(&mut other, &mut field, &mut ()).unwrap();
    }
    for (a, b) in one
        .particles
        .positions()
        .iter()
        .zip(other.particles.positions())
    {
        assert!((*a - *b).length() < 1e-13);
    }
}

/// A trajectory belongs to an identity, not to a place: the bits are the same in any order of particles.
#[test]
fn law_noise_follows_identities() {
    let (mut system, _) = crowd(0.5, 0.01);
    let mut permuted = system.clone();
    let order: Vec<u32> = (0..27).map(|k| 5 * k % 27).collect();
    permuted.particles.permute(&order).unwrap();
    let mut trap = Trap { stiffness: 1.0 };
    let mut stepper = Langevin::new(0.5).unwrap();
    for _ in 0..50 {
        stepper.step(&mut system, &mut trap, &mut ()).unwrap();
        stepper.step(&mut permuted, &mut trap, &mut ()).unwrap();
    }
    for (place, &id) in order.iter().enumerate() {
        let places = [(&system, id as usize), (&permuted, place)];
        let [a, b] = places.map(|(s, k)| (s.particles.positions()[k], s.particles.velocities()[k]));
        assert_eq!(a, b);
    }
}

#[test]
fn extreme_frictions() {
    for friction in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(Langevin::new(friction).unwrap_err().name, "friction");
    }
    // Friction without end leaves thermal velocities and nothing of the past.
    let mut system = at_origin(1, 1.0, 0.1, 0.0);
    system.particles = system.particles.with_velocities(vec![DVec3::X]).unwrap();
    Langevin::new(1e300)
        .unwrap()
        .step(&mut system, &mut (), &mut ())
        .unwrap();
    assert_eq!(system.particles.velocities()[0], DVec3::ZERO);
}
