//! Figures of the experiment `scaling`.

use super::facts::{
    Cell, FIXED_MATERIAL, FIXED_QUOTIENT, Facts, Growth, Memory, RunTiming, TimingRow, growths,
};
use crate::families::{Family, families, labels};
use drape_report::Verdict;
use drape_report::number::{power, significant};
use drape_report::page::{Table, absent, texts};
use drape_report::plate::{Draw, Plate};
use drape_report::plot::{
    At, Axis, Draft, Look, Point, Rule, Series, Sheet, State, panels_of, values,
};

/// The input of the figures.
pub(super) type Input = crate::studies::Input<Facts, TimingRow>;

/// All figures, in the page's order.
pub(super) const PLATES: &[Plate<Input>] = &[
    Plate {
        file: "scaling-cost.svg",
        title: "Time of a step for each particle, from a hundred particles to a million",
        caption: "A level curve means that cost grows in proportion to the size; beyond 10⁵ \
            particles most methods rise, because arrays leave the caches. Nanoseconds of a step \
            over the number of particles: by family of methods, then by phase; k/m = 10⁴ s⁻². \
            Dashed: one pass of the memory over positions, velocities and forces. Byte bound: the \
            least bytes of a step at the measured bandwidth.",
        draw: Draw::Sheet(cost),
    },
    Plate {
        file: "scaling-cg.svg",
        title: "CG iterations of a step against the number of particles",
        caption: "With k/m fixed the iterations do not grow. For the same cloth on every mesh k/m \
            grows with the number of particles, and so do the iterations: a step's cost grows \
            faster than its size. By family of methods; first steps of a sheet that starts with a \
            wave in it, h = 0.01 s.",
        draw: Draw::Sheet(iterations),
    },
];

const SERIES: [&str; 2] = [FIXED_QUOTIENT, FIXED_MATERIAL];
const PHASES: [&str; 5] = ["forces", "matrix set-up", "solve", "contacts", "update"];
/// Bytes of a particle's position, velocity and force, each read and written once.
const BYTES: f64 = 144.0;
const LEAPFROG: &str = "The leapfrog method solves for its damping only, to 1e-14 and with \
                        Jacobi's preconditioner, in steps within its stability \
    limit.";
const PARTICLES: &str = "particles n";
const NANOSECONDS: &str = "ns a particle and step";

fn identity(cell: &Cell) -> (&str, &str) {
    (&cell.method, &cell.label)
}

fn series(label: &str, look: Look, points: impl Iterator<Item = (f64, f64)>) -> Option<Series> {
    let points = points.map(|(x, y)| Point { x, y, state: State::Stable });
    Series::new(label.to_owned(), look, points.collect())
}

fn timed(input: &Input) -> impl Iterator<Item = &RunTiming> + Clone {
    let rows = input.timings.iter().flat_map(|timings| &timings.rows);
    rows.filter_map(|row| match row {
        TimingRow::Run(run) => Some(run),
        TimingRow::Memory(_) | TimingRow::Triad { .. } => None,
    })
}

fn bandwidth(input: &Input) -> Option<f64> {
    let rows = input.timings.iter().flat_map(|timings| &timings.rows);
    rows.into_iter().find_map(|row| match row {
        TimingRow::Triad { bytes_per_s, .. } => Some(*bytes_per_s),
        TimingRow::Run(_) | TimingRow::Memory(_) => None,
    })
}

/// Nanoseconds a particle and step in which the memory can move the least bytes of a step.
fn byte_bound(input: &Input, run: &RunTiming) -> Option<f64> {
    Some(1e9 * run.least_bytes? / bandwidth(input)?)
}

/// Seconds of the phases, in the order of [`PHASES`].
fn phases(run: &RunTiming) -> [f64; 5] {
    let phases = &run.phases_s;
    [phases.forces, phases.matrix_setup, phases.solve, phases.contact, phases.update]
}

fn cost(input: &Input) -> Option<Sheet> {
    let of = |label: &str| timed(input).filter(move |run| run.label == label).collect::<Vec<_>>();
    let floor = bandwidth(input).map(|bandwidth| Rule {
        label: format!("{BYTES:.0} bytes a particle at {} GB/s", significant(1e-9 * bandwidth, 3)),
        at: At::Y(1e9 * BYTES / bandwidth),
    });
    let rules =
        || floor.iter().map(|rule| Rule { label: rule.label.clone(), at: rule.at }).collect();
    let whole = |family: Family<'_>| -> Draft {
        let curves = family.members.iter().filter_map(|(label, look)| {
            let points =
                of(label).into_iter().map(|run| (run.particles as f64, run.ns_per_particle_step));
            series(label, *look, points)
        });
        (vec![family.title.to_owned(), "whole step".to_owned()], curves.collect(), rules())
    };
    let mut drafts: Vec<Draft> =
        families(input.facts.cells.iter().map(identity)).into_iter().map(whole).collect();
    for label in ["imex-euler", "imex-euler, Jacobi", "leapfrog", "baraff-witkin"] {
        let runs = of(label);
        let curves = PHASES.iter().enumerate().filter_map(|(n, phase)| {
            let points = runs.iter().filter_map(|run| {
                let steps = run.particles as f64 * run.steps as f64;
                Some((run.particles as f64, 1e9 * phases(run)[n] / steps))
                    .filter(|(_, ns)| *ns > 0.1)
            });
            series(&format!("phase: {phase}"), Look::pair(n, 6 - n), points)
        });
        let bound =
            runs.iter().filter_map(|run| Some((run.particles as f64, byte_bound(input, run)?)));
        let curves = curves.chain(series("byte bound", Look::pair(5, 1), bound));
        drafts.push((vec![format!("{label}, by phase")], curves.collect(), rules()));
    }
    let mut sheet = panels_of(
        drafts,
        |xs| Axis::log(PARTICLES, xs),
        |ys| {
            let floor = bandwidth(input).map(|bandwidth| 1e9 * BYTES / bandwidth);
            let all: Vec<f64> = ys.iter().copied().chain(floor).collect();
            Axis::log(NANOSECONDS, &all)
        },
    )?;
    sheet.notes.push(input.machine()?);
    Some(sheet)
}

fn iterations(input: &Input) -> Option<Sheet> {
    let cells = || input.facts.cells.iter().filter(|cell| cell.cg_per_step > 0.0);
    let draft = |family: &Family<'_>, name: &str| -> Draft {
        let curves = family.members.iter().filter_map(|(label, look)| {
            let mine = cells().filter(|cell| cell.series == name && cell.label == *label);
            series(label, *look, mine.map(|cell| (cell.particles as f64, cell.cg_per_step)))
        });
        (vec![family.title.to_owned(), name.to_owned()], curves.collect(), Vec::new())
    };
    let families = families(cells().map(identity));
    let drafts = families.iter().flat_map(|family| SERIES.map(|name| draft(family, name)));
    panels_of(
        drafts.collect(),
        |xs| Axis::log(PARTICLES, xs),
        |ys| Axis::log("CG iterations per step", ys),
    )
    .map(|sheet| Sheet { notes: vec![LEAPFROG.to_owned()], ..sheet })
}

fn sizes(input: &Input) -> Vec<f64> {
    values(input.facts.cells.iter().map(|cell| cell.particles as f64))
}

fn header(sizes: &[f64], first: &[&str]) -> Vec<String> {
    let sizes = sizes.iter().map(|n| format!("n = {}", power(*n)));
    texts(first).into_iter().chain(sizes).collect()
}

/// All tables of the page.
pub(super) fn tables(input: &Input) -> Vec<Table> {
    let mut tables = vec![growth(input), counts(input), times(input)];
    tables.extend(memory(input));
    tables
}

/// The table of the growth of iterations, fastest growth first.
fn growth(input: &Input) -> Table {
    let mut growths = growths(&input.facts);
    growths.sort_by(|a, b| b.power().total_cmp(&a.power()));
    let line = |growth: &Growth<'_>| {
        let Growth { first, last } = growth;
        vec![
            first.series.clone(),
            first.label.clone(),
            significant(growth.power(), 2),
            format!("{} to {}", power(first.particles as f64), power(last.particles as f64)),
            significant(first.cg_per_step, 3),
            significant(last.cg_per_step, 3),
        ]
    };
    Table {
        title: "**Growth of the CG iterations, the fastest first**: power of n on average, and \
                iterations a step on the smallest and the largest \
            mesh."
            .to_owned(),
        header: texts(&["series", "method", "power", "n", "smallest", "largest"]),
        names: 2,
        rows: growths.iter().map(line).collect(),
    }
}

fn counts(input: &Input) -> Table {
    let cells = || input.facts.cells.iter();
    let labels = labels(cells().map(identity));
    let mut rows = Vec::new();
    for name in SERIES {
        for label in &labels {
            let at = |n: f64| {
                let is_it = |cell: &&Cell| {
                    cell.series == name && cell.label == *label && cell.particles as f64 == n
                };
                cells().find(is_it).map_or_else(absent, |cell| {
                    let steps = cell.steps as f64;
                    let sign = match cell.verdict {
                        Verdict::Completed if cell.unconverged_steps > 0 => " °",
                        Verdict::Completed => "",
                        _ => " ✗",
                    };
                    format!(
                        "{}; {}; {}{sign}",
                        significant(cell.cg_per_step, 3),
                        significant(cell.matvecs as f64 / steps, 3),
                        significant(cell.force_evaluations as f64 / steps, 3)
                    )
                })
            };
            let start = [name.to_owned(), label.clone()];
            rows.push(start.into_iter().chain(sizes(input).into_iter().map(at)).collect());
        }
    }
    Table {
        title: "**Counts of a step**: CG iterations; products with the matrix; sweeps over the \
                springs. ✗ diverged, ° some solves missed their tolerance, – not \
            run."
            .to_owned(),
        header: header(&sizes(input), &["series", "method"]),
        names: 2,
        rows,
    }
}

fn times(input: &Input) -> Table {
    let is_timed = |cell: &&Cell| timed(input).any(|run| run.label == cell.label);
    let labels = labels(input.facts.cells.iter().filter(is_timed).map(identity));
    let sizes = values(timed(input).map(|run| run.particles as f64));
    let line = |label: &String| {
        let at = |n: &f64| {
            let run = timed(input).find(|run| run.label == *label && run.particles as f64 == *n);
            run.map_or_else(absent, |run| {
                let bound = byte_bound(input, run)
                    .map(|bound| format!("; {}", significant(run.ns_per_particle_step / bound, 3)));
                format!(
                    "{}; {}{}",
                    significant(run.ns_per_particle_step, 3),
                    significant(1e3 * run.prepare_s, 3),
                    bound.unwrap_or_default()
                )
            })
        };
        std::iter::once(label.clone()).chain(sizes.iter().map(at)).collect()
    };
    Table {
        title: format!(
            "**Times, k/m fixed**: nanoseconds of a step for each particle; milliseconds of the \
             set-up; where the bytes of a step are counted, its time over their byte bound.{} – \
             not timed.",
            real_time(input).unwrap_or_default()
        ),
        header: header(&sizes, &["method"]),
        names: 1,
        rows: labels.iter().map(line).collect(),
    }
}

/// Step of the timed runs of [`REAL_TIME`]'s method, s.
const STEP: f64 = 0.01;
/// The method whose speed is compared with real time.
const REAL_TIME: &str = "imex-euler";

/// Whether a hundred thousand particles run in real time, in a sentence.
fn real_time(input: &Input) -> Option<String> {
    let near = |run: &&RunTiming| run.label == REAL_TIME && run.particles.abs_diff(100_000) < 1000;
    let run = timed(input).find(near)?;
    let seconds = 1e-9 * run.ns_per_particle_step * run.particles as f64;
    let verdict = if seconds <= STEP { "in real time" } else { "slower than the clock" };
    Some(format!(
        " {REAL_TIME} moves {} particles by steps of {STEP} s {verdict} on one core: {} s of \
         computing for each simulated \
         second.",
        run.particles,
        significant(seconds / STEP, 3)
    ))
}

/// The table of memory, by part.
fn memory(input: &Input) -> Option<Table> {
    let rows = || input.timings.iter().flat_map(|timings| &timings.rows);
    let sheets: Vec<&Memory> = rows()
        .filter_map(|row| match row {
            TimingRow::Memory(memory) => Some(memory),
            TimingRow::Run(_) | TimingRow::Triad { .. } => None,
        })
        .collect();
    let method = &sheets.first()?.label;
    let sizes: Vec<_> = sheets.iter().map(|memory| memory.particles as f64).collect();
    let line = |name: &str, value: fn(&Memory) -> f64| {
        let cells = sheets.iter().map(|memory| significant(value(memory), 3));
        std::iter::once(name.to_owned()).chain(cells).collect()
    };
    Some(Table {
        title: format!(
            "**Memory**: bytes a particle for a sheet with tension, shear and bending springs and \
             {method} after `prepare`; milliseconds to build the system and to \
             prepare."
        ),
        header: header(&sizes, &["part"]),
        names: 1,
        rows: vec![
            line("system, bytes", |m| m.system_bytes as f64 / m.particles as f64),
            line("state, bytes", |m| m.state_bytes as f64 / m.particles as f64),
            line("method, bytes", |m| m.integrator_bytes as f64 / m.particles as f64),
            line("all, bytes", |m| {
                (m.system_bytes + m.state_bytes + m.integrator_bytes) as f64 / m.particles as f64
            }),
            line("build, ms", |m| 1e3 * m.build_s),
            line("prepare, ms", |m| 1e3 * m.prepare_s),
        ],
    })
}
