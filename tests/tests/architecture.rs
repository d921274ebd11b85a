//! Which crate may import which, over `cargo metadata`.

use cargo_metadata::{DependencyKind, MetadataCommand, Package};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// What the methods of a family may import.
const METHOD: &[&str] = &["drape-model", "drape-solvers", "drape-integrator"];

/// A room of the house: who may be imported there, and what a wrong import would break.
struct Room {
    imports: &'static [&'static str],
    /// Imported by tests only.
    tests: &'static [&'static str],
    wall: &'static str,
}

/// The room of a crate, by its name and the folder of its manifest.
fn room(name: &str, folder: &str) -> Room {
    let room = |imports, tests, wall| Room { imports, tests, wall };
    if folder.contains("/crates/integrators/") {
        let wall = "a method imports model, solvers and integrator, never another method and \
                    nothing that runs methods";
        return room(METHOD, &["drape-oracle", "drape-kernels"], wall);
    }
    match name {
        "drape-kernels" => room(
            &[],
            &[],
            "the kernels are below the ground floor: they know no physics and no algebra",
        ),
        "drape-model" => room(
            &["drape-kernels"],
            &[],
            "the model is on the ground floor: it knows no time step and no solver",
        ),
        "drape-solvers" => room(
            &["drape-kernels"],
            &[],
            "the solvers are on the ground floor: they know no physics",
        ),
        "drape-integrator" => room(
            &["drape-model", "drape-solvers"],
            &["drape-oracle", "drape-kernels"],
            "the integrator crate joins physics and linear algebra, and knows no method",
        ),
        "drape-oracle" => room(
            &["drape-kernels", "drape-model", "drape-integrator"],
            &[],
            "the oracle is independent of what it checks: it imports no method",
        ),
        "drape-harness" => room(
            &[
                "drape-model",
                "drape-solvers",
                "drape-integrator",
                "drape-oracle",
                "drape-render",
                "drape-report",
                "drape-explicit-euler",
                "drape-backward-euler",
                "drape-imex",
                "drape-provot",
                "drape-baraff-witkin",
                "drape-desbrun",
                "drape-kang",
                "drape-terzopoulos-fleischer",
                "drape-multistep",
                "drape-midpoint",
                "drape-generalized-alpha",
                "drape-dirk",
                "drape-rosenbrock",
                "drape-imex-rk",
                "drape-rkc",
                "drape-srkn4",
                "drape-exponential",
                "drape-xpbd",
                "drape-xpbd-lines",
                "drape-projective",
                "drape-vbd",
                "drape-energy-momentum",
                "drape-multirate",
                "drape-program",
            ],
            &[],
            "the harness runs methods, writes records and hands them to the report",
        ),
        "drape-render" => room(
            &["drape-model"],
            &[],
            "the render crate draws positions that it is given: it runs nothing and reads no record",
        ),
        "drape-report" => {
            room(&[], &[], "the report draws what it is given: it runs nothing and knows no study")
        }
        "drape-lab" => room(
            &["drape-model", "drape-integrator", "drape-harness", "drape-render", "drape-report"],
            &[],
            "the lab knows methods by their ids only, through the harness",
        ),
        "drape-lab-wasm" => room(&["drape-lab"], &[], "it is a door to the lab and no more"),
        "drape-python" => room(
            &["drape-model", "drape-integrator", "drape-harness"],
            &[],
            "the Python package knows methods by their ids only, through the harness",
        ),
        "drape" => room(
            &[
                "drape-model",
                "drape-integrator",
                "drape-harness",
                "drape-lab",
                "drape-render",
                "drape-report",
            ],
            &[],
            "the command line knows methods by their ids only, through the harness",
        ),
        _ => room(&[], &[], "it is not in the plan of the house: give it a room in this test"),
    }
}

/// Packages for tests and benches, which nobody imports.
const WORKSHOPS: [&str; 2] = ["drape-tests", "drape-benches"];

fn packages() -> Vec<Package> {
    let metadata = MetadataCommand::new().no_deps().exec();
    metadata.unwrap_or_else(|error| panic!("{error}")).packages
}

fn folder(package: &Package) -> &str {
    package.manifest_path.parent().map_or("", |folder| folder.as_str())
}

/// One sentence for each import through a wall.
fn broken_walls(packages: &[Package]) -> Vec<String> {
    let ours = |name: &str| packages.iter().any(|package| package.name.as_str() == name);
    let mut broken = Vec::new();
    for package in packages {
        let name = package.name.as_str();
        let Room { imports, tests, wall } = room(name, folder(package));
        for dependency in package.dependencies.iter().filter(|d| ours(d.name.as_str())) {
            let other = dependency.name.as_str();
            let allowed = match dependency.kind {
                _ if WORKSHOPS.contains(&other) => false,
                _ if WORKSHOPS.contains(&name) => true,
                DependencyKind::Normal | DependencyKind::Build => imports.contains(&other),
                _ => imports.contains(&other) || tests.contains(&other),
            };
            if !allowed {
                broken.push(format!("{name} must not import {other}: {wall}"));
            }
        }
    }
    broken
}

#[test]
fn no_crate_imports_through_a_wall() {
    let packages = packages();
    assert!(packages.len() >= 12, "all rooms are there");
    let broken = broken_walls(&packages);
    assert!(broken.is_empty(), "\n{}\n", broken.join("\n"));
}

/// The check sees a wrong import, and says which wall it breaks.
#[test]
fn a_wrong_import_is_named() {
    let mut packages = packages();
    let wrong = [
        ("drape-imex", "drape-backward-euler", "never another method"),
        ("drape-model", "drape-solvers", "ground floor"),
        ("drape-oracle", "drape-imex", "independent"),
        ("drape-report", "drape-harness", "runs nothing"),
    ];
    for (importer, imported, _) in wrong {
        // Any dependency will do as a pattern.
        let pattern = packages.iter().flat_map(|package| &package.dependencies).next().cloned();
        let mut dependency = pattern.expect("some crate imports something");
        dependency.name = imported.to_owned();
        dependency.kind = DependencyKind::Normal;
        let importer = packages.iter_mut().find(|package| package.name.as_str() == importer);
        importer.expect("a member").dependencies.push(dependency);
    }
    let broken = broken_walls(&packages);
    assert_eq!(broken.len(), wrong.len(), "{broken:?}");
    for (importer, imported, wall) in wrong {
        let named = |text: &&String| {
            text.starts_with(&format!("{importer} must not import {imported}"))
                && text.contains(wall)
        };
        assert!(broken.iter().find(named).is_some(), "{importer} → {imported}: {broken:?}");
    }
}

/// Lints, version, edition and licence are said once, in the workspace.
#[test]
fn every_crate_inherits_the_lints_of_the_workspace() {
    for package in packages() {
        let text = std::fs::read_to_string(&package.manifest_path).expect("readable manifest");
        let lints = text.split("[lints]").nth(1).unwrap_or_default();
        let inherits = lints.trim_start().starts_with("workspace = true");
        // Exports need an attribute that counts as unsafe; everything else is as elsewhere.
        let is_door = package.name == "drape-lab-wasm" && text.contains("unsafe_code = \"deny\"");
        let place = &package.manifest_path;
        assert!(inherits || is_door, "{place}: add `[lints] workspace = true`");
        for key in ["version", "edition", "license"] {
            let line = format!("{key}.workspace = true");
            assert!(text.contains(&line), "{}: add `{line}`", package.manifest_path);
        }
    }
}

/// Modules and crates that run, step or solve: plates and words of a study must not reach them.
const RUNS: &[&str] = &[
    "film",
    "run",
    "drape_solvers",
    "drape_integrator",
    "drape_oracle",
    "drape_harness",
    "methods",
    "ordered",
    "schedule",
    "scenes",
    "sheet",
    "stability",
    "stepper",
    "variant",
];

/// Whether a path begins with the crate of a method.
fn is_method(name: &str) -> bool {
    let folder = name.strip_prefix("drape_").map(|name| name.replace('_', "-"));
    let methods = drape_tests::equations::root().join("crates/integrators");
    folder.is_some_and(|folder| methods.join(folder).is_dir())
}

/// Paths in a study's drawing code that lead to code that runs something.
fn forbidden_paths(source: &str) -> Vec<String> {
    let code: String = source
        .split("#[cfg(test)]")
        .next()
        .unwrap_or_default()
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect::<Vec<_>>()
        .join("\n");
    let words = code.split(|c: char| !(c.is_alphanumeric() || "_:{".contains(c)));
    let reaches = |path: &&str| {
        let mut parts = path.split("::").map(|part| part.trim_matches(['{', ':']));
        let first = parts.next().unwrap_or_default();
        match first {
            "super" | "crate" => parts.any(|part| RUNS.contains(&part)),
            name => name.starts_with("drape_") && (RUNS.contains(&name) || is_method(name)),
        }
    };
    words.filter(reaches).map(str::to_owned).collect()
}

/// Pages are drawn from records alone: what a study draws and says cannot run anything.
#[test]
fn plates_and_words_reach_nothing_that_runs() {
    let studies = concat!(env!("CARGO_MANIFEST_DIR"), "/../crates/harness/src/studies");
    let mut seen = 0;
    for entry in std::fs::read_dir(studies).expect("the folder of the studies") {
        let folder = entry.expect("an entry").path();
        for file in ["plates.rs", "plates/tabulated.rs", "words.rs"].map(|file| folder.join(file)) {
            let Ok(source) = std::fs::read_to_string(&file) else { continue };
            let found = forbidden_paths(&source);
            assert!(found.is_empty(), "{}: {found:?} run something", file.display());
            seen += 1;
        }
    }
    assert!(seen >= 36, "every study has plates and words, found {seen}");
}

/// A claim reads recorded numbers: what is run for it belongs to a study.
#[test]
fn claims_reach_nothing_that_runs() {
    let claims = concat!(env!("CARGO_MANIFEST_DIR"), "/../crates/harness/src/claims");
    let mut seen = 0;
    for entry in std::fs::read_dir(claims).expect("the folder of the claims") {
        let file = entry.expect("an entry").path();
        let source = std::fs::read_to_string(&file).expect("a source file");
        let found = forbidden_paths(&source);
        assert!(found.is_empty(), "{}: {found:?} run something", file.display());
        seen += 1;
    }
    assert!(seen >= 30, "one file a claim and their list, found {seen}");
}

/// The scan sees each way to reach a run.
#[test]
fn a_plate_that_runs_something_is_named() {
    let wrong = [
        "use super::run;",
        "use super::run::BASE_STEP;",
        "use crate::run::Simulation;",
        "use crate::methods::Choice;",
        "use crate::studies::sheet;",
        "use drape_solvers::Cg;",
        "let v = drape_imex::METHOD.id;",
        "fn f() { super::super::order::run::rows() }",
    ];
    for source in wrong {
        assert!(!forbidden_paths(source).is_empty(), "{source}");
    }
    let right =
        "use super::facts::Facts;\nuse drape_report::plot::Sheet;\n// super::run is not code";
    assert!(forbidden_paths(right).is_empty());
}

/// A sample of what the house can be given one more of, and every file that names it.
///
/// To add another one touches files of the same kinds. The list may only become shorter.
struct Sample {
    what: &'static str,
    /// How it is called in code.
    names: &'static [&'static str],
    /// Beginnings of the paths that are its own.
    own: &'static [&'static str],
    /// Files outside that name it.
    places: &'static [&'static str],
}

const SAMPLES: [Sample; 4] = [
    Sample {
        what: "the method Kang",
        names: &["kang", "drape_kang", "drape-kang"],
        own: &["crates/integrators/kang/", "crates/harness/src/methods/kang.rs"],
        places: &[
            "Cargo.toml",
            "benches/src/bin/profile/bound.rs",
            "crates/harness/Cargo.toml",
            "crates/harness/src/claims/c07.rs",
            "crates/harness/src/methods/mod.rs",
            "crates/harness/src/ordered_tests.rs",
            "crates/harness/src/studies/claims/run/evidence/e07.rs",
            "crates/harness/src/studies/claims/run/evidence/e13.rs",
            "crates/harness/src/studies/course/lessons.rs",
            "crates/harness/src/studies/course/plates.rs",
            "crates/harness/tests/common/mod.rs",
            "crates/oracle/src/laws.rs",
            "crates/oracle/src/laws/tests.rs",
            "tests/src/lib.rs",
            "tests/tests/conservation.rs",
            "tests/tests/contact.rs",
            "tests/tests/contract.rs",
            "tests/tests/energy_ledger.rs",
            "tests/tests/laws.rs",
            "tests/tests/motion.rs",
            "tests/tests/order.rs",
            "tests/tests/recurrence.rs",
            "tests/tests/threads.rs",
        ],
    },
    Sample {
        what: "the effect of hinges",
        names: &["hinge", "hinges", "Hinge", "Hinges", "HingeSpec"],
        own: &["crates/model/src/effects/hinge.rs", "crates/model/src/effects/hinge/"],
        places: &[
            "crates/harness/src/stability.rs",
            "crates/harness/src/studies/animation/run/mod.rs",
            "crates/harness/src/studies/claims/run/meshes.rs",
            "crates/harness/src/studies/effects/run/additions.rs",
            "crates/harness/src/studies/effects/run/tests.rs",
            "crates/harness/src/studies/fabric/facts.rs",
            "crates/harness/src/studies/fabric/plates.rs",
            "crates/harness/src/studies/sheet.rs",
            "crates/integrator/tests/stencils.rs",
            "crates/model/src/effects/mod.rs",
            "crates/model/src/fabric/material.rs",
            "crates/model/src/fabric/weave.rs",
            "crates/model/src/lib.rs",
            "crates/model/src/spec.rs",
            "crates/model/tests/material.rs",
            "crates/model/tests/refusals.rs",
            "crates/model/tests/round_trip.rs",
            "crates/model/tests/schema.rs",
            "crates/model/tests/stencils.rs",
            "crates/oracle/tests/cantilever.rs",
            "crates/oracle/tests/stencils.rs",
            "tests/tests/refusals.rs",
        ],
    },
    Sample {
        what: "the study of scaling",
        names: &["scaling"],
        // A study that does not run methods at their defaults only asks each for its forms.
        own: &["crates/harness/src/studies/scaling/", "crates/harness/src/methods/"],
        places: &[
            "crates/harness/src/studies/mod.rs",
            "crates/harness/tests/common/mod.rs",
            "crates/harness/tests/common/work.rs",
            "crates/harness/tests/draw.rs",
            // Only a study whose numbers stand in the prose is named there.
            "crates/harness/src/studies/uses.rs",
            // Only a study that compares all methods is named there.
            "tests/tests/rows.rs",
        ],
    },
    Sample {
        what: "claim 7",
        names: &["C07", "c07", "e07"],
        own: &["crates/harness/src/claims/c07.rs", "crates/harness/src/studies/claims/run/"],
        places: &["crates/harness/src/claims/mod.rs"],
    },
];

/// Code of the workspace: paths from its root, with their texts.
fn sources() -> Vec<(String, String)> {
    fn walk(folder: &Path, files: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).expect("a folder of the workspace") {
            let path = entry.expect("an entry").path();
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            if path.is_dir() && name != "target" && !name.starts_with('.') {
                walk(&path, files);
            } else if name.ends_with(".rs") || name == "Cargo.toml" {
                files.push(path);
            }
        }
    }
    let root = drape_tests::equations::root();
    let mut files = vec![root.join("Cargo.toml")];
    ["crates", "benches", "tests"].iter().for_each(|room| walk(&root.join(room), &mut files));
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).expect("a readable file");
        let name = path.strip_prefix(&root).expect("below the root").display().to_string();
        (name, text)
    };
    files.into_iter().map(read).collect()
}

impl Sample {
    /// Files that name it and are not its own.
    fn found<'a>(&self, sources: &'a [(String, String)]) -> BTreeSet<&'a str> {
        let is_name = |word: &str| self.names.contains(&word);
        let is_code = |line: &&str| !line.trim_start().starts_with("//");
        let names_it = |text: &str| {
            let of_line = |line: &str| {
                line.split(|c: char| !(c.is_alphanumeric() || "_-".contains(c))).any(is_name)
            };
            text.lines().filter(is_code).any(of_line)
        };
        let is_foreign = |path: &str| {
            path != THIS && !self.own.iter().any(|beginning| path.starts_with(beginning))
        };
        let files = sources.iter().filter(|(path, text)| is_foreign(path) && names_it(text));
        files.map(|(path, _)| path.as_str()).collect()
    }
}

/// This file names the samples themselves.
const THIS: &str = "tests/tests/architecture.rs";

/// One more method, effect, study or claim touches no more places than today.
#[test]
fn the_places_that_a_new_member_touches_do_not_grow() {
    let sources = sources();
    for sample in &SAMPLES {
        let found = sample.found(&sources);
        let listed: BTreeSet<&str> = sample.places.iter().copied().collect();
        let new: Vec<_> = found.difference(&listed).collect();
        assert!(new.is_empty(), "{}: every one of its kind would touch {new:?} too", sample.what);
        let gone: Vec<_> = listed.difference(&found).collect();
        assert!(gone.is_empty(), "{}: take off the list: {gone:?}", sample.what);
    }
}

/// The scan sees a file that names a sample, and only as a whole word.
#[test]
fn a_new_place_is_found() {
    let source = |text: &str| vec![("crates/new.rs".to_owned(), text.to_owned())];
    let method = &SAMPLES[0];
    for text in ["Choice::parse(\"kang:sweeps=8\", &[])", "use drape_kang::METHOD;"] {
        assert_eq!(method.found(&source(text)).len(), 1, "{text}");
    }
    assert!(method.found(&source("let kangaroo = 1;")).is_empty());
}
