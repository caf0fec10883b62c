//! What can go wrong on the way from Verilog to cells.

use std::path::PathBuf;

use potamoi_netlist::IrErrors;
use thiserror::Error;

use super::unit_kind::UnitKind;

/// Where a program fails that has read a cell library.
pub(super) const CHECK_LIBRARY: &str = "check what the cell library says of its cells (the same \
    Verilog in another library tells whether it is at fault), then `potamoi doctor` for versions \
    that work";
/// Where it has read what Potamoi wrote alone.
pub(super) const CHECK_VERSIONS: &str = "see `potamoi doctor` for versions that work";

/// A synthesis that could not be done.
#[derive(Debug, Error)]
pub enum SynthError {
    /// A program is not here.
    #[error("{tool} is not here: {disables} needs it; to get it: {remedy}")]
    MissingTool {
        /// Its name.
        tool: &'static str,
        /// What it is needed for.
        disables: &'static str,
        /// How to get it.
        remedy: &'static str,
    },
    /// No library was named, and the default one is not installed.
    #[error(
        "no cell library: {path} is not here; name one with --liberty, or: apt-get install \
         qflow-tech-osu018"
    )]
    NoLibrary {
        /// Where the default library would be.
        path: PathBuf,
    },
    /// A file cannot be read.
    #[error("cannot read {path}: {source}; name a Liberty file, plain or packed with gzip")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file is no Liberty file.
    #[error("{path}, line {line}: expected {expected}, found {found}")]
    Liberty {
        /// The file.
        path: String,
        /// Line, from 1.
        line: usize,
        /// What would be right.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A library lacks what every netlist needs.
    #[error("{path}: no {what} among its {cells} cells; name a library of standard cells")]
    MissingCell {
        /// The file.
        path: PathBuf,
        /// What is missing.
        what: &'static str,
        /// How many cells there are.
        cells: usize,
    },
    /// A memory cannot be modelled.
    #[error("memory {memory}: {why}")]
    Memory {
        /// Its name.
        memory: String,
        /// Why.
        why: String,
    },
    /// A file of parameters is not what it should be.
    #[error("{path}: {why}; make it again: {remedy}")]
    Parameters {
        /// The file.
        path: PathBuf,
        /// What was found, and what was expected.
        why: String,
        /// The command.
        remedy: &'static str,
    },
    /// A point of the grid.
    #[error("a point of the grid ({point}): {why}")]
    Grid {
        /// What it has in place of the defaults.
        point: String,
        /// Why it cannot be one.
        why: String,
    },
    /// A unit that no formula was fitted for.
    #[error(
        "no formulas for this {unit}, which differs in more than numbers from those that were \
         synthesised: {}; synthesise it: potamoi synth",
        fields.join(", ")
    )]
    NotFitted {
        /// Which.
        unit: UnitKind,
        /// In which fields.
        fields: Vec<String>,
    },
    /// The netlist of a unit.
    #[error("the generated netlist is wrong: {0}")]
    Netlist(#[from] IrErrors),
    /// A temporary file.
    #[error(
        "cannot write {path}: {source}; make room there, or name another folder of temporary \
         files in TMPDIR"
    )]
    Temporary {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A kept file.
    #[error(
        "cannot write {path}: {source}; make room (`potamoi cache --clear` removes what is kept), \
         or name another folder in POTAMOI_CACHE"
    )]
    File {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// There is no folder for what is kept.
    #[error(transparent)]
    Cache(#[from] potamoi_verilated::Error),
    /// A program does not work, whatever its input is.
    #[error("{tool} does not work ({unit}): {fault}; `potamoi doctor` shows which tools are found")]
    Broken {
        /// Its name.
        tool: &'static str,
        /// The unit, or what it was asked.
        unit: String,
        /// What it did.
        fault: potamoi_verilated::child::Fault,
    },
    /// A program failed.
    #[error("{tool} failed on {unit}: {said}; {remedy}")]
    Tool {
        /// Its name.
        tool: &'static str,
        /// The unit, or the memory.
        unit: String,
        /// The last lines that it printed.
        said: String,
        /// What to look at.
        remedy: &'static str,
    },
    /// A program's output is not what it should be.
    #[error("{tool} printed no {what} for {unit}; {remedy}")]
    Output {
        /// Its name.
        tool: &'static str,
        /// The unit.
        unit: &'static str,
        /// What was looked for.
        what: String,
        /// What to look at.
        remedy: &'static str,
    },
    /// A netlist in cells that cannot be simulated.
    #[error("the netlist of {unit} in cells of {library}: {problem}")]
    Gates {
        /// The unit.
        unit: String,
        /// The library's name.
        library: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A simulation in cells failed, or found another result than the golden one.
    #[error(transparent)]
    Rtl(#[from] Box<potamoi_rtl::RtlError>),
}

/// An error of writing a kept file.
pub(crate) fn cannot_keep(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> SynthError {
    let path = path.to_owned();
    move |source| SynthError::File { path, source }
}
