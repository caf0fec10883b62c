//! Prints modules as Verilog-2005.

mod arrays;
mod checks;
mod clocked;
mod expr;
mod instances;
mod macro_hook;
mod names;
mod order;
mod uses;
mod wrap;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::sync::Arc;

use super::Module;
use super::node::{Node, Op};
use super::repetition::picked;
pub use checks::check_modules;
use expr::{Exprs, constant};
use wrap::{WIDTH, wrap};

/// Header of every file.
#[derive(Debug, Clone, Default)]
pub struct Header {
    /// Generator and configuration.
    pub origin: String,
    /// Command that generates it again.
    pub command: String,
}

/// The module and its hierarchy as Verilog, one file for each module, by file name.
#[must_use]
pub fn verilog(top: &Arc<Module>, header: &Header) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    print_below(top, header, true, &mut files);
    files
}

fn print_below(module: &Module, header: &Header, top: bool, files: &mut BTreeMap<String, String>) {
    let file = format!("{}.v", module.name);
    if files.contains_key(&file) {
        return;
    }
    files.insert(file, Printer::new(module).print(header, top));
    for inst in &module.instances {
        print_below(&inst.module, header, false, files);
    }
}

struct Printer<'a> {
    module: &'a Module,
    exprs: Exprs<'a>,
    text: String,
    /// Title of the section, until its first line is printed.
    title: Option<String>,
    /// Loop variables that are declared.
    loop_variables: BTreeSet<String>,
    /// What is declared without a comment, and not yet written.
    declared: Vec<Declared>,
}

/// Names of one kind and width.
struct Declared {
    kind: &'static str,
    width: u32,
    names: Vec<String>,
}

impl<'a> Printer<'a> {
    fn new(module: &'a Module) -> Self {
        Self {
            module,
            exprs: Exprs::new(module),
            text: String::new(),
            title: None,
            loop_variables: BTreeSet::new(),
            declared: vec![],
        }
    }

    /// Declares a name without a comment. Names of one kind and width that follow each other share a
    /// declaration.
    fn declare(&mut self, kind: &'static str, width: u32, name: &str) {
        let mut all = self.declared.iter_mut();
        match all.find(|d| d.kind == kind && d.width == width) {
            Some(own) => own.names.push(name.to_owned()),
            None => self.declared.push(Declared {
                kind,
                width,
                names: vec![name.to_owned()],
            }),
        }
    }

    /// Writes what is declared.
    fn declarations(&mut self) {
        for Declared { kind, width, names } in std::mem::take(&mut self.declared) {
            let text = format!("{kind} {}{};", spaced(width), names.join(", "));
            self.line(1, &text);
        }
    }

    /// An empty line.
    fn gap(&mut self) {
        self.declarations();
        self.text.push('\n');
    }

    fn line(&mut self, indent: usize, text: &str) {
        if !self.declared.is_empty() {
            self.declarations();
        }
        if let Some(title) = self.title.take() {
            if !self.text.ends_with("\n\n") {
                self.text.push('\n');
            }
            if !title.is_empty() {
                for line in fill(&title, WIDTH - "  // ".len()) {
                    let _ = writeln!(self.text, "  // {line}");
                }
            }
        }
        let _ = writeln!(self.text, "{}", wrap(text, indent));
    }

    fn print(mut self, header: &Header, top: bool) -> String {
        self.header(header);
        self.ports();
        if self.module.macro_hook {
            self.with_macro();
        } else {
            self.localparams();
            self.body();
        }
        self.checks(top);
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
            for line in fill(paragraph, WIDTH - "// ".len()) {
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
        if self.module.has_reset() {
            rows.push((
                "input  wire".into(),
                String::new(),
                "rst_n".into(),
                "synchronous reset, active low".into(),
            ));
        }
        for p in &self.module.ports {
            let node = &self.module.nodes[p.node];
            let kind = match (
                p.output,
                self.is_own_port(p.node) && is_stored(self.module, node),
            ) {
                (false, _) => "input  wire",
                (true, true) => "output reg ",
                (true, false) => "output wire",
            };
            let doc = match (p.low_in_reset, p.doc.as_str()) {
                (false, doc) => doc.to_owned(),
                (true, "") => "low in reset".to_owned(),
                (true, doc) => format!("{doc}; low in reset"),
            };
            rows.push((kind.into(), bits(node.ty.width), p.name.clone(), doc));
        }
        let range = rows.iter().map(|r| r.1.len()).max().unwrap_or(0);
        let name = rows.iter().map(|r| r.2.len()).max().unwrap_or(0) + 1;
        let _ = writeln!(self.text, "module {} (", self.module.name);
        let count = rows.len();
        for (i, (kind, bits, port, doc)) in rows.into_iter().enumerate() {
            let comma = if i + 1 < count { "," } else { "" };
            let port = format!("{port}{comma}");
            let port = format!("{kind} {bits:<range$} {port:<name$}");
            let doc = if doc.is_empty() {
                String::new()
            } else {
                format!("  // {doc}")
            };
            let text = wrap(format!("{port}{doc}").trim_end(), 1);
            let _ = writeln!(self.text, "{}", text.trim_end());
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
                    && self.exprs.names.live[*id]
                    && self.exprs.names.ident(*id).is_some()
            })
            .collect();
        if !params.is_empty() {
            self.gap();
        }
        for (id, node) in params {
            let Op::Lit(value) = &node.op else { continue };
            let name = self.exprs.names.ident(id).unwrap_or_default();
            let text = format!(
                "localparam {}{name} = {};{}",
                spaced(node.ty.width),
                constant(value, node),
                comment(node)
            );
            self.line(1, &text);
        }
    }

    /// Whether a node is printed under the name of the output port that it drives.
    fn is_own_port(&self, id: usize) -> bool {
        self.module.ports.iter().any(|p| {
            p.output && p.node == id && self.exprs.names.ident(id) == Some(p.name.as_str())
        })
    }

    fn node(&mut self, id: usize) {
        let node = &self.module.nodes[id];
        let Some(name) = self.exprs.names.ident(id).map(str::to_owned) else {
            return;
        };
        let arrays = self.module.arrays.iter();
        if arrays
            .flat_map(|a| &a.outputs)
            .any(|(_, vector)| *vector == id)
        {
            return;
        }
        let (width, note) = (spaced(node.ty.width), comment(node));
        let own = self.is_own_port(id);
        let rearranged = self.module.rearranged.iter().find(|of| of.node == id);
        if let Some(of) = rearranged.filter(|_| !own).cloned() {
            self.rearranged(&of, &note);
            return;
        }
        match &node.op {
            Op::Input | Op::Lit(_) | Op::InstanceOut(..) => {}
            Op::Reg { .. } | Op::ReadSync(..) => {
                if !own && note.is_empty() {
                    self.declare("reg", node.ty.width, &name);
                } else if !own {
                    self.line(1, &format!("reg {width}{name};{note}"));
                }
            }
            Op::Select(index, options) if is_case(self.module, node) => {
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

    fn outputs(&mut self) {
        let assigns: Vec<_> = self
            .module
            .ports
            .iter()
            .filter(|p| p.output && self.exprs.names.ident(p.node) != Some(p.name.as_str()))
            .map(|p| format!("assign {} = {};", p.name, self.exprs.operand(p.node)))
            .collect();
        if !assigns.is_empty() {
            self.gap();
        }
        for a in assigns {
            self.line(1, &a);
        }
    }

    fn unread(&mut self) {
        let parts = uses::unread(&self.exprs.names);
        if parts.is_empty() {
            return;
        }
        self.gap();
        let why: BTreeSet<_> = self
            .module
            .unused
            .values()
            .filter(|w| !w.is_empty())
            .cloned()
            .collect();
        for line in why.iter().flat_map(|w| fill(w, WIDTH - "  // ".len())) {
            self.line(1, &format!("// {line}"));
        }
        self.line(
            1,
            &format!("wire unused_ok = &{{1'b0, {}}};", parts.join(", ")),
        );
    }
}

/// Whether a node is assigned in a process, and so is a `reg`.
fn is_stored(module: &Module, node: &Node) -> bool {
    matches!(node.op, Op::Reg { .. } | Op::ReadSync(..)) || is_case(module, node)
}

/// Whether a node prints as a `case` statement.
fn is_case(module: &Module, node: &Node) -> bool {
    matches!(node.op, Op::Select(..)) && picked(&module.nodes, node).is_none()
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
