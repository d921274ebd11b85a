//! The shadow of a cloth under a light from above, and its drape coefficient.

use crate::Vec3;

/// Lines along x on which the shadow is measured.
const LINES: u32 = 4000;

/// Area of the union of all triangles as seen along z, m².
///
/// The function measures the shadow on 4000 lines along x, each in the middle of a strip, and is
/// exact on each line. The area of a disc has a relative error of 1e-5. Where the outline runs
/// along x, the error is at most half the width of a strip: 1/8000 of the extent along y, times the
/// length of that piece.
///
/// Memory is proportional to the number of triangles, time to the number of crossings of triangles
/// and lines.
///
/// # Panics
/// If a triangle names a particle that is not in `x`.
pub fn projected_area(x: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
    let corners = |triangle: &[u32; 3]| triangle.map(|i| x[i as usize]);
    let all = triangles.iter().flat_map(corners).map(|x| x.y);
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), widen);
    let strip = (high - low) / f64::from(LINES);
    if !(strip > 0.0 && strip.is_finite()) {
        return 0.0;
    }
    // First and last line of each triangle that meets one, by first line.
    let mut waiting: Vec<(u32, u32, u32)> = Vec::new();
    for (triangle, place) in triangles.iter().zip(0..) {
        let (first, last) = corners(triangle).iter().map(|x| x.y).fold((high, low), widen);
        let first = ((first - low) / strip - 0.5).ceil().max(0.0) as u32;
        let last = ((last - low) / strip - 0.5).floor();
        if last >= f64::from(first) {
            waiting.push((first, (last as u32).min(LINES - 1), place));
        }
    }
    waiting.sort_unstable();
    let mut waiting = waiting.into_iter().peekable();
    let mut crossed: Vec<(u32, u32, u32)> = Vec::new();
    let mut covered = Vec::new();
    let mut length = 0.0;
    for line in 0..LINES {
        crossed.retain(|&(_, last, _)| last >= line);
        while let Some(triangle) = waiting.next_if(|&(first, ..)| first <= line) {
            crossed.push(triangle);
        }
        let y = low + (f64::from(line) + 0.5) * strip;
        covered.clear();
        for &(_, _, place) in &crossed {
            let (from, to) = crossing(&corners(&triangles[place as usize]), y);
            if from < to {
                covered.push((from, to, place));
            }
        }
        covered.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        let mut reached = f64::NEG_INFINITY;
        for &(from, to, _) in &covered {
            length += (to - from.max(reached)).max(0.0);
            reached = reached.max(to);
        }
    }
    length * strip
}

fn widen((low, high): (f64, f64), value: f64) -> (f64, f64) {
    (low.min(value), high.max(value))
}

/// The part of the line at `y` that a triangle covers; from infinity to minus infinity if none.
fn crossing(corners: &[Vec3; 3], y: f64) -> (f64, f64) {
    let mut ends = (f64::INFINITY, f64::NEG_INFINITY);
    for side in 0..3 {
        let (a, b) = (corners[side], corners[(side + 1) % 3]);
        if (a.y <= y) != (b.y <= y) {
            ends = widen(ends, a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x));
        }
    }
    ends
}

/// Drape coefficient after Cusick (1965, "The dependence of fabric drape on bending and shear
/// stiffness", Journal of the Textile Institute 56, T596): the share of the overhang that the
/// shadow covers. It is 1 for a cloth that does not bend and 0 for one that hangs straight down.
/// The arguments are areas, m²: of the shadow, of the disc that supports the specimen, and of the
/// specimen.
pub fn drape_coefficient(shadow: f64, support: f64, specimen: f64) -> f64 {
    (shadow - support) / (specimen - support)
}
