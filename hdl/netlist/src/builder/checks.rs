//! Checks of a module.

use super::ModuleBuilder;
use crate::IrError;
use crate::checks::{Check, CheckKind, Formula, Source, parse};
use crate::keywords::is_keyword;
use crate::node::{Instance, Op, Signal, Ty};

impl ModuleBuilder {
    /// Ends the hardware: all nodes from here on are ghosts, which only checks use. They may read
    /// everything that has a name.
    pub fn begin_checks(&mut self) {
        if self.first_ghost.is_none() {
            self.first_ghost = Some(self.module.nodes.len());
        }
    }

    /// Whether nodes are ghosts now; a fault otherwise.
    fn among_checks(&mut self, what: &str) {
        if self.first_ghost.is_none() {
            let problem = "is part of the checks: call begin_checks first";
            self.fail(what, problem.to_owned());
        }
    }

    /// A property: the formula always holds. `doc` says it in words.
    pub fn assert(&mut self, name: &str, formula: &str, doc: &str) {
        self.check(CheckKind::Assert, name, formula, doc);
    }

    /// A formula that always holds, and is there to support the proof of the others.
    pub fn invariant(&mut self, name: &str, formula: &str, doc: &str) {
        self.check(CheckKind::Invariant, name, formula, doc);
    }

    /// What the module expects of its inputs.
    pub fn assume(&mut self, name: &str, formula: &str, doc: &str) {
        self.check(CheckKind::Assume, name, formula, doc);
    }

    /// A formula that holds at some time.
    pub fn cover(&mut self, name: &str, formula: &str, doc: &str) {
        self.check(CheckKind::Cover, name, formula, doc);
    }

    fn check(&mut self, kind: CheckKind, name: &str, formula: &str, doc: &str) {
        self.among_checks(name);
        let s = self.formula(formula);
        if s.ty() != Ty::bit() {
            self.fail(name, format!("`{formula}` is {}: expected one bit", s.ty()));
        }
        if self.is_fixed(s) {
            // A bound may be that of a register's width; what supports others is then not needed.
            if kind == CheckKind::Invariant {
                return;
            }
            let problem = format!("`{formula}` does not depend on the hardware");
            self.fail(name, problem);
        }
        self.module.checks.list.push(Check {
            kind,
            name: name.to_owned(),
            doc: doc.to_owned(),
            node: s.id,
        });
    }

    /// Any constant.
    pub fn free(&mut self, name: &str, width: u32) -> Signal {
        self.source(name, Ty::u(width), Source::Free)
    }

    /// Whether checks count in this clock, as `checking`: from the first one on that a proof or a
    /// simulation looks at.
    pub fn checking(&mut self) -> Signal {
        self.source("checking", Ty::bit(), Source::Checking)
    }

    /// A signal within an instance, an output or a ghost of its checks too, by its name there. Its own
    /// name is `INSTANCE_NAME`.
    pub fn inside(&mut self, instance: Instance, name: &str) -> Signal {
        let own = format!("{}_{name}", self.module.instances[instance.0].name);
        self.inside_as(&own, instance, name)
    }

    /// As [`Self::inside`], under a name of its own.
    pub fn inside_as(&mut self, own: &str, instance: Instance, name: &str) -> Signal {
        let inst = &self.module.instances[instance.0];
        let checks = &inst.module.checks;
        let nodes = inst.module.nodes.iter().chain(&checks.ghosts);
        let mut nodes = nodes.filter(|n| n.name.as_deref() == Some(name));
        let mut outputs = inst.module.ports.iter().filter(|port| port.output);
        let mut output = || outputs.find(|port| port.name == name);
        let of_output = || output().map(|port| inst.module.nodes[port.node].ty);
        let found = nodes.next().map(|node| node.ty).or_else(of_output);
        let Some(ty) = found else {
            let problem = format!("module {} has no signal `{name}`", inst.module.name);
            self.fail(own, problem);
            return self.zero(Ty::bit());
        };
        let source = Source::Inside {
            instance: instance.0,
            name: name.to_owned(),
        };
        self.source(own, ty, source)
    }

    /// Whether two payloads are the same. Where nothing but registers and memories that treat all bits
    /// alike is between them, one bit stands for all, and a proof may compare that one.
    pub fn same(&mut self, name: &str, a: &str, b: &str) -> Signal {
        self.same_bits(name, a, b, [false, false])
    }

    /// As [`Self::same`], but in a simulation X is the same as X.
    pub fn same_or_x(&mut self, name: &str, a: &str, b: &str) -> Signal {
        self.same_bits(name, a, b, [false, true])
    }

    /// Whether two payloads are the same in all bits. In a simulation X is the same as X.
    pub fn same_in_all_bits(&mut self, name: &str, a: &str, b: &str) -> Signal {
        self.same_bits(name, a, b, [true, true])
    }

    fn same_bits(&mut self, name: &str, a: &str, b: &str, [whole, takes_x]: [bool; 2]) -> Signal {
        let (a, b) = (self.formula(a), self.formula(b));
        if !self.agree(name, a, b) {
            return a;
        }
        let (a, b) = (a.id, b.id);
        self.source(
            name,
            Ty::bit(),
            Source::Same {
                a,
                b,
                whole,
                takes_x,
            },
        )
    }

    fn source(&mut self, name: &str, ty: Ty, source: Source) -> Signal {
        self.among_checks(name);
        let s = self.node(Op::Input, ty);
        self.module.nodes[s.id].name = Some(name.to_owned());
        self.module.checks.sources.insert(s.id, source);
        s
    }

    /// A formula under a name.
    pub fn ghost(&mut self, name: &str, formula: &str) -> Signal {
        self.among_checks(name);
        let s = self.formula(formula);
        let own = self.node(Op::Cast(s.id), s.ty());
        self.module.nodes[own.id].name = Some(name.to_owned());
        own
    }

    /// A ghost register of a module without a reset: it starts with any value, and checks count
    /// from the second clock edge on.
    pub fn ghost_data_reg(&mut self, name: &str, width: u32) -> Signal {
        self.among_checks(name);
        self.data_reg(name, Ty::u(width))
    }

    /// A ghost register, 0 after reset.
    pub fn ghost_reg(&mut self, name: &str, width: u32) -> Signal {
        self.among_checks(name);
        self.reg(name, Ty::u(width), 0)
    }

    /// The next value of a ghost register at clock edges where `enable` holds; numbers that are too
    /// wide for it lose their high bits.
    pub fn ghost_next(&mut self, reg: Signal, enable: &str, next: &str) {
        let enable = (enable != "1").then(|| self.formula(enable));
        let next = self.formula(next);
        let width = reg.width();
        let next = if next.width() > width {
            // The text slices it, and so needs a name.
            let name = format!(
                "{}_next",
                self.module.nodes[reg.id].name.as_deref().unwrap_or("")
            );
            let wide = match self.module.nodes[next.id].name.is_some() || self.has(&name) {
                true => next,
                false => self.name(next, &name),
            };
            self.truncate(wide, width)
        } else {
            self.extend(next, width)
        };
        match enable {
            Some(enable) => self.set_next_if(reg, enable, next),
            None => self.set_next(reg, next),
        }
    }

    /// Whether a signal has this name.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        let mut nodes = self.module.nodes.iter();
        nodes.any(|n| n.name.as_deref() == Some(name))
    }

    /// The signal of this name.
    pub fn named(&mut self, name: &str) -> Signal {
        let mut nodes = self.module.nodes.iter();
        let id = nodes.position(|n| n.name.as_deref() == Some(name));
        let mut ports = self.module.ports.iter();
        let id = id.or_else(|| ports.find(|p| p.name == name).map(|p| p.node));
        match id {
            Some(id) => Signal {
                id,
                ty: self.module.nodes[id].ty,
            },
            None => {
                self.fail(name, "no signal has this name".to_owned());
                self.zero(Ty::bit())
            }
        }
    }

    /// The value of a formula.
    pub fn formula(&mut self, text: &str) -> Signal {
        match parse(text) {
            Ok(formula) => self.value(&formula),
            Err(problem) => {
                self.fail("a formula", problem);
                self.zero(Ty::bit())
            }
        }
    }

    fn value(&mut self, formula: &Formula) -> Signal {
        match formula {
            Formula::Number(n) => {
                let width = n.max(&1).ilog2() + 1;
                self.lit(*n, Ty::u(width))
            }
            Formula::Name(name) => {
                let of = self.named(name);
                match of.ty().signed {
                    true => self.as_unsigned(of),
                    false => of,
                }
            }
            Formula::Bit(name, at) => {
                let of = self.named(name);
                self.bit(of, *at)
            }
            Formula::Not(a) => {
                let a = self.value(a);
                self.not(a)
            }
            Formula::Any(a) => {
                let a = self.value(a);
                self.any(a)
            }
            Formula::Ones(_) | Formula::Two("+", _) => {
                let mut addends = vec![];
                self.addends(formula, &mut addends);
                self.sum(&addends)
            }
            Formula::Choice(all) => {
                let [c, t, e] = all.each_ref().map(|part| self.value(part));
                let (t, e) = self.alike(t, e);
                self.mux(c, t, e)
            }
            Formula::Two(operator, both) => {
                let [a, b] = both.each_ref().map(|part| self.value(part));
                let (a, b) = self.alike(a, b);
                match *operator {
                    "->" => {
                        let not = self.not(a);
                        self.or(not, b)
                    }
                    "|" => self.or(a, b),
                    "&" => self.and(a, b),
                    "==" => self.eq(a, b),
                    "!=" => self.ne(a, b),
                    "<" => self.lt(a, b),
                    "<=" => self.le(a, b),
                    ">" => self.lt(b, a),
                    ">=" => self.le(b, a),
                    _ => self.sub(a, b),
                }
            }
        }
    }

    /// Both at the wider one's width.
    fn alike(&mut self, a: Signal, b: Signal) -> (Signal, Signal) {
        let width = a.width().max(b.width());
        (self.extend(a, width), self.extend(b, width))
    }

    /// The addends of a formula, as many as it is a sum of.
    fn addends(&mut self, formula: &Formula, all: &mut Vec<Signal>) {
        match formula {
            Formula::Two("+", both) => {
                self.addends(&both[0], all);
                self.addends(&both[1], all);
            }
            Formula::Ones(of) => {
                let of = self.value(of);
                for at in 0..of.width() {
                    all.push(self.bit(of, at));
                }
            }
            other => all.push(self.value(other)),
        }
    }

    /// The sum of all, in a width in which it does not wrap.
    fn sum(&mut self, all: &[Signal]) -> Signal {
        let widest = all.iter().map(|s| s.width()).max().unwrap_or(1);
        let width = widest + (all.len().max(1) as u32).next_power_of_two().ilog2();
        let mut all = all.iter();
        let first = match all.next() {
            Some(first) => self.extend(*first, width),
            None => self.zero(Ty::u(width)),
        };
        all.fold(first, |sum, next| {
            let next = self.extend(*next, width);
            self.add(sum, next)
        })
    }

    /// What the checks need of the module's clock and reset, and it does not have.
    pub(super) fn clock_of_checks(&self) -> Option<IrError> {
        let module = &self.module;
        let is_reset = |n: &crate::node::Node| matches!(n.op, Op::Reg { reset: Some(_), .. });
        let problem = if module.checks.list.is_empty() {
            return None;
        } else if !module.clocked {
            "the module has no clock to check at: check its parent"
        } else if !module.registers && module.checks.ghosts.iter().any(is_reset) {
            "the module has no reset, and a ghost register is reset: use ghost_data_reg"
        } else {
            return None;
        };
        Some(IrError {
            module: module.name.clone(),
            node: "checks".to_owned(),
            problem: problem.to_owned(),
        })
    }

    /// Moves the ghosts out of the module's nodes, and checks them.
    pub(super) fn part_from_ghosts(&mut self) -> Vec<IrError> {
        let Some(first) = self.first_ghost else {
            return vec![];
        };
        let ghosts = self.module.nodes.split_off(first);
        let module = &mut self.module;
        module.checks.base = first;
        module.checks.ghosts = ghosts;
        let mut problems = vec![];
        for node in &module.checks.ghosts {
            let name = node.name.clone().unwrap_or_default();
            if matches!(node.op, Op::Reg { next: None, .. }) {
                problems.push((name.clone(), "ghost register is never driven"));
            }
            let hardware = module.nodes.iter();
            let taken = hardware.filter_map(|n| n.name.as_ref());
            if !name.is_empty() && taken.into_iter().any(|own| *own == name) {
                problems.push((name, "a ghost has the name of a signal"));
            }
        }
        let mut seen = std::collections::BTreeSet::new();
        let ghosts = module.checks.ghosts.iter().filter_map(|n| n.name.as_ref());
        for name in ghosts.chain(module.checks.list.iter().map(|c| &c.name)) {
            if !seen.insert(name.clone()) {
                problems.push((name.clone(), "two checks or ghosts have this name"));
            }
            if is_keyword(name) {
                problems.push((name.clone(), "a check or ghost is a keyword"));
            }
        }
        let module = &module.name;
        let problem = |(node, problem): (String, &str)| IrError {
            module: module.clone(),
            node,
            problem: problem.to_owned(),
        };
        problems.into_iter().map(problem).collect()
    }
}
