//! Friction between pairs and the noise that balances it, as a bath.

use crate::pair_bath::{Exchange, PairBath};
use zimm_core::noise::Domain;
use zimm_core::{Item, Now, Pair, PairForce, ParameterError};

/// The exact solution of friction and noise for one pair over one time step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Friction<L>(L);

impl<L: PairForce> Friction<L> {
    /// The bath of a law of friction.
    pub(crate) const fn new(law: L) -> Self {
        const {
            assert!(
                L::READS.velocity && !L::READS.noise,
                "the law must be one of friction alone: the stepper makes the noise that balances it"
            );
        }
        Self(law)
    }
}

impl<L: PairForce> PairBath for Friction<L> {
    const ITEMS: [Item; 2] = [Item::Dissipative, Item::Random];

    fn cutoff(&self) -> f64 {
        self.0.cutoff()
    }

    fn share(&self, _: &Now) -> Result<f64, ParameterError> {
        Ok(1.0)
    }

    #[inline(always)]
    fn exchange(&self, pair: &Pair, mass: f64, now: &Now) -> Exchange {
        // F = -gamma u along the line of centres; at u = -r, F / r is gamma.
        let approaching = Pair {
            rv: -pair.r2,
            ..*pair
        };
        let gamma = self.0.force(&approaching, now).dissipative;
        // What cancels here is lost to friction and noise alike.
        let loss = 1.0 - libm::exp(-gamma * now.dt / mass);
        let spread = (now.kt / mass * loss * (2.0 - loss)).sqrt();
        Exchange {
            loss,
            kick: spread * pair.noise.normal(Domain::PAIR_KICK),
        }
    }
}
