//! The mobility of Rotne, Prager and Yamakawa in a periodic cell, by direct sums.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is an index into several arrays at once"
)]

mod tile;
mod waves;

use crate::lattice_sum::{Near, Plan};
use crate::rpy::finite;
use crate::{Entries, Mobility};
use std::f64::consts::PI;
use std::ops::Range;
use waves::Waves;
use zimm_core::{DMat3, DVec3, Frame, Lattice, MobilityError, ParameterError, Periodic};

/// Beads and all their images in a cell of any shape: the mobility of [`Rpy`](crate::Rpy) summed over the lattice, in a
/// solvent that is at rest, or in the flow of the cell, on average.
///
/// The sum goes over pairs and over waves (Ewald 1921; for this mobility Beenakker 1986), split as in
/// [`Mesh`](crate::Mesh). It is positive semidefinite, also for beads that overlap each other or themselves across the
/// cell. Wave vectors are those of the lattice at the moment, whatever flow has done to it.
///
/// `error` is the one parameter of the method: the root-mean-square error of a velocity, for independent forces,
/// relative to the velocity of one bead pulled alone in the cell. How much of the sum goes to pairs, and how far both
/// parts go, is chosen for the least work that delivers it. That makes a product cost of the order N^(3/2).
///
/// Pairs are found and evaluated once for each configuration and kept, which takes memory of the order N^(3/2), about
/// 2 kB for each of 1 000 beads at an error of 1e-3. [`without_storage`](Self::without_storage) looks them up in every
/// product.
///
/// A cell has a mobility of its own: that of a single bead, alone with its images, is
/// 1 - 2.837 a / L + 4.19 (a / L)^3 in units of 1 / friction in a cube (Hasimoto 1959), and may be above 1 along the
/// axis of a long cell.
///
/// ```
/// use zimm_boundary::PeriodicBox;
/// use zimm_brownian::{Entries, Ewald, Mobility};
/// use zimm_core::{Clock, DVec3, Particles, System};
///
/// let system = System::new(PeriodicBox::cubic(10.0)?, Particles::new(vec![DVec3::ZERO])?, Clock::new(0.01, 1.0, 1)?);
/// let mut mobility = Ewald::new(1.0, 0.5, 1e-9)?;
/// mobility.bind(&system.frame())?;
/// let mut velocity = [DVec3::ZERO];
/// Mobility::<PeriodicBox>::apply(&mut mobility, &[DVec3::X], &mut velocity);
/// assert!((velocity[0].x - 0.858_658_724_8).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Open space has no lattice, so this does not compile ([`Rpy`](crate::Rpy) serves there):
///
/// ```compile_fail,E0277
/// use zimm_brownian::{Ewald, Mobility};
/// use zimm_core::{Clock, DVec3, Open, Particles, System};
///
/// let system = System::new(Open, Particles::new(vec![DVec3::ZERO])?, Clock::new(0.01, 1.0, 1)?);
/// Ewald::new(1.0, 0.5, 1e-3)?.bind(&system.frame())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Ewald {
    mobility: f64,
    radius: f64,
    error: f64,
    /// Time of a pair in a product, in times of a wave.
    pair: f64,
    lattice: Option<Lattice>,
    positions: Vec<DVec3>,
    near: Near,
    waves: Waves,
    sums: Vec<DVec3>,
}

impl Ewald {
    /// Beads of a friction and a radius, summed to a relative error.
    ///
    /// Binding is an error if the radius is more than three times the shortest lattice vector: of a mobility that is
    /// averaged over so many images nothing is left.
    ///
    /// # Errors
    /// If `friction` or `radius` is not finite and above zero, or `error` is not between 1e-13 and 0.1.
    pub fn new(friction: f64, radius: f64, error: f64) -> Result<Self, ParameterError> {
        /// Measured, with a search for pairs every ten products.
        const KEPT: f64 = 8.0;
        if !(1e-13..=0.1).contains(&error) {
            let allowed = "from 1e-13, the rounding of double precision, to 0.1";
            return Err(ParameterError::new("relative error", error, allowed));
        }
        Ok(Self {
            mobility: ParameterError::positive("friction", friction)?.recip(),
            radius: ParameterError::positive("radius", radius)?,
            error,
            pair: KEPT,
            lattice: None,
            positions: Vec::new(),
            near: Near::new(true),
            waves: Waves::new(),
            sums: Vec::new(),
        })
    }

    /// Looks pairs up in every product instead of keeping them: memory of the order N, and products that take about
    /// twice as long.
    pub fn without_storage(mut self) -> Self {
        /// Measured.
        const LOOKED_UP: f64 = 32.0;
        self.pair = LOOKED_UP;
        self.near = Near::new(false);
        self
    }

    /// The split of the least cost. A product takes half of the sphere of pairs for each bead, and half of that of
    /// waves: `pair` N 2 pi / 3 range^3 and V (sharpness / range)^3 / 12 pi^2.
    fn plan(&self, lattice: &Lattice, beads: usize) -> Result<Plan, MobilityError> {
        let balance = beads as f64 / (8.0 * PI.powi(3) * self.pair);
        let balance = libm::sqrt(libm::cbrt(balance));
        Plan::new(lattice, beads, self.radius, self.error, balance, false)
    }

    fn bind_with(&mut self, plan: Plan, lattice: &Lattice, positions: &[DVec3]) {
        self.lattice = Some(*lattice);
        positions.clone_into(&mut self.positions);
        self.near.bind(plan, lattice, positions);
        self.waves.bind(lattice, positions, self.near.kernel());
    }

    fn block(&self, i: usize, j: usize) -> DMat3 {
        let Some(lattice) = &self.lattice else {
            return DMat3::ZERO;
        };
        let r = self.positions[i] - self.positions[j];
        self.near.entry(lattice, r, i == j) + self.waves.entry(i, j)
    }
}

impl<B: Periodic> Mobility<B> for Ewald {
    fn bind(&mut self, frame: &Frame<'_, B>) -> Result<(), MobilityError> {
        finite("position", frame.positions)?;
        let lattice = frame.boundary.lattice();
        let plan = self.plan(lattice, frame.len())?;
        self.bind_with(plan, lattice, frame.positions);
        Ok(())
    }

    fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        self.sums.clear();
        self.sums.resize(forces.len(), DVec3::ZERO);
        self.near.apply(forces, &mut self.sums);
        self.waves.apply(forces, &mut self.sums);
        for (velocity, &sum) in velocities.iter_mut().zip(&self.sums) {
            *velocity += self.mobility * sum;
        }
    }

    fn accuracy(&self) -> f64 {
        self.mobility * self.error
    }

    fn alone(&self, _: usize) -> f64 {
        self.mobility
    }
}

impl<B: Periodic> Entries<B> for Ewald {
    fn entry(&self, i: usize, j: usize) -> DMat3 {
        self.mobility * self.block(i, j)
    }

    fn runs(&self) -> Vec<Range<usize>> {
        let beads = self.positions.len();
        std::iter::once(0..beads)
            .filter(|run| !run.is_empty())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector(limit: f64) -> impl Strategy<Value = DVec3> {
        [-limit..limit, -limit..limit, -limit..limit].prop_map(DVec3::from_array)
    }

    /// Cells from cubes to flat, long and oblique ones.
    fn lattice() -> impl Strategy<Value = Lattice> {
        (vector(3.0), vector(3.0), vector(3.0))
            .prop_map(|(a, b, c)| DMat3::from_cols(a, b, c))
            .prop_filter("spans a volume", |h| h.determinant().abs() > 1.0)
            .prop_filter_map("is a lattice", |h| Lattice::new(h).ok())
    }

    fn product(mobility: &mut Ewald, forces: &[DVec3]) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; forces.len()];
        mobility.near.apply(forces, &mut sums);
        mobility.waves.apply(forces, &mut sums);
        sums
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 40, rng_seed: prop::test_runner::RngSeed::Fixed(7), ..Default::default() })]

        /// Ranges up to twice as long give the same entries and products, to 20 times the error asked for,
        /// for beads of a tenth of the shortest lattice vector to all of it.
        #[test]
        fn law_the_sum_does_not_depend_on_its_split(
            lattice in lattice(),
            radius in 0.1..1.0_f64,
            beads in prop::collection::vec((vector(3.0), vector(1.0)), 1..6),
            exponent in 1..5_i32,
        ) {
            let error = 1e-3_f64.powi(exponent).max(1e-13);
            let radius = radius * lattice.shortest();
            let (positions, forces): (Vec<_>, Vec<_>) = beads.into_iter().unzip();
            let mut mobility = Ewald::new(1.0, radius, error).unwrap();
            let best = mobility.plan(&lattice, positions.len()).unwrap();
            let mut results = Vec::new();
            for factor in [1.0, 1.4, 2.0] {
                let plan = Plan { range: factor * best.range, ..best };
                mobility.bind_with(plan, &lattice, &positions);
                results.push((product(&mut mobility, &forces), mobility.block(0, positions.len() - 1)));
            }
            for (velocities, entry) in &results[1..] {
                for (a, b) in velocities.iter().zip(&results[0].0) {
                    prop_assert!((*a - *b).length() < 20.0 * error, "{a} {b} {error}");
                }
                let apart = *entry - results[0].1;
                prop_assert!(apart.to_cols_array().iter().all(|x| x.abs() < 20.0 * error));
            }
        }
    }
}
