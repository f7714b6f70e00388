//! Checkpoints: every bit comes back, the run goes on as if nothing had been, and nothing else is taken for one.

#![allow(clippy::unwrap_used)]

mod common;

use common::Cell;
use proptest::prelude::*;
use std::path::PathBuf;
use zimm_core::{
    Boundary, Central, CheckpointError, Clock, DMat3, DVec3, ForceField, IVec3, Now, Open, Pair,
    PairForce, Pairwise, ParticleError, Particles, Periodic, Reads, System, VerletList, load,
    load_file, noise::Domain, save, save_file, start,
};

/// Everything that a system holds, as words.
fn bits<B: Boundary>(system: &System<B>) -> Vec<Vec<u64>> {
    let (now, next, p) = (system.clock.now(), system.clock.next(), &system.particles);
    let vectors = |column: &[DVec3]| {
        column
            .iter()
            .flat_map(|v| v.to_array())
            .map(f64::to_bits)
            .collect()
    };
    let moment = |n: Now| {
        [
            n.time.to_bits(),
            n.dt.to_bits(),
            n.kt.to_bits(),
            n.seed,
            n.step,
        ]
    };
    let cell = system.boundary.cell().unwrap_or(DMat3::ZERO);
    vec![
        moment(now).into_iter().chain(moment(next)).collect(),
        cell.to_cols_array().map(f64::to_bits).to_vec(),
        vectors(p.positions()),
        vectors(p.velocities()),
        vectors(p.forces()),
        p.masses().iter().map(|m| m.to_bits()).collect(),
        p.species().iter().map(|&s| s.into()).collect(),
        p.images()
            .iter()
            .flat_map(|n| n.to_array())
            .map(|n| n as u64)
            .collect(),
        p.ids().iter().map(|&id| id.into()).collect(),
        (0..p.len() as u32)
            .map(|id| system.frame().place(id).unwrap() as u64)
            .collect(),
    ]
}

fn bytes<B: Boundary>(system: &System<B>) -> Vec<u8> {
    let mut bytes = Vec::new();
    save(system, &mut (), &mut bytes).unwrap();
    bytes
}

fn read<B: Boundary>(boundary: B, mut bytes: &[u8]) -> Result<System<B>, CheckpointError> {
    load(boundary, &mut bytes)
}

fn shear(rate: f64) -> DMat3 {
    DMat3::from_cols(DVec3::ZERO, rate * DVec3::X, DVec3::ZERO)
}

fn cube(edge: f64) -> DMat3 {
    DMat3::from_diagonal(DVec3::splat(edge))
}

/// Numbers whose bits are easily lost: zeros of either sign, the smallest, the largest, thirds.
fn number() -> impl Strategy<Value = f64> {
    let awkward = [
        0.0,
        -0.0,
        f64::MIN_POSITIVE,
        5e-324,
        -f64::MAX,
        1.0 / 3.0,
        -1e-200,
    ];
    prop_oneof![prop::sample::select(awkward.to_vec()), -10.0..10.0]
}

fn vectors(n: usize) -> impl Strategy<Value = Vec<DVec3>> {
    let vector = [number(), number(), number()].prop_map(DVec3::from_array);
    prop::collection::vec(vector, n)
}

/// Particles with any set of columns.
fn particles() -> impl Strategy<Value = Particles> {
    (0_usize..12, any::<[bool; 6]>()).prop_flat_map(|(n, has)| {
        let column = move |k: usize| vectors(if has[k] { n } else { 0 });
        let images = prop::collection::vec(any::<[i32; 3]>(), if has[4] { n } else { 0 });
        let masses = prop::collection::vec(1e-3..1e3, n);
        let species = prop::collection::vec(any::<u8>(), n);
        let order = Just((0..n as u32).collect::<Vec<_>>()).prop_shuffle();
        (
            vectors(n),
            column(0),
            column(1),
            masses,
            species,
            images,
            order,
        )
            .prop_map(
                move |(positions, velocities, forces, masses, species, images, order)| {
                    let mut particles = Particles::new(positions).unwrap();
                    if has[2] {
                        particles = particles.with_masses(masses).unwrap();
                    }
                    if has[3] {
                        particles = particles.with_species(species).unwrap();
                    }
                    if has[5] {
                        particles = particles.with_ids(order).unwrap();
                    }
                    let columns = particles.columns_mut();
                    *columns.velocities = velocities;
                    *columns.forces = forces;
                    *columns.images = images.into_iter().map(IVec3::from_array).collect();
                    particles
                },
            )
    })
}

fn clock() -> impl Strategy<Value = Clock> {
    (1e-6..1.0, 0.0..3.0, any::<u64>(), 0_u64..50, 1e-6..1.0).prop_map(
        |(dt, kt, seed, steps, other)| {
            let mut clock = Clock::new(dt, kt, seed).unwrap();
            (0..steps).for_each(|_| clock.tick());
            if steps % 2 == 1 {
                clock.set_dt(other).unwrap();
                (0..steps / 3).for_each(|_| clock.tick());
            }
            clock
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn law_every_bit_comes_back(particles in particles(), clock in clock(), rate in -2.0..2.0) {
        let boundary = Cell::flowing(cube(3.0), shear(rate));
        let mut in_cell = System { boundary: boundary.clone(), particles: particles.clone(), clock };
        in_cell.boundary.advance(clock.now().time);
        let again = read(boundary, &bytes(&in_cell)).unwrap();
        prop_assert_eq!(bits(&again), bits(&in_cell));
        let still = Cell::at_rest(cube(3.0));
        let at_rest = System { boundary: still.clone(), particles: particles.clone(), clock };
        let again = read(still, &bytes(&at_rest)).unwrap();
        prop_assert_eq!(bits(&again), bits(&at_rest));
        let in_open = System { boundary: Open, particles, clock };
        let again = read(Open, &bytes(&in_open)).unwrap();
        prop_assert_eq!(bits(&again), bits(&in_open));
    }

    /// Whatever bytes come, the answer is an error and not a panic; the head is good now and then.
    #[test]
    fn extreme_random_bytes_are_no_checkpoint(
        keep in 0_usize..40,
        noise in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let mut file = bytes(&small());
        file.truncate(keep);
        file.extend(noise);
        prop_assert!(read(Open, &file).is_err());
    }
}

/// Soft repulsion, friction and noise.
#[derive(Clone)]
struct Fluid;

impl PairForce for Fluid {
    const READS: Reads = Reads {
        velocity: true,
        noise: true,
        species: false,
    };

    fn cutoff(&self) -> f64 {
        1.0
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, now: &Now) -> Central {
        let r = pair.r2.sqrt();
        let w = (1.0 - r).max(0.0);
        Central {
            conservative: 25.0 * w / r,
            dissipative: -4.5 * w * w * pair.rv / pair.r2,
            random: (9.0 * now.kt / now.dt).sqrt() * w * pair.noise.uniform(Domain::DPD) / r,
        }
    }
}

/// One step of Euler's scheme in a flow with wrapping and image counts: crude, but it reads all that a scheme reads.
fn step<B: Periodic>(system: &mut System<B>, field: &mut impl ForceField<B>) {
    if system.particles.forces().is_empty() {
        let mut forces = vec![DVec3::ZERO; system.particles.len()];
        field
            .accumulate(&system.frame(), &mut forces, &mut ())
            .unwrap();
        *system.particles.columns_mut().forces = forces;
    }
    let (before, next) = (system.clock.now(), system.clock.next());
    let carry = system.boundary.carry(before.time, next.time);
    system.clock.tick();
    let remap = system.boundary.advance(next.time);
    let columns = system.particles.columns_mut();
    for (k, r) in columns.positions.iter_mut().enumerate() {
        columns.velocities[k] += before.dt * columns.forces[k];
        let (folded, taken) = system
            .boundary
            .wrap(carry * *r + before.dt * columns.velocities[k]);
        *r = folded;
        columns.images[k] = remap.apply(columns.images[k]) + taken;
    }
    let mut forces = vec![DVec3::ZERO; system.particles.len()];
    field
        .accumulate(&system.frame(), &mut forces, &mut ())
        .unwrap();
    *system.particles.columns_mut().forces = forces;
}

/// Going on and starting again agree in every bit for twenty steps, over a change of basis and of the time step. The
/// last lines show that this takes a barrier: a run that is not interrupted sums in another order.
#[test]
fn law_going_on_and_starting_again_agree_bit_for_bit() {
    let boundary = || Cell::flowing(cube(6.0), shear(2.0));
    let mut rng = start::stream(3);
    let positions = start::grid(boundary().lattice(), 600);
    let particles = Particles::new(positions).unwrap().counting_images();
    let velocities = start::velocities(&particles, 1.0, &mut rng).unwrap();
    let particles = particles.with_velocities(velocities).unwrap();
    let clock = Clock::new(0.01, 1.0, 77).unwrap();
    let mut system = System::new(boundary(), particles, clock);
    let field = || Pairwise::new(Fluid, VerletList::new(0.6).unwrap());
    let mut lists = field();
    for _ in 0..10 {
        step(&mut system, &mut lists);
    }
    system.clock.set_dt(0.008).unwrap();
    let (mut uninterrupted, mut old_lists) = (system.clone(), lists.clone());
    let mut file = Vec::new();
    save(&system, &mut lists, &mut file).unwrap();
    let (mut again, mut new_lists) = (read(boundary(), &file).unwrap(), field());
    assert_eq!(bits(&again), bits(&system));
    for _ in 0..20 {
        step(&mut system, &mut lists);
        step(&mut again, &mut new_lists);
        assert!(bits(&again) == bits(&system));
    }
    assert!(system.particles.images().iter().any(|n| n.y != 0));
    assert!(system.clock.now().time > 0.25);
    step(&mut uninterrupted, &mut old_lists);
    let mut at_once = read(boundary(), &file).unwrap();
    step(&mut at_once, &mut field());
    assert!(bits(&uninterrupted) != bits(&at_once));
}

/// Two particles with all columns in open space.
fn small() -> System<Open> {
    let mut particles = Particles::new(vec![DVec3::X, DVec3::Y])
        .and_then(|p| p.with_velocities(vec![DVec3::Z, DVec3::ZERO]))
        .and_then(|p| p.with_masses(vec![1.0, 2.0]))
        .and_then(|p| p.with_species(vec![3, 4]))
        .and_then(|p| p.with_ids(vec![1, 0]))
        .unwrap()
        .counting_images();
    *particles.columns_mut().forces = vec![DVec3::ONE; 2];
    System::new(Open, particles, Clock::new(0.5, 1.0, 9).unwrap())
}

/// Replaces bytes and makes the checksum good again, as only somebody who wants to can: FNV-1a once more.
fn forged(mut file: Vec<u8>, at: usize, with: &[u8]) -> Vec<u8> {
    file[at..at + with.len()].copy_from_slice(with);
    let end = file.len() - 8;
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for &byte in &file[..end] {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
    file[end..].copy_from_slice(&hash.to_le_bytes());
    file
}

// Places in the file of `small`: the head of 24 bytes, the clock of 48, no cell, a gradient of nine.
const DT: usize = 24;
const STEP: usize = 48;
const EPOCH_STEP: usize = 56;
const EPOCH_TIME: usize = 64;
const CELL: usize = 72;
const POSITIONS: usize = CELL + 8 + 8 + 72;
const VELOCITIES: usize = POSITIONS + 8 + 48;
const FORCES: usize = VELOCITIES + 8 + 48;
const MASSES: usize = FORCES + 8 + 48;
const IDS: usize = MASSES + (8 + 16) + (8 + 2) + (8 + 24);

/// The layout, byte by byte; whoever changes it has to change its version.
#[test]
fn reference_the_layout_is_pinned() {
    let file = bytes(&small());
    assert_eq!(file.len(), IDS + 8 + 8 + 8);
    assert_eq!(file[..8], [0x7a, 0x69, 0x6d, 0x6d, 0x0d, 0x0a, 0x1a, 0x0a]);
    let word = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap());
    assert_eq!(word(8), 1 | 1 << 32);
    assert_eq!(word(16), (file.len() - 32) as u64);
    assert_eq!(
        (word(DT), word(STEP - 8), word(CELL)),
        (0.5_f64.to_bits(), 9, 0)
    );
    let counts = [POSITIONS, VELOCITIES, FORCES, MASSES, IDS].map(word);
    assert_eq!((counts, word(CELL + 8)), ([2; 5], 9));
    assert_eq!(forged(file.clone(), DT, &0.5_f64.to_le_bytes()), file);
}

#[test]
fn extreme_a_foreign_file_is_refused() {
    for foreign in [
        &b"\x89PNG\r\n\x1a\n and so on"[..],
        b"zimmer",
        b"x",
        &[0; 100],
    ] {
        match read(Open, foreign) {
            Err(CheckpointError::Foreign { found }) => {
                assert_eq!(found, foreign[..foreign.len().min(8)])
            }
            other => panic!("{other:?}"),
        }
    }
    // A checkpoint whose line ends went through a text mode.
    let mut file = bytes(&small());
    file.remove(4);
    assert!(matches!(
        read(Open, &file),
        Err(CheckpointError::Foreign { .. })
    ));
}

#[test]
fn extreme_another_version_is_refused() {
    for (at, of) in [(8, "layout"), (12, "noise mapping")] {
        let mut file = bytes(&small());
        file[at..at + 4].copy_from_slice(&7_u32.to_le_bytes());
        let error = read(Open, &file);
        assert!(matches!(
            error,
            Err(CheckpointError::Version {
                quantity,
                found: 7,
                known: 1
            }) if quantity == of
        ));
    }
}

#[test]
fn extreme_a_file_cut_off_anywhere_is_refused() {
    let file = bytes(&small());
    for end in 0..file.len() {
        let announced = if end < 24 { 24 } else { file.len() as u64 };
        match read(Open, &file[..end]) {
            Err(CheckpointError::Truncated { found, expected }) => {
                assert_eq!((found, expected), (end as u64, announced));
            }
            other => panic!("{end}: {other:?}"),
        }
    }
}

#[test]
fn extreme_one_flipped_bit_anywhere_is_seen() {
    let file = bytes(&small());
    for bit in 0..8 * file.len() {
        let mut flipped = file.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        let error = read(Open, &flipped).unwrap_err();
        let named = match bit / 8 {
            0..8 => matches!(error, CheckpointError::Foreign { .. }),
            8..16 => matches!(error, CheckpointError::Version { .. }),
            16..24 => matches!(
                error,
                CheckpointError::Truncated { .. } | CheckpointError::Damaged { .. }
            ),
            _ => matches!(error, CheckpointError::Damaged { .. }),
        };
        assert!(named, "bit {bit}: {error:?}");
    }
}

/// Lengths of 2^60 and beyond, in the head and in every column: the file is refused at once and nothing of that size
/// is asked of the memory.
#[test]
fn extreme_announced_lengths_are_not_believed() {
    for length in [3, 1_u64 << 60, u64::MAX / 24 + 1, u64::MAX] {
        let mut file = bytes(&small());
        file[16..24].copy_from_slice(&length.to_le_bytes());
        assert!(read(Open, &file).is_err());
        for column in [CELL, CELL + 8, POSITIONS, VELOCITIES, FORCES, MASSES, IDS] {
            let file = forged(bytes(&small()), column, &length.to_le_bytes());
            assert!(read(Open, &file).is_err(), "{length} at {column}");
        }
        if length > 3 {
            let file = forged(bytes(&small()), POSITIONS, &length.to_le_bytes());
            let error = read(Open, &file).unwrap_err();
            assert!(
                matches!(error, CheckpointError::Truncated { expected, .. } if expected >= length)
            );
        }
    }
}

#[test]
fn extreme_particles_that_make_no_sense_are_refused() {
    let refused = |at, with: &[u8]| match read(Open, &forged(bytes(&small()), at, with)) {
        Err(CheckpointError::Particles(error)) => error,
        other => panic!("{other:?}"),
    };
    let nan = f64::NAN.to_le_bytes();
    for (at, name) in [
        (POSITIONS, "positions"),
        (VELOCITIES, "velocities"),
        (FORCES, "forces"),
    ] {
        match refused(at + 8 + 24, &nan) {
            ParticleError::NotFinite {
                column, particle, ..
            } => assert_eq!((column, particle), (name, 1)),
            other => panic!("{other:?}"),
        }
    }
    let error = refused(MASSES + 8, &0.0_f64.to_le_bytes());
    let mass = ParticleError::Mass {
        particle: 0,
        mass: 0.0,
    };
    assert_eq!(error, mass);
    let identity = ParticleError::Identity {
        particle: 1,
        identity: 1,
        particles: 2,
    };
    assert_eq!(refused(IDS + 8 + 4, &1_u32.to_le_bytes()), identity);
}

#[test]
fn extreme_clocks_that_make_no_sense_are_refused() {
    for (at, with, name) in [
        (DT, 0.0_f64.to_le_bytes(), "dt"),
        (DT + 8, f64::NAN.to_le_bytes(), "kt"),
        (STEP, u64::MAX.to_le_bytes(), "step"),
        (
            EPOCH_STEP,
            1_u64.to_le_bytes(),
            "step of the last change of dt",
        ),
        (EPOCH_TIME, f64::INFINITY.to_le_bytes(), "time"),
    ] {
        match read(Open, &forged(bytes(&small()), at, &with)) {
            Err(CheckpointError::Clock(error)) => assert_eq!(error.name, name),
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn extreme_another_boundary_is_refused() {
    let particles = || Particles::new(vec![DVec3::ZERO]).unwrap();
    let mut clock = Clock::new(0.25, 1.0, 0).unwrap();
    clock.tick();
    let system = System::new(Cell::flowing(cube(4.0), shear(1.0)), particles(), clock);
    let file = bytes(&system);
    let refused = |answer: Result<(), CheckpointError>| match answer {
        Err(CheckpointError::Boundary {
            time,
            quantity,
            found,
            expected,
        }) => {
            assert_eq!(time, 0.25);
            (quantity, found, expected)
        }
        other => panic!("{other:?}"),
    };
    let cell = DMat3::from_cols(4.0 * DVec3::X, DVec3::new(1.0, 4.0, 0.0), 4.0 * DVec3::Z);
    let cell = cell.to_cols_array().to_vec();
    let open = read(Open, &file).map(|_| ());
    assert_eq!(refused(open), ("cell", vec![], cell.clone()));
    let larger = 4.0_f64.next_up();
    let other = read(Cell::flowing(cube(larger), shear(1.0)), &file).map(|_| ());
    assert_eq!(refused(other).0, "cell");
    // A whole number of cells has slid by: the same lattice in another flow.
    let other = read(Cell::flowing(cube(4.0), shear(5.0)), &file).map(|_| ());
    let gradients = [shear(5.0), shear(1.0)].map(|kappa| kappa.to_cols_array().to_vec());
    let (quantity, found, expected) = refused(other);
    assert_eq!(
        (quantity, [found, expected]),
        ("velocity gradient", gradients)
    );
    assert!(read(Cell::flowing(cube(4.0), shear(1.0)), &file).is_ok());
}

#[test]
fn extreme_a_state_that_could_not_be_read_back_is_not_written() {
    let mut system = small();
    system.particles.columns_mut().velocities.pop();
    let mut file = Vec::new();
    let error = save(&system, &mut (), &mut file).unwrap_err();
    let length = ParticleError::Length {
        column: "velocities",
        found: 1,
        particles: 2,
    };
    assert!(matches!(error, CheckpointError::Particles(found) if found == length));
    let mut system = small();
    system.particles.positions_mut()[1].x = f64::NAN;
    assert!(save(&system, &mut (), &mut file).is_err());
    let mut system = small();
    system.particles.columns_mut().images.pop();
    assert!(save(&system, &mut (), &mut file).is_err());
    assert!(file.is_empty());
}

/// Several checkpoints may follow each other in one stream.
#[test]
fn law_nothing_is_read_beyond_the_end() {
    let (first, mut second) = (small(), small());
    second.clock.tick();
    let stream = [bytes(&first), bytes(&second), b"end".to_vec()].concat();
    let mut rest = stream.as_slice();
    assert_eq!(bits(&load(Open, &mut rest).unwrap()), bits(&first));
    assert_eq!(bits(&load(Open, &mut rest).unwrap()), bits(&second));
    assert_eq!(rest, b"end");
}

/// A directory of its own for each test, taken away at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("zimm-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let name = |entry: std::fs::DirEntry| entry.file_name().into_string().unwrap();
        let mut names: Vec<String> = entries.map(|entry| name(entry.unwrap())).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).unwrap();
    }
}

#[test]
fn law_a_failed_save_leaves_the_former_file_whole() {
    let folder = Folder::new("former");
    let path = folder.0.join("run.checkpoint");
    let mut system = small();
    save_file(&system, &mut (), &path).unwrap();
    let first = std::fs::read(&path).unwrap();
    assert_eq!(first, bytes(&system));
    system.clock.tick();
    system.particles.positions_mut()[0].x = f64::INFINITY;
    assert!(save_file(&system, &mut (), &path).is_err());
    assert_eq!(std::fs::read(&path).unwrap(), first);
    assert_eq!(folder.names(), ["run.checkpoint"]);
    // What an interrupted save leaves behind is in nobody's way.
    std::fs::write(folder.0.join("run.checkpoint.part"), b"zimm").unwrap();
    assert_eq!(bits(&load_file(Open, &path).unwrap()), bits(&small()));
    system.particles.positions_mut()[0].x = 5.0;
    save_file(&system, &mut (), &path).unwrap();
    assert_eq!(folder.names(), ["run.checkpoint"]);
    assert_eq!(bits(&load_file(Open, &path).unwrap()), bits(&system));
}

#[test]
fn extreme_paths_that_hold_no_file_are_errors() {
    let folder = Folder::new("paths");
    let missing = folder.0.join("missing");
    assert!(matches!(
        load_file(Open, &missing),
        Err(CheckpointError::Io(_))
    ));
    assert!(matches!(
        load_file(Open, &folder.0),
        Err(CheckpointError::Io(_))
    ));
    for path in [
        missing.join("deeper"),
        PathBuf::from("/"),
        PathBuf::from(".."),
    ] {
        assert!(matches!(
            save_file(&small(), &mut (), path),
            Err(CheckpointError::Io(_))
        ));
    }
    let occupied = folder.0.join("occupied");
    std::fs::create_dir(&occupied).unwrap();
    assert!(matches!(
        save_file(&small(), &mut (), &occupied),
        Err(CheckpointError::Io(_))
    ));
    assert_eq!(folder.names(), ["occupied"]);
}

/// A device that is full is an error of the save, not of a later load.
#[test]
fn extreme_a_writer_that_fails_is_an_error() {
    let length = bytes(&small()).len();
    for room in 0..length {
        let mut buffer = vec![0; room];
        let answer = save(&small(), &mut (), &mut buffer.as_mut_slice());
        assert!(matches!(answer, Err(CheckpointError::Io(_))));
    }
}
