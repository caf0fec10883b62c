//! What a digest depends on, over random modules with every kind of node.

#![allow(clippy::unwrap_used)]

mod changes;
mod random;

use std::collections::BTreeSet;
use std::sync::Arc;

use super::*;
use crate::node::Op;
use crate::{Change, Fault, ModuleBuilder, Ty, check};
use changes::{operands, otherwise_built, renamed};
use random::{child, random};

const SEEDS: std::ops::Range<u64> = 0..60;

/// A number for each operation; a new one does not compile until it has one, and is then asked of
/// the random modules.
const fn kind(op: &Op) -> usize {
    match op {
        Op::Input => 0,
        Op::OutOfReset => 1,
        Op::Lit(_) => 2,
        Op::Unary(..) => 3,
        Op::Binary(..) => 4,
        Op::Shl(..) => 5,
        Op::Shr(..) => 6,
        Op::Slice(..) => 7,
        Op::Cat(_) => 8,
        Op::Repeat(..) => 9,
        Op::Extend(_) => 10,
        Op::Cast(_) => 11,
        Op::Round(..) => 12,
        Op::Saturate(_) => 13,
        Op::Mux(..) => 14,
        Op::Select(..) => 15,
        Op::Reg { reset: Some(_), .. } => 16,
        Op::Reg { reset: None, .. } => 20,
        Op::ReadSync(..) => 17,
        Op::ReadAsync(..) => 18,
        Op::InstanceOut(..) => 19,
    }
}
const KINDS: usize = 21;

#[test]
fn random_modules_have_every_kind_and_differ() {
    let (mut kinds, mut digests) = (BTreeSet::new(), BTreeSet::new());
    for seed in SEEDS {
        let module = random(seed);
        let live = check::live(&module);
        let nodes = module.nodes.iter().zip(live).filter(|(_, live)| *live);
        kinds.extend(nodes.map(|(node, _)| kind(&node.op)));
        assert!(digests.insert(module.digest().to_string()), "{seed}");
        assert_eq!(module.digest(), random(seed).digest());
    }
    assert_eq!(kinds, (0..KINDS).collect());
}

#[test]
fn names_comments_and_the_order_of_building_change_nothing() {
    for seed in SEEDS {
        let module = random(seed);
        let digest = module.digest();
        assert_eq!(renamed(&module).digest(), digest, "{seed}: names");
        let other = otherwise_built(&module, seed);
        assert_eq!(other.digest(), digest, "{seed}: order");
        assert_eq!(renamed(&other).digest(), digest, "{seed}: both");
    }
}

/// Every operand, number, operator and type of every live node, one at a time.
#[test]
fn each_part_of_a_live_node_counts() {
    for seed in SEEDS {
        let module = random(seed);
        let (digest, live) = (module.digest(), check::live(&module));
        for id in (0..module.nodes.len()).filter(|id| live[*id]) {
            for (what, changed) in changes::of_node(&module, id) {
                assert_ne!(changed.digest(), digest, "{seed}: node {id}: {what}");
            }
        }
        let dead = (0..module.nodes.len()).filter(|id| !live[*id]);
        for id in dead.filter(|id| !matches!(module.nodes[*id].op, Op::Input)) {
            for (what, changed) in changes::of_node(&module, id) {
                assert_eq!(changed.digest(), digest, "{seed}: dead node {id}: {what}");
            }
        }
    }
}

#[test]
fn ports_memories_and_instances_count() {
    for seed in SEEDS {
        let module = random(seed);
        let digest = module.digest();
        for (what, changed) in changes::of_parts(&module) {
            assert_ne!(changed.digest(), digest, "{seed}: {what}");
        }
    }
}

#[test]
fn the_operands_of_an_operator_are_in_order() {
    type Make = fn(&mut ModuleBuilder, crate::Signal, crate::Signal) -> crate::Signal;
    let operators: [Make; 6] = [
        ModuleBuilder::sub,
        ModuleBuilder::lt,
        ModuleBuilder::le,
        ModuleBuilder::shl,
        ModuleBuilder::shr,
        |m, a, b| m.cat(&[a, b]),
    ];
    let of = |make: Make, is_swapped: bool| {
        let mut m = ModuleBuilder::new("operands");
        let (a, b) = (m.input("a", Ty::u(8), ""), m.input("b", Ty::u(8), ""));
        let (a, b) = if is_swapped { (b, a) } else { (a, b) };
        let made = make(&mut m, a, b);
        m.output("o", made, "");
        m.finish().unwrap().digest().to_string()
    };
    let mut all = BTreeSet::new();
    for make in operators {
        for is_swapped in [false, true] {
            assert!(all.insert(of(make, is_swapped)));
        }
    }
}

/// A later write to the same row has priority.
#[test]
fn the_writes_of_a_memory_are_in_order() {
    let of = |is_swapped: bool| {
        let mut m = ModuleBuilder::new("two_writes");
        let [on, row] = [("on", 1), ("row", 2)].map(|(name, w)| m.input(name, Ty::u(w), ""));
        let mut data = ["a", "b"].map(|name| m.input(name, Ty::u(8), ""));
        if is_swapped {
            data.reverse();
        }
        let rows = m.memory("rows", 4, 8, "");
        for data in data {
            m.mem_write(rows, on, row, data);
        }
        let read = m.mem_read(rows, on, row, "read");
        m.output("o", read, "");
        m.finish().unwrap().digest()
    };
    assert_ne!(of(false), of(true));
}

/// Faults of registers, in the top module and in one below.
#[test]
fn a_fault_changes_the_digests_of_its_module_and_of_those_above() {
    for seed in SEEDS {
        let top = random(seed);
        let digests = top.digests();
        for module in ["random", "child"] {
            let register = match module {
                "child" => "held",
                _ => "state_0",
            };
            for change in [Change::Invert(1), Change::ResetBit(0)] {
                let fault = Fault {
                    module: module.to_owned(),
                    register: register.to_owned(),
                    change,
                };
                // A register that nothing reads is no part of the netlist.
                let Ok(faulty) = fault.inject(&top) else {
                    continue;
                };
                let found = faulty.digests();
                assert_eq!(
                    found.keys().collect::<Vec<_>>(),
                    digests.keys().collect::<Vec<_>>()
                );
                for (name, digest) in &found {
                    let is_changed = name == module || name == "random";
                    assert_eq!(
                        *digest != digests[name],
                        is_changed,
                        "{seed}: {name}: {fault:?}"
                    );
                }
            }
        }
    }
}

/// A module above depends on the digest of the one below alone: not on its name.
#[test]
fn a_module_changes_where_its_instance_does() {
    let above = |child: &Arc<Module>| {
        let mut m = ModuleBuilder::new("above");
        let d = m.input("d", Ty::u(8), "");
        let own = m.instance("own", child, &[("d", d)]);
        let q = m.out(own, "q");
        m.output("q", q, "");
        m.finish().unwrap().digest()
    };
    let digest = above(&child("child", 3));
    assert_eq!(above(&child("another_name", 3)), digest);
    assert_ne!(above(&child("child", 4)), digest);
}

/// An alias of a value, and a constant that is made twice.
#[test]
fn a_second_name_for_a_value_is_no_node() {
    let of = |is_named: bool| {
        let mut m = ModuleBuilder::new("named");
        let a = m.input("a", Ty::u(8), "");
        let (one, other) = (m.lit(1, Ty::u(8)), m.lit(1, Ty::u(8)));
        let mut sum = m.add(a, one);
        let twice = if is_named {
            sum = m.name(sum, "sum");
            let alias = m.name(sum, "total");
            let one = m.param("ONE", 1, Ty::u(8), "");
            m.sub(alias, one)
        } else {
            m.sub(sum, other)
        };
        let both = m.xor(sum, twice);
        m.output("o", both, "");
        m.finish().unwrap().digest()
    };
    assert_eq!(of(false), of(true));
}

/// The digest in files and caches of earlier runs and other machines.
#[test]
fn a_digest_is_the_same_everywhere() {
    let digests = [child("child", 3).digest(), random(1).digest()];
    assert_eq!(
        digests.map(|d| d.to_string()),
        ["10bcf8cda0de1c4e", "db44fa93d52d3eb0"]
    );
}

/// Operands of a node as numbers that can be changed.
fn count_of_operands(op: &Op) -> usize {
    operands(&mut op.clone()).len()
}

#[test]
fn every_operand_of_a_kind_is_known_to_the_changes() {
    for seed in SEEDS {
        for node in &random(seed).nodes {
            let known = node.op.operands().len() + node.op.edge_operands().len();
            assert_eq!(count_of_operands(&node.op), known, "{:?}", node.op);
        }
    }
}
