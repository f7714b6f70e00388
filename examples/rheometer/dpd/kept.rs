//! The files from which an interrupted run goes on.

use super::measure::Sample;
use crate::Problem;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter};
use std::path::{Path, PathBuf};
use zimm::prelude::*;

const HEADER: &str = "step,seconds,temperature,\
    stress_xx,stress_yy,stress_zz,stress_xy,stress_xz,stress_yz,\
    tension_xx,tension_yy,tension_zz,tension_xy,tension_xz,tension_yz,\
    stretch_xx,stretch_yy,stretch_zz,stretch_xy,stretch_xz,stretch_yz,\
    ends_xx,ends_yy,ends_zz,ends_xy,ends_xz,ends_yz";

impl Sample {
    /// Every bit of a sample in one line.
    fn line(&self) -> String {
        let mut numbers = vec![self.seconds, self.temperature];
        for m in [self.stress, self.tension, self.stretch, self.ends] {
            numbers.extend([
                m.x_axis.x, m.y_axis.y, m.z_axis.z, m.y_axis.x, m.z_axis.x, m.z_axis.y,
            ]);
        }
        let words: Vec<_> = numbers.iter().map(f64::to_string).collect();
        format!("{},{}", self.step, words.join(","))
    }

    fn from_line(line: &str) -> Option<Self> {
        let (step, numbers) = line.split_once(',')?;
        let numbers: Vec<f64> = numbers
            .split(',')
            .map(str::parse)
            .collect::<Result<_, _>>()
            .ok()?;
        let (&[seconds, temperature], tensors) = numbers.split_first_chunk()?;
        let [stress, tension, stretch, ends] = tensors.as_chunks::<6>().0 else {
            return None;
        };
        let symmetric = |&[xx, yy, zz, xy, xz, yz]: &[f64; 6]| {
            DMat3::from_cols(
                DVec3::new(xx, xy, xz),
                DVec3::new(xy, yy, yz),
                DVec3::new(xz, yz, zz),
            )
        };
        Some(Self {
            step: step.parse().ok()?,
            seconds,
            temperature,
            stress: symmetric(stress),
            tension: symmetric(tension),
            stretch: symmetric(stretch),
            ends: symmetric(ends),
        })
    }
}

/// A state and the samples that led to it.
pub(crate) type State<B> = (System<B>, Vec<Sample>);

/// The files of one rate: a checkpoint, and the samples that led to it.
#[derive(Clone, Debug)]
pub(crate) struct Kept {
    checkpoint: PathBuf,
    samples: PathBuf,
}

impl Kept {
    /// In this directory, whether they exist or not.
    pub(crate) fn at(directory: &Path, run: &str) -> Self {
        Self {
            checkpoint: directory.join(format!("{run}.checkpoint")),
            samples: directory.join(format!("{run}.csv")),
        }
    }

    /// Forgets an earlier run.
    pub(crate) fn remove(&self) -> io::Result<()> {
        for path in [&self.checkpoint, &self.samples] {
            if path.exists() {
                fs::remove_file(path)?;
            }
        }
        Ok(())
    }

    /// Writes the state. Samples first: those that are newer than the checkpoint are dropped by [`Self::load`].
    pub(crate) fn save<B: Periodic>(
        &self,
        fluid: &System<B>,
        forces: &mut impl ForceField<B>,
        samples: &[Sample],
    ) -> Result<(), Problem> {
        let lines = samples.iter().map(Sample::line);
        let text: Vec<String> = std::iter::once(HEADER.into()).chain(lines).collect();
        let part = self.samples.with_extension("part");
        fs::write(&part, text.join("\n") + "\n")?;
        fs::rename(part, &self.samples)?;
        Ok(save_file(fluid, forces, &self.checkpoint)?)
    }

    /// The state and the samples up to it, if there are any. `fresh` is what a run would begin with.
    pub(crate) fn load<B: Periodic>(&self, fresh: &System<B>) -> Result<Option<State<B>>, Problem> {
        if !self.checkpoint.exists() {
            return Ok(None);
        }
        let name = self.checkpoint.display();
        let fluid = load_file(fresh.boundary.clone(), &self.checkpoint)
            .map_err(|error| format!("{name}: {error}"))?;
        same_run(&fluid, fresh).map_err(|why| format!("{name} {why}"))?;
        let samples = read_samples(&self.samples, fluid.clock.now().step)?;
        Ok(Some((fluid, samples)))
    }

    /// Writes the state and, behind it, what has been averaged.
    pub(crate) fn save_average<B: Periodic>(
        &self,
        fluid: &System<B>,
        forces: &mut impl ForceField<B>,
        average: &StressProfileAverage,
    ) -> Result<(), Problem> {
        let part = self.checkpoint.with_extension("part");
        let mut file = BufWriter::new(File::create(&part)?);
        save(fluid, forces, &mut file)?;
        average.save(&mut file)?;
        file.into_inner()?.sync_all()?;
        Ok(fs::rename(part, &self.checkpoint)?)
    }

    /// The state, if there is one, with the average up to it. `fresh` is what a run would begin with.
    pub(crate) fn load_average<B: Periodic>(
        &self,
        fresh: &System<B>,
        average: &mut StressProfileAverage,
    ) -> Result<Option<System<B>>, Problem> {
        if !self.checkpoint.exists() {
            return Ok(None);
        }
        let mut file = BufReader::new(File::open(&self.checkpoint)?);
        let mut found = || -> Result<System<B>, Problem> {
            let fluid = load(fresh.boundary.clone(), &mut file)?;
            same_run(&fluid, fresh)?;
            average.restore(&mut file)?;
            Ok(fluid)
        };
        let name = self.checkpoint.display();
        let fluid = found().map_err(|error| format!("{name}: {error}"))?;
        Ok(Some(fluid))
    }
}

/// Refuses the state of another run.
fn same_run<B>(fluid: &System<B>, fresh: &System<B>) -> Result<(), String> {
    let key = |fluid: &System<B>| {
        let Now { dt, kt, seed, .. } = fluid.clock.now();
        (fluid.particles.len(), dt, kt, seed)
    };
    if key(fluid) == key(fresh) {
        return Ok(());
    }
    let (found, expected) = (key(fluid), key(fresh));
    let what = "(particles, dt, kT, seed of the noise)";
    Err(format!(
        "is of another run: {what} are {found:?} in it and {expected:?} here"
    ))
}

fn read_samples(path: &Path, last_step: u64) -> io::Result<Vec<Sample>> {
    let text = fs::read_to_string(path)?;
    let mut samples = Vec::new();
    for (number, line) in text.lines().enumerate().skip(1) {
        let damaged = || {
            io::Error::other(format!(
                "line {} of {} is damaged",
                number + 1,
                path.display()
            ))
        };
        let sample = Sample::from_line(line).ok_or_else(damaged)?;
        if sample.step <= last_step {
            samples.push(sample);
        }
    }
    Ok(samples)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn law_samples_are_kept_bit_for_bit() {
        let tensor = |x: f64| {
            let shear = DVec3::new(1.0 / x, 0.1 * x, 1e-300 * x);
            let diagonal = DMat3::from_diagonal(DVec3::new(x / 3.0, -1e300 / x, f64::MIN_POSITIVE));
            let upper = DMat3::from_cols(
                DVec3::ZERO,
                DVec3::X * shear.x,
                DVec3::new(shear.y, shear.z, 0.0),
            );
            diagonal + upper + upper.transpose()
        };
        let samples: Vec<Sample> = (1..50)
            .map(|step| Sample {
                step: 10 * step,
                seconds: 0.1 * step as f64,
                temperature: 1.0 / step as f64,
                stress: tensor(step as f64),
                tension: tensor(step as f64 + 0.5),
                stretch: tensor(step as f64 + 0.7),
                ends: tensor(step as f64 + 0.9),
            })
            .collect();
        let path =
            std::env::temp_dir().join(format!("rheometer-samples-{}.csv", std::process::id()));
        let text: Vec<_> = samples.iter().map(Sample::line).collect();
        fs::write(&path, format!("{HEADER}\n{}\n", text.join("\n"))).unwrap();
        assert_eq!(read_samples(&path, u64::MAX).unwrap(), samples);
        assert_eq!(read_samples(&path, 100).unwrap(), samples[..10]);
        assert_eq!(HEADER.split(',').count(), text[0].split(',').count());

        fs::write(&path, "names\n10,1,2\n").unwrap();
        assert!(
            read_samples(&path, 100)
                .unwrap_err()
                .to_string()
                .contains("line 2")
        );
        fs::remove_file(&path).unwrap();
    }
}
