//! Lessons, figures and tables of the experiment `course`.

use super::facts::{Facts, Lesson, Run, Scene, by_work};
use crate::families::looks;
use drape_report::Verdict;
use drape_report::number::{power, significant};
use drape_report::page::{Lesson as PageLesson, Step, Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{Axis, Look, Panel, Point, Series, Sheet, State};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts>;

/// The figure of the n-th lesson. Its title names the method and, from the second lesson on, the
/// method before.
macro_rules! plate_of_lesson {
    ($n:literal, $file:literal, $title:literal, $see:literal) => {
        Plate {
            file: concat!("course-", $file, ".svg"),
            title: $title,
            caption: concat!(
                $see,
                "Height of the middle of the free edge against time: a sheet of 20 × 20 particles \
                 swings down from two corners, with steps of 0.01 s, at k/m = 10⁴ (left) and 10⁶ \
                 s⁻² (right). Crossed out: the run was not stable."
            ),
            draw: Draw::Sheet(height_of_lesson::<$n>),
        }
    };
}

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "course-motion.svg",
        title: "How much of its motion the cloth keeps with each method",
        caption: "At k/m = 10⁶ s⁻² Desbrun and IMEX Euler keep less than a tenth of the motion; \
            updates bring it back. Retained motion: the path of the middle of the free edge in the \
            first second over the true one, with steps of 0.01 s; methods in the order of the \
            lessons. Crossed out: the run was not stable.",
        draw: Draw::Sheet(motion),
    },
    plate_of_lesson!(
        0,
        "explicit-euler",
        "Explicit Euler",
        "Explicit Euler diverges within the first swing, on the stiff sheet at once; the black \
         curve is the true motion."
    ),
    plate_of_lesson!(
        1,
        "leapfrog",
        "Leapfrog beside explicit Euler",
        "Leapfrog, with steps divided below its limit, lies on the true motion."
    ),
    plate_of_lesson!(
        2,
        "provot",
        "Provot beside leapfrog",
        "At the full step, beyond the limit, Provot swings too short on the soft sheet and \
         diverges at once on the stiff one."
    ),
    plate_of_lesson!(
        3,
        "backward-euler",
        "Backward Euler beside Provot",
        "Backward Euler holds the full step on both sheets; it only swings back less far."
    ),
    plate_of_lesson!(
        4,
        "baraff-witkin",
        "Baraff and Witkin beside backward Euler",
        "One linear solve a step comes close to a converged Newton iteration on both sheets."
    ),
    plate_of_lesson!(
        5,
        "desbrun",
        "Desbrun beside Baraff and Witkin",
        "With a constant matrix the soft sheet swings, damped more; the stiff one almost stands \
         still: it is stable, but locked."
    ),
    plate_of_lesson!(
        6,
        "kang",
        "Kang beside Desbrun",
        "One correction by the neighbours does not hold the sheet: on both sides it falls out of \
         the frame."
    ),
    plate_of_lesson!(
        7,
        "imex-euler",
        "IMEX Euler beside Kang",
        "With the same matrix solved to a tolerance the sheet is stable again; the stiff one still \
         almost stands still."
    ),
    plate_of_lesson!(
        8,
        "imex-updated",
        "IMEX Euler with updated CG beside plain IMEX Euler",
        "Updates of the right-hand side bring the motion of the stiff sheet back, close to that of \
         backward Euler."
    ),
    plate_of_lesson!(
        9,
        "imex-sbdf2",
        "Two-step IMEX beside updated CG",
        "On the soft sheet the two-step method is closer to the truth than updated CG; on the \
         stiff one it lags behind."
    ),
    plate_of_lesson!(
        10,
        "imex-rk",
        "IMEX Runge-Kutta beside two-step IMEX",
        "Two stages with the constant matrix follow the soft sheet; on the stiff one they, too, \
         lag behind."
    ),
    plate_of_lesson!(
        11,
        "dirk",
        "TR-BDF2 beside IMEX Runge-Kutta",
        "Two implicit stages lie on the true motion of both sheets, at the full step."
    ),
    plate_of_lesson!(
        12,
        "projective",
        "Projective dynamics beside TR-BDF2",
        "Ten local and global solves come close to backward Euler on both sheets, and so swing \
         back less far than the truth."
    ),
    plate_of_lesson!(
        13,
        "vbd",
        "Vertex block descent beside projective dynamics",
        "Sweeps over single particles follow the soft sheet; twenty of them are too few for the \
         stiff one."
    ),
    plate_of_lesson!(
        14,
        "xpbd",
        "XPBD beside vertex block descent",
        "Sweeps over single springs in small substeps lie on the true motion of the soft sheet and \
         close to that of the stiff one."
    ),
    plate_of_lesson!(
        15,
        "xpbd-lines",
        "XPBD by lines beside XPBD",
        "Lines that are solved at once lie on the true motion of both sheets, closer than \
         sweeps over single springs."
    ),
    plate_of_lesson!(
        16,
        "rkc",
        "Runge-Kutta-Chebyshev beside XPBD by lines",
        "An explicit method with many stages lies on the true motion of both sheets."
    ),
    plate_of_lesson!(
        17,
        "srkn4",
        "Order 4 beside Runge-Kutta-Chebyshev",
        "Explicit steps of order 4 below their limit lie on the true motion of both sheets."
    ),
    plate_of_lesson!(
        18,
        "multirate",
        "Two rates beside order 4",
        "Thirty short steps for the tension springs suit the soft sheet. On the stiff one the \
         slow forces, which are not slow there, make the motion grow."
    ),
    plate_of_lesson!(
        19,
        "midpoint",
        "Implicit midpoint beside two rates",
        "The implicit midpoint holds the full step on both sheets and lies close to the true \
         motion."
    ),
    plate_of_lesson!(
        20,
        "generalized-alpha",
        "Generalized-alpha beside the midpoint",
        "With little damping of the fastest motion both sheets swing as they should."
    ),
    plate_of_lesson!(
        21,
        "energy-momentum",
        "Energy and momentum beside generalized-alpha",
        "Discrete gradients lie on the true motion of both sheets."
    ),
    plate_of_lesson!(
        22,
        "rosenbrock",
        "Rosenbrock beside energy and momentum",
        "Two linear solves a step lie on the true motion of both sheets, too, as far as the eye \
         can tell."
    ),
    plate_of_lesson!(
        23,
        "exponential",
        "The exponential beside Rosenbrock",
        "The exponential of the linearised motion needs no linear system and lies on the true \
         motion \
         of both sheets."
    ),
];

/// Look of the true motion. No method has the same.
const TRUE: Look = Look::pair(4, 3);
/// Share of the true motion's range that is left free above and below it.
const MARGIN: f64 = 0.3;

fn run_of<'a>(lesson: &'a Lesson, scene: &Scene) -> Option<&'a Run> {
    lesson.runs.iter().find(|run| run.scene == scene.id)
}

/// Points of height against time within the range. The last point is crossed out if the run was not
/// stable.
fn points(scene: &Scene, heights: &[f64], (low, high): (f64, f64), verdict: Verdict) -> Vec<Point> {
    let seen = scene.time_s.iter().zip(heights).take_while(|(_, z)| (low..=high).contains(*z));
    let mut points: Vec<_> = seen.map(|(&x, &y)| Point { x, y, state: State::Stable }).collect();
    if let (Some(last), false) = (points.last_mut(), verdict == Verdict::Stable) {
        last.state = State::of_verdict(verdict);
    }
    points
}

fn height_of_lesson<const N: usize>(input: &Input) -> Option<Sheet> {
    let lesson = input.facts.lessons.get(N)?;
    let before = N.checked_sub(1).and_then(|n| input.facts.lessons.get(n));
    let heights = || input.facts.scenes.iter().flat_map(|scene| &scene.height_m).copied();
    let (low, high) =
        heights().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)));
    let range = (low - MARGIN * (high - low), high + MARGIN * (high - low));
    let mut panels = Vec::new();
    for scene in &input.facts.scenes {
        let mut panel = Panel::new(
            vec![format!("k/m = {} s⁻²", power(scene.stiffness_over_mass_per_s2))],
            Axis::linear("time (s)", &scene.time_s),
            Axis::linear("height (m)", &[range.0, range.1]),
        );
        let truth = points(scene, &scene.height_m, range, Verdict::Stable);
        let truth = Series::new("true motion".to_owned(), TRUE, truth);
        panel.series.extend(truth.map(Series::sparse));
        for lesson in before.into_iter().chain([lesson]) {
            let look = looks(&[&lesson.id])[0];
            let Some(run) = run_of(lesson, scene) else { continue };
            let points = points(scene, &run.height_m, range, run.verdict);
            let series = Series::new(lesson.id.clone(), look, points);
            panel.series.extend(series.map(Series::sparse));
        }
        panels.push(panel);
    }
    (!panels.is_empty()).then_some(Sheet { panels, notes: Vec::new() })
}

fn motion(input: &Input) -> Option<Sheet> {
    let Facts { scenes, lessons, .. } = &input.facts;
    let labels: Vec<_> = lessons.iter().map(|lesson| lesson.id.clone()).collect();
    let axis = Axis::linear("retained motion R (dimensionless)", &[0.0, 1.1]);
    let mut panel = Panel::new(Vec::new(), axis, Axis::names("", &labels));
    for (n, scene) in scenes.iter().enumerate() {
        let points = lessons.iter().enumerate().filter_map(|(m, lesson)| {
            let run = run_of(lesson, scene)?;
            let y = -(m as f64);
            Some(match run.retained_motion {
                Some(x) => Point { x, y, state: State::Stable },
                None => Point { x: f64::INFINITY, y, state: State::Failed },
            })
        });
        let label = format!("k/m = {} s⁻²", power(scene.stiffness_over_mass_per_s2));
        let series = Series::new(label, Look::number(n), points.collect());
        panel.series.extend(series.map(Series::apart));
    }
    (!labels.is_empty()).then(|| Sheet { panels: vec![panel], notes: Vec::new() })
}

/// The lessons of the page.
pub(super) fn lessons(facts: &Facts) -> Vec<PageLesson> {
    let lesson = |lesson: &Lesson| PageLesson {
        id: lesson.id.clone(),
        title: lesson.title.clone(),
        before: lesson.before.clone(),
        idea: lesson.idea.clone(),
        finding: lesson.finding.clone(),
        figure: format!("course-{}.svg", lesson.id),
        step: crate::lessons::find(&lesson.id).ok().and_then(|(_, known)| step(known)),
        docs: lesson.docs.clone(),
        commands: facts.scenes.iter().map(|scene| command(lesson, scene)).collect(),
    };
    facts.lessons.iter().map(lesson).collect()
}

/// Equations, code and factors, as the lab shows them. They are parts of the program, not measured
/// facts.
fn step(lesson: &crate::lessons::Lesson) -> Option<Step> {
    let setting = &lesson.setting;
    let stiffness = power(setting.stiffness);
    let damping = match setting.damping {
        0.0 => "no damping".to_owned(),
        damping => format!("d/m = {} s⁻¹", significant(damping, 3)),
    };
    let radii = lesson.radii();
    // They span four decades. The middle two are shown, in eleven steps.
    let near = radii.iter().skip(radii.len() / 4).step_by(2).take(11);
    let factor = |(h, radius): &(f64, f64)| {
        let radius = if radius.is_finite() { significant(*radius, 3) } else { absent() };
        [significant(*h, 3), radius]
    };
    Some(Step {
        equation: lesson.equation()?,
        code: lesson.code()?,
        files: [lesson.file(&lesson.equation), lesson.file(&lesson.code)],
        spring: format!(
            "The factor by which a step multiplies the motion of a single spring in the long run, \
             with k/m = {stiffness} s⁻² and {damping}. Above 1 the motion grows."
        ),
        factors: near.map(factor).collect(),
    })
}

fn command(lesson: &Lesson, scene: &Scene) -> String {
    let Scene { id, step_s, duration_s, .. } = scene;
    format!("drape run {id} --method {} --dt {step_s} --duration {duration_s}", lesson.method)
}

/// The tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let facts = &input.facts;
    let lessons = || facts.lessons.iter();
    let headline = lessons().filter(|lesson| facts.headline.contains(&lesson.id));
    vec![headlines(facts, headline), work(facts), numbers(facts, lessons()), support(facts)]
}

/// A share in per cent, as text.
fn per_cent(share: Option<f64>) -> String {
    share.map_or_else(absent, |share| significant(100.0 * share, 3))
}

/// The rows of a table: one for each method and stiffness.
fn rows<'a>(
    facts: &Facts,
    lessons: impl Iterator<Item = &'a Lesson>,
    columns: impl Fn(&Run) -> Vec<String>,
) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for lesson in lessons {
        for scene in &facts.scenes {
            let Some(run) = run_of(lesson, scene) else { continue };
            let stiffness = power(scene.stiffness_over_mass_per_s2);
            let mut row = vec![lesson.id.clone(), stiffness, run.verdict.to_string()];
            row.extend(columns(run));
            rows.push(row);
        }
    }
    rows
}

fn headlines<'a>(facts: &Facts, lessons: impl Iterator<Item = &'a Lesson>) -> Table {
    let truth = facts.scenes.iter().map(|scene| per_cent(Some(scene.energy_change)));
    let truth = truth.collect::<Vec<_>>().join(" and ");
    Table {
        title: format!(
            "**The five methods compared first.** Gain: greatest rise of the total energy above \
             its start; drift: its change over two seconds (truly {truth} %); both over E_ref. \
             Work in ms of modelled time."
        ),
        header: texts(&[
            "method",
            "k/m (s⁻²)",
            "verdict",
            "gain (%)",
            "drift (%)",
            "motion kept (%)",
            "work (ms)",
        ]),
        names: 3,
        rows: rows(facts, lessons, |run| {
            let shares = [run.energy_gain, run.energy_change, run.retained_motion];
            let mut row: Vec<_> = shares.map(per_cent).into();
            row.push(significant(1e3 * run.modelled_s, 3));
            row
        }),
    }
}

/// The table of work of the methods that keep most of the motion, for each sheet, least work first.
fn work(facts: &Facts) -> Table {
    let lines = |scene: &Scene| {
        let stiffness = power(scene.stiffness_over_mass_per_s2);
        let line = move |(lesson, run): (&Lesson, &Run)| {
            let motion = per_cent(run.retained_motion);
            vec![stiffness.clone(), lesson.id.clone(), significant(1e3 * run.modelled_s, 3), motion]
        };
        by_work(facts, scene).into_iter().map(line).collect::<Vec<_>>()
    };
    Table {
        title:
            "**Work of the methods that keep at least 90 % of the motion**, the least first, in \
                ms of modelled time."
                .to_owned(),
        header: texts(&["k/m (s⁻²)", "method", "work (ms)", "motion kept (%)"]),
        names: 2,
        rows: facts.scenes.iter().flat_map(lines).collect(),
    }
}

fn numbers<'a>(facts: &Facts, lessons: impl Iterator<Item = &'a Lesson>) -> Table {
    let columns = [
        "method",
        "k/m (s⁻²)",
        "verdict",
        "until (s)",
        "motion kept (%)",
        "height off by (m)",
        "gain (%)",
        "stretch (%)",
        "force evaluations",
        "products with a matrix",
        "CG iterations",
        "Newton iterations",
        "factorisations",
        "work (ms)",
    ];
    Table {
        title: "**Every run of the course.** Gain over E_ref; stretch: greatest elongation of a \
                spring; work in ms of modelled time. –: not measured, because the run was not \
                stable."
            .to_owned(),
        header: texts(&columns),
        names: 3,
        rows: rows(facts, lessons, |run| {
            let counts = [
                run.force_evaluations,
                run.matvecs,
                run.cg_iterations,
                run.newton_iterations,
                run.factorisations,
            ];
            let mut row = vec![
                format!("{:.2}", run.reached_s),
                per_cent(run.retained_motion),
                run.height_error_m.map_or_else(absent, |error| significant(error, 3)),
                per_cent(run.energy_gain),
                per_cent(run.greatest_stretch),
            ];
            row.extend(counts.map(|count| count.to_string()));
            row.push(significant(1e3 * run.modelled_s, 3));
            row
        }),
    }
}

fn support(facts: &Facts) -> Table {
    let mut header = texts(&["method"]);
    header
        .extend(facts.support.iter().take(1).flat_map(|row| &row.effects).map(|(e, _)| e.clone()));
    let row = |row: &super::facts::Support| {
        let treatments = row.effects.iter().map(|(_, treatment)| treatment.clone());
        std::iter::once(row.method.clone()).chain(treatments).collect()
    };
    Table {
        names: header.len(),
        title: "**How each method treats each effect**. Implicit: at the new positions and \
                velocities. Explicit: at the old ones. By setting: either. Constraint: as a \
                condition on the new velocity. Refused: the method does not run such a scene."
            .to_owned(),
        header,
        rows: facts.support.iter().map(row).collect(),
    }
}
