//! Paths on which pins and obstacles are led.

use crate::Vec3;
use crate::build::{number, vector, within};
use crate::error::Violation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Latest time of a keyframe, s: as long as a run may last.
const MAX_TIME: f64 = 1e9;
/// Most keyframes of one path.
const MAX_KEYFRAMES: usize = 100_000;

/// A point that a path goes through.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KeyframeSpec {
    /// When, s after the start.
    #[schemars(range(min = 0.0, max = MAX_TIME))]
    pub time_s: f64,
    /// Where, m from the place at the start.
    pub offset_m: [f64; 3],
}

/// A displacement over time: from 0 at the start through the keyframes, linear in between, at rest after the last.
///
/// ```
/// use drape_model::{Input, Vec3, parse};
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

impl Path {
    /// Checks keyframes; none of them make no path. `at` is where they stand in the file.
    ///
    /// # Errors
    /// The first [`Violation`].
    pub(crate) fn check(at: &str, frames: &[KeyframeSpec]) -> Result<Option<Self>, Violation> {
        if frames.len() > MAX_KEYFRAMES {
            let expected = format!("at most {MAX_KEYFRAMES} keyframes");
            return Err(Violation::new(at, format!("of length {}", frames.len()), expected));
        }
        let mut keyframes: Vec<(f64, Vec3)> = Vec::with_capacity(frames.len());
        for (k, frame) in frames.iter().enumerate() {
            let path = |key: &str| format!("{at}[{k}].{key}");
            let time = within(path("time_s"), frame.time_s, 0.0, MAX_TIME)?;
            let offset = vector(path("offset_m"), frame.offset_m)?;
            if let Some((before, _)) = keyframes.last().filter(|(before, _)| time <= *before) {
                let expected =
                    format!("a time after {}, that of the keyframe before", number(*before));
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

    /// Time of the last keyframe, s: from then on it rests.
    pub fn end(&self) -> f64 {
        self.keyframes.last().map_or(0.0, |(time, _)| *time)
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

/// What is left of a path at `t` seconds, as one that starts there and then.
pub(crate) fn rest_of(frames: &[KeyframeSpec], t: f64) -> Vec<KeyframeSpec> {
    let passed = offset_of(frames, t);
    let left = frames.iter().filter(|frame| frame.time_s > t);
    left.map(|frame| KeyframeSpec {
        time_s: frame.time_s - t,
        offset_m: (Vec3::from(frame.offset_m) - passed).into(),
    })
    .collect()
}

/// Displacement of keyframes that a file holds at `t` seconds, m; none where they make no path.
pub(crate) fn offset_of(frames: &[KeyframeSpec], t: f64) -> Vec3 {
    let path = Path::check("", frames).ok().flatten();
    path.map_or(Vec3::zeros(), |path| path.offset(t))
}

/// A pinned particle that is led on a path.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingPin {
    /// Its index.
    pub particle: usize,
    /// Where it starts, m.
    pub(crate) start: Vec3,
    pub(crate) path: Path,
}

impl MovingPin {
    /// Where it is at `t` seconds, m.
    pub fn position(&self, t: f64) -> Vec3 {
        self.start + self.path.offset(t)
    }

    /// When it has come to rest for good, s.
    pub fn stops(&self) -> f64 {
        self.path.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(time_s: f64, x: f64) -> KeyframeSpec {
        KeyframeSpec { time_s, offset_m: [x, -x, 0.0] }
    }

    #[test]
    fn a_path_goes_through_its_keyframes_and_rests_after_the_last() {
        let frames = [frame(0.3, 0.1), frame(0.7, 0.9), frame(2.0, 0.9)];
        let path = Path::check("", &frames).expect("valid").expect("valid");
        for frame in &frames {
            assert_eq!(path.offset(frame.time_s), Vec3::from(frame.offset_m));
        }
        assert_eq!(path.offset(0.0), Vec3::zeros());
        assert!((path.offset(0.5).x - 0.5).abs() < 1e-15);
        assert!((path.offset(0.15).x - 0.05).abs() < 1e-15);
        assert_eq!((path.end(), path.offset(1e9)), (2.0, Vec3::from(frames[2].offset_m)));
        assert_eq!(Path::check("", &[]).expect("valid"), None);
    }

    #[test]
    fn the_rest_of_a_path_leads_where_the_path_leads() {
        let frames = [frame(0.3, 0.1), frame(0.7, 0.9)];
        let path = Path::check("", &frames).expect("valid").expect("valid");
        for t in [0.0, 0.2, 0.3, 0.5, 0.7, 1.0] {
            for later in [0.0, 0.1, 0.25, 0.6] {
                let rest = offset_of(&rest_of(&frames, t), later);
                assert!((path.offset(t) + rest - path.offset(t + later)).norm() < 1e-15);
            }
        }
    }
}
