//! `drape list`.

use crate::cli::input::unknown_name;
use crate::cli::output::print;
use drape_harness::studies::{self, Study};
use drape_harness::{Preset, bundled, claims, methods, presets};
use drape_integrator::{Method, StabilityClass};
use drape_model::fabric::Material;
use std::fmt::Write as _;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// What to list
    #[arg(value_enum)]
    what: What,
    /// Only the entry of this name; for study-scenes, those of this study
    name: Option<String>,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum What {
    /// Bundled scenes
    Scenes,
    /// Bundled materials with their constants and sources
    Materials,
    /// Time integrators with their settings, ranges and defaults
    Methods,
    /// Experiments in teaching order; each names the experiments that it builds on
    Experiments,
    /// Scenes from which studies start, as commands take them in place of a scene
    StudyScenes,
    /// Claims of the paper, then expectations about later methods, with their criteria
    Claims,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut entries = entries(arguments.what)?;
    if let Some(name) = &arguments.name {
        let is_it = |entry: &Entry| entry.name.eq_ignore_ascii_case(name);
        if !entries.iter().any(is_it) {
            let mut known: Vec<_> = entries.iter().map(|entry| entry.name).collect();
            known.dedup();
            return Err(unknown_name("NAME", name, "names in the list", &known));
        }
        entries.retain(is_it);
    }
    print(&entries.into_iter().map(|entry| entry.text).collect::<String>())
}

/// What is told of one name. The starts of a study stand under the name of the study.
struct Entry {
    name: &'static str,
    text: String,
}

fn entries(what: What) -> anyhow::Result<Vec<Entry>> {
    match what {
        What::Scenes => drape_model::bundled::names().map(scene).collect(),
        What::Materials => Material::bundled().map(material).collect(),
        What::Methods => methods::all().map(method).collect(),
        What::Experiments => studies::all().iter().map(|study| experiment(*study)).collect(),
        What::StudyScenes => {
            let mut entries = Vec::new();
            for study in studies::all() {
                for start in study.starts() {
                    let line = format!("{}/{}\n", study.name(), start.name());
                    entries.push(Entry { name: study.name(), text: line });
                }
            }
            Ok(entries)
        }
        What::Claims => {
            let claims = claims::all().iter();
            let tell = |claim: &claims::Claim| {
                let claims::Claim { id, origin, says, criterion, .. } = claim;
                let text = format!("{id} ({origin}): {says}\n    criterion: {criterion}\n");
                Ok(Entry { name: id, text })
            };
            claims.map(tell).collect()
        }
    }
}

fn scene(name: &'static str) -> anyhow::Result<Entry> {
    let scene = bundled(name)?;
    let time = scene.time;
    let text = format!(
        "{name}\n    {}\n    h = {} s, {} s; assumed: {}\n",
        scene.description,
        time.step_s,
        time.duration_s,
        scene.assumed.join(", ")
    );
    Ok(Entry { name, text })
}

fn material(name: &'static str) -> anyhow::Result<Entry> {
    let material = Material::load(name)?;
    let [tension, bending] = [material.tension_n_per_m, material.bending_n_m];
    let text = format!(
        "{name}\n    {}\n    {} kg/m²; tension {} and {} N/m (warp, weft), shear {} N/m, bending \
         {:e} and {:e} N m; assumed: {}\n",
        material.source,
        material.areal_density_kg_m2,
        tension.warp,
        tension.weft,
        material.shear_n_per_m,
        bending.warp,
        bending.weft,
        material.assumed.join(", ")
    );
    Ok(Entry { name, text })
}

fn experiment(study: &dyn Study) -> anyhow::Result<Entry> {
    let name = study.name();
    let mut text = format!("{name}\n    {}\n", study.question());
    if !study.builds_on().is_empty() {
        writeln!(text, "    builds on: {}", study.builds_on().join(", "))?;
    }
    let lessons = studies::lessons(name);
    if !lessons.is_empty() {
        writeln!(text, "    lessons: {}", lessons.join(" → "))?;
    }
    Ok(Entry { name, text })
}

fn method(method: &Method) -> anyhow::Result<Entry> {
    let mut text = String::new();
    let order = method.order.number();
    let class = match method.class {
        StabilityClass::Dissipative => "judged by: energy must not rise",
        StabilityClass::Symplectic => "judged by: energy must not drift",
    };
    writeln!(
        text,
        "{}\n    {} ({}), order {order}, {class}",
        method.id, method.name, method.source
    )?;
    let conserved: Vec<_> = method.conserves.iter().map(|quantity| quantity.name()).collect();
    let conserved = if conserved.is_empty() { "nothing".to_owned() } else { conserved.join(", ") };
    writeln!(text, "    conserves {conserved}, to the tolerance of its solve; {}", method.theory)?;
    let supports: Vec<_> = method
        .supports()
        .map(|support| format!("{} {}", support.effect, support.treatment.name()))
        .collect();
    writeln!(text, "    supports: {}", supports.join(", "))?;
    for setting in method.settings {
        writeln!(
            text,
            "    {}={}    {}; {}",
            setting.key, setting.default, setting.kind, setting.help
        )?;
    }
    for preset in presets(method) {
        let Preset { name, help, .. } = preset;
        let (id, all) = (method.id, preset.written_out(method));
        writeln!(text, "    {id}:{name}    stands for {all}; {help}")?;
    }
    Ok(Entry { name: method.id, text })
}
