//! Springs that repel each other do not cross.
#![allow(clippy::unwrap_used)]

mod scene;

use scene::{pairs, run};
use zimm::prelude::*;

/// Chains of Clarke (2008): 20 beads, FENE springs with Q_0 = 5 and b = 50, H = 2.
fn springs(molecules: &Molecules) -> Bonded<Fene> {
    Bonded::new(
        Fene::with_extensibility(50.0, 5.0, 1.0).unwrap(),
        molecules.bonds(),
    )
}

fn repulsion<L>(law: L, molecules: &Molecules) -> SegmentRepulsion<L, VerletList> {
    SegmentRepulsion::new(law, molecules.bonds(), VerletList::new(0.35).unwrap())
}

/// This many chains, and solvent up to a density if it is above zero, in a cube of edge 7.
fn scene(chains: u32, density: f64, seed: u64) -> (System<PeriodicBox>, Molecules) {
    let space = PeriodicBox::cubic(7.0).unwrap();
    let lattice = *space.lattice();
    let molecules = Molecules::linear(0, chains, 20).unwrap();
    let mut rng = start::stream(seed);
    let mut positions = start::chains(&lattice, &molecules, |_| 1.1, &mut rng);
    let count = (density * lattice.volume()).round() as usize;
    let solvent = count.saturating_sub(positions.len());
    positions.extend(start::uniform(&lattice, solvent, &mut rng));
    let particles = Particles::new(positions).unwrap();
    let velocities = start::velocities(&particles, 1.0, &mut rng).unwrap();
    let particles = particles.with_velocities(velocities).unwrap();
    let clock = Clock::new(0.01, 1.0, seed).unwrap();
    (System::new(space, particles, clock), molecules)
}

/// The law of the thesis as it is printed, with a contact force of A alpha = 1000, and one whose contact force is 100.
fn laws() -> [KumarLarson; 2] {
    let cutoff = 1.0 / 3.0;
    [
        KumarLarson::new(100.0, 10.0, cutoff).unwrap(),
        KumarLarson::with_contact_force(100.0, 10.0, cutoff).unwrap(),
    ]
}

/// Crossings while a scene runs, looked at in every step.
fn crossings<F: ForceField<PeriodicBox>>(
    stepper: &mut impl Stepper<PeriodicBox, F>,
    system: &mut System<PeriodicBox>,
    field: &mut F,
    molecules: &Molecules,
    steps: u32,
) -> u64 {
    let mut crossings = Crossings::new(*molecules, VerletList::new(0.0).unwrap());
    crossings.measure(&system.frame(), &()).unwrap();
    let each = (0..steps).map(|_| {
        stepper.step(system, field, &mut ()).unwrap();
        crossings.measure(&system.frame(), &()).unwrap()
    });
    each.sum()
}

/// Chains at five times the overlap concentration pass through each other at the rate of kinetic theory if nothing
/// hinders them, and not once in the time of 7000 such crossings with the thesis' law: a rate that falls by 1000 would
/// let 7 pass, and none in e^-7 = 0.1 % of cases.
///
/// 35 chains in Langevin dynamics, seed 7. Theory counts bonds of different chains, which are independent: per pair (pi
/// / 4) <Q>^2 (2 / pi)^1/2 I / V with <Q> = 0.21615 Q_0 and I = 1.1424, see [`Crossings`]'s own test. Those of the same
/// chain add what their closeness makes of them, and a pair that has crossed often crosses back, so that the standard
/// error is near 4 %; measured 1.17 of theory. The weaker law has let none of 6100 pass.
#[test]
fn limit_chains_cross_unless_they_repel() {
    let (mut system, molecules) = scene(35, 0.0, 7);
    let mut stepper = Langevin::new(2.0).unwrap();
    let mut free = springs(&molecules);
    run(&mut stepper, &mut system, &mut free, 500);
    let phantom = crossings(&mut stepper, &mut system, &mut free, &molecules, 300);
    let phantom_rate = phantom as f64 / 3.0;
    let bond = 0.21615 * 5.0;
    let per_pair = 0.25 * std::f64::consts::PI * bond * bond * (2.0 / std::f64::consts::PI).sqrt();
    let pairs = 0.5 * (35.0 * 19.0) * (34.0 * 19.0);
    let theory = pairs * per_pair * 1.1424 / 343.0;
    println!(
        "phantom chains: {phantom} crossings, {phantom_rate:.0} per time; {theory:.0} between chains"
    );

    let [literal, weaker] = laws();
    let mut soft = (free.clone(), repulsion(weaker, &molecules));
    run(&mut stepper, &mut system, &mut soft, 200);
    let passed = crossings(&mut stepper, &mut system, &mut soft, &molecules, 1000);
    println!("contact force 100: {passed} of {:.0}", 10.0 * phantom_rate);
    let mut hard = (free, repulsion(literal, &molecules));
    run(&mut stepper, &mut system, &mut hard, 100);
    let (steps, before) = (1300, system.clock.now().time);
    let through = crossings(&mut stepper, &mut system, &mut hard, &molecules, steps);
    let expected = (system.clock.now().time - before) * phantom_rate;
    println!("contact force 1000: {through} of {expected:.0}");
    assert!((1.0..1.4).contains(&(phantom_rate / theory)));
    assert!(expected > 7000.0 && through == 0);
    assert!(passed as f64 * 1000.0 < 10.0 * phantom_rate);
}

/// The scene of 7 chains in solvent, 10 % beads of chains (Clarke's c / c* = 1), in classic DPD: the distribution of
/// distances between springs and the rate of crossing, without and with the exponential law.
///
/// Expected are the numbers of an independent code with the thermostat of Lowe and Andersen: pairs per bin of 0.05 up
/// to 0.35 are 2.5 3.1 3.9 4.8 5.9 7.4 9.4 without; none below 0.2 with a contact force of 1000; 0.0025 0.018 0.12 0.53
/// 1.5 3.2 5.9 with one of 100. Theirs and ours are good to some 10 % (7 chains, one relaxation time). Extra pressure
/// 0.026 and 0.016.
#[test]
#[ignore = "a minute; cargo test --release -p zimm-tests --test spring_crossings -- --ignored --nocapture"]
fn reference_distances_between_springs() {
    let (mut system, molecules) = scene(7, 4.0, 5);
    let field = || {
        let dpd = pairs(Dpd::new(18.75, 4.5).unwrap());
        (dpd, springs(&molecules))
    };
    let mut stepper = GrootWarren::new(0.65).unwrap();
    run(&mut stepper, &mut system, &mut field(), 3000);
    let [literal, weaker] = laws().map(|law| repulsion(law, &molecules));
    let (phantom, free) = look(&mut system, &mut field(), &molecules);
    let (soft_crossings, soft) = look(&mut system, &mut (field(), weaker), &molecules);
    let (hard_crossings, hard) = look(&mut system, &mut (field(), literal), &molecules);
    for (found, expected) in free.iter().zip([2.5, 3.1, 3.9, 4.8, 5.9, 7.4, 9.4]) {
        assert!(
            (found / expected - 1.0).abs() < 0.25,
            "{found} against {expected}"
        );
    }
    assert!(hard[..4].iter().all(|&pairs| pairs == 0.0));
    assert!(soft[..3].iter().sum::<f64>() * 20.0 < free[..3].iter().sum());
    for (found, expected) in soft[3..].iter().zip([0.53, 1.5, 3.2, 5.9]) {
        assert!(
            (found / expected - 1.0).abs() < 0.35,
            "{found} against {expected}"
        );
    }
    assert!(phantom > 2000 && hard_crossings == 0 && soft_crossings * 500 < phantom);
}

/// Crossings, and mean numbers of pairs by their distance in seven bins of 0.05, over a time of 150.
fn look<F: ForceField<PeriodicBox>>(
    system: &mut System<PeriodicBox>,
    field: &mut F,
    molecules: &Molecules,
) -> (u64, Vec<f64>) {
    let mut stepper = GrootWarren::new(0.65).unwrap();
    run(&mut stepper, system, field, 1000);
    let (mut bins, mut pressure) = (BlockAverages::new(7), BlockAverage::new());
    let mut histogram = SpringDistribution::new(0.35, 7).unwrap();
    let mut counter = Crossings::new(*molecules, VerletList::new(0.0).unwrap());
    let mut listener = repulsion(Phantom::new(0.35).unwrap(), molecules);
    let (mut crossings, mut closest) = (0, f64::INFINITY);
    for step in 0..15_000 {
        let mut virial = Virial::default();
        stepper.step(system, field, &mut virial).unwrap();
        crossings += counter.measure(&system.frame(), &()).unwrap();
        if step % 10 == 0 {
            let mut scratch = vec![DVec3::ZERO; system.particles.len()];
            let mut heard = SpringDistances::default();
            let frame = system.frame();
            listener
                .accumulate(&frame, &mut scratch, &mut heard)
                .unwrap();
            closest = heard.0.iter().copied().fold(closest, f64::min);
            bins.push(histogram.measure(&frame, &heard));
            let w = virial.item(Item::SpringRepulsion);
            pressure.push((w.x_axis.x + w.y_axis.y + w.z_axis.z) / (3.0 * 343.0));
        }
    }
    let means: Vec<f64> = bins
        .estimate()
        .unwrap()
        .iter()
        .map(|mean| mean.value)
        .collect();
    println!(
        "{crossings} crossings; pairs per bin {means:.4?}; closest {closest:.2e}; extra pressure {}",
        pressure.estimate().unwrap()
    );
    (crossings, means)
}
