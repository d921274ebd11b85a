//! Tests of the public interface.

mod air;
mod cantilever;
mod drape;
mod stencils;
