//! Verdicts that are kept, so that a run which is interrupted goes on where it was.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use potamoi_result_cache::{self as result_cache, Key};
use serde::Serialize;

use crate::{Fate, Judge, MutateError};

/// Version of this record.
const VERSION: &str = "1";
/// Time between two writes.
const PAUSE: Duration = Duration::from_secs(5);

/// Where verdicts are kept.
#[derive(Debug, Clone)]
pub struct Kept {
    /// The folder.
    pub folder: PathBuf,
    /// Hash of the program that judges: a verdict of another one is not believed.
    pub program: String,
}

/// Verdicts by judge and number of the mutant: what the judge finds, if anything.
type Verdicts = BTreeMap<Judge, BTreeMap<usize, Option<Fate>>>;

/// Verdicts on the mutants of a unit, in a file unless they are not kept.
pub(crate) struct Record {
    path: Option<PathBuf>,
    verdicts: Mutex<(Verdicts, Instant)>,
}

impl Record {
    /// What is kept of earlier runs of the same program on the same mutants, which `parts` tells.
    pub(crate) fn open(kept: Option<&Kept>, parts: &impl Serialize) -> Self {
        let path = kept.map(|kept| {
            let key = Key::new("mutants", VERSION)
                .text("judge", &kept.program)
                .value("mutants", parts);
            key.file(&kept.folder, "json")
        });
        let verdicts = path.as_deref().and_then(result_cache::read);
        Self {
            path,
            verdicts: Mutex::new((verdicts.unwrap_or_default(), Instant::now())),
        }
    }

    /// The verdict of a judge on a mutant, kept or by `find`.
    pub(crate) fn verdict(
        &self,
        judge: Judge,
        mutant: usize,
        find: impl FnOnce() -> Result<Option<Fate>, MutateError>,
    ) -> Result<Option<Fate>, MutateError> {
        if let Ok(all) = self.verdicts.lock()
            && let Some(known) = all.0.get(&judge).and_then(|found| found.get(&mutant))
        {
            return Ok(known.clone());
        }
        let found = find()?;
        if let Ok(mut all) = self.verdicts.lock() {
            let (verdicts, written) = &mut *all;
            let of_judge = verdicts.entry(judge).or_default();
            of_judge.insert(mutant, found.clone());
            if written.elapsed() >= PAUSE {
                self.write(verdicts)?;
                *written = Instant::now();
            }
        }
        Ok(found)
    }

    /// Writes the verdicts.
    pub(crate) fn save(&self) -> Result<(), MutateError> {
        self.verdicts
            .lock()
            .map_or(Ok(()), |all| self.write(&all.0))
    }

    fn write(&self, verdicts: &Verdicts) -> Result<(), MutateError> {
        let Some(path) = &self.path else {
            return Ok(());
        };
        result_cache::write(path, verdicts).map_err(|error| MutateError::File {
            path: path.clone(),
            error,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_verdict_is_kept_for_the_same_program_and_mutants() {
        let folder = tempfile::tempdir().unwrap();
        let kept = |program: &str| Kept {
            folder: folder.path().to_owned(),
            program: program.to_owned(),
        };
        let first = Record::open(Some(&kept("a")), &"mutants");
        let fate = Fate::Verify {
            said: "cycle 3".to_owned(),
        };
        let found = first.verdict(Judge::Bench, 4, || Ok(Some(fate.clone())));
        assert_eq!(found.unwrap(), Some(fate.clone()));
        first.save().unwrap();

        let asked = |program: &str, parts: &str, judge, mutant| {
            let record = Record::open(Some(&kept(program)), &parts);
            record.verdict(judge, mutant, || Ok(None)).unwrap()
        };
        assert_eq!(asked("a", "mutants", Judge::Bench, 4), Some(fate));
        for (program, parts, judge, mutant) in [
            ("b", "mutants", Judge::Bench, 4),
            ("a", "others", Judge::Bench, 4),
            ("a", "mutants", Judge::Miter, 4),
            ("a", "mutants", Judge::Bench, 5),
        ] {
            assert_eq!(asked(program, parts, judge, mutant), None);
        }
    }
}
