//! Buffers for nets that leave a module for many others.
//!
//! ABC maps modules one by one and sees, of a net between modules, one pin. What
//! such a net drives is known only when all modules are mapped; here each gets the
//! buffer tree that a flow with placement would give it, in named cells that count
//! in area and in delay.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::Library;

/// Pins that a cell may drive; the limit that ABC is given within a module.
pub(super) const FAN_OUT: usize = 16;
/// A driver carries at most this part of its `max_capacitance`: a delay of about
/// three of an unloaded buffer, where a level more would cost as much.
pub(super) const LOAD: f64 = 0.125;

/// A netlist as Yosys writes it with `write_json`.
#[derive(Debug, Deserialize, Serialize)]
struct Design {
    modules: BTreeMap<String, Module>,
    #[serde(flatten)]
    others: Map<String, Value>,
}

#[derive(Debug, Deserialize, Serialize)]
struct Module {
    #[serde(default)]
    attributes: Map<String, Value>,
    ports: BTreeMap<String, Port>,
    cells: BTreeMap<String, Instance>,
    #[serde(flatten)]
    others: Map<String, Value>,
}

#[derive(Debug, Deserialize, Serialize)]
struct Port {
    direction: String,
    bits: Vec<Bit>,
    #[serde(flatten)]
    others: Map<String, Value>,
}

#[derive(Debug, Deserialize, Serialize)]
struct Instance {
    #[serde(rename = "type")]
    kind: String,
    connections: BTreeMap<String, Vec<Bit>>,
    #[serde(flatten)]
    others: Map<String, Value>,
}

/// A net, or a constant.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize)]
#[serde(untagged)]
enum Bit {
    Net(u64),
    Constant(String),
}

/// What a module looks like from outside: loads of its inputs and strengths of its
/// outputs, both in the library's unit of capacitance, bit by bit.
#[derive(Debug, Default)]
struct Outside {
    loads: BTreeMap<String, Vec<f64>>,
    clocks: BTreeSet<String>,
    strengths: BTreeMap<String, Vec<f64>>,
}

#[derive(Debug, Clone)]
struct Sink {
    cell: String,
    pin: String,
    at: usize,
    load: f64,
}

/// What is on a net of a module.
#[derive(Debug, Default)]
struct Net {
    sinks: Vec<Sink>,
    /// How much the driver may carry; none of an input port.
    strength: Option<f64>,
    is_clock: bool,
    /// Whether ABC could not see all of it.
    crosses: bool,
}

/// The netlist with every net's fan-out and load within limits, and how many
/// buffers that took by module; nothing where the text is no netlist below `top`.
///
/// Clocks stay as they are. Nets within a module are ABC's, but for their number of
/// pins; nets between modules are held to [`LOAD`] too.
pub(super) fn limit(
    text: &[u8],
    top: &str,
    library: &Library,
) -> Option<(String, BTreeMap<String, u64>)> {
    let mut design: Design = serde_json::from_slice(text).ok()?;
    let mut known = BTreeMap::new();
    let mut buffers = BTreeMap::new();
    for name in children_first(&design, top)? {
        let module = design.modules.get_mut(&name)?;
        let outside = match module.attributes.contains_key("blackbox") {
            true => memory(module, library),
            false => {
                let (outside, added) = buffer(module, &known, library);
                buffers.insert(name.clone(), added);
                outside
            }
        };
        known.insert(name, outside);
    }
    let text = serde_json::to_string(&design).ok()?;
    Some((text, buffers))
}

/// Modules from `top` down, each after all that it holds.
fn children_first(design: &Design, top: &str) -> Option<Vec<String>> {
    fn visit(design: &Design, name: &str, done: &mut Vec<String>, depth: u32) -> Option<()> {
        if depth > 64 || done.iter().any(|d| d == name) {
            return (depth <= 64).then_some(());
        }
        let kinds: BTreeSet<&String> = design
            .modules
            .get(name)?
            .cells
            .values()
            .map(|c| &c.kind)
            .collect();
        for kind in kinds {
            if design.modules.contains_key(kind) {
                visit(design, kind, done, depth + 1)?;
            }
        }
        done.push(name.to_owned());
        Some(())
    }
    let mut done = vec![];
    visit(design, top, &mut done, 0)?;
    Some(done)
}

/// A memory's pins: inputs as heavy as the smallest buffer's, outputs as strong.
fn memory(module: &Module, library: &Library) -> Outside {
    let buffer = library.cells.get(&library.buffer);
    let load = buffer.map_or(0.0, |c| c.inputs.values().sum());
    let strength = LOAD * buffer.map_or(0.0, |c| c.drive);
    let mut outside = Outside::default();
    for (name, port) in &module.ports {
        let of = |value| vec![value; port.bits.len()];
        match (&*port.direction, &**name) {
            ("output", _) => {
                outside.strengths.insert(name.clone(), of(strength));
            }
            (_, "clk") => {
                outside.clocks.insert(name.clone());
            }
            _ => {
                outside.loads.insert(name.clone(), of(load));
            }
        }
    }
    outside
}

/// Buffers the nets of a module whose own modules are `known`.
fn buffer(
    module: &mut Module,
    known: &BTreeMap<String, Outside>,
    library: &Library,
) -> (Outside, u64) {
    let nets = nets(module, known, library);
    let bits = module.ports.values().flat_map(|p| &p.bits);
    let bits = bits.chain(
        module
            .cells
            .values()
            .flat_map(|c| c.connections.values().flatten()),
    );
    let last = bits.filter_map(|b| match b {
        Bit::Net(net) => Some(*net),
        Bit::Constant(_) => None,
    });
    let mut builder = Builder {
        next_net: last.max().unwrap_or(1) + 1,
        added: 0,
        module,
        buffers: buffers(library),
    };
    let mut outside = Outside::default();
    let mut loads = BTreeMap::new();
    let mut strengths = BTreeMap::new();
    let mut clocks = BTreeSet::new();
    for (id, net) in nets {
        if net.is_clock {
            clocks.insert(id);
            continue;
        }
        strengths.insert(id, net.strength);
        let load = builder.tree(id, net);
        loads.insert(id, load);
    }
    let added = builder.added;
    for (name, port) in &module.ports {
        let of = |bit: &Bit| match bit {
            Bit::Net(net) => Some(*net),
            Bit::Constant(_) => None,
        };
        if port.direction == "output" {
            let strength = |bit: &Bit| of(bit).and_then(|n| strengths.get(&n).copied().flatten());
            let all = port
                .bits
                .iter()
                .map(|b| strength(b).unwrap_or(f64::INFINITY));
            outside.strengths.insert(name.clone(), all.collect());
        } else if port.bits.iter().filter_map(of).any(|n| clocks.contains(&n)) {
            outside.clocks.insert(name.clone());
        } else {
            let load = |bit: &Bit| of(bit).and_then(|n| loads.get(&n)).copied();
            let all = port.bits.iter().map(|b| load(b).unwrap_or(0.0));
            outside.loads.insert(name.clone(), all.collect());
        }
    }
    (outside, added)
}

fn nets(
    module: &Module,
    known: &BTreeMap<String, Outside>,
    library: &Library,
) -> BTreeMap<u64, Net> {
    let mut nets: BTreeMap<u64, Net> = BTreeMap::new();
    for (name, instance) in &module.cells {
        let cell = library.cells.get(&instance.kind);
        let child = known.get(&instance.kind);
        for (pin, bits) in &instance.connections {
            for (at, bit) in bits.iter().enumerate() {
                let Bit::Net(id) = bit else { continue };
                let net = nets.entry(*id).or_default();
                net.crosses |= child.is_some();
                let sink = |load| Sink {
                    cell: name.clone(),
                    pin: pin.clone(),
                    at,
                    load,
                };
                if let Some(cell) = cell {
                    net.is_clock |= cell.clock.as_ref() == Some(pin);
                    if let Some(load) = cell.inputs.get(pin) {
                        net.sinks.push(sink(*load));
                    } else if cell.outputs.contains_key(pin) {
                        net.strength = Some(LOAD * cell.drive);
                    }
                } else if let Some(child) = child {
                    net.is_clock |= child.clocks.contains(pin);
                    if let Some(loads) = child.loads.get(pin) {
                        net.sinks.push(sink(loads.get(at).copied().unwrap_or(0.0)));
                    } else if let Some(all) = child.strengths.get(pin) {
                        net.strength = all.get(at).copied();
                    }
                }
            }
        }
    }
    nets
}

/// A buffer of the library.
struct Buffer<'a> {
    name: &'a str,
    input: &'a str,
    output: &'a str,
    load: f64,
    strength: f64,
}

/// Buffers, the smallest first.
fn buffers(library: &Library) -> Vec<Buffer<'_>> {
    let mut found: Vec<(f64, Buffer<'_>)> = library
        .cells
        .iter()
        .filter(|(_, cell)| cell.is_buffer())
        .filter_map(|(name, cell)| {
            let (input, load) = cell.inputs.iter().next()?;
            let output = cell.outputs.keys().next()?;
            let (load, strength) = (*load, LOAD * cell.drive);
            let buffer = Buffer {
                name,
                input,
                output,
                load,
                strength,
            };
            Some((cell.area, buffer))
        })
        .collect();
    found.sort_by(|(a, x), (b, y)| a.total_cmp(b).then(x.name.cmp(y.name)));
    found.into_iter().map(|(_, buffer)| buffer).collect()
}

struct Builder<'a> {
    module: &'a mut Module,
    buffers: Vec<Buffer<'a>>,
    next_net: u64,
    added: u64,
}

impl Builder<'_> {
    /// Buffers a net, level by level from its pins; gives the load that its driver
    /// then has.
    fn tree(&mut self, id: u64, net: Net) -> f64 {
        let Net {
            mut sinks,
            strength,
            crosses,
            ..
        } = net;
        let strongest = self.buffers.iter().map(|b| b.strength).fold(0.0, f64::max);
        // Who drives an input port is buffered for it, where it is driven.
        let limit = match strength {
            Some(limit) if crosses && limit > 0.0 => limit,
            _ => f64::INFINITY,
        };
        let total = |sinks: &[Sink]| sinks.iter().map(|s| s.load).sum::<f64>();
        while sinks.len() > FAN_OUT || total(&sinks) > limit {
            let groups = groups(&sinks, strongest);
            let buffers = groups.iter().filter_map(|g| self.choose(total(g)));
            let next: f64 = buffers.map(|at| self.buffers[at].load).sum();
            // As many buffers as pins, and no lighter: nothing is gained.
            if groups.len() == sinks.len() && next >= total(&sinks) {
                break;
            }
            sinks = groups.iter().filter_map(|g| self.insert(id, g)).collect();
        }
        total(&sinks)
    }

    /// The smallest buffer that may carry a load, else the strongest.
    fn choose(&self, load: f64) -> Option<usize> {
        let enough = self.buffers.iter().position(|b| b.strength >= load);
        let by_strength = |a: &usize, b: &usize| {
            self.buffers[*a]
                .strength
                .total_cmp(&self.buffers[*b].strength)
        };
        enough.or_else(|| (0..self.buffers.len()).max_by(by_strength))
    }

    /// A buffer from `id` to the pins.
    fn insert(&mut self, id: u64, pins: &[Sink]) -> Option<Sink> {
        let at = self.choose(pins.iter().map(|s| s.load).sum())?;
        let buffer = &self.buffers[at];
        let net = self.next_net;
        self.next_net += 1;
        for sink in pins {
            let cell = self.module.cells.get_mut(&sink.cell)?;
            *cell.connections.get_mut(&sink.pin)?.get_mut(sink.at)? = Bit::Net(net);
        }
        let number = (self.added..).find(|n| !self.module.cells.contains_key(&name(*n)))?;
        let connections = [(buffer.input, id), (buffer.output, net)];
        let connections = connections.map(|(pin, net)| (pin.to_owned(), vec![Bit::Net(net)]));
        let nothing = || Value::Object(Map::new());
        let others = [
            ("hide_name", Value::from(0)),
            ("parameters", nothing()),
            ("attributes", nothing()),
        ];
        let instance = Instance {
            kind: buffer.name.to_owned(),
            connections: connections.into(),
            others: others.map(|(k, v)| (k.to_owned(), v)).into_iter().collect(),
        };
        let sink = Sink {
            cell: name(number),
            pin: buffer.input.to_owned(),
            at: 0,
            load: buffer.load,
        };
        self.module.cells.insert(name(number), instance);
        self.added += 1;
        Some(sink)
    }
}

fn name(number: u64) -> String {
    format!("fan_out_{number}")
}

/// Neighbours together, as many as a buffer may drive and no heavier than the
/// strongest may carry, the groups about as heavy.
fn groups(sinks: &[Sink], strongest: f64) -> Vec<Vec<Sink>> {
    let total: f64 = sinks.iter().map(|s| s.load).sum();
    let by_load = match strongest > 0.0 {
        true => (total / strongest).ceil() as usize,
        false => 1,
    };
    let count = by_load.max(sinks.len().div_ceil(FAN_OUT)).max(1);
    let size = sinks.len().div_ceil(count).max(1);
    sinks.chunks(size).map(<[Sink]>::to_vec).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use serde_json::json;

    const LIBRARY: &str = "library (t) { time_unit : \"1ps\"; capacitive_load_unit (1, ff);\n\
        cell (INV) { area : 1; pin (A) { direction : input; capacitance : 1; } \
        pin (Y) { direction : output; max_capacitance : 40; function : \"!A\"; } }\n\
        cell (BUF) { area : 2; pin (A) { direction : input; capacitance : 0.5; } \
        pin (Y) { direction : output; max_capacitance : 80; function : \"A\"; } }\n\
        cell (BUFX4) { area : 4; pin (A) { direction : input; capacitance : 0.8; } \
        pin (Y) { direction : output; max_capacitance : 320; function : \"A\"; } }\n\
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

    /// A flip-flop that drives `children` modules, in each of which `pins` inverters
    /// hang on the port; all flip-flops are clocked.
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

    /// Pins of cells and modules on each net of a module, and the net above a buffer.
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
}
