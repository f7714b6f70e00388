//! Columns in pieces, with something of its own for each: cut by the problem, the same bits on any number of threads.

/// Calls `work(k, piece, state)` for pieces of `size` entries of a column and one state each, on whatever threads there
/// are. Nothing is asked of the heap.
pub(crate) fn each_piece<A: Send, S: Send>(
    column: &mut [A],
    size: usize,
    states: &mut [S],
    work: impl Fn(usize, &mut [A], &mut S) + Sync,
) {
    each_from(0, column, size, states, &work);
}

fn each_from<A: Send, S: Send>(
    first: usize,
    column: &mut [A],
    size: usize,
    states: &mut [S],
    work: &(impl Fn(usize, &mut [A], &mut S) + Sync),
) {
    if column.len() <= size {
        if let (false, Some(state)) = (column.is_empty(), states.first_mut()) {
            work(first, column, state);
        }
        return;
    }
    let middle = column.len().div_ceil(size) / 2;
    let (low, high) = column.split_at_mut(middle * size);
    let (these, those) = states.split_at_mut(middle.min(states.len()));
    #[cfg(feature = "rayon")]
    rayon::join(
        || each_from(first, low, size, these, work),
        || each_from(first + middle, high, size, those, work),
    );
    #[cfg(not(feature = "rayon"))]
    {
        each_from(first, low, size, these, work);
        each_from(first + middle, high, size, those, work);
    }
}
