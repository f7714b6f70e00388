//! Lengths, as parameters and as arguments of laws.

use zimm_core::ParameterError;

const LEAST: f64 = 1e-100;
const MOST: f64 = 1e100;

/// `value` if it is a length whose powers neither vanish nor overflow.
pub(crate) fn length(name: &'static str, value: f64) -> Result<f64, ParameterError> {
    if (LEAST..=MOST).contains(&value) {
        Ok(value)
    } else {
        let allowed = "between 1e-100 and 1e100";
        Err(ParameterError::new(name, value, allowed))
    }
}

/// The distance, kept off zero: coincident particles have no direction, so a finite F/r makes their force vanish.
#[inline(always)]
pub(crate) fn distance(r2: f64) -> f64 {
    r2.max(LEAST * LEAST).sqrt()
}
