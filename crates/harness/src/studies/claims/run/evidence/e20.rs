//! What is run for claim C20.

use super::runs::walk;
use super::scenes::{build, hanging};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c20::TOLERANCE;
use drape_model::{KeyframeSpec, ObstacleSpec, State, System, Vec3};

pub(super) const TRIAL: Trial = Trial {
    id: "C20",
    scenes: || {
        "a sheet of 144 particles falls at 1, 3 and 10 m/s on a tilted plane, a table and a \
         sphere, on a closed mesh (an octahedron, tip up), on the tilted plane with friction 0.5, \
         and on a table with friction 0.5 that rises at 2 m/s, all with restitution 0, 0.5 and 1; \
         k/m = 1e-3, 1e4 and 1e6, h = 0.01 s, 0.6 s; auxiliary particles: x − min(φ, 0) n"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const STEP: f64 = 0.01;
const STEPS: u64 = 60;
const SPEEDS: [f64; 3] = [1.0, 3.0, 10.0];
const RESTITUTIONS: [f64; 3] = [0.0, 0.5, 1.0];
/// A touch within so many steps after another belongs to the same impact.
const FLIGHT: u64 = 4;
/// An impact at less than this speed, m/s, is a sheet that comes to rest.
const SLOW: f64 = 0.5;
/// Stiffness over mass of springs that hardly pull, 1/s².
const LIMP: f64 = 1e-3;

/// Coefficient of friction where there is any.
const FRICTION: f64 = 0.5;
/// Speed at which the moving table rises, m/s.
const RISING: f64 = 2.0;

fn obstacles(restitution: f64) -> [ObstacleSpec; 6] {
    let [x, y, z] = [[0.4, 0.0, 0.0], [0.0, 0.4, 0.0], [0.0, 0.0, 0.4]].map(Vec3::from);
    let middle = Vec3::new(0.0, 0.0, -0.5);
    let corners = [x, y, z, -x, -y, -z].map(|corner| (middle + corner).into());
    let octahedron = ObstacleSpec::Mesh {
        vertices_m: corners.to_vec(),
        triangles: vec![
            [0, 1, 2],
            [1, 3, 2],
            [3, 4, 2],
            [4, 0, 2],
            [1, 0, 5],
            [3, 1, 5],
            [4, 3, 5],
            [0, 4, 5],
        ],
        restitution,
        friction: 0.0,
        path: Vec::new(),
    };
    let rough = ObstacleSpec::Plane {
        point_m: [0.0, 0.0, -0.3],
        normal: [0.3, 0.0, 1.0],
        restitution,
        friction: FRICTION,
        path: Vec::new(),
    };
    let rising = ObstacleSpec::Box {
        center_m: [0.0, 0.0, -0.9],
        size_m: [0.5; 3],
        restitution,
        friction: FRICTION,
        path: vec![KeyframeSpec { time_s: 1.0, offset_m: [0.0, 0.0, RISING] }],
    };
    [
        octahedron,
        rough,
        rising,
        ObstacleSpec::plane([0.0, 0.0, -0.3], [0.3, 0.0, 1.0], restitution),
        ObstacleSpec::cuboid([0.0, 0.0, -0.4], [0.5; 3], restitution),
        ObstacleSpec::sphere([0.0, 0.0, -0.4], 0.3, restitution),
    ]
}

/// What was seen of the impacts, over all runs.
#[derive(Clone, Copy, Debug, Default)]
struct Impacts {
    count: u64,
    /// Greatest depth over `v h`, where `v` is the greatest speed of the particle so far, that of
    /// the obstacle added.
    depth: f64,
    /// Greatest lack of the velocity that restitution asks for, over that before.
    lack: f64,
    /// Impacts that leave faster than that: springs pull them off harder than the contact would
    /// push.
    pulled: u64,
    /// The same on the sheets whose springs are limp.
    pulled_limp: u64,
    /// Greatest depth of a displayed particle, and of the triangles between them, m.
    displayed: f64,
    between: f64,
}

/// Watches one run.
struct Watch<'a> {
    seen: &'a mut Impacts,
    triangles: &'a [[u32; 3]],
    restitution: f64,
    is_limp: bool,
    before: State,
    speed: Vec<f64>,
    touched: Vec<Option<u64>>,
    step: u64,
}

impl Watch<'_> {
    fn look(&mut self, system: &System, state: &State) {
        let obstacle = &system.obstacles()[0];
        let [was_at, is_at] = [self.before.t, state.t].map(|t| obstacle.offset(t));
        let surface = (is_at - was_at) / STEP;
        let depth = |x: &Vec3| {
            let (distance, normal) = obstacle.distance(&(x - is_at));
            ((-distance).max(0.0), distance, normal)
        };
        for i in 0..state.len() {
            let (distance, normal) = obstacle.distance(&(self.before.x[i] - was_at));
            let approach = -normal.dot(&(self.before.v[i] - surface));
            let flies = self.touched[i].is_none_or(|step| self.step - step > FLIGHT);
            if distance < 0.0 && approach > SLOW && flies {
                let leaves = normal.dot(&(state.v[i] - surface));
                let lack = self.restitution - leaves / approach;
                self.seen.count += 1;
                self.seen.lack = self.seen.lack.max(lack);
                let pulled = u64::from(lack < -TOLERANCE);
                self.seen.pulled += pulled;
                self.seen.pulled_limp += pulled * u64::from(self.is_limp);
            }
            if distance < 1e-9 {
                self.touched[i] = Some(self.step);
            }
            self.speed[i] = self.speed[i].max(state.v[i].norm() + surface.norm());
            let share = depth(&state.x[i]).0 / (self.speed[i] * STEP);
            self.seen.depth = self.seen.depth.max(share);
        }
        let shown: Vec<_> = state.x.iter().map(|x| x + depth(x).2 * depth(x).0).collect();
        let deepest = |points: &mut dyn Iterator<Item = Vec3>| {
            points.fold(0.0_f64, |deepest, x| deepest.max(depth(&x).0))
        };
        self.seen.displayed = self.seen.displayed.max(deepest(&mut shown.iter().copied()));
        let inside = self.triangles.iter().flat_map(|corners| {
            let [a, b, c] = corners.map(|i| shown[i as usize]);
            [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0]
        });
        self.seen.between = self.seen.between.max(deepest(&mut { inside }));
        self.before = state.clone();
        self.step += 1;
    }
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut seen = Impacts::default();
    for stiffness in [LIMP, 1e4, 1e6] {
        for (speed, restitution) in SPEEDS.into_iter().flat_map(|v| RESTITUTIONS.map(|e| (v, e))) {
            for obstacle in obstacles(restitution) {
                let mut spec = hanging(12, stiffness, 40.0).spec()?;
                spec.pins.clear();
                let n = spec.particles.mass_kg.len();
                spec.particles.velocity_m_s = vec![[0.0, 0.0, -speed]; n];
                spec.obstacles = vec![obstacle];
                let start = build(&spec)?;
                let mut watch = Watch {
                    seen: &mut seen,
                    triangles: &spec.triangles,
                    restitution,
                    is_limp: stiffness == LIMP,
                    before: start.state.clone(),
                    speed: vec![speed; n],
                    touched: vec![None; n],
                    step: 0,
                };
                let method = "imex-euler:norm=euclid,forcing_term=1e-6";
                walk(
                    &start,
                    method,
                    STEP,
                    STEPS,
                    |_, _| (),
                    |system, _, state| {
                        watch.look(system, state);
                    },
                )?;
            }
        }
    }
    Ok(numbers(&seen))
}

fn numbers(seen: &Impacts) -> Vec<Number> {
    vec![
        Number::new("greatest depth over v·h", seen.depth, "").against(1.0),
        Number::new("greatest lack of the velocity that restitution asks for", seen.lack, "")
            .against(TOLERANCE),
        Number::new("impacts", seen.count as f64, ""),
        Number::new("impacts that springs pull off faster", seen.pulled as f64, ""),
        Number::new("the same with limp springs", seen.pulled_limp as f64, "").against(0.0),
        Number::new("greatest displayed depth of a particle", seen.displayed, "m").against(0.0),
        Number::new("greatest displayed depth between particles", seen.between, "m"),
    ]
}
