//! Animations, read back by a reader of glTF.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{Obstacle, Shape, Vec3};
use drape_render::{Animation, RenderError, Subject};
use gltf::animation::util::ReadOutputs;
use gltf::mesh::Mode;

const SIDE: u32 = 4;

fn subject() -> Subject {
    let table = Shape::Box { center: -Vec3::z(), half_extents: Vec3::repeat(0.5) };
    let ball = Shape::Sphere { center: Vec3::x(), radius: 0.5 };
    Subject::grid(SIDE, SIDE, &[table, ball].map(Obstacle::from), &sheet(0.0))
}

/// A sheet that bends more and more.
fn sheet(bend: f64) -> Vec<Vec3> {
    let at = |n: u32| f64::from(n) / f64::from(SIDE - 1);
    let place = |n: u32| (at(n / SIDE), at(n % SIDE));
    (0..SIDE * SIDE).map(place).map(|(x, y)| Vec3::new(x, y, bend * x * y)).collect()
}

fn close(a: [f32; 3], b: &Vec3) -> bool {
    a.iter().zip(b.iter()).all(|(a, b)| (f64::from(*a) - b).abs() < 1e-6)
}

#[test]
fn counts_positions_normals_and_times_read_back() {
    let times = [0.0, 0.04, 0.1];
    let mut animation = Animation::new(subject());
    for (n, time) in times.iter().enumerate() {
        assert!(animation.push(*time, &sheet(n as f64)));
    }
    let file = gltf::Gltf::from_slice(&animation.glb().unwrap()).unwrap();
    let blob = file.blob.clone().unwrap();
    let names: Vec<_> = file.meshes().map(|mesh| mesh.name().unwrap().to_owned()).collect();
    assert_eq!(names, ["cloth", "box-0", "sphere-1"]);
    let scene = file.default_scene().unwrap().nodes().next().unwrap();
    assert_eq!(scene.children().count(), 3);
    let gltf::scene::Transform::Decomposed { rotation: [x, _, _, w], .. } = scene.transform()
    else {
        panic!("a rotation");
    };
    assert!((x + w).abs() < 1e-6, "z becomes y");

    let cloth = file.meshes().next().unwrap().primitives().next().unwrap();
    let reader = cloth.reader(|_| Some(&blob));
    assert_eq!(cloth.mode(), Mode::Triangles);
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    assert_eq!(indices, subject().triangles.as_flattened());
    let base: Vec<_> = reader.read_positions().unwrap().collect();
    for normal in reader.read_normals().unwrap() {
        assert_eq!(normal, [0.0, 0.0, -1.0], "the sheet starts flat, rows along x");
    }
    let targets: Vec<_> = reader.read_morph_targets().collect();
    assert_eq!(targets.len(), times.len() - 1);
    for (n, (positions, normals, tangents)) in targets.into_iter().enumerate() {
        assert!(tangents.is_none() && normals.unwrap().len() == base.len());
        let whole = base.iter().zip(positions.unwrap());
        let whole = whole.map(|(a, b)| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
        assert!(whole.zip(sheet((n + 1) as f64)).all(|(a, b)| close(a, &b)));
    }
    let bounds = cloth.bounding_box();
    assert_eq!((bounds.min, bounds.max), ([0.0; 3], [1.0, 1.0, 0.0]));

    let animation = file.animations().next().unwrap();
    let channel = animation.channels().next().unwrap();
    let reader = channel.reader(|_| Some(&blob));
    let read: Vec<f32> = reader.read_inputs().unwrap().collect();
    assert_eq!(read, times.map(|t| t as f32));
    let Some(ReadOutputs::MorphTargetWeights(weights)) = reader.read_outputs() else {
        panic!("weights")
    };
    let weights: Vec<f32> = weights.into_f32().collect();
    assert_eq!(weights, [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
}

#[test]
fn an_obstacle_that_moves_is_a_node_that_is_displaced() {
    let text = r#"{ "format": "drape-system/1", "particles": { "mass_kg": [1],
        "position_m": [[0, 0, 0]] },
        "obstacles": [{ "sphere": { "center_m": [0, 0, 0], "radius_m": 1 } },
            { "sphere": { "center_m": [0, 0, 0], "radius_m": 1,
                "path": [{ "time_s": 0.5, "offset_m": [1, 0, 2] }] } }] }"#;
    let input = drape_model::parse("text", text).unwrap();
    let (system, state) = input.spec().build().unwrap();
    let mut animation = Animation::new(Subject::new(input.spec(), system.obstacles()));
    for time in [0.0, 0.25, 1.0] {
        assert!(animation.push(time, &state.x));
    }
    let file = gltf::Gltf::from_slice(&animation.glb().unwrap()).unwrap();
    let blob = file.blob.clone().unwrap();
    let animation = file.animations().next().unwrap();
    assert_eq!(file.animations().count(), 1);
    let nodes: Vec<_> =
        animation.channels().map(|c| c.target().node().name().unwrap().to_owned()).collect();
    assert_eq!(nodes, ["cloth", "sphere-1"]);
    let reader = animation.channels().nth(1).unwrap();
    let reader = reader.reader(|_| Some(&blob));
    assert_eq!(reader.read_inputs().unwrap().collect::<Vec<_>>(), [0.0, 0.25, 1.0]);
    let Some(ReadOutputs::Translations(offsets)) = reader.read_outputs() else {
        panic!("translations")
    };
    assert_eq!(offsets.collect::<Vec<_>>(), [[0.0; 3], [0.5, 0.0, 1.0], [1.0, 0.0, 2.0]]);
}

#[test]
fn springs_without_triangles_are_lines_and_a_lonely_particle_is_a_point() {
    for (lines, mode) in [(vec![[0, 1]], Mode::Lines), (Vec::new(), Mode::Points)] {
        let subject = Subject { lines, ..Subject::default() };
        let mut animation = Animation::new(subject);
        animation.push(0.0, &[Vec3::zeros(), Vec3::x()]);
        animation.push(1.0, &[Vec3::zeros(), Vec3::y()]);
        let file = gltf::Gltf::from_slice(&animation.glb().unwrap()).unwrap();
        let primitive = file.meshes().next().unwrap().primitives().next().unwrap();
        assert_eq!(primitive.mode(), mode);
        assert_eq!(primitive.morph_targets().count(), 1);
    }
}

#[test]
fn frames_that_cannot_be_held_are_left_out_and_a_file_without_motion_is_one() {
    let mut animation = Animation::new(subject());
    let far: Vec<Vec3> = sheet(0.0).iter().map(|x| x * 1e39).collect();
    assert!(!animation.push(0.0, &far));
    assert!(animation.push(0.0, &sheet(0.0)));
    assert!(!animation.push(0.0, &sheet(1.0)), "no later than the last one");
    assert!(!animation.push(f64::NAN, &sheet(1.0)));
    let file = gltf::Gltf::from_slice(&animation.glb().unwrap()).unwrap();
    assert_eq!(file.animations().count(), 0);
    assert!(gltf::Gltf::from_slice(&Animation::new(subject()).glb().unwrap()).is_ok());
}

#[test]
fn what_would_fill_the_memory_is_refused() {
    assert!(Animation::check_size(400, 1000).is_ok());
    let refused = Animation::check_size(4_000_000, 1000);
    assert!(matches!(refused, Err(RenderError::TooLarge { .. })));
    assert!(Animation::check_size(usize::MAX, u64::MAX).is_err());
}
