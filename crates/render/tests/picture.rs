//! Pictures, pixel by pixel.

#![allow(clippy::unwrap_used, reason = "tests")]

use drape_model::{Obstacle, Shape, Vec3};
use drape_render::{Camera, Colour, Font, Image, Subject, View, draw, obj};

const SIZE: [u32; 2] = [160, 120];

fn sheet(side: u32) -> Vec<Vec3> {
    let at = |n: u32| f64::from(n) / f64::from(side - 1);
    (0..side * side).map(|n| Vec3::new(at(n % side), at(n / side), 0.0)).collect()
}

fn seen(view: &str, x: &[Vec3], obstacles: &[Shape]) -> Image {
    let obstacles: Vec<_> = obstacles.iter().cloned().map(Obstacle::from).collect();
    let subject = Subject::grid(5, 5, &obstacles, x);
    let camera = Camera::fit(view.parse().unwrap(), &subject.points(x), 4.0 / 3.0);
    draw(&subject, x, &camera, SIZE)
}

fn middle(image: &Image) -> [i32; 3] {
    // These points lie beside the lines of the grid.
    image.pixel(SIZE[0] / 2 + 7, SIZE[1] / 2 + 3).unwrap().0.map(i32::from)
}

#[test]
fn the_same_positions_give_the_same_bytes() {
    let x = sheet(5);
    let png = || seen("auto", &x, &[]).png().unwrap();
    assert_eq!(png(), png());
    let decoder = png::Decoder::new(std::io::Cursor::new(png()));
    let info = decoder.read_info().unwrap();
    assert_eq!((info.info().width, info.info().height), (SIZE[0], SIZE[1]));
}

#[test]
fn the_two_sides_of_a_cloth_have_two_colours_before_an_empty_background() {
    let x = sheet(5);
    // Rows run along y here, so that the triangles face down.
    let (top, bottom) = (seen("top", &x, &[]), seen("-90,-90", &x, &[]));
    let [r, _, b] = middle(&top);
    let [other_r, _, other_b] = middle(&bottom);
    assert!((r - b) * (other_r - other_b) < 0, "one is blue, the other one is not");
    for image in [&top, &bottom] {
        assert_eq!(image.pixel(0, 0), Some(Colour::BACKGROUND));
        assert_eq!(image.pixel(SIZE[0], 0), None);
    }
}

#[test]
fn what_is_nearer_hides_what_is_farther_and_cloth_on_a_table_hides_its_top() {
    let x = sheet(5);
    let over = |z: f64| {
        let half_extents = Vec3::new(0.3, 0.3, 0.1);
        [Shape::Box { center: Vec3::new(0.5, 0.5, z), half_extents }]
    };
    let is_grey = |image: &Image| {
        let [r, g, b] = middle(image);
        (r - g).abs() < 12 && (g - b).abs() < 12
    };
    assert!(is_grey(&seen("top", &x, &over(0.5))), "the box is above the cloth");
    assert!(!is_grey(&seen("top", &x, &over(-0.5))), "the cloth is above the box");
    assert!(!is_grey(&seen("top", &x, &over(-0.1))), "the cloth lies on the box");
}

#[test]
fn pins_are_dots_and_a_ground_carries_a_shadow_seen_from_above_alone() {
    let x = sheet(5);
    let bare = Subject::grid(5, 5, &[], &x);
    let points = bare.points(&x);
    let camera = Camera::fit(View::default(), &points, 4.0 / 3.0);
    let count = |image: &Image, other: &Image| {
        let places = (0..SIZE[0]).flat_map(|x| (0..SIZE[1]).map(move |y| (x, y)));
        places.filter(|&(x, y)| image.pixel(x, y) != other.pixel(x, y)).count()
    };
    let plain = draw(&bare, &x, &camera, SIZE);
    let pinned = Subject { pins: vec![0, 4], ..bare.clone() };
    let changed = count(&draw(&pinned, &x, &camera, SIZE), &plain);
    assert!((60..200).contains(&changed), "two dots of four pixels' radius: {changed}");
    for (view, sees) in [("auto", true), ("-62,-24", false)] {
        let (grounded, points) = bare.clone().on_ground(points.clone());
        let camera = Camera::fit(view.parse().unwrap(), &points, 4.0 / 3.0);
        let [with, without] = [&grounded, &bare].map(|subject| draw(subject, &x, &camera, SIZE));
        assert_eq!(count(&with, &without) > 1000, sees, "{view}");
    }
    let plane = Shape::Plane { point: Vec3::zeros(), normal: Vec3::z() };
    let on_plane = Subject::grid(5, 5, &[plane.into()], &x);
    assert_eq!(on_plane.on_ground(points).0.ground, None, "a plane is its ground");
}

#[test]
fn particles_that_are_anywhere_or_nowhere_do_no_harm() {
    let plane = Shape::Plane { point: Vec3::zeros(), normal: Vec3::z() };
    let good = sheet(5);
    let subject = Subject::grid(5, 5, &[plane.into()], &good);
    let camera = Camera::fit(View::default(), &subject.points(&good), 4.0 / 3.0);
    let mut random = 1_u64;
    for scale in [1.0, 10.0, 1e3, 1e5, 1e20, 1e38, 1e300, f64::INFINITY] {
        for _ in 0..20 {
            let mut number = || {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (random >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
            };
            let x: Vec<Vec3> =
                good.iter().map(|x| x + Vec3::new(number(), number(), number()) * scale).collect();
            let image = draw(&subject, &x, &camera, SIZE);
            assert_eq!((image.width(), image.height()), (SIZE[0], SIZE[1]));
            let _ = Camera::fit(View::default(), &subject.points(&x), 1.0);
        }
    }
}

#[test]
fn a_failure_says_why_and_text_may_reach_beyond_the_picture() {
    let image = Image::failure([120, 60], "diverged");
    let alarm = |x: u32, y: u32| image.pixel(x, y) == Some(Colour::ALARM);
    assert!((0..120).any(|x| (0..60).any(|y| alarm(x, y))));
    let mut image = Image::new(20, 20);
    image.write("far too long, ℓ", 10, 15, Font::Heading, Colour::INK);
    image.paste(&Image::new(40, 40), 10, 10);
    assert!(Image::new(0, 10).png().is_err());
}

#[test]
fn an_obj_file_reads_back_to_the_same_bits() {
    let mut x = sheet(3);
    x[4] = Vec3::new(0.1 + 0.2, 1e-17 / 3.0, -1e9 / 7.0);
    let ball = Shape::Sphere { center: Vec3::zeros(), radius: 1.0 };
    let table = Shape::Box { center: Vec3::zeros(), half_extents: Vec3::repeat(1.0) };
    let subject = Subject::grid(3, 3, &[table.into(), ball.into()], &x);
    let text = obj::cloth(&subject, &x);
    let read: Vec<f64> = text
        .lines()
        .filter_map(|line| line.strip_prefix("v "))
        .flat_map(|line| line.split(' ').map(|number| number.parse().unwrap()))
        .collect();
    let bits = |numbers: &[f64]| numbers.iter().map(|n| n.to_bits()).collect::<Vec<_>>();
    let written: Vec<f64> = x.iter().flat_map(|x| [x.x, x.y, x.z]).collect();
    assert_eq!(bits(&read), bits(&written));
    assert_eq!(text.lines().filter(|line| line.starts_with("f ")).count(), 8);

    // Indices of the second object continue those of the first.
    let text = obj::solids(&subject.solids);
    let vertices = text.lines().filter(|line| line.starts_with("v ")).count();
    let faces = text.lines().filter_map(|line| line.strip_prefix("f "));
    let corners: Vec<usize> =
        faces.flat_map(|line| line.split(' ').map(|i| i.parse().unwrap())).collect();
    assert_eq!(corners.iter().max(), Some(&vertices));
    assert_eq!(corners.iter().min(), Some(&1));

    let springs = Subject { lines: vec![[0, 2]], ..Subject::default() };
    assert!(obj::cloth(&springs, &x).ends_with("l 1 3\n"));
}
