//! Tests of the public interface.

mod auto;
mod linearised;
