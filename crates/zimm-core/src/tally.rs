//! Listeners in the force loop: the virial, item by item, and the energy.

use glam::{DMat3, DVec3};

/// The items of the stress budget that come from forces; the kinetic item comes from the velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// Non-bonded forces with a potential.
    Conservative,
    /// Friction between pairs.
    Dissipative,
    /// Noise between pairs.
    Random,
    /// Springs.
    Spring,
    /// Repulsion between springs.
    SpringRepulsion,
    /// Velocity exchanges of a pairwise thermostat, as impulse over time step.
    Impulse,
}

impl Item {
    /// Every item, in order.
    pub const ALL: [Self; 6] = [
        Self::Conservative,
        Self::Dissipative,
        Self::Random,
        Self::Spring,
        Self::SpringRepulsion,
        Self::Impulse,
    ];
}

/// Listens to the force loop. `()` listens to nothing and costs nothing; a tuple is two listeners.
pub trait Tally: Send {
    /// Whether anything is heard; `false` takes the calls out of the loop.
    const LISTENS: bool = true;

    /// A listener of the same kind that has heard nothing; each block of work has one.
    fn fresh(&self) -> Self;

    /// One interaction: where i is, in any image; the separation r_ij, the force on i, and the potential energy for
    /// whoever asks.
    fn hear(&mut self, item: Item, at: DVec3, r: DVec3, force: DVec3, energy: &impl Fn() -> f64);

    /// Adds what another block heard; called in the order of blocks.
    fn absorb(&mut self, other: Self);
}

impl Tally for () {
    const LISTENS: bool = false;

    #[inline(always)]
    fn fresh(&self) {}

    #[inline(always)]
    fn hear(&mut self, _: Item, _: DVec3, _: DVec3, _: DVec3, _: &impl Fn() -> f64) {}

    #[inline(always)]
    fn absorb(&mut self, (): ()) {}
}

impl<A: Tally, B: Tally> Tally for (A, B) {
    const LISTENS: bool = A::LISTENS || B::LISTENS;

    fn fresh(&self) -> Self {
        (self.0.fresh(), self.1.fresh())
    }

    #[inline(always)]
    fn hear(&mut self, item: Item, at: DVec3, r: DVec3, force: DVec3, energy: &impl Fn() -> f64) {
        self.0.hear(item, at, r, force, energy);
        self.1.hear(item, at, r, force, energy);
    }

    fn absorb(&mut self, other: Self) {
        self.0.absorb(other.0);
        self.1.absorb(other.1);
    }
}

/// The virial sum r_ij F_ij, item by item.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Virial {
    items: [DMat3; Item::ALL.len()],
}

impl Default for Virial {
    /// Zero; the default of a matrix would be the identity.
    fn default() -> Self {
        let items = [DMat3::ZERO; Item::ALL.len()];
        Self { items }
    }
}

impl Virial {
    /// The virial of one item: sum of r_ij (rows) times F_ij (columns).
    pub fn item(&self, item: Item) -> DMat3 {
        self.items[item as usize]
    }

    /// All items together.
    pub fn total(&self) -> DMat3 {
        self.items.iter().fold(DMat3::ZERO, |sum, item| sum + *item)
    }
}

impl Tally for Virial {
    fn fresh(&self) -> Self {
        Self::default()
    }

    #[inline(always)]
    fn hear(&mut self, item: Item, _: DVec3, r: DVec3, force: DVec3, _: &impl Fn() -> f64) {
        let sum = &mut self.items[item as usize];
        sum.x_axis += force.x * r;
        sum.y_axis += force.y * r;
        sum.z_axis += force.z * r;
    }

    fn absorb(&mut self, other: Self) {
        for (mine, theirs) in self.items.iter_mut().zip(other.items) {
            *mine += theirs;
        }
    }
}

/// The potential energy of all forces that have one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy(pub f64);

impl Tally for Energy {
    fn fresh(&self) -> Self {
        Self::default()
    }

    #[inline(always)]
    fn hear(&mut self, item: Item, _: DVec3, _: DVec3, _: DVec3, energy: &impl Fn() -> f64) {
        if !matches!(item, Item::Dissipative | Item::Random | Item::Impulse) {
            self.0 += energy();
        }
    }

    fn absorb(&mut self, other: Self) {
        self.0 += other.0;
    }
}
