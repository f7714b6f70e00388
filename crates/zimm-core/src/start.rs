//! Initial states: where particles are and how they move before anything has happened.
//!
//! These numbers are drawn in sequence from a generator of the caller's, [`stream`] or any other; nothing here is
//! addressed as the [`noise`](crate::noise) of a run is.
//!
//! ```
//! use zimm_core::{DVec3, Lattice, Molecules, Particles, start};
//!
//! // 100 dumbbells of length 0.8 in solvent, three particles per volume in all, at thermal velocities.
//! let mut rng = start::stream(42);
//! let lattice = Lattice::brick(DVec3::splat(7.0))?;
//! let dumbbells = Molecules::linear(0, 100, 2)?;
//! let positions = start::chains(&lattice, &dumbbells, |_| 0.8, &mut rng);
//! let positions = start::fill(&lattice, positions, 3.0, &mut rng)?;
//! let particles = Particles::new(positions)?;
//! let velocities = start::velocities(&particles, 1.0, &mut rng)?;
//! let particles = particles.with_velocities(velocities)?;
//! assert_eq!(particles.len(), 1029);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Particles at random overlap. Those that are soft sort themselves out within a few units of time; where forces are
//! steep, between springs that lie across each other for example, [`relax`] before the first step.

use crate::{
    BondForce, Boundary, ForceField, Lattice, Molecules, ParameterError, Particles, StepError,
    System, Topology,
};
use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal, StandardUniform, UnitSphere};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A generator for what is drawn in sequence: xoshiro256++ (Blackman and Vigna 2021), the same for the same seed.
pub fn stream(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

/// Positions drawn independently, with the same density everywhere in the cell.
pub fn uniform(lattice: &Lattice, count: usize, rng: &mut impl Rng) -> Vec<DVec3> {
    (0..count).map(|_| anywhere(lattice, rng)).collect()
}

/// Positions spread over a grid in fractional coordinates: simple cubic if the cell is a cube and `count` a cube
/// number. The grid has the most equal spacings that give every particle a site of its own; sites left over are
/// spread as well.
pub fn grid(lattice: &Lattice, count: usize) -> Vec<DVec3> {
    let basis = lattice.basis();
    let edges = [basis.x_axis, basis.y_axis, basis.z_axis].map(DVec3::length);
    let mut sites = [1_usize; 3];
    while sites.iter().product::<usize>() < count {
        let spacing = |k: usize| edges[k] / sites[k] as f64;
        let widest = (1..3).fold(0, |widest, k| {
            if spacing(k) > spacing(widest) {
                k
            } else {
                widest
            }
        });
        sites[widest] += 1;
    }
    let [a, b, c] = sites;
    let stride = (a * b * c) as f64 / count as f64;
    (0..count)
        .map(|k| {
            let site = (k as f64 * stride) as usize;
            let place = [site / (b * c), site / c % b, site % c].map(|n| n as f64 + 0.5);
            basis * (DVec3::from_array(place) / DVec3::new(a as f64, b as f64, c as f64) - 0.5)
        })
        .collect()
}

/// Molecules in a cell: each grows from a first bead anywhere, bead after bead, by independent and isotropic bonds. Bead
/// after bead and molecule after molecule, as [`Molecules`] counts them. The beads are not folded into the cell.
///
/// `bond` draws the length of each bond; `|_| 0.8` makes all alike, [`BondLength`] gives those of a spring in
/// equilibrium. Linear molecules, stars and combs without other forces are then in equilibrium.
///
/// A ring is a walk of independent bonds that is closed by taking their mean off each. For a Hookean spring that is the
/// exact equilibrium, a Brownian bridge. For any other it is near it but not in it: the bonds of a ring are not
/// independent, and what is taken off changes their lengths, even beyond the limit of a spring that has one. Start such
/// rings from shorter bonds and let them relax.
pub fn chains<R: Rng>(
    lattice: &Lattice,
    molecules: &Molecules,
    mut bond: impl FnMut(&mut R) -> f64,
    rng: &mut R,
) -> Vec<DVec3> {
    let mut positions = Vec::new();
    for _ in 0..molecules.count() {
        let first = anywhere(lattice, rng);
        grow(first, molecules, &mut bond, rng, &mut positions);
    }
    positions
}

/// Molecules in a cell, each pulled out straight: from a first bead anywhere, every bead is one `bond` further along than
/// the bead that it is joined to. The arms of a star, the teeth of a comb and the two halves of a ring lie upon each
/// other. The beads are not folded into the cell, which may be much smaller than the molecules.
///
/// ```
/// # use zimm_core::{DVec3, Lattice, Molecules, start};
/// let lattice = Lattice::brick(DVec3::splat(2.0))?;
/// let chain = Molecules::linear(0, 1, 20)?;
/// let beads = start::stretched(&lattice, &chain, 0.9 * DVec3::X, &mut start::stream(1));
/// assert!((beads[19] - beads[0]).abs_diff_eq(17.1 * DVec3::X, 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn stretched(
    lattice: &Lattice,
    molecules: &Molecules,
    bond: DVec3,
    rng: &mut impl Rng,
) -> Vec<DVec3> {
    let mut bonds_away: Vec<u32> = Vec::new();
    for bead in 0..molecules.beads() {
        let along = molecules
            .parent(bead)
            .map_or(0, |parent| bonds_away[parent as usize] + 1);
        let back = match molecules.topology() {
            Topology::Ring => molecules.beads() - bead,
            _ => along,
        };
        bonds_away.push(along.min(back));
    }
    let mut positions = Vec::new();
    for _ in 0..molecules.count() {
        let first = anywhere(lattice, rng);
        positions.extend(bonds_away.iter().map(|&n| first + f64::from(n) * bond));
    }
    positions
}

/// These positions, and behind them others drawn independently, anywhere in the cell, until there are `density` in all
/// per volume: molecules get their solvent.
///
/// # Errors
/// If `density` is not above zero, below that of the positions given, or makes more than 2^31 particles.
pub fn fill(
    lattice: &Lattice,
    mut positions: Vec<DVec3>,
    density: f64,
    rng: &mut impl Rng,
) -> Result<Vec<DVec3>, ParameterError> {
    const MOST: f64 = (1_u64 << 31) as f64;
    let density = ParameterError::positive("density", density)?;
    let (given, all) = (positions.len(), (density * lattice.volume()).round());
    if all < given as f64 {
        let (name, found) = ("density of the molecules", given as f64 / lattice.volume());
        return Err(ParameterError::new(name, found, "at most that of all"));
    }
    if all > MOST {
        return Err(ParameterError::new("particles", all, "at most 2^31"));
    }
    positions.extend(uniform(lattice, all as usize - given, rng));
    Ok(positions)
}

/// Parts what overlaps, so that a run can begin: `iterations` times every particle goes the way F dt^2 / 2m of a step
/// from rest, but no farther than `farthest`. Time stands still; velocities stay as they are.
///
/// No bond gets to its limit: a move that the field refuses is taken back, and particles go half as far at most for a
/// while. A `farthest` of some per cent of the range of the forces and a hundred iterations serve. It is no equilibrium
/// that they lead to, only a state that a time step dt can start from.
///
/// ```
/// # use zimm_core::{AllPairs, Central, Clock, DVec3, Now, Open, Pair, PairForce, Pairwise, Particles, System, start};
/// /// F = r^-13 below a distance of 1.
/// struct Hard;
///
/// impl PairForce for Hard {
///     fn cutoff(&self) -> f64 {
///         1.0
///     }
///
///     fn force(&self, pair: &Pair, _: &Now) -> Central {
///         Central::conservative(pair.r2.powi(-7))
///     }
/// }
///
/// // A force of 1e13, after which a step would have ended 1e8 away.
/// let particles = Particles::new(vec![DVec3::ZERO, 0.1 * DVec3::X])?;
/// let mut system = System::new(Open, particles, Clock::new(0.005, 1.0, 1)?);
/// start::relax(&mut system, &mut Pairwise::new(Hard, AllPairs::default()), 0.02, 50)?;
/// let apart = system.particles.positions()[1] - system.particles.positions()[0];
/// assert!((0.7..0.8).contains(&apart.x));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the field refuses the first state, or a force is not finite. The particles are then where they were last accepted.
pub fn relax<B: Boundary, F: ForceField<B>>(
    system: &mut System<B>,
    field: &mut F,
    farthest: f64,
    iterations: u32,
) -> Result<(), StepError> {
    let now = system.clock.now();
    let step = now.step;
    let parameter = |source| StepError::Parameter { step, source };
    let mut most = ParameterError::positive("farthest", farthest).map_err(parameter)?;
    let mut forces = vec![DVec3::ZERO; system.particles.len()];
    let first = field.accumulate(&system.frame(), &mut forces, &mut ());
    first.map_err(|source| StepError::Force { step, source })?;
    for _ in 0..iterations {
        if let Some(particle) = forces.iter().position(|force| !force.is_finite()) {
            let force = forces[particle].to_array();
            return Err(StepError::NotFinite {
                step,
                particle,
                force,
            });
        }
        let accepted = system.particles.clone();
        system.particles.forces.clear();
        for (k, &force) in forces.iter().enumerate() {
            let way = force * (0.5 * now.dt * now.dt / accepted.mass(k));
            let moved = accepted.positions[k] + way.clamp_length_max(most);
            let (folded, count) = system.boundary.wrap(moved);
            system.particles.positions[k] = folded;
            if let Some(image) = system.particles.images.get_mut(k) {
                *image = image.wrapping_add(count);
            }
        }
        let mut next = vec![DVec3::ZERO; forces.len()];
        match field.accumulate(&system.frame(), &mut next, &mut ()) {
            Ok(()) => {
                forces = next;
                most = farthest.min(1.2 * most);
            }
            Err(_) => {
                system.particles = accepted;
                most *= 0.5;
            }
        }
    }
    field.forget();
    Ok(())
}

/// Molecules in open space, as [`chains`] but each with the mean position of its beads at the origin, where a flow is
/// at rest.
///
/// ```
/// use zimm_core::{BondForce, Molecules, start};
///
/// /// U = Q^2 / 2.
/// struct Hooke;
///
/// impl BondForce for Hooke {
///     fn force(&self, _: f64) -> f64 {
///         -1.0
///     }
///
///     fn energy(&self, r2: f64) -> f64 {
///         0.5 * r2
///     }
/// }
///
/// // Gaussian rings: the mean square radius of gyration is (N^2 - 1) / (12 N) <Q^2> = 2.475.
/// let (mut rng, bond) = (start::stream(1), start::BondLength::new(&Hooke, 1.0)?);
/// let rings = Molecules::ring(0, 10_000, 10)?;
/// let positions = start::isolated(&rings, |rng| bond.sample(rng), &mut rng);
/// let sum: f64 = positions.iter().map(|r| r.length_squared()).sum();
/// assert!((sum / 100_000.0 - 2.475).abs() < 0.05);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
pub fn isolated<R: Rng>(
    molecules: &Molecules,
    mut bond: impl FnMut(&mut R) -> f64,
    rng: &mut R,
) -> Vec<DVec3> {
    let mut positions = Vec::new();
    for _ in 0..molecules.count() {
        let start = positions.len();
        grow(DVec3::ZERO, molecules, &mut bond, rng, &mut positions);
        let molecule = &mut positions[start..];
        let centre = molecule.iter().sum::<DVec3>() / molecule.len() as f64;
        for position in molecule {
            *position -= centre;
        }
    }
    positions
}

fn grow<R: Rng>(
    first: DVec3,
    molecules: &Molecules,
    bond: &mut impl FnMut(&mut R) -> f64,
    rng: &mut R,
    positions: &mut Vec<DVec3>,
) {
    let mut draw = || {
        let direction = DVec3::from_array(UnitSphere.sample(rng));
        bond(rng) * direction
    };
    let start = positions.len();
    positions.push(first);
    for bead in 1..molecules.beads() {
        let parent = molecules.parent(bead).unwrap_or_default();
        let from = positions[start + parent as usize];
        positions.push(from + draw());
    }
    if molecules.topology() == Topology::Ring {
        let ring = &mut positions[start..];
        let gap = ring[ring.len() - 1] + draw() - first;
        let mean = gap / ring.len() as f64;
        for (bead, position) in ring.iter_mut().enumerate() {
            *position -= bead as f64 * mean;
        }
    }
}

/// The lengths that a bond takes in equilibrium: the distribution of density r^2 exp(-U(r) / kT), for any spring.
///
/// The density is tabulated where it is above 1e-20 of its maximum, at 16384 equal steps, and sampled as if it were
/// straight between them: the mean square is right to 1e-7 for smooth springs of one well. What makes the density jump
/// costs more, such as a limit that is reached at a finite energy.
///
/// ```
/// # use zimm_core::{BondForce, start};
/// # struct Hooke;
/// # impl BondForce for Hooke {
/// #     fn force(&self, _: f64) -> f64 { -1.0 }
/// #     fn energy(&self, r2: f64) -> f64 { 0.5 * r2 }
/// # }
/// // The median of Maxwell's distribution.
/// let bond = start::BondLength::new(&Hooke, 1.0)?;
/// assert!((bond.quantile(0.5) - 1.538172).abs() < 1e-6);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct BondLength {
    least: f64,
    step: f64,
    /// The density at the nodes of the table, and its integral up to them.
    density: Vec<f64>,
    integral: Vec<f64>,
}

impl BondLength {
    /// The lengths of a spring at thermal energy `kt`.
    ///
    /// # Errors
    /// If `kt` or the limit of the spring is not above zero, its energy is nowhere finite, or it does not hold the
    /// beads together.
    pub fn new(spring: &impl BondForce, kt: f64) -> Result<Self, ParameterError> {
        let kt = ParameterError::positive("kt", kt)?;
        let logarithm = |r: f64| 2.0 * r.ln() - spring.energy(r * r) / kt;
        let (mut least, mut most) = found_anywhere(spring.limit(), logarithm)?;
        loop {
            let step = (most - least) / PANELS as f64;
            let nodes: Vec<f64> = (0..=PANELS).map(|k| least + k as f64 * step).collect();
            let heights: Vec<f64> = nodes.iter().map(|&r| logarithm(r)).collect();
            let (from, to, highest) = above_the_floor(&heights)?;
            if 2 * (to - from) < PANELS && step > f64::EPSILON * most {
                (least, most) = (nodes[from], nodes[to]);
                continue;
            }
            let density: Vec<f64> = heights.iter().map(|h| (h - highest).exp()).collect();
            let mut integral = vec![0.0];
            let mut sum = 0.0;
            for pair in density.windows(2) {
                sum += 0.5 * (pair[0] + pair[1]);
                integral.push(sum);
            }
            return Ok(Self {
                least,
                step,
                density,
                integral,
            });
        }
    }

    /// The length that a fraction `p` of all bonds does not reach.
    pub fn quantile(&self, p: f64) -> f64 {
        let goal = p.clamp(0.0, 1.0) * self.integral[PANELS];
        let node = self.integral.partition_point(|&sum| sum < goal);
        let panel = node.clamp(1, PANELS) - 1;
        let rest = goal - self.integral[panel];
        let (here, slope) = (
            self.density[panel],
            self.density[panel + 1] - self.density[panel],
        );
        let root = (here * here + 2.0 * slope * rest).max(0.0).sqrt();
        let part = 2.0 * rest / (here + root).max(f64::MIN_POSITIVE);
        self.least + (panel as f64 + part.min(1.0)) * self.step
    }

    /// A length.
    pub fn sample(&self, rng: &mut impl Rng) -> f64 {
        self.quantile(StandardUniform.sample(rng))
    }
}

const PANELS: usize = 1 << 14;

/// Where a density of this logarithm is at all, whatever its scale: eight lengths an octave over all that squares do
/// not overflow for, or down from the limit.
fn found_anywhere(
    limit: f64,
    logarithm: impl Fn(f64) -> f64,
) -> Result<(f64, f64), ParameterError> {
    const LONGEST: f64 = 1e100;
    if limit <= 0.0 || limit.is_nan() {
        let allowed = "above zero";
        return Err(ParameterError::new("limit of the spring", limit, allowed));
    }
    let top = limit.min(LONGEST);
    let length = |k: i32| top * (f64::from(k) / 8.0).exp2();
    let lengths: Vec<f64> = (-5400..=0).map(length).collect();
    let heights: Vec<f64> = lengths.iter().map(|&r| logarithm(r)).collect();
    let (from, to, _) = above_the_floor(&heights)?;
    if limit > LONGEST && to + 1 == lengths.len() {
        let (name, allowed) = ("longest bond", "held back by the spring");
        return Err(ParameterError::new(name, lengths[to], allowed));
    }
    Ok((lengths[from], lengths[to]))
}

/// The nodes between which is all that matters, and the maximum.
fn above_the_floor(heights: &[f64]) -> Result<(usize, usize, f64), ParameterError> {
    const DEPTH: f64 = 46.0;
    let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    ParameterError::finite("greatest logarithm of the density", highest)?;
    // At least, not above: a maximum of -1e40, of a stiff spring between two nodes, less the depth is itself.
    let matters = |&height: &f64| height >= highest - DEPTH;
    let from = heights.iter().position(matters).unwrap_or(0);
    let to = heights.iter().rposition(matters).unwrap_or(0);
    let last = heights.len() - 1;
    Ok((from.saturating_sub(1), (to + 1).min(last), highest))
}

/// Peculiar velocities drawn from Maxwell and Boltzmann's distribution, `<c c> = (kt / m) I`, less the velocity of the
/// centre of mass, so that the total momentum is zero to rounding.
///
/// The kinetic energy is not scaled to a value: it fluctuates as it does in the ensemble, about 3/2 (N - 1) kt.
///
/// # Errors
/// If `kt` is below zero.
pub fn velocities(
    particles: &Particles,
    kt: f64,
    rng: &mut impl Rng,
) -> Result<Vec<DVec3>, ParameterError> {
    let kt = ParameterError::non_negative("kt", kt)?;
    let mut velocities: Vec<DVec3> = (0..particles.len())
        .map(|k| {
            let [x, y, z] = std::array::from_fn(|_| StandardNormal.sample(rng));
            (kt / particles.mass(k)).sqrt() * DVec3::new(x, y, z)
        })
        .collect();
    let (mut momentum, mut mass) = (DVec3::ZERO, 0.0);
    for (k, &velocity) in velocities.iter().enumerate() {
        momentum += particles.mass(k) * velocity;
        mass += particles.mass(k);
    }
    for velocity in &mut velocities {
        *velocity -= momentum / mass;
    }
    Ok(velocities)
}

fn anywhere(lattice: &Lattice, rng: &mut impl Rng) -> DVec3 {
    let fraction: [f64; 3] = std::array::from_fn(|_| StandardUniform.sample(rng));
    lattice.basis() * (DVec3::from_array(fraction) - 0.5)
}
