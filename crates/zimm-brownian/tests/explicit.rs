//! Explicit schemes: exact moments of Rouse chains, with and without the error of the step, and springs of finite
//! length. Units are l_H and zeta / 4H: kt = 1, stiffness 1, friction 4.
#![allow(
    clippy::unwrap_used,
    reason = "a test may panic, and so may its helpers"
)]

use zimm_boundary::OpenFlow;
use zimm_brownian::{Diagonal, EulerMaruyama, FreeDraining, Heun, Rejection, White};
use zimm_core::{
    BondForce, Bonded, Clock, DMat3, DVec3, ForceError, Molecules, Open, Particles, StepError,
    Stepper, System,
    noise::{Domain, Noise},
};
use zimm_forces::{Fene, Hooke};

type Flow = OpenFlow<zimm_boundary::Steady>;

fn mixed_flow(eps: f64, gam: f64) -> Flow {
    let gradient = DMat3::from_cols(eps * DVec3::X, DVec3::new(gam, -eps, 0.0), DVec3::ZERO);
    OpenFlow::new(gradient).unwrap()
}

fn chain_springs(beads: usize) -> Bonded<Hooke> {
    let bonds = (1..beads as u32).map(|k| [k - 1, k]).collect();
    Bonded::new(Hooke::new(1.0).unwrap(), bonds)
}

fn free() -> FreeDraining {
    FreeDraining::new(4.0).unwrap()
}

/// A scheme for one chain, as a function of the positions: one step from them.
struct OneStep<'a, S> {
    stepper: &'a mut S,
    flow: Flow,
    beads: usize,
    dt: f64,
}

impl<S: Stepper<Flow, Bonded<Hooke>>> OneStep<'_, S> {
    fn take(&mut self, positions: Vec<DVec3>, kt: f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
        let particles = Particles::new(positions).unwrap();
        let clock = Clock::new(self.dt, kt, seed).unwrap();
        let mut system = System::new(self.flow, particles, clock);
        let white = White::new(clock.next(), &system.frame());
        let z = (0..self.beads).flat_map(|place| white.bead(place).to_array());
        let z = z.collect();
        self.stepper
            .step(&mut system, &mut chain_springs(self.beads), &mut ())
            .unwrap();
        let r = system.particles.positions();
        let bonds = r.windows(2).flat_map(|r| (r[1] - r[0]).to_array());
        (bonds.collect(), z)
    }

    /// The covariance of all bonds that the scheme keeps for ever: it is linear, Q' = A Q + N z, so C = A C A^T + N N^T.
    fn stationary(&mut self) -> Vec<Vec<f64>> {
        let order = 3 * (self.beads - 1);
        let a: Vec<Vec<f64>> = (0..order)
            .map(|j| {
                let mut r = vec![DVec3::ZERO; self.beads];
                for r in &mut r[j / 3 + 1..] {
                    r[j % 3] = 1.0;
                }
                self.take(r, 0.0, 0).0
            })
            .collect();
        let mut a = transpose(&a);
        let (mut noises, mut found) = (Vec::new(), Vec::new());
        for seed in 0..3 * self.beads as u64 {
            let (bonds, z) = self.take(vec![DVec3::ZERO; self.beads], 1.0, seed);
            noises.push(z);
            found.push(bonds);
        }
        let n = transpose(&solve(noises, found));
        let mut c = product(&n, &transpose(&n));
        for _ in 0..40 {
            let more = product(&product(&a, &c), &transpose(&a));
            for (c, more) in c.iter_mut().flatten().zip(more.iter().flatten()) {
                *c += more;
            }
            a = product(&a, &a);
        }
        c
    }

    /// Sums over bonds of <Q_x Q_x>, <Q_x Q_y>, <Q_y Q_y>, <Q_z Q_z>, and the squares of the end-to-end distance and of
    /// the radius of gyration.
    fn moments(&mut self) -> [f64; 6] {
        let c = self.stationary();
        let bonds = self.beads - 1;
        let sum = |i: usize, j: usize| (0..bonds).map(|k| c[3 * k + i][3 * k + j]).sum::<f64>();
        let between = |first: usize, last: usize| -> f64 {
            let pairs = (first..last).flat_map(|k| (first..last).map(move |l| (k, l)));
            pairs
                .flat_map(|(k, l)| (0..3).map(move |i| (3 * k + i, 3 * l + i)))
                .map(|(i, j)| c[i][j])
                .sum()
        };
        let pairs = (0..self.beads).flat_map(|l| (0..l).map(move |k| (k, l)));
        let gyration: f64 = pairs.map(|(k, l)| between(k, l)).sum();
        let size = (self.beads * self.beads) as f64;
        [
            sum(0, 0),
            sum(0, 1),
            sum(1, 1),
            sum(2, 2),
            between(0, bonds),
            gyration / size,
        ]
    }
}

fn transpose(m: &[Vec<f64>]) -> Vec<Vec<f64>> {
    (0..m[0].len())
        .map(|j| m.iter().map(|row| row[j]).collect())
        .collect()
}

fn product(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let row = |row: &Vec<f64>| -> Vec<f64> {
        (0..b[0].len())
            .map(|j| row.iter().zip(b).map(|(x, b)| x * b[j]).sum())
            .collect()
    };
    a.iter().map(row).collect()
}

/// X of A X = B, by elimination.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let order = a.len();
    for k in 0..order {
        let pivot = (k..order)
            .max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))
            .unwrap();
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in (0..order).filter(|&i| i != k) {
            let factor = a[i][k] / a[k][k];
            let (from_a, from_b) = (a[k].clone(), b[k].clone());
            a[i].iter_mut()
                .zip(from_a)
                .for_each(|(x, y)| *x -= factor * y);
            b[i].iter_mut()
                .zip(from_b)
                .for_each(|(x, y)| *x -= factor * y);
        }
    }
    for (row, a) in b
        .iter_mut()
        .zip(a.iter().enumerate().map(|(k, row)| row[k]))
    {
        row.iter_mut().for_each(|x| *x /= a);
    }
    b
}

// Moments of Euler's scheme at a finite step, made with 20 digits: no statistics, no extrapolation. With extension they
// are those of the increment kappa r dt, whereas this scheme carries by exp(kappa dt): the rate differs by eps dt / 2, at
// most 5e-4 of it, which makes 3e-4 of the moments of a chain that is half as far from its coil-stretch transition as at
// rest. The tests below hold for extension without this allowance.
#[test]
fn reference_euler_has_the_moments_of_euler() {
    let mut stepper = EulerMaruyama::new(free(), Diagonal);
    let mut rows = 0;
    for line in include_str!("data/rouse_euler.csv").lines().skip(1) {
        let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let [eps, gam] = [row[2], row[3]];
        let flow = mixed_flow(eps, gam);
        let (beads, dt) = (row[0] as usize, row[1]);
        let found = OneStep {
            stepper: &mut stepper,
            flow,
            beads,
            dt,
        }
        .moments();
        let error = if eps == 0.0 { 1e-11 } else { 5e-3 * dt };
        for (found, exact) in found.iter().zip(&row[4..]) {
            assert!(
                (found - exact).abs() <= error * row[8],
                "{line}: {found}, not {exact}"
            );
        }
        rows += 1;
    }
    assert_eq!(rows, 24);
}

/// Exact sums over the modes of a Rouse chain in steady mixed flow: those of `OneStep::moments` but the last two.
fn rouse(beads: usize, eps: f64, gam: f64) -> [f64; 4] {
    let mut sums = [0.0; 4];
    for j in 1..beads {
        let angle = std::f64::consts::PI * j as f64 / (2 * beads) as f64;
        let time = 0.5 / angle.sin().powi(2);
        let yy = 1.0 / (1.0 + 2.0 * eps * time);
        let xy = gam * time * yy;
        let xx = (1.0 + 2.0 * gam * time * xy) / (1.0 - 2.0 * eps * time);
        for (sum, term) in sums.iter_mut().zip([xx, xy, yy, 1.0]) {
            *sum += term;
        }
    }
    sums
}

// Published sums for four beads at gam = 0.29289..., and for ten in planar extension, fix the formula.
#[test]
fn reference_rouse_chains_in_steady_flow() {
    let shear = rouse(4, 0.0, 0.292_893_218_813_452_5);
    let extension = rouse(10, 0.012_235_870_926_211_607, 0.0);
    assert!((shear[0] - 5.230_447_378_299_529).abs() < 1e-12);
    assert!((shear[1] - 1.464_466_094_067_262).abs() < 1e-12);
    assert!((extension[0] - 10.333_002_544_243_467).abs() < 1e-11);
    assert!((extension[2] - 8.379_688_834_663_164).abs() < 1e-11);
}

// The error of the moments, at dt and dt / 2: a factor of four for Heun's scheme, of two for Euler's; in shear, planar
// extension and a mixed flow, at Weissenberg numbers of order one. No statistics.
#[test]
fn law_heun_is_of_second_order_and_euler_of_first() {
    let (mut heun, mut euler) = (Heun::new(free()), EulerMaruyama::new(free(), Diagonal));
    for (beads, eps, gam) in [(2, 0.0, 1.0), (4, 0.0, 0.5), (4, 0.1, 0.0), (4, 0.08, 0.3)] {
        let exact = rouse(beads, eps, gam);
        let flow = mixed_flow(eps, gam);
        let error =
            |moments: [f64; 6]| -> [f64; 4] { std::array::from_fn(|k| moments[k] - exact[k]) };
        let at = |dt| {
            error(
                OneStep {
                    stepper: &mut heun,
                    flow,
                    beads,
                    dt,
                }
                .moments(),
            )
        };
        let by_heun = [0.2, 0.1, 0.05].map(at);
        let at = |dt| {
            error(
                OneStep {
                    stepper: &mut euler,
                    flow,
                    beads,
                    dt,
                }
                .moments(),
            )
        };
        let by_euler = [0.02, 0.01, 0.005].map(at);
        for k in 0..4 {
            let [coarse, fine, finer] = by_heun.map(|error| error[k]);
            assert!(
                fine.abs() < 2e-3 * exact[0],
                "eps {eps}, gam {gam}: moment {k} is {fine} off"
            );
            if finer.abs() > 1e-6 {
                assert!(
                    (coarse / fine - 4.0).abs() < 0.8,
                    "eps {eps}, gam {gam}: moment {k}, {coarse} to {fine}"
                );
                assert!(
                    (fine / finer - 4.0).abs() < 0.4,
                    "eps {eps}, gam {gam}: moment {k}, {fine} to {finer}"
                );
            }
            let [coarse, fine, finer] = by_euler.map(|error| error[k]);
            if finer.abs() > 1e-5 {
                assert!(
                    (coarse / fine - 2.0).abs() < 0.1,
                    "eps {eps}, gam {gam}: Euler's moment {k}, {coarse} to {fine}"
                );
                assert!((fine / finer - 2.0).abs() < 0.05);
            }
        }
    }
}

// The equilibrium of Heun's scheme, mode by mode: variance 1 / (1 + (s^2 / 2) / (2 - s)) with s = a dt / 4, a the
// stiffness of the mode. For a dumbbell a = 2.
#[test]
fn limit_heun_at_rest() {
    let mut heun = Heun::new(free());
    for dt in [0.01, 0.5, 2.0] {
        let found = OneStep {
            stepper: &mut heun,
            flow: mixed_flow(0.0, 0.0),
            beads: 2,
            dt,
        }
        .moments();
        let s = 0.5 * dt;
        let exact = 1.0 / (1.0 + 0.5 * s * s / (2.0 - s));
        assert!(
            (found[0] - exact).abs() < 1e-12,
            "{dt}: {}, not {exact}",
            found[0]
        );
    }
}

/// The mean of a moment of each chain over a run, and its standard error from chain to chain.
fn mean_and_error(samples: &[f64]) -> (f64, f64) {
    let n = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / n;
    let variance = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

// A run as a user makes it: 300 chains of ten beads in mixed flow, eps = 0.01, gam = 0.02, dt = 0.05, seed 5, against the
// exact moments of the scheme at this step. They start from equilibrium; the longest time of the chain is 20, or 34
// along the flow; they relax for 100 and are followed for 100 more, sampled every 2. Standard errors come from the 300
// independent chains, 0.5 to 1.2 % of the first four moments (of the first, for the second) and 3.3 % of the last; the
// bound is 4 sigma. What it adds to the tests without statistics, which find errors of 1e-11, is noise from step to
// step: that of the same step twice in a row would double all moments.
#[test]
fn reference_a_run_of_rouse_chains_in_mixed_flow() {
    const CHAINS: usize = 300;
    let molecules = Molecules::linear(0, CHAINS as u32, 10).unwrap();
    let noise = Noise::new(5, 0);
    let mut positions = Vec::new();
    for beads in molecules.iter() {
        let mut r = DVec3::ZERO;
        for bead in beads {
            positions.push(r);
            r += noise.site(bead).normal3(Domain::user(1));
        }
    }
    let particles = Particles::new(positions).unwrap();
    let mut system = System::new(
        mixed_flow(0.01, 0.02),
        particles,
        Clock::new(0.05, 1.0, 5).unwrap(),
    );
    let mut springs = Bonded::new(Hooke::new(1.0).unwrap(), molecules.bonds());
    let mut stepper = EulerMaruyama::new(free(), Diagonal);
    let mut sums = vec![[0.0; 5]; CHAINS];
    let mut samples = 0.0;
    for step in 0..4000 {
        stepper.step(&mut system, &mut springs, &mut ()).unwrap();
        if step < 2000 || step % 40 != 0 {
            continue;
        }
        samples += 1.0;
        for (sums, r) in sums
            .iter_mut()
            .zip(system.particles.positions().chunks_exact(10))
        {
            let bonds = r.windows(2).map(|r| r[1] - r[0]);
            for q in bonds {
                for (sum, term) in sums
                    .iter_mut()
                    .zip([q.x * q.x, q.x * q.y, q.y * q.y, q.z * q.z])
                {
                    *sum += term;
                }
            }
            sums[4] += (r[9] - r[0]).length_squared();
        }
    }
    let exact = [
        10.505_386_280_571_6,
        0.527_272_801_778_1,
        8.587_134_221_038_4,
        9.114_573_158_016_15,
        33.439_665_578_915,
    ];
    for (k, exact) in exact.into_iter().enumerate() {
        let of_chains: Vec<f64> = sums.iter().map(|sums| sums[k] / samples).collect();
        let (mean, error) = mean_and_error(&of_chains);
        let scale = if k == 1 { 10.5 } else { exact };
        assert!(error < 0.035 * scale, "moment {k}: {mean} +- {error}");
        assert!(
            (mean - exact).abs() < 4.0 * error,
            "moment {k}: {mean} +- {error}, not {exact}"
        );
    }
}

fn dumbbells(count: usize, length: f64, dt: f64, seed: u64) -> System<Open> {
    let positions = (0..2 * count).map(|k| (k % 2) as f64 * length * DVec3::X);
    let particles = Particles::new(positions.collect()).unwrap();
    System::new(Open, particles, Clock::new(dt, 1.0, seed).unwrap())
}

fn fene(count: usize, b: f64) -> Bonded<Fene> {
    let bonds = (0..count as u32).map(|k| [2 * k, 2 * k + 1]).collect();
    Bonded::new(Fene::new(1.0, b.sqrt()).unwrap(), bonds)
}

/// No force, up to a length that is not exceeded.
#[derive(Clone, Copy)]
struct Tether {
    limit: f64,
}

impl BondForce for Tether {
    fn force(&self, _: f64) -> f64 {
        0.0
    }

    fn energy(&self, _: f64) -> f64 {
        0.0
    }

    fn limit(&self) -> f64 {
        self.limit
    }
}

// Without a force, moves that are drawn until they fit obey detailed balance with the density P(Q), the probability that
// a move from Q fits at once: for steps of variance s^2 = dt and a limit of 1
//
//   P = [erf((1 + Q) / s sqrt 2) + erf((1 - Q) / s sqrt 2)] / 2 - s / (Q sqrt(2 pi)) [exp(-(1 - Q)^2 / 2s^2) - exp(-(1 + Q)^2 / 2s^2)]
//
// So <Q^2> is known at any step; it is 3/5 for small ones. 500 dumbbells, dt = 0.05, seed 11, 300 samples 10 steps
// apart, by when 3 % of a square is remembered: standard deviation 0.25, standard error 0.25 / sqrt(1.5e5) = 6.5e-4, or
// 0.12 %. Bound: 5 sigma. Moves that stay when they do not fit would give 0.6, 9 % off.
#[test]
fn limit_rejection_without_a_force() {
    const COUNT: usize = 500;
    let dt: f64 = 0.05;
    let bonds = (0..COUNT as u32).map(|k| [2 * k, 2 * k + 1]).collect();
    let mut springs = Bonded::new(Tether { limit: 1.0 }, bonds);
    let mut system = dumbbells(COUNT, 0.7, dt, 11);
    let mut stepper = Rejection::new(free(), Diagonal, &springs);
    let (mut square, mut samples) = (0.0, 0.0);
    for step in 1..=3100 {
        stepper.step(&mut system, &mut springs, &mut ()).unwrap();
        if step > 100 && step % 10 == 0 {
            for r in system.particles.positions().chunks_exact(2) {
                square += (r[1] - r[0]).length_squared();
                samples += 1.0;
            }
        }
    }
    let s = dt.sqrt();
    let fits = |q: f64| {
        let bell = |x: f64| libm::exp(-0.5 * (x / s).powi(2));
        let tail = |x: f64| libm::erf(x / (s * 2.0_f64.sqrt()));
        let edge = s / (q * (2.0 * std::f64::consts::PI).sqrt());
        0.5 * (tail(1.0 + q) + tail(1.0 - q)) - edge * (bell(1.0 - q) - bell(1.0 + q))
    };
    let integral = |power: i32| -> f64 {
        let at = |k: u32| (f64::from(k) + 0.5) / 2000.0;
        (0..2000).map(at).map(|q| q.powi(power) * fits(q)).sum()
    };
    let exact = integral(4) / integral(2);
    let found = square / samples;
    assert!((found - exact).abs() < 5.0 * 6.5e-4, "{found}, not {exact}");
    assert!(exact < 0.56 && stepper.rejections() > 25_000);
}

// What is drawn again is drawn for whole molecules, and for them alone: of two chains, one is stretched so that most
// moves fail. The other moves as it would without rejection, bit by bit.
#[test]
fn law_only_rejected_molecules_are_drawn_again() {
    let chain = |length: f64| (0..3).map(move |k| f64::from(k) * length * DVec3::X);
    let positions: Vec<DVec3> = chain(0.5).chain(chain(3.1)).collect();
    let system = |seed| {
        let particles = Particles::new(positions.clone()).unwrap();
        System::new(Open, particles, Clock::new(1e-3, 1.0, seed).unwrap())
    };
    let bonds = vec![[0, 1], [1, 2], [3, 4], [4, 5]];
    let mut springs = Bonded::new(Fene::new(1e-3, 3.12).unwrap(), bonds);
    let mut again = 0;
    for seed in 0..50 {
        let mut stepper = Rejection::new(free(), Diagonal, &springs);
        let (mut rejecting, mut plain) = (system(seed), system(seed));
        stepper.step(&mut rejecting, &mut springs, &mut ()).unwrap();
        let mut euler = EulerMaruyama::new(free(), Diagonal);
        let mut hooke = Bonded::new(Hooke::new(1.0).unwrap(), vec![]);
        // The same forces, without the springs' limit.
        *plain.particles.columns_mut().forces = {
            let mut forces = vec![DVec3::ZERO; 6];
            zimm_core::ForceField::accumulate(&mut springs, &plain.frame(), &mut forces, &mut ())
                .unwrap();
            forces
        };
        euler.step(&mut plain, &mut hooke, &mut ()).unwrap();
        let (found, expected) = (rejecting.particles.positions(), plain.particles.positions());
        assert_eq!(found[..3], expected[..3]);
        if stepper.rejections() == 0 {
            assert_eq!(found, expected);
        } else {
            again += 1;
            assert!((3..6).all(|k| found[k] != expected[k]));
        }
    }
    assert!((5..50).contains(&again), "{again} of 50 were drawn again");
}

#[test]
fn extreme_a_move_that_never_fits() {
    let mut system = dumbbells(1, 3.16, 50.0, 1);
    let before = system.clone();
    let mut springs = fene(1, 10.0);
    let mut stepper = Rejection::new(free(), Diagonal, &springs)
        .within(20)
        .unwrap();
    let failed = stepper.step(&mut system, &mut springs, &mut ());
    let Err(StepError::Force {
        step: 1,
        source: ForceError::Overstretched { length, limit, .. },
    }) = failed
    else {
        panic!("{failed:?}");
    };
    assert!(length >= limit);
    assert_eq!(stepper.rejections(), 21);
    assert_eq!(system.particles.positions(), before.particles.positions());
    assert!(
        Rejection::new(free(), Diagonal, &springs)
            .within(1 << 31)
            .is_err()
    );

    let strangers = fene(3, 10.0);
    let mut stepper = Rejection::new(free(), Diagonal, &strangers);
    let failed = stepper.step(&mut system, &mut springs, &mut ());
    assert!(matches!(
        failed,
        Err(StepError::Force {
            source: ForceError::NoSuchParticle { .. },
            ..
        })
    ));
}

#[test]
fn extreme_heun_and_overstretched_springs() {
    let mut springs = fene(1, 10.0);
    for (length, dt) in [(3.16, 0.5), (1.0, 1e3)] {
        let mut system = dumbbells(1, length, dt, 1);
        let before = system.clone();
        let failed = Heun::new(free()).step(&mut system, &mut springs, &mut ());
        let Err(StepError::Force {
            source: ForceError::Overstretched { .. },
            ..
        }) = failed
        else {
            panic!("{failed:?}");
        };
        assert_eq!(system.particles.positions(), before.particles.positions());
    }
}

// With hydrodynamic interactions the root is applied anew, and the step still ends with springs that fit.
#[cfg(feature = "hydrodynamics")]
#[test]
fn extreme_rejection_with_hydrodynamics() {
    use zimm_brownian::{Cholesky, Rpy};
    let mut system = dumbbells(5, 0.8, 0.05, 3);
    let bonds = (0..5).map(|k| [2 * k, 2 * k + 1]).collect();
    let mut springs = Bonded::new(Tether { limit: 1.0 }, bonds);
    let rpy = Rpy::new(4.0, 0.4).unwrap();
    let mut stepper = Rejection::new(rpy, Cholesky::new(1e-6).unwrap(), &springs);
    for _ in 0..300 {
        stepper.step(&mut system, &mut springs, &mut ()).unwrap();
    }
    assert!(stepper.rejections() > 10, "{}", stepper.rejections());
}
