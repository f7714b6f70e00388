//! What repulsion between springs stops and what it costs: the rate at which springs pass through each other, the
//! pressure that the repulsion adds and the distances between springs, for the laws of Pan and Manke and of Kumar and
//! Larson over their height at contact. Chains of 20 beads at five times their overlap concentration, without solvent.

use crate::chart::{Curve, Panel};
use crate::{Problem, Task};
use plotters::prelude::SeriesLabelPosition;
use zimm::prelude::*;

const EDGE: f64 = 8.0;
const CHAINS: u32 = 52;
/// Energies at contact, in kT; the last are those of Clarke's laws, a = 18.75 and A alpha = 100 kT / r_c.
const PAN_MANKE: [f64; 8] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.5, 9.375];
const KUMAR_LARSON: [f64; 8] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.5, 9.643];
/// Distances between springs are counted in this many bins up to 0.5.
const BINS: usize = 50;
const RANGE: f64 = 0.5;
const STEP: f64 = 0.01;

/// What one law does.
struct Row {
    law: &'static str,
    /// Energy at contact.
    barrier: f64,
    crossings: u64,
    /// Springs that pass through each other, per unit of time.
    rate: f64,
    /// The pressure of the repulsion over that of the beads' ideal gas.
    pressure: f64,
    /// Mean numbers of pairs of springs by their distance.
    distances: Vec<f64>,
}

pub(crate) fn figure(task: &Task) -> Result<(), Problem> {
    let cutoff = 1.0 / 3.0;
    let pan_manke = |barrier| PanManke::new(2.0 * barrier, 1.0);
    let kumar_larson = |barrier: f64| {
        let energy = barrier / (1.0 - f64::exp(-10.0 * cutoff));
        KumarLarson::new(energy, 10.0, cutoff)
    };
    let every = if task.quick { 3 } else { 1 };
    let mut rows = vec![row(task, "none", ())?];
    for barrier in PAN_MANKE.into_iter().rev().step_by(every) {
        rows.push(row(task, "Pan and Manke", pan_manke(barrier)?)?);
    }
    for barrier in KUMAR_LARSON.into_iter().rev().step_by(every) {
        rows.push(row(task, "Kumar and Larson", kumar_larson(barrier)?)?);
    }
    let literal = KumarLarson::new(100.0, 10.0, cutoff)?;
    rows.push(row(task, "Kumar and Larson, A = 100", literal)?);
    let free = rows[0].rate;
    let quantities = rows.iter().flat_map(|row| {
        [
            ("crossings", 0.0, row.crossings as f64),
            ("crossings over phantom", 0.0, row.rate / free),
            ("pressure over n kT", 0.0, row.pressure),
        ]
        .into_iter()
        .chain((0..BINS).map(|bin| ("pairs", middle(bin), row.distances[bin])))
        .map(|(what, distance, value)| {
            format!("{},{},{what},{distance:.3},{value:e}", row.law, row.barrier)
        })
    });
    task.csv("law,energy_at_contact,what,distance,value", quantities)?;
    let shown = |row: &&Row| row.barrier == 0.0 || row.barrier > 9.0;
    let distances = rows.iter().filter(shown).enumerate().map(|(k, row)| Curve {
        label: format!("{}, {:.1} kT", row.law, row.barrier),
        colour: k,
        filled: true,
        points: (0..BINS)
            .map(|bin| (middle(bin), row.distances[bin]))
            .filter(|point| point.1 > 0.0)
            .collect(),
    });
    let against = |x: fn(&Row) -> f64| {
        let laws = ["Pan and Manke", "Kumar and Larson"].into_iter();
        laws.enumerate()
            .map(|(k, law)| Curve {
                label: law.into(),
                colour: k + 1,
                filled: true,
                points: rows
                    .iter()
                    .filter(|row| row.law == law && row.crossings > 0)
                    .map(|row| (x(row), row.rate / free))
                    .collect(),
            })
            .collect()
    };
    task.draw(&[
        Panel {
            title: "How close springs come",
            x: "distance between springs, r_c",
            y: "pairs in a bin of 0.01",
            legend: SeriesLabelPosition::MiddleLeft,
            curves: distances.collect(),
        },
        Panel {
            title: "What a barrier lets through",
            x: "energy at contact, kT",
            y: "crossings over those of phantom chains",
            legend: SeriesLabelPosition::LowerLeft,
            curves: against(|row| row.barrier),
        },
        Panel {
            title: "What it does to the solution",
            x: "pressure of the repulsion over n kT",
            y: "crossings over those of phantom chains",
            legend: SeriesLabelPosition::LowerLeft,
            curves: against(|row| row.pressure),
        },
    ])?;
    check(&rows)
}

/// The middle of a bin.
fn middle(bin: usize) -> f64 {
    RANGE * (bin as f64 + 0.5) / BINS as f64
}

fn row<L: SegmentForce + Copy>(task: &Task, name: &'static str, law: L) -> Result<Row, Problem> {
    let (settling, steps) = if task.quick {
        (300, 1000)
    } else {
        (3000, 20_000)
    };
    let chains = Molecules::linear(0, CHAINS, 20)?;
    let space = PeriodicBox::cubic(EDGE)?;
    let mut rng = start::stream(7);
    let positions = start::chains(space.lattice(), &chains, |_| 1.1, &mut rng);
    let particles = Particles::new(positions)?;
    let velocities = start::velocities(&particles, 1.0, &mut rng)?;
    let particles = particles.with_velocities(velocities)?;
    let mut system = System::new(space, particles, Clock::new(STEP, 1.0, 7)?);
    let mut stepper = Langevin::new(2.0)?;
    let mut springs = Bonded::new(Fene::with_extensibility(50.0, 5.0, 1.0)?, chains.bonds());
    for _ in 0..settling {
        stepper.step(&mut system, &mut springs, &mut ())?;
    }
    let list = || VerletList::new(0.35);
    let repulsion = SegmentRepulsion::new(law, chains.bonds(), list()?);
    let mut field = (springs, repulsion);
    start::relax(&mut system, &mut field, 0.02, 100)?;
    for _ in 0..settling {
        stepper.step(&mut system, &mut field, &mut ())?;
    }

    let mut counter = Crossings::new(chains, VerletList::new(0.0)?);
    let mut listener = SegmentRepulsion::new(Phantom::new(RANGE)?, chains.bonds(), list()?);
    let mut histogram = SpringDistribution::new(RANGE, BINS)?;
    let (mut distances, mut looks) = (vec![0.0; BINS], 0.0);
    let (mut crossings, mut pressure) = (0, 0.0);
    counter.measure(&system.frame(), &())?;
    for number in 0..steps {
        let mut virial = Virial::default();
        stepper.step(&mut system, &mut field, &mut virial)?;
        let frame = system.frame();
        crossings += counter.measure(&frame, &())?;
        let work = virial.item(Item::SpringRepulsion);
        pressure += (work.x_axis.x + work.y_axis.y + work.z_axis.z) / 3.0;
        if number % 10 == 0 {
            let mut unused = vec![DVec3::ZERO; frame.len()];
            let mut heard = SpringDistances::default();
            listener.accumulate(&frame, &mut unused, &mut heard)?;
            let pairs = histogram.measure(&frame, &heard);
            distances
                .iter_mut()
                .zip(pairs)
                .for_each(|(sum, n)| *sum += n);
            looks += 1.0;
        }
    }
    let ideal = f64::from(steps) * system.particles.len() as f64;
    let found = Row {
        law: name,
        barrier: law.energy(0.0),
        crossings,
        rate: crossings as f64 / (f64::from(steps) * STEP),
        pressure: pressure / ideal,
        distances: distances.iter().map(|sum| sum / looks).collect(),
    };
    println!(
        "{name}, {:.1} kT: {crossings} crossings, pressure {:.4}",
        found.barrier, found.pressure,
    );
    Ok(found)
}

/// What the figure is there to show, in numbers.
fn check(rows: &[Row]) -> Result<(), Problem> {
    let free = rows[0].rate;
    for row in rows.iter().filter(|row| row.barrier > 9.0) {
        let part = row.rate / free;
        if part > 1e-3 {
            return Err(format!("{}: {part:.1e} of all crossings pass", row.law).into());
        }
    }
    // For the same barrier the exponential law reaches less far.
    let of = |law| rows.iter().filter(move |row| row.law == law);
    for (linear, exponential) in of("Pan and Manke").zip(of("Kumar and Larson")) {
        if exponential.pressure > linear.pressure {
            return Err(format!(
                "{:.1} kT: the exponential law adds a pressure of {:.4}, the linear one {:.4}",
                linear.barrier, exponential.pressure, linear.pressure
            )
            .into());
        }
    }
    Ok(())
}
