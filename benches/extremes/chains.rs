//! Bead-spring chains without hydrodynamic interactions.

use crate::{Outcome, Problem, Trial};
use zimm::prelude::*;

/// One scene at its end of what is reasonable.
struct Case {
    tried: String,
    space: OpenFlow,
    chains: Molecules,
    spring: Fene,
    positions: Vec<DVec3>,
    dt: f64,
    steps: u64,
    /// Exact mean of Q^2 at rest, if the case is to be compared with it, and how far off it may be.
    exact: Option<(f64, f64)>,
}

pub(crate) fn trials() -> Result<Vec<Trial>, Problem> {
    let mut trials = Vec::new();
    for case in cases()? {
        let free = || FreeDraining::new(4.0);
        let springs = || Bonded::new(case.spring, case.chains.bonds());
        let rejection = Rejection::new(free()?, Diagonal, &springs()).within(100)?;
        let outcomes = [
            ("Euler", case.run(EulerMaruyama::new(free()?, Diagonal))?),
            ("Euler with rejection", case.run(rejection)?),
            ("Heun", case.run(Heun::new(free()?))?),
            (
                "semi-implicit",
                case.run(SemiImplicit::new(free()?, Diagonal))?,
            ),
        ];
        trials.extend(outcomes.map(|(scheme, outcome)| Trial {
            scheme,
            tried: case.tried.clone(),
            outcome,
        }));
    }
    Ok(trials)
}

fn cases() -> Result<Vec<Case>, Problem> {
    let mut cases = Vec::new();
    for wi in [1.0, 1e2, 1e3, 1e5] {
        cases.push(
            Case::new(
                format!("dumbbell b 50, extension Wi {wi:e}, dt 0.01"),
                50.0,
                2,
            )?
            .stretched(wi)?,
        );
        cases.push(
            Case::new(format!("dumbbell b 50, shear Wi {wi:e}, dt 0.01"), 50.0, 2)?.sheared(wi)?,
        );
    }
    for b in [1.1, 10.0, 1e3, 1e6] {
        cases.push(
            Case::new(format!("dumbbell b {b}, at rest, dt 0.01"), b, 2)?.at_rest(0.01, 0.03),
        );
        cases.push(
            Case::new(format!("dumbbell b {b}, at rest, dt 1"), b, 2)?.at_rest(1.0, f64::INFINITY),
        );
        cases.push(
            Case::new(format!("dumbbell b {b}, at rest, dt 100"), b, 2)?
                .at_rest(100.0, f64::INFINITY),
        );
    }
    for b in [1.1, 50.0, 1e6] {
        let mut case = Case::new(
            format!("dumbbell b {b}, springs at 0.999999 of their limit, dt 0.01"),
            b,
            2,
        )?;
        let length = 0.999999 * case.spring.limit();
        for (k, r) in case.positions.iter_mut().enumerate() {
            *r = DVec3::X * (length * (k % 2) as f64);
        }
        cases.push(case);
    }
    let mut case = Case::new("dumbbell b 50, beads on one point, dt 0.01".into(), 50.0, 2)?;
    case.positions.fill(DVec3::ZERO);
    cases.push(case);
    for (tried, dt) in [("0.01", 0.01), ("10", 10.0), ("1e6", 1e6)] {
        let mut case = Case::new(format!("chain of 1000 beads, b 50, dt {tried}"), 50.0, 1000)?;
        (case.dt, case.steps) = (dt, 20);
        cases.push(case);
    }
    let mut case = Case::new(
        "chain of 1000 beads on one point, extension Wi 1e5".into(),
        50.0,
        1000,
    )?
    .stretched(1e5)?;
    (case.dt, case.steps) = (1e-4, 20);
    case.positions.fill(DVec3::ZERO);
    cases.push(case);
    Ok(cases)
}

impl Case {
    /// Chains at rest in equilibrium, a thousand beads in all.
    fn new(tried: String, b: f64, beads: u32) -> Result<Self, Problem> {
        let chains = Molecules::linear(0, 1000 / beads, beads)?;
        let spring = Fene::new(1.0, b.sqrt())?;
        let bond = start::BondLength::new(&spring, 1.0)?;
        let mut rng = start::stream(7);
        Ok(Self {
            tried,
            space: OpenFlow::new(DMat3::ZERO)?,
            positions: start::isolated(&chains, |rng| bond.sample(rng), &mut rng),
            chains,
            spring,
            dt: 0.01,
            steps: 300,
            exact: None,
        })
    }

    fn stretched(mut self, rate: f64) -> Result<Self, ParameterError> {
        self.space = OpenFlow::new(DMat3::from_diagonal(DVec3::new(rate, -rate, 0.0)))?;
        Ok(self)
    }

    fn sheared(mut self, rate: f64) -> Result<Self, ParameterError> {
        self.space = OpenFlow::new(DMat3::from_cols(DVec3::ZERO, rate * DVec3::X, DVec3::ZERO))?;
        Ok(self)
    }

    fn at_rest(mut self, dt: f64, tolerance: f64) -> Self {
        let limit2 = self.spring.limit().powi(2);
        self.dt = dt;
        self.exact = Some((3.0 * limit2 / (limit2 + 5.0), tolerance));
        self
    }

    fn run(&self, mut stepper: impl Stepper<OpenFlow, Bonded<Fene>>) -> Result<Outcome, Problem> {
        let clock = Clock::new(self.dt, 1.0, 11)?;
        let mut system = System::new(self.space, Particles::new(self.positions.clone())?, clock);
        let mut springs = Bonded::new(self.spring, self.chains.bonds());
        let limit = self.spring.limit();
        let (mut sum, mut count) = (0.0, 0.0);
        for step in 1..=self.steps {
            let before = system.particles.positions().to_vec();
            if let Err(error) = stepper.step(&mut system, &mut springs, &mut ()) {
                return Ok(if system.particles.positions() == before {
                    Outcome::Refused(error.to_string())
                } else {
                    Outcome::Silent(format!("{error}; the last good state is lost"))
                });
            }
            recentre(&mut system, &self.chains)?;
            let positions = system.particles.positions();
            for &[i, j] in springs.bonds() {
                let length = (positions[j as usize] - positions[i as usize]).length();
                if length.is_nan() || length >= limit {
                    return Ok(Outcome::Silent(format!(
                        "step {step}: a spring is {length} long, its limit {limit}"
                    )));
                }
                if 2 * step > self.steps {
                    sum += length * length;
                    count += 1.0;
                }
            }
        }
        let found = sum / count;
        Ok(match self.exact {
            None => Outcome::Answer(format!("<Q^2> / Q_0^2 = {:.6}", found / (limit * limit))),
            Some((exact, tolerance)) => {
                let off = found / exact - 1.0;
                let text = format!("<Q^2> off by {:+.1} %", 100.0 * off);
                if off.abs() < tolerance {
                    Outcome::Answer(text)
                } else {
                    Outcome::Silent(text)
                }
            }
        })
    }
}
