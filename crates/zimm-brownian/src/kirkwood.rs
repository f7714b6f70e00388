//! How fast chains diffuse at first.

use crate::Entries;
use zimm_core::{Boundary, Frame, ListError, MobilityError, Molecules, Observable};

/// The short-time diffusivity of each molecule's centre of mass, Kirkwood's (1954) double sum over its N beads:
///
/// ```text
/// D = kT / N^2  sum_ij  tr M_ij / 3
/// ```
///
/// Its average over configurations is the rate at which the centre of mass moves before the chain changes shape; the
/// rate at long times is a few per cent smaller. Units are those of kT over a friction; in units of l_H and zeta / 4H a
/// bead alone has 1/4.
///
/// ```
/// use zimm_brownian::{Kirkwood, Rpy};
/// use zimm_core::{Clock, DVec3, Molecules, Observable, Open, Particles, System};
///
/// // A dumbbell of two beads that touch: (1 + a / r) / 2 of a bead alone.
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut diffusivity = Kirkwood {
///     mobility: Rpy::new(4.0, 0.5)?,
///     molecules: Molecules::linear(0, 1, 2)?,
/// };
/// let found = diffusivity.measure(&system.frame(), &())?[0];
/// assert!((found - 0.25 * 0.75).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Kirkwood<M> {
    /// How beads move each other.
    pub mobility: M,
    /// The molecules.
    pub molecules: Molecules,
}

impl<B: Boundary, T, M: Entries<B>> Observable<B, T> for Kirkwood<M> {
    type Output = Result<Vec<f64>, MobilityError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        self.mobility.bind(frame)?;
        let trace = |i: usize, j: usize| {
            let block = self.mobility.entry(i, j);
            block.x_axis.x + block.y_axis.y + block.z_axis.z
        };
        let beads = f64::from(self.molecules.beads());
        self.molecules
            .iter()
            .map(|identities| {
                let mut sum = 0.0;
                let mut places = Vec::with_capacity(identities.len());
                for identity in identities {
                    let place = frame.place(identity).ok_or(ListError::NoSuchParticle {
                        identity,
                        particles: frame.len(),
                    })?;
                    sum += trace(place, place);
                    sum += 2.0 * places.iter().map(|&other| trace(place, other)).sum::<f64>();
                    places.push(place);
                }
                Ok(frame.now.kt * sum / (3.0 * beads * beads))
            })
            .collect()
    }
}
