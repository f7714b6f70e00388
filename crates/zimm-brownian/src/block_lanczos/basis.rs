//! An orthonormal basis in slabs of rows, which are cut by the number of beads: sums are those of slabs, joined in order,
//! so bits are the same on any number of threads.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use std::ops::Range;
use zimm_core::{DVec3, each_block};

/// Beads in a slab.
const SLAB: usize = 1024;

/// Columns that are orthonormal, and images that are made so.
#[derive(Clone, Debug, Default)]
pub(super) struct Basis {
    slabs: Vec<Slab>,
    beads: usize,
    columns: usize,
    images: usize,
}

/// The rows of some beads, column after column.
#[derive(Clone, Debug, Default)]
struct Slab {
    rows: usize,
    basis: Vec<f64>,
    images: Vec<f64>,
    shares: Vec<f64>,
    square: f64,
}

impl Basis {
    /// No columns, and so many images of zero.
    pub(super) fn clear(&mut self, beads: usize, images: usize) {
        self.beads = beads;
        self.columns = 0;
        self.slabs.resize_with(beads.div_ceil(SLAB), Slab::default);
        for (k, slab) in self.slabs.iter_mut().enumerate() {
            slab.rows = 3 * SLAB.min(beads - k * SLAB);
            slab.basis.clear();
        }
        self.expect(images);
    }

    /// Makes room for so many images.
    pub(super) fn expect(&mut self, images: usize) {
        self.images = images;
        for slab in &mut self.slabs {
            slab.images.clear();
            slab.images.resize(slab.rows * images, 0.0);
        }
    }

    /// Number of columns.
    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    /// Number of images.
    pub(super) fn images(&self) -> usize {
        self.images
    }

    /// Whether there is no room for another column.
    pub(super) fn is_complete(&self) -> bool {
        self.columns >= 3 * self.beads
    }

    /// Reads a column.
    pub(super) fn read(&self, column: usize, vector: &mut Vec<DVec3>) {
        vector.clear();
        for slab in &self.slabs {
            let part = &slab.basis[slab.column(column)];
            vector.extend(part.chunks_exact(3).map(DVec3::from_slice));
        }
    }

    /// Writes an image.
    pub(super) fn write(&mut self, image: usize, vector: &[DVec3]) {
        for (slab, vector) in self.slabs.iter_mut().zip(vector.chunks(SLAB)) {
            let place = slab.column(image);
            let part = slab.images[place].chunks_exact_mut(3);
            for (part, v) in part.zip(vector) {
                v.write_to_slice(part);
            }
        }
    }

    /// The length of an image.
    pub(super) fn length(&mut self, image: usize) -> f64 {
        each_block(&mut self.slabs, |_, slab| {
            let part = &slab.images[slab.column(image)];
            slab.square = part.iter().map(|x| x * x).sum();
        });
        self.slabs
            .iter()
            .map(|slab| slab.square)
            .sum::<f64>()
            .sqrt()
    }

    /// Takes off the images what they have of the columns from `first` on: how much that is, a row for each column.
    pub(super) fn take_off(&mut self, first: usize, images: Range<usize>) -> Mat<f64> {
        let (from, columns) = (first, self.columns - first);
        let mut shares = Mat::zeros(columns, images.len());
        each_block(&mut self.slabs, |_, slab| {
            slab.measure(from, columns, images.clone());
        });
        for slab in &self.slabs {
            shares += MatRef::from_column_major_slice(&slab.shares, columns, images.len());
        }
        each_block(&mut self.slabs, |_, slab| {
            slab.take_off(from, &shares, images.clone());
        });
        shares
    }

    /// Makes an image of this length a column.
    pub(super) fn push(&mut self, image: usize, length: f64) {
        self.columns += 1;
        let scale = length.recip();
        each_block(&mut self.slabs, |_, slab| {
            let place = slab.column(image);
            let Slab { basis, images, .. } = slab;
            basis.extend(images[place].iter().map(|x| scale * x));
        });
    }

    /// The products of the first columns with `weights`, which has a row for each of them.
    pub(super) fn multiply(&mut self, weights: &Mat<f64>, products: &mut Vec<Vec<DVec3>>) {
        self.expect(weights.ncols());
        each_block(&mut self.slabs, |_, slab| slab.multiply(weights));
        products.resize_with(weights.ncols(), Vec::new);
        for (image, product) in products.iter_mut().enumerate() {
            product.clear();
            for slab in &self.slabs {
                let part = &slab.images[slab.column(image)];
                product.extend(part.chunks_exact(3).map(DVec3::from_slice));
            }
        }
    }
}

impl Slab {
    fn column(&self, column: usize) -> Range<usize> {
        column * self.rows..(column + 1) * self.rows
    }

    fn span(&self, columns: Range<usize>) -> Range<usize> {
        columns.start * self.rows..columns.end * self.rows
    }

    fn measure(&mut self, from: usize, columns: usize, images: Range<usize>) {
        self.shares.clear();
        self.shares.resize(columns * images.len(), 0.0);
        let basis = &self.basis[self.span(from..from + columns)];
        let basis = MatRef::from_column_major_slice(basis, self.rows, columns);
        let part = &self.images[self.span(images.clone())];
        let part = MatRef::from_column_major_slice(part, self.rows, images.len());
        let shares = MatMut::from_column_major_slice_mut(&mut self.shares, columns, images.len());
        matmul(
            shares,
            Accum::Replace,
            basis.transpose(),
            part,
            1.0,
            Par::Seq,
        );
    }

    fn take_off(&mut self, from: usize, shares: &Mat<f64>, images: Range<usize>) {
        let basis = &self.basis[self.span(from..from + shares.nrows())];
        let basis = MatRef::from_column_major_slice(basis, self.rows, shares.nrows());
        let place = self.span(images.clone());
        let part = &mut self.images[place];
        let part = MatMut::from_column_major_slice_mut(part, self.rows, images.len());
        matmul(part, Accum::Add, basis, shares, -1.0, Par::Seq);
    }

    fn multiply(&mut self, weights: &Mat<f64>) {
        let basis = &self.basis[self.span(0..weights.nrows())];
        let basis = MatRef::from_column_major_slice(basis, self.rows, weights.nrows());
        let images = &mut self.images;
        let images = MatMut::from_column_major_slice_mut(images, self.rows, weights.ncols());
        matmul(images, Accum::Replace, basis, weights, 1.0, Par::Seq);
    }
}
