//! The work-precision study: what an approximation really errs by, against what it costs. One figure a name, each a
//! CSV and an SVG.
//!
//! ```text
//! cargo run --release -p benches --bin study                 every figure, into benches/study/
//! cargo run --release -p benches --bin study -- lattice      one of them
//! cargo run --release -p benches --bin study -- --quick      coarse ones, in two minutes
//! ```
//!
//! Every figure's file says what it compares; `STUDY.md` shows them and says what to choose when. A figure checks the
//! orders and rankings that it is there to show, and fails if they do not hold.

mod chain_steps;
mod chart;
mod dpd_steps;
mod hydrodynamic_steps;
mod kept;
mod lattice;
#[path = "../memory.rs"]
mod memory;
mod mobility;
mod sampling;
#[path = "../scene.rs"]
#[allow(dead_code, clippy::expect_used)]
mod scene;
mod size;
mod skin;
mod spring_repulsion;
mod viscosity;

use chart::Panel;
use clap::{Parser, ValueEnum};
use std::error::Error;
use std::fs;
use std::path::PathBuf;

/// What went wrong, in one sentence.
type Problem = Box<dyn Error + Send + Sync>;

#[derive(Parser)]
struct Options {
    /// The figures to make; all if none is named.
    figures: Vec<Figure>,
    /// Coarse figures, to see that orders and rankings hold.
    #[arg(long)]
    quick: bool,
    /// Where CSV and SVG go.
    #[arg(long, default_value = "benches/study")]
    out: PathBuf,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Figure {
    /// Error of the carried lattice against the number of periods.
    Lattice,
    /// Error of schemes for bead-spring chains against step and CPU time.
    ChainSteps,
    /// CPU time and error of products with a periodic mobility and of its roots.
    Mobility,
    /// CPU time of a unit of time with hydrodynamic interactions, at equal error.
    HydrodynamicSteps,
    /// Error and CPU time of mobilities that are kept for several steps.
    Kept,
    /// Error of the schemes of DPD against step and CPU time: the fluid of Groot and Warren.
    DpdSteps,
    /// The same for FENE chains with strong friction.
    DpdStiffSteps,
    /// CPU time of a DPD step against the skin of its list.
    Skin,
    /// Crossings and pressure against the height of springs' repulsion.
    SpringRepulsion,
    /// Error of averages against CPU time, by the sampling interval.
    Sampling,
    /// CPU time and memory of a particle against the number of particles.
    Size,
    /// Relative error of the viscosity against CPU time, by three rheometers.
    Viscosity,
}

fn main() -> Result<(), Problem> {
    let options = Options::parse();
    fs::create_dir_all(&options.out)?;
    let figures = if options.figures.is_empty() {
        Figure::value_variants()
    } else {
        &options.figures
    };
    for figure in figures {
        let value = figure.to_possible_value();
        let task = Task {
            name: value.map_or_else(String::new, |value| value.get_name().into()),
            quick: options.quick,
            out: options.out.clone(),
        };
        match figure {
            Figure::Lattice => lattice::figure(&task)?,
            Figure::ChainSteps => chain_steps::figure(&task)?,
            Figure::Mobility => mobility::figure(&task)?,
            Figure::HydrodynamicSteps => hydrodynamic_steps::figure(&task)?,
            Figure::Kept => kept::figure(&task)?,
            Figure::DpdSteps => dpd_steps::figure(&task, &dpd_steps::FLUID)?,
            Figure::DpdStiffSteps => dpd_steps::figure(&task, &dpd_steps::CHAINS)?,
            Figure::Skin => skin::figure(&task)?,
            Figure::SpringRepulsion => spring_repulsion::figure(&task)?,
            Figure::Sampling => sampling::figure(&task)?,
            Figure::Size => size::figure(&task)?,
            Figure::Viscosity => viscosity::figure(&task)?,
        }
        println!("{}: {}", task.name, task.path("svg").display());
    }
    Ok(())
}

/// One figure to be made.
struct Task {
    name: String,
    /// Whether a coarse figure is enough.
    quick: bool,
    out: PathBuf,
}

impl Task {
    fn path(&self, extension: &str) -> PathBuf {
        self.out.join(format!("{}.{extension}", self.name))
    }

    /// Writes the numbers.
    fn csv(&self, names: &str, lines: impl IntoIterator<Item = String>) -> Result<(), Problem> {
        let mut text = format!("{names}\n");
        for line in lines {
            text += &line;
            text.push('\n');
        }
        Ok(fs::write(self.path("csv"), text)?)
    }

    /// Draws the panels side by side.
    fn draw(&self, panels: &[Panel]) -> Result<(), Problem> {
        chart::draw(&self.path("svg"), panels)
    }
}
