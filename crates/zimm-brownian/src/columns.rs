//! Sums over columns in blocks cut by their length, joined in order: the same bits on any number of threads.

use zimm_core::{DVec3, each_block, for_each_chunk};

const BLOCK: usize = 1024;

/// The scalar product of two columns of the same length.
pub(crate) fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    let block = |k: usize| -> f64 {
        let range = k * BLOCK..a.len().min((k + 1) * BLOCK);
        let pairs = a[range.clone()].iter().zip(&b[range]);
        pairs.map(|(a, b)| a.dot(*b)).sum()
    };
    let blocks = a.len().div_ceil(BLOCK);
    let (mut total, mut sums) = (0.0, [0.0; 64]);
    for first in (0..blocks).step_by(sums.len()) {
        let sums = &mut sums[..(blocks - first).min(64)];
        each_block(sums, |k, sum| *sum = block(first + k));
        total = sums.iter().fold(total, |total, sum| total + sum);
    }
    total
}

/// The length of a column.
pub(crate) fn norm(a: &[DVec3]) -> f64 {
    dot(a, a).sqrt()
}

/// `a += factor * b`.
pub(crate) fn add_scaled(a: &mut [DVec3], factor: f64, b: &[DVec3]) {
    for_each_chunk(a, |start, chunk| {
        for (a, b) in chunk.iter_mut().zip(&b[start..]) {
            *a += factor * *b;
        }
    });
}

/// `a *= factor`.
pub(crate) fn rescale(a: &mut [DVec3], factor: f64) {
    for_each_chunk(a, |_, chunk| {
        for a in chunk {
            *a *= factor;
        }
    });
}
