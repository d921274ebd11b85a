//! Cloth in textile units: rigidities per width, from measured materials, in place of stiffnesses
//! of springs.
//!
//! A scene names a material, and drape converts its constants for the cloth's mesh:
//!
//! ```json
//! "material": "denim"
//! "material": { "of": "denim", "shear_n_per_m": 40, "bending_model": "angles" }
//! "material": { "of": "my/cloth.json" }
//! "material": { "of": "dataset.csv", "row": 17, "shear_n_per_m": 30,
//!               "tension_n_per_m": { "warp": 1000, "weft": 800 } }
//! ```
//!
//! | symbol | constant | name in the code | unit | what a tester reports |
//! |---|---|---|---|---|
//! | `ρ` | areal density | `areal_density_kg_m2` | kg/m² | weight |
//! | `C₁₁`, `C₂₂` | tensile rigidity of warp, weft | `tension_n_per_m` | N/m | KES-FB1, FAST-3 |
//! | `G` | shear rigidity | `shear_n_per_m` | N/m | KES-FB1, FAST-3 |
//! | `B₁`, `B₂` | bending rigidity of warp, weft | `bending_n_m` | N m | KES-FB2, FAST-2, cantilever |
//! | `τ` | retardation time of springs | `retardation_s` | s | – |
//!
//! [`units`] turns the readings of testers into these. [`convert`] derives the stiffness of each
//! spring, angle and hinge, and states the limits of each model.
//!
//! # What the material gives
//!
//! | effect | on a grid | on a mesh |
//! |---|---|---|
//! | mass, unless the cloth states it | by the area of the cells at each particle | by the area of the faces |
//! | `tension` | springs along rows and columns | springs along edges |
//! | `shear` (`"shear_model": "springs"`) | both diagonals of each cell | both diagonals of each quad; in triangles the edges do it |
//! | `shear_angle` (`"angles"`) | the four angles of each cell | – |
//! | `bending_hinge` (`"bending_model": "hinges"`) | between triangles | between triangles |
//! | `bending_angle` (`"angles"`) | along rows and columns | – |
//! | `bending` (`"buckling"`) | from a particle to the next but one | – |
//!
//! An effect that the scene names itself replaces the material's effect of that group.
//!
//! The warp of a grid is its x. The warp of a mesh is the direction in which the first texture
//! coordinate (`vt`) grows. A mesh without texture coordinates has no directions;
//! `"directions": "mean"` then takes the mean of warp and weft. A spring's damping is `τ k`, so the
//! same strain rate gives the same damping stress on every mesh.
//!
//! # The bundled materials
//!
//! They are five of the ten cloths that Wang, O'Brien and Ramamoorthi measured (2011, *Data-driven
//! elastic models for cloth: modeling and measurement*, ACM Transactions on Graphics 30(4), 71,
//! doi:10.1145/2010324.1964966). Their model has a table of stiffnesses over strain and curvature;
//! a material has one constant for each:
//!
//! | constant | from their table |
//! |---|---|
//! | tension | `c₁₁` and `c₂₂` at zero strain |
//! | shear | `c₃₃/2` at zero strain: their shear stress is `c₃₃` times the tensor's component `γ/2` |
//! | bending | the median over the five curvatures of the rows for 0° and 90° |
//!
//! Two things are assumed: which row of bending belongs to the warp, and the retardation time,
//! which was not measured. Poisson's coupling `c₁₂` is left out, because springs have `C₁₂ = G`.
//! The linear constants hold at small loads; a cloth that is stretched by several percent is
//! stiffer.
//!
//! The table shows their drape coefficients (30 cm on 18 cm, [`Disc`] with hinges, rest positions
//! on 16, 24, 32, 40 and 48 squares across, from two starts; `tests/drape.rs` of the oracle):
//!
//! | material | least | greatest | published band of its class |
//! |---|---|---|---|
//! | `denim` | 0.76 | 0.83 | denim 0.70–0.90 |
//! | `cotton-blend` | 0.97 | 0.98 | cotton 0.60–0.76 |
//! | `tablecloth` | 0.80 | 0.83 | – |
//! | `fleece` | 0.86 | 0.89 | – |
//! | `ponte` | 0.57 | 0.67 | – |
//!
//! The trousers' cloth lies far above the band of cottons: its published rigidity, 0.2 mN m at
//! 0.22 kg/m², is typical of a stiff twill. The two starts end in different folds; the range
//! includes both.
//!
//! # For studies
//!
//! [`Strip`], [`TriangleStrip`] and [`Disc`] build the specimens of a cantilever test and of a drape
//! test as scenes.

pub mod convert;
mod material;
mod specimen;
mod table;
mod triangles;
pub mod units;
mod weave;

pub use convert::{Cell, HingeFit};
pub(crate) use material::MaterialKey;
pub use material::{BendingModel, Directions, Loaded, Material, MaterialChoice, ShearModel, Woven};
pub use specimen::{Disc, Strip};
pub use table::{Row, Table};
pub use triangles::TriangleStrip;
pub(crate) use weave::{PIECES, weave};
