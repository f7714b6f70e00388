//! Smooth functions as Chebyshev series: two at a time, many arguments at a time.

use std::f64::consts::PI;

/// Two functions of x in [0, end] as one series of pairs of coefficients.
#[derive(Clone, Debug, Default)]
pub(crate) struct Series {
    coefficients: Vec<[f64; 2]>,
    scale: f64,
}

/// How many arguments are evaluated together.
pub(crate) const WIDTH: usize = 32;

impl Series {
    /// Interpolates at `nodes` points and drops coefficients from the end whose sizes sum to less than
    /// `error`.
    pub(crate) fn fit(
        end: f64,
        nodes: usize,
        error: f64,
        function: impl Fn(f64) -> [f64; 2],
    ) -> Self {
        let angle = |j: usize| PI * (j as f64 + 0.5) / nodes as f64;
        let values: Vec<[f64; 2]> = (0..nodes)
            .map(|j| function(0.5 * end * (1.0 + libm::cos(angle(j)))))
            .collect();
        let coefficient = |k: usize| {
            let mut sum = [0.0; 2];
            for (j, value) in values.iter().enumerate() {
                // The angle of T_k, from 0 to 2 pi without rounding.
                let quarters = k * (2 * j + 1) % (4 * nodes);
                let cosine = libm::cos(0.5 * PI * quarters as f64 / nodes as f64);
                sum[0] += value[0] * cosine;
                sum[1] += value[1] * cosine;
            }
            let norm = if k == 0 { 1.0 } else { 2.0 } / nodes as f64;
            sum.map(|s| s * norm)
        };
        let mut coefficients: Vec<[f64; 2]> = (0..nodes).map(coefficient).collect();
        let mut dropped = [0.0; 2];
        while let Some(&[a, b]) = coefficients.last() {
            dropped[0] += a.abs();
            dropped[1] += b.abs();
            if coefficients.len() == 1 || dropped[0] > error || dropped[1] > error {
                break;
            }
            coefficients.pop();
        }
        let scale = 4.0 / end;
        Self {
            coefficients,
            scale,
        }
    }

    /// Both functions at many arguments, by Clenshaw's recurrence.
    #[inline(always)]
    pub(crate) fn evaluate(&self, x: &[f64; WIDTH]) -> [[f64; WIDTH]; 2] {
        let mut twice = [0.0; WIDTH];
        for l in 0..WIDTH {
            twice[l] = self.scale * x[l] - 2.0;
        }
        let mut ahead = [[0.0; WIDTH]; 2];
        let mut sum = [[0.0; WIDTH]; 2];
        for &[a, b] in self.coefficients.iter().skip(1).rev() {
            for l in 0..WIDTH {
                let next = [
                    a + twice[l] * sum[0][l] - ahead[0][l],
                    b + twice[l] * sum[1][l] - ahead[1][l],
                ];
                ahead[0][l] = sum[0][l];
                ahead[1][l] = sum[1][l];
                sum[0][l] = next[0];
                sum[1][l] = next[1];
            }
        }
        let [a, b] = self.coefficients.first().copied().unwrap_or_default();
        for l in 0..WIDTH {
            sum[0][l] = a + 0.5 * twice[l] * sum[0][l] - ahead[0][l];
            sum[1][l] = b + 0.5 * twice[l] * sum[1][l] - ahead[1][l];
        }
        sum
    }
}
