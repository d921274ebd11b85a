//! Views of a cloth: pictures without a display, OBJ files, glTF animations.
//!
//! ```text
//! SystemSpec, obstacles ─► Subject ─┬─► draw (Camera, positions) ─► Image ─► PNG
//!                                   ├─► obj::cloth, obj::solids   ─► text
//!                                   └─► Animation (frames)        ─► GLB
//! ```
//!
//! A [`Subject`] holds the constant parts of a scene: triangles and lines between particles, and
//! the surfaces of the obstacles. Each picture takes positions in the order of the specification.
//! Pass display positions ([`System::display_positions`](drape_model::System::display_positions)),
//! which lie outside of every obstacle.
//!
//! `retrofire-core` rasterises a picture into a z-buffer, with three by three samples a pixel. The
//! same positions give the same bytes. Light comes from the upper left of the camera; the two sides
//! of a cloth have different colours. Pins are dots. A [`Ground`] carries the shadow of a light
//! from above, which shows how high a cloth hangs.
//!
//! | symbol | name in the code | unit | shape |
//! |---|---|---|---|
//! | `x` | positions | m | 3 numbers per particle |
//! | – | [`Subject::triangles`], [`Subject::lines`] | indices | per triangle, per line |
//! | `t` | [`Animation::push`] | s | one number per frame |

pub mod animation;
pub mod camera;
mod draw;
mod ground;
mod image;
pub mod obj;
mod solid;
mod subject;
mod surface;

pub use animation::Animation;
pub use camera::{Camera, View};
pub use draw::{colours, draw};
pub use ground::Ground;
pub use image::{Colour, Font, Image};
pub use solid::Solid;
pub use subject::Subject;

/// Why something could not be shown.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A picture could not be encoded.
    #[error("the picture cannot be encoded as PNG: {0}")]
    Png(#[from] png::EncodingError),
    /// An animation could not be encoded.
    #[error("the animation cannot be encoded as glTF: {0}")]
    Gltf(#[from] gltf::Error),
    /// The JSON part of an animation could not be written.
    #[error("the animation cannot be encoded as glTF: {0}")]
    Json(#[from] gltf::json::Error),
    /// An animation would not fit into a file.
    #[error("the animation takes {bytes} bytes; expected at most {most}: give fewer frames")]
    TooLarge {
        /// Size of the animation, bytes.
        bytes: u64,
        /// Greatest size, bytes.
        most: u64,
    },
}
