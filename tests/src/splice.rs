//! Numbers of the prose, spliced from the records.
//!
//! A page marks a number so: `<!-- fact: NAME -->8 %<!-- end -->`. [`splice`] replaces the text
//! between the marks by the fact of that name ([`facts`]). Markdown shows neither mark.

use drape_harness::claims::{Standing, standing};
use drape_harness::cost::{other_prices, prices};
use drape_harness::methods;
use drape_harness::studies::claims::facts::Row;
use drape_harness::studies::regret::facts as regret;
use drape_harness::studies::rest::facts as rest;
use drape_harness::studies::trajectory::facts::{Facts, Winner};
use drape_harness::studies::trajectory::{Agreement, by_other_prices, with_longer_steps};
use drape_harness::studies::uses::{self, COLUMNS, DAMPINGS, LEVEL, Use, all_uses, tied, wins};
use drape_harness::studies::work_precision::facts::TimingRow;
use drape_report::number::median;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const BEGIN: &str = "<!-- fact: ";
const CLOSE: &str = " -->";
const END: &str = "<!-- end -->";

/// The pages with facts, from the root of the workspace.
///
/// # Errors
/// When the folder of the guide cannot be read.
pub fn pages(root: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut pages = vec![root.join("README.md"), root.join("CONTRIBUTING.md")];
    for entry in std::fs::read_dir(root.join("crates/drape/docs"))? {
        pages.push(entry?.path());
    }
    pages.sort();
    Ok(pages)
}

/// The text with every marked fact as the records have it.
///
/// # Errors
/// A fact that is unknown, a mark without its end, or a mark at the start of a line of prose, which
/// Markdown would take for a block of HTML.
pub fn splice(text: &str, facts: &BTreeMap<&str, String>) -> Result<String, String> {
    let (mut spliced, mut rest) = (String::new(), text);
    while let Some((before, after)) = rest.split_once(BEGIN) {
        let (name, after) = after.split_once(CLOSE).ok_or("a mark is not closed")?;
        let (_, after) = after.split_once(END).ok_or(format!("fact `{name}` has no end"))?;
        let fact = facts.get(name).ok_or(format!("no fact is called `{name}`"))?;
        let line = before.rsplit('\n').next().unwrap_or_default();
        let is_at_start = line.trim().is_empty();
        if is_at_start != fact.contains('\n') {
            return Err(format!("`{name}`: a table starts a line, a number does not"));
        }
        spliced += &format!("{before}{BEGIN}{name}{CLOSE}{fact}{END}");
        rest = after;
    }
    Ok(spliced + rest)
}

/// All facts that pages may name.
///
/// # Errors
/// When a record cannot be read or lacks what is looked up.
pub fn facts(results: &Path) -> Result<BTreeMap<&'static str, String>, String> {
    let claims = rows(results, "claims", "/facts/claims")?;
    let is_expectation =
        |c: &Value| c["id"].as_str().is_some_and(drape_harness::claims::is_expectation);
    let (expectations, claims): (Vec<Value>, Vec<Value>) =
        claims.into_iter().partition(is_expectation);
    let standings = |rows: &[Value]| -> Result<Vec<Standing>, String> {
        let of = |row: &Value| {
            let row: Row = serde_json::from_value(row.clone()).map_err(|e| e.to_string())?;
            Ok(standing(&row.id, row.verdict, &row.numbers))
        };
        rows.iter().map(of).collect()
    };
    let (stand, expected) = (standings(&claims)?, standings(&expectations)?);
    let with = |all: &[Standing], standing: Standing| {
        all.iter().filter(|other| **other == standing).count().to_string()
    };
    let motions: Facts = uses::facts(results, "trajectory")?;
    // Without damping modelled times are guesses: no count takes them.
    let decided: Vec<_> =
        on_damped_sheets(&motions).filter(|winner| winner.level == LEVEL).collect();
    let ties = decided.iter().filter(|winner| !tied(winner).is_empty()).count();
    let runs = rows(results, "locking", "/facts/runs")?;
    let kept = |label: &str| {
        let at = |run: &&Value| {
            run["label"] == label
                && run["stiffness_over_mass_per_s2"] == 1e6
                && run["step_s"] == 0.01
        };
        let run = runs.iter().find(at).ok_or(format!("locking: no run of {label}"))?;
        let share = run["retained"].as_f64().ok_or("locking: no share of the motion")?;
        Ok::<_, String>(format!("{:.0} %", 100.0 * share))
    };
    let ranked = rows(results, "work-precision", "/facts/rows")?;
    let timings: Vec<TimingRow> = uses::timings(results, "work-precision")?;
    let regret = regret(&uses::timings::<regret::TimingRow>(results, "regret")?)?;
    let engines = results.join("engines");
    let of_engine = |study: &str, list: &str| rows(&engines, study, &format!("/facts/{list}"));
    Ok(BTreeMap::from([
        ("claims", claims.len().to_string()),
        ("claims-hold", with(&stand, Standing::Holds)),
        ("claims-depend", with(&stand, Standing::Depends)),
        ("claims-fail", with(&stand, Standing::Fails)),
        ("claims-undecided", with(&stand, Standing::Undecided)),
        ("expectations", expectations.len().to_string()),
        ("expectations-hold", with(&expected, Standing::Holds)),
        ("expectations-fail", with(&expected, Standing::Fails)),
        ("method-count", methods::all().count().to_string()),
        ("leads", leads(&motions)),
        ("regret-met", regret[0].clone()),
        ("regret-ratio", regret[1].clone()),
        ("ties", format!("{ties} of {}", decided.len())),
        ("winners", winner_table(&motions)),
        ("forms", form_table(&motions)),
        ("form-counts", form_counts(results)?),
        ("imex-euler-kept", kept("imex-euler")?),
        ("imex-updated-kept", kept("imex-updated")?),
        ("time-to-1-percent", times(&timings)),
        ("methods", method_table()),
        ("engine-machine", machine(&engines)?),
        ("engine-order", engine_orders(&of_engine("order", "rows")?)),
        ("engine-energy", engine_energies(&of_engine("energy", "rows")?)),
        ("engine-locking", engine_locking(&of_engine("locking", "runs")?)),
        ("engine-place", engine_place(&of_engine("work-precision", "rows")?, &ranked)),
        ("rest-modelled", rest_modelled(results)?),
        ("other-prices", agreement(by_other_prices(&motions, other_prices()))),
        ("longer-steps", agreement(with_longer_steps(&motions))),
        ("untested-prices", untested_prices(&motions)),
        ("light-prices", light_prices(&motions, &ranked)),
        ("large-cloth", uses::on_large_cloth(results)?),
        ("large-cloth-long", uses::on_large_cloth_for_long(results)?),
        ("lines-substeps", uses::substeps_of_lines(results)?),
        ("one-call", uses::in_one_call(results)?),
        ("film-command", uses::command_of_film(results)?),
        ("film-bound", uses::bound_of_film(results)?),
        ("bounded", uses::bounded(results)?),
        ("over-model", over_model(&uses::timings::<regret::TimingRow>(results, "regret")?)?),
        ("uses", uses(results)?),
        ("uses-short", uses_in_short(results)?),
    ]))
}

/// A list of a record, `record` being its path below the results without extension.
pub(crate) fn rows(results: &Path, record: &str, pointer: &str) -> Result<Vec<Value>, String> {
    let path = results.join(record).with_extension("json");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let record: Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
    let rows = record.pointer(pointer).and_then(Value::as_array);
    rows.cloned().ok_or_else(|| format!("{}: no list {pointer}", path.display()))
}

/// How often the advice met its target by the clock, and what it cost beside the best form.
fn regret(rows: &[regret::TimingRow]) -> Result<[String; 2], String> {
    let tally = regret::Tally::of(rows.iter().filter_map(regret::TimingRow::outcome));
    let regrets = || rows.iter().filter_map(|row| row.regret);
    let worst = regrets().reduce(f64::max).ok_or("regret: no case was judged by the clock")?;
    let middle = median(regrets()).unwrap_or(worst);
    Ok([
        format!("{} of {}", tally.met, tally.measured()),
        format!("{middle:.2} times the best form's time in the median, {worst:.2} at most"),
    ])
}

/// How far modelled times lie from measured ones on the tables of `rest` whose runs have prices, in
/// seconds and relative to the other runs.
fn rest_modelled(results: &Path) -> Result<String, String> {
    let facts: rest::Facts = uses::facts(results, "rest")?;
    let timings: Vec<rest::TimingRow> = uses::timings(results, "rest")?;
    let ratio = |row: &rest::TimingRow| {
        Some(facts.runs.iter().find(|run| row.is_of(run))?.modelled_s? / row.seconds)
    };
    let ratios: Vec<f64> = timings.iter().filter_map(ratio).collect();
    let least = ratios.iter().copied().reduce(f64::min).ok_or("rest: no run has a price")?;
    let most = ratios.iter().copied().fold(0.0, f64::max);
    let middle = median(ratios.iter().copied()).unwrap_or(most);
    let within =
        |by: f64| ratios.iter().filter(|ratio| (0.75..=1.25).contains(&(**ratio / by))).count();
    let is_same = uses::processor(results, "rest")? == prices().cpu;
    let processor = if is_same { "the processor" } else { "another processor than that" };
    Ok(format!(
        "{least:.2} to {most:.2} times the measured ones (median {middle:.2}), on {processor} of the \
         prices; {} of the {} timed runs lie within 25 %, {} within 25 % of the median",
        within(1.0),
        ratios.len(),
        within(middle)
    ))
}

/// How far the winners of `trajectory` agree with those of a ranking by other rules.
fn agreement(agreement: Agreement) -> String {
    let Agreement { winners, same, tied } = agreement;
    let others = winners - same;
    let same = format!("{same} of the {winners} winners of `trajectory` are the same method");
    match others {
        0 => same,
        others if others == tied => format!("{same}, and the other {others} tie with it here"),
        others => format!("{same}; of the other {others}, {tied} tie with it here"),
    }
}

/// The winners on sheets with damping.
fn on_damped_sheets(motions: &Facts) -> impl Iterator<Item = &Winner> {
    let is_damped =
        |id: &str| motions.scenes.iter().any(|scene| scene.id == id && scene.is_damped());
    motions.winners.iter().filter(move |winner| is_damped(&winner.scene))
}

/// The form of a winner.
fn form_of<'a>(motions: &'a Facts, winner: &Winner) -> Option<&'a str> {
    let row = motions.rows.iter().find(|row| Some(&row.label) == winner.label.as_ref())?;
    Some(row.method.as_str())
}

/// Texts in a row; `none` without any.
fn listed(texts: impl Iterator<Item = String>) -> String {
    let texts: Vec<String> = texts.collect();
    if texts.is_empty() { "none".to_owned() } else { texts.join(", ") }
}

/// Winners on damped sheets whose prices were not tested by leaving out runs: the forms, with their
/// places.
fn untested_prices(motions: &Facts) -> String {
    let mut forms = BTreeMap::new();
    for winner in on_damped_sheets(motions) {
        let form = form_of(motions, winner);
        if let Some(form) =
            form.filter(|form| prices().own(form).is_none_or(|price| price.left_out.is_none()))
        {
            *forms.entry(form).or_insert(0) += 1;
        }
    }
    let told = forms.iter().map(|(form, places)| format!("`{form}` ({places})"));
    listed(told)
}

/// Winners on damped sheets whose prices rest on sheets with light damping alone: the forms,
/// with their sheets. `runs` are the rows of `work-precision`.
fn light_prices(motions: &Facts, runs: &[Value]) -> String {
    let is_light = |form: &str| {
        let own = || runs.iter().filter(|row| row["method"] == form);
        let is_base = |row: &Value| {
            row["scene"].as_str().is_some_and(|scene| scene.starts_with("hanging light"))
        };
        own().next().is_some() && own().all(is_base)
    };
    let mut forms: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for winner in on_damped_sheets(motions) {
        if let Some(form) = form_of(motions, winner).filter(|form| is_light(form)) {
            forms.entry(form).or_default().insert(&winner.scene);
        }
    }
    let told = forms.iter().map(|(form, scenes)| {
        let scenes: Vec<&str> = scenes.iter().copied().collect();
        format!("`{form}` ({})", scenes.join("; "))
    });
    listed(told)
}

/// Measured over modelled times on the scenes of `regret`: the range on all scenes but the worst,
/// and the largest on that.
fn over_model(rows: &[regret::TimingRow]) -> Result<String, String> {
    let ratios = || rows.iter().filter_map(|row| Some((row.over_model?, row.scene.as_str())));
    let worst = ratios().max_by(|a, b| a.0.total_cmp(&b.0));
    let (last, scene) = worst.ok_or("regret: no run was timed beside the model")?;
    let others = || ratios().filter(|(_, other)| *other != scene).map(|(ratio, _)| ratio);
    let least = others().reduce(f64::min).ok_or("regret: one scene was timed beside the model")?;
    let most = others().fold(0.0, f64::max);
    Ok(format!("{least:.2} to {most:.2} times the modelled ones, and {last:.2} times on `{scene}`"))
}

/// Who leads for an error of [`LEVEL`] at which stiffness, with how many ties.
fn leads(facts: &Facts) -> String {
    let cell = |winner: Option<&Winner>| match winner.map(|winner| (winner, tied(winner).len())) {
        Some((winner, 0)) => named(winner),
        Some((winner, more)) => format!("{} +{more}", named(winner)),
        None => "noise".to_owned(),
    };
    let mut rows = Vec::new();
    for damping in DAMPINGS {
        let wins = wins(facts, damping, LEVEL);
        if rows.is_empty() {
            let at: Vec<String> = wins.iter().map(|(stiffness, _)| power(*stiffness)).collect();
            rows.push(format!("| k/m (s⁻²) | {} |", at.join(" | ")));
            rows.push(format!("|---|{}", "---|".repeat(at.len())));
        }
        let cells: Vec<String> = wins.iter().map(|(_, winner)| cell(*winner)).collect();
        rows.push(format!("| {damping} | {} |", cells.join(" | ")));
    }
    format!("\n{}\n", rows.join("\n"))
}

/// The form of a winner; none where no run gets there.
fn named(winner: &Winner) -> String {
    winner.label.as_ref().map_or_else(|| "none".to_owned(), |label| format!("`{label}`"))
}

/// The names of some methods that tie with a winner, and the number of others.
fn ties(winner: &Winner, most: usize) -> String {
    let tied = tied(winner);
    if tied.is_empty() {
        return String::new();
    }
    let names: Vec<_> = tied.iter().take(most).map(|name| format!("`{name}`")).collect();
    let more = tied.len().saturating_sub(most);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("; tie: {}{more}", names.join(", "))
}

/// Winners on the hanging sheet, with those that tie.
fn winner_table(facts: &Facts) -> String {
    let mut text = "\n\n| damping | k/m (s⁻²) | error ≤ 10 % | error ≤ 1 % | error ≤ 0.1 % |\n\
                    |---|---|---|---|---|\n"
        .to_owned();
    let cell = |winner: &Option<&Winner>| match winner {
        Some(winner) => format!("**{}**{}", named(winner), ties(winner, 3)),
        None => "too noisy to rank".to_owned(),
    };
    let mut dampings: Vec<&str> = Vec::new();
    for scene in &facts.scenes {
        if !dampings.contains(&scene.damping.as_str()) {
            dampings.push(&scene.damping);
        }
    }
    for damping in dampings {
        let columns = [0.1, LEVEL, 1e-3].map(|level| wins(facts, damping, level));
        for (k, (stiffness, _)) in columns[0].iter().enumerate() {
            let cells = columns.iter().filter_map(|column| column.get(k));
            let cells: Vec<_> = cells.map(|(_, winner)| cell(winner)).collect();
            // Writing to a string cannot fail.
            let _ = writeln!(text, "| {damping} | {} | {} |", power(*stiffness), cells.join(" | "));
        }
    }
    text + "\n"
}

/// The settings of the forms that win, as the command takes them.
fn form_table(facts: &Facts) -> String {
    let mut text = "\n\n| form | `--method` |\n|---|---|\n".to_owned();
    let wins = |label: &str| facts.winners.iter().any(|w| w.label.as_deref() == Some(label));
    let mut known: Vec<&str> = Vec::new();
    for row in &facts.rows {
        let is_plain = row.label == row.method && row.knob == "steps";
        if is_plain || known.contains(&&*row.label) || !wins(&row.label) {
            continue;
        }
        known.push(&row.label);
        let more = match row.knob.as_str() {
            "steps" => String::new(),
            knob => format!(", with `{knob}` varied"),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {} | `{}`{more} |", row.label, row.method);
    }
    text + "\n"
}

/// A power of ten as prose writes it.
fn power(value: f64) -> String {
    let digits = (value.log10().round() as i32).to_string();
    let raised = |c: char| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(c as usize - '0' as usize).unwrap_or('⁻');
    format!("10{}", digits.chars().map(raised).collect::<String>())
}

/// Least measured time of each form to an error of 1 % at k/m = 10⁶ s⁻², the fastest first.
fn times(timings: &[TimingRow]) -> String {
    let mut text = "\n\n| damping | form | time (ms) |\n|---|---|---|\n".to_owned();
    for damping in ["light", "heavy"] {
        let scene = format!("hanging {damping} 1e6 n=400");
        let mut best: BTreeMap<&str, f64> = BTreeMap::new();
        for row in
            timings.iter().filter(|row| row.scene == scene && row.is_verified && row.error <= LEVEL)
        {
            let least = best.entry(&row.label).or_insert(f64::INFINITY);
            *least = least.min(row.seconds);
        }
        let mut best: Vec<_> = best.into_iter().collect();
        best.sort_by(|a, b| a.1.total_cmp(&b.1));
        for (label, seconds) in best.into_iter().take(8) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "| {damping} | {label} | {:.1} |", 1e3 * seconds);
        }
    }
    text + "\n"
}

/// A cell of a table; a dash where it is empty.
fn or_dash(text: &str) -> &str {
    if text.is_empty() { "–" } else { text }
}

/// The uses with their reasons.
fn uses(results: &Path) -> Result<String, String> {
    let columns = COLUMNS.join(" | ");
    let mut text = format!("\n\n| use | {columns} | the record says |\n|---|---|---|---|---|\n");
    for Use { what, take, measured, bundled, why } in all_uses(results)? {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {what} | {take} | {measured} | {} | {why} |", or_dash(&bundled));
    }
    Ok(format!("{text}\n{}\n\n", uses::measured_on(results)?))
}

/// The uses alone; the page of methods has the reasons.
fn uses_in_short(results: &Path) -> Result<String, String> {
    let reasons = "[reasons](crates/drape/docs/methods.md)";
    let columns = COLUMNS.join(" | ");
    let mut text = format!("\n| use ({reasons}) | {columns} |\n|---|---|---|---|\n");
    for Use { what, take, measured, bundled, .. } in all_uses(results)? {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {what} | {take} | {measured} | {} |", or_dash(&bundled));
    }
    Ok(format!(
        "{text}\n{} {} The last column: what `drape compare` advises for the motion.\n",
        uses::measured_on(results)?,
        uses::light_damping(results)?
    ))
}

/// The methods as the registry describes them.
fn method_table() -> String {
    let mut text =
        "\n\n| id | method | source | order | theory |\n|---|---|---|---|---|\n".to_owned();
    for method in methods::all() {
        let order = method.order.number();
        let (id, name, source, theory) = (method.id, method.name, method.source, method.theory);
        let _ = writeln!(text, "| `{id}` | {name} | {source} | {order} | {theory} |");
    }
    text + "\n"
}

/// The studies that compare all methods, with the list of their runs.
const COMPARING: [(&str, &str); 11] = [
    ("order", "rows"),
    ("momentum", "rows"),
    ("stability", "cells"),
    ("locking", "runs"),
    ("energy", "rows"),
    ("hard-cases", "cells"),
    ("effects", "cells"),
    ("work-precision", "rows"),
    ("trajectory", "rows"),
    ("animation", "runs"),
    ("rest", "runs"),
];

/// How many methods and forms each of these studies runs.
fn form_counts(results: &Path) -> Result<String, String> {
    let mut text = "\n\n| study | methods | forms |\n|---|---|---|\n".to_owned();
    for (study, list) in COMPARING {
        let runs = rows(results, study, &format!("/facts/{list}"))?;
        let (mut ids, mut forms) = (BTreeSet::new(), BTreeSet::new());
        for run in &runs {
            let method = run["method"].as_str().unwrap_or_default();
            let id = method.split([':', ' ']).next().unwrap_or_default();
            // `dop853` is not a method of drape.
            if methods::all().any(|known| known.id == id) {
                ids.insert(id);
                forms.insert(run["label"].as_str().unwrap_or(method));
            }
        }
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| `{study}` | {} | {} |", ids.len(), forms.len());
    }
    Ok(text + "\n")
}

/// The processor of the records of the engine.
fn machine(engines: &Path) -> Result<String, String> {
    let record = engines.join("order.json");
    let text =
        std::fs::read_to_string(&record).map_err(|e| format!("{}: {e}", record.display()))?;
    let record: Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
    let cpu = record.pointer("/provenance/cpu").and_then(Value::as_str);
    cpu.map(str::to_owned).ok_or_else(|| "engines/order: no processor".to_owned())
}

/// What a program's command ends with: the solver of the engine.
pub(crate) fn solver(row: &Value) -> &str {
    let label = row["label"].as_str().unwrap_or_default();
    label.split_once(".py ").map_or(label, |(_, solver)| solver)
}

/// A number with so many decimals, or a dash.
fn decimals(value: &Value, count: usize) -> String {
    value.as_f64().map_or_else(|| "—".to_owned(), |value| format!("{value:.count$}"))
}

/// Orders and error constants.
fn engine_orders(rows: &[Value]) -> String {
    let mut text = "\n\n| solver | scene | order | C | largest step (s) | its error |\n\
                    |---|---|---|---|---|---|\n"
        .to_owned();
    for row in rows {
        let first = &row["runs"][0];
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {} | {} |",
            solver(row),
            row["scene"].as_str().unwrap_or_default(),
            decimals(&row["order"], 2),
            decimals(&row["error_constant"], 2),
            first["step_s"],
            decimals(&first["error"], 3),
        );
    }
    text + "\n"
}

/// Verdicts on the energy, and the share of it that is gone at the end.
fn engine_energies(rows: &[Value]) -> String {
    let mut text =
        "\n\n| solver | scene | step (s) | verdict | energy at the end over the start |\n\
                    |---|---|---|---|---|\n"
            .to_owned();
    for row in rows {
        let kept = row["drift"].as_f64().map(|drift| Value::from(1.0 + drift));
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {} |",
            solver(row),
            row["scene"].as_str().unwrap_or_default(),
            row["step_s"],
            row["verdict"].as_str().unwrap_or_default(),
            decimals(&kept.unwrap_or_default(), 3),
        );
    }
    text + "\n"
}

/// The share of the path that is kept.
fn engine_locking(rows: &[Value]) -> String {
    let mut text = "\n\n| solver | verdict | path kept |\n|---|---|---|\n".to_owned();
    for row in rows {
        let share = row["retained"].as_f64().map(|share| format!("{:.0} %", 100.0 * share));
        let (solver, verdict) = (solver(row), row["verdict"].as_str().unwrap_or_default());
        let _ = writeln!(text, "| `{solver}` | {verdict} | {} |", share.as_deref().unwrap_or("—"));
    }
    text + "\n"
}

/// The rows of the engine's solvers and of some methods on the same scene, and whether each is ours.
pub(crate) fn engine_rows<'a>(engine: &'a [Value], ours: &'a [Value]) -> Vec<(bool, &'a Value)> {
    const BESIDE: [&str; 4] = ["symplectic-euler", "leapfrog", "xpbd", "vbd"];
    let scene = engine.first().map(|row| row["scene"].clone()).unwrap_or_default();
    let beside = |row: &&Value| row["scene"] == scene && BESIDE.iter().any(|b| row["label"] == *b);
    let is_engine = |row: &&Value| row["label"].as_str().is_some_and(|l| l.starts_with("program:"));
    let engine = engine.iter().filter(is_engine).map(|row| (false, row));
    engine.chain(ours.iter().filter(beside).map(|row| (true, row))).collect()
}

/// Fewest sweeps over all springs that bring the error to a level, of the engine's solvers and of
/// some methods.
fn engine_place(engine: &[Value], ours: &[Value]) -> String {
    const LEVELS: [f64; 2] = [0.1, LEVEL];
    let mut text =
        "\n\n| method | sweeps for an error of 10 % | for 1 % |\n|---|---|---|\n".to_owned();
    let fewest = |row: &Value, level: f64| {
        let runs = row["runs"].as_array().map_or(&[][..], Vec::as_slice);
        let good = runs.iter().filter(|run| run["error"].as_f64().is_some_and(|e| e <= level));
        let sweeps = good.filter_map(|run| run["force_evaluations"].as_u64()).min();
        sweeps.map_or_else(|| "—".to_owned(), |sweeps| sweeps.to_string())
    };
    for (is_ours, row) in engine_rows(engine, ours) {
        let [coarse, fine] = LEVELS.map(|level| fewest(row, level));
        let whose = if is_ours { "drape" } else { "Newton" };
        let _ = writeln!(text, "| `{}` of {whose} | {coarse} | {fine} |", solver(row));
    }
    text + "\n"
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::equations::root;

    #[test]
    fn no_number_of_the_prose_is_stale() {
        let facts = facts(&root().join("results")).unwrap();
        for page in pages(&root()).unwrap() {
            let text = std::fs::read_to_string(&page).unwrap();
            let hint = "run `cargo run -p drape-tests --bin splice`";
            assert_eq!(splice(&text, &facts).unwrap(), text, "{}: {hint}", page.display());
        }
    }

    #[test]
    fn a_stale_number_is_replaced_and_a_wrong_mark_is_named() {
        let facts = BTreeMap::from([("n", "2".to_owned()), ("table", "\n| a |\n".to_owned())]);
        let text = "It has <!-- fact: n -->1<!-- end --> ends.\n<!-- fact: table --><!-- end -->\n";
        let spliced = splice(text, &facts).unwrap();
        assert!(spliced.contains("-->2<!-- end --> ends") && spliced.contains("-->\n| a |\n<!--"));
        assert_eq!(splice(&spliced, &facts).unwrap(), spliced);
        for wrong in [
            "a <!-- fact: m -->1<!-- end -->",
            "a <!-- fact: n -->1",
            "<!-- fact: n -->1<!-- end -->",
        ] {
            assert!(splice(wrong, &facts).is_err(), "{wrong}");
        }
        assert_eq!(power(1e8), "10⁸");
    }

    /// Every path that a page names is there, and the file holds the word that the page says.
    #[test]
    fn every_path_and_word_of_the_pages_is_there() {
        for page in pages(&root()).unwrap() {
            let text = std::fs::read_to_string(&page).unwrap();
            for line in text.lines() {
                let spans: Vec<&str> = line.split('`').skip(1).step_by(2).collect();
                let is_path = |span: &&str| {
                    ["crates/", "results/", "tests/", "benches/", ".ci/"]
                        .iter()
                        .any(|start| span.starts_with(start))
                        && !span.contains(['*', '<', ' ', '…'])
                        && !span.contains("NAME")
                        && !span.ends_with("report.html")
                };
                for path in spans.iter().filter(|span| is_path(span)) {
                    let file = root().join(path);
                    assert!(file.exists(), "{}: `{path}` is not there", page.display());
                    let is_finding_aid = page.ends_with("places.md") && line.starts_with('|');
                    if let (true, Some(word)) = (is_finding_aid, spans.get(1)) {
                        let text = std::fs::read_to_string(&file).unwrap();
                        assert!(text.contains(word), "{path} does not hold `{word}`");
                    }
                }
            }
            let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
            for link in links.filter(|link| !link.starts_with(['#', '<']) && !link.contains("://"))
            {
                let file = page.with_file_name(link.split('#').next().unwrap_or_default());
                assert!(file.exists(), "{}: link to {link}", page.display());
            }
        }
    }

    #[test]
    fn the_first_page_is_short() {
        let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
        assert!(readme.lines().count() <= 150);
    }

    /// A phone is about 400 pixels wide. It shows letters of 14 pixels of such a figure with 8.
    #[test]
    fn the_figures_on_the_first_page_can_be_read_on_a_phone() {
        let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
        let figures: Vec<&str> = readme
            .split("![")
            .skip(1)
            .filter_map(|rest| rest.split_once("](")?.1.split(')').next())
            .collect();
        assert!(!figures.is_empty());
        for figure in figures {
            let svg = std::fs::read_to_string(root().join(figure)).unwrap();
            let width = svg.split("width=\"").nth(1).and_then(|rest| rest.split('"').next());
            let width: u32 = width.and_then(|width| width.parse().ok()).expect(figure);
            assert!(width <= 680, "{figure}: {width} pixels wide");
        }
    }
}
