//! Clocked processes: registers and memory ports.

use std::collections::BTreeSet;

use super::Printer;
use super::expr::constant;
use crate::node::Op;

impl Printer<'_> {
    pub(super) fn registers(&mut self, ids: &[usize]) {
        if ids.is_empty() {
            return;
        }
        self.gap();
        self.line(1, "always @(posedge clk) begin");
        self.line(2, "if (!rst_n) begin");
        for id in ids {
            let node = &self.module.nodes[*id];
            if let Op::Reg { reset, .. } = &node.op {
                let text = format!(
                    "{} <= {};",
                    self.exprs.names.ident(*id).unwrap_or_default(),
                    constant(reset, node)
                );
                self.line(3, &text);
            }
        }
        self.line(2, "end else begin");
        let mut done = BTreeSet::new();
        for id in ids {
            let Op::Reg {
                next: Some(next),
                enable,
                ..
            } = self.module.nodes[*id].op
            else {
                continue;
            };
            let Some(enable) = enable else {
                let text = format!(
                    "{} <= {};",
                    self.exprs.names.ident(*id).unwrap_or_default(),
                    self.exprs.operand(next)
                );
                self.line(3, &text);
                continue;
            };
            if !done.insert(enable) {
                continue;
            }
            let condition = self.exprs.operand(enable);
            let alike: Vec<_> = ids
                .iter()
                .filter_map(|r| match self.module.nodes[*r].op {
                    Op::Reg {
                        next: Some(n),
                        enable: Some(e),
                        ..
                    } if e == enable => Some((*r, n)),
                    _ => None,
                })
                .collect();
            self.line(3, &format!("if ({condition}) begin"));
            for (reg, value) in alike {
                let text = format!(
                    "{} <= {};",
                    self.exprs.names.ident(reg).unwrap_or_default(),
                    self.exprs.operand(value)
                );
                self.line(4, &text);
            }
            self.line(3, "end");
        }
        self.line(2, "end");
        self.line(1, "end");
    }

    pub(super) fn memory_ports(&mut self, index: usize) {
        let memory = &self.module.memories[index];
        let mut lines = vec![];
        for (en, addr, data) in &memory.writes {
            let (en, addr, data) = (
                self.exprs.operand(*en),
                self.exprs.operand(*addr),
                self.exprs.operand(*data),
            );
            lines.push(format!("if ({en}) {}[{addr}] <= {data};", memory.name));
        }
        for (id, node) in self.module.nodes.iter().enumerate() {
            if let Op::ReadSync(m, en, addr) = node.op
                && m == index
                && self.exprs.names.live[id]
            {
                let (en, addr) = (self.exprs.operand(en), self.exprs.operand(addr));
                let name = self.exprs.names.ident(id).unwrap_or_default();
                lines.push(format!("if ({en}) {name} <= {}[{addr}];", memory.name));
            }
        }
        if lines.is_empty() {
            return;
        }
        self.gap();
        self.line(1, "always @(posedge clk) begin");
        for l in lines {
            self.line(2, &l);
        }
        self.line(1, "end");
    }
}
