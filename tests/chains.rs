//! Bead-spring chains in Brownian dynamics: what the tests share; none of them uses all.
//!
//! Units are kT, l_H = sqrt(kT / H) and lambda_H = zeta / 4H: stiffness 1 and a friction of 4.
#![allow(dead_code, unreachable_pub)]

use zimm::prelude::*;

pub type Scheme = SemiImplicit<FreeDraining, Diagonal>;

const FRICTION: f64 = 4.0;

/// How far a time step may move a mean, in parts of it.
const STEP_ERROR: f64 = 2e-3;

/// Chains in a space, what acts on them and what moves them.
pub struct Scene<B, F> {
    pub system: System<B>,
    pub chains: Molecules,
    pub field: F,
    stepper: Scheme,
}

/// Means over the chains of a scene at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Stress per chain over kT, by Kramers and by Giesekus.
    pub kramers: DMat3,
    pub giesekus: DMat3,
    /// `<RR>` and `<R^4>` of the vector between the ends.
    pub ends: DMat3,
    pub fourth: f64,
    /// Squared radius of gyration.
    pub gyration: f64,
}

impl Seen {
    pub fn square(&self) -> f64 {
        self.ends.x_axis.x + self.ends.y_axis.y + self.ends.z_axis.z
    }
}

pub fn clock(dt: f64, seed: u64) -> Clock {
    Clock::new(dt, 1.0, seed).unwrap()
}

/// Chains in open space, each with its centre at the origin, that begin in the equilibrium of their springs.
pub fn isolated<B: Boundary, S: BondForce>(
    space: B,
    spring: S,
    chains: Molecules,
    clock: Clock,
) -> Scene<B, Bonded<S>> {
    let bond = start::BondLength::new(&spring, 1.0).unwrap();
    let mut rng = start::stream(clock.now().seed);
    let positions = start::isolated(&chains, |rng| bond.sample(rng), &mut rng);
    Scene::new(space, positions, spring, chains, clock)
}

/// The same anywhere in a cell.
pub fn in_cell<B: Periodic, S: BondForce>(
    space: B,
    spring: S,
    chains: Molecules,
    clock: Clock,
) -> Scene<B, Bonded<S>> {
    let bond = start::BondLength::new(&spring, 1.0).unwrap();
    let mut rng = start::stream(clock.now().seed);
    let positions = start::chains(space.lattice(), &chains, |rng| bond.sample(rng), &mut rng);
    Scene::new(space, positions, spring, chains, clock)
}

impl<B: Boundary, S: BondForce> Scene<B, Bonded<S>> {
    pub fn new(
        space: B,
        positions: Vec<DVec3>,
        spring: S,
        chains: Molecules,
        clock: Clock,
    ) -> Self {
        Self {
            system: System::new(space, Particles::new(positions).unwrap(), clock),
            chains,
            field: Bonded::new(spring, chains.bonds()),
            stepper: Scheme::new(FreeDraining::new(FRICTION).unwrap(), Diagonal),
        }
    }

    /// More than springs.
    pub fn with<X>(self, rest: X) -> Scene<B, (Bonded<S>, X)> {
        Scene {
            system: self.system,
            chains: self.chains,
            field: (self.field, rest),
            stepper: self.stepper,
        }
    }
}

impl<B: Boundary, F: ForceField<B>> Scene<B, F>
where
    Scheme: Stepper<B, F>,
{
    /// Goes on; isolated chains are brought back from where an extension carries them.
    pub fn run<T: Tally>(&mut self, steps: u64, tally: &mut T) {
        for _ in 0..steps {
            let (system, field) = (&mut self.system, &mut self.field);
            self.stepper.step(system, field, tally).unwrap();
            let now = system.clock.now();
            if system.boundary.cell().is_none() && now.step.is_multiple_of(8) {
                recentre(system, &self.chains).unwrap();
            }
        }
    }

    /// Goes on and looks at the last step.
    pub fn look(&mut self, steps: u64) -> Seen {
        self.run(steps - 1, &mut ());
        let mut virial = Virial::default();
        self.run(1, &mut virial);
        let (frame, molecules) = (self.system.frame(), self.chains);
        let kramers = ChainStress { molecules }.measure(&frame, &virial).unwrap();
        let friction = |_| FRICTION;
        let mut giesekus = GiesekusStress {
            molecules,
            friction,
        };
        let giesekus = giesekus.measure(&frame, &()).unwrap();
        let ends = EndToEnd { molecules }.measure(&frame, &()).unwrap();
        let radii = SquaredRadius { molecules }.measure(&frame, &()).unwrap();
        let each = 1.0 / f64::from(molecules.count());
        let outer = |r: &DVec3| DMat3::from_cols(r.x * *r, r.y * *r, r.z * *r);
        Seen {
            kramers,
            giesekus,
            ends: each * ends.iter().fold(DMat3::ZERO, |sum, r| sum + outer(r)),
            fourth: each * ends.iter().map(|r| r.length_squared().powi(2)).sum::<f64>(),
            gyration: each * radii.iter().sum::<f64>(),
        }
    }
}

/// What groups of chains with noise of their own show at these steps: group by group, step by step. A group may be
/// several scenes, such as one in flow and its twin at rest.
fn watch<B, F, const T: usize, const K: usize>(
    groups: u64,
    steps: &[u64],
    scenes: impl Fn(u64) -> [Scene<B, F>; T] + Sync + Send,
    numbers: impl Fn([Seen; T]) -> [f64; K] + Sync + Send,
) -> Vec<Vec<[f64; K]>>
where
    B: Boundary,
    F: ForceField<B>,
    Scheme: Stepper<B, F>,
{
    let group = |group| {
        let (mut scenes, mut now) = (scenes(group), 0);
        let look = |&step: &u64| {
            let seen = std::array::from_fn(|k| scenes[k].look(step - now));
            now = step;
            numbers(seen)
        };
        Ok::<_, String>(steps.iter().map(look).collect())
    };
    replicas(groups, group).unwrap()
}

fn means<'a, const K: usize>(groups: impl Iterator<Item = (u64, &'a [[f64; K]])>) -> [Mean; K] {
    let mut averages: [EnsembleAverage; K] = std::array::from_fn(|_| EnsembleAverage::new());
    for (group, samples) in groups {
        for sample in samples {
            for (average, x) in averages.iter_mut().zip(sample) {
                average.push((group, *x));
            }
        }
    }
    averages.map(|average| average.estimate().unwrap())
}

/// Means over groups at each of these steps; the scatter of groups is the error.
pub fn curve<B, F, const T: usize, const K: usize>(
    groups: u64,
    steps: &[u64],
    scenes: impl Fn(u64) -> [Scene<B, F>; T] + Sync + Send,
    numbers: impl Fn([Seen; T]) -> [f64; K] + Sync + Send,
) -> Vec<[Mean; K]>
where
    B: Boundary,
    F: ForceField<B>,
    Scheme: Stepper<B, F>,
{
    let found = watch(groups, steps, scenes, numbers);
    let at = |k: usize| {
        means(
            (0..)
                .zip(&found)
                .map(|(g, samples)| (g, &samples[k..k + 1])),
        )
    };
    (0..steps.len()).map(at).collect()
}

/// Means over groups and over a stretch of time: `before` steps unseen, then `count` looks `between` steps apart.
pub fn averages<B, F, const T: usize, const K: usize>(
    groups: u64,
    [before, count, between]: [u64; 3],
    scenes: impl Fn(u64) -> [Scene<B, F>; T] + Sync + Send,
    numbers: impl Fn([Seen; T]) -> [f64; K] + Sync + Send,
) -> [Mean; K]
where
    B: Boundary,
    F: ForceField<B>,
    Scheme: Stepper<B, F>,
{
    let steps: Vec<u64> = (1..=count).map(|k| before + k * between).collect();
    let found = watch(groups, &steps, scenes, numbers);
    means((0..).zip(&found).map(|(g, samples)| (g, &samples[..])))
}

/// The mean is the expected value, itself known to an error of one sigma, within four sigma of both and what a time
/// step may do; all this is less than `detectable`, in parts of the scale.
pub fn assert_near(
    what: &str,
    found: Mean,
    (expected, error): (f64, f64),
    scale: f64,
    detectable: f64,
) {
    let sigma = found.standard_error().unwrap().hypot(error);
    let bound = 4.0 * sigma + STEP_ERROR * scale;
    let off = found.value - expected;
    println!(
        "{what}: {found:#}, expected {expected:.6}, off {:+.1} sigma or {:+.2} %, detectable {:.1} %",
        off / sigma,
        100.0 * off / scale,
        100.0 * bound / scale
    );
    assert!(off.abs() < bound, "{what}: {found}, not {expected}");
    assert!(
        bound < detectable * scale,
        "{what}: {found}, an error of {bound} would not be seen"
    );
}

/// The same for what is known exactly and is its own scale.
pub fn assert_mean(what: &str, found: Mean, exact: f64, detectable: f64) {
    assert_near(what, found, (exact, 0.0), exact.abs(), detectable);
}

/// The velocity gradient of u = (e x + g y, -e y, 0).
pub fn planar(e: f64, g: f64) -> DMat3 {
    DMat3::from_cols(DVec3::new(e, 0.0, 0.0), DVec3::new(g, -e, 0.0), DVec3::ZERO)
}

/// Hounkonnou's viscosity of that flow.
pub fn viscosity(e: f64, g: f64, stress: DMat3) -> f64 {
    let extension = 2.0 * e * first_difference(stress);
    (extension + 2.0 * g * stress.y_axis.x) / (8.0 * e * e + 2.0 * g * g)
}

pub fn first_difference(stress: DMat3) -> f64 {
    stress.x_axis.x - stress.y_axis.y
}

/// A line of a table, by the names in its first line.
pub struct Line<'a> {
    names: &'a str,
    cells: &'a str,
}

impl<'a> Line<'a> {
    pub fn word(&self, name: &str) -> &'a str {
        let column = self.names.split(',').position(|n| n == name).unwrap();
        self.cells.split(',').nth(column).unwrap()
    }

    pub fn number(&self, name: &str) -> f64 {
        self.word(name).parse().unwrap()
    }

    pub fn numbers<const K: usize>(&self, names: [&str; K]) -> [f64; K] {
        names.map(|name| self.number(name))
    }
}

pub fn table(csv: &str) -> impl Iterator<Item = Line<'_>> {
    let (names, lines) = csv.split_once('\n').unwrap();
    lines.lines().map(move |cells| Line { names, cells })
}
