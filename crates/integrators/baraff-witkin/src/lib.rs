//! Baraff and Witkin's linearised implicit step.
