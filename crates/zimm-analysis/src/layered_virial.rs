//! The virial, layer by layer.

use crate::Profile;
use zimm_core::{DVec3, Item, Tally, Virial};

/// The virial of each layer of a [`Profile`], item by item.
///
/// Each interaction is shared among the layers that the straight line from one particle to the other crosses, as the
/// lengths of the line in them (Irving and Kirkwood, J. Chem. Phys. 18, 817, 1950, averaged over the layers). The
/// stress of a layer is so the mean over it of a stress whose divergence is the density of force: with a body force f
/// along x on particles of density n, d sigma_xy / dy = -n f on average, from layer to layer, whatever their width.
/// The layers add up to the [`Virial`] of the whole.
///
/// ```
/// use zimm_analysis::{LayeredVirial, Profile};
/// use zimm_core::{DVec3, Item, ParameterError, Tally};
///
/// // Layers of width 1 from -2 to 2; a pair from 0.5 down to -1.5.
/// let mut virial = LayeredVirial::new(&Profile::new(DVec3::Y, 4.0, 4)?);
/// virial.hear(Item::Spring, 0.5 * DVec3::Y, 2.0 * DVec3::Y, -2.0 * DVec3::Y, &|| 0.0);
/// let springs: Vec<f64> = virial.layers().iter().map(|layer| layer.item(Item::Spring).y_axis.y).collect();
/// assert_eq!(springs, [-1.0, -2.0, -1.0, 0.0]);
/// assert_eq!(virial.total().item(Item::Spring).y_axis.y, -4.0);
/// # Ok::<(), ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct LayeredVirial {
    /// Layers per length along the axis.
    axis: DVec3,
    layers: Vec<Virial>,
}

impl LayeredVirial {
    /// Zero in the layers of this profile.
    pub fn new(profile: &Profile) -> Self {
        Self {
            axis: profile.axis * (profile.bins as f64 / profile.period),
            layers: vec![Virial::default(); profile.bins],
        }
    }

    /// The virial of each layer, in the order of [`Profile::positions`].
    pub fn layers(&self) -> &[Virial] {
        &self.layers
    }

    /// The virial of all layers together.
    pub fn total(&self) -> Virial {
        let mut total = Virial::default();
        for layer in &self.layers {
            total.absorb(*layer);
        }
        total
    }
}

impl Tally for LayeredVirial {
    fn fresh(&self) -> Self {
        Self {
            axis: self.axis,
            layers: vec![Virial::default(); self.layers.len()],
        }
    }

    fn hear(&mut self, item: Item, at: DVec3, r: DVec3, force: DVec3, _: &impl Fn() -> f64) {
        /// A line that spans less than this of a layer lies in one.
        const FLAT: f64 = 1e-9;
        let bins = self.layers.len() as f64;
        let (end, span) = (self.axis.dot(at) + 0.5 * bins, self.axis.dot(r));
        let (low, high) = (end.min(end - span), end.max(end - span));
        let mut hear = |layer: f64, share: f64| {
            let within = layer - (layer / bins).floor() * bins;
            if let Some(virial) = self.layers.get_mut(within as usize) {
                virial.hear(item, at, share * r, force, &|| 0.0);
            }
        };
        let (first, last) = (low.floor(), high.floor());
        if first == last || high - low < FLAT {
            return hear(first, 1.0);
        }
        let share = (high - low).recip();
        let mut layer = first;
        while layer <= last {
            hear(layer, share * (high.min(layer + 1.0) - low.max(layer)));
            layer += 1.0;
        }
    }

    fn absorb(&mut self, other: Self) {
        for (mine, theirs) in self.layers.iter_mut().zip(other.layers) {
            mine.absorb(theirs);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Random;

    /// Interactions between points of a cell of height 5, at most 1.8 long, each heard from a random image.
    fn interactions(random: &mut Random) -> (Vec<DVec3>, Vec<[DVec3; 3]>, Vec<DVec3>) {
        let cell = DVec3::new(3.0, 5.0, 4.0);
        let points: Vec<DVec3> = (0..60)
            .map(|_| {
                cell * (DVec3::new(random.uniform(), random.uniform(), random.uniform()) - 0.5)
            })
            .collect();
        let mut forces = vec![DVec3::ZERO; points.len()];
        let mut heard = Vec::new();
        for i in 0..points.len() {
            for j in 0..i {
                let apart = points[i] - points[j];
                let r = apart - cell * (apart / cell).round();
                if r.length() < 1.8 {
                    let image = DVec3::new(0.0, 5.0, 0.0) * (3.0 * random.uniform() - 1.0).round();
                    let force = random.normal3();
                    forces[i] += force;
                    forces[j] -= force;
                    heard.push([points[i] + image, r, force]);
                }
            }
        }
        (points, heard, forces)
    }

    fn layered(heard: &[[DVec3; 3]], bins: usize) -> LayeredVirial {
        let mut virial = LayeredVirial::new(&Profile::new(DVec3::Y, 5.0, bins).unwrap());
        for &[at, r, force] in heard {
            virial.hear(Item::Conservative, at, r, force, &|| 0.0);
        }
        virial
    }

    // Momentum is conserved layer by layer, not on average but in every configuration: what leaves a layer through its
    // ends is what the forces on its particles add. For means over layers k and k + 1 of width w with a plane b between
    // them, W_k - W_(k+1) = sum_i F_i w max(0, 1 - |y_i - b| / w), whatever the width of the layers.
    #[test]
    fn law_the_divergence_of_the_local_stress_is_the_force() {
        let (points, heard, forces) = interactions(&mut Random::new(5));
        assert!(heard.len() > 300);
        for bins in [3, 4, 10, 40, 100] {
            let virial = layered(&heard, bins);
            let width = 5.0 / bins as f64;
            for k in 0..bins {
                let [here, next] =
                    [k, (k + 1) % bins].map(|k| virial.layers()[k].item(Item::Conservative).row(1));
                let plane = width * (k as f64 + 1.0) - 2.5;
                let mut added = DVec3::ZERO;
                for (r, &force) in points.iter().zip(&forces) {
                    let apart = (r.y - plane) - 5.0 * ((r.y - plane) / 5.0).round();
                    added += force * width * (1.0 - apart.abs() / width).max(0.0);
                }
                let (off, scale) = (here - next - added, added.length() + 1.0);
                assert!(off.length() < 1e-12 * scale, "{bins} {k}: {off}");
            }
        }
    }

    #[test]
    fn law_layers_add_up_to_the_virial_and_blocks_to_the_layers() {
        let (_, heard, _) = interactions(&mut Random::new(6));
        let mut whole = Virial::default();
        for &[at, r, force] in &heard {
            whole.hear(Item::Conservative, at, r, force, &|| 0.0);
        }
        for bins in [1, 3, 64] {
            let virial = layered(&heard, bins);
            let off = virial.total().total() - whole.total();
            assert!(off.abs_diff_eq(zimm_core::DMat3::ZERO, 1e-11), "{off}");
            let (mut first, second) = (layered(&heard[..100], bins), layered(&heard[100..], bins));
            first.absorb(second);
            for (a, b) in first.layers().iter().zip(virial.layers()) {
                assert!((a.total() - b.total()).abs_diff_eq(zimm_core::DMat3::ZERO, 1e-11));
            }
            assert!(
                virial
                    .fresh()
                    .layers()
                    .iter()
                    .all(|layer| *layer == Virial::default())
            );
        }
    }

    // Lines that lie in a plane between layers, that have no length, or that end in a plane are in one layer.
    #[test]
    fn extreme_lines_along_the_layers_are_counted_once() {
        for (at, r) in [
            (DVec3::ZERO, DVec3::X),
            (DVec3::Y, DVec3::new(1.0, 1e-300, 0.0)),
            (DVec3::new(0.0, 2.5, 0.0), DVec3::new(1.0, 1e-12, 0.0)),
            (DVec3::new(0.0, -2.5, 0.0), DVec3::ZERO),
            (DVec3::new(0.0, 1.0, 0.0), DVec3::Y),
        ] {
            let virial = layered(&[[at, r, DVec3::ONE]], 5);
            let found = virial.total().total();
            let expected = zimm_core::DMat3::from_cols(r, r, r);
            assert!(found.abs_diff_eq(expected, 1e-15), "{at} {r}: {found}");
        }
    }
}
