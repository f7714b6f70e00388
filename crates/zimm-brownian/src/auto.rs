//! The cheaper of the two periodic mobilities.

use crate::{Ewald, Lanczos, Mesh, Mobility, Root, SplitNoise, White};
use zimm_core::{DVec3, Frame, MobilityError, ParameterError, Periodic};

/// As many beads as it takes for a step with [`Mesh`] and [`SplitNoise`] to be cheaper than one with [`Ewald`] and
/// [`Lanczos`]. Measured at a relative error of 1e-3 (the work-precision study, figure `mobility`): at 100 beads, the
/// fewest tried, the mesh takes less already, since its noise needs so few products.
const CROSSOVER: usize = 100;

/// [`Ewald`] for few beads, [`Mesh`] for many, whichever makes the cheaper step. The noise that goes with it is
/// [`AutoNoise`].
///
/// The choice depends on the number of beads alone, so that a restart makes the same one.
///
/// ```
/// use zimm_boundary::PeriodicBox;
/// use zimm_brownian::{Auto, AutoNoise, SemiImplicit};
/// use zimm_core::{Bonded, Clock, DVec3, Particles, Stepper, System};
/// use zimm_forces::Fene;
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?;
/// let space = PeriodicBox::brick(DVec3::splat(20.0))?;
/// let mut system = System::new(space, particles, Clock::new(0.05, 1.0, 1)?);
/// let mut springs = Bonded::new(Fene::new(1.0, 50.0_f64.sqrt())?, vec![[0, 1]]);
/// let mut stepper = SemiImplicit::new(Auto::new(4.0, 0.44, 1e-3)?, AutoNoise::new(1e-3)?);
/// stepper.step(&mut system, &mut springs, &mut ())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Auto {
    direct: Ewald,
    mesh: Mesh,
    is_on_mesh: bool,
}

impl Auto {
    /// Beads of this friction and radius, to a relative error of `tolerance`.
    ///
    /// # Errors
    /// If `friction` or `radius` is not finite and above zero, or `tolerance` is not between 1e-11 and 0.1.
    pub fn new(friction: f64, radius: f64, tolerance: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            direct: Ewald::new(friction, radius, tolerance)?,
            mesh: Mesh::new(friction, radius, tolerance)?,
            is_on_mesh: false,
        })
    }
}

impl<B: Periodic> Mobility<B> for Auto {
    fn bind(&mut self, frame: &Frame<'_, B>) -> Result<(), MobilityError> {
        self.is_on_mesh = frame.len() >= CROSSOVER;
        if self.is_on_mesh {
            self.mesh.bind(frame)
        } else {
            self.direct.bind(frame)
        }
    }

    fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        if self.is_on_mesh {
            Mobility::<B>::apply(&mut self.mesh, forces, velocities);
        } else {
            Mobility::<B>::apply(&mut self.direct, forces, velocities);
        }
    }

    fn accuracy(&self) -> f64 {
        if self.is_on_mesh {
            Mobility::<B>::accuracy(&self.mesh)
        } else {
            Mobility::<B>::accuracy(&self.direct)
        }
    }

    fn alone(&self, place: usize) -> f64 {
        if self.is_on_mesh {
            Mobility::<B>::alone(&self.mesh, place)
        } else {
            Mobility::<B>::alone(&self.direct, place)
        }
    }
}

/// The square root of an [`Auto`] mobility: [`Lanczos`] or [`SplitNoise`].
#[derive(Clone, Debug)]
pub struct AutoNoise {
    direct: Lanczos,
    mesh: SplitNoise,
}

impl AutoNoise {
    /// The root with a relative error of `tolerance`.
    ///
    /// # Errors
    /// If `tolerance` is not between 1e-12 and 1.
    pub fn new(tolerance: f64) -> Result<Self, ParameterError> {
        Ok(Self {
            direct: Lanczos::new(tolerance)?,
            mesh: SplitNoise::new(tolerance)?,
        })
    }
}

impl<B: Periodic> Root<B, Auto> for AutoNoise {
    fn add(
        &mut self,
        mobility: &mut Auto,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        if mobility.is_on_mesh {
            Root::<B, Mesh>::add(
                &mut self.mesh,
                &mut mobility.mesh,
                white,
                scale,
                displacements,
            )
        } else {
            let direct = &mut mobility.direct;
            Root::<B, Ewald>::add(&mut self.direct, direct, white, scale, displacements)
        }
    }
}
