//! Arrays of instances as `generate for`.

use super::expr::indexed;
use super::{Printer, spaced};
use crate::repetition::{Array, Rearranged, label, place};

impl Printer<'_> {
    /// Wires of the arrays' outputs and, once all that they read is declared, the arrays.
    pub(super) fn arrays_at(&mut self, id: usize) {
        for index in 0..self.module.arrays.len() {
            let array = self.module.arrays[index].clone();
            let at = self.module.instances[array.first].at;
            if at == id {
                self.array_wires(&array);
            }
            let last = array.inputs.iter().map(|(_, fed)| fed.node + 1).max();
            if last.unwrap_or(0).max(at) == id {
                self.array(&array);
            }
        }
    }

    fn array_wires(&mut self, array: &Array) {
        for (port, node) in &array.outputs {
            let name = self.array_output(array, *port, *node);
            if !self.is_own_port(*node) {
                let width = self.module.nodes[*node].ty.width;
                self.declare("wire", width, &name);
            }
        }
    }

    fn array_output(&self, array: &Array, port: usize, node: usize) -> String {
        match self.exprs.names.ident(node) {
            Some(name) => name.to_owned(),
            None => {
                let child = &self.module.instances[array.first].module;
                format!("unused_{}_{}", array.name, child.ports[port].name)
            }
        }
    }

    fn array(&mut self, array: &Array) {
        let indent = self.open_loops(&array.name, &array.printed_loops());
        self.elements(array, indent);
        self.close_loops(indent);
    }

    /// Begins loops, outermost first. Returns the indent within.
    fn open_loops(&mut self, name: &str, loops: &[(String, u32)]) -> usize {
        let new: Vec<_> = (loops.iter())
            .filter(|(variable, _)| self.loop_variables.insert(variable.clone()))
            .map(|(variable, _)| variable.clone())
            .collect();
        if !new.is_empty() {
            self.line(1, &format!("genvar {};", new.join(", ")));
        }
        self.line(1, "generate");
        let mut indent = 2;
        for (i, (variable, count)) in loops.iter().enumerate() {
            let label = label(name, loops, i);
            let range =
                format!("{variable} = 0; {variable} < {count}; {variable} = {variable} + 1");
            self.line(indent, &format!("for ({range}) begin : {label}"));
            indent += 1;
        }
        indent
    }

    fn close_loops(&mut self, mut indent: usize) {
        while indent > 2 {
            indent -= 1;
            self.line(indent, "end");
        }
        self.line(1, "endgenerate");
    }

    /// Bits in another order or several times each, in a process: an event-driven simulator would follow each of so many
    /// assignments.
    pub(super) fn rearranged(&mut self, of: &Rearranged, note: &str) {
        let name = self.exprs.names.ident(of.node).unwrap_or_default();
        let name = name.to_owned();
        let width = self.module.nodes[of.node].ty.width;
        let from = self.exprs.operand(of.from);
        self.line(1, &format!("reg {}{name};{note}", spaced(width)));
        let new: Vec<_> = (of.loops.iter().map(|own| own.variable.clone()))
            .filter(|variable| self.loop_variables.insert(variable.clone()))
            .collect();
        if !new.is_empty() {
            self.line(1, &format!("integer {};", new.join(", ")));
        }
        self.line(1, "always @(*) begin");
        let ranges = of.loops.iter().map(|own| {
            let (variable, count) = (&own.variable, own.count);
            format!("for ({variable} = 0; {variable} < {count}; {variable} = {variable} + 1)")
        });
        let ranges: Vec<String> = ranges.collect();
        let variables = || of.loops.iter().map(|own| own.variable.as_str());
        let to = place(variables().zip(of.loops.iter().map(|l| l.to)).collect());
        let at = place(variables().zip(of.loops.iter().map(|l| l.from)).collect());
        let bit = match of.times {
            1 => format!("{name}[{to}] = {from}[{at}];"),
            times => format!("{name}[{to} +: {times}] = {{{times}{{{from}[{at}]}}}};"),
        };
        match &ranges[..] {
            [range] => self.line(2, &format!("{range} {bit}")),
            ranges => {
                for (depth, range) in (2..).zip(ranges) {
                    self.line(depth, &format!("{range} begin"));
                }
                self.line(2 + ranges.len(), &bit);
                for depth in (2..2 + ranges.len()).rev() {
                    self.line(depth, "end");
                }
            }
        }
        self.line(1, "end");
    }

    /// The instance within the loops.
    fn elements(&mut self, array: &Array, indent: usize) {
        let child = self.module.instances[array.first].module.clone();
        let mut connections = vec![];
        for (i, port) in child.ports.iter().enumerate() {
            let width = child.nodes[port.node].ty.width;
            let all = (0..array.loops.len()).filter(|l| array.loops[*l].1 > 1);
            let all: Vec<usize> = all.collect();
            let text = if port.output {
                let of_port = array.outputs.iter().find(|(p, _)| *p == i);
                let name = of_port.map(|(p, node)| self.array_output(array, *p, *node));
                element(array, &name.unwrap_or_default(), &all, (0, width, width))
            } else {
                let Some((_, fed)) = array.inputs.iter().find(|(p, _)| *p == i) else {
                    continue;
                };
                let vector = self.exprs.operand(fed.node);
                element(array, &vector, &fed.over, (fed.base, fed.stride, width))
            };
            connections.push((port.name.clone(), text));
        }
        let own = match self.exprs.names.is_taken(&child.name) {
            true => format!("{}_unit", child.name),
            false => child.name.clone(),
        };
        self.connected(indent, &child, &own, connections);
    }
}

/// The value of one turn in a vector over some of the loops with several turns, at base, stride and
/// width.
fn element(array: &Array, vector: &str, over: &[usize], at: (u32, u32, u32)) -> String {
    let Some((first, rest)) = over.split_first() else {
        return vector.to_owned();
    };
    let mut index = array.loops[*first].0.clone();
    for l in rest {
        let (variable, count) = &array.loops[*l];
        index = match index.contains('+') {
            true => format!("{count} * ({index}) + {variable}"),
            false => format!("{count} * {index} + {variable}"),
        };
    }
    if !rest.is_empty() && at.1 > 1 {
        index = format!("({index})");
    }
    indexed(vector, at, &index)
}
