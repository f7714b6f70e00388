//! The sum over waves.

use super::tile::{Collect, Spread, TILE, Tile};
use crate::lattice_sum::Kernel;
use std::f64::consts::{PI, TAU};
use zimm_core::{DMat3, DVec3, Lattice, each_block, for_each_chunk};

/// The sum over all waves of a lattice up to the edge of a split, k = 0 left out: W(k) of
/// 6 pi a (I - kk / k^2) / k^2 V.
///
/// Waves come in rows along one reciprocal vector, k = n1 b1 + n2 b2 + (c +- n) b3, in one half of space. With phases
/// t of each bead, the sums over a row are
///
/// ```text
/// A_n = sum_j g_j cos(n t3)    B_n = sum_j g_j sin(n t3)    g_j = F_j exp i(n1 t1 + n2 t2 + c t3)
/// ```
///
/// and A_n + iB_n, A_n - iB_n those of the two waves. That takes 12 multiplications for both, and as many on the way
/// back. Beads are in lanes, a tile of them stays in the nearest memory for all rows.
#[derive(Clone, Debug)]
pub(crate) struct Waves {
    /// Reciprocal vectors without 2 pi, the shortest last.
    reciprocal: [DVec3; 3],
    /// The largest multiples of each that occur.
    most: [usize; 3],
    rows: Vec<Row>,
    /// For each pair of waves the sum and the difference of their two tensors w (I - kk / k^2): xx, yy, zz, xy, xz, yz.
    tensors: Vec<[[f64; 6]; 2]>,
    beads: usize,
    /// exp(i t) of each bead for the three reciprocal vectors.
    phases: Vec<[[f64; 2]; 3]>,
    groups: Vec<Group>,
    /// What each pair of waves brings to the beads: real and imaginary part of a vector times cos, another times sin.
    amplitudes: Vec<[[f64; 6]; 2]>,
    arch: pulp::Arch,
}

/// Waves k = n1 b1 + n2 b2 + (c +- n) b3, n from 0 to `count` - 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub(super) n1: i32,
    pub(super) n2: i32,
    pub(super) centre: i32,
    pub(super) start: usize,
    pub(super) count: usize,
}

/// Tiles that are worked off one after the other, and what they sum up to.
#[derive(Clone, Debug, Default)]
struct Group {
    tile: Tile,
    sums: Vec<[[f64; 6]; 2]>,
}

impl Waves {
    pub(crate) fn new() -> Self {
        Self {
            reciprocal: [DVec3::ZERO; 3],
            most: [0; 3],
            rows: Vec::new(),
            tensors: Vec::new(),
            beads: 0,
            phases: Vec::new(),
            groups: Vec::new(),
            amplitudes: Vec::new(),
            arch: pulp::Arch::new(),
        }
    }

    pub(crate) fn bind(&mut self, lattice: &Lattice, positions: &[DVec3], kernel: &Kernel) {
        let rows = lattice.inverse().transpose();
        self.reciprocal = [rows.x_axis, rows.y_axis, rows.z_axis];
        self.reciprocal
            .sort_by(|a, b| b.length_squared().total_cmp(&a.length_squared()));
        self.list(lattice, kernel);
        self.beads = positions.len();
        let (reciprocal, beads) = (self.reciprocal, self.beads);
        self.phases.resize(beads, [[0.0; 2]; 3]);
        for_each_chunk(&mut self.phases, |start, phases| {
            for (phase, &r) in phases.iter_mut().zip(&positions[start..]) {
                *phase = reciprocal.map(|b| {
                    let turns = b.dot(r);
                    let (sin, cos) = libm::sincos(TAU * (turns - turns.round()));
                    [cos, sin]
                });
            }
        });
        let groups = beads.div_ceil(TILE).clamp(1, 8);
        self.groups.resize_with(groups, Group::default);
    }

    /// Lists the waves.
    fn list(&mut self, lattice: &Lattice, kernel: &Kernel) {
        let [b1, b2, b3] = self.reciprocal;
        let plan = kernel.plan();
        let edge = plan.edge() / TAU;
        let edge2 = edge * edge;
        // How far multiples of b1 and b2 go: the edge over the distance of neighbouring planes.
        let volume = lattice.volume();
        let unit = 6.0 * PI * plan.radius / (TAU * TAU * volume);
        let far = |u: DVec3, v: DVec3| (edge * volume * u.cross(v).length()) as i32;
        let (far1, far2) = (far(b2, b3), far(b3, b1));
        let square = b3.length_squared();
        self.rows.clear();
        self.tensors.clear();
        self.most = [far1 as usize, far2 as usize, 0];
        for n1 in 0..=far1 {
            for n2 in if n1 == 0 { 0 } else { -far2 }..=far2 {
                let base = f64::from(n1) * b1 + f64::from(n2) * b2;
                let along = base.dot(b3) / square;
                let rest = edge2 - (base.length_squared() - along * along * square);
                if rest < 0.0 {
                    continue;
                }
                let half = (rest / square).sqrt();
                let centre = (-along).round();
                let count = (half + (along + centre).abs()) as usize + 1;
                let base = base + centre * b3;
                let start = self.tensors.len();
                let middle = n1 == 0 && n2 == 0;
                self.tensors.extend((0..count).map(|n| {
                    let tensor = |side: f64| {
                        let k = base + side * n as f64 * b3;
                        let k2 = k.length_squared();
                        if k2 > edge2 || n == 0 && (middle || side < 0.0) {
                            return [0.0; 6];
                        }
                        let [kept] = kernel.waves(&[TAU * TAU * k2]);
                        let weight = unit * kept / k2;
                        // The other half of space; the row through the origin has both halves.
                        let weight = if middle { weight } else { 2.0 * weight };
                        let u = k / k2;
                        [
                            1.0 - k.x * u.x,
                            1.0 - k.y * u.y,
                            1.0 - k.z * u.z,
                            -k.x * u.y,
                            -k.x * u.z,
                            -k.y * u.z,
                        ]
                        .map(|component| weight * component)
                    };
                    let (plus, minus) = (tensor(1.0), tensor(-1.0));
                    let with = |sign: f64| std::array::from_fn(|c| plus[c] + sign * minus[c]);
                    [with(1.0), with(-1.0)]
                }));
                self.rows.push(Row {
                    n1,
                    n2,
                    centre: centre as i32,
                    start,
                    count,
                });
                let highest = (count - 1).max(centre.abs() as usize);
                self.most[2] = self.most[2].max(highest);
            }
        }
    }

    /// Adds the velocities, in units of the mobility of a bead alone.
    pub(crate) fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        let Self {
            most,
            rows,
            tensors,
            phases,
            groups,
            amplitudes,
            arch,
            ..
        } = self;
        let tiles = phases.len().div_ceil(TILE);
        let each = tiles.div_ceil(groups.len()).max(1) * TILE;
        each_block(groups, |g, Group { tile, sums }| {
            sums.clear();
            sums.resize(tensors.len(), [[0.0; 6]; 2]);
            let (mut from, end) = (g * each, phases.len().min((g + 1) * each));
            while from < end {
                let to = end.min(from + TILE);
                arch.dispatch(Collect {
                    tile,
                    most: *most,
                    rows,
                    phases: &phases[from..to],
                    forces: &forces[from..to],
                    sums,
                });
                from = to;
            }
        });
        amplitudes.resize(tensors.len(), [[0.0; 6]; 2]);
        for (k, (amplitude, [sum, difference])) in amplitudes.iter_mut().zip(&*tensors).enumerate()
        {
            let [mut a, mut b] = [[0.0; 6]; 2];
            for group in &*groups {
                for c in 0..6 {
                    a[c] += group.sums[k][0][c];
                    b[c] += group.sums[k][1][c];
                }
            }
            // sum A + i difference B, and sum B - i difference A.
            let (sa, sb) = (product(sum, &a), product(sum, &b));
            let (da, db) = (product(difference, &a), product(difference, &b));
            for c in 0..3 {
                amplitude[0][2 * c] = sa[2 * c] - db[2 * c + 1];
                amplitude[0][2 * c + 1] = sa[2 * c + 1] + db[2 * c];
                amplitude[1][2 * c] = sb[2 * c] + da[2 * c + 1];
                amplitude[1][2 * c + 1] = sb[2 * c + 1] - da[2 * c];
            }
        }
        let mut work: Vec<_> = groups.iter_mut().zip(velocities.chunks_mut(each)).collect();
        each_block(&mut work, |g, (group, velocities)| {
            let tile = &mut group.tile;
            for (k, velocities) in velocities.chunks_mut(TILE).enumerate() {
                let from = g * each + k * TILE;
                arch.dispatch(Spread {
                    tile,
                    most: *most,
                    rows,
                    phases: &phases[from..from + velocities.len()],
                    amplitudes,
                    velocities,
                });
            }
        });
    }

    /// The 3 x 3 block of the beads at two places.
    pub(crate) fn entry(&self, i: usize, j: usize) -> DMat3 {
        let powers: [Vec<[f64; 2]>; 3] = std::array::from_fn(|d| {
            let ([c, s], [c_j, s_j]) = (self.phases[i][d], self.phases[j][d]);
            let step = [c * c_j + s * s_j, s * c_j - c * s_j];
            let next = |&last: &[f64; 2]| Some(times(last, step));
            std::iter::successors(Some([1.0, 0.0]), next)
                .take(self.most[d] + 1)
                .collect()
        });
        let power = |d: usize, n: i32| {
            let [cos, sin]: [f64; 2] = powers[d][n.unsigned_abs() as usize];
            [cos, if n < 0 { -sin } else { sin }]
        };
        let mut total = [0.0; 6];
        for row in &self.rows {
            let carrier = times(
                times(power(0, row.n1), power(1, row.n2)),
                power(2, row.centre),
            );
            let mut sums = [[0.0; 6]; 2];
            let tensors = &self.tensors[row.start..row.start + row.count];
            for ([sum, difference], [cos, sin]) in tensors.iter().zip(&powers[2]) {
                for c in 0..6 {
                    sums[0][c] += sum[c] * cos;
                    sums[1][c] += difference[c] * sin;
                }
            }
            for c in 0..6 {
                total[c] += carrier[0] * sums[0][c] - carrier[1] * sums[1][c];
            }
        }
        let [xx, yy, zz, xy, xz, yz] = total;
        DMat3::from_cols(
            DVec3::new(xx, xy, xz),
            DVec3::new(xy, yy, yz),
            DVec3::new(xz, yz, zz),
        )
    }
}

/// A symmetric tensor times a complex vector.
fn product([xx, yy, zz, xy, xz, yz]: &[f64; 6], v: &[f64; 6]) -> [f64; 6] {
    let mut result = [0.0; 6];
    for part in 0..2 {
        let (x, y, z) = (v[part], v[2 + part], v[4 + part]);
        result[part] = xx * x + xy * y + xz * z;
        result[2 + part] = xy * x + yy * y + yz * z;
        result[4 + part] = xz * x + yz * y + zz * z;
    }
    result
}

fn times([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}
