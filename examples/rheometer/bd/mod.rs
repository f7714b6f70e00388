//! Isolated bead-spring chains in Brownian dynamics.
//!
//! # What is simulated
//! Thousands of chains in open space that do not know of each other, in units of kT, l_H = sqrt(kT / H) and
//! lambda_H = zeta / 4H. Chains come in groups with noise of their own, so that the scatter of the groups' means is the
//! error. Springs are implicit: no step overstretches them, whatever the rate.
//!
//! # What the columns mean
//! * `rate`: as in dissipative particle dynamics, here in 1 / lambda_H.
//! * `eta`: polymer viscosity over n kT lambda_H: sigma_xy / rate in shear, eta_1 = (sigma_xx - sigma_yy) / rate in
//!   planar extension, Trouton's (sigma_xx - (sigma_yy + sigma_zz) / 2) / rate in uniaxial extension, Hounkonnou's in
//!   mixed flow.
//! * `N_1`: (sigma_xx - sigma_yy) over n kT.
//! * `<R_e^2>`: mean square distance of the ends over l_H^2.
//! * `theory`: exact, for Rouse chains in any flow and dumbbells in extension; blank elsewhere.
//!
//! The stress is Giesekus', from the positions of the beads: its noise falls with the rate as the stress does. With
//! hydrodynamic interactions it is Kramers', from the forces.
//!
//! With `--hi rpy` the beads of a chain move each other through the solvent. With `--hi ewald` or `mesh` chains are in a
//! periodic cell of the flow, at `--concentration` c/c*, and all beads move all others.

mod model;
mod protocol;
mod scene;
mod steady;
mod theory;

use crate::Problem;
use crate::flow::Flow;
use crate::options::{Hydrodynamics, Options, Protocol};
use indicatif::{ProgressBar, ProgressStyle};
use model::Model;
use zimm::prelude::*;

const KT: f64 = 1.0;
const FRICTION: f64 = 4.0;
/// Groups of chains with noise of their own.
const GROUPS: u64 = 64;
const GROUPS_IN_CELLS: u64 = 16;
/// Beads of a group, as near as whole chains come.
const BEADS: u32 = 512;
const QUICK_BEADS: u32 = 128;
/// Time that passes before anything counts, in longest relaxation times.
const TRANSIENT: f64 = 8.0;

/// Rates that show something.
pub(crate) fn default_rates(flow: Flow) -> Vec<f64> {
    match flow {
        Flow::Shear | Flow::Rpf | Flow::Mixed => vec![0.1, 0.3, 1.0, 3.0, 10.0],
        Flow::Extension | Flow::Uniaxial => vec![0.1, 0.3, 0.5, 0.7, 1.0, 2.0, 5.0],
    }
}

/// The measurements that the options ask for.
pub(crate) fn rheogram(options: &Options) -> Result<(), Problem> {
    let model = Model::new(&options.molecules)?;
    let bar = progress_bar(options);
    match options.molecules.protocol {
        Protocol::Steady => steady::rheogram(options, &model, &bar),
        changing => protocol::rheogram(options, &model, changing, &bar),
    }
}

fn progress_bar(options: &Options) -> ProgressBar {
    let style = ProgressStyle::with_template("flowing [{bar:40}] {percent:>3} %, {eta} left");
    let groups = if options.molecules.hi == Hydrodynamics::Ewald
        || options.molecules.hi == Hydrodynamics::Mesh
    {
        GROUPS_IN_CELLS
    } else {
        GROUPS
    };
    ProgressBar::new(groups * options.rates.len() as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Chains of a group.
fn chains(options: &Options, model: &Model) -> u32 {
    let beads = if options.quick { QUICK_BEADS } else { BEADS };
    (beads / model.beads).max(1)
}

/// The seed of a group.
fn seed(options: &Options, rate: f64, group: u64) -> u64 {
    options.seed ^ rate.to_bits().rotate_left(17) ^ group.rotate_left(40)
}

/// A time step that resolves the flow, a relaxation time and, as it is explicit, the excluded volume.
fn step_size(model: &Model, rate: f64) -> f64 {
    let resolved = if model.excluded_volume().is_some() {
        0.02
    } else {
        0.1
    };
    resolved / rate.max(1.0)
}

fn first_difference(stress: DMat3) -> f64 {
    stress.x_axis.x - stress.y_axis.y
}

/// The customary viscosity of a flow, from the stress; of a strain in place of the gradient, the modulus.
fn viscosity(flow: Flow, gradient: DMat3, stress: DMat3) -> f64 {
    let rate = gradient + gradient.transpose();
    let contract = |a: DMat3| {
        let [x, y, z] = [0, 1, 2].map(|k| a.col(k).dot(rate.col(k)));
        x + y + z
    };
    flow.customary() * contract(stress) / contract(rate)
}
