//! Cells and particles that the tests share.
#![allow(dead_code, unreachable_pub)]

use proptest::prelude::*;
use zimm_core::{
    Boundary, Clock, DMat3, DVec3, IVec3, Lattice, Molecules, Now, Particles, Periodic, System,
};

/// A lattice that stands still, whatever its flow.
#[derive(Clone, Debug)]
pub struct Cell<const FLOWS: bool> {
    pub lattice: Lattice,
    pub gradient: DMat3,
}

impl<const FLOWS: bool> Boundary for Cell<FLOWS> {
    const FLOWS: bool = FLOWS;

    fn min_image(&self, dr: DVec3) -> DVec3 {
        self.lattice.nearest(dr)
    }

    fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
        self.lattice.fold(r)
    }

    fn gradient(&self) -> DMat3 {
        if FLOWS { self.gradient } else { DMat3::ZERO }
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

/// Any numbers whose products are finite: ordinary ones, tiny ones, huge ones, both zeros.
pub fn number() -> impl Strategy<Value = f64> {
    use prop::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    let any = POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO;
    prop_oneof![
        -10.0..10.0,
        any.prop_filter("products overflow", |x| x.abs() < 1e100)
    ]
}

pub fn vector() -> impl Strategy<Value = DVec3> {
    (number(), number(), number()).prop_map(DVec3::from)
}

/// Vectors of order one.
pub fn tame() -> impl Strategy<Value = DVec3> {
    let entry = || -3.0..3.0;
    (entry(), entry(), entry()).prop_map(DVec3::from)
}

pub fn lattice() -> impl Strategy<Value = Lattice> {
    (tame(), tame(), tame()).prop_filter_map("no volume", |(a, b, c)| {
        let basis = DMat3::from_cols(a, b, c);
        (basis.determinant().abs() > 0.1)
            .then(|| Lattice::new(basis).ok())
            .flatten()
    })
}

pub fn image() -> impl Strategy<Value = IVec3> {
    (any::<i32>(), any::<i32>(), any::<i32>()).prop_map(IVec3::from)
}

pub fn now() -> impl Strategy<Value = Now> {
    let moment = (number(), 1e-6..1.0, 0.0..10.0, any::<u64>(), 0_u64..1 << 53);
    moment.prop_map(|(time, dt, kt, seed, step)| Now {
        time,
        dt,
        kt,
        seed,
        step,
    })
}

/// Particles with any set of columns.
pub fn particles(
    position: impl Strategy<Value = DVec3>,
    image: impl Strategy<Value = IVec3>,
) -> impl Strategy<Value = Particles> {
    let row = (
        position,
        vector(),
        1e-3..1e3,
        any::<u8>(),
        image,
        any::<u32>(),
    );
    let rows = prop::collection::vec(row, 0..12);
    (rows, any::<[bool; 5]>()).prop_map(|(rows, has)| {
        let mut particles = Particles::new(rows.iter().map(|row| row.0).collect()).unwrap();
        if has[0] {
            let velocities = rows.iter().map(|row| row.1).collect();
            particles = particles.with_velocities(velocities).unwrap();
        }
        if has[1] {
            let masses = rows.iter().map(|row| row.2).collect();
            particles = particles.with_masses(masses).unwrap();
        }
        if has[2] {
            let species = rows.iter().map(|row| row.3).collect();
            particles = particles.with_species(species).unwrap();
        }
        if has[3] {
            particles = particles.counting_images();
            for (image, row) in particles.columns_mut().images.iter_mut().zip(&rows) {
                *image = row.4;
            }
        }
        if has[4] {
            let mut ids: Vec<u32> = (0..rows.len() as u32).collect();
            ids.sort_by_key(|&id| rows[id as usize].5);
            particles = particles.with_ids(ids).unwrap();
        }
        particles
    })
}

pub fn system<B: Boundary>(boundary: B, particles: Particles, now: Now) -> System<B> {
    System {
        boundary,
        particles,
        clock: Clock::showing(now).unwrap(),
    }
}

/// Two dimers and a trimer behind one particle of none.
pub fn kinds() -> [Molecules; 2] {
    let dimers = Molecules::linear(1, 2, 2).unwrap();
    [dimers, Molecules::linear(5, 1, 3).unwrap()]
}

/// The molecule of an identity among these.
pub fn molecule(id: u32) -> u32 {
    *[0, 1, 1, 2, 2, 3, 3, 3].get(id as usize).unwrap_or(&0)
}
