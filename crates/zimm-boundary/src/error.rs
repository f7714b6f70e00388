//! Why a flow has no cell.

use thiserror::Error;
use zimm_core::{LatticeError, ParameterError};

/// Why there is no lattice for a flow.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FlowError {
    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The cell spans no volume, now or at some time.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// A flow that turns more than it strains.
    #[error(
        "a mixedness of {mixedness} is elliptic: such a flow turns everything round and maps no lattice onto itself by \
         stretching it; from 0 (shear) to 1 (extension) there are cells"
    )]
    Elliptic {
        /// The mixedness asked for.
        mixedness: f64,
    },
    /// A flow so close to shear that images would come too close in any cell that it maps onto itself.
    #[error(
        "a mixedness of {mixedness} is below {least}: in any cell that returns, images would come as close as {closest} \
         edges; take Lees-Edwards shear instead"
    )]
    NearlyShear {
        /// The mixedness asked for.
        mixedness: f64,
        /// The least allowed.
        least: f64,
        /// The closest that images would come, in edges of the cell in the plane.
        closest: f64,
    },
    /// No square lattice is mapped onto itself by this matrix.
    #[error(
        "no square lattice has trace k = {trace} and N11 = {n11}: N11 (k - N11) - 1 = {square}, not the square of an \
         integer above zero"
    )]
    NotSquare {
        /// Trace of the integer matrix.
        trace: i64,
        /// Its first entry.
        n11: i64,
        /// What has to be a square.
        square: i64,
    },
    /// An integer matrix that is no stretch at constant area, or one out of bounds.
    #[error(
        "{rows:?} maps no lattice onto itself by stretching it: the determinant is {determinant} and has to be 1, the \
         trace {trace} and has to be from 3 to 10^9, with entries up to 10^18"
    )]
    NoMap {
        /// The matrix.
        rows: [[i64; 2]; 2],
        /// Its determinant.
        determinant: i128,
        /// Its trace.
        trace: i64,
    },
    /// A flow that changes volume.
    #[error(
        "the rates {stretch:?} along the axes have the sum {trace}: the flow would change the volume"
    )]
    Compressible {
        /// Rates along the axes.
        stretch: [f64; 3],
        /// Their sum.
        trace: f64,
    },
    /// Axes that are not perpendicular to each other, or not of length 1.
    #[error("the axes miss being orthonormal by {deviation}; {most} is allowed")]
    Axes {
        /// Sum of the deviations of their scalar products from 0 and 1.
        deviation: f64,
        /// The largest allowed.
        most: f64,
    },
    /// A cell that is to go on in a flow of another type.
    #[error(
        "the lattice recurs in the flow {expected:?} (columns of the velocity gradient at unit rate) and no other: in \
         {found:?} it would not be reproduced, and images would come as close as they like; start in a cell made for \
         that flow"
    )]
    OtherFlow {
        /// The velocity gradient at unit rate of the flow asked for, column by column.
        found: Vec<f64>,
        /// Of the flow that the lattice is made for.
        expected: Vec<f64>,
    },
}
