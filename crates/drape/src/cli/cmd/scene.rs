//! `drape scene`.

use crate::cli::input::unknown_name;
use crate::cli::output::{Sink, check_extension, print};
use drape_model::bundled;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of a bundled scene
    scene: String,
    /// File for the scene; without it the scene is printed
    #[arg(long, value_name = "FILE.json")]
    out: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let name = &arguments.scene;
    let Some(text) = bundled::text(name) else {
        let known: Vec<_> = bundled::names().collect();
        return Err(unknown_name("SCENE", name, "bundled scenes", &known));
    };
    match &arguments.out {
        Some(file) => {
            check_extension("--out", file, "json", "scene in JSON")?;
            Sink::check("--out", file, &[])?.write(text.as_bytes())
        }
        None => print(text),
    }
}
