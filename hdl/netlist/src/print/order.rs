//! Order of a module's body: declarations precede uses.

use std::collections::BTreeMap;

use super::{Printer, spaced};
use crate::node::Op;

/// Clocked processes at the end of a section, after all they read.
#[derive(Default)]
struct Clocked {
    registers: Vec<usize>,
    memories: Vec<usize>,
}

impl Printer<'_> {
    pub(super) fn body(&mut self) {
        let mut clocked: BTreeMap<usize, Clocked> = BTreeMap::new();
        for (id, node) in self.module.nodes.iter().enumerate() {
            if self.exprs.names.live[id] && matches!(node.op, Op::Reg { .. }) {
                let section = self.last_section(node.op.edge_operands(), node.section);
                clocked.entry(section).or_default().registers.push(id);
            }
        }
        for (i, memory) in self.module.memories.iter().enumerate() {
            if !self.exprs.names.read[i] {
                continue;
            }
            let mut reads: Vec<usize> = memory
                .writes
                .iter()
                .flat_map(|(a, b, c)| [*a, *b, *c])
                .collect();
            for (id, node) in self.module.nodes.iter().enumerate() {
                if self.exprs.names.live[id] && matches!(node.op, Op::ReadSync(m, ..) if m == i) {
                    reads.push(id);
                    reads.extend(node.op.edge_operands());
                }
            }
            let section = self.last_section(reads, 0);
            clocked.entry(section).or_default().memories.push(i);
        }
        let mut section = usize::MAX;
        for id in 0..=self.module.nodes.len() {
            let now = self
                .module
                .nodes
                .get(id)
                .map_or(self.module.sections.len(), |n| n.section);
            if section != now {
                if section != usize::MAX {
                    self.close_sections(section, now, &mut clocked);
                }
                section = now;
                if let Some(title) = self.module.sections.get(now) {
                    self.declarations();
                    self.title = Some(title.clone());
                }
            }
            self.stateful_parts_at(id);
            if id < self.module.nodes.len() && self.exprs.names.live[id] {
                self.node(id);
            }
        }
        self.outputs();
        self.unread();
    }

    fn close_sections(&mut self, from: usize, to: usize, clocked: &mut BTreeMap<usize, Clocked>) {
        for s in from..to {
            if let Some(work) = clocked.remove(&s) {
                self.registers(&work.registers);
                for m in work.memories {
                    self.memory_ports(m);
                }
            }
        }
    }

    fn last_section(&self, nodes: Vec<usize>, own: usize) -> usize {
        nodes
            .into_iter()
            .map(|n| self.module.nodes[n].section)
            .max()
            .unwrap_or(0)
            .max(own)
    }

    fn stateful_parts_at(&mut self, id: usize) {
        for (i, memory) in self.module.memories.iter().enumerate() {
            if memory.at == id && self.exprs.names.read[i] {
                let doc = if memory.doc.is_empty() {
                    String::new()
                } else {
                    format!("  // {}", memory.doc)
                };
                let text = format!(
                    "reg {}{} [0:{}];{doc}",
                    spaced(memory.width),
                    memory.name,
                    memory.depth - 1
                );
                if self.module.no_read_during_write {
                    self.line(1, "(* no_rw_check *)");
                }
                self.line(1, &text);
            }
        }
        self.arrays_at(id);
        for i in 0..self.module.instances.len() {
            if self.exprs.names.in_array[i] {
                continue;
            }
            let inst = &self.module.instances[i];
            if inst.at == id {
                self.instance_wires(i);
            }
            // Once all that it reads is declared.
            let last = inst.inputs.iter().map(|(_, n)| n + 1).max().unwrap_or(0);
            if last.max(inst.at) == id {
                self.instance(i);
            }
        }
    }
}
