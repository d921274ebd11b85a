//! The index from the paper's equations, and from the names of methods and of their parts, to the
//! items of the code that implement them, collected from their `#[doc(alias = "…")]` attributes.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Where the index is committed, from the root of the workspace.
pub const INDEX: &str = "crates/integrator/docs/equations.md";

/// What must be found in the code: the label, as after `EEH ` in the alias, and what it says.
pub const EQUATIONS: [(&str, &str); 24] = [
    ("1", "linear multistep method"),
    ("2", "Adams methods"),
    ("3", "BDF methods"),
    ("4", "the nonlinear system of an implicit step"),
    ("5", "Newton's method for it"),
    ("6", "split equation, stiff and non-stiff part"),
    ("7", "implicit-explicit multistep method"),
    ("8", "its nonlinear system"),
    ("9", "its linear system, where the stiff part is linear"),
    ("10", "second-order equation of motion, reduced to the velocities"),
    ("11", "force of a spring"),
    ("12", "its linear part"),
    ("13", "its nonlinear part"),
    ("14", "damping of a spring"),
    ("15", "what is integrated implicitly"),
    ("16", "stiffness matrix"),
    ("17", "damping matrix"),
    ("18", "linear force of all springs"),
    ("19", "IMEX Euler"),
    ("20", "update of the positions"),
    ("21", "linear system of IMEX Euler"),
    ("22", "extrapolated start"),
    ("section 6", "collisions as velocity constraints"),
    ("Algorithm 1", "updated and filtered conjugate gradients"),
];

/// An item that carries an alias.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Item {
    /// The alias: `EEH 21` for an equation of the paper, else a name.
    pub label: String,
    /// Path of the item, e.g. `drape_imex::step::advance`.
    pub path: String,
    /// Source file, from the root of the workspace.
    pub file: String,
}

impl Item {
    /// Label of the equation of the paper, if it is one.
    pub fn equation(&self) -> Option<&str> {
        self.label.strip_prefix("EEH ")
    }
}

/// The root of the workspace.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every aliased item of the methods and of what they share. The oracle is left out: it restates
/// equations in order to check them.
///
/// # Errors
/// When a source file cannot be read.
pub fn collect(root: &Path) -> std::io::Result<Vec<Item>> {
    let mut items = Vec::new();
    let mut folders = vec![root.join("crates")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder)? {
            let path = entry?.path();
            if path.is_dir() {
                if !path.ends_with("oracle") {
                    folders.push(path);
                }
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let file = path.strip_prefix(root).unwrap_or(&path);
                let file = file.to_string_lossy().replace('\\', "/");
                items.extend(scan(&file, &std::fs::read_to_string(&path)?));
            }
        }
    }
    items.sort();
    Ok(items)
}

/// The aliased items of one source file.
pub fn scan(file: &str, text: &str) -> Vec<Item> {
    let module = module_of(file);
    let (mut owner, mut labels, mut items) = (None, Vec::new(), Vec::new());
    for line in text.lines() {
        let trimmed = line.trim_start();
        if let Some(alias) = trimmed.strip_prefix("#[doc(alias = \"") {
            labels.extend(alias.split('"').next().map(str::to_owned));
        } else if line.starts_with("impl") || line.starts_with("pub trait ") {
            owner = owner_of(line);
        } else if line == "}" {
            owner = None;
        }
        let is_item = !trimmed.starts_with("#[") && !trimmed.starts_with("//");
        if !labels.is_empty() && is_item && !trimmed.is_empty() {
            let mut path = module.clone();
            let name = name_of(trimmed).unwrap_or_default();
            let owner = owner.as_deref().filter(|owner| *owner != name);
            for part in owner.into_iter().chain([name.as_str()]) {
                path = format!("{path}::{part}");
            }
            let item = |label| Item { label, path: path.clone(), file: file.to_owned() };
            items.extend(labels.drain(..).map(item));
        }
    }
    items
}

/// `crates/integrators/imex/src/two_step/mod.rs` is `drape_imex::two_step`.
fn module_of(file: &str) -> String {
    let (folder, inner) = file.split_once("/src/").unwrap_or((file, "lib.rs"));
    let crate_name = folder.rsplit('/').next().unwrap_or_default().replace('-', "_");
    let inner = inner.trim_end_matches(".rs").trim_end_matches("/mod");
    let mut path = format!("drape_{crate_name}");
    for part in inner.split('/').filter(|part| *part != "lib") {
        path = format!("{path}::{part}");
    }
    path
}

/// The type that an `impl` block or trait belongs to.
fn owner_of(line: &str) -> Option<String> {
    let head = line.split('{').next()?.trim();
    let subject = match head.split_once(" for ") {
        Some((_, subject)) => subject,
        None if head.starts_with("impl<") => head.split_once("> ")?.1,
        None => head.trim_start_matches("pub trait").trim_start_matches("impl").trim(),
    };
    let name: String = subject.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    (!name.is_empty()).then_some(name)
}

/// The name that a line declares.
fn name_of(line: &str) -> Option<String> {
    let words = ["fn ", "struct ", "enum ", "trait ", "const ", "static ", "mod ", "type "];
    let after = words.iter().find_map(|word| {
        let position = line.find(word)?;
        let declares = position == 0 || line[..position].ends_with(' ');
        declares.then(|| &line[position + word.len()..])
    })?;
    let after = after.trim_start_matches("fn ");
    Some(after.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect())
}

/// The index as Markdown.
pub fn render(items: &[Item]) -> String {
    let mut text = String::from(
        "Where each equation of Eberhardt, Etzmuß and Hauth (2000) is in the code.\n\n\
         Written by `cargo run -p drape-tests --bin equation-index` from the `#[doc(alias = \"EEH …\")]` attributes of the \
         items; a search of the sources for `EEH 21` finds the line, a search of these docs those items that are public. How each equation is read where the print is wrong or \
         silent is told in the errata of `drape_imex`. The equations of the other methods stand in the docs of their crates, and their \
         numbers in the code; the second table leads to the crates.\n\n\
         | equation | what it says | in the code |\n|---|---|---|\n",
    );
    for (label, meaning) in EQUATIONS {
        let places = places(items, |item| item.equation() == Some(label));
        let name =
            if label.parse::<u32>().is_ok() { format!("({label})") } else { label.to_owned() };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {name} | {meaning} | {places} |");
    }
    text += "\nThe names of methods, of their authors and of their parts:\n\n| name | in the code |\n|---|---|\n";
    let names = items.iter().filter(|item| item.equation().is_none());
    let names: BTreeSet<_> = names.map(|item| &item.label).collect();
    for name in names {
        let _ = writeln!(text, "| {name} | {} |", places(items, |item| item.label == *name));
    }
    text
}

fn places(items: &[Item], is_meant: impl Fn(&Item) -> bool) -> String {
    let found = items.iter().filter(|item| is_meant(item));
    found.map(|item| format!("`{}`", item.path)).collect::<Vec<_>>().join(", ")
}
