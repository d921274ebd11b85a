//! Plots and pages, drawn from records alone
