//! The skin with which a list is cheapest.

use crate::Lattice;

/// Learns from the lives of lists how thick the next one's skin should be.
///
/// While a list lives the tuner hears how thick a skin it would have needed until then. A skin that is needed for n steps
/// costs one making in n steps and looking at the candidates of that skin in each of them; the cheapest n is taken. All
/// that decides is the trajectory, so a tuned list has the same bits on any machine.
#[derive(Clone, Debug, Default)]
pub(super) struct Tuner {
    /// The skin needed at the 1st, 2nd, .. look at a list, the thickest of late.
    needed: Vec<f64>,
    looks: usize,
}

/// Looks at one list that are remembered, and the most that are hoped for.
const MOST: usize = 256;

impl Tuner {
    /// Hears the skin that the list would have needed to be good now. More than any list has says that the particles are
    /// no longer those that it was made for.
    pub(super) fn hear(&mut self, needed: f64, thickest: f64) {
        /// What is not seen again fades within some thirty lists.
        const MEMORY: f64 = 0.97;
        if self.looks < MOST && needed <= thickest {
            match self.needed.get_mut(self.looks) {
                Some(known) => *known = needed.max(MEMORY * *known),
                None => self.needed.push(needed),
            }
            self.looks += 1;
        }
    }

    /// The skin for a list that is about to be made.
    pub(super) fn next(&mut self, cutoff: f64, lattice: &Lattice, particles: usize) -> f64 {
        /// In units of the cutoff, when nothing is known.
        const FIRST: f64 = 0.3;
        /// What other particles may need in addition to those seen.
        const MARGIN: f64 = 1.05;
        self.needed.truncate(self.looks);
        self.looks = 0;
        let known = self.needed.len();
        if known == 0 {
            return FIRST * cutoff;
        }
        let density = particles as f64 / lattice.volume();
        let lives = (1..=MOST.min(2 * known)).map(|life| {
            let skin = MARGIN * self.needed_for(life - 1);
            (skin, cost(cutoff + skin, density, life))
        });
        let cheapest = lives.min_by(|a, b| a.1.total_cmp(&b.1));
        cheapest.map_or(FIRST * cutoff, |(skin, _)| skin)
    }

    /// The skin needed for so many looks: known, or by the power of time that fits the second half of what is known,
    /// between diffusion and free flight.
    fn needed_for(&self, looks: usize) -> f64 {
        if looks == 0 {
            return 0.0;
        }
        if let Some(&needed) = self.needed.get(looks - 1) {
            return needed;
        }
        let all = self.needed.len();
        let half = all.div_ceil(2);
        let [then, now] = [half, all].map(|looks| self.needed[looks - 1]);
        let power = if then > 0.0 && half < all {
            libm::log(now / then) / libm::log(all as f64 / half as f64)
        } else {
            1.0
        };
        now * libm::pow(looks as f64 / all as f64, power.clamp(0.5, 1.0))
    }
}

/// What a particle costs in a step, in nanoseconds of one machine; only the ratio of the two parts matters, and that
/// is much the same elsewhere: making a list that lives so many steps, and looking at its candidates.
fn cost(range: f64, density: f64, life: usize) -> f64 {
    let candidates = 2.0 / 3.0 * std::f64::consts::PI * density * range.powi(3);
    (75.0 + 0.45 * candidates) / life as f64 + 2.2 * candidates
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use glam::DVec3;

    const DENSITY: f64 = 3.0;

    fn lattice() -> Lattice {
        Lattice::brick(DVec3::splat(10.0)).unwrap()
    }

    /// Lists whose need of skin grows by a law of time, until they have settled: the last skin, and how long it lives.
    fn tuned(tuner: &mut Tuner, needed: impl Fn(usize) -> f64) -> (f64, usize) {
        let (mut skin, mut life) = (0.0, 0);
        for _ in 0..30 {
            skin = tuner.next(1.0, &lattice(), 3000);
            life = 0;
            loop {
                life += 1;
                tuner.hear(needed(life), 2.0);
                if needed(life) > skin {
                    break;
                }
            }
        }
        (skin, life)
    }

    /// Asserts that lists of some skin and life cost at most 5 % more than the cheapest of all, whose skin is just what is
    /// needed.
    fn assert_cheap((skin, life): (f64, usize), needed: impl Fn(usize) -> f64, case: &str) {
        let costs = (1..=MOST).map(|life| cost(1.0 + needed(life - 1), DENSITY, life));
        let least = costs.min_by(f64::total_cmp).unwrap();
        let ratio = cost(1.0 + skin, DENSITY, life) / least;
        assert!(
            ratio < 1.03,
            "{case}: {ratio} times as much, {skin}, {life}"
        );
    }

    /// Free flight and diffusion, fast and slow.
    #[test]
    fn limit_lists_come_to_cost_least() {
        for size in [1.0, 0.3, 0.1, 0.03, 0.01, 0.003] {
            for power in [1.0, 0.5] {
                let needed = |looks: usize| size * (looks as f64).powf(power);
                let found = tuned(&mut Tuner::default(), needed);
                assert_cheap(found, needed, &format!("{size} {power}"));
            }
        }
    }

    /// Particles that become ten times as fast, and slow again: nothing of the past is left.
    #[test]
    fn law_what_has_changed_is_learned() {
        let mut tuner = Tuner::default();
        for speed in [0.02, 0.2, 0.02, 0.002] {
            let needed = |looks: usize| speed * looks as f64;
            let found = tuned(&mut tuner, needed);
            assert_cheap(found, needed, &speed.to_string());
        }
    }

    /// At rest nothing is needed, and what is not finite, or more than any list has, is not heard.
    #[test]
    fn extreme_no_motion_and_no_numbers() {
        let mut tuner = Tuner::default();
        for needed in [0.0, 1e3, f64::INFINITY, f64::NAN] {
            for _ in 0..10 {
                assert!(tuner.next(1.0, &lattice(), 3000) <= 0.3);
                (0..1000).for_each(|_| tuner.hear(needed, 2.0));
            }
        }
    }
}
