//! Pairs from any source, one after another.

use zimm_core::{Boundary, DVec3, Neighbours};

/// Calls `each` with the indices (in the source's order) and the separation of every pair closer than `cutoff`.
pub(crate) fn for_each_pair<B: Boundary, N: Neighbours<B>>(
    neighbours: &N,
    cutoff: f64,
    mut each: impl FnMut(usize, usize, DVec3),
) {
    let positions = neighbours.positions();
    for block in 0..neighbours.blocks() {
        neighbours.visit(block, |row| {
            let (i, here) = (row.i as usize, positions[row.i as usize] + row.shift);
            for &j in row.js {
                let r = here - positions[j as usize];
                if r.length_squared() < cutoff * cutoff {
                    each(i, j as usize, r);
                }
            }
        });
    }
}
