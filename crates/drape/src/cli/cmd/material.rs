//! `drape material`.

use super::readings::{self, Reading};
use super::refusal;
use crate::cli::output::{Sink, check_extension, print};
use drape_model::Violation;
use drape_model::fabric::{Material, Table};
use drape_report::file::json;
use drape_report::tell;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Name of a bundled material, a file with a material (JSON), or a table of fabrics (CSV)
    material: String,
    /// Row of the table, from 1
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    row: Option<i64>,
    /// Name of the material (default: of the file and the row)
    #[arg(long)]
    name: Option<String>,
    /// Material (bundled or a file) that provides the constants that a table lacks: tension, shear
    /// and retardation
    #[arg(long, value_name = "MATERIAL", default_value = "cotton-blend")]
    like: String,
    #[arg(long = "reading", value_name = "KEY=VALUE", help = readings::HELP)]
    readings: Vec<Reading>,
    /// File for the material; without it the material is printed
    #[arg(long, value_name = "FILE.json")]
    out: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let is_bundled = Material::text(&arguments.material).is_some();
    let inputs: Vec<_> =
        (!is_bundled).then(|| PathBuf::from(&arguments.material)).into_iter().collect();
    let sink = |file: &PathBuf| {
        let sink = Sink::check("--out", file, &inputs)?;
        check_extension("--out", file, "json", "material in JSON")?;
        Ok::<_, Violation>(sink)
    };
    let sink = arguments.out.as_ref().map(sink).transpose()?;
    let mut material =
        if is_table(&arguments.material) { of_table(arguments)? } else { whole(arguments)? };
    readings::apply(&arguments.readings, &mut material)?;
    let shown = arguments.out.as_deref().unwrap_or(Path::new("standard output"));
    let bytes = json(shown, &material)?;
    match sink {
        Some(sink) => sink.write(&bytes),
        None => print(&String::from_utf8_lossy(&bytes)),
    }
}

fn is_table(file: &str) -> bool {
    Path::new(file).extension().is_some_and(|end| end.eq_ignore_ascii_case("csv"))
}

/// A bundled material, or one from a file.
fn whole(arguments: &Arguments) -> Result<Material, Violation> {
    let expected = "no such option: only a table of fabrics (CSV) has rows";
    if let Some(row) = arguments.row {
        return Err(refusal("--row", row, expected));
    }
    let mut material = Material::load(&arguments.material)
        .map_err(|violation| in_place("material", &arguments.material, violation))?;
    if let Some(name) = &arguments.name {
        name.clone_into(&mut material.name);
    }
    Ok(material)
}

/// The refusal of a material, by the name that the user gave.
fn in_place(key: &str, file: &str, violation: Violation) -> Violation {
    let path = match violation.path.strip_prefix("of, ") {
        Some(place) => format!("{file}, {place}"),
        None => key.to_owned(),
    };
    Violation { path, ..violation }
}

/// A row of a table, with tension and shear of another material.
fn of_table(arguments: &Arguments) -> Result<Material, Violation> {
    let file = &arguments.material;
    let table = Table::load(file)?;
    let rows = format!("the number of a row of the table, from 1 to {}", table.rows.len());
    let Some(number) = arguments.row else {
        return Err(refusal("--row", "missing", &rows));
    };
    let row = u32::try_from(number).map_err(|_| refusal("--row", number, &rows))?;
    let row = table.row(row, "--row")?;
    let like = Material::load(&arguments.like)
        .map_err(|violation| in_place("--like", &arguments.like, violation))?;
    let stem = Path::new(file).file_stem().unwrap_or_default().display().to_string();
    let name = arguments.name.clone().unwrap_or_else(|| format!("{stem}-{number}"));
    let title = Path::new(file).file_name().unwrap_or_default().display().to_string();
    let material = row.material(&name, &format!("Row {number} of {title}"), &like);
    tell!(
        "drape: {file} has no tension and no shear; they are assumed to be those of {} (--like)",
        like.name
    );
    Ok(material)
}
