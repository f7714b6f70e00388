//! What a step of DPD costs against the skin of its Verlet list, and how long a list lives: the fluid of Groot and Warren
//! at rest, in shear and in planar extension; and which skin a tuned list chooses. Skins are in units of the cutoff.

use crate::chart::{Curve, Panel};
use crate::{Problem, Task, scene};
use cpu_time::ProcessTime;
use plotters::prelude::SeriesLabelPosition;
use zimm::prelude::*;

const FLOWS: [&str; 3] = ["at rest", "shear, rate 0.2", "extension, rate 0.1"];

/// What one skin does.
struct Row {
    flow: &'static str,
    skin: f64,
    tuned: bool,
    /// CPU time for a particle and a step, in nanoseconds.
    cost: f64,
    /// Steps from one list to the next.
    lifetime: f64,
    /// Candidates of a particle, each pair counted once.
    candidates: f64,
}

pub(crate) fn figure(task: &Task) -> Result<(), Problem> {
    let edge = if task.quick { 10.0 } else { 20.0 };
    let mut rows = Vec::new();
    let sheared = LeesEdwards::new(DVec3::splat(edge), Steady::new(0.2)?)?;
    let extended = KraynikReinelt::new(edge * 2.0_f64.sqrt(), 0.5 * edge, Steady::new(0.1)?)?;
    rows.extend(sweep(task, FLOWS[0], scene::cube(edge))?);
    rows.extend(sweep(task, FLOWS[1], sheared)?);
    rows.extend(sweep(task, FLOWS[2], extended)?);
    task.csv(
        "flow,skin,tuned,cpu_nanoseconds,list_lifetime_steps,candidates_per_particle",
        rows.iter().map(|row| {
            format!(
                "\"{}\",{},{},{},{},{}",
                row.flow, row.skin, row.tuned, row.cost, row.lifetime, row.candidates
            )
        }),
    )?;
    let curve =
        |label: &str, colour, filled, shown: &dyn Fn(&Row) -> bool, pick: fn(&Row) -> f64| {
            let shown = rows.iter().filter(|row| shown(row));
            Curve {
                label: label.into(),
                colour,
                filled,
                points: shown.map(|row| (row.skin, pick(row))).collect(),
            }
        };
    let panel = |title, y, pick: fn(&Row) -> f64, legend| {
        let flows = FLOWS.iter().enumerate().map(|(colour, flow)| {
            let mine = |row: &Row| row.flow == *flow && !row.tuned;
            curve(flow, colour, true, &mine, pick)
        });
        let tuned = curve(
            "chosen by the list",
            FLOWS.len(),
            false,
            &|row| row.tuned,
            pick,
        );
        Panel {
            title,
            x: "skin / cutoff",
            y,
            legend,
            curves: flows.chain([tuned]).collect(),
        }
    };
    let (middle, left) = (
        SeriesLabelPosition::UpperMiddle,
        SeriesLabelPosition::UpperLeft,
    );
    task.draw(&[
        panel(
            "Cost of a step",
            "CPU time of a particle, ns",
            |row| row.cost,
            middle,
        ),
        panel("Life of a list", "steps", |row| row.lifetime, left),
    ])?;
    check(&rows)
}

/// The same state again and again, with one skin after another.
fn sweep<B: Periodic>(task: &Task, flow: &'static str, space: B) -> Result<Vec<Row>, Problem> {
    let skins: &[f64] = if task.quick {
        &[0.05, 0.2, 0.45, 0.8]
    } else {
        &[
            0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.7, 0.8, 1.0,
        ]
    };
    let steps = if task.quick { 100 } else { 300 };
    let (mut system, _) = scene::equilibrated(space);
    let lists = skins.iter().map(|&skin| Some(skin)).chain([None]);
    let mut rows = Vec::new();
    for skin in lists {
        let list = match skin {
            Some(skin) => VerletList::new(skin)?,
            None => VerletList::tuned(),
        };
        let mut field = Pairwise::new(Dpd::new(25.0, 4.5)?, list);
        let mut stepper = GrootWarren::new(0.65)?;
        for _ in 0..20 {
            stepper.step(&mut system, &mut field, &mut ())?;
        }
        let builds = field.neighbours().builds();
        let start = ProcessTime::now();
        for _ in 0..steps {
            stepper.step(&mut system, &mut field, &mut ())?;
        }
        let particles = system.particles.len() as f64;
        let builds = field.neighbours().builds() - builds;
        rows.push(Row {
            flow,
            skin: field.neighbours().skin(),
            tuned: skin.is_none(),
            cost: 1e9 * start.elapsed().as_secs_f64() / particles / f64::from(steps),
            lifetime: f64::from(steps) / builds.max(1) as f64,
            candidates: field.neighbours().candidates() as f64 / particles,
        });
    }
    Ok(rows)
}

/// What the figure is there to show, in numbers.
fn check(rows: &[Row]) -> Result<(), Problem> {
    for flow in FLOWS {
        let mine = rows.iter().filter(|row| row.flow == flow);
        let (tuned, mine): (Vec<&Row>, Vec<&Row>) = mine.partition(|row| row.tuned);
        let Some(best) = mine.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)) else {
            continue;
        };
        let near = mine.iter().filter(|row| row.cost < 1.1 * best.cost);
        let near = near.map(|row| row.skin);
        println!(
            "{flow}: {:.0} ns at a skin of {} (a list lives {:.1} steps), within 10 % from {} to {}",
            best.cost,
            best.skin,
            best.lifetime,
            near.clone().fold(f64::INFINITY, f64::min),
            near.fold(0.0, f64::max)
        );
        for tuned in tuned {
            let ratio = tuned.cost / best.cost;
            println!(
                "{flow}: {ratio:.2} times that at {:.3}, chosen by the list",
                tuned.skin
            );
            if ratio > 1.25 {
                return Err(
                    format!("{flow}: the list chose {}, {ratio} of the best", tuned.skin).into(),
                );
            }
        }
        // The list moves with the flow: streaming makes none invalid.
        for row in mine {
            let still = rows
                .iter()
                .find(|r| r.flow == FLOWS[0] && r.skin == row.skin && !r.tuned);
            if still.is_some_and(|still| row.lifetime < 0.8 * still.lifetime) {
                return Err(format!(
                    "{flow}: a list with a skin of {} lives only {} steps",
                    row.skin, row.lifetime
                )
                .into());
            }
        }
    }
    Ok(())
}
