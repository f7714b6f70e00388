//! The semi-implicit scheme: exact linear theory, exact distributions of FENE dumbbells at rest and in extension, and
//! everything that breaks an explicit step. Units are l_H and zeta / 4H: kt = 1, stiffness 1, friction 4.
#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

use zimm_boundary::{KraynikReinelt, OpenFlow, PeriodicBox, Steady, StepStrain};
use zimm_brownian::{Diagonal, FreeDraining, Lanczos, Mobility, SemiImplicit, White};
use zimm_core::{
    BondForce, Bonded, Boundary, Clock, DMat3, DVec3, ForceError, ForceField, Frame, MobilityError,
    Molecules, Open, Particles, Reads, StepError, Stepper, System, Tally,
    noise::{Domain, Noise},
};
use zimm_forces::{Fene, Fraenkel, Hooke, MarkoSiggia};

type Free = SemiImplicit<FreeDraining, Diagonal>;

fn scheme() -> Free {
    SemiImplicit::new(FreeDraining::new(4.0).unwrap(), Diagonal)
}

fn fene(b: f64) -> Fene {
    Fene::with_extensibility(b, b.sqrt(), 1.0).unwrap()
}

fn shear(rate: f64) -> DMat3 {
    DMat3::from_cols(DVec3::ZERO, rate * DVec3::X, DVec3::ZERO)
}

fn planar(rate: f64) -> DMat3 {
    DMat3::from_diagonal(DVec3::new(rate, -rate, 0.0))
}

/// Normal numbers for initial states.
fn normal(identity: u32) -> DVec3 {
    Noise::new(99, 0).site(identity).normal3(Domain::user(1))
}

/// Molecules whose bonds all have one length and random directions, each molecule from the origin.
fn coiled(molecules: &Molecules, length: f64) -> Vec<DVec3> {
    let mut positions = Vec::new();
    for beads in molecules.iter() {
        let first = positions.len();
        for (number, identity) in beads.enumerate() {
            let parent = molecules.parent(number as u32);
            let step = length * normal(identity).normalize();
            let from = parent.map(|parent| positions[first + parent as usize] + step);
            positions.push(from.unwrap_or(DVec3::ZERO));
        }
    }
    positions
}

/// Molecules stretched along x.
fn stretched(molecules: &Molecules, length: f64) -> Vec<DVec3> {
    let beads = molecules
        .iter()
        .flat_map(|beads| beads.enumerate())
        .map(|(number, _)| number as f64 * length * DVec3::X);
    beads.collect()
}

fn system<B: Boundary>(
    boundary: B,
    positions: Vec<DVec3>,
    dt: f64,
    kt: f64,
    seed: u64,
) -> System<B> {
    let clock = Clock::new(dt, kt, seed).unwrap();
    System::new(boundary, Particles::new(positions).unwrap(), clock)
}

/// The mean of a quantity of each molecule over a run, and its standard error from molecule to molecule.
fn mean_and_error(samples: &[f64]) -> (f64, f64) {
    let n = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / n;
    let variance = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// Means and errors of Q^2 and of Q F of dumbbells, over `steps` after a relaxation of `relax`.
fn dumbbells<B: Boundary, S: BondForce>(
    system: &mut System<B>,
    springs: &mut Bonded<S>,
    relax: usize,
    steps: usize,
) -> [(f64, f64); 2] {
    let mut stepper = scheme();
    let count = springs.bonds().len();
    let mut sums = [vec![0.0; count], vec![0.0; count]];
    for step in 0..relax + steps {
        stepper.step(system, springs, &mut ()).unwrap();
        if system.boundary.cell().is_none() {
            let molecules = Molecules::linear(0, count as u32, 2).unwrap();
            zimm_core::recentre(system, &molecules).unwrap();
        }
        if step < relax {
            continue;
        }
        let (r, forces) = (system.particles.positions(), system.particles.forces());
        for (k, &[i, j]) in springs.bonds().iter().enumerate() {
            let [i, j] = [i as usize, j as usize];
            let bond = system.boundary.min_image(r[i] - r[j]);
            sums[0][k] += bond.length_squared() / steps as f64;
            sums[1][k] -= bond.dot(forces[i]) / steps as f64;
        }
    }
    sums.map(|sums| mean_and_error(&sums))
}

fn assert_near(what: &str, found: (f64, f64), exact: f64, bias: f64) {
    let (mean, error) = found;
    let off = (mean - exact).abs();
    assert!(
        off < 4.0 * error + bias * exact,
        "{what}: {mean} +- {error}, not {exact}"
    );
    assert!(error < 0.005 * exact, "{what}: error {error} of {exact}");
}

// --- Linear springs: the whole scheme in closed form, no statistics ---

/// Q' = A Q + N (z_1 - z_2) for the bond of a Hookean dumbbell: A and N from steps without noise and with.
fn linear_step(gradient: DMat3, dt: f64) -> (DMat3, DMat3) {
    let mut springs = Bonded::new(Hooke::new(1.0).unwrap(), vec![[0, 1]]);
    let mut step = |bond: DVec3, kt: f64, seed: u64| {
        let flow = OpenFlow::new(gradient).unwrap();
        let mut system = system(flow, vec![bond, DVec3::ZERO], dt, kt, seed);
        let white = White::new(system.clock.next(), &system.frame());
        let drawn = white.bead(0) - white.bead(1);
        scheme().step(&mut system, &mut springs, &mut ()).unwrap();
        let r = system.particles.positions();
        (r[0] - r[1], drawn)
    };
    let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| step(axis, 0.0, 0).0);
    let a = DMat3::from_cols(columns[0], columns[1], columns[2]);
    let noisy = [1, 2, 3].map(|seed| step(DVec3::ZERO, 1.0, seed));
    let [found, drawn] = [noisy.map(|(found, _)| found), noisy.map(|(_, drawn)| drawn)]
        .map(|c| DMat3::from_cols(c[0], c[1], c[2]));
    (a, found * drawn.inverse())
}

/// The covariance that the scheme keeps: C = A C A^T + 2 N N^T, summed by doubling.
fn stationary(gradient: DMat3, dt: f64) -> DMat3 {
    let (mut a, n) = linear_step(gradient, dt);
    let mut c = n * n.transpose() * 2.0;
    for _ in 0..40 {
        c += a * c * a.transpose();
        a *= a;
    }
    c
}

#[test]
fn law_linear_springs_at_rest_have_their_exact_variance_at_any_step() {
    for dt in [0.001, 0.3, 2.0, 50.0, 1000.0] {
        let error = stationary(DMat3::ZERO, dt) - DMat3::IDENTITY;
        let largest = error
            .to_cols_array()
            .iter()
            .fold(0.0_f64, |m, e| m.max(e.abs()));
        assert!(largest < 1e-9, "dt {dt}: {largest:e}");
    }
}

/// With z = dt / 2 the mode decays by (1 - z/2) / (1 + z/2), as the trapezoidal rule has it.
#[test]
fn limit_the_decay_of_a_linear_spring() {
    for dt in [0.01, 1.0, 100.0] {
        let (a, n) = linear_step(DMat3::ZERO, dt);
        let (z, noise) = (0.5 * dt, (0.5 * dt).sqrt());
        let exact = (1.0 - 0.5 * z) / (1.0 + 0.5 * z);
        assert!((a.x_axis.x - exact).abs() < 1e-12);
        assert!((n.x_axis.x * (1.0 + 0.5 * z) / noise - 1.0).abs() < 1e-9);
    }
}

/// Steady shear and mixed flow of Hookean dumbbells: the exact moments (stress time 1) with an error that is a quarter
/// at half the step.
#[test]
fn law_moments_in_flow_are_of_second_order() {
    for (eps, gam) in [
        (0.0_f64, 1.0),
        (0.0, 4.0),
        (0.2, 0.0),
        (0.2, 1.0),
        (-0.2, 0.3),
    ] {
        let gradient = DMat3::from_cols(eps * DVec3::X, DVec3::new(gam, -eps, 0.0), DVec3::ZERO);
        let yy = 1.0 / (1.0 + 2.0 * eps);
        let xy = gam * yy;
        let xx = (1.0 + 2.0 * gam * xy) / (1.0 - 2.0 * eps);
        let errors = [0.2, 0.1, 0.05].map(|dt| {
            let c = stationary(gradient, dt);
            [
                c.x_axis.x - xx,
                c.x_axis.y - xy,
                c.y_axis.y - yy,
                c.z_axis.z - 1.0,
            ]
        });
        for (k, coarse) in errors[0].iter().enumerate() {
            let (fine, finer) = (errors[1][k], errors[2][k]);
            assert!(
                fine.abs() < 4e-3 * xx,
                "eps {eps}, gam {gam}, moment {k}: {fine}"
            );
            if finer.abs() > 1e-8 {
                assert!((coarse / fine - 4.0).abs() < 0.8, "{coarse} to {fine}");
                assert!((fine / finer - 4.0).abs() < 0.4, "{fine} to {finer}");
            }
        }
    }
}

// 500 Rouse chains of ten beads, seed 3, from an exact equilibrium, 40 steps of 20 times the unit of time, which is
// half of the longest relaxation time and 40 times the shortest: <Q^2> = 3 and <R^2> = 27, exactly. Errors from chain
// to chain, 0.2 to 0.5 %; bound 4 sigma. Backward Euler would make <Q^2> = 0.4.
#[test]
fn limit_rouse_chains_at_steps_beyond_all_times() {
    let molecules = Molecules::linear(0, 500, 10).unwrap();
    let mut positions = Vec::new();
    for beads in molecules.iter() {
        let mut r = DVec3::ZERO;
        for bead in beads {
            positions.push(r);
            r += normal(bead);
        }
    }
    let mut system = system(Open, positions, 20.0, 1.0, 3);
    let mut springs = Bonded::new(Hooke::new(1.0).unwrap(), molecules.bonds());
    let mut stepper = scheme();
    let (mut bonds, mut ends) = (vec![0.0; 500], vec![0.0; 500]);
    for _ in 0..40 {
        stepper.step(&mut system, &mut springs, &mut ()).unwrap();
        let chains = system.particles.positions().chunks(10);
        for (k, r) in chains.enumerate() {
            bonds[k] += r
                .windows(2)
                .map(|r| (r[1] - r[0]).length_squared())
                .sum::<f64>()
                / 360.0;
            ends[k] += (r[9] - r[0]).length_squared() / 40.0;
        }
    }
    let bonds = mean_and_error(&bonds);
    assert_near("bonds", bonds, 3.0, 0.0);
    let (mean, error) = mean_and_error(&ends);
    assert!(
        (mean - 27.0).abs() < 4.0 * error && error < 0.6,
        "ends: {mean} +- {error}"
    );
}

// --- FENE dumbbells against their exact distributions ---

// 1000 dumbbells, seed 11. <Q^2> = 3 b / (b + 5) is met to 0.6 % at these steps (bias measured with 4e6 samples: 0.6 %
// at b = 10, below 0.2 % else); <Q F> = 3 at any step, which is a law of the scheme. Errors 0.1 to 0.3 %, bound 4 sigma
// and the bias: an error of 2 % is found.
#[test]
fn reference_fene_dumbbells_at_rest() {
    for (b, dt, bias) in [
        (10.0, 0.2, 0.003),
        (10.0, 0.5, 0.008),
        (50.0, 1.0, 0.002),
        (1000.0, 2.0, 0.001),
    ] {
        let molecules = Molecules::linear(0, 1000, 2).unwrap();
        let mut springs = Bonded::new(fene(b), molecules.bonds());
        let mut system = system(Open, coiled(&molecules, 1.5), dt, 1.0, 11);
        let relax = (10.0 / dt) as usize;
        let [q2, qf] = dumbbells(&mut system, &mut springs, relax, 1000);
        assert_near(&format!("b {b}: <Q^2>"), q2, 3.0 * b / (b + 5.0), bias);
        assert_near(&format!("b {b}: <QF>"), qf, 3.0, 0.0);
    }
}

// The virial theorem is a law of the trapezoidal rule: with y = Q + dt Q F / 4 the step is y' = 2 Q - y + noise, and
// <y'^2> = <y^2>. 1000 dumbbells, seed 12, at steps of up to 100 relaxation times: <Q F> = 3 within 4 sigma of 0.2 to
// 0.4 %. Half of the force left out would make 2 or less.
#[test]
fn law_the_virial_is_exact_at_any_step() {
    let molecules = Molecules::linear(0, 1000, 2).unwrap();
    let worm = MarkoSiggia::new(1.0, 3.0).unwrap();
    for dt in [0.3, 3.0, 30.0] {
        let mut springs = Bonded::new(worm, molecules.bonds());
        let mut positions = system(Open, coiled(&molecules, 1.0), dt, 1.0, 12);
        let [_, qf] = dumbbells(&mut positions, &mut springs, 200, 1500);
        assert_near(&format!("worm-like chain, dt {dt}"), qf, 3.0, 0.0);
        let mut springs = Bonded::new(fene(4.0), molecules.bonds());
        let mut positions = system(Open, coiled(&molecules, 1.0), dt, 1.0, 13);
        let [_, qf] = dumbbells(&mut positions, &mut springs, 200, 1500);
        assert_near(&format!("FENE, dt {dt}"), qf, 3.0, 0.0);
    }
}

// Exact stationary moments by quadrature, psi ~ (1 - Q^2 / b)^(b/2) exp(Q kappa Q), where <Q F> = 3 + 2 <Q kappa Q>.
// 1000 dumbbells, seed 21. Errors 0.01 to 0.4 %, bound 4 sigma and the bias of the step, measured with 4e6 samples to
// be below 0.4 %: an error of 2 % is found. The steps are long, rate dt is 0.1 to 2.
#[test]
fn reference_fene_dumbbells_in_extension() {
    let axial = |rate: f64| DMat3::from_diagonal(rate * DVec3::new(1.0, -0.5, -0.5));
    // b, gradient, dt, start, <Q^2>, <Q F>
    let cases = [
        (50.0, planar(0.3), 0.3, 0.2, 3.300_474_911, 3.735_553_451),
        (50.0, planar(1.0), 0.5, 0.7, 23.316_028_085, 47.593_199_328),
        (
            50.0,
            planar(10.0),
            0.2,
            0.9,
            47.397_243_788,
            948.943_286_473,
        ),
        (10.0, planar(1.0), 0.2, 0.5, 3.751_171_712, 8.427_817_771),
        (10.0, planar(10.0), 0.1, 0.9, 9.396_725_686, 188.926_355_743),
        (50.0, axial(1.0), 0.2, 0.7, 23.320_223_626, 47.606_674_645),
        (10.0, axial(-1.0), 0.2, 0.5, 2.738_330_715, 4.895_632_856),
    ];
    for (b, gradient, dt, start, q2_exact, qf_exact) in cases {
        let molecules = Molecules::linear(0, 1000, 2).unwrap();
        let mut springs = Bonded::new(fene(b), molecules.bonds());
        let positions = stretched(&molecules, start * f64::sqrt(b));
        let flow = OpenFlow::new(gradient).unwrap();
        let mut system = system(flow, positions, dt, 1.0, 21);
        let relax = (20.0 / dt) as usize;
        let [q2, qf] = dumbbells(&mut system, &mut springs, relax, 1500);
        let what = format!("b {b}, {} dt {dt}", gradient.x_axis.x);
        assert_near(&format!("{what}: <Q^2>"), q2, q2_exact, 0.004);
        assert_near(&format!("{what}: <Q F>"), qf, qf_exact, 0.004);
    }
}

// 400 dumbbells wrapped into a Kraynik-Reinelt cell of edge 20, seed 31, over 100 units of time or 104 strain periods,
// against the same distribution. Bonds are found by the nearest image, across every change of basis.
#[test]
fn reference_many_dumbbells_in_a_kraynik_reinelt_cell() {
    let molecules = Molecules::linear(0, 400, 2).unwrap();
    let mut positions = stretched(&molecules, 4.0);
    for (bead, r) in positions.iter_mut().enumerate() {
        *r += 10.0 * normal(bead as u32 / 2);
    }
    let space = KraynikReinelt::new(20.0, 20.0, Steady::new(1.0).unwrap()).unwrap();
    let mut springs = Bonded::new(fene(50.0), molecules.bonds());
    let mut system = system(space, positions, 0.1, 1.0, 31);
    let [q2, qf] = dumbbells(&mut system, &mut springs, 200, 1000);
    assert_near("<Q^2>", q2, 23.316_028_085, 0.002);
    assert_near("<Q F>", qf, 47.593_199_328, 0.002);
}

// --- Nonlinear springs and other forces: the order without noise ---

/// A bowl that pulls every bead to the origin.
struct Bowl(f64);

impl<B: Boundary> ForceField<B> for Bowl {
    const READS: Reads = Reads::NOTHING;
    const CONSERVES_MOMENTUM: bool = false;

    fn accumulate<T: Tally>(
        &mut self,
        frame: &Frame<'_, B>,
        forces: &mut [DVec3],
        _: &mut T,
    ) -> Result<(), ForceError> {
        for (force, r) in forces.iter_mut().zip(frame.positions) {
            *force -= self.0 * *r * (1.0 + r.length_squared());
        }
        Ok(())
    }
}

fn trimer_at_start() -> Vec<DVec3> {
    vec![DVec3::ZERO, 2.5 * DVec3::X, DVec3::new(2.0, -2.6, 0.3)]
}

/// Where a FENE trimer is after one unit of time in mixed flow and a bowl, without noise.
fn trimer(dt: f64, mobility: impl Mobility<OpenFlow>) -> Vec<DVec3> {
    let flow = OpenFlow::new(planar(0.5) + shear(0.8)).unwrap();
    let mut system = system(flow, trimer_at_start(), dt, 0.0, 1);
    let mut field = (Bonded::new(fene(9.0), vec![[0, 1], [1, 2]]), Bowl(0.3));
    let mut stepper = SemiImplicit::new(mobility, ());
    for _ in 0..(1.0 / dt).round() as usize {
        stepper.step(&mut system, &mut field, &mut ()).unwrap();
    }
    system.particles.positions().to_vec()
}

fn assert_second_order(what: &str, found: impl Fn(f64) -> Vec<DVec3>) {
    let exact = found(1.0 / 4096.0);
    let error = |dt| {
        let found = found(dt);
        let squares = found
            .iter()
            .zip(&exact)
            .map(|(a, b)| (*a - *b).length_squared());
        squares.sum::<f64>().sqrt()
    };
    let [coarse, fine] = [1.0 / 64.0, 1.0 / 128.0].map(error);
    assert!(
        (coarse / fine - 4.0).abs() < 0.2,
        "{what}: {coarse} to {fine}"
    );
    assert!(fine < 1e-3, "{what}: {fine}");
}

#[test]
fn law_second_order_with_springs_flow_and_another_force() {
    let alone = || FreeDraining::new(4.0).unwrap();
    assert_second_order("alone", |dt| trimer(dt, alone()));
    // Touching beads, whose mobility stays what it is in the beginning.
    let frozen = || {
        Frozen(Dense {
            positions: trimer_at_start(),
            ..dense(1.2)
        })
    };
    assert_second_order("together", |dt| trimer(dt, frozen()));
}

#[test]
fn law_a_balance_of_flow_and_springs_is_a_fixed_point_at_any_step() {
    for (rate, dt) in [(1.0, 1.0), (1e3, 0.1), (1e5, 1e-3)] {
        // eps Q = Q / (2 (1 - Q^2 / b)).
        let length = f64::sqrt(50.0 * (1.0 - 0.5 / rate));
        let positions = vec![0.5 * length * DVec3::X, -0.5 * length * DVec3::X];
        let flow = OpenFlow::new(planar(rate)).unwrap();
        let mut system = system(flow, positions, dt, 0.0, 1);
        let mut springs = Bonded::new(fene(50.0), vec![[0, 1]]);
        let mut stepper = scheme();
        for _ in 0..5 {
            stepper.step(&mut system, &mut springs, &mut ()).unwrap();
        }
        let r = system.particles.positions();
        let error = ((r[0] - r[1]).length() - length).abs() / (50.0_f64.sqrt() - length);
        assert!(
            error < 1e-6,
            "rate {rate}: {error:e} of the distance to the limit"
        );
    }
}

/// The tension in the middle of a chain is many times that of a dumbbell, and must not be taken for an accident. The
/// chain finds its balance in steps of 1, and keeps it in steps of up to 20 strains.
#[test]
fn law_a_chain_in_balance_stays_there_at_any_step() {
    let molecules = Molecules::linear(0, 1, 20).unwrap();
    let mut springs = (Bonded::new(fene(50.0), molecules.bonds()), ());
    for rate in [0.02, 1.0] {
        let flow = OpenFlow::new(planar(rate)).unwrap();
        let start = stretched(&molecules, 5.0);
        let mut balanced = system(flow, start, 0.5 / rate, 0.0, 1);
        zimm_core::recentre(&mut balanced, &molecules).unwrap();
        let mut stepper = scheme();
        for _ in 0..2000 {
            stepper.step(&mut balanced, &mut springs, &mut ()).unwrap();
            zimm_core::recentre(&mut balanced, &molecules).unwrap();
        }
        let found = balanced.particles.positions().to_vec();
        for dt in [0.01, 1.0, 10.0, 20.0].map(|strain| strain / rate) {
            let mut system = system(flow, found.clone(), dt, 0.0, 1);
            for _ in 0..3 {
                stepper.step(&mut system, &mut springs, &mut ()).unwrap();
                zimm_core::recentre(&mut system, &molecules).unwrap();
            }
            let pairs = found.iter().zip(system.particles.positions());
            let moved = pairs.fold(0.0_f64, |most, (a, b)| most.max((*a - *b).length()));
            assert!(moved < 1e-4, "rate {rate}, dt {dt}: moved by {moved}");
        }
    }
}

#[test]
fn limit_a_step_strain_stretches_at_once() {
    let step = StepStrain::new(1.5, 0.0).unwrap();
    let flow = OpenFlow::with_history(shear(1.0), step).unwrap();
    let mut system = system(flow, vec![DVec3::ZERO, DVec3::Y], 1e-6, 0.0, 1);
    let mut springs = Bonded::new(Hooke::new(1.0).unwrap(), vec![[0, 1]]);
    scheme().step(&mut system, &mut springs, &mut ()).unwrap();
    let r = system.particles.positions();
    assert!((r[1] - r[0] - DVec3::new(1.5, 1.0, 0.0)).length() < 2e-6);
}

// --- Hydrodynamic interactions ---

/// Rotne, Prager and Yamakawa's mobility in open space as a full matrix.
struct Dense {
    friction: f64,
    radius: f64,
    positions: Vec<DVec3>,
}

impl Dense {
    fn block(&self, i: usize, j: usize) -> DMat3 {
        let d = self.positions[i] - self.positions[j];
        let (r, a) = (d.length(), self.radius);
        if i == j {
            return DMat3::IDENTITY * (1.0 / self.friction);
        }
        let n = d / r;
        let outer = DMat3::from_cols(n.x * n, n.y * n, n.z * n);
        let (even, along) = if r >= 2.0 * a {
            let s = a * a / (r * r);
            (
                0.75 * a / r * (1.0 + 2.0 * s / 3.0),
                0.75 * a / r * (1.0 - 2.0 * s),
            )
        } else {
            (1.0 - 9.0 * r / (32.0 * a), 3.0 * r / (32.0 * a))
        };
        (DMat3::IDENTITY * even + outer * along) * (1.0 / self.friction)
    }
}

impl<B: Boundary> Mobility<B> for Dense {
    fn bind(&mut self, frame: &Frame<'_, B>) -> Result<(), MobilityError> {
        self.positions = frame.positions.to_vec();
        Ok(())
    }

    fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        for (i, u) in velocities.iter_mut().enumerate() {
            *u += (0..forces.len())
                .map(|j| self.block(i, j) * forces[j])
                .sum::<DVec3>();
        }
    }

    fn alone(&self, _: usize) -> f64 {
        1.0 / self.friction
    }
}

fn dense(radius: f64) -> Dense {
    Dense {
        friction: 4.0,
        radius,
        positions: Vec::new(),
    }
}

/// The same wherever beads are.
struct Frozen(Dense);

impl<B: Boundary> Mobility<B> for Frozen {
    fn bind(&mut self, _: &Frame<'_, B>) -> Result<(), MobilityError> {
        Ok(())
    }

    fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        Mobility::<B>::apply(&mut self.0, forces, velocities);
    }

    fn alone(&self, place: usize) -> f64 {
        Mobility::<B>::alone(&self.0, place)
    }
}

/// r' = r + (dt / 2) M (F(r) + F(r')) for ten touching beads, at steps up to 100 relaxation times of a dumbbell, M the
/// mobility at the beginning.
#[test]
fn law_the_implicit_equations_hold_with_hydrodynamic_interactions() {
    let molecules = Molecules::linear(0, 1, 10).unwrap();
    let radius = 0.45;
    for dt in [0.01, 1.0, 100.0] {
        let positions = coiled(&molecules, 2.0 * radius);
        let mut system = system(Open, positions.clone(), dt, 1.0, 1);
        let mut springs = Bonded::new(fene(10.0), molecules.bonds());
        let mut before = vec![DVec3::ZERO; 10];
        springs
            .accumulate(&system.frame(), &mut before, &mut ())
            .unwrap();
        let mut matrix = dense(radius);
        matrix.bind(&system.frame()).unwrap();
        SemiImplicit::new(dense(radius), ())
            .step(&mut system, &mut springs, &mut ())
            .unwrap();
        let forces = before.iter().zip(system.particles.forces());
        let mean: Vec<DVec3> = forces.map(|(a, b)| 0.5 * dt * (*a + *b)).collect();
        let mut moved = vec![DVec3::ZERO; 10];
        Mobility::<Open>::apply(&mut matrix, &mean, &mut moved);
        for ((old, new), moved) in positions
            .iter()
            .zip(system.particles.positions())
            .zip(moved)
        {
            let error = (*new - *old - moved).length();
            assert!(error < 1e-6, "dt {dt}: {error:e}");
        }
    }
}

// Hydrodynamic interaction does not change equilibrium. Dumbbells in one open space would all interact, so each is a
// system of its own. b = 50, dt = 0.05, radius sqrt(pi) / 4, 60 runs of 400 steps, seeds 1 to 60: error 4 %, bound 4 sigma.
// A force that moved beads as if they were alone, with noise that does not, would be 30 % off.
#[test]
fn limit_equilibrium_with_hydrodynamic_interactions() {
    let mut samples = Vec::new();
    for seed in 1..=60 {
        let mut system = system(
            Open,
            vec![DVec3::ZERO, 1.6 * normal(seed).normalize()],
            0.05,
            1.0,
            seed.into(),
        );
        let mut springs = Bonded::new(fene(50.0), vec![[0, 1]]);
        let root = Lanczos::new(1e-6).unwrap();
        let mut stepper = SemiImplicit::new(dense(0.443), root);
        let mut sum = 0.0;
        for step in 0..500 {
            stepper.step(&mut system, &mut springs, &mut ()).unwrap();
            let r = system.particles.positions();
            sum += if step < 100 {
                0.0
            } else {
                (r[0] - r[1]).length_squared() / 400.0
            };
        }
        samples.push(sum);
    }
    let (mean, error) = mean_and_error(&samples);
    assert!(
        (mean - 150.0 / 55.0).abs() < 4.0 * error,
        "{mean} +- {error}"
    );
    assert!(error < 0.15, "{error}");
}

// --- Whatever breaks an explicit step ---

fn assert_sound<B: Boundary, S: BondForce>(what: &str, system: &System<B>, springs: &Bonded<S>) {
    let r = system.particles.positions();
    let limit = springs.spring().limit();
    for &[i, j] in springs.bonds() {
        let length = system
            .boundary
            .min_image(r[i as usize] - r[j as usize])
            .length();
        assert!(length < limit, "{what}: {length} of {limit}");
    }
    assert!(
        system.particles.forces().iter().all(|f| f.is_finite()),
        "{what}"
    );
}

#[test]
fn extreme_nothing_overstretches_whatever_rate_step_and_spring() {
    let kinds = [
        ("dumbbell", Molecules::linear(0, 3, 2).unwrap()),
        ("chain", Molecules::linear(0, 1, 12).unwrap()),
        ("ring", Molecules::ring(0, 1, 6).unwrap()),
        ("star", Molecules::star(0, 1, 3, 3).unwrap()),
    ];
    let mut steps = 0;
    for (kind, molecules) in kinds {
        for b in [1.1_f64, 10.0, 1e3, 1e6] {
            // Just below the limit (rings: folded, else beads would be pulled apart), coincident, or at rest.
            let folded = molecules.iter().flatten().map(|bead| f64::from(bead % 2));
            let tight: Vec<DVec3> = folded
                .map(|x| 0.999_999 * b.sqrt() * x * DVec3::X)
                .collect();
            let tight = if kind == "ring" {
                tight
            } else {
                coiled(&molecules, 0.999_999 * b.sqrt())
            };
            let starts = [tight, coiled(&molecules, 1e-200), coiled(&molecules, 0.1)];
            for start in starts {
                for gradient in [
                    DMat3::ZERO,
                    shear(1.0),
                    planar(1.0),
                    planar(-0.5) + shear(1.0),
                ] {
                    for rate in [1.0, 1e3, 1e5] {
                        for dt in [1e-5, 1e-2, 1.0, 200.0] {
                            // Centres in extension go as exp(rate dt), and bonds lose their digits to them.
                            if gradient.x_axis.x != 0.0 && rate * dt > 20.0 {
                                continue;
                            }
                            let what = format!("{kind}, b {b}, {gradient:?} times {rate}, dt {dt}");
                            let flow = OpenFlow::new(rate * gradient).unwrap();
                            let mut system = system(flow, start.clone(), dt, 1.0, 5);
                            let mut springs = Bonded::new(fene(b), molecules.bonds());
                            let mut stepper = scheme();
                            zimm_core::recentre(&mut system, &molecules).unwrap();
                            for _ in 0..4 {
                                if let Err(error) = stepper.step(&mut system, &mut springs, &mut ())
                                {
                                    panic!("{what}: {error}");
                                }
                                assert_sound(&what, &system, &springs);
                                zimm_core::recentre(&mut system, &molecules).unwrap();
                                steps += 1;
                            }
                        }
                    }
                }
            }
        }
    }
    assert!(steps > 4000);
}

#[test]
fn extreme_a_thousand_beads_at_a_hundred_relaxation_times() {
    let molecules = Molecules::linear(0, 1, 1000).unwrap();
    for (rate, dt) in [(0.0, 200.0), (1.0, 200.0), (1e5, 1e-2), (100.0, 1.0)] {
        let flow = OpenFlow::new(shear(rate)).unwrap();
        let mut springs = Bonded::new(fene(50.0), molecules.bonds());
        let start = coiled(&molecules, 0.999_999 * 50.0_f64.sqrt());
        let mut system = system(flow, start, dt, 1.0, 5);
        let mut stepper = scheme();
        for _ in 0..3 {
            stepper.step(&mut system, &mut springs, &mut ()).unwrap();
            assert_sound(&format!("rate {rate}, dt {dt}"), &system, &springs);
        }
    }
}

/// A spring at 0.999999 of its limit pulls 5e5 times harder than at rest. It falls back as it should, in one sweep:
/// (1 - u)^2 with u = Q^2 / b shrinks as dt, so after 100 steps of 0.01 some 22 of 50 are left; the trapezoidal rule
/// alone would throw it from side to side for hundreds of steps, at full stretch.
#[test]
fn extreme_a_spring_at_its_limit_falls_back() {
    let molecules = Molecules::linear(0, 200, 2).unwrap();
    let end = 0.999_999 * 50.0_f64.sqrt();
    let mut means = Vec::new();
    for dt in [0.01, 0.0005] {
        let mut springs = Bonded::new(fene(50.0), molecules.bonds());
        let mut system = system(Open, coiled(&molecules, end), dt, 1.0, 5);
        let mut stepper = scheme();
        for _ in 0..(1.0 / dt) as usize {
            stepper.step(&mut system, &mut springs, &mut ()).unwrap();
        }
        let r = system.particles.positions().chunks(2);
        means.push(r.map(|r| (r[0] - r[1]).length_squared()).sum::<f64>() / 200.0);
    }
    // Standard error of each 0.5; the two steps agree within four times that of the difference.
    assert!((means[0] - means[1]).abs() < 3.0, "{means:?}");
}

#[test]
fn extreme_rods_and_mixed_frictions() {
    let molecules = Molecules::linear(0, 50, 8).unwrap();
    let rods = Fraenkel::new(1e4, 1.0).unwrap();
    let mut springs = Bonded::new(rods, molecules.bonds());
    let positions = coiled(&molecules, 1.0);
    let species = (0..400).map(|bead| u8::from(bead % 3 == 0)).collect();
    let particles = Particles::new(positions)
        .unwrap()
        .with_species(species)
        .unwrap();
    let flow = OpenFlow::new(shear(5.0)).unwrap();
    let mut system = System::new(flow, particles, Clock::new(1e-3, 1.0, 3).unwrap());
    let friction = FreeDraining::new(4.0)
        .unwrap()
        .with_species(&[4.0, 400.0])
        .unwrap();
    let mut stepper = SemiImplicit::new(friction, Diagonal);
    let mut lengths = Vec::new();
    for _ in 0..200 {
        stepper.step(&mut system, &mut springs, &mut ()).unwrap();
        let r = system.particles.positions();
        let mean: f64 = springs
            .bonds()
            .iter()
            .map(|&[i, j]| (r[i as usize] - r[j as usize]).length() / 350.0)
            .sum();
        lengths.push(mean);
    }
    // The thermal width of a rod is 0.01, its mean length 1 + 2e-4.
    let mean = lengths[100..].iter().sum::<f64>() / 100.0;
    assert!((mean - 1.0).abs() < 5e-3, "{mean}");
}

#[test]
fn extreme_errors_leave_no_trace() {
    let start = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 2.0, 0.0)];
    let mut stepper = scheme();

    // Extension by exp(2e7).
    let flow = OpenFlow::new(planar(1e5)).unwrap();
    let mut far = system(flow, start.clone(), 200.0, 1.0, 1);
    let mut springs = Bonded::new(fene(50.0), vec![[0, 1], [1, 2]]);
    springs
        .accumulate(&far.frame(), &mut [DVec3::ZERO; 3], &mut ())
        .unwrap();
    let before = (far.particles.clone(), far.clock.now());
    let error = stepper.step(&mut far, &mut springs, &mut ()).unwrap_err();
    assert!(
        matches!(
            error,
            StepError::NotFinite { .. } | StepError::NotSolved { .. }
        ),
        "{error}"
    );
    assert_eq!((far.particles, far.clock.now()), before);

    // A bond longer than half of the cell: found at the new positions.
    let cell = PeriodicBox::cubic(6.0).unwrap();
    let mut tight = system(cell, start.clone(), 1.0, 100.0, 1);
    let before = tight.particles.clone();
    let mut error = None;
    for seed in 1..50 {
        tight.clock = Clock::new(1.0, 100.0, seed).unwrap();
        if let Err(found) = stepper.step(&mut tight, &mut springs, &mut ()) {
            error = Some(found);
            break;
        }
        tight.particles = before.clone();
    }
    let beyond = |error: &StepError| {
        matches!(
            error,
            StepError::Force {
                source: ForceError::BeyondCell { .. },
                ..
            }
        )
    };
    assert!(error.as_ref().is_some_and(beyond), "{error:?}");
    assert_eq!(tight.particles.positions(), before.positions());

    // A bond to nowhere, a ring around the cell, a dial beyond its range.
    let mut lost = Bonded::new(fene(50.0), vec![[0, 7]]);
    let error = stepper.step(&mut tight, &mut lost, &mut ()).unwrap_err();
    assert!(matches!(
        error,
        StepError::Force {
            source: ForceError::NoSuchParticle { identity: 7, .. },
            ..
        }
    ));
    let around: Vec<DVec3> = (0..3).map(|k| 2.0 * f64::from(k) * DVec3::X).collect();
    let mut wound = system(cell, around, 1e-3, 1.0, 1);
    let mut ring = Bonded::new(fene(50.0), vec![[0, 1], [1, 2], [2, 0]]);
    let error = stepper.step(&mut wound, &mut ring, &mut ()).unwrap_err();
    assert!(matches!(error, StepError::Parameter { .. }), "{error}");
    assert!(scheme().with_tolerance(0.1).is_err());
}

/// Places and identities in another order, images counted: the same trajectory, bit for bit.
#[test]
fn law_places_do_not_matter() {
    let molecules = Molecules::star(0, 20, 3, 4).unwrap();
    let cell = || PeriodicBox::cubic(60.0).unwrap();
    let run = |order: Option<Vec<u32>>| {
        let mut particles = Particles::new(coiled(&molecules, 2.0))
            .unwrap()
            .counting_images();
        if let Some(order) = order {
            particles.permute(&order).unwrap();
        }
        let mut system = System::new(cell(), particles, Clock::new(0.2, 1.0, 4).unwrap());
        let mut springs = Bonded::new(fene(20.0), molecules.bonds());
        let mut stepper = scheme();
        for _ in 0..50 {
            stepper.step(&mut system, &mut springs, &mut ()).unwrap();
        }
        let frame = system.frame();
        let places = (0..260).map(|identity| frame.place(identity).unwrap());
        let unwrapped = places.map(|place| frame.unwrapped(place).unwrap());
        unwrapped.collect::<Vec<DVec3>>()
    };
    let shuffled = (0..260).map(|k| k * 77 % 260).collect();
    let (here, there) = (run(None), run(Some(shuffled)));
    assert_eq!(here, there);
    // Molecules stay whole: all bonds are short when unwrapped.
    for [i, j] in molecules.bonds() {
        assert!((here[i as usize] - here[j as usize]).length() < 20.0_f64.sqrt());
    }
}

#[cfg(feature = "rayon")]
#[test]
fn law_the_same_bits_on_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let pairs = Molecules::linear(0, 2000, 2).unwrap();
            let rings = Molecules::ring(4000, 200, 7).unwrap();
            let mut positions = coiled(&pairs, 2.0);
            positions.extend(coiled(&rings, 0.5));
            let flow = OpenFlow::new(shear(3.0)).unwrap();
            let mut system = system(flow, positions, 0.3, 1.0, 8);
            let mut bonds = pairs.bonds();
            bonds.extend(rings.bonds());
            let mut springs = Bonded::new(fene(30.0), bonds);
            let mut stepper = scheme();
            for _ in 0..5 {
                stepper.step(&mut system, &mut springs, &mut ()).unwrap();
            }
            system.particles.positions().to_vec()
        })
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}
