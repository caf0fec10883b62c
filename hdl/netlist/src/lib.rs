//! Netlists that ordinary Rust code builds at run time, because every parameter comes from a file.
//!
//! Each node has an explicit width and signedness, and operands must agree. The printed Verilog
//! therefore never depends on context rules. Registers have reset values, memories are explicit,
//! and modules are shared by identity.
//!
//! | task | item |
//! |---|---|
//! | build a module | [`ModuleBuilder`], whose `finish` checks it |
//! | prove that sums do not overflow | [`ranges`] |
//! | print it as Verilog-2005 | [`verilog`] |
//! | print loops and indices instead of repetition | [`ModuleBuilder::array`], `transpose`, `every`, `spread`, `indexed`, `as_values` |
//! | run it, cycle by cycle | [`Interpreter`] |
//! | bound the error of dropped bits over sets of inputs | [`IntervalInterpreter`] |
//! | state what always holds, for proofs and simulation | [`ModuleBuilder::begin_checks`], `assert`, `assume`, `cover` |
//! | inject a fault | [`Fault`] |
//! | tell whether it has changed | [`Module::digest`] |
//!
//! ```
//! use potamoi_netlist::{Header, Interpreter, ModuleBuilder, Ty, verilog};
//!
//! let mut m = ModuleBuilder::new("counter");
//! let up = m.input("up", Ty::bit(), "counts");
//! let count = m.reg("count", Ty::u(8), 0);
//! let one = m.lit(1, Ty::u(8));
//! let next = m.add(count, one);
//! m.set_next_if(count, up, next);
//! m.output("value", count, "so far");
//! let counter = m.finish()?;
//!
//! let mut run = Interpreter::new(&counter, 1);
//! let [reset, up, value] = ["rst_n", "up", "value"].map(|name| run.port(name).unwrap());
//! for (in_reset, counts) in [(0, 0), (1, 1), (1, 1)] {
//!     run.set_u64(reset, in_reset)?;
//!     run.set_u64(up, counts)?;
//!     run.clock()?;
//! }
//! run.eval()?;
//! assert_eq!(run.get_u64(value)?, 2);
//! assert!(verilog(&counter, &Header::default())["counter.v"].contains("always @(posedge clk)"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod builder;
mod check;
mod checks;
mod digest;
mod error_analysis;
mod fault;
mod interpret;
mod keywords;
mod memories;
mod node;
mod prefix;
mod print;
mod range;
mod repetition;
mod tree;

use std::collections::BTreeMap;
use std::fmt;

use thiserror::Error;

pub use builder::{Feed, InstanceArray, ModuleBuilder};
pub use checks::{CheckInfo, CheckKind, every_index};
pub use digest::Digest;
pub use error_analysis::IntervalInterpreter;
pub use fault::{Change, Fault, FaultError};
pub use interpret::{InterpretError, Interpreter, PortHandle};
pub use memories::MemoryMacro;
pub use node::{Binary, Op, Unary};
pub use node::{Instance, MemId, Signal, Ty};
pub use print::{Header, check_modules, verilog};
pub use range::Interval;
pub(crate) use range::ModuleRanges;
pub use range::{Ranges, ranges};

use node::{Contract, Inst, Memory, Node, Port};
use repetition::{Array, Rearranged};

/// A complete module.
#[derive(Debug, Clone)]
pub struct Module {
    pub(crate) name: String,
    pub(crate) doc: String,
    /// Operands precede the nodes that use them, except for the inputs of registers and memories.
    pub(crate) nodes: Vec<Node>,
    pub(crate) ports: Vec<Port>,
    pub(crate) memories: Vec<Memory>,
    pub(crate) instances: Vec<Inst>,
    pub(crate) arrays: Vec<Array>,
    pub(crate) rearranged: Vec<Rearranged>,
    pub(crate) contracts: Vec<Contract>,
    pub(crate) sections: Vec<String>,
    pub(crate) unused: BTreeMap<usize, String>,
    /// Set when the module is complete.
    pub(crate) clocked: bool,
    /// Whether the text has a place for a macro instead of the memory.
    pub(crate) macro_hook: bool,
    /// Whether what a read returns of a word that is written at the same edge does not matter.
    pub(crate) no_read_during_write: bool,
    pub(crate) registers: bool,
    pub(crate) checks: checks::Checks,
}

/// Description of a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortInfo {
    /// Name.
    pub name: String,
    /// Type of its values.
    pub ty: Ty,
    /// Whether it is an output.
    pub output: bool,
    /// What it is for.
    pub doc: String,
}

impl Module {
    /// The module's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Ports in order of declaration, without `clk` and `rst_n`.
    #[must_use]
    pub fn ports(&self) -> Vec<PortInfo> {
        self.ports
            .iter()
            .map(|p| PortInfo {
                name: p.name.clone(),
                ty: self.nodes[p.node].ty,
                output: p.output,
                doc: p.doc.clone(),
            })
            .collect()
    }

    /// Instances in the module itself, as pairs of a name in the text and the module's name. The name
    /// of an element of an array is its scope, as `bank[3]`, within which the instance is the only one.
    pub fn instances(&self) -> impl Iterator<Item = (String, &str)> {
        self.instances.iter().enumerate().map(|(at, own)| {
            let scope = self.arrays.iter().find_map(|array| array.scope(at));
            (scope.unwrap_or_else(|| own.name.clone()), own.module.name())
        })
    }

    /// The module without the gates that keep ports low in reset: its behaviour while `rst_n` is
    /// high.
    #[must_use]
    pub fn without_reset_gates(&self) -> Self {
        let mut module = self.clone();
        for port in module.ports.iter_mut().filter(|p| p.low_in_reset) {
            port.low_in_reset = false;
            if let Op::Binary(_, _, otherwise) = module.nodes[port.node].op {
                port.node = otherwise;
                let own = &mut module.nodes[otherwise];
                // An input keeps its name: it is a port itself.
                if !matches!(own.op, Op::Input) {
                    own.name = own.name.take().map(|_| port.name.clone());
                }
            }
        }
        module
    }

    /// Whether the module or its hierarchy has state, and thus a `clk` port.
    #[must_use]
    pub const fn is_clocked(&self) -> bool {
        self.clocked
    }

    /// Whether reset affects a register or another node of the module or its hierarchy, and thus
    /// the module has an `rst_n` port.
    #[must_use]
    pub const fn has_reset(&self) -> bool {
        self.registers
    }
}

/// A fault of a netlist's construction.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("module {module}: {node}: {problem}")]
pub struct IrError {
    /// The module.
    pub module: String,
    /// The node, port, memory or instance.
    pub node: String,
    /// The problem, and what was expected.
    pub problem: String,
}

/// All faults found in a netlist.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub struct IrErrors(pub Vec<IrError>);

impl fmt::Display for IrErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, e) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{e}")?;
        }
        Ok(())
    }
}
