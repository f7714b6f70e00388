//! The stress of chains in overdamped dynamics, per chain.

use crate::AnalysisError;
use zimm_core::{Boundary, DMat3, Frame, Molecules, Observable, Virial};

/// The polymer stress per chain in Brownian dynamics, by Kramers' expression:
///
/// ```text
/// sigma_p / n = (1/n V) [ sum_springs Q F  -  sum_other pairs r_ij F_ij ]  -  (N - 1) kT 1        tension positive
/// ```
///
/// with n chains (or rings, stars, combs) of N beads per volume, F the tension in a spring of connector Q, and F_ij the force on i from j of
/// excluded volume and whatever else acts between beads (Bird, Curtiss, Armstrong and Hassager 1987, sec. 13.3 and
/// 14.3, whose tau_p is -sigma_p). It is an energy: in units of kT it is the stress in units of n kT, and material
/// functions that come of it are in units of n kT and the unit of time.
///
/// It holds for springs of any law, with and without hydrodynamic interactions, in any flow however it changes with
/// time, for isolated chains in open space and for many chains in a cell. Its mean at rest is zero for isolated
/// chains; many chains that repel have a pressure. The tally must have heard of the chains' own forces and of none
/// else: beads are all there is in the scene, as they are in Brownian dynamics. [`Stress`](crate::Stress) of such a
/// scene is n times this, less n kT 1 for the chains as an ideal gas.
///
/// In a flow that is slow, the noise of sum Q F hides its mean: see [`GiesekusStress`](crate::GiesekusStress).
///
/// ```
/// use zimm_analysis::ChainStress;
/// use zimm_core::{Clock, DVec3, Item, Molecules, Observable, Open, Particles, System, Tally, Virial};
///
/// // A dumbbell whose spring is under the tension 1.5.
/// let particles = Particles::new(vec![DVec3::ZERO, 2.0 * DVec3::X])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut virial = Virial::default();
/// virial.hear(Item::Spring, DVec3::ZERO, -2.0 * DVec3::X, 1.5 * DVec3::X, &|| 0.0);
///
/// let molecules = Molecules::linear(0, 1, 2)?;
/// let stress = ChainStress { molecules }.measure(&system.frame(), &virial)?;
/// assert_eq!((stress.x_axis.x, stress.y_axis.y), (3.0 - 1.0, -1.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ChainStress {
    /// The molecules: all particles of the scene.
    pub molecules: Molecules,
}

impl<B: Boundary> Observable<B, Virial> for ChainStress {
    type Output = Result<DMat3, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, virial: &Virial) -> Self::Output {
        let (chains, beads) = (self.molecules.count(), self.molecules.beads());
        if chains == 0 {
            return Err(AnalysisError::TooFew {
                what: "molecules",
                found: 0,
                needed: 1,
            });
        }
        let internal = f64::from(beads - 1) * frame.now.kt;
        Ok(virial.total() * (-1.0 / f64::from(chains)) - DMat3::IDENTITY * internal)
    }
}

impl<B: Boundary, T> Observable<B, (Virial, T)> for ChainStress {
    type Output = Result<DMat3, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, (virial, _): &(Virial, T)) -> Self::Output {
        self.measure(frame, virial)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stress;
    use crate::scene::{Cell, Hooke, at};
    use zimm_core::{Bonded, DVec3, Energy, ForceField, Item, Open, Tally};

    // Two trimers in a cell, with a repulsion between beads of both: the stress of the scene is n sigma - n kT 1.
    #[test]
    fn law_the_stress_of_the_scene_is_that_of_its_chains() {
        let positions = vec![
            DVec3::ZERO,
            DVec3::X,
            DVec3::new(1.0, 0.5, 0.2),
            DVec3::splat(1.5),
            DVec3::new(1.1, 1.4, 1.3),
            DVec3::new(0.9, 1.0, 1.5),
        ];
        let system = at(Cell::cube(4.0), positions);
        let molecules = Molecules::linear(0, 2, 3).unwrap();
        let mut virial = Virial::default();
        Bonded::new(Hooke(1.3), molecules.bonds())
            .accumulate(&system.frame(), &mut [DVec3::ZERO; 6], &mut virial)
            .unwrap();
        let r = DVec3::new(0.1, -0.5, -1.3);
        virial.hear(Item::Conservative, DVec3::ZERO, r, 0.7 * r, &|| 0.0);
        let chain = ChainStress { molecules }
            .measure(&system.frame(), &virial)
            .unwrap();
        let both = ChainStress { molecules }.measure(&system.frame(), &(virial, Energy(0.0)));
        assert_eq!(both, Ok(chain));
        let density = 2.0 / 64.0;
        let whole = Stress.measure(&system.frame(), &virial).total();
        let expected = chain * density - DMat3::IDENTITY * density;
        assert!((whole - expected).abs_diff_eq(DMat3::ZERO, 1e-14));
    }

    #[test]
    fn extreme_no_molecules_are_an_error_and_single_beads_have_no_stress() {
        let system = at(Open, vec![DVec3::ZERO; 2]);
        let measure = |count, beads| {
            let molecules = Molecules::linear(0, count, beads).unwrap();
            ChainStress { molecules }.measure(&system.frame(), &Virial::default())
        };
        assert!(matches!(measure(0, 2), Err(AnalysisError::TooFew { .. })));
        assert_eq!(measure(2, 1), Ok(DMat3::ZERO));
    }
}
