//! `drape list`.

use crate::cli::output::print;
use drape_harness::{Preset, bundled, claims, methods, presets, studies};
use drape_integrator::{Method, StabilityClass};
use drape_model::fabric::Material;
use std::fmt::Write as _;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// What to list
    #[arg(value_enum)]
    what: What,
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
    let mut text = String::new();
    match arguments.what {
        What::Scenes => {
            for name in drape_model::bundled::names() {
                let scene = bundled(name)?;
                let time = scene.time;
                writeln!(
                    text,
                    "{name}\n    {}\n    h = {} s, {} s; assumed: {}",
                    scene.description,
                    time.step_s,
                    time.duration_s,
                    scene.assumed.join(", ")
                )?;
            }
        }
        What::Materials => {
            for name in Material::bundled() {
                let material = Material::load(name)?;
                let [tension, bending] = [material.tension_n_per_m, material.bending_n_m];
                writeln!(
                    text,
                    "{name}\n    {}\n    {} kg/m²; tension {} and {} N/m (warp, weft), shear {} \
                     N/m, bending {:e} and {:e} N m; assumed: {}",
                    material.source,
                    material.areal_density_kg_m2,
                    tension.warp,
                    tension.weft,
                    material.shear_n_per_m,
                    bending.warp,
                    bending.weft,
                    material.assumed.join(", ")
                )?;
            }
        }
        What::Methods => methods::all().try_for_each(|method| describe(&mut text, method))?,
        What::Experiments => {
            for experiment in studies::all() {
                writeln!(text, "{}\n    {}", experiment.name(), experiment.question())?;
                if !experiment.builds_on().is_empty() {
                    writeln!(text, "    builds on: {}", experiment.builds_on().join(", "))?;
                }
                let lessons = studies::lessons(experiment.name());
                if !lessons.is_empty() {
                    writeln!(text, "    lessons: {}", lessons.join(" → "))?;
                }
            }
        }
        What::StudyScenes => {
            for study in studies::all() {
                for start in study.starts() {
                    writeln!(text, "{}/{}", study.name(), start.name())?;
                }
            }
        }
        What::Claims => {
            for claim in claims::all() {
                writeln!(
                    text,
                    "{} ({}): {}\n    criterion: {}",
                    claim.id, claim.origin, claim.says, claim.criterion
                )?;
            }
        }
    }
    print(&text)
}

fn describe(text: &mut String, method: &Method) -> std::fmt::Result {
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
    Ok(())
}
