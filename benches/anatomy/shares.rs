//! What the parts of a step cost: the fluid of Groot and Warren, the same with FENE chains in shear, Fedosov's melt; each
//! with the skin that makes its whole step cheapest.
//!
//! The pair loop is measured as a ladder: the list alone; with the driver around it and empty rows; looking at the
//! candidates with a cutoff that none is within; a law of constant zero, which adds forces; the same reading velocities;
//! DPD that reads no noise; all of DPD. Parts are the differences, so together they are the whole pair loop. Integration
//! is a step whose forces do nothing, bonds are bonds alone. That the sum is the whole step says that the parts do not
//! disturb each other. (With empty rows a block joins the forces on its own particles only; those on others' are with
//! the candidates.)

use crate::film::Film;
use crate::timing::{medians, seconds};
use crate::{Problem, limits, scene, states};
use std::marker::PhantomData;
use zimm::core::noise::Site;
use zimm::prelude::*;

/// A pair in a bare force loop, without a list to be made: pairs within the cutoff are packed, laws with uniform noise
/// evaluated in lanes, forces added. It took 111 to 124 ns for a particle of the fluid of Groot and Warren, which has 6.0
/// pairs, with a skin of 0.3 on a Cascade-Lake core of 3 GHz: a measure of other machines, not of this one.
const BARE_LOOP: f64 = 118.0 / 6.0;

pub(crate) fn table(quick: bool) -> Result<(), Problem> {
    let mut columns = vec![dpd(10.0, quick)?];
    if quick {
        columns.push(fene_shear(3_000.0, quick)?);
        columns.push(fedosov(3_000.0, quick)?);
    } else {
        columns.push(dpd(20.0, quick)?);
        columns.push(fene_shear(24_000.0, quick)?);
        columns.push(fedosov(30_000.0, quick)?);
    }
    print(&columns);
    check(&columns)
}

fn dpd(edge: f64, quick: bool) -> Result<Column, Problem> {
    let scene = Scene {
        name: "DPD",
        system: scene::fluid(scene::cube(edge)),
        cutoff: 1.0,
        weight: Quadratic,
        rest: (),
        stepper: GrootWarren::new(0.65)?,
        before: &[(200, 0.04)],
        skins: &[0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6],
    };
    // Kicks, prediction and positions read r, c, f and write r, c and the predicted c; the second kick reads c and f
    // and writes c.
    scene.measure(9.0, quick)
}

fn fene_shear(particles: f64, quick: bool) -> Result<Column, Problem> {
    let (system, chains) = states::fene_shear(particles)?;
    let scene = Scene {
        name: "FENE chains in shear",
        system,
        cutoff: 1.0,
        weight: Quadratic,
        rest: Bonded::new(Fene::new(20.0, 2.0)?, chains.bonds()),
        stepper: GrootWarren::new(0.5)?,
        before: &[(100, 0.01), (200, 0.02)],
        skins: &[0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5],
    };
    scene.measure(8.0, quick)
}

fn fedosov(particles: f64, quick: bool) -> Result<Column, Problem> {
    let (system, chains) = states::fedosov(particles)?;
    let springs = Bonded::new(Fene::new(50.0, 1.0)?, chains.bonds());
    let scene = Scene {
        name: "Fedosov's melt",
        system,
        cutoff: 2.0,
        weight: SquareRoot,
        rest: (springs, ReversePoiseuille::new(0.25, 0, 1)?),
        stepper: GrootWarren::new(0.5)?,
        before: &[(100, 0.002), (100, 0.005)],
        skins: &[0.1, 0.15, 0.2, 0.25, 0.3, 0.4],
    };
    scene.measure(8.0, quick)
}

/// A fluid with a = 25 and gamma = 4.5, and whatever else acts in it.
struct Scene<B, W, R> {
    name: &'static str,
    system: System<B>,
    cutoff: f64,
    weight: W,
    rest: R,
    stepper: GrootWarren,
    /// Steps before anything is timed, so many of one length.
    before: &'static [(u32, f64)],
    skins: &'static [f64],
}

/// What was measured of a scene, in nanoseconds for a particle and a step.
struct Column {
    name: String,
    skin: f64,
    life: f64,
    /// For a particle.
    candidates: f64,
    pairs: f64,
    parts: [f64; PARTS.len()],
    step: f64,
    law_at_best: f64,
    integration_at_best: f64,
}

const PARTS: [&str; 10] = [
    "list: following the particles",
    "list: making it, over its life",
    "joining blocks, order of the frame",
    "candidates: distances, packing",
    "adding forces",
    "velocities of pairs",
    "pair law without noise",
    "noise",
    "bonds, body forces",
    "integration",
];

impl<B: Periodic, W: Weight + Copy, R: ForceField<B> + Clone> Scene<B, W, R> {
    /// `vectors` are the fewest that a step without forces can read and write for a particle.
    fn measure(mut self, vectors: f64, quick: bool) -> Result<Column, Problem> {
        let law = self.law()?;
        let skin = self.settle()?;
        let mut field = (
            Pairwise::new(law, VerletList::new(skin)?),
            self.rest.clone(),
        );
        let film = Film::shoot(&mut self.system, &mut field, &mut self.stepper, quick)?;

        let cutoff = self.cutoff;
        let list = || VerletList::new(skin);
        let (mut once, mut twice) = (list()?, list()?);
        let mut hollow = Pairwise::new(ZERO, Seen::<false>(list()?, cutoff));
        let mut blind = Pairwise::new(ZERO, Seen::<true>(list()?, cutoff));
        let mut zero = Pairwise::new(Constant::<false> { cutoff, ..ZERO }, list()?);
        let zero_of_velocity = Constant::<true> { cutoff, f: 0.0 };
        let mut zero_of_velocity = Pairwise::new(zero_of_velocity, list()?);
        let quiet = Quiet(law.with_distribution(Silent));
        let mut quiet = Pairwise::new(quiet, list()?);
        let mut whole = Pairwise::new(law, list()?);
        let mut rest = self.rest.clone();
        let mut still = Still::like(&field);
        let mut stepper = self.stepper.clone();
        let mut together = (Pairwise::new(law, list()?), self.rest.clone());
        let times = medians([
            Box::new(|| film.list(&mut once, cutoff, 1)),
            Box::new(|| film.list(&mut twice, cutoff, 2)),
            Box::new(|| film.forces(&mut hollow, &mut ())),
            Box::new(|| film.forces(&mut blind, &mut ())),
            Box::new(|| film.forces(&mut zero, &mut ())),
            Box::new(|| film.forces(&mut zero_of_velocity, &mut ())),
            Box::new(|| film.forces(&mut quiet, &mut ())),
            Box::new(|| film.forces(&mut whole, &mut ())),
            Box::new(|| film.forces(&mut rest, &mut ())),
            Box::new(|| film.steps(&mut still, &mut stepper, &mut ())),
            Box::new(|| film.steps(&mut together, &mut self.stepper, &mut ())),
        ])?;
        let [once, twice, hollow, blind, zero, zero_of_velocity, ..] = times;
        let [.., quiet, whole, rest, integration, step] = times;
        let follow = twice - once;

        let mut pairs = Pairs(0);
        film.forces(&mut field.0, &mut pairs)?;
        let pairs = pairs.0 as f64 / film.heard() as f64;
        let particles = film.particles();
        let vectors = vectors * size_of::<DVec3>() as f64;
        Ok(Column {
            name: format!("{}, {particles}", self.name),
            skin,
            life: film.life,
            candidates: field.0.neighbours().candidates() as f64 / particles as f64,
            pairs,
            parts: [
                follow,
                once - follow,
                hollow - once,
                blind - hollow,
                zero - blind,
                zero_of_velocity - zero,
                quiet - zero_of_velocity,
                whole - quiet,
                rest,
                integration,
            ],
            step,
            law_at_best: pairs * limits::law(&law)?,
            integration_at_best: vectors * limits::byte(particles)?,
        })
    }

    fn law(&self) -> Result<Dpd<f64, W>, Problem> {
        let law = Dpd::new(25.0, 4.5)?;
        Ok(law.with_cutoff(self.cutoff)?.with_weight(self.weight))
    }

    /// Lets the run forget its start; answers the skin with which a step is cheapest.
    fn settle(&mut self) -> Result<f64, Problem> {
        let [first, ..] = self.skins else {
            return Err("no skins to try".into());
        };
        let mut best = (f64::INFINITY, *first);
        for &(steps, dt) in self.before {
            self.system.clock.set_dt(dt)?;
            self.run(*first, steps)?;
        }
        for &skin in self.skins {
            let time = self.run(skin, 60)?;
            if time < best.0 {
                best = (time, skin);
            }
        }
        Ok(best.1)
    }

    /// Takes steps with a list of this skin.
    fn run(&mut self, skin: f64, steps: u32) -> Result<f64, Problem> {
        let list = VerletList::new(skin)?;
        let mut field = (Pairwise::new(self.law()?, list), self.rest.clone());
        seconds(|| {
            for _ in 0..steps {
                self.stepper.step(&mut self.system, &mut field, &mut ())?;
            }
            Ok(())
        })
    }
}

/// A law of constant zero, which reads velocities or not.
#[derive(Clone, Copy)]
struct Constant<const VELOCITY: bool> {
    cutoff: f64,
    f: f64,
}

/// Constant zero between nobody.
const ZERO: Constant<false> = Constant {
    cutoff: 1e-9,
    f: 0.0,
};

impl<const VELOCITY: bool> PairForce for Constant<VELOCITY> {
    const READS: Reads = Reads {
        velocity: VELOCITY,
        ..Reads::NOTHING
    };

    #[inline(always)]
    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    #[inline(always)]
    fn force(&self, _: &Pair, _: &Now) -> Central {
        Central::conservative(self.f)
    }
}

/// A distribution that answers zero.
#[derive(Clone, Copy)]
struct Silent;

impl Distribution for Silent {
    #[inline(always)]
    fn draw(&self, _: Site) -> f64 {
        0.0
    }
}

/// DPD that reads no noise.
struct Quiet<W>(Dpd<f64, W, Silent>);

impl<W: Weight> PairForce for Quiet<W> {
    const READS: Reads = Reads {
        noise: false,
        ..Dpd::<f64, W, Silent>::READS
    };

    #[inline(always)]
    fn cutoff(&self) -> f64 {
        self.0.cutoff()
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, now: &Now) -> Central {
        self.0.force(pair, now)
    }
}

/// A list for a cutoff of its own, not the law's; with the candidates in its rows or without.
struct Seen<const CANDIDATES: bool>(VerletList, f64);

impl<B: Periodic, const CANDIDATES: bool> Neighbours<B> for Seen<CANDIDATES> {
    fn refresh(&mut self, frame: &Frame<'_, B>, _: f64) -> Result<bool, ListError> {
        self.0.refresh(frame, self.1)
    }

    fn order(&self) -> &[u32] {
        Neighbours::<B>::order(&self.0)
    }

    fn positions(&self) -> &[DVec3] {
        Neighbours::<B>::positions(&self.0)
    }

    fn blocks(&self) -> usize {
        Neighbours::<B>::blocks(&self.0)
    }

    #[inline(always)]
    fn visit(&self, block: usize, mut each: impl FnMut(Row<'_>)) {
        Neighbours::<B>::visit(
            &self.0,
            block,
            #[inline(always)]
            |row| {
                let js = if CANDIDATES { row.js } else { &[] };
                each(Row { js, ..row });
            },
        );
    }
}

/// A field that asks a stepper for all that another does, and does nothing.
struct Still<F>(PhantomData<F>);

impl<F> Still<F> {
    fn like(_: &F) -> Self {
        Self(PhantomData)
    }
}

impl<B: Boundary, F: ForceField<B>> ForceField<B> for Still<F> {
    const ACTS: bool = F::ACTS;
    const READS: Reads = F::READS;
    const CONSERVES_MOMENTUM: bool = F::CONSERVES_MOMENTUM;

    fn accumulate<T: Tally>(
        &mut self,
        _: &Frame<'_, B>,
        _: &mut [DVec3],
        _: &mut T,
    ) -> Result<(), ForceError> {
        Ok(())
    }
}

/// Counts pairs within the cutoff.
struct Pairs(u64);

impl Tally for Pairs {
    fn fresh(&self) -> Self {
        Self(0)
    }

    #[inline(always)]
    fn hear(&mut self, item: Item, _: DVec3, _: DVec3, _: DVec3, _: &impl Fn() -> f64) {
        self.0 += u64::from(item == Item::Conservative);
    }

    fn absorb(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl Column {
    fn sum(&self) -> f64 {
        self.parts.iter().sum()
    }

    fn list(&self) -> f64 {
        self.parts[0] + self.parts[1]
    }

    /// The pair loop without the list.
    fn forces(&self) -> f64 {
        self.parts[2..8].iter().sum()
    }

    fn law(&self) -> f64 {
        self.parts[6] + self.parts[7]
    }

    fn integration(&self) -> f64 {
        self.parts[9]
    }
}

fn print(columns: &[Column]) {
    let line = |name: &str, cell: &dyn Fn(&Column) -> String| {
        let cells: Vec<String> = columns.iter().map(cell).collect();
        println!("| {name} | {} |", cells.join(" | "));
    };
    line("ns for a particle and a step", &|c| c.name.clone());
    line("---", &|_| "---".into());
    for (k, name) in PARTS.iter().enumerate() {
        line(name, &|c| {
            let share = 100.0 * c.parts[k] / c.sum();
            format!("{:.1} ({share:.0} %)", c.parts[k])
        });
    }
    line("sum", &|c| format!("{:.1}", c.sum()));
    line("whole step", &|c| format!("{:.1}", c.step));
    line("sum / whole step", &|c| format!("{:.2}", c.sum() / c.step));
    line("share of the list", &|c| {
        format!("{:.0} %", 100.0 * c.list() / c.sum())
    });
    line("best skin; steps a list lives", &|c| {
        format!("{}; {:.1}", c.skin, c.life)
    });
    line("candidates; pairs within the cutoff", &|c| {
        format!("{:.1}; {:.2}", c.candidates, c.pairs)
    });
    line("forces / a bare force loop", &|c| {
        let best = c.pairs * BARE_LOOP;
        format!("{:.1} / {best:.0} = {:.2}", c.forces(), c.forces() / best)
    });
    line("law and noise / side by side in lanes", &|c| {
        let best = c.law_at_best;
        format!("{:.1} / {best:.1} = {:.1}", c.law(), c.law() / best)
    });
    line("integration / its columns copied", &|c| {
        let best = c.integration_at_best;
        let all = c.integration();
        format!("{all:.1} / {best:.1} = {:.1}", all / best)
    });
}

/// What the table is there to show, in numbers.
fn check(columns: &[Column]) -> Result<(), Problem> {
    for column in columns {
        let ratio = column.sum() / column.step;
        if !(0.75..1.25).contains(&ratio) {
            let name = &column.name;
            return Err(format!("{name}: the parts sum to {ratio:.2} of a step").into());
        }
    }
    Ok(())
}
