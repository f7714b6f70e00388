//! A run of any length in a fixed number of parts.

/// What equal stretches of a run have shown, each a `T`. There are never more than `most` complete ones: two become
/// one when there would be, so memory does not grow with the run.
#[derive(Clone, Debug)]
pub(crate) struct Segments<T> {
    complete: Vec<T>,
    open: T,
    most: usize,
    length: u64,
    filled: u64,
}

/// What two stretches of a run can be made one by.
pub(crate) trait Join: Clone + Default {
    /// Adds what a later stretch has shown.
    fn join(&mut self, later: &Self);
}

impl<T: Join> Segments<T> {
    /// None yet; `most` is even and above zero.
    pub(crate) fn new(most: usize) -> Self {
        Self {
            complete: Vec::with_capacity(most),
            open: T::default(),
            most,
            length: 1,
            filled: 0,
        }
    }

    /// As another was: stretches of so many samples that are complete, and one that is open with what it has.
    pub(crate) fn resumed(
        most: usize,
        (complete, length): (Vec<T>, u64),
        (open, filled): (T, u64),
    ) -> Self {
        Self {
            complete,
            open,
            most,
            length,
            filled,
        }
    }

    /// Adds one sample to the stretch that is open.
    pub(crate) fn add(&mut self, take: impl FnOnce(&mut T)) {
        take(&mut self.open);
        self.filled += 1;
        if self.filled < self.length {
            return;
        }
        self.filled = 0;
        self.complete.push(std::mem::take(&mut self.open));
        if self.complete.len() == self.most {
            self.complete = grouped(&self.complete, 2);
            self.length *= 2;
        }
    }

    pub(crate) fn complete(&self) -> &[T] {
        &self.complete
    }

    /// What is not a whole stretch yet.
    pub(crate) fn open(&self) -> &T {
        &self.open
    }

    /// Samples in the open stretch.
    pub(crate) fn filled(&self) -> u64 {
        self.filled
    }

    /// Samples in a complete stretch.
    pub(crate) fn length(&self) -> u64 {
        self.length
    }
}

/// Every `size` stretches joined to one, counted from the end; what is left at the beginning is left out.
pub(crate) fn grouped<T: Join>(stretches: &[T], size: usize) -> Vec<T> {
    let join = |group: &[T]| {
        let mut sum = T::default();
        group.iter().for_each(|stretch| sum.join(stretch));
        sum
    };
    let mut groups: Vec<T> = stretches.rchunks_exact(size).map(join).collect();
    groups.reverse();
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Join for Vec<u32> {
        fn join(&mut self, later: &Self) {
            self.extend(later);
        }
    }

    #[test]
    fn law_stretches_are_equal_and_hold_every_sample_once_and_in_order() {
        let mut segments = Segments::<Vec<u32>>::new(8);
        for sample in 0..1000 {
            segments.add(|open| open.push(sample));
            let length = segments.length();
            assert!(segments.complete().len() < 8);
            assert!(segments.complete().iter().all(|s| s.len() as u64 == length));
            let all = segments.complete().concat();
            let all: Vec<u32> = all.into_iter().chain(segments.open().clone()).collect();
            assert!(all.into_iter().eq(0..=sample));
        }
        assert_eq!((segments.length(), segments.complete().len()), (128, 7));
        let pairs = grouped(segments.complete(), 2);
        assert_eq!((pairs.len(), pairs[0][0], pairs[2].len()), (3, 128, 256));
    }
}
