//! What is run for claim M05.

use super::runs::{Track, free_edge, track, true_motion};
use super::scenes::{build, hanging};
use super::{Number, Trial};
use crate::claims::m05::{LOCKED, SOFT, STABLE, STIFF, TABLEAUX, rise, way};
use crate::run::Simulation;
use crate::studies::sheet::Sheet;
use crate::{HarnessError, reference_energy};

pub(super) const TRIAL: Trial = Trial {
    id: "M05",
    scenes: || {
        "a hanging sheet of 400 particles, at first horizontal, d/m = 40/s, k/m = 1e6, 1e8 and \
         1e10, shear springs of a tenth of it; h = 0.01 s, 0.3 s for the way and 2 s for the \
         energy"
            .to_owned()
    },
    portable: false,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const STEP: f64 = 0.01;
/// Time in which the way is measured, and in which the energy is watched, s.
const FALL: f64 = 0.3;
const WATCH: f64 = 2.0;

/// A sheet, the particle that is followed, its true way, and the energy that the fall sets free.
struct Stage {
    stiffness: f64,
    start: Simulation,
    tracked: usize,
    way: f64,
    released: f64,
}

impl Stage {
    fn new(stiffness: f64) -> Result<Self, HarnessError> {
        let spec = Sheet { shear: 0.1 * stiffness, ..hanging(20, stiffness, 40.0) }.spec()?;
        let (start, tracked) = (build(&spec)?, free_edge(&spec));
        // A stiff sheet sets free what a soft one does: it falls as far.
        let soft = Sheet { shear: 0.1 * SOFT, ..hanging(20, SOFT, 40.0) }.spec()?;
        let released = reference_energy(&build(&soft)?, WATCH)?;
        let way = true_motion(&start, FALL, tracked)?.path;
        Ok(Self { stiffness, start, tracked, way, released })
    }

    fn run(&self, method: &str, duration: f64) -> Result<Track, HarnessError> {
        track(&self.start, method, STEP, duration, self.tracked)
    }

    fn kept(&self, form: &str, method: &str) -> Result<Number, HarnessError> {
        let kept = self.run(method, FALL)?.path / self.way;
        Ok(Number::new(way(self.stiffness, form), kept, ""))
    }
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    for stiffness in [SOFT].into_iter().chain(STIFF) {
        let stage = Stage::new(stiffness)?;
        for tableau in TABLEAUX {
            let method = format!("imex-rk:tableau={tableau}");
            let kept = stage.kept(tableau, &method)?;
            let kept = if stiffness == SOFT { kept } else { kept.against(LOCKED) };
            let gain = stage.run(&method, WATCH)?.gain / stage.released;
            let gained = Number::new(rise(stiffness, tableau), gain, "").against(STABLE);
            // What blows up differs from machine to machine.
            let told = |number: Number| if gain > STABLE { number.of_machine() } else { number };
            numbers.extend([kept, gained].map(told));
        }
        if stiffness == SOFT {
            numbers.push(stage.kept("IMEX Euler", "imex-euler:forcing_term=1e-8")?);
        }
    }
    Ok(numbers)
}
