//! The stress of free-draining chains, from where their beads are.

use crate::AnalysisError;
use crate::chain::map_chains;
use crate::tensor::outer;
use zimm_core::{Boundary, DMat3, DVec3, Frame, Molecules, Observable, ParameterError};

/// The polymer stress per chain in a steady homogeneous flow u = kappa r, by Giesekus' expression:
///
/// ```text
/// sigma_p / n = (1/2) (kappa S + S kappa^T),   S = sum_i zeta_i (r_i - c) (r_i - c)        tension positive
/// ```
///
/// for beads of friction zeta_i about their centre of friction c, averaged over the chains of a frame. With one
/// friction S is zeta N times the [`GyrationTensor`](crate::GyrationTensor); for dumbbells it is zeta QQ / 2, and
/// sigma_p the familiar (n zeta / 4) (kappa QQ + QQ kappa^T) (Giesekus 1962; Bird, Curtiss, Armstrong and Hassager 1987,
/// sec. 13.3).
///
/// It comes of dS/dt = kappa S + S kappa^T - 2 sigma_p / n on average, for chains that follow
/// dr_i = (kappa r_i + F_i / zeta_i) dt + noise. So its mean is that of [`ChainStress`](crate::ChainStress) for any
/// springs and any forces within a chain, if the beads do not interact hydrodynamically, forces between chains are
/// absent, and the flow is **steady**; in a transient it lacks -(1/2) dS/dt. It needs no forces, and its noise is
/// proportional to the rate: at low rates the viscosity is known from it with an error that does not grow, which
/// Kramers' expression cannot give. Where both hold, their agreement is a test of a time step. The flow is that of the
/// frame's boundary.
///
/// ```
/// use zimm_analysis::GiesekusStress;
/// use zimm_core::{Boundary, DMat3, DVec3, Frame, IVec3, Molecules, Observable};
///
/// // In units of l_H, lambda_H and kT every bead has the friction 4.
/// fn viscosity<B: Boundary>(frame: &Frame<'_, B>, chains: Molecules, rate: f64) -> Result<f64, zimm_analysis::AnalysisError> {
///     let mut stress = GiesekusStress { molecules: chains, friction: |_| 4.0 };
///     Ok(stress.measure(frame, &())?.y_axis.x / rate)
/// }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct GiesekusStress<Z> {
    /// The molecules.
    pub molecules: Molecules,
    /// The friction coefficient of a bead of each species.
    pub friction: Z,
}

impl<B: Boundary, T, Z: Fn(u8) -> f64> Observable<B, T> for GiesekusStress<Z> {
    type Output = Result<DMat3, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        let (mut sum, mut frictions) = (DMat3::ZERO, Vec::new());
        let chains = map_chains(frame, &self.molecules, |places, beads| {
            frictions.clear();
            for &place in places {
                let friction = (self.friction)(frame.species(place));
                frictions.push(ParameterError::positive("friction of a bead", friction)?);
            }
            let total: f64 = frictions.iter().sum();
            let weighted = |(&friction, &bead): (&f64, &DVec3)| friction / total * bead;
            let centre: DVec3 = frictions.iter().zip(beads).map(weighted).sum();
            for (&friction, &bead) in frictions.iter().zip(beads) {
                sum += outer(friction * (bead - centre), bead - centre);
            }
            Ok(())
        })?;
        chains.into_iter().collect::<Result<(), ParameterError>>()?;
        let count = f64::from(self.molecules.count());
        if count == 0.0 {
            return Err(AnalysisError::TooFew {
                what: "molecules",
                found: 0,
                needed: 1,
            });
        }
        let carried = frame.boundary.gradient() * sum;
        Ok((carried + carried.transpose()) * (0.5 / count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{
        Flow, Hooke, at, chains_of_moments, fene_in_planar_flow, planar, planar_mixed,
        rouse_moments, system,
    };
    use crate::{ChainStress, GyrationTensor};
    use approx::assert_relative_eq;
    use zimm_core::{Bonded, ForceField, Open, Particles, Virial};

    /// Rows of the reference table of Rouse chains: n, e, g, the four sums of `<QQ>`, R_e^2, R_g^2.
    fn table() -> impl Iterator<Item = (u32, Vec<f64>)> {
        include_str!("../tests/data/rouse_steady.csv")
            .lines()
            .skip(1)
            .map(|line| {
                let words: Vec<&str> = line.split(',').collect();
                let numbers = words[2..11].iter().map(|word| word.parse().unwrap());
                (words[1].parse().unwrap(), numbers.collect())
            })
    }

    // Hookean chains of 2 to 20 beads in shear, planar extension and mixed flow, at rates up to 50 relaxation times in
    // shear and to 98 % of the divergence in extension: moments in, stress out, without statistics. Kramers' sum over the
    // springs and Giesekus' over the beads both give the table's numbers; a lost bead, bond, factor or transposed
    // gradient shows in full.
    #[test]
    fn reference_rouse_chains_have_one_stress_by_kramers_and_by_giesekus() {
        let mut rows = 0;
        for (n, row) in table() {
            let [e, g, _, xx, xy, yy, zz, re2, rg2] = row.try_into().unwrap();
            let positions = chains_of_moments(&rouse_moments(n, e, g));
            let beads = positions.len();
            let system = at(Flow(planar_mixed(e, g)), positions);
            let molecules = Molecules::linear(0, 3 * (n - 1), n).unwrap();
            let mut virial = Virial::default();
            Bonded::new(Hooke(1.0), molecules.bonds())
                .accumulate(&system.frame(), &mut vec![DVec3::ZERO; beads], &mut virial)
                .unwrap();
            let internal = f64::from(n - 1);
            let exact = planar(xx, xy, yy, zz) - DMat3::IDENTITY * internal;
            let close = |found: DMat3| (found - exact).abs_diff_eq(DMat3::ZERO, 2e-11 * xx);
            let kramers = ChainStress { molecules }
                .measure(&system.frame(), &virial)
                .unwrap();
            assert!(close(kramers), "{kramers} for {exact}");
            let giesekus = GiesekusStress {
                molecules,
                friction: |_| 4.0,
            }
            .measure(&system.frame(), &())
            .unwrap();
            assert!(close(giesekus), "{giesekus} for {exact}");
            let (mut ends, mut squares) = (0.0, 0.0);
            for (chain, gyration) in system.particles.positions().chunks(n as usize).zip(
                GyrationTensor { molecules }
                    .measure(&system.frame(), &())
                    .unwrap(),
            ) {
                ends += (chain[chain.len() - 1] - chain[0]).length_squared();
                squares += crate::tensor::trace(&gyration);
            }
            let count = f64::from(3 * (n - 1));
            assert_relative_eq!(ends / count, re2, max_relative = 1e-10);
            assert_relative_eq!(squares / count, rg2, max_relative = 1e-10);
            rows += 1;
        }
        assert_eq!(rows, 130);
    }

    // FENE dumbbells, b = 50, in shear and mixed flow, in units of l_H, lambda_H and kT: rate e, rate g, <QQ> as xx, xy,
    // yy, zz, and <QF> as xx, xy, yy, from a spectral solution of the Fokker-Planck equation good to 1e-10.
    #[test]
    fn reference_fene_dumbbells_in_mixed_flow() {
        let mut rows = 0;
        for [b, e, g, xx, xy, yy, zz, _, _, fxx, fxy, fyy] in fene_in_planar_flow() {
            assert_eq!(b, 50.0);
            // The connector is sqrt(2) times the mode.
            let positions = chains_of_moments(&[planar(xx, xy, yy, zz) * 0.5]);
            let system = at(Flow(planar_mixed(e, g)), positions);
            let found = GiesekusStress {
                molecules: Molecules::linear(0, 3, 2).unwrap(),
                friction: |_| 4.0,
            }
            .measure(&system.frame(), &())
            .unwrap();
            let exact = planar(fxx - 1.0, fxy, fyy - 1.0, 0.0);
            assert!(
                (found - exact).abs_diff_eq(DMat3::ZERO, 1e-6 * fxx),
                "{found} for {exact}"
            );
            rows += 1;
        }
        assert_eq!(rows, 16);
    }

    // A Hookean dumbbell of two frictions moves as one of relative friction m = z1 z2 / (z1 + z2): its moments in shear
    // are those of equal beads with lambda = m / 2 H in place of lambda_H.
    #[test]
    fn limit_beads_of_two_frictions() {
        let (z1, z2, rate) = (1.5, 6.0, 0.8);
        let lambda = 0.5 * z1 * z2 / (z1 + z2);
        let xy = rate * lambda;
        let stretch = planar(1.0 + 2.0 * xy * xy, xy, 1.0, 1.0);
        let particles = Particles::new(chains_of_moments(&[stretch * 0.5]))
            .unwrap()
            .with_species(vec![0, 1, 0, 1, 0, 1])
            .unwrap();
        let system = system(Flow(planar_mixed(0.0, rate)), particles);
        let found = GiesekusStress {
            molecules: Molecules::linear(0, 3, 2).unwrap(),
            friction: |species| [z1, z2][usize::from(species)],
        }
        .measure(&system.frame(), &())
        .unwrap();
        let exact = stretch - DMat3::IDENTITY;
        assert!((found - exact).abs_diff_eq(DMat3::ZERO, 1e-12), "{found}");
    }

    #[test]
    fn extreme_no_friction_no_molecules_and_no_flow() {
        let system = at(Open, vec![DVec3::ZERO, DVec3::X]);
        let measure = |count, friction: f64| {
            GiesekusStress {
                molecules: Molecules::linear(0, count, 2).unwrap(),
                friction: |_| friction,
            }
            .measure(&system.frame(), &())
        };
        for friction in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let found = measure(1, friction);
            assert!(
                matches!(found, Err(AnalysisError::Parameter(_))),
                "{found:?}"
            );
        }
        assert!(matches!(measure(0, 4.0), Err(AnalysisError::TooFew { .. })));
        assert_eq!(measure(1, 4.0), Ok(DMat3::ZERO));
    }
}
