//! `drape system`.

use crate::output::print;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of a bundled scene, or a file with a scene or a frozen system
    scene: String,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let input = drape_model::load(&arguments.scene)?;
    print(&format!("{}\n", serde_json::to_string(input.spec())?))
}
