//! Buffer trees drive every pin, and no driver exceeds its limits.
#![allow(clippy::unwrap_used)]

use serde_json::{Map, Value, json};

use super::*;

const LIBRARY: &str = "library (t) { time_unit : \"1ps\"; capacitive_load_unit (1, ff);\n\
    cell (INV) { area : 1; pin (A) { direction : input; capacitance : 1; } \
    pin (Y) { direction : output; max_capacitance : 40; function : \"!A\"; } }\n\
    cell (BUF) { area : 2; pin (A) { direction : input; capacitance : 0.5; } \
    pin (Y) { direction : output; max_capacitance : 80; function : \"A\"; } }\n\
    cell (BUFX4) { area : 4; pin (A) { direction : input; capacitance : 0.8; } \
    pin (Y) { direction : output; max_capacitance : 320; function : \"A\"; } }\n\
    cell (NAND) { area : 2; pin (A) { direction : input; } pin (B) { direction : input; } \
    pin (Y) { direction : output; function : \"!(A B)\"; } }\n\
    cell (DFF) { area : 5; ff (IQ, IQN) { next_state : \"D\"; clocked_on : \"CK\"; } \
    pin (D) { direction : input; capacitance : 1; } \
    pin (CK) { direction : input; capacitance : 1; } \
    pin (Q) { direction : output; max_capacitance : 40; function : \"IQ\"; } }\n}\n";

fn library() -> Library {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.lib");
    std::fs::write(&path, LIBRARY).unwrap();
    Library::read(&path).unwrap()
}

fn cell(kind: &str, pins: &[(&str, u64)]) -> Value {
    let pins = pins
        .iter()
        .map(|(pin, net)| ((*pin).to_owned(), json!([net])));
    json!({"type": kind, "connections": pins.collect::<Map<_, _>>()})
}

/// A flip-flop that drives `children` modules, each with `pins` inverters at the port; all
/// flip-flops are clocked.
fn design(children: u64, pins: u64) -> String {
    let port = |direction: &str, net: u64| json!({"direction": direction, "bits": [net]});
    let mut inside = Map::new();
    for i in 0..pins {
        inside.insert(format!("i{i}"), cell("INV", &[("A", 2), ("Y", 10 + i)]));
        inside.insert(
            format!("f{i}"),
            cell("DFF", &[("D", 10 + i), ("CK", 3), ("Q", 10 + pins + i)]),
        );
    }
    let mut above = Map::new();
    above.insert("flop".into(), cell("DFF", &[("D", 4), ("CK", 3), ("Q", 5)]));
    for i in 0..children {
        above.insert(format!("c{i}"), cell("child", &[("in", 5), ("clk", 3)]));
    }
    let modules = json!({
        "child": {"ports": {"in": port("input", 2), "clk": port("input", 3)}, "cells": inside},
        "top": {"ports": {"clk": port("input", 3), "d": port("input", 4)}, "cells": above},
    });
    json!({"creator": "test", "modules": modules}).to_string()
}

/// Fan-out of each net of a module to cells and modules, and the net before a buffer.
fn loads(module: &Module) -> (BTreeMap<u64, Vec<String>>, BTreeMap<u64, u64>) {
    let (mut loads, mut above) = (BTreeMap::<u64, Vec<String>>::new(), BTreeMap::new());
    for (name, instance) in &module.cells {
        let net = |pin: &str| match instance.connections.get(pin) {
            Some(bits) => match bits[0] {
                Bit::Net(net) => Some(net),
                Bit::Constant(_) => None,
            },
            None => None,
        };
        for pin in ["A", "D", "in"] {
            if let Some(net) = net(pin) {
                loads.entry(net).or_default().push(name.clone());
            }
        }
        if name.starts_with("fan_out_") {
            above.insert(net("Y").unwrap(), net("A").unwrap());
        }
    }
    (loads, above)
}

#[test]
fn every_pin_is_still_driven_and_no_driver_has_too_much() {
    let library = library();
    for (children, pins) in [
        (1, 1),
        (3, 2),
        (16, 1),
        (17, 1),
        (33, 9),
        (300, 5),
        (1000, 20),
    ] {
        let text = design(children, pins);
        let (limited, added) = limit(text.as_bytes(), "top", &library).unwrap();
        let after: Design = serde_json::from_str(&limited).unwrap();
        for (name, source) in [("top", 5), ("child", 2)] {
            let module = &after.modules[name];
            let (loads, above) = loads(module);
            assert_eq!(
                above.len() as u64,
                added[name],
                "{name}, {children}, {pins}"
            );
            for (net, pins) in &loads {
                assert!(pins.len() <= FAN_OUT, "{name}: {} on {net}", pins.len());
            }
            // From each pin up through buffers to the source.
            let wanted = |n: &String| n.starts_with('c') || n.starts_with('i');
            let mut reached = 0;
            for (net, pins) in &loads {
                let mut at = *net;
                while let Some(up) = above.get(&at) {
                    at = *up;
                }
                let count = pins.iter().filter(|p| wanted(p)).count();
                assert!(count == 0 || at == source, "{name}: {net} hangs on {at}");
                reached += count as u64;
            }
            assert_eq!(reached, if name == "top" { children } else { pins });
            let clocks = module
                .cells
                .values()
                .filter_map(|c| c.connections.get("CK").or_else(|| c.connections.get("clk")));
            assert!(clocks.into_iter().all(|bits| bits == &[Bit::Net(3)]));
        }
    }
}

/// The flip-flop may carry an eighth of 40 fF.
#[test]
fn a_weak_driver_of_few_heavy_modules_gets_a_buffer() {
    let library = library();
    let (_, added) = limit(design(2, 2).as_bytes(), "top", &library).unwrap();
    assert_eq!(added["top"], 0, "4 fF are within its 5");
    let (_, added) = limit(design(3, 2).as_bytes(), "top", &library).unwrap();
    assert_eq!(added["top"], 1, "6 fF are not");
}

#[test]
fn what_is_no_netlist_is_refused() {
    let library = library();
    assert!(limit(b"{", "top", &library).is_none());
    assert!(limit(b"{\"modules\": {}}", "top", &library).is_none());
    assert!(limit(design(1, 1).as_bytes(), "bottom", &library).is_none());
}

/// One flip-flop on all outputs of the top module, and on none of a child's.
#[test]
fn outputs_of_the_top_module_hang_on_a_tree() {
    let library = library();
    let nets = vec![5; 100];
    let port = |direction: &str, bits: &[u64]| json!({"direction": direction, "bits": bits});
    let flop = cell("DFF", &[("D", 4), ("CK", 3), ("Q", 5)]);
    let module = json!({
        "ports": {"clk": port("input", &[3]), "d": port("input", &[4]), "out": port("output", &nets)},
        "cells": {"flop": flop},
        "netnames": {"out": {"bits": nets}},
    });
    let above = json!({"ports": {}, "cells": {"c": {"type": "top", "connections": {}}}});
    let text = json!({"modules": {"top": module, "above": above}}).to_string();
    let (limited, added) = limit(text.as_bytes(), "top", &library).unwrap();
    let after: Design = serde_json::from_str(&limited).unwrap();
    let module = &after.modules["top"];
    let mut on: BTreeMap<u64, usize> = BTreeMap::new();
    for bit in &module.ports["out"].bits {
        let Bit::Net(net) = bit else { unreachable!() };
        *on.entry(*net).or_default() += 1;
    }
    assert_eq!(on.values().sum::<usize>(), 100);
    assert!(on.values().all(|n| *n <= FAN_OUT), "{on:?}");
    let (_, above) = loads(module);
    assert_eq!(above.len() as u64, added["top"]);
    for net in on.keys() {
        let mut at = *net;
        while let Some(up) = above.get(&at) {
            at = *up;
        }
        assert_eq!(at, 5);
    }
    let wire: Vec<Bit> =
        serde_json::from_value(module.others["netnames"]["out"]["bits"].clone()).unwrap();
    assert_eq!(wire, module.ports["out"].bits);
    let (_, added) = limit(text.as_bytes(), "above", &library).unwrap();
    assert_eq!(added["top"], 0);
}
