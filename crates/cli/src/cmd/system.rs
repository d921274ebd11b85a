//! `drape system`.

use crate::input::load;
use crate::output::print;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of a bundled scene, or a file with a scene or a frozen system
    scene: String,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let input = load(&arguments.scene)?;
    print(&format!("{}\n", serde_json::to_string(input.spec())?))
}
