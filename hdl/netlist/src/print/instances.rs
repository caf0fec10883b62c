//! Instances of modules.

use super::{Printer, spaced};
use crate::node::Op;

impl Printer<'_> {
    /// Name of an instance's output, and whether it is an output port of this module.
    fn instance_output(&self, index: usize, port: usize) -> (String, bool) {
        let inst = &self.module.instances[index];
        let mut nodes = self.module.nodes.iter().enumerate();
        let out = nodes.find(|(id, n)| {
            self.exprs.names.live[*id]
                && matches!(n.op, Op::InstanceOut(a, b) if a == index && b == port)
        });
        match out {
            Some((id, _)) => (
                self.exprs.names.ident(id).unwrap_or_default().to_owned(),
                self.is_own_port(id),
            ),
            None => (
                format!("unused_{}_{}", inst.name, inst.module.ports[port].name),
                false,
            ),
        }
    }

    pub(super) fn instance_wires(&mut self, index: usize) {
        let child = self.module.instances[index].module.clone();
        for (i, port) in child.ports.iter().enumerate().filter(|(_, p)| p.output) {
            let (name, own) = self.instance_output(index, i);
            if !own {
                self.line(
                    1,
                    &format!("wire {}{name};", spaced(child.nodes[port.node].ty.width)),
                );
            }
        }
    }

    pub(super) fn instance(&mut self, index: usize) {
        let inst = &self.module.instances[index];
        let child = inst.module.clone();
        let mut connections = vec![];
        if child.is_clocked() {
            connections.push(("clk".to_owned(), "clk".to_owned()));
        }
        if child.has_registers() {
            connections.push(("rst_n".to_owned(), "rst_n".to_owned()));
        }
        for (i, port) in child.ports.iter().enumerate() {
            let value = if port.output {
                self.instance_output(index, i).0
            } else {
                inst.inputs
                    .iter()
                    .find(|(p, _)| *p == i)
                    .map_or_else(String::new, |(_, n)| self.exprs.operand(*n))
            };
            connections.push((port.name.clone(), value));
        }
        let name = inst.name.clone();
        self.line(1, &format!("{} {name} (", child.name));
        self.connections(2, connections);
        self.line(1, ");");
    }

    /// Connections of an instance: port and value.
    pub(super) fn connections(&mut self, indent: usize, connections: Vec<(String, String)>) {
        let width = connections.iter().map(|c| c.0.len()).max().unwrap_or(0);
        let count = connections.len();
        for (i, (port, value)) in connections.into_iter().enumerate() {
            let comma = if i + 1 < count { "," } else { "" };
            self.line(indent, &format!(".{port:<width$} ({value}){comma}"));
        }
    }
}
