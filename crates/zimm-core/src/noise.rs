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

mod normal;

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
    /// The random displacements of Brownian dynamics.
    pub const BROWNIAN: Self = Self(3);
    /// The random waves of a Brownian displacement that is drawn in reciprocal space.
    pub const BROWNIAN_WAVES: Self = Self(4);

    /// When in a step a pair's turn comes, for schemes that treat pairs one after another.
    pub const PAIR_TURN: Self = Self(10);
    /// The new relative velocity of a pair in such a scheme.
    pub const PAIR_KICK: Self = Self(11);

    /// The same consumer, when it draws again what it has drawn already in this step: attempt 0 is the domain itself,
    /// and attempts below 2^31 are kept apart.
    pub const fn again(self, attempt: u32) -> Self {
        Self(self.0 ^ (attempt as u64) << 33)
    }

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
    #[inline(always)]
    pub fn normal(self, domain: Domain) -> f64 {
        normal::pair(self.word(domain)).0
    }

    /// Three independent normal numbers of mean zero and variance one.
    #[inline]
    pub fn normal3(self, domain: Domain) -> DVec3 {
        normal3(self.word(domain))
    }
}

/// Three independent normal numbers for each entry of a column, in SIMD lanes: what [`Site::normal3`] makes of the words
/// at the places 0, 1, ..
///
/// ```
/// use zimm_core::DVec3;
/// use zimm_core::noise::{Domain, Noise, fill_normal3};
///
/// let (noise, domain) = (Noise::new(1, 2), Domain::user(3));
/// let mut column = vec![DVec3::ZERO; 100];
/// fill_normal3(&mut column, |place| noise.site(place as u32).word(domain));
/// assert_eq!(column[99], noise.site(99).normal3(domain));
/// ```
pub fn fill_normal3(column: &mut [DVec3], word: impl Fn(usize) -> u64) {
    pulp::Arch::new().dispatch(Fill(column, word));
}

struct Fill<'a, W>(&'a mut [DVec3], W);

impl<W: Fn(usize) -> u64> pulp::NullaryFnOnce for Fill<'_, W> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        const RUN: usize = 8;
        let Self(column, word) = self;
        for (start, run) in (0..).step_by(RUN).zip(column.chunks_mut(RUN)) {
            let (mut words, mut numbers) = ([0; RUN], [[0.0; RUN]; 3]);
            for (k, slot) in words.iter_mut().enumerate().take(run.len()) {
                *slot = word(start + k);
            }
            let [x, y, z] = &mut numbers;
            for k in 0..RUN {
                (x[k], y[k]) = normal::pair(words[k]);
            }
            for k in 0..RUN {
                z[k] = normal::pair(second(words[k])).0;
            }
            for (k, entry) in run.iter_mut().enumerate() {
                *entry = DVec3::new(x[k], y[k], z[k]);
            }
        }
    }
}

#[inline(always)]
fn normal3(word: u64) -> DVec3 {
    let (x, y) = normal::pair(word);
    let (z, _) = normal::pair(second(word));
    DVec3::new(x, y, z)
}

/// The word of the third number.
#[inline(always)]
fn second(word: u64) -> u64 {
    mix(word.wrapping_add(GOLDEN))
}

#[inline(always)]
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    //! Statistical tests draw 1e6 numbers at fixed addresses (seed 2024 unless said otherwise). Every statistic is
    //! compared with its exact expectation within five of its own standard errors, which are those of independent
    //! draws: 1e-3 sqrt(variance of the summand). A covariance of 0.005 or a variance wrong by 0.5 % is caught.

    use super::*;

    const DRAWS: u64 = 1_000_000;
    const SEED: u64 = 2024;

    /// A distribution and its even moments.
    struct Law {
        name: &'static str,
        draw: fn(Site, Domain) -> f64,
        cumulative: fn(f64) -> f64,
        fourth: f64,
        sixth: f64,
        eighth: f64,
    }

    const UNIFORM: Law = Law {
        name: "uniform",
        draw: Site::uniform,
        cumulative: |x| 0.5 + x / 12.0_f64.sqrt(),
        fourth: 9.0 / 5.0,
        sixth: 27.0 / 7.0,
        eighth: 9.0,
    };

    const NORMAL: Law = Law {
        name: "normal",
        draw: Site::normal,
        cumulative: |x| 0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2),
        fourth: 3.0,
        sixth: 15.0,
        eighth: 105.0,
    };

    /// The sum of a statistic over `draws` draws, whose summand has this mean and variance if the noise is right.
    #[derive(Clone, Copy)]
    struct Sum {
        what: &'static str,
        mean: f64,
        variance: f64,
        sum: f64,
        draws: u64,
    }

    impl Sum {
        fn new(what: &'static str, mean: f64, variance: f64) -> Self {
            let (sum, draws) = (0.0, 0);
            Self {
                what,
                mean,
                variance,
                sum,
                draws,
            }
        }

        fn push(&mut self, x: f64) {
            self.sum += x;
            self.draws += 1;
        }

        fn check(&self, case: &str) {
            let found = self.sum / self.draws as f64;
            let sigmas = (found - self.mean) / (self.variance / self.draws as f64).sqrt();
            let (what, mean) = (self.what, self.mean);
            assert!(
                sigmas.abs() < 5.0,
                "{case}: {what} is {found}, not {mean}: {sigmas} sigma"
            );
        }
    }

    /// Counts in 256 bins of equal probability; chi-square has mean 255 and standard deviation sqrt(510).
    struct Bins {
        what: &'static str,
        counts: [u64; 256],
    }

    impl Bins {
        fn new(what: &'static str) -> Self {
            let counts = [0; 256];
            Self { what, counts }
        }

        fn push(&mut self, bin: u64) {
            self.counts[bin as usize & 255] += 1;
        }

        fn check(&self, case: &str) {
            let expected = self.counts.iter().sum::<u64>() as f64 / 256.0;
            let square = |&count: &u64| (count as f64 - expected).powi(2) / expected;
            let chi_square: f64 = self.counts.iter().map(square).sum();
            let sigmas = (chi_square - 255.0) / 510.0_f64.sqrt();
            let what = self.what;
            assert!(
                sigmas.abs() < 5.0,
                "{case}: chi-square of {what} is {chi_square}: {sigmas} sigma"
            );
        }
    }

    fn pair(seed: u64, step: u64, i: u32, j: u32) -> Site {
        let noise = Noise::new(seed, step);
        noise.site(i) + noise.site(j)
    }

    /// A thousand identities at each of a thousand steps.
    fn address(k: u64) -> (u64, u32) {
        (k / 1000, (k % 1000) as u32)
    }

    /// Two streams of draws are independent: no covariance of values, of squares, of values with squares, and no
    /// structure in the joint histogram of either half of the words.
    fn assert_independent(case: &str, draws: impl Fn(u64) -> [(Site, Domain); 2]) {
        for law in [UNIFORM, NORMAL] {
            let spread = law.fourth - 1.0;
            let mut sums = [
                Sum::new("<x y>", 0.0, 1.0),
                Sum::new("<(x^2 - 1) (y^2 - 1)>", 0.0, spread * spread),
                Sum::new("<x (y^2 - 1)>", 0.0, spread),
                Sum::new("<(x^2 - 1) y>", 0.0, spread),
            ];
            for k in 0..DRAWS {
                let [x, y] = draws(k).map(|(site, domain)| (law.draw)(site, domain));
                let (x2, y2) = (x * x - 1.0, y * y - 1.0);
                for (sum, term) in sums.iter_mut().zip([x * y, x2 * y2, x * y2, x2 * y]) {
                    sum.push(term);
                }
            }
            for sum in sums {
                sum.check(&format!("{case}, {}", law.name));
            }
        }
        let (mut high, mut low) = (Bins::new("upper halves"), Bins::new("lower halves"));
        for k in 0..DRAWS {
            let [x, y] = draws(k).map(|(site, domain)| site.word(domain));
            high.push((x >> 60) << 4 | y >> 60);
            low.push((x >> 28 & 15) << 4 | (y >> 28 & 15));
        }
        high.check(case);
        low.check(case);
    }

    // Words: the mapping of the module's head in Python integers, whose `mix` was first held against the published
    // SplitMix64 sequence (seed 1234567 begins with 6457827717110365317). Uniform and normal numbers: from these
    // words with 40 digits, rounded.
    #[test]
    fn reference_known_answers_pin_the_mapping() {
        let one = |seed, step, i| Noise::new(seed, step).site(i);
        let answers = [
            (
                one(0, 0, 0),
                Domain::DPD,
                0x7999_bbea_f24e_4213,
                -0.086_595_454_565_927_65,
                [
                    1.151_917_868_786_473,
                    -0.402_439_512_596_653_06,
                    0.241_068_939_223_202_33,
                ],
            ),
            (
                one(42, 7, 3),
                Domain::LANGEVIN,
                0x700d_1431_8c82_f2e4,
                -0.215_815_027_505_716_68,
                [
                    -1.225_340_932_886_093_4,
                    -0.388_567_423_090_960_7,
                    0.408_279_590_976_879_3,
                ],
            ),
            (
                one(u64::MAX, u64::MAX, u32::MAX),
                Domain::user(9),
                0x6dae_e38e_b0f7_d361,
                -0.247_857_015_209_455_38,
                [
                    -0.469_529_548_899_953_74,
                    -1.214_374_408_730_878_5,
                    -0.074_315_562_429_809_95,
                ],
            ),
            (
                pair(42, 7, 3, 5),
                Domain::DPD,
                0x7965_313e_b253_a913,
                -0.089_372_703_040_804_39,
                [
                    -0.402_298_498_002_856_2,
                    -1.153_432_602_036_347_2,
                    0.193_087_697_618_591_57,
                ],
            ),
            (
                pair(1 << 63, 1_000_000, 999_999, u32::MAX - 1),
                Domain::DPD,
                0x352e_0e76_bf3a_57bd,
                -1.012_439_065_804_503,
                [
                    -0.033_593_748_894_927_36,
                    -1.772_530_685_294_999_6,
                    -0.071_729_529_103_864_97,
                ],
            ),
        ];
        for (site, domain, word, uniform, normal) in answers {
            assert_eq!(site.word(domain), word);
            assert!((site.uniform(domain) - uniform).abs() < 1e-15);
            assert!((site.normal(domain) - normal[0]).abs() < 4e-15);
            assert!(
                (site.normal3(domain) - DVec3::from_array(normal))
                    .abs()
                    .max_element()
                    < 4e-15
            );
        }
    }

    #[test]
    fn law_a_pair_is_the_same_from_both_ends() {
        for k in 0..1000 {
            let (i, j) = (k, 7919 * k + 1);
            assert_eq!(pair(SEED, 5, i, j), pair(SEED, 5, j, i));
        }
    }

    #[test]
    fn reference_moments_and_histograms_of_the_distributions() {
        for law in [UNIFORM, NORMAL] {
            for (case, site) in [
                (
                    "one",
                    (|k| Noise::new(SEED, k / 1000).site((k % 1000) as u32)) as fn(u64) -> Site,
                ),
                ("two", |k| pair(SEED, k / 1000, (k % 1000) as u32, 1000)),
            ] {
                let mut moments = [
                    Sum::new("<x>", 0.0, 1.0),
                    Sum::new("<x^2>", 1.0, law.fourth - 1.0),
                    Sum::new("<x^3>", 0.0, law.sixth),
                    Sum::new("<x^4>", law.fourth, law.eighth - law.fourth * law.fourth),
                ];
                let mut bins = Bins::new("the cumulative distribution");
                for k in 0..DRAWS {
                    let x = (law.draw)(site(k), Domain::DPD);
                    for (moment, power) in moments.iter_mut().zip(1..) {
                        moment.push(x.powi(power));
                    }
                    bins.push((256.0 * (law.cumulative)(x)) as u64);
                }
                let case = format!("{}, {case}", law.name);
                for moment in moments {
                    moment.check(&case);
                }
                bins.check(&case);
            }
        }
    }

    #[test]
    fn reference_three_normals_are_independent() {
        let mut sums = [[
            Sum::new("a component", 0.0, 1.0),
            Sum::new("its square", 1.0, 2.0),
            Sum::new("its fourth power", 3.0, 96.0),
            Sum::new("a product of two", 0.0, 1.0),
            Sum::new("a product of squares", 0.0, 4.0),
        ]; 3];
        let mut radius = Bins::new("the radius");
        for k in 0..DRAWS {
            let (step, i) = address(k);
            let v = Noise::new(SEED, step).site(i).normal3(Domain::LANGEVIN);
            for (axis, sums) in sums.iter_mut().enumerate() {
                let (x, y) = (v[axis], v[(axis + 1) % 3]);
                let terms = [x, x * x, x.powi(4), x * y, (x * x - 1.0) * (y * y - 1.0)];
                for (sum, term) in sums.iter_mut().zip(terms) {
                    sum.push(term);
                }
            }
            // Maxwell's distribution of the length of three normal numbers.
            let r = v.length();
            let below = libm::erf(r / 2.0_f64.sqrt())
                - (2.0 / std::f64::consts::PI).sqrt() * r * libm::exp(-0.5 * r * r);
            radius.push((256.0 * below) as u64);
        }
        for sum in sums.as_flattened() {
            sum.check("three normals");
        }
        radius.check("three normals");
    }

    #[test]
    fn law_pairs_that_share_a_particle_are_independent() {
        assert_independent("(i, i+1) and (i, i+2)", |k| {
            let (step, i) = address(k);
            [
                (pair(SEED, step, i, i + 1), Domain::DPD),
                (pair(SEED, step, i, i + 2), Domain::DPD),
            ]
        });
        assert_independent("a pair and its first particle", |k| {
            let (step, i) = address(k);
            [
                (pair(SEED, step, i, i + 1), Domain::DPD),
                (Noise::new(SEED, step).site(i), Domain::DPD),
            ]
        });
    }

    #[test]
    fn law_neighbouring_identities_are_independent() {
        assert_independent("i and i+1", |k| {
            let (step, i) = address(k);
            let noise = Noise::new(SEED, step);
            [
                (noise.site(i), Domain::LANGEVIN),
                (noise.site(i + 1), Domain::LANGEVIN),
            ]
        });
        assert_independent("(i, i+500) and (i+1, i+501)", |k| {
            let (step, i) = address(k);
            [
                (pair(SEED, step, i, i + 500), Domain::DPD),
                (pair(SEED, step, i + 1, i + 501), Domain::DPD),
            ]
        });
    }

    #[test]
    fn law_consecutive_steps_are_independent() {
        assert_independent("a particle at two steps", |k| {
            let (step, i) = address(k);
            [
                (Noise::new(SEED, step).site(i), Domain::LANGEVIN),
                (Noise::new(SEED, step + 1).site(i), Domain::LANGEVIN),
            ]
        });
        assert_independent("a pair at two steps", |k| {
            let (step, i) = address(k);
            [
                (pair(SEED, step, i, i + 1), Domain::DPD),
                (pair(SEED, step + 1, i, i + 1), Domain::DPD),
            ]
        });
    }

    #[test]
    fn law_neighbouring_seeds_are_independent() {
        assert_independent("seeds s and s+1", |k| {
            let (step, i) = address(k);
            [
                (pair(SEED, step, i, i + 1), Domain::DPD),
                (pair(SEED + 1, step, i, i + 1), Domain::DPD),
            ]
        });
        assert_independent(
            "a seed at each draw, and the next seed a step before",
            |k| {
                [
                    (pair(k, 1, 0, 1), Domain::DPD),
                    (pair(k + 1, 0, 0, 1), Domain::DPD),
                ]
            },
        );
        assert_independent("seeds that differ in the highest bit", |k| {
            let (step, i) = address(k);
            [
                (pair(SEED, step, i, i + 1), Domain::DPD),
                (pair(SEED | 1 << 63, step, i, i + 1), Domain::DPD),
            ]
        });
    }

    #[test]
    fn law_the_first_attempt_is_the_domain_itself() {
        assert_eq!(Domain::BROWNIAN.again(0), Domain::BROWNIAN);
        let last = (1 << 31) - 1;
        assert_ne!(Domain::user(1).again(last), Domain::user(1));
    }

    #[test]
    fn law_domains_are_independent() {
        for [first, second] in [
            [Domain::DPD, Domain::LANGEVIN],
            [Domain::PAIR_TURN, Domain::PAIR_KICK],
            [Domain::DPD, Domain::user(1)],
            [Domain::user(0), Domain::user(1)],
            [Domain::BROWNIAN, Domain::BROWNIAN.again(1)],
            [Domain::BROWNIAN.again(1), Domain::BROWNIAN.again(2)],
        ] {
            assert_independent(&format!("{first:?} and {second:?}"), |k| {
                let (step, i) = address(k);
                let site = pair(SEED, step, i, i + 1);
                [(site, first), (site, second)]
            });
        }
    }

    /// A pair's word comes from a sum of two sites, so the sums around a cycle of four, taken with alternating signs,
    /// cancel: without the last `mix` every combination below would be zero.
    #[test]
    fn law_cycles_of_pairs_are_independent() {
        for law in [UNIFORM, NORMAL] {
            let spread = law.fourth - 1.0;
            let mut sums = [
                Sum::new("x_ij x_jk x_ki", 0.0, 1.0),
                Sum::new(
                    "(x_ij^2 - 1) (x_jk^2 - 1) (x_ki^2 - 1)",
                    0.0,
                    spread.powi(3),
                ),
                Sum::new("x_ij x_jk x_kl x_li", 0.0, 1.0),
                Sum::new("(x_ij^2 - 1) .. (x_li^2 - 1)", 0.0, spread.powi(4)),
                Sum::new("(x_ij - x_jk + x_kl - x_li)^2", 4.0, 4.0 * spread + 24.0),
            ];
            let mut bins = Bins::new("w_ij - w_jk + w_kl - w_li");
            for n in 0..DRAWS {
                let (step, i) = address(n);
                let site = |particle| Noise::new(SEED, step).site(particle);
                let sites = [site(i), site(i + 1), site(i + 2), site(i + 3)];
                let around = |m: usize| sites[m] + sites[(m + 1) % 4];
                let x = [0, 1, 2, 3].map(|m| (law.draw)(around(m), Domain::DPD));
                let closing = (law.draw)(sites[2] + sites[0], Domain::DPD);
                let three = [x[0], x[1], closing];
                let terms = [
                    three.iter().product(),
                    three.iter().map(|x| x * x - 1.0).product(),
                    x.iter().product(),
                    x.iter().map(|x| x * x - 1.0).product(),
                    (x[0] - x[1] + x[2] - x[3]).powi(2),
                ];
                for (sum, term) in sums.iter_mut().zip(terms) {
                    sum.push(term);
                }
                let w = [0, 1, 2, 3].map(|m| around(m).word(Domain::DPD));
                bins.push(
                    w[0].wrapping_sub(w[1])
                        .wrapping_add(w[2])
                        .wrapping_sub(w[3])
                        >> 56,
                );
            }
            for sum in sums {
                sum.check(law.name);
            }
            bins.check(law.name);
        }
    }

    /// What a fluid sees: the noise on one particle from twelve neighbours, and on one pair over twelve steps. A sum
    /// of m independent numbers has the variance m and the fourth moment 3 m^2 + m (x4 - 3). The standard error of
    /// the variance is 0.14 %, so a temperature wrong by 0.7 % is caught.
    #[test]
    fn law_forces_add_up_as_independent_ones() {
        const M: u32 = 12;
        let m = f64::from(M);
        for law in [UNIFORM, NORMAL] {
            let fourth = 3.0 * m * m + m * (law.fourth - 3.0);
            let variance = fourth - m * m;
            let mut space = Sum::new("<(sum over neighbours)^2>", m, variance);
            let mut time = Sum::new("<(sum over steps)^2>", m, variance);
            for k in 0..DRAWS {
                let (step, i) = address(k);
                let noise = Noise::new(SEED, step);
                let centre = (M + 1) * i;
                let neighbours = (1..=M).map(|n| noise.site(centre) + noise.site(centre + n));
                let neighbours = neighbours.map(|site| (law.draw)(site, Domain::DPD));
                space.push(neighbours.sum::<f64>().powi(2));
                let steps = (0..u64::from(M)).map(|n| {
                    let step = u64::from(M) * step + n;
                    (law.draw)(pair(SEED, step, i, i + 1), Domain::DPD)
                });
                time.push(steps.sum::<f64>().powi(2));
            }
            space.check(law.name);
            time.check(law.name);
        }
    }
}
