//! Two channels of opposite flow in one periodic cell.

use zimm_core::{DVec3, ForceError, ForceField, Frame, ParameterError, Periodic, Reads, Tally};

/// Reverse Poiseuille flow: a force +f along one axis on every particle in one half of the cell, -f in the other.
///
/// The halves are those of the lattice vector number `gradient`: +f where the fractional coordinate along it is
/// between 0 and 1/2, -f between -1/2 and 0. The velocity vanishes at the planes between them, which so act as walls
/// without being any. With H half the cell and n the number density, the stress at these planes is f n H / 2 and falls
/// linearly to zero at the centre of either half; a Newtonian fluid peaks at n f H^2 / (8 eta). The halves seldom hold
/// equally many particles, so the mean force at each moment is taken off: the total vanishes and momentum is conserved.
///
/// Body forces act between no pair, so tallies do not hear of them. Backer, Lowe, Hoefsloot and Iedema, J. Chem. Phys.
/// 122, 154503 (2005); Fedosov, Karniadakis and Caswell, J. Chem. Phys. 132, 144103 (2010).
///
/// ```
/// # use zimm_core::{Boundary, Clock, DVec3, ForceField, IVec3, Lattice, Particles, Periodic, System};
/// # #[derive(Clone)]
/// # struct Brick(Lattice);
/// # impl Boundary for Brick {
/// #     fn min_image(&self, dr: DVec3) -> DVec3 { self.0.nearest(dr) }
/// #     fn wrap(&self, r: DVec3) -> (DVec3, IVec3) { self.0.fold(r) }
/// # }
/// # impl Periodic for Brick {
/// #     fn lattice(&self) -> &Lattice { &self.0 }
/// # }
/// use zimm_forces::ReversePoiseuille;
///
/// // Driven along x, sheared along y.
/// let mut drive = ReversePoiseuille::new(0.5, 0, 1)?;
/// let space = Brick(Lattice::brick(DVec3::splat(4.0))?);
/// let particles = Particles::new(vec![DVec3::Y, -DVec3::Y])?;
/// let system = System::new(space, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut forces = vec![DVec3::ZERO; 2];
/// drive.accumulate(&system.frame(), &mut forces, &mut ())?;
/// assert_eq!(forces, [0.5 * DVec3::X, -0.5 * DVec3::X]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Open space has no halves:
///
/// ```compile_fail,E0277
/// use zimm_core::{ForceField, Open};
/// use zimm_forces::ReversePoiseuille;
///
/// fn needs_field<F: ForceField<Open>>() {}
/// needs_field::<ReversePoiseuille>();
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReversePoiseuille {
    force: DVec3,
    gradient: usize,
}

impl ReversePoiseuille {
    /// A force of this size on each particle, along axis `driving` and changing sign along axis `gradient`; axes are
    /// 0, 1 and 2.
    ///
    /// # Errors
    /// If `force` is not finite, or the axes are not two of three.
    pub fn new(force: f64, driving: usize, gradient: usize) -> Result<Self, ParameterError> {
        let force = ParameterError::finite("force", force)?;
        let Some(direction) = DVec3::AXES.get(driving) else {
            let allowed = "0, 1 or 2";
            return Err(ParameterError::new("driving axis", driving as f64, allowed));
        };
        if gradient > 2 || gradient == driving {
            let allowed = "0, 1 or 2, and not the driving axis";
            return Err(ParameterError::new(
                "gradient axis",
                gradient as f64,
                allowed,
            ));
        }
        Ok(Self {
            force: force * *direction,
            gradient,
        })
    }
}

impl<B: Periodic> ForceField<B> for ReversePoiseuille {
    const READS: Reads = Reads::NOTHING;
    const CONSERVES_MOMENTUM: bool = true;

    fn accumulate<T: Tally>(
        &mut self,
        frame: &Frame<'_, B>,
        forces: &mut [DVec3],
        _: &mut T,
    ) -> Result<(), ForceError> {
        let reciprocal = frame.boundary.lattice().inverse().row(self.gradient);
        let sign = |r: &DVec3| {
            let s = reciprocal.dot(*r);
            if s - s.floor() < 0.5 { 1.0 } else { -1.0 }
        };
        let mean = frame.positions.iter().map(sign).sum::<f64>() / frame.len().max(1) as f64;
        for (force, r) in forces.iter_mut().zip(frame.positions) {
            *force += (sign(r) - mean) * self.force;
        }
        Ok(())
    }
}
