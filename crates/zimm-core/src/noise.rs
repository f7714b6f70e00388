//! Addressed noise: a random number is a pure function of where it is used, never of what was drawn before.
//!
//! The address is (seed, step, domain, identity) or (seed, step, domain, identity, identity). The mapping, version 1:
//!
//! ```text
//! key  = mix(mix(seed + A) + step * A)           once a step
//! site = mix(key + (identity + 1) * A)           once a particle and step
//! one  = mix(site + domain * B)                  a particle's word
//! two  = mix(site_i + site_j + domain * B)       a pair's word, the same from both ends
//! ```
//!
//! in wrapping 64-bit arithmetic, with `mix` the finaliser of SplitMix64 (Steele, Lea and Flood 2014, constants of
//! Stafford's variant 13), `A` the golden ratio and `B` another odd constant. Nothing but multiplications, shifts and
//! exclusive ors of 64-bit words: a pair's word costs one `mix` and runs in SIMD lanes.
//!
//! Known answers in this module's tests pin the mapping; the family's tests check uniformity, and covariance between
//! pairs that share a particle, between successive steps and between neighbouring seeds.

use glam::DVec3;
use std::ops::Add;

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
const SPREAD: u64 = 0xd1b5_4a32_d192_ed03;

/// Version of the mapping from addresses to numbers; checkpoints carry it.
pub const MAPPING_VERSION: u32 = 1;

/// Who draws. Two consumers that read the same step and identities must differ here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Domain(u64);

impl Domain {
    /// The random force of DPD.
    pub const DPD: Self = Self(1);
    /// The random kicks of Langevin dynamics.
    pub const LANGEVIN: Self = Self(2);

    /// A domain for a law of your own: any number, kept apart from the family's.
    pub const fn user(number: u32) -> Self {
        Self(1 << 32 | number as u64)
    }
}

/// The noise of one step.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    key: u64,
}

impl Noise {
    /// The noise of a run's `seed` at `step`.
    pub fn new(seed: u64, step: u64) -> Self {
        let key = mix(mix(seed.wrapping_add(GOLDEN)).wrapping_add(step.wrapping_mul(GOLDEN)));
        Self { key }
    }

    /// The noise that belongs to one particle.
    #[inline(always)]
    pub fn site(&self, identity: u32) -> Site {
        let address = (identity as u64 + 1).wrapping_mul(GOLDEN);
        Site(mix(self.key.wrapping_add(address)))
    }
}

/// The noise of one particle, or of the sum of two: `a + b` is the noise of the pair, equal to `b + a`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(transparent)]
pub struct Site(u64);

impl Add for Site {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }
}

impl Site {
    /// 64 random bits.
    #[inline(always)]
    pub fn word(self, domain: Domain) -> u64 {
        mix(self.0.wrapping_add(domain.0.wrapping_mul(SPREAD)))
    }

    /// A number from the uniform distribution of mean zero and variance one, in [-sqrt 3, sqrt 3).
    #[inline(always)]
    pub fn uniform(self, domain: Domain) -> f64 {
        const SQRT_12: f64 = 3.464_101_615_137_754_6;
        let one_to_two = f64::from_bits(self.word(domain) >> 12 | 0x3ff0_0000_0000_0000);
        (one_to_two - 1.5) * SQRT_12
    }

    /// A number from the normal distribution of mean zero and variance one.
    #[inline]
    pub fn normal(self, domain: Domain) -> f64 {
        normal_pair(self.word(domain)).0
    }

    /// Three independent normal numbers of mean zero and variance one.
    #[inline]
    pub fn normal3(self, domain: Domain) -> DVec3 {
        let first = self.word(domain);
        let (x, y) = normal_pair(first);
        let (z, _) = normal_pair(mix(first.wrapping_add(GOLDEN)));
        DVec3::new(x, y, z)
    }
}

/// Box and Muller (1958) on the two halves of a word; the tail ends at 6.7 standard deviations.
#[inline]
fn normal_pair(word: u64) -> (f64, f64) {
    const UNIT: f64 = 1.0 / 4_294_967_296.0;
    let radius_draw = ((word >> 32) as f64 + 0.5) * UNIT;
    let angle_draw = ((word & 0xffff_ffff) as f64 + 0.5) * UNIT;
    let radius = (-2.0 * libm::log(radius_draw)).sqrt();
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * angle_draw);
    (radius * cos, radius * sin)
}

#[inline(always)]
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
