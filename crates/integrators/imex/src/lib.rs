//! imex
