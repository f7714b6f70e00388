//! The explicit scheme of Euler and Maruyama.

use crate::{Mobility, Root, stage::Stage};
use zimm_core::{Boundary, ForceField, ParameterError, StepError, Stepper, System, Tally};

/// Euler and Maruyama's scheme for overdamped beads in a flow:
///
/// ```text
/// r' = E r + M F dt + sqrt(2 kT dt) M^(1/2) z
/// ```
///
/// with E the deformation of the flow over the step, M the mobility and F the forces, both at the beginning, and z
/// normal numbers. Averages are of first order in dt. A spring that would be stretched beyond its limit is an error
/// ([`zimm_core::ForceError::Overstretched`]); the system is then as it was.
///
/// ```
/// use zimm_brownian::{Diagonal, EulerMaruyama, FreeDraining};
/// use zimm_core::{Bonded, Clock, DVec3, Open, Particles, Stepper, System};
/// use zimm_forces::Hooke;
///
/// // A dumbbell in the customary units, kT = H = 1 and a friction of 4.
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?;
/// let mut system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut springs = Bonded::new(Hooke::new(1.0)?, vec![[0, 1]]);
/// let mut stepper = EulerMaruyama::new(FreeDraining::new(4.0)?, Diagonal);
/// for _ in 0..100 {
///     stepper.step(&mut system, &mut springs, &mut ())?;
/// }
/// assert_eq!(system.clock.now().time, 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct EulerMaruyama<M, R> {
    mobility: M,
    root: R,
    stage: Stage,
}

impl<M, R> EulerMaruyama<M, R> {
    /// The scheme with this mobility and this root of it.
    pub fn new(mobility: M, root: R) -> Self {
        Self {
            mobility,
            root,
            stage: Stage::default(),
        }
    }

    /// Keeps a mobility and what its root has made of it for so many steps, as
    /// [`SemiImplicit::keeping`](crate::SemiImplicit::keeping) does.
    ///
    /// # Errors
    /// If `steps` is 0.
    pub fn keeping(mut self, steps: u64) -> Result<Self, ParameterError> {
        self.stage.keep(steps)?;
        Ok(self)
    }
}

impl<B: Boundary, F: ForceField<B>, M: Mobility<B>, R: Root<B, M>> Stepper<B, F>
    for EulerMaruyama<M, R>
{
    fn step<T: Tally>(
        &mut self,
        system: &mut System<B>,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError> {
        let stage = &mut self.stage;
        stage.open(system, field)?;
        stage.drive(system, &mut self.mobility, &mut self.root)?;
        stage.carry(system);
        let boundary = stage.settle(system)?;
        let mut heard = tally.fresh();
        stage.evaluate(system, &boundary, field, &mut heard)?;
        stage.commit(system, boundary);
        tally.absorb(heard);
        Ok(())
    }
}
