//! An interrupted `reproduce` goes on where it was killed.

#![allow(clippy::unwrap_used, reason = "tests")]

use serde_json::Value;
use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const EXPERIMENTS: [&str; 3] = ["tables", "order", "momentum"];
const KILLS: u32 = 10;

fn reproduce(out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
    command.args(["reproduce", "--quick", "--only", &EXPERIMENTS.join(","), "--out"]).arg(out);
    command
}

/// Facts and words of every experiment.
fn results(out: &Path) -> Vec<(Value, Value)> {
    let read = |name: &str| -> Value {
        let bytes = std::fs::read(out.join(name).with_extension("json")).unwrap();
        serde_json::from_slice(&bytes).unwrap()
    };
    EXPERIMENTS.map(|name| (read(name)["facts"].clone(), read(name)["words"].clone())).into()
}

/// The whole lines of each journal.
fn journals(out: &Path) -> HashMap<PathBuf, Vec<Value>> {
    let entries = std::fs::read_dir(out.join(".unfinished")).into_iter().flatten().flatten();
    let is_journal = |path: &PathBuf| path.extension().is_some_and(|e| e == "journal");
    let paths = entries.map(|entry| entry.path()).filter(is_journal);
    let lines = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let whole = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
        let json = |line: &str| serde_json::from_str(line.split_once(' ').unwrap().1).unwrap();
        whole.map(json).collect()
    };
    paths.map(|path| (path.clone(), lines(&path))).collect()
}

/// A number from 0 to 1, another one at each call and each run of the test. Failures print it.
fn random() -> f64 {
    use std::hash::BuildHasher as _;
    let bits = std::hash::RandomState::new().hash_one(0);
    bits as f64 / u64::MAX as f64
}

#[test]
fn killed_at_random_moments_it_ends_with_undisturbed_facts_and_redoes_no_finished_cell() {
    let folder = tempfile::tempdir().unwrap();
    let (calm, killed) = (folder.path().join("calm"), folder.path().join("killed"));
    let begin = Instant::now();
    assert!(reproduce(&calm).stderr(Stdio::null()).status().unwrap().success());
    let longest = begin.elapsed();
    assert!(!calm.join(".unfinished").exists());

    let (mut delays, mut interrupted) = (Vec::new(), 0);
    for _ in 0..KILLS {
        let before = journals(&killed);
        let mut child = reproduce(&killed).stderr(Stdio::null()).spawn().unwrap();
        let delay = Duration::from_secs_f64(0.4 * random() * longest.as_secs_f64());
        delays.push(delay);
        std::thread::sleep(delay);
        child.kill().unwrap(); // SIGKILL
        let status = child.wait().unwrap();
        if status.success() {
            continue; // it was faster; what follows begins anew
        }
        interrupted += 1;
        let after = journals(&killed);
        for (path, lines) in &after {
            let cell = |line: &Value| {
                let cell = line.get("cell")?;
                Some((cell["part"].to_string(), cell["number"].as_u64()))
            };
            let cells: Vec<_> = lines.iter().filter_map(cell).collect();
            let different: BTreeSet<_> = cells.iter().collect();
            let path = path.display();
            assert_eq!(different.len(), cells.len(), "{path}: a cell was done twice, {delays:?}");
        }
        for (path, kept) in &before {
            // An experiment that ends takes its journal along only with the last one.
            let lines = after.get(path).map_or(&[][..], |lines| lines);
            assert!(lines.starts_with(kept), "{}: a cell was lost, {delays:?}", path.display());
        }
    }
    assert!(interrupted > 0, "no run was interrupted: {delays:?}");
    let last = reproduce(&killed).output().unwrap();
    assert!(last.status.success(), "{delays:?}: {}", String::from_utf8_lossy(&last.stderr));
    assert_eq!(results(&killed), results(&calm), "{delays:?}");
    assert!(!killed.join(".unfinished").exists());
}

#[test]
fn a_second_run_in_the_same_folder_is_refused_while_the_first_is_at_work() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut first = reproduce(&out).stderr(Stdio::null()).spawn().unwrap();
    // The first one is at work as soon as its journal is there.
    while journals(&out).is_empty() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let second = reproduce(&out).output().unwrap();
    let was_busy = first.try_wait().unwrap().is_none();
    first.kill().unwrap();
    first.wait().unwrap();
    if was_busy {
        assert_eq!(second.status.code(), Some(2));
        let message = String::from_utf8(second.stderr).unwrap();
        assert!(message.contains("another process is writing results there"), "{message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    }
}

/// Works until `tables` is finished, and is killed before the others are.
fn interrupted_after_tables(out: &Path) {
    let mut child = reproduce(out).stderr(Stdio::null()).spawn().unwrap();
    while !journals(out).keys().any(|path| path.ends_with("momentum.journal")) {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it could be killed");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
}

/// What is wrong with a file, and what does it.
type Damage = (&'static str, fn(&Path));

#[test]
fn a_record_that_is_missing_or_damaged_is_written_again_from_the_journal() {
    let folder = tempfile::tempdir().unwrap();
    let (calm, out) = (folder.path().join("calm"), folder.path().join("out"));
    assert!(reproduce(&calm).stderr(Stdio::null()).status().unwrap().success());
    let damages: [Damage; 3] = [
        ("missing", |record| std::fs::remove_file(record).unwrap()),
        ("no JSON", |record| std::fs::write(record, b"{\xff").unwrap()),
        ("another digit", |record| {
            let text = std::fs::read_to_string(record).unwrap();
            let facts = text.find("\"facts\"").unwrap();
            let digit = facts + text[facts..].find(|c: char| c.is_ascii_digit()).unwrap();
            let other = if &text[digit..=digit] == "1" { "2" } else { "1" };
            let changed = format!("{}{other}{}", &text[..digit], &text[digit + 1..]);
            std::fs::write(record, changed).unwrap();
        }),
    ];
    for (what, damage) in damages {
        interrupted_after_tables(&out);
        damage(&out.join("tables.json"));
        let last = reproduce(&out).output().unwrap();
        let said = String::from_utf8_lossy(&last.stderr);
        assert!(last.status.success(), "{what}: {said}");
        assert!(said.contains("tables: a file is missing or changed"), "{what}: {said}");
        assert!(said.contains("order: finished before the interruption"), "{what}: {said}");
        assert_eq!(results(&out), results(&calm), "{what}");
    }
}

/// One digit of a journal that changes does not become a fact, and `--fresh` forgets all journals.
#[test]
fn a_changed_journal_does_not_change_a_fact() {
    let folder = tempfile::tempdir().unwrap();
    let (calm, out) = (folder.path().join("calm"), folder.path().join("out"));
    assert!(reproduce(&calm).stderr(Stdio::null()).status().unwrap().success());
    for fresh in [false, true] {
        interrupted_after_tables(&out);
        let path = out.join(".unfinished/order.journal");
        let mut bytes = std::fs::read(&path).unwrap();
        // The last digit of the first cell.
        let lines: Vec<_> = bytes.iter().enumerate().filter(|(_, b)| **b == b'\n').collect();
        let end = lines[1].0;
        let digit = bytes[..end].iter().rposition(u8::is_ascii_digit).unwrap();
        bytes[digit] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        std::fs::remove_file(out.join("order.json")).unwrap();
        let mut last = reproduce(&out);
        let last = last.args(fresh.then_some("--fresh")).output().unwrap();
        let said = String::from_utf8_lossy(&last.stderr);
        assert!(last.status.success(), "{said}");
        let dropped = said.contains("order: 1 lines of the journal are damaged");
        assert_eq!(dropped, !fresh, "{said}");
        assert_eq!(results(&out), results(&calm));
    }
}

/// The records name what the program was built from, whatever repository the caller points at.
#[test]
fn a_repository_of_the_environment_is_not_that_of_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let (other, out) = (folder.path().join("other"), folder.path().join("out"));
    let git = |arguments: &[&str]| {
        let identity = ["-c", "user.name=a", "-c", "user.email=a", "-c", "commit.gpgsign=false"];
        let mut command = Command::new("git");
        let output = command.args(identity).arg("-C").arg(folder.path()).args(arguments).output();
        String::from_utf8(output.unwrap().stdout).unwrap().trim().to_owned()
    };
    git(&["init", "--quiet", "other"]);
    git(&["-C", "other", "commit", "--quiet", "--allow-empty", "-m", "one"]);
    let theirs = git(&["-C", "other", "rev-parse", "HEAD"]);
    assert_eq!(theirs.len(), 40, "{theirs}");
    let commit = |variables: &[(&str, &Path)]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
        command.args(["experiment", "tables", "--quick", "--out"]).arg(&out);
        command.envs(variables.iter().copied());
        assert!(command.output().unwrap().status.success());
        let bytes = std::fs::read(out.join("tables.json")).unwrap();
        let record: Value = serde_json::from_slice(&bytes).unwrap();
        let provenance = &record["provenance"];
        (provenance["commit"].clone(), provenance["dirty"].clone())
    };
    let (dir, tree) = (other.join(".git"), other.clone());
    let misled = commit(&[("GIT_DIR", &dir), ("GIT_WORK_TREE", &tree)]);
    assert_ne!(misled.0, Value::String(theirs));
    assert_eq!(misled, commit(&[]));
}
