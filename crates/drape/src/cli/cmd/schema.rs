//! `drape schema`.

use crate::cli::output::print;
use drape_harness::record::Run;
use drape_model::{Scene, SystemSpec};
use schemars::schema_for;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Format
    #[arg(value_enum)]
    format: Format,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Format {
    /// A scene, as a person writes it: "drape-scene/1"
    Scene,
    /// A discretised system: "drape-system/1"
    System,
    /// A run, as `drape run --out` writes it: "drape-run/2"
    Run,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let schema = match arguments.format {
        Format::Scene => schema_for!(Scene),
        Format::System => schema_for!(SystemSpec),
        Format::Run => schema_for!(Run),
    };
    print(&format!("{}\n", serde_json::to_string_pretty(&schema)?))
}
