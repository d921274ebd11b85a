//! Which method to take for what: the five uses of the first page, each answered from records.

use drape_report::page::{Table, texts};
use serde_json::Value;
use std::path::Path;

/// A use, what to take for it, and why.
pub type Use = (&'static str, (String, String));

/// Which method to take for what, and what the record says, each from a record.
///
/// # Errors
/// When a record cannot be read or lacks what is looked up.
pub fn all_uses(results: &Path) -> Result<[Use; 5], String> {
    Ok([
        ("a curtain in a film at 24 frames a second", of_frames(results, "24 Hz")?),
        ("a skirt in a game at 60 frames a second", of_frames(results, "on a ball")?),
        ("a drape test for a textile laboratory", at_rest(results)?),
        ("a teaching demonstration", taught(results)?),
        ("a still of a million particles", of_a_million(results)?),
    ])
}

/// The table of the report; none where a record is missing.
pub(super) fn table(results: &Path) -> Option<Table> {
    let uses = all_uses(results).ok()?;
    let line = |(what, (take, why)): Use| vec![what.to_owned(), take, why];
    Some(Table {
        title: "**Which method for what**, and what the records say.".to_owned(),
        header: texts(&["use", "take", "the record says"]),
        names: 3,
        rows: uses.into_iter().map(line).collect(),
    })
}

/// A list of a record, `record` being its path below the results without extension.
///
/// # Errors
/// When the record cannot be read or has no such list.
pub fn rows(results: &Path, record: &str, pointer: &str) -> Result<Vec<Value>, String> {
    let path = results.join(record).with_extension("json");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let record: Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
    let rows = record.pointer(pointer).and_then(Value::as_array);
    rows.cloned().ok_or_else(|| format!("{}: no list {pointer}", path.display()))
}

/// The error for which the pages name winners.
pub const LEVEL: f64 = 0.01;

/// Stiffness of each hanging sheet of the series over stiffness, in rising order, and the winner for
/// an error there.
pub fn wins(scenes: &[Value], winners: &[Value], damping: &str, level: f64) -> Vec<(f64, Value)> {
    let is_meant = |scene: &&Value| {
        scene["scene"] == "hanging"
            && scene["damping"] == damping
            && scene["series"].as_array().is_some_and(|s| s.contains(&"stiffness".into()))
    };
    let mut wins: Vec<(f64, Value)> = Vec::new();
    for scene in scenes.iter().filter(is_meant) {
        let winner = winners.iter().find(|w| w["scene"] == scene["id"] && w["level"] == level);
        let stiffness = scene["stiffness_over_mass_per_s2"].as_f64().unwrap_or(f64::NAN);
        wins.extend(winner.map(|w| (stiffness, w.clone())));
    }
    wins.sort_by(|a, b| a.0.total_cmp(&b.0));
    wins
}

/// The method behind a label: what stands before the first comma.
pub fn method(label: &Value) -> &str {
    label.as_str().unwrap_or("none").split(',').next().unwrap_or_default()
}

/// A number of a row.
fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or(f64::NAN)
}

/// The fastest methods of the scene of `animation` whose name has this part.
fn of_frames(results: &Path, part: &str) -> Result<(String, String), String> {
    let scenes = rows(results, "animation", "/facts/scenes")?;
    let has_part = |scene: &&Value| scene["id"].as_str().is_some_and(|id| id.contains(part));
    let scene = scenes.iter().find(has_part).ok_or(format!("animation: no scene {part}"))?;
    let (error, floor) = match scene["measure"].as_str() {
        Some("shape") => ("shape_error_m", "shape_floor_m"),
        _ => ("trajectory_error_m", "trajectory_floor_m"),
    };
    let good = f64::max(0.01, 2.0 * number(scene, floor));
    let timings = rows(results, "timings/animation", "/rows")?;
    let mut least: Vec<(Value, f64)> = Vec::new();
    for run in rows(results, "animation", "/facts/runs")? {
        let is_its =
            |row: &&Value| ["scene", "label", "substeps"].iter().all(|key| row[*key] == run[*key]);
        let time = timings.iter().find(is_its).map(|row| number(row, "frame_s"));
        let is_good = run["scene"] == scene["id"]
            && run["verdict"] == "stable"
            && run[error].as_f64().is_some_and(|error| error <= good);
        let Some(time) = time.filter(|_| is_good) else { continue };
        match least.iter_mut().find(|(other, _)| method(&other["label"]) == method(&run["label"])) {
            Some(known) if known.1 <= time => {}
            Some(known) => *known = (run, time),
            None => least.push((run, time)),
        }
    }
    least.sort_by(|a, b| a.1.total_cmp(&b.1));
    let Some((first, time)) = least.first() else {
        return Ok(("none".to_owned(), format!("`animation`: no run is within {} mm", 1e3 * good)));
    };
    let ties: Vec<_> = least[1..]
        .iter()
        .take_while(|(_, other)| *other <= 1.5 * time)
        .map(|(run, _)| format!("`{}`", method(&run["label"])))
        .collect();
    let ties = if ties.is_empty() { String::new() } else { format!("; tie: {}", ties.join(", ")) };
    let label = first["label"].as_str().unwrap_or_default();
    let name = method(&first["label"]);
    let form = if label == name { String::new() } else { format!(" ({label})") };
    let take = format!("`{name}`{form}, calls a frame: {}{ties}", first["substeps"]);
    let why = format!(
        "`animation`, {}: {:.1} ms a frame, off by {:.1} mm (good: {:.0} mm)",
        scene["id"].as_str().unwrap_or_default(),
        1e3 * time,
        1e3 * number(first, error),
        1e3 * good
    );
    Ok((take, why))
}

/// The form that is nearest to the cheapest on every round table.
fn at_rest(results: &Path) -> Result<(String, String), String> {
    let timings = rows(results, "timings/rest", "/rows")?;
    let scenes = rows(results, "rest", "/facts/scenes")?;
    let ids = scenes.iter().filter_map(|scene| scene["id"].as_str());
    let round: Vec<&str> =
        ids.filter(|id| id.starts_with("round") && !id.contains(" 8 ")).collect();
    let least = |scene: &str, label: Option<&str>| {
        let own = timings.iter().filter(|row| row["scene"] == scene);
        let own = own.filter(|row| label.is_none_or(|label| row["label"] == label));
        own.map(|row| number(row, "seconds")).fold(f64::INFINITY, f64::min)
    };
    let ratio = |label: &str| {
        let ratios = round.iter().map(|scene| least(scene, Some(label)) / least(scene, None));
        ratios.fold(0.0, f64::max)
    };
    let mut labels: Vec<&str> = timings.iter().filter_map(|row| row["label"].as_str()).collect();
    labels.sort_unstable();
    labels.dedup();
    labels.retain(|label| ratio(label).is_finite());
    labels.sort_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    let Some(first) = labels.first() else {
        return Ok(("none".to_owned(), "`rest`: no form comes to rest on all".to_owned()));
    };
    let ties: Vec<_> = labels[1..]
        .iter()
        .take_while(|label| ratio(label) <= 1.5 * ratio(first))
        .take(4)
        .map(|label| format!("`{label}`"))
        .collect();
    let ties = if ties.is_empty() { String::new() } else { format!("; near: {}", ties.join(", ")) };
    let seconds: Vec<_> =
        round.iter().map(|scene| format!("{:.2} s", least(scene, Some(first)))).collect();
    let why = format!(
        "`rest`, {} fabrics on the round table: {} until the cloth rests, at most {:.1} times the \
         cheapest",
        round.len(),
        seconds.join(", "),
        ratio(first)
    );
    Ok((format!("`{first}`{ties}"), why))
}

/// Who is first on a soft sheet.
fn taught(results: &Path) -> Result<(String, String), String> {
    let scenes = rows(results, "work-precision", "/facts/scenes")?;
    let winners = rows(results, "work-precision", "/facts/winners")?;
    let wins = wins(&scenes, &winners, "light", LEVEL);
    let soft = wins.iter().find(|(stiffness, _)| *stiffness == 1e4).ok_or("no soft sheet")?;
    let why = "`work-precision`, hanging sheet, k/m = 10⁴ s⁻²: the least modelled time for 1 %; its \
               step fits on a line, and the course begins with its kind";
    Ok((format!("`{}`", method(&soft.1["label"])), why.to_owned()))
}

/// What is known of a million particles.
fn of_a_million(results: &Path) -> Result<(String, String), String> {
    let timings = rows(results, "timings/scaling", "/rows")?;
    let largest = timings.iter().filter(|row| {
        row["kind"] == "run" && row["series"] == "k/m fixed" && number(row, "particles") >= 1e6
    });
    let told: Vec<_> = largest
        .map(|row| {
            let seconds = 1e-9 * number(row, "ns_per_particle_step") * number(row, "particles");
            format!("`{}` {seconds:.2} s", row["label"].as_str().unwrap_or_default())
        })
        .collect();
    let why = format!(
        "`scaling`, 10⁶ particles, k/m fixed, a step: {}; nobody measured the way to rest there",
        told.join(", ")
    );
    let (take, _) = at_rest(results)?;
    let take = take.split(';').next().unwrap_or_default().to_owned();
    Ok((format!("{take}, with long steps: unproven at that size"), why))
}
