//! Laws of one's own, written as a user would write them, beside the library's: all forces of the fluid of Groot and
//! Warren, and its whole steps. Both run in the same loop, so a law outside the family is to be as fast as one within.

use crate::film::{self, Film};
use crate::timing::medians;
use crate::{Problem, scene};
use zimm::core::noise::Domain;
use zimm::prelude::*;

/// F = a (1 - r) for r < 1: what `DpdConservative` is.
#[derive(Clone, Copy)]
struct Soft {
    a: f64,
}

impl PairForce for Soft {
    fn cutoff(&self) -> f64 {
        1.0
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, _: &Now) -> Central {
        let r = pair.r2.sqrt();
        Central::conservative(self.a * (1.0 - r).max(0.0) / r)
    }
}

/// U = e (1 - r)^4 (1 + 4 r) for r < 1, smooth twice over (Wendland 1995): a law that the library does not have.
#[derive(Clone, Copy)]
struct Wendland {
    e: f64,
}

impl PairForce for Wendland {
    fn cutoff(&self) -> f64 {
        1.0
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, _: &Now) -> Central {
        let x = (1.0 - pair.r2.sqrt()).max(0.0);
        Central::conservative(20.0 * self.e * x * x * x)
    }
}

/// Soft repulsion with friction and noise of weight 1 - r: what `Dpd` is.
#[derive(Clone, Copy)]
struct Thermostat {
    a: f64,
    gamma: f64,
}

impl PairForce for Thermostat {
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
        let x = (1.0 - r).max(0.0);
        let sigma = (2.0 * self.gamma * now.kt / now.dt).sqrt();
        // The library's domain, so that the forces are the same; a law of one's own has Domain::user.
        let theta = pair.noise.uniform(Domain::DPD);
        Central {
            conservative: self.a * x / r,
            dissipative: -self.gamma * x * x * pair.rv / pair.r2,
            random: sigma * x * theta / r,
        }
    }
}

/// A law beside the library's.
struct Row {
    name: &'static str,
    forces: [f64; 2],
    steps: [f64; 2],
}

pub(crate) fn table(quick: bool) -> Result<(), Problem> {
    let film = film::fluid(scene::cube(if quick { 10.0 } else { 20.0 }), quick)?;
    let soft = DpdConservative::new(25.0, 1.0)?;
    let (own, dpd) = (Soft { a: 25.0 }, Dpd::new(25.0, 4.5)?);
    let thermostat = Thermostat {
        a: 25.0,
        gamma: 4.5,
    };
    agree(&film, own, soft)?;
    agree(&film, thermostat, dpd)?;
    let rows = [
        race("a (1 - r) beside `DpdConservative`", &film, own, soft)?,
        race(
            "20 e (1 - r)^3 r beside `DpdConservative`",
            &film,
            Wendland { e: 5.0 },
            soft,
        )?,
        race(
            "all of DPD, which reads velocity and noise, beside `Dpd`",
            &film,
            thermostat,
            dpd,
        )?,
    ];
    println!(
        "| law of one's own, {} particles | forces, ns: own, library | ratio | steps, ns: own, library | ratio |",
        film.particles()
    );
    println!("| --- | --- | --- | --- | --- |");
    for row in &rows {
        let ([f, g], [s, t]) = (row.forces, row.steps);
        println!(
            "| {} | {f:.1}, {g:.1} | {:.2} | {s:.1}, {t:.1} | {:.2} |",
            row.name,
            f / g,
            s / t
        );
    }
    for row in &rows {
        let ratio = row.forces[0] / row.forces[1];
        if ratio > 1.2 {
            let name = row.name;
            return Err(format!("{name}: takes {ratio:.2} times as long").into());
        }
    }
    Ok(())
}

/// Forces and steps with either law.
fn race(
    name: &'static str,
    film: &Film<PeriodicBox>,
    own: impl PairForce + Copy,
    library: impl PairForce + Copy,
) -> Result<Row, Problem> {
    let list = || VerletList::new(scene::SKIN);
    let (mut mine, mut theirs) = (Pairwise::new(own, list()?), Pairwise::new(library, list()?));
    let forces = medians([
        Box::new(|| film.forces(&mut mine, &mut ())),
        Box::new(|| film.forces(&mut theirs, &mut ())),
    ])?;
    let (mut first, mut second) = (GrootWarren::new(0.65)?, GrootWarren::new(0.65)?);
    let steps = medians([
        Box::new(|| film.steps(&mut mine, &mut first, &mut ())),
        Box::new(|| film.steps(&mut theirs, &mut second, &mut ())),
    ])?;
    Ok(Row {
        name,
        forces,
        steps,
    })
}

/// An error unless the two laws are one.
fn agree(
    film: &Film<PeriodicBox>,
    own: impl PairForce,
    library: impl PairForce,
) -> Result<(), Problem> {
    let mine = film.forces_once(&mut Pairwise::new(own, VerletList::new(scene::SKIN)?))?;
    let theirs = film.forces_once(&mut Pairwise::new(library, VerletList::new(scene::SKIN)?))?;
    let worst = mine
        .iter()
        .zip(&theirs)
        .map(|(&f, &g)| (f - g).length() / (1.0 + g.length()))
        .fold(0.0, f64::max);
    if worst < 1e-12 {
        Ok(())
    } else {
        Err(format!("forces of the two laws differ by {worst}").into())
    }
}
