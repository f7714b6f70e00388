//! The Ewald-summed mobility on a mesh.

mod grid;
mod noise;
mod points;
mod spectrum;
mod wave;
mod window;

use crate::lattice_sum::{Near, Plan, sharpness_of};
use crate::{Mobility, White, columns::add_scaled, rpy::finite, stage::zero};
use grid::Grid;
pub use noise::SplitNoise;
use wave::Waves;
use window::{WIDEST, Window};
use zimm_core::{DVec3, Frame, MobilityError, ParameterError, Periodic};

/// Beads and all their images in a cell of any shape: the mobility of Rotne, Prager and Yamakawa summed over the lattice
/// in O(N log N).
///
/// ```text
/// M_ij = 1 / zeta sum_n m(r_i - r_j + H n) = 1 / zeta (pairs within a range + waves on a mesh)
/// ```
///
/// with m that of [`Rpy`](crate::Rpy) in units of the mobility of one bead, and no mean flow: forces that do not sum to
/// zero are balanced by a pressure gradient. The cell may be any that flows; the mesh is laid along its reduced basis.
///
/// # The sum
/// The kernel is split into two parts, both positive: a smooth one that has no wave shorter than a limit, and the rest,
/// which ends at a range (as in Fiore, Balboa Usabiaga, Donev and Swan, J. Chem. Phys. 146, 124116, 2017, with a sharper
/// split). Pairs within the range, of all images, are kept as a sparse matrix. Waves are summed by spreading forces onto
/// a mesh with a window of Kaiser and Bessel, Fourier transforms (particle-mesh sums go back to Hockney and Eastwood
/// 1981; windows of this kind, to Lindbo and Tornberg, J. Comput. Phys. 229, 8994, 2010) and gathering.
///
/// # The error
/// Everything follows from the relative error that is asked for: |error of M F| <= tolerance |M F|, for forces that are
/// not made to cancel. (Where beads are so dense that none moves as fast as it would alone, the error is relative to
/// |F| / zeta.) Tests hold it to that against numbers with 15 digits in cubic, sheared, stretched and mixed cells, dilute
/// and dense; about a third of it is usual. Mesh, range and split are functions of the lattice, the number of
/// beads and the tolerance, and of nothing else, and sums are cut by the problem: results have the same bits on any
/// number of threads and after any history. (Transforms are those of rustfft, which takes the widest vectors that the
/// processor has, so processors of another kind may differ in the last digits.)
///
/// # Cost
/// At a tolerance of 1e-3, a product takes about 0.4 microseconds a bead, and a semi-implicit step with noise three,
/// whatever the number of beads; memory is about 2 kilobytes a bead.
///
/// ```
/// use zimm_boundary::PeriodicBox;
/// use zimm_brownian::{Mesh, Mobility};
/// use zimm_core::{Clock, DVec3, Particles, System};
///
/// // A cubic lattice of spheres is slower than one sphere by 2.837297 a / L - 4 pi/3 (a / L)^3 (Hasimoto 1959).
/// let particles = Particles::new(vec![DVec3::ZERO])?;
/// let system = System::new(PeriodicBox::cubic(10.0)?, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut mobility = Mesh::new(1.0, 1.0, 1e-9)?;
/// mobility.bind(&system.frame())?;
/// let mut velocities = [DVec3::ZERO];
/// Mobility::<PeriodicBox>::apply(&mut mobility, &[DVec3::X], &mut velocities);
/// assert!((velocities[0].x - 0.720459042).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Open space has no lattice, so this does not compile ([`Rpy`](crate::Rpy) serves there):
///
/// ```compile_fail,E0277
/// use zimm_brownian::{Mesh, Mobility};
/// use zimm_core::{Clock, DVec3, Open, Particles, System};
///
/// let system = System::new(Open, Particles::new(vec![DVec3::ZERO])?, Clock::new(0.01, 1.0, 1)?);
/// Mesh::new(1.0, 1.0, 1e-3)?.bind(&system.frame())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Mesh {
    mobility: f64,
    radius: f64,
    tolerance: f64,
    window: Window,
    grid: Grid,
    near: Near,
    waves: Waves,
    sums: Vec<DVec3>,
}

impl Mesh {
    /// Beads of a friction and a radius; velocities have a relative error of at most `tolerance`. A bead may be as
    /// large as three times the narrowest width of the cell.
    ///
    /// # Errors
    /// If `friction` or `radius` is not finite and above zero, or `tolerance` is not from 1e-11 to 0.1.
    pub fn new(friction: f64, radius: f64, tolerance: f64) -> Result<Self, ParameterError> {
        if !(1e-11..=0.1).contains(&tolerance) {
            let allowed = "from 1e-11 to 0.1";
            return Err(ParameterError::new("tolerance", tolerance, allowed));
        }
        let points = (0.5 * sharpness_of(tolerance) - 0.5).ceil();
        let points = points.clamp(4.0, WIDEST as f64);
        Ok(Self {
            mobility: ParameterError::positive("friction", friction)?.recip(),
            radius: ParameterError::positive("radius", radius)?,
            tolerance,
            window: Window::new(points as usize, 1e-2 * tolerance),
            grid: Grid::default(),
            near: Near::new(true),
            waves: Waves::default(),
            sums: Vec::new(),
        })
    }

    /// Number of mesh points along each basis vector, as bound last.
    pub fn points(&self) -> [usize; 3] {
        self.grid.points
    }

    /// Number of pairs that are summed one by one, as bound last.
    pub fn pairs(&self) -> usize {
        self.near.pairs()
    }

    /// Adds noise of the covariance of the wave part of beads of a mobility of one.
    fn draw(&mut self, white: &White<'_>, scale: f64, displacements: &mut [DVec3]) {
        if self.points() == [0; 3] {
            return;
        }
        self.waves.draw(&mut self.grid, self.near.kernel(), white);
        self.grid.gather(&self.window, scale, displacements);
    }
}

impl<B: Periodic> Mobility<B> for Mesh {
    fn bind(&mut self, frame: &Frame<'_, B>) -> Result<(), MobilityError> {
        finite("position", frame.positions)?;
        /// At which pairs and waves cost about the same in a step with noise. Longer ranges suit beads that do not overlap,
        /// whose noise takes few products with pairs; where beads overlap, it takes many.
        const BALANCE: f64 = 0.47;
        /// What of the error is left to the split; the mesh has one, too.
        const SHARE: f64 = 1.0 / 1.5;
        let lattice = frame.boundary.lattice();
        let error = SHARE * self.tolerance;
        let plan = Plan::new(lattice, frame.len(), self.radius, error, BALANCE, true)?;
        let points = points::of(lattice, &plan, &self.window)?;
        self.near.bind(plan, lattice, frame.positions);
        self.waves
            .bind(points, lattice, &self.window, self.near.kernel());
        self.grid
            .bind(points, lattice, &self.window, frame.positions);
        Ok(())
    }

    fn apply(&mut self, forces: &[DVec3], velocities: &mut [DVec3]) {
        if self.points() == [0; 3] {
            return;
        }
        zero(&mut self.sums, forces.len());
        self.grid.spread(&self.window, forces);
        self.waves.convolve(&mut self.grid, self.near.kernel());
        self.grid.gather(&self.window, 1.0, &mut self.sums);
        self.near.apply(forces, &mut self.sums);
        add_scaled(velocities, self.mobility, &self.sums);
    }

    fn accuracy(&self) -> f64 {
        self.mobility * self.tolerance
    }

    fn alone(&self, _: usize) -> f64 {
        self.mobility
    }
}
