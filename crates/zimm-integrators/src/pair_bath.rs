//! Baths that act on pairs, one pair after another: the part that all their schemes share.

use crate::stage::{Stage, Streaming};
use zimm_core::noise::Domain;
use zimm_core::{
    Boundary, DVec3, ForceError, ForceField, Frame, Item, Neighbours, Now, Pair, ParameterError,
    StepError, System, Tally, each_block, for_each_chunk,
};

/// What a bath does to the velocity `u` at which a pair parts along its line of centres: `u' = (1 - loss) u + kick`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exchange {
    pub(crate) loss: f64,
    pub(crate) kick: f64,
}

/// A bath that acts on every pair by itself: one formula.
pub(crate) trait PairBath: Sync {
    /// Where the stress of loss and kick is tallied.
    const ITEMS: [Item; 2];

    /// Range of the bath.
    fn cutoff(&self) -> f64;

    /// The probability that a pair within the range takes part in a step.
    ///
    /// # Errors
    /// If the time step does not go with the bath.
    fn share(&self, now: &Now) -> Result<f64, ParameterError>;

    /// What happens to a pair of this reduced mass that takes part; `pair.rv` is not set.
    fn exchange(&self, pair: &Pair, mass: f64, now: &Now) -> Exchange;
}

/// One sweep of a bath over the pairs of a source.
///
/// Pairs take turns in an order that noise draws anew in every step, and separations are those of the frame. So the
/// order has no direction in space, and nothing of the source shows in the result: not its order, not its age.
#[derive(Clone, Debug)]
pub(crate) struct Sweep<N> {
    neighbours: N,
    blocks: Vec<Vec<Turn>>,
    turns: Vec<Turn>,
    meetings: Vec<Meeting>,
}

/// Places of two particles that may be in range, and when their turn comes.
#[derive(Clone, Copy, Debug, Default)]
struct Turn {
    when: u64,
    i: u32,
    j: u32,
}

/// All that does not depend on the velocities at a pair's turn.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    i: u32,
    j: u32,
    /// Unit vector from j to i.
    along: DVec3,
    distance: f64,
    /// What the flow adds to the parting velocity.
    stream: f64,
    /// Reduced mass.
    mass: f64,
    exchange: Exchange,
}

impl<N> Sweep<N> {
    pub(crate) fn new(neighbours: N) -> Self {
        Self {
            neighbours,
            blocks: Vec::new(),
            turns: Vec::new(),
            meetings: Vec::new(),
        }
    }

    /// Lets the bath act on the stage's velocities, with the positions of the stage, in this boundary at this moment.
    pub(crate) fn act<B: Boundary, T: Tally>(
        &mut self,
        bath: &impl PairBath,
        stage: &mut Stage,
        system: &System<B>,
        (boundary, now): (&B, Now),
        tally: &mut T,
    ) -> Result<(), StepError>
    where
        N: Neighbours<B>,
    {
        let step = now.step;
        let share = bath
            .share(&now)
            .map_err(|source| StepError::Parameter { step, source })?;
        let mut frame = system.frame();
        frame.now = now;
        frame.boundary = boundary;
        frame.positions = &stage.positions;
        self.draw(&frame, bath.cutoff(), share)
            .map_err(|source| StepError::Force { step, source })?;
        self.meet(&frame, bath);
        self.collide(bath, &frame, &mut stage.velocities, tally);
        stage.check_velocities(system)
    }

    /// Collects the pairs that take part, in the order of their turns.
    fn draw<B: Boundary>(
        &mut self,
        frame: &Frame<'_, B>,
        cutoff: f64,
        share: f64,
    ) -> Result<(), ForceError>
    where
        N: Neighbours<B>,
    {
        const RUN: usize = 64;
        const UNIT: f64 = (1_u64 << 53) as f64;
        /// A source may keep other images of positions, whose rounding is another one.
        const MARGIN: f64 = 1.0 + 1e-9;
        self.neighbours.refresh(frame, cutoff)?;
        let (order, positions) = (self.neighbours.order(), self.neighbours.positions());
        let noise = frame.now.noise();
        let sites: Vec<_> = order
            .iter()
            .map(|&place| noise.site(frame.id(place as usize)))
            .collect();
        let (limit, last) = (MARGIN * cutoff * cutoff, (share * UNIT) as u64);
        let neighbours = &self.neighbours;
        self.blocks.resize_with(neighbours.blocks(), Vec::new);
        each_block(&mut self.blocks, |block, turns| {
            let mut used = 0;
            neighbours.visit(block, |row| {
                let i = row.i as usize;
                let here = positions[i] + row.shift;
                for js in row.js.chunks(RUN) {
                    // Every candidate is written; only those that take part are kept.
                    let (mut near, mut found) = ([0; RUN], 0);
                    for &j in js {
                        near[found] = j;
                        let r2 = (here - positions[j as usize]).length_squared();
                        found += (r2 < limit) as usize;
                    }
                    if turns.len() < used + RUN {
                        turns.resize(2 * turns.len() + RUN, Turn::default());
                    }
                    for &j in &near[..found] {
                        let j = j as usize;
                        let when = (sites[i] + sites[j]).word(Domain::PAIR_TURN);
                        let (i, j) = (order[i], order[j]);
                        turns[used] = Turn { when, i, j };
                        used += (when >> 11 < last) as usize;
                    }
                }
            });
            turns.truncate(used);
        });
        let turns = &mut self.turns;
        turns.clear();
        turns.extend(self.blocks.iter().flatten());
        turns.sort_unstable_by_key(|turn| turn.when);
        Ok(())
    }

    /// Works out what will happen to each pair.
    fn meet<B: Boundary>(&mut self, frame: &Frame<'_, B>, bath: &impl PairBath) {
        let (turns, noise) = (&self.turns, frame.now.noise());
        let (gradient, reach) = (frame.boundary.gradient(), bath.cutoff().powi(2));
        self.meetings.clear();
        self.meetings.resize(turns.len(), Meeting::NONE);
        for_each_chunk(&mut self.meetings, |start, chunk| {
            for (meeting, turn) in chunk.iter_mut().zip(&turns[start..]) {
                let [i, j] = [turn.i, turn.j].map(|place| place as usize);
                let apart = frame.positions[i] - frame.positions[j];
                let r = frame.boundary.min_image(apart);
                let r2 = r.length_squared();
                // Particles on top of each other have no line of centres.
                if !(r2 >= f64::MIN_POSITIVE && r2 < reach) {
                    continue;
                }
                let [m, n] = [frame.mass(i), frame.mass(j)];
                let (mass, distance) = (m * n / (m + n), r2.sqrt());
                let pair = Pair {
                    r2,
                    rv: 0.0,
                    noise: noise.site(frame.id(i)) + noise.site(frame.id(j)),
                    species: [frame.species(i), frame.species(j)],
                };
                let along = r / distance;
                *meeting = Meeting {
                    i: turn.i,
                    j: turn.j,
                    along,
                    distance,
                    stream: if B::FLOWS {
                        along.dot(gradient * r)
                    } else {
                        0.0
                    },
                    mass,
                    exchange: bath.exchange(&pair, mass, &frame.now),
                };
            }
        });
    }

    /// The sweep itself: each pair sees what those before it have done.
    fn collide<B: Boundary, K: PairBath, T: Tally>(
        &self,
        _: &K,
        frame: &Frame<'_, B>,
        velocities: &mut [DVec3],
        tally: &mut T,
    ) {
        let rate = frame.now.dt.recip();
        for meeting in &self.meetings {
            let Meeting { along, mass, .. } = *meeting;
            let Exchange { loss, kick } = meeting.exchange;
            let [i, j] = [meeting.i, meeting.j].map(|place| place as usize);
            let parting = along.dot(velocities[i] - velocities[j]) + meeting.stream;
            let impulses = [-mass * loss * parting, mass * kick];
            let impulse = impulses[0] + impulses[1];
            velocities[i] += (impulse / frame.mass(i)) * along;
            velocities[j] -= (impulse / frame.mass(j)) * along;
            if T::LISTENS {
                let (at, r) = (frame.positions[i], meeting.distance * along);
                for (item, impulse) in K::ITEMS.into_iter().zip(impulses) {
                    tally.hear(item, at, r, rate * impulse * along, &|| 0.0);
                }
            }
        }
    }
}

impl Meeting {
    /// A pair that turns out to be none.
    const NONE: Self = Self {
        i: 0,
        j: 0,
        along: DVec3::ZERO,
        distance: 0.0,
        stream: 0.0,
        mass: 1.0,
        exchange: Exchange {
            loss: 0.0,
            kick: 0.0,
        },
    };
}

/// Refuses, when a scene is compiled, force fields with friction or noise of their own.
pub(crate) const fn conservative<B: Boundary, F: ForceField<B>>() {
    const {
        assert!(
            !F::READS.velocity && !F::READS.noise,
            "friction and noise belong to the stepper here: the field must be conservative"
        );
    }
}

/// One step of velocity Verlet in the flow, with a sweep of the bath over the new state.
pub(crate) fn verlet_and_sweep<B, F, N, T>(
    bath: &impl PairBath,
    sweep: &mut Sweep<N>,
    stage: &mut Stage,
    (system, field, tally): (&mut System<B>, &mut F, &mut T),
) -> Result<(), StepError>
where
    B: Boundary,
    F: ForceField<B>,
    N: Neighbours<B>,
    T: Tally,
{
    conservative::<B, F>();
    let (now, next) = (system.clock.now(), system.clock.next());
    let half = 0.5 * now.dt;

    let streaming = Streaming::new(&system.boundary, now.time, next.time, now.dt);
    let ahead = system.ahead();
    stage.depart(system, field, false, |flight| {
        flight.kick(half)?;
        flight.stream::<B>(&streaming);
        flight.settle(&ahead)
    })?;

    let mut heard = tally.fresh();
    stage.evaluate(system, &ahead.boundary, field, &mut heard)?;
    stage.kick(system, half)?;
    sweep.act(bath, stage, system, (&ahead.boundary, next), &mut heard)?;
    stage.rest::<B, F>(system);
    stage.commit(system, ahead.boundary);
    tally.absorb(heard);
    Ok(())
}
