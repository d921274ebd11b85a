//! The limits on the requests of a page.

/// Most panes of a session.
pub const PANES: usize = 6;
/// Most sessions at a time.
pub const SESSIONS: usize = 8;
/// Most runs at a time, of all sessions. Each pane may have a reference beside it, and a run that
/// was closed counts until its step ends.
pub const RUNS: usize = 4 * SESSIONS * PANES;
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
/// Most bytes of a request from the page; [`FILE_MESSAGE_BYTES`] for a file.
pub const MESSAGE_BYTES: usize = 64 << 10;
/// Most bytes of a scene or a frozen system from a page.
pub const FILE_BYTES: usize = 16 << 20;
/// Most bytes of a mesh from a page.
pub const MESH_BYTES: usize = 4 << 20;
/// Most files of a page, and most bytes of all of them.
pub const FILES: usize = 16;
/// See [`FILES`].
pub const FILES_BYTES: usize = 32 << 20;
/// Most bytes of the name of a file.
pub const NAME_BYTES: usize = 120;
/// Most bytes of a message with a file: its name, and where the name ends.
pub const FILE_MESSAGE_BYTES: usize = FILE_BYTES + NAME_BYTES + 4;
/// Gravity, m/s².
pub const GRAVITY_M_S2: (f64, f64) = (0.0, 1000.0);
/// Components of the wind, m/s.
pub const WIND_M_S: (f64, f64) = (-100.0, 100.0);
/// Greatest displacement along an axis of a particle that is led by hand, m.
pub const WAY_M: f64 = 1000.0;
/// Most bytes of positions that a reference solution keeps.
pub const GHOST_BYTES: usize = 32 << 20;
