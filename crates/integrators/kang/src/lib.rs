//! Kang, Choi and Cho's neighbour-corrected sweep.
