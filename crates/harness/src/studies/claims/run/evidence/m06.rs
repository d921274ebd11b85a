//! What is run for claim M06.

use super::contest::{Contest, id};
use super::{Number, Trial};
use crate::HarnessError;
use crate::claims::m06::{BETTER, CHEAP, COST, ERROR, GROUNDS, LEVELS, METHODS};
use crate::claims::places::Ground;
use crate::cost::prices;
use crate::methods::Choice;
use crate::run::Runner;
use crate::studies::work_precision::run::variants::Variant;
use drape_model::TimeSpan;

pub(super) const TRIAL: Trial = Trial {
    id: "M06",
    scenes: || {
        "the hanging sheet of `work-precision` with 400 particles, 0.25 s, d/m = 40/s at k/m = \
         1e4, 1e6 and 1e8, d/m = √(k/m) at 1e6 and 1e8; all forms of all methods, but of the \
         five methods of the claim only the form that iterates until its residual is small and \
         that `work-precision` runs on all scenes"
            .to_owned()
    },
    portable: false,
    is_quick: false,
    run: evidence,
    seconds: None,
};

/// Most modelled time of a run, s.
const MOST: f64 = 1.0;
const STEP: f64 = 0.01;

/// The five iterate until their residual is small: one linear solve a step is another method.
fn is_meant(form: &Variant) -> bool {
    let iterates = !form.method.split([':', ',']).any(|setting| setting == "max_iterations=1");
    !METHODS.contains(&id(form.method)) || (form.is_run_everywhere() && iterates)
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let mut numbers = Vec::new();
    for ground in GROUNDS {
        numbers.extend(Contest::new(ground)?.efforts(&METHODS, &LEVELS, MOST, is_meant)?);
    }
    let contest = Contest::new(Ground::light(1e6))?;
    let [euler, other] =
        ["backward-euler:residual=1e-3,solver=cholesky", "dirk:residual=1e-3,solver=cholesky"]
            .map(|method| at_equal_steps(&contest, method));
    let ([error, effort], [other_error, other_effort]) = (euler?, other?);
    numbers.push(Number::new(ERROR, error / other_error, "").against(BETTER).of_machine());
    numbers.push(Number::new(COST, other_effort / effort, "").against(CHEAP).of_machine());
    Ok(numbers)
}

/// Error and modelled time, s.
fn at_equal_steps(contest: &Contest, method: &str) -> Result<[f64; 2], HarnessError> {
    let setting = &contest.setting;
    let time = TimeSpan { step_s: STEP, duration_s: setting.scene.span_s };
    let mut simulation = setting.simulation.clone();
    let outcome = Runner::new(&Choice::parse(method, &[])?, time).go(&mut simulation)?;
    Ok([setting.error(&simulation.state.x), outcome.counted.seconds(prices().of(method))])
}
