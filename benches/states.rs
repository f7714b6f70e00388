//! Starting states with chains that several programs share.

use std::error::Error;
use zimm::prelude::*;

type Problem = Box<dyn Error + Send + Sync>;

/// Particles at density 3, 10 % of them in chains of 5, sheared at 0.2; and the chains.
pub(crate) fn fene_shear(
    particles: f64,
) -> Result<(System<LeesEdwards<Steady>>, Molecules), Problem> {
    const BEADS: u32 = 5;
    let edge = (particles / 3.0).cbrt();
    let chains = Molecules::linear(0, (0.1 * particles / f64::from(BEADS)) as u32, BEADS)?;
    let space = LeesEdwards::new(DVec3::splat(edge), Steady::new(0.2)?)?;
    let solvent = particles as usize - chains.identities().len();
    Ok((start(space, &chains, 0.8, solvent)?, chains))
}

/// Chains of 5 and nothing else, in a brick of 5 by 2 by 1 at density 3; and the chains.
pub(crate) fn fedosov(particles: f64) -> Result<(System<PeriodicBox>, Molecules), Problem> {
    const BEADS: u32 = 5;
    let chains = Molecules::linear(0, particles as u32 / BEADS, BEADS)?;
    let edge = (f64::from(chains.count() * BEADS) / 30.0).cbrt();
    let space = PeriodicBox::brick(edge * DVec3::new(5.0, 2.0, 1.0))?;
    Ok((start(space, &chains, 0.5, 0)?, chains))
}

/// Chains of bonds of one length, and solvent, at kT = 1.
pub(crate) fn start<B: Periodic>(
    space: B,
    chains: &Molecules,
    bond: f64,
    solvent: usize,
) -> Result<System<B>, Problem> {
    let mut rng = start::stream(1);
    let mut positions = start::chains(space.lattice(), chains, |_| bond, &mut rng);
    positions.extend(start::uniform(space.lattice(), solvent, &mut rng));
    moving(space, positions, 1.0)
}

/// Particles with thermal velocities.
pub(crate) fn moving<B: Periodic>(
    space: B,
    positions: Vec<DVec3>,
    kt: f64,
) -> Result<System<B>, Problem> {
    let particles = Particles::new(positions)?;
    let velocities = start::velocities(&particles, kt, &mut start::stream(2))?;
    let particles = particles.with_velocities(velocities)?;
    Ok(System::new(space, particles, Clock::new(0.01, kt, 1)?))
}
