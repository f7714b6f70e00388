//! FENE dumbbells of extensibility b = 50 in the fluid of Lowe and Andersen (Clarke, PhD thesis, MIT 2008, chapter 4:
//! density 4, a = 18.75, dt = 0.01; 0.02 for long dumbbells), at rest, in shear and in planar extension, against dilute dumbbells without
//! hydrodynamic interactions and without excluded volume.
//!
//! Two things make these dumbbells differ from those, both the less the longer they are, and the bounds leave room for
//! both. Beads repel each other, which at rest lengthens dumbbells of Q_0 = 5, 10 and 20 by 4.5, 0.6 and 0.1 %. And the
//! solvent that one bead drags along carries the other: h* = 0.13, 0.064 and 0.032 for these, and the slowest motion of a
//! dumbbell is slower by 1 / (1 - sqrt(2) h*) with averaged interactions: by 22, 10 and 5 %. The drag that dumbbells show
//! in a flow is above that of a bead alone by so much at most, and by less the farther it stretches them.
//!
//! The tension of a dumbbell is that of its spring. What else acts between its beads on average is not their repulsion but
//! the mean force, kT d ln g / dr, in which the push of the solvent from outside all but cancels it. It is left out: at rest
//! it makes 3 kT of the spring's <Q . F> = 3.14, 3.02 and 3.00 for these lengths, and it changes the viscosity at small
//! rates by less than 0.2 %. To take the bare repulsion off in its place would leave 1.84, 2.79 and 2.97.
#![allow(clippy::unwrap_used)]

mod scene;

use scene::{fluid, pairs, run};
use std::f64::consts::FRAC_PI_2;
use std::sync::LazyLock;
use zimm::prelude::*;

const B: f64 = 50.0;
const DENSITY: f64 = 4.0;
const A: f64 = 18.75;

fn forces() -> Pairwise<DpdConservative, VerletList> {
    pairs(DpdConservative::new(A, 1.0).unwrap())
}

fn bath(gamma: f64) -> LoweAndersen<VerletList> {
    LoweAndersen::new(gamma, 1.0, VerletList::new(0.35).unwrap()).unwrap()
}

/// Groups of dumbbells whose scatter is the error: dumbbells are nearly independent of each other, and a run is only some
/// ten of their relaxation times long.
const GROUPS: u32 = 32;

fn trace(m: &DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// Dumbbells in a fluid, how fast the bath redraws, and how long to look at them.
#[derive(Clone, Copy, Debug)]
struct Solution {
    limit: f64,
    gamma: f64,
    /// The share of beads that belong to dumbbells.
    share: f64,
    dt: f64,
    /// Unseen, then seen.
    times: [f64; 2],
    seed: u64,
}

/// What the dumbbells show.
#[derive(Clone, Copy, Debug)]
struct Shown {
    solution: Solution,
    gradient: DMat3,
    /// <QF> over kT: the sum, the shear component, and the difference of xx and yy.
    tension: [Mean; 3],
    /// <Q^2> over Q_0^2.
    square: Mean,
    /// Kramers against Giesekus; none at rest.
    drag: Option<Drag>,
    /// The stress of the solution: xy, and the difference of xx and yy.
    stress: [Mean; 2],
    temperature: Mean,
}

impl Solution {
    fn spring(&self) -> Fene {
        Fene::with_extensibility(B, self.limit, 1.0).unwrap()
    }

    /// Starts with springs in equilibrium, lets the fluid find its structure in the flow, and looks ten times in a unit
    /// of time.
    fn go<S: Periodic>(self, space: S) -> Shown {
        let spring = self.spring();
        let clock = Clock::new(self.dt, 1.0, self.seed).unwrap();
        let (lattice, reach) = (*space.lattice(), space.reach());
        let beads = (DENSITY * lattice.volume()).round();
        let molecules = Molecules::linear(0, (0.5 * self.share * beads) as u32, 2).unwrap();
        let mut rng = start::stream(self.seed);
        let bond = start::BondLength::new(&spring, 1.0).unwrap();
        let length = |rng: &mut _| bond.sample(rng).min(0.9 * reach);
        let mut positions = start::chains(&lattice, &molecules, length, &mut rng);
        let solvent = beads as usize - positions.len();
        positions.extend(start::uniform(&lattice, solvent, &mut rng));
        let particles = Particles::new(positions).unwrap();
        let velocities = start::velocities(&particles, 1.0, &mut rng).unwrap();
        let particles = particles.with_velocities(velocities).unwrap();
        let mut system = System::new(space, particles, clock);
        let mut field = (forces(), Bonded::new(spring, molecules.bonds()));
        let mut stepper = bath(self.gamma);
        let [unseen, looks] = [self.times[0] / self.dt, 10.0 * self.times[1]].map(f64::round);
        run(&mut stepper, &mut system, &mut field, unseen as u32);

        let gradient = system.boundary.gradient();
        let mut drag = GiesekusDrag::new(gradient, 1.0).ok();
        let mut ends = EndToEnd { molecules };
        let mut seen: [EnsembleAverage; 4] = Default::default();
        let mut heard: [BlockAverage; 3] = Default::default();
        let per_group = molecules.count().div_ceil(GROUPS) as usize;
        let between = (0.1 / self.dt).round() as u32;
        for _ in 0..looks as u32 {
            run(&mut stepper, &mut system, &mut field, between - 1);
            let mut virial = Virial::default();
            stepper.step(&mut system, &mut field, &mut virial).unwrap();
            let frame = system.frame();
            let connectors = ends.measure(&frame, &()).unwrap();
            let (mut qf, mut qq) = (DMat3::ZERO, DMat3::ZERO);
            for (group, connectors) in (0..).zip(connectors.chunks(per_group)) {
                let [mut tension, mut stretch] = [DMat3::ZERO; 2];
                for &q in connectors {
                    let outer = DMat3::from_cols(q.x * q, q.y * q, q.z * q);
                    tension -= outer * spring.force(q.length_squared());
                    stretch += outer;
                }
                qf += tension * (1.0 / f64::from(molecules.count()));
                qq += stretch * (1.0 / f64::from(molecules.count()));
                let tension = tension * (1.0 / connectors.len() as f64);
                let stretch = stretch * (1.0 / connectors.len() as f64);
                let sample = [
                    trace(&tension),
                    tension.y_axis.x,
                    tension.x_axis.x - tension.y_axis.y,
                    trace(&stretch) / self.limit.powi(2),
                ];
                for (average, x) in seen.iter_mut().zip(sample) {
                    average.push((group, x));
                }
            }
            if let Some(drag) = &mut drag {
                drag.push([qf, qq]);
            }
            let stress = Stress.measure(&frame, &virial);
            let [shear, normal] = [stress.shear(), stress.normal_differences()[0]];
            let kinetic = KineticTemperature::default().measure(&frame, &());
            let sample = [shear, normal, kinetic.unwrap().mean()];
            for (mean, x) in heard.iter_mut().zip(sample) {
                mean.push(x);
            }
        }
        let [sum, xy, difference, square] = seen.map(|average| average.estimate().unwrap());
        let [shear, normal, temperature] = heard.map(|mean| mean.estimate().unwrap());
        let shown = Shown {
            solution: self,
            gradient,
            tension: [sum, xy, difference],
            square,
            drag: drag.and_then(|drag| drag.estimate().ok()),
            stress: [shear, normal],
            temperature,
        };
        println!(
            "{self:?}, {} dumbbells\n  T {temperature:#}, <Q^2>/Q_0^2 {square:#}, <Q.F> {sum:#}, <QF>_xy {xy:#}, \
             <QF>_xx-yy {difference:#}, stress {shear:#} {normal:#}",
            molecules.count()
        );
        if let Some(drag) = shown.drag {
            println!(
                "  drag {:#}, by the trace {:#}, De {}",
                drag.deformation,
                drag.trace,
                shown.deborah()
            );
        }
        shown
    }

    /// In shear, in a cube of this edge.
    fn sheared(self, edge: f64, rate: f64) -> Shown {
        self.go(LeesEdwards::new(DVec3::splat(edge), Steady::new(rate).unwrap()).unwrap())
    }

    /// In planar extension, in the smallest cell whose images stay twice the limit apart.
    fn extended(self, rate: f64) -> Shown {
        self.extended_up_to(self.limit, rate)
    }

    /// The same, in a cell for dumbbells no longer than this.
    fn extended_up_to(self, longest: f64, rate: f64) -> Shown {
        self.go(KraynikReinelt::box_for_cutoff(longest, Steady::new(rate).unwrap()).unwrap())
    }
}

impl Shown {
    /// The rate of shear, or of extension.
    fn rate(&self) -> f64 {
        self.gradient.y_axis.x.max(self.gradient.x_axis.x)
    }

    fn drag(&self) -> Mean {
        self.drag.unwrap().deformation
    }

    /// lambda_H, with the drag that these dumbbells show.
    fn time(&self) -> f64 {
        self.drag().value / (4.0 * self.solution.spring().stiffness())
    }

    fn deborah(&self) -> f64 {
        self.time() * self.rate()
    }

    /// The shear stress of the solvent, of viscosity 6.63 at a rate of redrawing of 10, and of so many dumbbells.
    fn sum_of_parts(&self) -> f64 {
        let dumbbells = 0.5 * DENSITY * self.solution.share;
        let sum = 6.63 * self.rate() + dumbbells * self.tension[1].value;
        println!(
            "  stress of the solution {:#}, of its parts {sum:.3}",
            self.stress[0]
        );
        sum
    }

    /// Viscosity of the dumbbells over n kT lambda_H, Psi_1 over n kT lambda_H^2, <Q^2> over Q_0^2.
    fn in_shear(&self) -> [Mean; 3] {
        let de = self.deborah();
        let [_, xy, difference] = self.tension;
        [
            xy.times(1.0 / de),
            difference.times(de.powi(-2)),
            self.square,
        ]
    }

    /// eta_1 over n kT lambda_H, <Q^2> over Q_0^2.
    fn in_extension(&self) -> [Mean; 2] {
        [self.tension[2].times(1.0 / self.deborah()), self.square]
    }
}

/// De, viscosity, Psi_1, <Q^2> / Q_0^2 of dilute dumbbells of b = 50 in shear: from a Fokker-Planck equation to De = 10,
/// from Brownian dynamics at 30.
const SHEAR: [[f64; 4]; 10] = [
    [0.01, 0.909086, 1.594876, 0.054548],
    [0.1, 0.908594, 1.592822, 0.054801],
    [0.3, 0.904690, 1.576621, 0.056806],
    [0.5, 0.897254, 1.546132, 0.060640],
    [1.0, 0.867474, 1.428647, 0.076186],
    [2.0, 0.790527, 1.154911, 0.117667],
    [3.0, 0.718335, 0.931668, 0.158242],
    [5.0, 0.607907, 0.644687, 0.223443],
    [10.0, 0.452078, 0.338962, 0.322592],
    [30.0, 0.2539, 0.0987, 0.4654],
];

/// Between the entries: the cubic through the four next ones, of logarithms against log(1 + De^2).
fn theory_in_shear(de: f64) -> [f64; 3] {
    let x = |de: f64| (de * de).ln_1p();
    let above = SHEAR.partition_point(|row| row[0] < de);
    let first = above.saturating_sub(2).min(SHEAR.len() - 4);
    let rows = &SHEAR[first..first + 4];
    let mut sums = [0.0; 3];
    for row in rows {
        let others = rows.iter().filter(|other| other[0] != row[0]);
        let weight: f64 = others
            .map(|other| (x(de) - x(other[0])) / (x(row[0]) - x(other[0])))
            .product();
        for (sum, value) in sums.iter_mut().zip(&row[1..]) {
            *sum += weight * value.ln();
        }
    }
    sums.map(f64::exp)
}

/// eta_1 and <Q^2> / Q_0^2 in planar extension, by quadrature of (1 - Q^2 / b)^(b/2) exp(De (x^2 - y^2)).
fn theory_in_extension(de: f64) -> [f64; 2] {
    const N: u32 = 60;
    let middle = |k: u32, n: u32| (f64::from(k) + 0.5) / f64::from(n);
    let mut sums = [0.0; 3];
    for k in 0..4 * N {
        let share = middle(k, 4 * N).powi(2);
        for m in 0..N {
            let across = 1.0 - middle(m, N).powi(2);
            for n in 0..N {
                let difference = across * (2.0 * FRAC_PI_2 * middle(n, N)).cos();
                let exponent = 0.5 * B * (1.0 - share).ln() + de * B * (share * difference - 1.0);
                let weight = share * exponent.exp();
                let tension = B * share * difference / (1.0 - share);
                for (sum, value) in sums.iter_mut().zip([1.0, tension, share]) {
                    *sum += weight * value;
                }
            }
        }
    }
    [sums[1] / sums[0] / de, sums[2] / sums[0]]
}

/// Prints what was found against what was expected, and answers by what part it is off.
fn off<const N: usize>(what: [&str; N], found: [Mean; N], expected: [f64; N]) -> [f64; N] {
    std::array::from_fn(|k| {
        let off = found[k].value / expected[k] - 1.0;
        println!(
            "  {}: {:#}, expected {:.4}, off by {:+.1} %",
            what[k],
            found[k],
            expected[k],
            100.0 * off
        );
        off
    })
}

fn off_in_shear(shown: &Shown) -> [f64; 3] {
    let expected = theory_in_shear(shown.deborah());
    off(["eta", "Psi_1", "stretch"], shown.in_shear(), expected)
}

fn off_in_extension(shown: &Shown) -> [f64; 2] {
    let expected = theory_in_extension(shown.deborah());
    off(["eta_1", "stretch"], shown.in_extension(), expected)
}

/// The quadrature and the interpolation that the tests go by.
#[test]
fn reference_theory_of_dilute_dumbbells() {
    for [de, eta, psi1, stretch] in SHEAR {
        for (found, exact) in theory_in_shear(de).into_iter().zip([eta, psi1, stretch]) {
            assert!((found / exact - 1.0).abs() < 1e-12);
        }
    }
    for (de, eta, stretch) in [
        (0.1, 3.74301, 0.055592),
        (0.5, 8.65682, 0.103803),
        (1.0, 45.6058, 0.466321),
    ] {
        let [found, square] = theory_in_extension(de);
        assert!((found / eta - 1.0).abs() < 2e-3, "{found}");
        assert!((square / stretch - 1.0).abs() < 2e-3, "{square}");
    }
}

/// By what part repulsion lengthens dumbbells of Q_0 = 5 at rest; viscosity and Psi_1 at small rates grow as much.
const AT_REST: f64 = 0.045;

/// Dumbbells of Q_0 = 5 in a small cell.
const SHORT: Solution = Solution {
    limit: 5.0,
    gamma: 10.0,
    share: 0.25,
    dt: 0.01,
    times: [10.0, 40.0],
    seed: 1,
};

/// In shear at De = 1.2, for all that ask.
static SHEARED: LazyLock<Shown> = LazyLock::new(|| SHORT.sheared(10.5, 0.4));

/// The diffusion coefficient of beads in the fluid without dumbbells, in a cell of edge 6.
fn diffusion(gamma: f64, time: f64) -> Mean {
    let clock = Clock::new(0.01, 1.0, 8).unwrap();
    let mut system = fluid(PeriodicBox::cubic(6.0).unwrap(), DENSITY, clock);
    let (mut field, mut stepper) = (forces(), bath(gamma));
    run(&mut stepper, &mut system, &mut field, 1000);
    let mut diffusion = MeanSquareDisplacement::new(0.8, 3..=10).unwrap();
    for _ in 0..(time / 0.8) as u32 {
        run(&mut stepper, &mut system, &mut field, 80);
        diffusion.push(Unwrapped.measure(&system.frame(), &()).unwrap());
    }
    diffusion.estimate().unwrap().coefficient
}

/// The viscosity of the fluid as published for these rates of redrawing, by kinetic theory at 5, and the Schmidt number and
/// the drag of a bead that come of it and of diffusion.
fn schmidt_number_and_drag(gamma: f64, time: f64) -> [Mean; 2] {
    let (eta, error) = match gamma {
        5.0 => (3.35, 0.1),
        10.0 => (6.6, 0.2),
        40.0 => (28.6, 0.6),
        _ => (63.7, 0.8),
    };
    let (uncertainty, found) = (0.1 * error, diffusion(gamma, time));
    let error = StandardError::Plateau { error, uncertainty };
    let viscosity = Mean { value: eta, error };
    let drag = einstein_drag(1.0, 1, found, viscosity, 6.0).unwrap();
    let schmidt = schmidt_number(viscosity, DENSITY, found).unwrap();
    println!("rate of redrawing {gamma}: D {found:#}, Sc {schmidt:#}, drag of a bead {drag:#}");
    [schmidt, drag]
}

/// At rest <Q^2> / Q_0^2 = 0.05698 and <Q . F> = 3.14 by quadrature of g(Q) Q^2 (1 - Q^2 / Q_0^2)^25 with g of the fluid;
/// 0.05455 and 3 without repulsion.
///
/// Seed 1, 512 dumbbells, 60 time units, 22 relaxation times: standard errors 0.0004 (0.7 %) and 0.03, bounds 4 of them.
/// Beads that do not repel each other, 4.3 and 4.4 % less, are caught by each.
#[test]
fn reference_dumbbells_at_rest() {
    let shown = Solution {
        gamma: 5.0,
        share: 0.5,
        times: [10.0, 60.0],
        ..SHORT
    }
    .go(PeriodicBox::cubic(8.0).unwrap());
    assert!((shown.square.value - 0.05698).abs() < 0.0016);
    assert!((shown.tension[0].value - 3.137).abs() < 0.12);
    assert!(shown.square.at_least() < 0.0005);
}

/// Against dilute dumbbells at the De that their drag makes, with lambda_H = zeta / 4H, and as much longer as they are at
/// rest.
///
/// Seed 1, 578 dumbbells, 40 time units, 14 relaxation times: standard errors 3 % of the viscosity and of Psi_1, 1.4 % of
/// the stretch. Bounds are 4 of them and 3 % for the flow's share: a mistake of 15 and 8.5 % is caught here, of 8 and 7 %
/// by the longer runs below.
#[test]
fn reference_short_dumbbells_in_shear() {
    let [eta, psi1, stretch] = off_in_shear(&SHEARED);
    assert!((eta - AT_REST).abs() < 0.15);
    assert!((psi1 - AT_REST).abs() < 0.15);
    assert!((stretch - AT_REST).abs() < 0.085);
    assert!((SHEARED.temperature.value - 1.0).abs() < 0.012);
}

/// The drag of a bead from diffusion is some 20 at a rate of redrawing of 10. What dumbbells of Q_0 = 5 show in shear is
/// larger by their hydrodynamic interactions, 22 % if those are averaged at rest, less in a flow that stretches them.
///
/// Standard errors: 1.5 % of the drag from diffusion (seed 8, 40 time units of 864 beads), 2 % of that from stress, 2.5 % of
/// the ratio. Found: 21.1, 23.6 and 1.12. Bounds: 15 % to what is published, and a ratio between those of no interaction
/// and of averaged ones at rest, 1 and 1.22, and 3 errors beyond. A factor of 4/3 or 3/4 in either is caught.
#[test]
fn reference_drag_by_two_routes() {
    let [schmidt, bead] = schmidt_number_and_drag(10.0, 40.0);
    assert!((bead.value / 20.0 - 1.0).abs() < 0.15, "{bead}");
    assert!((schmidt.value / 36.0 - 1.0).abs() < 0.12, "{schmidt}");
    let ratio = SHEARED.drag().value / bead.value;
    println!("drag in shear over drag of a bead: {ratio:.3}");
    assert!(ratio > 0.93 && ratio < 1.3);
}

/// Beads that are pulled one way by F, while all others share the opposite, drift at F D / kT, with D of the same cell and N
/// / (N - 1) for that none of them is among its own others: the mobility of one bead, however many are pulled.
///
/// Seed 8, a fifth of 864 beads pulled by 2 for 120 time units: the drift has a standard error of 2.5 %, D after 80 one of
/// 1.5 %. Bound: 4 of both, 12 %: a force that is not balanced by the others is caught, and a balance of another share. (If half of the beads are pulled, they fall in plumes, and scatter by twice as much as they
/// diffuse.)
#[test]
fn law_pulled_beads_drift_as_they_diffuse() {
    const FORCE: f64 = 2.0;
    const TIME: f64 = 120.0;
    let diffusion = diffusion(10.0, 80.0);
    let clock = Clock::new(0.01, 1.0, 8).unwrap();
    let mut system = fluid(PeriodicBox::cubic(6.0).unwrap(), DENSITY, clock);
    let beads = system.particles.len() as u32;
    let pulled = 0..beads / 5;
    let mut field = (
        forces(),
        Pulled::new(FORCE * DVec3::X, pulled.clone()).unwrap(),
    );
    let mut stepper = bath(10.0);
    run(&mut stepper, &mut system, &mut field, 500);
    let places = |system: &System<PeriodicBox>| Unwrapped.measure(&system.frame(), &()).unwrap();
    let before = places(&system);
    run(&mut stepper, &mut system, &mut field, (TIME / 0.01) as u32);
    let moved = places(&system).into_iter().zip(before);
    let moved: Vec<f64> = moved.map(|(to, from)| to.x - from.x).collect();
    let all = moved.iter().sum::<f64>() / f64::from(beads);
    let mut drift = EnsembleAverage::new();
    for bead in pulled {
        drift.push((u64::from(bead), (moved[bead as usize] - all) / TIME));
    }
    let drift = drift.estimate().unwrap();
    let expected = FORCE * diffusion.value * f64::from(beads) / f64::from(beads - 1);
    println!("drift {drift:#}, expected {expected:.4} of D = {diffusion:#}");
    assert!(drift.at_least() < 0.03 * expected);
    assert!((drift.value / expected - 1.0).abs() < 0.12);
}

/// A bath that redraws twice as fast makes a fluid of four times the Schmidt number, 37 and 150, and twice the drag: at the
/// same De the same rheology.
///
/// Seed 1, 578 dumbbells, 40 time units: standard errors of the differences 5 % of viscosity and Psi_1, 2.5 % of the
/// stretch, 3 % of the drag. Bounds are 4 of them.
#[test]
fn reference_schmidt_number_does_not_show() {
    let slower = Solution {
        gamma: 20.0,
        times: [15.0, 40.0],
        ..SHORT
    }
    .sheared(10.5, 0.2);
    assert!((slower.drag().value / SHEARED.drag().value / 2.0 - 1.0).abs() < 0.12);
    let (slower, faster) = (off_in_shear(&slower), off_in_shear(&SHEARED));
    for ((a, b), bound) in slower.into_iter().zip(faster).zip([0.2, 0.2, 0.1]) {
        assert!((a - b).abs() < bound, "{a} {b}");
    }
}

/// Planar extension at De = 0.35, against the exact distribution of dilute dumbbells.
///
/// Seed 1, 559 dumbbells, 30 time units: standard errors 4 % of eta_1, 1.5 % of the stretch. Bounds are 4 of them about
/// what repulsion does at rest.
#[test]
fn reference_short_dumbbells_in_extension() {
    let shown = Solution {
        times: [15.0, 30.0],
        ..SHORT
    }
    .extended(0.12);
    let [eta, stretch] = off_in_extension(&shown);
    assert!((eta - AT_REST).abs() < 0.16);
    assert!((stretch - AT_REST).abs() < 0.06);
}

/// With half of all beads in dumbbells in place of a quarter, each dumbbell does the same, and the solution has the stress
/// of its solvent, 6.6 at this rate of redrawing, and that of so many dumbbells.
///
/// Seed 1, 1157 dumbbells, 25 time units: standard errors of the differences 4 % of the tension and 2 % of the stretch; of
/// the stress of the solution 2.5 %. Bounds are 4 of them. Dumbbells counted once too often or too little, or a half of
/// them, make 14 % of the stress.
#[test]
fn reference_stress_is_linear_in_the_concentration() {
    let dense = Solution {
        share: 0.5,
        times: [10.0, 25.0],
        ..SHORT
    }
    .sheared(10.5, 0.4);
    for shown in [dense, *SHEARED] {
        assert!((shown.stress[0].value / shown.sum_of_parts() - 1.0).abs() < 0.1);
    }
    let ratio = |a: Mean, b: Mean| a.value / b.value - 1.0;
    assert!(ratio(dense.tension[1], SHEARED.tension[1]).abs() < 0.16);
    assert!(ratio(dense.square, SHEARED.square).abs() < 0.08);
}

/// Schmidt numbers of 37, 660 and 2600, drags of a bead of 20, 86 and 160: at De of 1.1 to 1.2 the same rheology, and the
/// same drag in units of a bead's.
///
/// Seed 2, 578 dumbbells, 23 to 34 relaxation times each: standard errors 2.3 % of the viscosity and of Psi_1, 1.1 % of the
/// stretch, 2 % of the drag. Found: 2, 3 and 2, 9, 6 and 9, and 6, 5 and 5 % above dilute dumbbells without repulsion; the
/// drag 1.09, 1.12 and 1.10 of that of a bead. Bounds are 4 errors about what repulsion does at rest, and 3.5 % for the flow's share
/// in Psi_1. A time that scales otherwise than with the drag by 10 % is caught by Psi_1, which goes as its square.
#[test]
#[ignore = "five minutes; cargo test -p zimm-tests --test dpd_dumbbells -- --ignored --nocapture schmidt"]
fn reference_schmidt_numbers_do_not_show() {
    for (gamma, rate, times) in [
        (10.0, 0.4, [10.0, 100.0]),
        (40.0, 0.093, [35.0, 300.0]),
        (80.0, 0.051, [60.0, 500.0]),
    ] {
        let [_, bead] = schmidt_number_and_drag(gamma, 160.0);
        let shown = Solution {
            gamma,
            times,
            seed: 2,
            ..SHORT
        }
        .sheared(10.5, rate);
        let ratio = shown.drag().value / bead.value;
        println!("  drag over that of a bead {ratio:.3}");
        assert!(ratio > 1.0 && ratio < 1.3);
        let [eta, psi1, stretch] = off_in_shear(&shown);
        assert!((eta - AT_REST).abs() < 0.09);
        assert!((psi1 - AT_REST).abs() < 0.125);
        assert!((stretch - AT_REST).abs() < 0.045);
    }
}

/// The polymer's viscosity in planar extension is four times that in shear at small rates; at De = 0.18 in one and 0.61 in
/// the other dilute dumbbells have 4.49. Found: 4.63. Dumbbells of De = 0.19 and 0.53 are stretched by 5 and 7 % more than
/// dilute ones without repulsion, and have 4 and 8 % more of eta_1.
///
/// Seed 3, 559 and 578 dumbbells. At De = 0.18, 69 relaxation times: standard errors 2.6 % of eta_1, 0.7 % of the stretch,
/// 3.5 % of the ratio, for which no drag is needed. At De = 0.54, 20 relaxation times: 2.3 and 1.4 %. Bounds are 4 of them
/// about what repulsion does at rest.
#[test]
#[ignore = "two minutes; cargo test -p zimm-tests --test dpd_dumbbells -- --ignored --nocapture trouton"]
fn reference_trouton_ratio() {
    let extended = |rate, times| {
        let seed = 3;
        let shown = Solution {
            times,
            seed,
            ..SHORT
        }
        .extended(rate);
        (shown, off_in_extension(&shown))
    };
    let (slow, [eta, stretch]) = extended(0.06, [15.0, 200.0]);
    assert!((eta - AT_REST).abs() < 0.105);
    assert!((stretch - AT_REST).abs() < 0.03);
    let (_, [eta, stretch]) = extended(0.18, [25.0, 60.0]);
    assert!((eta - AT_REST).abs() < 0.09);
    assert!((stretch - AT_REST).abs() < 0.06);

    let sheared = Solution {
        times: [10.0, 150.0],
        seed: 3,
        ..SHORT
    }
    .sheared(10.5, 0.2);
    off_in_shear(&sheared);
    let ratio = slow.tension[2].value / slow.rate() / (sheared.tension[1].value / sheared.rate());
    let [expected, _] = theory_in_extension(slow.deborah());
    let [viscosity, ..] = theory_in_shear(sheared.deborah());
    let expected = expected / viscosity;
    println!("Trouton ratio {ratio:.3}, expected {expected:.3}");
    assert!((ratio / expected - 1.0).abs() < 0.14);
}

/// Dumbbells drawn out to two thirds of their limit, De = 1: short ones stretch less than dilute ones without
/// hydrodynamic interactions at the same De. Beads far apart do not carry each other, so that long dumbbells feel less drag
/// than short ones do. A rate of redrawing of 40 holds the temperature to 0.4 %; one of 10 lets the work of the flow heat
/// the fluid by 8 %.
///
/// Seed 3, 559 dumbbells, 12 relaxation times after 15, which dilute ones take to be within 1 % of where they end: standard
/// errors 0.8 % of eta_1, 0.5 % of the stretch. Found: 7.4 and 6.2 % less, where those of Q_0 = 10 below have 4.2 and 3.7 %.
/// The bounds are 12 and 10 %, what is published (10 %) within the errors, and that there is less at all, by more than
/// three.
#[test]
#[ignore = "two minutes; cargo test -p zimm-tests --test dpd_dumbbells -- --ignored --nocapture drawn"]
fn reference_short_dumbbells_drawn_out() {
    let shown = Solution {
        gamma: 40.0,
        times: [180.0, 140.0],
        seed: 3,
        ..SHORT
    }
    .extended(0.0875);
    let [eta, stretch] = off_in_extension(&shown);
    assert!(eta > -0.12 && eta < -0.03, "{eta}");
    assert!(stretch > -0.1 && stretch < -0.03, "{stretch}");
    assert!((shown.temperature.value - 1.0).abs() < 0.006);
}

/// The same with a twentieth and with half of all beads in dumbbells.
///
/// Seed 7, 115 and 1157 dumbbells, 26 and 5 relaxation times: standard errors 4 and 3 % of the tension, 1.8 and 1.3 % of
/// the stretch, 1.5 % of the stress of the solution. Bounds are 4 of them.
#[test]
#[ignore = "one minute; cargo test -p zimm-tests --test dpd_dumbbells -- --ignored --nocapture concentrations"]
fn reference_stress_is_linear_in_many_concentrations() {
    let [dilute, dense] = [(0.05, [15.0, 150.0]), (0.5, [10.0, 30.0])].map(|(share, times)| {
        let shown = Solution {
            share,
            times,
            seed: 7,
            ..SHORT
        }
        .sheared(10.5, 0.4);
        off_in_shear(&shown);
        let sum = shown.sum_of_parts();
        assert!((shown.stress[0].value / sum - 1.0).abs() < 0.06);
        shown
    });
    let ratio = |a: Mean, b: Mean| a.value / b.value - 1.0;
    assert!(ratio(dense.tension[1], dilute.tension[1]).abs() < 0.17);
    assert!(ratio(dense.square, dilute.square).abs() < 0.09);
}

/// Dumbbells of Q_0 = 10 at De = 1.06 are nearer to dilute ones than those of Q_0 = 5.
///
/// Seed 4, 2544 dumbbells, 16 relaxation times after 5: standard errors 1.1 % of the viscosity, 1.4 % of Psi_1, 0.6 % of the
/// stretch. Found: 2.7, 1.8 and 2.1 % more, where those of Q_0 = 5 above have on average 3.6(13), 8.0(15) and 5.3(6) % more,
/// and repulsion at rest explains 0.6 %. In a tenth of the concentration, 12 000 dumbbell times, they have 0.8(20), 0.5(20)
/// and 0.7(9) % more, and 4(2) % less drag. Bounds are 4 errors about 1.6 %, half of the way between: the share of
/// Q_0 = 5 is caught in Psi_1 and the stretch.
#[test]
#[ignore = "two minutes; cargo test -p zimm-tests --test dpd_dumbbells -- --ignored --nocapture twice"]
fn reference_dumbbells_twice_as_long_are_nearer_to_theory() {
    let shown = Solution {
        limit: 10.0,
        gamma: 5.0,
        dt: 0.02,
        times: [30.0, 100.0],
        seed: 4,
        ..SHORT
    }
    .sheared(17.2, 0.167);
    let [eta, psi1, stretch] = off_in_shear(&shown);
    assert!((eta - 0.016).abs() < 0.044);
    assert!((psi1 - 0.016).abs() < 0.056);
    assert!((stretch - 0.016).abs() < 0.024);
}

/// Dumbbells of Q_0 = 5 where they thin, De = 2.7: the drag is less than at De = 1, 84 in place of 94 at a rate of redrawing
/// of 40, as beads are farther apart, and nears that of a bead, 86.
///
/// Seed 4, 578 dumbbells, 56 relaxation times: standard errors 1.2 % of the viscosity and of Psi_1, 0.7 % of the stretch,
/// 0.9 % of the drag. Found: -2.3, 11.1 and 6.3 % more than dilute dumbbells without hydrodynamic interactions, whose width
/// and stretch one drag makes. Repulsion, which is 4.5 % at rest, and interactions that fade as beads part, 7 % in a strong
/// extension below, pull the viscosity either way: bounds are these and 4 errors. Those of Psi_1 and the stretch are 4
/// errors about what repulsion does at rest, and 5 % for the flow's share in Psi_1.
#[test]
#[ignore = "three minutes; cargo test -p zimm-tests --test dpd_dumbbells -- --ignored --nocapture thinning"]
fn reference_short_dumbbells_thinning() {
    let shown = Solution {
        gamma: 40.0,
        times: [30.0, 600.0],
        seed: 4,
        ..SHORT
    }
    .sheared(10.5, 0.26);
    let [eta, psi1, stretch] = off_in_shear(&shown);
    assert!(eta > -0.07 - 0.05 && eta < AT_REST + 0.05);
    assert!((psi1 - AT_REST).abs() < 0.1);
    assert!((stretch - AT_REST).abs() < 0.05);
    assert!((shown.drag().value / 86.0 - 1.0).abs() < 0.08);
}

/// Dumbbells of Q_0 = 20 are dilute ones in shear at De = 1: repulsion at rest explains 0.1 %. Averaged hydrodynamic
/// interactions make their drag up to 5 % larger than that of a bead, and the many that lie across each other in a fourth
/// of all beads another 4 %, by what Q_0 = 10 loses in drag where there are a tenth as many.
///
/// Seed 5, 17968 dumbbells, 0.7 relaxation times after 5, by when dilute ones are within 1 % of where they end: standard
/// errors 1.4 % of the viscosity, of Psi_1 and of the drag, 0.6 % of the stretch. Found: +0.2, -0.5 and -0.3 %, and a drag of 1.11 of that
/// of a bead. Bounds are 4 errors, and 1 %. Some dumbbells reach 0.75 of their limit, which takes a cell of 1.65 limits.
#[test]
#[ignore = "ten minutes; cargo test -p zimm-tests --test dpd_dumbbells -- --ignored --nocapture long_dumbbells"]
fn reference_long_dumbbells_in_shear() {
    let [_, bead] = schmidt_number_and_drag(5.0, 160.0);
    let shown = Solution {
        limit: 20.0,
        gamma: 5.0,
        dt: 0.02,
        times: [110.0, 15.0],
        seed: 5,
        ..SHORT
    }
    .sheared(33.0, 0.044);
    let ratio = shown.drag().value / bead.value;
    println!("  drag over that of a bead {ratio:.3}");
    assert!((ratio - 1.045).abs() < 0.1);
    let [eta, psi1, stretch] = off_in_shear(&shown);
    assert!(eta.abs() < 0.066);
    assert!(psi1.abs() < 0.066);
    assert!(stretch.abs() < 0.034);
}

/// The same in extension at De = 0.3, in a cell for springs of 0.8 of the limit, which none of them reaches there.
///
/// Seed 7, 18 000 dumbbells, 0.9 relaxation times after 10, by when dilute ones are within 1 % of where they end.
/// Standard errors: 1.4 % of eta_1, 0.6 % of the stretch. Found: 0.8 and 0.4 % more than dilute ones, where those of
/// Q_0 = 5 have 4 to 8 %. Bounds are 4 errors.
#[test]
#[ignore = "20 minutes; cargo test -p zimm-tests --test dpd_dumbbells -- --ignored --nocapture long_dumbbells"]
fn reference_long_dumbbells_in_extension() {
    let shown = Solution {
        limit: 20.0,
        gamma: 5.0,
        dt: 0.02,
        times: [240.0, 20.0],
        seed: 7,
        ..SHORT
    }
    .extended_up_to(16.0, 0.014);
    let [eta, stretch] = off_in_extension(&shown);
    assert!(eta.abs() < 0.06);
    assert!(stretch.abs() < 0.03);
}

/// Dumbbells of Q_0 = 10 where they thin, De = 3, are nearer to dilute ones than those of Q_0 = 5 above, whose viscosity,
/// Psi_1 and stretch are 0, 11 and 7 % larger.
///
/// Seed 6, 3707 dumbbells, 2.6 relaxation times after 3, by when dilute ones are within 2 % of where they end: standard
/// errors 1.8 % of the viscosity, 1.4 % of Psi_1, 0.9 % of the stretch. Found: 1.2, 4.4 and 3.4 % more; half of what
/// Q_0 = 5 has would be 0, 5 and 3 %. Bounds are 4 errors about a third of it: all of it is caught.
#[test]
#[ignore = "one minute; cargo test -p zimm-tests --test dpd_dumbbells -- --ignored --nocapture middling"]
fn reference_middling_dumbbells_thinning() {
    let shown = Solution {
        limit: 10.0,
        gamma: 20.0,
        dt: 0.02,
        times: [70.0, 60.0],
        seed: 6,
        ..SHORT
    }
    .sheared(19.5, 0.13);
    let [eta, psi1, stretch] = off_in_shear(&shown);
    assert!(eta.abs() < 0.075);
    assert!((psi1 - 0.037).abs() < 0.056);
    assert!((stretch - 0.023).abs() < 0.036);
    assert!((shown.temperature.value - 1.0).abs() < 0.006);
}

/// Dumbbells of Q_0 = 10 in extension at De = 0.32, where those of Q_0 = 5 have 4 to 5 % more than dilute ones.
///
/// Seed 7, 4472 dumbbells, 5 relaxation times after 10: standard errors 1.9 % of eta_1, 0.7 % of the stretch. Found: 0.2 and
/// 1.0 % more. Bounds are 4 errors about what repulsion does at rest, 0.6 %: the share of Q_0 = 5 is caught in the stretch.
#[test]
#[ignore = "one minute; cargo test -p zimm-tests --test dpd_dumbbells -- --ignored --nocapture middling"]
fn reference_middling_dumbbells_in_extension() {
    let shown = Solution {
        limit: 10.0,
        gamma: 5.0,
        dt: 0.02,
        times: [60.0, 30.0],
        seed: 7,
        ..SHORT
    }
    .extended(0.052);
    let [eta, stretch] = off_in_extension(&shown);
    assert!((eta - 0.006).abs() < 0.08);
    assert!((stretch - 0.006).abs() < 0.03);
}

/// Dumbbells of Q_0 = 10 drawn out, De = 1. A twentieth of all beads, or the work of the flow heats the fluid.
///
/// Seed 7, 894 dumbbells, 3.5 relaxation times after 14, which dilute ones take to be within 1 % of where they end: standard
/// errors 1.2 % of eta_1, 0.7 % of the stretch. Found: 4.2 and 3.7 % less. Bounds are 4 errors about half of what those of
/// Q_0 = 5 lack, 3.4 and 2.9 %: that what they lack falls as 1 / Q_0. Dumbbells of Q_0 = 20 at De = 1.16 have 1.1(6) and 1.0(2) %
/// less, but in a fluid that redraws at a rate of 5 and is 11 % hot; at rates that keep it cold they take hours.
#[test]
#[ignore = "four minutes; cargo test -p zimm-tests --test dpd_dumbbells -- --ignored --nocapture drawn"]
fn reference_middling_dumbbells_drawn_out() {
    let shown = Solution {
        limit: 10.0,
        gamma: 10.0,
        share: 0.05,
        dt: 0.02,
        times: [160.0, 40.0],
        seed: 7,
    }
    .extended(0.085);
    let [eta, stretch] = off_in_extension(&shown);
    assert!((eta + 0.034).abs() < 0.05);
    assert!((stretch + 0.029).abs() < 0.03);
    assert!((shown.temperature.value - 1.0).abs() < 0.01);
}
