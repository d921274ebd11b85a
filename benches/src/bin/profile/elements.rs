//! The cost of an element of each effect in a force evaluation, beside a spring on a grid.

use drape_model::{State, System, Vec3};
use drape_oracle::Random;
use drape_report::number::median;
use serde_json::{Value, json};
use std::error::Error;
use std::fmt::Write as _;
use std::time::Instant;

/// Repetitions; the median counts.
const REPETITIONS: usize = 41;
/// Springs and elements of a repetition, at least.
const LEAST: usize = 400_000;

/// The time of an element.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    name: &'static str,
    side: u32,
    count: usize,
    /// Median, s.
    seconds: f64,
    /// Most of these elements that a time of [`Self::seconds`] should be in springs; 0 if none is
    /// asked for.
    aim: f64,
}

/// Effects of a scene, how many elements each has, and the aim.
type Kind = (&'static str, fn() -> Value, &'static str, f64);

/// What is timed, a spring first.
const KINDS: [Kind; 8] = [
    ("spring, on a grid", springs, "full", 0.0),
    ("spring, projected damping", springs, "projected", 0.0),
    ("spring with a curve", curved, "full", 0.0),
    ("bending_hinge", || json!({ "bending_hinge": { "stiffness_n_m": 1e-4 } }), "full", 4.0),
    ("angle, shear", || json!({ "shear_angle": { "stiffness_n_m": 1e-2 } }), "full", 0.0),
    ("angle, bending", || json!({ "bending_angle": { "stiffness_n_m": 1e-4 } }), "full", 0.0),
    (
        "triangle, quadratic drag",
        || drag(json!({ "quadratic": { "coefficient": 1.0 } })),
        "full",
        2.0,
    ),
    (
        "triangle, linear drag",
        || drag(json!({ "linear": { "coefficient_n_s_per_m3": 1.0 } })),
        "full",
        2.0,
    ),
];

fn springs() -> Value {
    json!({ "tension": { "stiffness_n_per_m": 50.0, "damping_n_s_per_m": 0.01 } })
}

fn curved() -> Value {
    json!({ "tension": { "pieces": [
        { "stiffness_n_per_m": 20.0, "up_to_strain": 0.02 }, { "stiffness_n_per_m": 60.0 }
    ], "damping_n_s_per_m": 0.01 } })
}

fn drag(law: Value) -> Value {
    json!({ "air": { "drag": law, "wind": { "velocity_m_s": [1.0, 2.0, 0.5] } } })
}

/// A sheet in disorder: at rest, many forces vanish.
fn sheet(side: u32, effects: &Value, damping: &str) -> Result<(System, State), Box<dyn Error>> {
    let scene = json!({
        "format": "drape-scene/1", "name": "sheet", "damping": damping,
        "cloth": { "grid": { "rows": side, "columns": side, "size_m": [1.0, 1.0],
            "center_m": [0, 0, 0], "mass_kg": 0.4 } },
        "effects": effects, "time": { "step_s": 0.01, "duration_s": 1.0 }
    });
    let input = drape_model::parse("sheet", &scene.to_string())?;
    let (system, mut state) = input.spec().build()?;
    let mut random = Random::new(20);
    let width = 1.0 / f64::from(side);
    let mut draw = || Vec3::new(random.unit(), random.unit(), random.unit());
    state.x.iter_mut().for_each(|x| *x += draw() * (0.2 * width));
    state.v.iter_mut().for_each(|v| *v += draw());
    Ok((system, state))
}

/// The number of elements of the effects.
fn count(system: &System, effects: &Value, triangles: usize) -> usize {
    let mut count = if effects.get("air").is_some() { triangles } else { 0 };
    for effect in system.effects() {
        if let Some(split) = effect.split() {
            split.visit_weights(&mut |_, _, _, _| count += 1);
        }
        if let Some(stencils) = effect.stencils() {
            stencils.visit(&mut |_| count += 1);
        }
    }
    count
}

/// Times each kind on sheets of these sides, in turns.
pub(crate) fn measure(sides: &[u32]) -> Result<Vec<Element>, Box<dyn Error>> {
    let mut elements = Vec::new();
    for &side in sides {
        let triangles = 2 * (side as usize - 1) * (side as usize - 1);
        let mut sheets = Vec::new();
        for (name, effects, damping, aim) in KINDS {
            let effects = effects();
            let (system, state) = sheet(side, &effects, damping)?;
            let count = count(&system, &effects, triangles);
            sheets.push((
                Element { name, side, count, seconds: 0.0, aim },
                system,
                state,
                Vec::new(),
            ));
        }
        for _ in 0..REPETITIONS {
            for (element, system, state, times) in &mut sheets {
                times.push(once(element.count, system, state));
            }
        }
        elements.extend(sheets.into_iter().map(|(element, _, _, times)| Element {
            seconds: median(times).unwrap_or(f64::NAN),
            ..element
        }));
    }
    Ok(elements)
}

/// Time of an element in one repetition, s.
fn once(count: usize, system: &System, state: &State) -> f64 {
    let mut out = vec![Vec3::zeros(); state.len()];
    let sweeps = LEAST.div_ceil(count.max(1));
    let begin = Instant::now();
    for _ in 0..sweeps {
        system.forces(state.level(), std::hint::black_box(&mut out));
    }
    begin.elapsed().as_secs_f64() / (sweeps * count.max(1)) as f64
}

/// The table.
pub(crate) fn text(elements: &[Element]) -> String {
    let mut text = String::from(HEAD);
    for Element { name, side, count, seconds, aim } in elements {
        let spring = elements.iter().find(|first| first.side == *side);
        let springs = spring.map_or(f64::NAN, |spring| seconds / spring.seconds);
        let aim = if *aim > 0.0 { format!("≤ {aim}") } else { "–".to_owned() };
        let ns = 1e9 * seconds;
        let _ = writeln!(text, "| {name} | {side} | {count} | {ns:.2} | {springs:.1} | {aim} |");
    }
    text
}

const HEAD: &str = "\n## What an element costs\n\n\
Forces and damping of a sheet in disorder that has this effect alone: median of rounds in which the effects take turns. Springs \
with a curve and projected damping are springs on the same grid.\n\n\
| element | N | elements | ns an element | in springs | aim |\n\
|---|---|---|---|---|---|\n";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_elements_and_a_time() {
        let elements = measure(&[6]).unwrap_or_else(|error| panic!("{error}"));
        let counts: Vec<_> = elements.iter().map(|element| element.count).collect();
        // 2 · 6 · 5 springs; 65 edges between 50 triangles; 4 · 25 and 2 · 6 · 4 angles.
        assert_eq!(counts, [60, 60, 60, 65, 100, 48, 50, 50]);
        assert!(elements.iter().all(|element| element.seconds > 0.0));
        assert_eq!(text(&elements).lines().filter(|line| line.contains("| 6 |")).count(), 8);
    }
}
