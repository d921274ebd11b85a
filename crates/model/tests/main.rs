//! Tests of the public interface.

mod bundled_meshes;
mod fabric;
mod freeze;
mod geometry;
mod limits;
mod material;
mod mesh;
mod projection;
mod refusals;
mod round_trip;
mod schema;
mod specimen;
mod stencils;
