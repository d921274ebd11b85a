//! A level ground below a scene, with the shadow of the scene.

use crate::subject::bounds;
use drape_model::Vec3;

/// Distance between the ground and the lowest point, over the size of the scene.
const GAP: f64 = 0.04;
/// Half the ground's sides over the sides of the scene's box, and at least over the box's diagonal.
const REACH: [f64; 2] = [0.8, 0.45];
/// Cells of the ground along each side.
const CELLS: usize = 128;
/// Number of cells to each side over which a blur takes the mean. Three blurs give a soft rim.
const BLUR: usize = 3;
const BLURS: usize = 3;
/// Share of the light that the ground takes away, and that a full shadow on it takes away.
const GREY: f64 = 0.06;
const DARK: f64 = 0.34;
/// Part of each side of the ground that lies below the scene's box.
const BELOW: f64 = 0.5 / REACH[0];
/// Distance from the middle from which the ground fades into the background; it is 1 at the rim.
/// Curves of equal distance are squares with round corners, so that nothing fades below the box.
const FADE: f64 = 0.75;

/// A level ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Height, m.
    height: f64,
    /// Its middle in x and y, and half its sides, m.
    middle: [f64; 2],
    half: [f64; 2],
}

/// A ground with its shadow, ready to be drawn.
pub(crate) struct Shadow {
    /// Corners, row by row, m.
    pub(crate) points: Vec<Vec3>,
    /// Share of the background's light at each corner.
    pub(crate) light: Vec<f64>,
}

impl Ground {
    /// The ground below these points, m; `None` if no point has finite coordinates.
    pub fn under(points: &[Vec3]) -> Option<Self> {
        let is_finite = |x: &&Vec3| x.iter().all(|c| c.is_finite());
        let points: Vec<Vec3> = points.iter().filter(is_finite).copied().collect();
        if points.is_empty() {
            return None;
        }
        let (low, high) = bounds(&points);
        let size = (high - low).norm();
        let half = [0, 1].map(|n| (REACH[0] * (high[n] - low[n])).max(REACH[1] * size));
        let middle = [0, 1].map(|n| 0.5 * (low[n] + high[n]));
        Some(Self { height: low.z - GAP * size, middle, half })
    }

    /// Height, m.
    pub fn height(&self) -> f64 {
        self.height
    }

    /// The corners, m, of the part that a picture must show, on which a shadow can lie. The ground
    /// fades beyond it.
    pub fn points(&self) -> [Vec3; 4] {
        let at = |x: f64, y: f64| self.at(BELOW * x, BELOW * y);
        [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]
    }

    /// The point of the ground at `x` and `y`, which run from −1 to 1.
    fn at(&self, x: f64, y: f64) -> Vec3 {
        let [a, b] = self.middle;
        Vec3::new(a + x * self.half[0], b + y * self.half[1], self.height)
    }

    /// Number of a cell along an axis, as a fraction, also beyond the ground.
    fn cell(&self, axis: usize, x: f64) -> f64 {
        0.5 * ((x - self.middle[axis]) / self.half[axis] + 1.0) * CELLS as f64
    }

    /// The ground in the light from above, with the shadow of triangles and lines.
    pub(crate) fn shadow<'a>(
        &self,
        triangles: impl Iterator<Item = [&'a Vec3; 3]>,
        lines: impl Iterator<Item = [&'a Vec3; 2]>,
    ) -> Shadow {
        let mut cover = vec![0.0; CELLS * CELLS];
        triangles.for_each(|corners| self.cover(&mut cover, &corners));
        lines.for_each(|ends| self.cover(&mut cover, &ends));
        for _ in 0..BLURS {
            cover = blurred(&blurred(&cover));
        }
        let side = CELLS + 1;
        let (mut points, mut light) = (Vec::new(), Vec::new());
        for n in 0..side * side {
            let at = |k: usize| 2.0 * k as f64 / CELLS as f64 - 1.0;
            let (x, y) = (at(n % side), at(n / side));
            // The mean of the cells around a corner.
            let around = |k: usize| k.saturating_sub(1)..(k + 1).min(CELLS);
            let cells =
                around(n / side).flat_map(|row| around(n % side).map(move |column| (row, column)));
            let covers: Vec<f64> = cells.map(|(row, column)| cover[row * CELLS + column]).collect();
            let mean = covers.iter().sum::<f64>() / covers.len() as f64;
            let distance = (x * x).hypot(y * y).sqrt();
            let far = ((distance - FADE) / (1.0 - FADE)).clamp(0.0, 1.0);
            let near = 1.0 - far * far * (3.0 - 2.0 * far);
            points.push(self.at(x, y));
            light.push(1.0 - near * (GREY + DARK * mean));
        }
        Shadow { points, light }
    }

    /// Covers the cells below a triangle or a line.
    fn cover(&self, cover: &mut [f64], corners: &[&Vec3]) {
        let places: Vec<[f64; 2]> =
            corners.iter().map(|x| [0, 1].map(|axis| self.cell(axis, x[axis]))).collect();
        let range = |axis: usize| {
            let along = || places.iter().map(|place| place[axis]);
            let (low, high) =
                along().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
            // Leave out shapes that are not finite or lie beside the ground.
            let is_above = low.is_finite() && high >= 0.0 && low < CELLS as f64;
            is_above.then(|| low.max(0.0) as usize..(high.min(CELLS as f64 - 1.0) as usize + 1))
        };
        let (Some(columns), Some(rows)) = (range(0), range(1)) else { return };
        // A cell is below a triangle if its middle is. A narrow triangle still covers the cells of
        // its edges.
        for (n, &from) in places.iter().enumerate() {
            let to = places[(n + 1) % places.len()];
            let steps = (to[0] - from[0]).abs().max((to[1] - from[1]).abs()).ceil();
            if !(0.0..=4.0 * CELLS as f64).contains(&steps) {
                continue;
            }
            for step in 0..=steps as usize {
                let part = step as f64 / steps.max(1.0);
                let [x, y] = [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]));
                let inside = 0.0..CELLS as f64;
                if inside.contains(&x) && inside.contains(&y) {
                    cover[y as usize * CELLS + x as usize] = 1.0;
                }
            }
        }
        let [a, b, c] = places[..] else { return };
        for row in rows {
            for column in columns.clone() {
                let middle = [column as f64 + 0.5, row as f64 + 0.5];
                let turn = |from: [f64; 2], to: [f64; 2]| {
                    (to[0] - from[0]) * (middle[1] - from[1])
                        - (to[1] - from[1]) * (middle[0] - from[0])
                };
                let turns = [turn(a, b), turn(b, c), turn(c, a)];
                if turns.iter().all(|t| *t >= 0.0) || turns.iter().all(|t| *t <= 0.0) {
                    cover[row * CELLS + column] = 1.0;
                }
            }
        }
    }
}

/// Means along the rows. The result is transposed, so that the next blur runs along the columns.
fn blurred(cover: &[f64]) -> Vec<f64> {
    let mut turned = vec![0.0; cover.len()];
    for row in 0..CELLS {
        for column in 0..CELLS {
            let around = column.saturating_sub(BLUR)..(column + BLUR + 1).min(CELLS);
            let sum: f64 = around.map(|k| cover[row * CELLS + k]).sum();
            turned[column * CELLS + row] = sum / (2 * BLUR + 1) as f64;
        }
    }
    turned
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    /// Light at the corner of the ground that is nearest to a place.
    fn light(shadow: &Shadow, x: f64, y: f64) -> f64 {
        let place = Vec3::new(x, y, shadow.points[0].z);
        let distance = |p: &Vec3| (p - place).norm();
        let all = shadow.points.iter().zip(&shadow.light);
        *all.min_by(|(a, _), (b, _)| distance(a).total_cmp(&distance(b))).unwrap().1
    }

    #[test]
    fn a_shadow_lies_below_what_casts_it_and_nowhere_else() {
        let corners = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.2], [0.0, 1.0, 1.0], [4.0, 4.0, 2.0]];
        let points = corners.map(Vec3::from);
        let ground = Ground::under(&points).unwrap();
        assert!(ground.height() < 1.0);
        let [a, b, c, _] = &points;
        let shadow = ground.shadow([[a, b, c]].into_iter(), std::iter::empty());
        let (below, beside) = (light(&shadow, 0.3, 0.3), light(&shadow, 2.5, 2.5));
        assert!(below < 1.0 - GREY - 0.4 * DARK, "{below}");
        assert!((beside - (1.0 - GREY)).abs() < 1e-3, "{beside}");
        // The rim has the light of the background, so that no edge of the ground is visible.
        let side = CELLS + 1;
        for n in 0..side {
            for rim in [n, n * side, n * side + CELLS, CELLS * side + n] {
                assert_eq!(shadow.light[rim], 1.0);
            }
        }
        let line = ground.shadow(std::iter::empty(), [[a, b]].into_iter());
        let (at, off) = (light(&line, 0.5, 0.0), light(&line, 0.5, 1.5));
        assert!(at < off - 0.02, "a line casts a shadow, too: {at} and {off}");
    }

    #[test]
    fn there_is_no_ground_below_nothing_and_none_of_its_cells_is_out_of_bounds() {
        let nan = Vec3::repeat(f64::NAN);
        assert_eq!(Ground::under(&[]), None);
        assert_eq!(Ground::under(&[nan]), None);
        let ground = Ground::under(&[Vec3::zeros(), nan, Vec3::x()]).unwrap();
        for scale in [0.0, 1.0, 1e3, 1e20, 1e300, f64::INFINITY] {
            let far = Vec3::new(scale, -scale, 0.0);
            let zero = Vec3::zeros();
            let triangles = [[&zero, &far, &nan], [&far, &zero, &far]].into_iter();
            let shadow = ground.shadow(triangles, [[&zero, &far]].into_iter());
            assert!(shadow.light.iter().all(|light| (0.0..=1.0).contains(light)));
        }
        let point = Ground::under(&[Vec3::zeros()]).unwrap();
        let shadow = point.shadow(std::iter::empty(), std::iter::empty());
        assert!(shadow.light.iter().all(|light| light.is_finite()));
    }
}
