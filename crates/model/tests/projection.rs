//! Shadows against closed forms.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{Vec3, drape_coefficient, load, projected_area};
use std::f64::consts::PI;

/// Places and triangles of the disc of the drape test.
fn disc() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let input = load("drape-test").unwrap();
    let x = input.spec().particles.position_m.iter().map(|&x| Vec3::from(x)).collect();
    (x, input.spec().triangles.clone())
}

/// Area of a polygon of `n` corners on a circle.
fn polygon(n: f64, radius: f64) -> f64 {
    0.5 * n * radius * radius * libm::sin(2.0 * PI / n)
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    let off = (found / expected - 1.0).abs();
    assert!(off <= tolerance, "{found}, expected {expected}: off by {off:e}");
}

#[test]
fn the_shadow_of_a_flat_disc_is_the_disc() {
    let (x, triangles) = disc();
    // Vertices are rounded to a micrometre.
    let area = projected_area(&x, &triangles);
    assert_near(area, polygon(90.0, 0.15), 1e-5);
    let support = PI * 0.09 * 0.09;
    assert_eq!(drape_coefficient(area, support, area), 1.0);
    assert_eq!(drape_coefficient(support, support, area), 0.0);
}

#[test]
fn a_tilted_disc_throws_a_shadow_shorter_by_the_cosine() {
    let (mut x, triangles) = disc();
    let (sine, cosine) = (libm::sin(1.0), libm::cos(1.0));
    for x in &mut x {
        *x = Vec3::new(cosine * x.x + 0.3, x.y - 2.0, sine * x.x);
    }
    assert_near(projected_area(&x, &triangles), polygon(90.0, 0.15) * cosine, 1e-5);
}

#[test]
fn what_lies_twice_in_the_light_throws_one_shadow() {
    // Two squares that overlap in a quarter, and one below both, turned over.
    let square = |x: f64, y: f64, z: f64| {
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(a, b)| Vec3::new(x + a, y + b, z))
    };
    let x = [square(0.0, 0.0, 1.0), square(0.5, 0.5, 2.0), square(0.25, 0.25, -1.0)].concat();
    let halves = |s: u32| [[4 * s, 4 * s + 1, 4 * s + 2], [4 * s, 4 * s + 2, 4 * s + 3]];
    let [a, b, c] = [0, 1, 2].map(halves);
    let turned = c.map(|[a, b, c]| [a, c, b]);
    assert_near(projected_area(&x, &[a, b].concat()), 1.75, 1e-3);
    // The third square reaches beyond the two by two squares of a quarter of a metre, at the inner
    // corners.
    assert_near(projected_area(&x, &[a, b, turned].concat()), 1.75 + 2.0 / 16.0, 1e-3);
}

#[test]
fn a_skirt_throws_the_shadow_of_a_ring() {
    let input = load("skirt").unwrap();
    let x: Vec<_> = input.spec().particles.position_m.iter().map(|&x| Vec3::from(x)).collect();
    let expected = polygon(48.0, 0.28) - polygon(48.0, 0.12);
    assert_near(projected_area(&x, &input.spec().triangles), expected, 1e-4);
}

#[test]
fn nothing_throws_no_shadow() {
    assert_eq!(projected_area(&[], &[]), 0.0);
    let edge_on = [Vec3::zeros(), Vec3::x(), Vec3::z()];
    assert_eq!(projected_area(&edge_on, &[[0, 1, 2]]), 0.0);
    let x = [Vec3::zeros(), Vec3::y(), Vec3::z()];
    assert_eq!(projected_area(&x, &[[0, 1, 2]]), 0.0);
    let broken = [Vec3::zeros(), Vec3::y() * f64::NAN, Vec3::x() * f64::INFINITY];
    assert!(!projected_area(&broken, &[[0, 1, 2]]).is_sign_negative());
}
