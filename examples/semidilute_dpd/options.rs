//! The command line.

use crate::solution::{DT, IMAGES, RELAXATION_TIME, Solution};
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, ValueEnum};
use std::ffi::OsString;
use std::path::PathBuf;

/// Lets a semidilute solution of chains flow, or several of them.
#[derive(Debug, Parser)]
#[command(name = "semidilute_dpd")]
pub(crate) struct Options {
    /// Concentrations over the overlap concentration.
    #[arg(long, value_name = "C,..", value_delimiter = ',', default_values_t = [1.0])]
    #[arg(value_parser = positive, allow_negative_numbers = true)]
    concentration: Vec<f64>,
    /// How solvent and chains get along.
    #[arg(long, value_enum, default_value_t = Solvent::Theta)]
    solvent: Solvent,
    /// The flow.
    #[arg(long, value_enum, default_value_t = Flow::Extension)]
    pub(crate) flow: Flow,
    /// Deborah numbers, each the rate times the relaxation time below c*.
    #[arg(long, value_name = "DE,..", value_delimiter = ',', default_values_t = [1.0])]
    #[arg(value_parser = positive, allow_negative_numbers = true)]
    de: Vec<f64>,
    /// Rates of shear or extension in 1 / tau, instead of --de.
    #[arg(
        long,
        value_name = "RATE,..",
        value_delimiter = ',',
        conflicts_with = "de"
    )]
    #[arg(value_parser = positive, allow_negative_numbers = true)]
    rate: Vec<f64>,
    /// How chains begin: stretched in a sweep of extension, else as coils, if not given.
    #[arg(long, value_enum)]
    start: Option<Start>,
    /// Force of springs on each other at contact, in kT / r_c: 1000 as the law is printed, 100 as its pictures show it; 0 lets
    /// springs pass through each other.
    #[arg(long, value_name = "F", default_value_t = 1000.0)]
    #[arg(value_parser = not_negative, allow_negative_numbers = true)]
    contact_force: f64,
    /// Distance of the images of the cell, 10 or more: twice as far as a spring may reach.
    #[arg(long, value_name = "L", default_value_t = IMAGES)]
    #[arg(value_parser = apart, allow_negative_numbers = true)]
    pub(crate) images: f64,
    /// Time in the flow, in relaxation times.
    #[arg(long, value_name = "T", default_value_t = 10.0)]
    #[arg(value_parser = positive, allow_negative_numbers = true)]
    times: f64,
    /// Independent runs of each concentration and rate.
    #[arg(long, value_name = "K", default_value_t = 1)]
    #[arg(value_parser = clap::value_parser!(u64).range(1..=1000), allow_negative_numbers = true)]
    runs: u64,
    /// Seed of the first run, each has the next; the same seed gives the same bits on any number of threads.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    seed: u64,
    /// A third of a relaxation time.
    #[arg(long)]
    quick: bool,
    /// Directory for semidilute_dpd.csv, semidilute_dpd.svg and the checkpoints.
    #[arg(long, default_value = "target/semidilute_dpd")]
    pub(crate) out: PathBuf,
    /// Goes on from the checkpoints.
    #[arg(long)]
    pub(crate) resume: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Solvent {
    /// All beads are alike.
    Theta,
    /// Beads of chains and of solvent repel each other less.
    Good,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Flow {
    /// No flow.
    Rest,
    /// u = (rate y, 0, 0).
    Shear,
    /// u = rate (x, -y, 0).
    Extension,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Start {
    /// In equilibrium.
    Coils,
    /// Pulled out straight along x, to half of the contour.
    Stretched,
}

impl Options {
    /// What the command line says, concentrations and rates in rising order.
    ///
    /// # Errors
    /// One sentence, for standard error.
    pub(crate) fn parse_command_line() -> Result<Self, String> {
        Self::from_words(std::env::args_os()).map_err(|error| {
            if !error.use_stderr() {
                error.exit(); // --help
            }
            one_sentence(&error)
        })
    }

    fn from_words(
        words: impl IntoIterator<Item: Into<OsString> + Clone>,
    ) -> Result<Self, clap::Error> {
        let mut options = Self::try_parse_from(words)?;
        if options.rate.is_empty() {
            options.rate = options.de.iter().map(|de| de / RELAXATION_TIME).collect();
        }
        if options.flow == Flow::Rest {
            options.rate = vec![0.0];
        }
        for numbers in [&mut options.concentration, &mut options.rate] {
            numbers.sort_by(f64::total_cmp);
            numbers.dedup();
        }
        if options.flow == Flow::Rest && options.solutions().len() > 1 {
            let sentence = "--flow rest is one run, a sweep takes shear or extension\n";
            return Err(Self::command().error(ErrorKind::ArgumentConflict, sentence));
        }
        Ok(options)
    }

    /// All runs, those of one concentration and rate side by side.
    pub(crate) fn solutions(&self) -> Vec<Solution> {
        let count = self.concentration.len() as u64 * self.rate.len() as u64 * self.runs;
        let default = match self.flow {
            Flow::Extension if count > 1 => Start::Stretched,
            _ => Start::Coils,
        };
        let mut solutions = Vec::new();
        for &concentration in &self.concentration {
            for &rate in &self.rate {
                solutions.extend((0..self.runs).map(|run| Solution {
                    concentration,
                    solvent: self.solvent,
                    flow: self.flow,
                    rate,
                    contact_force: self.contact_force,
                    images: self.images,
                    start: self.start.unwrap_or(default),
                    seed: self.seed.wrapping_add(run),
                }));
            }
        }
        solutions
    }

    pub(crate) fn steps(&self) -> u64 {
        let times = if self.quick { 0.3 } else { self.times };
        (times * RELAXATION_TIME / DT).ceil() as u64
    }
}

fn positive(word: &str) -> Result<f64, String> {
    match not_negative(word)? {
        0.0 => Err("must be above zero".into()),
        value => Ok(value),
    }
}

fn apart(word: &str) -> Result<f64, String> {
    match not_negative(word)? {
        value if value < IMAGES => Err(format!("must be {IMAGES} or more")),
        value => Ok(value),
    }
}

fn not_negative(word: &str) -> Result<f64, String> {
    match word.trim().parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value),
        Ok(_) => Err("must be finite and not below zero".into()),
        Err(_) if word.trim().is_empty() => Err("a number is missing".into()),
        Err(_) => Err("must be a number".into()),
    }
}

/// The parser's message without its advice on usage.
fn one_sentence(error: &clap::Error) -> String {
    let message = error.to_string();
    let line = message.lines().next().unwrap_or_default();
    line.trim_start_matches("error: ").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(words: &str) -> Result<Options, String> {
        let words = std::iter::once("semidilute_dpd").chain(words.split_whitespace());
        Options::from_words(words).map_err(|error| one_sentence(&error))
    }

    /// No two runs share a checkpoint.
    #[test]
    fn law_runs_of_a_sweep_rise_and_differ() {
        let options = parse("--concentration 2,0.5,2 --rate 0.02,0.01 --runs 2 --seed 7").unwrap();
        let runs = options.solutions();
        let found: Vec<_> = runs
            .iter()
            .map(|run| (run.concentration, run.rate, run.seed))
            .collect();
        let of = |c| [(c, 0.01, 7), (c, 0.01, 8), (c, 0.02, 7), (c, 0.02, 8)];
        assert_eq!(found, [of(0.5), of(2.0)].concat());
        assert!(runs.iter().all(|run| run.start == Start::Stretched));
    }

    #[test]
    fn law_one_run_begins_as_coils_unless_told_otherwise() {
        for (words, start) in [
            ("", Start::Coils),
            ("--flow rest", Start::Coils),
            ("--start stretched", Start::Stretched),
            ("--flow shear --de 1,2", Start::Coils),
            ("--de 1,2 --start coils", Start::Coils),
        ] {
            assert!(
                parse(words)
                    .unwrap()
                    .solutions()
                    .iter()
                    .all(|run| run.start == start)
            );
        }
    }

    #[test]
    fn extreme_bad_arguments_get_one_sentence_that_names_them() {
        for words in [
            "--de 0",
            "--de -1",
            "--de NaN",
            "--de inf",
            "--de ,",
            "--de=",
            "--de 1,,2",
            "--de fast",
            "--rate 0",
            "--rate 0.1 --de 1",
            "--concentration 0",
            "--concentration ,",
            "--times 0",
            "--times NaN",
            "--runs 0",
            "--seed -1",
            "--start tangled",
            "--flow sideways",
            "--flow rest --concentration 1,2",
            "--flow rest --runs 2",
        ] {
            let sentence = parse(words).unwrap_err();
            let name = words.split(['=', ' ']).next().unwrap();
            assert!(sentence.contains(name), "{words}: {sentence}");
            let one = !sentence.contains('\n') && sentence.len() < 150;
            assert!(one, "{words}: {sentence}");
        }
    }
}
