//! Which particles a block of work adds forces to.

/// Windows begin and end at multiples of this many particles.
pub(super) const CHUNK: usize = 64;

/// Chunks of particles that are among some pairs.
#[derive(Clone, Debug, Default)]
pub(super) struct Touched {
    chunks: Vec<bool>,
    particles: usize,
}

impl Touched {
    /// Forgets all, for so many particles.
    pub(super) fn clear(&mut self, particles: usize) {
        self.particles = particles;
        self.chunks.clear();
        self.chunks.resize(particles.div_ceil(CHUNK), false);
    }

    #[inline(always)]
    pub(super) fn add(&mut self, particle: u32) {
        self.chunks[particle as usize / CHUNK] = true;
    }
}

/// A run of particles in the source's order, which may go on at its beginning from its end.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Window {
    start: u32,
    /// From the start to the end of the order.
    before_end: u32,
    len: u32,
}

impl Window {
    /// All of so many particles.
    pub(super) fn all(particles: usize) -> Self {
        Self {
            start: 0,
            before_end: particles as u32,
            len: particles as u32,
        }
    }

    /// All that is touched: what the longest gap leaves.
    pub(super) fn around(touched: &Touched) -> Self {
        let Touched { chunks, particles } = touched;
        let Some(first) = chunks.iter().position(|&t| t) else {
            return Self::default();
        };
        // From gap to gap, once around.
        let (mut start, mut longest, mut last) = (first, 0, first);
        for c in first + 1..=first + chunks.len() {
            if chunks[c % chunks.len()] {
                if c - last - 1 > longest {
                    (start, longest) = (c % chunks.len(), c - last - 1);
                }
                last = c;
            }
        }
        let particle = |chunk: usize| (chunk * CHUNK).min(*particles);
        let before_end = particles - particle(start);
        let end = start + chunks.len() - longest;
        let len = if end <= chunks.len() {
            particle(end) - particle(start)
        } else {
            before_end + particle(end - chunks.len())
        };
        Self {
            start: particle(start) as u32,
            before_end: before_end as u32,
            len: len as u32,
        }
    }

    pub(super) fn len(self) -> usize {
        self.len as usize
    }

    /// Where a particle stands in the window; beyond its length if it is not in it.
    #[inline(always)]
    pub(super) fn place(self, particle: u32) -> usize {
        let shift = if particle < self.start {
            self.before_end
        } else {
            self.start.wrapping_neg()
        };
        particle.wrapping_add(shift) as usize
    }
}

/// Which blocks have each chunk of particles in their windows.
#[derive(Clone, Debug, Default)]
pub(super) struct Sharers {
    starts: Vec<u32>,
    blocks: Vec<u32>,
}

impl Sharers {
    pub(super) fn find(&mut self, particles: usize, windows: impl Iterator<Item = Window> + Clone) {
        self.starts.clear();
        self.blocks.clear();
        for first in (0..particles).step_by(CHUNK) {
            self.starts.push(self.blocks.len() as u32);
            let sharing = (0..).zip(windows.clone());
            let sharing = sharing.filter(|(_, window)| window.place(first as u32) < window.len());
            self.blocks.extend(sharing.map(|(block, _)| block));
        }
        self.starts.push(self.blocks.len() as u32);
    }

    /// The blocks that share the chunk of a particle, in rising order.
    pub(super) fn of(&self, particle: usize) -> &[u32] {
        let chunk = particle / CHUNK;
        &self.blocks[self.starts[chunk] as usize..self.starts[chunk + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of every set of up to nine chunks, the last one whole or not, the window holds all, each particle in a place of
    /// its own, and nothing but the longest gap is left out.
    #[test]
    fn law_windows_are_what_the_longest_gap_leaves() {
        for chunks in 1..=9 {
            for particles in [CHUNK * chunks, CHUNK * chunks - 10] {
                for set in 0_u32..1 << chunks {
                    let touches = |c: usize| set >> (c % chunks) & 1 == 1;
                    let mut touched = Touched::default();
                    touched.clear(particles);
                    let members = (0..particles).filter(|k| touches(k / CHUNK));
                    members.clone().for_each(|k| touched.add(k as u32));
                    let window = Window::around(&touched);

                    let mut taken = vec![false; window.len()];
                    for k in 0..particles {
                        if let Some(taken) = taken.get_mut(window.place(k as u32)) {
                            assert!(!std::mem::replace(taken, true), "{k} of {set:b}");
                        } else {
                            assert!(!touches(k / CHUNK), "{k} of {set:b}");
                        }
                    }
                    assert!(taken.iter().all(|&taken| taken), "{set:b}");

                    let gap = |c: usize| (c..c + chunks).take_while(|&c| !touches(c)).count();
                    let longest = (0..chunks).map(gap).max().unwrap_or(0);
                    let kept = window.len().div_ceil(CHUNK);
                    assert_eq!(kept, chunks - longest, "{set:b}");
                }
            }
        }
    }

    /// A chunk is shared by those blocks whose windows it is in, one that nobody touches by none.
    #[test]
    fn law_sharers_have_the_chunk_in_their_windows() {
        let window = |chunks: &[u32]| {
            let mut touched = Touched::default();
            touched.clear(6 * CHUNK - 1);
            chunks.iter().for_each(|c| touched.add(c * CHUNK as u32));
            Window::around(&touched)
        };
        let windows = [
            window(&[0, 1]),
            window(&[]),
            window(&[1, 2]),
            window(&[5, 0]),
        ];
        let mut sharers = Sharers::default();
        sharers.find(6 * CHUNK - 1, windows.into_iter());
        let expected: [&[u32]; 6] = [&[0, 3], &[0, 2], &[2], &[], &[], &[3]];
        for (chunk, blocks) in expected.into_iter().enumerate() {
            assert_eq!(sharers.of(chunk * CHUNK + 7), blocks);
        }
    }
}
