//! A motion as one binary glTF 2.0 file.
//!
//! The cloth is a mesh. Each frame after the first is a morph target: the differences of its
//! positions and normals from those of the first frame. The animated weights fade linearly from one
//! frame to the next. Moving obstacles are nodes with an animated translation. Every reader of glTF
//! supports this, Blender among them. Positions are float32, in metres. The y-axis is up in glTF
//! and the z-axis in scenes, so a node turns the scene.

use crate::Solid;
use crate::surface::normals;
use crate::{RenderError, Subject};
use drape_model::Vec3;
use gltf::binary::{Glb, Header};
use gltf::json;
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::animation::{Channel, Interpolation, Property, Sampler, Target};
use gltf::json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use gltf::json::validation::{Checked::Valid, USize64};
use gltf::json::{Accessor, Index, Root, buffer};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Most frames of an animation. The size of the weights grows with their square.
pub const MOST_FRAMES: u64 = 1000;
/// Most bytes of an animation.
const MOST_BYTES: u64 = 1 << 30;

/// Colours of cloth and obstacles (linear, with opacity).
const CLOTH: [f32; 4] = [0.11, 0.30, 0.71, 1.0];
const SOLID: [f32; 4] = [0.60, 0.60, 0.65, 1.0];

type Points = Vec<[f32; 3]>;

/// A motion, collected frame by frame.
#[derive(Clone, Debug)]
pub struct Animation {
    subject: Subject,
    times: Vec<f32>,
    /// Positions, m, and normals of each frame; the normals are empty without triangles.
    frames: Vec<[Points; 2]>,
}

impl Animation {
    /// An animation without frames.
    pub fn new(subject: Subject) -> Self {
        Self { subject, times: Vec::new(), frames: Vec::new() }
    }

    /// Checks that so many frames of so many particles fit into a file.
    ///
    /// # Errors
    /// [`RenderError::TooLarge`] if they do not fit.
    pub fn check_size(particles: usize, frames: u64) -> Result<(), RenderError> {
        let a_frame =
            24_u64.saturating_mul(particles as u64).saturating_add(frames.saturating_mul(4));
        let bytes = frames.saturating_mul(a_frame);
        if bytes > MOST_BYTES {
            return Err(RenderError::TooLarge { bytes, most: MOST_BYTES });
        }
        Ok(())
    }

    /// Adds a frame: the positions `x`, m, at `time`, s, which is later than that of the last
    /// frame. Returns `false` and adds nothing if float32 cannot hold the frame.
    pub fn push(&mut self, time: f64, x: &[Vec3]) -> bool {
        let time = time as f32;
        let points: Points = x.iter().map(single).collect();
        // Differences of two frames must be finite, too.
        let is_small = points.as_flattened().iter().all(|c| c.abs() < 0.25 * f32::MAX);
        if !is_small || !time.is_finite() || self.times.last().is_some_and(|&last| time <= last) {
            return false;
        }
        let normals = if self.subject.triangles.is_empty() {
            Vec::new()
        } else {
            normals(x, &self.subject.triangles).iter().map(single).collect()
        };
        self.times.push(time);
        self.frames.push([points, normals]);
        true
    }

    /// The bytes of a GLB file.
    ///
    /// # Errors
    /// [`RenderError`] when the file would be too large or cannot be encoded.
    pub fn glb(&self) -> Result<Vec<u8>, RenderError> {
        let particles = self.frames.first().map_or(0, |[points, _]| points.len());
        Self::check_size(particles, self.frames.len() as u64)?;
        let mut file = File::default();
        let mut children = Vec::new();
        if let Some((first, later)) = self.frames.split_first() {
            children.push(self.cloth(&mut file, first, later));
        }
        let material = (!self.subject.solids.is_empty()).then(|| file.material("obstacle", SOLID));
        for solid in &self.subject.solids {
            let node = file.solid(solid, material);
            if let (Some(path), true) = (&solid.path, self.times.len() > 1) {
                let at = |&t: &f32| single(&path.offset(f64::from(t)));
                let offsets: Points = self.times.iter().map(at).collect();
                file.translate(node, &self.times, &offsets);
            }
            children.push(node);
        }
        file.finish(children)
    }

    fn cloth(
        &self,
        file: &mut File,
        first: &[Points; 2],
        later: &[[Points; 2]],
    ) -> Index<json::Node> {
        let (indices, mode) = if self.subject.triangles.is_empty() {
            (self.subject.lines.as_flattened(), Mode::Lines)
        } else {
            (self.subject.triangles.as_flattened(), Mode::Triangles)
        };
        let less = |points: &Points, base: &Points| -> Points {
            let pairs = points.iter().zip(base);
            pairs.map(|(a, b)| [a[0] - b[0], a[1] - b[1], a[2] - b[2]]).collect()
        };
        let targets: Vec<MorphTarget> = later
            .iter()
            .map(|[points, normals]| MorphTarget {
                positions: Some(file.vectors(&less(points, &first[0]), true)),
                normals: (!normals.is_empty())
                    .then(|| file.vectors(&less(normals, &first[1]), false)),
                tangents: None,
            })
            .collect();
        let material = file.material("cloth", CLOTH);
        let primitive = Primitive {
            targets: (!targets.is_empty()).then_some(targets),
            ..file.primitive(first, indices, mode, Some(material))
        };
        let node = file.node("cloth", primitive, vec![0.0; later.len()]);
        if !later.is_empty() {
            file.animate(node, &self.times);
        }
        node
    }
}

/// A vector in float32.
fn single(x: &Vec3) -> [f32; 3] {
    [x.x as f32, x.y as f32, x.z as f32]
}

/// A file while it is built.
#[derive(Default)]
struct File {
    root: Root,
    binary: Vec<u8>,
    samplers: Vec<Sampler>,
    channels: Vec<Channel>,
}

impl File {
    /// Appends data of four bytes each and returns their accessor.
    fn accessor(
        &mut self,
        bytes: &[u8],
        (component, kind, width): (ComponentType, Type, usize),
        target: Option<buffer::Target>,
    ) -> Accessor {
        let view = self.root.push(buffer::View {
            buffer: Index::new(0),
            byte_length: USize64::from(bytes.len()),
            byte_offset: Some(USize64::from(self.binary.len())),
            byte_stride: None,
            name: None,
            target: target.map(Valid),
            extensions: None,
            extras: Default::default(),
        });
        self.binary.extend(bytes);
        Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: USize64::from(bytes.len() / (4 * width)),
            component_type: Valid(GenericComponentType(component)),
            type_: Valid(kind),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
            extensions: None,
            extras: Default::default(),
        }
    }

    /// Adds vectors, one for each vertex, and their bounds if `has_bounds`. Positions need bounds.
    fn vectors(&mut self, vectors: &[[f32; 3]], has_bounds: bool) -> Index<Accessor> {
        let kind = (ComponentType::F32, Type::Vec3, 3);
        let bytes = bytemuck::cast_slice(vectors);
        let mut accessor = self.accessor(bytes, kind, Some(buffer::Target::ArrayBuffer));
        if let (true, Some(&first)) = (has_bounds, vectors.first()) {
            let over = |pick: fn(f32, f32) -> f32| {
                let pick = |a: [f32; 3], b: &[f32; 3]| [0, 1, 2].map(|n| pick(a[n], b[n]));
                Some(json::Value::from(vectors.iter().fold(first, pick).to_vec()))
            };
            (accessor.min, accessor.max) = (over(f32::min), over(f32::max));
        }
        self.root.push(accessor)
    }

    /// Adds numbers that belong to no vertex.
    fn numbers(&mut self, numbers: &[f32]) -> Accessor {
        self.accessor(bytemuck::cast_slice(numbers), (ComponentType::F32, Type::Scalar, 1), None)
    }

    fn primitive(
        &mut self,
        [points, normals]: &[Points; 2],
        indices: &[u32],
        mode: Mode,
        material: Option<Index<json::Material>>,
    ) -> Primitive {
        let mut attributes = BTreeMap::new();
        attributes.insert(Valid(Semantic::Positions), self.vectors(points, true));
        if !normals.is_empty() {
            attributes.insert(Valid(Semantic::Normals), self.vectors(normals, false));
        }
        let kind = (ComponentType::U32, Type::Scalar, 1);
        let target = Some(buffer::Target::ElementArrayBuffer);
        // Particles without triangles and lines are a mesh without indices: points.
        let mode = if indices.is_empty() { Mode::Points } else { mode };
        let indices = (!indices.is_empty()).then(|| {
            let accessor = self.accessor(bytemuck::cast_slice(indices), kind, target);
            self.root.push(accessor)
        });
        Primitive {
            attributes,
            indices,
            material,
            mode: Valid(mode),
            targets: None,
            extensions: None,
            extras: Default::default(),
        }
    }

    fn material(&mut self, name: &str, colour: [f32; 4]) -> Index<json::Material> {
        let mut material = json::Material {
            double_sided: true,
            name: Some(name.to_owned()),
            ..Default::default()
        };
        let surface = &mut material.pbr_metallic_roughness;
        surface.base_color_factor = json::material::PbrBaseColorFactor(colour);
        surface.metallic_factor = json::material::StrengthFactor(0.0);
        surface.roughness_factor = json::material::StrengthFactor(0.9);
        self.root.push(material)
    }

    /// A node with a mesh of one primitive.
    fn node(&mut self, name: &str, primitive: Primitive, weights: Vec<f32>) -> Index<json::Node> {
        let mesh = self.root.push(json::Mesh {
            name: Some(name.to_owned()),
            primitives: vec![primitive],
            weights: (!weights.is_empty()).then_some(weights),
            extensions: None,
            extras: Default::default(),
        });
        let name = Some(name.to_owned());
        self.root.push(json::Node { mesh: Some(mesh), name, ..Default::default() })
    }

    fn solid(
        &mut self,
        solid: &Solid,
        material: Option<Index<json::Material>>,
    ) -> Index<json::Node> {
        // Flat faces share no corners.
        let is_flat = !solid.lines.is_empty();
        let corners = solid.triangles.as_flattened();
        let (points, triangles) = if is_flat {
            let points: Vec<Vec3> = corners.iter().map(|&i| solid.points[i as usize]).collect();
            let triangles =
                (0..points.len() as u32 / 3).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
            (points, triangles)
        } else {
            (solid.points.clone(), solid.triangles.clone())
        };
        let normals = normals(&points, &triangles);
        let data = [points, normals].map(|vectors| vectors.iter().map(single).collect());
        let primitive = self.primitive(&data, triangles.as_flattened(), Mode::Triangles, material);
        self.node(&solid.name, primitive, Vec::new())
    }

    /// Animates the weights. At the time of frame `k`, the weight of target `k` is 1 and all others
    /// are 0. The first frame is the mesh itself.
    fn animate(&mut self, node: Index<json::Node>, times: &[f32]) {
        let targets = times.len() - 1;
        let input = self.moments(times);
        let mut weights = vec![0.0; times.len() * targets];
        for frame in 1..times.len() {
            weights[frame * targets + frame - 1] = 1.0;
        }
        let output = self.numbers(&weights);
        self.channel(node, Property::MorphTargetWeights, input, output);
    }

    /// Animates the translation: at time `k` the node is displaced by offset `k`, m.
    fn translate(&mut self, node: Index<json::Node>, times: &[f32], offsets: &[[f32; 3]]) {
        let input = self.moments(times);
        let kind = (ComponentType::F32, Type::Vec3, 3);
        let output = self.accessor(bytemuck::cast_slice(offsets), kind, None);
        self.channel(node, Property::Translation, input, output);
    }

    /// Adds times, s, with their bounds.
    fn moments(&mut self, times: &[f32]) -> Accessor {
        let mut input = self.numbers(times);
        input.min = times.first().map(|&t| vec![t].into());
        input.max = times.last().map(|&t| vec![t].into());
        input
    }

    fn channel(
        &mut self,
        node: Index<json::Node>,
        property: Property,
        input: Accessor,
        output: Accessor,
    ) {
        let sampler = Index::new(self.samplers.len() as u32);
        self.samplers.push(Sampler {
            input: self.root.push(input),
            interpolation: Valid(Interpolation::Linear),
            output: self.root.push(output),
            extensions: None,
            extras: Default::default(),
        });
        let target =
            Target { node, path: Valid(property), extensions: None, extras: Default::default() };
        let extras = Default::default();
        self.channels.push(Channel { sampler, target, extensions: None, extras });
    }

    fn finish(self, children: Vec<Index<json::Node>>) -> Result<Vec<u8>, RenderError> {
        let Self { mut root, binary, samplers, channels } = self;
        if !channels.is_empty() {
            root.push(json::Animation {
                channels,
                samplers,
                name: Some("motion".to_owned()),
                extensions: None,
                extras: Default::default(),
            });
        }
        root.asset.generator = Some(format!("drape {}", env!("CARGO_PKG_VERSION")));
        if !binary.is_empty() {
            root.push(json::Buffer {
                byte_length: USize64::from(binary.len()),
                name: None,
                uri: None,
                extensions: None,
                extras: Default::default(),
            });
        }
        // A quarter turn about x: z becomes y.
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let scene = root.push(json::Node {
            children: (!children.is_empty()).then_some(children),
            name: Some("scene".to_owned()),
            rotation: Some(json::scene::UnitQuaternion([-half, 0.0, 0.0, half])),
            ..Default::default()
        });
        let scene = root.push(json::Scene {
            nodes: vec![scene],
            name: None,
            extensions: None,
            extras: Default::default(),
        });
        root.scene = Some(scene);
        let text = root.to_vec()?;
        // The writer pads both parts and fills in the length.
        let header = Header { magic: *b"glTF", version: 2, length: 0 };
        let bin = (!binary.is_empty()).then_some(Cow::Owned(binary));
        let glb = Glb { header, json: Cow::Owned(text), bin };
        Ok(glb.to_vec()?)
    }
}
