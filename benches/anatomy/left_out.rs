//! Steps of the fluid of Groot and Warren with and without what a scene may leave out, each from the same states.
//!
//! What is left out is an empty column, a constant that is false or a type of no size. A step without it is faster by what
//! it would take, and a step whose types or columns have room for it, but which nobody reads, is as fast as one without.

use crate::film::{self, Film};
use crate::timing::{Run, medians};
use crate::{Problem, limits, scene};
use zimm::prelude::*;

/// What is left out.
struct Row {
    what: &'static str,
    /// Nanoseconds for a particle and a step without it and with it.
    times: [f64; 2],
    /// What it takes.
    takes: Work,
    /// What there is of it in types and columns.
    without_with: String,
}

/// What something takes in a step.
enum Work {
    Nothing,
    /// Operations that do not come down to memory.
    Operations(&'static str),
    /// Bytes read and written for a particle.
    Bytes(f64, &'static str),
}

pub(crate) fn table(quick: bool) -> Result<(), Problem> {
    let edge = if quick { 10.0 } else { 20.0 };
    let film = film::fluid(scene::cube(edge), quick)?;
    let sheared = film::fluid(
        LeesEdwards::new(DVec3::splat(edge), Steady::new(0.1)?)?,
        quick,
    )?;
    let species = film.with(|p| {
        let two = (0..p.len()).map(|k| (k % 2) as u8).collect();
        p.with_species(two)
    })?;
    let images = film.with(|p| Ok(p.counting_images()))?;
    let masses = film.with(|p| {
        let ones = vec![1.0; p.len()];
        p.with_masses(ones)
    })?;
    let ids = film.with(|p| {
        let places = (0..p.len() as u32).collect();
        p.with_ids(places)
    })?;

    let dpd = Dpd::new(25.0, 4.5)?;
    let by_species = Dpd::new(SpeciesMatrix::new([[25.0; 2]; 2])?, 4.5)?;
    let soft = DpdConservative::new(25.0, 1.0)?;
    let quiet = (soft, DpdDissipative::new(4.5, Quadratic, 1.0)?);
    let [
        bare,
        stress,
        tabled,
        unread,
        frictionless,
        noiseless,
        flow,
        counted,
        weighed,
        named,
        null_law,
        null_field,
    ] = medians([
        steps(&film, pairs(dpd)?, ())?,
        steps(&film, pairs(dpd)?, Virial::default())?,
        steps(&species, pairs(by_species)?, ())?,
        steps(&species, pairs(dpd)?, ())?,
        steps(&film, pairs(soft)?, ())?,
        steps(&film, pairs(quiet)?, ())?,
        steps(&sheared, pairs(dpd)?, ())?,
        steps(&images, pairs(dpd)?, ())?,
        steps(&masses, pairs(dpd)?, ())?,
        steps(&ids, pairs(dpd)?, ())?,
        steps(&film, pairs((dpd, ()))?, ())?,
        steps(&film, (pairs(dpd)?, ()), ())?,
    ])?;

    let column = |with: &Film<PeriodicBox>, bytes: fn(&Particles) -> usize| {
        let [without, with] = [&film, with].map(|film| bytes(film.first()) / film.particles());
        format!("{without} B, {with} B a particle")
    };
    let types = |without: usize, with: usize| format!("{without} B, {with} B");
    let reads = |what, [without, with]: [bool; 2]| format!("`READS.{what}`: {without}, {with}");
    let (soft_reads, quiet_reads, dpd_reads) = (read_by(&soft), read_by(&quiet), read_by(&dpd));
    let rows = [
        Row {
            what: "stress",
            times: [bare, stress],
            takes: Work::Operations("9 products and sums for each of 3 items of a pair"),
            without_with: types(size_of::<()>(), size_of::<Virial>()),
        },
        Row {
            what: "species, a table of 2 x 2",
            times: [bare, tabled],
            takes: Work::Operations("2 bytes fetched, 3 comparisons for a pair"),
            without_with: column(&species, |p| size_of_val(p.species())),
        },
        Row {
            what: "friction",
            times: [frictionless, noiseless],
            takes: Work::Operations(
                "24 bytes fetched and about 15 operations for a pair, predicted velocities",
            ),
            without_with: reads("velocity", [soft_reads.velocity, quiet_reads.velocity]),
        },
        Row {
            what: "noise",
            times: [noiseless, bare],
            takes: Work::Operations("8 bytes fetched and a mix of 64 bits for a pair"),
            without_with: reads("noise", [quiet_reads.noise, dpd_reads.noise]),
        },
        Row {
            what: "shear, Lees-Edwards",
            times: [bare, flow],
            takes: Work::Operations("6 products of a matrix and a vector for a particle"),
            without_with: types(size_of::<PeriodicBox>(), size_of::<LeesEdwards<Steady>>()),
        },
        Row {
            what: "counting images",
            times: [bare, counted],
            takes: Work::Bytes(4.0 * 12.0, "and a wrap of each"),
            without_with: column(&images, |p| size_of_val(p.images())),
        },
        Row {
            what: "masses",
            times: [bare, weighed],
            takes: Work::Bytes(3.0 * 8.0, "and 3 divisions"),
            without_with: column(&masses, |p| size_of_val(p.masses())),
        },
        Row {
            what: "identities",
            times: [bare, named],
            takes: Work::Bytes(4.0, ""),
            without_with: column(&ids, |p| size_of_val(p.ids())),
        },
        Row {
            what: "species that no law reads",
            times: [bare, unread],
            takes: Work::Nothing,
            without_with: column(&species, |p| size_of_val(p.species())),
        },
        Row {
            what: "a law `()` in a sum",
            times: [bare, null_law],
            takes: Work::Nothing,
            without_with: types(size_of_val(&dpd), size_of_val(&(dpd, ()))),
        },
        Row {
            what: "a field `()` in a sum",
            times: [bare, null_field],
            takes: Work::Nothing,
            without_with: types(size_of_val(&pairs(dpd)?), size_of_val(&(pairs(dpd)?, ()))),
        },
    ];
    print(&film, &rows)?;
    check(&rows)
}

fn read_by<L: PairForce>(_: &L) -> Reads {
    L::READS
}

fn pairs<L: PairForce>(law: L) -> Result<Pairwise<L, VerletList>, Problem> {
    Ok(Pairwise::new(law, VerletList::new(scene::SKIN)?))
}

/// Steps of the film, to be timed.
fn steps<'a, B: Periodic, F: ForceField<B> + 'a, T: Tally + 'a>(
    film: &'a Film<B>,
    mut field: F,
    mut tally: T,
) -> Result<Run<'a>, Problem> {
    let mut stepper = GrootWarren::new(0.65)?;
    Ok(Box::new(move || {
        film.steps(&mut field, &mut stepper, &mut tally)
    }))
}

fn print(film: &Film<PeriodicBox>, rows: &[Row]) -> Result<(), Problem> {
    let particles = film.particles();
    let byte = limits::byte(particles)?;
    println!(
        "| left out, {particles} particles | without, with: ns | with / without | what it takes | type or column without, with |"
    );
    println!("| --- | --- | --- | --- | --- |");
    for row in rows {
        let [without, with] = row.times;
        let takes = match row.takes {
            Work::Nothing => "nothing".into(),
            Work::Operations(text) => text.into(),
            Work::Bytes(bytes, text) => {
                let time = bytes * byte;
                format!("{bytes} bytes for a particle ({time:.1} ns) {text}")
            }
        };
        println!(
            "| {} | {without:.1}, {with:.1} | {:.2} | {} | {} |",
            row.what,
            with / without,
            takes.trim_end(),
            row.without_with
        );
    }
    Ok(())
}

/// What the table is there to show, in numbers.
fn check(rows: &[Row]) -> Result<(), Problem> {
    for row in rows {
        let ratio = row.times[1] / row.times[0];
        let is_free = matches!(row.takes, Work::Nothing);
        if ratio < 0.85 || (is_free && ratio > 1.15) {
            let what = row.what;
            return Err(format!("{what}: a step with it takes {ratio:.2} of one without").into());
        }
    }
    Ok(())
}
