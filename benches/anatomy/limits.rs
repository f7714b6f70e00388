//! What the machine could do at best.

use crate::{Problem, timing::seconds};
use std::hint::black_box;
use zimm::core::noise::{Noise, Site};
use zimm::prelude::*;

/// CPU time of a byte read or written, in nanoseconds: columns of so many particles copied one into the next, as many as
/// a stepper goes through in a step.
pub(crate) fn byte(particles: usize) -> Result<f64, Problem> {
    const COLUMNS: usize = 8;
    let mut columns = vec![vec![DVec3::ONE; particles]; COLUMNS];
    let rounds = 4_000_000_usize.div_ceil(particles * COLUMNS);
    let time = seconds(|| {
        for _ in 0..rounds {
            for k in 1..COLUMNS {
                let (before, after) = columns.split_at_mut(k);
                if let (Some(from), Some(to)) = (before.last(), after.first_mut()) {
                    to.copy_from_slice(from);
                }
            }
            black_box(&mut columns);
        }
        Ok(())
    })?;
    let bytes = rounds * (COLUMNS - 1) * particles * 2 * size_of::<DVec3>();
    Ok(1e9 * time / bytes as f64)
}

/// CPU time of one evaluation of a law, in nanoseconds: pairs side by side in the nearest cache, in the widest lanes.
pub(crate) fn law(law: &impl PairForce) -> Result<f64, Problem> {
    const PAIRS: usize = 512;
    const ROUNDS: usize = 20_000;
    let noise = Noise::new(1, 1);
    let cutoff_squared = law.cutoff() * law.cutoff();
    let share = |k: usize| (k as f64 + 0.5) / PAIRS as f64;
    let mut pairs = Pairs {
        r2: (0..PAIRS).map(|k| share(k) * cutoff_squared).collect(),
        rv: (0..PAIRS).map(|k| share(k) - 0.5).collect(),
        noise: (0..PAIRS as u32).map(|k| noise.site(k)).collect(),
        f: vec![0.0; PAIRS],
    };
    let (now, arch) = (Now::default(), pulp::Arch::new());
    let time = seconds(|| {
        for _ in 0..ROUNDS {
            let pairs = black_box(&mut pairs);
            arch.dispatch(Lanes { law, now, pairs });
        }
        Ok(())
    })?;
    Ok(1e9 * time / (PAIRS * ROUNDS) as f64)
}

struct Pairs {
    r2: Vec<f64>,
    rv: Vec<f64>,
    noise: Vec<Site>,
    f: Vec<f64>,
}

struct Lanes<'a, L> {
    law: &'a L,
    now: Now,
    pairs: &'a mut Pairs,
}

impl<L: PairForce> pulp::NullaryFnOnce for Lanes<'_, L> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Pairs { r2, rv, noise, f } = self.pairs;
        let columns = r2.iter().zip(rv.iter()).zip(noise.iter());
        for (f, ((&r2, &rv), &noise)) in f.iter_mut().zip(columns) {
            let pair = Pair {
                r2,
                rv,
                noise,
                ..Pair::default()
            };
            *f = self.law.force(&pair, &self.now).total();
        }
    }
}
