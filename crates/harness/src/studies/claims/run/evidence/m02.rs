//! What is run for claim M02.

use super::contest::Contest;
use super::{Number, Trial};
use crate::claims::m02::{FEWER, GROUNDS, LEVELS, METHOD, STABLE, SUBSTEPS, rise};
use crate::claims::places::Ground;
use crate::methods::Choice;
use crate::need::Matrix;
use crate::run::Runner;
use crate::studies::work_precision::run::variants::Variant;
use crate::{HarnessError, reference_energy};
use drape_model::TimeSpan;

pub(super) const TRIAL: Trial = Trial {
    id: "M02",
    scenes: || {
        "the hanging sheet of `work-precision` with d/m = 40/s, 0.25 s: 400 particles at \
         k/m = 1e6, 1e8 and 1e10, 1600 at 4e6, 4e8 and 4e10, 10 000 at 2.5e7, 2.5e9 and 2.5e11, \
         400 above a ball of 0.2 m at 1e6, 1e8 and 1e10; all forms of all methods, but for \
         `energy-momentum` from 1600 on and forms that factorise Newton's matrix with 10 000; \
         energies for 1 s at h = 0.01 s; references: `srkn4` at half its limit, leapfrog at an \
         eighth above the ball, none at 2.5e11"
            .to_owned()
    },
    portable: false,
    is_quick: false,
    run: evidence,
    seconds: None,
};

/// Most modelled time of a run with 400 particles, s; more for more.
const MOST: f64 = 0.32;
/// Left out where there are more than 400 particles.
const COSTLY: &str = "energy-momentum";
/// From so many particles along each edge on forms that factorise Newton's matrix are left out.
const LARGE: u32 = 100;
const STEP: f64 = 0.01;
const WATCH: f64 = 1.0;

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    for ground in GROUNDS {
        if !Contest::is_in_reach(&ground)? {
            numbers.push(Number::new(ground.doubt(), f64::INFINITY, "").of_machine());
            continue;
        }
        // A step of this method that cannot be solved factorises hundreds of times before it gives
        // up. A factor of Newton's matrix of 10 000 particles takes a tenth of a second.
        let is_meant = |form: &Variant| {
            let is_light = ground.side < LARGE || !factorises(form);
            is_light && (ground.side <= 20 || !form.method.starts_with(COSTLY))
        };
        let leaders = leaders(&numbers, &ground);
        let most = MOST * f64::from(ground.side * ground.side) / 400.0;
        let mut contest = Contest::new(ground)?;
        numbers.extend(contest.places(METHOD, &leaders, &LEVELS, most, is_meant)?);
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

/// Whether a form factorises Newton's matrix.
fn factorises(form: &Variant) -> bool {
    let choice = Choice::parse(form.method, &[]);
    choice.is_ok_and(|c| (c.theory().matrix)(c.settings()) == Matrix::BlockFactor)
}

/// The methods that led on smaller sheets of the same fabric.
fn leaders(numbers: &[Number], ground: &Ground) -> Vec<String> {
    let is_smaller = |other: &&Ground| {
        let same = ground.stiffness * f64::from(other.side * other.side);
        let own = other.stiffness * f64::from(ground.side * ground.side);
        other.side < ground.side
            && other.has_ball == ground.has_ball
            && same.total_cmp(&own).is_eq()
    };
    let prefixes: Vec<_> = GROUNDS
        .iter()
        .filter(is_smaller)
        .flat_map(|smaller| LEVELS.map(|level| smaller.effort(level, "")))
        .collect();
    let of_number = |number: &Number| {
        prefixes.iter().find_map(|prefix| number.what.strip_prefix(prefix)).map(str::to_owned)
    };
    numbers.iter().filter_map(of_number).filter(|method| method != METHOD).collect()
}
