//! Fault injection: faults that verification must find.

use std::collections::BTreeMap;
use std::sync::Arc;

use num_bigint::BigInt;
use thiserror::Error;

use super::node::{Binary, Node, Op, Ty};
use super::{Module, check};

/// A fault of one register.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Module that declares the register; all instances are affected.
    pub module: String,
    /// Name of the register, or `name[i]` for value `i` of one that is a vector of values.
    pub register: String,
    /// The change.
    pub change: Change,
}

/// Change of a register.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Change {
    /// One bit of its next value is inverted, whenever it takes one.
    Invert(u32),
    /// Its reset value is another one.
    Reset(BigInt),
    /// One bit of its reset value is inverted.
    ResetBit(u32),
}

/// Why a fault cannot be injected.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("cannot make a fault in register {register} of module {module}: {problem}")]
pub struct FaultError {
    /// The module.
    pub module: String,
    /// The register.
    pub register: String,
    /// The problem, and what was expected.
    pub problem: String,
}

impl Fault {
    /// A copy of the hierarchy of `top` with the fault.
    ///
    /// # Errors
    /// An unknown module or register, or a change that does not fit its width.
    pub fn inject(&self, top: &Arc<Module>) -> Result<Arc<Module>, FaultError> {
        let mut done = BTreeMap::new();
        let mut found = false;
        let faulty = self.rebuild(top, &mut done, &mut found)?;
        if found {
            Ok(faulty)
        } else {
            Err(self.error(format!("{} has no module of that name", top.name)))
        }
    }

    fn error(&self, problem: String) -> FaultError {
        FaultError {
            module: self.module.clone(),
            register: self.register.clone(),
            problem,
        }
    }

    /// Copies modules, and keeps them shared: `done` maps addresses to copies.
    fn rebuild(
        &self,
        module: &Arc<Module>,
        done: &mut BTreeMap<usize, Arc<Module>>,
        found: &mut bool,
    ) -> Result<Arc<Module>, FaultError> {
        let address = Arc::as_ptr(module) as usize;
        if let Some(copy) = done.get(&address) {
            return Ok(copy.clone());
        }
        let mut copy = Module {
            name: module.name.clone(),
            doc: module.doc.clone(),
            nodes: module.nodes.clone(),
            ports: module.ports.clone(),
            memories: module.memories.clone(),
            instances: module.instances.clone(),
            arrays: module.arrays.clone(),
            rearranged: module.rearranged.clone(),
            contracts: module.contracts.clone(),
            sections: module.sections.clone(),
            unused: module.unused.clone(),
            clocked: module.clocked,
            macro_hook: module.macro_hook,
            no_read_during_write: module.no_read_during_write,
            registers: module.registers,
            checks: module.checks.clone(),
        };
        for instance in &mut copy.instances {
            instance.module = self.rebuild(&instance.module, done, found)?;
        }
        if copy.name == self.module {
            self.change(&mut copy)?;
            *found = true;
        }
        let copy = Arc::new(copy);
        done.insert(address, copy.clone());
        Ok(copy)
    }

    /// The name of the register, and the value that is meant of a vector.
    fn place(&self) -> (&str, Option<u32>) {
        let value = self.register.strip_suffix(']');
        let parts = value.and_then(|text| text.rsplit_once('['));
        let parts = parts.and_then(|(name, index)| Some((name, index.parse().ok()?)));
        parts.map_or((&*self.register, None), |(name, index)| (name, Some(index)))
    }

    fn change(&self, module: &mut Module) -> Result<(), FaultError> {
        let live = check::live(module);
        let (name, value) = self.place();
        let named = |(i, n): &(usize, &Node)| {
            n.name.as_deref() == Some(name) && matches!(n.op, Op::Reg { .. }) && live[*i]
        };
        let Some((id, node)) = module.nodes.iter().enumerate().find(named) else {
            return Err(self.error("it has no register of that name".to_owned()));
        };
        let (whole, section) = (node.ty, node.section);
        let (ty, low) = match (value, node.values) {
            (None, _) => (whole, 0),
            (Some(index), Some(width)) if index < whole.width / width => {
                (Ty::u(width), index * width)
            }
            (Some(index), _) => return Err(self.error(format!("it has no value {index}"))),
        };
        match &self.change {
            Change::Reset(value) if *value < ty.min() || *value > ty.max() => {
                Err(self.error(format!("{value} is no value of type {ty}")))
            }
            Change::Reset(_) | Change::ResetBit(_)
                if matches!(module.nodes[id].op, Op::Reg { reset: None, .. }) =>
            {
                Err(self.error("it has no reset".to_owned()))
            }
            Change::Reset(value) => {
                if let Op::Reg {
                    reset: Some(reset), ..
                } = &mut module.nodes[id].op
                {
                    let old = (&*reset >> low) & ((BigInt::from(1) << ty.width) - 1);
                    *reset = match ty == whole {
                        true => value.clone(),
                        false => &*reset + ((value - old) << low),
                    };
                }
                Ok(())
            }
            Change::Invert(bit) | Change::ResetBit(bit) if *bit >= ty.width => {
                Err(self.error(format!("bit {bit}: expected below {}", ty.width)))
            }
            Change::ResetBit(bit) => {
                if let Op::Reg {
                    reset: Some(reset), ..
                } = &mut module.nodes[id].op
                {
                    *reset ^= mask(whole, low + bit);
                }
                Ok(())
            }
            Change::Invert(bit) => {
                let mask = mask(whole, low + bit);
                let plain = |op| Node {
                    op,
                    ty: whole,
                    name: None,
                    note: None,
                    section,
                    exact: false,
                    values: None,
                    indexed: false,
                };
                let lit = module.nodes.len();
                module.nodes.push(plain(Op::Lit(mask)));
                if let Op::Reg {
                    next: Some(next), ..
                } = &mut module.nodes[id].op
                {
                    let right = std::mem::replace(next, lit + 1);
                    let wrong = Op::Binary(Binary::Xor, right, lit);
                    module.nodes.push(plain(wrong));
                }
                Ok(())
            }
        }
    }
}

/// A value with one bit set; negative for the sign bit.
fn mask(ty: Ty, bit: u32) -> BigInt {
    let value = BigInt::from(1) << bit;
    if ty.signed && bit + 1 == ty.width {
        -value
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{Header, Interpreter, ModuleBuilder, Ty, verilog};

    /// Two instances of a register.
    fn pair() -> Arc<Module> {
        let mut m = ModuleBuilder::new("stage");
        let d = m.input("d", Ty::s(8), "");
        let q = m.reg("held", Ty::s(8), 3);
        m.set_next(q, d);
        m.output("q", q, "");
        let stage = m.finish().unwrap();
        let mut m = ModuleBuilder::new("pair");
        let d = m.input("d", Ty::s(8), "");
        let first = m.instance("first", &stage, &[("d", d)]);
        let between = m.out(first, "q");
        let second = m.instance("second", &stage, &[("d", between)]);
        let q = m.out(second, "q");
        m.output("q", q, "");
        m.finish().unwrap()
    }

    fn fault(change: Change) -> Fault {
        Fault {
            module: "stage".to_owned(),
            register: "held".to_owned(),
            change,
        }
    }

    /// The output after reset, and two clocks after 5 was given.
    fn run(module: &Arc<Module>) -> [u64; 2] {
        let mut unit = Interpreter::new(module, 1);
        let [reset, d, q] = ["rst_n", "d", "q"].map(|n| unit.port(n).unwrap());
        unit.clock().unwrap();
        unit.set_u64(reset, 1).unwrap();
        unit.set_u64(d, 5).unwrap();
        unit.eval().unwrap();
        let first = unit.get_u64(q).unwrap();
        for _ in 0..2 {
            unit.clock().unwrap();
        }
        unit.eval().unwrap();
        [first, unit.get_u64(q).unwrap()]
    }

    #[test]
    fn every_instance_gets_the_fault_and_the_rest_stays() {
        let right = pair();
        assert_eq!(run(&right), [3, 5]);
        let flipped = fault(Change::Invert(7)).inject(&right).unwrap();
        // Inverted twice on the way.
        assert_eq!(run(&flipped), [3, 5]);
        let reset = fault(Change::Reset(9.into())).inject(&right).unwrap();
        assert_eq!(run(&reset), [9, 5]);
        let bit = fault(Change::ResetBit(2)).inject(&right).unwrap();
        assert_eq!(run(&bit), [7, 5]);
        assert_eq!(run(&right), [3, 5]);
        for (module, text) in [(&flipped, " ^ "), (&reset, "held <= 8'd9")] {
            let files = verilog(module, &Header::default());
            assert_eq!(files.len(), 2);
            assert!(files.iter().any(|(_, t)| t.contains(text)), "{files:?}");
        }
    }

    /// A ring of three values; a fault names one of them.
    #[test]
    fn one_value_of_a_vector_gets_the_fault() {
        let mut m = ModuleBuilder::new("ring");
        let ring = m.reg("places", Ty::u(12), 0x321);
        m.as_values(ring, 4);
        let (low, rest) = (m.slice(ring, 0, 4), m.slice(ring, 4, 8));
        let next = m.cat(&[low, rest]);
        m.set_next(ring, next);
        m.output("value", low, "");
        let right = m.finish().unwrap();
        let text = &verilog(&right, &Header::default())["ring.v"];
        assert!(text.contains("places <= {4'd3, 4'd2, 4'd1};"), "{text}");
        let values = |module: &Arc<Module>| {
            let mut unit = Interpreter::new(module, 1);
            let [reset, value] = ["rst_n", "value"].map(|n| unit.port(n).unwrap());
            unit.clock().unwrap();
            unit.set_u64(reset, 1).unwrap();
            [0; 4].map(|_| {
                unit.eval().unwrap();
                let now = unit.get_u64(value).unwrap();
                unit.clock().unwrap();
                now
            })
        };
        assert_eq!(values(&right), [1, 2, 3, 1]);
        let faulty = |register: &str, change| {
            let fault = Fault {
                module: "ring".to_owned(),
                register: register.to_owned(),
                change,
            };
            fault.inject(&right)
        };
        for (change, expected) in [
            (Change::Reset(9.into()), [1, 9, 3, 1]),
            (Change::ResetBit(3), [1, 10, 3, 1]),
            // What passes the second place is wrong from there on.
            (Change::Invert(3), [1, 2, 11, 9]),
        ] {
            let found = values(&faulty("places[1]", change.clone()).unwrap());
            assert_eq!(found, expected, "{change:?}");
        }
        for (register, said) in [("places[3]", "no value 3"), ("places[x]", "no register")] {
            let error = faulty(register, Change::ResetBit(0))
                .unwrap_err()
                .to_string();
            assert!(error.contains(said), "{error}");
        }
    }

    #[test]
    fn what_is_not_there_is_named() {
        let top = pair();
        let refused = |f: &Fault, text: &str| {
            let error = f.inject(&top).unwrap_err().to_string();
            assert!(error.contains(text), "{error}");
        };
        refused(&fault(Change::Invert(8)), "bit 8: expected below 8");
        refused(&fault(Change::ResetBit(8)), "bit 8: expected below 8");
        refused(&fault(Change::Reset(128.into())), "128 is no value");
        let mut other = fault(Change::Invert(0));
        other.register = "d".to_owned();
        refused(&other, "no register");
        other.module = "nothing".to_owned();
        refused(&other, "no module");
    }
}
