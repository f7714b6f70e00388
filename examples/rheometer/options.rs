//! The command line.

use crate::dpd::Solute;
use crate::flow::Flow;
use crate::{bd, dpd};
use clap::error::ErrorKind;
use clap::{Args, CommandFactory, Parser, ValueEnum};
use std::path::PathBuf;

/// Deforms a polymer solution and measures what a rheometer would.
#[derive(Clone, Debug, Parser)]
#[command(name = "rheometer")]
pub(crate) struct Options {
    /// How the solution is simulated.
    #[arg(long, value_enum, default_value_t = Method::Dpd)]
    pub(crate) method: Method,

    /// The flow.
    #[arg(long, value_enum, default_value_t = Flow::Shear)]
    pub(crate) flow: Flow,

    /// Mixedness of --flow mixed, from 0.01, nearly shear, to 1, extension.
    #[arg(long, value_name = "CHI", default_value_t = 0.5, value_parser = mixedness)]
    #[arg(allow_negative_numbers = true)]
    pub(crate) mixedness: f64,

    /// Rates, in 1/tau (dpd) or 1/lambda_H (bd); some that suit the flow if not given.
    #[arg(long, value_name = "RATE,..", value_delimiter = ',', value_parser = rate)]
    #[arg(allow_negative_numbers = true)]
    pub(crate) rates: Vec<f64>,

    /// Body forces of --flow rpf, each a run, in kT/r_c; some that suit it if not given.
    #[arg(long, value_name = "FORCE,..", value_delimiter = ',', value_parser = force)]
    #[arg(allow_negative_numbers = true)]
    pub(crate) forces: Vec<f64>,

    /// The molecules of --method dpd.
    #[command(flatten)]
    pub(crate) solute: Solute,

    /// The molecules of --method bd.
    #[command(flatten)]
    pub(crate) molecules: Molecule,

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

/// How a solution is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// Dissipative particle dynamics: FENE dumbbells or chains among particles of solvent.
    Dpd,
    /// Brownian dynamics: isolated bead-spring chains.
    Bd,
}

/// A spring law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Spring {
    /// Finitely extensible, after Warner.
    Fene,
    /// Hookean: Rouse chains.
    Hooke,
    /// Worm-like chain, after Marko and Siggia.
    Wlc,
}

/// How the flow goes on in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Protocol {
    /// Steady flow.
    Steady,
    /// From rest into the flow.
    StartUp,
    /// From the steady flow to rest.
    Cessation,
    /// Rest after a sudden strain of the size of the rate.
    Step,
    /// Small oscillations, with the rates as angular frequencies.
    Oscillation,
}

/// How beads move each other through the solvent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Hydrodynamics {
    /// Not at all.
    None,
    /// Isolated chains, Rotne-Prager-Yamakawa.
    Rpy,
    /// Many chains in a periodic cell, Ewald sums.
    Ewald,
    /// The same, on a mesh.
    Mesh,
}

/// A bead-spring chain of --method bd, in units of kT, l_H = sqrt(kT / H) and lambda_H = zeta / 4H.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Molecule {
    /// Beads of a chain.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = beads)]
    pub(crate) beads: u32,

    /// Springs between them.
    #[arg(long, value_enum, default_value_t = Spring::Fene)]
    pub(crate) spring: Spring,

    /// Extensibility b = H Q_0^2 / kT of FENE and worm-like springs.
    #[arg(long, value_name = "B", default_value_t = 50.0, value_parser = extensibility)]
    #[arg(allow_negative_numbers = true)]
    pub(crate) extensibility: f64,

    /// Strength z* of the excluded volume U/kT = (z*/d*^3) exp(-r^2 / 2 d*^2); none if not given.
    #[arg(long, value_name = "Z", value_parser = strength, allow_negative_numbers = true)]
    pub(crate) excluded_volume: Option<f64>,

    /// Range d* of the excluded volume.
    #[arg(long, value_name = "D", default_value_t = 1.0, value_parser = range)]
    #[arg(allow_negative_numbers = true)]
    pub(crate) excluded_volume_range: f64,

    /// Hydrodynamic interactions.
    #[arg(long, value_enum, default_value_t = Hydrodynamics::None)]
    pub(crate) hi: Hydrodynamics,

    /// Hydrodynamic interaction parameter h*: beads of radius sqrt(pi) h* l_H.
    #[arg(long, value_name = "H", default_value_t = 0.25, value_parser = hstar)]
    #[arg(allow_negative_numbers = true)]
    pub(crate) hstar: f64,

    /// Concentration c/c* of chains in a cell (--hi ewald or mesh).
    #[arg(long, value_name = "C", default_value_t = 0.1, value_parser = concentration)]
    #[arg(allow_negative_numbers = true)]
    pub(crate) concentration: f64,

    /// How the flow goes on in time.
    #[arg(long, value_enum, default_value_t = Protocol::Steady)]
    pub(crate) protocol: Protocol,
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

    /// What files of one rate, or body force, are called.
    pub(crate) fn name_of_run(&self, rate: f64) -> String {
        let solute = self.solute.name();
        match self.flow {
            Flow::Mixed => format!("{solute}mixed-{}-{rate}", self.mixedness),
            flow => format!("{solute}{}-{rate}", flow.name()),
        }
    }

    /// For tests of other modules.
    #[cfg(test)]
    pub(crate) fn of_words(words: &str) -> Self {
        Self::from_words(words.split(' ')).unwrap()
    }

    fn from_words<W>(words: impl IntoIterator<Item = W>) -> Result<Self, clap::Error>
    where
        W: Into<std::ffi::OsString> + Clone,
    {
        let mut options = Self::try_parse_from(words)?;
        if let Some(sentence) = options.clash() {
            let sentence = format!("{sentence}\n");
            return Err(Self::command().error(ErrorKind::ArgumentConflict, sentence));
        }
        if options.forces.is_empty() {
            options.forces = dpd::DEFAULT_FORCES.to_vec();
        }
        if options.rates.is_empty() {
            options.rates = match options.method {
                Method::Dpd => dpd::default_rates(options.flow, options.solute),
                Method::Bd => bd::default_rates(options.flow),
            };
        }
        let allowed = match options.method {
            Method::Dpd => 1e-7..=10.0,
            Method::Bd => 1e-4..=1e6,
        };
        if let Some(rate) = options.rates.iter().find(|rate| !allowed.contains(*rate)) {
            let (least, most) = (allowed.start(), allowed.end());
            let sentence = format!("--rates: {rate} is not between {least} and {most}\n");
            return Err(Self::command().error(ErrorKind::ValueValidation, sentence));
        }
        for numbers in [&mut options.rates, &mut options.forces] {
            numbers.sort_by(f64::total_cmp);
            numbers.dedup();
        }
        Ok(options)
    }

    /// What does not go together.
    fn clash(&self) -> Option<&'static str> {
        match (self.flow, self.method) {
            (Flow::Rpf, Method::Bd) => Some("--flow rpf goes with --method dpd only"),
            (Flow::Rpf, _) if !self.rates.is_empty() => Some(
                "--rates does not go with --flow rpf, which has all rates up to those that --forces cause",
            ),
            (Flow::Rpf, _) => None,
            _ if !self.forces.is_empty() => Some("--forces goes with --flow rpf only"),
            _ => None,
        }
    }
}

fn rate(word: &str) -> Result<f64, String> {
    match word.trim().parse::<f64>() {
        Ok(rate) if rate.is_finite() => Ok(rate),
        Ok(_) => Err("a rate must be finite".into()),
        Err(_) if word.trim().is_empty() => Err("at least one rate is needed".into()),
        Err(_) => Err("a rate must be a number".into()),
    }
}

fn force(word: &str) -> Result<f64, String> {
    between(word, "a body force", 1e-3, 10.0)
}

fn mixedness(word: &str) -> Result<f64, String> {
    between(word, "the mixedness (--flow shear is 0)", 0.01, 1.0)
}

fn beads(word: &str) -> Result<u32, String> {
    match word.parse() {
        Ok(beads @ 2..=10_000) => Ok(beads),
        _ => Err("a chain must have between 2 and 10000 beads".into()),
    }
}

fn extensibility(word: &str) -> Result<f64, String> {
    between(word, "the extensibility", 1.0, 1e9)
}

fn strength(word: &str) -> Result<f64, String> {
    between(word, "the excluded volume", 0.0, 1e3)
}

fn hstar(word: &str) -> Result<f64, String> {
    between(word, "h*", 0.001, 0.5)
}

fn concentration(word: &str) -> Result<f64, String> {
    between(word, "the concentration", 1e-4, 10.0)
}

fn range(word: &str) -> Result<f64, String> {
    between(word, "the range of the excluded volume", 0.1, 10.0)
}

fn between(word: &str, what: &str, least: f64, most: f64) -> Result<f64, String> {
    match word.trim().parse::<f64>() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        Ok(_) => Err(format!("{what} must be between {least} and {most}")),
        Err(_) => Err(format!("{what} must be a number")),
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

    /// For 20 beads in the same fluid lambda_1 / lambda_H = sin^2(pi / 4) / sin^2(pi / 40) = 81.2, and rates are as much
    /// lower. They rise, and none is so high that extension stirs the fluid.
    #[test]
    fn limit_default_rates_follow_the_longest_relaxation_time() {
        let flows = |words: &str| parse(&format!("--flow extension {words}")).unwrap().rates;
        assert_eq!(flows(""), [0.05, 0.1, 0.2, 0.28]);
        assert_eq!(
            parse("--chain 20").unwrap().rates,
            [0.0012, 0.0025, 0.0049, 0.0098]
        );
        assert_eq!(flows("--chain 20"), [0.00062, 0.0012, 0.0025, 0.0034]);
        for words in [
            "--gamma-la 0.1",
            "--gamma-la 100",
            "--chain 200 --gamma-la 30",
        ] {
            let rates = flows(words);
            assert!(
                rates.is_sorted() && rates.iter().all(|rate| *rate <= 0.28),
                "{rates:?}"
            );
        }
        assert_eq!(parse("--chain 20 --rates 0.3").unwrap().rates, [0.3]);
    }

    #[test]
    fn law_rates_rise_and_occur_once() {
        let options = parse("--rates 0.4,0.1,0.4,1e-2 --threads 2 --seed 7").unwrap();
        assert_eq!(options.rates, [0.01, 0.1, 0.4]);
        assert_eq!((options.threads, options.seed), (Some(2), 7));
    }

    /// Checkpoints of one solution are not found by a run of another.
    #[test]
    fn law_runs_of_different_solutions_have_different_names() {
        let name = |words| parse(words).unwrap().name_of_run(0.1);
        assert_eq!(name(""), "shear-0.1");
        let all = "--chain 20 --spring-repulsion exponential --gamma-la 5";
        assert_eq!(name(all), "chain-20-exponential-la-5-shear-0.1");
        assert_eq!(name("--spring-repulsion linear"), "linear-shear-0.1");
        assert_eq!(name("--flow rpf"), "rpf-0.1");
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
            "--forces 0.1",
            "--flow rpf --rates 0.1",
            "--flow rpf --forces 0",
            "--flow rpf --forces -0.1",
            "--flow rpf --forces NaN",
            "--flow rpf --forces ,",
            "--method bd --flow rpf",
            "--method md",
            "--chain 1",
            "--chain 1000",
            "--spring-repulsion hard",
            "--gamma-la 0",
            "--gamma-la -5",
            "--gamma-la 1000",
            "--method bd --beads 1",
            "--method bd --beads 2.5",
            "--method bd --spring rope",
            "--method bd --extensibility 0.5",
            "--method bd --extensibility NaN",
            "--method bd --excluded-volume -1",
            "--method bd --excluded-volume-range 0",
            "--method bd --protocol never",
            "--method bd --hi oseen",
            "--method bd --hstar 0",
            "--method bd --hstar 2",
            "--method bd --concentration 0",
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
            let name = words.trim_start_matches("--method bd ");
            let name = name.trim_start_matches("--flow rpf ");
            let name = name.split(['=', ' ']).next().unwrap();
            assert!(sentence.contains(name), "{words}: {sentence}");
            assert!(
                !sentence.contains('\n') && sentence.len() < 150,
                "{words}: {sentence}"
            );
        }
    }
}
