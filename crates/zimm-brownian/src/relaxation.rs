//! Implicit springs: where connected beads go when their springs act at the end of the step.

use crate::{one_bond::lengths, symmetric::Factors};
use zimm_core::{BondForce, DMat3, DVec3};

/// The largest fraction of its limit that a solution leaves to a spring.
const FULLEST: f64 = 1.0 - 1e-12;
const SWEEPS: usize = 12;
const STEPS: usize = 40;
const MANY_STEPS: usize = 1000;
const STAGES: usize = 100;

/// What is to be solved: x_i = free_i + pull_i F_i(x) for one connected set of beads, with F the forces of springs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Problem<'a, S> {
    pub(crate) law: &'a S,
    /// Bonds as pairs of beads. The k-th bond joins bead k + 1 to an earlier one as long as there are beads; other
    /// bonds close rings.
    pub(crate) links: &'a [[u32; 2]],
    /// Where the beads would go without springs.
    pub(crate) free: &'a [DVec3],
    /// Mobilities times the time that springs act, all above zero.
    pub(crate) pull: &'a [f64],
    /// Relative tolerance.
    pub(crate) tolerance: f64,
    /// No coordinate of the solution is larger than this.
    pub(crate) extent: f64,
}

/// A set that was not solved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unsolved {
    /// Relative error reached.
    pub(crate) reached: f64,
    /// After how many rounds.
    pub(crate) iterations: usize,
}

/// The length that no spring passes.
#[inline(always)]
pub(crate) fn end<S: BondForce>(law: &S) -> f64 {
    law.limit() * FULLEST
}

/// What is left of a length when rounding may add to it where coordinates are as large as `extent`.
#[inline(always)]
pub(crate) fn safe<S: BondForce>(law: &S, extent: f64) -> f64 {
    1.0 - 16.0 * f64::EPSILON * extent / law.limit()
}

impl<S: BondForce> Problem<'_, S> {
    fn end(&self) -> f64 {
        end(self.law)
    }

    fn bonds(&self) -> impl Iterator<Item = (usize, usize)> {
        self.links.iter().map(|&[i, j]| (i as usize, j as usize))
    }

    /// Whether all bonds are shorter than a part of the limit.
    pub(crate) fn fits(&self, part: f64, x: &[DVec3]) -> bool {
        let most = part * self.law.limit();
        self.bonds().all(|(i, j)| (x[i] - x[j]).length() < most)
    }

    /// The gradient of sum |x_i - free_i|^2 / 2 pull_i + sum U.
    fn gradient(&self, x: &[DVec3], gradient: &mut Vec<DVec3>) {
        gradient.clear();
        let pulls = x.iter().zip(self.free).zip(self.pull);
        gradient.extend(pulls.map(|((x, free), pull)| (*x - *free) / *pull));
        for (i, j) in self.bonds() {
            let bond = x[i] - x[j];
            let force = self.law.force(bond.length_squared()) * bond;
            gradient[i] -= force;
            gradient[j] += force;
        }
    }

    /// The stiffness of a spring; where it would be negative, zero.
    fn stiffness(&self, bond: DVec3) -> DMat3 {
        let tension = |length: f64| -self.law.force(length * length) * length;
        let length = bond.length();
        if length == 0.0 {
            return DMat3::IDENTITY * (-self.law.force(0.0)).max(0.0);
        }
        let difference = 1e-4 * length.min(self.end() - length);
        let rise = tension(length + difference) - tension(length - difference);
        let along = (0.5 * rise / difference).max(0.0);
        let across = (tension(length) / length).max(0.0);
        let n = bond / length;
        let outer = DMat3::from_cols(n.x * n, n.y * n, n.z * n);
        DMat3::IDENTITY * across + outer * (along - across)
    }

    /// How much stronger springs would have to be to leave about half of their limit.
    fn slack(&self) -> f64 {
        let half = 0.5 * self.end();
        let tension = -self.law.force(half * half) * half;
        self.bonds().fold(1.0, |most, (i, j)| {
            let c = self.pull[i] + self.pull[j];
            let displacement = (self.free[i] - self.free[j]).length();
            most.max(displacement / (c * tension))
        })
    }

    /// How far bonds may go along a step of the beads before one reaches its end.
    fn reach(&self, x: &[DVec3], step: &[DVec3]) -> f64 {
        let end = self.end();
        if end == f64::INFINITY {
            return end;
        }
        self.bonds().fold(f64::INFINITY, |reach, (i, j)| {
            let (bond, change) = (x[i] - x[j], step[i] - step[j]);
            let length = bond.length();
            let (a, b) = (change.length_squared(), bond.dot(change));
            let c = (end - length) * (end + length);
            let root = (b * b + a * c).sqrt();
            let far = if b > 0.0 {
                c / (b + root)
            } else {
                (root - b) / a
            };
            reach.min(far)
        })
    }
}

/// How much the last round changed, on the scale of what it may.
#[derive(Clone, Copy, Debug, Default)]
struct Change {
    most: f64,
    longest: f64,
    tightest: f64,
}

impl Change {
    #[inline(always)]
    fn hear(&mut self, change: f64, length: f64, room: f64) {
        self.most = self.most.max(change);
        self.longest = self.longest.max(length);
        self.tightest = self.tightest.max(change / room);
    }

    fn relative(&self) -> f64 {
        (self.most / self.longest.max(f64::MIN_POSITIVE)).max(self.tightest)
    }
}

/// A bead of the tree, its own outer branches eliminated.
#[derive(Clone, Copy, Debug, Default)]
struct Branch {
    /// Stiffness of the bead and all beyond it, without the bond to its parent.
    own: DMat3,
    /// Factors of that with the bond.
    factors: Factors,
}

/// The solver and its memory.
///
/// For springs whose tension grows with their length the solution is the one minimum of the convex function
/// sum |x_i - free_i|^2 / 2 pull_i + sum U(Q). It is looked for bond by bond, which converges always, but slowly when
/// springs are stiff on the scale of the step; then by Newton's method along the tree of bonds, in steps that keep
/// every spring below its end. Bonds that close rings are brought in by conjugate gradients, which end after a few
/// rounds a ring.
#[derive(Clone, Debug, Default)]
pub(crate) struct Relaxation {
    tensions: Vec<DVec3>,
    lengths: Vec<f64>,
    stiffness: Vec<DMat3>,
    branches: Vec<Branch>,
    gradient: Vec<DVec3>,
    step: Vec<DVec3>,
    trial: Vec<DVec3>,
    residual: Vec<DVec3>,
    preconditioned: Vec<DVec3>,
    direction: Vec<DVec3>,
    image: Vec<DVec3>,
}

impl Relaxation {
    /// Solves one set. `x` holds a first guess, then the solution.
    pub(crate) fn solve<S: BondForce>(
        &mut self,
        problem: &Problem<'_, S>,
        x: &mut [DVec3],
    ) -> Result<(), Unsolved> {
        self.trial.clear();
        self.trial.extend_from_slice(x);
        if self.sweep(problem, x) {
            return Ok(());
        }
        if !fit(problem, 0.99, x) {
            x.copy_from_slice(&self.trial);
            fit(problem, 0.99, x);
        }
        if problem.end() == f64::INFINITY {
            return self.newton(problem, MANY_STEPS, x);
        }
        self.newton(problem, STEPS, x)
            .or_else(|_| self.follow(problem, x))
    }

    /// Newton's method for springs that are all but rods at their limit, which it cannot turn in straight steps.
    /// Springs that are stronger do not come so near to the limit; from there the solution is followed as they get
    /// weaker.
    fn follow<S: BondForce>(
        &mut self,
        problem: &Problem<'_, S>,
        x: &mut [DVec3],
    ) -> Result<(), Unsolved> {
        fit(problem, 0.5, x);
        let (mut strength, mut weaker) = (10.0 * problem.slack(), 0.1);
        let (mut pull, mut solved) = (problem.pull.to_vec(), None);
        let mut outcome = Ok(());
        for _ in 0..STAGES {
            for (pull, full) in pull.iter_mut().zip(problem.pull) {
                *pull = strength * full;
            }
            let stage = Problem {
                pull: &pull,
                ..*problem
            };
            let start = x.to_vec();
            outcome = self.newton(&stage, STEPS, x);
            match (&outcome, solved) {
                (Ok(()), _) if strength == 1.0 => return Ok(()),
                (Ok(()), _) => {
                    solved = Some(strength);
                    strength = (weaker * strength).max(1.0);
                }
                (Err(_), Some(last)) => {
                    x.copy_from_slice(&start);
                    weaker = f64::sqrt(weaker);
                    strength = (weaker * last).max(1.0);
                }
                (Err(_), None) => {
                    x.copy_from_slice(&start);
                    strength *= 10.0;
                }
            }
        }
        outcome.and(Err(Unsolved {
            reached: f64::INFINITY,
            iterations: STAGES,
        }))
    }

    /// Solves bond by bond, as long as that converges fast; the first guess is on trial. What is not a number is passed on; the stepper will find it.
    fn sweep<S: BondForce>(&mut self, problem: &Problem<'_, S>, x: &mut [DVec3]) -> bool {
        /// Springs that move beads by less than this part of a bond start as they are guessed, others from nothing.
        const WEAK: f64 = 0.1;
        let end = problem.end();
        self.tensions.clear();
        self.lengths.clear();
        x.copy_from_slice(problem.free);
        for (i, j) in problem.bonds() {
            let bond = self.trial[i] - self.trial[j];
            let stiffness = -problem.law.force(bond.length_squared());
            let weak = (problem.pull[i] + problem.pull[j]) * stiffness.abs() < WEAK;
            let tension = if weak { stiffness * bond } else { DVec3::ZERO };
            x[i] -= problem.pull[i] * tension;
            x[j] += problem.pull[j] * tension;
            self.tensions.push(tension);
            self.lengths.push(bond.length());
        }
        let mut before = f64::INFINITY;
        for _ in 0..SWEEPS {
            let mut change = Change::default();
            let bonds = problem.bonds().zip(&mut self.tensions);
            for (((i, j), tension), length) in bonds.zip(&mut self.lengths) {
                let (pull_i, pull_j) = (problem.pull[i], problem.pull[j]);
                let c = pull_i + pull_j;
                let bond = x[i] - x[j];
                let free = bond + c * *tension;
                let displacement = free.length();
                let (ends, guess) = ([end], [*length]);
                let tolerance = problem.tolerance;
                let found = lengths(problem.law, [c], [displacement], ends, guess, tolerance);
                let Some([found]) = found else {
                    return false;
                };
                // Beads that coincide have no direction to be pulled in.
                let scale = if displacement > 0.0 {
                    found / displacement
                } else {
                    1.0
                };
                let (new, pulled) = (scale * free, (1.0 - scale) / c * free);
                change.hear((new - bond).length(), found, end - found);
                let more = pulled - *tension;
                (*length, *tension) = (found, pulled);
                x[i] -= pull_i * more;
                x[j] += pull_j * more;
            }
            if change.relative() <= problem.tolerance {
                return true;
            }
            if change.most > 0.2 * before {
                return false;
            }
            before = change.most;
        }
        false
    }

    fn newton<S: BondForce>(
        &mut self,
        problem: &Problem<'_, S>,
        steps: usize,
        x: &mut [DVec3],
    ) -> Result<(), Unsolved> {
        let end = problem.end();
        let rounding = 64.0 * f64::EPSILON * problem.extent;
        let mut reached = f64::NAN;
        for iterations in 1..=steps {
            problem.gradient(x, &mut self.gradient);
            self.stiffness.clear();
            let stiffness = problem.bonds().map(|(i, j)| problem.stiffness(x[i] - x[j]));
            self.stiffness.extend(stiffness);
            self.eliminate(problem);
            self.newton_step(problem);

            let mut change = Change::default();
            for (i, j) in problem.bonds() {
                let length = (x[i] - x[j]).length();
                let moved = (self.step[i] - self.step[j]).length();
                change.hear((moved - rounding).max(0.0), length, end - length);
            }
            reached = change.relative();
            let downhill = dot(&self.gradient, &self.step);
            let farthest = 0.9 * problem.reach(x, &self.step);
            let mut part = farthest.min(1.0);
            let whole = part == 1.0;
            if !downhill.is_finite() {
                return Err(Unsolved {
                    reached,
                    iterations,
                });
            }
            let mut shortened = false;
            for _ in 0..60 {
                self.trial.clear();
                let moved = x.iter().zip(&self.step).map(|(x, step)| *x + part * *step);
                self.trial.extend(moved);
                problem.gradient(&self.trial, &mut self.image);
                let uphill = dot(&self.image, &self.step);
                if uphill <= -0.5 * downhill || reached <= problem.tolerance {
                    break;
                }
                part *= (downhill / (downhill - uphill)).clamp(0.1, 0.7);
                shortened = true;
            }
            x.copy_from_slice(&self.trial);
            if reached <= problem.tolerance && whole && !shortened {
                return Ok(());
            }
        }
        Err(Unsolved {
            reached,
            iterations: steps,
        })
    }

    /// Gaussian elimination of the tree, from its leaves to its root.
    fn eliminate<S: BondForce>(&mut self, problem: &Problem<'_, S>) {
        self.branches.clear();
        let alone = |pull: &f64| Branch {
            own: DMat3::IDENTITY * (1.0 / pull),
            factors: Factors::default(),
        };
        self.branches.extend(problem.pull.iter().map(alone));
        for k in (1..self.branches.len()).rev() {
            let (parent, bond) = (problem.links[k - 1][0] as usize, self.stiffness[k - 1]);
            let branch = &mut self.branches[k];
            branch.factors = Factors::new(branch.own + bond);
            // Bond and branch in series.
            let series = branch.own * branch.factors.solve_columns(bond);
            self.branches[parent].own += 0.5 * (series + series.transpose());
        }
        let root = &mut self.branches[0];
        root.factors = Factors::new(root.own);
    }

    /// The step from the gradient: along the tree at once, and what rings add by conjugate gradients.
    fn newton_step<S: BondForce>(&mut self, problem: &Problem<'_, S>) {
        let beads = self.branches.len();
        self.residual.clear();
        self.residual.extend(self.gradient.iter().map(|g| -*g));
        self.substitute(problem);
        std::mem::swap(&mut self.step, &mut self.preconditioned);
        let rings = problem.links.len() + 1 - beads;
        if rings == 0 {
            return;
        }
        self.multiply(problem, true);
        for (residual, image) in self.residual.iter_mut().zip(&self.image) {
            *residual -= *image;
        }
        let mut before = 0.0;
        self.direction.clear();
        self.direction.resize(beads, DVec3::ZERO);
        let start = dot(&self.gradient, &self.gradient);
        for _ in 0..3 * rings + 6 {
            if dot(&self.residual, &self.residual) <= 1e-28 * start {
                break;
            }
            self.substitute(problem);
            let now = dot(&self.residual, &self.preconditioned);
            let keep = if before > 0.0 { now / before } else { 0.0 };
            for (direction, new) in self.direction.iter_mut().zip(&self.preconditioned) {
                *direction = *new + keep * *direction;
            }
            self.multiply(problem, false);
            let part = now / dot(&self.direction, &self.image);
            if !part.is_finite() {
                break;
            }
            for k in 0..beads {
                self.step[k] += part * self.direction[k];
                self.residual[k] -= part * self.image[k];
            }
            before = now;
        }
    }

    /// `preconditioned` from `residual`: the equations of the tree alone.
    fn substitute<S: BondForce>(&mut self, problem: &Problem<'_, S>) {
        let solution = &mut self.preconditioned;
        solution.clone_from(&self.residual);
        for k in (1..solution.len()).rev() {
            let parent = problem.links[k - 1][0] as usize;
            let passed = self.stiffness[k - 1] * self.branches[k].factors.solve(solution[k]);
            solution[parent] += passed;
        }
        solution[0] = self.branches[0].factors.solve(solution[0]);
        for k in 1..solution.len() {
            let parent = problem.links[k - 1][0] as usize;
            let pulled = solution[k] + self.stiffness[k - 1] * solution[parent];
            solution[k] = self.branches[k].factors.solve(pulled);
        }
    }

    /// `image`: the second derivative times the step, or times the direction of the conjugate gradients.
    fn multiply<S: BondForce>(&mut self, problem: &Problem<'_, S>, step: bool) {
        let vector = if step { &self.step } else { &self.direction };
        self.image.clear();
        let alone = vector.iter().zip(problem.pull).map(|(v, pull)| *v / *pull);
        self.image.extend(alone);
        for ((i, j), stiffness) in problem.bonds().zip(&self.stiffness) {
            let force = *stiffness * (vector[i] - vector[j]);
            self.image[i] += force;
            self.image[j] -= force;
        }
    }
}

/// Shrinks a configuration until no spring is longer than this part of its end; false if it would be out of shape.
fn fit<S: BondForce>(problem: &Problem<'_, S>, part: f64, x: &mut [DVec3]) -> bool {
    let end = problem.end();
    let (mut longest, mut finite) = (0.0_f64, true);
    for (i, j) in problem.bonds() {
        let length = (x[i] - x[j]).length();
        longest = longest.max(length);
        finite &= length.is_finite();
    }
    if !finite || longest > 1e3 * end {
        return false;
    }
    if longest >= part * end {
        let scale = part * end / longest;
        x.iter_mut().for_each(|x| *x *= scale);
    }
    true
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zimm_core::{Molecules, Topology, noise};
    use zimm_forces::{Fene, Fraenkel, Hooke, MarkoSiggia};

    /// Normal numbers of variance one.
    fn random(seed: u64, count: usize) -> Vec<DVec3> {
        let noise = noise::Noise::new(seed, 0);
        let bead = |k| noise.site(k as u32).normal3(noise::Domain::user(1));
        (0..count).map(bead).collect()
    }

    fn molecules() -> [(&'static str, Molecules); 6] {
        [
            ("chain", Molecules::linear(0, 1, 10).unwrap()),
            ("ring of three", Molecules::ring(0, 1, 3).unwrap()),
            ("ring", Molecules::ring(0, 1, 12).unwrap()),
            ("star", Molecules::star(0, 1, 5, 3).unwrap()),
            ("comb", Molecules::comb(0, 1, 12, 3, 2).unwrap()),
            ("long chain", Molecules::linear(0, 1, 1000).unwrap()),
        ]
    }

    /// The first bonds must make a tree in the order of their beads, as `connected` sees to.
    fn links(molecules: &Molecules) -> Vec<[u32; 2]> {
        molecules.links().collect()
    }

    /// Solves, and returns the largest error of the equations, relative to the displacements by springs, less what the
    /// rounding of positions makes of forces near a limit.
    fn error<S: BondForce>(problem: &Problem<'_, S>, x: &mut [DVec3]) -> f64 {
        let mut solver = Relaxation::default();
        solver.solve(problem, x).unwrap();
        let mut gradient = Vec::new();
        problem.gradient(x, &mut gradient);
        let size = x.iter().fold(1.0, |most: f64, x| most.max(x.length()));
        let mut rounding: f64 = 0.0;
        for (i, j) in problem.bonds() {
            let bond = x[i] - x[j];
            assert!(bond.length() < problem.law.limit());
            let along = problem.stiffness(bond) * (bond / bond.length());
            let pull = problem.pull[i].max(problem.pull[j]);
            rounding = rounding.max(pull * along.length() * 1e-15 * size);
        }
        let mut largest: f64 = 0.0;
        let mut moved: f64 = 0.0;
        for ((gradient, pull), (x, free)) in
            (gradient.iter().zip(problem.pull)).zip(x.iter().zip(problem.free))
        {
            largest = largest.max(gradient.length() * pull);
            moved = moved.max((*x - *free).length());
        }
        (largest - 10.0 * rounding).max(0.0) / (moved + 1.0)
    }

    fn check<S: BondForce>(name: &str, law: &S, start: f64, strengths: &[f64]) {
        for (molecule, molecules) in molecules() {
            let links = links(&molecules);
            let beads = molecules.beads() as usize;
            for (round, &strength) in strengths.iter().enumerate() {
                // Beyond this, springs are closer to their limit than numbers resolve.
                for spread in [0.0, 1.0, 1e3].map(|spread: f64| spread.min(1e7 * strength)) {
                    let seed = 7 + round as u64;
                    // Bonds at the start are random, or all stretched to the same length on a chain.
                    let mut x = vec![DVec3::ZERO; beads];
                    let steps = random(seed, beads);
                    for bead in 1..beads {
                        let parent = molecules.parent(bead as u32).unwrap() as usize;
                        let straight = molecules.topology() == Topology::Linear;
                        let step = if straight {
                            start * steps[bead].normalize()
                        } else {
                            0.1 * start * steps[bead].normalize()
                        };
                        x[bead] = x[parent] + step;
                    }
                    let noise = random(seed + 100, beads);
                    let moved = x.iter().zip(&noise).map(|(x, z)| *x + spread * *z);
                    let free: Vec<DVec3> = moved.collect();
                    let pull: Vec<f64> = (0..beads)
                        .map(|k| strength * if k % 3 == 0 { 0.2 } else { 1.0 })
                        .collect();
                    let problem = Problem {
                        law,
                        links: &links,
                        free: &free,
                        pull: &pull,
                        tolerance: 1e-10,
                        extent: free.iter().fold(0.0, |most, r| most.max(r.length())),
                    };
                    let error = error(&problem, &mut x);
                    assert!(
                        error < 1e-8,
                        "{name}, {molecule}: error {error:e} at strength {strength}, spread {spread}"
                    );
                }
            }
        }
    }

    #[test]
    fn extreme_equations_hold_for_all_topologies_at_all_strengths() {
        let strengths = [1e-6, 1e-2, 1.0, 1e2, 1e4];
        check("Hooke", &Hooke::new(1.0).unwrap(), 1.0, &strengths);
        for limit in [1.05_f64, 7.0, 1000.0] {
            let start = 0.999_999 * limit;
            check("Fene", &Fene::new(1.0, limit).unwrap(), start, &strengths);
            let worm = MarkoSiggia::new(1.0, limit).unwrap();
            check("MarkoSiggia", &worm, start, &strengths);
        }
    }

    #[test]
    fn extreme_rods_have_a_solution_near_where_they_were() {
        let rod = Fraenkel::new(1.0, 1.0).unwrap();
        check("Fraenkel", &rod, 1.0, &[1e-6, 1e-2, 0.1]);
    }
}
