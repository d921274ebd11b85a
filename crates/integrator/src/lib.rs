//! The integrator trait and what several time integrators share
