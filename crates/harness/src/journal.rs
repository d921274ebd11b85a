//! What an interrupted run has finished.
//!
//! While an experiment runs, each finished cell becomes a line of a file under `.unfinished/` in
//! the folder of the results, written by one call as soon as the cell is done. A run that is killed
//! leaves complete lines and at most one torn line, which the next run cuts off. Only the same
//! program takes the file up: its first line carries the SHA-256 of the executable.

use crate::{HarnessError, sha256};
use drape_report::RecordError;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

const FOLDER: &str = ".unfinished";

/// First line of a journal.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Head {
    /// SHA-256 of the program.
    program: String,
    /// Whether only the quick subset is computed.
    quick: bool,
}

/// Any other line.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Line<'a, R> {
    /// A finished cell.
    Cell { part: std::borrow::Cow<'a, str>, number: usize, result: R },
    /// All records of the experiment were written.
    Finished,
}

/// The unfinished work in a folder of results. While it exists no other process works there.
#[derive(Debug)]
pub struct Unfinished {
    folder: PathBuf,
    program: String,
    // Locked until it is dropped, also by a process that is killed.
    _lock: File,
}

fn io(path: &Path, action: &'static str) -> impl FnOnce(std::io::Error) -> HarnessError {
    let path = path.to_owned();
    move |source| RecordError::Io { path, action, source }.into()
}

impl Unfinished {
    /// Takes up what is unfinished in the folder `out`, or forgets it if `fresh`.
    ///
    /// # Errors
    /// [`HarnessError::Busy`] while another process works there; [`HarnessError::Record`] when the
    /// folder cannot be made or read.
    pub fn enter(out: &Path, fresh: bool) -> Result<Self, HarnessError> {
        let folder = out.join(FOLDER);
        std::fs::create_dir_all(&folder).map_err(io(&folder, "write"))?;
        let path = folder.join("lock");
        let lock = File::create(&path).map_err(io(&path, "write"))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(HarnessError::Busy { folder: out.to_owned() });
            }
            Err(TryLockError::Error(source)) => return Err(io(&path, "write")(source)),
        }
        let executable = std::env::current_exe().map_err(io(Path::new("drape"), "read"))?;
        let program = sha256(&std::fs::read(&executable).map_err(io(&executable, "read"))?);
        let unfinished = Self { folder, program, _lock: lock };
        if fresh {
            for path in unfinished.journals()? {
                std::fs::remove_file(&path).map_err(io(&path, "write"))?;
            }
        }
        Ok(unfinished)
    }

    /// The journal of an experiment. It is that of the interrupted run if this program made it for
    /// the same cells.
    ///
    /// # Errors
    /// [`HarnessError::Record`] when the file cannot be read or written.
    pub fn journal(&self, experiment: &str, quick: bool) -> Result<Journal, HarnessError> {
        let head = Head { program: self.program.clone(), quick };
        Journal::open(&self.folder.join(format!("{experiment}.jsonl")), &head)
    }

    /// Removes the journals of experiments whose records and pages are written, and the empty
    /// folder.
    ///
    /// # Errors
    /// [`HarnessError::Record`] when a file cannot be removed.
    pub fn leave<'a>(self, written: impl IntoIterator<Item = &'a str>) -> Result<(), HarnessError> {
        for experiment in written {
            let path = self.folder.join(format!("{experiment}.jsonl"));
            match std::fs::remove_file(&path) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(io(&path, "write")(error));
                }
                _ => {}
            }
        }
        let journals = self.journals()?;
        if journals.is_empty() {
            std::fs::remove_dir_all(&self.folder).map_err(io(&self.folder, "write"))?;
        }
        Ok(())
    }

    fn journals(&self) -> Result<Vec<PathBuf>, HarnessError> {
        let entries = std::fs::read_dir(&self.folder).map_err(io(&self.folder, "read"))?;
        let paths = entries.flatten().map(|entry| entry.path());
        Ok(paths.filter(|path| path.extension().is_some_and(|e| e == "jsonl")).collect())
    }
}

/// The finished cells of one experiment.
#[derive(Debug, Default)]
pub struct Journal {
    done: HashMap<(String, usize), Value>,
    is_finished: bool,
    file: Option<Mutex<(File, PathBuf)>>,
}

impl Journal {
    /// Keeps nothing.
    pub fn none() -> Self {
        Self::default()
    }

    fn open(path: &Path, head: &Head) -> Result<Self, HarnessError> {
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            Err(error) => return Err(io(path, "read")(error)),
        };
        let mut journal = Self::default();
        let mut whole = 0;
        let lines = bytes.split_inclusive(|&byte| byte == b'\n');
        let mut lines = lines.take_while(|line| line.ends_with(b"\n"));
        let is_ours = |line: &&[u8]| serde_json::from_slice::<Head>(line).is_ok_and(|h| h == *head);
        if let Some(first) = lines.next().filter(is_ours) {
            whole = first.len();
            for line in lines {
                match serde_json::from_slice(line) {
                    Ok(Line::Cell { part, number, result }) => {
                        journal.done.insert((part.into_owned(), number), result);
                    }
                    Ok(Line::<Value>::Finished) => journal.is_finished = true,
                    Err(_) => break,
                }
                whole += line.len();
            }
        }
        let file = OpenOptions::new().create(true).append(true).open(path);
        let file = file.map_err(io(path, "write"))?;
        file.set_len(whole as u64).map_err(io(path, "write"))?;
        journal.file = Some(Mutex::new((file, path.to_owned())));
        if whole == 0 {
            journal.append(head)?;
        }
        Ok(journal)
    }

    /// Whether the interrupted run had written all records of the experiment.
    pub fn is_finished(&self) -> bool {
        self.is_finished
    }

    /// Number of cells that the interrupted run had finished.
    pub fn cells(&self) -> usize {
        self.done.len()
    }

    /// Notes that all records of the experiment are written.
    ///
    /// # Errors
    /// [`HarnessError::Record`] when the file cannot be written.
    pub fn finish(&self) -> Result<(), HarnessError> {
        self.append(&Line::<()>::Finished)
    }

    /// The result of a cell: from the journal, else computed and kept there.
    pub(crate) fn cell<R: Serialize + DeserializeOwned>(
        &self,
        part: &str,
        number: usize,
        compute: impl FnOnce() -> Result<R, HarnessError>,
    ) -> Result<R, HarnessError> {
        let kept = self.done.get(&(part.to_owned(), number));
        if let Some(result) = kept.and_then(|value| R::deserialize(value).ok()) {
            return Ok(result);
        }
        let result = compute()?;
        self.append(&Line::Cell { part: part.into(), number, result: &result })?;
        Ok(result)
    }

    fn append(&self, line: &impl Serialize) -> Result<(), HarnessError> {
        let Some(file) = &self.file else { return Ok(()) };
        let mut file = file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let (file, path) = &mut *file;
        let mut bytes = serde_json::to_vec(line)
            .map_err(|source| RecordError::Format { path: path.clone(), source })?;
        bytes.push(b'\n');
        file.write_all(&bytes).map_err(io(path, "write"))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use std::cell::Cell;

    fn head(program: &str) -> Head {
        Head { program: program.to_owned(), quick: false }
    }

    /// Asks for three cells; returns the results and how many had to be computed.
    fn cells(journal: &Journal) -> (Vec<f64>, usize) {
        let computed = Cell::new(0);
        let compute = |number: usize| {
            journal.cell("part", number, || {
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
        let path = folder.path().join("a.jsonl");
        let first = cells(&Journal::open(&path, &head("a")).unwrap());
        assert_eq!(first, (vec![0.1, 1.1, 2.1], 3));
        let again = Journal::open(&path, &head("a")).unwrap();
        assert_eq!((again.cells(), cells(&again)), (3, (first.0, 0)));
    }

    /// Wherever a kill cuts the file, whole lines are kept, and the file is whole again afterwards.
    #[test]
    fn a_torn_line_is_cut_off_and_its_cell_computed_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jsonl");
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
        let path = folder.path().join("a.jsonl");
        cells(&Journal::open(&path, &head("a")).unwrap());
        assert_eq!(cells(&Journal::open(&path, &head("b")).unwrap()).1, 3);
        let quick = Head { quick: true, ..head("b") };
        assert_eq!(cells(&Journal::open(&path, &quick).unwrap()).1, 3);
        assert_eq!(cells(&Journal::open(&path, &quick).unwrap()).1, 0);
    }

    #[test]
    fn a_finished_experiment_is_known_as_such() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jsonl");
        let journal = Journal::open(&path, &head("a")).unwrap();
        cells(&journal);
        assert!(!journal.is_finished());
        journal.finish().unwrap();
        assert!(Journal::open(&path, &head("a")).unwrap().is_finished());
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
        assert_eq!(rest.journals().unwrap().len(), 1);
        rest.leave(["b"]).unwrap();
        assert!(!folder.path().join(FOLDER).exists());
    }

    /// A number that JSON does not know is computed again rather than taken for something else.
    #[test]
    fn a_result_that_cannot_be_read_back_is_computed_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jsonl");
        for _ in 0..2 {
            let journal = Journal::open(&path, &head("a")).unwrap();
            let result = journal.cell("part", 0, || Ok(f64::INFINITY)).unwrap();
            assert_eq!(result, f64::INFINITY);
        }
    }
}
