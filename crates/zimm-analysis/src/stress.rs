//! The stress, item by item.

use crate::tensor::{outer, trace};
use zimm_core::{DMat3, DVec3, Frame, Item, Observable, Periodic, Tally, Virial};

/// The stress of a frame, item by item, from the velocities and the virial that the force loop tallied.
///
/// ```text
/// sigma = -(1/V) (sum_i m c_i c_i + sum_pairs r_ij F_ij)        tension positive, pressure = -tr sigma / 3
/// ```
///
/// with c the peculiar velocity, r_ij = r_i - r_j and F_ij the force on i from j (Irving and Kirkwood, J.
/// Chem. Phys. 18, 817, 1950; Bird's pi is -sigma). A scene without velocities is overdamped: its kinetic item is the
/// mean over the velocities that were integrated out, -(N / V) kT 1.
///
/// A stress needs a cell, and a scene that tallies its virial: a [`Virial`], or a tuple that begins with one.
///
/// ```
/// use zimm_analysis::Stress;
/// use zimm_core::{Frame, Observable, Periodic, Virial};
///
/// fn shear<B: Periodic>(frame: &Frame<'_, B>, tally: &Virial) -> f64 {
///     Stress.measure(frame, tally).shear()
/// }
/// ```
///
/// A stress cannot be measured in a scene that tallies nothing:
///
/// ```compile_fail,E0277
/// use zimm_analysis::Stress;
/// use zimm_core::{Frame, Observable, Periodic, Virial};
///
/// fn shear<B: Periodic>(frame: &Frame<'_, B>, tally: &()) -> f64 {
///     Stress.measure(frame, tally).shear()
/// }
/// ```
///
/// nor in open space, which has no volume:
///
/// ```compile_fail,E0277
/// use zimm_analysis::Stress;
/// use zimm_core::{Boundary, Frame, Observable, Virial};
///
/// fn shear<B: Boundary>(frame: &Frame<'_, B>, tally: &Virial) -> f64 {
///     Stress.measure(frame, tally).shear()
/// }
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Stress;

impl<B: Periodic> Observable<B, Virial> for Stress {
    type Output = StressBudget;

    fn measure(&mut self, frame: &Frame<'_, B>, virial: &Virial) -> StressBudget {
        let mut kinetic = DMat3::ZERO;
        if frame.velocities.is_empty() {
            kinetic = DMat3::IDENTITY * (frame.len() as f64 * frame.now.kt);
        }
        for (place, &c) in frame.velocities.iter().enumerate() {
            kinetic += outer(frame.mass(place) * c, c);
        }
        StressBudget {
            volume: frame.boundary.lattice().volume(),
            kinetic,
            virial: *virial,
        }
    }
}

impl<B: Periodic, T> Observable<B, (Virial, T)> for Stress {
    type Output = StressBudget;

    fn measure(&mut self, frame: &Frame<'_, B>, (virial, _): &(Virial, T)) -> StressBudget {
        self.measure(frame, virial)
    }
}

/// The stress by the items it is made of; tension is positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressBudget {
    volume: f64,
    kinetic: DMat3,
    virial: Virial,
}

impl StressBudget {
    /// Volume of the cell.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// The stress of momentum carried by particles, -(1/V) sum m c c.
    pub fn kinetic(&self) -> DMat3 {
        self.kinetic * (-1.0 / self.volume)
    }

    /// The stress of one kind of force, -(1/V) sum r_ij F_ij.
    pub fn item(&self, item: Item) -> DMat3 {
        self.virial.item(item) * (-1.0 / self.volume)
    }

    /// The budget with one item left out, for what the rest adds up to.
    pub fn without(mut self, item: Item) -> Self {
        self.virial = without(self.virial, item);
        self
    }

    /// The whole stress.
    pub fn total(&self) -> DMat3 {
        (self.kinetic + self.virial.total()) * (-1.0 / self.volume)
    }

    /// Pressure, -tr sigma / 3.
    pub fn pressure(&self) -> f64 {
        -trace(&self.total()) / 3.0
    }

    /// Shear stress sigma_xy.
    pub fn shear(&self) -> f64 {
        let [shear, ..] = viscometric(self.total());
        shear
    }

    /// First and second normal stress differences, sigma_xx - sigma_yy and sigma_yy - sigma_zz.
    pub fn normal_differences(&self) -> [f64; 2] {
        let [_, first, second] = viscometric(self.total());
        [first, second]
    }

    /// The polymer stress of Kramers: that of the springs, less the pressure that as many free beads would add,
    ///
    /// ```text
    /// sigma_p = (1/V) sum_springs Q F - (springs / V) kT 1
    /// ```
    ///
    /// (Bird, Curtiss, Armstrong and Hassager 1987, sec. 13.3, whose tau_p is -sigma_p). It is zero on average at
    /// equilibrium if springs are the only forces between beads. In Brownian dynamics with others,
    /// [`ChainStress`](crate::ChainStress) counts them all.
    pub fn kramers(&self, springs: usize, kt: f64) -> DMat3 {
        self.item(Item::Spring) - DMat3::IDENTITY * (springs as f64 * kt / self.volume)
    }
}

/// A virial that has not heard of one item.
pub(crate) fn without(mut virial: Virial, item: Item) -> Virial {
    let heard = virial.item(item);
    let columns = [heard.x_axis, heard.y_axis, heard.z_axis];
    for (column, axis) in columns.into_iter().zip(DVec3::AXES) {
        virial.hear(item, DVec3::ZERO, column, -axis, &|| 0.0);
    }
    virial
}

/// What shear along x with the gradient along y shows of a stress: sigma_xy, sigma_xx - sigma_yy, sigma_yy - sigma_zz.
pub(crate) fn viscometric(sigma: DMat3) -> [f64; 3] {
    [
        0.5 * (sigma.y_axis.x + sigma.x_axis.y),
        sigma.x_axis.x - sigma.y_axis.y,
        sigma.y_axis.y - sigma.z_axis.z,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BlockAverage;
    use crate::scene::{Cell, Hooke, Random, at, system};
    use approx::assert_relative_eq;
    use zimm_core::{Bonded, Energy, Estimator, ForceField, Particles};

    #[test]
    fn law_signs_and_items_of_the_budget() {
        let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])
            .unwrap()
            .with_velocities(vec![DVec3::new(1.0, 2.0, 0.0), DVec3::ZERO])
            .unwrap()
            .with_masses(vec![3.0, 1.0])
            .unwrap();
        let system = system(Cell::cube(2.0), particles);
        let mut virial = Virial::default();
        for (k, item) in Item::ALL.into_iter().enumerate() {
            virial.hear(
                item,
                DVec3::ZERO,
                DVec3::new(1.0, 3.0, 0.0),
                DVec3::new(0.0, k as f64, 2.0),
                &|| 0.0,
            );
        }
        let budget = Stress.measure(&system.frame(), &virial);
        assert_eq!(
            budget,
            Stress.measure(&system.frame(), &(virial, Energy(0.0)))
        );
        assert_relative_eq!(budget.volume(), 8.0);
        assert_relative_eq!(budget.kinetic().y_axis.x, -6.0 / 8.0);
        assert_relative_eq!(budget.kinetic().x_axis.x, -3.0 / 8.0);
        for (k, item) in Item::ALL.into_iter().enumerate() {
            assert_relative_eq!(budget.item(item).y_axis.y, -3.0 * k as f64 / 8.0);
        }
        let sum = Item::ALL
            .iter()
            .fold(budget.kinetic(), |sum, &item| sum + budget.item(item));
        assert!((sum - budget.total()).abs_diff_eq(DMat3::ZERO, 1e-15));
        let left = budget.without(Item::Random);
        assert_eq!(left.item(Item::Random), DMat3::ZERO);
        let difference = budget.total() - budget.item(Item::Random);
        assert!((left.total() - difference).abs_diff_eq(DMat3::ZERO, 1e-15));
        assert_relative_eq!(budget.pressure(), (15.0 + 3.0 * 15.0) / 24.0);
        assert_relative_eq!(budget.shear(), -(6.0 + 0.5 * 15.0) / 8.0);
        assert_relative_eq!(budget.normal_differences()[0], -(3.0 - 12.0 - 45.0) / 8.0);
        assert_relative_eq!(budget.normal_differences()[1], -(12.0 + 45.0) / 8.0);
    }

    #[test]
    fn law_a_stretched_spring_pulls() {
        let particles = Particles::new(vec![DVec3::ZERO, DVec3::X]).unwrap();
        let system = system(Cell::cube(4.0), particles);
        let mut virial = Virial::default();
        Bonded::new(Hooke(2.0), vec![[0, 1]])
            .accumulate(&system.frame(), &mut [DVec3::ZERO; 2], &mut virial)
            .unwrap();
        let budget = Stress.measure(&system.frame(), &virial);
        assert_relative_eq!(budget.item(Item::Spring).x_axis.x, 2.0 / 64.0);
        assert_relative_eq!(budget.kramers(1, 1.0).x_axis.x, 1.0 / 64.0);
    }

    #[test]
    fn law_an_overdamped_ideal_gas_has_its_pressure() {
        let still = at(Cell::cube(2.0), vec![DVec3::ZERO; 3]);
        let budget = Stress.measure(&still.frame(), &Virial::default());
        assert_eq!(budget.kinetic(), DMat3::IDENTITY * (-3.0 / 8.0));
        assert_relative_eq!(budget.pressure(), 3.0 / 8.0);
    }

    // An ideal gas of n Hookean dumbbells: springs take one particle's worth of pressure, P = n kT / V, and their
    // Kramers stress vanishes. Seed 5, 100 frames of 200 dumbbells sampled exactly. Per frame the pressure scatters by
    // (1/3V) sqrt(6 n (2 + 1)) = 20 / V (velocities and springs, 3 degrees each, twofold); mean of 100: 1 % of P.
    // Bound 4 sigma = 4 %; a lost spring or kinetic item changes P by 100 %, a lost degree of freedom in 3 by 33 %.
    #[test]
    fn limit_dumbbell_gas() {
        let (n, edge) = (200, 20.0);
        let mut random = Random::new(5);
        let (mut pressure, mut polymer) = (BlockAverage::new(), BlockAverage::new());
        for _ in 0..100 {
            let mut positions = Vec::new();
            for _ in 0..n {
                let r = random.within(DMat3::IDENTITY * edge);
                positions.extend([r, r + random.normal3() / 2.0_f64.sqrt()]);
            }
            let velocities = (0..2 * n).map(|_| random.normal3()).collect();
            let particles = Particles::new(positions)
                .unwrap()
                .with_velocities(velocities)
                .unwrap();
            let system = system(Cell::lees_edwards(DVec3::splat(edge), 7.0), particles);
            let mut virial = Virial::default();
            let bonds = (0..n as u32).map(|k| [2 * k, 2 * k + 1]).collect();
            Bonded::new(Hooke(2.0), bonds)
                .accumulate(&system.frame(), &mut vec![DVec3::ZERO; 2 * n], &mut virial)
                .unwrap();
            let budget = Stress.measure(&system.frame(), &virial);
            pressure.push(budget.pressure());
            polymer.push(trace(&budget.kramers(n, 1.0)) / 3.0);
        }
        let ideal = n as f64 / edge.powi(3);
        let (pressure, polymer) = (pressure.estimate().unwrap(), polymer.estimate().unwrap());
        assert!(
            (pressure.value / ideal - 1.0).abs() < 0.04,
            "{pressure} against {ideal}"
        );
        assert!((polymer.value / ideal).abs() < 0.04, "{polymer} against 0");
    }
}
