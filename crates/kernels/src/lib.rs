//! Memory layouts and vectorised loops that the model and the solvers share.
//!
//! This crate knows neither physics nor matrices as operators. It defines the layouts and orders of
//! summation on which the crates that use it must agree:
//!
//! | module | what it holds |
//! |---|---|
//! | [`vector`] | one [`Vec3`] per particle: sums in one documented order, and updates |
//! | [`bands`] | how sweeps are cut into bands, and bands shared among threads |
//! | [`lanes`] | operations on four numbers, and [`vectorised!`] for the present processor |
//! | [`triples`] | operations on four vectors of three coordinates |
//! | [`angle`] | `atan2` of four points, with the bits of `libm` |
//! | [`planes`] | one array per coordinate: strides, aligned memory, windows that slide |
//! | [`blocks`] | where symmetric 3×3 blocks lie: along bands, or in one line per pair |
//! | [`testing`] | random numbers, and the comparison of two forms of a kernel bit by bit |
//!
//! # Two forms of a kernel
//!
//! A kernel exists twice: as the readable loop, called `reference`, and as the `fast` form that
//! runs in a step. Both add the same numbers in the same order, and products and sums are never
//! fused into one rounding. So both give the same bits on every machine, and
//! [`assert_same_bits`](testing::assert_same_bits) checks this.

pub mod angle;
pub mod bands;
pub mod blocks;
pub mod lanes;
pub mod planes;
pub mod testing;
pub mod triples;
pub mod vector;

#[doc(hidden)]
pub use pulp;

/// A vector of three coordinates, such as the position, velocity or force of one particle.
pub type Vec3 = nalgebra::Vector3<f64>;

/// A 3×3 block.
pub type Mat3 = nalgebra::Matrix3<f64>;
