//! Density, velocity and temperature across the cell.

use crate::{AnalysisError, BlockAverage, Mean, RatioAverage};
use zimm_core::{DVec3, Estimator, Frame, Observable, ParameterError, Periodic};

/// What each layer across an axis holds, at one moment.
///
/// Layers are of equal width and cover one period of the cell along the axis, from -1/2 to 1/2 of it. In shear with
/// the gradient along y, `Profile::new(DVec3::Y, height, bins)` serves at all times: whatever the tilt of the cell and
/// its basis, its images repeat along y with its height. Velocities are peculiar, so a flow that is homogeneous shows
/// as zero everywhere, and a kink at a boundary as what it is.
///
/// ```
/// use zimm_analysis::{Profile, ProfileAverage};
/// use zimm_core::{DVec3, ParameterError};
///
/// let profile = Profile::new(DVec3::Y, 10.0, 4)?;
/// assert_eq!(profile.positions().collect::<Vec<_>>(), [-3.75, -1.25, 1.25, 3.75]);
/// let average = ProfileAverage::new(&profile);
/// # Ok::<(), ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Profile {
    pub(crate) axis: DVec3,
    pub(crate) period: f64,
    pub(crate) bins: usize,
}

/// What one layer holds at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Layer {
    /// Volume of the layer.
    pub volume: f64,
    /// Number of particles.
    pub particles: u64,
    /// Their mass.
    pub mass: f64,
    /// Their peculiar momentum, sum m c.
    pub momentum: DVec3,
    /// sum m c^2.
    pub twice_kinetic_energy: f64,
}

impl Profile {
    /// Across an axis of any length along which the cell repeats with this period, in this many layers.
    ///
    /// # Errors
    /// If the axis or the period is not finite or of no length, or there are no bins.
    pub fn new(axis: DVec3, period: f64, bins: usize) -> Result<Self, ParameterError> {
        let length = ParameterError::positive("length of the axis", axis.length())?;
        ParameterError::positive("bins", bins as f64)?;
        Ok(Self {
            axis: axis / length,
            period: ParameterError::positive("period", period)?,
            bins,
        })
    }

    /// The middle of each layer along the axis.
    pub fn positions(&self) -> impl Iterator<Item = f64> {
        let (period, bins) = (self.period, self.bins);
        (0..bins).map(move |k| ((k as f64 + 0.5) / bins as f64 - 0.5) * period)
    }

    /// The layer that holds a position, in whatever image.
    pub(crate) fn layer(&self, r: DVec3) -> usize {
        let periods = self.axis.dot(r) / self.period + 0.5;
        let layer = (periods - periods.floor()) * self.bins as f64;
        (layer as usize).min(self.bins - 1)
    }

    fn check<B: Periodic>(&self, boundary: &B) -> Result<(), AnalysisError> {
        const WHOLE: f64 = 1e-6;
        let basis = boundary.lattice().basis();
        for vector in [basis.x_axis, basis.y_axis, basis.z_axis] {
            let periods = self.axis.dot(vector) / self.period;
            if (periods - periods.round()).abs() > WHOLE {
                let period = self.period;
                return Err(AnalysisError::NotPeriodic { period, periods });
            }
        }
        Ok(())
    }
}

impl<B: Periodic, T> Observable<B, T> for Profile {
    type Output = Result<Vec<Layer>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        self.check(frame.boundary)?;
        if frame.velocities.is_empty() && !frame.is_empty() {
            return Err(AnalysisError::MissingColumn {
                column: "velocities",
            });
        }
        let volume = frame.boundary.lattice().volume() / self.bins as f64;
        let empty = Layer {
            volume,
            ..Layer::default()
        };
        let mut layers = vec![empty; self.bins];
        for (place, (&r, &c)) in frame.positions.iter().zip(frame.velocities).enumerate() {
            if let Some(layer) = layers.get_mut(self.layer(r)) {
                let mass = frame.mass(place);
                layer.particles += 1;
                layer.mass += mass;
                layer.momentum += mass * c;
                layer.twice_kinetic_energy += mass * c.length_squared();
            }
        }
        Ok(layers)
    }
}

/// Averages a [`Profile`] over time, layer by layer.
#[derive(Clone, Debug)]
pub struct ProfileAverage {
    positions: Vec<f64>,
    layers: Vec<LayerAverage>,
    samples: u64,
    misfit: Option<AnalysisError>,
}

#[derive(Clone, Debug, Default)]
struct LayerAverage {
    density: BlockAverage,
    velocity: [RatioAverage; 3],
    temperature: RatioAverage,
}

/// The averages of one layer.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerMeans {
    /// Middle of the layer along the axis.
    pub position: f64,
    /// Particles per volume.
    pub density: Mean,
    /// Peculiar velocity `<sum m c> / <sum m>`.
    pub velocity: [Mean; 3],
    /// Temperature as kT, `<sum m c^2> / <3 particles>`. Where momentum is conserved this is (1 - 1/N) of kT.
    pub temperature: Mean,
}

impl ProfileAverage {
    /// No samples yet of this profile.
    pub fn new(profile: &Profile) -> Self {
        Self {
            positions: profile.positions().collect(),
            layers: vec![LayerAverage::default(); profile.bins],
            samples: 0,
            misfit: None,
        }
    }
}

impl Estimator for ProfileAverage {
    type Sample = Vec<Layer>;
    type Estimate = Result<Vec<LayerMeans>, AnalysisError>;

    fn push(&mut self, layers: Vec<Layer>) {
        if layers.len() != self.layers.len() {
            self.misfit.get_or_insert(AnalysisError::Length {
                sample: self.samples,
                found: layers.len(),
                expected: self.layers.len(),
            });
        }
        for (average, layer) in self.layers.iter_mut().zip(layers) {
            average.density.push(layer.particles as f64 / layer.volume);
            for (velocity, momentum) in average.velocity.iter_mut().zip(layer.momentum.to_array()) {
                velocity.push([momentum, layer.mass]);
            }
            let freedom = 3.0 * layer.particles as f64;
            average
                .temperature
                .push([layer.twice_kinetic_energy, freedom]);
        }
        self.samples += 1;
    }

    /// # Errors
    /// Among others, [`AnalysisError::Denominator`] if a layer is empty nearly all the time.
    fn estimate(&self) -> Self::Estimate {
        if let Some(misfit) = &self.misfit {
            return Err(misfit.clone());
        }
        let layers = self.positions.iter().zip(&self.layers);
        layers
            .map(|(&position, layer)| {
                let [x, y, z] = &layer.velocity;
                Ok(LayerMeans {
                    position,
                    density: layer.density.estimate()?,
                    velocity: [x.estimate()?, y.estimate()?, z.estimate()?],
                    temperature: layer.temperature.estimate()?,
                })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, Random, at, step, system};
    use zimm_core::{DMat3, Particles};

    #[test]
    fn law_layers_follow_the_axis_in_any_image_and_basis() {
        let heights = [-1.9, -0.1, 0.1, 0.9, 1.1, 1.9, 5.9, -2.1];
        let positions = heights
            .iter()
            .map(|&y| DVec3::new(7.0 * y, y, 3.0))
            .collect();
        let velocities = heights.iter().map(|&y| DVec3::new(y, 0.0, 1.0)).collect();
        let masses = vec![2.0; 8];
        let particles = Particles::new(positions)
            .unwrap()
            .with_velocities(velocities)
            .unwrap();
        let cell = Cell::new(DMat3::from_diagonal(DVec3::new(3.0, 4.0, 5.0)), 0.3);
        let mut system = system(cell, particles.with_masses(masses).unwrap());
        for _ in 0..5 {
            let layers = Profile::new(2.0 * DVec3::Y, 4.0, 4)
                .unwrap()
                .measure(&system.frame(), &())
                .unwrap();
            let counts: Vec<u64> = layers.iter().map(|layer| layer.particles).collect();
            assert_eq!(counts, [1, 1, 2, 4]);
            assert!((layers[2].momentum - DVec3::new(2.0, 0.0, 4.0)).length() < 1e-14);
            assert!((layers[1].twice_kinetic_energy - 2.0 * 1.01).abs() < 1e-14);
            assert!((layers[0].volume - 15.0).abs() < 1e-12 && layers[0].mass == 2.0);
            step(&mut system, || DVec3::ZERO);
        }
    }

    // A gas of density 1 + 0.5 sin(2 pi y / L), velocity (0.4 cos(2 pi y / L), 0, 0) and kT = 1.3 around it, 300
    // particles sampled exactly by rejection. Seed 71, 600 frames, 5 layers. Each estimate comes with its error: below
    // 1.5 % of the mean density, 0.012 in velocity, 1.2 % in temperature; bounds 4 of them, so that 5 % in any is
    // caught. The temperature is about zero velocity, so it holds the flow's energy: kT + <u^2> / 3.
    #[test]
    fn limit_a_gas_with_known_profiles() {
        let (n, frames, edge, kt) = (300, 600, 6.0, 1.3_f64);
        let mut random = Random::new(71);
        let mut profile = Profile::new(DVec3::Y, edge, 5).unwrap();
        let mut average = ProfileAverage::new(&profile);
        let phase = |y: f64| std::f64::consts::TAU * y / edge;
        for _ in 0..frames {
            let mut positions = Vec::new();
            while positions.len() < n {
                let r = random.within(DMat3::IDENTITY * edge);
                if 1.5 * random.uniform() < 1.0 + 0.5 * phase(r.y).sin() {
                    positions.push(r);
                }
            }
            let flow = |r: &DVec3| DVec3::X * 0.4 * phase(r.y).cos();
            let velocities = positions
                .iter()
                .map(|r| flow(r) + kt.sqrt() * random.normal3())
                .collect();
            let particles = Particles::new(positions)
                .unwrap()
                .with_velocities(velocities)
                .unwrap();
            let system = system(Cell::lees_edwards(DVec3::splat(edge), 2.2), particles);
            average.push(profile.measure(&system.frame(), &()).unwrap());
        }
        let holds = |mean: Mean, exact: f64, precision: f64| {
            let error = mean.at_least();
            assert!(error < precision, "{mean}");
            assert!(
                (mean.value - exact).abs() < 4.0 * error,
                "{mean} against {exact}"
            );
        };
        for layer in average.estimate().unwrap() {
            // Means over the layer, weighted with the density, by the midpoint rule.
            let points = (0..1000)
                .map(|k| layer.position + edge / 5.0 * ((f64::from(k) + 0.5) / 1000.0 - 0.5));
            let (mut weight, mut velocity, mut square) = (0.0, 0.0, 0.0);
            for y in points {
                let (density, u) = (1.0 + 0.5 * phase(y).sin(), 0.4 * phase(y).cos());
                weight += density / 1000.0;
                velocity += density * u / 1000.0;
                square += density * u * u / 1000.0;
            }
            let mean_density = n as f64 / edge.powi(3);
            holds(layer.density.times(1.0 / mean_density), weight, 0.015);
            holds(layer.velocity[0], velocity / weight, 0.012);
            holds(layer.velocity[1], 0.0, 0.012);
            holds(layer.velocity[2], 0.0, 0.012);
            holds(layer.temperature, kt + square / weight / 3.0, 0.012 * kt);
        }
    }

    #[test]
    fn extreme_bad_axes_and_empty_layers_are_errors() {
        assert!(Profile::new(DVec3::ZERO, 1.0, 4).is_err());
        assert!(Profile::new(DVec3::Y, 0.0, 4).is_err());
        assert!(Profile::new(DVec3::Y, 1.0, 0).is_err());
        let particles = Particles::new(vec![DVec3::ZERO; 2]).unwrap();
        let still = at(Cell::cube(4.0), vec![DVec3::ZERO; 2]);
        let system = system(
            Cell::cube(4.0),
            particles.with_velocities(vec![DVec3::X; 2]).unwrap(),
        );
        let mut wrong = Profile::new(DVec3::Y, 3.0, 4).unwrap();
        assert!(matches!(
            wrong.measure(&system.frame(), &()),
            Err(AnalysisError::NotPeriodic { .. })
        ));
        let mut profile = Profile::new(DVec3::Y, 4.0, 4).unwrap();
        assert!(matches!(
            profile.measure(&still.frame(), &()),
            Err(AnalysisError::MissingColumn { .. })
        ));
        let mut average = ProfileAverage::new(&profile);
        assert!(matches!(
            average.estimate(),
            Err(AnalysisError::TooFew { .. })
        ));
        for _ in 0..2 {
            average.push(profile.measure(&system.frame(), &()).unwrap());
        }
        assert!(matches!(
            average.estimate(),
            Err(AnalysisError::Denominator { .. })
        ));
        average.push(vec![]);
        assert!(matches!(
            average.estimate(),
            Err(AnalysisError::Length { sample: 2, .. })
        ));
    }
}
