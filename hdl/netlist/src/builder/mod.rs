//! Builds a module node by node.

mod array;
mod checks;
mod choice;
mod contract;
mod instance;
mod logic;
mod state;
mod width;

use std::collections::BTreeMap;
use std::sync::Arc;

use num_bigint::BigInt;

pub use array::{Feed, InstanceArray};

use super::node::{Node, Op, Port, Signal, Ty};
use super::{IrError, IrErrors, Module, check};
use crate::checks::Checks;

/// Builds one module. Misuse never panics: it is recorded, a well-typed placeholder is returned,
/// and [`ModuleBuilder::finish`] reports it.
#[derive(Debug)]
pub struct ModuleBuilder {
    module: Module,
    errors: Vec<IrError>,
    section: usize,
    /// The first node that only checks use.
    first_ghost: Option<usize>,
    /// Whether each node is made of constants only.
    fixed: Vec<bool>,
}

impl ModuleBuilder {
    /// An empty module.
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self {
            module: Module {
                name: name.to_owned(),
                doc: String::new(),
                nodes: vec![],
                ports: vec![],
                memories: vec![],
                instances: vec![],
                arrays: vec![],
                rearranged: vec![],
                contracts: vec![],
                sections: vec![String::new()],
                unused: BTreeMap::new(),
                clocked: false,
                macro_hook: false,
                no_read_during_write: false,
                registers: false,
                checks: Checks::default(),
            },
            errors: vec![],
            section: 0,
            first_ghost: None,
            fixed: vec![],
        }
    }

    /// Sets the description in the module's header.
    pub fn doc(&mut self, text: &str) {
        text.clone_into(&mut self.module.doc);
    }

    /// Lets the text take a macro of a memory compiler instead of the module's memory: where
    /// `POTAMOI_MACROS` is defined, an instance of `NAME_macro` with the same ports stands in place
    /// of the body.
    pub fn macro_hook(&mut self) {
        self.module.macro_hook = true;
    }

    /// States that what a read returns of a word that is written at the same edge does not matter: the
    /// text marks the module's memories `no_rw_check`.
    pub fn no_read_during_write(&mut self) {
        self.module.no_read_during_write = true;
    }

    /// Starts a commented section of the printed body.
    pub fn section(&mut self, title: &str) {
        self.section = self.module.sections.len();
        self.module.sections.push(title.to_owned());
    }

    pub(crate) fn fail(&mut self, what: &str, problem: String) {
        self.errors.push(IrError {
            module: self.module.name.clone(),
            node: what.to_owned(),
            problem,
        });
    }

    /// The type, or one bit if the type is invalid.
    fn legal(&mut self, ty: Ty) -> Ty {
        if (1..=65_536).contains(&ty.width) {
            return ty;
        }
        self.fail("a node", format!("width {}: expected 1 to 65536", ty.width));
        Ty { width: 1, ..ty }
    }

    fn node(&mut self, op: Op, ty: Ty) -> Signal {
        let ty = self.legal(ty);
        let operands = op.operands();
        let fixed = !operands.is_empty()
            && !matches!(op, Op::ReadAsync(..))
            && operands.iter().all(|o| self.fixed[*o]);
        self.fixed.push(fixed || matches!(op, Op::Lit(_)));
        self.module.nodes.push(Node {
            op,
            ty,
            name: None,
            note: None,
            section: self.section,
            exact: false,
            values: None,
            indexed: false,
        });
        Signal {
            id: self.module.nodes.len() - 1,
            ty,
        }
    }

    fn describe(&self, s: Signal) -> String {
        match self.module.nodes.get(s.id).and_then(|n| n.name.as_ref()) {
            Some(name) => format!("{name}: {}", s.ty),
            None => format!("unnamed: {}", s.ty),
        }
    }

    fn zero(&mut self, ty: Ty) -> Signal {
        self.node(Op::Lit(BigInt::ZERO), ty)
    }

    fn agree(&mut self, what: &str, a: Signal, b: Signal) -> bool {
        if a.ty == b.ty {
            return true;
        }
        let (a, b) = (self.describe(a), self.describe(b));
        self.fail(
            what,
            format!("operands differ: {a} and {b}; extend, truncate or reinterpret one"),
        );
        false
    }

    /// An input port.
    pub fn input(&mut self, name: &str, ty: Ty, doc: &str) -> Signal {
        let s = self.node(Op::Input, ty);
        self.module.nodes[s.id].name = Some(name.to_owned());
        self.port(name, s, false, doc);
        s
    }

    /// `rst_n` as a value: 0 during reset, in the same cycle. Registers do not need it.
    pub(crate) fn out_of_reset(&mut self) -> Signal {
        self.node(Op::OutOfReset, Ty::bit())
    }

    /// An output port of one bit that is low during reset: a stream's ready, so that a master
    /// outside the reset keeps its beat.
    pub fn output_low_in_reset(&mut self, name: &str, s: Signal, doc: &str) {
        let up = self.out_of_reset();
        let gated = self.and(up, s);
        self.output(name, gated, doc);
        self.module
            .ports
            .iter_mut()
            .last()
            .into_iter()
            .for_each(|p| p.low_in_reset = true);
    }

    /// An output port.
    pub fn output(&mut self, name: &str, s: Signal, doc: &str) {
        self.port(name, s, true, doc);
    }

    fn port(&mut self, name: &str, s: Signal, output: bool, doc: &str) {
        if self.first_ghost.is_some() {
            let kind = if output { "output" } else { "input" };
            self.fail(name, format!("{kind} after begin_checks"));
            return;
        }
        self.module.ports.push(Port {
            name: name.to_owned(),
            node: s.id,
            output,
            low_in_reset: false,
            doc: doc.to_owned(),
        });
    }

    /// Marks an input as deliberately unused, with the reason.
    pub fn unused(&mut self, s: Signal, why: &str) {
        self.module.unused.insert(s.id, why.to_owned());
    }

    /// A constant.
    pub fn lit(&mut self, value: impl Into<BigInt>, ty: Ty) -> Signal {
        let (value, ty) = (value.into(), self.legal(ty));
        if value < ty.min() || value > ty.max() {
            self.fail("a constant", format!("{value} does not fit {ty}"));
            return self.zero(ty);
        }
        self.node(Op::Lit(value), ty)
    }

    /// A constant that prints as a `localparam`.
    pub fn param(&mut self, name: &str, value: impl Into<BigInt>, ty: Ty, doc: &str) -> Signal {
        let s = self.lit(value, ty);
        self.module.nodes[s.id].name = Some(name.to_owned());
        self.note(s, doc);
        s
    }

    /// Names a signal in the Verilog. Constants are named by [`ModuleBuilder::param`] only.
    pub fn name(&mut self, s: Signal, name: &str) -> Signal {
        if self.constant(s).is_some() {
            return s;
        }
        let node = &mut self.module.nodes[s.id];
        match &node.name {
            None if !matches!(node.op, Op::OutOfReset) => node.name = Some(name.to_owned()),
            Some(old) if old == name => {}
            // A second name for one value is a wire of its own, and `rst_n` has one.
            _ => {
                let alias = self.node(Op::Cast(s.id), s.ty);
                self.module.nodes[alias.id].name = Some(name.to_owned());
                return alias;
            }
        }
        s
    }

    /// Adds a comment at a signal's declaration.
    pub fn note(&mut self, s: Signal, text: &str) -> Signal {
        self.module.nodes[s.id].note = Some(text.to_owned()).filter(|t| !t.is_empty());
        s
    }

    /// Asserts that the node's result never wraps; the range analysis proves it.
    pub fn exact(&mut self, s: Signal) -> Signal {
        self.module.nodes[s.id].exact = true;
        s
    }

    /// Marks a constant, or a register with its reset value, as a vector of values of `width` bits:
    /// the text has them one by one, the highest first.
    pub fn as_values(&mut self, s: Signal, width: u32) -> Signal {
        if width == 0 || !s.width().is_multiple_of(width) || s.ty.signed {
            let of = self.describe(s);
            self.fail(
                "as_values",
                format!("{of} is no vector of {width} bits each"),
            );
            return s;
        }
        self.module.nodes[s.id].values = Some(width);
        s
    }

    /// Checks the module and shares it.
    ///
    /// # Errors
    /// All recorded misuse, and all faults found by the checks.
    pub fn finish(mut self) -> Result<Arc<Module>, IrErrors> {
        let of_ghosts = self.part_from_ghosts();
        let mut errors = std::mem::take(&mut self.errors);
        errors.extend(of_ghosts);
        (self.module.clocked, self.module.registers) = check::state(&self.module);
        if errors.is_empty() {
            errors = check::check(&self.module);
        }
        errors.extend(self.clock_of_checks());
        if errors.is_empty() {
            Ok(Arc::new(self.module))
        } else {
            Err(IrErrors(errors))
        }
    }
}
