//! Synthesis of units to cells of a library: area by module, and the longest path.
//!
//! Yosys and ABC map the emitted Verilog module by module, and OpenSTA times the netlist of the
//! whole unit. Memories are excluded, as macros of a memory compiler. Wires and the clock tree are
//! excluded too: areas are those of cells, and the period is that before placement. Inputs arrive
//! at the clock edge from the library's smallest buffer, and outputs are loaded with four of its
//! inputs. Paths that begin or end in a memory are not timed.
//!
//! [`synthesise`] synthesises a unit, and [`estimate`] simulates its cells for the power. [`grid`]
//! contains many syntheses, to which [`fit`] fits formulas. [`scaling`] converts figures between
//! process nodes.
//!
//! # Example
//!
//! Area and period of the paper's vector unit by the built-in formulas, without running a tool.
//!
//! ```
//! use potamoi_formats::config::Config;
//! use potamoi_synth::fit::Fit;
//! use potamoi_synth::{UnitKind, scaling};
//!
//! let (fit, config) = (Fit::checked_in()?, Config::paper());
//! let family = fit.family(&config, UnitKind::Vector)?;
//! let work = fit.usual_work(family, &config);
//! let at_7_nm = fit.estimate(&config, UnitKind::Vector, work)?;
//! let at_12_nm = at_7_nm.scaled(&scaling::logic(7, 12).unwrap());
//! assert!(at_12_nm.area_um2 > at_7_nm.area_um2);
//! assert!((500.0..2000.0).contains(&at_7_nm.period_ps));
//! # Ok::<(), potamoi_synth::SynthError>(())
//! ```

mod attributes;
mod cache_keys;
mod cacti;
mod cell_gates;
mod error;
mod fanout;
pub mod fit;
mod fpga;
pub mod grid;
mod liberty;
mod library;
mod mapped_netlist;
mod memories;
mod memory_paths;
mod memory_table;
mod netlist;
mod netlist_digests;
mod parameters;
mod path_ends;
mod physical_units;
mod power;
mod power_report;
pub mod published_cells;
mod report;
mod retime;
pub mod scaling;
mod script;
pub mod study;
mod table_checks;
pub mod toolbox;
mod tools;
mod unit;
mod unit_kind;
mod unit_report;
mod work_folder;

pub use cacti::{Cacti, Figures, Settings, Shape};
pub use error::SynthError;
pub use fpga::{
    FORMAT_VERSION as FPGA_FORMAT_VERSION, FpgaReport, FpgaTools, FpgaUnit, Part, place_and_route,
};
pub use library::{Cell, Library};
pub use mapped_netlist::{cell_functions, netlist};
pub use memories::{Memories, MemoryReport, SYSTEM, macros, model, system};
pub use memory_paths::{access_times, with_memories};
pub use memory_table::MemoryTable;
pub use netlist::{MemoryArea, ModuleArea};
pub use netlist_digests::NetlistDigests;
pub use parameters::Synthesised;
pub use path_ends::{PathEnd, path_ends};
pub use power::{
    Estimated, Extent, GatherWindow, Order, POWER_STEPS, Sampler, SplatWindow, VectorWindow,
    Verified, Windows, estimate, verify_netlist,
};
pub use power_report::{Activity, Figures as PowerFigures, ModulePower, Power, PowerReport};
pub use report::{
    FORMAT_VERSION as REPORT_FORMAT_VERSION, LibraryOrigin, Raw, Scaled, ScaledEnergy, ScaledLogic,
    ScaledMemories, ScaledMemory, ScaledUnit, SynthReport, ToolsOrigin, differences,
};
pub use tools::Tools;
pub use unit::{STEPS, SynthesisedUnit, synthesise};
pub use unit_kind::UnitKind;
pub use unit_report::{FlopMemory, UnitReport, WithMemories};

use std::path::PathBuf;

/// The cell library that a package installs: Oklahoma State University, 180 nm.
pub(crate) const DEFAULT_LIBRARY: &str = "/usr/share/qflow/tech/osu018/osu018_stdcells.lib";

/// The default library, if it is installed.
///
/// # Errors
/// It is not; the error says which package has it.
pub fn default_library() -> Result<PathBuf, SynthError> {
    let path = PathBuf::from(DEFAULT_LIBRARY);
    match path.is_file() {
        true => Ok(path),
        false => Err(SynthError::NoLibrary { path }),
    }
}
