//! Integer maps of planar lattices onto themselves.

use crate::FlowError;
use zimm_core::{DMat3, DVec3};

/// How a planar lattice returns to itself: an integer matrix N of determinant 1 and trace k above 2.
///
/// In a planar flow with the eigenvalues +-1, b_i(T) = sum_j N_ij b_j(0) after the Hencky strain T = arccosh(k / 2).
/// N determines the lattice up to its size and the time at which it is first seen: the coordinates of the two basis
/// vectors along the axis of extension are an eigenvector of N, those along the axis of contraction the other
/// (Kraynik and Reinelt 1992; Todd and Daivis 1998; Hunt, Bernardi and Todd 2010).
///
/// How close images come is a matter of the quadratic form f = N_12 m^2 + (N_22 - N_11) m n - N_21 n^2, which is
/// the product of the two coordinates of the vector m b_1 + n b_2 but for a factor, and which the flow leaves alone.
///
/// ```
/// use zimm_boundary::PlanarMap;
///
/// let classic = PlanarMap::square(3, 2)?;
/// assert_eq!(classic, PlanarMap::CLASSIC);
/// assert!((classic.hencky_period() - 0.962423650119207).abs() < 1e-15);
/// assert!((classic.min_image_distance(1.0) - 0.945741609003176).abs() < 1e-15);
/// # Ok::<(), zimm_boundary::FlowError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanarMap {
    rows: [[i64; 2]; 2],
}

impl PlanarMap {
    /// k = 3, N11 = 2, the square lattice of Kraynik and Reinelt (1992) that comes back soonest. No lattice keeps
    /// images further apart in planar extension.
    pub const CLASSIC: Self = Self {
        rows: [[2, -1], [-1, 1]],
    };

    const MOST: i64 = 1_000_000_000_000_000_000;
    const MOST_TRACE: i64 = 1_000_000_000;

    /// A matrix given by its rows.
    ///
    /// # Errors
    /// If the determinant is not 1, the trace not between 3 and 10^9, or an entry beyond 10^18.
    pub fn new(rows: [[i64; 2]; 2]) -> Result<Self, FlowError> {
        let [[a, b], [c, d]] = rows;
        let determinant = i128::from(a) * i128::from(d) - i128::from(b) * i128::from(c);
        let trace = a.saturating_add(d);
        let small = rows
            .as_flattened()
            .iter()
            .all(|n| (-Self::MOST..=Self::MOST).contains(n));
        if small && determinant == 1 && (3..=Self::MOST_TRACE).contains(&trace) {
            Ok(Self { rows })
        } else {
            Err(FlowError::NoMap {
                rows,
                determinant,
                trace,
            })
        }
    }

    /// The map of a square lattice, by its trace k and first entry: N12 = N21 = -sqrt(N11 (k - N11) - 1). There are
    /// some for k = 3, 6, 7, 11, 15, 18, 27, ... only.
    ///
    /// # Errors
    /// If there is no such square lattice.
    pub fn square(trace: i64, n11: i64) -> Result<Self, FlowError> {
        let n22 = trace.saturating_sub(n11);
        let square = n11.saturating_mul(n22).saturating_sub(1);
        let n12 = -square.max(0).isqrt();
        if n12 == 0 || n12 * n12 != square {
            return Err(FlowError::NotSquare { trace, n11, square });
        }
        Self::new([[n11, n12], [n12, n22]])
    }

    /// The map that keeps images furthest apart in planar mixed flow of a mixedness above zero.
    ///
    /// With t near 1/chi it is one of the two whose lattices have the continued fractions [1, t, 1, t, ...] and
    /// [1, t, 1, t + 1, ...], or the [classic](Self::CLASSIC) one. Where 1/chi is an integer no lattice at all is better
    /// (Segre 1945).
    pub fn best(mixedness: f64) -> Self {
        let turns = (1.0 / mixedness).clamp(1.0, 1e8) as i64;
        let mut best = Self::CLASSIC;
        for t in (turns - 1).max(1)..=turns + 1 {
            // Of all bases of its lattice the one that is most alike before and after the time at which it is closest:
            // that saves digits.
            let j = t / 2;
            let once = [[t - j + 1, 1], [j + (j + 1) * (t - j), j + 1]];
            // From t = 20 on this is better by less than 2e-4.
            let twice = (t < 20).then_some([[(t + 1) * (t + 3), t + 2], [t * (t + 3) + 1, t + 1]]);
            for rows in [Some(once), twice].into_iter().flatten() {
                let map = Self { rows };
                let distance = |map: Self| map.min_image_distance(mixedness);
                // Of equals the former.
                if distance(map) > distance(best) * (1.0 + 1e-12) {
                    best = map;
                }
            }
        }
        best
    }

    /// The rows of the matrix.
    pub fn rows(&self) -> [[i64; 2]; 2] {
        self.rows
    }

    /// The trace, k.
    pub fn trace(&self) -> i64 {
        self.rows[0][0] + self.rows[1][1]
    }

    /// The Hencky strain after which the lattice is the same: arccosh(k / 2).
    pub fn hencky_period(&self) -> f64 {
        libm::acosh(0.5 * self.trace() as f64)
    }

    /// The closest that images ever come in planar mixed flow of a mixedness chi (1 is extension), per square root of
    /// the area of the cell:
    ///
    /// ```text
    /// D^2 = 2 min(sqrt(chi) f_-, f_+ / sqrt(chi)) / sqrt(k^2 - 4)
    /// ```
    ///
    /// with f_+ and f_- the least magnitudes of the positive and negative values that the form f takes. A vector with
    /// coordinates X and Y along the axes of the flow is shortest when X e^t = Y e^-t, which leaves 2 |X Y| (1 +- c),
    /// with c the cosine of the angle between the axes.
    pub fn min_image_distance(&self, mixedness: f64) -> f64 {
        let root = mixedness.sqrt();
        let [positive, negative] = self.least_values().map(|value| value as f64);
        (2.0 * (root * negative).min(positive / root) / self.root_of_discriminant()).sqrt()
    }

    /// Edges of the smallest cell, in the plane and along z, in which images stay two cutoffs apart; 1e-12 is added for
    /// rounding.
    pub(crate) fn edges_for_cutoff(&self, cutoff: f64, mixedness: f64) -> [f64; 2] {
        let apart = 2.0 * cutoff * (1.0 + 1e-12);
        [apart / self.min_image_distance(mixedness), apart]
    }

    /// The lattice of unit area at the time when it is as long in the one direction as in the other: coordinates along
    /// x are those along the axis of extension, those along y of contraction. Square if the matrix is symmetric.
    pub(crate) fn basis(&self) -> DMat3 {
        let [[n11, n12], [_, n22]] = self.rows.map(|row| row.map(|n| n as f64));
        let contraction = 2.0 / (self.trace() as f64 + self.root_of_discriminant());
        let along = |ratio: f64| {
            [
                1.0 / libm::hypot(1.0, ratio),
                ratio / libm::hypot(1.0, ratio),
            ]
        };
        // Of the two expressions for each ratio those without cancellation.
        let x = along((n22 - contraction) / n12);
        let y = along((contraction - n11) / n12);
        let area = x[0] * y[1] - x[1] * y[0];
        let scale = 1.0 / area.abs().sqrt();
        let turn = scale.copysign(area);
        DMat3::from_cols(
            DVec3::new(scale * x[0], turn * y[0], 0.0),
            DVec3::new(scale * x[1], turn * y[1], 0.0),
            DVec3::Z,
        )
    }

    /// sqrt(k^2 - 4).
    fn root_of_discriminant(&self) -> f64 {
        let trace = self.trace() as f64;
        ((trace - 2.0) * (trace + 2.0)).sqrt()
    }

    /// The least magnitudes of the positive and of the negative values of the form f. Among the leading coefficients
    /// of the forms that it is equivalent to and that are reduced, a cycle, there are both (Lagrange; Gauss 1801,
    /// articles 183 to 187).
    fn least_values(&self) -> [i64; 2] {
        let [[n11, n12], [n21, n22]] = self.rows;
        let mut form = Form::new(n12, n22 - n11, -n21);
        while !form.is_reduced() {
            form = form.next();
        }
        let (first, mut least) = (form, [i64::MAX; 2]);
        loop {
            let side = &mut least[usize::from(form.a < 0)];
            *side = form.a.abs().min(*side);
            form = form.next();
            if form == first {
                return least;
            }
        }
    }
}

/// The indefinite form a m^2 + b m n + c n^2; its discriminant is no square.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Form {
    a: i64,
    b: i64,
    c: i64,
    discriminant: i128,
    root: i64,
}

impl Form {
    fn new(a: i64, b: i64, c: i64) -> Self {
        let discriminant = i128::from(b) * i128::from(b) - 4 * i128::from(a) * i128::from(c);
        Self {
            a,
            b,
            c,
            discriminant,
            root: discriminant.isqrt() as i64,
        }
    }

    /// |sqrt(discriminant) - 2 |a|| < b < sqrt(discriminant), in integers.
    fn is_reduced(&self) -> bool {
        let (root, b, twice) = (self.root, self.b, 2 * self.a.abs());
        0 < b && b <= root && root - b < twice && twice <= root + b
    }

    /// The neighbour on the right: the form in the basis (v, -u + s v), with s such that it is closest to reduced.
    fn next(&self) -> Self {
        let (a, modulus) = (self.c, 2 * self.c.abs());
        let top = self.root.max(self.c.abs());
        let b = top - (top + self.b).rem_euclid(modulus);
        let c = (i128::from(b) * i128::from(b) - self.discriminant) / (4 * i128::from(a));
        Self {
            a,
            b,
            c: c as i64,
            ..*self
        }
    }
}
