//! Small netlists worked out by hand.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::sync::Arc;

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;
use crate::{Flop, Gate, Truth};

/// A combinational cell with output `Y`.
fn logic(name: &str, inputs: &[&str], function: &str) -> (String, Result<Gate, String>) {
    let gate = Gate {
        name: name.to_owned(),
        inputs: inputs.iter().map(|pin| (*pin).to_owned()).collect(),
        outputs: vec!["Y".to_owned()],
        functions: vec![Truth::parse(function, inputs).unwrap()],
        flop: None,
    };
    (name.to_owned(), Ok(gate))
}

/// Inverter, NAND, XOR and a flip-flop.
fn cells() -> BTreeMap<String, Result<Gate, String>> {
    let of = |text| Truth::parse(text, &["D", "IQ"]).unwrap();
    let flop = Gate {
        name: "DFF".to_owned(),
        inputs: vec!["D".to_owned()],
        outputs: vec!["Q".to_owned()],
        functions: vec![of("IQ")],
        flop: Some(Flop {
            clock: "CK".to_owned(),
            held: ["IQ".to_owned(), "IQN".to_owned()],
            next: of("D"),
        }),
    };
    BTreeMap::from([
        logic("INV", &["A"], "!A"),
        logic("NAND", &["A", "B"], "!(A B)"),
        logic("XOR", &["A", "B"], "A ^ B"),
        ("DFF".to_owned(), Ok(flop)),
    ])
}

fn flat(netlist: &str) -> Result<Arc<Flat>, String> {
    Flat::new(netlist, "top", &cells(), &BTreeMap::new()).map(Arc::new)
}

/// Counts of transitions by net, of outputs by pin, and of clocks.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
struct Counts {
    nets: BTreeMap<u32, u32>,
    inputs: u32,
    outputs: BTreeMap<(u32, u8), u32>,
    clocks: [u32; 2],
}

impl Watch for Counts {
    fn net(&mut self, net: u32) {
        *self.nets.entry(net).or_default() += 1;
    }
    fn input(&mut self, _: u32, _: u8, _: u16) {
        self.inputs += 1;
    }
    fn output(&mut self, cell: u32, _: u8, pin: u8, _: u16) {
        *self.outputs.entry((cell, pin)).or_default() += 1;
    }
    fn clock(&mut self, _: u32, _: u16, rises: bool) {
        self.clocks[usize::from(rises)] += 1;
    }
}

/// One delay for every pin, rising and falling, of each cell in order.
fn delays(flat: &Flat, each: &[u32]) -> Option<Arc<Delays>> {
    let (mut cells, mut from) = (vec![], vec![]);
    for (cell, delay) in (0..flat.cells.len() as u32).zip(each) {
        from.push(cells.len() as u32);
        let gate = flat.gate(cell);
        let causes = gate.flop.as_ref().map_or(gate.inputs.len(), |_| 1);
        cells.extend(vec![*delay; causes * gate.outputs.len() * 2]);
    }
    Some(Arc::new(Delays {
        cells,
        from,
        memory: 1,
    }))
}

fn port(flat: &Flat, name: &str) -> u32 {
    flat.ports.iter().find(|p| p.name == name).unwrap().nets[0]
}

/// `y` is 1 except for a moment after `a` rises.
const PULSE: &str = "module top(a, y);\n input a;\n output y;\n wire n;\n\
    INV i (.A(a), .Y(n));\n NAND g (.A(a), .B(n), .Y(y));\nendmodule\n";

#[test]
fn a_pulse_is_made_where_it_is_longer_than_its_cells_delay() {
    let flat = flat(PULSE).unwrap();
    let (a, y) = (port(&flat, "a"), port(&flat, "y"));
    // INV slower than NAND: y falls and rises; faster: the pulse is swallowed.
    for (each, expected, longest) in [
        (None, 0, 0),
        (Some([20, 5]), 2, 25),
        (Some([5, 20]), 0, 5),
        // As long as the delay: made.
        (Some([7, 6]), 2, 13),
    ] {
        let delays = each.and_then(|each| delays(&flat, &each));
        let mut simulator = Simulator::new(&flat, delays, 1, Counts::default()).unwrap();
        simulator.is_watched = true;
        simulator.set(a, true);
        simulator.settle().unwrap();
        let changes = |net: u32| simulator.watch.nets.get(&net).copied().unwrap_or(0);
        assert_eq!((changes(a), changes(y)), (1, expected), "{each:?}");
        assert!(simulator.value(y));
        assert_eq!(simulator.longest, longest, "{each:?}");
        if expected == 2 {
            // The fall is due to `a`, the rise to the inverter.
            let outputs = &simulator.watch.outputs;
            assert_eq!((outputs[&(1, 0)], outputs[&(1, 1)]), (1, 1));
        }
        // Falling, `a` makes none.
        simulator.watch = Counts::default();
        simulator.set(a, false);
        simulator.settle().unwrap();
        assert_eq!(simulator.watch.nets.get(&y), None, "{each:?}");
    }
}

/// A counter of two bits.
const COUNTER: &str = "module top(clk, q);\n input clk;\n output [1:0] q;\n wire [1:0] n;\n\
    bit low (.clk(clk), .carry(1'h1), .q(q[0]));\n\
    bit high (.clk(clk), .carry(q[0]), .q(q[1]));\nendmodule\n\
    module bit(clk, carry, q);\n input clk;\n input carry;\n output q;\n wire next;\n\
    XOR x (.A(q), .B(carry), .Y(next));\n DFF d (.CK(clk), .D(next), .Q(q));\nendmodule\n";

#[test]
fn a_counter_counts_and_its_movements_are_counted() {
    let flat = flat(COUNTER).unwrap();
    assert_eq!(flat.modules[1].name, "bit");
    assert_eq!((flat.modules[0].count, flat.modules[1].count), (1, 2));
    let bits = flat.ports[0].nets.clone();
    for delays in [None, delays(&flat, &[30, 10, 30, 10])] {
        for seed in 0..4 {
            let mut simulator =
                Simulator::new(&flat, delays.clone(), seed, Counts::default()).unwrap();
            simulator.is_watched = true;
            let read =
                |s: &Simulator<Counts>| u8::from(s.value(bits[0])) + 2 * u8::from(s.value(bits[1]));
            simulator.settle().unwrap();
            let first = read(&simulator);
            for i in 1..=8 {
                simulator.edge().unwrap();
                assert_eq!(read(&simulator), (first + i - 1) % 4, "before it settles");
                simulator.settle().unwrap();
                assert_eq!(read(&simulator), (first + i) % 4);
            }
            let nets = &simulator.watch.nets;
            assert_eq!((nets[&bits[0]], nets[&bits[1]]), (8, 4));
            assert_eq!((simulator.cycles, simulator.watch.clocks), (9, [18, 16]));
        }
    }
}

/// A chain of combinational cells, each reading earlier nets.
fn random_logic(random: &mut Pcg64Mcg, inputs: usize, cells: usize) -> String {
    let mut text = format!(
        "module top(a, y);\n input [{}:0] a;\n output [{}:0] y;\n",
        inputs - 1,
        cells - 1
    );
    for i in 0..cells {
        let mut net = || match random.random_range(0..inputs + i) {
            n if n < inputs => format!("a[{n}]"),
            n => format!("y[{}]", n - inputs),
        };
        let (a, b) = (net(), net());
        let kind = ["NAND", "XOR", "INV"][random.random_range(0..3)];
        text += &match kind {
            "INV" => format!("INV c{i} (.A({a}), .Y(y[{i}]));\n"),
            _ => format!("{kind} c{i} (.A({a}), .B({b}), .Y(y[{i}]));\n"),
        };
    }
    text + "endmodule\n"
}

#[test]
fn delays_change_what_moves_but_not_where_it_ends() {
    let mut random = Pcg64Mcg::seed_from_u64(8);
    let (mut moved, mut with_delays) = (0, 0);
    for _ in 0..20 {
        let flat = flat(&random_logic(&mut random, 6, 40)).unwrap();
        let each: Vec<u32> = (0..40).map(|_| random.random_range(1..30)).collect();
        let new = |delays| Simulator::new(&flat, delays, 0, Counts::default()).unwrap();
        let mut pair = [new(None), new(delays(&flat, &each))];
        for _ in 0..30 {
            for net in &flat.ports[0].nets {
                let value = random.random();
                pair.iter_mut().for_each(|s| s.set(*net, value));
            }
            for simulator in &mut pair {
                simulator.is_watched = true;
                simulator.settle().unwrap();
            }
            for net in 0..flat.nets() as u32 {
                assert_eq!(pair[0].value(net), pair[1].value(net));
            }
        }
        for (net, changes) in &pair[0].watch.nets {
            // What ends elsewhere moved, and an odd number of times in all.
            let other = pair[1].watch.nets[net];
            assert!(other >= *changes && (other - changes) % 2 == 0, "{net}");
        }
        let sum = |s: &Simulator<Counts>| s.watch.nets.values().sum::<u32>();
        moved += sum(&pair[0]);
        with_delays += sum(&pair[1]);
    }
    assert!(with_delays > moved + moved / 10, "{moved}, {with_delays}");
}

#[test]
fn netlists_that_cannot_be_run_are_named() {
    for (from, to, expected) in [
        (
            "NAND g",
            "NOR g",
            "NOR in module top: neither a module, a memory nor a cell",
        ),
        (".B(n)", ".C(n)", "pin B is not connected"),
        (
            "INV i (.A(a), .Y(n));",
            "",
            "an input of a NAND in module top has no driver",
        ),
        (".A(a), .Y(n)", ".A(y), .Y(n)", "depends on its own output"),
        (".Y(n)", ".Y(a)", "two drivers"),
        ("module top", "module bottom", "expected a module top"),
        (
            "INV i (.A(a), .Y(n))",
            "DFF d (.CK(a), .D(a), .Q(n))",
            "another net than the port clk",
        ),
        (
            "INV i (.A(a), .Y(n))",
            "top t (.a(a), .y(n))",
            "holds itself",
        ),
    ] {
        let text = PULSE.replace(from, to);
        assert_ne!(text, PULSE);
        let found = flat(&text).unwrap_err();
        assert!(found.contains(expected), "{found}");
    }
}
