//! Instances of modules.

use super::Printer;
use crate::Module;
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
                self.declare("wire", child.nodes[port.node].ty.width, &name);
            }
        }
    }

    pub(super) fn instance(&mut self, index: usize) {
        let inst = &self.module.instances[index];
        let child = inst.module.clone();
        let mut connections = vec![];
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
        self.connected(1, &child, &name, connections);
    }

    /// An instance of a module with what its ports are connected to, clock and reset first.
    pub(super) fn connected(
        &mut self,
        indent: usize,
        child: &Module,
        name: &str,
        ports: Vec<(String, String)>,
    ) {
        let clocks = [("clk", child.is_clocked()), ("rst_n", child.has_reset())];
        let clocks = clocks.into_iter().filter(|(_, has)| *has);
        let clocks = clocks.map(|(clock, _)| (clock.to_owned(), clock.to_owned()));
        let connections: Vec<_> = clocks.chain(ports).collect();
        let width = connections.iter().map(|c| c.0.len()).max().unwrap_or(0);
        let count = connections.len();
        self.line(indent, &format!("{} {name} (", child.name));
        for (i, (port, value)) in connections.into_iter().enumerate() {
            let comma = if i + 1 < count { "," } else { "" };
            self.line(indent + 1, &format!(".{port:<width$} ({value}){comma}"));
        }
        self.line(indent, ");");
    }
}
