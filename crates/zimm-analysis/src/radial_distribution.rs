//! The pair correlation function.

use crate::AnalysisError;
use crate::pairs::for_each_pair;
use std::f64::consts::PI;
use zimm_core::{Frame, Neighbours, Observable, ParameterError, Periodic};

/// The radial distribution function g(r) of a frame, in bins of equal width up to `range`:
///
/// ```text
/// g = V pairs / (N (N - 1) / 2 . shell),   shell = (4 pi / 3) (r_outer^3 - r_inner^3)
/// ```
///
/// An ideal gas of any number of particles has g = 1 exactly. The range is at most half the shortest lattice vector,
/// in a cell of any shape. Average frames with [`BlockAverages`](crate::BlockAverages).
///
/// ```
/// use zimm_analysis::{BlockAverages, RadialDistribution};
/// use zimm_core::{ParameterError, VerletList};
///
/// let g = RadialDistribution::new(3.0, 60, VerletList::new(0.0)?)?;
/// assert_eq!(g.radii().next(), Some(0.025));
/// let averages = BlockAverages::new(g.bins());
/// assert_eq!(averages.streams().len(), 60);
/// # Ok::<(), ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RadialDistribution<N> {
    range: f64,
    bins: usize,
    neighbours: N,
}

impl<N> RadialDistribution<N> {
    /// Up to a range, in this many bins, from a source of pairs.
    ///
    /// # Errors
    /// If the range is not above zero or there are no bins.
    pub fn new(range: f64, bins: usize, neighbours: N) -> Result<Self, ParameterError> {
        ParameterError::positive("bins", bins as f64)?;
        Ok(Self {
            range: ParameterError::positive("range", range)?,
            bins,
            neighbours,
        })
    }

    /// Number of bins.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// The middle of each bin.
    pub fn radii(&self) -> impl Iterator<Item = f64> {
        let width = self.range / self.bins as f64;
        (0..self.bins).map(move |k| (k as f64 + 0.5) * width)
    }
}

impl<B: Periodic, T, N: Neighbours<B>> Observable<B, T> for RadialDistribution<N> {
    type Output = Result<Vec<f64>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        let n = frame.len() as f64;
        if frame.len() < 2 {
            return Err(AnalysisError::TooFew {
                what: "particles",
                found: frame.len() as u64,
                needed: 2,
            });
        }
        self.neighbours.refresh(frame, self.range)?;
        let mut pairs = vec![0_u64; self.bins];
        let per_length = self.bins as f64 / self.range;
        for_each_pair(&self.neighbours, self.range, |_, _, r| {
            let bin = (r.length() * per_length) as usize;
            if let Some(count) = pairs.get_mut(bin) {
                *count += 1;
            }
        });
        let ideal = 0.5 * n * (n - 1.0) / frame.boundary.lattice().volume();
        let outer = |k: usize| (k as f64 / per_length).powi(3) * 4.0 * PI / 3.0;
        let density = |(k, count): (usize, u64)| count as f64 / (ideal * (outer(k + 1) - outer(k)));
        Ok(pairs.into_iter().enumerate().map(density).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, Random, at};
    use zimm_core::{AllPairs, DMat3, DVec3, VerletList};

    // A simple cubic lattice of spacing 1 has 6, 12, 8, 6, 24, 24, 12 neighbours at the roots of 1, 2, 3, 4, 5, 6, 8;
    // as seen from a brick and from a tilted cell of the same points. No shell is near the edge of a bin 0.06 wide.
    #[test]
    fn limit_shells_of_a_cubic_lattice() {
        let (edge, width, bins) = (6, 0.06, 49);
        let axis = || (0..edge).map(f64::from);
        let plane = |x: f64| axis().flat_map(move |y| axis().map(move |z| DVec3::new(x, y, z)));
        let positions: Vec<DVec3> = axis().flat_map(plane).collect();
        let mut neighbours = vec![0.0; bins];
        for (square, count) in [(1, 6), (2, 12), (3, 8), (4, 6), (5, 24), (6, 24), (8, 12)] {
            neighbours[(f64::from(square).sqrt() / width) as usize] = f64::from(count);
        }
        for offset in [0.0, 2.0] {
            let system = at(
                Cell::lees_edwards(DVec3::splat(6.0), offset),
                positions.clone(),
            );
            let source = VerletList::new(0.0).unwrap();
            let mut g = RadialDistribution::new(width * bins as f64, bins, source).unwrap();
            let found = g.measure(&system.frame(), &()).unwrap();
            for (k, (g, expected)) in found.iter().zip(&neighbours).enumerate() {
                let shell = 4.0 * PI / 3.0 * width.powi(3) * ((k + 1).pow(3) - k.pow(3)) as f64;
                approx::assert_relative_eq!(
                    g * shell * 215.0 / 216.0,
                    expected,
                    max_relative = 1e-9
                );
            }
        }
    }

    // Uniform positions: pairs are pairwise independent, so the count of a bin has the variance of the binomial
    // distribution and chi^2 of 20 bins over 200 frames has mean 20 and standard deviation 6.3. Seed 51; bound 4 sigma
    // on either side, and 4 sigma on the sum of pairs in range, which knows the normalisation to 0.6 % (1 / sqrt of 460
    // 000 pairs is 0.15 %).
    #[test]
    fn limit_an_ideal_gas_has_none() {
        let mut random = Random::new(51);
        let (n, frames) = (100, 200);
        let cell = Cell::lees_edwards(DVec3::new(5.0, 4.0, 6.0), 1.5);
        let volume = 120.0;
        let mut all = RadialDistribution::new(1.9, 20, AllPairs::default()).unwrap();
        let mut listed = RadialDistribution::new(1.9, 20, VerletList::new(0.0).unwrap()).unwrap();
        let mut mean = [0.0; 20];
        for _ in 0..frames {
            let basis = DMat3::from_diagonal(DVec3::new(5.0, 4.0, 6.0));
            let system = at(cell.clone(), (0..n).map(|_| random.within(basis)).collect());
            let found = all.measure(&system.frame(), &()).unwrap();
            assert_eq!(found, listed.measure(&system.frame(), &()).unwrap());
            for (mean, g) in mean.iter_mut().zip(found) {
                *mean += g / frames as f64;
            }
        }
        let pairs = (n * (n - 1) / 2 * frames) as f64;
        let (mut chi2, mut counted, mut expected) = (0.0, 0.0, 0.0);
        for (k, g) in mean.iter().enumerate() {
            let shell =
                4.0 * PI / 3.0 * (0.095_f64).powi(3) * ((k + 1).pow(3) - k.pow(3)) as f64 / volume;
            chi2 += (g - 1.0).powi(2) * pairs * shell / (1.0 - shell);
            counted += g * pairs * shell;
            expected += pairs * shell;
        }
        assert!((chi2 - 20.0).abs() < 4.0 * 40.0_f64.sqrt(), "chi2 {chi2}");
        assert!(
            (counted - expected).abs() < 4.0 * expected.sqrt(),
            "{counted} of {expected}"
        );
    }

    #[test]
    fn extreme_a_range_beyond_the_cell_is_an_error() {
        let system = at(Cell::cube(2.0), vec![DVec3::ZERO, DVec3::ONE]);
        let mut g = RadialDistribution::new(1.1, 5, AllPairs::default()).unwrap();
        assert!(matches!(
            g.measure(&system.frame(), &()),
            Err(AnalysisError::List(_))
        ));
        let single = at(Cell::cube(4.0), vec![DVec3::ZERO]);
        assert!(matches!(
            g.measure(&single.frame(), &()),
            Err(AnalysisError::TooFew { found: 1, .. })
        ));
        assert!(RadialDistribution::new(1.0, 0, AllPairs::default()).is_err());
        assert!(RadialDistribution::new(0.0, 3, AllPairs::default()).is_err());
    }
}
