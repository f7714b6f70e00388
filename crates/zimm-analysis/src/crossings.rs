//! How often springs pass through each other, and how close they come.

use crate::AnalysisError;
use crate::followed::Places;
use crate::pairs::for_each_pair;
use zimm_core::{
    Boundary, DVec3, Frame, Item, Molecules, Neighbours, Observable, ParameterError, Tally,
};

/// How many times bonds, as straight segments, have passed through each other since the last measurement; zero at the
/// first one.
///
/// Beads move in straight lines at constant velocity from where they were, carried by the flow, to where they are: a
/// flow alone makes nothing cross, and neither images nor changes of the cell's basis show. The volume that two
/// segments span is then a polynomial of third degree in time. Wherever it changes sign the two lines cross, which
/// counts if they do so within both segments. This is exact for such a motion; two segments that pass through each
/// other and back again count twice. Between distant measurements beads did not move in straight lines, so measure
/// often: until the rate no longer depends on it.
///
/// Bonds that share a bead do not cross. The source of pairs looks as far as the longest bond and its motion, and has
/// to have room for that in the cell.
///
/// ```
/// use zimm_analysis::Crossings;
/// use zimm_core::{AllPairs, Clock, DVec3, Molecules, Observable, Open, Particles, System};
///
/// // A bond along y falls through one along x.
/// let beads = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, -0.5, 0.1), (0.5, 0.5, 0.1)];
/// let particles = Particles::new(beads.map(DVec3::from).to_vec())?;
/// let mut system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut crossings = Crossings::new(Molecules::linear(0, 2, 2)?, AllPairs::default());
/// assert_eq!(crossings.measure(&system.frame(), &())?, 0);
/// system.particles.positions_mut()[2..].iter_mut().for_each(|r| r.z -= 0.2);
/// assert_eq!(crossings.measure(&system.frame(), &())?, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Crossings<N> {
    molecules: Molecules,
    bonds: Vec<[u32; 2]>,
    neighbours: N,
    /// At the last measurement, by identity.
    last: Option<Places>,
}

/// A bond between two measurements, in one image.
#[derive(Clone, Copy, Debug)]
struct Sweep {
    identities: [u32; 2],
    from: [DVec3; 2],
    to: [DVec3; 2],
}

impl<N> Crossings<N> {
    /// Between the bonds of these molecules, from a source of pairs.
    pub fn new(molecules: Molecules, neighbours: N) -> Self {
        Self {
            molecules,
            bonds: molecules.bonds(),
            neighbours,
            last: None,
        }
    }

    /// Where each bond was and is.
    fn sweeps<B: Boundary>(
        &self,
        frame: &Frame<'_, B>,
        positions: &[DVec3],
        moved: &[DVec3],
    ) -> Result<Vec<Sweep>, AnalysisError> {
        let (particles, reach) = (positions.len(), frame.boundary.reach());
        let per_molecule = self.bonds.len() / self.molecules.iter().len().max(1);
        let sweep = |(bond, &[i, j]): (usize, &[u32; 2])| {
            let molecule = bond / per_molecule;
            let find = |identity: u32| {
                let missing = AnalysisError::NoSuchParticle {
                    molecule,
                    identity,
                    particles,
                };
                let place = identity as usize;
                positions.get(place).zip(moved.get(place)).ok_or(missing)
            };
            let ((&here, &by), (&there, &other)) = (find(i)?, find(j)?);
            let span = frame.boundary.min_image(there - here);
            for span in [span, span - (other - by)] {
                let length = span.length();
                let resolved = length < reach;
                if !resolved {
                    return Err(AnalysisError::BeyondCell {
                        molecule,
                        i,
                        j,
                        length,
                        reach,
                    });
                }
            }
            let to = [here, here + span];
            Ok(Sweep {
                identities: [i, j],
                from: [to[0] - by, to[1] - other],
                to,
            })
        };
        self.bonds.iter().enumerate().map(sweep).collect()
    }
}

impl<B: Boundary, T, N: Neighbours<B>> Observable<B, T> for Crossings<N> {
    type Output = Result<u64, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        let mut positions = vec![DVec3::ZERO; frame.len()];
        for (place, &r) in frame.positions.iter().enumerate() {
            if let Some(entry) = positions.get_mut(frame.id(place) as usize) {
                *entry = r;
            }
        }
        let moved = match &self.last {
            None => vec![DVec3::ZERO; positions.len()],
            Some(last) => last.moved(frame, &positions)?,
        };
        let sweeps = self.sweeps(frame, &positions, &moved)?;
        let mut crossings = 0;
        if self.last.is_some() {
            let mut centres = Vec::with_capacity(sweeps.len());
            let mut radii = Vec::with_capacity(sweeps.len());
            for sweep in &sweeps {
                let (centre, radius) = sweep.ball();
                centres.push(frame.boundary.wrap(centre).0);
                radii.push(radius);
            }
            let range = 2.0 * radii.iter().copied().fold(0.0, f64::max);
            let mut balls = *frame;
            balls.positions = &centres;
            (balls.velocities, balls.masses, balls.species) = (&[], &[], &[]);
            (balls.images, balls.ids) = (&[], &[]);
            self.neighbours.refresh(&balls, range)?;
            let order = self.neighbours.order();
            for_each_pair(&self.neighbours, range, |i, j, r| {
                let [i, j] = [order[i] as usize, order[j] as usize];
                if r.length() < radii[i] + radii[j] {
                    let (first, second) = (&sweeps[i], &sweeps[j]);
                    let shift = r - (first.ball().0 - second.ball().0);
                    if !first.shares_bead(second, shift, frame.boundary.reach()) {
                        crossings += first.crossings(second, shift);
                    }
                }
            });
        }
        self.last = Some(Places {
            time: frame.now.time,
            positions,
        });
        Ok(crossings)
    }
}

impl Sweep {
    /// A ball around everything that the bond sweeps.
    fn ball(&self) -> (DVec3, f64) {
        let corners = [self.from[0], self.from[1], self.to[0], self.to[1]];
        let centre = 0.25 * corners.iter().sum::<DVec3>();
        let distance = |corner: &DVec3| (*corner - centre).length();
        let radius = corners.iter().map(distance).fold(0.0, f64::max);
        (centre, radius * (1.0 + 1e-9))
    }

    /// Whether a bead of this bond, seen shifted, is one of the other's.
    fn shares_bead(&self, other: &Self, shift: DVec3, reach: f64) -> bool {
        (0..2).any(|k| {
            (0..2).any(|m| {
                self.identities[k] == other.identities[m]
                    && (self.to[k] + shift - other.to[m]).length() < reach
            })
        })
    }

    /// How many times this bond, shifted, passes through the other.
    fn crossings(&self, other: &Self, shift: DVec3) -> u64 {
        // a + time b of the two spans and of the vector between their first beads.
        let span = |sweep: &Self| {
            let span = sweep.from[1] - sweep.from[0];
            [span, sweep.to[1] - sweep.to[0] - span]
        };
        let (first, second) = (span(self), span(other));
        let apart = self.from[0] + shift - other.from[0];
        let apart = [apart, self.to[0] + shift - other.to[0] - apart];
        let normal = [
            first[0].cross(second[0]),
            first[0].cross(second[1]) + first[1].cross(second[0]),
            first[1].cross(second[1]),
        ];
        let volume = Cubic([
            normal[0].dot(apart[0]),
            normal[0].dot(apart[1]) + normal[1].dot(apart[0]),
            normal[1].dot(apart[1]) + normal[2].dot(apart[0]),
            normal[2].dot(apart[1]),
        ]);
        let at = |line: [DVec3; 2], time: f64| line[0] + time * line[1];
        let within = |time: f64| {
            let (r, u, d) = (at(first, time), at(second, time), at(apart, time));
            let normal = r.cross(u);
            let on_segment = |other_span: DVec3| {
                let place = -normal.dot(d.cross(other_span)) / normal.length_squared();
                (0.0..=1.0).contains(&place)
            };
            on_segment(u) && on_segment(r)
        };
        volume.sign_changes().filter(|&time| within(time)).count() as u64
    }
}

/// c_0 + c_1 x + c_2 x^2 + c_3 x^3.
#[derive(Clone, Copy, Debug)]
struct Cubic([f64; 4]);

impl Cubic {
    fn at(&self, x: f64) -> f64 {
        let [a, b, c, d] = self.0;
        a + x * (b + x * (c + x * d))
    }

    /// Where it changes sign between 0 and 1; zero counts as positive, so that intervals that follow each other share
    /// out the changes between them.
    fn sign_changes(self) -> impl Iterator<Item = f64> {
        let [start, end] = self.turns();
        let pieces = [[0.0, start], [start, end], [end, 1.0]];
        let changes = move |[low, high]: [f64; 2]| {
            let falls = self.at(low) >= 0.0;
            (falls != (self.at(high) >= 0.0)).then(|| self.bisect(low, high, falls))
        };
        pieces.into_iter().filter_map(changes)
    }

    fn bisect(&self, mut low: f64, mut high: f64, falls: bool) -> f64 {
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if (self.at(middle) >= 0.0) == falls {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// Where it turns between 0 and 1, in order; it is monotonic from 0 to the first, to the second, to 1.
    fn turns(&self) -> [f64; 2] {
        // The slope, b + 2 c x + 3 d x^2, by the formula that does not cancel.
        let [_, b, c, d] = self.0;
        let root = (c * c - 3.0 * d * b).max(0.0).sqrt();
        let q = -(c + root.copysign(c));
        let inside = |x: f64| if x > 0.0 && x < 1.0 { x } else { 0.0 };
        let turns = [inside(q / (3.0 * d)), inside(b / q)];
        [turns[0].min(turns[1]), turns[0].max(turns[1])]
    }
}

/// The distances of springs that the force loop has heard of: those within the range of the
/// [repulsion](Item::SpringRepulsion), or of a law without force that is there to be heard.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpringDistances(pub Vec<f64>);

impl Tally for SpringDistances {
    fn fresh(&self) -> Self {
        Self::default()
    }

    fn hear(&mut self, item: Item, _: DVec3, r: DVec3, _: DVec3, _: &impl Fn() -> f64) {
        if item == Item::SpringRepulsion {
            self.0.push(r.length());
        }
    }

    fn absorb(&mut self, other: Self) {
        self.0.extend(other.0);
    }
}

/// The number of pairs of springs by their distance of closest approach, in bins of equal width up to `range`: what
/// [`SpringDistances`] has heard, in a histogram. Average frames with [`BlockAverages`](crate::BlockAverages).
///
/// This is the spring pair distribution of Clarke (PhD thesis, MIT, 2008, figure 5-5), as mean numbers of pairs per
/// frame. Springs that pass through each other make it tend to a constant at zero distance; where they cannot, it falls
/// to zero.
///
/// ```
/// use zimm_analysis::{SpringDistances, SpringDistribution};
/// use zimm_core::{Clock, Observable, Open, Particles, System};
///
/// let system = System::new(Open, Particles::new(vec![])?, Clock::new(0.01, 1.0, 1)?);
/// let heard = SpringDistances(vec![0.04, 0.12, 0.13, 0.4]);
/// let mut distribution = SpringDistribution::new(0.3, 3)?;
/// assert_eq!(distribution.measure(&system.frame(), &heard), [1.0, 2.0, 0.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringDistribution {
    range: f64,
    bins: usize,
}

impl SpringDistribution {
    /// Up to a range (a length), in this many bins.
    ///
    /// # Errors
    /// If the range is not above zero or there are no bins.
    pub fn new(range: f64, bins: usize) -> Result<Self, ParameterError> {
        ParameterError::positive("bins", bins as f64)?;
        let range = ParameterError::positive("range", range)?;
        Ok(Self { range, bins })
    }

    /// Number of bins.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// The middle of each bin.
    pub fn distances(&self) -> impl Iterator<Item = f64> {
        let width = self.range / self.bins as f64;
        (0..self.bins).map(move |k| (k as f64 + 0.5) * width)
    }
}

impl<B: Boundary> Observable<B, SpringDistances> for SpringDistribution {
    type Output = Vec<f64>;

    fn measure(&mut self, _: &Frame<'_, B>, heard: &SpringDistances) -> Vec<f64> {
        let mut pairs = vec![0.0; self.bins];
        let per_length = self.bins as f64 / self.range;
        for distance in &heard.0 {
            if let Some(count) = pairs.get_mut((distance * per_length) as usize) {
                *count += 1.0;
            }
        }
        pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, Random, at, step};
    use std::f64::consts::PI;
    use zimm_core::{AllPairs, DMat3, Open, System, VerletList};

    fn dumbbells<N>(count: u32, neighbours: N) -> Crossings<N> {
        Crossings::new(Molecules::linear(0, count, 2).unwrap(), neighbours)
    }

    /// Crossings of two bonds between beads at `from` and beads at `to`.
    fn crossed(from: [[f64; 3]; 4], to: [[f64; 3]; 4]) -> u64 {
        let mut system = at(Open, from.map(DVec3::from).to_vec());
        let mut crossings = dumbbells(2, AllPairs::default());
        assert_eq!(crossings.measure(&system.frame(), &()), Ok(0));
        system
            .particles
            .positions_mut()
            .copy_from_slice(&to.map(DVec3::from));
        crossings.measure(&system.frame(), &()).unwrap()
    }

    #[test]
    fn limit_two_bonds() {
        let bar = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let post = |x: f64, z: f64| [[x, -1.0, z], [x, 1.0, z]];
        let both = |a: [[f64; 3]; 2], b: [[f64; 3]; 2]| [a[0], a[1], b[0], b[1]];
        let falls = |x| crossed(both(bar, post(x, 0.3)), both(bar, post(x, -0.5)));
        // Through the bar, past its end, or not that far; both moving together.
        assert_eq!([falls(0.0), falls(0.999), falls(1.001)], [1, 1, 0]);
        assert_eq!(
            crossed(both(bar, post(0.0, 0.3)), both(bar, post(0.0, 0.1))),
            0
        );
        let lifted = bar.map(|[x, y, _]| [x, y, 0.6]);
        assert_eq!(
            crossed(both(bar, post(0.0, 0.3)), both(lifted, post(0.0, 0.9))),
            0
        );
        assert_eq!(
            crossed(both(bar, post(0.0, 0.3)), both(lifted, post(0.0, 0.3))),
            1
        );
        // Half a turn about its own middle, beads in straight lines.
        let turned = [[0.3, 1.0, 0.1], [0.3, -1.0, 0.1]];
        assert_eq!(
            crossed(
                both(bar, [[0.3, -1.0, 0.1], [0.3, 1.0, 0.1]]),
                both(bar, turned)
            ),
            0
        );
        // One end falls, the other rises, while it slides along: through and back.
        let there = [[0.0, -1.0, 0.1], [0.0, 3.0, -0.2]];
        let back = [[0.0, -3.0, -0.2], [0.0, 1.0, 0.1]];
        assert_eq!(crossed(both(bar, there), both(bar, back)), 2);
        // In a plane nothing passes through anything.
        let flat = |y: f64| [[-0.5, y, 0.0], [0.5, y, 0.0]];
        assert_eq!(crossed(both(bar, flat(0.2)), both(bar, flat(-0.2))), 0);
    }

    /// The roots of (x - 0.2) (x - 0.5) (x - 0.9), of a parabola, of a line; of what has none.
    #[test]
    fn limit_sign_changes_of_polynomials() {
        let check = |coefficients: [f64; 4], expected: &[f64]| {
            let found: Vec<f64> = Cubic(coefficients).sign_changes().collect();
            assert_eq!(found.len(), expected.len(), "{coefficients:?}: {found:?}");
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-14);
            }
        };
        check([-0.09, 0.73, -1.6, 1.0], &[0.2, 0.5, 0.9]);
        check([0.09, -0.73, 1.6, -1.0], &[0.2, 0.5, 0.9]);
        check([0.12, -0.7, 1.0, 0.0], &[0.3, 0.4]);
        check([-0.25, 1.0, 0.0, 0.0], &[0.25]);
        check([-0.25, 0.0, 1.0, 0.0], &[0.5]);
        check([-0.125, 0.0, 0.0, 1.0], &[0.5]);
        check([1.0, 0.0, 0.0, 0.0], &[]);
        check([0.0; 4], &[]);
        check([0.25, -1.0, 1.0001, 0.0], &[]);
    }

    /// Rods whose beads move at independent thermal velocities pass through each other at the rate of kinetic theory,
    /// per pair <|R_1 x R_2|> <|v_n|> / V = (pi / 4) L^2 sqrt(2 / pi) I / V, with I the mean over both rods of the
    /// width of the relative velocity at the contact, ((1 - s)^2 + s^2 + (1 - t)^2 + t^2)^1/2.
    ///
    /// 700 frames of 600 rods of length 1 in an oblique cell of 216, one step of 0.02 each: 8400 crossings, standard
    /// error 1.1 %, bound 4 of it. Seed 71. What rods turn and stretch within a step is of second order, 0.04 %.
    #[test]
    fn limit_rate_of_kinetic_theory() {
        let (n, frames, dt) = (600_u32, 700, 0.02);
        let edges = DVec3::splat(6.0);
        let (mut random, mut found) = (Random::new(71), 0);
        for _ in 0..frames {
            let mut positions = Vec::new();
            for _ in 0..n {
                let r = random.within(DMat3::from_diagonal(edges));
                positions.extend([r, r + random.normal3().normalize()]);
            }
            let mut system = at(Cell::lees_edwards(edges, 2.0), positions);
            let mut crossings = dumbbells(n, VerletList::new(0.0).unwrap());
            crossings.measure(&system.frame(), &()).unwrap();
            step(&mut system, || dt * random.normal3());
            found += crossings.measure(&system.frame(), &()).unwrap();
        }
        let squares = |s: f64| (1.0 - s).powi(2) + s * s;
        let nodes = (0..100).map(|k| (f64::from(k) + 0.5) / 100.0);
        let width = nodes
            .clone()
            .flat_map(|s| nodes.clone().map(move |t| (squares(s) + squares(t)).sqrt()))
            .sum::<f64>()
            / 1e4;
        let per_pair = 0.25 * PI * (2.0 / PI).sqrt() * width / 216.0;
        let pairs = 0.5 * f64::from(n) * f64::from(n - 1);
        let expected = pairs * per_pair * dt * f64::from(frames);
        println!("{found} crossings, {expected:.0} expected");
        assert!((found as f64 - expected).abs() < 4.0 * expected.sqrt());
    }

    /// In a flow that remaps its cell, the same rods cross at the same steps as without the flow; the flow alone makes
    /// none cross.
    #[test]
    fn law_a_flow_makes_nothing_cross() {
        let (n, edges, rate) = (500, DVec3::new(5.0, 4.0, 4.5), 0.07);
        let mut random = Random::new(72);
        let mut positions = Vec::new();
        for _ in 0..n {
            let r = random.within(DMat3::from_diagonal(edges));
            positions.extend([r, r + 0.4 * random.normal3().normalize()]);
        }
        let brick = DMat3::from_diagonal(edges);
        let start = |rate: f64| at(Cell::new(brick, rate), positions.clone());
        let mut scenes = [start(0.0), start(rate), start(rate)];
        let mut counters = [0; 3].map(|_| dumbbells(n, VerletList::new(0.0).unwrap()));
        let mut total = 0;
        for frame in 0..15 {
            let found = [0, 1, 2].map(|k| counters[k].measure(&scenes[k].frame(), &()).unwrap());
            assert_eq!(found, [found[0], found[0], 0], "frame {frame}");
            total += found[0];
            let kicks: Vec<DVec3> = (0..2 * n).map(|_| 0.05 * random.normal3()).collect();
            let mut shear = DMat3::IDENTITY;
            shear.y_axis.x = rate * (scenes[1].clock.now().time + 1.0);
            let kick = |system: &mut System<Cell>, deformation: DMat3| {
                let mut kicks = kicks.iter();
                step(system, || {
                    deformation * kicks.next().copied().unwrap_or_default()
                });
            };
            kick(&mut scenes[0], DMat3::IDENTITY);
            kick(&mut scenes[1], shear);
            kick(&mut scenes[2], DMat3::ZERO);
        }
        println!("{total} crossings");
        assert!(total > 100);
    }

    /// A chain whose beads jitter crosses others, never its own next bond; identities, not places, are what is
    /// followed.
    #[test]
    fn law_neighbours_do_not_cross_and_order_does_not_show() {
        let mut random = Random::new(73);
        let beads: Vec<DVec3> = (0..3).map(|_| random.normal3()).collect();
        let mut system = at(Open, beads);
        let mut crossings =
            Crossings::new(Molecules::linear(0, 1, 3).unwrap(), AllPairs::default());
        for _ in 0..200 {
            assert_eq!(crossings.measure(&system.frame(), &()), Ok(0));
            step(&mut system, || random.normal3());
            system.particles.permute(&[1, 2, 0]).unwrap();
        }
    }

    #[test]
    fn extreme_what_cannot_be_followed_is_an_error() {
        let beads = vec![
            DVec3::ZERO,
            1.5 * DVec3::X,
            DVec3::Y,
            DVec3::new(1.5, 1.0, 0.0),
        ];
        let scene = || at(Cell::cube(4.0), beads.clone());
        let counter = |count| dumbbells(count, VerletList::new(0.0).unwrap());
        assert!(matches!(
            counter(3).measure(&scene().frame(), &()),
            Err(AnalysisError::NoSuchParticle {
                molecule: 2,
                identity: 4,
                particles: 4
            })
        ));
        let (mut system, mut crossings) = (scene(), counter(2));
        crossings.measure(&system.frame(), &()).unwrap();
        system.particles.positions_mut()[1].x = 2.4;
        assert!(matches!(
            crossings.clone().measure(&system.frame(), &()),
            Err(AnalysisError::BeyondCell {
                molecule: 0,
                i: 0,
                j: 1,
                ..
            })
        ));
        system.particles.positions_mut()[1].x = 3.0;
        assert!(matches!(
            crossings.measure(&system.frame(), &()),
            Err(AnalysisError::TooFar { particle: 1, .. })
        ));
        let mut none = dumbbells(0, AllPairs::default());
        assert_eq!(none.measure(&system.frame(), &()), Ok(0));
        assert_eq!(none.measure(&system.frame(), &()), Ok(0));
        assert!(SpringDistribution::new(0.0, 3).is_err());
        assert!(SpringDistribution::new(1.0, 0).is_err());
    }
}
