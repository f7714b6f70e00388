//! Reverse Poiseuille flow as a rheometer.

use crate::ratio_average::clear_of_zero;
use crate::stress_profile::{StressLayerMeans, StressProfileAverage};
use crate::{AnalysisError, Mean, PolynomialFit, ShearFunctions, StandardError, minimum};
use zimm_core::{DMat3, DVec3, ParameterError};

/// The four half-channels of a reverse Poiseuille flow as one, and the material functions that it shows at all shear
/// rates from zero at its centre line to the largest at the planes where the flow turns round.
///
/// A force f along the flow acts on each particle above the middle of the [`Profile`](crate::Profile), where its
/// coordinate is above zero, and -f below. With y the distance from the nearest centre line, the balance of momentum
/// imposes the shear stress
///
/// ```text
/// tau(y) = f  integral of n from 0 to y
/// ```
///
/// whatever the fluid. The local rate is the slope of the velocity, from cubics through as many layers to either side
/// as the window has (Savitzky and Golay, Anal. Chem. 36, 1627, 1964); near the centre line the window reaches across
/// it, so that the polynomials there are even, and next to the planes of no flow, where the velocity bends, it stays on
/// one side of them. Then
///
/// ```text
/// eta = tau / rate,   Psi_1 = (sigma_xx - sigma_yy) / rate^2,   Psi_2 = (sigma_yy - sigma_zz) / rate^2
/// ```
///
/// with x along the flow, y across the layers, tau imposed and the normal stresses computed. These are taken from the
/// same polynomials: dense fluids are layered for a while wherever one looks, and what one layer has too much of the
/// next one lacks. Errors are those of a
/// [`Jackknife`](crate::Jackknife) over blocks of whole profiles: layers that move together are no independent
/// witnesses.
///
/// Backer, Lowe, Hoefsloot and Iedema, J. Chem. Phys. 122, 154503 (2005); Fedosov, Karniadakis and Caswell, J. Chem.
/// Phys. 132, 144103 (2010).
///
/// ```
/// use zimm_analysis::{AnalysisError, Channel, StressProfileAverage};
/// use zimm_core::DVec3;
///
/// fn viscosity(average: &StressProfileAverage) -> Result<String, AnalysisError> {
///     let channel = Channel::new(DVec3::X, 0.025)?.with_window(4)?;
///     let at_rest = channel.zero_shear(average, 0.5)?;
///     Ok(format!("eta_0 = {:#}, lambda_0 = {:#}", at_rest.viscosity, at_rest.relaxation_time))
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    flow: DVec3,
    force: f64,
    window: usize,
}

/// One layer of the folded channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelLayer {
    /// Distance from the centre line.
    pub distance: f64,
    /// Particles per volume.
    pub density: Mean,
    /// Particles of each species per volume.
    pub concentrations: Vec<Mean>,
    /// Velocity along the force.
    pub velocity: Mean,
    /// Temperature as kT, about the mean velocity.
    pub temperature: Mean,
    /// Pressure.
    pub pressure: Mean,
    /// Shear stress that the body force imposes.
    pub imposed: Mean,
    /// Shear stress computed from forces and motion.
    pub shear: Mean,
    /// sigma_xx - sigma_yy.
    pub first_difference: Mean,
    /// sigma_yy - sigma_zz.
    pub second_difference: Mean,
    /// Shear rate, minus the slope of the velocity.
    pub rate: Mean,
    /// The material functions at this rate, where the rate is clear of zero by four of its errors.
    pub functions: Option<ShearFunctions>,
}

/// Limits of the material functions as the rate goes to zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZeroShear {
    /// Viscosity.
    pub viscosity: Mean,
    /// First normal stress coefficient.
    pub psi1: Mean,
    /// Second normal stress coefficient.
    pub psi2: Mean,
    /// Mean relaxation time, Psi_1 / (2 eta).
    pub relaxation_time: Mean,
    /// -Psi_2 / Psi_1, where Psi_1 is clear of zero by four of its errors.
    pub ratio: Option<Mean>,
}

/// What a folded layer is in numbers, for one set of means.
pub(crate) struct Folded {
    distance: f64,
    /// Density, velocity, temperature, pressure, imposed and computed shear stress, normal stress differences, rate.
    numbers: [f64; NUMBERS],
    /// Normal stress differences of the polynomials through neighbouring layers.
    smooth: [f64; 2],
    concentrations: Vec<f64>,
}

const NUMBERS: usize = 9;
const FUNCTIONS: usize = 3;

impl Folded {
    pub(crate) fn imposed(&self) -> f64 {
        self.numbers[4]
    }

    pub(crate) fn rate(&self) -> f64 {
        self.numbers[8]
    }

    /// Viscosity and normal stress coefficients; zero at a rate of zero, which nobody is shown.
    pub(crate) fn functions(&self) -> [f64; FUNCTIONS] {
        let (imposed, rate, [first, second]) = (self.imposed(), self.rate(), self.smooth);
        if rate == 0.0 {
            return [0.0; FUNCTIONS];
        }
        [
            imposed / rate,
            first / (rate * rate),
            second / (rate * rate),
        ]
    }
}

impl Channel {
    /// A flow driven by a force of this size along this axis of any length.
    ///
    /// # Errors
    /// If the axis is of no length, or the force is zero or not finite.
    pub fn new(flow: DVec3, force: f64) -> Result<Self, ParameterError> {
        let length = ParameterError::positive("length of the axis of flow", flow.length())?;
        Ok(Self {
            flow: flow * (force.signum() / length),
            force: ParameterError::positive("size of the body force", force.abs())?,
            window: 3,
        })
    }

    /// Takes slopes from this many layers to either side; 3 if not told. Wider windows scatter less and flatten the
    /// velocity where it bends: compare two.
    ///
    /// # Errors
    /// If there are fewer than 2.
    pub fn with_window(self, window: usize) -> Result<Self, ParameterError> {
        if window < 2 {
            let name = "layers to either side in a window";
            return Err(ParameterError::new(name, window as f64, "at least 2"));
        }
        Ok(Self { window, ..self })
    }

    /// The folded channel from its centre line outwards.
    ///
    /// # Errors
    /// If there are too few samples, the number of layers is no multiple of four, or half a channel has fewer layers
    /// than the window.
    pub fn layers(
        &self,
        average: &StressProfileAverage,
    ) -> Result<Vec<ChannelLayer>, AnalysisError> {
        let flat = average.sums()?.of(|means| {
            let mut values = Vec::new();
            for layer in self.fold(average, means)? {
                values.extend(layer.numbers);
                values.extend(layer.functions());
                values.extend(layer.concentrations);
            }
            Ok(values)
        })?;
        let half = average.half_channel();
        let width = flat.len() / half.count.max(1);
        let layers = flat.chunks_exact(width.max(1)).enumerate();
        let layer = |(k, means): (usize, &[Mean])| {
            let (numbers, rest) = means.split_first_chunk::<NUMBERS>()?;
            let (functions, concentrations) = rest.split_first_chunk::<FUNCTIONS>()?;
            let &[
                density,
                velocity,
                temperature,
                pressure,
                imposed,
                shear,
                first,
                second,
                rate,
            ] = numbers;
            let &[viscosity, psi1, psi2] = functions;
            let functions = ShearFunctions {
                viscosity,
                psi1,
                psi2,
            };
            Some(ChannelLayer {
                distance: half.distance(k),
                density,
                concentrations: concentrations.to_vec(),
                velocity,
                temperature,
                pressure,
                imposed,
                shear,
                first_difference: first,
                second_difference: second,
                rate,
                functions: clear_of_zero(rate).is_ok().then_some(functions),
            })
        };
        Ok(layers.filter_map(layer).collect())
    }

    /// The viscosity of a fluid that has one, whatever the rate: that of the parabola
    ///
    /// ```text
    /// V(y) = (n f / 2 eta) (h^2 - y^2),   h half a channel
    /// ```
    ///
    /// that fits the profile best. It takes all layers together, so its error is the least; of a fluid whose viscosity
    /// does depend on the rate it is some mean. The peak velocity of the parabola is n f h^2 / 2 eta.
    ///
    /// # Errors
    /// As [`layers`](Self::layers), and if there is no flow.
    pub fn viscosity(&self, average: &StressProfileAverage) -> Result<Mean, AnalysisError> {
        let half = average.half_channel();
        let reach = half.width * half.count as f64;
        let found = average.sums()?.of(|means| {
            let (mut drive, mut vs, mut ss) = (0.0, 0.0, 0.0);
            for layer in self.fold(average, means)? {
                // The mean of the parabola over the layer.
                let square = layer.distance * layer.distance + half.width * half.width / 12.0;
                let shape = 0.5 * (reach * reach - square);
                drive += self.force * layer.numbers[0] / half.count as f64;
                vs += layer.numbers[1] * shape;
                ss += shape * shape;
            }
            let bend = vs / ss;
            Ok(vec![bend, if bend == 0.0 { 0.0 } else { drive / bend }])
        })?;
        let &[bend, viscosity] = found.as_slice() else {
            return Err(no_layers());
        };
        clear_of_zero(bend)?;
        Ok(viscosity)
    }

    /// Zero-shear values from the centre line outwards, up to this share of half a channel: from velocities
    /// V - (n f / 2 eta) y^2 + c y^4, and from normal stress differences Psi (n f / eta)^2 y^2 + c y^4.
    ///
    /// The share is a compromise: where terms beyond y^4 matter it is too large. Compare two.
    ///
    /// # Errors
    /// As [`layers`](Self::layers), and if fewer than three layers are within the share, or the velocity is flat.
    pub fn zero_shear(
        &self,
        average: &StressProfileAverage,
        share: f64,
    ) -> Result<ZeroShear, AnalysisError> {
        let found = average.sums()?.of(|means| {
            let [bend, drive, first, second] = self.near_centre(average, means, share)?;
            let per = if bend == 0.0 { 0.0 } else { bend.recip() };
            let (viscosity, psi1, psi2) = (drive * per, first * per * per, second * per * per);
            let time = psi1 / (2.0 * viscosity);
            let ratio = if psi1 == 0.0 { 0.0 } else { -psi2 / psi1 };
            Ok(vec![bend, viscosity, psi1, psi2, time, ratio])
        })?;
        let &[bend, viscosity, psi1, psi2, relaxation_time, ratio] = found.as_slice() else {
            return Err(no_layers());
        };
        clear_of_zero(bend)?;
        Ok(ZeroShear {
            viscosity,
            psi1,
            psi2,
            relaxation_time,
            ratio: clear_of_zero(psi1).is_ok().then_some(ratio),
        })
    }

    /// Around the centre line: the gradient of the rate, n f, and both normal stress differences over the square of the
    /// distance.
    fn near_centre(
        &self,
        average: &StressProfileAverage,
        means: &[f64],
        share: f64,
    ) -> Result<[f64; 4], AnalysisError> {
        let half = average.half_channel();
        let most = share * half.width * half.count as f64;
        let mut layers = self.fold(average, means)?;
        layers.retain(|layer| layer.distance < most);
        let points = |pick: fn(&Folded) -> f64, power: i32| -> Vec<_> {
            let point = |layer: &Folded| {
                let square = layer.distance * layer.distance;
                let error = square.powi(power).recip();
                (square, equal(pick(layer) * error, error))
            };
            layers.iter().map(point).collect()
        };
        let velocity = PolynomialFit::<3>::new(&points(|layer| layer.numbers[1], 0))?;
        let first = PolynomialFit::<2>::new(&points(|layer| layer.numbers[6], 1))?;
        let second = PolynomialFit::<2>::new(&points(|layer| layer.numbers[7], 1))?;
        let density = layers.iter().map(|layer| layer.numbers[0]).sum::<f64>();
        Ok([
            -2.0 * velocity.coefficients[1],
            self.force * density / layers.len() as f64,
            first.coefficients[0],
            second.coefficients[0],
        ])
    }

    /// The exponent p of a fluid tau = kappa rate^p whose velocity
    ///
    /// ```text
    /// V(y) = V_c (1 - (y / h)^(1 + 1/p)),   h half a channel
    /// ```
    ///
    /// fits the profile best (Fedosov et al. 2010, eq. 9), between 0.1 and 10.
    ///
    /// # Errors
    /// As [`layers`](Self::layers), and if there is no flow.
    pub fn velocity_exponent(&self, average: &StressProfileAverage) -> Result<Mean, AnalysisError> {
        let half = average.half_channel();
        let reach = half.width * half.count as f64;
        let found = average.sums()?.of(|means| {
            let layers = self.fold(average, means)?;
            let misfit = |log_p: f64| {
                let power = 1.0 + (-log_p).exp();
                let shape = |layer: &Folded| 1.0 - (layer.distance / reach).powf(power);
                let (mut vv, mut vs, mut ss) = (0.0, 0.0, 0.0);
                for layer in &layers {
                    let (v, s) = (layer.numbers[1], shape(layer));
                    (vv, vs, ss) = (vv + v * v, vs + v * s, ss + s * s);
                }
                1.0 - vs * vs / (vv * ss)
            };
            let ends = [0.1_f64.ln(), 10.0_f64.ln()];
            let speed = layers.iter().map(|layer| layer.numbers[1]).sum::<f64>();
            Ok(vec![speed, minimum::golden(misfit, ends).exp()])
        })?;
        let &[speed, exponent] = found.as_slice() else {
            return Err(no_layers());
        };
        clear_of_zero(speed)?;
        Ok(exponent)
    }

    /// The channel that these means of sums make, from the centre line outwards.
    pub(crate) fn fold(
        &self,
        average: &StressProfileAverage,
        means: &[f64],
    ) -> Result<Vec<Folded>, AnalysisError> {
        let half = average.half_channel();
        let needed = 2 * self.window + 1;
        if half.count * 4 != half.layers || half.count < needed {
            return Err(ParameterError::new(
                "layers of a profile to fold",
                half.layers as f64,
                "a multiple of 4, and of 4 for each layer of the window",
            )
            .into());
        }
        let across = average.axis();
        let neutral = self.flow.cross(across);
        let mut folded: Vec<Folded> = (0..half.count)
            .map(|k| Folded {
                distance: half.distance(k),
                numbers: [0.0; NUMBERS],
                smooth: [0.0; 2],
                concentrations: Vec::new(),
            })
            .collect();
        for (k, layer) in average.layers(means).into_iter().enumerate() {
            // Quarters from the lowest: falling to the lower centre line, rising from it, and the same above.
            let (quarter, within) = (k / half.count, k % half.count);
            let outwards = if quarter % 2 == 0 {
                half.count - 1 - within
            } else {
                within
            };
            let forwards = if quarter < 2 { -1.0 } else { 1.0 };
            let turned = if quarter % 2 == 0 {
                forwards
            } else {
                -forwards
            };
            let Some(Folded {
                numbers,
                concentrations,
                ..
            }) = folded.get_mut(outwards)
            else {
                continue;
            };
            let StressLayerMeans {
                density,
                velocity,
                temperature,
                stress: [xx, yy, zz, xy, xz, yz],
                ..
            } = layer;
            let stress = DMat3::from_cols(
                DVec3::new(xx, xy, xz),
                DVec3::new(xy, yy, yz),
                DVec3::new(xz, yz, zz),
            );
            let component = |a: DVec3, b: DVec3| a.dot(stress * b);
            let normal = [self.flow, across, neutral].map(|axis| component(axis, axis));
            let here = [
                density,
                forwards * self.flow.dot(DVec3::from_array(velocity)),
                temperature,
                -(xx + yy + zz) / 3.0,
                0.0,
                turned * component(self.flow, across),
                normal[0] - normal[1],
                normal[1] - normal[2],
                0.0,
            ];
            for (number, here) in numbers.iter_mut().zip(here) {
                *number += 0.25 * here;
            }
            concentrations.resize(layer.concentrations.len(), 0.0);
            for (sum, here) in concentrations.iter_mut().zip(layer.concentrations) {
                *sum += 0.25 * here;
            }
        }
        let column = |number: usize| -> Vec<f64> {
            folded.iter().map(|layer| layer.numbers[number]).collect()
        };
        let [velocity, first, second] = [1, 6, 7].map(column);
        let mut within = 0.0;
        for (k, layer) in folded.iter_mut().enumerate() {
            let column = half.width * layer.numbers[0];
            layer.numbers[4] = self.force * (within + 0.5 * column);
            within += column;
            layer.numbers[8] = -self.local(&velocity, k)?[1] / half.width;
            layer.smooth = [self.local(&first, k)?[0], self.local(&second, k)?[0]];
        }
        Ok(folded)
    }

    /// The value and the slope, per layer, of an even function of the layers at one of them: of the cubic through the
    /// layers of the window.
    fn local(&self, values: &[f64], k: usize) -> Result<[f64; 2], AnalysisError> {
        let last = (k + self.window).min(values.len() - 1) as isize;
        let scale = self.window as f64;
        let mut points = Vec::with_capacity(2 * self.window + 1);
        for i in last - 2 * self.window as isize..=last {
            let mirrored = if i < 0 { -1 - i } else { i };
            if let Some(&value) = values.get(mirrored as usize) {
                points.push(((i - k as isize) as f64 / scale, equal(value, 1.0)));
            }
        }
        let [value, slope, ..] = PolynomialFit::<4>::new(&points)?.coefficients;
        Ok([value, slope / scale])
    }
}

fn no_layers() -> AnalysisError {
    AnalysisError::TooFew {
        what: "layers",
        found: 0,
        needed: 4,
    }
}

/// A value for a fit whose errors are told by other means.
fn equal(value: f64, error: f64) -> Mean {
    let error = StandardError::AtLeast(error);
    Mean { value, error }
}

/// Half a channel as a profile sees it.
pub(crate) struct HalfChannel {
    /// Layers of the profile.
    layers: usize,
    /// Layers of half a channel.
    count: usize,
    /// Width of a layer.
    width: f64,
}

impl HalfChannel {
    pub(crate) fn new(layers: usize, width: f64) -> Self {
        Self {
            layers,
            count: layers / 4,
            width,
        }
    }

    fn distance(&self, k: usize) -> f64 {
        (k as f64 + 0.5) * self.width
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;
    use crate::{Carreau, Layer, PowerLaw, Profile, Rheogram, StressLayer, StressProfile};
    use zimm_core::{Estimator, Item, Tally, Virial};

    const LAYERS: usize = 64;
    const HALF: f64 = 4.0;
    const FORCE: f64 = 0.3;
    const DENSITY: f64 = 2.0;

    /// A fluid driven along z with the gradient along x: its velocity and stress differences at a distance from the
    /// centre lines.
    struct Fluid {
        velocity: fn(f64) -> f64,
        rate: fn(f64) -> f64,
        psi: [f64; 2],
        noise: f64,
    }

    /// The mean of a function over a layer of this width.
    fn mean_over(width: f64, middle: f64, function: impl Fn(f64) -> f64) -> f64 {
        let at = |k: i32| function(middle + width * ((f64::from(k) + 0.5) / 50.0 - 0.5));
        (0..50).map(at).sum::<f64>() / 50.0
    }

    fn averaged(fluid: &Fluid, samples: u32, random: &mut Random) -> StressProfileAverage {
        let profile = Profile::new(DVec3::X, 4.0 * HALF, LAYERS).unwrap();
        let mut average = StressProfileAverage::new(&StressProfile::new(profile.clone(), 1));
        let width = 4.0 * HALF / LAYERS as f64;
        for _ in 0..samples {
            let layer = |x: f64| {
                let channel = x.signum();
                let distance = (x - channel * HALF).abs();
                let mut noise = || fluid.noise * random.normal();
                let (volume, mass) = (10.0, 10.0 * DENSITY);
                let velocity = channel * mean_over(width, distance, |y| (fluid.velocity)(y.abs()));
                let momentum = mass * DVec3::new(0.0, 0.0, velocity + noise());
                let rate = mean_over(width, distance, |y| (fluid.rate)(y.abs()).powi(2));
                let sign = -channel * (x - channel * HALF).signum();
                let shear = sign * FORCE * DENSITY * distance + noise();
                // Axes: flow z, gradient x, neutral y. sigma_zz - sigma_xx, then sigma_xx - sigma_yy.
                let [first, second] = fluid.psi.map(|psi| psi * rate);
                let sigma = DMat3::from_cols(
                    DVec3::new(second - 5.0, 0.0, shear),
                    DVec3::new(0.0, -5.0, 0.0),
                    DVec3::new(shear, 0.0, first + second - 5.0),
                );
                let kinetic = DMat3::from_diagonal(DVec3::splat(mass))
                    + crate::tensor::outer(momentum / mass, momentum);
                let rest = sigma * -volume - DMat3::from_diagonal(DVec3::splat(mass));
                let mut virial = Virial::default();
                for (axis, column) in
                    DVec3::AXES
                        .into_iter()
                        .zip([rest.x_axis, rest.y_axis, rest.z_axis])
                {
                    virial.hear(Item::Conservative, DVec3::ZERO, column, axis, &|| 0.0);
                }
                StressLayer {
                    layer: Layer {
                        volume,
                        particles: mass as u64,
                        mass,
                        momentum,
                        twice_kinetic_energy: 0.0,
                    },
                    species: vec![15],
                    kinetic,
                    virial,
                }
            };
            average.push(profile.positions().map(layer).collect());
        }
        average
    }

    /// eta = 1.5: V = (n f / 2 eta) (h^2 - y^2).
    const NEWTON: Fluid = Fluid {
        velocity: |y| 0.2 * (HALF * HALF - y * y),
        rate: |y| 0.4 * y,
        psi: [3.0, -0.8],
        noise: 0.0,
    };

    #[test]
    fn limit_a_newtonian_fluid_without_noise() {
        let average = averaged(&NEWTON, 20, &mut Random::new(1));
        for (flow, force) in [(DVec3::Z, FORCE), (-3.0 * DVec3::Z, -FORCE)] {
            let channel = Channel::new(flow, force).unwrap();
            for layer in channel.layers(&average).unwrap() {
                let y = layer.distance;
                let close = |found: Mean, exact: f64| {
                    assert!(
                        (found.value - exact).abs() < 1e-9,
                        "{y}: {found} for {exact}"
                    );
                };
                close(layer.density, DENSITY);
                close(layer.concentrations[0], 1.5);
                close(layer.temperature, 1.0);
                close(layer.imposed, FORCE * DENSITY * y);
                close(layer.shear, FORCE * DENSITY * y);
                close(layer.rate, 0.4 * y);
                let functions = layer.functions.unwrap();
                close(functions.viscosity, 1.5);
                // The mean square of the rate over a layer is above the square of the mean.
                let square = 1.0 + 0.25_f64.powi(2) / (12.0 * y * y);
                assert!((functions.psi1.value / square - 3.0).abs() < 2e-3);
                assert!((functions.psi2.value / square + 0.8).abs() < 2e-3);
            }
            let rest = channel.zero_shear(&average, 0.5).unwrap();
            assert!((channel.viscosity(&average).unwrap().value - 1.5).abs() < 1e-4);
            assert!((rest.viscosity.value - 1.5).abs() < 1e-9);
            assert!((rest.psi1.value - 3.0).abs() < 0.1, "{}", rest.psi1);
            assert!((rest.relaxation_time.value - 1.0).abs() < 0.04);
            assert!((rest.ratio.unwrap().value - 0.8 / 3.0).abs() < 1e-9);
            let p = channel.velocity_exponent(&average).unwrap();
            assert!((p.value - 1.0).abs() < 0.01, "{p}");
        }
    }

    // tau = rate^p with p = 0.6: rate = (n f y)^(1/p). The velocity is taken as its mean over each layer, so the
    // exponent is as exact as the layers are thin: 1 %.
    #[test]
    fn limit_a_fluid_that_thins() {
        const P: f64 = 0.6;
        let fluid = Fluid {
            velocity: |y| {
                let speed = (DENSITY * FORCE).powf(1.0 / P) * P / (1.0 + P);
                speed * (HALF.powf(1.0 + 1.0 / P) - y.powf(1.0 + 1.0 / P))
            },
            rate: |y| (DENSITY * FORCE * y).powf(1.0 / P),
            ..NEWTON
        };
        let average = averaged(&fluid, 20, &mut Random::new(1));
        let channel = Channel::new(DVec3::Z, FORCE)
            .unwrap()
            .with_window(2)
            .unwrap();
        let p = channel.velocity_exponent(&average).unwrap();
        assert!((p.value - P).abs() < 0.01, "{p}");
        let rheogram = Rheogram::new(vec![(channel, average)]).unwrap();
        let law = rheogram.of(|points| {
            let fast = points
                .iter()
                .filter(|point| point.rate.value > 0.3)
                .copied();
            // Without noise there are no errors to weigh by.
            let weighed = fast.map(|mut point| {
                point.functions.viscosity.error = StandardError::AtLeast(0.01);
                point
            });
            let law = PowerLaw::fit(&weighed.collect::<Vec<_>>())?;
            Ok(vec![law.exponent, law.consistency])
        });
        let law = law.unwrap();
        assert!(
            (law[0].value - P).abs() < 0.01 && (law[1].value - 1.0).abs() < 0.02,
            "{law:?}"
        );
    }

    // 100 channels of 200 samples with noise of 0.3 in the velocity (up to 3.2) and in the shear stress of every layer,
    // seed 8. All viscosities are unbiased, and their deviations in units of their errors have a mean square of 1, to
    // be met within 4 standard errors of sqrt(2 / 100) and 10 % for the scatter of the errors themselves. Signs of a
    // half-channel that are wrong, or a fold that takes four quarters for independent when they are not, would show.
    #[test]
    fn limit_errors_cover_what_they_say() {
        let mut random = Random::new(8);
        let fluid = Fluid {
            noise: 0.3,
            ..NEWTON
        };
        let channel = Channel::new(DVec3::Z, FORCE).unwrap();
        let mut squares = [0.0; 4];
        const REPEATS: u32 = 100;
        for _ in 0..REPEATS {
            let average = averaged(&fluid, 200, &mut random);
            let layers = channel.layers(&average).unwrap();
            let local = layers[10].functions.unwrap().viscosity;
            let rest = channel.zero_shear(&average, 0.7).unwrap().viscosity;
            let whole = channel.viscosity(&average).unwrap();
            let shear = layers[5].shear.minus_independent(layers[5].imposed);
            let deviations = [(local, 1.5), (rest, 1.5), (whole, 1.5), (shear, 0.0)];
            for ((mean, exact), sum) in deviations.into_iter().zip(&mut squares) {
                *sum += ((mean.value - exact) / mean.at_least()).powi(2) / f64::from(REPEATS);
            }
        }
        println!("{squares:?}");
        for square in squares {
            assert!((0.5..1.65).contains(&square), "{square}");
        }
    }

    #[test]
    fn extreme_channels_that_cannot_be_folded_are_errors() {
        for (flow, force) in [(DVec3::ZERO, 1.0), (DVec3::X, 0.0), (DVec3::X, f64::NAN)] {
            assert!(Channel::new(flow, force).is_err());
        }
        let channel = Channel::new(DVec3::Z, FORCE).unwrap();
        assert!(channel.with_window(1).is_err());
        let average = averaged(&NEWTON, 20, &mut Random::new(1));
        let wide = channel.with_window(8).unwrap();
        assert!(matches!(
            wide.layers(&average),
            Err(AnalysisError::Parameter(_))
        ));
        assert!(channel.zero_shear(&average, 0.1).is_err());
        let still = Fluid {
            velocity: |_| 0.0,
            ..NEWTON
        };
        let still = averaged(&still, 20, &mut Random::new(1));
        assert!(
            channel
                .layers(&still)
                .unwrap()
                .iter()
                .all(|layer| layer.functions.is_none())
        );
        assert!(channel.viscosity(&still).is_err() && channel.zero_shear(&still, 0.5).is_err());
        assert!(channel.velocity_exponent(&still).is_err());
        let rheogram = Rheogram::new(vec![(channel, still)]).unwrap();
        assert_eq!(rheogram.points().count(), 0);
        assert!(
            rheogram
                .of(|points| Ok(vec![Carreau::fit(points, 0.0)?.time]))
                .is_err()
        );
        let profile = Profile::new(DVec3::X, 16.0, 64).unwrap();
        let empty = StressProfileAverage::new(&StressProfile::new(profile, 1));
        assert!(matches!(
            channel.layers(&empty),
            Err(AnalysisError::TooFew { .. })
        ));
    }
}
