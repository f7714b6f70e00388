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
