//! Brownian dynamics of isolated chains against theory.
//!
//! Means are over 32 groups with noise of their own, whose scatter is the error. Seeds are 1 to 32 in the first case of a
//! test, 33 to 64 in the second and so on. A mean is within four standard errors and 0.2 % for the time step, or it is
//! wrong: some 450 means are looked at, which once in thirty changes of the noise is too much for one of them. Every
//! check also asks that its bound is below the error in physics that it has to see, which is its last argument.
#![allow(clippy::unwrap_used)]

mod chains;

use chains::*;
use std::f64::consts::PI;
use zimm::prelude::*;

const GROUPS: u64 = 32;

fn hooke() -> Hooke {
    Hooke::new(1.0).unwrap()
}

fn fene(b: f64) -> Fene {
    Fene::new(1.0, b.sqrt()).unwrap()
}

fn open(gradient: DMat3) -> OpenFlow {
    OpenFlow::new(gradient).unwrap()
}

fn linear(count: u32, beads: u32) -> Molecules {
    Molecules::linear(0, count, beads).unwrap()
}

/// A clock for each group of each case.
fn noise(dt: f64, case: usize, group: u64) -> Clock {
    clock(dt, 1 + group + GROUPS * case as u64)
}

fn steps(time: f64, dt: f64) -> u64 {
    (time / dt).round() as u64
}

/// Relaxation times of the stress of Rouse chains; amplitudes relax in twice that time.
fn rouse_time(beads: u32, mode: u32) -> f64 {
    let angle = PI * f64::from(mode) / f64::from(2 * beads);
    0.5 / angle.sin().powi(2)
}

/// Without noise each mode decays as exp(-t / 2 tau_p). Looked at after 2 tau_p in 200 steps or more, in which the
/// scheme's error is 1e-5; the bound 1e-4 sees 0.01 % in a friction or a stiffness.
#[test]
fn limit_rouse_modes_decay() {
    for beads in [2, 10, 20] {
        for mode in 1..beads {
            let dt = 0.01 * rouse_time(beads, mode).min(1.0);
            let clock = Clock::new(dt, 0.0, 1).unwrap();
            let chains = linear(1, beads);
            let mut scene = isolated(Open, hooke(), chains, clock);
            let mut modes = RouseModes::new(chains, mode as usize).unwrap();
            let mut amplitude = |scene: &Scene<Open, Bonded<Hooke>>| {
                let found = modes.measure(&scene.system.frame(), &()).unwrap();
                found[mode as usize - 1][0].length()
            };
            let before = amplitude(&scene);
            let time = 2.0 * rouse_time(beads, mode);
            let count = steps(time, dt);
            scene.run(count, &mut ());
            let decay = (before / amplitude(&scene)).ln() * time / (count as f64 * dt);
            assert!(
                (decay - 1.0).abs() < 1e-4,
                "N {beads}, mode {mode}: {decay}"
            );
        }
    }
}

/// Chains of ten beads, all at one point, fill their modes: <|X_p|^2> = (3 / a_p) (1 - exp(-t / tau_p)). What noise adds
/// and what friction takes are seen apart, early and late.
///
/// 5120 chains at t = 5 and t = 60, three relaxation times of the slowest mode. Standard error of a square: 1.2 %;
/// detectable: 5.5 %.
#[test]
fn limit_rouse_modes_fill_from_nothing() {
    let (beads, chains, dt) = (10, 160, 0.5);
    let times = [5.0, 60.0];
    let groups = replicas(GROUPS, |group| {
        let positions = vec![DVec3::ZERO; (chains * beads) as usize];
        let chains = linear(chains, beads);
        let mut scene = Scene::new(Open, positions, hooke(), chains, clock(dt, 1 + group));
        let mut modes = RouseModes::new(chains, beads as usize - 1).unwrap();
        let mut now = 0.0;
        Ok::<_, String>(times.map(|time| {
            scene.run(steps(time - now, dt), &mut ());
            now = time;
            let found = modes.measure(&scene.system.frame(), &()).unwrap();
            let square = |mode: &Vec<DVec3>| {
                mode.iter().map(|x| x.length_squared()).sum::<f64>() / f64::from(chains.count())
            };
            found.iter().map(square).collect::<Vec<f64>>()
        }))
    });
    let groups = groups.unwrap();
    for (moment, time) in times.into_iter().enumerate() {
        for mode in 1..beads {
            let mut average = EnsembleAverage::new();
            for (group, found) in (0..).zip(&groups) {
                average.push((group, found[moment][mode as usize - 1]));
            }
            let tau = rouse_time(beads, mode);
            let exact = 1.5 * tau * (1.0 - (-time / tau).exp());
            let what = format!("t {time}, mode {mode}");
            assert_mean(&what, average.estimate().unwrap(), exact, 0.055);
        }
    }
}

/// In shear R(t) = R_0(t) + rate R_1(t), with R_1 along x, for the same start and the same noise: so averages at one
/// rate are averages at all. Four decades of rate up to Wi = 100, chains of 2, 10 and 20 beads, five relaxation times in
/// steps of a fifth of one, seed 1; R_1 is the same to 1e-5 of its size, which the solution of springs to 1e-8 allows.
#[test]
fn law_the_response_of_rouse_chains_is_linear_in_the_rate() {
    for beads in [2, 10, 20] {
        let time = rouse_time(beads, 1);
        let ends = |weissenberg: f64| {
            let space = open(planar(0.0, weissenberg / time));
            let chains = linear(8, beads);
            let mut scene = isolated(space, hooke(), chains, clock(0.2 * time, 1));
            scene.run(25, &mut ());
            let mut ends = EndToEnd { molecules: chains };
            ends.measure(&scene.system.frame(), &()).unwrap()
        };
        let response = |weissenberg: f64| -> Vec<DVec3> {
            let pairs = ends(weissenberg).into_iter().zip(ends(0.0));
            pairs
                .map(|(flow, rest)| (flow - rest) / weissenberg)
                .collect()
        };
        let expected = response(1.0);
        for weissenberg in [0.01, 0.1, 10.0, 100.0] {
            for (found, expected) in response(weissenberg).iter().zip(&expected) {
                let (off, size) = (found.distance(*expected), expected.length());
                assert!(
                    off < 1e-5 * (1.0 + size),
                    "N {beads}, Wi {weissenberg}: {found} {expected}"
                );
            }
        }
    }
}

/// R_e^2, R_g^2, eta and Psi_1 of Rouse chains at one Weissenberg number, from `time` relaxation times of 512 chains in
/// steps of a fifth of one. A twin at rest and one in the opposite flow, of the same start and the same noise, take off
/// what is even or odd in the rate by symmetry. `detectable` is for sizes and eta, and for Psi_1 and forces.
fn rouse_in_shear(case: usize, beads: u32, weissenberg: f64, time: u64, detectable: [f64; 2]) {
    const PER_TIME: u64 = 5;
    let tau = rouse_time(beads, 1);
    let (rate, dt) = (weissenberg / tau, tau / PER_TIME as f64);
    let found = averages(
        GROUPS,
        [10 * PER_TIME, time, PER_TIME],
        |group| {
            let space = |rate| open(planar(0.0, rate));
            let clock = noise(dt, case, group);
            let chain = |rate| isolated(space(rate), hooke(), linear(16, beads), clock);
            [chain(rate), chain(-rate), chain(0.0)]
        },
        |[flow, back, rest]| {
            let kramers = 0.5 * (flow.kramers + back.kramers) - rest.kramers;
            let giesekus = 0.5 * (flow.giesekus + back.giesekus);
            [
                0.5 * (flow.square() + back.square()) - rest.square(),
                0.5 * (flow.gyration + back.gyration) - rest.gyration,
                flow.giesekus.y_axis.x / rate,
                first_difference(giesekus) / (rate * rate),
                0.5 * (flow.kramers - back.kramers).y_axis.x / rate,
                first_difference(kramers) / (rate * rate),
            ]
        },
    );
    let known = |wi: f64| {
        let data = include_str!("data/rouse_steady.csv");
        let is_it = |row: &Line<'_>| row.numbers(["N", "Wi"]) == [f64::from(beads), wi];
        table(data)
            .find(is_it)
            .unwrap()
            .numbers(["Re2", "Rg2", "eta", "Psi1"])
    };
    let (rest, one) = (known(0.0), known(1.0));
    let what = |name: &str| format!("N {beads}, Wi {weissenberg}, {name}");
    for (k, name) in [(0, "R_e^2"), (1, "R_g^2")] {
        let grown = weissenberg.powi(2) * (one[k] - rest[k]);
        assert_near(
            &what(name),
            found[k],
            (grown, 0.0),
            rest[k] + grown,
            detectable[0],
        );
    }
    assert_mean(&what("eta"), found[2], one[2], detectable[0]);
    assert_mean(&what("Psi_1"), found[3], one[3], detectable[1]);
    assert_mean(&what("eta, Kramers"), found[4], one[2], detectable[1]);
    assert_mean(&what("Psi_1, Kramers"), found[5], one[3], detectable[1]);
}

/// Sizes are quadratic in the rate, viscosity and first normal stress coefficient do not depend on it.
///
/// Standard errors for 2 beads at any rate: 1.2 % of all four. For 10 and 20 beads at Wi = 1: 0.8 % of sizes and eta,
/// 2.3 % of Psi_1. Detectable: 5 % and 10 %; that they are the same at other rates is a law above.
#[test]
fn reference_rouse_chains_in_shear() {
    for (case, weissenberg) in [0.01, 0.1, 1.0, 10.0, 100.0].into_iter().enumerate() {
        rouse_in_shear(case, 2, weissenberg, 240, [0.05, 0.055]);
    }
    rouse_in_shear(5, 10, 1.0, 40, [0.05, 0.1]);
    rouse_in_shear(6, 20, 1.0, 32, [0.05, 0.1]);
}

/// The same for long chains at other rates, to 3 %.
#[test]
#[ignore = "minutes; cargo test -p zimm-tests --test brownian -- --ignored --nocapture rouse"]
fn reference_rouse_chains_in_shear_long() {
    let cases = [(10, 0.01), (10, 1.0), (10, 100.0), (20, 0.1), (20, 10.0)];
    for (case, (beads, weissenberg)) in (7..).zip(cases) {
        rouse_in_shear(case, beads, weissenberg, 500, [0.03, 0.03]);
    }
}

/// Chains that a shear flow takes hold of at time zero, or that are sheared all at once by 0.5: eta+ and Psi_1+, sizes,
/// and the relaxation modulus, against twins of the same start and the same noise in the opposite flow and at rest.
///
/// 20 480, 4608 and 2560 chains of 2, 10 and 20 beads. Standard errors: 1.2 % of eta+, 1.3 % of Psi_1+, 2 % of G.
/// Detectable: 6 %, and 10 % of Psi_1+ and G.
#[test]
fn reference_rouse_start_up_and_step_strain() {
    let data = include_str!("data/rouse_start_up.csv");
    for (beads, count, parts, [first, last]) in [
        (2, 640, 20.0, [0.05, 2.0]),
        (10, 144, 40.0, [0.05, 0.5]),
        (20, 80, 20.0, [0.2, 0.5]),
    ] {
        let tau = rouse_time(beads, 1);
        let (rate, strain, dt) = (1.0 / tau, 0.5, tau / parts);
        let of_these = |row: &Line<'_>| {
            let [n, t] = row.numbers(["N", "t_over_tau1"]);
            n == f64::from(beads) && (first..=last).contains(&t)
        };
        let rows: Vec<Line<'_>> = table(data).filter(of_these).collect();
        let at: Vec<u64> = rows.iter().map(|row| steps(row.number("t"), dt)).collect();
        let scene = |rate: f64, group: u64| {
            isolated(
                open(planar(0.0, rate)),
                hooke(),
                linear(count, beads),
                clock(dt, 1 + group),
            )
        };
        let started = curve(
            GROUPS,
            &at,
            |group| [rate, -rate, 0.0].map(|rate| scene(rate, group)),
            |[flow, back, rest]| {
                let both = 0.5 * (flow.kramers + back.kramers) - rest.kramers;
                [
                    0.5 * (flow.kramers - back.kramers).y_axis.x / rate,
                    first_difference(both) / (rate * rate),
                    0.5 * (flow.square() + back.square()) - rest.square(),
                    0.5 * (flow.gyration + back.gyration) - rest.gyration,
                ]
            },
        );
        let strained = curve(
            GROUPS,
            &at,
            |group| {
                [strain, 0.0].map(|strain| {
                    let step = StepStrain::new(strain, 0.0).unwrap();
                    let space = OpenFlow::with_history(planar(0.0, 1.0), step).unwrap();
                    isolated(space, hooke(), linear(count, beads), clock(dt, 1 + group))
                })
            },
            |[flow, rest]| [(flow.kramers - rest.kramers).y_axis.x / strain],
        );
        for (row, (found, modulus)) in rows.iter().zip(started.iter().zip(&strained)) {
            let what = |name| format!("N {beads}, t {} tau, {name}", row.number("t_over_tau1"));
            assert_mean(&what("eta+"), found[0], row.number("eta"), 0.06);
            assert_mean(&what("Psi_1+"), found[1], row.number("Psi1"), 0.1);
            for (k, name) in [(2, "Re2"), (3, "Rg2")] {
                let rest = table(data).find(|row| row.number("N") == f64::from(beads));
                let rest = rest.unwrap().number(name);
                let grown = rate * rate * (row.number(name) - rest);
                assert_near(&what(name), found[k], (grown, 0.0), rest + grown, 0.05);
            }
            // The step that holds the jump is of first order in the rates of relaxation.
            if beads == 2 || (beads == 10 && row.number("t_over_tau1") == 0.5) {
                assert_mean(&what("G"), modulus[0], row.number("G"), 0.1);
            }
        }
    }
}

/// <Q^2> = 3 b / (b + 5), <Q^4> = 15 b^2 / ((b + 5) (b + 7)), <Q F> = 3.
///
/// 2048 dumbbells for 40 time units. Standard errors: 0.4 % of <Q^2> and <Q F>, 0.7 % of <Q^4>. Detectable: 3 % and 6 %.
#[test]
fn reference_fene_dumbbells_at_rest() {
    let data = include_str!("data/fene_at_rest.csv");
    for (case, row) in table(data).enumerate() {
        let b = row.number("b");
        let [square, fourth, work] = averages(
            GROUPS,
            [20, 40, 10],
            |group| {
                let clock = noise(0.1, case, group);
                [isolated(open(DMat3::ZERO), fene(b), linear(64, 2), clock)]
            },
            |[seen]| {
                let k = seen.kramers;
                [
                    seen.square(),
                    seen.fourth,
                    3.0 + k.x_axis.x + k.y_axis.y + k.z_axis.z,
                ]
            },
        );
        assert_mean(&format!("b {b}, <Q^2>"), square, row.number("Q2"), 0.03);
        assert_mean(&format!("b {b}, <Q^4>"), fourth, row.number("Q4"), 0.06);
        assert_mean(&format!("b {b}, <Q F>"), work, 3.0, 0.03);
    }
}

/// The viscosity of planar and of uniaxial extension by Giesekus' expression, from `<QQ>`.
fn extensional(kind: &str, ends: DMat3) -> f64 {
    let (x, y, z) = (ends.x_axis.x, ends.y_axis.y, ends.z_axis.z);
    match kind {
        "planar" => 2.0 * (x + y),
        _ => 2.0 * x + 0.5 * (y + z),
    }
}

/// Planar and uniaxial extension at rates of 0.001 to 100. Below a rate of 0.3 a twin at rest with the same noise takes
/// the noise off.
///
/// 512 dumbbells at low rates, 2304 where coils turn into stretched chains, 1152 else. Standard errors: 0.5 % at low
/// rates, 1 % around 0.5, less beyond; detectable: 2.5 % and 5 %, by Kramers' expression 10 %.
#[test]
fn reference_fene_dumbbells_in_extension() {
    for (case, row) in table(include_str!("data/fene_extension.csv")).enumerate() {
        let [b, rate] = row.numbers(["b", "rate"]);
        let kind = row.word("kind");
        let shape = match kind {
            "planar" => DVec3::new(1.0, -1.0, 0.0),
            _ => DVec3::new(1.0, -0.5, -0.5),
        };
        let scene = |rate: f64, dt: f64, group: u64, count: u32| {
            let space = open(DMat3::from_diagonal(rate * shape));
            isolated(space, fene(b), linear(count, 2), noise(dt, case, group))
        };
        let what = |name| format!("{kind}, b {b}, rate {rate}, {name}");
        if rate < 0.3 {
            let at_rest = 3.0 * b / (b + 5.0);
            let found = averages(
                GROUPS,
                [80, 20, 10],
                |group| [rate, 0.0].map(|rate| scene(rate, 0.1, group, 16)),
                |[flow, rest]| {
                    let grown = extensional(kind, flow.ends) - extensional(kind, rest.ends);
                    [flow.square() - rest.square(), grown]
                },
            );
            let rest = extensional(kind, DMat3::IDENTITY * (at_rest / 3.0));
            for (found, rest, name) in [(found[0], at_rest, "Q2"), (found[1], rest, "viscosity")] {
                let exact = row.number(name);
                assert_near(&what(name), found, (exact - rest, 0.0), exact, 0.025);
            }
            continue;
        }
        let dt = 0.1 / rate.max(1.0);
        let (before, time) = if rate < 0.9 {
            (25.0, 40.0)
        } else {
            (15.0 / rate, 10.0 / rate)
        };
        // Where a coil turns into a stretched chain, fluctuations are large and slow.
        let count = if rate == 0.5 { 72 } else { 36 };
        let found = averages(
            GROUPS,
            [steps(before, dt), 20, steps(time / 20.0, dt).max(1)],
            |group| [scene(rate, dt, group, count)],
            |[seen]| {
                let tension = |stress: DMat3| {
                    let [x, y, z] = [stress.x_axis.x, stress.y_axis.y, stress.z_axis.z];
                    (x - if kind == "planar" { y } else { 0.5 * (y + z) }) / rate
                };
                [seen.square(), tension(seen.giesekus), tension(seen.kramers)]
            },
        );
        assert_mean(&what("Q2"), found[0], row.number("Q2"), 0.05);
        assert_mean(&what("viscosity"), found[1], row.number("viscosity"), 0.05);
        if rate >= 0.5 {
            assert_mean(
                &what("viscosity, Kramers"),
                found[2],
                row.number("viscosity"),
                0.1,
            );
        }
    }
}

/// Shear, mixed flow and extension against the solution of the Fokker-Planck equation. Kramers' stress is Giesekus',
/// component by component: <Q_x F_x> = 1 + 2 e <x^2> + 2 g <x y>, <Q_y F_y> = 1 - 2 e <y^2>, <Q_x F_y> = g <y^2>.
///
/// 1536 dumbbells for 30 relaxation times in the flow. Standard errors: 0.8 % of <Q^2> and eta, 1.2 % of N_1, 1.5 % of the
/// identities. Detectable: 5 %, and 10 % of N_1, forces and identities.
#[test]
fn reference_fene_dumbbells_in_shear_and_mixed_flow() {
    for (case, row) in table(include_str!("data/fene_mixed_flow.csv")).enumerate() {
        let [b, e, g] = row.numbers(["b", "e", "g"]);
        let fast = (e + g).max(1.0);
        if e + g < 0.9 {
            continue;
        }
        // What is stretched relaxes with the rate of extension, or with that of shear to the power 2/3.
        let unit = if e > 0.0 {
            1.0 / fast
        } else {
            fast.powf(-2.0 / 3.0)
        };
        let dt = 0.1 * unit;
        let found = averages(
            GROUPS,
            [steps(15.0, dt).min(400), 60, 5],
            |group| {
                [isolated(
                    open(planar(e, g)),
                    fene(b),
                    linear(48, 2),
                    noise(dt, case, group),
                )]
            },
            |[seen]| {
                let off = seen.kramers - seen.giesekus;
                [
                    seen.square(),
                    viscosity(e, g, seen.giesekus),
                    first_difference(seen.giesekus),
                    viscosity(e, g, seen.kramers),
                    off.x_axis.x,
                    off.y_axis.x,
                    off.y_axis.y,
                    off.z_axis.z,
                ]
            },
        );
        let [xx, xy, yy] = row.numbers(["QFxx", "QFxy", "QFyy"]);
        let stress = DMat3::from_cols(
            DVec3::new(xx, xy, 0.0),
            DVec3::new(xy, yy, 0.0),
            DVec3::ZERO,
        );
        let what = |name| format!("b {b}, e {e}, g {g}, {name}");
        let exact = viscosity(e, g, stress);
        assert_mean(&what("Q2"), found[0], row.number("Q2"), 0.05);
        assert_mean(&what("eta"), found[1], exact, 0.05);
        assert_mean(&what("N_1"), found[2], xx - yy, 0.1);
        assert_mean(&what("eta, Kramers"), found[3], exact, 0.1);
        for (found, name, scale) in [
            (found[4], "Kramers - Giesekus, xx", xx),
            (found[5], "xy", xx.sqrt()),
            (found[6], "yy", 1.0),
            (found[7], "zz", 1.0),
        ] {
            assert_near(&what(name), found, (0.0, 0.0), scale, 0.1);
        }
    }
}

/// The first deviations from linear response at a rate of 0.2: of the same start and the same noise, in flow, in the
/// opposite flow and at rest, the viscosity is known to parts of the 0.1 to 0.3 % that shear takes off it.
///
/// 3072 dumbbells for 60 time units. Standard errors: 1.5 % of eta - eta_0, 1 % of Psi_1. Detectable: 10 % and 5 %.
#[test]
fn reference_series_of_the_shear_viscosity() {
    for (case, row) in table(include_str!("data/fene_shear_series.csv")).enumerate() {
        let b = row.number("b");
        if ![10.0, 50.0, 100.0].contains(&b) {
            continue;
        }
        let rate: f64 = 0.2;
        let sum = |name: &str, from: i32| -> f64 {
            let term = |k: i32| row.number(&format!("{name}_{}", 2 * k)) * rate.powi(2 * k);
            (from..5).map(term).sum()
        };
        let found = averages(
            GROUPS,
            [100, 60, 10],
            |group| {
                [rate, -rate, 0.0].map(|rate| {
                    isolated(
                        open(planar(0.0, rate)),
                        fene(b),
                        linear(96, 2),
                        noise(0.1, case, group),
                    )
                })
            },
            |[flow, back, rest]| {
                let thinned = 0.5 * (flow.ends + back.ends) - rest.ends;
                let sheared = 0.5 * (flow.ends - back.ends);
                [thinned.y_axis.y, 2.0 * sheared.y_axis.x / rate]
            },
        );
        assert_mean(&format!("b {b}, eta - eta_0"), found[0], sum("eta", 1), 0.1);
        assert_mean(&format!("b {b}, Psi_1"), found[1], sum("Psi1", 0), 0.05);
    }
}

/// b = 50 at rates of 1 to 300, against the Fokker-Planck equation and an independent simulation. Psi_2 is zero. From 100 to
/// 300 the exponents come near -2/3 and -4/3.
///
/// 2048 dumbbells for 60 relaxation times in the flow. Standard errors: 0.6 % of eta, 0.8 % of Psi_1, 0.5 % of the stretch.
/// Detectable: 5 %; in the exponents 0.03, four errors of 0.6 % in each end over ln 3.
#[test]
fn reference_shear_thinning_of_fene_dumbbells() {
    let mut last = None;
    for (case, row) in table(include_str!("data/fene_shear.csv")).enumerate() {
        let g = row.number("g");
        let unit = g.powf(-2.0 / 3.0);
        let dt = 0.1 * unit;
        let found = averages(
            GROUPS,
            [200, 60, 10],
            |group| {
                [isolated(
                    open(planar(0.0, g)),
                    fene(50.0),
                    linear(64, 2),
                    noise(dt, case, group),
                )]
            },
            |[seen]| {
                let stress = seen.giesekus;
                [
                    stress.y_axis.x / g,
                    first_difference(stress) / (g * g),
                    seen.square() / 50.0,
                    (stress.y_axis.y - stress.z_axis.z) / (g * g),
                ]
            },
        );
        for (found, name) in found.into_iter().zip(["eta", "Psi1", "stretch"]) {
            let [expected, error] =
                [name.into(), format!("{name}_error")].map(|n: String| row.number(&n));
            assert_near(
                &format!("g {g}, {name}"),
                found,
                (expected, error),
                expected,
                0.05,
            );
        }
        assert_eq!(found[3].value, 0.0, "Psi_2");
        let logarithms = [g, found[0].value, found[1].value].map(f64::ln);
        if let Some(before) = last.replace(logarithms) {
            let run = logarithms[0] - before[0];
            let slopes = [1, 2].map(|k| (logarithms[k] - before[k]) / run);
            println!("exponents up to {g}: {slopes:.3?}");
            if g == 300.0 {
                assert!((slopes[0] + 0.63).abs() < 0.03 && (slopes[1] + 1.31).abs() < 0.03);
            }
        }
    }
}

/// `<Q^2>` and the viscosity, by Giesekus and by Kramers, of dumbbells with excluded volume.
fn swollen<S: BondForce + Copy>(
    spring: S,
    [z, d]: [f64; 2],
    [e, g]: [f64; 2],
    dt: f64,
    looks: [u64; 3],
    case: usize,
) -> [Mean; 3] {
    averages(
        GROUPS,
        looks,
        |group| {
            let chains = linear(64, 2);
            let scene = isolated(open(planar(e, g)), spring, chains, noise(dt, case, group));
            let law = NarrowGaussian::new(z, d).unwrap();
            [scene.with(Pairwise::new(law, WithinMolecules::new(chains)))]
        },
        |[seen]| {
            let [giesekus, kramers] = [seen.giesekus, seen.kramers].map(|stress| {
                if e + g > 0.0 {
                    viscosity(e, g, stress)
                } else {
                    0.0
                }
            });
            [seen.square(), giesekus, kramers]
        },
    )
}

/// Dumbbells with excluded volume at rest and in planar extension, against quadrature: FENE and Hookean springs, a
/// strong repulsion and a narrow one.
///
/// 2048 dumbbells, 24 time units. Standard error of <Q^2> 0.4 % at rest and 0.6 % in extension, of the viscosity 0.9 %,
/// by Kramers' expression 2 %; detectable are 3 % in sizes, 5 % in the viscosity and 9 % in forces.
#[test]
fn reference_excluded_volume_at_rest_and_in_extension() {
    let data = include_str!("data/excluded_volume_extension.csv");
    let cases = [
        [50.0, 10.0, 1.0],
        [50.0, 1.0, 0.5],
        [f64::INFINITY, 10.0, 1.0],
    ];
    let rates = [0.0, 0.3, 1.0];
    for (case, row) in table(data).enumerate() {
        let (law, e) = (row.numbers(["b", "z", "d"]), row.number("e"));
        if !cases.contains(&law) || !rates.contains(&e) {
            continue;
        }
        let [b, z, d] = law;
        let dt = 0.1;
        let looks = [steps(if e > 0.0 { 20.0 } else { 4.0 }, dt), 40, 6];
        let found = if b.is_finite() {
            swollen(fene(b), [z, d], [e, 0.0], dt, looks, case)
        } else {
            swollen(hooke(), [z, d], [e, 0.0], dt, looks, case)
        };
        let what = |name| format!("b {b}, z {z}, d {d}, e {e}, {name}");
        assert_mean(&what("Q2"), found[0], row.number("Q2"), 0.03);
        if e > 0.0 {
            let exact = 0.5 * (row.number("Qxx") + row.number("Qyy"));
            assert_mean(&what("eta"), found[1], exact, 0.05);
            assert_mean(&what("eta, Kramers"), found[2], exact, 0.09);
        }
    }
}

/// The same springs, z* = 10 and d* = 1, in shear and mixed flow, against an independent simulation whose errors are
/// 0.2 % of R_e^2 and 0.5 % of eta.
///
/// 2048 dumbbells, 40 relaxation times in the flow. Standard errors: 0.5 % of R_e^2, 0.8 % of eta; detectable: 4 %.
#[test]
fn reference_excluded_volume_in_mixed_flow() {
    let flows = [
        [0.0, 1.0],
        [0.0, 10.0],
        [0.1, 0.3],
        [0.3, 1.0],
        [0.5, 3.0],
        [0.7, 0.3],
        [1.0, 1.0],
        [1.0, 10.0],
    ];
    let data = include_str!("data/excluded_volume_mixed_flow.csv");
    for (case, row) in table(data).enumerate() {
        let [e, g] = row.numbers(["e", "g"]);
        if !flows.contains(&[e, g]) {
            continue;
        }
        let unit = (e + g).max(1.0).powf(-2.0 / 3.0);
        let found = swollen(
            fene(50.0),
            [10.0, 1.0],
            [e, g],
            0.1 * unit,
            [200, 50, 8],
            case,
        );
        let what = |name| format!("e {e}, g {g}, {name}");
        let [square, eta] = row.numbers(["Re2", "eta"]);
        assert_near(
            &what("R_e^2"),
            found[0],
            (square, 0.002 * square),
            square,
            0.04,
        );
        assert_near(&what("eta"), found[1], (eta, 0.005 * eta), eta, 0.04);
    }
}
