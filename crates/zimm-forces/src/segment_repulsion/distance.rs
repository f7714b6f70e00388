//! The closest approach of two segments.

use zimm_core::DVec3;

/// Where two segments come closest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// The place on the first segment, from -1/2 at its first end to 1/2 at its second.
    pub s: f64,
    /// The place on the second segment, likewise.
    pub t: f64,
    /// From the place on the second segment to that on the first.
    pub apart: DVec3,
}

impl Approach {
    /// The closest approach of two segments with spans R_1 and R_2 whose middles are `middles` = P_1 - P_2 apart:
    /// the minimum over s and t in [-1/2, 1/2] of
    ///
    /// ```text
    /// |D|^2 + b^2 (s^2 + t^2),    D = P_1 - P_2 + s R_1 - t R_2
    /// ```
    ///
    /// A blur b of zero gives the distance, exact to rounding of the lengths involved, for segments of any kind:
    /// parallel, collinear, crossing, of no length. Of many places that are equally close it takes one.
    ///
    /// A blur above zero (a length) makes the places unique and continuous in all that they depend on. Parallel
    /// segments have many pairs of places at the same distance; the blur takes the pair nearest the middles, and lets
    /// the places slide from end to end while ends move by about b, where without it they jump. It adds at most 0.71 b
    /// to a distance of zero, b^2 / 4D to a longer one.
    ///
    /// ```
    /// use zimm_core::DVec3;
    /// use zimm_forces::Approach;
    ///
    /// // One segment over the end of another.
    /// let near = Approach::between(DVec3::new(0.7, 0.0, 0.2), DVec3::Y, DVec3::X, 0.0);
    /// assert_eq!((near.s, near.t), (0.0, 0.5));
    /// assert!((near.apart - DVec3::new(0.2, 0.0, 0.2)).length() < 1e-15);
    /// ```
    #[inline(always)]
    pub fn between(middles: DVec3, first: DVec3, second: DVec3, blur: f64) -> Self {
        let b2 = blur * blur;
        let (r1, r2) = (first.length_squared(), second.length_squared());
        let along = (first.dot(middles), second.dot(middles));
        let across = first.dot(second);
        // By cross products: products of lengths lose the angle of segments that are nearly parallel.
        let normal = first.cross(second);
        let determinant = normal.length_squared() + b2 * (r1 + r2 + b2);
        let solved = -(normal.dot(middles.cross(second)) + b2 * along.0);
        // The best s if t were free; then the best t for it; if that is an end, the best s for that end.
        let s = place(solved, determinant);
        let t = place(along.1 + across * s, r2 + b2);
        let s = place(across * t - along.0, r1 + b2);
        Self {
            s,
            t,
            apart: middles + s * first - t * second,
        }
    }
}

/// A quotient kept on the segment; of a segment without length, or of parallel ones, the middle.
#[inline(always)]
fn place(numerator: f64, denominator: f64) -> f64 {
    let quotient = numerator / denominator;
    if quotient.is_finite() {
        quotient.clamp(-0.5, 0.5)
    } else {
        0.0
    }
}
