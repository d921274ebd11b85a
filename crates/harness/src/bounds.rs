//! How far a cloth may go: a run diverges when a particle goes farther.

use drape_model::{Effect, MovingPin, Numbering, Path, State, System, Vec3};
use drape_report::number::significant;

/// A position farther from the centre of the start than this many scene sizes, and farther than
/// [`Bounds::way`], counts as diverged.
const FAR: f64 = 1e3;
/// Factor on the distance that fall, throw, wind, led pins and led obstacles can cover. A led pin
/// whips the cloth to a multiple of its own speed, and long steps fall a little farther.
const GENEROUS: f64 = 2.0;

/// Extent of a scene, and what its particles can cover, for the test of divergence.
#[derive(Debug)]
pub(crate) struct Bounds {
    center: Vec3,
    size: f64,
    /// Greatest acceleration by forces without a stiffness, such as gravity, m/s².
    acceleration: f64,
    /// Sum of the greatest speeds of the start, of the air, and of led pins and obstacles, m/s.
    speed: f64,
    start: f64,
}

impl Bounds {
    pub(crate) fn of(system: &System, state: &State) -> Self {
        let x = &state.x;
        let (low, high) = x.iter().fold((x[0], x[0]), |(low, high), x| (low.inf(x), high.sup(x)));
        let size = (high - low).norm();
        // One particle, or many in one place, have no extent: take a metre.
        let size = if size > 0.0 { size } else { 1.0 };
        let mut force = vec![Vec3::zeros(); x.len()];
        for effect in system.effects().filter(|effect| !effect.has_jacobian()) {
            effect.add_force(system.mass(), x, &mut force);
        }
        let pulls = force.iter().zip(system.mass()).map(|(f, m)| f.norm() / m);
        let throw = state.v.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let air: f64 = system.effects().map(Effect::greatest_medium_speed).sum();
        let pins = system.moving_pins().iter().map(MovingPin::greatest_speed);
        let paths = system.obstacles().iter().filter_map(|obstacle| obstacle.path.as_ref());
        let led = pins.chain(paths.map(Path::greatest_speed)).fold(0.0, f64::max);
        Self {
            center: (low + high) * 0.5,
            size,
            acceleration: pulls.fold(0.0, f64::max),
            speed: throw + air + led,
            start: state.t,
        }
    }

    /// What a particle can cover in `t` seconds, m: by fall, throw, wind, and pins and obstacles
    /// that are led.
    fn way(&self, t: f64) -> f64 {
        0.5 * self.acceleration * t * t + self.speed * t
    }

    /// What is wrong with a state, if anything.
    pub(crate) fn violation(&self, state: &State, numbering: &Numbering) -> Option<String> {
        if !state.is_finite() {
            return Some("a position or velocity is not finite".to_owned());
        }
        let t = state.t - self.start;
        let (far, way) = (FAR * self.size, GENEROUS * self.way(t));
        let reach = far + way;
        let outside = |x: &Vec3| (x - self.center).norm() > reach;
        let particles = state.x.iter().enumerate().filter(|(_, x)| outside(x));
        particles.map(|(particle, _)| numbering.given(particle)).min().map(|particle| {
            format!(
                "particle {particle} is farther than {} m from the centre of the start: 1000 scene \
                 sizes ({} m), and twice what fall, throw, wind, led pins and led obstacles can \
                 cover in {t:.4} s ({} m)",
                significant(reach, 4),
                significant(far, 4),
                significant(way, 4)
            )
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on should stop")]
mod tests {
    use super::*;
    use crate::methods::Choice;
    use crate::run::{Runner, Simulation};
    use drape_model::TimeSpan;

    const SYSTEM: &str = r#"{ "format": "drape-system/1",
        "particles": { "mass_kg": [1e-3, 1e-3], "position_m": [[0, 0, 0], [0.005, 0, 0]],
            "velocity_m_s": [V, V] },
        "springs": [{ "effect": "tension", "i": 0, "j": 1, "rest_length_m": 0.005,
            "stiffness_n_per_m": 1 }],
        "pins": [PINS], "effects": { EFFECTS }, "obstacles": [OBSTACLES] }"#;

    fn simulation(edits: &[(&str, &str)]) -> Simulation {
        let mut text = SYSTEM.to_owned();
        for (name, value) in edits.iter().chain(&[
            ("V", "[0, 0, 0]"),
            ("PINS", ""),
            ("EFFECTS", ""),
            ("OBSTACLES", ""),
        ]) {
            text = text.replace(name, value);
        }
        Simulation::parse("test", &text).unwrap()
    }

    /// Motion that is exact and goes farther than 1000 scene sizes, 5 m, within two seconds.
    #[test]
    fn fall_throw_and_what_is_led_are_no_divergence() {
        let path = r#""path": [{ "time_s": 2, "offset_m": [0, 0, 12] }]"#;
        let pin = format!(r#"{{ "particle": 0, {path} }}"#);
        let lift =
            format!(r#"{{ "plane": {{ "point_m": [0, 0, 0], "normal": [0, 0, 1], {path} }} }}"#);
        for edits in [
            [("EFFECTS", r#""gravity": { "m_s2": [0, 0, -9.81] }"#)],
            [("V", "[0, 3, 0]")],
            [("PINS", pin.as_str())],
            [("OBSTACLES", lift.as_str())],
        ] {
            let mut piece = simulation(&edits);
            let time = TimeSpan { step_s: 0.01, duration_s: 2.0 };
            let method = Choice::parse("backward-euler", &[]).unwrap();
            let start = piece.state.x[1];
            let outcome = Runner::new(&method, time).go(&mut piece).unwrap();
            assert_eq!(outcome.divergence, None, "{edits:?}");
            let far = (piece.state.x[1] - start).norm();
            assert!(far > 5.1, "{edits:?}: only {far} m");
        }
    }

    #[test]
    fn a_particle_beyond_all_that_is_a_divergence() {
        let piece = simulation(&[("EFFECTS", r#""gravity": { "m_s2": [0, 0, -10] }"#)]);
        let bounds = Bounds::of(&piece.system, &piece.state);
        let mut state = piece.state;
        state.t = 1.0;
        let numbering = Numbering::identity();
        // 1000 sizes of 5 mm, and twice a fall of 5 m.
        state.x[1].z = -14.9;
        assert_eq!(bounds.violation(&state, &numbering), None);
        state.x[1].z = -15.1;
        let said = bounds.violation(&state, &numbering).unwrap();
        assert!(said.starts_with("particle 1 is farther than 15.00 m"), "{said}");
        assert!(said.contains("1000 scene sizes (5.000 m)"), "{said}");
        state.x[1].z = f64::NAN;
        assert!(bounds.violation(&state, &numbering).unwrap().contains("not finite"));
    }
}
