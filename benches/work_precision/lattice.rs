//! Error of the carried lattice and of pair distances against the number of strain periods, planar extension and planar
//! mixed flow. "Closed form" is what zimm does: the cell is computed anew from the strain. "Accumulated" carries the
//! basis on from step to step and reduces it, a hundred steps a period: rounding grows as exp(2 strain) and the lattice
//! is lost within some twenty periods.

use crate::chart::{Curve, Panel};
use crate::{Problem, Task};
use plotters::prelude::SeriesLabelPosition;
use zimm::prelude::*;

/// Errors after a number of periods.
struct Row {
    flow: &'static str,
    scheme: &'static str,
    periods: u32,
    lattice: f64,
    distance: f64,
}

pub(crate) fn figure(task: &Task) -> Result<(), Problem> {
    let rate = Steady::new(1.0)?;
    let mut rows = Vec::new();
    rows.extend(errors(
        "planar extension",
        &KraynikReinelt::new(1.0, 1.0, rate)?,
        1.0,
    )?);
    for (name, mixedness) in [("mixedness 0.5", 0.5), ("mixedness 0.1", 0.1)] {
        let space = PlanarMixed::with_map(PlanarMap::CLASSIC, 1.0, 1.0, mixedness, rate)?;
        rows.extend(errors(name, &space, mixedness.sqrt())?);
    }
    task.csv(
        "flow,scheme,periods,lattice_error,distance_error",
        rows.iter().map(|row| {
            let (flow, scheme, periods) = (row.flow, row.scheme, row.periods);
            format!(
                "{flow},{scheme},{periods},{:e},{:e}",
                row.lattice, row.distance
            )
        }),
    )?;
    let panel = |title, pick: fn(&Row) -> f64| Panel {
        title,
        x: "strain periods",
        y: "error / edge of the cell",
        legend: SeriesLabelPosition::MiddleRight,
        curves: ["planar extension", "mixedness 0.5", "mixedness 0.1"]
            .iter()
            .zip(0..)
            .flat_map(|(flow, colour)| {
                ["closed form", "accumulated"].map(|scheme| {
                    let mine = |row: &&Row| row.flow == *flow && row.scheme == scheme;
                    let point = |row: &Row| (f64::from(row.periods), pick(row).max(1e-17));
                    Curve {
                        label: format!("{flow}, {scheme}"),
                        colour,
                        filled: scheme == "closed form",
                        points: rows.iter().filter(mine).map(point).collect(),
                    }
                })
            })
            .collect(),
    };
    task.draw(&[
        panel("Error of the carried lattice", |row| row.lattice),
        panel("Error of pair distances", |row| row.distance),
    ])
}

/// The lattice after n periods and a third is that after a third, whatever n. `hencky` is the Hencky strain in a unit
/// of time.
fn errors<B: Periodic>(flow: &'static str, space: &B, hencky: f64) -> Result<Vec<Row>, Problem> {
    const STEPS: u32 = 99;
    let period = ((3.0 + 5.0_f64.sqrt()) / 2.0).ln() / hencky;
    let at = |time: f64| {
        let mut space = space.clone();
        space.advance(time);
        *space.lattice()
    };
    let exact = at(period / 3.0);
    let mut rows = Vec::new();
    let mut add = |scheme, periods, lattice: &Lattice| {
        rows.push(Row {
            flow,
            scheme,
            periods,
            lattice: lattice_error(lattice, &exact),
            distance: distance_error(lattice, &exact),
        });
    };
    for periods in (0..=16).map(|k| 10_f64.powf(0.25 * f64::from(k)).round() as u32) {
        add(
            "closed form",
            periods,
            &at((f64::from(periods) + 1.0 / 3.0) * period),
        );
    }
    let step = space.carry(0.0, period / f64::from(STEPS));
    let mut carried = at(0.0);
    for n in 1..=40 * STEPS {
        carried = Lattice::new(step * carried.basis())?;
        if n % STEPS == STEPS / 3 && n > STEPS {
            add("accumulated", n / STEPS, &carried);
        }
    }
    Ok(rows)
}

/// How far basis vectors of one lattice are from vectors of the other, relative to the cell; 1 if they have nothing in
/// common.
fn lattice_error(found: &Lattice, exact: &Lattice) -> f64 {
    let off = [0, 1, 2].map(|k| exact.nearest(found.basis().col(k)).length());
    let volumes = (found.volume() / exact.volume() - 1.0).abs();
    off.into_iter().fold(volumes, f64::max).min(1.0)
}

/// The largest difference in nearest-image distance over a grid of separations.
fn distance_error(found: &Lattice, exact: &Lattice) -> f64 {
    let mut worst = 0.0_f64;
    for i in 0..20 {
        for j in 0..20 {
            let s = DVec3::new(f64::from(i) / 20.0, f64::from(j) / 20.0, 0.3) - 0.5;
            let r = exact.basis() * s;
            worst = worst.max((found.nearest(r).length() - exact.nearest(r).length()).abs());
        }
    }
    worst
}
