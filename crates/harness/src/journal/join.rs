//! Joins the journals of parts.

use super::{EXTENSION, FOLDER, Head, Line, Unfinished, io, sealed, unsealed};
use crate::HarnessError;
use drape_report::file::write_atomically;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The experiments whose journals were joined.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Joined {
    /// Whether only the quick subset is computed.
    pub quick: bool,
    /// Names of the experiments, in alphabetical order.
    pub experiments: Vec<String>,
}

/// A cell, and where it was found.
struct Found {
    json: Vec<u8>,
    result: Value,
    is_timed: bool,
    file: PathBuf,
}

/// The cells of one experiment, by part and number.
type Cells = BTreeMap<(String, usize), Found>;

impl Unfinished {
    /// Joins the journals of `parts`, which are folders of results, with the journals here.
    ///
    /// # Errors
    /// [`HarnessError::Part`] where a folder holds no journal, where a journal was written by
    /// another executable or with other methods, where its subset of the cells is another one than
    /// in the first journal, and where two journals contradict each other. [`HarnessError::Record`]
    /// when a journal cannot be read or written.
    pub fn join(&self, parts: &[PathBuf]) -> Result<Joined, HarnessError> {
        let mut quick: Option<(bool, PathBuf)> = None;
        let mut found: BTreeMap<String, Cells> = BTreeMap::new();
        let here = std::iter::once((&self.out, true));
        for (folder, is_own) in here.chain(parts.iter().map(|part| (part, false))) {
            let journals = journals(&folder.join(FOLDER))?;
            if journals.is_empty() && !is_own {
                return Err(HarnessError::Part {
                    path: folder.clone(),
                    found: "no journal lies there".to_owned(),
                    expected: "the folder of a run with --shard".to_owned(),
                });
            }
            for (experiment, file) in journals {
                let bytes = std::fs::read(&file).map_err(io(&file, "read"))?;
                let Some((head, lines)) = read(&bytes) else {
                    // The process was killed before it had written a line.
                    found.entry(experiment).or_default();
                    continue;
                };
                self.check(&head, &mut quick, &file)?;
                let cells = found.entry(experiment).or_default();
                for json in lines {
                    take(cells, json, &file)?;
                }
            }
        }
        let Some((quick, _)) = quick else {
            return Err(HarnessError::Part {
                path: self.out.clone(),
                found: "no journal lies there, and no part holds one".to_owned(),
                expected: "the folders of runs with --shard, after the folder for the results"
                    .to_owned(),
            });
        };
        let head = self.head(quick);
        for (experiment, cells) in &found {
            let path = self.path(experiment);
            let salt = serde_json::to_vec(&head).map_err(|source| {
                drape_report::RecordError::Format { path: path.clone(), source }
            })?;
            let mut bytes = sealed(b"", &salt);
            cells.values().for_each(|cell| bytes.extend(sealed(&salt, &cell.json)));
            write_atomically(&path, &bytes)?;
        }
        Ok(Joined { quick, experiments: found.into_keys().collect() })
    }

    /// Refuses a journal of another executable, of other methods or of another subset.
    fn check(
        &self,
        head: &Head,
        quick: &mut Option<(bool, PathBuf)>,
        file: &Path,
    ) -> Result<(), HarnessError> {
        let refuse = |found: String, expected: String| {
            Err(HarnessError::Part { path: file.to_owned(), found, expected })
        };
        let own = self.head(head.quick);
        if head.program != own.program {
            let short = |sum: &str| sum.chars().take(12).collect::<String>();
            return refuse(
                format!("computed by another executable, of SHA-256 {}…", short(&head.program)),
                format!("{}…, that of this one: merge with the same program", short(&own.program)),
            );
        }
        if head.methods != own.methods {
            let names = |methods: &[String]| match methods {
                [] => "those that come with it".to_owned(),
                some => some.join(", "),
            };
            return refuse(
                format!("computed with other methods or programs: {}", names(&head.methods)),
                format!("{}; give the same --methods", names(&own.methods)),
            );
        }
        match quick {
            None => *quick = Some((head.quick, file.to_owned())),
            Some((other, first)) if *other != head.quick => {
                let subset = |quick| if quick { "the quick subset" } else { "all cells" };
                return refuse(
                    format!("a part of {}", subset(head.quick)),
                    format!("a part of {}, as {}", subset(*other), first.display()),
                );
            }
            Some(_) => {}
        }
        Ok(())
    }
}

/// The journals in a folder, by experiment; none where the folder is missing.
fn journals(folder: &Path) -> Result<BTreeMap<String, PathBuf>, HarnessError> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(BTreeMap::new()),
        Err(error) => return Err(io(folder, "read")(error)),
    };
    let paths = entries.flatten().map(|entry| entry.path());
    let is_journal = |path: &PathBuf| path.extension().is_some_and(|e| e == EXTENSION);
    let named = paths.filter(is_journal).filter_map(|path| {
        let name = path.file_stem()?.to_str()?.to_owned();
        Some((name, path))
    });
    Ok(named.collect())
}

/// The first line of a journal, and the JSON of the other lines that are whole.
fn read(bytes: &[u8]) -> Option<(Head, Vec<&[u8]>)> {
    let mut lines = bytes.split_inclusive(|&byte| byte == b'\n');
    let salt = unsealed(b"", lines.next()?)?;
    let head = serde_json::from_slice(salt).ok()?;
    Some((head, lines.filter_map(|line| unsealed(salt, line)).collect()))
}

/// Adds the cell of a line, if it holds one.
fn take(cells: &mut Cells, json: &[u8], file: &Path) -> Result<(), HarnessError> {
    let Ok(Line::Cell { part, number, is_timed, result }) = serde_json::from_slice(json) else {
        return Ok(());
    };
    let key = (part.into_owned(), number);
    match cells.get(&key) {
        // Times differ from run to run; the first result counts.
        Some(other) if other.result != result && !(is_timed && other.is_timed) => {
            Err(HarnessError::Part {
                path: file.to_owned(),
                found: format!("another result of cell {number} of `{}`", key.0),
                expected: format!("that in {}", other.file.display()),
            })
        }
        Some(_) => Ok(()),
        None => {
            let found = Found { json: json.to_owned(), result, is_timed, file: file.to_owned() };
            cells.insert(key, found);
            Ok(())
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::Shard;

    /// A part with cells of the study `a`: their numbers, results and whether they are timed.
    fn part(folder: &Path, program: &str, cells: &[(usize, f64, bool)]) {
        let unfinished = entered(folder, program);
        let journal = unfinished.journal("a", true).unwrap();
        for &(number, result, is_timed) in cells {
            journal.cell("part", number, is_timed, || Ok(result)).unwrap();
        }
    }

    fn entered(folder: &Path, program: &str) -> Unfinished {
        let mut unfinished = Unfinished::enter(folder, false).unwrap();
        program.clone_into(&mut unfinished.program);
        unfinished
    }

    /// Joins folders into `out`, as the program `a`.
    fn join(out: &Path, parts: &[&Path]) -> Result<Joined, HarnessError> {
        let parts: Vec<_> = parts.iter().map(|part| (*part).to_owned()).collect();
        entered(out, "a").join(&parts)
    }

    #[test]
    fn parts_are_joined_with_each_other_and_with_what_was_joined_before() {
        let folder = tempfile::tempdir().unwrap();
        let [out, one, two] = ["out", "one", "two"].map(|name| folder.path().join(name));
        part(&one, "a", &[(0, 0.5, false), (3, f64::INFINITY, false)]);
        part(&two, "a", &[(1, 1.5, false), (2, 9.0, true)]);
        let joined = Joined { quick: true, experiments: vec!["a".to_owned()] };
        assert_eq!(join(&out, &[&one]).unwrap(), joined);
        assert_eq!(join(&out, &[&two, &one]).unwrap(), joined);
        let journal = entered(&out, "a").journal("a", true).unwrap().for_reading();
        let takes: Vec<_> = (0..6).map(|cell| journal.takes("part", cell, false)).collect();
        assert_eq!(takes, [true, true, true, true, false, false]);
        assert_eq!(journal.cell("part", 1, false, || Ok(7.0)).unwrap(), 1.5);
        assert_eq!((journal.cells(), journal.dropped()), (4, 0));
    }

    #[test]
    fn results_that_differ_are_refused_by_name_unless_they_are_timed() {
        let folder = tempfile::tempdir().unwrap();
        let [out, one, two] = ["out", "one", "two"].map(|name| folder.path().join(name));
        part(&one, "a", &[(4, 1.0, true)]);
        part(&two, "a", &[(4, 2.0, true)]);
        join(&out, &[&one, &two]).unwrap();
        let journal = entered(&out, "a").journal("a", true).unwrap();
        assert_eq!(journal.cell("part", 4, true, || Ok(7.0)).unwrap(), 1.0, "the first one counts");
        drop(journal);
        part(&one, "a", &[(5, 1.0, false)]);
        part(&two, "a", &[(5, 1.0 + f64::EPSILON, false)]);
        let error = join(&out, &[&one, &two]).unwrap_err().to_string();
        let told = error.contains("two/.unfinished/a.journal: another result of cell 5 of `part`");
        assert!(told && error.contains("one/.unfinished/a.journal"), "{error}");
    }

    #[test]
    fn parts_of_another_executable_are_refused_and_a_torn_line_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let [out, one, two] = ["out", "one", "two"].map(|name| folder.path().join(name));
        part(&one, "b", &[(0, 1.0, false)]);
        let error = join(&out, &[&one]).unwrap_err().to_string();
        assert!(error.contains("one/.unfinished/a.journal: computed by another exec"), "{error}");
        part(&two, "a", &[(0, 1.0, false), (1, 2.0, false)]);
        let file = two.join(FOLDER).join("a.journal");
        let bytes = std::fs::read(&file).unwrap();
        std::fs::write(&file, &bytes[..bytes.len() - 3]).unwrap();
        join(&out, &[&two]).unwrap();
        assert_eq!(entered(&out, "a").journal("a", true).unwrap().cells(), 1);
    }

    #[test]
    fn a_shard_is_done_only_while_all_its_cells_are_there() {
        let folder = tempfile::tempdir().unwrap();
        let shard = Shard::Of { number: 1, count: 2 };
        let open = || entered(folder.path(), "a").journal("a", true).unwrap().for_shard(shard);
        let journal = open();
        for cell in 0..3 {
            journal.cell("part", cell, false, || Ok(0.1 * cell as f64)).unwrap();
        }
        assert!(!open().has_shard(shard));
        journal.end_shard(shard).unwrap();
        drop(journal);
        assert!(open().has_shard(shard) && !open().has_shard(Shard::Of { number: 2, count: 2 }));
        let file = folder.path().join(FOLDER).join("a.journal");
        let text = std::fs::read_to_string(&file).unwrap();
        assert_eq!(text.matches("0.1").count(), 1);
        std::fs::write(&file, text.replace("0.1", "0.4")).unwrap();
        let damaged = open();
        assert_eq!((damaged.dropped(), damaged.has_shard(shard)), (1, false));
        assert!(!open().has_shard(shard), "nor later, when the damaged line is gone");
    }

    #[test]
    fn a_second_shard_in_the_folder_needs_the_cells_of_the_first_too() {
        let folder = tempfile::tempdir().unwrap();
        let [one, two] = [1, 2].map(|number| Shard::Of { number, count: 2 });
        let open = |shard| entered(folder.path(), "a").journal("a", true).unwrap().for_shard(shard);
        for (shard, cells) in [(one, 0..2), (two, 2..3)] {
            let journal = open(shard);
            for cell in cells {
                journal.cell("part", cell, false, || Ok(0.1 + cell as f64)).unwrap();
            }
            journal.end_shard(shard).unwrap();
        }
        let whole = open(two);
        assert!(whole.has_shard(one) && whole.has_shard(two));
        drop(whole);
        let file = folder.path().join(FOLDER).join("a.journal");
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, text.replace("1.1", "1.4")).unwrap();
        let damaged = open(two);
        assert_eq!((damaged.cells(), damaged.has_shard(two)), (2, false));
    }

    /// A result that no line can hold, such as ∞, is computed again and stays one cell.
    #[test]
    fn a_cell_that_is_computed_again_counts_once() {
        let folder = tempfile::tempdir().unwrap();
        let open = || entered(folder.path(), "a").journal("a", true).unwrap();
        for _ in 0..2 {
            let journal = open();
            journal.cell("part", 0, false, || Ok(f64::INFINITY)).unwrap();
            journal.end_shard(Shard::Timed).unwrap();
        }
        let file = std::fs::read_to_string(folder.path().join(FOLDER).join("a.journal")).unwrap();
        assert_eq!(file.matches(r#""cells":1}"#).count(), 2, "{file}");
    }

    #[test]
    fn a_result_that_is_timed_in_one_part_only_must_agree() {
        let folder = tempfile::tempdir().unwrap();
        let [out, one, two] = ["out", "one", "two"].map(|name| folder.path().join(name));
        part(&one, "a", &[(4, 1.0, true)]);
        part(&two, "a", &[(4, 2.0, false)]);
        assert!(join(&out, &[&one, &two]).is_err());
    }
}
