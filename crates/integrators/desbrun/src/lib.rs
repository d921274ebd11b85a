//! Desbrun, Schröder and Barr's precomputed inverse.
