//! What a method cannot honour is refused by name, before anything runs.

use drape_harness::methods;
use drape_integrator::{Method, Order, PrepareError, Quantity, StabilityClass, Supports};
use drape_model::{
    AirSpec, AngleEffect, AngleSpec, DragSpec, HingeSpec, ObstacleSpec, SpringEffect, System, Vec3,
};
use drape_tests::{Sheet, build, bundled, floor, gravity, method, particles, pin, seconds, spring};

/// Everything that a system can have.
const KNOWN: [&str; 10] = [
    "tension",
    "shear",
    "bending",
    "shear_angle",
    "bending_angle",
    "bending_hinge",
    "gravity",
    "air",
    "pins",
    "contact",
];

/// A method that supports everything but what is named.
fn all_but(missing: &'static str) -> Method {
    Method {
        id: "choosy",
        name: "a choosy method",
        source: "",
        order: Order::One,
        class: StabilityClass::Dissipative,
        conserves: &[Quantity::Momentum],
        theory: "",
        supports: Supports::Explicit,
        refuses: vec![missing].leak(),
        settings: &[],
    }
}

/// A system that has exactly one of the things that are known.
fn with(what: &str) -> System {
    let positions = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::new(1.0, 1.0, 0.0)];
    let mut spec = particles(&[1.0; 4], &positions, &[]);
    for effect in SpringEffect::ALL.into_iter().filter(|effect| effect.name() == what) {
        spec.springs = vec![spring(effect, (0, 1), 1.0, 10.0, 0.0)];
    }
    for effect in AngleEffect::ALL.into_iter().filter(|effect| effect.name() == what) {
        let (rest_rad, stiffness_n_m) = (std::f64::consts::PI, 0.1);
        spec.angles = vec![AngleSpec { effect, i: 0, j: 1, k: 2, rest_rad, stiffness_n_m }];
    }
    match what {
        "bending_hinge" => {
            let (rest_rad, stiffness_n_m) = (0.0, 0.1);
            spec.hinges = vec![HingeSpec { i: 1, j: 2, k: 0, l: 3, rest_rad, stiffness_n_m }];
        }
        "air" => {
            spec.triangles = vec![[0, 1, 2]];
            let drag = DragSpec::Linear { coefficient_n_s_per_m3: 1.0 };
            spec.effects.air = Some(AirSpec { drag, wind: None });
        }
        "gravity" => spec.effects.gravity = gravity(),
        "pins" => spec.pins = vec![pin(0)],
        "contact" => spec.obstacles = vec![floor(0.0)],
        "friction" => {
            let (point_m, normal, path) = ([0.0; 3], Vec3::z().into(), Vec::new());
            let rough =
                ObstacleSpec::Plane { point_m, normal, restitution: 0.0, friction: 0.5, path };
            spec.obstacles = vec![rough];
        }
        _ => {}
    }
    build(&spec).0
}

#[test]
fn a_system_with_something_that_a_method_does_not_support_is_refused_by_its_name() {
    for missing in KNOWN {
        let choosy = all_but(missing);
        for what in KNOWN {
            match choosy.check(&with(what)) {
                Ok(()) => assert_ne!(what, missing, "{missing} passes"),
                Err(error) => {
                    assert_eq!(what, missing, "{error}");
                    let named = matches!(&error, PrepareError::Unsupported { method: "choosy", what, .. }
                        if what == missing);
                    let key = match missing {
                        "pins" => "pins".to_owned(),
                        "contact" => "obstacles".to_owned(),
                        effect => format!("effects.{effect}"),
                    };
                    let text = error.to_string();
                    assert!(named && text.contains("choosy") && text.contains(missing), "{text}");
                    assert!(text.starts_with(&format!("`{key}`: ")), "{text}");
                }
            }
        }
    }
}

/// What each method refuses; the others take everything. Tests over all methods leave out what
/// stands here, and nothing else.
const REFUSED: [(&str, &[&str]); 6] = [
    ("energy-momentum", &["shear_angle", "bending_angle", "bending_hinge", "projected damping"]),
    ("exponential", &["contact", "friction", "moving pins"]),
    ("imex-cnlf", &["friction"]),
    ("imex-rk", &["contact", "friction", "moving pins", "moving obstacles"]),
    ("rosenbrock", &["contact", "friction", "moving pins", "moving obstacles"]),
    ("srkn4", &["air", "contact", "friction", "moving pins", "moving obstacles"]),
];

/// What the other test leaves out of the list of what is known is no effect of any system.
#[test]
fn methods_take_everything_that_a_system_can_have_but_what_they_refuse_by_name() {
    let (sheared, _) = bundled("hanging-textile-sheared-1e6");
    for what in KNOWN {
        let system = with(what);
        let mut effects = system.effects().chain(sheared.effects());
        assert!(effects.all(|effect| KNOWN.contains(&effect.name())), "{what}");
    }
    for method in methods::all() {
        let refused = REFUSED.iter().find(|(id, _)| *id == method.id).map_or(&[][..], |(_, r)| r);
        assert_eq!(method.refuses, refused, "{}", method.id);
        for what in KNOWN.into_iter().chain(["friction"]) {
            let times = method.supports().filter(|support| support.effect == what).count();
            match method.check(&with(what)) {
                Ok(()) => assert_eq!(times, 1, "{}: {what}", method.id),
                Err(PrepareError::Unsupported { method: id, what: named, key }) => {
                    // An obstacle with friction is refused as an obstacle, if that is refused.
                    let is_named =
                        refused.contains(&&*named) && (named == what || named == "contact");
                    assert!(is_named && times == 0, "{}: {what}, {named}", method.id);
                    assert!(id == method.id && !key.is_empty(), "{id}: {key}");
                }
                Err(error) => panic!("{error}"),
            }
        }
        let known = KNOWN.iter().chain(&["friction"]).filter(|what| !refused.contains(*what));
        assert_eq!(method.supports().count(), known.count(), "{}", method.id);
    }
}

#[test]
fn a_dense_inverse_beyond_its_limit_is_refused_with_its_size() {
    let (system, _) = Sheet { side: 52, tension: 1e4, shear: 0.0, ..Sheet::default() }.build();
    let entries = 8 * (52_u64 * 52).pow(2);
    let mut integrator = method("desbrun:inverse=dense,memory_limit_mib=1");
    let error = integrator.prepare(&system, seconds(0.01)).expect_err("too large");
    let PrepareError::TooLarge { bytes, limit } = error else { panic!("{error}") };
    assert_eq!(limit, 1 << 20);
    assert!(bytes >= entries && bytes < 4 * entries, "{bytes}");
    let text = error.to_string();
    for number in [bytes.to_string(), limit.to_string()] {
        assert!(text.contains(&number), "{text}");
    }
    // The size in the message is the limit to ask for.
    let mib = bytes.div_ceil(1 << 20);
    for (limit, fits) in [(mib - 1, false), (mib, true)] {
        let mut integrator = method(&format!("desbrun:inverse=dense,memory_limit_mib={limit}"));
        let outcome = integrator.prepare(&system, seconds(0.01));
        assert_eq!(outcome.is_ok(), fits, "{limit} of {mib} MiB: {outcome:?}");
    }
}
