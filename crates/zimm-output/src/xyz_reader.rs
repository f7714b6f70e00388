use crate::lines::{Line, Lines, beginning};
use crate::{OutputError, Snapshot, elements};
use std::io::BufRead;
use std::num::NonZeroUsize;
use zimm_core::{DMat3, DVec3, IVec3, Now};

/// Reads what [`XyzWriter`](crate::XyzWriter) has written, frame by frame; one frame is in memory at a time.
///
/// Every number comes back with the bits that were written. Files that other tools have rewritten are read too, if
/// these kept the keys; keys and columns of other names are passed over.
///
/// ```
/// use zimm_core::{Clock, DVec3, Open, Particles, System};
/// use zimm_output::{XyzReader, XyzWriter};
///
/// // A particle that comes sqrt(t) far in a time t.
/// let (mut file, mut clock) = (Vec::new(), Clock::new(1.0, 1.0, 42)?);
/// let mut writer = XyzWriter::new(&mut file);
/// for step in 0..5 {
///     let particles = Particles::new(vec![DVec3::X * f64::from(step).sqrt()])?;
///     writer.write(&System::new(Open, particles, clock).frame())?;
///     clock.tick();
/// }
/// drop(writer);
///
/// // After the fact: its diffusivity. Any observable can measure the scene that a snapshot becomes again.
/// let mut diffusivity = 0.0;
/// for snapshot in XyzReader::new(file.as_slice()).skip(1) {
///     let system = snapshot?.into_system(Open)?;
///     let travelled = system.particles.positions()[0];
///     diffusivity = travelled.length_squared() / (6.0 * system.clock.now().time);
/// }
/// assert!((diffusivity - 1.0 / 6.0).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// An item is an error if the input fails or the file is damaged: cut off, a count that is wrong, an entry missing, not
/// a number or not finite. It tells the line and what stands there. Nothing comes after it.
#[derive(Debug)]
pub struct XyzReader<R> {
    lines: Lines<R>,
    names: Vec<String>,
    failed: bool,
}

impl<R: BufRead> XyzReader<R> {
    /// A reader of any source.
    pub fn new(source: R) -> Self {
        Self {
            lines: Lines::new(source),
            names: elements::names(),
            failed: false,
        }
    }

    fn snapshot(&mut self) -> Result<Option<Snapshot>, OutputError> {
        let expected: u64 = loop {
            match self.lines.next()? {
                None => return Ok(None),
                Some(line) if line.text.trim().is_empty() => {}
                Some(line) => {
                    let allowed = "the number of particles of a frame";
                    break line.integer("the line", line.text, allowed)?;
                }
            }
        };
        let cut_off = |line, found| OutputError::Truncated {
            line,
            found,
            expected,
        };
        let number = self.lines.number();
        let head = self.lines.next()?.ok_or(cut_off(number, 0))?;
        let (mut snapshot, layout) = head_of(&head)?;
        for found in 0..expected {
            let number = self.lines.number();
            let row = self.lines.next()?.ok_or(cut_off(number, found))?;
            push(&mut snapshot, &layout, &self.names, &row)?;
        }
        Ok(Some(snapshot))
    }
}

impl<R: BufRead> Iterator for XyzReader<R> {
    type Item = Result<Snapshot, OutputError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let next = self.snapshot().transpose();
        self.failed = matches!(next, Some(Err(_)));
        next
    }
}

/// What stands in a column.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Column {
    Species,
    Position,
    Velocity,
    Mass,
    Images,
    Identity,
    Molecule,
    Other,
}

const COLUMNS: [(&str, &str, usize, Column); 7] = [
    ("species", "S", 1, Column::Species),
    ("pos", "R", 3, Column::Position),
    ("velo", "R", 3, Column::Velocity),
    ("mass", "R", 1, Column::Mass),
    ("map_shift", "I", 3, Column::Images),
    ("id", "I", 1, Column::Identity),
    ("molecule", "I", 1, Column::Molecule),
];

/// Columns and how many entries each has.
type Layout = Vec<(Column, usize)>;

/// Moment, space and columns of a frame.
fn head_of(line: &Line<'_>) -> Result<(Snapshot, Layout), OutputError> {
    let real = |name| line.real(name, need(line, name)?);
    let integer = |name, word| line.integer(name, word, "an integer from 0 to 2^64 - 1");
    let layout = layout_of(line, need(line, "Properties")?)?;
    let snapshot = Snapshot {
        now: Now {
            time: real("Time")?,
            dt: real("dt")?,
            kt: real("kT")?,
            seed: integer("seed", need(line, "seed")?)?,
            step: integer("Timestep", need(line, "Timestep")?)?,
        },
        cell: matrix(line, "Lattice")?,
        gradient: matrix(line, "velocity_gradient")?.unwrap_or(DMat3::ZERO),
        ..Snapshot::default()
    };
    match (&snapshot.cell, find(line, "pbc")) {
        (_, None) | (Some(_), Some("T T T")) | (None, Some("F F F")) => Ok((snapshot, layout)),
        (_, Some(found)) => {
            let allowed = "T T T with a Lattice and F F F without";
            Err(line.wrong("pbc", found, allowed))
        }
    }
}

fn find<'a>(line: &Line<'a>, name: &'static str) -> Option<&'a str> {
    pairs(line.text).find_map(|(key, value)| (key == name).then_some(value))
}

fn need<'a>(line: &Line<'a>, name: &'static str) -> Result<&'a str, OutputError> {
    find(line, name).ok_or(OutputError::Missing {
        line: line.number,
        name,
    })
}

/// Nine numbers, column by column.
fn matrix(line: &Line<'_>, name: &'static str) -> Result<Option<DMat3>, OutputError> {
    let Some(value) = find(line, name) else {
        return Ok(None);
    };
    let words = value.split_ascii_whitespace();
    let numbers: Vec<f64> = words
        .map(|word| line.real(name, word))
        .collect::<Result<_, _>>()?;
    match numbers.as_array() {
        Some(numbers) => Ok(Some(DMat3::from_cols_array(numbers))),
        None => Err(line.wrong(name, value, "nine numbers")),
    }
}

/// Keys and values of a line; values may be in double quotes.
fn pairs(mut text: &str) -> impl Iterator<Item = (&str, &str)> {
    std::iter::from_fn(move || {
        text = text.trim_ascii_start();
        if text.is_empty() {
            return None;
        }
        let blank = |c: char| c.is_ascii_whitespace();
        let end = |text: &str| text.find(blank).unwrap_or(text.len());
        let (key, rest) = text.split_at(text.find('=').unwrap_or(usize::MAX).min(end(text)));
        let (value, rest) = match rest.strip_prefix('=') {
            None => ("", rest),
            Some(rest) => match rest.strip_prefix('"') {
                Some(rest) => rest.split_once('"').unwrap_or((rest, "")),
                None => rest.split_at(end(rest)),
            },
        };
        text = rest;
        Some((key, value))
    })
}

fn layout_of(line: &Line<'_>, properties: &str) -> Result<Layout, OutputError> {
    let wrong = |allowed| line.wrong("Properties", properties, allowed);
    let words: Vec<&str> = properties.split(':').collect();
    let (triples, []) = words.as_chunks::<3>() else {
        return Err(wrong("name:kind:width of each column, joined by colons"));
    };
    let mut layout = Layout::new();
    let has = |layout: &Layout, column| layout.iter().any(|&(known, _)| known == column);
    for [name, kind, width] in triples {
        let width: NonZeroUsize =
            line.integer("width of a column", width, "an integer above zero")?;
        let width = width.get();
        let column = match COLUMNS.iter().find(|(known, ..)| known == name) {
            None => Column::Other,
            Some(&(_, k, w, column)) if (k, w) == (*kind, width) && !has(&layout, column) => column,
            Some(_) => {
                return Err(wrong(
                    "once at most species:S:1, pos:R:3, velo:R:3, mass:R:1, map_shift:I:3, id:I:1, molecule:I:1",
                ));
            }
        };
        layout.push((column, width));
    }
    if has(&layout, Column::Position) {
        Ok(layout)
    } else {
        let (line, name) = (line.number, "pos");
        Err(OutputError::Missing { line, name })
    }
}

/// Adds a particle.
fn push(
    snapshot: &mut Snapshot,
    layout: &Layout,
    names: &[String],
    row: &Line<'_>,
) -> Result<(), OutputError> {
    let found = row.text.split_ascii_whitespace().count();
    let expected = layout
        .iter()
        .fold(0_usize, |sum, (_, width)| sum.saturating_add(*width));
    if found != expected {
        return Err(OutputError::Columns {
            line: row.number,
            found,
            expected,
            text: beginning(row.text),
        });
    }
    let mut words = row.text.split_ascii_whitespace();
    let mut word = || words.next().unwrap_or_default();
    for &(column, width) in layout {
        match column {
            Column::Species => {
                let word = word();
                let species = names.iter().position(|name| name == word);
                let species = species.and_then(|k| u8::try_from(k).ok());
                let allowed = "the symbol of an element, or X118 to X255";
                let species = species.ok_or_else(|| row.wrong("species", word, allowed));
                snapshot.species.push(species?);
            }
            Column::Position => {
                let mut next = || row.real("position", word());
                let position = DVec3::new(next()?, next()?, next()?);
                snapshot.positions.push(position);
            }
            Column::Velocity => {
                let mut next = || row.real("velocity", word());
                let velocity = DVec3::new(next()?, next()?, next()?);
                snapshot.velocities.push(velocity);
            }
            Column::Mass => snapshot.masses.push(row.real("mass", word())?),
            Column::Images => {
                let allowed = "an integer from -2^31 to 2^31 - 1";
                let mut next = || row.integer("image count", word(), allowed);
                snapshot.images.push(IVec3::new(next()?, next()?, next()?));
            }
            Column::Identity => {
                let id = row.integer("identity", word(), "an integer from 0 to 2^32 - 1")?;
                snapshot.ids.push(id);
            }
            Column::Molecule => {
                let molecule = row.integer("molecule", word(), "an integer from 0 to 2^32 - 1")?;
                snapshot.molecules.push(molecule);
            }
            Column::Other => {
                for _ in 0..width {
                    word();
                }
            }
        }
    }
    Ok(())
}
