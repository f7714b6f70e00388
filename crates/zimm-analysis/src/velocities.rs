//! How fast every particle is.

use crate::AnalysisError;
use crate::kinetic_temperature::mean_velocity;
use zimm_core::{Boundary, DVec3, Frame, Observable};

/// The peculiar velocity of every particle relative to the centre of mass of all of them, by identity.
///
/// Its autocorrelation is `<c(t) . c(0)>`, 3 kT / m at zero, and a third of its integral is the diffusion coefficient
/// (Green 1954, Kubo 1957).
///
/// ```
/// use zimm_analysis::{Autocorrelation, Velocities};
/// use zimm_core::{Clock, DVec3, Estimator, Observable, Open, Particles, System};
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?.with_velocities(vec![DVec3::X, 3.0 * DVec3::X])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// assert_eq!(Velocities.measure(&system.frame(), &())?, [-DVec3::X, DVec3::X]);
///
/// let mut correlation = Autocorrelation::new(0.01)?;
/// for _ in 0..8 {
///     // ... a step of the system ...
///     correlation.push(Velocities.measure(&system.frame(), &())?);
/// }
/// let diffusion = correlation.integral(0.02)?.times(1.0 / 3.0);
/// assert!((diffusion.value - 0.02 / 3.0).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Velocities;

impl<B: Boundary, T> Observable<B, T> for Velocities {
    type Output = Result<Vec<DVec3>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        if frame.velocities.len() < frame.len() {
            return Err(AnalysisError::MissingColumn {
                column: "velocities",
            });
        }
        let drift = mean_velocity(frame);
        let mut velocities = vec![DVec3::ZERO; frame.len()];
        for (place, &velocity) in frame.velocities.iter().enumerate() {
            if let Some(entry) = velocities.get_mut(frame.id(place) as usize) {
                *entry = velocity - drift;
            }
        }
        Ok(velocities)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Random, at, system};
    use crate::{Autocorrelation, MeanSquareDisplacement, Unwrapped};
    use zimm_core::{Estimator, Open, Particles};

    // Langevin particles without forces, exact at intervals of 0.05: velocities of variance kT / m = 1 that relax with
    // rate 1, and the displacements that go with them (Gillespie, Phys. Rev. E 54, 2084, 1996). D = 1 - 1/N with the
    // drift taken off. 40 particles of seed 420, 20 000 samples, 1000 relaxation times: D from velocities by the
    // trapezoidal rule, which adds interval^2 / 12 = 0.02 %, and from displacements of 6 to 12 time units. Errors of 1
    // to 2 % each, asserted below 2.5 %; bounds are 4 of them. A factor of 3 or 2 is far off.
    #[test]
    fn limit_diffusion_by_both_routes() {
        let (n, interval, samples) = (40, 0.05_f64, 20_000);
        let mut random = Random::new(420);
        let velocities = (0..n).map(|_| random.normal3()).collect();
        let particles = Particles::new(vec![DVec3::ZERO; n]).unwrap();
        let mut system = system(Open, particles.with_velocities(velocities).unwrap());
        let mut correlation = Autocorrelation::new(interval).unwrap();
        let mut displacement = MeanSquareDisplacement::new(20.0 * interval, 6..=12).unwrap();
        let mu = (-interval).exp();
        let width = (1.0 - mu * mu).sqrt();
        // Of the noise of positions: what goes with that of velocities, and what does not.
        let common = (1.0 - mu).powi(2) / width;
        let variance = 2.0 * interval - 3.0 + 4.0 * mu - mu * mu;
        let own = (variance - common * common).sqrt();
        for k in 0..samples {
            correlation.push(Velocities.measure(&system.frame(), &()).unwrap());
            if k % 20 == 0 {
                displacement.push(Unwrapped.measure(&system.frame(), &()).unwrap());
            }
            let columns = system.particles.columns_mut();
            for (r, c) in columns
                .positions
                .iter_mut()
                .zip(columns.velocities.iter_mut())
            {
                let (a, b) = (random.normal3(), random.normal3());
                *r += (1.0 - mu) * *c + common * a + own * b;
                *c = mu * *c + width * a;
            }
        }
        let exact = 1.0 - 1.0 / n as f64;
        let from_velocities = correlation.integral(8.0).unwrap().times(1.0 / 3.0);
        let from_displacements = displacement.estimate().unwrap().coefficient;
        println!("{from_velocities} {from_displacements}");
        for found in [from_velocities, from_displacements] {
            let error = found.at_least();
            assert!(error < 0.025, "{found}");
            assert!((found.value - exact).abs() < 4.0 * error, "{found}");
        }
    }

    #[test]
    fn extreme_no_velocities_are_an_error() {
        let column = "velocities";
        let found = Velocities.measure(&at(Open, vec![DVec3::ZERO]).frame(), &());
        assert_eq!(found, Err(AnalysisError::MissingColumn { column }));
    }
}
