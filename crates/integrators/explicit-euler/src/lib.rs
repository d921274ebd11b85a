//! explicit-euler
