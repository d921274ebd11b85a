//! Where results come from.

use drape_model::SystemSpec;
use drape_report::Provenance;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::io::BufWriter;
use std::process::Command;

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(Sha256::new_with_prefix(bytes))
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a frozen system's compact JSON text.
pub fn system_hash(spec: &SystemSpec) -> String {
    // The text of a large system would take more memory than the system.
    let mut hash = BufWriter::new(Sha256::new());
    // A specification is lists of numbers and strings, which always serialise.
    match (serde_json::to_writer(&mut hash, spec), hash.into_inner()) {
        (Ok(()), Ok(hash)) => hexadecimal(hash),
        _ => String::new(),
    }
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git")
        .args(["-C", env!("CARGO_MANIFEST_DIR")])
        .args(arguments)
        .output()
        .ok()
        .filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn cpu() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    cpu_name(&info).unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

/// Name of the first processor in `/proc/cpuinfo`, with the numbers that distinguish generations.
fn cpu_name(info: &str) -> Option<String> {
    let value = |key: &str| {
        info.lines().find_map(|line| {
            let (name, value) = line.split_once(':')?;
            (name.trim() == key).then(|| value.trim().to_owned())
        })
    };
    let name = value("model name")?;
    Some(match (value("cpu family"), value("model")) {
        (Some(family), Some(model)) => format!("{name} (family {family}, model {model})"),
        _ => name,
    })
}

/// Provenance of a record that is written now.
pub fn provenance(scene_sha256: BTreeMap<String, String>) -> Provenance {
    let commit = git(&["rev-parse", "HEAD"]);
    let changes = git(&["status", "--porcelain", "--", ":/", ":(exclude,top)results"]);
    Provenance {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        dirty: commit.as_ref().and(changes).map(|changes| !changes.is_empty()),
        commit,
        cargo_lock_sha256: sha256(include_bytes!("../../../Cargo.lock")),
        rustc: env!("DRAPE_RUSTC").to_owned(),
        build: env!("DRAPE_BUILD").to_owned(),
        cpu: cpu(),
        threads: rayon::current_num_threads(),
        scene_sha256,
        seed: None,
        date: humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::cpu_name;

    #[test]
    fn processors_of_the_same_name_are_told_apart() {
        let info = "processor\t: 0\ncpu family\t: 26\nmodel\t\t: 2\nmodel name\t: Some CPU\n\nmodel\t: 7\n";
        assert_eq!(cpu_name(info).as_deref(), Some("Some CPU (family 26, model 2)"));
        assert_eq!(cpu_name("model name : Another\n").as_deref(), Some("Another"));
        assert_eq!(cpu_name("Features : fp asimd\n"), None);
    }
}
