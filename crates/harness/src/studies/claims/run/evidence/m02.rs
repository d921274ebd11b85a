//! What is run for claim M02.

use super::contest::Contest;
use super::{Number, Trial};
use crate::claims::m02::{FEWER, GROUNDS, LEVELS, METHOD, STABLE, SUBSTEPS, rise};
use crate::claims::places::Ground;
use crate::methods::Choice;
use crate::run::Runner;
use crate::studies::work_precision::run::variants::Variant;
use crate::{HarnessError, reference_energy};
use drape_model::TimeSpan;

pub(super) const TRIAL: Trial = Trial {
    id: "M02",
    scenes: || {
        "the hanging sheet of `work-precision` with d/m = 40/s, 0.25 s: 400 particles at \
         k/m = 1e6, 1e8 and 1e10, 1600 at 4e6, 4e8 and 4e10, 400 above a \
         ball of 0.2 m at 1e6, 1e8 and 1e10; all forms of all methods, but for `energy-momentum` \
         with 1600; energies for 1 s at h = 0.01 s; references: `srkn4` at half its limit, \
         leapfrog at an eighth \
         above the ball"
            .to_owned()
    },
    portable: false,
    is_quick: false,
    run: evidence,
    seconds: None,
};

/// Most modelled time of a run with 400 particles, s; more for more.
const MOST: f64 = 0.12;
/// Left out where there are more than 400 particles.
const COSTLY: &str = "energy-momentum";
const STEP: f64 = 0.01;
const WATCH: f64 = 1.0;

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    for ground in GROUNDS {
        // A step of this method that cannot be solved factorises hundreds of times before it gives
        // up.
        let is_meant = |form: &Variant| ground.side <= 20 || !form.method.starts_with(COSTLY);
        let most = MOST * f64::from(ground.side * ground.side) / 400.0;
        numbers.extend(Contest::new(ground)?.efforts(&[METHOD], &LEVELS, most, is_meant)?);
    }
    // A stiff sheet sets free what a soft one does: it falls as far.
    let soft = Contest::start(&Ground::light(1e6))?;
    let released = reference_energy(&soft, WATCH)?;
    for (stiffness, substeps) in SUBSTEPS {
        let start = Contest::start(&Ground::light(stiffness))?;
        for substeps in [substeps / FEWER, substeps] {
            let choice = Choice::parse(METHOD, &[format!("substeps={substeps}")])?;
            let time = TimeSpan { step_s: STEP, duration_s: WATCH };
            let gain = Runner::new(&choice, time).count(&start)?.energy.gain / released;
            numbers.push(Number::new(rise(stiffness, substeps), gain, "").against(STABLE));
        }
    }
    Ok(numbers)
}
