//! Ports of the top module, from Verilator's generated header.

use std::fmt;

/// Direction of a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Direction {
    /// Set by the driver.
    Input,
    /// Read by the driver.
    Output,
    /// Both.
    Inout,
}

impl Direction {
    pub(crate) fn word(self) -> &'static str {
        match self {
            Direction::Input => "input",
            Direction::Output => "output",
            Direction::Inout => "inout",
        }
    }

    pub(crate) fn parse(s: &str) -> Option<Self> {
        [Direction::Input, Direction::Output, Direction::Inout]
            .into_iter()
            .find(|d| d.word() == s)
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// One port of the top module.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// Name in the Verilog.
    pub name: String,
    /// Width, at least 1.
    pub bits: u32,
    /// Direction.
    pub dir: Direction,
}

impl Port {
    /// 32-bit words that hold a value of the port (1 for anything up to 32 bits).
    pub fn words(&self) -> usize {
        self.bits.div_ceil(32) as usize
    }

    /// Bytes Verilator stores the port in: 1, 2, 4 or 8, or whole words above 64 bits.
    pub(crate) fn bytes(&self) -> usize {
        match self.bits {
            0..=8 => 1,
            9..=16 => 2,
            17..=32 => 4,
            33..=64 => 8,
            _ => 4 * self.words(),
        }
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.bits == 1 { "" } else { "s" };
        write!(f, "{} {} ({} bit{plural})", self.dir, self.name, self.bits)
    }
}

/// Handle of a port, valid for every model of a library with the same content.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PortId {
    pub(crate) library: u64,
    pub(crate) index: u32,
    pub(crate) bits: u32,
    pub(crate) words: u32,
    pub(crate) dir: Direction,
}

impl PortId {
    /// Width of the port in bits.
    pub fn bits(self) -> u32 {
        self.bits
    }

    /// Direction.
    pub fn direction(self) -> Direction {
        self.dir
    }

    /// 32-bit words that hold a value of the port.
    pub fn words(self) -> usize {
        self.words as usize
    }
}

/// A port with the C++ name of its storage.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Member {
    pub(crate) port: Port,
    pub(crate) cpp: String,
}

/// Widest signal that Verilator allows (`--max-num-width`), in bits.
const WIDEST: u32 = 1 << 16;

/// Parses the ports of Verilator's generated class header, such as `VL_INW(&a,64,0,3);`.
///
/// # Errors
/// The line of an unknown port declaration.
pub(crate) fn parse_header(header: &str) -> Result<Vec<Member>, String> {
    let mut members: Vec<Member> = vec![];
    for line in header.lines().map(str::trim) {
        let found = ["VL_INOUT", "VL_IN", "VL_OUT"]
            .into_iter()
            .find_map(|kind| Some((kind, line.strip_prefix(kind)?)));
        if let Some((kind, rest)) = found.filter(|(_, rest)| rest.contains("(&")) {
            let member = member(kind, rest).filter(|m| members.iter().all(|o| o.cpp != m.cpp));
            members.push(member.ok_or_else(|| line.chars().take(80).collect::<String>())?);
        }
    }
    Ok(members)
}

fn member(kind: &str, rest: &str) -> Option<Member> {
    let (storage, args) = rest.split_once("(&")?;
    let args: Vec<&str> = args.split_once(')')?.0.split(',').map(str::trim).collect();
    let [cpp, msb, lsb, ..] = args[..] else {
        return None;
    };
    let (msb, lsb): (i64, i64) = (msb.parse().ok()?, lsb.parse().ok()?);
    let bits = u32::try_from(msb.abs_diff(lsb)).ok()?.checked_add(1)?;
    let most = match storage {
        "8" => 8,
        "16" => 16,
        "" => 32,
        "64" => 64,
        "W" => WIDEST,
        _ => return None,
    };
    let is_name = !cpp.is_empty() && cpp.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    (bits <= most && is_name).then(|| Member {
        port: Port {
            name: decode(cpp),
            bits,
            dir: match kind {
                "VL_IN" => Direction::Input,
                "VL_OUT" => Direction::Output,
                _ => Direction::Inout,
            },
        },
        cpp: cpp.to_string(),
    })
}

/// Decodes Verilator's names: `__0HH` is the character HH, and `__SYM__` precedes a C++ keyword.
fn decode(cpp: &str) -> String {
    let mut rest = cpp.strip_prefix("__SYM__").unwrap_or(cpp);
    let mut name = String::new();
    while let Some(c) = rest.chars().next() {
        let code = rest
            .strip_prefix("__0")
            .and_then(|r| r.get(..2))
            .and_then(|h| u8::from_str_radix(h, 16).ok());
        match code {
            Some(byte) => {
                name.push(char::from(byte));
                rest = &rest[5..];
            }
            None => {
                name.push(c);
                rest = &rest[c.len_utf8()..];
            }
        }
    }
    name
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn header_lines_become_ports() {
        let got = parse_header(
            "    VL_IN8(&clk,0,0);\n    VL_OUTW(&z,64,0,3);\n    VL_INOUT16(&io,15,0);\n\
             VL_IN64(&a___05Fb,40,0);\n VL_IN8(&__SYM__for,6,0);\n CData& other;\n",
        )
        .unwrap();
        let text: Vec<String> = got.iter().map(|m| m.port.to_string()).collect();
        assert_eq!(
            text,
            [
                "input clk (1 bit)",
                "output z (65 bits)",
                "inout io (16 bits)",
                "input a__b (41 bits)",
                "input for (7 bits)"
            ]
        );
        assert_eq!(got.last().unwrap().cpp, "__SYM__for");
    }

    #[test]
    fn what_verilator_does_not_write_is_no_port() {
        for line in [
            "VL_IN8(&clk,999999999,0);",
            "VL_IN8(&clk,8,0);",
            "VL_INW(&a,70000,0,3);",
            "VL_IN9(&clk,0,0);",
            "VL_IN8(&a b,0,0);",
            "VL_IN8(&clk,x,0);",
            "VL_IN8(&clk",
            "VL_IN8(&clk,0,0); \n VL_IN8(&clk,0,0);",
        ] {
            assert!(parse_header(line).is_err(), "{line}");
        }
    }

    #[test]
    fn storage_follows_the_width() {
        let bytes = |bits| {
            Port {
                name: String::new(),
                bits,
                dir: Direction::Input,
            }
            .bytes()
        };
        let got: Vec<usize> = [1, 8, 9, 16, 17, 32, 33, 64, 65, 96, 97, 1024]
            .map(bytes)
            .to_vec();
        assert_eq!(got, [1, 1, 2, 2, 4, 4, 8, 8, 12, 12, 16, 128]);
    }
}
