//! Buffers for nets between modules.
//!
//! ABC maps each module on its own, and sees a net between modules as one pin. The load of such a
//! net is known only once all modules are mapped. Here it gets the buffer tree that a flow with
//! placement would insert, in named cells that count in area and delay.

mod design;
mod net;
#[cfg(test)]
mod tests;
mod tree;

use std::collections::{BTreeMap, BTreeSet};

use super::Library;
pub(super) use net::{FAN_OUT, LOAD};

use design::{Bit, Design, Module, children_first};
use net::{Net, Sink};
use tree::{Builder, buffers};

/// A module's interface: input loads and output drive strengths bit by bit, in the library's unit
/// of capacitance.
#[derive(Debug, Default)]
struct Outside {
    loads: BTreeMap<String, Vec<f64>>,
    clocks: BTreeSet<String>,
    strengths: BTreeMap<String, Vec<f64>>,
}

/// Limits fan-out and load of every net. Returns the netlist with the number of buffers by module;
/// `None` where the text is no netlist below `top`.
///
/// Clocks are left as they are. Nets within a module are ABC's, except for their fan-out; nets
/// between modules are limited to [`LOAD`] as well.
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
                let (outside, added) = buffer(module, &known, library, name == top);
                buffers.insert(name.clone(), added);
                outside
            }
        };
        known.insert(name, outside);
    }
    let text = serde_json::to_string(&design).ok()?;
    Some((text, buffers))
}

/// A memory's pins: input loads and drive strengths of the smallest buffer.
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

/// Buffers the nets of a module whose children are `known`. Outputs of the top module are loaded.
fn buffer(
    module: &mut Module,
    known: &BTreeMap<String, Outside>,
    library: &Library,
    is_top: bool,
) -> (Outside, u64) {
    let mut nets = nets(module, known, library);
    if is_top {
        add_outputs(&mut nets, module, library.load());
    }
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
                    cell: Some(name.clone()),
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

/// Adds a module's outputs to their nets. ABC does not see a net that goes straight to several
/// outputs.
fn add_outputs(nets: &mut BTreeMap<u64, Net>, module: &Module, load: f64) {
    for (name, port) in &module.ports {
        if port.direction != "output" {
            continue;
        }
        for (at, bit) in port.bits.iter().enumerate() {
            let Bit::Net(id) = bit else { continue };
            let net = nets.entry(*id).or_default();
            net.crosses = true;
            net.sinks.push(Sink {
                cell: None,
                pin: name.clone(),
                at,
                load,
            });
        }
    }
}
