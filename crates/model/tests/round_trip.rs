//! Printed systems read back to the same bits, and the published schemas agree with the reader.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{
    AirSpec, AngleEffect, AngleSpec, ContactSpec, DampingLaw, Detection, DragSpec, EffectsSpec,
    GravitySpec, GustSpec, HingeSpec, KeyframeSpec, ObstacleSpec, ParticlesSpec, PieceSpec,
    PinSpec, Scene, SceneFile, SpringEffect, SpringSpec, SystemSpec, WindSpec, bundled, load,
    parse,
};
use proptest::prelude::*;
use serde_json::{Value, json, to_string_pretty};

/// Prints, reads back, and compares values, print-outs and the bits of every number.
fn assert_survives(spec: &SystemSpec) {
    let text = to_string_pretty(spec).unwrap();
    let back = match parse("printed", &text).unwrap() {
        SceneFile::System(back) => back,
        SceneFile::Scene(..) => panic!("a system was read as a scene"),
    };
    assert_eq!(spec, &back);
    assert_eq!(text, to_string_pretty(&back).unwrap());
    let bits = |spec: &SystemSpec| -> Vec<u64> {
        let particles = &spec.particles;
        let vectors = particles.position_m.iter().chain(&particles.velocity_m_s).flatten();
        let springs = spec
            .springs
            .iter()
            .flat_map(|s| [s.rest_length_m, s.stiffness_n_per_m, s.damping_n_s_per_m]);
        let angles = spec.angles.iter().flat_map(|a| [a.rest_rad, a.stiffness_n_m]);
        let hinges = spec.hinges.iter().flat_map(|h| [h.rest_rad, h.stiffness_n_m]);
        let curves = spec.springs.iter().flat_map(|s| {
            let pieces = s.pieces.iter().flat_map(|p| [p.up_to_strain, Some(p.stiffness_n_per_m)]);
            pieces.chain([s.compression_stiffness_n_per_m, s.buckling_rigidity_n_m2])
        });
        let numbers = particles.mass_kg.iter().chain(vectors).copied().chain(springs);
        let numbers = numbers.chain(angles).chain(hinges);
        let numbers = numbers.chain(curves.map(Option::unwrap_or_default));
        numbers.map(f64::to_bits).collect()
    };
    assert_eq!(bits(spec), bits(&back));
    // Pretty or not, it is the same system.
    let compact = serde_json::to_string(spec).unwrap();
    assert_eq!(parse("compact", &compact).unwrap().spec(), spec);
}

#[test]
fn bundled_scenes_and_their_frozen_systems_survive_printing() {
    for name in bundled::names() {
        let input = load(name).unwrap();
        assert_survives(input.spec());
        let scene = input.scene().unwrap();
        let text = to_string_pretty(scene).unwrap();
        let back = parse(name, &text).unwrap();
        assert_eq!(back, input, "{name}");
        assert_eq!(text, to_string_pretty(back.scene().unwrap()).unwrap());
        assert_eq!(scene.name, name);
    }
}

#[test]
fn the_paths_that_scenes_call_assumed_exist() {
    for name in bundled::names() {
        let value: Value = serde_json::from_str(bundled::text(name).unwrap()).unwrap();
        for path in load(name).unwrap().scene().unwrap().assumed.clone() {
            assert!(
                value.pointer(&format!("/{}", path.replace('.', "/"))).is_some(),
                "{name}: {path}"
            );
        }
    }
}

fn coordinate() -> impl Strategy<Value = f64> {
    let special = prop::sample::select(vec![-1e9, 1e9, -0.0, 5e-324, -1e-310, 0.1 + 0.2]);
    prop_oneof![-1.0e9..1.0e9, -1.0..1.0, special]
}

fn vector() -> impl Strategy<Value = [f64; 3]> {
    [coordinate(), coordinate(), coordinate()]
}

fn coefficient() -> impl Strategy<Value = f64> {
    prop_oneof![0.0..1e30, 0.0..1.0, Just(0.0), Just(5e-324), Just(1e30)]
}

fn mass() -> impl Strategy<Value = f64> {
    prop_oneof![1e-30..1e30, 1e-30..1.0, Just(1e-30), Just(1e30)]
}

/// Pieces of rising strains, the last without an end.
fn pieces() -> impl Strategy<Value = Vec<PieceSpec>> {
    prop::collection::vec((coefficient(), 1e-3..10.0), 0..4).prop_map(|list| {
        let mut strain = 0.0;
        let last = list.len().saturating_sub(1);
        let piece = |(k, (stiffness_n_per_m, width)): (usize, (f64, f64))| {
            strain += width;
            PieceSpec { up_to_strain: (k < last).then_some(strain), stiffness_n_per_m }
        };
        list.into_iter().enumerate().map(piece).collect()
    })
}

fn spring(n: u32) -> impl Strategy<Value = SpringSpec> {
    let effect = prop::sample::select(SpringEffect::ALL.to_vec());
    let compression = prop::option::of(coefficient());
    let rigidity = prop::option::of(1e-9..1.0);
    let linear = (effect, 0..n, 1..n, 1e-3..1e9, coefficient(), coefficient());
    (linear, pieces(), compression, rigidity).prop_map(
        move |((effect, i, offset, rest_length_m, k, c), pieces, compression, rigidity)| {
            SpringSpec {
                effect,
                i,
                j: (i + offset) % n,
                rest_length_m,
                stiffness_n_per_m: pieces.first().map_or(k, |piece| piece.stiffness_n_per_m),
                damping_n_s_per_m: c,
                pieces: pieces.into(),
                compression_stiffness_n_per_m: compression,
                buckling_rigidity_n_m2: rigidity.filter(|_| effect == SpringEffect::Bending),
            }
        },
    )
}

/// Angles and hinges need three and four different particles: neighbours in the list, from `i` on.
fn stencil(n: u32) -> impl Strategy<Value = (AngleSpec, HingeSpec)> {
    use std::f64::consts::PI;
    let effect = prop::sample::select(AngleEffect::ALL.to_vec());
    (effect, 0..n, 0.0..=PI, -PI..=PI, coefficient(), coefficient()).prop_map(
        move |(effect, i, at_rest, flat, stiffness_n_m, k)| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|offset| (i + offset) % n);
            let angle = AngleSpec { effect, i: a, j: b, k: c, rest_rad: at_rest, stiffness_n_m };
            (angle, HingeSpec { i: a, j: b, k: c, l: d, rest_rad: flat, stiffness_n_m: k })
        },
    )
}

fn air() -> impl Strategy<Value = AirSpec> {
    let start = prop_oneof![Just(0.0), 0.0..1e12];
    let gust = (vector(), 1e-6..1e9, any::<u32>(), start).prop_map(
        |(amplitude_m_s, period_s, seed, start_s)| GustSpec {
            amplitude_m_s,
            period_s,
            seed,
            start_s,
        },
    );
    let wind = (vector(), prop::option::of(gust))
        .prop_map(|(velocity_m_s, gust)| WindSpec { velocity_m_s, gust });
    (any::<bool>(), 0.0..1e9, 0.0..1e9, prop::option::of(wind)).prop_map(
        |(is_linear, coefficient, density_kg_m3, wind)| {
            let drag = if is_linear {
                DragSpec::Linear { coefficient_n_s_per_m3: coefficient }
            } else {
                DragSpec::Quadratic { coefficient, density_kg_m3 }
            };
            AirSpec { drag, wind }
        },
    )
}

/// Keeps paths from these places in range.
fn confine(path: &mut [KeyframeSpec], places: &[[f64; 3]]) {
    for (axis, offset) in path.iter_mut().flat_map(|frame| frame.offset_m.iter_mut().enumerate()) {
        for place in places {
            *offset = offset.clamp(-1e9 - place[axis], 1e9 - place[axis]);
        }
    }
}

/// Keyframes at rising times, up to the bounds of the offsets.
fn path() -> impl Strategy<Value = Vec<KeyframeSpec>> {
    prop::collection::vec((1e-9..1e3, vector()), 0..4).prop_map(|frames| {
        let mut time_s = 0.0;
        let frame = |(later, offset_m): (f64, [f64; 3])| {
            time_s += later;
            KeyframeSpec { time_s, offset_m: offset_m.map(|offset| 2.0 * offset) }
        };
        frames.into_iter().map(frame).collect()
    })
}

/// A tetrahedron.
fn mesh() -> impl Strategy<Value = ObstacleSpec> {
    ([-9.0..9.0, -9.0..9.0, -9.0..9.0], 1e-2..9.0, 0.0..=1.0).prop_map(
        |(corner, edge, restitution)| {
            let along = |axis: usize| {
                let mut vertex = corner;
                vertex[axis] += edge;
                vertex
            };
            ObstacleSpec::Mesh {
                vertices_m: vec![corner, along(0), along(1), along(2)],
                triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
                restitution,
                friction: 0.0,
                path: Vec::new(),
            }
        },
    )
}

fn obstacle() -> impl Strategy<Value = ObstacleSpec> {
    let friction = prop_oneof![Just(0.0), 0.0..=100.0, Just(5e-324)];
    (shape(), friction, path()).prop_map(|(mut obstacle, mu, mut frames)| {
        let (places, friction, path) = match &mut obstacle {
            ObstacleSpec::Plane { point_m: place, friction, path, .. }
            | ObstacleSpec::Box { center_m: place, friction, path, .. }
            | ObstacleSpec::Sphere { center_m: place, friction, path, .. } => {
                (std::slice::from_ref(place), friction, path)
            }
            ObstacleSpec::Mesh { vertices_m, friction, path, .. } => {
                (vertices_m.as_slice(), friction, path)
            }
        };
        confine(&mut frames, places);
        (*friction, *path) = (mu, frames);
        obstacle
    })
}

/// An obstacle at rest, without friction.
fn shape() -> impl Strategy<Value = ObstacleSpec> {
    let size = || 1e-300..1e9;
    prop_oneof![
        mesh(),
        (vector(), vector(), 0.0..=1.0).prop_map(|(point_m, tilt, restitution)| {
            ObstacleSpec::plane(point_m, [tilt[0], tilt[1], 1.0], restitution)
        }),
        (vector(), [size(), size(), size()], 0.0..=1.0).prop_map(
            |(center_m, size_m, restitution)| ObstacleSpec::cuboid(center_m, size_m, restitution)
        ),
        (vector(), size(), 0.0..=1.0).prop_map(|(center_m, radius_m, restitution)| {
            ObstacleSpec::sphere(center_m, radius_m, restitution)
        }),
    ]
}

fn contact() -> impl Strategy<Value = ContactSpec> {
    (any::<bool>(), 0.0..1e9).prop_map(|(speculative, recovery_speed_limit_m_s)| ContactSpec {
        detection: if speculative { Detection::Speculative } else { Detection::Penetration },
        recovery_speed_limit_m_s,
    })
}

fn system() -> impl Strategy<Value = SystemSpec> {
    let particles = (2_usize..20, any::<bool>()).prop_flat_map(|(n, moves)| {
        let velocities = if moves { n } else { 0 };
        (
            prop::collection::vec(mass(), n),
            prop::collection::vec(vector(), n),
            prop::collection::vec(vector(), velocities),
            prop::collection::vec(spring(n as u32), 0..30),
            prop::collection::btree_map(0..n as u32, path(), 0..4),
            prop::collection::vec([0..n as u32, 0..n as u32, 0..n as u32], 0..4),
            prop::collection::vec(stencil(n as u32), 0..if n < 4 { 1 } else { 6 }),
        )
    });
    let rest = (
        any::<String>(),
        any::<bool>(),
        prop::option::of(vector()),
        prop::option::of(air()),
        prop::option::of(contact()),
        prop::collection::vec(obstacle(), 0..4),
    );
    (particles, rest).prop_map(|(particles, (name, full, gravity, air, contact, obstacles))| {
        let (mass_kg, position_m, velocity_m_s, springs, pins, triangles, stencils) = particles;
        let (angles, hinges) = stencils.into_iter().unzip();
        let air = air.filter(|_| !triangles.is_empty());
        let lead = |(particle, mut path): (u32, Vec<KeyframeSpec>)| {
            confine(&mut path, &position_m[particle as usize..][..1]);
            PinSpec { particle, path }
        };
        let pins = pins.into_iter().map(lead).collect();
        SystemSpec {
            format: "drape-system/1".to_owned(),
            name,
            particles: ParticlesSpec { mass_kg, position_m, velocity_m_s },
            springs,
            angles,
            hinges,
            damping: if full { DampingLaw::Full } else { DampingLaw::Projected },
            triangles,
            pins,
            effects: EffectsSpec {
                gravity: gravity.map(|m_s2| GravitySpec { m_s2 }),
                air,
                contact,
            },
            obstacles,
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn random_systems_survive_printing_and_obey_the_schema(spec in system()) {
        assert_survives(&spec);
        let schema = schemars::schema_for!(SystemSpec);
        let value = serde_json::to_value(&spec).unwrap();
        prop_assert!(jsonschema::is_valid(schema.as_value(), &value));
    }

    #[test]
    fn a_system_frozen_mid_run_starts_there(
        spec in system(), shift in vector(), times in prop::collection::vec(0.0..1500.0, 1..4)
    ) {
        let schema = schemars::schema_for!(SystemSpec);
        let mut last = spec.clone();
        for t in times {
            let (system, mut state) = last.build().unwrap();
            state.t = t;
            state.v.fill(shift.into());
            for pin in system.moving_pins() {
                state.x[pin.particle] = pin.position(t);
            }
            let frozen = last.clone().with_state(&state);
            assert_survives(&frozen);
            let value = serde_json::to_value(&frozen).unwrap();
            prop_assert!(jsonschema::is_valid(schema.as_value(), &value));
            let (later, again) = frozen.build().unwrap();
            prop_assert_eq!(&again.v, &state.v);
            for (x, same) in state.x.iter().zip(&again.x) {
                prop_assert!((x - same).amax() <= 1e-15 * x.amax(), "{} m off", (x - same).amax());
            }
            prop_assert_eq!(&frozen.springs, &spec.springs);
            for (one, rest) in system.obstacles().iter().zip(later.obstacles()) {
                let off = one.offset(t) + rest.offset(7.0) - one.offset(t + 7.0);
                prop_assert!(off.amax() <= 1e-5, "{} m", off.amax());
            }
            last = frozen;
        }
    }
}

/// Calls `visit` with a copy of `value` for each object in it, to which an unknown key was added.
fn with_unknown_keys(value: &Value, visit: &mut dyn FnMut(Value, &str)) {
    fn pointers(value: &Value, at: &str, found: &mut Vec<String>) {
        match value {
            Value::Object(map) => {
                found.push(at.to_owned());
                map.iter().for_each(|(key, inner)| pointers(inner, &format!("{at}/{key}"), found));
            }
            Value::Array(list) => {
                for (k, inner) in list.iter().enumerate().take(1) {
                    pointers(inner, &format!("{at}/{k}"), found);
                }
            }
            _ => {}
        }
    }
    let mut found = Vec::new();
    pointers(value, "", &mut found);
    for pointer in found {
        let mut copy = value.clone();
        let object = copy.pointer_mut(&pointer).and_then(Value::as_object_mut).unwrap();
        object.insert("surprise".to_owned(), json!(1));
        visit(copy, &pointer);
    }
}

#[test]
fn schemas_accept_what_the_reader_accepts_and_know_no_other_keys() {
    let scene_schema = schemars::schema_for!(Scene);
    let system_schema = schemars::schema_for!(SystemSpec);
    let scenes = jsonschema::validator_for(scene_schema.as_value()).unwrap();
    let systems = jsonschema::validator_for(system_schema.as_value()).unwrap();
    for name in bundled::names() {
        let scene: Value = serde_json::from_str(bundled::text(name).unwrap()).unwrap();
        let system = serde_json::to_value(load(name).unwrap().spec()).unwrap();
        for (validator, value) in [(&scenes, &scene), (&systems, &system)] {
            let errors: Vec<_> = validator.iter_errors(value).map(|e| e.to_string()).collect();
            assert!(errors.is_empty(), "{name}: {errors:?}");
            with_unknown_keys(value, &mut |broken, pointer| {
                assert!(!validator.is_valid(&broken), "{name}: schema, at {pointer:?}");
                assert!(
                    parse(name, &broken.to_string()).is_err(),
                    "{name}: reader, at {pointer:?}"
                );
            });
        }
    }
}
