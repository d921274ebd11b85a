//! Adams-Bashforth and BDF methods of up to three steps.
