//! The next state in the making. Steppers work on columns of their own and swap them in at the end, so that a step that
//! fails leaves no trace.

use std::mem::swap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use zimm_core::{
    Ahead, Boundary, DMat3, DVec3, ForceField, IVec3, StepError, System, Tally, for_each_chunk,
    for_each_chunk_of,
};

/// The columns that move, in their next state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stage {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) velocities: Vec<DVec3>,
    pub(crate) forces: Vec<DVec3>,
    images: Vec<IVec3>,
    /// Velocities that friction is to see, if a stepper predicts any.
    predicted: Vec<DVec3>,
    /// Forces of the present state, if the system had none.
    first: Vec<DVec3>,
    pub(crate) keeps_momentum: bool,
}

/// A chunk of particles on their way from one evaluation of forces to the next. It stays in the processor's caches
/// while all that moves it is done.
pub(crate) struct Flight<'a> {
    /// Place of the first of them.
    pub(crate) start: usize,
    positions: &'a mut [DVec3],
    pub(crate) velocities: &'a mut [DVec3],
    predicted: &'a mut [DVec3],
    images: &'a mut [IVec3],
    forces: &'a [DVec3],
    masses: &'a [f64],
}

/// A particle that cannot go on, by its place in a flight.
pub(crate) type Lost = usize;

impl Flight<'_> {
    /// Changes velocities by the forces for a while.
    pub(crate) fn kick(&mut self, dt: f64) -> Result<(), Lost> {
        if kick(self.velocities, self.forces, self.masses, dt) {
            return Ok(());
        }
        Err(lost(self.velocities))
    }

    /// Predicts velocities by the forces for another while, in a flow.
    pub(crate) fn predict<B: Boundary>(&mut self, dt: f64, streaming: &Streaming) {
        self.predicted.copy_from_slice(self.velocities);
        kick(self.predicted, self.forces, self.masses, dt);
        streaming.turn::<B>(self.predicted);
    }

    /// Lets particles move without forces for a while.
    pub(crate) fn stream<B: Boundary>(&mut self, streaming: &Streaming) {
        for (r, &c) in self.positions.iter_mut().zip(&*self.velocities) {
            *r = if B::FLOWS {
                streaming.carry * *r + streaming.reach * c
            } else {
                *r + streaming.dt * c
            };
        }
        streaming.turn::<B>(self.velocities);
    }

    /// Puts the particles into the space that is ahead.
    pub(crate) fn settle<B: Boundary>(&mut self, ahead: &Ahead<B>) -> Result<(), Lost> {
        ahead.wrap(self.positions, self.images)
    }
}

/// Steps between two removals of momentum. In between rounding grows by `exp(100 rate dt)`, which is 22 000 at
/// `rate dt = 0.1`.
const REMOVAL_INTERVAL: u64 = 100;

impl Stage {
    /// Copies the present state and lets it fly, chunk by chunk. Velocities that are not there are zero, forces that are
    /// not there are evaluated. With a prediction there is room for one.
    pub(crate) fn depart<B: Boundary, F: ForceField<B>>(
        &mut self,
        system: &System<B>,
        field: &mut F,
        predicts: bool,
        fly: impl Fn(&mut Flight<'_>) -> Result<(), Lost> + Sync + Send,
    ) -> Result<(), StepError> {
        let particles = &system.particles;
        let [r, c] = [particles.positions(), particles.velocities()];
        for column in [&mut self.positions, &mut self.velocities] {
            column.resize(r.len(), DVec3::ZERO);
        }
        self.predicted
            .resize(if predicts { r.len() } else { 0 }, DVec3::ZERO);
        self.images.resize(particles.images().len(), IVec3::ZERO);
        self.meet(system, field)?;
        self.go_on(system, |flight| {
            let here = flight.start..flight.start + flight.positions.len();
            flight.positions.copy_from_slice(&r[here.clone()]);
            match c.get(here.clone()) {
                Some(c) => flight.velocities.copy_from_slice(c),
                None => flight.velocities.fill(DVec3::ZERO),
            }
            if let Some(images) = particles.images().get(here) {
                flight.images.copy_from_slice(images);
            }
            fly(flight)
        })
    }

    /// Evaluates the forces of the present state if the system has none.
    fn meet<B: Boundary, F: ForceField<B>>(
        &mut self,
        system: &System<B>,
        field: &mut F,
    ) -> Result<(), StepError> {
        let particles = &system.particles;
        // Needed once: its room goes, too.
        self.first = Vec::new();
        if particles.forces().len() == particles.len() {
            return Ok(());
        }
        self.first.resize(particles.len(), DVec3::ZERO);
        let mut frame = system.frame();
        if frame.velocities.is_empty() {
            self.velocities.fill(DVec3::ZERO);
            frame.velocities = &self.velocities;
        }
        let step = system.clock.next().step;
        field
            .accumulate(&frame, &mut self.first, &mut ())
            .map_err(|source| StepError::Force { step, source })
    }

    /// Lets what has departed fly on, chunk by chunk.
    pub(crate) fn go_on<B: Boundary>(
        &mut self,
        system: &System<B>,
        fly: impl Fn(&mut Flight<'_>) -> Result<(), Lost> + Sync + Send,
    ) -> Result<(), StepError> {
        let masses = system.particles.masses();
        let forces = match &self.first[..] {
            [] => system.particles.forces(),
            first => first,
        };
        let columns = (
            (&mut self.positions[..], &mut self.velocities[..]),
            (&mut self.predicted[..], &mut self.images[..]),
        );
        let first_lost = AtomicUsize::new(usize::MAX);
        for_each_chunk_of(columns, |start, columns| {
            let ((positions, velocities), (predicted, images)) = columns;
            let end = start + positions.len();
            let mut flight = Flight {
                start,
                positions,
                velocities,
                predicted,
                images,
                forces: &forces[start..end],
                masses: masses.get(start..end).unwrap_or_default(),
            };
            if let Err(lost) = fly(&mut flight) {
                first_lost.fetch_min(start + lost, Relaxed);
            }
        });
        match first_lost.into_inner() {
            usize::MAX => Ok(()),
            particle => Err(StepError::NotFinite {
                step: system.clock.next().step,
                particle,
                force: forces[particle].to_array(),
            }),
        }
    }

    /// Changes velocities by the new forces for a while.
    pub(crate) fn kick<B: Boundary>(
        &mut self,
        system: &System<B>,
        dt: f64,
    ) -> Result<(), StepError> {
        let (forces, masses) = (&self.forces, system.particles.masses());
        let all_moderate = AtomicBool::new(true);
        for_each_chunk(&mut self.velocities, |start, chunk| {
            let end = start + chunk.len();
            let masses = masses.get(start..end).unwrap_or_default();
            if !kick(chunk, &forces[start..end], masses, dt) {
                all_moderate.store(false, Relaxed);
            }
        });
        if all_moderate.into_inner() {
            Ok(())
        } else {
            Err(self.not_finite(system))
        }
    }

    /// Evaluates the forces of the new state. Friction sees the predicted velocities, if there are any.
    pub(crate) fn evaluate<B: Boundary, F: ForceField<B>, T: Tally>(
        &mut self,
        system: &System<B>,
        boundary: &B,
        field: &mut F,
        tally: &mut T,
    ) -> Result<(), StepError> {
        let mut frame = system.frame();
        frame.now = system.clock.next();
        frame.boundary = boundary;
        frame.positions = &self.positions;
        frame.velocities = match self.predicted[..] {
            [] => &self.velocities,
            ref predicted => predicted,
        };
        frame.images = &self.images;
        self.forces.resize(frame.len(), DVec3::ZERO);
        for_each_chunk(&mut self.forces, |_, chunk| chunk.fill(DVec3::ZERO));
        let step = frame.now.step;
        field
            .accumulate(&frame, &mut self.forces, tally)
            .map_err(|source| StepError::Force { step, source })
    }

    /// Takes the velocity of the centre of mass off all velocities every [`REMOVAL_INTERVAL`] steps, if the forces of
    /// the field sum to zero and nobody wants the momentum kept.
    pub(crate) fn rest<B: Boundary, F: ForceField<B>>(&mut self, system: &System<B>) {
        let is_due = system.clock.next().step % REMOVAL_INTERVAL == 1;
        if !F::CONSERVES_MOMENTUM || self.keeps_momentum || !is_due {
            return;
        }
        let (mut momentum, mut total) = (DVec3::ZERO, 0.0);
        for (k, &c) in self.velocities.iter().enumerate() {
            let mass = system.particles.mass(k);
            momentum += mass * c;
            total += mass;
        }
        let drift = momentum / total;
        for c in &mut self.velocities {
            *c -= drift;
        }
    }

    /// An error if a velocity is not finite or too large.
    pub(crate) fn check_velocities<B: Boundary>(
        &self,
        system: &System<B>,
    ) -> Result<(), StepError> {
        if self.velocities.iter().all(|&c| is_moderate(c)) {
            Ok(())
        } else {
            Err(self.not_finite(system))
        }
    }

    /// Makes the stage the system's state.
    pub(crate) fn commit<B: Boundary>(&mut self, system: &mut System<B>, boundary: B) {
        let columns = system.particles.columns_mut();
        swap(columns.positions, &mut self.positions);
        swap(columns.velocities, &mut self.velocities);
        swap(columns.forces, &mut self.forces);
        swap(columns.images, &mut self.images);
        system.boundary = boundary;
        system.clock.tick();
    }

    /// What is wrong with the first velocity that is not moderate.
    fn not_finite<B: Boundary>(&self, system: &System<B>) -> StepError {
        let particle = lost(&self.velocities);
        StepError::NotFinite {
            step: system.clock.next().step,
            particle,
            force: self.forces[particle].to_array(),
        }
    }
}

/// The first velocity that is not moderate.
fn lost(velocities: &[DVec3]) -> Lost {
    let first = velocities.iter().position(|&c| !is_moderate(c));
    first.unwrap_or(0)
}

/// Adds `dt` times acceleration to velocities; answers whether they are all moderate.
fn kick(velocities: &mut [DVec3], forces: &[DVec3], masses: &[f64], dt: f64) -> bool {
    let mut moderate = true;
    if masses.is_empty() {
        for (c, &f) in velocities.iter_mut().zip(forces) {
            *c += dt * f;
            moderate &= is_moderate(*c);
        }
    } else {
        for ((c, &f), &m) in velocities.iter_mut().zip(forces).zip(masses) {
            *c += (dt / m) * f;
            moderate &= is_moderate(*c);
        }
    }
    moderate
}

/// The solution of dr/dt = c + kappa r, dc/dt = -kappa c over an interval: `r' = carry r + reach c`, `c' = turn c`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Streaming {
    dt: f64,
    carry: DMat3,
    reach: DMat3,
    turn: DMat3,
}

impl Streaming {
    /// The streaming between two times that are `dt` apart; `dt` is given as well since their difference is rounded.
    ///
    /// With E(t, s) the deformation from s to t, turn = E(from, to) and reach is the integral of E(to, s) E(from, s)
    /// over s. In four points of Gauss and Legendre that is exact to rounding while |kappa| dt < 0.05, and for flows
    /// that change in time as well.
    pub(crate) fn new<B: Boundary>(boundary: &B, from: f64, to: f64, dt: f64) -> Self {
        const HALF_POINTS: [(f64, f64); 2] = [
            (0.169_990_521_792_428_13, 0.326_072_577_431_273_07),
            (0.430_568_155_797_026_3, 0.173_927_422_568_726_93),
        ];
        let mut streaming = Self {
            dt,
            carry: DMat3::IDENTITY,
            reach: DMat3::ZERO,
            turn: DMat3::IDENTITY,
        };
        if B::FLOWS {
            streaming.carry = boundary.carry(from, to);
            streaming.turn = boundary.carry(to, from);
            for (offset, weight) in HALF_POINTS {
                for share in [0.5 - offset, 0.5 + offset] {
                    let s = from + share * (to - from);
                    streaming.reach +=
                        boundary.carry(s, to) * boundary.carry(s, from) * (weight * dt);
                }
            }
        }
        streaming
    }

    /// Turns peculiar velocities by the flow.
    fn turn<B: Boundary>(&self, velocities: &mut [DVec3]) {
        if B::FLOWS {
            for c in velocities {
                *c = self.turn * *c;
            }
        }
    }
}

/// Whether the square of a length is finite, and with it every sum that a scheme makes of such vectors.
#[inline(always)]
fn is_moderate(v: DVec3) -> bool {
    v.length_squared() < f64::INFINITY
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Open space in a flow with the gradient `s'(t) M`, where `M M = p` and `p M = M`; `p` is 0 in shear.
    #[derive(Clone)]
    struct Flow {
        strain: fn(f64) -> f64,
        shape: DMat3,
        p: DMat3,
    }

    impl Boundary for Flow {
        const FLOWS: bool = true;

        fn min_image(&self, dr: DVec3) -> DVec3 {
            dr
        }

        fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
            (r, IVec3::ZERO)
        }

        fn carry(&self, from: f64, to: f64) -> DMat3 {
            let strain = (self.strain)(to) - (self.strain)(from);
            if self.p == DMat3::ZERO {
                DMat3::IDENTITY + strain * self.shape
            } else {
                DMat3::IDENTITY
                    + (libm::cosh(strain) - 1.0) * self.p
                    + libm::sinh(strain) * self.shape
            }
        }
    }

    fn steady(t: f64) -> f64 {
        t
    }

    fn shear(strain: fn(f64) -> f64) -> Flow {
        let shape = DMat3::from_cols(DVec3::ZERO, DVec3::X, DVec3::ZERO);
        let p = DMat3::ZERO;
        Flow { strain, shape, p }
    }

    fn extension(strain: fn(f64) -> f64) -> Flow {
        let shape = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 0.0));
        let p = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0));
        Flow { strain, shape, p }
    }

    fn mixed(strain: fn(f64) -> f64) -> Flow {
        let shape = DMat3::from_cols(DVec3::X, DVec3::new(3.0, -1.0, 0.0), DVec3::ZERO);
        Flow {
            shape,
            ..extension(strain)
        }
    }

    /// reach / dt = the mean of exp(K (1 - 2 s)) = 1 + (sinh(h) / h - 1) p, with p the projector on the plane.
    #[test]
    fn limit_reach_is_the_mean_deformation() {
        for h in [1e-6, 1e-3, 0.01, 0.05, 0.1] {
            for flow in [shear(steady), extension(steady), mixed(steady)] {
                let reach = Streaming::new(&flow, 3.0, 3.0 + h, h).reach / h;
                let expected = DMat3::IDENTITY + (libm::sinh(h) / h - 1.0) * flow.p;
                let error = (reach - expected).to_cols_array().map(f64::abs);
                let worst = error.into_iter().fold(0.0, f64::max);
                let bound = if h > 0.05 { 3e-15 } else { 1e-15 };
                assert!(worst < bound, "off by {worst} at {h}");
            }
        }
    }

    /// 100 steps of free flight from r and c; answers position and velocity in the laboratory at time 2.
    fn fly(flow: &Flow, r: DVec3, c: DVec3) -> (DVec3, DVec3) {
        let (mut positions, mut velocities) = ([r], [c]);
        let mut flight = Flight {
            start: 0,
            positions: &mut positions,
            velocities: &mut velocities,
            predicted: &mut [],
            images: &mut [],
            forces: &[],
            masses: &[],
        };
        for n in 0..100 {
            let [from, to] = [n, n + 1].map(|n| 0.02 * f64::from(n));
            flight.stream::<Flow>(&Streaming::new(flow, from, to, 0.02));
        }
        (positions[0], velocities[0])
    }

    const START: (DVec3, DVec3) = (DVec3::new(0.3, -1.2, 0.5), DVec3::new(-0.7, 0.4, 1.1));

    /// In steady shear the laboratory trajectory is the straight line r + (c + kappa r) t. In the other flows, where
    /// kappa kappa is p, it is r cosh t + (c + kappa r) sinh t in the plane.
    #[test]
    fn limit_free_flight_is_exact() {
        let ((r, c), t) = (START, 2.0_f64);
        for flow in [shear(steady), extension(steady), mixed(steady)] {
            let (found, peculiar) = fly(&flow, r, c);
            let v = c + flow.shape * r;
            let (there, speed) = if flow.p == DMat3::ZERO {
                (r + t * v, v)
            } else {
                let (ahead, back) = (t.cosh() * r + t.sinh() * v, t.sinh() * r + t.cosh() * v);
                (
                    DVec3::new(ahead.x, ahead.y, r.z + t * c.z),
                    DVec3::new(back.x, back.y, c.z),
                )
            };
            assert!((found - there).length() < 1e-13, "{found} against {there}");
            assert!((peculiar + flow.shape * found - speed).length() < 1e-13);
        }
    }

    /// Oscillating shear s = sin t: with y = y0 + c_y t and c_x = c_x0 - s c_y,
    /// x = x0 + c_x0 t + s (y0 + c_y t) - 2 c_y (1 - cos t).
    #[test]
    fn limit_free_flight_is_exact_in_flows_that_change() {
        let ((r, c), t) = (START, 2.0_f64);
        let (found, peculiar) = fly(&shear(f64::sin), r, c);
        let y = r.y + c.y * t;
        let x = r.x + c.x * t + t.sin() * y - 2.0 * c.y * (1.0 - t.cos());
        assert!((found - DVec3::new(x, y, r.z + c.z * t)).length() < 1e-13);
        assert!((peculiar - DVec3::new(c.x - t.sin() * c.y, c.y, c.z)).length() < 1e-13);
    }
}
