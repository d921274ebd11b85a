//! Views and cameras.

use drape_model::Vec3;
use std::str::FromStr;

/// Tangent of half the angle of view along the shorter side.
const HALF_ANGLE_TANGENT: f64 = 0.22;
/// Part of the picture that the scene fills.
const FILL: f64 = 0.9;
/// Iterations of fitting. Each moves the centre to the middle of the visible points.
const FITS: usize = 8;

/// A direction to look from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Angle from the x-axis towards the y-axis, degrees.
    pub azimuth_deg: f64,
    /// Angle above the horizon, degrees.
    pub elevation_deg: f64,
}

/// Views with a name.
const NAMED: [(&str, View); 4] = [
    ("auto", View { azimuth_deg: -62.0, elevation_deg: 24.0 }),
    ("front", View { azimuth_deg: -90.0, elevation_deg: 0.0 }),
    ("side", View { azimuth_deg: 0.0, elevation_deg: 0.0 }),
    ("top", View { azimuth_deg: -90.0, elevation_deg: 90.0 }),
];

impl Default for View {
    fn default() -> Self {
        NAMED[0].1
    }
}

/// A view that does not exist.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("auto, front, side, top, or AZIMUTH,ELEVATION in degrees with an elevation from -90 to 90")]
pub struct UnknownView;

impl FromStr for View {
    type Err = UnknownView;

    fn from_str(text: &str) -> Result<Self, UnknownView> {
        if let Some((_, view)) = NAMED.iter().find(|(name, _)| *name == text) {
            return Ok(*view);
        }
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|n| n.abs() <= 360.0);
        let (azimuth, elevation) = text.split_once(',').ok_or(UnknownView)?;
        match (number(azimuth), number(elevation)) {
            (Some(azimuth_deg), Some(elevation_deg)) if elevation_deg.abs() <= 90.0 => {
                Ok(Self { azimuth_deg, elevation_deg })
            }
            _ => Err(UnknownView),
        }
    }
}

/// A camera that shows all of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    right: Vec3,
    up: Vec3,
    /// Unit vector towards the eye.
    back: Vec3,
    eye: Vec3,
    /// Tangents of half the angles of view, horizontally and vertically.
    tangents: [f64; 2],
    /// Distance from the eye to the middle of the scene, m.
    distance: f64,
}

impl Camera {
    /// A camera that looks at points, m, so that all of them are in the picture. `aspect` is the
    /// width of the picture over its height.
    pub fn fit(view: View, points: &[Vec3], aspect: f64) -> Self {
        let radians = std::f64::consts::PI / 180.0;
        let (sin_a, cos_a) = libm::sincos(view.azimuth_deg * radians);
        let (sin_e, cos_e) = libm::sincos(view.elevation_deg * radians);
        let back = Vec3::new(cos_a * cos_e, sin_a * cos_e, sin_e);
        let right = Vec3::new(-sin_a, cos_a, 0.0);
        let up = back.cross(&right);
        let tangents = [HALF_ANGLE_TANGENT * aspect.max(1.0), HALF_ANGLE_TANGENT / aspect.min(1.0)];
        let (low, high) = crate::subject::bounds(points);
        let mut center = (low + high) * 0.5;
        // A point at x to the right of the centre, and z nearer to the eye than it, is in the
        // picture if |x| ≤ (d − z) tan.
        let least_distance = |center: Vec3| {
            let mut distance = 0.0_f64;
            for point in points {
                let r = point - center;
                for (axis, tangent) in [right, up].iter().zip(tangents) {
                    distance = distance.max(r.dot(axis).abs() / (FILL * tangent) + r.dot(&back));
                }
            }
            distance
        };
        for _ in 0..FITS {
            let distance = least_distance(center);
            let from = center;
            for axis in [right, up] {
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                for point in points {
                    let r = point - from;
                    let seen = r.dot(&axis) / (distance - r.dot(&back)).max(1e-3 * distance);
                    (low, high) = (low.min(seen), high.max(seen));
                }
                let middle = 0.5 * (low + high) * distance;
                if middle.is_finite() {
                    center += axis * middle;
                }
            }
        }
        let distance = least_distance(center);
        let is_usable = distance > 0.0 && distance.is_finite();
        let distance = if is_usable { distance } else { 1.0 };
        Self { right, up, back, eye: center + back * distance, tangents, distance }
    }

    /// Projects a point to `[x, y, z, w]`. `x/w` runs from −1 at the left of the picture to 1 at
    /// the right, `y/w` from −1 at the top to 1 at the bottom. `w` is the distance from the eye
    /// along the view direction, m. `|z| ≤ w` between a tenth and ten times the distance of the
    /// scene.
    pub(crate) fn project(&self, point: &Vec3) -> [f64; 4] {
        let r = point - self.eye;
        let depth = -r.dot(&self.back);
        let (near, far) = (0.1 * self.distance, 10.0 * self.distance);
        let z = (depth * (far + near) - 2.0 * far * near) / (far - near);
        [r.dot(&self.right) / self.tangents[0], -r.dot(&self.up) / self.tangents[1], z, depth]
    }

    /// Unit vector from a point to the eye.
    pub(crate) fn towards_eye(&self, point: &Vec3) -> Vec3 {
        let r = self.eye - point;
        let length = r.norm();
        if length > 0.0 { r / length } else { self.back }
    }

    /// Unit vectors to the two lights: the key light at the upper left, and the fill light at the
    /// right. Both are in front of the scene.
    pub(crate) fn lights(&self) -> [Vec3; 2] {
        let key = self.up * 0.75 - self.right * 0.55 + self.back * 0.45;
        let fill = self.up * 0.2 + self.right * 0.9 + self.back * 0.4;
        [key, fill].map(|light| light.normalize())
    }

    /// Whether the eye is above a height, m.
    pub(crate) fn is_above(&self, height: f64) -> bool {
        self.eye.z > height
    }

    /// Distance from the eye to the middle of the scene, m.
    pub(crate) fn distance(&self) -> f64 {
        self.distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_points_are_in_the_picture_and_fill_it_from_every_side() {
        let points =
            [[0.0, 0.0, 0.0], [2.0, 0.1, 0.3], [0.5, -1.0, 4.0], [-0.3, 0.2, -1.0]].map(Vec3::from);
        for aspect in [0.5, 1.0, 1.6] {
            for view in ["auto", "front", "side", "top", "30,-40", "-120, 89"] {
                let camera = Camera::fit(view.parse().expect("valid"), &points, aspect);
                let mut reach: f64 = 0.0;
                for point in &points {
                    let [x, y, z, w] = camera.project(point);
                    assert!(w > 0.0 && x.abs() <= w && y.abs() <= w && z.abs() <= w, "{view}");
                    reach = reach.max(x.abs() / w).max(y.abs() / w);
                }
                assert!((0.8..=0.95).contains(&reach), "{view} {aspect}: {reach}");
            }
        }
    }

    #[test]
    fn a_single_point_can_be_looked_at() {
        let camera = Camera::fit(View::default(), &[Vec3::x()], 1.0);
        assert!(camera.project(&Vec3::x()).iter().all(|c| c.is_finite()));
    }

    #[test]
    fn views_that_do_not_exist_are_refused() {
        for text in ["", "back", "1", "1,", "nan,0", "0,91", "1,2,3", "inf,0", "1e9,0"] {
            assert_eq!(text.parse::<View>(), Err(UnknownView), "{text}");
        }
        assert_eq!("10, -20".parse(), Ok(View { azimuth_deg: 10.0, elevation_deg: -20.0 }));
    }
}
