//! Sums over waves for a few beads that stay in the nearest memory.

use super::waves::Row;
use pulp::Simd;
use zimm_core::DVec3;

/// Beads in a tile.
pub(super) const TILE: usize = 256;

/// Tiles are filled up to a multiple of this with beads that are not pulled. Sums over beads go by their place modulo
/// this, then over the places: the same for vectors of any width up to it.
const LANES: usize = 8;

/// The beads of a tile by columns.
#[derive(Clone, Debug, Default)]
pub(super) struct Tile {
    len: usize,
    /// cos(n t) and sin(n t) for the three reciprocal vectors, n = 0, 1, ...
    powers: [Vec<f64>; 3],
    /// Components of forces or velocities.
    vectors: Vec<f64>,
    /// Real and imaginary part of exp i(n1 t1 + n2 t2 + c t3) of a row.
    carrier: Vec<f64>,
    /// Real and imaginary part of three components.
    carried: Vec<f64>,
}

/// Adds the sums of a row, those with cos and those with sin, over the beads of a tile.
pub(super) struct Collect<'a> {
    pub(super) tile: &'a mut Tile,
    pub(super) most: [usize; 3],
    pub(super) rows: &'a [Row],
    pub(super) phases: &'a [[[f64; 2]; 3]],
    pub(super) forces: &'a [DVec3],
    pub(super) sums: &'a mut [[[f64; 6]; 2]],
}

impl pulp::WithSimd for Collect<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            tile,
            rows,
            forces,
            sums,
            ..
        } = self;
        tile.load(simd, self.phases, self.most);
        let len = tile.len;
        for (k, force) in forces.iter().enumerate() {
            for c in 0..3 {
                tile.vectors[c * len + k] = force[c];
            }
        }
        for row in rows {
            tile.carry(simd, row);
            for c in 0..6 {
                let force = column::<S>(&tile.vectors, len, c / 2);
                let carrier = column::<S>(&tile.carrier, len, c % 2);
                let carried = column_mut::<S>(&mut tile.carried, len, c);
                for ((carried, &force), &carrier) in carried.iter_mut().zip(force).zip(carrier) {
                    *carried = simd.mul_f64s(force, carrier);
                }
            }
            for (n, sum) in sums[row.start..row.start + row.count]
                .iter_mut()
                .enumerate()
            {
                tile.add_products(simd, n, sum);
            }
        }
    }
}

/// Adds the velocities that all rows bring to the beads of a tile.
pub(super) struct Spread<'a> {
    pub(super) tile: &'a mut Tile,
    pub(super) most: [usize; 3],
    pub(super) rows: &'a [Row],
    pub(super) phases: &'a [[[f64; 2]; 3]],
    pub(super) amplitudes: &'a [[[f64; 6]; 2]],
    pub(super) velocities: &'a mut [DVec3],
}

impl pulp::WithSimd for Spread<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            tile,
            rows,
            amplitudes,
            velocities,
            ..
        } = self;
        tile.load(simd, self.phases, self.most);
        for row in rows {
            tile.carry(simd, row);
            tile.add_waves(simd, &amplitudes[row.start..row.start + row.count]);
        }
        for (k, velocity) in velocities.iter_mut().enumerate() {
            for c in 0..3 {
                velocity[c] += tile.vectors[c * tile.len + k];
            }
        }
    }
}

impl Tile {
    /// Powers of the phases of some beads; vectors are zero.
    #[inline(always)]
    fn load<S: Simd>(&mut self, simd: S, phases: &[[[f64; 2]; 3]], most: [usize; 3]) {
        let len = phases.len().next_multiple_of(LANES);
        self.len = len;
        for (d, powers) in self.powers.iter_mut().enumerate() {
            powers.clear();
            powers.resize(2 * (most[d] + 1) * len, 0.0);
            powers[..len].fill(1.0);
            if most[d] == 0 {
                continue;
            }
            for (k, phase) in phases.iter().enumerate() {
                (powers[2 * len + k], powers[3 * len + k]) = (phase[d][0], phase[d][1]);
            }
            for n in 2..=most[d] {
                powers.copy_within(2 * (n - 1) * len..2 * n * len, 2 * n * len);
                let (first, last) = powers.split_at_mut(2 * n * len);
                turn(simd, last, &first[2 * len..], len, 1.0);
            }
        }
        self.vectors.clear();
        self.vectors.resize(3 * len, 0.0);
        self.carrier.resize(2 * len, 0.0);
        self.carried.resize(6 * len, 0.0);
    }

    /// exp i(n1 t1 + n2 t2 + c t3).
    #[inline(always)]
    fn carry<S: Simd>(&mut self, simd: S, row: &Row) {
        let len = self.len;
        let power = |d: usize, n: i32| &self.powers[d][2 * n.unsigned_abs() as usize * len..];
        let sign = |n: i32| if n < 0 { -1.0 } else { 1.0 };
        self.carrier.copy_from_slice(&power(0, row.n1)[..2 * len]);
        if row.n2 != 0 {
            turn(simd, &mut self.carrier, power(1, row.n2), len, sign(row.n2));
        }
        if row.centre != 0 {
            turn(
                simd,
                &mut self.carrier,
                power(2, row.centre),
                len,
                sign(row.centre),
            );
        }
    }

    /// Sums over beads of what is carried times cos(n t3), and times sin(n t3).
    #[inline(always)]
    fn add_products<S: Simd>(&self, simd: S, n: usize, sums: &mut [[f64; 6]; 2]) {
        let len = self.len;
        let cos = column::<S>(&self.powers[2], len, 2 * n);
        let sin = column::<S>(&self.powers[2], len, 2 * n + 1);
        let carried: [&[S::f64s]; 6] =
            std::array::from_fn(|c| &column::<S>(&self.carried, len, c)[..cos.len()]);
        let sin = &sin[..cos.len()];
        let vectors = LANES / S::F64_LANES;
        let mut lanes = [[[0.0; LANES]; 6]; 2];
        for v in 0..vectors {
            let [mut a, mut b] = [[simd.splat_f64s(0.0); 6]; 2];
            let mut at = v;
            while at < cos.len() {
                for c in 0..6 {
                    a[c] = simd.add_f64s(a[c], simd.mul_f64s(carried[c][at], cos[at]));
                    b[c] = simd.add_f64s(b[c], simd.mul_f64s(carried[c][at], sin[at]));
                }
                at += vectors;
            }
            for c in 0..6 {
                S::as_mut_simd_f64s(&mut lanes[0][c]).0[v] = a[c];
                S::as_mut_simd_f64s(&mut lanes[1][c]).0[v] = b[c];
            }
        }
        for (sums, lanes) in sums.iter_mut().zip(&lanes) {
            for (sum, [a, b, c, d, e, f, g, h]) in sums.iter_mut().zip(lanes) {
                *sum += ((a + e) + (c + g)) + ((b + f) + (d + h));
            }
        }
    }

    /// Adds the velocities that the waves of the row in carriage bring.
    #[inline(always)]
    fn add_waves<S: Simd>(&mut self, simd: S, amplitudes: &[[[f64; 6]; 2]]) {
        let len = self.len;
        let vectors = len / S::F64_LANES;
        let (powers, _) = S::as_simd_f64s(&self.powers[2][..2 * amplitudes.len() * len]);
        let (carrier, _) = S::as_simd_f64s(&self.carrier);
        let (velocities, _) = S::as_mut_simd_f64s(&mut self.vectors);
        let (carrier, velocities) = (&carrier[..2 * vectors], &mut velocities[..3 * vectors]);
        for at in 0..vectors {
            let [mut a, mut b] = [[simd.splat_f64s(0.0); 6]; 2];
            for ([with_cos, with_sin], power) in
                amplitudes.iter().zip(powers.chunks_exact(2 * vectors))
            {
                let (cos, sin) = (power[at], power[vectors + at]);
                for c in 0..6 {
                    a[c] = simd.add_f64s(a[c], simd.mul_f64s(simd.splat_f64s(with_cos[c]), cos));
                    b[c] = simd.add_f64s(b[c], simd.mul_f64s(simd.splat_f64s(with_sin[c]), sin));
                }
            }
            let (cos, sin) = (carrier[at], carrier[vectors + at]);
            for d in 0..3 {
                let re = simd.mul_f64s(simd.add_f64s(a[2 * d], b[2 * d]), cos);
                let im = simd.mul_f64s(simd.add_f64s(a[2 * d + 1], b[2 * d + 1]), sin);
                let velocity = &mut velocities[d * vectors + at];
                *velocity = simd.add_f64s(*velocity, simd.add_f64s(re, im));
            }
        }
    }
}

/// Multiplies complex numbers, columns of real and of imaginary parts, by others or, with a sign of -1, by their
/// conjugates.
#[inline(always)]
fn turn<S: Simd>(simd: S, z: &mut [f64], by: &[f64], len: usize, sign: f64) {
    let (re, im) = z.split_at_mut(len);
    let re = S::as_mut_simd_f64s(re).0.iter_mut();
    let im = S::as_mut_simd_f64s(im).0.iter_mut();
    let by = column::<S>(by, len, 0).iter().zip(column::<S>(by, len, 1));
    let sign = simd.splat_f64s(sign);
    for ((re, im), (&cos, &sin)) in re.zip(im).zip(by) {
        let (a, b) = (*re, *im);
        let sin = simd.mul_f64s(sign, sin);
        *re = simd.sub_f64s(simd.mul_f64s(a, cos), simd.mul_f64s(b, sin));
        *im = simd.add_f64s(simd.mul_f64s(a, sin), simd.mul_f64s(b, cos));
    }
}

#[inline(always)]
fn column<S: Simd>(columns: &[f64], len: usize, k: usize) -> &[S::f64s] {
    S::as_simd_f64s(&columns[k * len..(k + 1) * len]).0
}

#[inline(always)]
fn column_mut<S: Simd>(columns: &mut [f64], len: usize, k: usize) -> &mut [S::f64s] {
    S::as_mut_simd_f64s(&mut columns[k * len..(k + 1) * len]).0
}
