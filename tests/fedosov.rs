//! The melts and solutions of Fedosov, Karniadakis and Caswell, J. Chem. Phys. 132, 144103 (2010), in shear and in a
//! channel; no test uses all of it.
#![allow(dead_code, unreachable_pub)]

use crate::scene::run;
use zimm::prelude::*;

const DENSITY: f64 = 3.0;

/// Particles of density 3 with r_c = 2 and friction of weight (1 - r / r_c)^1/2, the first of them in chains with FENE
/// springs.
#[derive(Clone, Copy)]
pub struct Fluid {
    /// Beads of a chain.
    pub beads: u32,
    /// Share of the beads that are in chains.
    pub share: f64,
    pub kt: f64,
    pub repulsion: f64,
    pub friction: f64,
    pub stiffness: f64,
    pub limit: f64,
}

pub type Forces = (Pairwise<Dpd<f64, SquareRoot>, VerletList>, Bonded<Fene>);

/// The melts of his Table I.
pub fn melt(beads: u32) -> Fluid {
    Fluid {
        beads,
        share: 1.0,
        kt: 1.0,
        repulsion: 25.0,
        friction: 4.5,
        stiffness: 50.0,
        limit: 1.0,
    }
}

/// What a run in a channel was made with, and what it found.
pub struct Shown {
    pub average: StressProfileAverage,
    pub channel: Channel,
}

/// Averages a channel driven along x that is at rest, after `unseen` steps, looking at every `every`th of `steps`.
pub fn flow<F: ForceField<PeriodicBox>>(
    system: &mut System<PeriodicBox>,
    field: &mut F,
    stepper: &mut GrootWarren,
    (force, layers): (f64, usize),
    (unseen, steps, every): (u32, u32, u32),
) -> Shown {
    let height = system.boundary.lattice().basis().y_axis.y;
    let profile = Profile::new(DVec3::Y, height, layers).unwrap();
    let heard = LayeredVirial::new(&profile);
    let mut observable = StressProfile::new(profile, 2).without(Item::Random);
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

impl Fluid {
    /// In any space, relaxed for a time; then dt = 0.005. Chains are of species 1.
    fn relaxed<B: Periodic>(&self, space: B, time: f64) -> (System<B>, Forces) {
        let all = DENSITY * space.lattice().volume();
        let count = (all * self.share / f64::from(self.beads)).round() as u32;
        let chains = Molecules::linear(0, count, self.beads).unwrap();
        let mut rng = start::stream(1);
        let mut positions = start::chains(space.lattice(), &chains, |_| 0.3, &mut rng);
        let joined = positions.len();
        let free = (all.round() as usize).saturating_sub(joined);
        positions.extend(start::uniform(space.lattice(), free, &mut rng));
        let species = (0..positions.len()).map(|k| u8::from(k < joined)).collect();
        let particles = Particles::new(positions).unwrap();
        let velocities = start::velocities(&particles, self.kt, &mut rng).unwrap();
        let particles = particles.with_velocities(velocities).unwrap();
        let particles = particles.with_species(species).unwrap();
        // Overlaps of the random start want short steps.
        let clock = Clock::new(0.001, self.kt, 1).unwrap();
        let mut system = System::new(space, particles, clock);
        let law = Dpd::new(self.repulsion, self.friction).unwrap();
        let law = law.with_cutoff(2.0).unwrap().with_weight(SquareRoot);
        let springs = Fene::new(self.stiffness, self.limit).unwrap();
        let pairs = Pairwise::new(law, VerletList::new(0.25).unwrap());
        let mut field = (pairs, Bonded::new(springs, chains.bonds()));
        let mut stepper = GrootWarren::new(0.5).unwrap();
        run(&mut stepper, &mut system, &mut field, 1000);
        system.clock.set_dt(0.005).unwrap();
        run(&mut stepper, &mut system, &mut field, (time / 0.005) as u32);
        (system, field)
    }

    /// In a cube between Lees and Edwards' images.
    pub fn sheared(&self, edge: f64, rate: f64, (unseen, time): (f64, f64)) -> ShearFunctions {
        let space = LeesEdwards::new(DVec3::splat(edge), Steady::new(rate).unwrap()).unwrap();
        let (mut system, mut field) = self.relaxed(space, unseen);
        let mut stepper = GrootWarren::new(0.5).unwrap();
        let mut viscometer = Viscometer::new(rate).unwrap();
        let [mut pressure, mut temperature] = [(); 2].map(|()| BlockAverage::new());
        for _ in 0..(time / 0.05) as u32 {
            run(&mut stepper, &mut system, &mut field, 9);
            let mut virial = Virial::default();
            stepper.step(&mut system, &mut field, &mut virial).unwrap();
            let stress = Stress
                .measure(&system.frame(), &virial)
                .without(Item::Random);
            viscometer.push(stress.total());
            pressure.push(stress.pressure());
            let kinetic = KineticTemperature::default().measure(&system.frame(), &());
            temperature.push(kinetic.unwrap().mean());
        }
        let functions = viscometer.estimate().unwrap();
        let (viscosity, psi1, psi2) = (functions.viscosity, functions.psi1, functions.psi2);
        let [pressure, temperature] = [pressure, temperature].map(|mean| mean.estimate().unwrap());
        println!(
            "N {} kT {} shear {rate}: eta {viscosity}, Psi_1 {psi1}, Psi_2 {psi2}, P {pressure}, T {temperature}",
            self.beads, self.kt
        );
        functions
    }

    /// In a channel, driven by a force, in layers of about half a unit.
    pub fn driven(&self, size: DVec3, force: f64, (unseen, time): (f64, f64)) -> Shown {
        let space = PeriodicBox::brick(size).unwrap();
        let (mut system, (pairs, springs)) = self.relaxed(space, 20.0);
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
}

/// Prints all that a channel shows.
pub fn show(title: &str, Shown { average, channel }: &Shown) {
    for l in channel.layers(average).unwrap() {
        let ChannelLayer {
            distance,
            density,
            concentrations,
            velocity,
            temperature,
            imposed,
            shear,
            rate,
            ..
        } = &l;
        let chains = concentrations[1];
        print!(
            "{title} y {distance:.2} n {density:#} chains {chains:#} V {velocity:#} T {temperature:#}"
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
                "{title} share {share}: eta_0 {viscosity}, Psi_1 {psi1}, Psi_2 {psi2}, \
                 lambda_0 {relaxation_time}, ratio {ratio:?}"
            ),
            Err(problem) => println!("{title} share {share}: {problem}"),
        }
    }
    let (p, one) = (
        channel.velocity_exponent(average).unwrap(),
        channel.viscosity(average),
    );
    println!("{title}: p of the velocity {p}, one viscosity {one:?}");
}
