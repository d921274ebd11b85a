//! Terzopoulos and Fleischer's semi-implicit step with secant stiffness.
