//! `drape claim`.

use crate::cli::output::{check_folder, print};
use drape_harness::claims::{self, Evidence};
use drape_harness::{start_threads, studies};
use drape_model::SystemSpec;
use drape_report::{file::write_json, tell};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Id of the claim (see `drape list claims`)
    id: String,
    /// Write the systems from which the runs of the claim start into this folder, so that you can
    /// run them yourself: C12-001.json and so on, the smallest first
    #[arg(long, value_name = "DIR")]
    scenes: Option<PathBuf>,
}

/// Writes the systems, as `drape system` prints them.
fn write_scenes(folder: &Path, id: &str, systems: &[SystemSpec]) -> anyhow::Result<()> {
    for (n, system) in (1..).zip(systems) {
        write_json(&folder.join(format!("{id}-{n:03}.json")), system)?;
    }
    tell!("drape: wrote {} systems into {}", systems.len(), folder.display());
    Ok(())
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let claim = claims::find(&arguments.id)?;
    if let Some(folder) = &arguments.scenes {
        check_folder("--scenes", folder)?;
    }
    start_threads()?;
    let row = match &arguments.scenes {
        None => studies::claims::test(claim)?,
        Some(folder) => {
            let (row, systems) = studies::claims::test_with_starts(claim)?;
            write_scenes(folder, claim.id, &systems)?;
            row
        }
    };
    let judgement = claim.judge(&Evidence::new(&row.numbers));
    let mut text = String::new();
    writeln!(text, "{} ({}): {}", claim.id, claim.origin, claim.says)?;
    writeln!(text, "criterion: {}", claim.criterion)?;
    writeln!(text, "since:     commit {}", claim.age)?;
    writeln!(text, "overturned by: {}", claim.overturned_by)?;
    writeln!(text, "verdict:   {}", row.verdict.name())?;
    for number in &row.numbers {
        let unit = if number.unit.is_empty() { String::new() } else { format!(" {}", number.unit) };
        let limit = number.limit.map(|limit| format!("    limit {}", readable(limit)));
        let (value, limit) = (readable(number.value), limit.unwrap_or_default());
        writeln!(text, "    {} = {value}{unit}{limit}", number.what)?;
    }
    writeln!(text, "reason:    {}", judgement.reason)?;
    for reading in claim.readings(&Evidence::new(&row.numbers)) {
        let (asks, verdict) = (reading.asks, reading.verdict.name());
        writeln!(text, "reading:   {asks} {verdict}: {}", reading.seen)?;
    }
    let standing = claims::standing(claim.id, row.verdict, &row.numbers);
    writeln!(text, "in all:    {}", standing.name())?;
    if let Some(repair) = &judgement.repair {
        writeln!(text, "repair:    {repair}")?;
    }
    writeln!(text, "scenes:    {}", row.scenes)?;
    writeln!(text, "figure:    {}", claim.see)?;
    print(&text)
}

/// A number for a reader: counts whole, other numbers with decimals, extreme ones with an exponent.
fn readable(value: f64) -> String {
    match value.abs() {
        f64::MAX => "without bound".to_owned(),
        size if value.fract() == 0.0 && size < 1e7 => format!("{value}"),
        size if (1e-3..1e5).contains(&size) => format!("{value:.4}"),
        _ => format!("{value:.3e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::readable;

    #[test]
    fn numbers_are_readable_at_every_size() {
        let cases = [(96.0, "96"), (0.0, "0"), (0.83217, "0.8322"), (7.6e-11, "7.600e-11")];
        for (value, text) in cases {
            assert_eq!(readable(value), text);
        }
        assert_eq!(
            (readable(f64::MAX), readable(-3.2e8)),
            ("without bound".into(), "-3.200e8".into())
        );
    }
}
