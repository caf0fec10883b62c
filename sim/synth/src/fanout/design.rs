//! A netlist in the format of Yosys's `write_json`.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// Modules by name.
#[derive(Debug, Deserialize, Serialize)]
pub(super) struct Design {
    pub(super) modules: BTreeMap<String, Module>,
    #[serde(flatten)]
    pub(super) others: Map<String, Value>,
}

#[derive(Debug, Deserialize, Serialize)]
pub(super) struct Module {
    #[serde(default)]
    pub(super) attributes: Map<String, Value>,
    pub(super) ports: BTreeMap<String, Port>,
    pub(super) cells: BTreeMap<String, Instance>,
    #[serde(flatten)]
    pub(super) others: Map<String, Value>,
}

#[derive(Debug, Deserialize, Serialize)]
pub(super) struct Port {
    pub(super) direction: String,
    pub(super) bits: Vec<Bit>,
    #[serde(flatten)]
    pub(super) others: Map<String, Value>,
}

#[derive(Debug, Deserialize, Serialize)]
pub(super) struct Instance {
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) connections: BTreeMap<String, Vec<Bit>>,
    #[serde(flatten)]
    pub(super) others: Map<String, Value>,
}

/// A net, or a constant.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize)]
#[serde(untagged)]
pub(super) enum Bit {
    Net(u64),
    Constant(String),
}

impl Module {
    /// Connects a bit of a port to `net`.
    pub(super) fn connect_port(&mut self, port: &str, at: usize, net: u64) -> Option<()> {
        *self.ports.get_mut(port)?.bits.get_mut(at)? = Bit::Net(net);
        // A wire of the port's name, if it is listed, is the port.
        let wires = self.others.get_mut("netnames");
        let wire = wires.and_then(|wires| wires.get_mut(port)?.get_mut("bits")?.get_mut(at));
        if let Some(bit) = wire {
            *bit = Value::from(net);
        }
        Some(())
    }
}

/// Modules below `top`, each after all its children.
pub(super) fn children_first(design: &Design, top: &str) -> Option<Vec<String>> {
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
