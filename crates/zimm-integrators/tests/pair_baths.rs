//! The schemes whose baths act on pairs, against closed forms and conservation laws.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{Cell, Extension, Rub, bits, crowd, momentum};
use zimm_core::noise::Domain;
use zimm_core::{
    AllPairs, Boundary, Clock, DMat3, DVec3, ForceField, Item, Neighbours, Now, Open, Particles,
    StepError, Stepper, System, Tally, VerletList, Virial,
};
use zimm_integrators::{DpdBaoab, GrootWarren, LoweAndersen, Shardlow};

/// The three schemes as one type, so that a law is stated once.
enum Scheme<N> {
    LoweAndersen(LoweAndersen<N>),
    Shardlow(Shardlow<Rub, N>),
    DpdBaoab(DpdBaoab<Rub, N>),
}

impl<B: Boundary, F: ForceField<B>, N: Neighbours<B>> Stepper<B, F> for Scheme<N> {
    fn step<T: Tally>(
        &mut self,
        system: &mut System<B>,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError> {
        match self {
            Self::LoweAndersen(scheme) => scheme.step(system, field, tally),
            Self::Shardlow(scheme) => scheme.step(system, field, tally),
            Self::DpdBaoab(scheme) => scheme.step(system, field, tally),
        }
    }
}

/// Each scheme, with a rate of redrawing or a friction and momentum left alone.
fn schemes<N: Clone>(rate: f64, gamma: f64, neighbours: N) -> [Scheme<N>; 3] {
    let pairs = || neighbours.clone();
    [
        Scheme::LoweAndersen(
            LoweAndersen::new(rate, 1.0, pairs())
                .unwrap()
                .keeping_momentum(),
        ),
        Scheme::Shardlow(Shardlow::new(Rub { gamma }, pairs()).keeping_momentum()),
        Scheme::DpdBaoab(DpdBaoab::new(Rub { gamma }, pairs()).keeping_momentum()),
    ]
}

fn run<B: Boundary, F: ForceField<B>>(
    stepper: &mut impl Stepper<B, F>,
    system: &mut System<B>,
    field: &mut F,
    steps: u32,
) {
    for _ in 0..steps {
        stepper.step(system, field, &mut ()).unwrap();
    }
}

fn with_masses<B>(mut system: System<B>) -> System<B> {
    let n = system.particles.len() as u32;
    let masses = (0..n).map(|k| 0.3 + f64::from(k % 5)).collect();
    system.particles = system.particles.with_masses(masses).unwrap();
    system
}

/// Particles of masses 0.5, 1 and 2 at random places of a cube of edge 4, four in a unit of volume, without momentum
/// and at a quarter of the temperature.
fn ideal_gas(kt: f64, dt: f64) -> System<Cell> {
    let n = 256;
    let noise = Now::default().noise();
    let site = |k| noise.site(k);
    let place = |k: u32, axis: u32| 4.0 * (site(k).uniform(Domain::user(axis)) / 12.0_f64.sqrt());
    let positions = (0..n).map(|k| DVec3::new(place(k, 0), place(k, 1), place(k, 2)));
    let masses: Vec<f64> = (0..n).map(|k| [0.5, 1.0, 2.0][k as usize % 3]).collect();
    let mut velocities: Vec<DVec3> = masses
        .iter()
        .zip(0..n)
        .map(|(m, k)| (0.25 * kt / m).sqrt() * site(k).normal3(Domain::user(3)))
        .collect();
    let total: DVec3 = velocities.iter().zip(&masses).map(|(&c, m)| c * *m).sum();
    let drift = total / masses.iter().sum::<f64>();
    velocities.iter_mut().for_each(|c| *c -= drift);
    let particles = Particles::new(positions.collect()).unwrap();
    let particles = particles
        .with_velocities(velocities)
        .unwrap()
        .with_masses(masses)
        .unwrap();
    System::new(
        Cell::new(4.0, 0.0),
        particles,
        Clock::new(dt, kt, 3).unwrap(),
    )
}

/// Free particles keep Maxwell's distribution at any time step, whatever the rate or friction: `sum m c^2 = (3 N - 3) kT`,
/// and with `s = 1 - m / M` the variance that a momentum of zero leaves, `<(m c^2)^2> = 15 s^2 kT^2`.
///
/// Seed 3, 256 particles, 500 samples between which half of all pairs have been redrawn at the least: 3.8e5 squares,
/// standard error sqrt(2 / 3.8e5) = 0.23 %; fourth powers of 1.3e5 particles, sqrt(945 / 225 - 1) / sqrt(1.3e5) =
/// 0.5 %. Bounds are 4 of them: 0.92 % and 2 %.
#[test]
fn limit_ideal_gas_is_exact_at_any_time_step() {
    let (dt, kt) = (0.1, 1.7);
    for (rate, gamma, interval) in [(1.0, 0.5, 6), (5.0, 20.0, 2), (10.0, 1e4, 1)] {
        for mut scheme in schemes(rate, gamma, VerletList::new(0.2).unwrap()) {
            let mut system = ideal_gas(kt, dt);
            run(&mut scheme, &mut system, &mut (), 40 * interval);
            let (mut square, mut fourth) = (0.0, 0.0);
            for _ in 0..500 {
                run(&mut scheme, &mut system, &mut (), interval);
                let particles = &system.particles;
                let total: f64 = particles.masses().iter().sum();
                for (k, c) in particles.velocities().iter().enumerate() {
                    let mass = particles.mass(k);
                    let energy = mass * c.length_squared() / kt;
                    square += energy / (500.0 * 765.0);
                    fourth += (energy / (1.0 - mass / total)).powi(2) / (500.0 * 256.0 * 15.0);
                }
            }
            println!(
                "rate {rate}, gamma {gamma}: <m c2> {square:.5}, <(m c2)2> {fourth:.5} of expected"
            );
            assert!((square - 1.0).abs() < 0.0092, "{square}");
            assert!((fourth - 1.0).abs() < 0.02, "{fourth}");
        }
    }
}

/// Impulses are equal and opposite: the total momentum of unequal masses stays to rounding, which is that of 1e5 impulses.
#[test]
fn law_momentum_is_conserved() {
    for mut scheme in schemes(50.0, 8.0, AllPairs::default()) {
        let (system, mut field) = crowd(0.0, 0.01);
        let mut system = with_masses(system);
        let before = momentum(&system);
        assert!(before.length() > 1.0);
        run(&mut scheme, &mut system, &mut field, 1000);
        let drift = (momentum(&system) - before).length();
        assert!(drift < 1e-11, "{drift}");
    }
}

/// The total momentum is held at zero unless one wants to keep it.
#[test]
fn law_momentum_is_held_at_zero() {
    let still = |system: &System<Cell>| momentum(system).length() < 1e-12;
    let (system, mut field) = crowd(0.5, 0.01);
    let start = with_masses(system);
    assert!(!still(&start));
    let pairs = AllPairs::default;
    let mut system = start.clone();
    let mut scheme = LoweAndersen::new(50.0, 1.0, pairs()).unwrap();
    run(&mut scheme, &mut system, &mut field, 300);
    assert!(still(&system));
    let mut system = start.clone();
    let mut scheme = Shardlow::new(Rub { gamma: 8.0 }, pairs());
    run(&mut scheme, &mut system, &mut field, 300);
    assert!(still(&system));
    let mut system = start;
    let mut scheme = DpdBaoab::new(Rub { gamma: 8.0 }, pairs());
    run(&mut scheme, &mut system, &mut field, 300);
    assert!(still(&system));
}

/// A pair at distance 0.5 along (3, 4, 0) / 5 that parts at 2 along its line, and its masses.
fn pair_apart(masses: [f64; 2], dt: f64) -> (System<Open>, DVec3) {
    let e = DVec3::new(0.6, 0.8, 0.0);
    let velocities = vec![2.0 * e + DVec3::Z, DVec3::Z];
    let particles = Particles::new(vec![0.5 * e, DVec3::ZERO]).unwrap();
    let particles = particles
        .with_velocities(velocities)
        .unwrap()
        .with_masses(masses.to_vec())
        .unwrap();
    (
        System::new(Open, particles, Clock::new(dt, 0.0, 1).unwrap()),
        e,
    )
}

/// Without noise a pair parts at `exp(-gamma dt / mu)` of its speed, or not at all when it is redrawn; what is across
/// the line of centres stays. The tally hears of the force that the change of momentum makes over the step.
#[test]
fn limit_a_pair_without_noise() {
    let (masses, dt, gamma) = ([0.5, 2.0], 0.1, 0.7);
    let mu: f64 = 0.5 * 2.0 / 2.5;
    let kept = (-gamma * dt / mu).exp();
    for (mut scheme, left, item, middle) in schemes(10.0, gamma, AllPairs::default())
        .into_iter()
        .zip([0.0, kept, kept])
        .zip([Item::Impulse, Item::Dissipative, Item::Dissipative])
        .zip([1.0, 1.0, 0.5])
        .map(|(((scheme, left), item), middle)| (scheme, left, item, middle))
    {
        let (mut system, e) = pair_apart(masses, dt);
        let mut virial = Virial::default();
        scheme.step(&mut system, &mut (), &mut virial).unwrap();
        let c = system.particles.velocities();
        let impulse = mu * (left - 1.0) * 2.0;
        assert!((c[0] - ((2.0 + impulse / 0.5) * e + DVec3::Z)).length() < 1e-15);
        assert!((c[1] - (-impulse / 2.0 * e + DVec3::Z)).length() < 1e-15);
        let r = (0.5 + 2.0 * dt * middle) * e;
        let force = impulse / dt * e;
        let expected = DMat3::from_cols(force.x * r, force.y * r, force.z * r);
        for (found, expected) in [(virial.item(item), expected), (virial.total(), expected)] {
            assert!(
                (found - expected)
                    .to_cols_array()
                    .iter()
                    .all(|x| x.abs() < 1e-14)
            );
        }
    }
}

/// In a flow it is the velocity in the laboratory that is lost, of the nearest image: two particles with peculiar velocities
/// of zero, next to each other across the sheared boundary, part at e . kappa r.
#[test]
fn limit_images_part_with_the_flow() {
    let (rate, edge, dt) = (0.8, 4.0, 0.01);
    let apart = DVec3::new(0.3, 0.4, 0.0);
    for at in [
        DVec3::ZERO,
        DVec3::new(1.8, 1.9, 0.3),
        DVec3::new(-1.9, -1.95, 1.0),
    ] {
        for mut scheme in schemes(100.0, 1e9, AllPairs::default()) {
            let particles = Particles::new(vec![at + apart, at]).unwrap();
            let clock = Clock::new(dt, 0.0, 1).unwrap();
            let mut system = System::new(Cell::new(edge, rate), particles, clock);
            scheme.step(&mut system, &mut (), &mut ()).unwrap();
            let frame = system.frame();
            let r = frame
                .boundary
                .min_image(frame.positions[0] - frame.positions[1]);
            let v = frame.velocities[0] - frame.velocities[1] + frame.boundary.gradient() * r;
            // The others end a step with the sweep. In its middle the line of centres and the velocities turn on by
            // rate dt / 2.
            let parting = r.normalize().dot(v);
            let bound = if matches!(scheme, Scheme::DpdBaoab(_)) {
                0.4 * rate * dt
            } else {
                1e-15
            };
            assert!(parting.abs() < bound, "{parting}");
            assert!((frame.velocities[0].length() - 0.096).abs() < 0.002);
        }
    }
}

/// Where the boundary is does not matter: one step from the same state, moved by a vector, in shear.
#[test]
fn law_a_step_does_not_know_where_the_boundary_is() {
    let (start, mut field) = crowd(0.9, 0.01);
    let mut start = with_masses(start);
    let mut scheme = GrootWarren::new(0.5).unwrap().keeping_momentum();
    run(&mut scheme, &mut start, &mut field, 137);
    for shift in [DVec3::new(0.7, 0.9, -0.6), DVec3::new(-0.2, 0.35, 0.9)] {
        let mut moved = start.clone();
        for r in moved.particles.positions_mut() {
            *r = start.boundary.wrap(*r + shift).0;
        }
        let pairs = || schemes(80.0, 8.0, AllPairs::default()).into_iter();
        for (mut here, mut there) in pairs().zip(pairs()) {
            let (mut one, mut other) = (start.clone(), moved.clone());
            here.step(&mut one, &mut field, &mut ()).unwrap();
            there.step(&mut other, &mut field, &mut ()).unwrap();
            for (a, b) in one
                .particles
                .velocities()
                .iter()
                .zip(other.particles.velocities())
            {
                assert!((*a - *b).length() < 1e-12, "{a} against {b}");
            }
        }
    }
}

/// The source of pairs does not show, nor does its age: all pairs, thick and thin lists, and a scheme made anew in the
/// middle of the run (a restart) lead to the same bits.
#[test]
fn law_bits_do_not_depend_on_the_source_of_pairs() {
    fn go(steppers: [Scheme<impl Neighbours<Cell>>; 2]) -> Vec<u64> {
        let (system, mut field) = crowd(0.7, 0.02);
        let mut system = with_masses(system);
        for mut stepper in steppers {
            run(&mut stepper, &mut system, &mut field, 60);
        }
        bits(&system)
    }
    fn all<N: Clone + Neighbours<Cell>>(neighbours: N) -> Vec<Vec<u64>> {
        let make = || schemes(30.0, 8.0, neighbours.clone()).into_iter();
        make().zip(make()).map(|(a, b)| go([a, b])).collect()
    }
    let reference = all(AllPairs::default());
    for skin in [0.0, 0.05] {
        // Half the shortest lattice vector is 0.9 and more, and the range 1: images are told apart by the cutoff.
        assert!(
            reference == all(VerletList::new(skin).unwrap()),
            "skin {skin}"
        );
    }
}

/// A trajectory belongs to identities, not to places.
#[test]
fn law_noise_follows_identities() {
    for (mut one, mut other) in schemes(30.0, 8.0, AllPairs::default())
        .into_iter()
        .zip(schemes(30.0, 8.0, AllPairs::default()))
    {
        let mut system = with_masses(crowd(0.7, 0.02).0);
        let mut permuted = system.clone();
        let order: Vec<u32> = (0..27).map(|k| 5 * k % 27).collect();
        permuted.particles.permute(&order).unwrap();
        run(&mut one, &mut system, &mut (), 50);
        run(&mut other, &mut permuted, &mut (), 50);
        for (place, &id) in order.iter().enumerate() {
            let places = [(&system, id as usize), (&permuted, place)];
            let [a, b] =
                places.map(|(s, k)| (s.particles.positions()[k], s.particles.velocities()[k]));
            assert_eq!(a, b);
        }
    }
}

/// 200 pairs far from each other, at rest.
fn pairs_at_rest(kt: f64, dt: f64, seed: u64) -> System<Open> {
    let places = (0..200).flat_map(|k| {
        let r = f64::from(k) * 10.0 * DVec3::Z;
        [r, r + 0.5 * DVec3::X]
    });
    let particles = Particles::new(places.collect()).unwrap();
    System::new(Open, particles, Clock::new(dt, kt, seed).unwrap())
}

/// A pair is redrawn with the probability rate dt, and its new velocity has nothing to do with that it was chosen: from
/// the normal distribution of variance 2 kT.
///
/// 40 000 pairs, seeds 0 to 199. Standard errors: sqrt(p (1 - p) / 40 000), bound 4 of them, 6 % of p = 0.1; of those chosen
/// the variance has sqrt(2 / n), the fourth moment sqrt(96 / 9 / n), the mean sqrt(1 / n), bounds 4 of them.
#[test]
fn law_pairs_are_chosen_and_redrawn_independently() {
    let (kt, dt) = (1.3, 0.02);
    for share in [0.1, 0.5, 1.0] {
        let (mut chosen, mut moments) = (0.0, [0.0; 3]);
        for seed in 0..200 {
            let mut system = pairs_at_rest(kt, dt, seed);
            let rate = share / dt;
            let mut scheme = LoweAndersen::new(rate, 1.0, AllPairs::default()).unwrap();
            scheme.step(&mut system, &mut (), &mut ()).unwrap();
            for pair in system.particles.velocities().chunks(2) {
                let u = (pair[1] - pair[0]).x / (2.0 * kt).sqrt();
                if u != 0.0 {
                    chosen += 1.0;
                    for (moment, power) in moments.iter_mut().zip([1, 2, 4]) {
                        *moment += u.powi(power);
                    }
                }
            }
        }
        let [mean, square, fourth] = moments.map(|sum| sum / chosen);
        println!("share {share}: {chosen} chosen, moments {mean:.4} {square:.4} {fourth:.4}");
        let bound = 4.0 * (40_000.0 * share * (1.0 - share)).sqrt();
        assert!((chosen - 40_000.0 * share).abs() <= bound, "{chosen}");
        for (found, expected, variance) in
            [(mean, 0.0, 1.0), (square, 1.0, 2.0), (fourth, 3.0, 96.0)]
        {
            let bound = 4.0 * f64::sqrt(variance / chosen);
            assert!(
                (found - expected).abs() < bound,
                "{found} against {expected}"
            );
        }
    }
}

/// Three particles in a row, the first of which moves. Without noise the third gets to know of it in the same step if the
/// pair of the first two has its turn before the other one: in half of all cases, and its velocity is then 1/4.
///
/// 1000 seeds, standard error 0.016, bound 4 of them: 0.063.
#[test]
fn law_turns_are_drawn_anew_and_pairs_see_what_was_before() {
    let mut first = 0.0;
    for seed in 0..1000 {
        let places = [0.0, 0.6, 1.2].map(|x| DVec3::new(x, 0.0, 0.0));
        let particles = Particles::new(places.to_vec())
            .unwrap()
            .with_velocities(vec![DVec3::X, DVec3::ZERO, DVec3::ZERO])
            .unwrap();
        let mut system = System::new(Open, particles, Clock::new(0.01, 0.0, seed).unwrap());
        let mut scheme = LoweAndersen::new(100.0, 1.0, AllPairs::default())
            .unwrap()
            .keeping_momentum();
        scheme.step(&mut system, &mut (), &mut ()).unwrap();
        let c = system.particles.velocities();
        assert_eq!(c[0].x, 0.5);
        assert!(c[2].x == 0.25 || c[2].x == 0.0);
        first += c[2].x * 4.0 / 1000.0;
    }
    println!("{first}");
    assert!((first - 0.5).abs() < 0.063, "{first}");
}

/// Without friction the schemes are velocity Verlet.
#[test]
fn limit_no_bath_is_velocity_verlet() {
    for mut scheme in schemes(0.0, 0.0, AllPairs::default()) {
        let (mut one, mut field) = crowd(0.5, 0.01);
        let mut other = one.clone();
        let mut verlet = GrootWarren::new(0.5).unwrap().keeping_momentum();
        run(&mut scheme, &mut one, &mut field, 50);
        run(&mut verlet, &mut other, &mut field, 50);
        for (a, b) in one
            .particles
            .positions()
            .iter()
            .zip(other.particles.positions())
        {
            assert!((*a - *b).length() < 1e-13);
        }
    }
}

/// The forces kept are those of the field at the new positions.
#[test]
fn law_forces_are_those_of_the_field() {
    for mut scheme in schemes(50.0, 8.0, AllPairs::default()) {
        let (mut system, mut field) = crowd(0.5, 0.01);
        run(&mut scheme, &mut system, &mut field, 20);
        let mut forces = vec![DVec3::ZERO; 27];
        field
            .accumulate(&system.frame(), &mut forces, &mut ())
            .unwrap();
        assert_eq!(system.particles.forces(), forces);
    }
}

#[test]
fn extreme_rates_that_are_no_probability_are_errors() {
    let (mut system, mut field) = crowd(0.5, 0.01);
    let before = bits(&system);
    let mut scheme = LoweAndersen::new(101.0, 1.0, AllPairs::default()).unwrap();
    match scheme.step(&mut system, &mut field, &mut ()).unwrap_err() {
        StepError::Parameter { step, source } => {
            assert_eq!((step, source.name), (1, "rate dt"));
            assert!((source.found - 1.01).abs() < 1e-15);
        }
        other => panic!("{other}"),
    }
    assert_eq!(bits(&system), before);
    system.clock.set_dt(1.0 / 101.0).unwrap();
    scheme.step(&mut system, &mut field, &mut ()).unwrap();

    for rate in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(LoweAndersen::new(rate, 1.0, ()).unwrap_err().name, "rate");
    }
    for cutoff in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
        let error = LoweAndersen::new(1.0, cutoff, ()).unwrap_err();
        assert_eq!(error.name, "cutoff");
    }
}

/// A cutoff that the cell cannot resolve is an error of the step.
#[test]
fn extreme_a_cutoff_beyond_the_cell_is_an_error() {
    let (mut system, mut field) = crowd(0.0, 0.01);
    let mut scheme = LoweAndersen::new(10.0, 1.01, AllPairs::default()).unwrap();
    let error = scheme.step(&mut system, &mut field, &mut ()).unwrap_err();
    assert!(matches!(error, StepError::Force { step: 1, .. }), "{error}");
}

/// Particles on top of each other have no line of centres and do not see each other; those a hair apart do.
#[test]
fn extreme_particles_on_top_of_each_other() {
    for mut scheme in schemes(100.0, 1e3, AllPairs::default()) {
        let mut places = vec![DVec3::ONE; 8];
        places.push(DVec3::ONE + 1e-160 * DVec3::X);
        places.extend([DVec3::ZERO, 1e-150 * DVec3::X]);
        let particles = Particles::new(places).unwrap();
        let mut system = System::new(Open, particles, Clock::new(0.01, 1.0, 1).unwrap());
        scheme.step(&mut system, &mut (), &mut ()).unwrap();
        let c = system.particles.velocities();
        assert!(c.iter().all(|c| c.is_finite()));
        assert!(c[..9].iter().all(|other| *other == c[0]));
        assert!((c[9] - c[10]).x.abs() > 1e-3 && c[9].length() < 10.0);
    }
}

/// Friction without end, no temperature, no particles, a single one: nothing that is not finite.
#[test]
fn extreme_frictions_and_numbers() {
    for n in [0, 1, 2] {
        for kt in [0.0, 1.0] {
            for mut scheme in schemes(1.0, 1e300, AllPairs::default()) {
                let particles =
                    Particles::new((0..n).map(|k| f64::from(k) * DVec3::X * 0.3).collect());
                let mut system =
                    System::new(Open, particles.unwrap(), Clock::new(1.0, kt, 1).unwrap());
                run(&mut scheme, &mut system, &mut (), 10);
                assert!(system.particles.velocities().iter().all(|c| c.is_finite()));
                if kt == 0.0 {
                    assert!(
                        system
                            .particles
                            .velocities()
                            .iter()
                            .all(|c| *c == DVec3::ZERO)
                    );
                }
            }
        }
    }
}

/// Time steps without any sense end in an error, never in a state that is not finite.
#[test]
fn extreme_huge_time_steps_are_errors() {
    for dt in [1e10, 1e150, 1e308] {
        for mut scheme in schemes(1.0 / dt, 5.0, AllPairs::default()) {
            let (mut system, mut field) = crowd(0.0, dt);
            let before = bits(&system);
            let error = scheme.step(&mut system, &mut field, &mut ()).unwrap_err();
            assert!(
                matches!(error, StepError::NotFinite { step: 1, .. }),
                "{error}"
            );
            assert_eq!(bits(&system), before);
        }
    }
}

/// In extension a pair of peculiar velocity zero is stopped along its line as well, and the momentum that grows along the
/// contracting axis is taken off.
#[test]
fn limit_pairs_in_extension() {
    let apart = DVec3::new(0.3, 0.4, 0.0);
    for mut scheme in schemes(100.0, 1e9, AllPairs::default()) {
        let particles = Particles::new(vec![apart, DVec3::ZERO]).unwrap();
        let clock = Clock::new(0.01, 0.0, 1).unwrap();
        let mut system = System::new(Extension { rate: 0.7 }, particles, clock);
        run(&mut scheme, &mut system, &mut (), 200);
        // A rigid rod along the contracting axis turns towards the other one and keeps its length.
        let r = system.particles.positions()[0] - system.particles.positions()[1];
        println!("{r}");
        assert!((r.length() - 0.5).abs() < 0.02, "{r}");
        assert!(r.x > r.y.abs());
    }
}
