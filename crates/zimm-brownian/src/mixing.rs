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
    /// Changes of iterate and of residual, the oldest first, and room for more.
    changes: [[Vec<DVec3>; 2]; DEPTH],
    known: usize,
}

impl Mixing {
    pub(crate) fn forget(&mut self) {
        self.iterate.clear();
        self.known = 0;
    }

    /// Replaces the iterate `v` by the next one; `residual` is g(v) - v.
    pub(crate) fn mix(&mut self, v: &mut [DVec3], residual: &[DVec3]) {
        if !self.iterate.is_empty() {
            if self.known == DEPTH {
                self.changes.rotate_left(1);
            } else {
                self.known += 1;
            }
            let change = &mut self.changes[self.known - 1];
            let columns = [(&*v, &self.iterate), (residual, &self.residual)];
            for (change, (new, old)) in change.iter_mut().zip(columns) {
                change.clear();
                change.extend(new.iter().zip(old).map(|(new, old)| *new - *old));
            }
        }
        v.clone_into(&mut self.iterate);
        residual.clone_into(&mut self.residual);
        let weights = self.weights();
        add_scaled(v, 1.0, residual);
        for ([iterate, residual], weight) in self.changes[..self.known].iter().zip(weights) {
            add_scaled(v, -weight, iterate);
            add_scaled(v, -weight, residual);
        }
    }

    /// How much of each change of the residual makes up the residual, by least squares.
    fn weights(&self) -> [f64; DEPTH] {
        let n = self.known;
        let changes = &self.changes[..n];
        let mut rows = [[0.0; DEPTH + 1]; DEPTH];
        for (k, (row, [_, a])) in rows.iter_mut().zip(changes).enumerate() {
            for (entry, [_, b]) in row.iter_mut().zip(changes) {
                *entry = dot(a, b);
            }
            row[n] = dot(a, &self.residual);
            // Changes that are nearly linear combinations of others are left to rounding by this much.
            row[k] *= 1.0 + 1e-13;
        }
        // Gaussian elimination of a positive definite matrix.
        for k in 0..n {
            let (above, below) = rows[..n].split_at_mut(k + 1);
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
        let mut weights = [0.0; DEPTH];
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
