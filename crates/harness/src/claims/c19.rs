//! C19: repositioning causes a severe increase of CG iterations.

use super::runs::walk;
use super::scenes::{build, hanging};
use super::{Claim, Finding, Number, Verdict};
use crate::HarnessError;
use crate::run::Simulation;
use crate::studies::short;
use drape_model::{ContactSpec, Detection, ObstacleSpec, State, System};

pub(super) const CLAIM: Claim = Claim {
    id: "C19",
    section: "6",
    says: "repositioning causes a severe increase of CG iterations",
    criterion: "≥ 2 times those of the velocity constraint, same scene",
    is_quick: false,
    test,
    seconds: None,
};

const LIMIT: f64 = 2.0;
const STEPS: u64 = 40;
const STEP: f64 = 0.01;
/// Speeds of the fall at the start, m/s: a particle enters by a third of a mesh width or by two.
const SPEEDS: [f64; 2] = [2.0, 10.0];
/// The paper's system in several settings; updated CG from the old velocity, since its predictor gains energy.
const OWN: [(&str, &str); 3] = [
    ("plain, ε = 0.05", "imex-euler:forcing_term=0.05"),
    ("plain, ε = 1e-6", "imex-euler:forcing_term=1e-6"),
    ("updated, ε = 0.05", "imex-updated:forcing_term=0.05,safeguard=paper,start=last"),
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

/// Iterations with repositioning over those with the velocity constraint, in all scenes of one method at one speed.
struct Series {
    label: String,
    is_own: bool,
    ratios: Vec<f64>,
}

impl Series {
    fn least(&self) -> f64 {
        self.ratios.iter().fold(f64::INFINITY, |least, ratio| least.min(*ratio))
    }

    fn greatest(&self) -> f64 {
        self.ratios.iter().fold(0.0, |greatest, ratio| ratio.max(greatest))
    }
}

fn test() -> Result<Finding, HarnessError> {
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
    Ok(judge(&all))
}

/// Decides by the paper's own system; Baraff and Witkin's stands beside it.
fn judge(all: &[Series]) -> Finding {
    let mut numbers = Vec::new();
    for series in all {
        let least = Number::new(format!("least ratio, {}", series.label), series.least(), "");
        numbers.push(if series.is_own { least.against(LIMIT) } else { least });
        let what = format!("greatest ratio, {}", series.label);
        numbers.push(Number::new(what, series.greatest(), ""));
    }
    let of = |is_own: bool| {
        let ratios = all.iter().filter(|series| series.is_own == is_own);
        let ratios: Vec<_> = ratios.flat_map(|series| &series.ratios).copied().collect();
        let severe = ratios.iter().filter(|ratio| **ratio >= LIMIT).count();
        let low = ratios.iter().fold(f64::INFINITY, |low: f64, ratio| low.min(*ratio));
        let high = ratios.iter().fold(0.0, |high: f64, ratio| high.max(*ratio));
        let range = format!("{} to {} times", short(low), short(high));
        (severe, ratios.len(), range)
    };
    let (own, theirs) = (of(true), of(false));
    let verdict = Verdict::of(own.0 == own.1);
    let why = if verdict == Verdict::Refuted {
        " Both ways move a particle by its depth within the step, and to the matrix it is the same whether a spring is stretched by \
         a prescribed velocity or beforehand."
    } else {
        ""
    };
    Finding {
        verdict,
        numbers,
        reason: format!(
            "Putting penetrating particles on the surface takes {} the iterations of the velocity constraint in IMEX Euler and {} in \
             Baraff and Witkin's step; at least twice as many in {} of {} and {} of {} runs.{why}",
            own.2, theirs.2, own.0, own.1, theirs.0, theirs.1
        ),
        repair: None,
        scenes: "a sheet of 400 particles falls at 2 and 10 m/s on a tilted plane, a table and a sphere; k/m = 1e4 and 1e6, h = 0.01 s, \
                 0.4 s, no limit to the speed of recovery"
            .to_owned(),
        see: "collision-iterations.svg",
        portable: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_of_the_papers_system_must_show_the_increase() {
        let of = |ratios: [f64; 2]| {
            let theirs = Series { label: String::new(), is_own: false, ratios: vec![1.0] };
            let own = Series { label: String::new(), is_own: true, ratios: ratios.to_vec() };
            judge(&[own, theirs]).verdict
        };
        assert_eq!(of([2.0, 5.0]), Verdict::Confirmed);
        assert_eq!(of([1.9, 5.0]), Verdict::Refuted);
    }
}
