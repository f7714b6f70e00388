//! Stress, concentrations and all that a [`Profile`] holds, layer by layer.

use crate::channel::HalfChannel;
use crate::stress::without;
use crate::tensor::outer;
use crate::{AnalysisError, Jackknife, Layer, LayeredVirial, Mean, Profile};
use std::io::{self, Read, Write};
use zimm_core::{
    DMat3, DVec3, Estimator, Frame, Item, Observable, ParameterError, Periodic, Virial,
};

/// The local stress: what each layer across an axis holds at one moment, forces included.
///
/// It needs a scene that tallies a [`LayeredVirial`] of the same profile, or a tuple that begins with one.
///
/// ```
/// use zimm_analysis::{LayeredVirial, Profile, StressProfile, StressProfileAverage};
/// use zimm_core::{Estimator, Frame, Item, Observable, Periodic};
///
/// fn look<B: Periodic>(
///     frame: &Frame<'_, B>,
///     heard: &LayeredVirial,
///     average: &mut StressProfileAverage,
/// ) -> Result<(), Box<dyn std::error::Error>> {
///     let profile = Profile::new(zimm_core::DVec3::Y, 50.0, 100)?;
///     let mut observable = StressProfile::new(profile, 1).without(Item::Random);
///     average.push(observable.measure(frame, heard)?);
///     Ok(())
/// }
/// ```
#[derive(Clone, Debug)]
pub struct StressProfile {
    profile: Profile,
    species: usize,
    without: Option<Item>,
}

/// What one layer holds at one moment, forces included.
#[derive(Clone, Debug, PartialEq)]
pub struct StressLayer {
    /// Particles, mass, momentum, energy.
    pub layer: Layer,
    /// Number of particles of each species.
    pub species: Vec<u64>,
    /// sum m c c.
    pub kinetic: DMat3,
    /// The virial, sum r_ij F_ij.
    pub virial: Virial,
}

impl StressProfile {
    /// In the layers of a profile; particles of this many species are counted apart, from species 0.
    pub fn new(profile: Profile, species: usize) -> Self {
        Self {
            profile,
            species,
            without: None,
        }
    }

    /// Leaves one item out. The noise of a step knows nothing of the positions of that step: its stress is zero on
    /// average, and without [`Item::Random`] profiles of DPD scatter less.
    pub fn without(mut self, item: Item) -> Self {
        self.without = Some(item);
        self
    }
}

impl<B: Periodic> Observable<B, LayeredVirial> for StressProfile {
    type Output = Result<Vec<StressLayer>, AnalysisError>;

    /// # Errors
    /// As for [`Profile`], and if the tally has other layers.
    fn measure(&mut self, frame: &Frame<'_, B>, heard: &LayeredVirial) -> Self::Output {
        let layers = self.profile.measure(frame, &())?;
        if heard.layers().len() != layers.len() {
            return Err(AnalysisError::Length {
                sample: frame.now.step,
                found: heard.layers().len(),
                expected: layers.len(),
            });
        }
        let with_virial = |(layer, virial): (Layer, &Virial)| StressLayer {
            layer,
            species: vec![0; self.species],
            kinetic: DMat3::ZERO,
            virial: match self.without {
                Some(item) => without(*virial, item),
                None => *virial,
            },
        };
        let mut layers: Vec<_> = layers
            .into_iter()
            .zip(heard.layers())
            .map(with_virial)
            .collect();
        for (place, (&r, &c)) in frame.positions.iter().zip(frame.velocities).enumerate() {
            if let Some(layer) = layers.get_mut(self.profile.layer(r)) {
                layer.kinetic += outer(frame.mass(place) * c, c);
                if let Some(count) = layer.species.get_mut(usize::from(frame.species(place))) {
                    *count += 1;
                }
            }
        }
        Ok(layers)
    }
}

impl<B: Periodic, T> Observable<B, (LayeredVirial, T)> for StressProfile {
    type Output = Result<Vec<StressLayer>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, (heard, _): &(LayeredVirial, T)) -> Self::Output {
        self.measure(frame, heard)
    }
}

/// Averages a [`StressProfile`] over time.
///
/// The stress is that of the motion about the mean velocity u of each layer, of the whole run,
///
/// ```text
/// sigma = -(1/V) (<sum m c c> - <sum m> u u + <sum r_ij F_ij>),    u = <sum m c> / <sum m>
/// ```
///
/// so that a flow is no stress; what the flow varies by within a layer of width w still counts as motion, with
/// n m (rate w)^2 / 12 in the pressure along the flow. The temperature is taken about u likewise.
///
/// Errors are those of a [`Jackknife`] over blocks of whole profiles, which knows how layers go together.
#[derive(Clone, Debug)]
pub struct StressProfileAverage {
    positions: Vec<f64>,
    axis: DVec3,
    width: f64,
    species: usize,
    volume: f64,
    sums: Jackknife,
    misfit: Option<AnalysisError>,
}

/// The averages of one layer; `T` is [`Mean`], or a number.
#[derive(Clone, Debug, PartialEq)]
pub struct StressLayerMeans<T = Mean> {
    /// Middle of the layer along the axis.
    pub position: f64,
    /// Particles per volume.
    pub density: T,
    /// Particles of each species per volume.
    pub concentrations: Vec<T>,
    /// Peculiar velocity of the layer.
    pub velocity: [T; 3],
    /// Temperature as kT, about that velocity.
    pub temperature: T,
    /// Stress sigma_xx, sigma_yy, sigma_zz, sigma_xy, sigma_xz, sigma_yz; tension is positive.
    pub stress: [T; 6],
}

/// Quantities of a layer that are averaged, species aside.
const QUANTITIES: usize = 17;

impl StressProfileAverage {
    /// No samples yet of this observable.
    pub fn new(observable: &StressProfile) -> Self {
        let StressProfile {
            profile, species, ..
        } = observable;
        Self {
            positions: profile.positions().collect(),
            axis: profile.axis,
            width: profile.period / profile.bins as f64,
            species: *species,
            volume: 0.0,
            sums: Jackknife::new(profile.bins * (QUANTITIES + species)),
            misfit: None,
        }
    }

    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.sums.samples()
    }

    /// Writes the state, bit for bit, as [`Jackknife::save`] does.
    ///
    /// # Errors
    /// If writing fails, or a sample was no good.
    pub fn save(&self, out: &mut impl Write) -> io::Result<()> {
        out.write_all(&self.volume.to_le_bytes())?;
        self.sums.save(out)
    }

    /// Takes up the state that [`save`](Self::save) wrote and forgets its own.
    ///
    /// # Errors
    /// If reading fails, or the state is not one of as many layers and species.
    pub fn restore(&mut self, input: &mut impl Read) -> io::Result<()> {
        let mut volume = [0; 8];
        input.read_exact(&mut volume)?;
        self.sums.restore(input)?;
        self.volume = f64::from_le_bytes(volume);
        Ok(())
    }

    pub(crate) fn half_channel(&self) -> HalfChannel {
        HalfChannel::new(self.positions.len(), self.width)
    }

    pub(crate) fn axis(&self) -> DVec3 {
        self.axis
    }

    pub(crate) fn sums(&self) -> Result<&Jackknife, AnalysisError> {
        match &self.misfit {
            Some(misfit) => Err(misfit.clone()),
            None => Ok(&self.sums),
        }
    }

    /// The layers that these means of the sums make.
    pub(crate) fn layers(&self, means: &[f64]) -> Vec<StressLayerMeans<f64>> {
        let layers = means.chunks_exact(QUANTITIES + self.species);
        let layers = self.positions.iter().zip(layers);
        layers
            .filter_map(|(&position, means)| self.layer(position, means))
            .collect()
    }

    fn layer(&self, position: f64, means: &[f64]) -> Option<StressLayerMeans<f64>> {
        let (&[particles, mass, px, py, pz], rest) = means.split_first_chunk()?;
        let (kinetic, rest) = rest.split_first_chunk::<6>()?;
        let (virial, counts) = rest.split_first_chunk::<6>()?;
        // A layer without particles has no velocity.
        let [ux, uy, uz] = [px, py, pz].map(|p| if mass > 0.0 { p / mass } else { 0.0 });
        let carried = [px * ux, py * uy, pz * uz, px * uy, px * uz, py * uz];
        let thermal: [f64; 6] = std::array::from_fn(|k| kinetic[k] - carried[k]);
        let [xx, yy, zz, ..] = thermal;
        Some(StressLayerMeans {
            position,
            density: particles / self.volume,
            concentrations: counts.iter().map(|count| count / self.volume).collect(),
            velocity: [ux, uy, uz],
            temperature: if particles > 0.0 {
                (xx + yy + zz) / (3.0 * particles)
            } else {
                0.0
            },
            stress: std::array::from_fn(|k| -(thermal[k] + virial[k]) / self.volume),
        })
    }
}

impl Estimator for StressProfileAverage {
    type Sample = Vec<StressLayer>;
    type Estimate = Result<Vec<StressLayerMeans>, AnalysisError>;

    fn push(&mut self, layers: Vec<StressLayer>) {
        let volume = layers.first().map_or(0.0, |layer| layer.layer.volume);
        if self.samples() == 0 {
            self.volume = volume;
        } else if (volume / self.volume - 1.0).abs() > 1e-6 {
            // Sums of layers of different volumes have no density.
            let problem = ParameterError::new("volume of a layer", volume, "the same at all times");
            self.misfit.get_or_insert(problem.into());
        }
        let mut sample = Vec::with_capacity(layers.len() * (QUANTITIES + self.species));
        for StressLayer {
            layer,
            species,
            kinetic,
            virial,
        } in layers
        {
            sample.extend([layer.particles as f64, layer.mass]);
            sample.extend(layer.momentum.to_array());
            sample.extend(components(kinetic));
            sample.extend(components(virial.total()));
            sample.extend(species.into_iter().map(|count| count as f64));
        }
        self.sums.push(sample);
    }

    fn estimate(&self) -> Self::Estimate {
        let width = QUANTITIES - 6 + self.species;
        let flat = self.sums()?.of(|means| {
            let mut values = Vec::with_capacity(self.positions.len() * width);
            for layer in self.layers(means) {
                values.extend([layer.density, layer.temperature]);
                values.extend(layer.velocity);
                values.extend(layer.stress);
                values.extend(layer.concentrations);
            }
            Ok(values)
        })?;
        let layers = self.positions.iter().zip(flat.chunks_exact(width));
        let layer = |(&position, means): (&f64, &[Mean])| {
            let (&[density, temperature], rest) = means.split_first_chunk()?;
            let (&velocity, rest) = rest.split_first_chunk()?;
            let (&stress, concentrations) = rest.split_first_chunk()?;
            Some(StressLayerMeans {
                position,
                density,
                concentrations: concentrations.to_vec(),
                velocity,
                temperature,
                stress,
            })
        };
        Ok(layers.filter_map(layer).collect())
    }
}

/// The components xx, yy, zz, xy, xz, yz of the symmetric part.
fn components(m: DMat3) -> [f64; 6] {
    let s = 0.5 * (m + m.transpose());
    [
        s.x_axis.x, s.y_axis.y, s.z_axis.z, s.y_axis.x, s.z_axis.x, s.z_axis.y,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, system};
    use zimm_core::{Particles, Tally};

    fn observable() -> StressProfile {
        StressProfile::new(Profile::new(DVec3::Y, 4.0, 2).unwrap(), 2)
    }

    /// Four particles, three of them above the middle, in a cell of edge 4, and what their forces are heard to be.
    fn sample(observable: &mut StressProfile) -> Vec<StressLayer> {
        let heights = [-1.0, 0.5, 1.0, 1.5];
        let positions = heights.map(|y| DVec3::new(3.0 * y, y, 0.0)).to_vec();
        let velocities = [-3.0, 1.0, 2.0, 6.0].map(|c| DVec3::new(c, 0.5 * c, 0.0));
        let particles = Particles::new(positions)
            .and_then(|particles| particles.with_velocities(velocities.to_vec()))
            .and_then(|particles| particles.with_masses(vec![2.0; 4]))
            .and_then(|particles| particles.with_species(vec![0, 1, 1, 5]));
        let system = system(Cell::cube(4.0), particles.unwrap());
        let mut heard = LayeredVirial::new(&observable.profile);
        // From 1 down to -1: half in either layer.
        let (at, r) = (DVec3::Y, 2.0 * DVec3::Y);
        heard.hear(
            Item::Conservative,
            at,
            r,
            DVec3::new(8.0, 16.0, 0.0),
            &|| 0.0,
        );
        heard.hear(Item::Random, at, r, 100.0 * DVec3::ONE, &|| 0.0);
        observable.measure(&system.frame(), &heard).unwrap()
    }

    // Layers of volume 32. Above: mean velocity (3, 1.5, 0), mass 6, sum m (c - u)^2 along x 2 (4 + 1 + 9) = 28, so 28,
    // 7 and 14 in xx, yy and xy. The virial of a layer is 16 in yy and, made symmetric, 4 in xy. Below one particle is
    // the mean of itself.
    #[test]
    fn limit_layers_with_known_motion_and_forces() {
        let mut observable = observable().without(Item::Random);
        let mut average = StressProfileAverage::new(&observable);
        for _ in 0..20 {
            average.push(sample(&mut observable));
        }
        let layers = average.estimate().unwrap();
        let values = |layer: &StressLayerMeans| layer.stress.map(|mean| -32.0 * mean.value);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} for {b}");
        for (layer, exact) in layers.iter().zip([
            [0.0, 16.0, 0.0, 4.0, 0.0, 0.0],
            [28.0, 23.0, 0.0, 18.0, 0.0, 0.0],
        ]) {
            for (a, b) in values(layer).into_iter().zip(exact) {
                close(a, b);
            }
        }
        let above = &layers[1];
        close(above.position, 1.0);
        close(above.density.value, 3.0 / 32.0);
        close(above.concentrations[0].value, 0.0);
        close(above.concentrations[1].value, 2.0 / 32.0);
        close(above.velocity[0].value, 3.0);
        close(above.velocity[1].value, 1.5);
        close(above.temperature.value, 35.0 / 9.0);
        close(layers[0].temperature.value, 0.0);
    }

    #[test]
    fn extreme_tallies_and_samples_of_other_layers_are_errors() {
        let mut observable = observable();
        let layers = sample(&mut observable);
        let particles = Particles::new(vec![DVec3::ZERO])
            .and_then(|particles| particles.with_velocities(vec![DVec3::ZERO]));
        let still = system(Cell::cube(4.0), particles.unwrap());
        let other = LayeredVirial::new(&Profile::new(DVec3::Y, 4.0, 3).unwrap());
        let measured = observable.measure(&still.frame(), &other);
        assert!(matches!(
            measured,
            Err(AnalysisError::Length { found: 3, .. })
        ));
        let mut average = StressProfileAverage::new(&observable);
        average.push(layers.clone());
        assert!(matches!(
            average.estimate(),
            Err(AnalysisError::TooFew { .. })
        ));
        let mut wider = layers.clone();
        wider[0].layer.volume = 40.0;
        average.push(wider);
        assert!(matches!(
            average.estimate(),
            Err(AnalysisError::Parameter(_))
        ));
        let mut average = StressProfileAverage::new(&observable);
        average.push(layers[..1].to_vec());
        average.push(layers);
        assert!(matches!(
            average.estimate(),
            Err(AnalysisError::Length { sample: 0, .. })
        ));
    }
}
