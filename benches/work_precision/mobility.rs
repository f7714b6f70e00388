//! Products with the periodic mobility of Rotne, Prager and Yamakawa, and its roots: CPU time on one thread against the
//! number of beads at a relative error of 1e-3, and at 1 000 beads the error that is delivered against CPU time, for
//! tolerances from 1e-2 to 1e-8. Direct sums with and without storage, and the mesh.
//!
//! Two scenes of the same density: theta chains of 10 beads, b = 50, h* = 0.25, at c/c* = 1, and beads at random places.
//! Errors are against a direct sum at 1e-10.

use crate::chart::{Curve, Panel, slope};
use crate::{Problem, Task};
use cpu_time::ThreadTime;
use plotters::prelude::SeriesLabelPosition;
use std::f64::consts::PI;
use std::fs;
use zimm::prelude::*;

const TOLERANCE: f64 = 1e-3;
const HSTAR: f64 = 0.25;
const EXTENSIBILITY: f64 = 50.0;
const LENGTH: u32 = 10;
const METHODS: [&str; 3] = ["direct, stored", "direct", "mesh"];
const ROOTS: [&str; 5] = [
    "Cholesky",
    "Chebyshev",
    "Lanczos",
    "SplitNoise",
    "Lanczos, direct",
];
const SCENES: [&str; 2] = ["chains", "random"];

/// What was timed.
struct Row {
    what: &'static str,
    scene: &'static str,
    beads: u32,
    tolerance: f64,
    /// CPU seconds of binding, and of a product or root.
    bind: f64,
    seconds: f64,
    /// Relative error of the product.
    error: Option<f64>,
}

pub(crate) fn figure(task: &Task) -> Result<(), Problem> {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    one.install(|| on_one_thread(task))
}

fn on_one_thread(task: &Task) -> Result<(), Problem> {
    let sizes: &[u32] = if task.quick {
        &[100, 1000, 3000, 10_000, 30_000]
    } else {
        &[
            100, 180, 300, 560, 1000, 1800, 3000, 4000, 5600, 7500, 10_000, 14_000, 20_000, 30_000,
        ]
    };
    print_memory(task.quick)?;
    let mut rows = Vec::new();
    for scene in SCENES {
        for &beads in sizes {
            if task.quick && scene == "random" && beads > 3000 {
                continue;
            }
            products(
                &mut rows,
                &Scene::new(scene, beads)?,
                TOLERANCE,
                task.quick,
                None,
            )?;
        }
    }
    for &beads in sizes {
        roots(&mut rows, &Scene::new("chains", beads)?, task.quick)?;
    }
    let scene = Scene::new("chains", 1000)?;
    let exact = scene.velocities(Ewald::new(1.0, radius(), 1e-10)?)?;
    let other = scene.velocities(Mesh::new(1.0, radius(), 1e-10)?)?;
    println!(
        "1000 beads: direct sum and mesh at 1e-10 differ by {:.1e}",
        difference(&other, &exact)
    );
    for exponent in 2..=8 {
        products(
            &mut rows,
            &scene,
            10_f64.powi(-exponent),
            task.quick,
            Some(&exact),
        )?;
    }
    task.csv(
        "what,scene,beads,tolerance,bind_seconds,seconds,error",
        rows.iter().map(|row| {
            let error = row
                .error
                .map_or_else(String::new, |error| format!("{error:e}"));
            let (what, scene, beads, tolerance) = (row.what, row.scene, row.beads, row.tolerance);
            format!(
                "\"{what}\",{scene},{beads},{tolerance:e},{:e},{:e},{error}",
                row.bind, row.seconds
            )
        }),
    )?;
    task.draw(&[
        products_panel(&rows),
        errors_panel(&rows),
        roots_panel(&rows),
    ])?;
    check(&rows)
}

fn products_panel(rows: &[Row]) -> Panel {
    let curve = |(colour, what): (usize, &'static str), scene: &'static str| Curve {
        label: format!("{what}, {scene}"),
        colour,
        filled: scene == "chains",
        points: against_beads(rows, what, scene, |row| row.seconds),
    };
    Panel {
        title: "A product at 1e-3",
        x: "beads",
        y: "CPU time, s",
        legend: SeriesLabelPosition::LowerRight,
        curves: METHODS
            .into_iter()
            .enumerate()
            .flat_map(|method| SCENES.map(|scene| curve(method, scene)))
            .collect(),
    }
}

fn errors_panel(rows: &[Row]) -> Panel {
    let curve = |(colour, what): (usize, &'static str)| Curve {
        label: what.into(),
        colour,
        filled: true,
        points: rows
            .iter()
            .filter(|row| row.what == what)
            .filter_map(|row| Some((row.seconds, row.error?)))
            .collect(),
    };
    Panel {
        title: "A product of 1000 beads, 1e-2 to 1e-8",
        x: "CPU time, s",
        y: "relative error delivered",
        legend: SeriesLabelPosition::LowerLeft,
        curves: METHODS.into_iter().enumerate().map(curve).collect(),
    }
}

fn roots_panel(rows: &[Row]) -> Panel {
    let curve = |(colour, what): (usize, &'static str)| Curve {
        label: what.into(),
        colour,
        filled: true,
        points: against_beads(rows, what, "chains", |row| row.seconds),
    };
    Panel {
        title: "A root at 1e-3, chains",
        x: "beads",
        y: "CPU time, s",
        legend: SeriesLabelPosition::LowerRight,
        curves: ROOTS.into_iter().enumerate().map(curve).collect(),
    }
}

/// What the figure is there to show, in numbers.
fn check(rows: &[Row]) -> Result<(), Problem> {
    let of = |what, part: fn(&Row) -> f64| against_beads(rows, what, "chains", part);
    let from = |least: f64, mut points: Vec<(f64, f64)>| {
        points.retain(|(beads, _)| *beads >= least);
        points
    };
    let mut wrong = Vec::new();
    // A configuration is bound once for each step. Without storage, the direct sum comes to its power late.
    for (what, least, bound, allowed) in [
        ("mesh", 3000.0, true, 0.0..1.15),
        ("direct", 10_000.0, false, 1.4..1.6),
        ("direct, stored", 1000.0, false, 1.4..1.6),
    ] {
        let alone = slope(&from(least, of(what, |row| row.seconds)));
        let both = slope(&from(least, of(what, |row| row.bind + row.seconds)));
        println!(
            "{what}: a product takes N^{alone:.2}, with binding N^{both:.2}, from {least} beads on"
        );
        let found = if bound { both } else { alone };
        if !allowed.contains(&found) {
            wrong.push(format!("{what}: exponent {found:.2}, expected {allowed:?}"));
        }
    }
    for what in ROOTS {
        let points = from(300.0, of(what, |row| row.seconds));
        if points.len() > 1 {
            println!(
                "{what}: time of a root grows as N^{:.2} from 300 beads on",
                slope(&points)
            );
        }
    }
    let mesh = |part| of("mesh", part);
    for what in ["direct, stored", "direct"] {
        let alone = crossover(&of(what, |row| row.seconds), &mesh(|row| row.seconds));
        let bound = crossover(
            &of(what, |row| row.bind + row.seconds),
            &mesh(|row| row.bind + row.seconds),
        );
        println!(
            "the mesh is faster than {what}: a product from {alone} beads on, with binding from {bound} on"
        );
    }
    let root = |what| of(what, |row| row.bind + row.seconds);
    let step = crossover(&root("Lanczos, direct"), &root("SplitNoise"));
    println!(
        "binding and noise: the mesh with SplitNoise is faster than direct sums with Lanczos from {step} on"
    );
    for row in rows {
        if let Some(error) = row.error {
            let (what, tolerance, time) = (row.what, row.tolerance, 1e3 * row.seconds);
            println!(
                "1000 beads, {what}, tolerance {tolerance:.0e}: error {error:.1e}, {time:.2} ms"
            );
            if error > 1.5 * tolerance {
                wrong.push(format!(
                    "{what}: error {error:e} at a tolerance of {tolerance:e}"
                ));
            }
        }
    }
    if wrong.is_empty() {
        Ok(())
    } else {
        Err(wrong.join("; ").into())
    }
}

/// From how many beads on the second is always below the first, of those that were tried.
fn crossover(first: &[(f64, f64)], second: &[(f64, f64)]) -> f64 {
    let mut least = f64::INFINITY;
    for ((beads, a), (_, b)) in first.iter().zip(second).rev() {
        if b >= a {
            break;
        }
        least = *beads;
    }
    least
}

fn against_beads(rows: &[Row], what: &str, scene: &str, part: fn(&Row) -> f64) -> Vec<(f64, f64)> {
    let mine = |row: &&Row| row.what == what && row.scene == scene && row.error.is_none();
    rows.iter()
        .filter(mine)
        .map(|row| (f64::from(row.beads), part(row)))
        .collect()
}

fn radius() -> f64 {
    PI.sqrt() * HSTAR
}

/// Beads in a cube, and forces on them.
struct Scene {
    name: &'static str,
    system: System<PeriodicBox>,
    forces: Vec<DVec3>,
}

impl Scene {
    fn new(name: &'static str, beads: u32) -> Result<Self, Problem> {
        let chains = Molecules::linear(0, beads / LENGTH, LENGTH)?;
        let n = f64::from(LENGTH);
        let bond2 = 3.0 * EXTENSIBILITY / (EXTENSIBILITY + 5.0);
        let gyration = ((n * n - 1.0) / (6.0 * n) * bond2).sqrt();
        let edge = cell_edge(
            beads as usize,
            overlap_concentration(LENGTH as usize, gyration)?,
        )?;
        let space = PeriodicBox::cubic(edge)?;
        let mut rng = start::stream(1);
        let positions = if name == "chains" {
            let bond = start::BondLength::new(&Fene::new(1.0, EXTENSIBILITY.sqrt())?, 1.0)?;
            start::chains(space.lattice(), &chains, |rng| bond.sample(rng), &mut rng)
        } else {
            start::uniform(space.lattice(), beads as usize, &mut rng)
        };
        let system = System::new(space, Particles::new(positions)?, Clock::new(0.01, 1.0, 1)?);
        let mut forces = Vec::new();
        let frame = system.frame();
        let white = White::new(system.clock.next(), &frame);
        forces.extend((0..frame.len()).map(|place| white.bead(place)));
        Ok(Self {
            name,
            system,
            forces,
        })
    }

    fn beads(&self) -> u32 {
        self.forces.len() as u32
    }

    fn velocities(&self, mut mobility: impl Mobility<PeriodicBox>) -> Result<Vec<DVec3>, Problem> {
        let mut velocities = vec![DVec3::ZERO; self.forces.len()];
        mobility.bind(&self.system.frame())?;
        mobility.apply(&self.forces, &mut velocities);
        Ok(velocities)
    }
}

fn difference(found: &[DVec3], exact: &[DVec3]) -> f64 {
    let off: f64 = found
        .iter()
        .zip(exact)
        .map(|(a, b)| (*a - *b).length_squared())
        .sum();
    (off / exact.iter().map(|v| v.length_squared()).sum::<f64>()).sqrt()
}

/// CPU seconds of something, the least of several times.
fn timed(
    quick: bool,
    mut work: impl FnMut() -> Result<(), MobilityError>,
) -> Result<f64, MobilityError> {
    let (least, budget) = if quick { (2, 0.03) } else { (3, 0.1) };
    let (mut best, mut total, mut count) = (f64::INFINITY, 0.0, 0);
    while count < least && total < 10.0 * budget || total < budget {
        let start = ThreadTime::now();
        work()?;
        let seconds = start.elapsed().as_secs_f64();
        best = best.min(seconds);
        total += seconds;
        count += 1;
    }
    Ok(best)
}

/// Times every method's product.
fn products(
    rows: &mut Vec<Row>,
    scene: &Scene,
    tolerance: f64,
    quick: bool,
    exact: Option<&[DVec3]>,
) -> Result<(), Problem> {
    let row = |what, times, velocities: &[DVec3]| {
        let [bind, seconds] = times;
        let error = exact.map(|exact| difference(velocities, exact));
        Row {
            what,
            scene: scene.name,
            beads: scene.beads(),
            tolerance,
            bind,
            seconds,
            error,
        }
    };
    let [stored, direct, mesh] = METHODS;
    let radius = radius();
    let (times, found) = product(scene, quick, Ewald::new(1.0, radius, tolerance)?)?;
    rows.push(row(stored, times, &found));
    let (times, found) = product(
        scene,
        quick,
        Ewald::new(1.0, radius, tolerance)?.without_storage(),
    )?;
    rows.push(row(direct, times, &found));
    let (times, found) = product(scene, quick, Mesh::new(1.0, radius, tolerance)?)?;
    rows.push(row(mesh, times, &found));
    Ok(())
}

/// CPU seconds of binding and of a product, and the product.
fn product(
    scene: &Scene,
    quick: bool,
    mut mobility: impl Mobility<PeriodicBox>,
) -> Result<([f64; 2], Vec<DVec3>), Problem> {
    // The first time also chooses splits and transforms, once for all steps.
    mobility.bind(&scene.system.frame())?;
    let bind = timed(quick, || mobility.bind(&scene.system.frame()))?;
    let mut velocities = vec![DVec3::ZERO; scene.forces.len()];
    let seconds = timed(quick, || {
        velocities.fill(DVec3::ZERO);
        mobility.apply(&scene.forces, &mut velocities);
        Ok(())
    })?;
    Ok(([bind, seconds], velocities))
}

/// Times every root, as far as it is a matter of seconds.
fn roots(rows: &mut Vec<Row>, scene: &Scene, quick: bool) -> Result<(), Problem> {
    let most = if quick {
        [100, 3000, 3000, 30_000, 1000]
    } else {
        [1000, 30_000, 30_000, 30_000, 10_000]
    };
    let beads = scene.beads();
    let mesh = || Mesh::new(1.0, radius(), TOLERANCE);
    let direct = || Ewald::new(1.0, radius(), TOLERANCE);
    for (what, most) in ROOTS.into_iter().zip(most) {
        if beads > most {
            continue;
        }
        let [bind, seconds] = match what {
            "Cholesky" => root(scene, quick, direct()?, Cholesky::new(TOLERANCE)?)?,
            "Chebyshev" => root(scene, quick, mesh()?, Chebyshev::new(TOLERANCE)?)?,
            "Lanczos" => root(scene, quick, mesh()?, Lanczos::new(TOLERANCE)?)?,
            "SplitNoise" => root(scene, quick, mesh()?, SplitNoise::new(TOLERANCE)?)?,
            _ => root(scene, quick, direct()?, Lanczos::new(TOLERANCE)?)?,
        };
        rows.push(Row {
            what,
            scene: scene.name,
            beads,
            tolerance: TOLERANCE,
            bind,
            seconds,
            error: None,
        });
    }
    Ok(())
}

fn root<M: Mobility<PeriodicBox>>(
    scene: &Scene,
    quick: bool,
    mut mobility: M,
    mut root: impl Root<PeriodicBox, M>,
) -> Result<[f64; 2], Problem> {
    let frame = scene.system.frame();
    let white = White::new(scene.system.clock.next(), &frame);
    mobility.bind(&frame)?;
    let bind = timed(quick, || mobility.bind(&frame))?;
    let mut moved = vec![DVec3::ZERO; frame.len()];
    // Chebyshev's first root measures its bounds.
    root.add(&mut mobility, &white, 1.0, &mut moved)?;
    let seconds = timed(quick, || root.add(&mut mobility, &white, 1.0, &mut moved))?;
    Ok([bind, seconds])
}

/// Memory of a bound mobility after a product: what the process grew by. Nothing is given back in between.
fn print_memory(quick: bool) -> Result<(), Problem> {
    let sizes: &[u32] = if quick {
        &[3000, 10_000]
    } else {
        &[3000, 10_000, 30_000]
    };
    let (mut stored, mut direct, mut mesh) = (Vec::new(), Vec::new(), Vec::new());
    for &beads in sizes {
        let scene = Scene::new("chains", beads)?;
        let mut grown = [0.0; 3];
        let mut last = resident();
        let mut note = |k: usize| {
            let now = resident();
            if let (Some(now), Some(before)) = (now, last) {
                grown[k] = (now - before) / f64::from(beads);
            }
            last = now;
        };
        let mut mobility = Ewald::new(1.0, radius(), TOLERANCE)?;
        warm(&scene, &mut mobility)?;
        note(0);
        stored.push(mobility);
        let mut mobility = Ewald::new(1.0, radius(), TOLERANCE)?.without_storage();
        warm(&scene, &mut mobility)?;
        note(1);
        direct.push(mobility);
        let mut mobility = Mesh::new(1.0, radius(), TOLERANCE)?;
        warm(&scene, &mut mobility)?;
        note(2);
        mesh.push(mobility);
        let [a, b, c] = grown;
        println!("{beads} beads: bytes a bead: direct, stored {a:.0}; direct {b:.0}; mesh {c:.0}");
    }
    Ok(())
}

fn warm(scene: &Scene, mobility: &mut impl Mobility<PeriodicBox>) -> Result<(), Problem> {
    mobility.bind(&scene.system.frame())?;
    let mut velocities = vec![DVec3::ZERO; scene.forces.len()];
    mobility.apply(&scene.forces, &mut velocities);
    Ok(())
}

/// Bytes of memory that the process holds, where the system tells.
fn resident() -> Option<f64> {
    const PAGE: f64 = 4096.0;
    let text = fs::read_to_string("/proc/self/statm").ok()?;
    let pages: f64 = text.split_whitespace().nth(1)?.parse().ok()?;
    Some(PAGE * pages)
}
