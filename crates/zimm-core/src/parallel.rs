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
    for_each_chunk_of(column, work);
}

/// The same for several columns at once: see [`Cut`].
///
/// ```
/// use zimm_core::for_each_chunk_of;
///
/// let (mut places, mut speeds) = (vec![0.0; 9000], vec![2.0; 9000]);
/// for_each_chunk_of((&mut places[..], &mut speeds[..]), |start, (places, speeds)| {
///     for (k, (place, speed)) in places.iter_mut().zip(speeds).enumerate() {
///         *speed *= 0.5;
///         *place = *speed + (start + k) as f64;
///     }
/// });
/// assert_eq!(places[8999], 9000.0);
/// ```
pub fn for_each_chunk_of<C: Cut>(columns: C, work: impl Fn(usize, C) + Sync + Send) {
    each_chunk_from(0, columns, &work);
}

fn each_chunk_from<C: Cut>(start: usize, columns: C, work: &(impl Fn(usize, C) + Sync + Send)) {
    const CHUNK: usize = 4096;
    let chunks = columns.len().div_ceil(CHUNK);
    if chunks < 2 {
        if chunks == 1 {
            pulp::Arch::new().dispatch(Chunk(start, columns, work));
        }
        return;
    }
    let middle = chunks / 2 * CHUNK;
    let (first, second) = columns.cut(middle);
    let one = || each_chunk_from(start, first, work);
    let other = || each_chunk_from(start + middle, second, work);
    #[cfg(feature = "rayon")]
    rayon::join(one, other);
    #[cfg(not(feature = "rayon"))]
    {
        one();
        other();
    }
}

/// Work on one chunk, compiled once for every instruction set.
struct Chunk<'a, C, W>(usize, C, &'a W);

impl<C: Cut, W: Fn(usize, C)> pulp::NullaryFnOnce for Chunk<'_, C, W> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self(start, columns, work) = self;
        work(start, columns);
    }
}

/// Columns that are cut at the same place: slices, and pairs of what can be cut. All are of one length, or have no entries
/// at all.
#[allow(clippy::len_without_is_empty)]
pub trait Cut: Send + Sized {
    /// Entries of the longest column.
    fn len(&self) -> usize;

    /// What is before an entry, and the rest.
    fn cut(self, at: usize) -> (Self, Self);
}

impl<A: Send> Cut for &mut [A] {
    fn len(&self) -> usize {
        <[A]>::len(self)
    }

    fn cut(self, at: usize) -> (Self, Self) {
        let at = at.min(<[A]>::len(self));
        self.split_at_mut(at)
    }
}

impl<C: Cut, D: Cut> Cut for (C, D) {
    fn len(&self) -> usize {
        self.0.len().max(self.1.len())
    }

    fn cut(self, at: usize) -> (Self, Self) {
        let ((a, b), (c, d)) = (self.0.cut(at), self.1.cut(at));
        ((a, c), (b, d))
    }
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
