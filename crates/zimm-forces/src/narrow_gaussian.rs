//! Excluded volume of narrow Gaussians.

use crate::length::length;
use zimm_core::{Central, Now, Pair, PairForce, ParameterError};

/// The soft repulsion of excluded volume that tends to a delta function as its range goes to zero:
///
/// ```text
/// U = kT (z* / d*^3) (exp(-r^2 / 2 d*^2) - exp(-c^2 / 2))      r < c d*
/// F = kT (z* / d*^5) r exp(-r^2 / 2 d*^2)
/// ```
///
/// The limit is U = v kT delta(r) with v = (2 pi)^(3/2) z*, so z* has the unit of a volume, or none in units of
/// (kT / H)^1/2. The force is cut and not shifted. At the cutoff of 5 d* that [`new`](Self::new) takes it jumps by
/// 3.1e-5 of its maximum, which is at d*, and the energy is lowered by 3.7e-6 of its value at contact: the moments of
/// a dumbbell at rest and in extension change by less than 3e-5.
/// Prakash and Ottinger, Macromolecules 32, 2028 (1999).
///
/// ```
/// use zimm_core::{Now, Pair, PairForce};
/// use zimm_forces::NarrowGaussian;
///
/// let law = NarrowGaussian::new(10.0, 0.5)?;
/// let pair = Pair { r2: 0.25, ..Pair::default() };
/// assert!((law.force(&pair, &Now::default()).total() - 320.0 * (-0.5_f64).exp()).abs() < 1e-12);
/// assert!((law.energy(&pair) - 80.0 * (-0.5_f64).exp()).abs() < 80.0 * 3.8e-6);
/// # Ok::<(), zimm_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NarrowGaussian {
    /// U at contact, kT z* / d*^3, and what is left of it at the cutoff.
    contact: f64,
    left: f64,
    /// F/r at contact, kT z* / d*^5.
    strength: f64,
    /// 1 / 2 d*^2.
    decay: f64,
    cutoff: f64,
}

impl NarrowGaussian {
    /// Strength z* and range d* in units of kT and of any length, up to 5 d*.
    ///
    /// # Errors
    /// As [`with_cutoff`](Self::with_cutoff).
    pub fn new(z_star: f64, d_star: f64) -> Result<Self, ParameterError> {
        Self::with_cutoff(z_star, d_star, 1.0, 5.0)
    }

    /// Strength z* (length cubed), range d* (length), thermal energy, and the cutoff in units of d*. The force at a
    /// cutoff c is c exp((1 - c^2) / 2) of its maximum.
    ///
    /// # Errors
    /// If the strength or `kt` is not finite or below zero, the range is not between 1e-100 and 1e100, the cutoff not
    /// between 1 and 30, or the energy or F/r at contact not finite.
    pub fn with_cutoff(
        z_star: f64,
        d_star: f64,
        kt: f64,
        cutoff: f64,
    ) -> Result<Self, ParameterError> {
        let z_star = ParameterError::non_negative("z*", z_star)?;
        let kt = ParameterError::non_negative("kt", kt)?;
        let d_star = length("d*", d_star)?;
        if !(1.0..=30.0).contains(&cutoff) {
            return Err(ParameterError::new("cutoff", cutoff, "between 1 and 30"));
        }
        let contact = kt * z_star / d_star / d_star / d_star;
        let contact = ParameterError::finite("energy at contact", contact)?;
        let strength = ParameterError::finite("F/r at contact", contact / d_star / d_star)?;
        Ok(Self {
            contact,
            left: contact * exponential(-0.5 * cutoff * cutoff),
            strength,
            decay: 0.5 / (d_star * d_star),
            cutoff: cutoff * d_star,
        })
    }

    /// exp(-r^2 / 2 d*^2).
    #[inline(always)]
    fn gaussian(&self, r2: f64) -> f64 {
        let far = self.cutoff * self.cutoff;
        exponential(-self.decay * r2.min(far))
    }
}

impl PairForce for NarrowGaussian {
    #[inline(always)]
    fn cutoff(&self) -> f64 {
        self.cutoff
    }

    #[inline(always)]
    fn force(&self, pair: &Pair, _: &Now) -> Central {
        let f = self.strength * self.gaussian(pair.r2);
        let within = pair.r2 < self.cutoff * self.cutoff;
        Central::conservative(if within { f } else { 0.0 })
    }

    #[inline(always)]
    fn energy(&self, pair: &Pair) -> f64 {
        let within = pair.r2 < self.cutoff * self.cutoff;
        let energy = self.contact * self.gaussian(pair.r2) - self.left;
        if within { energy } else { 0.0 }
    }
}

/// e^x for x between -700 and 0, to two units in the last place: without branches and calls, so that it runs in lanes,
/// and by additions and multiplications alone, so that its bits are the same everywhere.
///
/// e^x = 2^k e^y with an integer k and |y| <= ln 2 / 2, and Taylor's series for e^y.
#[inline(always)]
fn exponential(x: f64) -> f64 {
    /// Adding 3 2^51 leaves the nearest integer in the last bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    /// ln 2 in two parts, of which the first has zeros at the end: k times it is exact.
    const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
    /// 1 / n!, n from 13 to 0.
    const TERMS: [f64; 14] = [
        1.0 / 6_227_020_800.0,
        1.0 / 479_001_600.0,
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5_040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        1.0 / 2.0,
        1.0,
        1.0,
    ];
    let shifted = x * std::f64::consts::LOG2_E + ROUND;
    let k = shifted - ROUND;
    let y = (x - k * LN_2[0]) - k * LN_2[1];
    let series = TERMS.iter().fold(0.0, |sum, term| sum * y + term);
    let power = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0_f64.to_bits()));
    power * series
}
