//! The command line.

use crate::flow::Flow;
use clap::Parser;
use std::path::PathBuf;

/// Deforms a DPD solution of FENE dumbbells and measures what a rheometer would.
#[derive(Clone, Debug, Parser)]
#[command(name = "rheometer")]
pub(crate) struct Options {
    /// The flow.
    #[arg(long, value_enum, default_value_t = Flow::Shear)]
    pub(crate) flow: Flow,

    /// Mixedness of --flow mixed, from 0.01, nearly shear, to 1, extension.
    #[arg(long, value_name = "CHI", default_value_t = 0.5, value_parser = mixedness)]
    #[arg(allow_negative_numbers = true)]
    pub(crate) mixedness: f64,

    /// Rates, in 1/tau; some that suit the flow if not given.
    #[arg(long, value_name = "RATE,..", value_delimiter = ',', value_parser = rate)]
    #[arg(allow_negative_numbers = true)]
    pub(crate) rates: Vec<f64>,

    /// A coarse run of a few seconds.
    #[arg(long)]
    pub(crate) quick: bool,

    /// Seed of the initial state and of the noise; the same seed gives the same bits on any number of threads.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub(crate) seed: u64,

    /// Threads; all processors if not given.
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub(crate) threads: Option<usize>,

    /// Directory for rheometer.csv, rheometer.svg and the state of the run.
    #[arg(long, value_name = "DIR", default_value = "target/rheometer")]
    pub(crate) out: PathBuf,

    /// Prints one JSON object per rate instead of the table.
    #[arg(long)]
    pub(crate) json: bool,

    /// Goes on with an interrupted run of the same options from its last checkpoint.
    #[arg(long)]
    pub(crate) resume: bool,
}

impl Options {
    /// What the command line says, rates in rising order.
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

    /// What files of one rate are called.
    pub(crate) fn name_of_run(&self, rate: f64) -> String {
        match self.flow {
            Flow::Mixed => format!("mixed-{}-{rate}", self.mixedness),
            flow => format!("{}-{rate}", flow.name()),
        }
    }

    fn from_words<W>(words: impl IntoIterator<Item = W>) -> Result<Self, clap::Error>
    where
        W: Into<std::ffi::OsString> + Clone,
    {
        let mut options = Self::try_parse_from(words)?;
        if options.rates.is_empty() {
            options.rates = options.flow.default_rates();
        }
        options.rates.sort_by(f64::total_cmp);
        options.rates.dedup();
        Ok(options)
    }
}

fn rate(word: &str) -> Result<f64, String> {
    match word.trim().parse::<f64>() {
        Ok(rate) if (1e-4..=10.0).contains(&rate) => Ok(rate),
        Ok(_) => Err("a rate must be between 0.0001 and 10".into()),
        Err(_) if word.trim().is_empty() => Err("at least one rate is needed".into()),
        Err(_) => Err("a rate must be a number".into()),
    }
}

fn mixedness(word: &str) -> Result<f64, String> {
    match word.trim().parse::<f64>() {
        Ok(mixedness) if (0.01..=1.0).contains(&mixedness) => Ok(mixedness),
        Ok(_) => Err("the mixedness must be between 0.01 and 1 (--flow shear is 0)".into()),
        Err(_) => Err("the mixedness must be a number".into()),
    }
}

fn threads(word: &str) -> Result<usize, String> {
    match word.parse() {
        Ok(threads @ 1..=1024) => Ok(threads),
        _ => Err("the number of threads must be a whole number between 1 and 1024".into()),
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
        let words =
            std::iter::once("rheometer").chain(words.split(' ').filter(|word| !word.is_empty()));
        Options::from_words(words).map_err(|error| one_sentence(&error))
    }

    #[test]
    fn law_the_defaults_need_no_arguments() {
        let options = parse("").unwrap();
        assert_eq!(options.rates, [0.1, 0.2, 0.4, 0.8]);
        assert_eq!(
            (options.seed, options.threads, options.quick),
            (1, None, false)
        );
        assert_eq!(options.out, PathBuf::from("target/rheometer"));
    }

    #[test]
    fn law_rates_rise_and_occur_once() {
        let options = parse("--rates 0.4,0.1,0.4,1e-2 --threads 2 --seed 7").unwrap();
        assert_eq!(options.rates, [0.01, 0.1, 0.4]);
        assert_eq!((options.threads, options.seed), (Some(2), 7));
    }

    #[test]
    fn extreme_bad_arguments_get_one_sentence_that_names_them() {
        for words in [
            "--rates 0",
            "--rates -0.1",
            "--rates 0.1,-0.1",
            "--rates NaN",
            "--rates inf",
            "--rates 1e-9",
            "--rates 0.1,,0.2",
            "--rates ,",
            "--rates slow",
            "--rates=",
            "--mixedness 0",
            "--mixedness -0.5",
            "--mixedness 1.5",
            "--mixedness NaN",
            "--flow sideways",
            "--threads 0",
            "--threads -1",
            "--threads 1.5",
            "--threads 300000",
            "--seed -1",
            "--seed x",
            "--out",
            "--shear",
            "now",
        ] {
            let sentence = parse(words).unwrap_err();
            let name = words.split(['=', ' ']).next().unwrap();
            assert!(sentence.contains(name), "{words}: {sentence}");
            assert!(
                !sentence.contains('\n') && sentence.len() < 150,
                "{words}: {sentence}"
            );
        }
    }
}
