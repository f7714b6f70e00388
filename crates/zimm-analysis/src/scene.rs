//! What the tests need: a tilted cell that shears, and random numbers.

use crate::{Mean, StandardError};
use std::f64::consts::PI;
use zimm_core::noise::{Domain, Noise};
use zimm_core::{
    BondForce, Boundary, Clock, DMat3, DVec3, IVec3, Lattice, Particles, Periodic, Remap, System,
};

/// Independent normal and uniform numbers, the same ones in every run.
pub(crate) struct Random {
    seed: u64,
    drawn: u32,
}

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self { seed, drawn: 0 }
    }

    fn next(&mut self, domain: u32) -> (zimm_core::noise::Site, Domain) {
        self.drawn += 1;
        (
            Noise::new(self.seed, 0).site(self.drawn),
            Domain::user(domain),
        )
    }

    pub(crate) fn normal(&mut self) -> f64 {
        let (site, domain) = self.next(1);
        site.normal(domain)
    }

    pub(crate) fn normal3(&mut self) -> DVec3 {
        let (site, domain) = self.next(2);
        site.normal3(domain)
    }

    /// Uniform in [0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        let (site, domain) = self.next(3);
        (site.word(domain) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in a cell.
    pub(crate) fn within(&mut self, cell: DMat3) -> DVec3 {
        cell * DVec3::new(self.uniform(), self.uniform(), self.uniform())
    }
}

/// A mean whose error is known to a tenth.
pub(crate) fn known(value: f64, error: f64) -> Mean {
    let uncertainty = 0.1 * error;
    let error = StandardError::Plateau { error, uncertainty };
    Mean { value, error }
}

/// FENE dumbbells, b = 50, in shear and mixed flow, in units of l_H, lambda_H and kT: b, rate e, rate g, <QQ> as xx, xy,
/// yy, zz, two columns more, and <QF> as xx, xy, yy, from a spectral solution of the Fokker-Planck equation.
pub(crate) fn fene_in_planar_flow() -> Vec<[f64; 12]> {
    let table = include_str!("../tests/data/fene_planar_flow.csv");
    let row = |line: &str| {
        let words = line.split(',').take(12);
        let numbers: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
        numbers.try_into().unwrap()
    };
    table.lines().skip(1).map(row).collect()
}

/// A lattice carried by the shear u = rate y, its basis reduced at all times.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    start: DMat3,
    rate: f64,
    time: f64,
    lattice: Lattice,
}

impl Cell {
    pub(crate) fn new(basis: DMat3, rate: f64) -> Self {
        let lattice = Lattice::new(basis).unwrap();
        Self {
            start: basis,
            rate,
            time: 0.0,
            lattice,
        }
    }

    pub(crate) fn cube(edge: f64) -> Self {
        Self::new(DMat3::from_diagonal(DVec3::splat(edge)), 0.0)
    }

    /// A Lees-Edwards brick: the image above is `offset` further along x.
    pub(crate) fn lees_edwards(edges: DVec3, offset: f64) -> Self {
        let mut basis = DMat3::from_diagonal(edges);
        basis.y_axis.x = offset;
        Self::new(basis, 0.0)
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

    fn carry(&self, from: f64, to: f64) -> DMat3 {
        let mut carry = DMat3::IDENTITY;
        carry.y_axis.x = self.rate * (to - from);
        carry
    }

    fn advance(&mut self, to: f64) -> Remap {
        let carried = self.carry(self.time, to) * self.lattice.basis();
        self.lattice = Lattice::new(self.carry(0.0, to) * self.start).unwrap();
        self.time = to;
        Remap::between(carried, &self.lattice)
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

/// Open space in a planar mixed flow of this gradient.
#[derive(Clone, Debug)]
pub(crate) struct Flow(pub(crate) DMat3);

impl Boundary for Flow {
    const FLOWS: bool = true;

    fn min_image(&self, dr: DVec3) -> DVec3 {
        dr
    }

    fn wrap(&self, r: DVec3) -> (DVec3, IVec3) {
        (r, IVec3::ZERO)
    }

    fn gradient(&self) -> DMat3 {
        self.0
    }

    /// exp(kappa t) = cosh(e t) + sinh(e t) kappa / e in the plane, as kappa^2 = e^2 there.
    fn carry(&self, from: f64, to: f64) -> DMat3 {
        let (e, t) = (self.0.x_axis.x, to - from);
        let slope = if e == 0.0 { t } else { (e * t).sinh() / e };
        let cosh = (e * t).cosh();
        DMat3::from_diagonal(DVec3::new(cosh, cosh, 1.0)) + self.0 * slope
    }
}

/// kappa = [[e, g, 0], [0, -e, 0], [0, 0, 0]].
pub(crate) fn planar_mixed(e: f64, g: f64) -> DMat3 {
    DMat3::from_cols(DVec3::X * e, DVec3::new(g, -e, 0.0), DVec3::ZERO)
}

/// A symmetric tensor without xz and yz.
pub(crate) fn planar(xx: f64, xy: f64, yy: f64, zz: f64) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(xx, xy, 0.0),
        DVec3::new(xy, yy, 0.0),
        DVec3::Z * zz,
    )
}

/// Mode p of a chain of n beads at one bead, orthonormal.
pub(crate) fn mode(n: u32, p: u32, bead: u32) -> f64 {
    let angle = PI * f64::from(p) * (f64::from(bead) + 0.5) / f64::from(n);
    (2.0 / f64::from(n)).sqrt() * angle.cos()
}

/// Stiffness of mode p, 4 sin^2(p pi / 2n): the relaxation time of its stress is 2 over this, in units of lambda_H.
pub(crate) fn stiffness(n: u32, p: u32) -> f64 {
    4.0 * (PI * f64::from(p) / f64::from(2 * n)).sin().powi(2)
}

/// 3 (n - 1) chains of n beads whose modes p = 1, 2, ... have exactly these second moments, averaged over the chains,
/// and no moments between modes: averages over a Gaussian distribution without noise.
pub(crate) fn chains_of_moments(moments: &[DMat3]) -> Vec<DVec3> {
    let n = moments.len() as u32 + 1;
    let mut positions = Vec::new();
    for (p, &moment) in (1..n).zip(moments) {
        for column in cholesky(moment) {
            let along = column * f64::from(3 * (n - 1)).sqrt();
            positions.extend((0..n).map(|bead| mode(n, p, bead) * along));
        }
    }
    positions
}

/// Columns of the lower triangle L with L L^T the symmetric matrix given.
fn cholesky(m: DMat3) -> [DVec3; 3] {
    let first = m.x_axis / m.x_axis.x.sqrt();
    let rest = m.y_axis - first * first.y;
    let second = rest / rest.y.sqrt();
    let rest = m.z_axis - first * first.z - second * second.z;
    let third = rest / rest.z.sqrt();
    [first, second, third]
}

/// The second moments of the modes of Hookean chains of n beads in a steady planar mixed flow without hydrodynamic
/// interactions, in units of l_H and lambda_H.
pub(crate) fn rouse_moments(n: u32, e: f64, g: f64) -> Vec<DMat3> {
    let moment = |p| {
        let tau = 2.0 / stiffness(n, p);
        let yy = 1.0 / (1.0 + 2.0 * e * tau);
        let xy = g * tau * yy;
        let xx = (1.0 + 2.0 * g * tau * xy) / (1.0 - 2.0 * e * tau);
        planar(xx, xy, yy, 1.0) * (1.0 / stiffness(n, p))
    };
    (1..n).map(moment).collect()
}

/// F = -H Q.
pub(crate) struct Hooke(pub(crate) f64);

impl BondForce for Hooke {
    fn force(&self, _: f64) -> f64 {
        -self.0
    }

    fn energy(&self, r2: f64) -> f64 {
        0.5 * self.0 * r2
    }
}

/// A system with time step 1 and kT = 1.
pub(crate) fn system<B: Boundary>(boundary: B, particles: Particles) -> System<B> {
    System::new(boundary, particles, Clock::new(1.0, 1.0, 0).unwrap())
}

/// A system of particles at these positions.
pub(crate) fn at<B: Boundary>(boundary: B, positions: Vec<DVec3>) -> System<B> {
    system(boundary, Particles::new(positions).unwrap())
}

/// Moves every particle with the flow through one time step and by a displacement of its own, and wraps it.
pub(crate) fn step<B: Boundary>(system: &mut System<B>, mut displacement: impl FnMut() -> DVec3) {
    let from = system.clock.now().time;
    system.clock.tick();
    let to = system.clock.now().time;
    let carry = system.boundary.carry(from, to);
    let remap = system.boundary.advance(to);
    let columns = system.particles.columns_mut();
    for (k, r) in columns.positions.iter_mut().enumerate() {
        let (wrapped, count) = system.boundary.wrap(carry * *r + displacement());
        *r = wrapped;
        if let Some(image) = columns.images.get_mut(k) {
            *image = remap.apply(*image) + count;
        }
    }
}
