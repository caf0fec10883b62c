//! Expressions of Verilog.

use num_bigint::BigInt;
use potamoi_formats::fixed::Rounding;

use super::names::Names;
use crate::Module;
use crate::node::{Binary, Node, Op, Ty, Unary};
use crate::repetition::{Picked, picked};

/// Widest signed product that Verilator computes, in bits.
const WIDEST_SIGNED_PRODUCT: u32 = 512;

/// Verilog text with its operator precedence.
struct Text {
    text: String,
    /// Top-level operator, if it needs parentheses inside another.
    top: Option<&'static str>,
}

fn atom(text: String) -> Text {
    Text { text, top: None }
}

fn op(text: String, top: &'static str) -> Text {
    Text {
        text,
        top: Some(top),
    }
}

/// Expressions of one module.
pub(super) struct Exprs<'a> {
    pub(super) names: Names<'a>,
}

impl<'a> Exprs<'a> {
    pub(super) fn new(module: &'a Module) -> Self {
        Self {
            names: Names::new(module),
        }
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
        match self.names.ident(id) {
            Some(name) => atom(name.to_owned()),
            None => self.expand(id),
        }
    }

    /// A use inside an operator, in parentheses unless it is atomic or a chain of the same
    /// associative operator.
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

    fn part(&self, id: usize, low: u32, width: u32) -> String {
        range(
            &self.operand(id),
            low,
            width,
            self.names.module.nodes[id].ty.width,
        )
    }

    fn expand(&self, id: usize) -> Text {
        let node = &self.names.module.nodes[id];
        match &node.op {
            Op::OutOfReset => atom("rst_n".to_owned()),
            Op::Input | Op::Reg { .. } | Op::ReadSync(..) | Op::InstanceOut(..) => {
                atom(self.names.ident(id).unwrap_or_default().to_owned())
            }
            Op::Lit(v) => atom(constant(v, node)),
            Op::Unary(Unary::Not, a) if self.is_double_negation(*a) => self.negated(*a),
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
            Op::Binary(Binary::Mul, a, b) => self.product(node.ty, *a, *b),
            Op::Binary(binary, a, b) => self.binary(*binary, *a, *b),
            Op::Shl(a, n) => op(
                format!("{} << {}", self.inside(*a, "<<"), self.inside(*n, "<<")),
                "<<",
            ),
            Op::Shr(a, n) if node.ty.signed => {
                let (value, amount) = (self.signed(*a), self.inside(*n, ">>"));
                atom(format!("$unsigned({value} >>> {amount})"))
            }
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
            Op::Mux(c, t, e) => self.choice(*c, *t, *e),
            Op::Select(index, _) => match picked(&self.names.module.nodes, node) {
                Some(of) => atom(self.picked(of, *index)),
                None => atom(String::new()),
            },
            Op::ReadAsync(m, addr) => atom(format!(
                "{}[{}]",
                self.names.module.memories[*m].name,
                self.operand(*addr)
            )),
        }
    }

    /// The operation of a node that has no name, so that it is written where it is used.
    fn inline(&self, id: usize) -> Option<&Op> {
        let is_inline = self.names.ident(id).is_none();
        is_inline.then(|| &self.names.module.nodes[id].op)
    }

    /// Whether the negation of a conjunction or disjunction has an operand that is negated itself.
    fn is_double_negation(&self, id: usize) -> bool {
        match self.inline(id) {
            Some(Op::Binary(Binary::And | Binary::Or, a, b)) => [*a, *b].into_iter().any(|id| {
                matches!(self.inline(id), Some(Op::Unary(Unary::Not, _)))
                    || self.is_double_negation(id)
            }),
            _ => false,
        }
    }

    /// The negation of a node, by De Morgan where that saves one.
    fn negated(&self, id: usize) -> Text {
        match self.inline(id) {
            Some(Op::Unary(Unary::Not, a)) => self.text(*a),
            Some(Op::Binary(binary @ (Binary::And | Binary::Or), a, b))
                if self.is_double_negation(id) =>
            {
                let symbol = match binary {
                    Binary::And => "|",
                    _ => "&",
                };
                let side = |id| {
                    let t = self.negated(id);
                    match t.top {
                        Some(top) if top != symbol => format!("({})", t.text),
                        _ => t.text,
                    }
                };
                op(format!("{} {symbol} {}", side(*a), side(*b)), symbol)
            }
            _ => op(format!("~{}", self.inside(id, "unary")), "unary"),
        }
    }

    fn picked(&self, of: Picked, index: usize) -> String {
        let (vector, index) = (self.operand(of.vector), self.operand(index));
        indexed(&vector, (of.base, of.stride, of.width), &index)
    }

    fn product(&self, ty: Ty, a: usize, b: usize) -> Text {
        let (x, y) = (self.widened(a, ty.width), self.widened(b, ty.width));
        // Both forms give the same bits; the signed one synthesises to a
        // multiplier of the operands' own widths.
        if ty.signed && ty.width <= WIDEST_SIGNED_PRODUCT {
            atom(format!("$unsigned($signed({x}) * $signed({y}))"))
        } else {
            op(format!("{x} * {y}"), "*")
        }
    }

    fn binary(&self, binary: Binary, a: usize, b: usize) -> Text {
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
        let (x, y) =
            if matches!(binary, Binary::Lt | Binary::Le) && self.names.module.nodes[a].ty.signed {
                (self.signed(a), self.signed(b))
            } else {
                (self.inside(a, symbol), self.inside(b, symbol))
            };
        op(format!("{x} {symbol} {y}"), symbol)
    }

    fn choice(&self, c: usize, t: usize, e: usize) -> Text {
        let condition = self.inside(c, "?");
        let other = self.text(e);
        let other = if other.top.is_none_or(|t| t == "?") {
            other.text
        } else {
            format!("({})", other.text)
        };
        op(
            format!("{condition} ? {} : {other}", self.inside(t, "?then")),
            "?",
        )
    }

    fn widened(&self, a: usize, width: u32) -> String {
        let ty = self.names.module.nodes[a].ty;
        let more = width - ty.width;
        if more == 0 {
            return self.operand(a);
        }
        if !ty.signed || self.is_positive(a) {
            return format!("{{{more}'d0, {}}}", self.operand(a));
        }
        let sign = self.part(a, ty.width - 1, 1);
        if more == 1 {
            return format!("{{{sign}, {}}}", self.operand(a));
        }
        format!("{{{{{more}{{{sign}}}}}, {}}}", self.operand(a))
    }

    /// Whether the sign of a signed value is 0 by its definition.
    fn is_positive(&self, a: usize) -> bool {
        let nodes = &self.names.module.nodes;
        match &nodes[a].op {
            Op::Cast(of) => self.is_positive(*of),
            Op::Extend(of) => !nodes[*of].ty.signed && nodes[*of].ty.width < nodes[a].ty.width,
            Op::Cat(parts) => parts.first().is_some_and(
                |high| matches!(&nodes[*high].op, Op::Lit(value) if *value == BigInt::ZERO),
            ),
            _ => false,
        }
    }

    fn rounded(&self, a: usize, bits: u32, rounding: Rounding) -> Text {
        let ty = self.names.module.nodes[a].ty;
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
        let from = self.names.module.nodes[a].ty;
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

/// The value at `index` of those at equal distances in a vector: base, stride and width.
pub(super) fn indexed(vector: &str, (base, stride, width): (u32, u32, u32), index: &str) -> String {
    let at = match (stride, base) {
        (1, 0) => index.to_owned(),
        (1, _) => format!("{index} + {base}"),
        (_, 0) => format!("{stride} * {index}"),
        _ => format!("{stride} * {index} + {base}"),
    };
    match width {
        1 => format!("{vector}[{at}]"),
        _ => format!("{vector}[{at} +: {width}]"),
    }
}

/// A bit range of an identifier of width `of`.
pub(super) fn range(name: &str, low: u32, width: u32, of: u32) -> String {
    if of == 1 {
        return name.to_owned();
    }
    if width == 1 {
        format!("{name}[{low}]")
    } else {
        format!("{name}[{}:{low}]", low + width - 1)
    }
}

/// The constant of a node, value by value where it is a vector.
pub(super) fn constant(value: &BigInt, node: &Node) -> String {
    let Some(width) = node.values.filter(|width| *width < node.ty.width) else {
        return literal(value, node.ty);
    };
    if width == 1 {
        return format!("{0}'b{value:0>0$b}", node.ty.width as usize);
    }
    let mask = (BigInt::from(1) << width) - 1;
    let all = (0..node.ty.width / width).rev();
    let all: Vec<BigInt> = all.map(|i| (value >> (i * width)) & &mask).collect();
    let short = width <= 64 && all.iter().all(|own| *own < BigInt::from(SHORT));
    let all = all.iter().map(|own| match short {
        true => format!("{width}'d{own}"),
        false => format!("{width}'h{own:x}"),
    });
    format!("{{{}}}", all.collect::<Vec<_>>().join(", "))
}

/// Numbers below it are printed in decimal.
const SHORT: u32 = 10_000;

/// A sized constant: decimal while short, otherwise hexadecimal.
pub(super) fn literal(value: &BigInt, ty: Ty) -> String {
    let modulus = BigInt::from(1) << ty.width;
    let code = if value.sign() == num_bigint::Sign::Minus {
        value + modulus
    } else {
        value.clone()
    };
    match ty.width {
        1 => format!("1'b{code}"),
        w if w <= 64 && code < BigInt::from(SHORT) => format!("{w}'d{code}"),
        w => format!("{w}'h{code:x}"),
    }
}
