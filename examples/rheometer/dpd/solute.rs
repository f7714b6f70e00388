//! The molecules, how their springs repel each other, and the scheme in time.

use super::{EXTENSIBILITY, KT, LIMIT, SKIN};
use crate::Problem;
use clap::{Args, ValueEnum};
use std::f64::consts::{FRAC_PI_2, PI};
use zimm::prelude::*;

/// Friction of a dumbbell's bead as this example finds it in coarse runs: 12.47(13) with friction and noise, 10.0(2) with
/// Lowe and Andersen's dynamics at the rate 5, here taken to be proportional to the rate.
const GROOT_WARREN_FRICTION: f64 = 12.5;
const LOWE_ANDERSEN_FRICTION: f64 = 2.0;

/// How springs repel each other, so that chains do not pass through each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Law {
    /// Not at all.
    None,
    /// F = 3 a (1 - 3 D / r_c), after Pan and Manke.
    Linear,
    /// F = A alpha exp(-alpha D) with A = 100 and alpha = 10, after Kumar and Larson.
    Exponential,
}

/// What --method dpd dissolves, and in what.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Solute {
    /// Beads of a chain of --method dpd.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = beads)]
    pub(crate) chain: u32,

    /// Repulsion between springs of --method dpd.
    #[arg(long, value_enum, default_value_t = Law::None)]
    pub(crate) spring_repulsion: Law,

    /// Rate at which --method dpd redraws the relative velocities of pairs after Lowe and Andersen, in 1/tau; friction
    /// and noise after Groot and Warren if not given.
    #[arg(long, value_name = "GAMMA", value_parser = bath_rate, allow_negative_numbers = true)]
    pub(crate) gamma_la: Option<f64>,
}

impl Solute {
    /// Begins the names of files, nothing for the default.
    pub(crate) fn name(&self) -> String {
        let mut name = String::new();
        if self.chain != 2 {
            name += &format!("chain-{}-", self.chain);
        }
        if self.spring_repulsion != Law::None {
            name += &format!("{:?}-", self.spring_repulsion).to_lowercase();
        }
        if let Some(rate) = self.gamma_la {
            name += &format!("la-{rate}-");
        }
        name
    }

    /// As it reads in a sentence.
    pub(crate) fn title(&self) -> String {
        match self.chain {
            2 => "dumbbells".into(),
            beads => format!("chains of {beads} beads"),
        }
    }

    /// Springs of a chain.
    pub(crate) fn springs(&self) -> f64 {
        f64::from(self.chain - 1)
    }

    /// An estimate of the longest relaxation time over that of dumbbells in the fluid of Groot and Warren, exactly 1 for
    /// these and for what is faster. Default rates and times follow it; what is reported follows the friction that is
    /// found.
    pub(crate) fn slowness(&self) -> f64 {
        let friction = self.gamma_la.map_or(1.0, |rate| {
            LOWE_ANDERSEN_FRICTION * rate / GROOT_WARREN_FRICTION
        });
        (friction / self.twice_square()).max(1.0)
    }

    /// 2 sin^2(pi / 2N) = 1 - cos(pi / N), exactly 1 for two beads.
    fn twice_square(&self) -> f64 {
        1.0 - (FRAC_PI_2 - PI / f64::from(self.chain)).sin()
    }

    /// The longest relaxation time over the friction of a bead, 1 / (8 H sin^2(pi / 2N)), for two beads 1 / 4H.
    pub(crate) fn time_per_friction(&self) -> Result<f64, ParameterError> {
        Ok(0.25 / spring()?.stiffness() / self.twice_square())
    }
}

/// The spring of all molecules.
pub(crate) fn spring() -> Result<Fene, ParameterError> {
    Fene::with_extensibility(EXTENSIBILITY, LIMIT, KT)
}

/// The springs' repulsion, chosen at run time: it is looked at once a step.
#[derive(Clone, Debug)]
pub(crate) enum SpringRepulsion {
    None,
    Linear(SegmentRepulsion<PanManke, VerletList>),
    Exponential(SegmentRepulsion<KumarLarson, VerletList>),
}

impl SpringRepulsion {
    /// Between the springs of these molecules.
    pub(crate) fn new(
        law: Law,
        molecules: &Molecules,
        bead_repulsion: f64,
    ) -> Result<Self, Problem> {
        let (bonds, list) = (molecules.bonds(), VerletList::new(SKIN)?);
        Ok(match law {
            Law::None => Self::None,
            Law::Linear => {
                let law = PanManke::new(bead_repulsion, 1.0)?;
                Self::Linear(SegmentRepulsion::new(law, bonds, list))
            }
            Law::Exponential => {
                let law = KumarLarson::new(100.0, 10.0, 1.0 / 3.0)?;
                Self::Exponential(SegmentRepulsion::new(law, bonds, list))
            }
        })
    }
}

impl<B: Periodic> ForceField<B> for SpringRepulsion {
    const READS: Reads = Reads::NOTHING;
    const CONSERVES_MOMENTUM: bool = true;

    fn accumulate<T: Tally>(
        &mut self,
        frame: &Frame<'_, B>,
        forces: &mut [DVec3],
        tally: &mut T,
    ) -> Result<(), ForceError> {
        match self {
            Self::None => Ok(()),
            Self::Linear(field) => field.accumulate(frame, forces, tally),
            Self::Exponential(field) => field.accumulate(frame, forces, tally),
        }
    }

    fn forget(&mut self) {
        match self {
            Self::None => {}
            Self::Linear(field) => ForceField::<B>::forget(field),
            Self::Exponential(field) => ForceField::<B>::forget(field),
        }
    }
}

fn beads(word: &str) -> Result<u32, String> {
    match word.parse() {
        Ok(beads @ 2..=200) => Ok(beads),
        _ => Err("a chain must have between 2 and 200 beads".into()),
    }
}

fn bath_rate(word: &str) -> Result<f64, String> {
    match word.trim().parse::<f64>() {
        Ok(rate) if (0.1..=100.0).contains(&rate) => Ok(rate),
        Ok(_) => Err("the rate of redrawing must be between 0.1 and 100".into()),
        Err(_) => Err("the rate of redrawing must be a number".into()),
    }
}
