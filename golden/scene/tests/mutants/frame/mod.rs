//! Mutants of files: a file is decoded, one or a few of its parts are changed, and it is encoded
//! again, so that readers get past the container.
//!
//! | structure | mutated by |
//! |---|---|
//! | JSON, TOML, MessagePack | [`tree`] |
//! | lines of words | [`text`] |
//! | PLY | [`ply`] |
//! | arrays and headers at known offsets | [`flat`] |
//! | NPY arrays, and ZIP files of members | [`npy`], [`zips`] |
//! | pickles | [`pickle`] |
//!
//! [`run`] makes mutants from numbers, passes each to a reader on a thread of its own, and checks
//! the contract of every reader: no panic, an answer within [`PATIENCE`], memory of at most
//! [`MEMORY`], and either an error in a user's words that names the file, or a result whose
//! invariants hold. A failure is reported with the command that makes the same mutant again; if
//! the process itself ends, `target/tmp/FORMAT.mutant` has the number.
#![allow(dead_code)]

pub(crate) mod flat;
pub(crate) mod npy;
pub(crate) mod pickle;
pub(crate) mod ply;
pub(crate) mod rng;
pub(crate) mod text;
pub(crate) mod tree;
pub(crate) mod zips;

use std::collections::BTreeSet;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use peak_alloc::PeakAlloc;

pub(crate) use rng::Rng;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Numbers of mutants of a format, in quick and in exhaustive runs.
pub(crate) const FEW: u64 = 100;
pub(crate) const MANY: u64 = 10_000;
/// Time limit of a reader, including rendering: about a hundred times the usual time on two loaded
/// cores.
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);
/// Memory limit of a reader with a small picture, in bytes, for files of less than 100 kB.
pub(crate) const MEMORY: usize = 256 << 20;
/// Maximum number of kinds of faults reported.
const KINDS: usize = 12;
/// Maximum length of an error in characters.
pub(crate) const TOLD: usize = 1000;
/// Words of the language and its libraries that mean nothing to a user.
const STRANGE: [&str; 16] = [
    "invalid type",
    "invalid value",
    "invalid length",
    "missing field",
    "unknown field",
    "unknown variant",
    "duplicate field",
    "data did not match",
    "expected u32",
    "expected u64",
    "expected f64",
    "expected usize",
    "struct ",
    "unwrap",
    "panicked",
    "Utf8Error",
];

/// Named files of one folder; readers are given the first.
pub(crate) type Files = Vec<(String, Vec<u8>)>;

/// The outcome of reading a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// All invariants of the result hold.
    Sound,
    /// An invariant that does not hold.
    Broken(String),
    /// The error.
    Refused(String),
}

impl Verdict {
    /// The outcome for a reader's result.
    pub(crate) fn of<T, E: std::fmt::Display>(
        read: Result<T, E>,
        check: impl FnOnce(T) -> Result<(), String>,
    ) -> Self {
        match read {
            Err(error) => Self::Refused(error.to_string()),
            Ok(found) => check(found).map_or_else(Self::Broken, |()| Self::Sound),
        }
    }
}

/// A format and its reader.
#[derive(Clone)]
pub(crate) struct Format {
    /// Name of the test.
    pub(crate) name: &'static str,
    /// Integration test that it is in, as cargo names it.
    pub(crate) binary: &'static str,
    /// A valid file, which readers accept.
    pub(crate) whole: Arc<dyn Fn() -> Files + Send + Sync>,
    /// Makes a mutant of it.
    pub(crate) mutant: Arc<dyn Fn(&mut Rng) -> Files + Send + Sync>,
    /// Reads the first of the files.
    pub(crate) judge: fn(&Path) -> Verdict,
}

/// Statistics of mutants.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(crate) struct Tally {
    pub(crate) sound: u64,
    pub(crate) refused: u64,
    /// Faults, each with the command that reproduces it.
    pub(crate) faults: Vec<String>,
    /// Total time of all readers.
    took: Duration,
    /// Longest time, and the number of its mutant.
    longest: (Duration, u64),
}

/// A fault of a reader.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Fault {
    kind: String,
    told: String,
}

impl Fault {
    fn of(kind: impl Into<String>, told: impl Into<String>) -> Self {
        let (kind, told) = (kind.into(), told.into());
        Self { kind, told }
    }
}

/// Whether there are many mutants or a single one is examined, so that slow checks are included.
static THOROUGH: AtomicBool = AtomicBool::new(false);

pub(crate) fn is_thorough() -> bool {
    THOROUGH.load(Ordering::Relaxed)
}

/// Runs one mutant at a time, so that its memory can be measured.
static ONE: Mutex<()> = Mutex::new(());

/// Tries `count` mutants of a format, or `POTAMOI_MUTANTS` of them, or only the one with number
/// `POTAMOI_MUTANT`, whose files are then kept.
pub(crate) fn run(formats: &[Format], name: &str, count: u64) {
    let format = formats
        .iter()
        .find(|format| format.name == name)
        .expect("a format");
    let given = |name| {
        let text = std::env::var(name).ok();
        text.map(|text| text.parse::<u64>().expect("a whole number"))
    };
    let only = given("POTAMOI_MUTANT");
    let count = given("POTAMOI_MUTANTS").unwrap_or(count);
    THOROUGH.fetch_or(count > FEW || only.is_some(), Ordering::Relaxed);
    let (whole, _) = tried(format, &(format.whole)(), PATIENCE);
    let name = format.name;
    assert!(
        whole == Ok(None),
        "{name}: the whole file is not read: {whole:?}"
    );
    let numbers = match only {
        Some(number) => number..number + 1,
        None => 0..count,
    };
    let tally = tally(format, numbers, only.is_some());
    let faults = tally.faults.join("\n\n");
    assert!(
        tally.faults.is_empty(),
        "{} faults:\n{faults}",
        tally.faults.len()
    );
    let (longest, of) = tally.longest;
    println!(
        "{name}: {} read, {} refused, {:.1?}; {longest:.1?} of mutant {of}",
        tally.sound, tally.refused, tally.took
    );
    // A mutator that only breaks files, or changes nothing that is looked at, tries nothing.
    let least = count / 25;
    if only.is_none() {
        assert!(tally.sound >= least && tally.refused >= least, "{tally:?}");
    }
}

/// Defines two tests for each format, and one that all formats have them.
macro_rules! tests {
    ($($name:ident),+) => {
        $(mod $name {
            #[test]
            fn few_mutants() {
                crate::frame::run(&crate::formats(), stringify!($name), crate::frame::FEW);
            }

            #[test]
            #[ignore = "exhaustive; run with make test-full"]
            fn many_mutants() {
                crate::frame::run(&crate::formats(), stringify!($name), crate::frame::MANY);
            }
        })+

        #[test]
        fn every_format_is_tried() {
            let names: Vec<_> = formats().iter().map(|format| format.name).collect();
            assert_eq!(names, [$(stringify!($name)),+]);
        }
    };
}
pub(crate) use tests;

/// Tries the mutants of these numbers. Among faults that differ only in numbers, the first is
/// reported, and at most [`KINDS`] in total.
pub(crate) fn tally(format: &Format, numbers: std::ops::Range<u64>, keep: bool) -> Tally {
    tally_within(format, numbers, keep, PATIENCE)
}

/// As [`tally`], with another time limit.
pub(crate) fn tally_within(
    format: &Format,
    numbers: std::ops::Range<u64>,
    keep: bool,
    patience: Duration,
) -> Tally {
    let mut tally = Tally::default();
    let mut kinds = BTreeSet::new();
    for number in numbers {
        let files = (format.mutant)(&mut Rng::new(format.name, number));
        if keep {
            let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format.name);
            write(&folder, &files);
            println!("mutant {number} is in {}", folder.display());
        }
        let trial = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}.mutant", format.name));
        fs::write(trial, number.to_string()).expect("a file");
        let (answer, took) = tried(format, &files, patience);
        tally.took += took;
        tally.longest = tally.longest.max((took, number));
        match answer {
            Ok(None) => tally.sound += 1,
            Ok(Some(_)) => tally.refused += 1,
            Err(fault) => {
                let Format { name, binary, .. } = format;
                let Fault { kind, told } = fault;
                if kinds.insert(kind.replace(|c: char| c.is_ascii_digit(), "")) {
                    tally.faults.push(format!(
                        "{kind}{told}\n  again: POTAMOI_MUTANT={number} cargo test {binary} \
                         {name}::few -- --nocapture"
                    ));
                }
                if kinds.len() == KINDS {
                    break;
                }
            }
        }
    }
    tally
}

fn write(folder: &Path, files: &Files) -> PathBuf {
    for (name, bytes) in files {
        let path = folder.join(name);
        if path.is_dir() {
            // A mutant's name is that of a folder: the file is missing.
            continue;
        }
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, bytes).expect("a file");
    }
    folder.join(&files[0].0)
}

/// The error of a mutant that is refused properly.
fn tried(
    format: &Format,
    files: &Files,
    patience: Duration,
) -> (Result<Option<String>, Fault>, Duration) {
    let _one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let begun = Instant::now();
    let answer = answer(format, files, patience);
    (answer, begun.elapsed())
}

fn answer(format: &Format, files: &Files, patience: Duration) -> Result<Option<String>, Fault> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = write(folder.path(), files);
    let judge = format.judge;
    let (told, heard) = channel();
    let own = path.clone();
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    // The thread is left behind if it hangs: the test ends all the same.
    std::thread::spawn(move || {
        let verdict = catch_unwind(AssertUnwindSafe(|| judge(&own)));
        let _ = told.send(verdict.map_err(|panic| {
            let text = panic.downcast_ref::<String>().cloned();
            text.or_else(|| panic.downcast_ref::<&str>().map(|t| (*t).to_owned()))
                .unwrap_or_default()
        }));
    });
    let verdict = match heard.recv_timeout(patience) {
        Ok(Ok(verdict)) => verdict,
        Ok(Err(panic)) => return Err(Fault::of(format!("a panic: {panic}"), "")),
        Err(RecvTimeoutError::Timeout) => {
            return Err(Fault::of(format!("no answer in {patience:?}"), ""));
        }
        Err(RecvTimeoutError::Disconnected) => return Err(Fault::of("no answer", "")),
    };
    let held = ALLOCATOR.peak_usage().saturating_sub(before);
    if held > MEMORY {
        let kind = format!("{held} bytes held: expected at most {MEMORY}");
        return Err(Fault::of(kind, format!(": {verdict:?}")));
    }
    match verdict {
        Verdict::Sound => Ok(None),
        Verdict::Broken(what) => Err(Fault::of(format!("read, but {what}"), "")),
        Verdict::Refused(error) => match words(&error, folder.path()) {
            Ok(()) => Ok(Some(error)),
            Err(problem) => {
                let told: String = error.chars().take(2 * TOLD).collect();
                Err(Fault::of(problem, format!(" in: {told}")))
            }
        },
    }
}

/// Checks that an error names the file, briefly and in a user's words.
fn words(error: &str, folder: &Path) -> Result<(), String> {
    // A description may name a file elsewhere, which is then the one at fault.
    if !error.contains(&*folder.to_string_lossy()) && !error.contains("/dev/") {
        return Err("no name of the file".to_owned());
    }
    // Names of files are told whole.
    let long = format!("/{}", "x".repeat(rng::LONG));
    let length = error.replace(&long, "/x").chars().count();
    if length > TOLD {
        return Err(format!("{length} characters"));
    }
    match STRANGE.iter().find(|word| error.contains(**word)) {
        Some(word) => Err(format!("strange words, `{word}`,")),
        None => Ok(()),
    }
}
