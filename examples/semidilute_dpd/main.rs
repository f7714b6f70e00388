//! A semidilute polymer solution in dissipative particle dynamics: chains of 20 beads that cannot pass through each
//! other, at rest, in shear or in extension. After Clarke (PhD thesis, MIT 2008, chapter 5).
//!
//! ```text
//! cargo run --release --example semidilute_dpd                             c/c* = 1, extension at De = 1, minutes
//! cargo run --release --example semidilute_dpd -- --quick                  less than a minute
//! cargo run --release --example semidilute_dpd -- --flow shear --de 10 --solvent good
//! cargo run --release --example semidilute_dpd -- --concentration 0.5,2 --de 0.2,0.3,0.4,0.5,0.6,0.8,1.2,2
//!                                                                          a sweep, 40 minutes of one core
//! cargo run --release --example semidilute_dpd -- --help                   all options
//! ```
//!
//! The fluid has four beads per volume, a = 18.75 and Lowe-Andersen dynamics at the rate Gamma = 5. In a theta solvent
//! all beads are alike, in a good one those of chains and solvent repel each other less, a = 13.125. Units are those of
//! DPD: r_c, kT, and tau = r_c (m / kT)^(1/2).
//!
//! Chains are held by FENE springs of limit 5 and extensibility 50, which repel each other by the exponential law with
//! alpha = 10 and a force of 1000 at contact, A = 100 as it is printed. `--contact-force 100` fits what the thesis shows
//! of it better, distances between springs and relaxation times that grow: at rest the stress of the longest mode then
//! takes 112(6), 144(7) and 180(10) tau to decay at c/c* = 0.5, 2 and 5, where with the printed law it takes 142(4),
//! 143(7) and 150(7). Both keep chains apart.
//!
//! The Deborah number De is the rate times 90 tau, the time in which stretched chains come back at c/c* = 0.5. (Rouse's
//! theory has zeta / (8 H sin^2(pi / 2N)) = 110 for the friction of a bead among its like.) Coils unravel in an extension
//! of De = 1/2 or more.
//!
//! An interrupted run goes on with `--resume`, to the same bits. The picture shows the extension of the chains, their size
//! and the stress of the springs against time, and how far springs are from each other.
//!
//! # Sweeps
//! More than one concentration, Deborah number or run makes a sweep: each combination is a run of its own, side by side
//! with others on as many threads as there are. Of each the second half counts. The picture, which for the sweep above is
//! `examples/semidilute_dpd.svg`, shows against De
//! * the extension of chains over their contour, with a mark at De = 1/2, or in shear Psi_1 = (sigma_xx - sigma_yy) /
//!   rate^2 over n kT lambda^2, with lambda = 90 tau and n chains per volume,
//! * the viscosity of the springs over n kT lambda, (sigma_xx - sigma_yy) / rate in extension, sigma_xy / rate in shear,
//! * the size of chains. Dashed is what ideal chains have at rest.
//!
//! Error bars are one standard error from the means of chains. The stress of a chain is that of its springs by Kramers'
//! expression, and its share of what their repulsion makes, which all chains have alike.
//!
//! In a sweep of extension chains begin stretched to half of their contour, in shear, which turns chains over again and
//! again, as coils; `--start` has it the other way. In fast extension the start does not matter: at De = 1.2 and c/c* = 0.5 either
//! are at 0.750(3) of their contour, coils after six relaxation times, stretched chains after two. Near the transition
//! neither way is short. At De = 0.8 chains that began stretched are at 0.61 after four relaxation times, coils at 0.50
//! after fourteen and still opening; at De = 0.5 the ones are at 0.32 after eight, the others at 0.08. What a sweep shows
//! there is how far stretched chains fall back in the time that they are given. Half of the way from coil to contour the
//! sweep above passes at De = 0.692(8) for c/c* = 0.5 and at 0.664(6) for 2. In shear chains thin from De = 1 or less on:
//! `--flow shear --concentration 2 --de 0.3,1,3,10,30` has viscosities of 3.2(5), 2.0(2), 1.65(13), 1.07(7) and 0.76(4).
//!
//! In fast shear chains are longer than the cell, wind around it and meet their own images. At c/c* = 0.5 and De = 30 that is
//! most of what they meet: in this cell their viscosity is 1.85(20), in one twice as wide (`--images 20`, eight times the
//! work) 1.22(8), as for chains that pass through each other, 1.19(12).

mod figure;
mod options;
mod series;
mod solution;
mod sweep;

use options::{Flow, Options};
use std::error::Error;
use std::fs;
use std::process::ExitCode;
use zimm::prelude::*;

/// What went wrong, in one sentence.
type Problem = Box<dyn Error + Send + Sync>;

fn main() -> ExitCode {
    let options = match Options::parse_command_line() {
        Ok(options) => options,
        Err(sentence) => return fail(2, &sentence),
    };
    // Inside a pool: from outside, every part of a step would be handed over to it anew.
    let pool = rayon::ThreadPoolBuilder::new().build();
    match pool
        .map_err(Problem::from)
        .and_then(|pool| pool.install(|| flow(&options)))
    {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(1, &error.to_string()),
    }
}

fn fail(code: u8, sentence: &str) -> ExitCode {
    eprintln!("semidilute_dpd: {sentence}");
    ExitCode::from(code)
}

/// Chooses the cell of a rate.
fn flow(options: &Options) -> Result<(), Problem> {
    fs::create_dir_all(&options.out)?;
    match options.flow {
        Flow::Rest | Flow::Shear => study(options, |rate| {
            let edges = DVec3::splat(options.images);
            Ok(LeesEdwards::new(edges, Steady::new(rate)?)?)
        }),
        Flow::Extension => study(options, |rate| {
            let history = Steady::new(rate)?;
            Ok(KraynikReinelt::box_for_cutoff(
                0.5 * options.images,
                history,
            )?)
        }),
    }
}

fn study<B: Periodic>(
    options: &Options,
    space: impl Fn(f64) -> Result<B, Problem> + Sync,
) -> Result<(), Problem> {
    match options.solutions().as_slice() {
        [alone] => series::run(options, alone, space),
        several => sweep::run(options, several, space),
    }
}
