//! Tests that cross crates: every method of the registry against every property.

mod architecture;
mod auto;
mod bundled;
mod conservation;
mod contact;
mod contract;
mod corner;
mod dependencies;
mod driven;
mod energy_ledger;
mod equations;
mod forces;
mod frames;
mod independent;
mod laws;
mod lessons;
mod locking;
mod motion;
mod order;
mod recurrence;
mod refusals;
mod robustness;
mod rows;
mod solver_control;
mod theorems;
mod threads;
