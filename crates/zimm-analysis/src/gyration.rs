//! How far molecules spread around their centres.

use crate::AnalysisError;
use crate::chain::map_chains;
use crate::tensor::{outer, trace};
use zimm_core::{Boundary, DMat3, DVec3, Frame, Molecules, Observable};

/// The gyration tensor of each molecule, (1/N) sum (r - r_cm)(r - r_cm), in length squared; r_cm is the mean position
/// of its N beads. Its trace is the squared radius of gyration (Theodorou and Suter, Macromolecules 18, 1206, 1985).
///
/// ```
/// use zimm_analysis::GyrationTensor;
/// use zimm_core::{Clock, DVec3, Molecules, Observable, Open, Particles, System};
///
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X, DVec3::splat(9.0), DVec3::splat(9.0)])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut gyration = GyrationTensor { molecules: Molecules::linear(0, 2, 2)? };
/// let tensors = gyration.measure(&system.frame(), &())?;
/// assert_eq!((tensors[0].x_axis.x, tensors[1].x_axis.x), (0.25, 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct GyrationTensor {
    /// The molecules.
    pub molecules: Molecules,
}

impl<B: Boundary, T> Observable<B, T> for GyrationTensor {
    type Output = Result<Vec<DMat3>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        map_chains(frame, &self.molecules, |_, beads| tensor(beads))
    }
}

/// The squared radius of gyration of each molecule, (1/N) sum |r - r_cm|^2.
#[derive(Clone, Copy, Debug)]
pub struct SquaredRadius {
    /// The molecules.
    pub molecules: Molecules,
}

impl<B: Boundary, T> Observable<B, T> for SquaredRadius {
    type Output = Result<Vec<f64>, AnalysisError>;

    fn measure(&mut self, frame: &Frame<'_, B>, _: &T) -> Self::Output {
        map_chains(frame, &self.molecules, |_, beads| trace(&tensor(beads)))
    }
}

fn tensor(beads: &[DVec3]) -> DMat3 {
    let per_bead = 1.0 / beads.len() as f64;
    let centre = per_bead * beads.iter().sum::<DVec3>();
    let sum = beads
        .iter()
        .fold(DMat3::ZERO, |sum, &r| sum + outer(r - centre, r - centre));
    sum * per_bead
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cell, Random, at, step, system};
    use approx::assert_relative_eq;
    use proptest::prelude::*;
    use zimm_core::Particles;

    fn measured<B: Boundary>(system: &zimm_core::System<B>, beads: u32) -> DMat3 {
        let molecules = Molecules::linear(0, 1, beads).unwrap();
        GyrationTensor { molecules }
            .measure(&system.frame(), &())
            .unwrap()[0]
    }

    /// Steps of a chain, none longer than 0.8.
    fn walk(beads: usize, seed: u64) -> Vec<DVec3> {
        let mut random = Random::new(seed);
        let mut r = random.normal3();
        (0..beads)
            .map(|_| {
                r += random.normal3().clamp_length_max(0.8);
                r
            })
            .collect()
    }

    // A rod of N beads b apart: R_g^2 = b^2 (N^2 - 1) / 12, all of it along the rod; here 12 times longer than the
    // cell.
    #[test]
    fn limit_a_rod_across_many_images() {
        let (n, b, along) = (60_u32, 0.7, DVec3::new(1.0, 2.0, -2.0) / 3.0);
        let system = at(
            Cell::lees_edwards(DVec3::new(4.0, 3.5, 5.0), 1.6),
            (0..n).map(|k| along * b * k as f64).collect(),
        );
        let square = b * b * (f64::from(n * n) - 1.0) / 12.0;
        let found = measured(&system, n);
        assert!((found - outer(along, along) * square).abs_diff_eq(DMat3::ZERO, 1e-10));
        let squares = SquaredRadius {
            molecules: Molecules::linear(0, 1, n).unwrap(),
        }
        .measure(&system.frame(), &())
        .unwrap();
        assert_relative_eq!(squares[0], square, max_relative = 1e-12);
    }

    // A ring of radius R in the x-y plane: R^2 / 2 along x and y. It is wider than the cell.
    #[test]
    fn limit_a_ring_across_the_boundary() {
        let (n, radius) = (60_u32, 3.0);
        let angle = |k| std::f64::consts::TAU * f64::from(k) / f64::from(n);
        let bead = |k| DVec3::new(radius * angle(k).cos(), radius * angle(k).sin(), 0.3);
        let system = at(
            Cell::lees_edwards(DVec3::splat(4.0), -1.3),
            (0..n).map(bead).collect(),
        );
        let flat = DMat3::from_diagonal(DVec3::new(0.5, 0.5, 0.0)) * radius * radius;
        assert!((measured(&system, n) - flat).abs_diff_eq(DMat3::ZERO, 1e-12));
    }

    // Ideal chains of N = 10 Gaussian bonds' beads: <R_g^2> = <Q^2> (N^2 - 1) / (6 N) = 1.65 <Q^2>. Seed 31, 20 000
    // chains in one cell; R_g^2 of such chains scatters by 0.55 of its mean, so the error is 0.39 %; bound 4 sigma =
    // 1.6 % (N in place of N^2 - 1 over N is off by 1 %, N - 1 bonds for N beads by 10 %).
    #[test]
    fn limit_ideal_chains() {
        let (chains, n, bond) = (20_000_u32, 10_u32, 0.3);
        let mut random = Random::new(31);
        let mut positions = Vec::new();
        for _ in 0..chains {
            let mut r = random.within(DMat3::IDENTITY * 6.0);
            for _ in 0..n {
                positions.push(r);
                r += bond * random.normal3();
            }
        }
        let system = at(Cell::lees_edwards(DVec3::splat(6.0), 2.0), positions);
        let molecules = Molecules::linear(0, chains, n).unwrap();
        let squares = SquaredRadius { molecules }
            .measure(&system.frame(), &())
            .unwrap();
        let mean = squares.iter().sum::<f64>() / f64::from(chains);
        assert_relative_eq!(mean, 3.0 * bond * bond * 99.0 / 60.0, max_relative = 0.016);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        // The same molecule moved anywhere, in whatever images and order of particles.
        #[test]
        fn law_translations_images_and_order_do_not_show(
            seed in 0_u64..1000, x in -50.0..50.0, y in -50.0..50.0, offset in -3.0..3.0,
        ) {
            let beads = walk(20, seed);
            let still = at(zimm_core::Open, beads.clone());
            let cell = Cell::lees_edwards(DVec3::splat(3.0), offset);
            let moved = beads.iter().map(|r| r + DVec3::new(x, y, x - y)).collect();
            let mut order: Vec<u32> = (0..20).collect();
            order.sort_by_key(|k| (7 * k + seed as u32) % 20);
            let mut particles = Particles::new(moved).unwrap();
            particles.permute(&order).unwrap();
            let found = measured(&system(cell, particles), 20);
            prop_assert!((found - measured(&still, 20)).abs_diff_eq(DMat3::ZERO, 1e-9));
            // R_g^2 is half the mean square distance of all pairs of beads (Lagrange).
            let square = |r: &DVec3| beads.iter().map(|s| (*r - *s).length_squared()).sum::<f64>();
            let pairs = beads.iter().map(square).sum::<f64>() / 800.0;
            let molecules = Molecules::linear(0, 1, 20).unwrap();
            let squares = SquaredRadius { molecules }.measure(&still.frame(), &()).unwrap();
            prop_assert!((squares[0] - pairs).abs() < 1e-9);
        }
    }

    // Beads carried by a shear F become G -> F G F^T, also where the basis changes (here 5 times).
    #[test]
    fn law_remaps_do_not_show() {
        let mut system = at(Cell::new(DMat3::IDENTITY * 8.0, 0.25), walk(20, 4));
        let before = measured(&system, 20);
        for _ in 0..20 {
            step(&mut system, || DVec3::ZERO);
            let carry = system.boundary.carry(0.0, system.clock.now().time);
            if carry.y_axis.x < 3.0 {
                let carried = carry * before * carry.transpose();
                assert!((measured(&system, 20) - carried).abs_diff_eq(DMat3::ZERO, 1e-9));
            }
        }
    }

    #[test]
    fn extreme_bad_molecules_are_errors() {
        let system = at(Cell::cube(2.0), vec![DVec3::ZERO, DVec3::splat(0.99)]);
        let measure = |first, count, beads| {
            let molecules = Molecules::linear(first, count, beads).unwrap();
            GyrationTensor { molecules }.measure(&system.frame(), &())
        };
        assert_eq!(
            measure(0, 3, 1),
            Err(AnalysisError::NoSuchParticle {
                molecule: 2,
                identity: 2,
                particles: 2
            })
        );
        let found = measure(0, 1, 2);
        assert!(
            matches!(found, Err(AnalysisError::BeyondCell { i: 0, j: 1, .. })),
            "{found:?}"
        );
        assert_eq!(measure(1, 1, 1).unwrap(), [DMat3::ZERO]);
        assert_eq!(measure(0, 0, 5).unwrap(), []);
    }
}
