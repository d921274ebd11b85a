//! What is run for claim M02.

use super::contest::{Contest, id};
use super::{Number, Trial};
use crate::claims::m02::{FEWER, GROUNDS, LEVELS, METHOD, STABLE, SUBSTEPS, rise};
use crate::claims::places::Ground;
use crate::methods::Choice;
use crate::run::Runner;
use crate::studies::work_precision::run::variants::Variant;
use crate::{HarnessError, reference_energy};
use drape_model::TimeSpan;
use rayon::prelude::*;

pub(super) const TRIAL: Trial = Trial {
    id: "M02",
    scenes: || {
        "the hanging sheet of `work-precision` with d/m = 40/s, 0.25 s: 400 particles at \
         k/m = 1e6, 1e8 and 1e10, 1600 at 4e6 and 4e8, 400 above a ball of 0.2 m at 1e6 and 1e8; \
         all forms of all methods, but for `energy-momentum` with 1600; energies for 1 s at \
         h = 0.01 s; references: `srkn4` at half its limit, leapfrog at an eighth above the ball"
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
/// Particles along each edge, from small to large.
const SIDES: [u32; 2] = [20, 40];
const STEP: f64 = 0.01;
const WATCH: f64 = 1.0;

fn evidence() -> Result<Vec<Number>, HarnessError> {
    // Leaders on smaller sheets are tried first on larger ones. Sheets of a size run side by side:
    // on large ones the reference of each takes a core for long.
    let mut places: Vec<Vec<Number>> = vec![Vec::new(); GROUNDS.len()];
    for side in SIDES {
        let known: Vec<Number> = places.iter().flatten().cloned().collect();
        let of_size: Result<Vec<_>, HarnessError> = GROUNDS
            .into_par_iter()
            .enumerate()
            .with_max_len(1)
            .filter(|(_, ground)| ground.side == side)
            .map(|(at, ground)| Ok((at, of_ground(ground, &leaders(&known, &ground))?)))
            .collect();
        of_size?.into_iter().for_each(|(at, numbers)| places[at] = numbers);
    }
    let mut numbers: Vec<Number> = places.into_iter().flatten().collect();
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

/// The place of the method on a sheet.
fn of_ground(ground: Ground, leaders: &[String]) -> Result<Vec<Number>, HarnessError> {
    let is_meant = |form: &Variant| ground.side <= 20 || id(form.method) != COSTLY;
    let most = MOST * f64::from(ground.side * ground.side) / 400.0;
    Contest::new(ground)?.places(METHOD, leaders, &LEVELS, most, is_meant)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods;

    #[test]
    fn what_is_left_out_exists() {
        assert!(methods::all().any(|method| method.id == COSTLY));
    }
}
