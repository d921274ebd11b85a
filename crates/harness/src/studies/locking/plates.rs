//! Figures and tables of the experiment `locking`.

use super::facts::{
    BASE_STEP as STEP, BASE_STIFFNESS as STIFFNESS, Facts, IMEX_EULER, Run, Spring,
    agrees_with_prototype, first_locked,
};
use crate::families::{families, labels, looks};
use drape_report::Verdict;
use drape_report::number::{power, setting, significant, trimmed};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{At, Axis, Panel, Point, Rule, Series, Sheet, State, values};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "locking-stiffness.svg",
        title: "Motion that is kept, against stiffness",
        caption: "Backward Euler, BDF2 and safeguarded updated CG keep nearly all of the motion at \
            every stiffness; IMEX Euler keeps less than half from 10⁵ s⁻² on. Path of the free \
            edge's midpoint in one second over the true one, against k/m; sheet of 20 × 20 \
            particles, h = 0.01 s, d/m = 40 s⁻¹. Runs that gained energy are crossed out, because \
            their long paths do not mean success.",
        draw: Draw::Sheet(by_stiffness),
    },
    Plate {
        file: "locking-step.svg",
        title: "Motion that is kept, against the time step",
        caption: "IMEX Euler and Desbrun keep half of the motion only at steps shorter than the \
            dotted limit of leapfrog. There an explicit method is stable too, and cheaper. Path \
            of the free edge's midpoint in one second over the true one, against h; k/m = 10⁶ \
            s⁻². Runs over budget are left out.",
        draw: Draw::Sheet(by_step),
    },
    Plate {
        file: "locking-terminal.svg",
        title: "Speed of fall of a locked sheet beside the law",
        caption: "The slowest sheets lie on the dashed line, the law; in a sheet that has sagged \
            the pins carry weight too, and it falls more slowly. Mean speed of the free edge's \
            midpoint from 0.5 s to 1 s, against the terminal speed v = a u/(h k/m), at which the \
            artificial damping d = hk of every spring balances gravity. Each locked run is one \
            point.",
        draw: Draw::Sheet(terminal),
    },
    Plate {
        file: "locking-spring.svg",
        title: "A single spring, loaded across itself: speed over that of free fall",
        caption: "Both panels are alike: a spring locks whether its exact Hessian couples \
            coordinates (oblique) or not (along x). It locks because the matrix has a stiffness \
            across the spring and the Hessian does not. One particle on an anchored spring at \
            rest length, h = 0.01 s; speed after one second, where 1 is true, against θ.",
        draw: Draw::Sheet(springs),
    },
];

/// A sheet that retains less of its motion is locked.
const HALF: f64 = 0.5;

fn identity(run: &Run) -> (&str, &str) {
    (&run.method, &run.label)
}

fn state(verdict: Verdict) -> State {
    if verdict == Verdict::Locked { State::Stable } else { State::of_verdict(verdict) }
}

fn by_stiffness(input: &Input) -> Option<Sheet> {
    let runs: Vec<_> = input.facts.runs.iter().filter(|run| run.step_s == STEP).collect();
    let label = "stiffness over mass k/m (s⁻²)";
    retained(&runs, label, |run| run.stiffness_over_mass_per_s2, None)
}

fn by_step(input: &Input) -> Option<Sheet> {
    let runs = input.facts.runs.iter();
    let runs: Vec<_> = runs.filter(|run| run.stiffness_over_mass_per_s2 == STIFFNESS).collect();
    // Shear springs have a tenth of the stiffness, so λ ≤ 8 (k + k_s)/m.
    let explicit = 2.0 / libm::sqrt(8.8 * STIFFNESS);
    retained(&runs, "time step h (s)", |run| run.step_s, Some(explicit))
}

/// Greater retained motion is drawn here: it is no success.
const MOST: f64 = 1.4;

/// A panel for each family of methods. Only a sweep over at least two values is drawn. `explicit`
/// is the limit of leapfrog.
fn retained(
    runs: &[&Run],
    x_label: &str,
    x: impl Fn(&Run) -> f64,
    explicit: Option<f64>,
) -> Option<Sheet> {
    let xs: Vec<f64> = runs.iter().map(|run| x(run)).collect();
    let mut panels = Vec::new();
    for family in families(runs.iter().map(|run| identity(run))) {
        let mut panel = Panel::new(
            vec![family.title.to_owned()],
            Axis::log(x_label, &xs),
            Axis::linear("retained motion R", &[0.0, MOST]),
        );
        panel.series = family
            .members
            .iter()
            .filter_map(|(label, look)| {
                let of = runs
                    .iter()
                    .filter(|run| run.label == *label && run.verdict != Verdict::OverBudget);
                let points = of.map(|run| Point {
                    x: x(run),
                    y: run.retained.unwrap_or(MOST).min(MOST),
                    state: state(run.verdict),
                });
                Series::new((*label).to_owned(), *look, points.collect())
            })
            .collect();
        panel.rules.push(Rule { label: "half of the motion".to_owned(), at: At::Y(HALF) });
        panel.rules.extend(
            explicit.map(|limit| Rule { label: "limit of leapfrog".to_owned(), at: At::X(limit) }),
        );
        panels.push(panel);
    }
    (values(xs.into_iter()).len() > 1).then_some(Sheet { panels, notes: Vec::new() })
}

/// Methods whose matrix has the whole stiffness: of all springs, or of the tension springs only.
const CREEPING: [&str; 3] = [IMEX_EULER, "desbrun", "imex-euler, tension only"];
/// Slower falls are drawn on the lower edge.
const SLOWEST: f64 = 1e-3;

fn terminal(input: &Input) -> Option<Sheet> {
    let of = |label: &str| {
        let runs = input.facts.runs.iter().filter(|run| run.label == label);
        let locked = runs.filter(|run| run.verdict == Verdict::Locked);
        let points = locked.filter_map(|run| {
            let y = run.late_speed_m_s.filter(|speed| *speed > SLOWEST)?;
            Some(Point { x: run.law_m_s, y, state: State::Stable })
        });
        points.collect::<Vec<_>>()
    };
    let points: Vec<_> = CREEPING.map(of).into();
    let all = || points.iter().flatten();
    let xs: Vec<f64> = all().map(|point| point.x).collect();
    let ys: Vec<f64> = all().map(|point| point.y).collect();
    let mut panel = Panel::new(
        Vec::new(),
        Axis::log("terminal speed of the law (m/s)", &xs),
        Axis::log("speed of fall, 0.5 s to 1 s (m/s)", &ys),
    );
    let looks = looks(&CREEPING);
    for (n, (label, points)) in CREEPING.into_iter().zip(points.clone()).enumerate() {
        let series = Series::new(label.to_owned(), looks[n], points);
        panel.series.extend(series.map(Series::apart));
    }
    let least = xs.iter().copied().reduce(f64::min)?;
    let at = At::Slope { order: 1.0, x: least, y: least };
    panel.rules.push(Rule { label: "the law".to_owned(), at });
    let notes = vec![
        "With tension springs only in the matrix less than the law's damping acts.".to_owned(),
    ];
    Some(Sheet { panels: vec![panel], notes })
}

fn springs(input: &Input) -> Option<Sheet> {
    let springs = &input.facts.springs;
    let names = labels(springs.iter().map(|s| (s.method.as_str(), s.label.as_str())));
    let xs: Vec<f64> = springs.iter().map(|s| s.theta).collect();
    let ys: Vec<f64> = springs.iter().map(|s| s.speed_m_s / s.free_m_s).collect();
    let directions = ["along x", "oblique"];
    let mut panels = Vec::new();
    for direction in directions {
        let mut panel = Panel::new(
            vec![format!("spring {direction}")],
            Axis::log("θ = h²k/m (dimensionless)", &xs),
            Axis::log("speed over that of free fall", &ys),
        );
        let shown: Vec<&str> = names.iter().take(MOST_CURVES).map(String::as_str).collect();
        for (label, look) in shown.iter().zip(looks(&shown)) {
            let of = |s: &&Spring| s.label == *label && s.direction == direction;
            let points = springs.iter().filter(of).map(|s| Point {
                x: s.theta,
                y: s.speed_m_s / s.free_m_s,
                state: State::Stable,
            });
            panel.series.extend(Series::new((*label).to_owned(), look, points.collect()));
        }
        panels.push(panel);
    }
    let notes = vec!["Backward Euler and Baraff-Witkin lie on one another.".to_owned()];
    (!springs.is_empty()).then_some(Sheet { panels, notes })
}

/// Largest number of curves that can be distinguished in one panel.
const MOST_CURVES: usize = 7;

/// All tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let at_step = |run: &&Run| run.step_s == STEP;
    let at_stiffness = |run: &&Run| run.stiffness_over_mass_per_s2 == STIFFNESS;
    let runs = || input.facts.runs.iter();
    let by_stiffness: Vec<_> = runs().filter(at_step).collect();
    let by_step: Vec<_> = runs().filter(at_stiffness).collect();
    vec![
        locked(input),
        motion(
            &by_stiffness,
            &format!("**R; R beside backward Euler; R_fall by stiffness**, h = {STEP} s."),
            |run| run.stiffness_over_mass_per_s2,
            |k| format!("k/m = {} s⁻²", power(k)),
        ),
        motion(
            &by_step,
            &format!(
                "**R; R beside backward Euler; R_fall by step**, k/m = {} s⁻².",
                power(STIFFNESS)
            ),
            |run| run.step_s,
            |h| format!("h = {} s", setting(h)),
        ),
        prototype(input),
        law(input),
        of_springs(input),
    ]
}

/// The table of the softest sheet on which each variant locks.
fn locked(input: &Input) -> Table {
    let line = |run: &Run| {
        let stiffness = power(run.stiffness_over_mass_per_s2);
        vec![run.label.clone(), stiffness, number(run.retained, 3)]
    };
    Table {
        title: format!(
            "**Least k/m at which a variant locks**, h = {STEP} s; the others never lock."
        ),
        header: texts(&["method", "k/m (s⁻²)", "R"]),
        names: 1,
        rows: first_locked(&input.facts).into_iter().map(line).collect(),
    }
}

fn number(value: Option<f64>, digits: i32) -> String {
    value.map_or_else(absent, |value| significant(value, digits))
}

fn motion(
    runs: &[&Run],
    title: &str,
    column: impl Fn(&Run) -> f64,
    name: impl Fn(f64) -> String,
) -> Table {
    let columns = values(runs.iter().map(|run| column(run)));
    let mut header = texts(&["method"]);
    header.extend(columns.iter().map(|value| name(*value)));
    let text = |run: &&&Run| match run.verdict {
        Verdict::Stable | Verdict::Locked => {
            let values = [run.retained, run.retained_beside_backward_euler, run.retained_fall];
            values.map(|value| number(value, 2)).join("; ")
        }
        Verdict::OverBudget => "B".to_owned(),
        verdict => format!("✗ {verdict}"),
    };
    let line = |label: String| {
        let of = |value: &f64| runs.iter().find(|r| r.label == label && column(r) == *value);
        let cells = columns.iter().map(|value| of(value).as_ref().map_or_else(absent, text));
        std::iter::once(label.clone()).chain(cells).collect()
    };
    Table {
        title: format!("{title} B: over budget; ✗: not stable."),
        header,
        names: 1,
        rows: labels(runs.iter().map(|run| identity(run))).into_iter().map(line).collect(),
    }
}

fn prototype(input: &Input) -> Table {
    let runs = || input.facts.runs.iter().filter(|run| run.prototype_path_m.is_some());
    let labels = labels(runs().map(identity));
    let mut header = texts(&["k/m (s⁻²)"]);
    header.extend(
        labels.iter().map(|label| format!("{label}: path; prototype; height at 0.3 s (m)")),
    );
    let stiffnesses = values(runs().map(|run| run.stiffness_over_mass_per_s2));
    let line = |stiffness: f64| {
        let mut line = vec![power(stiffness)];
        line.extend(labels.iter().map(|label| {
            let of =
                |run: &&Run| run.label == *label && run.stiffness_over_mass_per_s2 == stiffness;
            runs().find(of).map_or_else(absent, |run| {
                let expected = run.prototype_path_m.map_or_else(absent, |path| path.to_string());
                let sign = if agrees_with_prototype(run) == Some(true) { "" } else { " ✗" };
                let height = number(run.height_m, 3);
                format!("{}; {expected}{sign}; {height}", number(run.path_m, 4))
            })
        }));
        line
    };
    Table {
        title: "**Paths of the midpoint beside an independent prototype**, h = 0.01 s. ✗: they \
                differ by more than 1 %. The prototype's updated CG has no safeguards and was \
                unstable at 10⁸."
            .to_owned(),
        header,
        names: 0,
        rows: stiffnesses.into_iter().map(line).collect(),
    }
}

fn law(input: &Input) -> Table {
    let line = |run: &&Run| {
        vec![
            run.label.clone(),
            power(run.stiffness_over_mass_per_s2),
            setting(run.step_s),
            number(run.retained, 3),
            number(run.late_speed_m_s, 3),
            significant(run.law_m_s, 3),
            number(run.late_speed_m_s.map(|speed| speed / run.law_m_s), 3),
        ]
    };
    let is_creeping =
        |run: &&Run| CREEPING.contains(&run.label.as_str()) && run.verdict == Verdict::Locked;
    let lever = input.facts.sheets.first().map_or(0.0, |sheet| sheet.lever);
    let swing = input.facts.sheets.first().map_or(0.0, |sheet| sheet.swing_lever);
    Table {
        title: format!(
            "**Locked sheets beside the law** v = a u/(h k/m), with u = {} for this sheet; the \
             lowest swing of a sheet held along a whole edge has u = 1/λ = {}. Speeds from 0.5 s \
             to 1 s.",
            significant(lever, 4),
            significant(swing, 4)
        ),
        header: texts(&[
            "method",
            "k/m (s⁻²)",
            "h (s)",
            "R",
            "speed (m/s)",
            "law (m/s)",
            "speed over law",
        ]),
        names: 1,
        rows: input.facts.runs.iter().filter(is_creeping).map(|run| line(&run)).collect(),
    }
}

fn of_springs(input: &Input) -> Table {
    let line = |spring: &Spring| {
        vec![
            spring.label.clone(),
            spring.direction.clone(),
            trimmed(spring.theta, 3),
            significant(spring.speed_m_s / spring.free_m_s, 4),
            significant(spring.law_m_s / spring.free_m_s, 4),
            number(spring.recurrence_error, 2),
        ]
    };
    Table {
        title:
            "**A single spring loaded across itself**: speed after one second over that of free \
                fall, measured and by the closed form; deviation from the exact recurrence."
                .to_owned(),
        header: texts(&["method", "spring", "θ", "measured", "law", "off the recurrence by"]),
        names: 2,
        rows: input.facts.springs.iter().map(line).collect(),
    }
}
