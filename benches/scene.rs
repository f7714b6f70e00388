//! The Groot-Warren fluid (density 3, a = 25, gamma = 4.5, kT = 1) that the benches share.

use std::hint::black_box;
use zimm::prelude::*;

/// Density of the fluid.
pub(crate) const DENSITY: f64 = 3.0;
/// A skin that suits it at dt = 0.04.
pub(crate) const SKIN: f64 = 0.45;

/// The fluid in a cell, from random positions and thermal velocities.
pub(crate) fn fluid<B: Periodic>(boundary: B) -> System<B> {
    let lattice = *boundary.lattice();
    let count = (DENSITY * lattice.volume()).round() as usize;
    let mut rng = start::stream(1);
    let positions = start::uniform(&lattice, count, &mut rng);
    let particles = Particles::new(positions).expect("finite positions");
    let velocities = start::velocities(&particles, 1.0, &mut rng).expect("legal temperature");
    let particles = particles
        .with_velocities(velocities)
        .expect("as many velocities");
    System::new(
        boundary,
        particles,
        Clock::new(0.04, 1.0, 1).expect("legal clock"),
    )
}

/// A cube at rest.
pub(crate) fn cube(edge: f64) -> PeriodicBox {
    PeriodicBox::cubic(edge).expect("legal box")
}

/// The DPD law of the fluid with a Verlet list.
pub(crate) fn field() -> Pairwise<Dpd, VerletList> {
    let law = Dpd::new(25.0, 4.5).expect("legal parameters");
    Pairwise::new(law, VerletList::new(SKIN).expect("legal skin"))
}

/// The fluid after enough steps to forget its start.
pub(crate) fn equilibrated<B: Periodic>(boundary: B) -> (System<B>, Pairwise<Dpd, VerletList>) {
    let (mut system, mut field) = (fluid(boundary), field());
    let mut stepper = GrootWarren::new(0.65).expect("legal lambda");
    for _ in 0..100 {
        stepper
            .step(&mut system, &mut field, &mut ())
            .expect("a stable fluid");
    }
    (system, field)
}

/// Any law between the particles of the equilibrated fluid, evaluated again and again at the same positions.
pub(crate) struct Forces<L> {
    system: System<PeriodicBox>,
    field: Pairwise<L, VerletList>,
    forces: Vec<DVec3>,
}

impl<L: PairForce> Forces<L> {
    /// A law in a cell of the given edge.
    pub(crate) fn new(edge: f64, law: L) -> Self {
        let (system, _) = equilibrated(cube(edge));
        let forces = vec![DVec3::ZERO; system.particles.len()];
        let field = Pairwise::new(law, VerletList::new(SKIN).expect("legal skin"));
        Self {
            system,
            field,
            forces,
        }
    }

    /// One evaluation of all forces with a list that is valid.
    pub(crate) fn evaluate(&mut self) {
        self.tallied::<()>();
    }

    /// One evaluation of all forces with a list that is made anew.
    pub(crate) fn evaluate_with_new_list(&mut self) {
        ForceField::<PeriodicBox>::forget(&mut self.field);
        self.evaluate();
    }

    /// One evaluation of all forces that a tally hears.
    pub(crate) fn tallied<T: Tally + Default>(&mut self) {
        self.forces.fill(DVec3::ZERO);
        let mut tally = T::default();
        self.field
            .accumulate(&self.system.frame(), &mut self.forces, &mut tally)
            .expect("a stable fluid");
        black_box((&self.forces, &mut tally as *mut T));
    }
}

type Soft = (Pairwise<Dpd, VerletList>, Bonded<Fraenkel>);
type Springs = SegmentRepulsion<PanManke, VerletList>;

/// A melt of chains of 20 whose springs repel each other: density 3, a = 60, gamma = 4.5; springs of stiffness 450 and
/// length 0.85, repulsion 100 (1 - D / 0.8).
pub(crate) struct Melt {
    system: System<PeriodicBox>,
    field: (Soft, Springs),
    stepper: GrootWarren,
    forces: Vec<DVec3>,
}

impl Melt {
    /// About as many segments, after some steps in a bath that takes up the heat of a random start.
    pub(crate) fn new(segments: u32) -> Self {
        let chains = Molecules::linear(0, segments.div_ceil(19), 20).expect("legal chains");
        let bonds = chains.bonds();
        let beads = f64::from(chains.count() * chains.beads());
        let space = cube((beads / DENSITY).cbrt());
        let mut rng = start::stream(1);
        let positions = start::chains(space.lattice(), &chains, |_| 0.85, &mut rng);
        let particles = Particles::new(positions).expect("finite positions");
        let forces = vec![DVec3::ZERO; particles.len()];
        let clock = Clock::new(0.005, 1.0, 1).expect("legal clock");
        let mut system = System::new(space, particles, clock);
        let list = |skin| VerletList::new(skin).expect("legal skin");
        let dpd = Dpd::new(60.0, 4.5).expect("legal parameters");
        let spring = Fraenkel::new(450.0, 0.85).expect("legal parameters");
        let soft = (
            Pairwise::new(dpd, list(0.25)),
            Bonded::new(spring, bonds.clone()),
        );
        // 3 a = 100 at contact, a range of 3 times 0.8.
        let law = PanManke::new(100.0 / 3.0, 2.4).expect("legal parameters");
        let mut field = (soft, SegmentRepulsion::new(law, bonds, list(0.15)));
        let mut bath = Langevin::new(10.0).expect("legal rate");
        for _ in 0..100 {
            bath.step(&mut system, &mut field, &mut ())
                .expect("a stable melt");
        }
        Self {
            system,
            field,
            stepper: GrootWarren::new(0.5).expect("legal lambda"),
            forces,
        }
    }

    /// The repulsion alone, with a list that is valid.
    pub(crate) fn repulsion(&mut self) {
        let Self { system, field, .. } = self;
        field
            .1
            .accumulate(&system.frame(), &mut self.forces, &mut ())
            .expect("a stable melt");
        black_box(&self.forces);
    }

    /// A step.
    pub(crate) fn step(&mut self) {
        let Self { system, field, .. } = self;
        self.stepper
            .step(system, field, &mut ())
            .expect("a stable melt");
    }

    /// A step of chains that pass through each other.
    pub(crate) fn step_without(&mut self) {
        let Self { system, field, .. } = self;
        self.stepper
            .step(system, &mut field.0, &mut ())
            .expect("a stable melt");
    }
}
