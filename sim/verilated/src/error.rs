//! Errors, each with a remedy.

use std::io::ErrorKind;
use std::path::PathBuf;

/// Why a model could not be built, loaded or driven.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A program that builds need is missing.
    #[error("{tool} was not found ({searched}); without it {disables}. {remedy}")]
    MissingTool {
        /// Its name.
        tool: String,
        /// Places searched.
        searched: String,
        /// What needs it.
        disables: &'static str,
        /// How to install it.
        remedy: &'static str,
    },
    /// Wrong numbers of packed words.
    #[error(
        "cycle of {top}: {inputs} words of inputs and {outputs} of outputs: expected {} and {}; \
         all ports in order, the clock included", expected[0], expected[1]
    )]
    Packed {
        /// The top module.
        top: String,
        /// Words of inputs given.
        inputs: usize,
        /// Words of outputs given.
        outputs: usize,
        /// Expected words of both.
        expected: [usize; 2],
    },
    /// A tool refused its input.
    #[error("{tool} failed ({status}) while {doing}:\n{output}")]
    Tool {
        /// The program.
        tool: String,
        /// Its task.
        doing: String,
        /// Its exit status.
        status: String,
        /// The end of its output.
        output: String,
    },
    /// A tool is too old.
    #[error("{tool} is version {found}, and version {needed} or later is needed; {remedy}")]
    OldTool {
        /// The program.
        tool: String,
        /// The version it reports.
        found: String,
        /// The first supported version.
        needed: &'static str,
        /// How to install it.
        remedy: &'static str,
    },
    /// A tool is broken whatever its input: it does not start, does not end, is killed, or leaves
    /// no result.
    #[error("{tool} does not work ({doing}): {problem}. {remedy}")]
    Broken {
        /// The program.
        tool: String,
        /// Its task.
        doing: String,
        /// The fault.
        problem: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// The environment names no cache folder.
    #[error(
        "no folder for kept files: neither POTAMOI_CACHE nor an absolute XDG_CACHE_HOME or HOME is \
         set; set POTAMOI_CACHE to a folder of your own"
    )]
    NoCacheDir,
    /// The cache folder cannot be created.
    #[error(
        "cannot create the folder of kept files {path:?}: {reason}; name a folder of your own in \
         POTAMOI_CACHE"
    )]
    NoFolder {
        /// The folder.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// Other users can write the cache folder.
    #[error(
        "the folder of kept files {path:?} is not used, since models are loaded from it as code: \
         {problem}; name a folder of your own in POTAMOI_CACHE{}",
        if *is_own { format!(", or: chmod go-w {path:?}") } else { String::new() }
    )]
    Untrusted {
        /// The folder.
        path: PathBuf,
        /// Who can write it.
        problem: String,
        /// Whether it belongs to this user, who can change its permissions.
        is_own: bool,
    },
    /// A name that cannot be used as a module, file or port.
    #[error("{what} {name:?} cannot be used: {expected}")]
    BadName {
        /// Kind of the named thing.
        what: &'static str,
        /// The name.
        name: String,
        /// Names that can be used.
        expected: &'static str,
    },
    /// Nothing to build: no source file was given.
    #[error("module {top} has no source file; call ModelBuilder::source before build")]
    NoSource {
        /// The top module.
        top: String,
    },
    /// A declared port is not in the Verilog.
    #[error("module {top} has no port {port}; its ports are: {available}")]
    NoSuchPort {
        /// The top module.
        top: String,
        /// The port asked for.
        port: String,
        /// Available ports.
        available: String,
    },
    /// A port has another width or direction than declared.
    #[error("port {port} of module {top} is declared as {declared}, but the Verilog has {found}")]
    PortMismatch {
        /// The top module.
        top: String,
        /// The port.
        port: String,
        /// The declaration.
        declared: String,
        /// The port in the Verilog.
        found: String,
    },
    /// A port handle belongs to another library.
    #[error(
        "the port handle belongs to another library; ask this model (or its library) for the \
         port by name"
    )]
    ForeignPort,
    /// A write to an output.
    #[error("port {port} is an output and cannot be set")]
    NotAnInput {
        /// The port.
        port: String,
    },
    /// A call does not fit a port's width.
    #[error("port {port} has {bits} bits, but {call} takes {expected}; use {instead}")]
    WrongWidth {
        /// The port.
        port: String,
        /// Its width.
        bits: u32,
        /// The call.
        call: &'static str,
        /// Width that the call requires.
        expected: String,
        /// The right call.
        instead: &'static str,
    },
    /// The model stopped (`$fatal`, `$stop`, `$finish`, a failed assertion, or a design that does
    /// not settle), and accepts no further calls.
    #[error("the model of {top} stopped at time {time}: {text}")]
    Stopped {
        /// The top module.
        top: String,
        /// Simulation time in half periods, where [`crate::Model::tick`] drives the clock.
        time: u64,
        /// The cause.
        cause: Stop,
        /// The Verilog's message.
        text: String,
    },
    /// A trace call on a library built with [`crate::Trace::Off`].
    #[error("the model of {top} was built without traces; build it with Trace::Vcd")]
    NoTrace {
        /// The top module.
        top: String,
    },
    /// A trace file could not be opened, or none is open.
    #[error("trace: {0}")]
    Trace(String),
    /// A newly built library cannot be loaded.
    #[error("cannot load {path:?}: {reason}")]
    Load {
        /// The library file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// Two drivers disagree on the same stimulus.
    #[error("{0}")]
    Peer(String),
    /// A file or folder cannot be used.
    #[error("cannot {doing} {path:?}: {reason}")]
    Io {
        /// The operation.
        doing: &'static str,
        /// The path.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
}

/// Cause of a model's stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// `$finish`.
    Finish,
    /// `$stop`, `$fatal`, `$error` or a failed assertion.
    Stop,
    /// Verilator's own run-time checks, such as a combinational loop that does not settle.
    Fatal,
    /// A C++ exception, such as memory running out.
    Exception,
}

impl Error {
    pub(crate) fn io(doing: &'static str, path: &std::path::Path, e: &std::io::Error) -> Self {
        Error::Io {
            doing,
            path: path.to_path_buf(),
            reason: match remedy(e.kind()) {
                Some(remedy) => format!("{e}; {remedy}"),
                None => e.to_string(),
            },
        }
    }
}

/// Remedy where a folder is full.
fn remedy(kind: ErrorKind) -> Option<&'static str> {
    match kind {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => Some(
            "make room (`potamoi cache --clear` removes what is kept), or name a folder on \
             another disk in POTAMOI_CACHE",
        ),
        ErrorKind::ReadOnlyFilesystem | ErrorKind::PermissionDenied => {
            Some("name a folder of your own in POTAMOI_CACHE")
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_or_closed_folder_has_a_remedy() {
        let said = |code| {
            let error = std::io::Error::from_raw_os_error(code);
            Error::io("write", std::path::Path::new("/c/f"), &error).to_string()
        };
        let [missing, denied, no_space, read_only] = [2, 13, 28, 30];
        let full = said(no_space);
        assert!(full.contains("No space left"), "{full}");
        assert!(full.contains("cache --clear"), "{full}");
        for code in [denied, no_space, read_only] {
            assert!(said(code).contains("POTAMOI_CACHE"), "{code}");
        }
        assert!(!said(missing).contains("POTAMOI_CACHE"));
    }
}
