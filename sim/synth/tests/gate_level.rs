//! The units' netlists in cells against golden values and cycle models: every output bit
//! and every cycle.
//!
//! The netlist and the cells' functions are run by a simulator that shares nothing with
//! this project: Yosys reads the functions from the library, Icarus Verilog or Verilator
//! runs them. Icarus has unknown values: a flip-flop that reset does not set and that
//! matters would show. The project's own netlist simulator, which power comes from, is
//! then held against the same values on the same work.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../../rtl/tests/rtl/gather_common.rs"]
mod gather_common;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use potamoi_cycles::Stalls;
use potamoi_formats::config::Config;
use potamoi_formats::rit::Vertices;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_netlist::{Header, Module, verilog};
use potamoi_reference::observer::Observed;
use potamoi_reference::vector_unit::ReferenceVectorUnit;
use potamoi_reference::{GatherTask, ReferenceUnits, Units};
use potamoi_rtl::{Check, EngineKind, GatherUnit, RtlError, VectorBatch, VectorUnit};
use potamoi_synth::{
    Library, Sampler, SynthError, Tools, UnitKind, Verified, cell_functions, default_library,
    netlist, verify_netlist,
};
use potamoi_units::array_mac::array_mac;
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::splat_unit::splat_unit;
use potamoi_units::vector_unit::vector_unit;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use gather_common::{expected, held_up, task};

/// Eight cells of the project's own.
fn handful() -> Library {
    Library::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("cells/handful.lib")).unwrap()
}

/// Yosys, and the folder of what it made earlier.
fn tools() -> (Tools, PathBuf) {
    let cache = potamoi_verilated::cache::folder("synth").unwrap();
    (Tools::yosys_alone().unwrap(), cache)
}

/// A unit in cells.
struct InCells<'a> {
    config: Config,
    unit: UnitKind,
    library: &'a Library,
    netlist: String,
    functions: String,
}

impl<'a> InCells<'a> {
    fn new(text: &str, unit: UnitKind, library: &'a Library) -> Self {
        let config = Config::from_toml(text, "test").unwrap();
        let (tools, cache) = tools();
        let module = module(&config, unit);
        Self {
            netlist: netlist(&module, unit.top(), library, &tools, &cache).unwrap(),
            functions: cell_functions(library, &tools, &cache).unwrap(),
            config,
            unit,
            library,
        }
    }

    /// Verilog of the whole: cells, their functions, and memories as they were emitted.
    fn files(&self) -> BTreeMap<String, String> {
        let module = module(&self.config, self.unit);
        let memories = module.memory_modules();
        let is_memory = |file: &str| memories.contains_key(file.trim_end_matches(".v"));
        let all = verilog(&module, &Header::default()).into_iter();
        let mut files: BTreeMap<_, _> = all.filter(|(file, _)| is_memory(file)).collect();
        files.insert("netlist.v".to_owned(), self.netlist.clone());
        files.insert("cells.v".to_owned(), self.functions.clone());
        files
    }

    fn own(&self, sampler: &Sampler) -> Result<Verified, SynthError> {
        verify_netlist(
            &self.config,
            self.unit,
            self.library,
            &self.netlist,
            sampler,
        )
    }
}

fn module(config: &Config, unit: UnitKind) -> Arc<Module> {
    match unit {
        UnitKind::Gathering => gathering_unit(config).unwrap(),
        UnitKind::Vector => vector_unit(config).unwrap(),
        UnitKind::ArrayMac => array_mac().unwrap(),
        UnitKind::Splat => splat_unit(config, config.su.as_ref().unwrap()).unwrap(),
    }
}

fn conditions(stalls: Stalls, seed: u64) -> Check<'static> {
    Check {
        stalls,
        seed,
        flags: 0,
        progress: Box::leak(Box::new(|_| {})),
    }
}

/// MVoxels of random rows and entries, and what must come of them.
fn tasks(config: &Config, seed: u64, sizes: &[[usize; 2]]) -> (Vec<GatherTask>, Vec<i16>) {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let banks = config.gu.banks as usize;
    let mut task = |[rows, entries]: &[usize; 2]| {
        task(&mut random, config, Vertices::Eight, banks, *rows, *entries)
    };
    let tasks: Vec<_> = sizes.iter().map(&mut task).collect();
    let features = tasks.iter().flat_map(|t| expected(config, t)).collect();
    (tasks, features)
}

/// Runs the gathering unit's netlist on an engine.
fn gather(
    cells: &InCells<'_>,
    engine: EngineKind,
    (tasks, features): &(Vec<GatherTask>, Vec<i16>),
    stalls: Stalls,
    seed: u64,
) -> Result<u64, RtlError> {
    let unit = GatherUnit::of_files(engine, &cells.config, &cells.files()).unwrap();
    let check = conditions(stalls, seed);
    Ok(unit.check(&cells.config, tasks, features, check)?.cycles)
}

fn sampled(config: &Config, tasks: &[GatherTask]) -> Sampler {
    let mut sampler = Sampler::new(config);
    let mut twins = ReferenceUnits::new(config);
    let mut units = Observed::new(&mut twins, config).by(&mut sampler);
    units.gather(tasks, &mut vec![]).unwrap();
    sampler
}

/// Gives one cell of a module that makes a bit of its `result` another function: the
/// netlist is another one.
fn mutated(netlist: &str, module: &str) -> String {
    // The same pins each.
    let swaps = [
        ("  NAND2 ", "  NOR2 "),
        ("  NOR2 ", "  NAND2 "),
        ("  INV ", "  BUF "),
        ("  BUF ", "  INV "),
    ];
    let start = netlist.find(&format!("module {module}(")).unwrap();
    let end = start + netlist[start..].find("endmodule").unwrap();
    let swapped = |bit: usize| {
        let pin = start + netlist[start..end].find(&format!(".Y(result[{bit}])"))?;
        let line = netlist[..pin].rfind(" (\n")?;
        let line = netlist[..line].rfind('\n')? + 1;
        if netlist[line..].starts_with("  AOI21 ") {
            // Not (A and B or C), with C stuck at 1.
            let net = line + netlist[line..pin].find(".C(")? + 3;
            let end = net + netlist[net..].find(')')?;
            return Some(format!("{}1'h1{}", &netlist[..net], &netlist[end..]));
        }
        let swap = swaps
            .iter()
            .find(|(from, _)| netlist[line..].starts_with(from));
        let (from, to) = swap?;
        let rest = &netlist[line + from.len()..];
        Some(format!("{}{to}{rest}", &netlist[..line]))
    };
    (0..16).find_map(swapped).unwrap()
}

const FOUR_BANKS: &str = "[rit]\nentries = 16\n[gu]\nbanks = 4\nports = 1\nfifo_depth = 4\n\
    counter_bits = 16\nmodes = \"structured\"\nvertices = [8]\n";
const ONE_LANE: &str = "[vu]\nlanes = 1\nops = [\"exp\", \"one-minus-exp\"]\n";

#[test]
fn a_gathering_unit_of_four_banks_computes_the_same_in_cells() {
    let library = handful();
    let mut cells = InCells::new(FOUR_BANKS, UnitKind::Gathering, &library);
    let work = tasks(&cells.config, 3, &[[9, 5], [4, 1]]);
    let cycles = gather(&cells, EngineKind::Icarus, &work, Stalls::NONE, 1).unwrap();
    assert!(cycles > 48, "{cycles}");

    // With and without delays, and on more of it.
    let work = tasks(&cells.config, 4, &[[40, 60], [1, 1], [60, 90]]);
    let own = cells.own(&sampled(&cells.config, &work.0)).unwrap();
    // Of each at most 64.
    assert_eq!((own.runs, own.items), (2, 125));

    cells.netlist = mutated(&cells.netlist, "reducer");
    let work = tasks(&cells.config, 3, &[[4, 2]]);
    let found = gather(&cells, EngineKind::Icarus, &work, Stalls::NONE, 1);
    assert!(matches!(found, Err(RtlError::Mismatch(_))), "{found:?}");
    let found = cells.own(&sampled(&cells.config, &work.0)).unwrap_err();
    assert!(matches!(&found, SynthError::Rtl(e) if matches!(**e, RtlError::Mismatch(_))));
}

/// Exponentials, and what must come of them.
fn exponentials(config: &Config, count: usize) -> [Vec<i32>; 3] {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let a: Vec<i32> = (0..count)
        .map(|_| random.random_range(0..1 << 16))
        .collect();
    let (b, mut out) = (vec![0; count], vec![0; count]);
    let twin = ReferenceVectorUnit::new(&config.vu);
    twin.slice(VectorOp::new(OpCode::Exp), &a, &b, &mut out)
        .unwrap();
    [a, b, out]
}

fn compute(cells: &InCells<'_>, engine: EngineKind, work: &[Vec<i32>; 3]) -> Result<u64, RtlError> {
    let unit = VectorUnit::of_files(engine, &cells.config, &cells.files()).unwrap();
    let batch = VectorBatch {
        op: VectorOp::new(OpCode::Exp),
        a: &work[0],
        b: &work[1],
    };
    let check = conditions(Stalls::NONE, 1);
    Ok(unit.check(&cells.config, &[batch], &work[2], check)?.cycles)
}

#[test]
fn a_lane_computes_the_same_in_cells() {
    let library = handful();
    let mut cells = InCells::new(ONE_LANE, UnitKind::Vector, &library);
    let work = exponentials(&cells.config, 12);
    let cycles = compute(&cells, EngineKind::Icarus, &work).unwrap();
    assert!(cycles > 12 * 20, "{cycles}");

    let mut sampler = Sampler::new(&cells.config);
    let [a, b, _] = exponentials(&cells.config, 64);
    let op = VectorOp::new(OpCode::Exp);
    let mut twins = ReferenceUnits::new(&cells.config);
    let mut units = Observed::new(&mut twins, &cells.config).by(&mut sampler);
    units.vector(op, &a, &b, &mut [0; 64]).unwrap();
    let own = cells.own(&sampler).unwrap();
    assert_eq!((own.runs, own.items), (2, 64));

    cells.netlist = mutated(&cells.netlist, "vector_lane");
    let found = compute(&cells, EngineKind::Icarus, &work);
    assert!(matches!(found, Err(RtlError::Mismatch(_))), "{found:?}");
    let found = cells.own(&sampler).unwrap_err();
    assert!(matches!(&found, SynthError::Rtl(e) if matches!(**e, RtlError::Mismatch(_))));
}

/// Products of the features that were gathered, four channels of each sample.
#[test]
fn a_unit_of_the_array_computes_the_same_in_cells() {
    let library = handful();
    let mut cells = InCells::new(FOUR_BANKS, UnitKind::ArrayMac, &library);
    let work = tasks(&cells.config, 3, &[[9, 5], [4, 1]]);
    let sampler = sampled(&cells.config, &work.0);
    let own = cells.own(&sampler).unwrap();
    // A weight takes a cycle to load.
    assert_eq!(
        (own.runs, own.items, own.cycles),
        (2, 4 * 6, 2 * (4 * 6 + 4 + 1))
    );
    cells.netlist = cells.netlist.replacen("  NAND2 ", "  NOR2 ", 1);
    let found = cells.own(&sampler).unwrap_err().to_string();
    assert!(found.contains("array_mac: "), "{found}");
}

/// Libraries of foundries' kind, under Verilator, with stalls too.
#[test]
#[ignore = "exhaustive; run with make test-full"]
fn units_in_other_libraries_compute_the_same() {
    let mut libraries = vec![Library::read(&default_library().unwrap()).unwrap()];
    let shared = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
        PathBuf::from,
    );
    let asap7 = shared.join("data/liberty/asap7_rvt_tt_62cells.lib.gz");
    match asap7.is_file() {
        true => libraries.push(Library::read(&asap7).unwrap()),
        false => println!("skipped: ASAP7: no shared data (set POTAMOI_SHARED)"),
    }
    for library in &libraries {
        let cells = InCells::new("[gu]\nbanks = 4\n", UnitKind::Gathering, library);
        let work = tasks(
            &cells.config,
            6,
            &[[200, 150], [20, 1], [100, 300], [512, 40]],
        );
        for (seed, stalls) in [
            (1, Stalls::NONE),
            (2, held_up(&mut Pcg64Mcg::seed_from_u64(2))),
        ] {
            gather(&cells, EngineKind::Verilator, &work, stalls, seed)
                .unwrap_or_else(|e| panic!("{}: {e}", library.name));
        }
        cells.own(&sampled(&cells.config, &work.0)).unwrap();

        let cells = InCells::new("[vu]\nlanes = 1\n", UnitKind::Vector, library);
        let work = exponentials(&cells.config, 3000);
        compute(&cells, EngineKind::Verilator, &work)
            .unwrap_or_else(|e| panic!("{}: {e}", library.name));
    }
}
