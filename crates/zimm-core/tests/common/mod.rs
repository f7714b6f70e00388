//! A periodic cell carried by any constant velocity gradient, as a user would write it.

use zimm_core::{Boundary, DMat3, DVec3, IVec3, Lattice, Periodic, Remap};

/// The cell exp(kappa t) H0 in a reduced basis; with `FLOWS` false it is at rest.
#[derive(Clone, Debug)]
pub(crate) struct Cell<const FLOWS: bool> {
    start: DMat3,
    gradient: DMat3,
    time: f64,
    lattice: Lattice,
}

impl Cell<false> {
    pub(crate) fn at_rest(start: DMat3) -> Self {
        Self::new(start, DMat3::ZERO)
    }
}

impl Cell<true> {
    #[allow(dead_code)]
    pub(crate) fn flowing(start: DMat3, gradient: DMat3) -> Self {
        Self::new(start, gradient)
    }
}

impl<const FLOWS: bool> Cell<FLOWS> {
    fn new(start: DMat3, gradient: DMat3) -> Self {
        let lattice = Lattice::new(start).unwrap();
        Self {
            start,
            gradient,
            time: 0.0,
            lattice,
        }
    }
}

impl<const FLOWS: bool> Boundary for Cell<FLOWS> {
    const FLOWS: bool = FLOWS;

    fn min_image(&self, dr: DVec3) -> DVec3 {
        self.lattice.nearest(dr)
    }

    fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
        self.lattice.fold(r)
    }

    fn reach(&self) -> f64 {
        0.5 * self.lattice.shortest()
    }

    fn gradient(&self) -> DMat3 {
        self.gradient
    }

    fn carry(&self, from: f64, to: f64) -> DMat3 {
        exponential(self.gradient * (to - from))
    }

    fn advance(&mut self, to: f64) -> Remap {
        let carried = self.carry(self.time, to) * self.lattice.basis();
        self.time = to;
        self.lattice = Lattice::new(self.carry(0.0, to) * self.start).unwrap();
        Remap::between(carried, &self.lattice)
    }

    fn cell(&self) -> Option<DMat3> {
        Some(self.lattice.basis())
    }
}

impl<const FLOWS: bool> Periodic for Cell<FLOWS> {
    fn lattice(&self) -> &Lattice {
        &self.lattice
    }
}

/// Scaling and squaring of the Taylor series.
fn exponential(a: DMat3) -> DMat3 {
    const HALVINGS: i32 = 4;
    let a = a * 0.5_f64.powi(HALVINGS);
    let mut term = DMat3::IDENTITY;
    let mut sum = DMat3::IDENTITY;
    for n in 1..=24 {
        term = term * a * (1.0 / f64::from(n));
        sum += term;
    }
    (0..HALVINGS).fold(sum, |root, _| root * root)
}
