//! Keeping the near ones of several particles at once, with the instructions that the processor has. All give the same.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::__m256i;

/// Candidates that are looked at together.
pub(super) const LANES: usize = 16;

/// Which instructions pack candidates. All give the same list.
#[derive(Clone, Copy, Debug)]
pub(super) enum Packing {
    #[cfg(target_arch = "x86_64")]
    Compress(pulp::x86::V4),
    #[cfg(target_arch = "x86_64")]
    Permute(pulp::x86::V3),
    OneByOne,
}

impl Packing {
    /// The best that this processor has.
    pub(super) fn new() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if let Some(v4) = pulp::x86::V4::try_new() {
                return Self::Compress(v4);
            }
            if let Some(v3) = pulp::x86::V3::try_new() {
                return Self::Permute(v3);
            }
        }
        Self::OneByOne
    }

    /// Does some work with it; compiled once for every instruction set.
    pub(super) fn run(self, work: impl Work) {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Compress(v4) => v4.vectorize(With(work, v4)),
            #[cfg(target_arch = "x86_64")]
            Self::Permute(v3) => v3.vectorize(With(work, v3)),
            Self::OneByOne => pulp::Arch::new().dispatch(With(work, OneByOne)),
        }
    }
}

/// Something that keeps the near ones of many.
pub(super) trait Work {
    fn run(self, pack: impl Pack);
}

struct With<W, P>(W, P);

impl<W: Work, P: Pack> pulp::NullaryFnOnce for With<W, P> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.0.run(self.1);
    }
}

/// Ways to keep the near ones.
pub(super) trait Pack: Copy {
    /// Writes the numbers of those of [`LANES`] candidates that are nearer than a squared limit, and how many there are;
    /// what is behind them in the room is of no use.
    fn near(
        self,
        here: [f32; 3],
        limit: f32,
        candidates: Lanes<'_>,
        room: &mut [u32; LANES],
    ) -> usize;
}

/// Coordinates and numbers of candidates.
pub(super) type Lanes<'a> = ([&'a [f32; LANES]; 3], &'a [u32; LANES]);

/// Works everywhere.
#[derive(Clone, Copy)]
pub(super) struct OneByOne;

impl Pack for OneByOne {
    #[inline(always)]
    fn near(
        self,
        here: [f32; 3],
        limit: f32,
        (columns, numbers): Lanes<'_>,
        room: &mut [u32; LANES],
    ) -> usize {
        let [x, y, z] = columns;
        let mut squares = [0.0; LANES];
        for (k, square) in squares.iter_mut().enumerate() {
            let (dx, dy, dz) = (here[0] - x[k], here[1] - y[k], here[2] - z[k]);
            *square = dx * dx + dy * dy + dz * dz;
        }
        let mut found = 0;
        for (&number, square) in numbers.iter().zip(squares) {
            room[found] = number;
            found += (square < limit) as usize;
        }
        found
    }
}

#[cfg(target_arch = "x86_64")]
impl Pack for pulp::x86::V4 {
    #[inline(always)]
    fn near(
        self,
        here: [f32; 3],
        limit: f32,
        (columns, numbers): Lanes<'_>,
        room: &mut [u32; LANES],
    ) -> usize {
        use pulp::{Simd, b16, cast};
        let square = |axis: usize| {
            let apart = self.sub_f32s(self.splat_f32s(here[axis]), cast(*columns[axis]));
            self.mul_f32s(apart, apart)
        };
        let squares = self.add_f32s(self.add_f32s(square(0), square(1)), square(2));
        let b16(near) = self.less_than_f32s(squares, self.splat_f32s(limit));
        *room = pulp::cast!(
            self.avx512f
                ._mm512_maskz_compress_epi32(near, pulp::cast!(*numbers))
        );
        near.count_ones() as usize
    }
}

/// For each set of eight lanes, the lanes that are in it.
#[cfg(target_arch = "x86_64")]
static MEMBERS: [[u32; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut set = 0;
    while set < 256 {
        let (mut found, mut lane) = (0, 0);
        while lane < 8 {
            if set >> lane & 1 == 1 {
                table[set][found] = lane;
                found += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    table
};

#[cfg(target_arch = "x86_64")]
impl Pack for pulp::x86::V3 {
    #[inline(always)]
    fn near(
        self,
        here: [f32; 3],
        limit: f32,
        (columns, numbers): Lanes<'_>,
        room: &mut [u32; LANES],
    ) -> usize {
        use pulp::{Simd, cast, f32x8};
        let all: [__m256i; 2] = pulp::cast!(*numbers);
        let mut found = 0;
        for half in 0..2 {
            let square = |axis: usize| {
                let both: [f32x8; 2] = cast(*columns[axis]);
                let apart = self.sub_f32s(self.splat_f32s(here[axis]), both[half]);
                self.mul_f32s(apart, apart)
            };
            let squares = self.add_f32s(self.add_f32s(square(0), square(1)), square(2));
            let near = self.less_than_f32s(squares, self.splat_f32s(limit));
            let near = self.avx._mm256_movemask_ps(pulp::cast!(near)) as usize;
            let members = self
                .avx2
                ._mm256_permutevar8x32_epi32(all[half], pulp::cast!(MEMBERS[near]));
            let members: [u32; 8] = pulp::cast!(members);
            room[found..found + 8].copy_from_slice(&members);
            found += near.count_ones() as usize;
        }
        found
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// All ways keep the same numbers, in order: of every set of lanes that are near, by itself and among others.
    #[test]
    fn law_all_instructions_keep_the_same() {
        struct Keep<'a>(&'a [[f32; LANES]; 3], &'a mut Vec<u32>);

        impl Work for Keep<'_> {
            fn run(self, pack: impl Pack) {
                let numbers = std::array::from_fn(|k| 100 + k as u32);
                let mut room = [0; LANES];
                let here = [0.5, -0.25, 0.0];
                let found = pack.near(here, 1.0, (self.0.each_ref(), &numbers), &mut room);
                self.1.extend_from_slice(&room[..found]);
            }
        }

        #[cfg_attr(not(target_arch = "x86_64"), allow(unused_mut))]
        let mut ways = vec![Packing::OneByOne];
        #[cfg(target_arch = "x86_64")]
        {
            ways.extend(pulp::x86::V3::try_new().map(Packing::Permute));
            ways.extend(pulp::x86::V4::try_new().map(Packing::Compress));
        }
        for set in 0..1_u32 << LANES {
            let near = |k: usize| set >> k & 1 == 1;
            // Just inside along x, at the limit, which is not near, or nowhere.
            let far = |k: usize| if k.is_multiple_of(2) { 1.5 } else { f32::NAN };
            let x = std::array::from_fn(|k| if near(k) { 1.499 } else { far(k) });
            let columns = [x, [-0.25; LANES], [0.0; LANES]];
            let members: Vec<_> = (0..LANES)
                .filter(|&k| near(k))
                .map(|k| 100 + k as u32)
                .collect();
            for way in &ways {
                let mut found = Vec::new();
                way.run(Keep(&columns, &mut found));
                assert_eq!(found, members, "{way:?}");
            }
        }
    }
}
