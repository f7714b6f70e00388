//! The anatomy of a step: what its parts cost, what a law of one's own costs, and that what a scene leaves out costs
//! nothing. One Markdown table each.
//!
//! ```text
//! cargo run --release -p benches --bin anatomy                       every table
//! cargo run --release -p benches --bin anatomy -- shares             one of them
//! cargo run --release -p benches --bin anatomy -- --quick            small scenes, within seconds
//! ```
//!
//! Everything is measured from outside, on a film: some twenty states, one step apart, of a run that has settled. The film
//! begins and ends where the run made a list, so that a list that watches it again and again is made as often as in the
//! run. Times are CPU time of one thread for a particle and a step in nanoseconds, medians of five runs that take turns.
//! A table that does not show what it is there to show is an error, with bounds that a busy machine keeps.

mod film;
mod left_out;
mod limits;
mod own_law;
#[path = "../scene.rs"]
#[allow(dead_code, clippy::expect_used)]
mod scene;
mod shares;
#[path = "../states.rs"]
mod states;
mod timing;

use clap::{Parser, ValueEnum};
use std::error::Error;

/// What went wrong, in one sentence.
type Problem = Box<dyn Error + Send + Sync>;

#[derive(Parser)]
struct Options {
    /// The tables to print; all if none is named.
    tables: Vec<Table>,
    /// Small scenes, to see that ratios hold.
    #[arg(long)]
    quick: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Table {
    /// What the parts of a step cost.
    Shares,
    /// A law of one's own beside the library's.
    OwnLaw,
    /// Steps with and without what a scene may leave out.
    LeftOut,
}

fn main() -> Result<(), Problem> {
    let options = Options::parse();
    // Work stays on the thread whose time is taken.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        let tables = if options.tables.is_empty() {
            Table::value_variants()
        } else {
            &options.tables
        };
        for table in tables {
            match table {
                Table::Shares => shares::table(options.quick)?,
                Table::OwnLaw => own_law::table(options.quick)?,
                Table::LeftOut => left_out::table(options.quick)?,
            }
            println!();
        }
        Ok(())
    })
}
