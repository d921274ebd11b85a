//! `drape claim`.

use crate::output::print;
use drape_harness::claims;
use std::fmt::Write as _;

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Id of the claim (see `drape list claims`)
    id: String,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let row = claims::find(&arguments.id)?.test()?;
    let mut text = String::new();
    writeln!(text, "{} (§{}): {}", row.id, row.section, row.says)?;
    writeln!(text, "criterion: {}", row.criterion)?;
    writeln!(text, "verdict:   {}", row.verdict.name())?;
    for number in &row.numbers {
        let unit = if number.unit.is_empty() { String::new() } else { format!(" {}", number.unit) };
        let limit = number.limit.map_or(String::new(), |limit| format!("    limit {limit}"));
        writeln!(text, "    {} = {:.6e}{unit}{limit}", number.what, number.value)?;
    }
    writeln!(text, "reason:    {}", row.reason)?;
    if let Some(repair) = &row.repair {
        writeln!(text, "repair:    {repair}")?;
    }
    writeln!(text, "scenes:    {}", row.scenes)?;
    writeln!(text, "figure:    {}", row.see)?;
    print(&text)
}
