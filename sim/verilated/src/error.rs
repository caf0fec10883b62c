//! What can go wrong, with what to do about it.

use std::io::ErrorKind;
use std::path::PathBuf;

/// Why a model could not be built, loaded or driven.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A program that building a model needs is not on this machine.
    #[error("{tool} was not found ({searched}); without it {disables}. {remedy}")]
    MissingTool {
        /// The program.
        tool: String,
        /// Where it was looked for.
        searched: String,
        /// What cannot be done without it.
        disables: &'static str,
        /// How to get it.
        remedy: &'static str,
    },
    /// Packed words of a wrong number.
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
        /// Words of both that are right.
        expected: [usize; 2],
    },
    /// A tool ran and refused its input; `output` is what it said.
    #[error("{tool} failed ({status}) while {doing}:\n{output}")]
    Tool {
        /// The program.
        tool: String,
        /// What it was asked to do.
        doing: String,
        /// Its exit status.
        status: String,
        /// The end of its output.
        output: String,
    },
    /// The tool found is too old.
    #[error("{tool} is version {found}, and version {needed} or later is needed; {remedy}")]
    OldTool {
        /// The program.
        tool: String,
        /// The version it reports.
        found: String,
        /// The first version that works.
        needed: &'static str,
        /// How to get it.
        remedy: &'static str,
    },
    /// A tool does not do what it should, whatever its input is: it does not start, does not end,
    /// is killed, or leaves no result.
    #[error("{tool} does not work ({doing}): {problem}. {remedy}")]
    Broken {
        /// The program.
        tool: String,
        /// What it was asked to do.
        doing: String,
        /// What it did.
        problem: String,
        /// What to do.
        remedy: &'static str,
    },
    /// The environment does not say where to keep files.
    #[error(
        "no folder for kept files: neither POTAMOI_CACHE nor an absolute XDG_CACHE_HOME or HOME is \
         set; set POTAMOI_CACHE to a folder of your own"
    )]
    NoCacheDir,
    /// The folder of kept files cannot be made.
    #[error(
        "cannot create the folder of kept files {path:?}: {reason}; name a folder of your own in \
         POTAMOI_CACHE"
    )]
    NoFolder {
        /// The folder.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A folder of kept files that somebody else may have filled.
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
        /// Whether it is this user's, who can close it to others.
        is_own: bool,
    },
    /// A name that cannot be used as a module, file or port.
    #[error("{what} {name:?} cannot be used: {expected}")]
    BadName {
        /// What the name is of.
        what: &'static str,
        /// The name.
        name: String,
        /// What would do.
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
        /// The ports it has.
        available: String,
    },
    /// A declared port has another width or direction in the Verilog.
    #[error("port {port} of module {top} is declared as {declared}, but the Verilog has {found}")]
    PortMismatch {
        /// The top module.
        top: String,
        /// The port.
        port: String,
        /// What was declared.
        declared: String,
        /// What the Verilog says.
        found: String,
    },
    /// A handle made by another library.
    #[error(
        "the port handle belongs to another library; ask this model (or its library) for the \
         port by name"
    )]
    ForeignPort,
    /// An output was written.
    #[error("port {port} is an output and cannot be set")]
    NotAnInput {
        /// The port.
        port: String,
    },
    /// A port was read or written with a call for another width.
    #[error("port {port} has {bits} bits, but {call} takes {expected}; use {instead}")]
    WrongWidth {
        /// The port.
        port: String,
        /// Its width.
        bits: u32,
        /// The call made.
        call: &'static str,
        /// What that call takes.
        expected: String,
        /// The call to make.
        instead: &'static str,
    },
    /// The model stopped (`$fatal`, `$stop`, `$finish`, a failed assertion, or a design that
    /// does not settle) and takes no further calls.
    #[error("the model of {top} stopped at time {time}: {text}")]
    Stopped {
        /// The top module.
        top: String,
        /// Simulation time, in half periods when [`crate::Model::tick`] drives the clock.
        time: u64,
        /// What stopped it.
        cause: Stop,
        /// Verilog's text.
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
    /// A freshly built library could not be loaded.
    #[error("cannot load {path:?}: {reason}")]
    Load {
        /// The library file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// Two drivers that were given the same stimulus disagree.
    #[error("{0}")]
    Peer(String),
    /// A file or folder could not be used.
    #[error("cannot {doing} {path:?}: {reason}")]
    Io {
        /// What was tried.
        doing: &'static str,
        /// On what.
        path: PathBuf,
        /// Why it failed.
        reason: String,
    },
}

/// What made a model stop.
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

/// What to do where a folder takes no more files.
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
