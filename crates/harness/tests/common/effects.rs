//! A synthetic record of the experiment `effects`.

use super::{provenance, record};
use drape_harness::studies::effects::facts::{
    Cell, EVERYTHING, Effect, Facts, NOTHING, Support, TimingRow,
};
use drape_report::Verdict;
use drape_report::{Record, TIMINGS_FORMAT, Timings};

const METHODS: [&str; 2] = ["leapfrog", "imex-euler"];
const NAMES: [&str; 3] = [NOTHING, "shear springs", EVERYTHING];

/// Counts and changes of one effect with two methods, of which one diverges.
pub(crate) fn effects() -> Record<Facts> {
    let effect = |(n, name): (usize, &&str)| Effect {
        name: (*name).to_owned(),
        adds: format!("{{\"effects\":{{\"number\":{n}}}}}"),
        objects: 2 + n,
        springs: 760 * (n + 1),
        coupled_pairs: 760 * (n + 1),
    };
    let support = |effect: &str, method: &str, treatment: &str| Support {
        effect: effect.to_owned(),
        method: method.to_owned(),
        treatment: treatment.to_owned(),
    };
    let cell = |effect: &str, method: &str| Cell {
        effect: effect.to_owned(),
        method: method.to_owned(),
        step_s: 0.01,
        verdict: if effect == EVERYTHING { Verdict::Diverged } else { Verdict::Completed },
        steps: 50,
        cg_iterations: 321,
        newton_iterations: 0,
        matvecs: 371,
        force_evaluations: 50,
        setups: 1,
        change_m: (effect != NOTHING).then_some(0.0123),
        portable: true,
    };
    let cells =
        NAMES.iter().flat_map(|effect| METHODS.map(|method| cell(effect, method))).collect();
    let facts = Facts {
        scene: "{}".to_owned(),
        duration_s: 0.5,
        effects: NAMES.iter().enumerate().map(effect).collect(),
        methods: METHODS.map(str::to_owned).into(),
        supports: (0..20)
            .flat_map(|n| {
                let effect = format!("effect {n}");
                [
                    support(&effect, METHODS[0], "explicit"),
                    support(&effect, METHODS[1], if n == 7 { "refused" } else { "implicit" }),
                ]
            })
            .collect(),
        cells,
    };
    record("effects", false, facts)
}

/// Its times.
pub(crate) fn effects_timings() -> Timings<TimingRow> {
    let row = |effect: &str| TimingRow {
        effect: effect.to_owned(),
        method: METHODS[1].to_owned(),
        steps: 50,
        without_ns: vec![1000; 3],
        with_ns: vec![1500; 3],
        ratio: 1.5,
        system_bytes: Some(24_000),
        method_bytes: Some(-1200),
    };
    Timings {
        format: TIMINGS_FORMAT.to_owned(),
        experiment: "effects".to_owned(),
        method: "In turns.".to_owned(),
        rows: NAMES[1..].iter().map(|name| row(name)).collect(),
        provenance: provenance(),
    }
}
