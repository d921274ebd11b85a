//! Tests of the public interface.

mod broken;
mod shipped;
