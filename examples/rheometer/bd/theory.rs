//! What theory says of isolated chains without hydrodynamic interaction, in units of kT, l_H and lambda_H.
//!
//! Rouse chains (Hookean springs, no excluded volume) are known in every homogeneous flow: each normal mode j has the
//! relaxation time t_j = 2 / a_j, a_j = 4 sin^2(j pi / 2N), and its covariance, over that at rest, solves
//! C = 1 + t_j (kappa C + C kappa^T). Dumbbells of any spring and any excluded volume are known in potential flows:
//! psi ~ exp(-U(Q) + Q . kappa Q), integrated here.

use super::model::Model;
use std::f64::consts::{FRAC_PI_2, PI};
use zimm::prelude::*;

/// Steady averages of one molecule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Averages {
    /// Stress over n kT, tension positive, up to a multiple of the identity.
    pub(crate) stress: DMat3,
    /// Mean square distance of the ends.
    pub(crate) end_to_end: f64,
}

/// The exact averages in a steady flow, if they are known and exist.
pub(crate) fn steady(model: &Model, gradient: DMat3) -> Option<Averages> {
    if model.is_rouse() {
        return rouse(model.beads, gradient);
    }
    let is_diagonal = gradient.y_axis.x == 0.0;
    (model.beads == 2 && is_diagonal && model.is_free_draining())
        .then(|| dumbbell(model, gradient))
        .flatten()
}

/// Relaxation times of the stress of a Rouse chain, longest first.
pub(crate) fn rouse_times(beads: u32) -> impl Iterator<Item = f64> {
    (1..beads).map(move |mode| {
        let sine = (f64::from(mode) * PI / (2.0 * f64::from(beads))).sin();
        0.5 / (sine * sine)
    })
}

fn rouse(beads: u32, gradient: DMat3) -> Option<Averages> {
    let mut sum = Averages {
        stress: DMat3::ZERO,
        end_to_end: 0.0,
    };
    for (mode, time) in (1..beads).zip(rouse_times(beads)) {
        let c = covariance(gradient * time)?;
        sum.stress += c;
        if mode % 2 == 1 {
            let angle = f64::from(mode) * PI / (2.0 * f64::from(beads));
            let ends = 8.0 / f64::from(beads) * angle.cos().powi(2);
            sum.end_to_end += 0.5 * time * ends * (c.x_axis.x + c.y_axis.y + c.z_axis.z);
        }
    }
    Some(sum)
}

/// The stress over n kT of Rouse chains that were at rest at time zero, after these numbers of time steps: each mode is
/// carried by the flow and relaxes, half a step before and half a step after, with an error of second order in `dt`.
pub(crate) fn rouse_transient(
    beads: u32,
    carry: &dyn Fn(f64, f64) -> DMat3,
    dt: f64,
    steps: &[u64],
) -> Vec<DMat3> {
    let mut modes = vec![DMat3::IDENTITY; beads as usize - 1];
    let memories: Vec<f64> = rouse_times(beads)
        .map(|time| (-0.5 * dt / time).exp())
        .collect();
    let last = steps.last().copied().unwrap_or(0);
    let mut stresses = Vec::new();
    for step in 1..=last {
        let (from, to) = ((step - 1) as f64 * dt, step as f64 * dt);
        let e = carry(from, to);
        for (c, memory) in modes.iter_mut().zip(&memories) {
            let relax = |c: DMat3| DMat3::IDENTITY + (c - DMat3::IDENTITY) * *memory;
            *c = relax(e * relax(*c) * e.transpose());
        }
        if steps.contains(&step) {
            stresses.push(modes.iter().fold(DMat3::ZERO, |sum, c| sum + *c));
        }
    }
    stresses
}

/// The solution of C = 1 + k C + C k^T for the flows of the rheometer, in which k is upper triangular and z apart from
/// x and y; nothing if there is no steady state.
fn covariance(k: DMat3) -> Option<DMat3> {
    let [kx, ky, kz] = [k.x_axis.x, k.y_axis.y, k.z_axis.z];
    if [kx, ky, kz].iter().any(|rate| 2.0 * rate >= 1.0) {
        return None;
    }
    let shear = k.y_axis.x;
    let yy = 1.0 / (1.0 - 2.0 * ky);
    let xy = shear * yy / (1.0 - kx - ky);
    let xx = (1.0 + 2.0 * shear * xy) / (1.0 - 2.0 * kx);
    let zz = 1.0 / (1.0 - 2.0 * kz);
    let (x, y) = (DVec3::new(xx, xy, 0.0), DVec3::new(xy, yy, 0.0));
    Some(DMat3::from_cols(x, y, zz * DVec3::Z))
}

/// Averages over the distribution of a dumbbell, with x the axis of the greatest rate: Simpson's rule along Q and along
/// its direction's z, the midpoint rule around z. Panels follow the width of the distribution at each length.
fn dumbbell(model: &Model, gradient: DMat3) -> Option<Averages> {
    const LENGTHS: u32 = 4000;
    const HEIGHTS: u32 = 48;
    let rates = DVec3::new(gradient.x_axis.x, gradient.y_axis.y, gradient.z_axis.z);
    let longest = model.longest(rates.x)?;
    let length = |k: u32| longest * f64::from(k) / f64::from(LENGTHS);
    let exponent = |r2: f64| rates.x * r2 - model.energy(r2);
    // Exponents are taken relative to the largest of all, so that nothing overflows.
    let highest = (1..LENGTHS)
        .map(|k| exponent(length(k).powi(2)))
        .fold(f64::MIN, f64::max);
    let simpson = |k: u32, n: u32| match k {
        0 => 1.0,
        k if k == n => 1.0,
        k => f64::from(2 + 2 * (k % 2)),
    };
    let (mut norm, mut square, mut stress) = (0.0, 0.0, DVec3::ZERO);
    for k in 1..LENGTHS {
        let r2 = length(k).powi(2);
        let top = exponent(r2) - highest;
        if top < -60.0 {
            continue;
        }
        let [across, up] = [rates.x - rates.y, rates.x - rates.z].map(|rate| rate * r2);
        let height = (8.0 / (2.0 * up).sqrt()).min(1.0);
        let angles = 8 + (15.0 * across).sqrt() as u32;
        let (mut share, mut directions) = (0.0, DVec3::ZERO);
        for m in 0..=HEIGHTS {
            let z2 = (height * f64::from(m) / f64::from(HEIGHTS)).powi(2);
            let mut ring = (0.0, 0.0);
            for n in 0..angles {
                let sine = (FRAC_PI_2 * (f64::from(n) + 0.5) / f64::from(angles)).sin();
                let y2 = (1.0 - z2) * sine * sine;
                let probability = (-across * y2).exp();
                ring = (ring.0 + probability, ring.1 + probability * y2);
            }
            let weight = simpson(m, HEIGHTS) * (-up * z2).exp() * height / f64::from(angles);
            share += weight * ring.0;
            let (y2, z2) = (weight * ring.1, weight * ring.0 * z2);
            directions += DVec3::new(0.0, y2, z2);
        }
        directions.x = share - directions.y - directions.z;
        let probability = top.exp() * simpson(k, LENGTHS) * r2;
        norm += probability * share;
        square += probability * share * r2;
        stress -= probability * model.force(r2) * r2 * directions;
    }
    Some(Averages {
        stress: DMat3::from_diagonal(stress / norm),
        end_to_end: square / norm,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::{Molecule, Options, Spring};

    fn model(change: impl Fn(&mut Molecule)) -> Model {
        let mut molecule = Options::of_words("rheometer").molecules;
        change(&mut molecule);
        Model::new(&molecule).unwrap()
    }

    fn flow(x: f64, y: f64, shear: f64) -> DMat3 {
        let z = -x - y;
        DMat3::from_cols(x * DVec3::X, DVec3::new(shear, y, 0.0), z * DVec3::Z)
    }

    fn close(found: f64, exact: f64, tolerance: f64) {
        assert!(
            (found / exact - 1.0).abs() < tolerance,
            "{found} against {exact}"
        );
    }

    /// N = 10 in shear: R_e^2 = 3 (N - 1) (1 + N (N + 1) (N^2 + 1) rate^2 / 45), eta = (N^2 - 1) / 3, Psi_1 = 910.8.
    #[test]
    fn limit_rouse_chains_in_shear() {
        let chain = model(|molecule| {
            molecule.spring = Spring::Hooke;
            molecule.beads = 10;
        });
        for rate in [0.01, 0.1, 1.0] {
            let found = steady(&chain, flow(0.0, 0.0, rate)).unwrap();
            close(found.stress.y_axis.x / rate, 33.0, 1e-13);
            let difference = found.stress.x_axis.x - found.stress.y_axis.y;
            close(difference / (rate * rate), 910.8, 1e-11);
            close(
                found.end_to_end,
                27.0 * (1.0 + 11110.0 * rate * rate / 45.0),
                1e-13,
            );
        }
        assert_eq!(steady(&chain, flow(0.0245, -0.0245, 0.0)), None);
    }

    /// Hookean dumbbells in mixed flow: (e, g) = (0.3, 3) has R_e^2 = 32.25 and Hounkonnou's viscosity 1 / (1 - 4 e^2).
    #[test]
    fn limit_hookean_dumbbells_in_mixed_flow() {
        let found = steady(
            &model(|molecule| molecule.spring = Spring::Hooke),
            flow(0.3, -0.3, 3.0),
        )
        .unwrap();
        close(found.end_to_end, 32.25, 1e-13);
    }

    /// FENE dumbbells, b = 50, without and with excluded volume (z* = 10, d* = 1): R_e^2 and eta_1 in planar extension, to
    /// the digits of an independent quadrature; uniaxial extension at 0.3: 4.34883.
    #[test]
    fn reference_dumbbells_in_extension() {
        let bare = model(|_| ());
        let swollen = model(|molecule| molecule.excluded_volume = Some(10.0));
        for (rate, square, viscosity, square_10, viscosity_10) in [
            (0.1, 2.77959, 3.74301, 5.86595, 7.97094),
            (0.3, 3.30047, 4.80481, 6.74167, 10.32770),
            (0.7, 11.24303, 20.99540, 13.83325, 26.10692),
            (2.0, 36.90864, 73.31376, 36.90864, 73.31377),
            (10.0, 47.39724, 94.69438, 47.39724, 94.69438),
            (100.0, 49.73997, 99.46995, 49.73997, 99.46995),
        ] {
            for (model, square, viscosity) in [
                (bare, square, viscosity),
                (swollen, square_10, viscosity_10),
            ] {
                let found = steady(&model, flow(rate, -rate, 0.0)).unwrap();
                close(found.end_to_end, square, 1e-5);
                let difference = found.stress.x_axis.x - found.stress.y_axis.y;
                close(difference / rate, viscosity, 1e-5);
            }
        }
        let found = steady(&bare, flow(0.3, -0.15, 0.0)).unwrap();
        let difference = found.stress.x_axis.x - found.stress.y_axis.y;
        close(difference / 0.3, 4.34883, 2e-6);
    }
}
