//! Paths of pins and obstacles.

use crate::Vec3;
use crate::bounds::{MAX_COORDINATE, at_most, number, within};
use crate::error::Violation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Latest time of a keyframe, s: as long as a run may last.
const MAX_TIME: f64 = 1e9;
/// Greatest displacement along an axis, m: from one bound of the coordinates to the other.
const MAX_OFFSET: f64 = 2.0 * MAX_COORDINATE;
/// Distance by which a place on a path may be out of range, m. It allows for round-off where the
/// rest of a path begins.
const ROUND_OFF: f64 = 1e-12 * MAX_COORDINATE;
/// Most keyframes of one path.
pub(crate) const MAX_KEYFRAMES: usize = 100_000;

/// A point that a path goes through.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KeyframeSpec {
    /// Time after the start, s.
    #[schemars(range(min = 0.0, max = MAX_TIME))]
    pub time_s: f64,
    /// Displacement from the starting place, m. The displaced places must stay within the bounds of
    /// coordinates.
    #[schemars(inner(range(min = -MAX_OFFSET, max = MAX_OFFSET)))]
    pub offset_m: [f64; 3],
}

/// A displacement over time. It starts at 0, is linear between keyframes, and is constant after the
/// last one.
///
/// ```
/// use drape_model::{Vec3, parse};
/// let text = r#"{ "format": "drape-system/1", "particles": { "mass_kg": [1], "position_m": [[0, 0, 5]] },
///     "pins": [{ "particle": 0, "path": [{ "time_s": 2, "offset_m": [4, 0, 0] }] }] }"#;
/// let (system, _) = parse("text", text)?.spec().build().expect("valid");
/// let pin = &system.moving_pins()[0];
/// assert_eq!(pin.position(0.5), Vec3::new(1.0, 0.0, 5.0));
/// assert_eq!(pin.position(3.0), Vec3::new(4.0, 0.0, 5.0));
/// # Ok::<(), drape_model::SceneError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Times, s, rising, and offsets, m; at least one.
    keyframes: Vec<(f64, Vec3)>,
}

/// Moves a place back into range, m; round-off may have put it a little beyond.
pub(crate) fn in_range(place: Vec3) -> Vec3 {
    place.map(|coordinate| coordinate.clamp(-MAX_COORDINATE, MAX_COORDINATE))
}

/// The smallest box around the moving points at the start, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    low: Vec3,
    high: Vec3,
}

impl Extent {
    /// The box of these points, cut to the range of coordinates.
    pub(crate) fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        let none = (Vec3::repeat(MAX_COORDINATE), Vec3::repeat(-MAX_COORDINATE));
        let (low, high) =
            points.into_iter().fold(none, |(low, high), x| (low.inf(&x), high.sup(&x)));
        Self { low: in_range(low), high: in_range(high) }
    }

    /// Checks that the box stays in range when displaced. `path` is the key of the displacement.
    fn displaced(&self, path: &str, offset: [f64; 3]) -> Result<Vec3, Violation> {
        for (axis, component) in offset.into_iter().enumerate() {
            let (least, most) =
                (-MAX_COORDINATE - self.low[axis], MAX_COORDINATE - self.high[axis]);
            let is_in = (least - ROUND_OFF..=most + ROUND_OFF).contains(&component);
            if !(is_in && component.abs() <= MAX_OFFSET) {
                let expected = format!(
                    "a number from {} to {}: no place beyond {} m",
                    number(least),
                    number(most),
                    number(MAX_COORDINATE)
                );
                let found = number(component);
                return Err(Violation::new(format!("{path}[{axis}]"), found, expected));
            }
        }
        Ok(Vec3::from(offset))
    }
}

impl Path {
    /// Times, s, and offsets, m.
    pub(crate) fn keyframes(&self) -> &[(f64, Vec3)] {
        &self.keyframes
    }

    /// Checks keyframes; an empty list gives `None`. `at` is their key, `led` the box of the moving
    /// points.
    ///
    /// # Errors
    /// The first [`Violation`].
    pub(crate) fn check(
        at: &str,
        frames: &[KeyframeSpec],
        led: Extent,
    ) -> Result<Option<Self>, Violation> {
        at_most(at, frames.len(), MAX_KEYFRAMES, "keyframes")?;
        let mut keyframes: Vec<(f64, Vec3)> = Vec::with_capacity(frames.len());
        for (k, frame) in frames.iter().enumerate() {
            let path = |key: &str| format!("{at}[{k}].{key}");
            let time = within(path("time_s"), frame.time_s, 0.0, MAX_TIME)?;
            let offset = led.displaced(&path("offset_m"), frame.offset_m)?;
            if let Some((before, _)) = keyframes.last().filter(|(before, _)| time <= *before) {
                let expected =
                    format!("a time after {}, the time of the keyframe before", number(*before));
                return Err(Violation::new(path("time_s"), number(time), expected));
            }
            if time == 0.0 && offset != Vec3::zeros() {
                let found = format!("{:?}", frame.offset_m);
                let expected = "[0, 0, 0] at time 0: a path begins where the scene puts it";
                return Err(Violation::new(path("offset_m"), found, expected));
            }
            keyframes.push((time, offset));
        }
        Ok((!keyframes.is_empty()).then_some(Self { keyframes }))
    }

    /// Time of the last keyframe, s; the path rests from then on.
    pub fn end(&self) -> f64 {
        self.keyframes.last().map_or(0.0, |(time, _)| *time)
    }

    /// Greatest speed, m/s.
    pub fn greatest_speed(&self) -> f64 {
        let mut from = (0.0, Vec3::zeros());
        self.keyframes.iter().fold(0.0, |greatest: f64, &to| {
            let (start, place) = std::mem::replace(&mut from, to);
            let span = to.0 - start;
            if span > 0.0 { greatest.max((to.1 - place).norm() / span) } else { greatest }
        })
    }

    /// Displacement at `t` seconds, m.
    pub fn offset(&self, t: f64) -> Vec3 {
        let next = self.keyframes.partition_point(|(time, _)| *time <= t);
        let (start, from) = match next.checked_sub(1) {
            Some(last) => self.keyframes[last],
            None => (0.0, Vec3::zeros()),
        };
        match self.keyframes.get(next) {
            Some((end, to)) => from + (to - from) * ((t - start) / (end - start)),
            None => from,
        }
    }
}

/// The rest of a path after `t` seconds, as a path of its own.
pub(crate) fn rest_of(frames: &[KeyframeSpec], t: f64) -> Vec<KeyframeSpec> {
    let passed = offset_of(frames, t);
    let mut rest: Vec<KeyframeSpec> = Vec::new();
    for frame in frames.iter().filter(|frame| frame.time_s > t) {
        let offset = Vec3::from(frame.offset_m) - passed;
        let offset_m = offset.map(|component| component.clamp(-MAX_OFFSET, MAX_OFFSET)).into();
        let time_s = frame.time_s - t;
        // Round-off may make two times equal.
        if rest.last().is_some_and(|before| before.time_s == time_s) {
            rest.pop();
        }
        rest.push(KeyframeSpec { time_s, offset_m });
    }
    rest
}

/// Displacement of keyframes at `t` seconds, m; 0 without keyframes.
pub(crate) fn offset_of(frames: &[KeyframeSpec], t: f64) -> Vec3 {
    let keyframes = frames.iter().map(|frame| (frame.time_s, Vec3::from(frame.offset_m)));
    Path { keyframes: keyframes.collect() }.offset(t)
}

/// A pinned particle that follows a path.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingPin {
    /// Index of the particle.
    pub particle: usize,
    /// Place at the start, m.
    pub(crate) start: Vec3,
    pub(crate) path: Path,
}

impl MovingPin {
    /// Position at `t` seconds, m.
    pub fn position(&self, t: f64) -> Vec3 {
        self.start + self.path.offset(t)
    }

    /// Time after which the pin rests, s.
    pub fn stops(&self) -> f64 {
        self.path.end()
    }

    /// Greatest speed, m/s.
    pub fn greatest_speed(&self) -> f64 {
        self.path.greatest_speed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(time_s: f64, x: f64) -> KeyframeSpec {
        KeyframeSpec { time_s, offset_m: [x, -x, 0.0] }
    }

    fn check(frames: &[KeyframeSpec]) -> Result<Option<Path>, Violation> {
        Path::check("path", frames, Extent::of([Vec3::zeros()]))
    }

    #[test]
    fn a_path_goes_through_its_keyframes_and_rests_after_the_last() {
        let frames = [frame(0.3, 0.1), frame(0.7, 0.9), frame(2.0, 0.9)];
        let path = check(&frames).expect("valid").expect("valid");
        for frame in &frames {
            assert_eq!(path.offset(frame.time_s), Vec3::from(frame.offset_m));
        }
        assert_eq!(path.offset(0.0), Vec3::zeros());
        assert!((path.offset(0.5).x - 0.5).abs() < 1e-15);
        assert!((path.offset(0.15).x - 0.05).abs() < 1e-15);
        assert_eq!((path.end(), path.offset(1e9)), (2.0, Vec3::from(frames[2].offset_m)));
        let fastest = 0.8 * 2.0_f64.sqrt() / 0.4;
        assert!((path.greatest_speed() - fastest).abs() < 1e-14, "{}", path.greatest_speed());
        assert_eq!(check(&[]).expect("valid"), None);
    }

    #[test]
    fn the_rest_of_a_path_leads_where_the_path_leads() {
        let frames = [frame(0.3, 0.1), frame(0.7, 0.9)];
        let path = check(&frames).expect("valid").expect("valid");
        for t in [0.0, 0.2, 0.3, 0.5, 0.7, 1.0] {
            for later in [0.0, 0.1, 0.25, 0.6] {
                let rest = offset_of(&rest_of(&frames, t), later);
                assert!((path.offset(t) + rest - path.offset(t + later)).norm() < 1e-15);
            }
        }
    }

    #[test]
    fn no_place_on_a_path_is_out_of_range() {
        let led = Extent::of([Vec3::new(-9e8, 0.0, 0.0), Vec3::new(8e8, 0.0, 0.0)]);
        let check = |x: f64| {
            Path::check("path", &[KeyframeSpec { time_s: 1.0, offset_m: [x, 0.0, 0.0] }], led)
        };
        for x in [-1e8, 0.0, 2e8] {
            assert!(check(x).is_ok(), "{x}");
        }
        for x in [-1.1e8, 2.1e8, f64::NAN] {
            let refused = check(x).expect_err("out of range");
            assert_eq!(refused.path, "path[0].offset_m[0]");
            assert!(refused.expected.contains("from -1e8 to 2e8"), "{refused}");
        }
    }

    #[test]
    fn times_that_round_off_makes_one_are_one() {
        let frames = [frame(1.5, 1.0), frame(1.5 + f64::EPSILON, 2.0)];
        // Both differences lie in the middle between two numbers, and are rounded to 1.5.
        let rest = rest_of(&frames, 0.5 * f64::EPSILON);
        assert_eq!(rest, [frame(1.5, 2.0)]);
        assert!(check(&rest).is_ok());
    }
}
