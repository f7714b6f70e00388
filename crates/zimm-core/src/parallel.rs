//! Work in blocks that are cut by the problem, never by the machine: the same bits on any number of threads.

/// Runs `work` on every block's state.
pub(crate) fn each_block<S: Send>(states: &mut [S], work: impl Fn(usize, &mut S) + Sync + Send) {
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
