//! Boolean functions of Liberty files, as truth tables.

/// Largest number of variables.
pub const MAX_VARIABLES: usize = 12;
/// Largest depth of parentheses; cells have a handful.
const MAX_DEPTH: u32 = 64;

/// Truth table: one bit for each assignment; variable 0 is the lowest bit of the index.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Truth(Vec<u64>);

impl Truth {
    /// Parses `!` or `'` (highest precedence), `^`, `&`, `*` or a blank, `|` or `+` (lowest),
    /// constants and parentheses, as in Liberty.
    ///
    /// # Errors
    /// The expected and the found text.
    pub fn parse(text: &str, names: &[&str]) -> Result<Self, String> {
        if names.len() > MAX_VARIABLES {
            let count = names.len();
            return Err(format!(
                "expected a function of at most {MAX_VARIABLES} pins, found {count}"
            ));
        }
        Self::read(text, names, names.len())
    }

    /// Checks that the text is a function of some of these pins, however many.
    ///
    /// # Errors
    /// The expected and the found text.
    pub fn check(text: &str, names: &[&str]) -> Result<(), String> {
        Self::read(text, names, 0).map(drop)
    }

    fn read(text: &str, names: &[&str], variables: usize) -> Result<Self, String> {
        let mut reader = Reader {
            rest: text,
            names,
            variables,
            depth: 0,
        };
        let truth = reader.sum()?;
        match reader.peek() {
            None => Ok(truth),
            Some(c) => Err(format!("expected an operator in `{text}`, found `{c}`")),
        }
    }

    /// The value where variable `i` is bit `i`.
    #[inline]
    #[must_use]
    pub fn at(&self, bits: usize) -> bool {
        self.0[bits >> 6] >> (bits & 63) & 1 == 1
    }

    /// The function without its last variable, which is always another one's complement.
    #[must_use]
    pub fn with_last_as_complement(&self, of: usize, variables: usize) -> Self {
        let last = variables - 1;
        Self::by(last, |bits| {
            self.at(bits | usize::from(bits >> of & 1 == 0) << last)
        })
    }

    /// Tabulates a function of so many variables.
    #[must_use]
    pub fn by(variables: usize, value: impl Fn(usize) -> bool) -> Self {
        let mut words = vec![0; (1usize << variables).div_ceil(64)];
        for bits in (0..1 << variables).filter(|bits| value(*bits)) {
            words[bits >> 6] |= 1 << (bits & 63);
        }
        Self(words)
    }
}

struct Reader<'a> {
    rest: &'a str,
    names: &'a [&'a str],
    /// Number of names, or `None` where no table is wanted.
    variables: usize,
    depth: u32,
}

impl Reader<'_> {
    fn peek(&mut self) -> Option<char> {
        self.rest = self.rest.trim_start();
        self.rest.chars().next()
    }

    fn take(&mut self, wanted: &[char]) -> bool {
        let is_here = self.peek().is_some_and(|c| wanted.contains(&c));
        if is_here {
            // All that is looked for is of one byte.
            self.rest = &self.rest[1..];
        }
        is_here
    }

    fn sum(&mut self) -> Result<Truth, String> {
        let mut left = self.product()?;
        while self.take(&['|', '+']) {
            left = both(&left, &self.product()?, |a, b| a | b);
        }
        Ok(left)
    }

    fn product(&mut self) -> Result<Truth, String> {
        let mut left = self.difference()?;
        loop {
            // What follows without an operator is a factor too.
            let is_factor = self.take(&['&', '*'])
                || self
                    .peek()
                    .is_some_and(|c| c == '!' || c == '(' || is_of_name(c));
            if !is_factor {
                return Ok(left);
            }
            left = both(&left, &self.difference()?, |a, b| a & b);
        }
    }

    fn difference(&mut self) -> Result<Truth, String> {
        let mut left = self.factor()?;
        while self.take(&['^']) {
            left = both(&left, &self.factor()?, |a, b| a ^ b);
        }
        Ok(left)
    }

    fn factor(&mut self) -> Result<Truth, String> {
        let mut signs = 0;
        while self.take(&['!']) {
            signs += 1;
        }
        let mut inner = if self.take(&['(']) {
            self.depth += 1;
            if self.depth > MAX_DEPTH {
                return Err(format!(
                    "expected at most {MAX_DEPTH} parentheses within each other"
                ));
            }
            let inner = self.sum()?;
            if !self.take(&[')']) {
                return Err(self.wrong("`)`"));
            }
            self.depth -= 1;
            inner
        } else {
            self.variable()?
        };
        while self.take(&['\'']) {
            signs += 1;
        }
        if signs % 2 == 1 {
            let values = 1usize << self.variables;
            let mask = if values < 64 {
                (1 << values) - 1
            } else {
                u64::MAX
            };
            inner.0.iter_mut().for_each(|w| *w = !*w & mask);
        }
        Ok(inner)
    }

    fn variable(&mut self) -> Result<Truth, String> {
        self.peek();
        let end = self.rest.find(|c| !is_of_name(c));
        let (name, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        if name.is_empty() {
            return Err(self.wrong("a pin"));
        }
        let variables = self.variables;
        let found = match (self.names.iter().position(|n| *n == name), name) {
            (Some(i), _) => Truth::by(variables, |bits| i < variables && bits >> i & 1 == 1),
            (None, "0") => Truth::by(variables, |_| false),
            (None, "1") => Truth::by(variables, |_| true),
            _ => {
                let listed = self.names.iter().take(MAX_VARIABLES).copied();
                let known = listed.chain(["0", "1"]).collect::<Vec<_>>().join(", ");
                let others = match self.names.len().checked_sub(MAX_VARIABLES) {
                    None | Some(0) => String::new(),
                    Some(count) => format!(" and {count} others"),
                };
                return Err(format!("expected one of {known}{others}, found `{name}`"));
            }
        };
        self.rest = rest;
        Ok(found)
    }

    fn wrong(&mut self, expected: &str) -> String {
        match self.peek() {
            Some(c) => format!("expected {expected} in a function, found `{c}`"),
            None => format!("expected {expected} in a function, found its end"),
        }
    }
}

fn is_of_name(c: char) -> bool {
    c.is_ascii_alphanumeric() || "_[]".contains(c)
}

fn both(a: &Truth, b: &Truth, of: fn(u64, u64) -> u64) -> Truth {
    Truth(a.0.iter().zip(&b.0).map(|(a, b)| of(*a, *b)).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn table(text: &str, names: &[&str]) -> Vec<u8> {
        let truth = Truth::parse(text, names).unwrap();
        (0..1 << names.len())
            .map(|bits| u8::from(truth.at(bits)))
            .collect()
    }

    #[test]
    fn operators_bind_as_liberty_says() {
        let names = ["A", "B", "C"];
        for (text, same) in [
            ("A B' + C", "(A & (!B)) | C"),
            ("A ^ B C", "(A ^ B) & C"),
            ("!(A + B)", "!A * !B"),
            ("!A'", "A"),
            ("A | B & C", "A | (B & C)"),
            ("(A)(B)", "A&B"),
            ("!!C", "C"),
            ("A * 1 + 0", "A"),
        ] {
            assert_eq!(table(text, &names), table(same, &names), "{text}");
        }
        assert_eq!(table("(!A) + (!B)", &["A", "B"]), [1, 1, 1, 0]);
        assert_eq!(table("(A ^ B)", &["A", "B"]), [0, 1, 1, 0]);
        assert_eq!(table("1", &[]), [1]);
    }

    #[test]
    fn more_than_six_variables_take_several_words() {
        let names = ["a", "b", "c", "d", "e", "f", "g", "h"];
        let table = table("!(a b c + d e + f g h)", &names);
        for (bits, value) in table.iter().enumerate() {
            let all = |i: &[usize]| i.iter().all(|i| bits >> i & 1 == 1);
            let expected = !(all(&[0, 1, 2]) || all(&[3, 4]) || all(&[5, 6, 7]));
            assert_eq!(*value == 1, expected, "{bits:b}");
        }
    }

    #[test]
    fn a_complement_is_folded_into_its_variable() {
        let truth = Truth::parse("(E D) | (!E !QN)", &["D", "E", "Q", "QN"]).unwrap();
        let folded = truth.with_last_as_complement(2, 4);
        let plain = Truth::parse("(E D) | (!E Q)", &["D", "E", "Q"]).unwrap();
        assert_eq!(folded, plain);
    }

    #[test]
    fn what_is_no_function_is_refused() {
        let deep = "(".repeat(100_000);
        for text in ["", "A +", "(A", "A)", "A & D", "A ? B", "!", &deep] {
            assert!(Truth::parse(text, &["A", "B"]).is_err(), "{text}");
        }
        assert!(Truth::parse("A0", &["A"; MAX_VARIABLES + 1]).is_err());
    }

    /// Functions of more pins than a table could have.
    #[test]
    fn functions_are_checked_without_a_table() {
        let names: Vec<String> = (0..100).map(|i| format!("A{i}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        for text in ["A0", "!(A99 A70' + A3 ^ 1)", "!A0 !A64", "0"] {
            assert_eq!(Truth::check(text, &names), Ok(()), "{text}");
        }
        for (text, why) in [
            ("A99 &", "a pin in a function, found its end"),
            ("A3 ! & A4", "a pin in a function, found `&`"),
            ("A3 + A100", "found `A100`"),
            ("(A3", "`)`"),
        ] {
            let found = Truth::check(text, &names).unwrap_err();
            assert!(found.contains(why), "{text}: {found}");
        }
    }
}
