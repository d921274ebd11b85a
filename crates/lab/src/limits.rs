//! How much a page may ask for.

/// Most panes of a session.
pub const PANES: usize = 6;
/// Most sessions at a time.
pub const SESSIONS: usize = 8;
/// Most runs at a time, of all sessions. A run that was closed counts until its step ends.
pub const RUNS: usize = SESSIONS * PANES;
/// Most particles of a cloth.
pub const PARTICLES: usize = 10_000;
/// Particles along a side of a square grid.
pub const SIDE: (u32, u32) = (2, 100);
/// Stiffness over mass, 1/s².
pub const STIFFNESS_PER_S2: (f64, f64) = (1.0, 1e10);
/// Damping over mass, 1/s.
pub const DAMPING_PER_S: (f64, f64) = (0.0, 1e6);
/// Time steps, s.
pub const STEP_S: (f64, f64) = (1e-6, 1.0);
/// Simulated time, s.
pub const DURATION_S: (f64, f64) = (1e-6, 3600.0);
/// Most steps of a run.
pub const STEPS: u64 = 10_000_000;
/// Simulated seconds in a second.
pub const RATE: (f64, f64) = (0.01, 10.0);
/// Most bytes of a message from the page.
pub const MESSAGE_BYTES: usize = 64 << 10;
