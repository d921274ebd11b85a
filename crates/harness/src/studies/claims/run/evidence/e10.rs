//! What is run for claim C10.

use super::scenes::{build, hanging, shake};
use super::{Number, Trial};
use crate::HarnessError;
use crate::methods::Choice;
use crate::run::{Runner, Simulation};
use crate::schedule::Schedule;
use crate::stability::{judge, reference};
use crate::studies::sheet::Sheet;
use drape_model::{SpringEffect, SpringSpec, TimeSpan};
use rayon::prelude::*;

pub(super) const TRIAL: Trial = Trial {
    id: "C10",
    scenes: || {
        "hanging sheets of 8 × 8; explicit shear, or explicit bending springs, of 1e-4 to 1 times \
         k; k/m = 1e4, 1e6/s², d/m = 0, 40/s; h = 1e-4 to 1 s, 200 steps and 2 s or until the \
         budget ends; each with these springs in the matrix and out of it, plain CG to 1e-8 and \
         updated CG to 1e-4, both from v_n"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

const SIDE: u32 = 8;
const STEPS: [f64; 5] = [1e-4, 1e-3, 1e-2, 1e-1, 1.0];
const STIFFNESSES: [f64; 2] = [1e4, 1e6];
const DAMPINGS: [f64; 2] = [0.0, 40.0];
/// Stiffness of the explicit springs over that of tension; the paper's fabrics have 1e-4 to 0.1.
const RATIOS: [f64; 6] = [1e-4, 1e-3, 1e-2, 0.1, 0.3, 1.0];
/// Plain CG, and Algorithm 1 from v_n, so that no predictor interferes; both solved well.
const METHODS: [(&str, &str); 2] = [
    ("plain", "imex-euler:norm=euclid,forcing_term=1e-8,start=last"),
    (
        "updated",
        "imex-updated:norm=euclid,safeguard=paper,forcing_term=1e-4,start=last,max_outer=1000",
    ),
];
/// Most visits of a spring in a run, and in one with many small steps, where explicit springs are
/// stable anyway.
const BUDGET: f64 = 2e7;
const SMALL_BUDGET: f64 = 2e6;

/// Which springs stay out of the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Extra {
    Shear,
    Bending,
}

impl Extra {
    fn name(self) -> &'static str {
        match self {
            Self::Shear => "shear",
            Self::Bending => "bending",
        }
    }
}

/// A hanging sheet with shear springs, or bending springs over two mesh widths, of `ratio · k`.
fn scene(
    stiffness: f64,
    damping: f64,
    extra: Extra,
    ratio: f64,
) -> Result<Simulation, HarnessError> {
    let sheet = hanging(SIDE, stiffness, damping);
    let mut start = match extra {
        Extra::Shear => build(&Sheet { shear: ratio * stiffness, ..sheet }.spec()?)?,
        Extra::Bending => {
            let mut spec = sheet.spec()?;
            let tension = spec.springs[0].clone();
            let spring = |i: u32, j: u32| SpringSpec {
                effect: SpringEffect::Bending,
                i,
                j,
                rest_length_m: 2.0 * tension.rest_length_m,
                stiffness_n_per_m: ratio * tension.stiffness_n_per_m,
                damping_n_s_per_m: 0.0,
                ..SpringSpec::default()
            };
            for row in 0..SIDE {
                for column in 0..SIDE - 2 {
                    let along = row * SIDE + column;
                    let across = column * SIDE + row;
                    spec.springs.push(spring(along, along + 2));
                    spec.springs.push(spring(across, across + 2 * SIDE));
                }
            }
            build(&spec)?
        }
    };
    shake(&mut start, 1e-6, 1);
    Ok(start)
}

/// One combination with the explicit springs in the matrix and out of it.
#[derive(Clone, Debug)]
struct Pair {
    extra: Extra,
    ratio: f64,
    method: &'static str,
    /// Stable with all springs in the matrix, or without a ratio to speak of.
    was_stable: bool,
    is_stable: bool,
}

/// Whether a method is stable over 200 steps, or 2 s if the budget allows; over budget counts as
/// far as it came.
fn is_stable(
    start: &Simulation,
    method: &str,
    step: f64,
    released: f64,
) -> Result<bool, HarnessError> {
    let duration_s = (200.0 * step).max(2.0);
    let schedule = Schedule::steady(TimeSpan { step_s: step, duration_s });
    let choice = Choice::parse(method, &[])?;
    let budget = if step < 5e-3 { SMALL_BUDGET } else { BUDGET };
    let run = Runner::by(&choice, &schedule).budget(budget).count(start)?;
    let verdict = judge(&run.energy, run.rule, released);
    Ok(run.outcome.divergence.is_none() && verdict == drape_report::Verdict::Stable)
}

fn pairs(
    (extra, ratio, step): (Extra, f64, f64),
    stiffness: f64,
    damping: f64,
) -> Result<Vec<Pair>, HarnessError> {
    let start = scene(stiffness, damping, extra, ratio)?;
    let tame = scene(stiffness.min(1e5), damping, extra, ratio)?;
    let span = Schedule::steady(TimeSpan { step_s: 0.01, duration_s: 2.0 });
    let released = reference(&tame, &span)?.energy;
    METHODS
        .iter()
        .map(|(name, settings)| {
            let run = |implicit: &str| {
                is_stable(&start, &format!("{settings},implicit={implicit}"), step, released)
            };
            Ok(Pair {
                extra,
                ratio,
                method: name,
                was_stable: run("springs")?,
                is_stable: run("tension")?,
            })
        })
        .collect()
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut places = Vec::new();
    for extra in [Extra::Shear, Extra::Bending] {
        for ratio in RATIOS {
            for step in STEPS {
                for stiffness in STIFFNESSES {
                    places
                        .extend(DAMPINGS.map(|damping| ((extra, ratio, step), stiffness, damping)));
                }
            }
        }
    }
    let runs = places.par_iter().with_max_len(1).map(|&(place, k, d)| pairs(place, k, d));
    let runs: Vec<Vec<Pair>> = runs.collect::<Result<_, _>>()?;
    Ok(numbers(&runs.concat()))
}

/// Least ratio at which a stable step is lost.
fn first_loss(pairs: &[Pair], method: &str, extra: Extra) -> Option<f64> {
    let lost = |pair: &&Pair| {
        pair.method == method && pair.extra == extra && pair.was_stable && !pair.is_stable
    };
    pairs.iter().filter(lost).map(|pair| pair.ratio).min_by(f64::total_cmp)
}

fn numbers(pairs: &[Pair]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for (method, _) in METHODS {
        for extra in [Extra::Shear, Extra::Bending] {
            let of = |pair: &&Pair| pair.method == method && pair.extra == extra && pair.was_stable;
            let stable = pairs.iter().filter(of).count();
            let lost = pairs.iter().filter(of).filter(|pair| !pair.is_stable).count();
            let name = format!("{method} CG, explicit {}", extra.name());
            numbers.push(Number::new(
                format!("stable with it in the matrix, {name}"),
                stable as f64,
                "",
            ));
            numbers.push(
                Number::new(format!("of these lost without, {name}"), lost as f64, "").against(0.0),
            );
            let first = first_loss(pairs, method, extra);
            if let Some(ratio) = first {
                numbers.push(Number::new(format!("least ratio that fails, {name}"), ratio, ""));
            }
        }
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(ratio: f64, was_stable: bool, is_stable: bool) -> Pair {
        let extra = Extra::Shear;
        Pair { extra, ratio, method: "plain", was_stable, is_stable }
    }

    #[test]
    fn only_stable_steps_can_be_lost() {
        let found = |pairs: &[Pair]| {
            let numbers = numbers(pairs);
            let of = |what: &str| {
                let name = format!("{what}, plain CG, explicit shear");
                numbers.iter().find(|number| number.what == name).map(|number| number.value)
            };
            (of("of these lost without"), of("least ratio that fails"))
        };
        let kept = [pair(0.1, true, true), pair(1.0, false, false)];
        assert_eq!(found(&kept), (Some(0.0), None));
        let lost = [pair(0.1, true, true), pair(1.0, true, false), pair(0.5, true, false)];
        assert_eq!(found(&lost), (Some(2.0), Some(0.5)));
    }
}
