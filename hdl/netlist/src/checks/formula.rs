//! Formulas of checks: text with the names of signals, read as arithmetic on natural numbers.
//!
//! | | |
//! |---|---|
//! | `a -> b` | if a, then b |
//! | `a \| b`, `a & b`, `~a` | of bits |
//! | `==`, `!=`, `<`, `<=`, `>`, `>=` | of numbers of any widths |
//! | `a + b` | never wraps |
//! | `a - b` | modulo the width of the wider |
//! | `if(c, a, b)` | a choice |
//! | `any(a)` | whether a bit is set |
//! | `ones(a)` | number of bits that are set |
//! | `a[3]` | a bit |

/// A parsed formula.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Formula {
    Number(u64),
    Name(String),
    Bit(String, u32),
    Not(Box<Formula>),
    Any(Box<Formula>),
    Ones(Box<Formula>),
    Choice(Box<[Formula; 3]>),
    /// An operator, as written.
    Two(&'static str, Box<[Formula; 2]>),
}

/// Operators by precedence, the loosest first; longer ones before their beginnings.
const LEVELS: [&[&str]; 5] = [
    &["->"],
    &["|"],
    &["&"],
    &["==", "!=", "<=", ">=", "<", ">"],
    &["+", "-"],
];

/// Reads a formula.
///
/// # Errors
/// What is wrong, and where.
pub(crate) fn parse(text: &str) -> Result<Formula, String> {
    let mut reader = Reader { rest: text, text };
    let formula = reader.level(0)?;
    match reader.rest.trim_start() {
        "" => Ok(formula),
        _ => Err(reader.wrong("an operator or the end")),
    }
}

struct Reader<'a> {
    text: &'a str,
    rest: &'a str,
}

impl Reader<'_> {
    fn wrong(&self, expected: &str) -> String {
        let at = self.text.len() - self.rest.trim_start().len();
        format!(
            "formula `{}`, column {}: expected {expected}",
            self.text,
            at + 1
        )
    }

    fn takes(&mut self, token: &str) -> bool {
        let left = self.rest.trim_start().strip_prefix(token);
        self.rest = left.unwrap_or(self.rest);
        left.is_some()
    }

    /// Takes an operator; a minus is not the beginning of an arrow.
    fn operator(&mut self, operator: &str) -> bool {
        let arrow = operator == "-" && self.rest.trim_start().starts_with("->");
        !arrow && self.takes(operator)
    }

    fn expects(&mut self, token: &str) -> Result<(), String> {
        match self.takes(token) {
            true => Ok(()),
            false => Err(self.wrong(&format!("`{token}`"))),
        }
    }

    fn level(&mut self, level: usize) -> Result<Formula, String> {
        let Some(operators) = LEVELS.get(level) else {
            return self.operand();
        };
        let mut left = self.level(level + 1)?;
        while let Some(operator) = operators.iter().find(|operator| self.operator(operator)) {
            // An implication groups to the right.
            let next = level + usize::from(*operator != "->");
            let right = self.level(next)?;
            left = Formula::Two(operator, Box::new([left, right]));
        }
        Ok(left)
    }

    fn operand(&mut self) -> Result<Formula, String> {
        if self.takes("~") {
            return Ok(Formula::Not(Box::new(self.operand()?)));
        }
        if self.takes("(") {
            let inner = self.level(0)?;
            self.expects(")")?;
            return Ok(inner);
        }
        let word = self.word();
        if word.is_empty() {
            return Err(self.wrong("a name, a number or `(`"));
        }
        if word.starts_with(|c: char| c.is_ascii_digit()) {
            let number = word.parse().map(Formula::Number);
            return number.map_err(|_| self.wrong("a number below 2^64 before"));
        }
        match word.as_str() {
            "any" => Ok(Formula::Any(self.argument()?)),
            "ones" => Ok(Formula::Ones(self.argument()?)),
            "if" => {
                self.expects("(")?;
                let condition = self.level(0)?;
                self.expects(",")?;
                let then = self.level(0)?;
                self.expects(",")?;
                let other = self.level(0)?;
                self.expects(")")?;
                Ok(Formula::Choice(Box::new([condition, then, other])))
            }
            _ if self.takes("[") => {
                let index = self.word();
                let index = index.parse().map_err(|_| self.wrong("an index before"))?;
                self.expects("]")?;
                Ok(Formula::Bit(word, index))
            }
            _ => Ok(Formula::Name(word)),
        }
    }

    fn argument(&mut self) -> Result<Box<Formula>, String> {
        self.expects("(")?;
        let inner = self.level(0)?;
        self.expects(")")?;
        Ok(Box::new(inner))
    }

    fn word(&mut self) -> String {
        let rest = self.rest.trim_start();
        let part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let end = rest.find(|c| !part(c)).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        self.rest = rest;
        word.to_owned()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn written(formula: &Formula) -> String {
        match formula {
            Formula::Number(n) => n.to_string(),
            Formula::Name(name) => name.clone(),
            Formula::Bit(name, at) => format!("{name}[{at}]"),
            Formula::Not(a) => format!("~{}", written(a)),
            Formula::Any(a) => format!("any({})", written(a)),
            Formula::Ones(a) => format!("ones({})", written(a)),
            Formula::Choice(all) => {
                let [c, t, e] = all.each_ref().map(written);
                format!("if({c}, {t}, {e})")
            }
            Formula::Two(operator, both) => {
                let [a, b] = both.each_ref().map(written);
                format!("({a} {operator} {b})")
            }
        }
    }

    #[test]
    fn operators_bind_as_in_the_table() {
        for (text, expected) in [
            ("a -> b -> c", "(a -> (b -> c))"),
            ("a | b & ~c", "(a | (b & ~c))"),
            ("a + 1 + b <= c -> d", "(((a + 1) + b) <= c) -> d"),
            ("if(a, b, 3) == any(c)", "(if(a, b, 3) == any(c))"),
            ("ones(a) + b", "(ones(a) + b)"),
            ("a[3]&(b|c)", "(a[3] & (b | c))"),
        ] {
            let found = written(&parse(text).unwrap());
            let expected = expected.to_owned();
            let all = [expected.clone(), format!("({expected})")];
            assert!(all.contains(&found), "{text}: {found}");
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        for (text, said) in [
            ("a &", "column 4: expected a name, a number or `(`"),
            ("a b", "column 3: expected an operator or the end"),
            ("(a", "column 3: expected `)`"),
            ("if(a, b)", "column 8: expected `,`"),
            ("a[b]", "expected an index"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
    }
}
