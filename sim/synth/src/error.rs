//! Errors of synthesis, from Verilog to cells.

use std::path::PathBuf;

use potamoi_netlist::IrErrors;
use thiserror::Error;

use super::unit_kind::UnitKind;

/// Remedy where a program fails that read a cell library.
pub(super) const CHECK_LIBRARY: &str = "check the cell descriptions of the library (another \
                                        library shows whether it is at fault), then the versions \
                                        of the tools with `potamoi doctor`";
/// Remedy where a program fails that read generated files only.
pub(super) const CHECK_VERSIONS: &str = "check the versions of the tools with `potamoi doctor`";

/// Why a synthesis failed.
#[derive(Debug, Error)]
pub enum SynthError {
    /// A program is missing.
    #[error("{tool} is not installed: {disables} needs it; to install it: {remedy}")]
    MissingTool {
        /// Its name.
        tool: &'static str,
        /// What needs it.
        disables: &'static str,
        /// How to install it.
        remedy: &'static str,
    },
    /// No library was named, and the default one is not installed.
    #[error(
        "no cell library: {path} does not exist; name one with --liberty, or: apt-get install \
         qflow-tech-osu018"
    )]
    NoLibrary {
        /// Path of the default library.
        path: PathBuf,
    },
    /// A file cannot be read.
    #[error("cannot read {path}: {source}; name a Liberty file, plain or packed with gzip")]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// A file is not a valid Liberty file.
    #[error("{path}, line {line}: expected {expected}, found {found}")]
    Liberty {
        /// The file.
        path: String,
        /// Line, from 1.
        line: usize,
        /// The expected syntax.
        expected: String,
        /// The text found.
        found: String,
    },
    /// A library lacks a cell that every netlist needs.
    #[error("{path}: no {what} among its {cells} cells; name a library of standard cells")]
    MissingCell {
        /// The file.
        path: PathBuf,
        /// The missing cell.
        what: &'static str,
        /// Number of cells in the library.
        cells: usize,
    },
    /// A memory cannot be modelled.
    #[error("memory {memory}: {why}")]
    Memory {
        /// Its name.
        memory: String,
        /// The reason.
        why: String,
    },
    /// A file of parameters is invalid.
    #[error("{path}: {why}; make it again: {remedy}")]
    Parameters {
        /// The file.
        path: PathBuf,
        /// The problem, and what was expected.
        why: String,
        /// The command that writes it.
        remedy: &'static str,
    },
    /// A point of the grid is invalid.
    #[error("a point of the grid ({point}): {why}")]
    Grid {
        /// Its differences from the defaults.
        point: String,
        /// The reason.
        why: String,
    },
    /// No formulas were fitted for a unit.
    #[error(
        "no formulas for this {unit}: {}; synthesise it: potamoi synth",
        difference(fields)
    )]
    NotFitted {
        /// The unit.
        unit: UnitKind,
        /// The fields in which it differs; none, if no formulas are of such units.
        fields: Vec<String>,
    },
    /// The netlist of a unit is invalid.
    #[error("the generated netlist is invalid: {0}")]
    Netlist(#[from] IrErrors),
    /// A temporary file cannot be written.
    #[error(
        "cannot write {path}: {source}; make room there, or name another folder of temporary \
         files in TMPDIR"
    )]
    Temporary {
        /// The file or folder.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// A cached file cannot be written.
    #[error(
        "cannot write {path}: {source}; make room (`potamoi cache --clear` removes what is kept), \
         or name another folder in POTAMOI_CACHE"
    )]
    File {
        /// The file or folder.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// There is no cache folder.
    #[error(transparent)]
    Cache(#[from] potamoi_verilated::Error),
    /// A program is broken, whatever its input.
    #[error("{tool} does not work ({unit}): {fault}; `potamoi doctor` lists the tools found")]
    Broken {
        /// Its name.
        tool: &'static str,
        /// The unit, or the request.
        unit: String,
        /// The fault.
        fault: potamoi_verilated::child::Fault,
    },
    /// A program failed on an input.
    #[error("{tool} failed on {unit}: {said}; {remedy}")]
    Tool {
        /// Its name.
        tool: &'static str,
        /// The unit, or the memory.
        unit: String,
        /// Last lines of its output.
        said: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// A program's output is not understood.
    #[error("{tool} printed no {what} for {unit}; {remedy}")]
    Output {
        /// Its name.
        tool: &'static str,
        /// The unit.
        unit: &'static str,
        /// The item looked for.
        what: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// A gate-level netlist cannot be simulated.
    #[error("the netlist of {unit} in cells of {library}: {problem}")]
    Gates {
        /// The unit.
        unit: String,
        /// The library's name.
        library: String,
        /// The problem.
        problem: String,
    },
    /// A gate-level simulation failed, or differs from the golden result.
    #[error(transparent)]
    Rtl(#[from] Box<potamoi_rtl::RtlError>),
}

/// Error of writing a cached file.
pub(crate) fn cannot_keep(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> SynthError {
    let path = path.to_owned();
    move |source| SynthError::File { path, source }
}

/// In what a unit differs from those that formulas are of.
fn difference(fields: &[String]) -> String {
    match fields {
        [] => "formulas are of gathering and vector units".to_owned(),
        fields => format!(
            "it differs from the synthesised ones in {}",
            fields.join(", ")
        ),
    }
}
