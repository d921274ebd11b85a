//! Symmetric matrices of 3×3 blocks, for Jacobians that couple the coordinates.
//!
//! A matrix has one of three layouts, which the couplings choose.
//!
//! | layout | for | a row of a sheet with tension, shear and bending springs |
//! |---|---|---|
//! | [`Coupling::Bands`] | springs of regular grids, numbered row by row | 384 bytes, no index |
//! | [`Coupling::Pairs`] | springs in any order | 304 bytes |
//! | [`Coupling::Rows`] | any blocks; factorisations | 1036 bytes |
//!
//! Bands and compressed rows give the same bits. Each of them sums a row from its first scalar column
//! to its last. Places along a band without a coupling hold zeros, which change no sum of finite
//! numbers. Springs in any order multiply the difference of their ends, and round elsewhere.

mod bands;
mod pairs;
mod product;
mod rows;
mod single;
#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests;

use self::bands::Bands;
use self::pairs::Pairs;
pub(crate) use self::rows::Rows;
pub use self::single::SinglePcg;
use crate::bands::{bands, in_bands};
use crate::pattern::Pattern;
use crate::{Constraints, Filter, LinearOperator, Mat3, Vec3};
use drape_kernels::blocks::{BlockLayout, BlockSink, Coupling};
use std::borrow::Cow;

/// A symmetric matrix of 3×3 blocks.
///
/// ```
/// use drape_solvers::{BlockMatrix, LinearOperator, Mat3, Vec3};
/// let mut a = BlockMatrix::with_pattern(2, [(0, 1)]);
/// a.add_diagonal(0, &Mat3::identity());
/// a.add_diagonal(1, &Mat3::identity());
/// // A spring along x resists in that direction only.
/// a.add_pair(0, 1, &(10.0 * Vec3::x() * Vec3::x().transpose()));
/// let mut y = [Vec3::zeros(); 2];
/// a.multiply(&[Vec3::new(1.0, 1.0, 0.0), Vec3::zeros()], &mut y);
/// assert_eq!(y, [Vec3::new(11.0, 1.0, 0.0), Vec3::new(-10.0, 0.0, 0.0)]);
/// ```
#[derive(Clone, Debug)]
pub struct BlockMatrix {
    layout: Layout,
    /// Parts of a product that threads share.
    bands: usize,
}

#[derive(Clone, Debug)]
enum Layout {
    Rows(Rows),
    Bands(Bands),
    Pairs(Pairs),
}

/// The same expression for the matrix of any layout.
macro_rules! each {
    ($layout:expr, $matrix:ident => $value:expr) => {
        match $layout {
            Layout::Rows($matrix) => $value,
            Layout::Bands($matrix) => $value,
            Layout::Pairs($matrix) => $value,
        }
    };
}

impl BlockMatrix {
    /// The zero matrix in the layout of `coupling`, with room for `n` diagonal blocks and for each
    /// edge. Edges may be repeated, and may join a row to itself. The layout of bands ignores the
    /// edges.
    ///
    /// # Panics
    /// When an edge names a row that is not below `n`, when a `u32` cannot number rows and edges,
    /// or when a band has the offset 0.
    pub fn new(
        n: usize,
        coupling: &Coupling,
        edges: impl IntoIterator<Item = (usize, usize)>,
    ) -> Self {
        let layout = match coupling {
            Coupling::Bands(offsets) => Layout::Bands(Bands::new(n, offsets)),
            Coupling::Pairs => Layout::Pairs(Pairs::new(n, edges)),
            Coupling::Rows => Layout::Rows(Rows::new(n, edges)),
        };
        Self { layout, bands: 1 }
    }

    /// As [`new`](Self::new), in compressed rows, a layout that can hold any blocks.
    pub fn with_pattern(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Self {
        Self::new(n, &Coupling::Rows, edges)
    }

    /// The layout of the matrix.
    pub fn coupling(&self) -> Coupling {
        match &self.layout {
            Layout::Rows(_) => Coupling::Rows,
            Layout::Bands(bands) => Coupling::Bands(bands.offsets().to_vec()),
            Layout::Pairs(_) => Coupling::Pairs,
        }
    }

    /// Number of block rows.
    pub fn n(&self) -> usize {
        each!(&self.layout, a => a.n())
    }

    /// Lets so many threads of the current [`rayon`] pool share products, and the sweeps of
    /// conjugate gradients with this matrix, where there are rows enough. No bit depends on it.
    pub fn set_threads(&mut self, threads: usize) {
        self.set_bands(bands(threads, self.n()));
    }

    pub(crate) fn set_bands(&mut self, bands: usize) {
        self.bands = bands;
        if let Layout::Bands(matrix) = &mut self.layout {
            matrix.reserve_windows(bands);
        }
    }

    /// Number of blocks that can differ from zero: both triangles and the diagonal.
    pub fn nonzeros(&self) -> usize {
        each!(&self.layout, a => a.nonzeros())
    }

    /// Sets all blocks to zero; the pattern stays.
    pub fn clear(&mut self) {
        each!(&mut self.layout, a => a.clear());
    }

    /// Copies all blocks of a matrix with the same layout and pattern.
    ///
    /// # Panics
    /// When the other matrix has another number of blocks.
    pub fn copy_from(&mut self, other: &Self) {
        if let (Layout::Rows(own), Layout::Rows(other)) = (&mut self.layout, &other.layout) {
            return own.copy_from(other);
        }
        self.layout = other.layout.clone();
        self.set_bands(self.bands);
    }

    /// Adds `block` to diagonal block `i`. The sum of all added blocks must be symmetric.
    pub fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        each!(&mut self.layout, a => a.add_diagonal(i, block));
    }

    /// Adds the symmetric `block` at (i, i) and (j, j), and its negative at (i, j) and (j, i): the
    /// contribution of a force that depends on the difference between particles `i` and `j`. For
    /// `i = j` it adds nothing.
    ///
    /// The layout of springs in any order takes its blocks only through
    /// [`fast_layout`](Self::fast_layout). Here a pair converts it to compressed rows, in which it
    /// stays.
    ///
    /// A pair outside the pattern is a bug in the caller: debug builds panic, release builds ignore
    /// the pair.
    pub fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        match &mut self.layout {
            Layout::Rows(rows) => rows.add_pair(i, j, block),
            Layout::Bands(bands) => bands.add_pair(i, j, block),
            Layout::Pairs(_) if i == j => {}
            Layout::Pairs(_) => self.make_rows().add_pair(i, j, block),
        }
    }

    /// As [`add_pair`](Self::add_pair), for a block that need not be symmetric: `B` at (i, i), `Bᵀ`
    /// at (j, j), `−B` at (i, j), `−Bᵀ` at (j, i). Such a block converts bands and springs
    /// to compressed rows.
    pub fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        if *block == block.transpose() && !matches!(self.layout, Layout::Rows(_)) {
            return self.add_pair(i, j, block);
        }
        self.make_rows().add_general_pair(i, j, block);
    }

    /// Block (i, j); zero outside the pattern.
    pub fn get(&self, i: usize, j: usize) -> Mat3 {
        each!(&self.layout, a => a.get(i, j))
    }

    /// The memory that a sweep over the springs can fill directly; `None` for compressed rows.
    pub fn fast_layout(&mut self) -> Option<BlockLayout<'_>> {
        match &mut self.layout {
            Layout::Rows(_) => None,
            Layout::Bands(bands) => Some(BlockLayout::Bands(bands.planes_mut())),
            Layout::Pairs(pairs) => Some(BlockLayout::Pairs(pairs.blocks_mut())),
        }
    }

    /// `A ← S A S + (I − S) D`, where `dᵢ` is a positive number for each constrained particle: a
    /// third of the trace of its diagonal block, or 1 if that is not positive.
    ///
    /// The matrix stays symmetric and positive definite. If a right-hand side is zero in the
    /// constrained directions (`b = S b`), so is the solution, which then solves the filtered
    /// problem. So a direct solver can replace filtered conjugate gradients.
    ///
    /// Planes and lines give blocks that are not symmetric. They convert bands and springs to
    /// compressed rows.
    ///
    /// # Panics
    /// If `constraints` is for another number of particles.
    pub fn project(&mut self, constraints: &Constraints) {
        assert_eq!(constraints.len(), self.n(), "one filter a block row");
        let constrained = || constraints.constrained().iter().map(|&i| i as usize);
        if constrained().any(|i| constraints.filter(i) != Filter::Fixed) {
            return self.make_rows().project(constraints);
        }
        let scale = |third: f64| if third > 0.0 { third } else { 1.0 };
        match &mut self.layout {
            Layout::Rows(rows) => rows.project(constraints),
            Layout::Bands(bands) => constrained().for_each(|i| bands.fix(i, scale)),
            Layout::Pairs(pairs) => constrained().for_each(|i| pairs.fix(i, scale)),
        }
    }

    /// The matrix in compressed rows: itself, or a copy.
    pub(crate) fn rows(&self) -> Cow<'_, Rows> {
        let edges = match &self.layout {
            Layout::Rows(rows) => return Cow::Borrowed(rows),
            Layout::Bands(bands) => bands.edges(),
            Layout::Pairs(pairs) => pairs.edges(),
        };
        let mut rows = Rows::new(self.n(), edges);
        rows.fill(|i, j| self.get(i, j));
        Cow::Owned(rows)
    }

    fn make_rows(&mut self) -> &mut Rows {
        if !matches!(self.layout, Layout::Rows(_)) {
            self.layout = Layout::Rows(self.rows().into_owned());
        }
        let Layout::Rows(rows) = &mut self.layout else { unreachable!("made above") };
        rows
    }

    /// Whether the matrix has room for just the blocks of a pattern.
    pub(crate) fn has_pattern(&self, pattern: &Pattern) -> bool {
        each!(&self.layout, a => a.has_pattern(pattern))
    }

    /// The compressed rows, if that is the layout.
    pub(crate) fn as_rows(&self) -> Option<&Rows> {
        match &self.layout {
            Layout::Rows(rows) => Some(rows),
            _ => None,
        }
    }
}

/// A symmetric matrix whose lower triangle can be read.
pub(crate) trait BlockSource {
    /// Writes the blocks left of the diagonal, row by row with increasing columns. Returns whether
    /// all are symmetric.
    fn read_lower(&self, lower: &mut [Mat3]) -> bool;

    /// Lets `visitor` read the numbers `xx, xy, xz, yy, yz, zz` of each diagonal block's lower
    /// triangle.
    fn with_diagonal<V: VisitDiagonal>(&self, visitor: V) -> V::Output;
}

impl BlockSource for Rows {
    fn read_lower(&self, lower: &mut [Mat3]) -> bool {
        self.read_lower(lower)
    }

    fn with_diagonal<V: VisitDiagonal>(&self, visitor: V) -> V::Output {
        visitor.visit(
            #[inline(always)]
            |i| self.diagonal(i),
        )
    }
}

impl BlockSource for BlockMatrix {
    fn read_lower(&self, lower: &mut [Mat3]) -> bool {
        each!(&self.layout, a => a.read_lower(lower))
    }

    fn with_diagonal<V: VisitDiagonal>(&self, visitor: V) -> V::Output {
        match &self.layout {
            Layout::Rows(rows) => rows.with_diagonal(visitor),
            Layout::Bands(bands) => {
                let planes = bands.diagonal();
                visitor.visit(
                    #[inline(always)]
                    |i| planes.map(|plane| plane[i]),
                )
            }
            Layout::Pairs(pairs) => visitor.visit(
                #[inline(always)]
                |i| pairs.diagonal(i),
            ),
        }
    }
}

impl From<Rows> for BlockMatrix {
    fn from(rows: Rows) -> Self {
        Self { layout: Layout::Rows(rows), bands: 1 }
    }
}

/// The symmetric block of `xx, xy, xz, yy, yz, zz`.
#[inline(always)]
pub(crate) fn symmetric([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Mat3 {
    Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// A computation over diagonal blocks, compiled for each layout.
pub(crate) trait VisitDiagonal {
    type Output;

    /// `block(i)` is diagonal block `i`.
    fn visit(self, block: impl Fn(usize) -> [f64; 6] + Sync) -> Self::Output;
}

impl BlockSink for BlockMatrix {
    fn add_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.add_pair(i, j, block);
    }

    fn add_general_pair(&mut self, i: usize, j: usize, block: &Mat3) {
        self.add_general_pair(i, j, block);
    }

    fn add_diagonal(&mut self, i: usize, block: &Mat3) {
        self.add_diagonal(i, block);
    }
}

impl LinearOperator for BlockMatrix {
    fn size(&self) -> usize {
        self.n()
    }

    fn bands(&self) -> usize {
        self.bands
    }

    /// Each row is summed from its first scalar column to its last. A matrix of springs in any order
    /// sums the forces of a row's springs instead, from its first column to its last.
    fn multiply(&self, x: &[Vec3], y: &mut [Vec3]) {
        assert_eq!(x.len(), self.n(), "one vector a block row");
        assert_eq!(y.len(), self.n(), "one vector a block row");
        each!(&self.layout, a => {
            in_bands(self.bands, y.len(), y, &|rows, y: &mut [Vec3]| a.multiply(rows, x, y));
        });
    }
}
