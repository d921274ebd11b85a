//! Provot's symplectic Euler with a limit on elongation.
