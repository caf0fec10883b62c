//! The units' netlists in cells against golden values and cycle models: every output bit
//! and every cycle, under Verilog simulators with the cells' functions as Yosys reads
//! them from the library.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod gather_common;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use gather_common::{expected, held_up, task};
use potamoi_formats::config::Config;
use potamoi_formats::rit::Vertices;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_golden::units::vu::VectorTwin;
use potamoi_hdl::gu::gathering_unit;
use potamoi_hdl::ir::{Header, Module, verilog};
use potamoi_hdl::vu::vector_unit;
use potamoi_sim::cycles::Stalls;
use potamoi_sim::rtl::{Check, EngineKind, GatherUnit, RtlError, VectorBatch, VectorUnit};
use potamoi_sim::synth::{Library, Tools, cell_functions, netlist};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn main_cells() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("cells/handful.lib")
}

fn cache() -> PathBuf {
    potamoi_verilated::default_cache_folder().unwrap().with_file_name("synth")
}

fn files(module: &std::sync::Arc<Module>, library: &Library) -> BTreeMap<String, String> {
    let tools = Tools::yosys_alone().unwrap();
    let t = Instant::now();
    let cells = netlist(module, "unit", library, &tools, &cache()).unwrap();
    eprintln!("yosys {:?}", t.elapsed());
    let functions = cell_functions(library, &tools, &cache()).unwrap();
    let memories = module.memory_modules();
    let mut files: BTreeMap<_, _> = verilog(module, &Header::default())
        .into_iter()
        .filter(|(file, _)| memories.contains_key(file.trim_end_matches(".v")))
        .collect();
    files.insert("netlist.v".to_owned(), cells);
    files.insert("cells.v".to_owned(), functions);
    files
}

#[test]
fn try_it() {
    let library = Library::read(&main_cells()).unwrap();
    let config = Config::from_toml("[gu]\nbanks = 4\nports = 2\n[rit]\nentries = 16", "test").unwrap();
    let module = gathering_unit(&config).unwrap();
    let files = files(&module, &library);
    let mut random = Pcg64Mcg::seed_from_u64(3);
    let tasks: Vec<_> = (0..3).map(|_| task(&mut random, &config, Vertices::Eight, 4, 30, 20)).collect();
    let wanted: Vec<i16> = tasks.iter().flat_map(|t| expected(&config, t)).collect();
    for engine in [EngineKind::Icarus, EngineKind::Verilator] {
        let t = Instant::now();
        let unit = GatherUnit::of_files(engine, &config, &files).unwrap();
        eprintln!("{engine} built {:?}", t.elapsed());
        let t = Instant::now();
        let totals = unit.check(&config, &tasks, &wanted, Check { stalls: Stalls::NONE, seed: 1, flags: 0, progress: &mut |_| {} }).unwrap();
        eprintln!("{engine} {:?} {totals:?}", t.elapsed());
    }
}
