//! The journal of a sweep: a line for each finished point, so that an interrupted sweep goes on.

use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufRead as _, BufReader, ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use potamoi_base::files::in_words;
use serde::{Deserialize, Serialize};

use super::SweepError;
use crate::cells::{COLUMNS, Cell};

/// First line: who wrote the rows.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Header {
    journal: String,
}

/// A finished point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Line {
    /// Key of the point: all that its row depends on.
    pub(crate) key: String,
    /// Cells in the order of the columns; why there are none.
    pub(crate) row: Result<Vec<Cell>, String>,
}

/// A journal that is open for more points.
pub(super) struct Journal {
    path: PathBuf,
    file: Mutex<File>,
}

impl Journal {
    /// Opens the journal of a folder for rows of `program`, and reads the points that it has. A torn last
    /// line is cut off: the program was killed while it wrote it.
    pub(super) fn open(
        folder: &Path,
        program: &str,
    ) -> Result<(Self, HashMap<String, Line>), SweepError> {
        let path = folder.join("journal.jsonl");
        let fail = |source| SweepError::Journal {
            path: path.clone(),
            source: in_words(source),
        };
        std::fs::create_dir_all(folder).map_err(|source| SweepError::Journal {
            path: folder.to_owned(),
            source: in_words(source),
        })?;
        let mut file = OpenOptions::new()
            .read(true)
            .append(true)
            .create(true)
            .open(&path)
            .map_err(fail)?;
        alone(&file, &path)?;
        let header = Header {
            journal: program.to_owned(),
        };
        let mut known = HashMap::new();
        let (mut whole, mut is_first) = (0u64, true);
        let mut lines = BufReader::new(&file);
        let mut text = vec![];
        loop {
            text.clear();
            let length = lines.read_until(b'\n', &mut text).map_err(fail)?;
            let is_whole = text.last() == Some(&b'\n');
            if is_first && !text.is_empty() {
                check(&text, &header, &path)?;
            }
            if !is_whole {
                break;
            }
            // A line that is none is passed over: its point is evaluated again.
            if !is_first && let Some(line) = Line::of(&text) {
                known.insert(line.key.clone(), line);
            }
            is_first = false;
            whole += length as u64;
        }
        file.set_len(whole).map_err(fail)?;
        if is_first {
            write(&mut file, &header).map_err(fail)?;
        }
        let file = Mutex::new(file);
        Ok((Self { path, file }, known))
    }

    /// Appends a point. It is in the file when this returns.
    pub(super) fn append(&self, line: &Line) -> Result<(), SweepError> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        write(&mut file, line).map_err(|source| SweepError::Journal {
            path: self.path.clone(),
            source: in_words(source),
        })
    }
}

impl Line {
    /// The line of a text; `None` where it is none, or has other columns.
    fn of(text: &[u8]) -> Option<Self> {
        let own: Self = serde_json::from_slice(text).ok()?;
        let fits = own
            .row
            .as_ref()
            .map_or(true, |cells| cells.len() == COLUMNS.len());
        fits.then_some(own)
    }
}

/// Refuses a journal that another process writes. The lock ends with the process, however it ends.
fn alone(file: &File, path: &Path) -> Result<(), SweepError> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(SweepError::InUse {
            path: path.to_owned(),
        }),
        // Some shared file systems have no locks.
        Err(TryLockError::Error(source)) if source.kind() == ErrorKind::Unsupported => Ok(()),
        Err(TryLockError::Error(source)) => Err(SweepError::Journal {
            path: path.to_owned(),
            source: in_words(source),
        }),
    }
}

/// Refuses rows of another program.
fn check(text: &[u8], own: &Header, path: &Path) -> Result<(), SweepError> {
    let found = serde_json::from_slice::<Header>(text).ok();
    match found {
        Some(found) if found == *own => Ok(()),
        found => Err(SweepError::Foreign {
            path: path.to_owned(),
            found: found.map_or_else(|| "something else".to_owned(), |found| found.journal),
            own: own.journal.clone(),
        }),
    }
}

/// A line in one call, so that a kill leaves the whole line or its beginning. It is not forced to the disk,
/// which would take longer than a point.
fn write(file: &mut File, line: &impl Serialize) -> std::io::Result<()> {
    let mut text = serde_json::to_vec(line)?;
    text.push(b'\n');
    file.write_all(&text)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn line(key: &str) -> Line {
        Line {
            key: key.to_owned(),
            row: Ok(vec![Cell::Number(1.5); COLUMNS.len()]),
        }
    }

    #[test]
    fn what_was_finished_is_read_again_and_a_torn_line_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let (journal, known) = Journal::open(folder.path(), "p 1").unwrap();
        assert!(known.is_empty());
        journal.append(&line("a")).unwrap();
        let refused = Line {
            key: "b".into(),
            row: Err("why".into()),
        };
        journal.append(&refused).unwrap();
        drop(journal);
        let path = folder.path().join("journal.jsonl");
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, [&whole[..], b"{\"key\":\"c\",\"ro"].concat()).unwrap();
        let (journal, known) = Journal::open(folder.path(), "p 1").unwrap();
        assert_eq!(known.len(), 2);
        assert_eq!((&known["a"], &known["b"]), (&line("a"), &refused));
        journal.append(&line("c")).unwrap();
        let both = Journal::open(folder.path(), "p 1");
        assert!(matches!(both, Err(SweepError::InUse { .. })));
        drop(journal);
        assert_eq!(Journal::open(folder.path(), "p 1").unwrap().1.len(), 3);
    }

    #[test]
    fn rows_of_another_program_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        Journal::open(folder.path(), "p 1").unwrap();
        let error = Journal::open(folder.path(), "p 2")
            .err()
            .unwrap()
            .to_string();
        assert!(error.contains("p 1") && error.contains("p 2"), "{error}");
        for foreign in ["# mine\n", "notes without an end", "{\"journal\""] {
            let path = folder.path().join("journal.jsonl");
            std::fs::write(&path, foreign).unwrap();
            assert!(Journal::open(folder.path(), "p 1").is_err(), "{foreign}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), foreign);
        }
    }

    /// One damaged line costs its own point.
    #[test]
    fn a_damaged_line_is_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        let (journal, _) = Journal::open(folder.path(), "p 1").unwrap();
        for key in ["a", "b", "c"] {
            journal.append(&line(key)).unwrap();
        }
        drop(journal);
        let path = folder.path().join("journal.jsonl");
        let text = std::fs::read_to_string(&path).unwrap();
        let second = text.lines().nth(2).unwrap();
        std::fs::write(
            &path,
            text.replace(second, "{\"key\":\"b\",\"row\":{\"Ok\":[1]}}"),
        )
        .unwrap();
        let mut known: Vec<String> = Journal::open(folder.path(), "p 1")
            .unwrap()
            .1
            .into_keys()
            .collect();
        known.sort();
        assert_eq!(known, ["a", "c"]);
    }
}
