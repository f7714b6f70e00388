//! A lattice that its flow maps onto itself again and again.

use crate::FlowError;
use crate::exp::{exp, size};
use crate::history::{FlowHistory, Then};
use zimm_core::{Boundary, DMat3, DVec3, IVec3, Lattice, LatticeError, Periodic, Remap};

/// A flow `kappa(t) = rate(t) K` of fixed shape K, and a lattice that it maps onto itself again and again.
///
/// The shape is a sum of two commuting parts, one of which may be zero, and each of them alone returns the lattice after
/// a strain of its own, exp(T_i K_i) H(0) = H(0) N_i with N_i an integer matrix of determinant 1. So the lattice at any
/// strain is
///
/// ```text
/// H(t) = exp( sum_i (strain(t) mod T_i) K_i ) H(0),    K = K_1 + K_2
/// ```
///
/// and then reduced. It is computed anew from H(0) and never accumulated: no number of periods makes it drift, and it is
/// as exact as the strain itself. The modulus is the nearest to zero, so that the cell is strained by half a period at
/// most; the exponential is taken in the basis of the flow's own axes, however oblique they are. Stopping the flow,
/// starting it again or changing its rate keep the lattice, since time enters by the strain alone.
///
/// Nothing outside sees when the basis changes: image counts are told how to follow by the [`Remap`], and peculiar
/// velocities are untouched.
///
/// Extension carries particles apart exponentially, and with them their image counts. Counts are integers of 32 bits
/// that wrap around. Those of particles that diverge with the flow have a meaning up to a Hencky strain of some 20 since
/// counting began, and a single step is to strain by less than that; the beads of a molecule, held together, have counts
/// that differ by little at all times. A time at which the strain is not finite leaves the space as it was.
///
/// F names the flow; the constructors are at [`KraynikReinelt`](crate::KraynikReinelt),
/// [`PlanarMixed`](crate::PlanarMixed), [`UniaxialExtension`](crate::UniaxialExtension) and
/// [`TriaxialFlow`](crate::TriaxialFlow).
#[derive(Clone, Debug, PartialEq)]
pub struct LatticeFlow<F, H> {
    pub(crate) flow: F,
    history: H,
    recurrence: Recurrence,
    time: f64,
    lattice: Lattice,
}

/// A flow of fixed shape and the lattice that it returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Recurrence {
    /// The velocity gradient at unit rate.
    pub(crate) shape: DMat3,
    /// The axes of the flow, as columns.
    pub(crate) axes: DMat3,
    /// The cell at strain zero, in coordinates along the axes.
    pub(crate) start: DMat3,
    pub(crate) parts: [Part; 2],
    /// The closest that two images ever come.
    pub(crate) min_image_distance: f64,
}

/// A part of a flow that commutes with the rest and returns the lattice after a strain of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// In coordinates along the axes.
    pub(crate) shape: DMat3,
    pub(crate) period: f64,
}

impl Recurrence {
    /// The cell at a strain, not yet reduced.
    fn cell(&self, strain: f64) -> DMat3 {
        let part = |k: usize| libm::remainder(strain, self.parts[k].period) * self.parts[k].shape;
        self.strained(part(0) + part(1))
    }

    fn strained(&self, exponent: DMat3) -> DMat3 {
        self.axes * (exp(exponent) * self.start)
    }

    /// Whether the cell is a lattice at all strains: at the ends of the periods it is most oblique.
    fn check(&self) -> Result<(), LatticeError> {
        let half = self.parts.map(|part| {
            if part.period.is_finite() {
                0.5 * part.period * part.shape
            } else {
                DMat3::ZERO
            }
        });
        for ends in [half[0] + half[1], half[0] - half[1]] {
            Lattice::new(self.strained(ends))?;
            Lattice::new(self.strained(-ends))?;
        }
        Ok(())
    }
}

impl Part {
    pub(crate) const NONE: Self = Self {
        shape: DMat3::ZERO,
        period: f64::INFINITY,
    };
}

impl<F: Clone, H: FlowHistory> LatticeFlow<F, H> {
    pub(crate) fn assemble(flow: F, recurrence: Recurrence, history: H) -> Result<Self, FlowError> {
        recurrence.check()?;
        let lattice = Lattice::new(recurrence.cell(history.strain(0.0)))?;
        Ok(Self {
            flow,
            history,
            recurrence,
            time: 0.0,
            lattice,
        })
    }

    /// The same flow and cell in another orientation: the columns of `frame` tell where the axes x, y and z of the flow
    /// point. Stands at time zero.
    ///
    /// ```
    /// use zimm_boundary::{KraynikReinelt, Steady};
    /// use zimm_core::{Boundary, DMat3, DVec3};
    ///
    /// // Extension along z, contraction along x, y neutral.
    /// let frame = DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y);
    /// let space = KraynikReinelt::new(10.0, 8.0, Steady::new(0.5)?)?.oriented(frame)?;
    /// assert_eq!(space.gradient(), DMat3::from_diagonal(DVec3::new(-0.5, 0.0, 0.5)));
    /// # Ok::<(), zimm_boundary::FlowError>(())
    /// ```
    ///
    /// # Errors
    /// If the columns are not orthonormal to 1e-12.
    pub fn oriented(self, frame: DMat3) -> Result<Self, FlowError> {
        let most = 1e-12;
        let products = frame.transpose() * frame - DMat3::IDENTITY;
        let deviation = size(products);
        let orthonormal = deviation <= most;
        if !orthonormal {
            return Err(FlowError::Axes { deviation, most });
        }
        let turned = Recurrence {
            shape: frame * self.recurrence.shape * frame.transpose(),
            axes: frame * self.recurrence.axes,
            ..self.recurrence
        };
        Self::assemble(self.flow, turned, self.history)
    }

    /// Goes on from the present state by another history, in the flow that has the velocity gradient `shape` at unit
    /// rate. That has to be the [`shape`](Self::shape) of this flow: another one, be it of another mixedness or
    /// orientation, would not reproduce the lattice.
    ///
    /// ```
    /// use zimm_boundary::{FlowError, PlanarMixed, Steady};
    /// use zimm_core::Boundary;
    ///
    /// let mut space = PlanarMixed::new(10.0, 10.0, 0.25, Steady::new(1.0)?)?;
    /// space.advance(3.0);
    /// let slower = space.resumed(space.shape(), Steady::new(0.1)?)?;
    /// assert_eq!(slower.cell(), space.cell());
    ///
    /// let other = PlanarMixed::new(10.0, 10.0, 0.5, ())?;
    /// let refused = space.resumed(other.shape(), Steady::new(0.1)?);
    /// assert!(matches!(refused, Err(FlowError::OtherFlow { .. })));
    /// # Ok::<(), FlowError>(())
    /// ```
    ///
    /// # Errors
    /// If the shapes differ by more than 1e-12, or the strain of `next` is not finite now.
    pub fn resumed<N: FlowHistory>(
        &self,
        shape: DMat3,
        next: N,
    ) -> Result<LatticeFlow<F, Then<H, N>>, FlowError> {
        let own = self.shape();
        let same = size(shape - own) <= 1e-12 * size(own);
        if !same {
            return Err(FlowError::OtherFlow {
                found: shape.to_cols_array().to_vec(),
                expected: own.to_cols_array().to_vec(),
            });
        }
        Ok(LatticeFlow {
            flow: self.flow.clone(),
            history: Then::new(self.history.clone(), self.time, next)?,
            recurrence: self.recurrence,
            time: self.time,
            lattice: self.lattice,
        })
    }

    /// The history of the flow.
    pub fn history(&self) -> &H {
        &self.history
    }

    /// The velocity gradient at unit rate.
    pub fn shape(&self) -> DMat3 {
        self.recurrence.shape
    }

    /// The closest that two images ever come, over all times. A cutoff up to half of it fits at every strain.
    pub fn min_image_distance(&self) -> f64 {
        self.recurrence.min_image_distance
    }
}

impl<F, H> Boundary for LatticeFlow<F, H>
where
    F: Clone + Send + Sync,
    H: FlowHistory,
{
    const FLOWS: bool = true;

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

    fn gradient(&self) -> DMat3 {
        self.history.rate(self.time) * self.recurrence.shape
    }

    fn carry(&self, from: f64, to: f64) -> DMat3 {
        exp((self.history.strain(to) - self.history.strain(from)) * self.recurrence.shape)
    }

    fn advance(&mut self, to: f64) -> Remap {
        match Lattice::new(self.recurrence.cell(self.history.strain(to))) {
            Ok(lattice) if to.is_finite() => {
                let carried = self.carry(self.time, to) * self.lattice.basis();
                (self.time, self.lattice) = (to, lattice);
                Remap::between(carried, &lattice)
            }
            // Only a time or strain that is not finite comes here; the next good time finds the old state intact.
            _ => Remap::None,
        }
    }

    fn cell(&self) -> Option<DMat3> {
        Some(self.lattice.basis())
    }
}

impl<F, H> Periodic for LatticeFlow<F, H>
where
    F: Clone + Send + Sync,
    H: FlowHistory,
{
    fn lattice(&self) -> &Lattice {
        &self.lattice
    }
}
