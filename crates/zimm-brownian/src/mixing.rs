//! Fixed points of maps that are dear to evaluate.

use crate::columns::{add_scaled, dot};
use zimm_core::DVec3;

const DEPTH: usize = 8;

/// Anderson's mixing (1965) of the iterates of v = g(v): the next iterate is the image of that mixture of the last
/// ones whose residual g(v) - v is the smallest. For linear maps it is GMRES.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mixing {
    iterate: Vec<DVec3>,
    residual: Vec<DVec3>,
    /// Changes of iterate and of residual, the oldest first.
    changes: Vec<[Vec<DVec3>; 2]>,
}

impl Mixing {
    pub(crate) fn forget(&mut self) {
        self.iterate.clear();
        self.changes.clear();
    }

    /// Replaces the iterate `v` by the next one; `residual` is g(v) - v.
    pub(crate) fn mix(&mut self, v: &mut [DVec3], residual: &[DVec3]) {
        if !self.iterate.is_empty() {
            let mut change = if self.changes.len() == DEPTH {
                self.changes.remove(0)
            } else {
                Default::default()
            };
            let columns = [(&*v, &self.iterate), (residual, &self.residual)];
            for (change, (new, old)) in change.iter_mut().zip(columns) {
                change.clear();
                change.extend(new.iter().zip(old).map(|(new, old)| *new - *old));
            }
            self.changes.push(change);
        }
        v.clone_into(&mut self.iterate);
        residual.clone_into(&mut self.residual);
        let weights = self.weights();
        add_scaled(v, 1.0, residual);
        for ([iterate, residual], weight) in self.changes.iter().zip(weights) {
            add_scaled(v, -weight, iterate);
            add_scaled(v, -weight, residual);
        }
    }

    /// How much of each change of the residual makes up the residual, by least squares.
    fn weights(&self) -> Vec<f64> {
        let n = self.changes.len();
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(n);
        for [_, a] in &self.changes {
            let mut row: Vec<f64> = self.changes.iter().map(|[_, b]| dot(a, b)).collect();
            row.push(dot(a, &self.residual));
            rows.push(row);
        }
        // Changes that are nearly linear combinations of others are left to rounding by this much.
        for (k, row) in rows.iter_mut().enumerate() {
            row[k] *= 1.0 + 1e-13;
        }
        // Gaussian elimination of a positive definite matrix.
        for k in 0..n {
            let (above, below) = rows.split_at_mut(k + 1);
            let pivot = &above[k];
            for row in below {
                let factor = if pivot[k] > 0.0 {
                    row[k] / pivot[k]
                } else {
                    0.0
                };
                for (entry, pivot) in row.iter_mut().zip(pivot) {
                    *entry -= factor * pivot;
                }
            }
        }
        let mut weights = vec![0.0; n];
        for k in (0..n).rev() {
            let known: f64 = (k + 1..n).map(|m| rows[k][m] * weights[m]).sum();
            if rows[k][k] > 0.0 {
                weights[k] = (rows[k][n] - known) / rows[k][k];
            }
        }
        weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// v = b - A v diverges when iterated as it is, for A has an eigenvalue of 7. In three dimensions of distinct
    /// eigenvalues mixing ends after four rounds.
    #[test]
    fn law_a_linear_map_is_solved_in_as_many_rounds_as_it_has_dimensions() {
        let (rates, b) = (DVec3::new(7.0, 0.5, 2.0), DVec3::new(1.0, -2.0, 3.0));
        let mut mixing = Mixing::default();
        let mut v = [DVec3::ZERO];
        for _ in 0..4 {
            let residual = [b - rates * v[0] - v[0]];
            mixing.mix(&mut v, &residual);
        }
        assert!((v[0] - b / (rates + 1.0)).length() < 1e-10);
    }
}
