//! The figure of an engine's solvers beside methods of drape, from two records.

use crate::splice::{engine_rows, rows, solver};
use drape_harness::methods;
use drape_report::Files;
use drape_report::plate::{Draw, Plate, draw_all};
use drape_report::plot::{At, Axis, Look, Point, Rule, Series, Sheet, State, panels_of};
use serde_json::Value;
use std::path::Path;

/// The rows of the engine and of drape.
type Input = [Vec<Value>; 2];

const PLATES: &[Plate<Input>] = &[Plate {
    file: "engine-place.svg",
    title: "Error against sweeps: three solvers of an engine beside methods of drape",
    caption: "Sweeps over all springs against the error after 0.25 s, on a lightly damped sheet of 400 \
              particles with k/m = 10⁴ s⁻². The methods of an engine are lighter or darker, and stand for the \
              same idea as those of drape in the same colour. A sweep takes unlike times in unlike \
              methods.",
    draw: Draw::Sheet(place),
}];

/// The figure, with its path below the results.
///
/// # Errors
/// When a record cannot be read, or the figure cannot be drawn.
pub fn figure(results: &Path) -> Result<Files, String> {
    let engine = rows(&results.join("engines"), "work-precision", "/facts/rows")?;
    let ours = rows(results, "work-precision", "/facts/rows")?;
    let mut files = Files::new();
    draw_all(PLATES, &[engine, ours], &mut files).map_err(|error| error.to_string())?;
    Ok(files)
}

fn place(input: &Input) -> Option<Sheet> {
    let [engine, ours] = input;
    let series = engine_rows(engine, ours).into_iter().filter_map(|(is_ours, row)| {
        let name = solver(row);
        let whose = if is_ours { "drape" } else { "Newton" };
        let like = match name.split(' ').next().unwrap_or_default() {
            "semi-implicit" => "symplectic-euler",
            same => same,
        };
        let at = methods::all().position(|method| method.id == like)?;
        let runs = row["runs"].as_array()?.iter();
        let points = runs.filter_map(|run| {
            let x = run["force_evaluations"].as_u64()? as f64;
            let y = run["error"].as_f64().filter(|error| *error > 0.0)?;
            Some(Point { x, y: 100.0 * y, state: State::Stable })
        });
        let look = Look::of_method(at, usize::from(!is_ours));
        Series::new(format!("{name} of {whose}"), look, points.collect())
    });
    let rules = vec![Rule { label: "1 %".to_owned(), at: At::Y(1.0) }];
    panels_of(
        vec![(Vec::new(), series.collect(), rules)],
        |xs| Axis::log("sweeps over all springs", xs),
        |ys| Axis::log("error (% of the motion)", ys),
    )
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::equations::root;

    #[test]
    fn the_committed_figure_is_that_of_the_records() {
        let results = root().join("results");
        let files = figure(&results).unwrap();
        assert_eq!(files.len(), 1);
        for (name, content) in files {
            let committed = std::fs::read(results.join(&name)).unwrap();
            let hint = "run `cargo run -p drape-tests --bin splice`";
            assert!(committed == content.bytes(), "{name}: {hint}");
        }
    }
}
