//! What is written as extended XYZ comes back, bit for bit.

#![allow(clippy::unwrap_used)]

mod common;

use common::{Cell, kinds, lattice, molecule, now, number, particles, system, vector};
use proptest::prelude::*;
use std::cell::Cell as Counter;
use std::io::{BufReader, Read};
use zimm_core::{Boundary, DMat3, DVec3, Open, Particles, System};
use zimm_output::{OutputError, Snapshot, XyzReader, XyzWriter};

fn written<B: Boundary>(system: &System<B>, molecules: bool) -> String {
    let mut file = Vec::new();
    let mut writer = XyzWriter::new(&mut file);
    if molecules {
        writer = writer.with_molecules(kinds());
    }
    writer.write(&system.frame()).unwrap();
    drop(writer);
    String::from_utf8(file).unwrap()
}

fn only(file: &str) -> Snapshot {
    let mut frames = XyzReader::new(file.as_bytes());
    let snapshot = frames.next().unwrap().unwrap();
    assert!(frames.next().is_none());
    snapshot
}

fn bits(vectors: &[DVec3]) -> Vec<[u64; 3]> {
    let of = |v: &DVec3| v.to_array().map(f64::to_bits);
    vectors.iter().map(of).collect()
}

/// Everything but velocities, and the moment to the bit.
fn same_frame<B: Boundary>(system: &System<B>, snapshot: &Snapshot, molecules: bool) {
    let frame = system.frame();
    assert_eq!(snapshot.now, frame.now);
    assert_eq!(snapshot.now.time.to_bits(), frame.now.time.to_bits());
    assert_eq!(snapshot.cell, frame.boundary.cell());
    assert_eq!(bits(&snapshot.positions), bits(frame.positions));
    assert_eq!(snapshot.masses, frame.masses);
    assert_eq!(snapshot.images, frame.images);
    assert_eq!(snapshot.ids, frame.ids);
    let places = 0..frame.len();
    assert!(
        places
            .clone()
            .map(|k| frame.species(k))
            .eq(snapshot.species.iter().copied())
    );
    if molecules {
        let expected = places.map(|k| molecule(frame.id(k)));
        assert!(expected.eq(snapshot.molecules.iter().copied()));
    } else {
        assert!(snapshot.molecules.is_empty());
    }
}

proptest! {
    #[test]
    fn law_what_is_at_rest_comes_back_to_the_bit(
        lattice in lattice(),
        particles in particles(vector(), common::image()),
        now in now(),
        molecules: bool,
    ) {
        let cell = Cell::<false> { lattice, gradient: DMat3::ZERO };
        let there = system(cell.clone(), particles, now);
        let snapshot = only(&written(&there, molecules));
        same_frame(&there, &snapshot, molecules);
        prop_assert_eq!(bits(&snapshot.velocities), bits(there.particles.velocities()));
        prop_assert_eq!(snapshot.gradient, DMat3::ZERO);
        let frame = there.frame();
        for place in 0..frame.len() {
            prop_assert_eq!(snapshot.unwrapped(place), frame.unwrapped(place));
        }
        let back = snapshot.into_system(cell).unwrap();
        prop_assert_eq!(back.clock.now(), now);
        prop_assert_eq!(bits(back.particles.velocities()), bits(there.particles.velocities()));
        prop_assert_eq!(back.particles.images(), there.particles.images());
        prop_assert_eq!(written(&back, molecules), written(&there, molecules));
    }

    // Laboratory velocities to the bit; peculiar ones to the rounding of c + kappa r.
    #[test]
    fn law_what_flows_comes_back_to_the_bit(
        lattice in lattice(),
        gradient in prop::array::uniform9(-2.0..2.0),
        particles in particles(vector(), common::image()),
        now in now(),
    ) {
        let gradient = DMat3::from_cols_array(&gradient);
        let cell = Cell::<true> { lattice, gradient };
        let there = system(cell.clone(), particles, now);
        let snapshot = only(&written(&there, false));
        same_frame(&there, &snapshot, false);
        prop_assert_eq!(snapshot.gradient, gradient);
        let frame = there.frame();
        let peculiar = || frame.velocities.iter().zip(frame.positions);
        let laboratory: Vec<_> = peculiar().map(|(&c, &r)| c + gradient * r).collect();
        prop_assert_eq!(bits(&snapshot.velocities), bits(&laboratory));
        let back = snapshot.into_system(cell).unwrap();
        for (found, (&c, &r)) in back.particles.velocities().iter().zip(peculiar()) {
            let scale = c.length() + 6.0 * r.length();
            prop_assert!((*found - c).length() <= 4.0 * f64::EPSILON * scale);
        }
    }

    #[test]
    fn law_open_space_comes_back_to_the_bit(
        particles in particles(vector(), common::image()),
        now in now(),
    ) {
        let there = system(Open, particles, now);
        let snapshot = only(&written(&there, true));
        same_frame(&there, &snapshot, true);
        prop_assert_eq!(bits(&snapshot.velocities), bits(there.particles.velocities()));
        prop_assert_eq!(snapshot.unwrapped(0), there.particles.positions().first().copied());
        let back = snapshot.into_system(Open).unwrap();
        prop_assert_eq!(written(&back, true), written(&there, true));
    }

    // Whatever the bytes are, they are read or refused.
    #[test]
    fn extreme_any_bytes_are_an_error_at_worst(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = XyzReader::new(bytes.as_slice()).count();
    }

    #[test]
    fn extreme_any_wrong_byte_is_an_error_at_worst(place in 0_usize..400, byte: u8) {
        let mut bytes = written(&scene(), true).into_bytes();
        let place = place % bytes.len();
        bytes[place] = byte;
        for snapshot in XyzReader::new(bytes.as_slice()) {
            let Ok(snapshot) = snapshot else { break };
            let finite = |v: &DVec3| v.is_finite();
            prop_assert!(snapshot.positions.iter().chain(&snapshot.velocities).all(finite));
            let _ = snapshot.into_system(scene().boundary);
        }
    }

    #[test]
    fn extreme_any_number_has_a_shortest_form(x in number()) {
        let there = system(Open, Particles::new(vec![DVec3::splat(x)]).unwrap(), Default::default());
        let file = written(&there, false);
        let words: Vec<_> = file.lines().last().unwrap().split(' ').collect();
        prop_assert_eq!(words[1].parse::<f64>().unwrap().to_bits(), x.to_bits());
        prop_assert!(words[1].len() <= 24, "{}", words[1]);
    }
}

/// Three particles in a tilted cell that is sheared.
fn scene() -> System<Cell<true>> {
    let basis = DMat3::from_cols(DVec3::X * 4.0, DVec3::new(1.0, 3.0, 0.0), DVec3::Z * 5.0);
    let cell = Cell {
        lattice: zimm_core::Lattice::new(basis).unwrap(),
        gradient: DMat3::from_cols(DVec3::ZERO, DVec3::X * 0.5, DVec3::ZERO),
    };
    let positions = vec![DVec3::new(0.5, 1.0, -2.0), DVec3::ZERO, DVec3::X];
    let particles = Particles::new(positions)
        .unwrap()
        .with_velocities(vec![DVec3::ONE, DVec3::Y, DVec3::NEG_Z])
        .unwrap()
        .with_species(vec![0, 200, 7])
        .unwrap()
        .with_ids(vec![2, 0, 1])
        .unwrap()
        .counting_images();
    system(cell, particles, Default::default())
}

#[test]
fn reference_a_frame_in_full() {
    assert_eq!(
        written(&scene(), true),
        "3\n\
        Lattice=\"4.0 0.0 0.0 1.0 3.0 0.0 0.0 0.0 5.0\" Origin=\"-2.5 -1.5 -2.5\" pbc=\"T T T\" \
        Properties=species:S:1:pos:R:3:velo:R:3:map_shift:I:3:id:I:1:molecule:I:1 \
        Time=0.0 Timestep=0 dt=1.0 kT=1.0 seed=0 \
        velocity_gradient=\"0.0 0.0 0.0 0.5 0.0 0.0 0.0 0.0 0.0\"\n\
        H 0.5 1.0 -2.0 1.5 1.0 1.0 0 0 0 2 1\n\
        X200 0.0 0.0 0.0 0.0 1.0 0.0 0 0 0 0 0\n\
        O 1.0 0.0 0.0 0.0 0.0 -1.0 0 0 0 1 1\n"
    );
}

/// The error of a file of one frame in which a text is replaced by another.
fn damaged(from: &str, to: &str) -> OutputError {
    let file = written(&scene(), true);
    assert_eq!(file.matches(from).count(), 1, "{from}");
    let mut frames = XyzReader::new(BufReader::new(std::io::Cursor::new(file.replace(from, to))));
    let error = frames.find_map(Result::err).unwrap();
    assert!(frames.next().is_none(), "nothing comes after an error");
    error
}

#[test]
fn extreme_wrong_entries_are_told_with_their_line() {
    for (from, to, line, name) in [
        ("3\nL", "three\nL", 1, "the line"),
        ("3\nL", "-3\nL", 1, "the line"),
        ("3\nL", "2\nL", 5, "the line"),
        ("Time=0.0", "Time=now", 2, "Time"),
        ("Timestep=0", "Timestep=-1", 2, "Timestep"),
        ("kT=1.0", "kT=NaN", 2, "kT"),
        ("seed=0", "seed=0.5", 2, "seed"),
        ("\"4.0 0.0", "\"4.0", 2, "Lattice"),
        ("\"4.0 0.0", "\"4.0 inf", 2, "Lattice"),
        ("T T T", "T F T", 2, "pbc"),
        (":velo:R:3", ":velo:R:2", 2, "Properties"),
        (":velo:R:3", ":pos:R:3", 2, "Properties"),
        (":velo:R:3", ":velo:R", 2, "Properties"),
        (":velo:R:3", ":velo:R:0", 2, "width of a column"),
        ("H 0.5", "Wood 0.5", 3, "species"),
        ("H 0.5", "H NaN", 3, "position"),
        ("H 0.5", "H 0,5", 3, "position"),
        ("O 1.0", "O 1e999", 5, "position"),
        ("-1.0 0 0", "-inf 0 0", 5, "velocity"),
        ("-1.0 0 0 0", "-1.0 0 0.5 0", 5, "image count"),
        ("1.5 1.0 1.0 0 0 0 2", "1.5 1.0 1.0 0 0 0 -2", 3, "identity"),
    ] {
        match damaged(from, to) {
            OutputError::Value {
                line: l, name: n, ..
            } => assert_eq!((l, n), (line, name), "{to}"),
            other => panic!("{to}: {other:?}"),
        }
    }
    let error = damaged("H 0.5", "H NaN").to_string();
    assert_eq!(
        error,
        "line 3: position is `NaN`, but must be a finite number"
    );
}

#[test]
fn extreme_missing_parts_are_told_with_their_line() {
    for name in ["Properties", "Time", "Timestep", "dt", "kT", "seed"] {
        let error = damaged(&format!(" {name}="), " other=");
        assert!(
            matches!(error, OutputError::Missing { line: 2, name: n } if n == name),
            "{name}: {error:?}"
        );
    }
    let error = damaged(":pos:R:3", ":force:R:3");
    assert!(matches!(
        error,
        OutputError::Missing {
            line: 2,
            name: "pos"
        }
    ));

    let error = damaged("O 1.0 ", "O ").to_string();
    let expected =
        "line 5 has 11 entries; its frame announces 12: `O 0.0 0.0 0.0 0.0 -1.0 0 0 0 1 1`";
    assert_eq!(error, expected);
    let error = damaged(":id:I:1", "");
    let expected = matches!(
        error,
        OutputError::Columns {
            line: 3,
            found: 12,
            expected: 11,
            ..
        }
    );
    assert!(expected, "{error:?}");
}

// Two frames of three particles are ten lines; cut off after each.
#[test]
fn extreme_a_file_that_is_cut_off_tells_where() {
    let file = written(&scene(), false).repeat(2);
    let lines: Vec<&str> = file.split_inclusive('\n').collect();
    for kept in 0..10 {
        let file: String = lines[..kept].concat();
        let (good, wrong): (Vec<_>, Vec<_>) =
            XyzReader::new(file.as_bytes()).partition(Result::is_ok);
        assert_eq!(good.len(), kept / 5);
        let wrong: Vec<_> = wrong.into_iter().filter_map(Result::err).collect();
        match (kept % 5, wrong.as_slice()) {
            (0, []) => {}
            (
                rest,
                [
                    OutputError::Truncated {
                        line,
                        found,
                        expected: 3,
                    },
                ],
            ) => {
                assert_eq!(
                    (*line, *found),
                    (kept as u64, rest.saturating_sub(2) as u64)
                );
            }
            other => panic!("{kept} lines: {other:?}"),
        }
    }
    // A count too high runs into the next frame, or into the end.
    let error = XyzReader::new(file.replacen("3\n", "4\n", 1).as_bytes()).find_map(Result::err);
    let error = error.unwrap();
    let expected = matches!(
        error,
        OutputError::Columns {
            line: 6,
            found: 1,
            ..
        }
    );
    assert!(expected, "{error:?}");
    let endless = written(&scene(), true).replacen("3\n", "18446744073709551615\n", 1);
    let error = XyzReader::new(endless.as_bytes())
        .find_map(Result::err)
        .unwrap();
    let expected = matches!(
        error,
        OutputError::Truncated {
            line: 5,
            found: 3,
            expected: u64::MAX
        }
    );
    assert!(expected, "{error:?}");
}

#[test]
fn extreme_what_is_no_text_is_an_error() {
    let error = |bytes: Vec<u8>| {
        let mut frames = XyzReader::new(BufReader::new(std::io::Cursor::new(bytes)));
        frames.next().unwrap().unwrap_err()
    };
    for bytes in [vec![0xff, 0xfe, b'\n'], vec![b' '; 2 << 20]] {
        let error = error(bytes);
        assert!(
            matches!(error, OutputError::Value { line: 1, .. }),
            "{error:?}"
        );
    }
    assert!(XyzReader::new(&b""[..]).next().is_none());
    assert!(XyzReader::new(&b"\n \n\n"[..]).next().is_none());
}

#[test]
fn extreme_what_is_not_finite_is_not_written() {
    let mut there = scene();
    there.particles.positions_mut()[1].y = f64::NAN;
    let mut file = Vec::new();
    let error = XyzWriter::new(&mut file).write(&there.frame()).unwrap_err();
    let expected = "column `positions` of particle 1 is not finite: [0.0, NaN, 0.0]";
    assert_eq!(error.to_string(), expected);
    assert!(file.is_empty());

    let there = scene();
    let mut frame = there.frame();
    frame.velocities = &frame.velocities[1..];
    let error = XyzWriter::new(&mut file).write(&frame).unwrap_err();
    assert_eq!(
        error.to_string(),
        "column `velocities` has 2 entries for 3 particles"
    );
}

#[test]
fn extreme_another_boundary_is_refused() {
    let snapshot = only(&written(&scene(), false));
    let error = snapshot.clone().into_system(Open).unwrap_err();
    let expected = matches!(
        error,
        OutputError::Boundary {
            quantity: "cell",
            ..
        }
    );
    assert!(expected, "{error:?}");
    let mut other = scene().boundary;
    other.gradient.y_axis.x += 1e-6;
    let error = snapshot.clone().into_system(other).unwrap_err();
    let expected = matches!(
        error,
        OutputError::Boundary {
            quantity: "velocity gradient",
            ..
        }
    );
    assert!(expected, "{error:?}");
    let mut twice = snapshot;
    twice.ids = vec![0, 1, 1];
    let error = twice.into_system(scene().boundary).unwrap_err();
    assert!(matches!(error, OutputError::Particles(_)), "{error:?}");
}

/// The same bytes again and again; counts those that were asked for.
struct Endless<'a> {
    bytes: &'a [u8],
    taken: &'a Counter<usize>,
}

impl Read for Endless<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let rest = &self.bytes[self.taken.get() % self.bytes.len()..];
        let count = rest.len().min(into.len());
        into[..count].copy_from_slice(&rest[..count]);
        self.taken.set(self.taken.get() + count);
        Ok(count)
    }
}

// A trajectory without end is read frame by frame: after k frames, no more than those and one buffer were taken.
#[test]
fn law_frames_are_read_one_by_one() {
    let (file, taken) = (written(&scene(), true), Counter::new(0));
    let source = Endless {
        bytes: file.as_bytes(),
        taken: &taken,
    };
    let mut frames = XyzReader::new(BufReader::with_capacity(64, source));
    for k in 1..=1000 {
        assert_eq!(frames.next().unwrap().unwrap().positions.len(), 3);
        assert!(taken.get() <= k * file.len() + 64);
    }
}

/// Takes no more than so many bytes.
struct Full(usize);

impl std::io::Write for Full {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let count = bytes.len().min(self.0);
        self.0 -= count;
        Ok(count)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn extreme_a_sink_that_is_full_is_an_error_at_once() {
    let frame = written(&scene(), false).len();
    let mut writer = XyzWriter::new(Full(2 * frame));
    let there = scene();
    assert!(writer.write(&there.frame()).is_ok());
    assert!(writer.write(&there.frame()).is_ok());
    let error = writer.write(&there.frame()).unwrap_err();
    assert!(matches!(error, OutputError::Io(_)), "{error:?}");
}
