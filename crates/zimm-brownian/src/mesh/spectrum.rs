//! The modes of a mesh and what the wave part does to them.

use super::window::Window;
use crate::{White, lattice_sum::Kernel};
use realfft::num_complex::Complex64;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};
use zimm_core::{DVec3, Lattice};

/// Modes whose kernels are evaluated together.
const LANES: usize = 8;

/// The wave vectors of a mesh, and the windows that a velocity passes through twice.
#[derive(Clone, Debug, Default)]
pub(super) struct Spectrum {
    points: [usize; 3],
    reciprocal: [DVec3; 3],
    /// One over the square of the window's transform, for every mode along every direction; zero for the mode that is
    /// its own mirror image at the end of the band, whose sign is not known.
    sharpening: [Vec<f64>; 3],
    volume: f64,
    edge: f64,
    arch: pulp::Arch,
}

impl Spectrum {
    /// Fixes the modes.
    pub(super) fn bind(
        &mut self,
        points: [usize; 3],
        lattice: &Lattice,
        window: &Window,
        kernel: &Kernel,
    ) {
        let reciprocal = TAU * lattice.inverse().transpose();
        self.reciprocal = [reciprocal.x_axis, reciprocal.y_axis, reciprocal.z_axis];
        (self.volume, self.edge) = (lattice.volume(), kernel.plan().edge());
        for ((sharpening, known), n) in self.sharpening.iter_mut().zip(&mut self.points).zip(points)
        {
            if *known != n {
                *known = n;
                sharpening.clear();
                sharpening.extend((0..n).map(|m| {
                    if 2 * m == n {
                        0.0
                    } else {
                        window.transform(TAU * signed(m, n) / n as f64).powi(-2)
                    }
                }));
            }
        }
    }

    pub(super) fn points(&self) -> [usize; 3] {
        self.points
    }

    /// Number of modes in a row of one component: those of real values.
    pub(super) fn half(&self) -> usize {
        self.points[2] / 2 + 1
    }

    /// The wave vector of a mode of a line, but for its part along the line.
    fn across(&self, second: usize, third: usize) -> DVec3 {
        let [_, n2, n3] = self.points;
        signed(second, n2) * self.reciprocal[1] + signed(third, n3) * self.reciprocal[2]
    }

    /// Whether all waves of a line are shorter than those that are kept.
    pub(super) fn is_beyond(&self, second: usize, third: usize) -> bool {
        let along = self.reciprocal[0].normalize();
        self.across(second, third).cross(along).length() > self.edge
    }
}

/// The three components of some modes: lines of modes along the first direction, line by line.
pub(super) struct Lines<'a> {
    pub(super) spectrum: &'a Spectrum,
    pub(super) second: usize,
    pub(super) third: usize,
    pub(super) modes: &'a mut [Complex64],
}

impl Lines<'_> {
    /// Forces to velocities.
    pub(super) fn scale(self, kernel: &Kernel) {
        self.spectrum.arch.dispatch(Scale {
            lines: self,
            kernel,
        });
    }

    /// Random velocities.
    pub(super) fn draw(self, kernel: &Kernel, white: &White<'_>) {
        let Self {
            spectrum,
            second,
            third,
            modes,
        } = self;
        let n1 = spectrum.points[0];
        let size = modes.len() / 3;
        for line in 0..size / n1 {
            let third = third + line;
            for start in (0..n1).step_by(LANES) {
                let group = Group::new(spectrum, kernel, [start, second, third]);
                for lane in 0..LANES.min(n1 - start) {
                    let factor = group.factor[lane].max(0.0).sqrt();
                    let at = line * n1 + start + lane;
                    let mode = [start + lane, second, third];
                    let z = if factor > 0.0 {
                        spectrum.random(mode, white)
                    } else {
                        [DVec3::ZERO; 2]
                    };
                    let k = DVec3::new(group.k[0][lane], group.k[1][lane], group.k[2][lane]);
                    let [re, im] = z.map(|z| factor * (z - k * (k.dot(z) * group.inverse[lane])));
                    for c in 0..3 {
                        modes[c * size + at] = Complex64::new(re[c], im[c]);
                    }
                }
            }
        }
    }
}

impl Spectrum {
    /// Three independent complex normal numbers of variance one, those of the mirror image conjugate.
    fn random(&self, mode: [usize; 3], white: &White<'_>) -> [DVec3; 2] {
        let [n1, n2, _] = self.points;
        let [m1, m2, m3] = mode;
        let mirror = [(n1 - m1) % n1, (n2 - m2) % n2];
        let mirrored = m3 == 0 && [m2, m1] > [mirror[1], mirror[0]];
        let [m1, m2] = if mirrored { mirror } else { [m1, m2] };
        let index = 2 * ((m1 * n2 + m2) * self.half() + m3) as u32;
        let re = FRAC_1_SQRT_2 * white.wave(index);
        let im = FRAC_1_SQRT_2 * white.wave(index + 1);
        [re, if mirrored { -im } else { im }]
    }
}

/// Wave vectors and factors of some modes of a line.
struct Group {
    k: [[f64; LANES]; 3],
    /// 1 / k^2.
    inverse: [f64; LANES],
    /// The wave part but for its projector; zero for no wave and for modes off the end of the line.
    factor: [f64; LANES],
}

impl Group {
    #[inline(always)]
    fn new(spectrum: &Spectrum, kernel: &Kernel, mode: [usize; 3]) -> Self {
        let [start, second, third] = mode;
        let n1 = spectrum.points[0];
        let across = spectrum.across(second, third).to_array();
        let along = spectrum.reciprocal[0].to_array();
        let unit = 6.0 * PI * kernel.plan().radius / spectrum.volume;
        let unit = unit * spectrum.sharpening[1][second] * spectrum.sharpening[2][third];
        let mut first = [0.0; LANES];
        let mut sharpening = [0.0; LANES];
        for (lane, first) in first.iter_mut().enumerate() {
            *first = signed(start + lane, n1);
        }
        for (here, known) in sharpening.iter_mut().zip(&spectrum.sharpening[0][start..]) {
            *here = *known;
        }
        let mut k = [first; 3];
        for (c, k) in k.iter_mut().enumerate() {
            for k in k {
                *k = across[c] + *k * along[c];
            }
        }
        let mut k2 = [0.0; LANES];
        for component in &k {
            for (k2, k) in k2.iter_mut().zip(component) {
                *k2 += k * k;
            }
        }
        // The wave of no wave number is the mean flow, which is zero.
        let mut inverse = k2;
        for k2 in &mut inverse {
            *k2 = if *k2 > 0.0 { 1.0 / *k2 } else { 0.0 };
        }
        let mut factor = kernel.waves(&k2);
        for lane in 0..LANES {
            factor[lane] *= unit * sharpening[lane] * inverse[lane];
        }
        Self { k, inverse, factor }
    }
}

/// Multiplies modes by the wave part; `call` is compiled once for every instruction set and the best one runs.
struct Scale<'a, 'b> {
    lines: Lines<'a>,
    kernel: &'b Kernel,
}

impl pulp::NullaryFnOnce for Scale<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Lines {
            spectrum,
            second,
            third,
            modes,
        } = self.lines;
        let n1 = spectrum.points[0];
        let size = modes.len() / 3;
        let (x, rest) = modes.split_at_mut(size);
        let (y, z) = rest.split_at_mut(size);
        for line in 0..size / n1 {
            for start in (0..n1).step_by(LANES) {
                let mode = [start, second, third + line];
                let Group { k, inverse, factor } = Group::new(spectrum, self.kernel, mode);
                let range = line * n1 + start..line * n1 + n1.min(start + LANES);
                let modes = x[range.clone()]
                    .iter_mut()
                    .zip(&mut y[range.clone()])
                    .zip(&mut z[range]);
                for (lane, ((x, y), z)) in modes.enumerate() {
                    let [kx, ky, kz] = [k[0][lane], k[1][lane], k[2][lane]];
                    let along = (*x * kx + *y * ky + *z * kz) * inverse[lane];
                    *x = (*x - along * kx) * factor[lane];
                    *y = (*y - along * ky) * factor[lane];
                    *z = (*z - along * kz) * factor[lane];
                }
            }
        }
    }
}

/// The number of a mode with its sign.
#[inline(always)]
fn signed(m: usize, n: usize) -> f64 {
    if 2 * m <= n {
        m as f64
    } else {
        m as f64 - n as f64
    }
}
