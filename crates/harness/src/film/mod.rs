//! Films a moving cloth, and measures how far two motions are apart.
//!
//! A [`Camera`] looks at a run at the ends of frames. It keeps the positions at every look and the
//! path of chosen particles. Two films of the same camera are compared by the distance of their
//! surfaces or of their particles.

mod bytes;
mod surface;

use crate::HarnessError;
use crate::run::{Counts, Moment, Outcome, Runner, Simulation};
use drape_model::{SpringEffect, State, System, SystemSpec, TimeSpan, Vec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::rc::Rc;
use surface::Surface;

/// Less than this share of the true motion counts as standing still.
pub(crate) const HALF: f64 = 0.5;

/// Positions, kinetic energy and strain at one look.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Look {
    /// Position of each particle, in the order of the specification, m.
    #[serde(with = "bytes")]
    pub(crate) x: Vec<Vec3>,
    /// Kinetic energy, J.
    pub(crate) kinetic: f64,
    /// 99th percentile of the strain along the threads.
    pub(crate) strain: f64,
}

/// The film of a motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Seen {
    pub(crate) looks: Vec<Look>,
    /// Mean path of the tracked particles, from frame to frame, m.
    pub(crate) path: f64,
}

/// Ends and rest length, m, of a spring.
pub(crate) type Thread = (usize, usize, f64);

/// How a scene is filmed.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    /// Triangles of the cloth, as indices of particles.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The springs along the threads.
    pub(crate) threads: Vec<Thread>,
    /// The particles whose path is measured.
    pub(crate) tracked: Vec<usize>,
    /// Frames a second.
    pub(crate) rate: f64,
    /// Length of the film in frames.
    pub(crate) frames: u32,
    /// Frames from one look to the next.
    pub(crate) stride: u32,
}

/// The springs of a system along its threads.
pub(crate) fn threads(spec: &SystemSpec) -> Vec<Thread> {
    let along = spec.springs.iter().filter(|spring| spring.effect == SpringEffect::Tension);
    along.map(|spring| (spring.i as usize, spring.j as usize, spring.rest_length_m)).collect()
}

impl Camera {
    /// The time span of the first `frames` frames, with `substeps` steps a frame.
    pub(crate) fn span(&self, substeps: u32, frames: u32) -> TimeSpan {
        let step_s = 1.0 / (self.rate * f64::from(substeps));
        TimeSpan { step_s, duration_s: f64::from(frames) / self.rate }
    }

    /// Makes a run and films it. `runner` takes the whole [`span`](Self::span) with so many
    /// substeps. `first` are the positions at the start in the order of the specification, m.
    pub(crate) fn film<'a>(
        &'a self,
        runner: Runner<'a>,
        start: &Simulation,
        first: &[Vec3],
        substeps: u32,
    ) -> Result<(Counts, Seen), HarnessError> {
        let (runner, eye) = self.before(runner, first, at_ends(substeps));
        let counts = runner.count(start)?;
        Ok((counts, eye.borrow_mut().close()))
    }

    /// As [`film`](Self::film), but starts from the state of the simulation and does not watch the
    /// energy. The energy of every step costs as much as a step of an explicit method.
    pub(crate) fn glance<'a>(
        &'a self,
        runner: Runner<'a>,
        simulation: &mut Simulation,
        substeps: u32,
    ) -> Result<(Outcome, Seen), HarnessError> {
        let (runner, eye) = self.before(runner, &simulation.state.x, at_ends(substeps));
        let outcome = runner.go(simulation)?;
        Ok((outcome, eye.borrow_mut().close()))
    }

    /// As [`glance`](Self::glance), for steps that last `frames` frames each. Between the ends of a
    /// step the motion is the cubic through its states (Hermite, of third order).
    pub(crate) fn glance_within<'a>(
        &'a self,
        runner: Runner<'a>,
        simulation: &mut Simulation,
        frames: u32,
    ) -> Result<(Outcome, Seen), HarnessError> {
        let mut from = simulation.state.clone();
        let within = move |eye: &mut Eye<'_>, moment: &Moment<'_>| {
            for frame in 1..=frames {
                let share = f64::from(frame) / f64::from(frames);
                let state = between(&from, moment.state, moment.h, share);
                let x = moment.numbering.restore_list(&state.x);
                let kinetic = || moment.system.kinetic_energy(&state.v);
                let before = (moment.step - 1) * u64::from(frames);
                eye.look(before + u64::from(frame), &x, kinetic);
            }
            from.clone_from(moment.state);
        };
        let (runner, eye) = self.before(runner, &simulation.state.x, within);
        let outcome = runner.go(simulation)?;
        Ok((outcome, eye.borrow_mut().close()))
    }

    /// The film of a motion that starts at `first`, m, and has these states at the ends of its
    /// frames.
    pub(crate) fn look_at(&self, system: &System, first: &[Vec3], states: &[State]) -> Seen {
        let mut eye = Eye::new(self, first);
        for (frame, state) in (1..).zip(states) {
            eye.look(frame, &state.x, || system.kinetic_energy(&state.v));
        }
        eye.close()
    }

    /// The runner with an observer that looks at every moment. The runner outlives the run, so the
    /// observer does, too.
    fn before<'a>(
        &'a self,
        runner: Runner<'a>,
        first: &[Vec3],
        mut look: impl FnMut(&mut Eye<'a>, &Moment<'_>) + 'a,
    ) -> (Runner<'a>, Rc<RefCell<Eye<'a>>>) {
        let eye = Rc::new(RefCell::new(Eye::new(self, first)));
        let kept = Rc::clone(&eye);
        let runner =
            runner.observe(move |moment: &Moment<'_>| look(&mut kept.borrow_mut(), moment));
        (runner, eye)
    }

    /// 99th percentile of the strain along the threads; 0 without threads.
    fn strain(&self, x: &[Vec3]) -> f64 {
        let strain = |&(i, j, rest): &Thread| (x[i] - x[j]).norm() / rest - 1.0;
        let mut strains: Vec<f64> = self.threads.iter().map(strain).collect();
        strains.sort_unstable_by(f64::total_cmp);
        strains.get(strains.len() * 99 / 100).copied().unwrap_or(0.0)
    }

    /// Mean distance of two surfaces, both ways, m.
    pub(crate) fn distance(&self, a: &[Vec3], b: &[Vec3]) -> f64 {
        let [a, b] = [a, b].map(|x| Surface::new(x, &self.triangles));
        a.apart(&b)
    }

    /// Mean distance of the surfaces over all looks, m. Without triangles each particle is compared
    /// with itself.
    pub(crate) fn shape_apart(&self, a: &Seen, b: &Seen) -> f64 {
        let apart = |(a, b): (&Look, &Look)| self.distance(&a.x, &b.x);
        let all: Vec<f64> = a.looks.par_iter().zip(&b.looks).map(apart).collect();
        mean(all.into_iter())
    }
}

/// The film of a camera so far.
#[derive(Debug)]
struct Eye<'a> {
    camera: &'a Camera,
    seen: Seen,
    /// Where the tracked particles were at the frame before, m.
    last: Vec<Vec3>,
}

impl<'a> Eye<'a> {
    fn new(camera: &'a Camera, first: &[Vec3]) -> Self {
        let last = camera.tracked.iter().map(|&i| first[i]).collect();
        Self { camera, seen: Seen::default(), last }
    }

    /// Looks at the end of a frame; frames count from 1.
    fn look(&mut self, frame: u64, x: &[Vec3], kinetic: impl FnOnce() -> f64) {
        let share = 1.0 / self.last.len().max(1) as f64;
        let way = |(&i, last): (&usize, &mut Vec3)| {
            let way = (x[i] - *last).norm();
            *last = x[i];
            way
        };
        let tracked = self.camera.tracked.iter();
        self.seen.path += share * tracked.zip(&mut self.last).map(way).sum::<f64>();
        if frame.is_multiple_of(u64::from(self.camera.stride)) {
            let strain = self.camera.strain(x);
            self.seen.looks.push(Look { x: x.to_vec(), kinetic: kinetic(), strain });
        }
    }

    /// Ends the film and returns it.
    fn close(&mut self) -> Seen {
        std::mem::take(&mut self.seen)
    }
}

/// Looks at the ends of frames of so many steps.
fn at_ends(substeps: u32) -> impl FnMut(&mut Eye<'_>, &Moment<'_>) {
    let substeps = u64::from(substeps);
    move |eye, moment| {
        if moment.step.is_multiple_of(substeps) {
            let kinetic = || moment.system.kinetic_energy(&moment.state.v);
            eye.look(moment.step / substeps, &moment.moving().state().x, kinetic);
        }
    }
}

/// The state at the share `s` of a step of `h` seconds, by the cubic through the states at its ends.
fn between(from: &State, to: &State, h: f64, s: f64) -> State {
    let cubic = |a: &Vec3, va: &Vec3, b: &Vec3, vb: &Vec3| {
        // The straight line, and what bends it: both ends keep their velocities.
        let way = b - a;
        a + way * s + ((va * h - way) * (1.0 - s) - (vb * h - way) * s) * (s * (1.0 - s))
    };
    let slope = |a: &Vec3, va: &Vec3, b: &Vec3, vb: &Vec3| {
        let way = (b - a) / h;
        way + (va - way) * ((1.0 - s) * (1.0 - 3.0 * s)) - (vb - way) * (s * (2.0 - 3.0 * s))
    };
    let all = |f: &dyn Fn(&Vec3, &Vec3, &Vec3, &Vec3) -> Vec3| {
        let starts = from.x.iter().zip(&from.v);
        starts.zip(to.x.iter().zip(&to.v)).map(|((a, va), (b, vb))| f(a, va, b, vb)).collect()
    };
    State { t: from.t + s * h, x: all(&cubic), v: all(&slope) }
}

/// Root of the mean square distance of the particles at one look, m.
pub(crate) fn look_apart(a: &Look, b: &Look) -> f64 {
    mean(a.x.iter().zip(&b.x).map(|(a, b)| (a - b).norm_squared())).sqrt()
}

/// The mean; 0 without values.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / f64::max(count, 1.0)
}

/// The noise of several true motions: the mean distance of a motion from the nearest of the others;
/// `None` of fewer than two, or if a distance is not finite. A run that is held against the nearest
/// true motion scores about as much, or less, without any error of its own: it has one motion more to
/// choose from.
pub(crate) fn noise(motions: &[Seen], apart: impl Fn(&Seen, &Seen) -> f64) -> Option<f64> {
    let mut nearest = vec![f64::INFINITY; motions.len()];
    for (n, motion) in motions.iter().enumerate() {
        for (m, other) in motions[..n].iter().enumerate() {
            let distance = apart(other, motion);
            nearest[m] = nearest[m].min(distance);
            nearest[n] = nearest[n].min(distance);
        }
    }
    (motions.len() > 1).then(|| mean(nearest.into_iter())).filter(|noise| noise.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of three motions at 0, 1 and 5, the first two are one apart, and the third is four from the
    /// nearest. Two motions have the distance between them, and one motion has no noise.
    #[test]
    fn noise_is_the_distance_from_the_nearest_other_motion() {
        let at = |path: f64| Seen { path, ..Seen::default() };
        let apart = |a: &Seen, b: &Seen| (a.path - b.path).abs();
        let motions = [at(0.0), at(1.0), at(5.0)];
        assert_eq!(noise(&motions, apart), Some((1.0 + 1.0 + 4.0) / 3.0));
        assert_eq!(noise(&motions[1..], apart), Some(4.0));
        let in_other_order = [at(1.0), at(0.0), at(5.0)];
        assert_eq!(noise(&in_other_order, apart), noise(&motions, apart));
        assert_eq!(noise(&motions[..1], apart), None);
        assert_eq!(noise(&motions, |_, _| f64::NAN), None);
    }

    /// A cubic motion is met at every share of a step, with its velocity.
    #[test]
    fn a_cubic_motion_is_met_within_a_step() {
        let at = |t: f64| {
            let x = Vec3::new(1.0 + 2.0 * t, 3.0 * t * t - t, t * t * t - 0.5 * t * t);
            let v = Vec3::new(2.0, 6.0 * t - 1.0, 3.0 * t * t - t);
            State { t, x: vec![x], v: vec![v] }
        };
        let (t, h) = (0.2, 0.7);
        for s in [0.0, 0.25, 0.5, 0.9, 1.0] {
            let (seen, meant) = (between(&at(t), &at(t + h), h, s), at(t + s * h));
            assert!((seen.x[0] - meant.x[0]).norm() < 1e-14, "{s}: {seen:?} {meant:?}");
            assert!((seen.v[0] - meant.v[0]).norm() < 1e-13, "{s}: {seen:?} {meant:?}");
        }
    }

    /// A kept film has every bit of the motion, also of numbers that decimals round.
    #[test]
    fn a_film_is_the_same_after_it_was_kept() {
        let x = vec![Vec3::new(0.1, -1.0 / 3.0, 1e-300), Vec3::new(f64::MAX, -0.0, 7.0)];
        let look = Look { x, kinetic: 1.0 / 7.0, strain: 0.3 };
        let film = Seen { looks: vec![look.clone(), look], path: 2.0 / 3.0 };
        let kept = serde_json::to_value(&film).expect("JSON");
        let again = Seen::deserialize(&kept).expect("a film");
        assert_eq!(again, film);
        assert!(again.looks[0].x[1].y.is_sign_negative());
        for bad in ["AAAA", "no base64"] {
            let mut torn = kept.clone();
            torn["looks"][0]["x"] = bad.into();
            assert!(Seen::deserialize(&torn).is_err(), "{bad}");
        }
    }

    #[test]
    fn the_path_of_a_film_is_the_mean_of_those_of_the_tracked_particles() {
        let camera = Camera {
            triangles: Vec::new(),
            threads: Vec::new(),
            tracked: vec![0, 2],
            rate: 25.0,
            frames: 2,
            stride: 2,
        };
        let mut x = [Vec3::zeros(); 3];
        let mut eye = Eye::new(&camera, &x);
        for frame in 1..=2 {
            x[0].x += 1.0;
            x[1].y -= 50.0;
            x[2].z += if frame == 1 { 3.0 } else { -3.0 };
            eye.look(frame, &x, || 0.0);
        }
        let seen = eye.close();
        assert_eq!((seen.path, seen.looks.len()), (4.0, 1));
    }
}
