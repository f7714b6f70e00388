//! Whole-system forces and their sums.

use crate::{Boundary, ForceError, Frame, Reads, Tally};
use glam::DVec3;

/// Anything that adds forces to particles: pairs, bonds, body forces. A tuple is a sum, `()` is no force.
///
/// A force is a function of the frame and of nothing else, up to rounding: lists and buffers that an implementation
/// keeps may change the order of its sums but not what is summed.
pub trait ForceField<B: Boundary> {
    /// Whether there are any forces; `false` takes out what a stepper would do for them alone.
    const ACTS: bool = true;

    /// What the parts read; a stepper prepares no velocities that nobody reads.
    const READS: Reads;

    /// Whether the forces sum to zero by construction, so that a drift of the total momentum is rounding and may be
    /// taken off.
    const CONSERVES_MOMENTUM: bool;

    /// Adds the forces to `forces`; `tally` hears of every interaction.
    ///
    /// # Errors
    /// Whatever makes a force meaningless; `forces` and `tally` then hold nothing of use.
    fn accumulate<T: Tally>(
        &mut self,
        frame: &Frame<'_, B>,
        forces: &mut [DVec3],
        tally: &mut T,
    ) -> Result<(), ForceError>;

    /// Forgets whatever depends on the past (lists), so that a run that goes on and one that starts again from a
    /// checkpoint sum in the same order.
    fn forget(&mut self) {}
}

impl<B: Boundary> ForceField<B> for () {
    const ACTS: bool = false;
    const READS: Reads = Reads::NOTHING;
    const CONSERVES_MOMENTUM: bool = true;

    fn accumulate<T: Tally>(
        &mut self,
        _: &Frame<'_, B>,
        _: &mut [DVec3],
        _: &mut T,
    ) -> Result<(), ForceError> {
        Ok(())
    }
}

macro_rules! sum_of_fields {
    ($($field:ident . $n:tt),+) => {
        impl<S: Boundary, $($field: ForceField<S>),+> ForceField<S> for ($($field,)+) {
            const ACTS: bool = false $(|| $field::ACTS)+;
            const READS: Reads = Reads::NOTHING$(.or($field::READS))+;
            const CONSERVES_MOMENTUM: bool = true $(&& $field::CONSERVES_MOMENTUM)+;

            fn accumulate<T: Tally>(
                &mut self,
                frame: &Frame<'_, S>,
                forces: &mut [DVec3],
                tally: &mut T,
            ) -> Result<(), ForceError> {
                $(self.$n.accumulate(frame, forces, tally)?;)+
                Ok(())
            }

            fn forget(&mut self) {
                $(self.$n.forget();)+
            }
        }
    };
}
sum_of_fields!(A.0);
sum_of_fields!(A.0, B.1);
sum_of_fields!(A.0, B.1, C.2);
sum_of_fields!(A.0, B.1, C.2, D.3);
