//! The normal modes of linear chains.

use crate::AnalysisError;
use crate::chain::map_chains;
use std::f64::consts::PI;
use zimm_core::{Boundary, DVec3, Frame, Molecules, Observable, Topology};

/// The amplitudes of the Rouse modes of linear chains of N beads,
///
/// ```text
/// X_p = sqrt(2/N) sum_i r_i cos(p pi (i + 1/2) / N),   i = 0 .. N-1,   p = 1, 2, ...
/// ```
///
/// by mode, and of each mode by molecule. The modes are orthonormal, so that sum_p |X_p|^2 is N times the squared radius
/// of gyration, and those of Hookean chains at rest are independent (Rouse 1953; Verdier, J. Chem. Phys. 45, 2118, 1966):
///
/// ```text
/// <|X_p|^2> = 3 kT / (H a_p),   <X_p(t) . X_p(0)> ~ exp(-t / 2 tau_p),   a_p = 4 sin^2(p pi / 2N),   tau_p = zeta / (2 H a_p)
/// ```
///
/// tau_p is the relaxation time of stress; the amplitude relaxes in 2 tau_p, which is what
/// [`Autocorrelation`](crate::Autocorrelation) of a mode finds.
///
/// ```
/// use zimm_analysis::RouseModes;
/// use zimm_core::{Clock, DVec3, Molecules, Observable, Open, Particles, System};
///
/// // A dumbbell has one mode, Q / sqrt(2) against its connector.
/// let particles = Particles::new(vec![DVec3::ZERO, 2.0 * DVec3::X])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let modes = RouseModes::new(Molecules::linear(0, 1, 2)?, 1)?.measure(&system.frame(), &())?;
/// assert!((modes[0][0].x + 2.0_f64.sqrt()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct RouseModes {
    molecules: Molecules,
    /// The weights of the beads, mode by mode.
    weights: Vec<Vec<f64>>,
}

impl RouseModes {
    /// The first `modes` modes of linear molecules.
    ///
    /// # Errors
    /// If the molecules are not linear, or have fewer beads than `modes` + 1.
    pub fn new(molecules: Molecules, modes: usize) -> Result<Self, AnalysisError> {
        let (beads, topology) = (molecules.beads() as usize, molecules.topology());
        if topology != Topology::Linear {
            return Err(AnalysisError::NotLinear { topology });
        }
        if beads <= modes {
            return Err(AnalysisError::TooFew {
                what: "beads of a chain",
                found: beads as u64,
                needed: modes as u64 + 1,
            });
        }
        let size = (2.0 / beads as f64).sqrt();
        let weight = |p: usize, bead: usize| {
            size * (PI * p as f64 * (bead as f64 + 0.5) / beads as f64).cos()
        };
        let weights = |p| (0..beads).map(|bead| weight(p, bead)).collect();
        Ok(Self {
            molecules,
            weights: (1..=modes).map(weights).collect(),
        })
    }
}

impl<B: Boundary, T> Observable<B, T> for RouseModes {
    type Output = Result<Vec<Vec<DVec3>>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        let mut modes: Vec<Vec<DVec3>> = vec![Vec::new(); self.weights.len()];
        map_chains(frame, &self.molecules, |_, beads| {
            for (mode, weights) in modes.iter_mut().zip(&self.weights) {
                let weighted = weights.iter().zip(beads).map(|(&w, &bead)| w * bead);
                mode.push(weighted.sum());
            }
        })?;
        Ok(modes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, Random, at, chains_of_moments, mode, rouse_moments, step, stiffness};
    use crate::{Autocorrelation, SquaredRadius};
    use approx::assert_relative_eq;
    use zimm_core::{Estimator, Open, Particles};

    // Chains of 10 and 20 beads whose second moments are exactly those of equilibrium: <|X_p|^2> = 3 / a_p.
    #[test]
    fn limit_amplitudes_of_hookean_chains() {
        for n in [2_u32, 3, 10, 20] {
            let count = 3 * (n - 1);
            let system = at(Open, chains_of_moments(&rouse_moments(n, 0.0, 0.0)));
            let molecules = Molecules::linear(0, count, n).unwrap();
            let modes = RouseModes::new(molecules, n as usize - 1)
                .unwrap()
                .measure(&system.frame(), &())
                .unwrap();
            for (p, amplitudes) in (1..n).zip(modes) {
                assert_eq!(amplitudes.len(), count as usize);
                let square: f64 = amplitudes.iter().map(|x| x.length_squared()).sum();
                let exact = 3.0 / stiffness(n, p);
                assert_relative_eq!(square / f64::from(count), exact, max_relative = 1e-12);
            }
        }
    }

    // A random walk across many images of a tilted cell: Parseval, and the chain comes back from its modes.
    #[test]
    fn law_modes_are_orthonormal_and_see_no_images() {
        let (n, mut random) = (12_u32, Random::new(91));
        let mut walk = vec![DVec3::splat(0.3)];
        for _ in 1..n {
            let bond = random.normal3().clamp_length_max(0.9);
            walk.push(walk[walk.len() - 1] + bond);
        }
        let centre = walk.iter().sum::<DVec3>() / f64::from(n);
        let system = at(Cell::lees_edwards(DVec3::splat(2.0), 0.7), walk.clone());
        let molecules = Molecules::linear(0, 1, n).unwrap();
        let modes = RouseModes::new(molecules, n as usize - 1)
            .unwrap()
            .measure(&system.frame(), &())
            .unwrap();
        let squares: f64 = modes.iter().map(|mode| mode[0].length_squared()).sum();
        let radius = SquaredRadius { molecules }
            .measure(&system.frame(), &())
            .unwrap();
        assert_relative_eq!(squares, f64::from(n) * radius[0], max_relative = 1e-12);
        for (bead, r) in (0..n).zip(walk) {
            let parts = (1..n).zip(&modes).map(|(p, x)| mode(n, p, bead) * x[0]);
            assert!((parts.sum::<DVec3>() + centre - r).length() < 1e-12);
        }
    }

    // Ten Rouse chains of five beads whose modes are Ornstein-Uhlenbeck processes, exact at intervals of 0.25: stress
    // times tau_p = 2 / a_p = 5.236, 1.447, 0.764, 0.553 in lambda_H, so amplitudes relax in 10.47, 2.894, 1.528, 1.106.
    // 40 000 samples, seed 92. The lags that give the time are about 0 and one such time. Each time comes with its
    // error, which must be below 2 %, and each amplitude <|X_p|^2> = 3 / a_p below 1.5 %; bounds 4 of the errors. A
    // factor of 2 between the two times, or N + 1 in place of N, is far off.
    #[test]
    fn limit_relaxation_spectrum() {
        let (n, chains, interval) = (5_u32, 10_u32, 0.25);
        let mut random = Random::new(92);
        let particles = Particles::new(vec![DVec3::ZERO; (n * chains) as usize]).unwrap();
        let mut system = crate::scene::system(Open, particles);
        let molecules = Molecules::linear(0, chains, n).unwrap();
        let mut rouse = RouseModes::new(molecules, n as usize - 1).unwrap();
        let time = |p| 4.0 / stiffness(n, p);
        let mut correlations: Vec<_> = (1..n)
            .map(|_| Autocorrelation::new(interval).unwrap())
            .collect();
        let mut state: Vec<Vec<DVec3>> = (1..n)
            .map(|p| {
                let amplitude = || random.normal3() / stiffness(n, p).sqrt();
                std::iter::repeat_with(amplitude)
                    .take(chains as usize)
                    .collect()
            })
            .collect();
        for _ in 0..40_000 {
            let mut place = 0;
            let before: Vec<DVec3> = system.particles.positions().to_vec();
            step(&mut system, || {
                let (chain, bead) = (place / n, place % n);
                let parts = (1..n).zip(&state);
                let r: DVec3 = parts
                    .map(|(p, x)| mode(n, p, bead) * x[chain as usize])
                    .sum();
                place += 1;
                r - before[place as usize - 1]
            });
            let modes = rouse.measure(&system.frame(), &()).unwrap();
            for (correlation, amplitudes) in correlations.iter_mut().zip(modes) {
                correlation.push(amplitudes);
            }
            for (p, amplitudes) in (1..n).zip(&mut state) {
                let phi = (-interval / time(p)).exp();
                let width = ((1.0 - phi * phi) / stiffness(n, p)).sqrt();
                for x in amplitudes {
                    *x = phi * *x + width * random.normal3();
                }
            }
        }
        for (p, correlation) in (1..n).zip(correlations) {
            let found = correlation.relaxation_time(0.0..=time(p)).unwrap();
            let error = found.at_least();
            assert!(error < 0.02 * time(p), "{found}");
            assert!((found.value - time(p)).abs() < 4.0 * error, "{p}: {found}");
            let square = correlation.estimate().unwrap().correlation[0];
            let (error, exact) = (square.at_least(), 3.0 / stiffness(n, p));
            assert!(error < 0.015 * exact, "{square}");
            assert!((square.value - exact).abs() < 4.0 * error, "{p}: {square}");
        }
    }

    #[test]
    fn extreme_modes_that_a_chain_does_not_have_are_refused() {
        let chains = |count, beads| Molecules::linear(0, count, beads).unwrap();
        assert!(matches!(
            RouseModes::new(chains(1, 3), 3),
            Err(AnalysisError::TooFew {
                found: 3,
                needed: 4,
                ..
            })
        ));
        assert!(RouseModes::new(chains(1, 3), 2).is_ok());
        let ring = Molecules::ring(0, 1, 3).unwrap();
        let topology = Topology::Ring;
        assert_eq!(
            RouseModes::new(ring, 1).unwrap_err(),
            AnalysisError::NotLinear { topology }
        );
        let none = at(Open, vec![]);
        let mut modes = RouseModes::new(chains(0, 3), 1).unwrap();
        assert_eq!(modes.measure(&none.frame(), &()), Ok(vec![vec![]]));
    }
}
