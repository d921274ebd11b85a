//! The model: particles, springs and other effects, pins, obstacles. This crate knows no time step.
//!
//! # The model
//!
//! A cloth is a system of `n` particles with masses `m_i` (kg), positions `x_i` (m) and velocities
//! `v_i` (m/s) that obeys `M x'' = f(x, v)`. The forces are a sum over *effects*. A scene names its
//! effects. An effect that it does not name costs nothing in the running [`System`]: no field, no
//! pass over the particles, no entry in a matrix.
//!
//! All forces follow one sign convention: they are *restoring*. Between the ends `i` and `j` of a
//! spring with `d = x_i − x_j`, length `L = |d|`, direction `û = d/L`,
//!
//! ```text
//! f_i = −k (L − ℓ) û − c (v_i − v_j)          f_j = −f_i
//!     = −k d  +  k ℓ û  − c (v_i − v_j)
//!        F1       F2        F_D
//! ```
//!
//! Eberhardt, Etzmuß and Hauth (2000, "EEH") print the opposite sign in their (11)–(15), which
//! would make springs repulsive and damping excite the motion; see [`effects`].
//!
//! # How the code does it
//!
//! ```text
//! scene file ─► Scene ─► SystemSpec ("drape-system/1") ─► System + State
//! ```
//!
//! A person writes a [`Scene`]. A [`SystemSpec`] is the discretised system, which any program can
//! read. A [`System`] is the running form. A scene always passes through its specification, so a
//! frozen scene gives the same bits as the scene itself. [`load`] reads either from a file.
//!
//! Each effect is one file in [`effects`], from its keys in a scene to its Jacobian; one line there
//! registers it.
//!
//! # Units that people have
//!
//! A scene may name a measured [material](fabric) in place of masses and stiffnesses. The material
//! has rigidities per width (N/m and N m) along warp and weft, which do not depend on the mesh.
//! drape converts them to the springs, angles and hinges of the scene's grid or mesh.
//! [`fabric::convert`] derives the conversion and states the limits of each model of bending.
//!
//! # Symbols
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `n` | [`System::len`] | – | |
//! | `m` | [`System::mass`] | kg | `n` |
//! | `x`, `v` | [`State::x`], [`State::v`] | m, m/s | `n` × 3 |
//! | `k` | `stiffness` | N/m | per spring |
//! | `T(L)` | [`effects::TensionLaw`] | N | per spring |
//! | `ℓ` | `rest_length` | m | per spring |
//! | `c` (EEH: d) | `damping` | N s/m | per spring |
//! | `k/m` | `stiffness_over_mass` | 1/s² | per scene |
//! | `φ`, `n̂` | [`Obstacle::distance`] | m, – | per point |
//! | `F1`, `F2` | [`effects::LinearSplit`] | N | `n` × 3 |

mod bounds;
mod build;
pub mod bundled;
mod cloth;
mod diagnostics;
pub mod effects;
mod error;
pub mod fabric;
mod freeze;
mod load;
mod mesh;
mod numbering;
mod obstacle;
mod path;
mod projection;
mod scene;
mod select;
mod size;
mod spec;
mod state;
mod strict;
mod system;
mod topology;
pub mod triangles;

pub use cloth::{Cloth, Grid, Particles};
pub use drape_kernels::{Mat3, Vec3};
pub use effects::{
    AirSpec, AngleEffect, AngleSpec, AngularLaw, BlockSink, DampingLaw, DragSpec, Effect,
    EffectClass, EffectKind, Effects, EffectsSpec, Fabric, GravitySpec, GustSpec, HingeSpec,
    LinearSplit, Linearised, Part, PieceSpec, SpringEffect, SpringLaw, SpringSpec, Stencils,
    StiffnessProduct, StretchLaw, Tangent, TensionVisitor, Turn, WindSpec,
};
pub use error::{SceneError, Violation, nearest};
pub use load::{MAX_FILE_BYTES, SceneFile, load, load_within, parse};
pub use mesh::{MeshCloth, Rotation};
pub use numbering::Numbering;
pub use obstacle::{ClosedMesh, Detection, Obstacle, ObstacleSpec, Shape};
pub use path::{KeyframeSpec, MovingPin, Path};
pub use projection::{drape_coefficient, projected_area};
pub use scene::{Scene, TimeSpan};
pub use select::Pin;
pub use size::Size;
pub use spec::{ContactSpec, ParticlesSpec, PinSpec, SystemSpec};
pub use state::{Level, State};
pub use system::{Revisions, System};
