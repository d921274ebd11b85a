//! backward-euler
