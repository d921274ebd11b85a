//! The journal of a run, from which an interrupted run goes on.
//!
//! While an experiment runs, each finished cell becomes a line of a file under `.unfinished/` in
//! the folder of the results. One call writes the line as soon as the cell is done. A run that is
//! killed leaves complete lines and at most one torn line. Each line begins with a checksum. A line
//! that was torn or changed is dropped, and its cell is computed again. The first line carries the
//! SHA-256 of the executable, and only the same program goes on from the file. The last line names
//! the files that the experiment wrote, each with its SHA-256. Where such a file is missing or has
//! changed, the experiment writes its files again from the cells in the journal.
//!
//! A process may compute only a [`Shard`] of the cells. Then it writes nothing but the journal,
//! whose last line says that the shard is done. [`Unfinished::join`] joins the journals of such
//! parts.

mod join;

pub use join::Joined;

use crate::shard::{Missing, Shard};
use crate::{HarnessError, sha256};
use drape_report::RecordError;
use drape_report::file::{remove_leftovers, write_atomically};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

const FOLDER: &str = ".unfinished";
const EXTENSION: &str = "journal";
/// Folders below that of the results into which files are written.
const SUBFOLDERS: [&str; 3] = [FOLDER, "timings", "figures"];

/// First line of a journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Head {
    /// SHA-256 of the program.
    program: String,
    /// Whether only the quick subset is computed.
    quick: bool,
    /// Methods that the user added to the registry, or chose from it.
    methods: Vec<String>,
}

/// Any other line.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Line<'a, R> {
    /// A finished cell.
    Cell {
        part: std::borrow::Cow<'a, str>,
        number: usize,
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        is_timed: bool,
        result: R,
    },
    /// The journal holds all cells of a shard.
    Shard {
        shard: String,
        /// Number of cells in the journal at that moment.
        cells: usize,
    },
    /// All records of the experiment were written.
    Finished {
        /// SHA-256 of each file, by its path from the folder of the results.
        files: BTreeMap<PathBuf, String>,
    },
}

/// A line as it stands in a journal: a checksum, a space, and JSON. The checksum includes `salt`,
/// the JSON of the first line, so that a line counts in its own journal alone.
fn sealed(salt: &[u8], json: &[u8]) -> Vec<u8> {
    let mut line = checksum(salt, json).into_bytes();
    line.push(b' ');
    line.extend(json);
    line.push(b'\n');
    line
}

/// The JSON of a line; `None` if the line was changed since it was written.
fn unsealed<'a>(salt: &[u8], line: &'a [u8]) -> Option<&'a [u8]> {
    let line = line.strip_suffix(b"\n")?;
    let space = line.iter().position(|&byte| byte == b' ')?;
    let (sum, json) = (&line[..space], &line[space + 1..]);
    (sum == checksum(salt, json).as_bytes()).then_some(json)
}

fn checksum(salt: &[u8], json: &[u8]) -> String {
    sha256(&[salt, b"\n", json].concat())
}

/// The unfinished work in a folder of results. While this value exists, no other process works in
/// the folder.
#[derive(Debug)]
pub struct Unfinished {
    /// Folder of the results.
    out: PathBuf,
    folder: PathBuf,
    program: String,
    // The lock holds until the file is closed, and so ends also with a process that is killed.
    _lock: File,
}

fn io(path: &Path, action: &'static str) -> impl FnOnce(std::io::Error) -> HarnessError {
    let path = path.to_owned();
    move |source| RecordError::Io { path, action, source }.into()
}

/// Removes a file, a link or a whole folder.
fn remove(path: &Path) -> std::io::Result<()> {
    if path.symlink_metadata()?.is_dir() {
        std::fs::remove_dir_all(path)
    } else {
        std::fs::remove_file(path)
    }
}

/// Most attempts to lock a file that another process removes at the same time.
const MOST_TRIES: usize = 1000;

/// Opens the file at `path` and locks it; `None` while another process holds the lock. Creates the
/// folder where it is missing.
fn lock(path: &Path) -> std::io::Result<Option<File>> {
    for _ in 0..MOST_TRIES {
        path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
        let lock = match File::create(path) {
            Ok(lock) => lock,
            // Another process left and removed the folder.
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
            Err(error) => return Err(error),
        };
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(None),
            Err(TryLockError::Error(error)) => return Err(error),
        }
        // The process that held the lock may have removed the file in between. A third process
        // would then make and lock another file at the same place.
        if is_at(&lock, path)? {
            return Ok(Some(lock));
        }
    }
    Err(std::io::Error::other(format!("it was removed {MOST_TRIES} times before it was locked")))
}

/// Whether an open file is still the one at a path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> std::io::Result<bool> {
    use std::os::unix::fs::MetadataExt as _;
    let own = file.metadata()?;
    match path.metadata() {
        Ok(there) => Ok((there.dev(), there.ino()) == (own.dev(), own.ino())),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// On such a system an open file cannot be removed, so it is still at its path.
#[cfg(not(unix))]
fn is_at(_file: &File, _path: &Path) -> std::io::Result<bool> {
    Ok(true)
}

impl Unfinished {
    /// Takes up what is unfinished in the folder `out`, or forgets it if `fresh`. Removes the
    /// temporary files of processes that were killed there.
    ///
    /// # Errors
    /// [`HarnessError::Busy`] while another process works there; [`HarnessError::Record`] when the
    /// folder cannot be made or read.
    pub fn enter(out: &Path, fresh: bool) -> Result<Self, HarnessError> {
        let folder = out.join(FOLDER);
        if fresh && folder.symlink_metadata().is_ok_and(|metadata| !metadata.is_dir()) {
            std::fs::remove_file(&folder).map_err(io(&folder, "write"))?;
        }
        let path = folder.join("lock");
        if fresh && path.symlink_metadata().is_ok_and(|metadata| !metadata.is_file()) {
            remove(&path).map_err(io(&path, "write"))?;
        }
        let Some(lock) = lock(&path).map_err(io(&path, "write"))? else {
            return Err(HarnessError::Busy { folder: out.to_owned() });
        };
        remove_leftovers(out, |_| true);
        SUBFOLDERS.iter().for_each(|name| remove_leftovers(&out.join(name), |_| true));
        let executable = std::env::current_exe().map_err(io(Path::new("drape"), "read"))?;
        let program = sha256(&std::fs::read(&executable).map_err(io(&executable, "read"))?);
        let unfinished = Self { out: out.to_owned(), folder, program, _lock: lock };
        if fresh {
            for path in unfinished.rest()? {
                remove(&path).map_err(io(&path, "write"))?;
            }
        }
        Ok(unfinished)
    }

    /// The journal of an experiment. If this program wrote one for the same cells in an interrupted
    /// run, the journal goes on from there.
    ///
    /// # Errors
    /// [`HarnessError::Record`] when the file cannot be read or written.
    pub fn journal(&self, experiment: &str, quick: bool) -> Result<Journal, HarnessError> {
        let mut journal = Journal::open(&self.path(experiment), &self.head(quick))?;
        journal.out.clone_from(&self.out);
        experiment.clone_into(&mut journal.experiment);
        Ok(journal)
    }

    /// The first line of the journals of this process.
    fn head(&self, quick: bool) -> Head {
        Head { program: self.program.clone(), quick, methods: crate::methods::identity() }
    }

    fn path(&self, experiment: &str) -> PathBuf {
        self.folder.join(experiment).with_extension(EXTENSION)
    }

    /// Removes the journals of experiments whose records and pages are written, and the empty
    /// folder.
    ///
    /// # Errors
    /// [`HarnessError::Record`] when a file cannot be removed.
    pub fn leave<'a>(self, written: impl IntoIterator<Item = &'a str>) -> Result<(), HarnessError> {
        use std::io::ErrorKind::{DirectoryNotEmpty, NotFound};
        for experiment in written {
            let path = self.path(experiment);
            match std::fs::remove_file(&path) {
                Err(error) if error.kind() != NotFound => return Err(io(&path, "write")(error)),
                _ => {}
            }
        }
        let rest = self.rest()?;
        if rest.iter().any(|path| path.extension().is_some_and(|e| e == EXTENSION)) {
            return Ok(());
        }
        // The rest are temporary files, and journals in the format of an older version.
        for path in rest {
            remove(&path).map_err(io(&path, "write"))?;
        }
        let lock = self.folder.join("lock");
        std::fs::remove_file(&lock).map_err(io(&lock, "write"))?;
        match std::fs::remove_dir(&self.folder) {
            // From here on another process may work there.
            Err(error) if !matches!(error.kind(), NotFound | DirectoryNotEmpty) => {
                Err(io(&self.folder, "write")(error))
            }
            _ => Ok(()),
        }
    }

    /// The files beside the lock.
    fn rest(&self) -> Result<Vec<PathBuf>, HarnessError> {
        let entries = std::fs::read_dir(&self.folder).map_err(io(&self.folder, "read"))?;
        let paths = entries.flatten().map(|entry| entry.path());
        Ok(paths.filter(|path| path.file_name().is_some_and(|name| name != "lock")).collect())
    }
}

/// Which cells a process may compute.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Scope {
    /// All.
    #[default]
    All,
    /// Those of a shard.
    Shard(Shard),
    /// None.
    Nothing,
}

/// The finished cells of one experiment.
#[derive(Debug, Default)]
pub struct Journal {
    experiment: String,
    scope: Scope,
    /// Cells that the journal does not hold and this process may not compute.
    missing: Mutex<Vec<Missing>>,
    /// The moment after which no cell of a study that may stop (`animation-long`) is computed.
    until: Option<Instant>,
    /// Shards that are done, each with the number of cells in the journal at that moment.
    shards: Vec<(String, usize)>,
    done: HashMap<(String, usize), Value>,
    /// The files that the experiment wrote, if it ended.
    written: Option<BTreeMap<PathBuf, String>>,
    dropped: usize,
    /// Cells that this process added.
    written_cells: AtomicUsize,
    file: Option<Mutex<(File, PathBuf)>>,
    /// JSON of the first line.
    salt: Vec<u8>,
    /// Folder of the results.
    out: PathBuf,
}

impl Journal {
    /// A journal without a file, which keeps nothing.
    pub fn none() -> Self {
        Self::default()
    }

    fn open(path: &Path, head: &Head) -> Result<Self, HarnessError> {
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            Err(error) => return Err(io(path, "read")(error)),
        };
        let salt = serde_json::to_vec(head)
            .map_err(|source| RecordError::Format { path: path.to_owned(), source })?;
        let mut journal = Self { salt, ..Self::default() };
        let mut lines = bytes.split_inclusive(|&byte| byte == b'\n');
        let mut kept = sealed(b"", &journal.salt);
        if lines.next() == Some(&kept[..]) {
            for line in lines {
                let json = unsealed(&journal.salt, line);
                let parsed: Option<Line<'_, Value>> =
                    json.and_then(|json| serde_json::from_slice(json).ok());
                match parsed {
                    Some(Line::Cell { part, number, result, .. }) => {
                        journal.done.insert((part.into_owned(), number), result);
                    }
                    Some(Line::Shard { shard, cells }) => journal.shards.push((shard, cells)),
                    Some(Line::Finished { files }) => journal.written = Some(files),
                    None => {
                        // A line that ends is not torn: something changed it.
                        journal.dropped += usize::from(line.ends_with(b"\n"));
                        continue;
                    }
                }
                kept.extend(line);
            }
        }
        if kept != bytes {
            write_atomically(path, &kept)?;
        }
        let file = OpenOptions::new().append(true).open(path);
        journal.file = Some(Mutex::new((file.map_err(io(path, "write"))?, path.to_owned())));
        Ok(journal)
    }

    /// Whether the interrupted run had written all files of the experiment, and they are unchanged.
    pub fn is_finished(&self) -> bool {
        let is_there = |(name, sum): (&PathBuf, &String)| {
            std::fs::read(self.out.join(name)).is_ok_and(|bytes| sha256(&bytes) == *sum)
        };
        self.written.as_ref().is_some_and(|files| files.iter().all(is_there))
    }

    /// Whether the interrupted run had written all records of the experiment, even if they were
    /// changed or removed since then.
    pub fn was_finished(&self) -> bool {
        self.written.is_some()
    }

    /// Number of cells that the interrupted run had finished.
    pub fn cells(&self) -> usize {
        self.done.len()
    }

    /// Number of lines that are ignored because they were changed since they were written.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// The same journal for a process that computes only the cells of a shard.
    #[must_use]
    pub fn for_shard(self, shard: Shard) -> Self {
        Self { scope: Scope::Shard(shard), ..self }
    }

    /// The same journal for a process that computes no cell of a study that may stop
    /// (`animation-long`) after `until`.
    #[must_use]
    pub fn until(self, until: Option<Instant>) -> Self {
        Self { until, ..self }
    }

    /// The time after which no cell of such a study is computed.
    pub(crate) fn deadline(&self) -> Option<Instant> {
        self.until
    }

    /// Whether that time has come.
    pub(crate) fn is_late(&self) -> bool {
        self.until.is_some_and(|until| Instant::now() >= until)
    }

    /// Whether the process may compute all cells. Then a cell is missing only for lack of time.
    pub(crate) fn is_alone(&self) -> bool {
        self.scope == Scope::All
    }

    /// The same journal for a process that computes no cell.
    #[must_use]
    pub fn for_reading(self) -> Self {
        Self { scope: Scope::Nothing, ..self }
    }

    /// Whether the process computes cells for others, and writes no record.
    pub(crate) fn is_part(&self) -> bool {
        matches!(self.scope, Scope::Shard(_))
    }

    /// Whether the journal holds all cells of the shard.
    pub fn has_shard(&self, shard: Shard) -> bool {
        let name = shard.to_string();
        self.shards.iter().any(|(shard, cells)| *shard == name && self.done.len() >= *cells)
    }

    /// Notes that the journal holds all cells of the shard.
    ///
    /// # Errors
    /// [`HarnessError::Record`] when the journal cannot be written.
    pub fn end_shard(&self, shard: Shard) -> Result<(), HarnessError> {
        let written = self.written_cells.load(Ordering::Relaxed);
        let cells = self.done.len() + written;
        let line: Line<'_, ()> = Line::Shard { shard: shard.to_string(), cells };
        self.append(&line)
    }

    /// The cells that the journal does not hold and this process may not compute.
    pub fn missing(&self) -> Vec<Missing> {
        self.missing.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Adds cells that are missing.
    pub(crate) fn miss(&self, missing: Missing) {
        self.missing.lock().unwrap_or_else(PoisonError::into_inner).push(missing);
    }

    /// Whether the journal holds the cell, or this process may compute it.
    pub(crate) fn takes(&self, part: &str, number: usize, is_timed: bool) -> bool {
        let is_own = match self.scope {
            Scope::All => true,
            Scope::Shard(shard) => shard.has(&self.experiment, part, number, is_timed),
            Scope::Nothing => false,
        };
        is_own || self.done.contains_key(&(part.to_owned(), number))
    }

    /// Notes that all records of the experiment are written, into `files`.
    ///
    /// # Errors
    /// [`HarnessError::Record`] when a file cannot be read or the journal cannot be written.
    pub fn finish(&self, files: &[PathBuf]) -> Result<(), HarnessError> {
        let sum = |path: &PathBuf| {
            let bytes = std::fs::read(path).map_err(io(path, "read"))?;
            let name = path.strip_prefix(&self.out).unwrap_or(path);
            Ok((name.to_owned(), sha256(&bytes)))
        };
        let files = files.iter().map(sum).collect::<Result<_, HarnessError>>()?;
        let line: Line<'_, ()> = Line::Finished { files };
        self.append(&line)
    }

    /// The result of a cell: from the journal, or else computed and then kept in the journal.
    pub(crate) fn cell<R: Serialize + DeserializeOwned>(
        &self,
        part: &str,
        number: usize,
        is_timed: bool,
        compute: impl FnOnce() -> Result<R, HarnessError>,
    ) -> Result<R, HarnessError> {
        let kept = self.done.get(&(part.to_owned(), number));
        if let Some(result) = kept.and_then(|value| R::deserialize(value).ok()) {
            return Ok(result);
        }
        let result = compute()?;
        self.append(&Line::Cell { part: part.into(), number, is_timed, result: &result })?;
        self.written_cells.fetch_add(usize::from(kept.is_none()), Ordering::Relaxed);
        Ok(result)
    }

    /// The result of a cell, if the journal holds it.
    pub(crate) fn kept<R: DeserializeOwned>(&self, part: &str, number: usize) -> Option<R> {
        R::deserialize(self.done.get(&(part.to_owned(), number))?).ok()
    }

    /// Keeps the result of a cell that depends on the time that it took.
    pub(crate) fn keep(
        &self,
        part: &str,
        number: usize,
        result: &impl Serialize,
    ) -> Result<(), HarnessError> {
        self.append(&Line::Cell { part: part.into(), number, is_timed: true, result })
    }

    /// The results of all cells that the interrupted run had finished.
    pub(crate) fn results(&self) -> impl Iterator<Item = &Value> {
        self.done.values()
    }

    fn append(&self, line: &impl Serialize) -> Result<(), HarnessError> {
        let Some(file) = &self.file else { return Ok(()) };
        let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
        let (file, path) = &mut *file;
        let json = serde_json::to_vec(line)
            .map_err(|source| RecordError::Format { path: path.clone(), source })?;
        file.write_all(&sealed(&self.salt, &json)).map_err(io(path, "write"))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use std::cell::Cell;

    fn head(program: &str) -> Head {
        Head { program: program.to_owned(), quick: false, methods: Vec::new() }
    }

    /// Asks for three cells; returns the results and how many had to be computed.
    fn cells(journal: &Journal) -> (Vec<f64>, usize) {
        let computed = Cell::new(0);
        let compute = |number: usize| {
            journal.cell("part", number, false, || {
                computed.set(computed.get() + 1);
                Ok(0.1 + number as f64)
            })
        };
        let results = (0..3).map(|number| compute(number).unwrap()).collect();
        (results, computed.get())
    }

    #[test]
    fn finished_cells_are_not_computed_again_and_have_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.journal");
        let first = cells(&Journal::open(&path, &head("a")).unwrap());
        assert_eq!(first, (vec![0.1, 1.1, 2.1], 3));
        let again = Journal::open(&path, &head("a")).unwrap();
        assert_eq!((again.cells(), cells(&again)), (3, (first.0, 0)));
    }

    /// A kill may cut the file at any byte: whole lines are kept, and the file is whole afterwards.
    #[test]
    fn a_torn_line_is_cut_off_and_its_cell_computed_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.journal");
        let expected = cells(&Journal::open(&path, &head("a")).unwrap()).0;
        let bytes = std::fs::read(&path).unwrap();
        let mut seen = std::collections::BTreeSet::new();
        for length in 0..=bytes.len() {
            std::fs::write(&path, &bytes[..length]).unwrap();
            let (results, computed) = cells(&Journal::open(&path, &head("a")).unwrap());
            assert_eq!(results, expected, "cut at {length}");
            seen.insert(computed);
            let whole = cells(&Journal::open(&path, &head("a")).unwrap());
            assert_eq!(whole, (results, 0), "cut at {length}");
        }
        assert_eq!(seen.into_iter().collect::<Vec<_>>(), [0, 1, 2, 3]);
    }

    #[test]
    fn cells_of_another_program_or_of_the_quick_subset_are_not_taken_up() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.journal");
        cells(&Journal::open(&path, &head("a")).unwrap());
        assert_eq!(cells(&Journal::open(&path, &head("b")).unwrap()).1, 3);
        let quick = Head { quick: true, ..head("b") };
        assert_eq!(cells(&Journal::open(&path, &quick).unwrap()).1, 3);
        assert_eq!(cells(&Journal::open(&path, &quick).unwrap()).1, 0);
        let own = Head { methods: vec!["added my-midpoint".to_owned()], ..head("b") };
        assert_eq!(cells(&Journal::open(&path, &own).unwrap()).1, 3);
    }

    #[test]
    fn a_finished_experiment_is_known_as_such() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.journal");
        let journal = Journal::open(&path, &head("a")).unwrap();
        cells(&journal);
        assert!(!journal.is_finished());
        journal.finish(&[]).unwrap();
        assert!(Journal::open(&path, &head("a")).unwrap().is_finished());
    }

    #[test]
    fn an_experiment_is_finished_while_its_files_are_as_it_wrote_them() {
        let folder = tempfile::tempdir().unwrap();
        let enter = || Unfinished::enter(folder.path(), false).unwrap();
        let file = folder.path().join("timings/a.json");
        std::fs::create_dir(folder.path().join("timings")).unwrap();
        std::fs::write(&file, "12").unwrap();
        let journal = enter().journal("a", false).unwrap();
        cells(&journal);
        journal.finish(std::slice::from_ref(&file)).unwrap();
        let is_finished = || enter().journal("a", false).unwrap().is_finished();
        assert!(is_finished());
        std::fs::write(&file, "13").unwrap();
        assert!(!is_finished(), "the file was changed");
        std::fs::remove_file(&file).unwrap();
        assert!(!is_finished(), "the file was removed");
        // Writing the files again computes no cell again, and the last such line counts.
        let again = enter().journal("a", false).unwrap();
        assert!(again.was_finished() && cells(&again).1 == 0);
        std::fs::write(&file, "14").unwrap();
        again.finish(&[file]).unwrap();
        assert!(is_finished());
    }

    /// No change of a single byte of a journal becomes the result of a cell.
    #[test]
    fn a_changed_byte_does_not_become_a_result() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.journal");
        let expected = cells(&Journal::open(&path, &head("a")).unwrap()).0;
        let bytes = std::fs::read(&path).unwrap();
        for n in 0..bytes.len() {
            let mut changed = bytes.clone();
            // Another digit where there was a digit.
            changed[n] ^= 1;
            std::fs::write(&path, &changed).unwrap();
            let journal = Journal::open(&path, &head("a")).unwrap();
            assert!(journal.cells() < 3, "byte {n}");
            assert_eq!(cells(&journal).0, expected, "byte {n}");
            let whole = Journal::open(&path, &head("a")).unwrap();
            assert_eq!((cells(&whole), whole.dropped()), ((expected.clone(), 0), 0), "byte {n}");
        }
    }

    #[test]
    fn one_damaged_line_costs_one_cell_and_a_line_of_another_journal_counts_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let [path, other] = ["a", "b"].map(|name| folder.path().join(name));
        let expected = cells(&Journal::open(&path, &head("a")).unwrap()).0;
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text.matches("1.1").count(), 1);
        std::fs::write(&path, text.replace("1.1", "1.2")).unwrap();
        let journal = Journal::open(&path, &head("a")).unwrap();
        assert_eq!((journal.cells(), journal.dropped()), (2, 1));
        assert_eq!(cells(&journal), (expected, 1));
        Journal::open(&other, &head("b")).unwrap();
        let first = std::fs::read_to_string(&other).unwrap();
        let (_, rest) = text.split_once('\n').unwrap();
        std::fs::write(&other, first + rest).unwrap();
        assert_eq!(Journal::open(&other, &head("b")).unwrap().cells(), 0);
    }

    /// With `fresh`, a file that is not valid UTF-8 does no harm, nor a folder in the place of a
    /// file, nor a file in the place of a folder.
    #[test]
    fn fresh_works_whatever_lies_in_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let unfinished = folder.path().join(FOLDER);
        let place = |name: &str| unfinished.join(name);
        let clear = || remove(&unfinished).unwrap_or_default();
        let litter: [&dyn Fn(); 4] = [
            &|| std::fs::write(&unfinished, "no folder").unwrap(),
            &|| std::fs::create_dir_all(place("lock/below")).unwrap(),
            &|| std::fs::create_dir_all(place("a.journal/below")).unwrap(),
            &|| {
                std::fs::create_dir_all(&unfinished).unwrap();
                std::fs::write(place("a.journal"), b"\xff\xfe").unwrap();
            },
        ];
        for (n, litter) in litter.iter().enumerate() {
            clear();
            litter();
            let fresh = Unfinished::enter(folder.path(), true).unwrap();
            assert_eq!(cells(&fresh.journal("a", false).unwrap()).1, 3, "{n}");
            fresh.leave(["a"]).unwrap();
            assert!(!unfinished.exists(), "{n}");
        }
    }

    /// The owner of a lock removes the file when it leaves. A lock that another process then takes
    /// on the removed file does not count.
    #[test]
    fn a_lock_on_a_removed_file_is_no_lock() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        for round in 0..200 {
            let owners = std::sync::atomic::AtomicUsize::new(0);
            // All start together, so that some open the file that another is about to remove.
            let start = std::sync::Barrier::new(4);
            std::thread::scope(|scope| {
                for _ in 0..4 {
                    scope.spawn(|| {
                        use std::sync::atomic::Ordering::SeqCst;
                        start.wait();
                        for _ in 0..50 {
                            let Some(lock) = lock(&path).unwrap() else { continue };
                            assert_eq!(owners.fetch_add(1, SeqCst), 0, "round {round}");
                            std::thread::yield_now();
                            owners.fetch_sub(1, SeqCst);
                            std::fs::remove_file(&path).unwrap();
                            drop(lock);
                        }
                    });
                }
            });
        }
    }

    /// Temporary files of killed processes are removed, in all folders that a run writes to.
    #[test]
    fn temporary_files_of_killed_processes_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let mut kept = Vec::new();
        let below = ["", "timings", "figures", FOLDER].map(|below| folder.path().join(below));
        for below in &below {
            std::fs::create_dir_all(below).unwrap();
            std::fs::write(below.join("a.json.drape-a1B2c3D4.tmp"), "half a rec").unwrap();
            kept.push(below.join("b.tmp"));
            std::fs::write(below.join("b.tmp"), "").unwrap();
        }
        drop(Unfinished::enter(folder.path(), false).unwrap());
        assert!(kept.iter().all(|path| path.exists()));
        assert!(below.iter().all(|below| !below.join("a.json.drape-a1B2c3D4.tmp").exists()));
    }

    #[test]
    fn only_one_process_works_in_a_folder_and_fresh_forgets() {
        let folder = tempfile::tempdir().unwrap();
        let unfinished = Unfinished::enter(folder.path(), false).unwrap();
        let busy = Unfinished::enter(folder.path(), false).unwrap_err();
        assert!(busy.to_string().contains("another process"), "{busy}");
        assert_eq!(cells(&unfinished.journal("a", false).unwrap()).1, 3);
        assert_eq!(cells(&unfinished.journal("a", false).unwrap()).1, 0);
        drop(unfinished);
        let fresh = Unfinished::enter(folder.path(), true).unwrap();
        assert_eq!(cells(&fresh.journal("a", false).unwrap()).1, 3);
        cells(&fresh.journal("b", false).unwrap());
        fresh.leave(["a"]).unwrap();
        let rest = Unfinished::enter(folder.path(), false).unwrap();
        assert_eq!(cells(&rest.journal("b", false).unwrap()).1, 0, "b is not written yet");
        assert_eq!(rest.rest().unwrap().len(), 1);
        rest.leave(["b"]).unwrap();
        assert!(!folder.path().join(FOLDER).exists());
    }

    /// A number that JSON cannot hold is computed again, not read back as another value.
    #[test]
    fn a_result_that_cannot_be_read_back_is_computed_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.journal");
        for _ in 0..2 {
            let journal = Journal::open(&path, &head("a")).unwrap();
            let result = journal.cell("part", 0, false, || Ok(f64::INFINITY)).unwrap();
            assert_eq!(result, f64::INFINITY);
        }
    }
}
