//! Eigenvalues of symmetric tridiagonal matrices, and those components of the eigenvectors that are asked for.

/// A decomposition in the making and its result; the buffers are used again.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tridiagonal {
    values: Vec<f64>,
    off: Vec<f64>,
    vectors: Vec<f64>,
    width: usize,
}

impl Tridiagonal {
    /// Decomposes the matrix with this diagonal and `off` beside it, which is shorter by one; of each eigenvector, the
    /// components in `wanted`, in this order.
    ///
    /// QL iterations with implicit shifts (Wilkinson and Reinsch 1971, contribution II/4).
    pub(crate) fn decompose(&mut self, diagonal: &[f64], off: &[f64], wanted: &[usize]) {
        let len = diagonal.len();
        diagonal.clone_into(&mut self.values);
        off.clone_into(&mut self.off);
        self.off.resize(len, 0.0);
        self.width = wanted.len();
        self.vectors.clear();
        for k in 0..len {
            let unit = wanted.iter().map(|&w| if w == k { 1.0 } else { 0.0 });
            self.vectors.extend(unit);
        }
        for low in 0..len {
            self.isolate(low);
        }
    }

    /// Eigenvalues, in no order.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// The components of the eigenvectors, vector after vector.
    pub(crate) fn vectors(&self) -> impl Iterator<Item = &[f64]> {
        self.vectors.chunks_exact(self.width)
    }

    /// Sweeps until `low` is an eigenvalue.
    fn isolate(&mut self, low: usize) {
        const SWEEPS: usize = 60;
        for _ in 0..SWEEPS {
            let high = self.end_of_block(low);
            if high == low {
                return;
            }
            self.sweep(low, high);
        }
    }

    /// The last index that is coupled to `low`.
    fn end_of_block(&self, low: usize) -> usize {
        let decoupled = |k: &usize| {
            let scale = self.values[*k].abs() + self.values[k + 1].abs();
            self.off[*k].abs() <= f64::EPSILON * scale
        };
        let last = self.values.len() - 1;
        (low..last).find(decoupled).unwrap_or(last)
    }

    /// One sweep of plane rotations from `high` down to `low`.
    fn sweep(&mut self, low: usize, high: usize) {
        let (d, e) = (&mut self.values, &mut self.off);
        let half = (d[low + 1] - d[low]) / (2.0 * e[low]);
        let root = half.hypot(1.0).copysign(half);
        let mut g = d[high] - d[low] + e[low] / (half + root);
        let (mut sin, mut cos, mut shift) = (1.0, 1.0, 0.0);
        for k in (low..high).rev() {
            let (f, b) = (sin * e[k], cos * e[k]);
            let r = f.hypot(g);
            e[k + 1] = r;
            if r == 0.0 {
                d[k + 1] -= shift;
                e[high] = 0.0;
                return;
            }
            (sin, cos) = (f / r, g / r);
            let next = d[k + 1] - shift;
            let turned = (d[k] - next) * sin + 2.0 * cos * b;
            shift = sin * turned;
            d[k + 1] = next + shift;
            g = cos * turned - b;
            let start = k * self.width;
            let (lower, upper) =
                self.vectors[start..start + 2 * self.width].split_at_mut(self.width);
            for (x, y) in lower.iter_mut().zip(upper) {
                (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
            }
        }
        d[low] -= shift;
        e[low] = g;
        e[high] = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    // The second difference of a string of n beads between walls: eigenvalues 2 - 2 cos(pi k / (n + 1)), components
    // sqrt(2 / (n + 1)) sin(pi k j / (n + 1)).
    #[test]
    fn limit_a_string_of_beads() {
        let mut found = Tridiagonal::default();
        for n in [1_usize, 2, 3, 10, 100] {
            let all: Vec<usize> = (0..n).collect();
            found.decompose(&vec![2.0; n], &vec![-1.0; n - 1], &all);
            let mut pairs: Vec<_> = found.values().iter().zip(found.vectors()).collect();
            pairs.sort_by(|a, b| a.0.total_cmp(b.0));
            for (k, (value, vector)) in pairs.into_iter().enumerate() {
                let angle = PI * (k + 1) as f64 / (n + 1) as f64;
                assert!(
                    (value - (2.0 - 2.0 * angle.cos())).abs() < 4e-15 * (1.0 + n as f64).sqrt()
                );
                let sign = vector[0].signum() * (2.0 / (n + 1) as f64).sqrt();
                for (j, component) in vector.iter().enumerate() {
                    let exact = sign * (angle * (j + 1) as f64).sin();
                    assert!(
                        (component - exact).abs() < 1e-12,
                        "n {n}: {component}, not {exact}"
                    );
                }
            }
        }
    }

    // Entries over sixteen decades: the trace and the sum of squares are those of the eigenvalues, and the first and
    // last components alone are those of the whole vectors.
    #[test]
    fn law_chosen_components_and_invariants() {
        let n = 60;
        let diagonal: Vec<f64> = (0..n)
            .map(|k| 10.0_f64.powf(-16.0 * k as f64 / n as f64))
            .collect();
        let off: Vec<f64> = diagonal
            .windows(2)
            .map(|d| 0.4 * (d[0] * d[1]).sqrt())
            .collect();
        let (mut whole, mut ends) = (Tridiagonal::default(), Tridiagonal::default());
        whole.decompose(&diagonal, &off, &(0..n).collect::<Vec<_>>());
        ends.decompose(&diagonal, &off, &[0, n - 1]);
        assert_eq!(whole.values(), ends.values());
        for (all, two) in whole.vectors().zip(ends.vectors()) {
            assert_eq!([all[0], all[n - 1]], *two);
        }
        let trace: f64 = diagonal.iter().sum();
        assert!((whole.values().iter().sum::<f64>() - trace).abs() < 1e-14 * trace);
        let squares = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let frobenius = squares(&diagonal) + 2.0 * squares(&off);
        assert!((squares(whole.values()) - frobenius).abs() < 1e-14 * frobenius);
    }
}
