//! How beads move when forces pull at them, and the square root that makes their noise.

use std::ops::Range;
use zimm_core::{
    Boundary, DMat3, DVec3, Frame, MobilityError, Now, for_each_chunk,
    noise::{Domain, Noise, fill_normal3},
};

/// A mobility operator `M`: beads pulled by forces `F` move at velocities `M F` against the flow.
///
/// `M` is symmetric and positive semidefinite, and its divergence with respect to the positions is zero: it depends
/// on differences of positions alone, as a sum over incompressible flows does.
///
/// The unit type is no motion: the null mobility.
pub trait Mobility<B: Boundary> {
    /// Whether every bead moves by the force on it and no other, at [`alone`](Self::alone) times that force.
    const DIAGONAL: bool = false;

    /// Fixes the configuration; everything below is about the frame that was bound last.
    ///
    /// # Errors
    /// If there is no mobility at this configuration, in this cell, at the accuracy asked for.
    fn bind(&mut self, frame: &Frame<'_, B>) -> Result<(), MobilityError>;

    /// Adds `M F` to `velocities`.
    fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]);

    /// How well the mobility is known: an eigenvalue that is no farther than this below zero is zero. It is zero for
    /// mobilities that are exact to rounding.
    fn accuracy(&self) -> f64 {
        0.0
    }

    /// The mobility of one bead alone, 1 / friction: the part that implicit schemes take for the whole.
    fn alone(&self, place: usize) -> f64;
}

/// A mobility whose 3 x 3 blocks can be asked for: what a factorisation needs.
pub trait Entries<B: Boundary>: Mobility<B> {
    /// The velocity of the bead at place `i` for a force on the bead at place `j`.
    fn entry(&self, i: usize, j: usize) -> DMat3;

    /// Runs of places, one after the other, between which there is no interaction. One run is a full matrix.
    fn runs(&self) -> Vec<Range<usize>>;
}

/// A way to take the square root of a mobility.
///
/// Which root suits which mobility is said by implementations, so that a bad match does not compile. The unit type
/// is no noise, whatever the temperature: the null root.
pub trait Root<B: Boundary, M: Mobility<B>> {
    /// Adds `scale` times a Gaussian vector of covariance `M` to `displacements`, `M` as it was bound last.
    ///
    /// Eigenvalues that are below zero within the [`accuracy`](Mobility::accuracy) of the mobility are taken for zero.
    ///
    /// # Errors
    /// If the root cannot be had to the accuracy asked for, or the mobility has eigenvalues farther below zero.
    /// `displacements` then hold nothing of use.
    fn add(
        &mut self,
        mobility: &mut M,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError>;

    /// The same for another vector, where `M` was not bound since the last [`add`](Self::add), which went well: a root that
    /// keeps what it made of `M` need not make it again.
    ///
    /// # Errors
    /// As [`add`](Self::add).
    fn again(
        &mut self,
        mobility: &mut M,
        white: &White<'_>,
        scale: f64,
        displacements: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        self.add(mobility, white, scale, displacements)
    }
}

impl<B: Boundary> Mobility<B> for () {
    const DIAGONAL: bool = true;

    fn bind(&mut self, _: &Frame<'_, B>) -> Result<(), MobilityError> {
        Ok(())
    }

    fn apply(&mut self, _: &[DVec3], _: &mut [DVec3]) {}

    fn alone(&self, _: usize) -> f64 {
        0.0
    }
}

impl<B: Boundary, M: Mobility<B>> Root<B, M> for () {
    fn add(
        &mut self,
        _: &mut M,
        _: &White<'_>,
        _: f64,
        _: &mut [DVec3],
    ) -> Result<(), MobilityError> {
        Ok(())
    }
}

/// White noise of one step: independent normal numbers of mean zero and variance one, by bead or by wave.
#[derive(Clone, Copy, Debug)]
pub struct White<'a> {
    now: Now,
    noise: Noise,
    ids: &'a [u32],
    attempts: &'a [u32],
}

impl<'a> White<'a> {
    /// The noise of the step that ends at this moment, for the particles of a frame.
    pub fn new<B>(now: Now, frame: &Frame<'a, B>) -> Self {
        Self {
            now,
            noise: now.noise(),
            ids: frame.ids,
            attempts: &[],
        }
    }

    /// The noise of the same particles so many steps later.
    ///
    /// ```
    /// use zimm_brownian::White;
    /// use zimm_core::{Clock, DVec3, Open, Particles, System};
    ///
    /// let particles = Particles::new(vec![DVec3::ZERO])?;
    /// let mut system = System::new(Open, particles, Clock::new(0.01, 1.0, 7)?);
    /// let foreseen = White::new(system.clock.next(), &system.frame()).later(2).bead(0);
    /// system.clock.tick();
    /// system.clock.tick();
    /// assert_eq!(White::new(system.clock.next(), &system.frame()).bead(0), foreseen);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn later(self, steps: u64) -> Self {
        let step = self.now.step.wrapping_add(steps);
        let now = Now { step, ..self.now };
        Self {
            now,
            noise: now.noise(),
            ..self
        }
    }

    /// The noise for schemes that draw again: how many times already, for the bead at each place. Waves, which belong
    /// to no bead, are the same in every attempt.
    pub fn again(self, attempts: &'a [u32]) -> Self {
        Self { attempts, ..self }
    }

    /// Three numbers for the bead at a place.
    #[inline]
    pub fn bead(&self, place: usize) -> DVec3 {
        let mut numbers = [DVec3::ZERO];
        self.beads(place, &mut numbers);
        numbers[0]
    }

    /// The same for a run of beads, at much less cost for each.
    pub fn beads(&self, start: usize, numbers: &mut [DVec3]) {
        fill_normal3(numbers, |k| {
            let place = start + k;
            let identity = self.ids.get(place).copied().unwrap_or(place as u32);
            let attempt = self.attempts.get(place).copied().unwrap_or(0);
            let domain = Domain::BROWNIAN.again(attempt);
            self.noise.site(identity).word(domain)
        });
    }

    /// The numbers of all beads.
    pub(crate) fn fill(&self, column: &mut Vec<DVec3>, len: usize) {
        column.resize(len, DVec3::ZERO);
        for_each_chunk(column, |start, chunk| self.beads(start, chunk));
    }

    /// Three numbers for a wave, whichever numbering of waves the caller has.
    #[inline]
    pub fn wave(&self, index: u32) -> DVec3 {
        self.noise.site(index).normal3(Domain::BROWNIAN_WAVES)
    }
}
