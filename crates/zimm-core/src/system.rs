//! The system, its clock, and the read-only frame that forces and observables see.

use crate::{Boundary, ParameterError, Particles, Remap, for_each_chunk_of, noise::Noise};
use glam::{DMat3, DVec3, IVec3};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The one copy of time step, temperature, seed and step number.
///
/// Time is counted in steps from the last change of the time step, so that it never accumulates rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    dt: f64,
    kt: f64,
    seed: u64,
    step: u64,
    epoch_step: u64,
    epoch_time: f64,
}

impl Clock {
    /// A clock at time zero that advances by `dt`; `kt` is the thermal energy of everything that makes noise.
    ///
    /// # Errors
    /// If `dt` is not above zero or `kt` is below it.
    pub fn new(dt: f64, kt: f64, seed: u64) -> Result<Self, ParameterError> {
        Self::restored(dt, kt, seed, 0, 0, 0.0)
    }

    /// A clock that shows a moment and goes on from there.
    ///
    /// ```
    /// use zimm_core::{Clock, Now};
    ///
    /// let mut clock = Clock::showing(Now { time: 2.5, dt: 0.1, step: 7, ..Now::default() })?;
    /// clock.tick();
    /// assert_eq!((clock.now().step, clock.now().time), (8, 2.6));
    /// # Ok::<(), zimm_core::ParameterError>(())
    /// ```
    ///
    /// # Errors
    /// If the moment has a `dt` that is not above zero, a `kt` below it, a time that is not finite, or a step above
    /// 2^53.
    pub fn showing(now: Now) -> Result<Self, ParameterError> {
        Self::restored(now.dt, now.kt, now.seed, now.step, now.step, now.time)
    }

    /// A clock in any state.
    pub(crate) fn restored(
        dt: f64,
        kt: f64,
        seed: u64,
        step: u64,
        epoch_step: u64,
        epoch_time: f64,
    ) -> Result<Self, ParameterError> {
        const MOST: u64 = 1 << 53;
        if step > MOST {
            return Err(ParameterError::new("step", step as f64, "at most 2^53"));
        }
        if epoch_step > step {
            let name = "step of the last change of dt";
            return Err(ParameterError::new(
                name,
                epoch_step as f64,
                "at most the step",
            ));
        }
        let clock = Self {
            dt: ParameterError::positive("dt", dt)?,
            kt: ParameterError::non_negative("kt", kt)?,
            seed,
            step,
            epoch_step,
            epoch_time,
        };
        ParameterError::finite("time", clock.now().time)?;
        Ok(clock)
    }

    /// Goes on with another time step.
    ///
    /// # Errors
    /// If `dt` is not above zero.
    pub fn set_dt(&mut self, dt: f64) -> Result<(), ParameterError> {
        let dt = ParameterError::positive("dt", dt)?;
        (self.epoch_step, self.epoch_time) = (self.step, self.now().time);
        self.dt = dt;
        Ok(())
    }

    /// This moment.
    pub fn now(&self) -> Now {
        self.at(self.step)
    }

    /// The moment one step ahead.
    pub fn next(&self) -> Now {
        self.at(self.step + 1)
    }

    /// One step forward.
    pub fn tick(&mut self) {
        self.step += 1;
    }

    pub(crate) fn epoch(&self) -> (u64, f64) {
        (self.epoch_step, self.epoch_time)
    }

    fn at(&self, step: u64) -> Now {
        Now {
            time: self.epoch_time + (step - self.epoch_step) as f64 * self.dt,
            dt: self.dt,
            kt: self.kt,
            seed: self.seed,
            step,
        }
    }
}

/// A moment, as laws see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Now {
    /// Time.
    pub time: f64,
    /// Time step.
    pub dt: f64,
    /// Thermal energy.
    pub kt: f64,
    /// Seed of the run.
    pub seed: u64,
    /// Number of the step.
    pub step: u64,
}

impl Default for Now {
    /// Time zero, `dt` = `kt` = 1, seed 0: for trying a law out.
    fn default() -> Self {
        Self {
            time: 0.0,
            dt: 1.0,
            kt: 1.0,
            seed: 0,
            step: 0,
        }
    }
}

impl Now {
    /// The noise of this step.
    pub fn noise(&self) -> Noise {
        Noise::new(self.seed, self.step)
    }
}

/// Particles in a space at a time.
#[derive(Clone, Debug)]
pub struct System<B> {
    /// The space and its flow.
    pub boundary: B,
    /// The particles.
    pub particles: Particles,
    /// Time, time step, temperature, seed.
    pub clock: Clock,
}

impl<B: Boundary> System<B> {
    /// Puts the boundary to the clock's time and every particle into the primary cell.
    pub fn new(mut boundary: B, mut particles: Particles, clock: Clock) -> Self {
        boundary.advance(clock.now().time);
        for k in 0..particles.len() {
            let (folded, count) = boundary.wrap(particles.positions[k]);
            particles.positions[k] = folded;
            if let Some(image) = particles.images.get_mut(k) {
                *image += count;
            }
        }
        Self {
            boundary,
            particles,
            clock,
        }
    }

    /// The space one step ahead. For steppers, which work on copies of the columns and change the system only when a
    /// step is known to be good.
    pub fn ahead(&self) -> Ahead<B> {
        let mut boundary = self.boundary.clone();
        let remap = boundary.advance(self.clock.next().time);
        Ahead { boundary, remap }
    }

    /// The space one step ahead, with new positions wrapped into it and image counts brought along.
    ///
    /// # Errors
    /// The first particle that [`Ahead::wrap`] refuses.
    pub fn settle(&self, positions: &mut [DVec3], images: &mut [IVec3]) -> Result<B, usize> {
        let ahead = self.ahead();
        let first = AtomicUsize::new(usize::MAX);
        for_each_chunk_of((positions, images), |start, (positions, images)| {
            if let Err(k) = ahead.wrap(positions, images) {
                first.fetch_min(start + k, Relaxed);
            }
        });
        match first.into_inner() {
            usize::MAX => Ok(ahead.boundary),
            first => Err(first),
        }
    }

    /// The system as forces and observables see it.
    pub fn frame(&self) -> Frame<'_, B> {
        Frame {
            now: self.clock.now(),
            boundary: &self.boundary,
            positions: &self.particles.positions,
            velocities: &self.particles.velocities,
            masses: &self.particles.masses,
            species: &self.particles.species,
            images: &self.particles.images,
            ids: &self.particles.ids,
            slots: &self.particles.slots,
        }
    }
}

/// The space one step ahead, for positions to be put into.
#[derive(Clone, Debug)]
pub struct Ahead<B> {
    /// The space then.
    pub boundary: B,
    remap: Remap,
}

impl<B: Boundary> Ahead<B> {
    /// Wraps new positions and brings image counts, if there are any, along.
    ///
    /// # Errors
    /// The index of a position that is not finite, or 2^26 times farther away than the reach of the cell: half of the
    /// digits would be lost in wrapping. In open space, where nothing is wrapped, every position fits whose square is
    /// finite.
    #[inline]
    pub fn wrap(&self, positions: &mut [DVec3], images: &mut [IVec3]) -> Result<(), usize> {
        const FARTHEST: f64 = 67_108_864.0;
        let farthest = FARTHEST * self.boundary.reach();
        let fits = |r: DVec3| r.length_squared() < farthest * farthest;
        let all_fit = positions.iter().fold(true, |all, &r| all & fits(r));
        if !all_fit {
            return Err(positions.iter().position(|&r| !fits(r)).unwrap_or(0));
        }
        for (image, &r) in images.iter_mut().zip(&*positions) {
            *image = self
                .remap
                .apply(*image)
                .wrapping_add(self.boundary.wrap(r).1);
        }
        for r in positions {
            *r = self.boundary.wrap(*r).0;
        }
        Ok(())
    }
}

/// A read-only view of the system at one moment. Columns that the scene does not use are empty.
#[derive(Debug)]
pub struct Frame<'a, B> {
    /// The moment.
    pub now: Now,
    /// The space at this moment.
    pub boundary: &'a B,
    /// Positions in the primary cell.
    pub positions: &'a [DVec3],
    /// Peculiar velocities; in a force, those that friction is to see.
    pub velocities: &'a [DVec3],
    /// Masses, or nothing if all are 1.
    pub masses: &'a [f64],
    /// Species, or nothing if all are 0.
    pub species: &'a [u8],
    /// Image counts, or nothing.
    pub images: &'a [IVec3],
    /// Identities, or nothing if each is its place.
    pub ids: &'a [u32],
    slots: &'a [u32],
}

impl<B> Clone for Frame<'_, B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<B> Copy for Frame<'_, B> {}

impl<B: Boundary> Frame<'_, B> {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Mass of the particle at a place.
    #[inline]
    pub fn mass(&self, place: usize) -> f64 {
        self.masses.get(place).copied().unwrap_or(1.0)
    }

    /// Species of the particle at a place.
    #[inline]
    pub fn species(&self, place: usize) -> u8 {
        self.species.get(place).copied().unwrap_or(0)
    }

    /// Identity of the particle at a place.
    #[inline]
    pub fn id(&self, place: usize) -> u32 {
        self.ids.get(place).copied().unwrap_or(place as u32)
    }

    /// Place of the particle of an identity, if it exists.
    #[inline]
    pub fn place(&self, id: u32) -> Option<usize> {
        if self.ids.is_empty() {
            ((id as usize) < self.len()).then_some(id as usize)
        } else {
            self.slots.get(id as usize).map(|&place| place as usize)
        }
    }

    /// The position that a particle would have had without wrapping, if images are counted. In a flow this is the
    /// image of the particle in the lattice as it is now.
    pub fn unwrapped(&self, place: usize) -> Option<DVec3> {
        let count = self.images.get(place)?.as_dvec3();
        let cell = self.boundary.cell().unwrap_or(DMat3::ZERO);
        Some(self.positions[place] + cell * count)
    }
}
