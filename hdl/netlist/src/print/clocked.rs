//! Clocked processes: registers and memory ports.

use std::collections::BTreeSet;

use super::Printer;
use super::expr::constant;
use crate::node::Op;

impl Printer<'_> {
    /// A process of the registers that are reset, and one of those that are not.
    pub(super) fn registers(&mut self, ids: &[usize]) {
        let is_reset =
            |id: &usize| matches!(self.module.nodes[*id].op, Op::Reg { reset: Some(_), .. });
        let (reset, data): (Vec<_>, Vec<_>) = ids.iter().copied().partition(is_reset);
        if !reset.is_empty() {
            self.gap();
            self.line(1, "always @(posedge clk) begin");
            self.reset_or_update(&reset);
            self.line(1, "end");
        }
        if !data.is_empty() {
            self.gap();
            self.line(1, "always @(posedge clk) begin");
            self.updates(2, &data);
            self.line(1, "end");
        }
    }

    /// Reset values, else next values.
    fn reset_or_update(&mut self, ids: &[usize]) {
        let value = |own: &Self, id: usize| match &own.module.nodes[id].op {
            Op::Reg {
                reset: Some(value), ..
            } => constant(value, &own.module.nodes[id]),
            _ => String::new(),
        };
        let enable = |id: &usize| match self.module.nodes[*id].op {
            Op::Reg { enable, .. } => enable,
            _ => None,
        };
        let common = enable(&ids[0]).filter(|_| ids.iter().all(|id| enable(id) == enable(&ids[0])));
        let or_else = match common {
            Some(enable) => format!("else if ({})", self.exprs.operand(enable)),
            None => "else".to_owned(),
        };
        if let [only] = *ids
            && let Op::Reg {
                next: Some(next), ..
            } = self.module.nodes[only].op
        {
            let reg = self.exprs.names.ident(only).unwrap_or_default();
            let (reset, next) = (value(self, only), self.exprs.operand(next));
            let lines = [
                format!("if (!rst_n) {reg} <= {reset};"),
                format!("{or_else} {reg} <= {next};"),
            ];
            for line in &lines {
                self.line(2, line);
            }
            return;
        }
        self.line(2, "if (!rst_n) begin");
        for id in ids {
            let text = value(self, *id);
            self.assign(3, *id, &text);
        }
        self.line(2, &format!("end {or_else} begin"));
        match common {
            Some(_) => self.next_values(3, ids),
            None => self.updates(3, ids),
        }
        self.line(2, "end");
    }

    fn next_values(&mut self, indent: usize, ids: &[usize]) {
        for id in ids {
            if let Op::Reg {
                next: Some(next), ..
            } = self.module.nodes[*id].op
            {
                let text = self.exprs.operand(next);
                self.assign(indent, *id, &text);
            }
        }
    }

    /// Next values, those with one enable together.
    fn updates(&mut self, indent: usize, ids: &[usize]) {
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
                let text = self.exprs.operand(next);
                self.assign(indent, *id, &text);
                continue;
            };
            if !done.insert(enable) {
                continue;
            }
            let condition = self.exprs.operand(enable);
            let shares = |id: &usize| {
                let op = &self.module.nodes[*id].op;
                matches!(op, Op::Reg { next: Some(_), enable: Some(e), .. } if *e == enable)
            };
            let alike: Vec<_> = ids.iter().copied().filter(shares).collect();
            if let [only] = *alike {
                let value = self.exprs.operand(next);
                let reg = self.exprs.names.ident(only).unwrap_or_default();
                self.line(indent, &format!("if ({condition}) {reg} <= {value};"));
                continue;
            }
            self.line(indent, &format!("if ({condition}) begin"));
            self.next_values(indent + 1, &alike);
            self.line(indent, "end");
        }
    }

    fn assign(&mut self, indent: usize, reg: usize, value: &str) {
        let reg = self.exprs.names.ident(reg).unwrap_or_default();
        let text = format!("{reg} <= {value};");
        self.line(indent, &text);
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
