//! Functions of several independent means.

use crate::{Mean, StandardError};

/// A function of independent means, to first order: its value, and of each mean the derivative. Errors add in
/// quadrature; the error is a lower bound if one of theirs is.
pub(crate) fn of_independent<const N: usize>(value: f64, parts: [(f64, Mean); N]) -> Mean {
    let (mut square, mut spread, mut known) = (0.0, 0.0, true);
    for (slope, mean) in parts {
        let part = slope * slope * mean.at_least() * mean.at_least();
        square += part;
        match mean.error {
            StandardError::Plateau { uncertainty, .. } => {
                spread += slope * slope * slope * slope * (mean.at_least() * uncertainty).powi(2);
            }
            StandardError::AtLeast(_) => known = false,
        }
    }
    let error = square.sqrt();
    let error = if known {
        let uncertainty = if error > 0.0 {
            spread.sqrt() / error
        } else {
            0.0
        };
        StandardError::Plateau { error, uncertainty }
    } else {
        StandardError::AtLeast(error)
    };
    Mean { value, error }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_a_multiple_is_that_of_one_mean() {
        let mean = |value, error, uncertainty| Mean {
            value,
            error: StandardError::Plateau { error, uncertainty },
        };
        let a = mean(5.0, 3.0, 0.5);
        assert_eq!(of_independent(10.0, [(2.0, a)]), a.times(2.0));
        let short = Mean {
            value: 1.0,
            error: StandardError::AtLeast(4.0),
        };
        let found = of_independent(6.0, [(1.0, a), (1.0, short)]);
        assert_eq!(found.error, StandardError::AtLeast(5.0));
        assert_eq!(of_independent(3.0, [(0.0, a)]).at_least(), 0.0);
    }
}
