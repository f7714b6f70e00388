//! Runs that take turns.

use crate::Problem;
use cpu_time::ThreadTime;

/// Something to be timed; it answers how long it took.
pub(crate) type Run<'a> = Box<dyn FnMut() -> Result<f64, Problem> + 'a>;

/// CPU time of this thread in seconds.
pub(crate) fn seconds(run: impl FnOnce() -> Result<(), Problem>) -> Result<f64, Problem> {
    let start = ThreadTime::now();
    run()?;
    Ok(start.elapsed().as_secs_f64())
}

/// All runs once, which does not count, and then five times in turn; the median of each.
pub(crate) fn medians<const N: usize>(mut runs: [Run<'_>; N]) -> Result<[f64; N], Problem> {
    const ROUNDS: usize = 5;
    let mut times = [[0.0; ROUNDS]; N];
    for run in &mut runs {
        run()?;
    }
    for round in 0..ROUNDS {
        for (run, times) in runs.iter_mut().zip(&mut times) {
            times[round] = run()?;
        }
    }
    Ok(times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[ROUNDS / 2]
    }))
}
