//! Checks, in a part of the text that only `POTAMOI_CHECKS` lets a tool see.

use std::collections::BTreeSet;

use super::names::Names;
use super::{Header, Printer, comment, fill, spaced, uses};
use crate::checks::{CheckKind, Source};
use crate::node::Op;

/// Modules that the checks are instances of, by file name.
#[must_use]
pub fn check_modules(header: &Header) -> Vec<(&'static str, String)> {
    let files = [
        ("potamoi_checking.v", include_str!("checks/checking.v")),
        ("potamoi_begun.v", include_str!("checks/begun.v")),
        ("potamoi_assert.v", include_str!("checks/assert.v")),
        ("potamoi_assume.v", include_str!("checks/assume.v")),
        ("potamoi_cover.v", include_str!("checks/cover.v")),
        ("potamoi_free.v", include_str!("checks/free.v")),
        ("potamoi_same.v", include_str!("checks/same.v")),
    ];
    files
        .map(|(file, text)| {
            let guard = file.trim_end_matches(".v").to_uppercase();
            // The files of several configurations may be read together.
            let origin = format!(
                "// {}\n\n`ifndef {guard}_V\n`define {guard}_V\n`default_nettype none",
                header.origin
            );
            let text = text.replacen("`default_nettype none", &origin, 1);
            (file, text + "`endif\n")
        })
        .to_vec()
}

impl Printer<'_> {
    /// The checks of the module; `top` where its ports are those of the design.
    pub(super) fn checks(&mut self, top: bool) {
        let joined = self.module.checks.joined(self.module);
        if joined.checks.list.is_empty() {
            return;
        }
        self.gap();
        let mut own = Printer::new(&joined);
        own.exprs.names = Names::of_checks(&joined, &self.exprs.names);
        // An output is checked at its port: past all that the module does to it, and of a macro where
        // one stands in the place of the body.
        own.exprs.names.name_outputs_as_ports();
        own.ghosts();
        own.statements(top);
        self.text.push_str("`ifdef POTAMOI_CHECKS\n");
        self.text.push_str(&own.text);
        self.text.push_str("`endif\n");
    }

    /// Declarations of what only the checks use, in the order of their use.
    fn ghosts(&mut self) {
        self.line(1, "// Checks: simulation reports what does not hold, and solvers prove it (POTAMOI_CHECKS)");
        let when = match self.module.has_reset() {
            true => [
                "wire checking;  // out of reset, and reset once",
                "potamoi_checking check_reset (.clk(clk), .rst_n(rst_n), .on(checking));",
            ],
            false => [
                "wire checking;  // from the second clock edge on",
                "potamoi_begun check_begun (.clk(clk), .on(checking));",
            ],
        };
        for line in when {
            self.line(1, line);
        }
        // The outputs have been assigned.
        let outputs = self.module.ports.iter().filter(|port| port.output);
        let outputs: BTreeSet<usize> = outputs.map(|port| port.node).collect();
        let printed: Vec<usize> = (0..self.module.nodes.len())
            .filter(|id| self.exprs.names.live[*id] && self.exprs.names.ident(*id).is_some())
            .filter(|id| !outputs.contains(id))
            .collect();
        self.insides(&printed);
        for id in &printed {
            match self.module.checks.sources.get(id).cloned() {
                Some(source) => self.source(*id, &source),
                None => self.node(*id),
            }
        }
        let registers: Vec<usize> = printed
            .iter()
            .copied()
            .filter(|id| matches!(self.module.nodes[*id].op, Op::Reg { .. }))
            .collect();
        self.declarations();
        self.registers(&registers);
        let unread = uses::unread_of(&self.exprs.names, &printed);
        if !unread.is_empty() {
            let text = format!("wire unused_checks = &{{1'b0, {}}};", unread.join(", "));
            self.gap();
            self.line(1, &text);
        }
    }

    /// Signals within instances, all at once.
    fn insides(&mut self, printed: &[usize]) {
        let (mut flat, mut nested) = (vec![], vec![]);
        for id in printed {
            let Some(Source::Inside { instance, name: of }) = self.module.checks.sources.get(id)
            else {
                continue;
            };
            let instance = &self.module.instances[*instance].name;
            let range = spaced(self.module.nodes[*id].ty.width);
            let name = self.exprs.names.ident(*id).unwrap_or_default();
            let joined = format!("(* hierconn *) wire {range}\\{instance}.{of} ;");
            if !flat.contains(&joined) {
                flat.push(joined);
            }
            flat.push(format!("wire {range}{name} = \\{instance}.{of} ;"));
            nested.push(format!("wire {range}{name} = {instance}.{of};"));
        }
        if flat.is_empty() {
            return;
        }
        // Yosys joins a wire of this attribute with the one of its name when it flattens.
        self.text.push_str("`ifdef FORMAL\n");
        flat.iter().for_each(|line| self.line(1, line));
        self.text.push_str("`else\n");
        nested.iter().for_each(|line| self.line(1, line));
        self.text.push_str("`endif\n");
    }

    fn source(&mut self, id: usize, source: &Source) {
        let node = &self.module.nodes[id];
        let width = node.ty.width;
        let name = self.exprs.names.ident(id).unwrap_or_default().to_owned();
        let note = comment(node);
        match source {
            // Declared for all checks.
            Source::Checking => {}
            Source::Free => {
                self.line(1, &format!("wire {}{name};{note}", spaced(width)));
                let text = format!("potamoi_free #(.WIDTH({width})) free_{name} (.value({name}));");
                self.line(1, &text);
            }
            Source::Same {
                a,
                b,
                whole,
                takes_x,
            } => {
                let of = self.module.nodes[*a].ty.width;
                let (a, b) = (self.exprs.operand(*a), self.exprs.operand(*b));
                self.declarations();
                self.line(1, &format!("wire {name};{note}"));
                let text = format!(
                    "potamoi_same #(.WIDTH({of}){}{}) compare_{name} (.a({a}), .b({b}), .same({name}));",
                    if *whole { ", .WHOLE(1)" } else { "" },
                    if *takes_x { ", .TAKES_X(1)" } else { "" }
                );
                self.line(1, &text);
            }
            // Declared before all others.
            Source::Inside { .. } => {}
        }
    }

    fn statements(&mut self, top: bool) {
        let mut stated = false;
        for check in self.module.checks.list.clone() {
            if !stated || !check.doc.is_empty() {
                self.gap();
            }
            stated = true;
            let module = match check.kind {
                CheckKind::Assume if top => "potamoi_assume",
                CheckKind::Cover => "potamoi_cover",
                _ => "potamoi_assert",
            };
            for line in fill(&check.doc, 90) {
                if !line.is_empty() {
                    self.line(1, &format!("// {line}"));
                }
            }
            let value = self.exprs.operand(check.node);
            let takes_x = match module {
                "potamoi_assert" if !self.module.has_reset() => "#(.TAKES_X(1)) ",
                _ => "",
            };
            let text = format!(
                "{module} {takes_x}check_{} (.clk(clk), .on(checking), .good({value}));",
                check.name
            );
            self.line(1, &text);
        }
    }
}
