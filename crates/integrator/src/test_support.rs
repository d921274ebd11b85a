//! Systems for the tests.

use drape_model::{State, System, Vec3, parse};

/// Particles at rest at `x`, and springs (i, j, stiffness, rest length) of one effect between them.
pub(crate) fn net(
    effect: &str,
    mass: &[f64],
    x: &[Vec3],
    springs: &[(usize, usize, f64, f64)],
    pinned: &[usize],
) -> (System, State) {
    let spring = |(i, j, k, rest): &(usize, usize, f64, f64)| {
        format!(
            r#"{{ "effect": "{effect}", "i": {i}, "j": {j}, "rest_length_m": {rest},
            "stiffness_n_per_m": {k} }}"#
        )
    };
    let springs: Vec<_> = springs.iter().map(spring).collect();
    let pins: Vec<_> = pinned.iter().map(|i| format!(r#"{{ "particle": {i} }}"#)).collect();
    let position: Vec<[f64; 3]> = x.iter().map(|&x| x.into()).collect();
    let text = format!(
        r#"{{ "format": "drape-system/1", "springs": [{}], "pins": [{}],
        "particles": {{ "mass_kg": {mass:?}, "position_m": {position:?} }} }}"#,
        springs.join(","),
        pins.join(",")
    );
    parse("test", &text).expect("valid").spec().build().expect("valid")
}
