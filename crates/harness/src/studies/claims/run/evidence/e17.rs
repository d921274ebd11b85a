//! What is run for claim C17.

use super::runs::{Track, free_edge, track};
use super::scenes::{build, hanging};
use super::{Number, Trial};
use crate::run::Simulation;
use crate::scenes::bundled;
use crate::{HarnessError, reference_energy};

pub(super) const TRIAL: Trial = Trial {
    id: "C17",
    scenes: || {
        "hanging sheets of 400 particles (k/m = 1e4, 1e5, 1e6 at h = 0.01 s, 1e6 at 0.002 s) and \
         the tables of rows 1 and 3 of table 2; IC(0), 1 s"
            .to_owned()
    },
    portable: true,
    is_quick: false,
    run: evidence,
    seconds: None,
};

/// A form of the method at a tolerance, and what stands against the start at `v_n`.
struct Form {
    name: &'static str,
    method: &'static str,
    good: &'static str,
}

const FORMS: [Form; 5] = [
    Form {
        name: "plain, ε = 0.05",
        method: "imex-euler:norm=euclid,forcing_term=0.05",
        good: "extrapolated",
    },
    Form {
        name: "plain, ε = 1e-3",
        method: "imex-euler:norm=euclid,forcing_term=1e-3",
        good: "extrapolated",
    },
    Form {
        name: "updated as printed, ε = 0.05",
        method: "imex-updated:norm=euclid,safeguard=paper,forcing_term=0.05",
        good: "extrapolated",
    },
    Form {
        name: "updated as printed, ε = 1e-3",
        method: "imex-updated:norm=euclid,safeguard=paper,forcing_term=1e-3",
        good: "extrapolated",
    },
    Form {
        name: "updated from the better start, ε = 0.01",
        method: "imex-updated:newton_above=1e300,max_outer=100000",
        good: "best",
    },
];

/// A scene with its step size, the energy that it sets free, and the way of a particle when plain
/// IMEX Euler is solved tightly.
struct Stage {
    start: Simulation,
    step: f64,
    released: f64,
    tracked: usize,
    way: f64,
}

impl Stage {
    fn new(start: Simulation, step: f64, tracked: usize) -> Result<Self, HarnessError> {
        let released = reference_energy(&start, 1.0)?;
        let way =
            track(&start, "imex-euler:norm=euclid,forcing_term=1e-8", step, 1.0, tracked)?.path;
        Ok(Self { start, step, released, tracked, way })
    }
}

fn stages() -> Result<Vec<Stage>, HarnessError> {
    let mut stages = Vec::new();
    for (stiffness, step) in [(1e4, 0.01), (1e5, 0.01), (1e6, 0.01), (1e6, 0.002)] {
        let spec = hanging(20, stiffness, 40.0).spec()?;
        stages.push(Stage::new(build(&spec)?, step, free_edge(&spec))?);
    }
    for (scene, step) in [("square-table-1e4", 0.01), ("square-table-1e6-h005", 0.005)] {
        stages.push(Stage::new(crate::scenes::build(&bundled(scene)?)?.1, step, 0)?);
    }
    Ok(stages)
}

/// How a form of the method fares with the better start against the old velocity, over all scenes.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    runs: u32,
    /// Runs with fewer iterations.
    fewer: u32,
    /// Runs that gain energy from the better start but not from the old velocity.
    broken: u32,
    /// Iterations from the better start and from the old velocity.
    iterations: [u64; 2],
    /// Greatest change of the way against plain IMEX Euler solved tightly, likewise.
    off: [f64; 2],
}

impl Tally {
    fn add(&mut self, better: &Track, last: &Track, stage: &Stage) {
        let released = stage.released;
        self.runs += 1;
        self.fewer += u32::from(better.iterations < last.iterations);
        self.broken += u32::from(last.is_stable(released) && !better.is_stable(released));
        for (k, run) in [better, last].into_iter().enumerate() {
            self.iterations[k] += run.iterations;
            self.off[k] = self.off[k].max((run.path / stage.way - 1.0).abs());
        }
    }

    fn ratio(&self) -> f64 {
        self.iterations[0] as f64 / self.iterations[1] as f64
    }
}

fn evidence() -> Result<Vec<Number>, HarnessError> {
    let stages = stages()?;
    let mut tallies = [Tally::default(); FORMS.len()];
    for (form, tally) in FORMS.iter().zip(&mut tallies) {
        for stage in &stages {
            let run = |from: &str| {
                let (id, settings) = form.method.split_once(':').unwrap_or((form.method, ""));
                let method = format!("{id}:{settings},start={from}");
                track(&stage.start, &method, stage.step, 1.0, stage.tracked)
            };
            tally.add(&run(form.good)?, &run("last")?, stage);
        }
    }
    Ok(numbers(&tallies))
}

fn numbers(tallies: &[Tally; FORMS.len()]) -> Vec<Number> {
    let mut numbers = Vec::new();
    for (form, tally) in FORMS.iter().zip(tallies) {
        let of = |what: &str| format!("{what}, {}", form.name);
        let Tally { runs, fewer, broken, off, .. } = *tally;
        numbers.push(
            Number::new(of("iterations over those from v_n"), tally.ratio(), "").against(1.0),
        );
        numbers.push(
            Number::new(of("runs with fewer"), f64::from(fewer), "").against(f64::from(runs)),
        );
        numbers.push(
            Number::new(of("runs that it alone makes unstable"), f64::from(broken), "")
                .against(0.0),
        );
        if form.method.starts_with("imex-euler") {
            numbers.push(Number::new(
                of("greatest change of the way by the tolerance"),
                off[0],
                "",
            ));
            numbers.push(Number::new(of("the same from v_n"), off[1], ""));
        }
    }
    numbers
}
