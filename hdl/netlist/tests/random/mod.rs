//! Random netlists mean the same to the interpreter, Verilator and Icarus.
//!
//! Many random modules stand side by side in one, so that the simulators build
//! once. `POTAMOI_SEED` picks others.

mod generate;
mod icarus;
mod stateful;
mod values;
mod wrapper;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use potamoi_netlist::{Header, Interpreter, Module, ranges, verilog};
use potamoi_verilated::{ModelBuilder, Opt, Toolchain, Warnings};

use crate::choices::Random;
use generate::{KINDS, Made, WIDTHS, class};

/// Nodes that are asked of a module; it has more, to feed them.
const NODES: usize = 12;

/// Cycles in which memories are filled, a row each, and a few more for what
/// is read from them, all in reset.
const INITIAL: usize = 12;

/// What is put in during a cycle.
pub(crate) struct Cycle {
    pub(crate) rst_n: bool,
    /// In the order of the input ports, low word first.
    pub(crate) inputs: Vec<Vec<u32>>,
}

fn seed() -> u64 {
    match std::env::var("POTAMOI_SEED") {
        Ok(text) => text.parse().unwrap_or_else(|e| {
            panic!("POTAMOI_SEED is `{text}` ({e}): expected a number below 2^64")
        }),
        Err(_) => 1,
    }
}

fn again(seed: u64) -> String {
    format!(
        "run it again with: POTAMOI_SEED={seed} cargo test -p potamoi-netlist --test netlist random::"
    )
}

fn stimulus(top: &Module, cycles: usize, random: &mut Random) -> Vec<Cycle> {
    let inputs: Vec<_> = top.ports().into_iter().filter(|p| !p.output).collect();
    let mut cycle = |i: usize| {
        let initial = i < INITIAL;
        let value = |p: &potamoi_netlist::PortInfo| match p.name.as_str() {
            "init" => vec![u32::from(initial)],
            "init_row" => vec![i as u32 % 8],
            // Mostly amounts about the widths: any others shift everything out.
            name if name.starts_with("amount_") && random.below(4) > 0 => {
                let mut words = vec![0; p.ty.width.div_ceil(32) as usize];
                let limit = p.ty.width.min(11);
                words[0] = random.below(1 << limit) as u32;
                words
            }
            _ => random.words(p.ty.width),
        };
        Cycle {
            // One more reset on the way.
            rst_n: !initial && i != cycles / 2,
            inputs: inputs.iter().map(value).collect(),
        }
    };
    (0..cycles).map(&mut cycle).collect()
}

/// The outputs of every cycle, as the interpreter has them.
fn interpreted(top: &Arc<Module>, stimulus: &[Cycle], seed: u64) -> Vec<Vec<String>> {
    let proven = ranges(top).unwrap_or_else(|e| panic!("{e}"));
    let mut run = Interpreter::new(top, seed).with_ranges(&proven).unwrap();
    let ports = top.ports();
    let rst_n = run.port("rst_n").unwrap();
    let handles: Vec<_> = ports
        .iter()
        .map(|p| (p, run.port(&p.name).unwrap()))
        .collect();
    let mut all = vec![];
    for cycle in stimulus {
        run.set_u64(rst_n, u64::from(cycle.rst_n)).unwrap();
        let inputs = handles.iter().filter(|(p, _)| !p.output);
        for ((_, h), words) in inputs.zip(&cycle.inputs) {
            run.set_words(*h, words).unwrap();
        }
        run.eval().unwrap_or_else(|e| panic!("{e}"));
        let outputs = handles.iter().filter(|(p, _)| p.output);
        all.push(
            outputs
                .map(|(p, h)| icarus::hex(&run.words(*h).unwrap(), p.ty.width))
                .collect(),
        );
        run.clock().unwrap_or_else(|e| panic!("{e}"));
    }
    all
}

/// The outputs of every cycle, as Verilator has them.
fn verilated(
    top: &Module,
    files: &BTreeMap<String, String>,
    stimulus: &[Cycle],
    folder: &Path,
) -> Vec<Vec<String>> {
    let tools = Toolchain::detect().unwrap_or_else(|e| panic!("{e}"));
    // Random netlists compare with constants and shift everything out.
    let mut builder = ModelBuilder::new(top.name())
        .optimise(Opt::O0)
        .warnings(Warnings::Allow)
        .cache_dir(folder.join("models"));
    for (name, text) in files {
        builder = builder.source(name, text);
    }
    let library = builder.build(&tools).unwrap_or_else(|e| panic!("{e}"));
    let mut model = library.model(7).unwrap();
    let (clk, rst_n) = (model.clock("clk").unwrap(), model.port("rst_n").unwrap());
    let ports = top.ports();
    let handles: Vec<_> = ports
        .iter()
        .map(|p| (p, model.port(&p.name).unwrap()))
        .collect();
    let mut all = vec![];
    for cycle in stimulus {
        model.set_u64(rst_n, u64::from(cycle.rst_n)).unwrap();
        let inputs = handles.iter().filter(|(p, _)| !p.output);
        for ((_, h), words) in inputs.zip(&cycle.inputs) {
            model.set_words(*h, words).unwrap();
        }
        model.fall(clk).unwrap();
        let outputs = handles.iter().filter(|(p, _)| p.output);
        all.push(
            outputs
                .map(|(p, h)| icarus::hex(&model.words(*h).unwrap(), p.ty.width))
                .collect(),
        );
        model.rise(clk).unwrap();
    }
    all
}

/// The first output that differs once everything is initialised.
fn differs(top: &Module, one: &[Vec<String>], other: &[Vec<String>]) -> Option<String> {
    let outputs: Vec<_> = top.ports().into_iter().filter(|p| p.output).collect();
    for (i, (a, b)) in one.iter().zip(other).enumerate().skip(INITIAL) {
        assert_eq!(a.len(), b.len());
        let mut ports = outputs.iter().zip(a.iter().zip(b));
        if let Some((port, (a, b))) = ports.find(|(_, (a, b))| a != b) {
            return Some(format!(
                "cycle {i}, {} ({}): {a} and {b}",
                port.name, port.ty
            ));
        }
    }
    None
}

fn random_netlists(seed: u64) -> (Arc<Module>, Made) {
    let mut random = Random::new(seed);
    let mut made = Made::new();
    let plan = generate::plan(&mut random);
    let modules: Vec<_> = plan
        .chunks(NODES)
        .enumerate()
        .map(|(i, nodes)| generate::module(&format!("random_{i}"), nodes, &mut random, &mut made))
        .collect();
    (wrapper::wrapper(&modules), made)
}

#[test]
fn every_kind_of_node_is_made_in_every_width() {
    let (_, made) = random_netlists(seed());
    for kind in KINDS {
        for width in WIDTHS {
            assert!(
                [false, true]
                    .iter()
                    .any(|s| made.contains(&(kind, width, *s))),
                "no {kind} of {width} bits"
            );
        }
        for of in ["small", "at 64", "wide"] {
            for signed in [false, true] {
                assert!(
                    made.iter()
                        .any(|(k, w, s)| (*k, class(*w), *s) == (kind, of, signed)),
                    "no {kind} of {of} width, signed: {signed}"
                );
            }
        }
    }
}

#[test]
fn all_simulators_agree() {
    let seed = seed();
    let (top, _) = random_netlists(seed);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("random_{seed}"));
    std::fs::create_dir_all(&folder).unwrap();
    let header = Header::default();
    let files = verilog(&top, &header);
    let cycles = stimulus(&top, 300, &mut Random::new(seed ^ 0x5eed));
    let own = interpreted(&top, &cycles, 11);
    let again = format!("\nthe Verilog is in {}\n{}", folder.display(), again(seed));
    let unseeded = interpreted(&top, &cycles, 12);
    if let Some(found) = differs(&top, &own, &unseeded) {
        panic!("the interpreter depends on what was never written: {found}{again}");
    }
    let few = &cycles[..80];
    let theirs = icarus::run(&top, &files, few, &folder);
    assert_eq!(theirs.len(), few.len(), "Icarus wrote too little{again}");
    if let Some(found) = differs(&top, &own, &theirs) {
        panic!("the interpreter and Icarus differ: {found}{again}");
    }
    let theirs = verilated(&top, &files, &cycles, &folder);
    if let Some(found) = differs(&top, &own, &theirs) {
        panic!("the interpreter and Verilator differ: {found}{again}");
    }
    assert_ne!(own[INITIAL], own[INITIAL + 1], "nothing moves");
    std::fs::remove_dir_all(&folder).unwrap();
}
