//! A virtual rheometer: FENE dumbbells in a solvent of dissipative particles, in shear or another flow at several rates.
//!
//! ```text
//! cargo run --release --example rheometer                        shear, about 70 seconds on two cores
//! cargo run --release --example rheometer -- --flow extension    or mixed (with --mixedness), or uniaxial
//! cargo run --release --example rheometer -- --flow rpf          reverse Poiseuille flow, two minutes
//! cargo run --release --example rheometer -- --chain 20 --spring-repulsion exponential --gamma-la 5
//! cargo run --release --example rheometer -- --help              all options
//! ```
//!
//! # What is simulated
//! A cube of edge 12 with 5184 beads at density 3 is sheared by Lees-Edwards boundaries; extension and mixed flow take
//! the smallest cell in which images stay 12 apart (Kraynik-Reinelt and its kin). All beads are alike: DPD with
//! a = 25, gamma = 10 and the weight of Fan et al. (2006), w_D = (1 - r)^(1/2), whose friction is felt more than that of
//! Groot and Warren's (1 - r)^2. Every fourth bead belongs to a dumbbell, held by a FENE spring of extensibility
//! b = H Q_0^2 / kT = 50 and limit Q_0 = 6. After Clarke (PhD thesis, MIT 2008, chapter 4).
//!
//! With `--chain N` the same share of the beads belongs to chains of N beads. `--spring-repulsion` keeps their springs
//! from passing through each other, and `--gamma-la` takes Lowe-Andersen dynamics of that rate instead of friction and
//! noise: chains as in Clarke's chapter 5, of which the example `semidilute_dpd` is a closer study.
//! Default rates and times follow an estimate of the longest relaxation time: rates cover the Deborah numbers of the
//! dumbbells' default rates; slower molecules flow for eight relaxation times before anything counts and for 20 after,
//! with `--quick` for one and four. Chains of 20 take an hour or more of one core, with `--quick` some minutes.
//!
//! With `--flow rpf` the cell is 12 x 24 x 12 and holds two channels one above the other, driven to and fro by
//! `--forces` on every bead. The stress f n y at the distance y from a centre line is imposed, the rate is the slope of
//! the velocity: each force is a flow curve from zero to its largest rate, and all of them should be one.
//!
//! Units are those of DPD: length r_c, mass m of a bead, energy kT, hence time tau = r_c (m / kT)^(1/2).
//!
//! # What the columns mean
//! * `rate`: of shear, u_x = rate y; of planar extension, u = rate (x, -y, 0); of uniaxial extension,
//!   u = rate (x, -y/2, -z/2); of mixed flow the strain rate Gamma, u = rate (sqrt(chi) x + (1 - chi) y,
//!   -sqrt(chi) y, 0) with chi the mixedness.
//! * `De`: Deborah number, lambda_H rate with lambda_H = zeta / 4H. The friction zeta of a bead is not put in, it is
//!   found: Kramers' and Giesekus' expressions for the stress of dumbbells agree if, in shear, zeta = 4 <F_x Q_y> /
//!   (rate <Q_y^2>), with F the tension between the beads, spring less repulsion. All rates together give one zeta.
//!   For chains lambda_1 = zeta / (8 H sin^2(pi / 2N)) takes the place of lambda_H, and twice the sum of R R over beads,
//!   R from their centre, that of Q Q: the same for two beads.
//! * `eta`, `Psi_1`: viscosity and (sigma_xx - sigma_yy) / rate^2 of the whole solution, from the stress of all forces
//!   and of the beads' motion; tension is positive. The viscosity is sigma_xy / rate in shear, eta_1 =
//!   (sigma_xx - sigma_yy) / rate in planar extension, Trouton's (sigma_xx - (sigma_yy + sigma_zz) / 2) / rate in
//!   uniaxial extension and Hounkonnou's in mixed flow, sigma : A / (A : A) with A = kappa + kappa^T.
//! * `eta_p*`, `Psi_1p*`: the dumbbells' share by Kramers' expression, over n kT lambda_H and n kT lambda_H^2, with n
//!   their number density.
//! * `<Q^2>/Q_0^2`: mean square length of the dumbbells; of chains `<R_e^2>/L^2`, from end to end over the contour length.
//!   At rest <Q^2>/Q_0^2 is 3 / (b + 5) = 0.0545 for beads that do not repel each other, and 3 % more for these.
//! * `force`, `y`, `n_p / mean`, of reverse Poiseuille flow: the body force, the distance from the centre line, and the
//!   beads of molecules per volume there over their mean, for flow may move them across.
//! * `T`: kinetic temperature of the peculiar velocities, of 3N - 3 degrees of freedom. The time step makes it half a
//!   per cent low, and viscous heating raises it as the square of the rate.
//! * `theory`: dilute dumbbells of the same b at the same De, whose beads do not interact; in shear from the
//!   Fokker-Planck equation (De up to 10) and Brownian dynamics (above), in extension exact. Blank outside
//!   0.01 < De < 300 (3 in extension) and in mixed flow.
//!
//! Errors are one standard error, from block averages, in units of the last digits: 0.912(12) is 0.912 +- 0.012. Where
//! the block average has not levelled off, the error is a lower bound: 0.912(>12). The error of lambda_H, common to
//! all rates, is told below the table and is not part of the starred columns' errors.
//!
//! # How to read the comparison
//! zeta is chosen so that Giesekus' relation holds, hence in shear eta_p* is H <Q_y^2> / kT: that column compares the
//! dumbbells' width across the flow with theory. Psi_1p* and the extension depend on the choice through De alone. Agreement is
//! within ten per cent: real beads repel each other, and they stir a solvent that takes its time to follow, so that
//! the beads of a long dumbbell feel more friction than those of a short one.

mod bd;
mod dpd;
mod flow;
mod options;
mod panel;
mod text;

use options::{Method, Options};
use std::error::Error;
use std::fs::{self, OpenOptions};
use std::io;
use std::path::Path;
use std::process::ExitCode;

/// What went wrong, in one sentence.
type Problem = Box<dyn Error + Send + Sync>;

fn main() -> ExitCode {
    let options = match Options::parse_command_line() {
        Ok(options) => options,
        Err(sentence) => return fail(2, &sentence),
    };
    if let Err(error) = make_writable(&options.out) {
        let out = options.out.display();
        return fail(2, &format!("cannot write to {out}: {error}"));
    }
    let rheogram = || match options.method {
        Method::Dpd => dpd::rheogram(&options),
        Method::Bd => bd::rheogram(&options),
    };
    match on_threads(options.threads, rheogram) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(1, &error.to_string()),
    }
}

fn on_threads(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<(), Problem> + Send,
) -> Result<(), Problem> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0));
    pool.build()?.install(work)
}

fn fail(code: u8, sentence: &str) -> ExitCode {
    eprintln!("rheometer: {sentence}");
    ExitCode::from(code)
}

fn make_writable(out: &Path) -> io::Result<()> {
    fs::create_dir_all(out)?;
    OpenOptions::new()
        .append(true)
        .create(true)
        .open(out.join("rheometer.csv"))?;
    Ok(())
}
