//! Prints modules as Verilog-2005.

mod expr;
mod wrap;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::sync::Arc;

use super::Module;
use super::node::{Node, Op};
use expr::{Exprs, literal};
use wrap::wrap;

/// What stands above every module.
#[derive(Debug, Clone, Default)]
pub struct Header {
    /// What generated the file, and from which configuration.
    pub origin: String,
    /// The command that makes it again.
    pub command: String,
}

/// The module and everything below it, one file each, by file name.
#[must_use]
pub fn verilog(top: &Arc<Module>, header: &Header) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    print_below(top, header, &mut files);
    files
}

fn print_below(module: &Module, header: &Header, files: &mut BTreeMap<String, String>) {
    let file = format!("{}.v", module.name);
    if files.contains_key(&file) {
        return;
    }
    files.insert(file, Printer::new(module).print(header));
    for inst in &module.instances {
        print_below(&inst.module, header, files);
    }
}

/// What is printed at the end of a section, once all it reads is declared.
#[derive(Default)]
struct Clocked {
    registers: Vec<usize>,
    memories: Vec<usize>,
}

struct Printer<'a> {
    module: &'a Module,
    exprs: Exprs<'a>,
    text: String,
}

impl<'a> Printer<'a> {
    fn new(module: &'a Module) -> Self {
        Self {
            module,
            exprs: Exprs::new(module),
            text: String::new(),
        }
    }

    fn line(&mut self, indent: usize, text: &str) {
        let _ = writeln!(self.text, "{}", wrap(text, indent));
    }

    fn print(mut self, header: &Header) -> String {
        self.header(header);
        self.ports();
        self.localparams();
        self.body();
        self.line(0, "endmodule");
        self.text.push_str("\n`default_nettype wire\n");
        self.text
    }

    fn header(&mut self, header: &Header) {
        let title = if self.module.doc.is_empty() {
            self.module.name.clone()
        } else {
            format!("{}: {}", self.module.name, self.module.doc)
        };
        for paragraph in [
            title.as_str(),
            "",
            header.origin.as_str(),
            header.command.as_str(),
        ] {
            for line in fill(paragraph, 90) {
                let _ = writeln!(self.text, "{}", format!("// {line}").trim_end());
            }
        }
        self.text.push_str("\n`default_nettype none\n\n");
    }

    fn ports(&mut self) {
        let mut rows: Vec<(String, String, String, String)> = vec![];
        if self.module.is_clocked() {
            rows.push((
                "input  wire".into(),
                String::new(),
                "clk".into(),
                "clock, rising edge".into(),
            ));
        }
        if self.module.has_registers() {
            rows.push((
                "input  wire".into(),
                String::new(),
                "rst_n".into(),
                "synchronous reset, active low".into(),
            ));
        }
        for p in &self.module.ports {
            let node = &self.module.nodes[p.node];
            let kind = match (p.output, self.is_own_port(p.node) && is_stored(node)) {
                (false, _) => "input  wire",
                (true, true) => "output reg ",
                (true, false) => "output wire",
            };
            rows.push((
                kind.into(),
                bits(node.ty.width),
                p.name.clone(),
                p.doc.clone(),
            ));
        }
        let range = rows.iter().map(|r| r.1.len()).max().unwrap_or(0);
        let name = rows.iter().map(|r| r.2.len()).max().unwrap_or(0) + 1;
        let _ = writeln!(self.text, "module {} (", self.module.name);
        let count = rows.len();
        for (i, (kind, bits, port, doc)) in rows.into_iter().enumerate() {
            let comma = if i + 1 < count { "," } else { "" };
            let port = format!("{port}{comma}");
            let doc = if doc.is_empty() {
                String::new()
            } else {
                format!("  // {doc}")
            };
            let _ = writeln!(
                self.text,
                "{}",
                format!("  {kind} {bits:<range$} {port:<name$}{doc}").trim_end()
            );
        }
        self.text.push_str(");\n");
    }

    fn localparams(&mut self) {
        let params: Vec<_> = self
            .module
            .nodes
            .iter()
            .enumerate()
            .filter(|(id, n)| {
                matches!(n.op, Op::Lit(_))
                    && self.exprs.live[*id]
                    && self.exprs.ident(*id).is_some()
            })
            .collect();
        if !params.is_empty() {
            self.text.push('\n');
        }
        for (id, node) in params {
            let Op::Lit(value) = &node.op else { continue };
            let name = self.exprs.ident(id).unwrap_or_default();
            let text = format!(
                "localparam {}{name} = {};{}",
                spaced(node.ty.width),
                literal(value, node.ty),
                comment(node)
            );
            self.line(1, &text);
        }
    }

    /// Whether a node is printed under the name of an output port that it drives.
    fn is_own_port(&self, id: usize) -> bool {
        self.module
            .ports
            .iter()
            .any(|p| p.output && p.node == id && self.exprs.ident(id) == Some(p.name.as_str()))
    }

    fn body(&mut self) {
        let mut clocked: BTreeMap<usize, Clocked> = BTreeMap::new();
        for (id, node) in self.module.nodes.iter().enumerate() {
            if self.exprs.live[id] && matches!(node.op, Op::Reg { .. }) {
                let section = self.last_section(node.op.edge_operands(), node.section);
                clocked.entry(section).or_default().registers.push(id);
            }
        }
        for (i, memory) in self.module.memories.iter().enumerate() {
            if !self.exprs.read[i] {
                continue;
            }
            let mut reads: Vec<usize> = memory
                .writes
                .iter()
                .flat_map(|(a, b, c)| [*a, *b, *c])
                .collect();
            for (id, node) in self.module.nodes.iter().enumerate() {
                if self.exprs.live[id] && matches!(node.op, Op::ReadSync(m, ..) if m == i) {
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
                    if !self.text.ends_with("\n\n") {
                        self.text.push('\n');
                    }
                    if !title.is_empty() {
                        self.line(1, &format!("// {title}"));
                    }
                }
            }
            self.stateful_parts_at(id);
            if id < self.module.nodes.len() && self.exprs.live[id] {
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
            if memory.at == id && self.exprs.read[i] {
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
                self.line(1, &text);
            }
        }
        for i in 0..self.module.instances.len() {
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

    /// The name that an output of an instance goes by, and whether it is an
    /// output port of this module.
    fn instance_output(&self, index: usize, port: usize) -> (String, bool) {
        let inst = &self.module.instances[index];
        let mut nodes = self.module.nodes.iter().enumerate();
        let out = nodes.find(|(id, n)| {
            self.exprs.live[*id] && matches!(n.op, Op::InstanceOut(a, b) if a == index && b == port)
        });
        match out {
            Some((id, _)) => (
                self.exprs.ident(id).unwrap_or_default().to_owned(),
                self.is_own_port(id),
            ),
            None => (
                format!("unused_{}_{}", inst.name, inst.module.ports[port].name),
                false,
            ),
        }
    }

    fn instance_wires(&mut self, index: usize) {
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

    fn instance(&mut self, index: usize) {
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
        let width = connections.iter().map(|c| c.0.len()).max().unwrap_or(0);
        let count = connections.len();
        for (i, (port, value)) in connections.into_iter().enumerate() {
            let comma = if i + 1 < count { "," } else { "" };
            self.line(2, &format!(".{port:<width$} ({value}){comma}"));
        }
        self.line(1, ");");
    }

    fn node(&mut self, id: usize) {
        let node = &self.module.nodes[id];
        let Some(name) = self.exprs.ident(id).map(str::to_owned) else {
            return;
        };
        let (width, note) = (spaced(node.ty.width), comment(node));
        let own = self.is_own_port(id);
        match &node.op {
            Op::Input | Op::Lit(_) | Op::InstanceOut(..) => {}
            Op::Reg { .. } | Op::ReadSync(..) => {
                if !own {
                    self.line(1, &format!("reg {width}{name};{note}"));
                }
            }
            Op::Select(index, options) => {
                let (index, options) = (*index, options.clone());
                if !own {
                    self.line(1, &format!("reg {width}{name};{note}"));
                }
                self.case(&name, index, &options);
            }
            _ => {
                let value = self.exprs.definition(id);
                let text = if own {
                    format!("assign {name} = {value};{note}")
                } else {
                    format!("wire {width}{name} = {value};{note}")
                };
                self.line(1, &text);
            }
        }
    }

    fn case(&mut self, name: &str, index: usize, options: &[usize]) {
        let ty = self.module.nodes[index].ty;
        self.line(1, "always @(*) begin");
        self.line(2, &format!("case ({})", self.exprs.operand(index)));
        let reachable = if ty.width >= 31 {
            options.len()
        } else {
            options.len().min(1usize << ty.width)
        };
        for (i, option) in options[..reachable].iter().enumerate() {
            let label = if i + 1 == reachable {
                "default".to_owned()
            } else {
                format!("{}'d{i}", ty.width)
            };
            let value = self.exprs.operand(*option);
            self.line(3, &format!("{label}: {name} = {value};"));
        }
        self.line(2, "endcase");
        self.line(1, "end");
    }

    fn registers(&mut self, ids: &[usize]) {
        if ids.is_empty() {
            return;
        }
        self.text.push('\n');
        self.line(1, "always @(posedge clk) begin");
        self.line(2, "if (!rst_n) begin");
        for id in ids {
            let node = &self.module.nodes[*id];
            if let Op::Reg { reset, .. } = &node.op {
                let text = format!(
                    "{} <= {};",
                    self.exprs.ident(*id).unwrap_or_default(),
                    literal(reset, node.ty)
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
                    self.exprs.ident(*id).unwrap_or_default(),
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
                    self.exprs.ident(reg).unwrap_or_default(),
                    self.exprs.operand(value)
                );
                self.line(4, &text);
            }
            self.line(3, "end");
        }
        self.line(2, "end");
        self.line(1, "end");
    }

    fn memory_ports(&mut self, index: usize) {
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
                && self.exprs.live[id]
            {
                let (en, addr) = (self.exprs.operand(en), self.exprs.operand(addr));
                let name = self.exprs.ident(id).unwrap_or_default();
                lines.push(format!("if ({en}) {name} <= {}[{addr}];", memory.name));
            }
        }
        if lines.is_empty() {
            return;
        }
        self.text.push('\n');
        self.line(1, "always @(posedge clk) begin");
        for l in lines {
            self.line(2, &l);
        }
        self.line(1, "end");
    }

    fn outputs(&mut self) {
        let assigns: Vec<_> = self
            .module
            .ports
            .iter()
            .filter(|p| p.output && self.exprs.ident(p.node) != Some(p.name.as_str()))
            .map(|p| format!("assign {} = {};", p.name, self.exprs.operand(p.node)))
            .collect();
        if !assigns.is_empty() {
            self.text.push('\n');
        }
        for a in assigns {
            self.line(1, &a);
        }
    }

    fn unread(&mut self) {
        let parts = self.exprs.unread();
        if parts.is_empty() {
            return;
        }
        self.text.push('\n');
        let why: BTreeSet<_> = self
            .module
            .unused
            .values()
            .filter(|w| !w.is_empty())
            .cloned()
            .collect();
        for w in why {
            self.line(1, &format!("// {w}"));
        }
        self.line(
            1,
            &format!("wire unused_ok = &{{1'b0, {}}};", parts.join(", ")),
        );
    }
}

fn is_stored(node: &Node) -> bool {
    matches!(node.op, Op::Reg { .. } | Op::ReadSync(..) | Op::Select(..))
}

fn bits(width: u32) -> String {
    if width == 1 {
        String::new()
    } else {
        format!("[{}:0]", width - 1)
    }
}

fn spaced(width: u32) -> String {
    if width == 1 {
        String::new()
    } else {
        format!("[{}:0] ", width - 1)
    }
}

fn comment(node: &Node) -> String {
    node.note
        .as_ref()
        .map_or_else(String::new, |n| format!("  // {n}"))
}

fn fill(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        if !lines[last].is_empty() && lines[last].len() + word.len() >= width {
            lines.push(word.to_owned());
        } else {
            if !lines[last].is_empty() {
                lines[last].push(' ');
            }
            lines[last].push_str(word);
        }
    }
    lines
}
