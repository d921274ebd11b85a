//! Studies in shards: computed apart, killed, resubmitted and merged.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

const SHARDS: usize = 7;
const KILLED: usize = 3;

fn drape(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_drape"));
    command.args(arguments);
    command
}

fn reproduce(out: &Path, shard: Option<usize>) -> Command {
    let mut command = drape(&["reproduce", "--quick", "--out"]);
    command.arg(out).stdout(Stdio::null());
    if let Some(shard) = shard {
        command.args(["--shard", &format!("{shard}/{SHARDS}")]);
    }
    command
}

fn merge(out: &Path, parts: &[PathBuf]) -> Output {
    drape(&["merge"]).arg(out).args(parts).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A text without its dates, such as 2026-11-23T17:58:06Z.
fn undated(text: &[u8]) -> Vec<u8> {
    const SHAPE: &[u8] = b"0000-00-00T00:00:00Z";
    let is_date = |window: &[u8]| {
        let fits = |(byte, shape): (&u8, &u8)| match shape {
            b'0' => byte.is_ascii_digit(),
            other => byte == other,
        };
        window.len() == SHAPE.len() && window.iter().zip(SHAPE).all(fits)
    };
    let mut rest = text;
    let mut undated = Vec::with_capacity(text.len());
    while let Some((first, after)) = rest.split_first() {
        if is_date(&rest[..rest.len().min(SHAPE.len())]) {
            rest = &rest[SHAPE.len()..];
        } else {
            undated.push(*first);
            rest = after;
        }
    }
    undated
}

/// Every file below a folder, without dates.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_owned();
                files.insert(name, undated(&std::fs::read(&path).unwrap()));
            }
        }
    }
    files
}

/// A running shard writes temporary files beside its journals, which come and go.
fn journal_paths(out: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(out.join(".unfinished")).into_iter().flatten();
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    paths.filter(|path| path.extension().is_some_and(|e| e == "journal")).collect()
}

fn journals(out: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let read = |path: PathBuf| {
        let name = PathBuf::from(path.file_name()?);
        Some((name, undated(&std::fs::read(&path).ok()?)))
    };
    journal_paths(out).into_iter().filter_map(read).collect()
}

fn lines(journal: &[u8]) -> usize {
    journal.iter().filter(|byte| **byte == b'\n').count()
}

/// How many lines a shard has written: cells and ends of studies. Each journal has a first line
/// besides.
fn written(part: &Path) -> usize {
    let journals = journal_paths(part).into_iter().filter_map(|path| std::fs::read(path).ok());
    journals.map(|journal| lines(&journal).saturating_sub(1)).sum()
}

/// Computes a shard on one processor, and kills it once it has written so many lines, if a number is
/// given. Returns whether it ended by itself.
fn computed(part: &Path, shard: usize, moment: Option<usize>) -> bool {
    let log = part.with_extension("log");
    let mut command = reproduce(part, Some(shard));
    command.env("RAYON_NUM_THREADS", "1").stderr(File::create(&log).unwrap());
    let mut child = command.spawn().unwrap();
    let mut is_killed = false;
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if moment.is_some_and(|moment| written(part) >= moment) {
            is_killed = true;
            child.kill().unwrap();
            break child.wait().unwrap();
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let said = || std::fs::read_to_string(&log).unwrap();
    assert!(status.success() || is_killed, "shard {shard}: {status}: {}", said());
    status.success()
}

fn two_at_a_time<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let work = &work;
    let pairs = items.chunks(2).map(|pair| {
        std::thread::scope(|scope| {
            let threads: Vec<_> = pair.iter().map(|item| scope.spawn(move || work(item))).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect::<Vec<_>>()
        })
    });
    pairs.flatten().collect()
}

/// Random numbers (splitmix64).
struct Random(u64);

impl Random {
    /// The seed is that of `DRAPE_TEST_SEED`, which repeats a test, or of the clock; it is told past
    /// the capture of tests.
    fn new() -> Self {
        let seed = match std::env::var("DRAPE_TEST_SEED") {
            Ok(seed) => seed.parse().unwrap(),
            Err(_) => SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as u64,
        };
        writeln!(std::io::stderr().lock(), "shards: DRAPE_TEST_SEED={seed}").unwrap();
        Self(seed)
    }

    /// A number less than `end`.
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % end as u64) as usize
    }

    fn shuffle(&mut self, items: &mut [usize]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}

/// The folder of an undivided run. `DRAPE_QUICK` names one that this executable made, so that it is
/// not made again; one that is older than the executable does not count.
fn undivided(new: PathBuf) -> PathBuf {
    let time = |path: &Path| path.metadata().and_then(|metadata| metadata.modified()).ok();
    let there = std::env::var_os("DRAPE_QUICK").map(PathBuf::from);
    let executable = time(Path::new(env!("CARGO_BIN_EXE_drape")));
    if let Some(there) = there.filter(|there| time(&there.join("report.html")) > executable) {
        return there;
    }
    let output = reproduce(&new, None).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    new
}

/// All studies, quickly. Which shards are killed, and when, is random. The shards take as long as
/// the undivided run, some two minutes on two processors each; `.ci/run` has made the latter before.
#[test]
fn seven_shards_of_which_three_are_killed_give_the_files_of_an_undivided_run() {
    let folder = tempfile::tempdir().unwrap();
    let whole = undivided(folder.path().join("whole"));
    let merged = folder.path().join("merged");
    let part = |shard: usize| folder.path().join(format!("part-{shard}"));
    let mut random = Random::new();
    let mut waiting: Vec<_> = (1..=SHARDS).collect();
    random.shuffle(&mut waiting);
    // Two that are whole tell how many lines a shard writes.
    let mut ended = waiting.split_off(SHARDS - 2);
    two_at_a_time(&ended, |shard| computed(&part(*shard), *shard, None));
    let most = ended.iter().map(|shard| written(&part(*shard))).min().unwrap();
    assert!(most > 100, "{most} lines in a shard of all studies");
    let mut killed = Vec::new();
    while killed.len() < KILLED {
        let mut lots = Vec::new();
        while lots.len() < KILLED - killed.len() {
            let shard = waiting.pop().unwrap_or_else(|| {
                // All others ended before their moment: one begins anew.
                let shard = ended.pop().unwrap();
                std::fs::remove_dir_all(part(shard)).unwrap();
                shard
            });
            lots.push((shard, 1 + random.below(most)));
        }
        let ends =
            two_at_a_time(&lots, |(shard, moment)| computed(&part(*shard), *shard, Some(*moment)));
        for ((shard, _), has_ended) in lots.into_iter().zip(ends) {
            let list = if has_ended { &mut ended } else { &mut killed };
            list.push(shard);
        }
    }
    two_at_a_time(&waiting, |shard| computed(&part(*shard), *shard, None));
    ended.append(&mut waiting);
    assert_eq!((killed.len(), ended.len()), (KILLED, SHARDS - KILLED));
    for shard in &ended {
        let (files, journals) = (files(&part(*shard)), journals(&part(*shard)));
        assert_eq!(files.len(), journals.len() + 1, "{shard}: journals and a lock alone");
    }
    for shard in &killed {
        let files = files(&part(*shard));
        assert!(files.keys().all(|name| name.starts_with(".unfinished")), "{:?}", files.keys());
    }
    let parts: Vec<_> = (1..=SHARDS).map(&part).collect();
    let before = merge(&merged, &parts);
    assert_eq!(before.status.code(), Some(4), "{}", said(&before));
    let text = said(&before);
    assert!(text.contains("cells are missing: run the shards again"), "{text}");
    assert!(!merged.join("report.html").exists(), "{text}");
    // Resubmitted, each of the seven computes what it lacks, and nothing again.
    let shards: Vec<_> = (1..=SHARDS).collect();
    two_at_a_time(&shards, |shard| {
        let part = part(*shard);
        let before = journals(&part);
        computed(&part, *shard, None);
        let after = journals(&part);
        for (name, journal) in &before {
            let whole = journal.iter().rposition(|b| *b == b'\n').map_or(0, |end| end + 1);
            assert!(after[name].starts_with(&journal[..whole]), "{shard}: {}", name.display());
        }
        assert!(killed.contains(shard) || before == after, "{shard}");
    });
    // What was merged before is not lost: the parts that were whole then need not come again.
    let again: Vec<_> = killed.iter().map(|shard| part(*shard)).collect();
    let output = merge(&merged, &again);
    assert!(output.status.success(), "{}", said(&output));
    let (whole, merged) = (files(&whole), files(&merged));
    assert_eq!(whole.keys().collect::<Vec<_>>(), merged.keys().collect::<Vec<_>>());
    for (name, bytes) in &whole {
        assert!(bytes == &merged[name], "{} differs", name.display());
    }
    assert!(whole.len() > 50 && whole.contains_key(Path::new("report.html")), "{:?}", whole.keys());
}

/// The same program with one byte more, which it never reads.
#[cfg(unix)]
#[test]
fn parts_of_another_program_or_subset_and_folders_without_parts_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let [other, part, full, empty, out] =
        ["drape-other", "part", "full", "empty", "out"].map(|name| folder.path().join(name));
    std::fs::copy(env!("CARGO_BIN_EXE_drape"), &other).unwrap();
    let mut file = std::fs::File::options().append(true).open(&other).unwrap();
    std::io::Write::write_all(&mut file, b"\n").unwrap();
    drop(file);
    let shard = ["experiment", "momentum", "--quick", "--shard", "1/99", "--out"];
    assert!(Command::new(&other).args(shard).arg(&part).output().unwrap().status.success());
    std::fs::create_dir(&empty).unwrap();
    let refused = |parts: &[PathBuf], expected: [&str; 2]| {
        let output = merge(&out, parts);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert_eq!(text.trim_end().lines().count(), 1, "{text}");
        assert!(expected.iter().all(|expected| text.contains(expected)), "{text}");
    };
    refused(
        std::slice::from_ref(&part),
        ["part/.unfinished/momentum.journal", "another executable"],
    );
    refused(std::slice::from_ref(&empty), ["empty", "no journal lies there"]);
    refused(&[], ["out", "no part holds one"]);
    // The same cells, all instead of a subset.
    let quick = folder.path().join("quick");
    assert!(drape(&shard).arg(&quick).output().unwrap().status.success());
    std::fs::create_dir_all(full.join(".unfinished")).unwrap();
    let mut child = drape(&["experiment", "momentum", "--shard", "1/99", "--out"])
        .arg(&full)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while journals(&full).values().all(|journal| lines(journal) == 0) {
        std::thread::sleep(Duration::from_millis(1));
        if child.try_wait().unwrap().is_some() {
            break;
        }
    }
    let _ = child.kill();
    child.wait().unwrap();
    refused(&[quick, full], ["full/.unfinished/momentum.journal", "all cells"]);
}

#[test]
fn a_shard_that_cannot_be_is_refused() {
    for (shard, expected) in [("8/7", "from 1 to 7"), ("0/7", "from 1 to 7"), ("x", "such as 3/7")]
    {
        let output = drape(&["experiment", "order", "--out", "a", "--shard", shard]).output();
        let output = output.unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(said(&output).contains(expected), "{}", said(&output));
    }
    let output = drape(&["experiment", "order", "--shard", "1/7"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "parts need a folder of their own");
    assert!(said(&output).contains("--out"), "{}", said(&output));
}
