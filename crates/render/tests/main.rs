//! Tests of the public interface.

mod animation;
mod picture;
