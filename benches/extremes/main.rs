//! The stability study: every scheme over its stiff and extreme cases, as one table of what was tried and what came back.
//!
//! ```text
//! cargo run --release -p benches --bin extremes
//! ```
//!
//! What comes back is an answer, an error that tells its reason in numbers, or a silent failure: an answer that is not
//! finite, that breaks a law which holds at any step (a spring beyond its limit), or that is wrong where theory knows
//! better. The last line counts those; it must say 0.

mod chains;
mod dpd;
mod hydrodynamics;

use std::error::Error;
use std::process::ExitCode;

/// What went wrong with the study itself.
type Problem = Box<dyn Error + Send + Sync>;

/// What came back.
enum Outcome {
    /// An answer that is as it should be, and what is known of it.
    Answer(String),
    /// A typed error.
    Refused(String),
    /// Neither.
    Silent(String),
}

/// One line of the table.
struct Trial {
    scheme: &'static str,
    tried: String,
    outcome: Outcome,
}

fn main() -> ExitCode {
    let all = || -> Result<Vec<Trial>, Problem> {
        let mut trials = chains::trials()?;
        trials.extend(dpd::trials()?);
        trials.extend(hydrodynamics::trials()?);
        Ok(trials)
    };
    let trials = match all() {
        Ok(trials) => trials,
        Err(error) => {
            eprintln!("extremes: {error}");
            return ExitCode::FAILURE;
        }
    };
    let width = |part: fn(&Trial) -> usize| trials.iter().map(part).max().unwrap_or(0);
    let (scheme, tried) = (
        width(|t| t.scheme.len()),
        width(|t| t.tried.chars().count()),
    );
    let mut silent = 0;
    for trial in &trials {
        let (kind, text) = match &trial.outcome {
            Outcome::Answer(text) => ("answer", text),
            Outcome::Refused(text) => ("error ", text),
            Outcome::Silent(text) => {
                silent += 1;
                ("SILENT", text)
            }
        };
        println!(
            "{:scheme$}  {:tried$}  {kind}  {text}",
            trial.scheme, trial.tried
        );
    }
    println!("silent failures: {silent}");
    if silent == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
