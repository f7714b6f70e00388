//! Minima of functions of one variable and of few.

/// Where a function is least between two ends, by golden sections; it is taken to have one minimum there.
pub(crate) fn golden(function: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> f64 {
    /// The golden section.
    const SHARE: f64 = 0.618_033_988_749_894_9;
    /// A minimum is no better known than to the root of rounding.
    const STEPS: usize = 45;
    let (mut left, mut right) = (high - SHARE * (high - low), low + SHARE * (high - low));
    let (mut at_left, mut at_right) = (function(left), function(right));
    for _ in 0..STEPS {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - SHARE * (high - low);
            at_left = function(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + SHARE * (high - low);
            at_right = function(right);
        }
    }
    0.5 * (low + high)
}
