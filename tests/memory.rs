//! Memory does not grow with the run.
#![allow(clippy::unwrap_used)]

use peak_alloc::PeakAlloc;
use zimm::prelude::*;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Bytes that an estimator holds after 10^3, 10^4, ... samples, up to ten to this power.
fn held<E: Estimator>(
    fresh: impl FnOnce() -> E,
    sample: impl Fn(f64) -> E::Sample,
    power: u32,
) -> Vec<usize> {
    let before = MEMORY.current_usage();
    let (mut estimator, mut k) = (fresh(), 0_u64);
    (3..=power)
        .map(|power| {
            while k < 10_u64.pow(power) {
                estimator.push(sample((k * 2_654_435_769 % 1000) as f64));
                k += 1;
            }
            MEMORY.current_usage().saturating_sub(before)
        })
        .collect()
}

/// Averages hold a few kB after 10^3 and after 10^7 samples. Correlators hold 16 samples and at most 128 stretches of
/// 8 lags, in pairs of numbers, for each doubling: less than 20 kB for each scalar, below 600 kB in all; three numbers
/// a lag take displacements twice that. A history of all samples would be 80 MB. One test in one process, so that
/// nobody else allocates.
#[test]
fn law_memory_does_not_grow_with_the_run() {
    let averages = [
        ("BlockAverage", held(BlockAverage::new, |x| x, 7)),
        ("RatioAverage", held(RatioAverage::new, |x| [x, 1.0], 7)),
        ("SteadyAverage", held(SteadyAverage::new, |x| x, 7)),
        (
            "SlidingAverage",
            held(|| SlidingAverage::new(1 << 20).unwrap(), |x| x, 7),
        ),
    ];
    let correlators = [
        (
            "Autocorrelation",
            held(|| Autocorrelation::new(1.0).unwrap(), |x| x, 7),
        ),
        (
            "GreenKubo",
            held(
                || GreenKubo::new(1.0, 1.0, 1.0).unwrap(),
                |x| DMat3::IDENTITY * x,
                6,
            ),
        ),
        (
            "MeanSquareDisplacement",
            held(
                || MeanSquareDisplacement::new(1.0, 1..=2).unwrap(),
                |x| vec![DVec3::X * x],
                6,
            ),
        ),
    ];
    for (name, bytes) in averages.iter().chain(&correlators) {
        println!("{name}: {bytes:?}");
    }
    for (name, bytes) in averages {
        assert!(bytes.iter().all(|&bytes| bytes < 10_000), "{name}");
    }
    for (name, bytes) in correlators {
        let doublings = |k: usize| 10.0 + 3.4 * k as f64;
        for (k, &bytes) in bytes.iter().enumerate() {
            assert!((bytes as f64) < 50_000.0 * doublings(k), "{name}");
        }
    }
}
