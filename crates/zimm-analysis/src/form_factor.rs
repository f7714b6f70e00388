//! The structure of a chain as scattering sees it.

use crate::AnalysisError;
use crate::chain::map_chains;
use zimm_core::{Boundary, Frame, Molecules, Observable, ParameterError};

/// The structure factor of single chains of N beads, averaged over all directions of the wave vector and over the
/// chains of a frame:
///
/// ```text
/// S(k) = (1/N) sum_i sum_j sin(k r_ij) / (k r_ij)          S(0) = N
/// ```
///
/// (Debye 1915; Doi and Edwards 1986, eq. 2.69). At small k it is N (1 - k^2 R_g^2 / 3), between 1 / R_g and the length of
/// a bond it falls as k^(-1/nu). Each frame costs N^2 / 2 sines a chain and wave number; average frames with
/// [`BlockAverages`](crate::BlockAverages). Chains that a flow has turned are not isotropic, and this averages over how.
///
/// ```
/// use zimm_analysis::FormFactor;
/// use zimm_core::{Clock, DVec3, Molecules, Observable, Open, Particles, System};
///
/// let particles = Particles::new(vec![DVec3::ZERO, 2.0 * DVec3::X])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let molecules = Molecules::linear(0, 1, 2)?;
/// let s = FormFactor::new(molecules, vec![0.0, 0.5])?.measure(&system.frame(), &())?;
/// assert_eq!(s[0], 2.0);
/// assert!((s[1] - (1.0 + 1.0_f64.sin())).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct FormFactor {
    molecules: Molecules,
    wave_numbers: Vec<f64>,
}

impl FormFactor {
    /// Of these molecules at these wave numbers, in 1 / length.
    ///
    /// # Errors
    /// If a wave number is below zero or not finite.
    pub fn new(molecules: Molecules, wave_numbers: Vec<f64>) -> Result<Self, ParameterError> {
        for &k in &wave_numbers {
            ParameterError::non_negative("wave number", k)?;
        }
        Ok(Self {
            molecules,
            wave_numbers,
        })
    }

    /// The wave numbers.
    pub fn wave_numbers(&self) -> &[f64] {
        &self.wave_numbers
    }
}

impl<B: Boundary, T> Observable<B, T> for FormFactor {
    type Output = Result<Vec<f64>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        let mut sums = vec![0.0; self.wave_numbers.len()];
        let chains = map_chains(frame, &self.molecules, |_, beads| {
            let per_bead = 1.0 / beads.len() as f64;
            for (sum, k) in sums.iter_mut().zip(&self.wave_numbers) {
                let mut pairs = 0.0;
                for (i, here) in beads.iter().enumerate() {
                    for there in &beads[..i] {
                        pairs += sinc(k * here.distance(*there));
                    }
                }
                *sum += 1.0 + 2.0 * per_bead * pairs;
            }
        })?;
        if chains.is_empty() {
            return Err(AnalysisError::TooFew {
                what: "molecules",
                found: 0,
                needed: 1,
            });
        }
        sums.iter_mut().for_each(|sum| *sum /= chains.len() as f64);
        Ok(sums)
    }
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.sin() / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, Random, at};
    use zimm_core::{DMat3, DVec3, Open};

    // Ideal chains with Gaussian bonds of unit variance along each axis: S = (1/N) sum exp(-k^2 |i - j| / 2). 4000 chains
    // of 10 beads and 2000 of 20 in one tilted cell, seed 95; S(k) of one chain scatters by less than 0.7 of its mean at
    // k = 0.5 and by less elsewhere, so errors are below 1.1 % (N = 10) and 1.6 %; each estimate of it is taken from the
    // chains themselves, and the bound is 4 of them.
    #[test]
    fn reference_ideal_chains() {
        for (n, count, exact) in [
            (10, 4000, [9.837_042, 6.899_972, 3.304_728, 1.276_832]),
            (20, 2000, [19.351_298, 10.153_815, 3.691_236, 1.294_934]),
        ] {
            let mut random = Random::new(95);
            let mut positions = Vec::new();
            for _ in 0..count {
                let mut r = random.within(DMat3::IDENTITY * 40.0);
                for _ in 0..n {
                    positions.push(r);
                    r += random.normal3();
                }
            }
            let system = at(Cell::lees_edwards(DVec3::splat(40.0), 17.0), positions);
            let wave_numbers = vec![0.1, 0.5, 1.0, 2.0];
            let (mut sum, mut squares) = ([0.0; 4], [0.0; 4]);
            for chain in 0..count {
                let molecules = Molecules::linear(chain * n, 1, n).unwrap();
                let found = FormFactor::new(molecules, wave_numbers.clone())
                    .unwrap()
                    .measure(&system.frame(), &())
                    .unwrap();
                for (k, s) in found.into_iter().enumerate() {
                    sum[k] += s;
                    squares[k] += s * s;
                }
            }
            for (k, exact) in exact.into_iter().enumerate() {
                let mean = sum[k] / f64::from(count);
                let variance = squares[k] / f64::from(count) - mean * mean;
                let error = (variance / f64::from(count)).sqrt();
                assert!(error < 0.02 * exact, "{error}");
                assert!((mean - exact).abs() < 4.0 * error, "{mean} for {exact}");
            }
            let molecules = Molecules::linear(0, count, n).unwrap();
            let together = FormFactor::new(molecules, wave_numbers)
                .unwrap()
                .measure(&system.frame(), &())
                .unwrap();
            for (together, sum) in together.into_iter().zip(sum) {
                approx::assert_relative_eq!(together, sum / f64::from(count), max_relative = 1e-12);
            }
        }
    }

    // At small k, S = N (1 - k^2 R_g^2 / 3 + ...); a rod of 5 beads 1 apart has R_g^2 = 2.
    #[test]
    fn limit_small_wave_numbers_show_the_radius_of_gyration() {
        let system = at(Open, (0..5).map(|k| DVec3::Y * f64::from(k)).collect());
        let molecules = Molecules::linear(0, 1, 5).unwrap();
        let mut form = FormFactor::new(molecules, vec![1e-3]).unwrap();
        let found = form.measure(&system.frame(), &()).unwrap()[0];
        approx::assert_relative_eq!((1.0 - found / 5.0) * 3e6, 2.0, max_relative = 1e-5);
        assert_eq!(form.wave_numbers(), [1e-3]);
    }

    #[test]
    fn extreme_beads_in_one_place_and_bad_wave_numbers() {
        let system = at(Open, vec![DVec3::ONE; 4]);
        let form = |count, k| {
            let molecules = Molecules::linear(0, count, 2).unwrap();
            FormFactor::new(molecules, vec![k])
        };
        let measure = |count| form(count, 3.0).unwrap().measure(&system.frame(), &());
        assert_eq!(measure(2), Ok(vec![2.0]));
        assert!(matches!(measure(0), Err(AnalysisError::TooFew { .. })));
        for k in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(form(1, k).is_err());
        }
    }
}
