//! The cells of the flows.

use super::LIMIT;
use crate::Problem;
use zimm::prelude::*;

/// A cube in shear. Springs reach across half of it.
pub(crate) fn shear(rate: f64) -> Result<LeesEdwards<Steady>, Problem> {
    Ok(LeesEdwards::new(
        DVec3::splat(2.0 * LIMIT),
        Steady::new(rate)?,
    )?)
}

/// The smallest cell in which no spring meets an image of itself.
pub(crate) fn extension(rate: f64) -> Result<KraynikReinelt<Steady>, Problem> {
    Ok(KraynikReinelt::box_for_cutoff(LIMIT, Steady::new(rate)?)?)
}

/// The smallest cell in which no spring meets an image of itself.
pub(crate) fn mixed(rate: f64, mixedness: f64) -> Result<PlanarMixed<Steady>, Problem> {
    Ok(PlanarMixed::box_for_cutoff(
        LIMIT,
        mixedness,
        Steady::new(rate)?,
    )?)
}

/// The smallest cell in which no spring meets an image of itself.
pub(crate) fn uniaxial(rate: f64) -> Result<UniaxialExtension<Steady>, Problem> {
    Ok(UniaxialExtension::box_for_cutoff(
        LIMIT,
        Steady::new(rate)?,
    )?)
}

/// Two channels above each other. Springs reach across half of it.
pub(crate) fn channels(height: f64) -> Result<PeriodicBox, Problem> {
    let edge = 2.0 * LIMIT;
    Ok(PeriodicBox::brick(DVec3::new(edge, height, edge))?)
}
