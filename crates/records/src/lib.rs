//! The types of everything that drape writes under results/
