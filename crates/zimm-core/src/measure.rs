//! What is measured, and what becomes of a stream of measurements.

use crate::{Boundary, Frame};

/// A quantity of one frame. `T` is the tally that it needs: a stress cannot be asked of a scene that tallies `()`.
pub trait Observable<B: Boundary, T = ()> {
    /// What is measured.
    type Output;

    /// Measures it.
    fn measure(&mut self, frame: &Frame<'_, B>, tally: &T) -> Self::Output;
}

/// Nothing is measured: the null observable.
impl<B: Boundary, T> Observable<B, T> for () {
    type Output = ();

    fn measure(&mut self, _: &Frame<'_, B>, _: &T) {}
}

macro_rules! several_observables {
    ($($observable:ident . $n:tt),+) => {
        impl<S: Boundary, Y, $($observable: Observable<S, Y>),+> Observable<S, Y> for ($($observable,)+) {
            type Output = ($($observable::Output,)+);

            fn measure(&mut self, frame: &Frame<'_, S>, tally: &Y) -> Self::Output {
                ($(self.$n.measure(frame, tally),)+)
            }
        }
    };
}
several_observables!(A.0, B.1);
several_observables!(A.0, B.1, C.2);
several_observables!(A.0, B.1, C.2, D.3);

/// A statistic of a stream of samples.
pub trait Estimator {
    /// What comes in.
    type Sample;
    /// What comes out.
    type Estimate;

    /// Takes one sample.
    fn push(&mut self, sample: Self::Sample);

    /// The estimate so far.
    fn estimate(&self) -> Self::Estimate;
}

/// Nothing is kept: the null estimator.
impl Estimator for () {
    type Sample = ();
    type Estimate = ();

    fn push(&mut self, (): ()) {}

    fn estimate(&self) {}
}
