//! Reads gate-level Verilog in the form that Yosys writes: instances, wires and plain assignments.

use std::collections::BTreeMap;

/// Largest number of bits in a wire and in a module.
const MAX_BITS: u32 = 1 << 24;

/// A connected bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Bit {
    Constant(bool),
    /// A wire, by its number in the module.
    Wire(u32),
}

/// A module as read.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Text {
    /// Ports in order.
    pub(super) ports: Vec<Port>,
    pub(super) bits: u32,
    pub(super) instances: Vec<Instance>,
    /// Assignments: source and target.
    pub(super) assigned: Vec<(Bit, Bit)>,
    /// Named wires, bit by bit.
    pub(super) named: Vec<(String, Bit)>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Port {
    pub(super) name: String,
    pub(super) output: bool,
    /// Bits, lowest first.
    pub(super) bits: Vec<Bit>,
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct Instance {
    pub(super) kind: String,
    /// Pins with connected bits, lowest first; empty where open.
    pub(super) pins: Vec<(String, Vec<Bit>)>,
}

/// Reads the modules of a netlist.
///
/// # Errors
/// The line, the expected and the found text.
pub(super) fn read(text: &str) -> Result<BTreeMap<String, Text>, String> {
    let mut reader = Reader::new(text);
    let mut modules = BTreeMap::new();
    while let Some(word) = reader.next() {
        if word != "module" {
            return Err(reader.wrong("`module`", Some(word)));
        }
        let name = reader.name()?;
        let module = Body::default().read(&mut reader)?;
        modules.insert(name, module);
    }
    Ok(modules)
}

/// Tokens without comments and attributes.
struct Reader<'a> {
    rest: &'a str,
    line: usize,
    ahead: Option<&'a str>,
}

impl<'a> Reader<'a> {
    fn new(text: &'a str) -> Self {
        Self {
            rest: text,
            line: 1,
            ahead: None,
        }
    }

    fn advance(&mut self, bytes: usize) -> &'a str {
        let (past, rest) = self.rest.split_at(bytes);
        self.line += past.bytes().filter(|b| *b == b'\n').count();
        self.rest = rest;
        past
    }

    fn next(&mut self) -> Option<&'a str> {
        if let Some(word) = self.ahead.take() {
            return Some(word);
        }
        loop {
            self.advance(self.rest.len() - self.rest.trim_start().len());
            let end = match self.rest {
                r if r.starts_with("//") => r.find('\n'),
                r if r.starts_with("/*") => r.find("*/").map(|at| at + 2),
                r if r.starts_with("(*") => r.find("*)").map(|at| at + 2),
                _ => break,
            };
            self.advance(end.unwrap_or(self.rest.len()));
        }
        let is_of_word = |c: char| c.is_ascii_alphanumeric() || "_$'".contains(c);
        let first = self.rest.chars().next()?;
        let end = match first {
            '\\' => self.rest.find(char::is_whitespace),
            c if is_of_word(c) => self.rest.find(|c| !is_of_word(c)),
            c => Some(c.len_utf8()),
        };
        Some(self.advance(end.unwrap_or(self.rest.len())))
    }

    fn peek(&mut self) -> Option<&'a str> {
        self.ahead = self.next();
        self.ahead
    }

    fn take(&mut self, wanted: &str) -> bool {
        let is_here = self.peek() == Some(wanted);
        if is_here {
            self.ahead = None;
        }
        is_here
    }

    fn expect(&mut self, wanted: &str) -> Result<(), String> {
        let found = self.next();
        match found == Some(wanted) {
            true => Ok(()),
            false => Err(self.wrong(&format!("`{wanted}`"), found)),
        }
    }

    fn wrong(&self, expected: &str, found: Option<&str>) -> String {
        let found = found.map_or_else(|| "its end".to_owned(), |f| format!("`{f}`"));
        format!(
            "line {} of the netlist: expected {expected}, found {found}",
            self.line
        )
    }

    fn name(&mut self) -> Result<String, String> {
        let word = self.next();
        let plain = |w: &str| w.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        match word {
            Some(w) if plain(w) => Ok(w.to_owned()),
            Some(w) if w.starts_with('\\') => Ok(w[1..].to_owned()),
            other => Err(self.wrong("a name", other)),
        }
    }

    fn number(&mut self) -> Result<u32, String> {
        let word = self.next();
        let number = word.and_then(|w| w.parse().ok());
        number
            .filter(|n| *n < MAX_BITS)
            .ok_or_else(|| self.wrong("a number", word))
    }

    /// Reads `[high:low]`, or one bit.
    fn range(&mut self) -> Result<Option<[u32; 2]>, String> {
        if !self.take("[") {
            return Ok(None);
        }
        let high = self.number()?;
        let low = if self.take(":") { self.number()? } else { high };
        self.expect("]")?;
        match low <= high {
            true => Ok(Some([high, low])),
            false => Err(self.wrong("a range from its highest bit", None)),
        }
    }
}

/// A module under construction.
#[derive(Default)]
struct Body {
    /// First bit and range of each wire.
    wires: BTreeMap<String, (u32, [u32; 2])>,
    directions: BTreeMap<String, bool>,
    module: Text,
}

impl Body {
    fn read(mut self, reader: &mut Reader<'_>) -> Result<Text, String> {
        let mut ports = vec![];
        reader.expect("(")?;
        while !reader.take(")") {
            ports.push(reader.name()?);
            reader.take(",");
        }
        reader.expect(";")?;
        loop {
            match reader.next() {
                Some("endmodule") => break,
                Some("wire") => drop(self.declare(reader)?),
                Some(way @ ("input" | "output")) => {
                    for name in self.declare(reader)? {
                        self.directions.insert(name, way == "output");
                    }
                }
                Some("assign") => {
                    let to = self.value(reader)?;
                    reader.expect("=")?;
                    let from = self.value(reader)?;
                    if to.len() != from.len() {
                        return Err(reader.wrong("as many bits on both sides", None));
                    }
                    self.module.assigned.extend(to.into_iter().zip(from));
                    reader.expect(";")?;
                }
                Some(kind) => self.instance(reader, kind)?,
                None => return Err(reader.wrong("`endmodule`", None)),
            }
        }
        for name in ports {
            let port = match (self.wires.get(&name), self.directions.get(&name)) {
                (Some((first, range)), Some(output)) => Port {
                    bits: bits(*first, *range, *range),
                    output: *output,
                    name,
                },
                _ => return Err(reader.wrong(&format!("a direction of port {name}"), None)),
            };
            self.module.ports.push(port);
        }
        // Yosys's own names begin with an underscore.
        for (name, (first, range)) in self.wires.iter().filter(|(n, _)| !n.starts_with('_')) {
            for (i, bit) in bits(*first, *range, *range).into_iter().enumerate() {
                let name = match range {
                    [0, 0] => name.clone(),
                    [_, low] => format!("{name}[{}]", *low as usize + i),
                };
                self.module.named.push((name, bit));
            }
        }
        Ok(self.module)
    }

    /// Declares wires of one width; a port is also declared as one, before or after.
    fn declare(&mut self, reader: &mut Reader<'_>) -> Result<Vec<String>, String> {
        reader.take("wire");
        let range = reader.range()?.unwrap_or([0, 0]);
        let mut names = vec![];
        loop {
            let name = reader.name()?;
            if !self.wires.contains_key(&name) {
                self.wires.insert(name.clone(), (self.module.bits, range));
                self.module.bits += range[0] - range[1] + 1;
            }
            if self.module.bits > MAX_BITS {
                return Err(reader.wrong("fewer bits in a module", None));
            }
            names.push(name);
            if !reader.take(",") {
                reader.expect(";")?;
                return Ok(names);
            }
        }
    }

    fn instance(&mut self, reader: &mut Reader<'_>, kind: &str) -> Result<(), String> {
        let kind = kind.trim_start_matches('\\').to_owned();
        reader.name()?;
        reader.expect("(")?;
        let mut pins = vec![];
        while !reader.take(")") {
            reader.expect(".")?;
            let pin = reader.name()?;
            reader.expect("(")?;
            let value = match reader.peek() {
                Some(")") => vec![],
                _ => self.value(reader)?,
            };
            reader.expect(")")?;
            pins.push((pin, value));
            reader.take(",");
        }
        reader.expect(";")?;
        self.module.instances.push(Instance { kind, pins });
        Ok(())
    }

    /// Reads bits, lowest first.
    fn value(&self, reader: &mut Reader<'_>) -> Result<Vec<Bit>, String> {
        if reader.take("{") {
            let mut parts = vec![];
            loop {
                parts.push(self.value(reader)?);
                if !reader.take(",") {
                    reader.expect("}")?;
                    break;
                }
            }
            return Ok(parts.into_iter().rev().flatten().collect());
        }
        if reader
            .peek()
            .is_some_and(|w| w.starts_with(|c: char| c.is_ascii_digit()))
        {
            let word = reader.next().unwrap_or_default();
            return constant(word).ok_or_else(|| reader.wrong("a number of 0 and 1", Some(word)));
        }
        let name = reader.name()?;
        let Some((first, range)) = self.wires.get(&name) else {
            return Err(reader.wrong("a wire", Some(&name)));
        };
        let part = reader.range()?.unwrap_or(*range);
        if part[0] > range[0] || part[1] < range[1] {
            return Err(reader.wrong(&format!("bits that {name} has"), None));
        }
        Ok(bits(*first, *range, part))
    }
}

fn bits(first: u32, range: [u32; 2], part: [u32; 2]) -> Vec<Bit> {
    (part[1]..=part[0])
        .map(|bit| Bit::Wire(first + bit - range[1]))
        .collect()
}

/// `4'hf`, `2'b01`, `3'd5`.
fn constant(word: &str) -> Option<Vec<Bit>> {
    let (width, digits) = word.split_once('\'')?;
    let width: usize = width.parse().ok().filter(|w| (1..=1 << 16).contains(w))?;
    let (radix, digits) = digits.split_at_checked(1)?;
    let each = match radix {
        "h" => 4,
        "b" => 1,
        "d" => {
            let number: u64 = digits.parse().ok()?;
            let bit = |i: usize| Bit::Constant(i < 64 && number >> i & 1 == 1);
            return Some((0..width).map(bit).collect());
        }
        _ => return None,
    };
    let mut found = Vec::with_capacity(width);
    for digit in digits.chars().rev() {
        let value = digit.to_digit(1 << each)?;
        found.extend((0..each).map(|i| Bit::Constant(value >> i & 1 == 1)));
    }
    found.resize(width, Bit::Constant(false));
    Some(found)
}

#[cfg(test)]
mod tests;
