//! Work in blocks that are cut by the problem, never by the machine: the same bits on any number of threads.

/// Calls `work(block, state)` for the state of every block, on whatever threads there are. For work on blocks of a
/// [`Neighbours`](crate::Neighbours) source.
pub fn each_block<S: Send>(states: &mut [S], work: impl Fn(usize, &mut S) + Sync + Send) {
    #[cfg(feature = "rayon")]
    if states.len() > 1 {
        use rayon::prelude::*;
        states
            .par_iter_mut()
            .enumerate()
            .for_each(|(block, state)| work(block, state));
        return;
    }
    for (block, state) in states.iter_mut().enumerate() {
        work(block, state);
    }
}

/// The same with two states a block.
pub(crate) fn each_block_of_two<S: Send, T: Send>(
    first: &mut [S],
    second: &mut [T],
    work: impl Fn(usize, &mut S, &mut T) + Sync + Send,
) {
    #[cfg(feature = "rayon")]
    if first.len() > 1 {
        use rayon::prelude::*;
        first
            .par_iter_mut()
            .zip(second)
            .enumerate()
            .for_each(|(block, (one, two))| work(block, one, two));
        return;
    }
    for (block, (one, two)) in first.iter_mut().zip(second).enumerate() {
        work(block, one, two);
    }
}

/// Calls `work(start, chunk)` for chunks of a column, on whatever threads there are. For work on each particle alone.
pub fn for_each_chunk<A: Send>(column: &mut [A], work: impl Fn(usize, &mut [A]) + Sync + Send) {
    const CHUNK: usize = 4096;
    #[cfg(feature = "rayon")]
    if column.len() > CHUNK {
        use rayon::prelude::*;
        column
            .par_chunks_mut(CHUNK)
            .enumerate()
            .for_each(|(k, chunk)| work(k * CHUNK, chunk));
        return;
    }
    for (k, chunk) in column.chunks_mut(CHUNK).enumerate() {
        work(k * CHUNK, chunk);
    }
}

/// Gives a column a length and each of its entries a value, on whatever threads there are.
pub(crate) fn fill_with<A: Copy + Default + Send>(
    column: &mut Vec<A>,
    len: usize,
    value: impl Fn(usize) -> A + Sync + Send,
) {
    column.resize(len, A::default());
    for_each_chunk(column, |start, chunk| {
        for (k, entry) in (start..).zip(chunk) {
            *entry = value(k);
        }
    });
}

/// An ensemble: runs `work` for the replicas 0, 1, .. on whatever threads there are, and gives what it answers in order.
///
/// Replicas are independent scenes, best small ones, each with a seed of its own; the bits of the answers are the same
/// on any number of threads.
///
/// ```
/// use zimm_core::{Clock, DVec3, Open, Particles, System, replicas};
///
/// let times = replicas(3, |replica| {
///     let particles = Particles::new(vec![DVec3::ZERO])?;
///     let mut system = System::new(Open, particles, Clock::new(0.1, 1.0, 40 + replica)?);
///     // ... steps ...
///     system.clock.tick();
///     Ok::<_, Box<dyn std::error::Error + Send + Sync>>(system.clock.now().time)
/// })?;
/// assert_eq!(times, [0.1, 0.1, 0.1]);
/// # Ok::<(), Box<dyn std::error::Error + Send + Sync>>(())
/// ```
///
/// # Errors
/// The first error, in the order of replicas.
pub fn replicas<A: Send, E: Send>(
    count: u64,
    work: impl Fn(u64) -> Result<A, E> + Sync + Send,
) -> Result<Vec<A>, E> {
    #[cfg(feature = "rayon")]
    let answers: Vec<_> = {
        use rayon::prelude::*;
        (0..count).into_par_iter().map(work).collect()
    };
    #[cfg(not(feature = "rayon"))]
    let answers: Vec<_> = (0..count).map(work).collect();
    answers.into_iter().collect()
}
