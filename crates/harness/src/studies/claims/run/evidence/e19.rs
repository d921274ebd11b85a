//! What is run for claim C19.

use super::runs::walk;
use super::scenes::{build, greatest, hanging, least};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::c19::LIMIT;
use crate::run::Simulation;
use crate::studies::collision;
use drape_model::{ContactSpec, Detection, ObstacleSpec, State, System};

pub(super) const TRIAL: Trial = Trial {
    id: "C19",
    scenes: || {
        "a sheet of 400 particles falls at 2 and 10 m/s on a tilted plane, a table and a sphere; \
         k/m = 1e4 and 1e6, h = 0.01 s, 0.4 s, no limit to the speed of recovery; and the paper's \
         system in the scenes of the study `collision`"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const STEPS: u64 = 40;
const STEP: f64 = 0.01;
/// Speeds of the fall at the start, m/s: a particle enters by a third of a mesh width or by two.
const SPEEDS: [f64; 2] = [2.0, 10.0];
/// The paper's system in several settings; updated CG from the old velocity, since its predictor
/// gains energy.
const OWN: [(&str, &str); 3] = [
    ("plain, ε = 0.05", "imex-euler:norm=euclid,forcing_term=0.05"),
    ("plain, ε = 1e-6", "imex-euler:norm=euclid,forcing_term=1e-6"),
    ("updated, ε = 0.05", "imex-updated:norm=euclid,forcing_term=0.05,safeguard=paper,start=last"),
];

/// What the sheet falls on; its top lies 2 cm below it.
const OBSTACLES: [ObstacleSpec; 3] = [
    ObstacleSpec::plane([0.0, 0.0, -0.02], [0.1, 0.0, 1.0], 0.0),
    ObstacleSpec::cuboid([0.0, 0.0, -0.27], [0.5, 0.5, 0.5], 0.0),
    ObstacleSpec::sphere([0.0, 0.0, -0.32], 0.3, 0.0),
];

fn scene(obstacle: ObstacleSpec, stiffness: f64, speed: f64) -> Result<Simulation, HarnessError> {
    let mut spec = hanging(20, stiffness, 40.0).spec()?;
    spec.pins.clear();
    spec.particles.velocity_m_s = vec![[0.0, 0.0, -speed]; spec.particles.mass_kg.len()];
    spec.obstacles = vec![obstacle];
    // The paper knows no limit to the speed at which a particle is led out.
    let detection = Detection::Penetration;
    spec.effects.contact = Some(ContactSpec { detection, recovery_speed_limit_m_s: 1e9 });
    build(&spec)
}

/// Puts what lies inside an obstacle on its surface.
fn reposition(system: &System, state: &mut State) {
    for x in &mut state.x {
        for obstacle in system.obstacles() {
            let (depth, normal) = obstacle.distance(x);
            if depth < 0.0 {
                *x -= normal * depth;
            }
        }
    }
}

fn count(
    start: &Simulation,
    method: &str,
    before: fn(&System, &mut State),
) -> Result<f64, HarnessError> {
    let mut iterations = 0;
    walk(start, method, STEP, STEPS, before, |_, report, _| iterations += report.cg_iterations)?;
    Ok(f64::from(iterations))
}

/// Iterations with repositioning over those with the velocity constraint, in all scenes of one
/// method at one speed.
struct Series {
    label: String,
    is_own: bool,
    ratios: Vec<f64>,
}

impl Series {
    fn least(&self) -> f64 {
        least(self.ratios.iter().copied())
    }

    fn greatest(&self) -> f64 {
        greatest(self.ratios.iter().copied())
    }
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut all = Vec::new();
    for speed in SPEEDS {
        let mut scenes = Vec::new();
        for obstacle in OBSTACLES {
            for stiffness in [1e4, 1e6] {
                scenes.push(scene(obstacle.clone(), stiffness, speed)?);
            }
        }
        for (name, method) in OWN {
            let ratio = |start: &Simulation| {
                Ok(count(start, method, reposition)? / count(start, method, |_, _| ())?)
            };
            let ratios = scenes.iter().map(ratio).collect::<Result<_, HarnessError>>()?;
            let label = format!("IMEX Euler, {name}, {speed} m/s");
            all.push(Series { label, is_own: true, ratios });
        }
        let ratio = |start: &Simulation| {
            let of = |way: &str| count(start, &format!("baraff-witkin:contact={way}"), |_, _| ());
            Ok(of("position")? / of("velocity")?)
        };
        let ratios = scenes.iter().map(ratio).collect::<Result<_, HarnessError>>()?;
        all.push(Series { label: format!("Baraff-Witkin, {speed} m/s"), is_own: false, ratios });
    }
    let mut numbers = numbers(&all);
    numbers.extend(in_collision()?);
    Ok(numbers)
}

/// The ratios in the scenes of the study `collision`, by its own count: iterations a step from the
/// first contact on, where neither run gains energy.
fn in_collision() -> Result<[Number; 3], HarnessError> {
    let rows = collision::run::repositioned()?;
    let ratios = collision::facts::ratios(&rows);
    let many = ratios.iter().filter(|ratio| **ratio >= LIMIT).count();
    Ok([
        Number::new("scenes of `collision`", ratios.len() as f64, ""),
        Number::new("scenes of `collision` with a ratio of at least 2", many as f64, ""),
        Number::new("greatest ratio in a scene of `collision`", greatest(ratios), "")
            .against(LIMIT),
    ])
}

fn numbers(all: &[Series]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for series in all {
        let least = Number::new(format!("least ratio, {}", series.label), series.least(), "");
        numbers.push(if series.is_own { least.against(LIMIT) } else { least });
        let what = format!("greatest ratio, {}", series.label);
        numbers.push(Number::new(what, series.greatest(), ""));
    }
    numbers
}
