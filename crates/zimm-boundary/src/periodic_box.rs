//! A lattice at rest.

use zimm_core::{Boundary, DMat3, DVec3, IVec3, Lattice, LatticeError, Periodic};

/// Space repeated by a lattice at rest. The primary cell is centred on the origin.
///
/// ```
/// use zimm_boundary::PeriodicBox;
/// use zimm_core::{Boundary, DVec3, IVec3};
///
/// let space = PeriodicBox::brick(DVec3::new(10.0, 8.0, 6.0))?;
/// let (folded, images) = space.wrap(DVec3::new(1.0, -13.0, 2.0));
/// assert_eq!((folded, images), (DVec3::new(1.0, 3.0, 2.0), IVec3::new(0, -2, 0)));
/// assert_eq!(space.reach(), 3.0);
/// # Ok::<(), zimm_core::LatticeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicBox {
    lattice: Lattice,
}

impl PeriodicBox {
    /// A cube of the given edge.
    ///
    /// # Errors
    /// If the edge is not finite and above zero, or its cube overflows or vanishes.
    pub fn cubic(edge: f64) -> Result<Self, LatticeError> {
        Self::brick(DVec3::splat(edge))
    }

    /// A brick with edges along x, y and z.
    ///
    /// # Errors
    /// If an edge is not finite and above zero, or the volume overflows or vanishes.
    pub fn brick(edges: DVec3) -> Result<Self, LatticeError> {
        let lattice = Lattice::brick(edges)?;
        Ok(Self { lattice })
    }

    /// A cell spanned by three vectors, the columns of `basis`, of either handedness. The basis is reduced: images
    /// are the same, image counts are in units of the reduced vectors.
    ///
    /// # Errors
    /// If the vectors are not finite, or flat to 1e-10 of the box that their lengths span.
    pub fn triclinic(basis: DMat3) -> Result<Self, LatticeError> {
        let lattice = Lattice::new(basis)?;
        Ok(Self { lattice })
    }
}

impl Boundary for PeriodicBox {
    #[inline(always)]
    fn min_image(&self, dr: DVec3) -> DVec3 {
        self.lattice.nearest(dr)
    }

    #[inline(always)]
    fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
        self.lattice.fold(r)
    }

    fn reach(&self) -> f64 {
        0.5 * self.lattice.shortest()
    }

    fn cell(&self) -> Option<DMat3> {
        Some(self.lattice.basis())
    }
}

impl Periodic for PeriodicBox {
    fn lattice(&self) -> &Lattice {
        &self.lattice
    }
}
