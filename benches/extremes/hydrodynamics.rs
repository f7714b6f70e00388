//! Mobilities and their roots.
//!
//! A product is wrong if it is not finite, not linear, or off by more than its tolerance from a direct sum at 1e-10. Roots are put to the test that holds for every realisation: the mean of |M^(1/2) z|^2 over
//! draws is the trace of M, which is 3 N times the mobility of a bead alone in its cell.

use crate::{Outcome, Problem, Trial};
use zimm::prelude::*;

const TOLERANCE: f64 = 1e-3;
const DRAWS: u64 = 100;

pub(crate) fn trials() -> Result<Vec<Trial>, Problem> {
    let mut trials = Vec::new();
    for (tried, edge, radius, positions) in scenes() {
        trials.extend(scene(&tried, edge, radius, &positions)?);
    }
    trials.extend(tolerances());
    trials.extend(not_numbers()?);
    trials.extend(pulled()?);
    Ok(trials)
}

/// Name, edge of the cell, radius of the beads, places of the beads.
type Scene = (String, f64, f64, Vec<DVec3>);

fn scenes() -> Vec<Scene> {
    let line = |count: u32, apart: f64| {
        (0..count)
            .map(|k| DVec3::X * (apart * f64::from(k)))
            .collect::<Vec<_>>()
    };
    let mut scenes = vec![
        ("no bead".into(), 10.0, 0.5, Vec::new()),
        ("one bead".into(), 10.0, 0.5, vec![DVec3::ZERO]),
        (
            "ten beads at one point".into(),
            10.0,
            0.5,
            vec![DVec3::ONE; 10],
        ),
        (
            "radius of one and a half cells".into(),
            1.0,
            1.5,
            line(3, 0.3),
        ),
        ("radius of twice the cell".into(), 1.0, 2.0, line(3, 0.3)),
        (
            "radius of four times the cell".into(),
            1.0,
            4.0,
            line(3, 0.3),
        ),
        ("radius of 1e12 cells".into(), 1.0, 1e12, line(3, 0.3)),
        ("radius of 1e-9 cells".into(), 1.0, 1e-9, line(3, 0.3)),
        ("beads 1e9 cells away".into(), 10.0, 0.5, line(3, 1e10)),
    ];
    // The mobility of two beads of radius 1/2 at r << 1 has the eigenvalue 9 r / 16 to 3 r / 8: condition numbers of
    // 4 / r and above.
    for apart in [1.0, 0.1, 1e-2, 1e-4, 4e-6, 1e-9] {
        scenes.push((
            format!("ten beads in a row, {apart} apart"),
            10.0,
            0.5,
            line(10, apart),
        ));
    }
    scenes
}

/// Every mobility and every root for one scene.
fn scene(tried: &str, edge: f64, radius: f64, positions: &[DVec3]) -> Result<Vec<Trial>, Problem> {
    let system = system(edge, positions)?;
    let trial = |scheme, outcome| Trial {
        scheme,
        tried: tried.into(),
        outcome,
    };
    let direct = || Ewald::new(1.0, radius, TOLERANCE);
    let mesh = || Mesh::new(1.0, radius, TOLERANCE);
    let open = || Rpy::new(1.0, radius);
    let free = System::new(
        Open,
        Particles::new(positions.to_vec())?,
        Clock::new(0.01, 1.0, 1)?,
    );
    let alone = alone(edge, radius)?;
    let (ours, unit) = ((&system, alone), (&free, Some(1.0)));
    Ok(vec![
        trial(
            "Ewald",
            against(&system, radius, alone, product(&system, direct()?)),
        ),
        trial(
            "Ewald, no storage",
            against(
                &system,
                radius,
                alone,
                product(&system, direct()?.without_storage()),
            ),
        ),
        trial(
            "Mesh",
            against(&system, radius, Some(1.0), product(&system, mesh()?)),
        ),
        trial("Rpy", outcome(product(&free, open()?))),
        trial(
            "Ewald, Cholesky",
            root(ours, direct()?, Cholesky::new(TOLERANCE)?),
        ),
        trial(
            "Ewald, Lanczos",
            root(ours, direct()?, Lanczos::new(TOLERANCE)?),
        ),
        trial(
            "Ewald, Chebyshev",
            root(ours, direct()?, Chebyshev::new(TOLERANCE)?),
        ),
        trial(
            "Mesh, Lanczos",
            root(ours, mesh()?, Lanczos::new(TOLERANCE)?),
        ),
        trial(
            "Mesh, Chebyshev",
            root(ours, mesh()?, Chebyshev::new(TOLERANCE)?),
        ),
        trial(
            "Mesh, SplitNoise",
            root(ours, mesh()?, SplitNoise::new(TOLERANCE)?),
        ),
        trial(
            "Rpy, Cholesky",
            root(unit, open()?, Cholesky::new(TOLERANCE)?),
        ),
        trial(
            "Rpy, Lanczos",
            root(unit, open()?, Lanczos::new(TOLERANCE)?),
        ),
        trial(
            "Rpy, Chebyshev",
            root(unit, open()?, Chebyshev::new(TOLERANCE)?),
        ),
    ])
}

fn system(edge: f64, positions: &[DVec3]) -> Result<System<PeriodicBox>, Problem> {
    let particles = Particles::new(positions.to_vec())?;
    Ok(System::new(
        PeriodicBox::cubic(edge)?,
        particles,
        Clock::new(0.01, 1.0, 1)?,
    ))
}

/// The mobility of a bead alone in its cell; nothing if the cell has none.
fn alone(edge: f64, radius: f64) -> Result<Option<f64>, Problem> {
    let one = system(edge, &[DVec3::ZERO])?;
    let mut mobility = Ewald::new(1.0, radius, 1e-10)?;
    if mobility.bind(&one.frame()).is_err() {
        return Ok(None);
    }
    Ok(Some(
        Entries::<PeriodicBox>::entry(&mobility, 0, 0).x_axis.x,
    ))
}

/// A product with forces of 1 and of 1e12: finite, linear, and, as forces must do work, F M F >= 0. Velocities, or what
/// came instead of them.
fn product<B: Boundary>(
    system: &System<B>,
    mut mobility: impl Mobility<B>,
) -> Result<Vec<DVec3>, Outcome> {
    let frame = system.frame();
    mobility
        .bind(&frame)
        .map_err(|error| Outcome::Refused(error.to_string()))?;
    let forces = forces(system);
    let great: Vec<DVec3> = forces.iter().map(|f| 1e12 * *f).collect();
    let [mut slow, mut fast] = [
        vec![DVec3::ZERO; forces.len()],
        vec![DVec3::ZERO; forces.len()],
    ];
    mobility.apply(&forces, &mut slow);
    mobility.apply(&great, &mut fast);
    if !fast.iter().chain(&slow).all(|v| v.is_finite()) {
        return Err(Outcome::Silent("not finite".into()));
    }
    let length = norm(&forces);
    let off = norm(
        &slow
            .iter()
            .zip(&fast)
            .map(|(a, b)| 1e-12 * *b - *a)
            .collect::<Vec<_>>(),
    );
    if off > 1e-9 * length {
        return Err(Outcome::Silent(format!(
            "forces of 1e12 are answered otherwise, by {off:e}"
        )));
    }
    let work: f64 = slow.iter().zip(&forces).map(|(v, f)| v.dot(*f)).sum();
    if work < -TOLERANCE * length * length {
        return Err(Outcome::Silent(format!("F M F = {work:e}")));
    }
    Ok(slow)
}

fn outcome(product: Result<Vec<DVec3>, Outcome>) -> Outcome {
    product.map_or_else(
        |other| other,
        |velocities| Outcome::Answer(format!("|M F| = {:.4e}", norm(&velocities))),
    )
}

/// Compares a product with a direct sum at 1e-10. The tolerance is relative to the velocity of one bead, and an error of
/// root-mean-square size: five times as much is too much.
fn against(
    system: &System<PeriodicBox>,
    radius: f64,
    one: Option<f64>,
    found: Result<Vec<DVec3>, Outcome>,
) -> Outcome {
    let found = match found {
        Ok(found) => found,
        Err(other) => return other,
    };
    let Ok(exact) = Ewald::new(1.0, radius, 1e-10).map(|exact| product(system, exact)) else {
        return Outcome::Silent("no exact product".into());
    };
    let (Ok(exact), Some(one)) = (exact, one) else {
        return Outcome::Silent("an answer where there is no mobility".into());
    };
    let off = norm(
        &found
            .iter()
            .zip(&exact)
            .map(|(a, b)| *a - *b)
            .collect::<Vec<_>>(),
    );
    let relative = off / (one * norm(&forces(system))).max(f64::MIN_POSITIVE);
    let text = format!("|M F| = {:.4e}, error {relative:.1e}", norm(&found));
    if relative < 5.0 * TOLERANCE {
        Outcome::Answer(text)
    } else {
        Outcome::Silent(text)
    }
}

fn forces<B: Boundary>(system: &System<B>) -> Vec<DVec3> {
    let frame = system.frame();
    let white = White::new(system.clock.next(), &frame);
    (0..frame.len()).map(|place| white.bead(place)).collect()
}

fn norm(column: &[DVec3]) -> f64 {
    column
        .iter()
        .map(|v| v.length_squared())
        .sum::<f64>()
        .sqrt()
}

/// Compares the mean square of draws with the trace. The variance of |M^(1/2) z|^2 is 2 tr M^2, at most 2 (tr M)^2 / 3
/// where all beads move as one: five standard errors of 100 draws are 41 % at worst, and 7 % for ten beads that do not
/// feel each other. It finds a root of the wrong scale, not a small error.
fn root<B: Boundary, M: Mobility<B>>(
    (system, alone): (&System<B>, Option<f64>),
    mut mobility: M,
    mut root: impl Root<B, M>,
) -> Outcome {
    let frame = system.frame();
    if let Err(error) = mobility.bind(&frame) {
        return Outcome::Refused(error.to_string());
    }
    let mut sum = 0.0;
    for step in 0..DRAWS {
        let now = Now {
            seed: 9,
            step,
            ..Now::default()
        };
        let white = White::new(now, &frame);
        let mut moved = vec![DVec3::ZERO; frame.len()];
        if let Err(error) = root.add(&mut mobility, &white, 1.0, &mut moved) {
            return Outcome::Refused(error.to_string());
        }
        sum += moved.iter().map(|r| r.length_squared()).sum::<f64>();
    }
    if !sum.is_finite() {
        return Outcome::Silent("not finite".into());
    }
    let Some(alone) = alone else {
        return Outcome::Silent("an answer where there is no mobility".into());
    };
    let trace = 3.0 * frame.len() as f64 * alone;
    if trace == 0.0 {
        return Outcome::Answer("nothing moves".into());
    }
    let off = sum / DRAWS as f64 / trace - 1.0;
    let text = format!("<x x> / tr M off by {:+.1} %", 100.0 * off);
    // At most three directions in which all beads move as one.
    if off.abs() < 5.0 * (2.0 / (3.0 * DRAWS as f64)).sqrt() {
        Outcome::Answer(text)
    } else {
        Outcome::Silent(text)
    }
}

/// Errors that cannot be asked for.
fn tolerances() -> Vec<Trial> {
    let asked = [0.0, -1e-3, 1e-17, 1.5, f64::NAN, f64::INFINITY];
    let trials = |tolerance: f64| {
        let trial = |scheme, refused: Option<ParameterError>| Trial {
            scheme,
            tried: format!("tolerance {tolerance:e}"),
            outcome: match refused {
                Some(error) => Outcome::Refused(error.to_string()),
                None => Outcome::Silent("accepted".into()),
            },
        };
        [
            trial("Ewald", Ewald::new(1.0, 0.5, tolerance).err()),
            trial("Mesh", Mesh::new(1.0, 0.5, tolerance).err()),
            trial("Cholesky", Cholesky::new(tolerance).err()),
            trial("Lanczos", Lanczos::new(tolerance).err()),
            trial("Chebyshev", Chebyshev::new(tolerance).err()),
            trial("SplitNoise", SplitNoise::new(tolerance).err()),
        ]
    };
    asked.into_iter().flat_map(trials).collect()
}

/// Positions that become no numbers after the start, which a particle set itself refuses.
fn not_numbers() -> Result<Vec<Trial>, Problem> {
    let mut trials = Vec::new();
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        let mut system = system(10.0, &[DVec3::ZERO, DVec3::X, DVec3::Y])?;
        system.particles.positions_mut()[1].y = bad;
        let mut add = |scheme, outcome| {
            trials.push(Trial {
                scheme,
                tried: format!("a position of {bad:e}"),
                outcome,
            });
        };
        add(
            "Ewald",
            outcome(product(&system, Ewald::new(1.0, 0.5, TOLERANCE)?)),
        );
        add(
            "Ewald, no storage",
            outcome(product(
                &system,
                Ewald::new(1.0, 0.5, TOLERANCE)?.without_storage(),
            )),
        );
        add(
            "Mesh",
            outcome(product(&system, Mesh::new(1.0, 0.5, TOLERANCE)?)),
        );
        let mut free = System::new(
            Open,
            Particles::new(vec![DVec3::ZERO; 3])?,
            Clock::new(0.01, 1.0, 1)?,
        );
        free.particles.positions_mut()[1].y = bad;
        add("Rpy", outcome(product(&free, Rpy::new(1.0, 0.5)?)));
    }
    Ok(trials)
}

/// Whole steps of chains that are pulled at with up to 1e300.
fn pulled() -> Result<Vec<Trial>, Problem> {
    let mut trials = Vec::new();
    let chains = Molecules::linear(0, 10, 10)?;
    let spring = Fene::new(1.0, 50.0_f64.sqrt())?;
    for pull in [1e6, 1e12, 1e300] {
        let mobility = || Mesh::new(4.0, 0.44, TOLERANCE);
        let noise = || SplitNoise::new(TOLERANCE);
        let springs = || Bonded::new(spring, chains.bonds());
        let euler = EulerMaruyama::new(mobility()?, noise()?);
        let rejection = Rejection::new(mobility()?, noise()?, &springs()).within(20)?;
        let implicit = SemiImplicit::new(mobility()?, noise()?);
        for (scheme, outcome) in [
            ("Mesh, Euler", stepped(euler, &chains, spring, pull)?),
            (
                "Mesh, rejection",
                stepped(rejection, &chains, spring, pull)?,
            ),
            (
                "Mesh, semi-implicit",
                stepped(implicit, &chains, spring, pull)?,
            ),
        ] {
            trials.push(Trial {
                scheme,
                tried: format!("force of {pull:e} on a bead of each chain"),
                outcome,
            });
        }
    }
    Ok(trials)
}

/// A force on the first bead of every chain.
#[derive(Clone, Copy)]
struct Pull(f64);

impl<B: Boundary> ForceField<B> for Pull {
    const READS: Reads = Reads::NOTHING;
    const CONSERVES_MOMENTUM: bool = false;

    fn accumulate<T: Tally>(
        &mut self,
        frame: &Frame<'_, B>,
        forces: &mut [DVec3],
        _: &mut T,
    ) -> Result<(), ForceError> {
        for (place, force) in forces.iter_mut().enumerate() {
            if frame.id(place).is_multiple_of(10) {
                force.x += self.0;
            }
        }
        Ok(())
    }
}

fn stepped(
    mut stepper: impl Stepper<PeriodicBox, (Bonded<Fene>, Pull)>,
    chains: &Molecules,
    spring: Fene,
    pull: f64,
) -> Result<Outcome, Problem> {
    let bond = start::BondLength::new(&spring, 1.0)?;
    let space = PeriodicBox::cubic(20.0)?;
    let mut rng = start::stream(5);
    let positions = start::chains(space.lattice(), chains, |rng| bond.sample(rng), &mut rng);
    let mut system = System::new(space, Particles::new(positions)?, Clock::new(0.01, 1.0, 1)?);
    let mut field = (Bonded::new(spring, chains.bonds()), Pull(pull));
    for step in 1..=10 {
        let before = system.particles.positions().to_vec();
        if let Err(error) = stepper.step(&mut system, &mut field, &mut ()) {
            return Ok(if system.particles.positions() == before {
                Outcome::Refused(error.to_string())
            } else {
                Outcome::Silent(format!("{error}; the last good state is lost"))
            });
        }
        let positions = system.particles.positions();
        for &[i, j] in field.0.bonds() {
            let r = system
                .boundary
                .min_image(positions[j as usize] - positions[i as usize]);
            if r.length() >= spring.limit() || r.is_nan() {
                return Ok(Outcome::Silent(format!(
                    "step {step}: a spring is {} long",
                    r.length()
                )));
            }
        }
    }
    Ok(Outcome::Answer(
        "ten steps, springs within their limits".into(),
    ))
}
