//! The provenance of results: program, machine, date and scenes.

use drape_model::SystemSpec;
use drape_report::Provenance;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::io::BufWriter;
use std::path::Path;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(Sha256::new_with_prefix(bytes))
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a frozen system's compact JSON text.
pub fn system_hash(spec: &SystemSpec) -> String {
    // Hash while writing: the text of a large system would take more memory than the system.
    let mut hash = BufWriter::new(Sha256::new());
    // A specification is lists of numbers and strings, which always serialise.
    match (serde_json::to_writer(&mut hash, spec), hash.into_inner()) {
        (Ok(()), Ok(hash)) => hexadecimal(hash),
        _ => String::new(),
    }
}

/// The commit of a source tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Source {
    /// SHA-1 of the commit; `None` where it is unknown.
    pub commit: Option<String>,
    /// Whether the files differ from that commit; `None` where it is unknown.
    pub dirty: Option<bool>,
}

/// The answer of git about a folder; `None` where git fails. Ignores variables such as `GIT_DIR`,
/// which name another repository.
fn git(folder: &Path, arguments: &[&str]) -> Option<String> {
    let mut command = Command::new("git");
    let variables = std::env::vars_os().map(|(name, _)| name);
    for name in variables.filter(|name| name.to_string_lossy().starts_with("GIT_")) {
        command.env_remove(name);
    }
    // Without this option, a query of the state would write the index.
    let command = command.arg("--no-optional-locks").arg("-C").arg(folder).args(arguments);
    let output = command.output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

impl Source {
    /// The present state of the repository that holds `folder`, files below `results/` aside.
    pub fn of_folder(folder: &Path) -> Self {
        let status = ["status", "--porcelain", "--untracked-files=normal", "--", ":/"];
        let without = ":(exclude,top)results";
        let commit = git(folder, &["rev-parse", "--verify", "HEAD"]);
        let changes = commit.as_ref().and(git(folder, &[&status[..], &[without]].concat()));
        Self { commit, dirty: changes.map(|changes| !changes.is_empty()) }
    }

    /// The commit at `folder`, where it differs from that of this source and the repository there
    /// contains the commit of this source; else `None`.
    pub fn other_commit_at(&self, folder: &Path) -> Option<String> {
        let own = self.commit.as_ref()?;
        let there = git(folder, &["rev-parse", "--verify", "HEAD"]).filter(|there| there != own)?;
        git(folder, &["cat-file", "-e", &format!("{own}^{{commit}}")])?;
        Some(there)
    }
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

/// Provenance of a record that a program, built from `source`, writes now.
pub fn provenance(source: &Source, scene_sha256: BTreeMap<String, String>) -> Provenance {
    Provenance {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: source.commit.clone(),
        dirty: source.dirty,
        cargo_lock_sha256: sha256(include_bytes!("../../../Cargo.lock")),
        rustc: env!("DRAPE_RUSTC").to_owned(),
        build: env!("DRAPE_BUILD").to_owned(),
        cpu: cpu(),
        threads: rayon::current_num_threads(),
        scene_sha256,
        seed: None,
        date: date(SystemTime::now()),
    }
}

/// A moment in UTC, ISO 8601. A clock may show any year. Years outside 0 to 9999 get a sign and six
/// digits.
fn date(moment: SystemTime) -> String {
    const DAY: i64 = 86_400;
    let whole = |seconds: u64| i64::try_from(seconds).unwrap_or(i64::MAX);
    let seconds = match moment.duration_since(UNIX_EPOCH) {
        Ok(after) => whole(after.as_secs()),
        Err(error) => {
            let before = error.duration();
            -whole(before.as_secs()) - i64::from(before.subsec_nanos() > 0)
        }
    };
    let (days, second) = (seconds.div_euclid(DAY), seconds.rem_euclid(DAY));
    // Years that begin in March end with the leap day. 400 such years have 146 097 days. Day 0 of
    // the clock is 719 468 days after the first of March of the year 0.
    let since = days + 719_468;
    let (era, day) = (since.div_euclid(146_097), since.rem_euclid(146_097));
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    // From March on, five months have 153 days.
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    let year = 400 * era + year + next;
    let year =
        if (0..=9999).contains(&year) { format!("{year:04}") } else { format!("{year:+07}") };
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::{Source, cpu_name, date};
    use std::path::Path;
    use std::time::{Duration, SystemTime, UNIX_EPOCH};

    fn git(folder: &Path, arguments: &[&str]) {
        let identity = ["-c", "user.name=a", "-c", "user.email=a", "-c", "commit.gpgsign=false"];
        let mut command = std::process::Command::new("git");
        let command = command.arg("-C").arg(folder).args(identity).args(arguments);
        assert!(command.output().expect("git").status.success(), "{arguments:?}");
    }

    /// A repository with one commit.
    fn repository() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        git(folder.path(), &["init", "--quiet"]);
        std::fs::write(folder.path().join("a"), "1").expect("written");
        git(folder.path(), &["add", "a"]);
        git(folder.path(), &["commit", "--quiet", "-m", "one"]);
        folder
    }

    #[test]
    fn a_tree_is_dirty_after_any_change_but_to_the_results() {
        let folder = repository();
        let write = |name: &str| std::fs::write(folder.path().join(name), "2").expect("written");
        let dirty = || Source::of_folder(folder.path()).dirty;
        assert_eq!(dirty(), Some(false));
        std::fs::create_dir(folder.path().join("results")).expect("a folder");
        write("results/new");
        assert_eq!(dirty(), Some(false));
        // A new file counts even where the user has set git not to show new files.
        git(folder.path(), &["config", "status.showUntrackedFiles", "no"]);
        write("new");
        assert_eq!(dirty(), Some(true));
        std::fs::remove_file(folder.path().join("new")).expect("removed");
        assert_eq!(dirty(), Some(false));
        write("a");
        assert_eq!(dirty(), Some(true));
        let nowhere = tempfile::tempdir().expect("a folder");
        assert_eq!(Source::of_folder(nowhere.path()), Source::default());
    }

    #[test]
    fn another_commit_is_told_where_the_repository_is_the_same() {
        let (ours, other) = (repository(), repository());
        let source = Source::of_folder(ours.path());
        assert_eq!(source.other_commit_at(ours.path()), None);
        std::fs::write(ours.path().join("a"), "2").expect("written");
        git(ours.path(), &["commit", "--quiet", "-am", "two"]);
        git(other.path(), &["commit", "--quiet", "--allow-empty", "-m", "three"]);
        let now = Source::of_folder(ours.path()).commit;
        assert!(now.is_some() && source.other_commit_at(ours.path()) == now);
        assert_eq!(Source::default().other_commit_at(ours.path()), None);
        std::fs::write(other.path().join("a"), "3").expect("written");
        git(other.path(), &["commit", "--quiet", "-am", "four"]);
        let there = Source::of_folder(other.path());
        assert_eq!(there.other_commit_at(ours.path()), None, "of another repository");
    }

    /// Dates that GNU date prints, and the last moments that a clock can show.
    #[test]
    fn every_moment_has_a_date() {
        let after = |seconds| UNIX_EPOCH + Duration::from_secs(seconds);
        let before = |millis| UNIX_EPOCH - Duration::from_millis(millis);
        let cases: [(SystemTime, &str); 12] = [
            (UNIX_EPOCH, "1970-01-01T00:00:00Z"),
            (after(1_709_210_096), "2024-02-29T12:34:56Z"),
            (after(951_868_799), "2000-02-29T23:59:59Z"),
            (after(4_107_542_400), "2100-03-01T00:00:00Z"),
            (after(253_402_300_799), "9999-12-31T23:59:59Z"),
            (after(253_402_300_800), "+010000-01-01T00:00:00Z"),
            (before(1), "1969-12-31T23:59:59Z"),
            (before(1000), "1969-12-31T23:59:59Z"),
            (before(2_208_988_800_000), "1900-01-01T00:00:00Z"),
            (before(62_167_219_200_000), "0000-01-01T00:00:00Z"),
            (before(62_167_219_201_000), "-000001-12-31T23:59:59Z"),
            (after(8_000_000_000_000_000_000), "+253509910024-06-28T14:13:20Z"),
        ];
        for (moment, expected) in cases {
            assert_eq!(date(moment), expected);
        }
        // Day after day the calendar goes on.
        let mut days: Vec<_> = (0..200_000).map(|day| date(after(86_400 * day))).collect();
        assert!(days.is_sorted());
        days.dedup();
        assert_eq!(days.len(), 200_000);
        assert_eq!(days[199_999], "2517-07-31T00:00:00Z");
    }

    #[test]
    fn processors_of_the_same_name_are_told_apart() {
        let info = "processor\t: 0\ncpu family\t: 26\nmodel\t\t: 2\nmodel name\t: Some CPU\n\nmodel\t: 7\n";
        assert_eq!(cpu_name(info).as_deref(), Some("Some CPU (family 26, model 2)"));
        assert_eq!(cpu_name("model name : Another\n").as_deref(), Some("Another"));
        assert_eq!(cpu_name("Features : fp asimd\n"), None);
    }
}
