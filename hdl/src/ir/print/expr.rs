//! Expressions: what is inlined, what gets a wire, and under which name.

use std::collections::BTreeSet;

use num_bigint::BigInt;
use potamoi_formats::fixed::Rounding;

use crate::ir::Module;
use crate::ir::check::{live, read_memories};
use crate::ir::node::{Binary, Op, Ty, Unary};

/// Bits of the widest signed product that Verilator computes.
const WIDEST_SIGNED_PRODUCT: u32 = 512;

/// A piece of Verilog, and how tightly it binds.
struct Text {
    text: String,
    /// The operator at its top, if it needs parentheses inside another.
    top: Option<&'static str>,
}

fn atom(text: String) -> Text {
    Text { text, top: None }
}

/// Names and expressions of one module.
pub(super) struct Exprs<'a> {
    module: &'a Module,
    pub(super) live: Vec<bool>,
    /// The memories that are printed.
    pub(super) read: Vec<bool>,
    /// The identifier of every node that has one.
    names: Vec<Option<String>>,
    /// Bits of each node that something reads.
    used: Vec<Vec<bool>>,
}

impl<'a> Exprs<'a> {
    pub(super) fn new(module: &'a Module) -> Self {
        let live = live(module);
        let mut this = Self {
            module,
            read: read_memories(module, &live),
            live,
            names: vec![None; module.nodes.len()],
            used: module
                .nodes
                .iter()
                .map(|n| vec![false; n.ty.width as usize])
                .collect(),
        };
        this.find_names();
        this.find_uses();
        this
    }

    /// The identifier of a node, if it has one.
    pub(super) fn ident(&self, id: usize) -> Option<&str> {
        self.names[id].as_deref()
    }

    /// Writes to memories that are printed.
    fn writes(&self) -> impl Iterator<Item = &'a (usize, usize, usize)> + use<'a> {
        let memories = self.module.memories.iter().zip(self.read.clone());
        memories
            .filter(|(_, read)| *read)
            .flat_map(|(m, _)| &m.writes)
    }

    fn find_names(&mut self) {
        let nodes = &self.module.nodes;
        let mut uses = vec![0u32; nodes.len()];
        let mut sliced = vec![false; nodes.len()];
        for (id, node) in nodes.iter().enumerate() {
            if !self.live[id] {
                continue;
            }
            for o in node
                .op
                .operands()
                .into_iter()
                .chain(node.op.edge_operands())
            {
                uses[o] += 1;
            }
            match &node.op {
                Op::Slice(a, _) | Op::Round(a, ..) | Op::Saturate(a) => sliced[*a] = true,
                Op::Extend(a) if nodes[*a].ty.signed => sliced[*a] = true,
                Op::Binary(Binary::Mul, a, b) => (sliced[*a], sliced[*b]) = (true, true),
                _ => {}
            }
        }
        for inst in &self.module.instances {
            for (_, n) in &inst.inputs {
                uses[*n] += 1;
            }
        }
        for (en, addr, data) in self.writes() {
            for n in [en, addr, data] {
                uses[*n] += 1;
            }
        }
        for port in self.module.ports.iter().filter(|p| p.output) {
            uses[port.node] += 1;
        }
        // Icarus 11 does not keep an index that is computed in place to its own
        // width: 1'd0 - 1'd1 would be below every row. A name does.
        let mut index = vec![false; nodes.len()];
        for (_, address, _) in self.writes() {
            index[*address] = true;
        }
        for node in nodes {
            if let Op::ReadSync(_, _, address) | Op::ReadAsync(_, address) = node.op {
                index[address] = true;
            }
        }
        // A reinterpretation without a name is its operand.
        for (id, node) in nodes.iter().enumerate().rev() {
            if let (Op::Cast(a), None) = (&node.op, &node.name) {
                uses[*a] += uses[id].saturating_sub(1);
                sliced[*a] |= sliced[id];
                index[*a] |= index[id];
            }
        }
        let mut taken: BTreeSet<String> = ["clk", "rst_n", "unused_ok"].map(str::to_owned).into();
        taken.extend(self.module.ports.iter().map(|p| p.name.clone()));
        taken.extend(self.module.memories.iter().map(|m| m.name.clone()));
        taken.extend(self.module.instances.iter().map(|i| i.name.clone()));
        taken.extend(nodes.iter().filter_map(|n| n.name.clone()));
        for (id, node) in nodes.iter().enumerate() {
            if !self.live[id] && !matches!(node.op, Op::Input) {
                continue;
            }
            if let Some(name) = &node.name {
                self.names[id] = Some(name.clone());
                continue;
            }
            let shared = uses[id] > 1
                && !matches!(
                    node.op,
                    Op::Lit(_) | Op::Cast(_) | Op::Slice(..) | Op::Repeat(..)
                );
            let needed = match &node.op {
                Op::Select(..) | Op::ReadAsync(..) => true,
                Op::Binary(Binary::Mul, ..) | Op::Shr(..) => node.ty.signed || sliced[id],
                Op::Lit(_) | Op::Cast(_) => false,
                Op::Slice(..) | Op::Cat(_) | Op::Repeat(..) => sliced[id],
                _ => sliced[id] || index[id],
            };
            // A literal under a slice is the one thing that a name must be made for.
            let literal = matches!(node.op, Op::Lit(_)) && sliced[id];
            if shared || needed || literal {
                let wish = self.derive(id);
                let name = unique(&wish, &mut taken);
                self.names[id] = Some(name);
            }
        }
    }

    /// A name that says what an unnamed node is.
    fn derive(&self, id: usize) -> String {
        let of = |n: &usize| self.short(*n);
        let name = match &self.module.nodes[id].op {
            Op::Lit(v) => format!("const_{}", v.magnitude()),
            Op::Unary(Unary::Not, a) => format!("not_{}", of(a)),
            Op::Unary(Unary::Neg, a) => format!("minus_{}", of(a)),
            Op::Unary(Unary::Any, a) => format!("any_{}", of(a)),
            Op::Unary(Unary::All, a) => format!("all_{}", of(a)),
            Op::Unary(Unary::Parity, a) => format!("parity_{}", of(a)),
            Op::Binary(op, a, b) => {
                let word = match op {
                    Binary::And => "and",
                    Binary::Or => "or",
                    Binary::Xor => "xor",
                    Binary::Add => "plus",
                    Binary::Sub => "minus",
                    Binary::Mul => "times",
                    Binary::Eq => "is",
                    Binary::Ne => "is_not",
                    Binary::Lt => "below",
                    Binary::Le => "up_to",
                };
                format!("{}_{word}_{}", of(a), of(b))
            }
            Op::Shl(a, _) | Op::Shr(a, _) => format!("{}_shifted", of(a)),
            Op::Slice(a, _) => format!("{}_part", of(a)),
            Op::Cat(parts) => format!("{}_joined", parts.first().map_or_else(String::new, of)),
            Op::Repeat(a, _) => format!("{}_mask", of(a)),
            Op::Extend(a) => format!("{}_wide", of(a)),
            Op::Round(a, ..) => format!("{}_rounded", of(a)),
            Op::Saturate(a) => format!("{}_held", of(a)),
            Op::Mux(c, ..) => format!("by_{}", of(c)),
            Op::Select(i, _) => format!("picked_by_{}", of(i)),
            Op::ReadAsync(m, _) => format!("{}_out", self.module.memories[*m].name),
            Op::Cast(a) => of(a),
            _ => "signal".to_owned(),
        };
        let mut name: String = name.chars().take(32).collect();
        while name.ends_with('_') {
            name.pop();
        }
        name
    }

    fn short(&self, id: usize) -> String {
        if let Some(name) = &self.names[id] {
            return name.clone();
        }
        match &self.module.nodes[id].op {
            Op::Lit(v) => v.magnitude().to_string(),
            Op::Slice(a, low) => format!("{}_{low}", self.short(*a)),
            Op::Cast(a) | Op::Extend(a) | Op::Repeat(a, _) => self.short(*a),
            Op::Unary(Unary::Not, a) => format!("no_{}", self.short(*a)),
            Op::Binary(Binary::Add, a, _) => format!("{}_sum", self.short(*a)),
            Op::Binary(_, a, _) | Op::Unary(_, a) | Op::Round(a, ..) | Op::Saturate(a) => {
                self.short(*a)
            }
            Op::Mux(_, a, _) | Op::Shl(a, _) | Op::Shr(a, _) => self.short(*a),
            Op::Cat(parts) => parts.first().map_or_else(String::new, |p| self.short(*p)),
            _ => "value".to_owned(),
        }
    }

    /// The node whose identifier stands for this one's bits.
    fn base(&self, id: usize) -> usize {
        match (&self.names[id], &self.module.nodes[id].op) {
            (None, Op::Cast(a)) => self.base(*a),
            _ => id,
        }
    }

    fn find_uses(&mut self) {
        let nodes = &self.module.nodes;
        let mut reads: Vec<(usize, u32, u32)> = vec![];
        for (id, node) in nodes.iter().enumerate() {
            if !self.live[id] {
                continue;
            }
            match &node.op {
                Op::Slice(a, low) => reads.push((*a, *low, node.ty.width)),
                Op::Cast(_) if self.names[id].is_none() => {}
                Op::InstanceOut(..) => {}
                // Rounding down or half-up does not look below the dropped bit.
                Op::Round(a, bits, Rounding::Floor) => {
                    reads.push((*a, *bits, nodes[*a].ty.width - bits))
                }
                Op::Round(a, bits, Rounding::HalfUp) => {
                    reads.push((*a, bits - 1, nodes[*a].ty.width - bits + 1))
                }
                op => reads.extend(
                    op.operands()
                        .into_iter()
                        .chain(op.edge_operands())
                        .map(|o| (o, 0, nodes[o].ty.width)),
                ),
            }
        }
        let whole = |n: usize| (n, 0, nodes[n].ty.width);
        reads.extend(
            self.module
                .instances
                .iter()
                .flat_map(|i| &i.inputs)
                .map(|(_, n)| whole(*n)),
        );
        for (en, addr, data) in self.writes() {
            reads.extend([whole(*en), whole(*addr), whole(*data)]);
        }
        reads.extend(
            self.module
                .ports
                .iter()
                .filter(|p| p.output)
                .map(|p| whole(p.node)),
        );
        for (id, low, width) in reads {
            let base = self.base(id);
            for bit in &mut self.used[base][low as usize..(low + width) as usize] {
                *bit = true;
            }
        }
    }

    /// Parts of identifiers that nothing reads, for the lint-clean sink.
    pub(super) fn unread(&self) -> Vec<String> {
        let mut parts = vec![];
        for (id, node) in self.module.nodes.iter().enumerate() {
            let Some(name) = &self.names[id] else {
                continue;
            };
            if matches!(node.op, Op::Lit(_)) {
                continue;
            }
            let used = &self.used[id];
            let mut low = 0;
            while low < used.len() {
                let run = used[low..].iter().take_while(|u| **u == used[low]).count();
                if !used[low] {
                    let whole = run == used.len();
                    parts.push(if whole {
                        name.clone()
                    } else {
                        range(name, low as u32, run as u32, node.ty.width)
                    });
                }
                low += run;
            }
        }
        parts
    }

    /// The defining expression of a node.
    pub(super) fn definition(&self, id: usize) -> String {
        self.expand(id).text
    }

    /// A use of a node.
    pub(super) fn operand(&self, id: usize) -> String {
        self.text(id).text
    }

    fn text(&self, id: usize) -> Text {
        match &self.names[id] {
            Some(name) => atom(name.clone()),
            None => self.expand(id),
        }
    }

    /// A use inside an operator: in parentheses unless it is an atom or a
    /// chain of the same associative operator.
    fn inside(&self, id: usize, operator: &str) -> String {
        let t = self.text(id);
        match t.top {
            Some(top) if !(top == operator && matches!(top, "&" | "|" | "^" | "+")) => {
                format!("({})", t.text)
            }
            _ => t.text,
        }
    }

    fn signed(&self, id: usize) -> String {
        format!("$signed({})", self.operand(id))
    }

    /// The identifier behind a node that is sliced.
    fn sliceable(&self, id: usize) -> String {
        self.operand(id)
    }

    fn part(&self, id: usize, low: u32, width: u32) -> String {
        range(
            &self.sliceable(id),
            low,
            width,
            self.module.nodes[id].ty.width,
        )
    }

    fn expand(&self, id: usize) -> Text {
        let node = &self.module.nodes[id];
        let nodes = &self.module.nodes;
        let op = |text: String, top: &'static str| Text {
            text,
            top: Some(top),
        };
        match &node.op {
            Op::Input | Op::Reg { .. } | Op::ReadSync(..) | Op::InstanceOut(..) => {
                atom(self.names[id].clone().unwrap_or_default())
            }
            Op::Lit(v) => atom(literal(v, node.ty)),
            Op::Unary(unary, a) => {
                let symbol = match unary {
                    Unary::Not => "~",
                    Unary::Neg => "-",
                    Unary::Any => "|",
                    Unary::All => "&",
                    Unary::Parity => "^",
                };
                op(format!("{symbol}{}", self.inside(*a, "unary")), "unary")
            }
            Op::Binary(Binary::Mul, a, b) => {
                let (x, y) = (
                    self.widened(*a, node.ty.width),
                    self.widened(*b, node.ty.width),
                );
                // Both forms give the same bits; the signed one synthesises to a
                // multiplier of the operands' own widths.
                if node.ty.signed && node.ty.width <= WIDEST_SIGNED_PRODUCT {
                    op(format!("$signed({x}) * $signed({y})"), "*")
                } else {
                    op(format!("{x} * {y}"), "*")
                }
            }
            Op::Binary(binary, a, b) => {
                let symbol = match binary {
                    Binary::And => "&",
                    Binary::Or => "|",
                    Binary::Xor => "^",
                    Binary::Add => "+",
                    Binary::Sub => "-",
                    Binary::Mul => "*",
                    Binary::Eq => "==",
                    Binary::Ne => "!=",
                    Binary::Lt => "<",
                    Binary::Le => "<=",
                };
                if matches!(binary, Binary::Lt | Binary::Le) && nodes[*a].ty.signed {
                    return op(
                        format!("{} {symbol} {}", self.signed(*a), self.signed(*b)),
                        symbol,
                    );
                }
                op(
                    format!(
                        "{} {symbol} {}",
                        self.inside(*a, symbol),
                        self.inside(*b, symbol)
                    ),
                    symbol,
                )
            }
            Op::Shl(a, n) => op(
                format!("{} << {}", self.inside(*a, "<<"), self.inside(*n, "<<")),
                "<<",
            ),
            Op::Shr(a, n) if node.ty.signed => op(
                format!("{} >>> {}", self.signed(*a), self.inside(*n, ">>")),
                ">>>",
            ),
            Op::Shr(a, n) => op(
                format!("{} >> {}", self.inside(*a, ">>"), self.inside(*n, ">>")),
                ">>",
            ),
            Op::Slice(a, low) => atom(self.part(*a, *low, node.ty.width)),
            Op::Cat(parts) => {
                let all: Vec<_> = parts.iter().map(|p| self.operand(*p)).collect();
                atom(format!("{{{}}}", all.join(", ")))
            }
            Op::Repeat(a, n) => atom(format!("{{{n}{{{}}}}}", self.operand(*a))),
            Op::Extend(a) => atom(self.widened(*a, node.ty.width)),
            Op::Cast(a) => self.text(*a),
            Op::Round(a, bits, rounding) => self.rounded(*a, *bits, *rounding),
            Op::Saturate(a) => self.saturated(*a, node.ty),
            Op::Mux(c, t, e) => {
                let condition = self.inside(*c, "?");
                let other = self.text(*e);
                let other = if other.top.is_none_or(|t| t == "?") {
                    other.text
                } else {
                    format!("({})", other.text)
                };
                op(
                    format!("{condition} ? {} : {other}", self.inside(*t, "?then")),
                    "?",
                )
            }
            Op::Select(..) => atom(String::new()),
            Op::ReadAsync(m, addr) => atom(format!(
                "{}[{}]",
                self.module.memories[*m].name,
                self.operand(*addr)
            )),
        }
    }

    fn widened(&self, a: usize, width: u32) -> String {
        let ty = self.module.nodes[a].ty;
        let more = width - ty.width;
        if more == 0 {
            return self.operand(a);
        }
        if !ty.signed {
            return format!("{{{more}'d0, {}}}", self.operand(a));
        }
        let sign = self.part(a, ty.width - 1, 1);
        if more == 1 {
            return format!("{{{sign}, {}}}", self.operand(a));
        }
        format!("{{{{{more}{{{sign}}}}}, {}}}", self.operand(a))
    }

    fn rounded(&self, a: usize, bits: u32, rounding: Rounding) -> Text {
        let ty = self.module.nodes[a].ty;
        let kept = ty.width - bits;
        let high = if ty.signed {
            self.part(a, ty.width - 1, 1)
        } else {
            "1'b0".to_owned()
        };
        let floor = format!("{{{high}, {}}}", self.part(a, bits, kept));
        let guard = self.part(a, bits - 1, 1);
        let up = match rounding {
            Rounding::Floor => return atom(floor),
            Rounding::HalfUp => guard,
            Rounding::HalfEven if bits == 1 => format!("{guard} & {}", self.part(a, bits, 1)),
            Rounding::HalfEven => {
                format!(
                    "{guard} & ({} | (|{}))",
                    self.part(a, bits, 1),
                    self.part(a, 0, bits - 1)
                )
            }
        };
        Text {
            text: format!("{floor} + {{{kept}'d0, {up}}}"),
            top: Some("+"),
        }
    }

    fn saturated(&self, a: usize, to: Ty) -> Text {
        let from = self.module.nodes[a].ty;
        let (w, t) = (from.width, to.width);
        let sign = self.part(a, w - 1, 1);
        let max = literal(&to.max(), to);
        let min = literal(&to.min(), to);
        // A reduction of one bit is that bit.
        let reduce = |operator: &str, low: u32, width: u32| {
            let part = self.part(a, low, width);
            if width == 1 {
                part
            } else {
                format!("({operator}{part})")
            }
        };
        let text = match (from.signed, to.signed) {
            (true, true) => {
                let (any, all) = (reduce("|", t - 1, w - t), reduce("&", t - 1, w - t));
                let low = self.part(a, 0, t);
                format!("(~{sign} & {any}) ? {max} : (({sign} & ~{all}) ? {min} : {low})")
            }
            (true, false) if t >= w - 1 => {
                let low = if w > 1 {
                    self.part(a, 0, w - 1)
                } else {
                    "1'b0".to_owned()
                };
                let wide = if t > w - 1 && w > 1 {
                    format!("{{{}'d0, {low}}}", t - (w - 1))
                } else if w == 1 {
                    format!("{t}'d0")
                } else {
                    low
                };
                format!("{sign} ? {min} : {wide}")
            }
            (true, false) => {
                let any = reduce("|", t, w - 1 - t);
                format!("{sign} ? {min} : ({any} ? {max} : {})", self.part(a, 0, t))
            }
            (false, false) => format!("{} ? {max} : {}", reduce("|", t, w - t), self.part(a, 0, t)),
            (false, true) => {
                let low = if t > 1 {
                    format!("{{1'b0, {}}}", self.part(a, 0, t - 1))
                } else {
                    "1'b0".to_owned()
                };
                format!("{} ? {max} : {low}", reduce("|", t - 1, w - t + 1))
            }
        };
        Text {
            text,
            top: Some("?"),
        }
    }
}

fn unique(wish: &str, taken: &mut BTreeSet<String>) -> String {
    let wish = if wish.is_empty() || wish.starts_with(|c: char| c.is_ascii_digit()) {
        format!("v_{wish}")
    } else {
        wish.to_owned()
    };
    let mut name = wish.clone();
    let mut n = 1;
    while !taken.insert(name.clone()) {
        n += 1;
        name = format!("{wish}_{n}");
    }
    name
}

fn range(name: &str, low: u32, width: u32, of: u32) -> String {
    if of == 1 {
        return name.to_owned();
    }
    if width == 1 {
        format!("{name}[{low}]")
    } else {
        format!("{name}[{}:{low}]", low + width - 1)
    }
}

/// A sized constant: decimal while that is short, hexadecimal past it.
pub(super) fn literal(value: &BigInt, ty: Ty) -> String {
    let modulus = BigInt::from(1) << ty.width;
    let code = if value.sign() == num_bigint::Sign::Minus {
        value + modulus
    } else {
        value.clone()
    };
    match ty.width {
        1 => format!("1'b{code}"),
        w if w <= 64 && code < BigInt::from(10_000) => format!("{w}'d{code}"),
        w => format!("{w}'h{code:x}"),
    }
}
