//! The machine, its tools, and how busy it was.

use std::fs;

use potamoi_base::vectors::Vectors;
use schemars::JsonSchema;
use serde::Serialize;

use crate::time::Meter;

/// Share of waiting from which a machine counts as busy.
const BUSY: f64 = 0.2;

/// The machine of a comparison.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Machine {
    /// The processor's name, as it reports it, or its architecture.
    pub processor: String,
    /// Cores that this process may use.
    pub cores: usize,
    /// Threads of the renderers and of verification.
    pub threads: usize,
    /// Vectors of the processor that the renderers know, the narrowest first.
    pub vectors: Vec<&'static str>,
    /// The operating system.
    pub system: String,
    /// Whether this program was built with optimisation. The figures of one that was not say nothing.
    pub is_optimised: bool,
}

impl Machine {
    /// This machine.
    pub(crate) fn here() -> Self {
        Self {
            processor: processor(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            threads: rayon::current_num_threads(),
            vectors: Vectors::here().map(Vectors::name).collect(),
            system: system(),
            is_optimised: !cfg!(debug_assertions),
        }
    }
}

/// The value after a key of a file of lines, without quotes.
fn value(file: &str, key: &str, separator: char) -> Option<String> {
    let text = fs::read_to_string(file).ok()?;
    let mut lines = text.lines().filter_map(|line| line.split_once(separator));
    let (_, value) = lines.find(|(name, _)| name.trim() == key)?;
    let value = value.trim().trim_matches('"');
    (!value.is_empty()).then(|| value.to_owned())
}

fn processor() -> String {
    let name = value("/proc/cpuinfo", "model name", ':');
    name.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

fn system() -> String {
    let name = value("/etc/os-release", "PRETTY_NAME", '=');
    let kernel = fs::read_to_string("/proc/sys/kernel/osrelease").ok();
    let os = std::env::consts::OS.to_owned();
    let kernel = kernel.map_or_else(|| os.clone(), |own| format!("{os} {}", own.trim()));
    match name {
        Some(name) => format!("{name}, {kernel}"),
        None => kernel,
    }
}

/// A tool or a peer of the comparison.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Tool {
    /// Its name.
    pub name: &'static str,
    /// The version that it reports; null where it cannot be used.
    pub version: Option<String>,
    /// Why it cannot be used, and how to install it.
    pub why: Option<String>,
}

impl Tool {
    pub(crate) fn new(name: &'static str, version: &Result<String, String>) -> Self {
        Self {
            name,
            version: version.as_ref().ok().cloned(),
            why: version.as_ref().err().cloned(),
        }
    }
}

/// Where processor times come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TimeSource {
    /// The system's account of every thread (`/proc/self/task/*/schedstat`).
    Threads,
    /// Elapsed time times the number of threads that the work keeps busy, where the system keeps no such
    /// account: on a busy machine that is more than processor time.
    ElapsedTimesThreads,
}

/// How busy the machine was with other work.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Busy {
    /// Share of the time in which threads of this process could run and had no processor; null where the
    /// system does not report it.
    pub waiting: Option<f64>,
    /// Whether that is so much that elapsed times are far above processor times, and processor times
    /// themselves longer than on a quiet machine.
    pub is_busy: bool,
}

impl Busy {
    pub(crate) fn of(meter: &Meter) -> Self {
        Self::by(meter.waiting())
    }

    fn by(waiting: Option<f64>) -> Self {
        Self {
            waiting,
            is_busy: waiting.is_some_and(|share| share > BUSY),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_is_busy_where_threads_wait() {
        for (waiting, expected) in [
            (None, false),
            (Some(0.0), false),
            (Some(0.1), false),
            (Some(0.5), true),
        ] {
            assert_eq!(Busy::by(waiting).is_busy, expected, "{waiting:?}");
        }
    }

    #[test]
    fn this_machine_has_a_name_and_threads() {
        let here = Machine::here();
        assert!(!here.processor.is_empty() && !here.system.is_empty());
        assert!(here.cores > 0 && here.threads > 0);
    }

    #[test]
    fn a_key_that_a_file_lacks_has_no_value() {
        assert_eq!(value("/no/such/file", "a", '='), None);
        assert_eq!(value("/proc/cpuinfo", "no such key", ':'), None);
    }
}
