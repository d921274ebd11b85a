//! `drape inspect`.

use crate::cli::input::{files, in_file, load};
use crate::cli::limit::LimitArguments;
use crate::cli::output::{Sink, check_extension, print};
use drape_harness::judgement::percent;
use drape_harness::{Forecast, Foreseen, Inspection, boundaries, groups, inspect};
use drape_model::{SceneError, SceneFile, SystemSpec, Violation};
use drape_render::{Camera, Colour, Font, Image, Subject, View, colours, draw};
use drape_report::{printable, tell};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of a bundled scene, a file with a scene or a discretised system, or a mesh (.obj),
    /// which is taken as cloth of 0.2 kg/m² with springs of 50 N/m
    scene: String,
    /// Print JSON (format "drape-inspection/1") instead of text
    #[arg(long)]
    json: bool,
    /// Draw the cloth at the start into this file. Each connected group has its own colour, each
    /// part of the boundary has dots of its own colour, and pins inside the cloth are white dots
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    limit: LimitArguments,
}

/// What a mesh alone does not say, as the bundled skirt has it.
const ASSUMED: &str = "0.2 kg/m², springs of 50 N/m along all edges, gravity";

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let name = &arguments.scene;
    let is_mesh = Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
    let input = if is_mesh { mesh(name)? } else { load(name, arguments.limit, None)? };
    let sink = match &arguments.picture {
        None => None,
        Some(file) => {
            check_extension("--picture", file, "png", "PNG image")?;
            Some(Sink::check("--picture", file, &files(name, &input))?)
        }
    };
    let inspection = inspect(input.spec()).map_err(|violation| in_file(name, violation))?;
    if let Some(sink) = sink {
        let image = picture(input.spec()).map_err(|violation| in_file(name, violation))?;
        sink.write(&image.png()?)?;
    }
    if arguments.json {
        return print(&(serde_json::to_string_pretty(&inspection)? + "\n"));
    }
    let assumed = is_mesh.then_some(ASSUMED);
    print(&text(&inspection, &input, assumed))
}

/// Width and height of the picture, pixels.
const SIZE: [u32; 2] = [960, 720];
/// Groups, and parts of the boundary, that the picture names.
const NAMED: usize = 6;

/// The cloth at the start with its groups and boundaries, and their numbers.
fn picture(spec: &SystemSpec) -> Result<Image, Violation> {
    let (system, state) = spec.build()?;
    let (groups, parts) = (groups(spec), boundaries(&spec.triangles));
    let number = |(number, part): (usize, &Vec<u32>)| -> Vec<(u32, usize)> {
        part.iter().map(|&particle| (particle, number)).collect()
    };
    let marks: Vec<(u32, usize)> = parts.iter().enumerate().flat_map(number).collect();
    let mut subject = Subject::new(spec, system.obstacles());
    let points = subject.points(&state.x);
    // The dot of a pin would hide that of a boundary, whose line tells its pins.
    let pinned = |part: &[u32]| part.iter().filter(|i| system.pinned()[**i as usize]).count();
    subject.pins.retain(|pin| !marks.iter().any(|(particle, _)| particle == pin));
    let subject = Subject { groups: groups.clone(), marks, ..subject };
    let camera = Camera::fit(View::default(), &points, f64::from(SIZE[0]) / f64::from(SIZE[1]));
    let mut image = draw(&subject, &state.x, &camera, SIZE);
    let count = groups.iter().max().map_or(0, |last| last + 1);
    let size = |group: usize| groups.iter().filter(|own| **own == group).count();
    let of_groups = (0..count).map(|n| (format!("group {n}: {} particles", size(n)), n, 0));
    let of_parts = parts.iter().enumerate();
    let of_parts = of_parts.map(|(n, part)| {
        let (count, pinned) = (part.len(), pinned(part));
        (format!("boundary {n}: {count} particles, {pinned} pinned"), n, 1)
    });
    let named = of_groups.take(NAMED).chain(of_parts.take(NAMED));
    let height = Font::Small.height() + 2;
    let mut top = 8;
    for (text, number, kind) in named {
        image.write("#", 12, top, Font::Small, colours(number)[kind]);
        image.write(&text, 28, top, Font::Small, Colour::INK);
        top += height;
    }
    let more = [count, parts.len()].map(|all| all.saturating_sub(NAMED));
    if more != [0, 0] {
        let text = format!("and {} groups, {} boundaries more", more[0], more[1]);
        image.write(&text, 28, top, Font::Small, Colour::GREY);
    }
    Ok(image)
}

/// A mesh as a scene.
fn mesh(file: &str) -> Result<SceneFile, SceneError> {
    let path = Path::new(file);
    let own = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
    let scene = serde_json::json!({
        "format": "drape-scene/1",
        "name": path.file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default(),
        "description": "", "assumed": [],
        "cloth": { "mesh": { "file": own, "areal_density_kg_m2": 0.2 } },
        "effects": {
            "tension": { "stiffness_n_per_m": 50 },
            "gravity": { "m_s2": [0, 0, -9.81] }
        },
        "time": { "step_s": 0.01, "duration_s": 1 }
    });
    let input = drape_model::parse(file, &scene.to_string())?;
    for repair in input.repairs() {
        tell!("drape: {file}: mesh mended: {repair}");
    }
    Ok(input)
}

fn text(inspection: &Inspection, input: &SceneFile, assumed: Option<&str>) -> String {
    let Inspection { particles, triangles, pins, obstacles, .. } = inspection;
    let mut text = String::new();
    let mut line = |key: &str, value: String| {
        // A String takes every text.
        let _ = writeln!(text, "{key:<20} {value}");
    };
    line("scene", printable(&inspection.name).to_string());
    if let Some(assumed) = assumed {
        line("assumed", assumed.to_owned());
    }
    let springs: Vec<_> =
        inspection.springs.iter().map(|(effect, count)| format!("{count} {effect}")).collect();
    let springs = if springs.is_empty() { "none".to_owned() } else { springs.join(", ") };
    line("particles", format!("{particles}; pinned {pins}"));
    line("springs", format!("{springs}; angles {}", inspection.angles));
    line(
        "surface",
        format!(
            "{triangles} triangles, {:.4} m², {} boundaries; obstacles {obstacles}",
            inspection.area_m2, inspection.boundaries
        ),
    );
    line(
        "groups",
        format!("{} connected, {} without a pin", inspection.groups, inspection.free_groups),
    );
    let [x, y, z] = inspection.size_m;
    line("size", format!("{x:.4} × {y:.4} × {z:.4} m"));
    let density = inspection
        .areal_density_kg_m2
        .map_or_else(String::new, |density| format!("; {density:.4} kg/m²"));
    line("mass", format!("{:.4e} kg{density}", inspection.mass_kg));
    if let Some([low, high]) = inspection.rest_length_m {
        line("rest lengths", format!("{low:.3e} to {high:.3e} m"));
    }
    if let Some([low, high]) = inspection.stiffness_over_mass_per_s2 {
        line("k/m", format!("{low:.3e} to {high:.3e} 1/s²"));
        line("damping", format!("ζ = {:.2e} of the stiffest mode", inspection.damping_ratio));
    }
    if let Some(time) = input.scene().map(|scene| scene.time) {
        line("time", format!("steps of {} s, {} s", time.step_s, time.duration_s));
    }
    let thetas = inspection.methods.iter().find(|method| !method.steps.is_empty());
    if let Some(method) = thetas {
        let told = method.steps.iter().map(|f| format!("{:.3e} at {:.4} s", f.theta, f.step_s));
        line("h²k/m", told.collect::<Vec<_>>().join(", "));
    }
    if let Some(reason) = &inspection.motion_unforeseen {
        line("locking", format!("not foreseen: {reason}"));
    }
    let limits = inspection.explicit_limits_s.iter().map(|(id, limit)| {
        let id = id.as_str();
        if *limit >= 1.0 { format!("{id} none below 1 s") } else { format!("{id} {limit:.2e} s") }
    });
    let limits: Vec<_> = limits.collect();
    for (place, few) in limits.chunks(3).enumerate() {
        line(if place == 0 { "explicit limits" } else { "" }, few.join(", "));
    }
    if !limits.is_empty() {
        line("", "(safe: they give all damping to the stiffest wave)".to_owned());
    }
    for doubt in &inspection.doubts {
        line("doubtful", doubt.clone());
    }
    table(&mut text, inspection);
    text
}

fn table(text: &mut String, inspection: &Inspection) {
    let steps = drape_harness::STEPS_S.map(|step| format!("h = {step:.4} s"));
    let _ = writeln!(text, "\n{:<24} {:<15} {:<15} why", "method", steps[0], steps[1]);
    for method in &inspection.methods {
        if let Some(refusal) = &method.refusal {
            let _ = writeln!(text, "{:<24} {:<15} {:<15} {refusal}", method.id, "refuses", "");
            continue;
        }
        let cell = |forecast: &Forecast| match (forecast.verdict, forecast.share) {
            (verdict @ (Foreseen::Locked | Foreseen::Stable), Some(share)) => {
                format!("{}, {}", verdict.name(), percent(share))
            }
            (verdict, _) => verdict.name().to_owned(),
        };
        let cells: Vec<_> = method.steps.iter().map(cell).collect();
        let reason = method.steps.last().map(|forecast| forecast.reason.as_str());
        let _ = writeln!(
            text,
            "{:<24} {:<15} {:<15} {}",
            method.id,
            cells.first().map_or("", String::as_str),
            cells.last().map_or("", String::as_str),
            reason.unwrap_or_default()
        );
    }
    let _ = writeln!(
        text,
        "Verdicts are those of linear theory at the start and at default settings; a percentage \
         is the share of the motion that is kept. `drape run` checks."
    );
}
