//! The flow over one step, as schemes need it that weigh it against forces.

use zimm_core::{Boundary, DMat3, DVec3, System};

/// The deformation of the flow over one step, and its split into a steady rate and a sudden strain.
///
/// Fields are carried by `whole`, exactly. What is inside a molecule is carried by `rate`, second order in the step:
/// a state in which flow and springs balance is then a fixed point of the scheme, however long the step. A strain
/// that the rate does not tell of, as in a step strain, comes first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carry {
    /// The deformation.
    pub(crate) whole: DMat3,
    /// Time step times velocity gradient in the middle of the step.
    pub(crate) rate: DMat3,
    /// The part of the deformation that the rate does not account for.
    sudden: Option<DMat3>,
}

impl Carry {
    /// The flow of a boundary between the present time of a system and the next.
    pub(crate) fn over_step<B: Boundary>(system: &System<B>) -> Self {
        if !B::FLOWS {
            return Self {
                whole: DMat3::IDENTITY,
                rate: DMat3::ZERO,
                sudden: None,
            };
        }
        let (now, next) = (system.clock.now(), system.clock.next());
        let whole = system.boundary.carry(now.time, next.time);
        let mut middle = system.boundary.clone();
        middle.advance(0.5 * (now.time + next.time));
        let rate = (next.time - now.time) * middle.gradient();
        let (found, smooth) = (largest(whole), largest(whole - exp(rate)));
        let sudden = (smooth > 1e-9 * found).then(|| exp(-rate) * whole);
        Self {
            whole,
            rate,
            sudden,
        }
    }

    /// A separation after the sudden strain.
    #[inline(always)]
    pub(crate) fn strain(&self, r: DVec3) -> DVec3 {
        self.sudden.map_or(r, |sudden| sudden * r)
    }
}

fn largest(m: DMat3) -> f64 {
    m.to_cols_array()
        .iter()
        .fold(0.0, |most, entry| entry.abs().max(most))
}

/// The exponential of a matrix by scaling, Taylor's series and squaring.
fn exp(m: DMat3) -> DMat3 {
    let mut halvings = 0;
    let mut scaled = m;
    while largest(scaled) > 0.125 && halvings < 1100 {
        scaled *= 0.5;
        halvings += 1;
    }
    let series = (1..=12).rev().fold(DMat3::IDENTITY, |tail, n| {
        DMat3::IDENTITY + scaled * tail * (1.0 / f64::from(n))
    });
    (0..halvings).fold(series, |root, _| root * root)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zimm_boundary::{OpenFlow, StepStrain};
    use zimm_core::{Clock, Particles};

    fn carry<B: Boundary>(boundary: B) -> Carry {
        let particles = Particles::new(vec![DVec3::ZERO]).unwrap();
        let clock = Clock::new(0.5, 1.0, 1).unwrap();
        Carry::over_step(&System::new(boundary, particles, clock))
    }

    #[test]
    fn limit_exponential_of_rotation_shear_and_extension() {
        let close = |a: DMat3, b: DMat3| largest(a - b) < 1e-14 * (1.0 + largest(b));
        let turn = DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::ZERO);
        assert!(close(exp(2.0 * turn), DMat3::from_rotation_z(2.0)));
        let shear = DMat3::from_cols(DVec3::ZERO, 1e7 * DVec3::X, DVec3::ZERO);
        assert_eq!(exp(shear), DMat3::IDENTITY + shear);
        let rates = DVec3::new(3.0, -2.0, -1.0);
        let stretched = DMat3::from_diagonal(DVec3::from_array(rates.to_array().map(f64::exp)));
        assert!(close(exp(DMat3::from_diagonal(rates)), stretched));
    }

    #[test]
    fn limit_steady_flow_is_all_rate_and_a_step_strain_all_sudden() {
        let shape = DMat3::from_cols(DVec3::new(1.0, 0.3, 0.0), -DVec3::Y, DVec3::ZERO);
        let steady = carry(OpenFlow::new(3.0 * shape).unwrap());
        assert_eq!((steady.rate, steady.sudden), (1.5 * shape, None));

        let step = StepStrain::new(0.7, 0.25).unwrap();
        let sudden = carry(OpenFlow::with_history(shape, step).unwrap());
        assert_eq!(sudden.rate, DMat3::ZERO);
        assert_eq!(sudden.sudden, Some(sudden.whole));
        assert!((sudden.whole.x_axis.x - 0.7_f64.exp()).abs() < 1e-14);
    }
}
