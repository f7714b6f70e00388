//! The driver of non-bonded laws: pairs in batches, several at a time in SIMD lanes, the same bits on any processor
//! and any number of threads.

mod windows;

use crate::{
    Boundary, ForceError, ForceField, Frame, Item, Neighbours, Now, Pair, PairForce, Reads, Row,
    Tally,
    noise::Site,
    parallel::{each_block, each_block_of_two, for_each_chunk, for_each_chunk_of},
};
use glam::{DMat3, DVec3};
use windows::{CHUNK, Sharers, Touched, Window};

/// Non-bonded forces: a law and a source of pairs.
///
/// ```
/// # use zimm_core::{AllPairs, Central, Clock, DVec3, ForceField, Now, Open, Pair, PairForce, Pairwise, Particles, System};
/// # struct Repulsion;
/// # impl PairForce for Repulsion {
/// #     fn cutoff(&self) -> f64 { 2.0 }
/// #     fn force(&self, pair: &Pair, _: &Now) -> Central { Central::conservative(2.0 - pair.r2.sqrt()) }
/// # }
/// let particles = Particles::new(vec![DVec3::ZERO, DVec3::X])?;
/// let system = System::new(Open, particles, Clock::new(0.01, 1.0, 1)?);
/// let mut field = Pairwise::new(Repulsion, AllPairs::default());
/// let mut forces = vec![DVec3::ZERO; 2];
/// field.accumulate(&system.frame(), &mut forces, &mut ())?;
/// assert_eq!(forces, [-DVec3::X, DVec3::X]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Work goes on in batches of pairs within the cutoff: find and compress, fetch velocities and noise, evaluate the
/// law in a loop without branches that the compiler turns into the widest lanes of the processor at hand, add the
/// forces. No operation is reordered or fused by this, so the lanes' width does not show in the result.
#[derive(Clone, Debug)]
pub struct Pairwise<L, N> {
    law: L,
    neighbours: N,
    velocities: Vec<DVec3>,
    sites: Vec<Site>,
    species: Vec<u8>,
    places: Vec<u32>,
    blocks: Vec<Scratch>,
    sharers: Sharers,
    joined: Vec<DVec3>,
    arch: pulp::Arch,
}

impl<L, N> Pairwise<L, N> {
    /// A law between the pairs of a source.
    pub fn new(law: L, neighbours: N) -> Self {
        Self {
            law,
            neighbours,
            velocities: Vec::new(),
            sites: Vec::new(),
            species: Vec::new(),
            places: Vec::new(),
            blocks: Vec::new(),
            sharers: Sharers::default(),
            joined: Vec::new(),
            arch: pulp::Arch::new(),
        }
    }

    /// The law.
    pub fn law(&self) -> &L {
        &self.law
    }

    /// The source of pairs.
    pub fn neighbours(&self) -> &N {
        &self.neighbours
    }
}

/// What one block of work needs: a batch of pairs, and forces on the particles in its window.
#[derive(Clone, Debug, Default)]
struct Scratch {
    batch: Box<Batch>,
    touched: Touched,
    window: Window,
    forces: Vec<DVec3>,
}

impl<L: PairForce, N> Pairwise<L, N> {
    /// Copies what the law reads into the source's order: velocities in the laboratory, noise, species.
    fn pack<B: Boundary>(&mut self, frame: &Frame<'_, B>)
    where
        N: Neighbours<B>,
    {
        let (order, positions) = (self.neighbours.order(), self.neighbours.positions());
        let (gradient, noise) = (frame.boundary.gradient(), frame.now.noise());
        let len = |is_read: bool| if is_read { order.len() } else { 0 };
        self.velocities.resize(len(L::READS.velocity), DVec3::ZERO);
        self.sites.resize(len(L::READS.noise), Site::default());
        self.species.resize(len(L::READS.species), 0);
        let columns = (&mut self.velocities[..], &mut self.sites[..]);
        let columns = (columns, &mut self.species[..]);
        for_each_chunk_of(columns, |start, ((velocities, sites), species)| {
            let known = || order[start..].iter().map(|&place| place as usize);
            for (velocity, place) in velocities.iter_mut().zip(known()) {
                *velocity = frame.velocities.get(place).copied().unwrap_or_default();
            }
            if B::FLOWS {
                for (velocity, &r) in velocities.iter_mut().zip(&positions[start..]) {
                    *velocity += gradient * r;
                }
            }
            for (site, place) in sites.iter_mut().zip(known()) {
                *site = noise.site(frame.id(place));
            }
            for (species, place) in species.iter_mut().zip(known()) {
                *species = frame.species(place);
            }
        });
    }

    /// Sums the forces of several blocks, in the source's order.
    fn join(&mut self) {
        let (blocks, sharers) = (&self.blocks, &self.sharers);
        self.joined.resize(self.places.len(), DVec3::ZERO);
        for_each_chunk(&mut self.joined, |start, chunk| {
            for (first, sums) in (start..).step_by(CHUNK).zip(chunk.chunks_mut(CHUNK)) {
                sums.fill(DVec3::ZERO);
                for &block in sharers.of(first) {
                    let Scratch { window, forces, .. } = &blocks[block as usize];
                    let forces = &forces[window.place(first as u32)..];
                    for (sum, &force) in sums.iter_mut().zip(forces) {
                        *sum += force;
                    }
                }
            }
        });
    }

    /// Adapts buffers to a new order.
    fn adapt<B: Boundary>(&mut self)
    where
        N: Neighbours<B>,
    {
        let order = self.neighbours.order();
        self.places.resize(order.len(), 0);
        for (k, &place) in order.iter().enumerate() {
            self.places[place as usize] = k as u32;
        }
        let (blocks, n) = (self.neighbours.blocks(), order.len());
        self.blocks.resize_with(blocks, Scratch::default);
        let neighbours = &self.neighbours;
        each_block(&mut self.blocks, |b, scratch| {
            scratch.window = if blocks == 1 {
                Window::all(n)
            } else {
                scratch.touched.clear(n);
                neighbours.visit(b, |row| {
                    scratch.touched.add(row.i);
                    row.js.iter().for_each(|&j| scratch.touched.add(j));
                });
                Window::around(&scratch.touched)
            };
            scratch.forces.resize(scratch.window.len(), DVec3::ZERO);
        });
        let windows = self.blocks.iter().map(|scratch| scratch.window);
        self.sharers.find(n, windows);
    }
}

impl<B, L, N> ForceField<B> for Pairwise<L, N>
where
    B: Boundary,
    L: PairForce,
    N: Neighbours<B>,
{
    const READS: Reads = L::READS;
    const CONSERVES_MOMENTUM: bool = true;

    fn accumulate<T: Tally>(
        &mut self,
        frame: &Frame<'_, B>,
        forces: &mut [DVec3],
        tally: &mut T,
    ) -> Result<(), ForceError> {
        if self.neighbours.refresh(frame, self.law.cutoff())? {
            self.adapt::<B>();
        }
        self.pack(frame);
        let view = View {
            law: &self.law,
            now: frame.now,
            cutoff_squared: self.law.cutoff() * self.law.cutoff(),
            gradient: frame.boundary.gradient(),
            positions: self.neighbours.positions(),
            velocities: &self.velocities,
            sites: &self.sites,
            species: &self.species,
        };
        let (neighbours, arch) = (&self.neighbours, self.arch);
        // A listener to nothing takes no room.
        let mut listeners: Vec<T> = self.blocks.iter().map(|_| tally.fresh()).collect();
        each_block_of_two(&mut self.blocks, &mut listeners, |block, scratch, heard| {
            scratch.forces.fill(DVec3::ZERO);
            arch.dispatch(BlockOfWork::<B, L, N, T> {
                view: &view,
                neighbours,
                block,
                batch: &mut scratch.batch,
                window: scratch.window,
                forces: &mut scratch.forces,
                heard,
                boundary: std::marker::PhantomData,
            });
        });
        for heard in listeners {
            tally.absorb(heard);
        }
        let joined = if let [all] = &self.blocks[..] {
            &all.forces
        } else {
            self.join();
            &self.joined
        };
        for_each_chunk(forces, |start, chunk| {
            // A source of nobody has no places.
            let places = self.places.get(start..).unwrap_or_default();
            for (force, &k) in chunk.iter_mut().zip(places) {
                *force += joined[k as usize];
            }
        });
        Ok(())
    }

    fn forget(&mut self) {
        self.neighbours.forget();
    }
}

/// What every block reads.
struct View<'a, L> {
    law: &'a L,
    now: Now,
    cutoff_squared: f64,
    gradient: DMat3,
    positions: &'a [DVec3],
    velocities: &'a [DVec3],
    sites: &'a [Site],
    species: &'a [u8],
}

/// Pairs within the cutoff, by columns.
#[derive(Clone, Debug)]
struct Batch {
    len: usize,
    i: [u32; BATCH],
    j: [u32; BATCH],
    x: [f64; BATCH],
    y: [f64; BATCH],
    z: [f64; BATCH],
    r2: [f64; BATCH],
    rv: [f64; BATCH],
    noise: [Site; BATCH],
    species: [[u8; 2]; BATCH],
    f: [f64; BATCH],
    /// The items of `f`, for tallies.
    conservative: [f64; BATCH],
    dissipative: [f64; BATCH],
    random: [f64; BATCH],
}

const BATCH: usize = 512;
/// Candidates are looked at in runs of this many; a batch with less room is worked off first.
const RUN: usize = 64;

impl Default for Batch {
    fn default() -> Self {
        Self {
            len: 0,
            i: [0; BATCH],
            j: [0; BATCH],
            x: [0.0; BATCH],
            y: [0.0; BATCH],
            z: [0.0; BATCH],
            r2: [0.0; BATCH],
            rv: [0.0; BATCH],
            noise: [Site::default(); BATCH],
            species: [[0; 2]; BATCH],
            f: [0.0; BATCH],
            conservative: [0.0; BATCH],
            dissipative: [0.0; BATCH],
            random: [0.0; BATCH],
        }
    }
}

/// One block of rows; `call` is compiled once for every instruction set and the best one runs.
struct BlockOfWork<'a, B, L, N, T> {
    view: &'a View<'a, L>,
    neighbours: &'a N,
    block: usize,
    batch: &'a mut Batch,
    window: Window,
    forces: &'a mut [DVec3],
    heard: &'a mut T,
    boundary: std::marker::PhantomData<B>,
}

impl<B: Boundary, L: PairForce, N: Neighbours<B>, T: Tally> pulp::NullaryFnOnce
    for BlockOfWork<'_, B, L, N, T>
{
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            view,
            neighbours,
            block,
            batch,
            window,
            forces,
            heard,
            ..
        } = self;
        batch.len = 0;
        neighbours.visit(
            block,
            #[inline(always)]
            |row| {
                for js in row.js.chunks(RUN) {
                    if batch.len + RUN > BATCH {
                        batch.work_off(view, window, forces, heard);
                    }
                    batch.take::<B, L>(view, &row, js);
                }
            },
        );
        batch.work_off(view, window, forces, heard);
    }
}

impl Batch {
    /// Adds the candidates that are within the cutoff. Every candidate is written; only those in range are kept.
    #[inline(always)]
    fn take<B: Boundary, L: PairForce>(&mut self, view: &View<'_, L>, row: &Row<'_>, js: &[u32]) {
        let i = row.i as usize;
        let here = view.positions[i] + row.shift;
        let first = self.len;
        let mut len = first;
        for &j in js {
            let r = here - view.positions[j as usize];
            let r2 = r.length_squared();
            self.i[len] = row.i;
            self.j[len] = j;
            (self.x[len], self.y[len], self.z[len]) = (r.x, r.y, r.z);
            self.r2[len] = r2;
            len += (r2 < view.cutoff_squared) as usize;
        }
        self.len = len;
        if L::READS.velocity {
            let mut v = view.velocities[i];
            if B::FLOWS {
                v += view.gradient * row.shift;
            }
            for k in first..len {
                let apart = v - view.velocities[self.j[k] as usize];
                self.rv[k] = self.x[k] * apart.x + self.y[k] * apart.y + self.z[k] * apart.z;
            }
        }
        if L::READS.noise {
            let site = view.sites[i];
            for k in first..len {
                self.noise[k] = site + view.sites[self.j[k] as usize];
            }
        }
        if L::READS.species {
            let species = view.species[i];
            for k in first..len {
                self.species[k] = [species, view.species[self.j[k] as usize]];
            }
        }
    }

    #[inline(always)]
    fn pair(&self, k: usize) -> Pair {
        Pair {
            r2: self.r2[k],
            rv: self.rv[k],
            noise: self.noise[k],
            species: self.species[k],
        }
    }

    /// Evaluates the law for the pairs collected, adds their forces and empties the batch.
    #[inline(always)]
    fn work_off<L: PairForce, T: Tally>(
        &mut self,
        view: &View<'_, L>,
        window: Window,
        forces: &mut [DVec3],
        heard: &mut T,
    ) {
        let len = self.len.min(BATCH);
        for k in 0..len {
            let force = view.law.force(&self.pair(k), &view.now);
            self.f[k] = force.total();
            if T::LISTENS {
                self.conservative[k] = force.conservative;
                self.dissipative[k] = force.dissipative;
                self.random[k] = force.random;
            }
        }
        for k in 0..len {
            let force = self.f[k] * DVec3::new(self.x[k], self.y[k], self.z[k]);
            forces[window.place(self.i[k])] += force;
            forces[window.place(self.j[k])] -= force;
        }
        if T::LISTENS {
            for k in 0..len {
                self.report(k, view, heard);
            }
        }
        self.len = 0;
    }

    #[inline(always)]
    fn report<L: PairForce, T: Tally>(&self, k: usize, view: &View<'_, L>, heard: &mut T) {
        let r = DVec3::new(self.x[k], self.y[k], self.z[k]);
        let at = view.positions[self.i[k] as usize];
        let energy = || view.law.energy(&self.pair(k));
        heard.hear(Item::Conservative, at, r, self.conservative[k] * r, &energy);
        if L::READS.velocity {
            heard.hear(Item::Dissipative, at, r, self.dissipative[k] * r, &|| 0.0);
        }
        if L::READS.noise {
            heard.hear(Item::Random, at, r, self.random[k] * r, &|| 0.0);
        }
    }
}
