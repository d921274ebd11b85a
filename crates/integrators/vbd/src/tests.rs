//! Vertex block descent against backward Euler, its laws, and the numbers of the crate's page.

mod convergence;
mod groups;
mod laws;
mod motion;
mod published;
mod support;
