//! One fault, as Yosys lists it.

use schemars::JsonSchema;
use serde::Serialize;

/// One fault in one cell.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Mutant {
    /// Its number in the build, from 1; 0 is none.
    pub number: usize,
    /// The module.
    pub module: String,
    /// What the fault does to the bit: `inv` inverts it, `const0` and `const1` fix it, `cnot0` and
    /// `cnot1` invert it while another bit of the port is 0 or 1.
    pub mode: String,
    /// Port of the cell, and its bit.
    pub bit: String,
    /// The wire that the bit is, where it has a name.
    pub wire: Option<String>,
    /// Places in the Verilog: file, line and column.
    pub places: Vec<String>,
    /// The Yosys command.
    #[serde(skip)]
    pub command: String,
}

impl Mutant {
    /// Reads a line of `mutate -list`.
    pub(crate) fn parse(number: usize, line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let all = |key: &str| -> Vec<&str> {
            let pairs = words.windows(2).filter(|pair| pair[0] == key);
            pairs.map(|pair| pair[1]).collect()
        };
        let one = |key: &str| all(key).first().map(|value| plain(value).to_owned());
        let wire = one("-wire").map(|wire| match one("-wirebit") {
            Some(bit) => format!("{wire}[{bit}]"),
            None => wire,
        });
        Some(Self {
            number,
            module: one("-module")?,
            mode: one("-mode")?,
            bit: format!("{}[{}]", one("-port")?, one("-portbit")?),
            wire,
            places: all("-src").into_iter().map(file_and_line).collect(),
            command: line.trim().to_owned(),
        })
    }

    /// What and where, in a line.
    #[must_use]
    pub fn what(&self) -> String {
        let place = self.places.first().map_or("?", String::as_str);
        let wire = self.wire.as_deref().map(|w| format!(" ({w})"));
        let (mode, bit) = (&self.mode, &self.bit);
        format!("{place}: {mode} {bit}{}", wire.unwrap_or_default())
    }
}

/// A name without the mark of a public one.
fn plain(name: &str) -> &str {
    name.strip_prefix('\\').unwrap_or(name)
}

/// A place without its folders and its end.
fn file_and_line(place: &str) -> String {
    let place = place.rsplit('/').next().unwrap_or(place);
    place.split('-').next().unwrap_or(place).to_owned()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_line_is_read() {
        let line = "mutate -mode cnot1 -module \\unit -cell $procdff$893 -port Q -portbit 8 \
                    -ctrlbit 2 -wire \\weight -wirebit 8 -src a/unit.v:101.14-101.23 \
                    -src a/unit.v:109.3-119.6\n";
        let mutant = Mutant::parse(7, line).unwrap();
        assert_eq!(mutant.what(), "unit.v:101.14: cnot1 Q[8] (weight[8])");
        assert_eq!((mutant.number, &*mutant.module), (7, "unit"));
        assert_eq!(mutant.command, line.trim());
        assert!(Mutant::parse(1, "mutate -mode none").is_none());
    }
}
