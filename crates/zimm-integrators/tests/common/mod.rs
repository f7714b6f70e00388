//! Little worlds and little forces for the tests of this crate.
#![allow(dead_code, unreachable_pub)]

use zimm_core::{
    AllPairs, Boundary, Central, Clock, DMat3, DVec3, ForceError, ForceField, Frame, IVec3,
    Lattice, ListError, Now, Pair, PairForce, Pairwise, Particles, Periodic, Reads, Remap, System,
    Tally,
};

/// A cube that shear `u_x = rate y` carries; at rest with a rate of zero.
#[derive(Clone, Debug)]
pub struct Cell {
    edge: f64,
    rate: f64,
    time: f64,
    lattice: Lattice,
}

impl Cell {
    pub fn new(edge: f64, rate: f64) -> Self {
        let lattice = Lattice::brick(DVec3::splat(edge)).unwrap();
        Self {
            edge,
            rate,
            time: 0.0,
            lattice,
        }
    }
}

impl Boundary for Cell {
    const FLOWS: bool = true;

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
        DMat3::from_cols(DVec3::ZERO, DVec3::new(self.rate, 0.0, 0.0), DVec3::ZERO)
    }

    fn carry(&self, from: f64, to: f64) -> DMat3 {
        let strain = self.rate * (to - from);
        DMat3::from_cols(DVec3::X, DVec3::new(strain, 1.0, 0.0), DVec3::Z)
    }

    fn advance(&mut self, to: f64) -> Remap {
        let carried = self.carry(self.time, to) * self.lattice.basis();
        let cube = DMat3::from_diagonal(DVec3::splat(self.edge));
        self.lattice = Lattice::new(self.carry(0.0, to) * cube).unwrap();
        self.time = to;
        let rows = (self.lattice.inverse() * carried).transpose();
        Remap::Counts([rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.round().as_ivec3()))
    }

    fn cell(&self) -> Option<DMat3> {
        Some(self.lattice.basis())
    }
}

impl Periodic for Cell {
    fn lattice(&self) -> &Lattice {
        &self.lattice
    }
}

/// Open space in planar extension `u = rate (x, -y, 0)`.
#[derive(Clone, Debug)]
pub struct Extension {
    pub rate: f64,
}

impl Boundary for Extension {
    const FLOWS: bool = true;

    fn min_image(&self, dr: DVec3) -> DVec3 {
        dr
    }

    fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
        (r, IVec3::ZERO)
    }

    fn gradient(&self) -> DMat3 {
        DMat3::from_diagonal(DVec3::new(self.rate, -self.rate, 0.0))
    }

    fn carry(&self, from: f64, to: f64) -> DMat3 {
        let stretch = (self.rate * (to - from)).exp();
        DMat3::from_diagonal(DVec3::new(stretch, stretch.recip(), 1.0))
    }
}

/// F = -k r on every particle.
pub struct Trap {
    pub stiffness: f64,
}

impl<B: Boundary> ForceField<B> for Trap {
    const READS: Reads = Reads::NOTHING;
    const CONSERVES_MOMENTUM: bool = false;

    fn accumulate<T: Tally>(
        &mut self,
        frame: &Frame<'_, B>,
        forces: &mut [DVec3],
        _: &mut T,
    ) -> Result<(), ForceError> {
        for (f, &r) in forces.iter_mut().zip(frame.positions) {
            *f -= self.stiffness * r;
        }
        Ok(())
    }
}

/// F = -zeta c on every particle.
pub struct Drag {
    pub friction: f64,
}

impl<B: Boundary> ForceField<B> for Drag {
    const READS: Reads = Reads {
        velocity: true,
        ..Reads::NOTHING
    };
    const CONSERVES_MOMENTUM: bool = false;

    fn accumulate<T: Tally>(
        &mut self,
        frame: &Frame<'_, B>,
        forces: &mut [DVec3],
        _: &mut T,
    ) -> Result<(), ForceError> {
        for (f, &c) in forces.iter_mut().zip(frame.velocities) {
            *f -= self.friction * c;
        }
        Ok(())
    }
}

/// What goes wrong in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    Error,
    NaN,
    Infinity,
}

/// Fails once when it is asked for the forces of one step; otherwise no force.
pub struct Fails {
    pub fault: Option<Fault>,
    pub step: u64,
    pub particle: usize,
}

impl<B: Boundary> ForceField<B> for Fails {
    const READS: Reads = Reads::NOTHING;
    const CONSERVES_MOMENTUM: bool = true;

    fn accumulate<T: Tally>(
        &mut self,
        frame: &Frame<'_, B>,
        forces: &mut [DVec3],
        _: &mut T,
    ) -> Result<(), ForceError> {
        if frame.now.step != self.step {
            return Ok(());
        }
        match self.fault.take() {
            None => {}
            Some(Fault::Error) => {
                return Err(ForceError::List(ListError::Cutoff {
                    cutoff: 2.0,
                    images: 1.0,
                    most: 0.5,
                }));
            }
            Some(Fault::NaN) => forces[self.particle].y = f64::NAN,
            Some(Fault::Infinity) => forces[self.particle].y = f64::INFINITY,
        }
        Ok(())
    }
}

/// U = k (1 - r^2)^4 for r < 1, smooth enough for every statement on orders.
pub struct Smooth {
    pub stiffness: f64,
}

impl PairForce for Smooth {
    fn cutoff(&self) -> f64 {
        1.0
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, _: &Now) -> Central {
        let depth = (1.0 - pair.r2).max(0.0);
        Central::conservative(8.0 * self.stiffness * depth * depth * depth)
    }

    fn energy(&self, pair: &Pair) -> f64 {
        self.stiffness * (1.0 - pair.r2).max(0.0).powi(4)
    }
}

/// F = -gamma u along the line of centres up to a distance of 1, the same at all distances.
#[derive(Clone, Copy)]
pub struct Rub {
    pub gamma: f64,
}

impl PairForce for Rub {
    const READS: Reads = Reads {
        velocity: true,
        ..Reads::NOTHING
    };

    fn cutoff(&self) -> f64 {
        1.0
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, _: &Now) -> Central {
        Central::dissipative(-self.gamma * pair.rv / pair.r2)
    }
}

/// 27 thermal particles on a grid in a cube of edge 2, strongly overlapping, without total momentum.
pub fn crowd(rate: f64, dt: f64) -> (System<Cell>, Pairwise<Smooth, AllPairs>) {
    let places = (0..27).map(|k| IVec3::new(k % 3, k / 3 % 3, k / 9).as_dvec3() * (2.0 / 3.0));
    let noise = Now::default().noise();
    let mut velocities: Vec<DVec3> = (0..27)
        .map(|k| noise.site(k).normal3(zimm_core::noise::Domain::user(1)))
        .collect();
    let mean = velocities.iter().sum::<DVec3>() / 27.0;
    velocities.iter_mut().for_each(|c| *c -= mean);
    let particles = Particles::new(places.collect()).unwrap();
    let particles = particles
        .with_velocities(velocities)
        .unwrap()
        .counting_images();
    let clock = Clock::new(dt, 1.0, 5).unwrap();
    let system = System::new(Cell::new(2.0, rate), particles, clock);
    (
        system,
        Pairwise::new(Smooth { stiffness: 5.0 }, AllPairs::default()),
    )
}

/// Every bit of the state.
pub fn bits<B: Boundary>(system: &System<B>) -> Vec<u64> {
    let particles = &system.particles;
    let vectors = [
        particles.positions(),
        particles.velocities(),
        particles.forces(),
    ];
    let lengths = vectors.map(|column| column.len() as u64);
    let vectors = vectors
        .into_iter()
        .flatten()
        .flat_map(|v| v.to_array().map(f64::to_bits));
    let images = particles
        .images()
        .iter()
        .flat_map(|n| n.to_array().map(|n| n as u64));
    let cell = system
        .boundary
        .cell()
        .unwrap_or_default()
        .to_cols_array()
        .map(f64::to_bits);
    let now = system.clock.now();
    let clock = [now.time.to_bits(), now.dt.to_bits(), now.step];
    lengths
        .into_iter()
        .chain(vectors)
        .chain(images)
        .chain(cell)
        .chain(clock)
        .collect()
}

pub fn momentum<B>(system: &System<B>) -> DVec3 {
    let particles = &system.particles;
    particles
        .velocities()
        .iter()
        .enumerate()
        .map(|(k, &c)| particles.mass(k) * c)
        .sum()
}
