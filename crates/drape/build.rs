//! Records the commit that the program is built from, for the provenance of results.
//!
//! It belongs to this crate because the crate that is built last is rebuilt after each commit
//! anyway.

use std::path::Path;
use std::process::Command;

/// The sources of the program, from the folder of this crate.
const SOURCES: [&str; 3] = ["../../crates", "../../Cargo.toml", "../../Cargo.lock"];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    // Cargo looks at all files below a folder.
    for source in SOURCES.iter().filter(|source| Path::new(source).exists()) {
        println!("cargo:rerun-if-changed={source}");
    }
    // Another repository may lie around the folder: this one knows its files.
    let is_known = git(&["ls-files", "--error-unmatch", "Cargo.toml"]).is_some();
    let commit = git(&["rev-parse", "--verify", "HEAD"]).filter(|_| is_known);
    let status = ["status", "--porcelain", "--untracked-files=normal", "--"];
    let changes = git(&[&status[..], &SOURCES].concat()).filter(|_| commit.is_some());
    let dirty = changes.map(|changes| (!changes.is_empty()).to_string());
    println!("cargo:rustc-env=DRAPE_COMMIT={}", commit.as_deref().unwrap_or_default());
    println!("cargo:rustc-env=DRAPE_DIRTY={}", dirty.unwrap_or_default());
    if commit.is_some() {
        watch();
    }
}

/// Runs this script again when the commit changes.
fn watch() {
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    let names = ["HEAD", "packed-refs"].into_iter().chain(branch.as_deref());
    for path in names.filter_map(|name| git(&["rev-parse", "--git-path", name])) {
        // A branch that is packed has no file yet: its folder changes when it gets one.
        let there = Path::new(&path).ancestors().find(|path| path.exists());
        // The folder of the repository itself changes all the time.
        let there = there.filter(|path| path.is_file() || path.iter().any(|part| part == "refs"));
        if let Some(there) = there {
            println!("cargo:rerun-if-changed={}", there.display());
        }
    }
}

/// What git answers about this folder; `None` where it fails. Variables such as `GIT_DIR`, which
/// name another repository, do not count.
fn git(arguments: &[&str]) -> Option<String> {
    let mut command = Command::new("git");
    let variables = std::env::vars_os().map(|(name, _)| name);
    for name in variables.filter(|name| name.to_string_lossy().starts_with("GIT_")) {
        command.env_remove(name);
    }
    // Without the option a look at the state would write the index.
    let output = command.arg("--no-optional-locks").args(arguments).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    output.status.success().then_some(text)
}
