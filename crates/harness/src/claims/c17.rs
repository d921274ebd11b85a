//! C17: the extrapolated start helps.

use super::runs::{Track, free_edge, track};
use super::scenes::{build, hanging};
use super::{Claim, Finding, Number, Verdict};
use crate::run::Simulation;
use crate::scenes::bundled;
use crate::{HarnessError, reference_energy, studies::short};

pub(super) const CLAIM: Claim = Claim {
    id: "C17",
    section: "5",
    says: "the extrapolated start helps",
    criterion: "fewer iterations at equal energy behaviour",
    is_quick: false,
    test,
    seconds: None,
};

/// A form of the method at a tolerance, and what stands against the start at `v_n`.
struct Form {
    name: &'static str,
    method: &'static str,
    good: &'static str,
    /// Whether it is the paper's, which decides.
    is_paper: bool,
}

const FORMS: [Form; 5] = [
    Form {
        name: "plain, ε = 0.05",
        method: "imex-euler:forcing_term=0.05",
        good: "extrapolated",
        is_paper: true,
    },
    Form {
        name: "plain, ε = 1e-3",
        method: "imex-euler:forcing_term=1e-3",
        good: "extrapolated",
        is_paper: true,
    },
    Form {
        name: "updated as printed, ε = 0.05",
        method: "imex-updated:safeguard=paper,forcing_term=0.05",
        good: "extrapolated",
        is_paper: true,
    },
    Form {
        name: "updated as printed, ε = 1e-3",
        method: "imex-updated:safeguard=paper,forcing_term=1e-3",
        good: "extrapolated",
        is_paper: true,
    },
    Form {
        name: "updated from the better start, ε = 0.01",
        method: "imex-updated:newton_above=1e300,max_outer=100000",
        good: "best",
        is_paper: false,
    },
];

/// A scene with its step size, the energy that it sets free, and the way of a particle when plain IMEX Euler is solved tightly.
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
        let way = track(&start, "imex-euler:forcing_term=1e-8", step, 1.0, tracked)?.path;
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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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

    fn helps(&self) -> bool {
        self.fewer == self.runs && self.broken == 0
    }
}

fn test() -> Result<Finding, HarnessError> {
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
    Ok(judge(&tallies))
}

fn judge(tallies: &[Tally; FORMS.len()]) -> Finding {
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
    let paper = FORMS.iter().zip(tallies).filter(|(form, _)| form.is_paper);
    let is_met = paper.clone().all(|(_, tally)| tally.helps());
    let broken: u32 = paper.clone().map(|(_, tally)| tally.broken).sum();
    let runs: u32 = paper.clone().map(|(_, tally)| tally.runs).sum();
    let [loose, tight, loose_updated, tight_updated, safe] = tallies;
    Finding {
        verdict: Verdict::of(is_met),
        numbers,
        reason: format!(
            "At ε = 1e-3 the extrapolated start takes {} (plain) and {} (updated) times the iterations of the start at v_n, at the \
             paper's ε = 0.05 {} and {} times, and it alone makes {broken} of {runs} runs unstable. At the loose tolerance v_n itself \
             often passes the test, which leaves motion out (its way is off by up to {} of that solved tightly), and an extrapolation that passes it goes uncorrected and feeds on itself.",
            short(tight.ratio()),
            short(tight_updated.ratio()),
            short(loose.ratio()),
            short(loose_updated.ratio()),
            short(loose.off[1])
        ),
        repair: (!is_met && safe.broken == 0 && safe.ratio() < 1.0).then(|| {
            format!(
                "take the extrapolation only where the incremental potential is lower there than at v_n, and measure the residual by \
             the forces: {} times the iterations of v_n, no run unstable.",
                short(safe.ratio())
            )
        }),
        scenes: "hanging sheets of 400 particles (k/m = 1e4, 1e5, 1e6 at h = 0.01 s, 1e6 at 0.002 s) and the tables of rows 1 and 3 of \
             table 2; IC(0), 1 s"
            .to_owned(),
        see: "cg-vs-forcing-term.svg",
        portable: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_of_the_paper_must_gain_and_lose_nothing() {
        let good = Tally { runs: 6, fewer: 6, iterations: [1, 2], ..Tally::default() };
        let with = |changed: usize, tally: Tally| {
            let mut tallies = [good; FORMS.len()];
            tallies[changed] = tally;
            judge(&tallies).verdict
        };
        assert_eq!(with(0, good), Verdict::Confirmed);
        assert_eq!(with(1, Tally { fewer: 5, ..good }), Verdict::Refuted);
        assert_eq!(with(2, Tally { broken: 1, ..good }), Verdict::Refuted);
        assert_eq!(with(4, Tally { broken: 1, ..good }), Verdict::Confirmed);
    }
}
