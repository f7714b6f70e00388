//! Trajectories: what a run has written is what its analysis sees after the fact, and what other people's tools see.
#![allow(clippy::unwrap_used)]

mod scene;

use scene::{fluid, pairs};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use zimm::prelude::*;

/// What is measured of a fluid, frame by frame.
struct Seen {
    structure: RadialDistribution<VerletList>,
    displacement: NonAffine,
    temperature: KineticTemperature,
}

/// One frame of it.
type Sight = (Vec<f64>, Vec<DVec3>, f64);

impl Seen {
    fn new() -> Self {
        let source = VerletList::new(0.0).unwrap();
        Self {
            structure: RadialDistribution::new(1.5, 30, source).unwrap(),
            displacement: NonAffine::default(),
            temperature: KineticTemperature::default(),
        }
    }

    fn of<B: Periodic>(&mut self, frame: &Frame<'_, B>) -> Sight {
        (
            self.structure.measure(frame, &()).unwrap(),
            self.displacement.measure(frame, &()).unwrap(),
            self.temperature.measure(frame, &()).unwrap().mean(),
        )
    }
}

/// Structure and displacements, which know positions alone, agree in every bit; the temperature to the rounding of
/// c + kappa r - kappa r. The run is long enough for the basis to change on the way, if it ever does.
fn after_the_fact<B: Periodic>(space: B, remaps: bool) {
    let mut system = fluid(space.clone(), 3.0, Clock::new(0.02, 1.0, 5).unwrap());
    let mut field = pairs(Dpd::new(25.0, 4.5).unwrap());
    let mut stepper = GrootWarren::new(0.65).unwrap();
    let (mut file, mut live, mut sights) = (Vec::new(), Seen::new(), Vec::new());
    let mut writer = XyzWriter::new(&mut file);
    let mut tilts = Vec::new();
    for step in 0..250 {
        stepper.step(&mut system, &mut field, &mut ()).unwrap();
        let frame = system.frame();
        let basis = system.boundary.lattice().basis();
        tilts.push(basis.y_axis.dot(basis.x_axis));
        if step % 5 == 0 {
            writer.write(&frame).unwrap();
            let unwrapped: Vec<_> = (0..frame.len()).map(|k| frame.unwrapped(k)).collect();
            sights.push((live.of(&frame), unwrapped));
        }
    }
    drop(writer);
    let jumps = tilts
        .windows(2)
        .filter(|pair| (pair[1] - pair[0]).abs() > 1.0);
    assert_eq!(jumps.count() > 0, remaps);

    let mut seen = Seen::new();
    let mut frames = 0;
    for (snapshot, (sight, unwrapped)) in XyzReader::new(file.as_slice()).zip(&sights) {
        let snapshot = snapshot.unwrap();
        let places = 0..snapshot.positions.len();
        assert!(
            places
                .map(|k| snapshot.unwrapped(k))
                .eq(unwrapped.iter().copied())
        );
        let system = snapshot.into_system(space.clone()).unwrap();
        let (structure, displacement, temperature) = seen.of(&system.frame());
        assert_eq!(structure, sight.0);
        assert_eq!(displacement, sight.1);
        assert!((temperature - sight.2).abs() < 1e-13);
        frames += 1;
    }
    assert_eq!(frames, 50);
}

#[test]
fn law_analysis_after_the_fact_is_that_of_the_run() {
    let edges = DVec3::new(4.0, 4.0, 3.5);
    let rate = |rate| Steady::new(rate).unwrap();
    after_the_fact(PeriodicBox::brick(edges).unwrap(), false);
    after_the_fact(LeesEdwards::new(edges, rate(0.5)).unwrap(), true);
    after_the_fact(KraynikReinelt::new(4.5, 3.5, rate(0.3)).unwrap(), true);
    after_the_fact(PlanarMixed::new(4.5, 3.5, 0.3, rate(0.4)).unwrap(), true);
}

/// What a tool is to find in a frame; particles by identity, from 0.
struct Truth {
    cell: Vec<f64>,
    corner: Vec<f64>,
    gradient: Vec<f64>,
    /// Distances of nearest images.
    distances: Vec<f64>,
    /// Below this, the images that any tool finds are the nearest.
    safe: f64,
    positions: Vec<DVec3>,
    velocities: Vec<DVec3>,
    images: Vec<IVec3>,
    masses: Vec<f64>,
    molecules: Vec<f64>,
    species: Vec<f64>,
    time: f64,
    step: f64,
}

impl Truth {
    /// Of a frame whose molecules are dimers, from identity 2 on.
    fn of<B: Boundary>(frame: &Frame<'_, B>, molecules: Molecules) -> Self {
        let places: Vec<usize> = (0..frame.len() as u32)
            .map(|id| frame.place(id).unwrap())
            .collect();
        let positions: Vec<DVec3> = places.iter().map(|&k| frame.positions[k]).collect();
        let gradient = frame.boundary.gradient();
        let cell = frame.boundary.cell();
        let apart = |i: usize, j: usize| {
            let nearest = frame.boundary.min_image(positions[j] - positions[i]);
            nearest.length()
        };
        let all = 0..frame.len();
        let row = |i| (0..frame.len()).map(move |j| apart(i, j));
        let widths = |h: DMat3| Lattice::new(h).unwrap().widths().min_element();
        Self {
            cell: cell.map_or(vec![], |h| h.to_cols_array().to_vec()),
            corner: cell.map_or(vec![], |h| (h * DVec3::splat(-0.5)).to_array().to_vec()),
            gradient: gradient.transpose().to_cols_array().to_vec(),
            distances: all.clone().flat_map(row).collect(),
            safe: 0.5 * cell.map_or(f64::INFINITY, widths),
            velocities: places
                .iter()
                .map(|&k| frame.velocities[k] + gradient * frame.positions[k])
                .collect(),
            images: places
                .iter()
                .filter_map(|&k| frame.images.get(k).copied())
                .collect(),
            masses: places.iter().map(|&k| frame.mass(k)).collect(),
            molecules: all
                .map(|id| id as u32)
                .map(|id| {
                    if molecules.identities().contains(&id) {
                        f64::from((id - 2) / 2 + 1)
                    } else {
                        0.0
                    }
                })
                .collect(),
            species: places
                .iter()
                .map(|&k| f64::from(frame.species(k)))
                .collect(),
            positions,
            time: frame.now.time,
            step: frame.now.step as f64,
        }
    }
}

/// A gas of particles of all kinds that flows through a cell, both files of it, and what they are to say.
struct Case {
    xyz: PathBuf,
    dump: PathBuf,
    frames: Vec<Truth>,
}

impl Case {
    fn of<B: Boundary>(name: &str, space: B, folder: &Path) -> Self {
        let count = 20;
        let mut rng = start::stream(11);
        let cube = Lattice::brick(DVec3::splat(6.0)).unwrap();
        let positions = start::uniform(&cube, count, &mut rng);
        let numbers = || (0..count as u32).map(|k| (7 * k + 3) % count as u32);
        let particles = Particles::new(positions)
            .unwrap()
            .with_masses(numbers().map(|k| 1.0 + f64::from(k % 3)).collect())
            .unwrap();
        let velocities = start::velocities(&particles, 1.0, &mut rng).unwrap();
        let particles = particles
            .with_velocities(velocities)
            .unwrap()
            .with_species(numbers().map(|k| (k % 4) as u8).collect())
            .unwrap()
            .with_ids(numbers().collect())
            .unwrap()
            .counting_images();
        let mut system = System::new(space, particles, Clock::new(0.1, 1.0, 11).unwrap());
        let mut stepper = GrootWarren::new(0.5).unwrap();
        let molecules = Molecules::linear(2, 4, 2).unwrap();
        let [xyz, dump] = ["xyz", "dump"].map(|kind| folder.join(format!("{name}.{kind}")));
        let mut xyz_writer =
            XyzWriter::new(std::fs::File::create(&xyz).unwrap()).with_molecules([molecules]);
        let mut dump_writer =
            DumpWriter::new(std::fs::File::create(&dump).unwrap()).with_molecules([molecules]);
        let mut frames = Vec::new();
        for step in 1..=60 {
            stepper.step(&mut system, &mut (), &mut ()).unwrap();
            if step % 12 == 0 {
                let frame = system.frame();
                xyz_writer.write(&frame).unwrap();
                dump_writer.write(&frame).unwrap();
                frames.push(Truth::of(&frame, molecules));
            }
        }
        Self { xyz, dump, frames }
    }
}

const EDGES: DVec3 = DVec3::new(5.0, 4.0, 6.0);

fn cases(folder: &Path) -> Vec<Case> {
    let rate = |rate| Steady::new(rate).unwrap();
    let tilted = DMat3::from_cols(
        DVec3::new(4.0, 1.0, -0.5),
        DVec3::new(-1.0, 4.5, 1.5),
        DVec3::new(0.5, 1.5, -5.0),
    );
    assert!(tilted.determinant() < 0.0);
    vec![
        Case::of("open", Open, folder),
        Case::of("brick", PeriodicBox::brick(EDGES).unwrap(), folder),
        Case::of(
            "left-handed",
            PeriodicBox::triclinic(tilted).unwrap(),
            folder,
        ),
        Case::of("shear", sheared(), folder),
        Case::of(
            "extension",
            KraynikReinelt::new(5.0, 4.0, rate(0.2)).unwrap(),
            folder,
        ),
        Case::of(
            "mixed",
            PlanarMixed::new(5.0, 4.0, 0.3, rate(0.2)).unwrap(),
            folder,
        ),
        Case::of(
            "uniaxial",
            UniaxialExtension::new(5.0, rate(0.1)).unwrap(),
            folder,
        ),
    ]
}

/// An interpreter that has a package, if the environment names one.
fn python(package: &str) -> Option<String> {
    let python = std::env::var("ZIMM_PYTHON").ok()?;
    let import = Command::new(&python)
        .args(["-c", &format!("import {package}")])
        .output();
    import.ok()?.status.success().then_some(python)
}

/// One object for each frame of each file, as `read_back.py` prints them.
fn read_back(python: &str, arguments: &[&str], files: &[&Path]) -> Vec<Value> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/read_back.py");
    let run = Command::new(python)
        .arg(script)
        .args(arguments)
        .args(files)
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{errors}");
    let text = String::from_utf8(run.stdout).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// All numbers of a field, row by row; none if it is not there.
fn numbers(frame: &Value, field: &str) -> Vec<f64> {
    fn collect(value: &Value, into: &mut Vec<f64>) {
        match value {
            Value::Array(entries) => entries.iter().for_each(|entry| collect(entry, into)),
            Value::Number(number) => into.extend(number.as_f64()),
            _ => {}
        }
    }
    let mut all = Vec::new();
    collect(&frame[field], &mut all);
    all
}

fn vectors(frame: &Value, field: &str) -> Vec<DVec3> {
    let numbers = numbers(frame, field);
    numbers.chunks_exact(3).map(DVec3::from_slice).collect()
}

#[track_caller]
fn agree(what: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (k, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!(
            (a - b).abs() <= 1e-11 * (1.0 + b.abs()),
            "{what} {k}: {a}, expected {b}"
        );
    }
}

/// Sorts rows of one or more numbers by the identities that a tool found in the file.
fn by_identity<A: Copy>(rows: &[A], identities: &[f64]) -> Vec<A> {
    let width = rows.len() / identities.len();
    let mut order: Vec<usize> = (0..identities.len()).collect();
    order.sort_by(|&i, &j| identities[i].total_cmp(&identities[j]));
    order
        .iter()
        .flat_map(|&k| rows[k * width..(k + 1) * width].iter().copied())
        .collect()
}

fn flat(vectors: &[DVec3]) -> Vec<f64> {
    vectors.iter().flat_map(|v| v.to_array()).collect()
}

/// Distances as the tool finds them; `any_shape`: the tool finds nearest images in any cell, not only close ones.
fn distances_agree(frame: &Value, truth: &Truth, identities: &[f64], any_shape: bool) {
    let n = identities.len();
    let rows = by_identity(&numbers(frame, "distances"), identities);
    let columns: Vec<f64> = (0..n)
        .flat_map(|j| (0..n).map(move |i| i * n + j))
        .map(|k| rows[k])
        .collect();
    let found = by_identity(&columns, identities);
    for (&a, &b) in found.iter().zip(&truth.distances) {
        let near = (a - b).abs() < 1e-11;
        assert!(
            near || (!any_shape && b > truth.safe && a > b),
            "{a}, expected {b}"
        );
    }
    let safe = truth.distances.iter().filter(|&&b| b <= truth.safe).count();
    assert!(found.len() == truth.distances.len() && safe > 2 * n);
}

/// A frame of extended XYZ is as it was in the scene.
fn xyz_agrees(frame: &Value, truth: &Truth, identities: &[f64], any_shape: bool) {
    agree("cell", &numbers(frame, "cell"), &truth.cell);
    distances_agree(frame, truth, identities, any_shape);
    for (field, expected) in [
        ("positions", &truth.positions),
        ("velocities", &truth.velocities),
    ] {
        agree(
            field,
            &by_identity(&numbers(frame, field), identities),
            &flat(expected),
        );
    }
    let images: Vec<_> = truth.images.iter().map(|n| n.as_dvec3()).collect();
    agree(
        "images",
        &by_identity(&numbers(frame, "images"), identities),
        &flat(&images),
    );
    agree("time", &numbers(frame, "time"), &[truth.time]);
    agree("step", &numbers(frame, "step"), &[truth.step]);
}

/// A frame of a dump is turned: whatever does not depend on directions is as it was.
fn dump_agrees(frame: &Value, truth: &Truth, identities: &[f64], any_shape: bool) {
    distances_agree(frame, truth, identities, any_shape);
    agree("step", &numbers(frame, "step"), &[truth.step]);
    let (mut found, mut expected) = (vectors(frame, "cell"), Vec::new());
    assert_eq!(found.len() * 3, truth.cell.len());
    for (k, vector) in truth
        .cell
        .chunks_exact(3)
        .map(DVec3::from_slice)
        .enumerate()
    {
        let basis = DMat3::from_cols_slice(&truth.cell);
        let mirrored = k == 2 && basis.determinant() < 0.0;
        expected.push(if mirrored { -vector } else { vector });
    }
    for field in ["positions", "velocities"] {
        found.extend(by_identity(&vectors(frame, field), identities));
    }
    expected.extend(truth.positions.iter().chain(&truth.velocities));
    let products = |v: &[DVec3]| -> Vec<f64> {
        let with_all = |a: &DVec3| v.iter().map(|b| a.dot(*b)).collect::<Vec<f64>>();
        v.iter().flat_map(with_all).collect()
    };
    agree("products", &products(&found), &products(&expected));
}

/// A file that ASE has read and written again, with 8 decimals, is still a trajectory of the scene.
fn has_rewritten(python: &str, shear: &Case, again: &Path) {
    read_back(python, &["rewrite"], &[&shear.xyz, again]);
    let file = std::io::BufReader::new(std::fs::File::open(again).unwrap());
    let snapshots: Vec<_> = XyzReader::new(file).map(Result::unwrap).collect();
    assert_eq!(snapshots.len(), shear.frames.len());
    for (snapshot, truth) in snapshots.into_iter().zip(&shear.frames) {
        let system = snapshot.into_system(sheared()).unwrap();
        let frame = system.frame();
        assert_eq!(
            (frame.now.time, frame.now.step as f64),
            (truth.time, truth.step)
        );
        for place in 0..frame.len() {
            let id = frame.id(place) as usize;
            let peculiar = truth.velocities[id] - frame.boundary.gradient() * truth.positions[id];
            assert!((frame.positions[place] - truth.positions[id]).length() < 2e-8);
            assert!((frame.velocities[place] - peculiar).length() < 4e-8);
            assert_eq!(frame.images[place], truth.images[id]);
            assert_eq!(frame.mass(place), truth.masses[id]);
        }
    }
}

fn sheared() -> LeesEdwards<Steady> {
    LeesEdwards::new(EDGES, Steady::new(0.3).unwrap()).unwrap()
}

// Needs Python with the packages ase and ovito: `ZIMM_PYTHON=venv/bin/python cargo test -p zimm-tests --test output`.
//
// Distances under periodic images, velocities, cell, images, species, masses, molecules and time of 35 frames, as ASE
// and OVITO read them. In the cells that are tilted most, OVITO takes rounded images for nearest ones beyond half the
// width of the cell.
#[test]
fn reference_other_tools_see_the_same() {
    let folder = std::env::temp_dir().join(format!("zimm-output-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let cases = cases(&folder);
    let truths: Vec<&Truth> = cases.iter().flat_map(|case| &case.frames).collect();
    let xyz: Vec<&Path> = cases.iter().map(|case| case.xyz.as_path()).collect();
    let dump: Vec<&Path> = cases.iter().map(|case| case.dump.as_path()).collect();
    let in_order: Vec<f64> = (0..20).map(f64::from).collect();
    let missing =
        |package| println!("skipped: ZIMM_PYTHON names no interpreter that has {package}");

    if let Some(python) = python("ase") {
        let frames = read_back(&python, &["ase", "extxyz"], &xyz);
        assert_eq!(frames.len(), truths.len());
        for (frame, truth) in frames.iter().zip(&truths) {
            let identities = numbers(frame, "identities");
            xyz_agrees(frame, truth, &identities, true);
            agree(
                "species",
                &by_identity(&numbers(frame, "species"), &identities),
                &truth.species,
            );
        }
        let frames = read_back(&python, &["ase", "lammps-dump-text"], &dump);
        assert_eq!(frames.len(), truths.len());
        for (frame, truth) in frames.iter().zip(&truths) {
            // Its reader sorts by identity.
            dump_agrees(frame, truth, &in_order, true);
            agree("species", &numbers(frame, "species"), &truth.species);
        }
        println!("ASE: {} frames of each format agree", frames.len());
        has_rewritten(&python, &cases[3], &folder.join("again.xyz"));
    } else {
        missing("ase");
    }

    if let Some(python) = python("ovito") {
        for files in [&xyz, &dump] {
            let frames = read_back(&python, &["ovito"], files);
            assert_eq!(frames.len(), truths.len());
            for (frame, truth) in frames.iter().zip(&truths) {
                let identities = numbers(frame, "identities");
                if files == &xyz {
                    xyz_agrees(frame, truth, &identities, false);
                    agree("corner", &numbers(frame, "corner"), &truth.corner);
                    let at_rest = truth.gradient.iter().all(|&x| x == 0.0);
                    let gradient = numbers(frame, "gradient");
                    assert!(at_rest || gradient.len() == 9);
                    agree("gradient", &gradient, &truth.gradient[..gradient.len()]);
                } else {
                    dump_agrees(frame, truth, &identities, false);
                    agree("time", &numbers(frame, "time"), &[truth.time]);
                }
                for (field, expected) in
                    [("masses", &truth.masses), ("molecules", &truth.molecules)]
                {
                    agree(
                        field,
                        &by_identity(&numbers(frame, field), &identities),
                        expected,
                    );
                }
            }
        }
        println!("OVITO: {} frames of each format agree", truths.len());
    } else {
        missing("ovito");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
