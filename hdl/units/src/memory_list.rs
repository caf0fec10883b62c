//! The list of memories that goes to a memory compiler.

use potamoi_formats::config::Config;
use potamoi_netlist::{IrErrors, MemoryMacro};
use serde::Serialize;

use crate::units;

/// A memory of a unit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ListedMemory {
    /// Top module of its unit.
    pub unit: String,
    /// Its module.
    pub module: String,
    /// Module that stands in its place where `POTAMOI_MACROS` is defined; none for a memory that is
    /// meant for flip-flops.
    #[serde(rename = "macro")]
    pub in_place: Option<String>,
    /// Number of instances in the unit.
    pub count: u32,
    /// Words.
    pub words: u32,
    /// Width of a word in bits.
    pub bits: u32,
    /// Ports that write or read, one access a clock each.
    pub read_writes: u32,
    /// Ports that only write.
    pub writes: u32,
    /// Ports that only read.
    pub reads: u32,
    /// When a read gives its word.
    pub read: &'static str,
    /// What a read gives of a word that is written at the same edge.
    pub read_during_write: &'static str,
}

impl ListedMemory {
    fn new(unit: &str, own: MemoryMacro, at_edge: bool) -> Self {
        Self {
            unit: unit.to_owned(),
            in_place: own.has_hook.then(|| format!("{}_macro", own.module)),
            module: own.module,
            count: own.count,
            words: own.words,
            bits: own.bits,
            read_writes: own.read_writes,
            writes: own.writes,
            reads: own.reads,
            read: match at_edge {
                true => "after the clock edge, held until the next read",
                false => "in the same clock",
            },
            read_during_write: match (own.read_writes > 0, at_edge) {
                (true, _) => "does not occur",
                (false, true) => "occurs; any word will do",
                (false, false) => "the word from before the edge",
            },
        }
    }

    /// Ports in short: `1rw1r`, `1r1w`.
    #[must_use]
    pub fn ports(&self) -> String {
        let all = [
            (self.read_writes, "rw"),
            (self.reads, "r"),
            (self.writes, "w"),
        ];
        let some = all.into_iter().filter(|(count, _)| *count > 0);
        some.map(|(count, kind)| format!("{count}{kind}")).collect()
    }
}

/// Memories of the units of a configuration, with a prefix before the modules' names; those that a
/// macro replaces first in each unit.
///
/// # Errors
/// The netlists' own checks; none for a configuration that keeps its rules.
pub fn memory_list(config: &Config, prefix: &str) -> Result<Vec<ListedMemory>, IrErrors> {
    let mut all = vec![];
    for unit in units(config)? {
        let own = unit.prefixed(prefix);
        let [edge, logic] = [own.memory_macros(), own.memories_in_logic()];
        let edge = edge.into_iter().map(|memory| (memory, true));
        let logic = logic.into_iter().map(|memory| (memory, false));
        let listed = edge.chain(logic);
        all.extend(listed.map(|(memory, edge)| ListedMemory::new(unit.name(), memory, edge)));
    }
    all.sort_by_key(|memory| (memory.unit.clone(), memory.in_place.is_none()));
    Ok(all)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::path::Path;

    use potamoi_formats::config::PRESETS;

    use super::*;

    fn of(preset: &str) -> Vec<String> {
        let list = memory_list(&Config::preset(preset).unwrap(), "p_").unwrap();
        let line = |m: &ListedMemory| {
            format!(
                "{}: {} of {} x {} {}, {}",
                m.module,
                m.count,
                m.words,
                m.bits,
                m.ports(),
                m.in_place.as_deref().unwrap_or("-")
            )
        };
        list.iter().map(line).collect()
    }

    #[test]
    fn the_table_of_the_book_has_the_memories_of_all_presets() {
        let page =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/how-to/use-the-verilog.md");
        let text = std::fs::read_to_string(&page).unwrap();
        let marks = ["<!-- memories -->\n", "<!-- end of memories -->\n"];
        let (before, rest) = text.split_once(marks[0]).unwrap();
        let (found, after) = rest.split_once(marks[1]).unwrap();
        let mut expected =
            "\n| preset | memory | count | words | bits | ports | read of a word that is \
            written at that edge | macro |\n|---|---|---|---|---|---|---|---|\n"
                .to_owned();
        for (preset, _) in PRESETS {
            for own in memory_list(&Config::preset(preset).unwrap(), "").unwrap() {
                expected += &format!(
                    "| {preset} | `{}` | {} | {} | {} | {} | {} | {} |\n",
                    own.module,
                    own.count,
                    own.words,
                    own.bits,
                    own.ports(),
                    own.read_during_write,
                    own.in_place
                        .map_or("-".to_owned(), |name| format!("`{name}`"))
                );
            }
        }
        expected += "\n";
        if std::env::var_os("POTAMOI_REFRESH").is_some() {
            let whole = [before, marks[0], &expected, marks[1], after].concat();
            return std::fs::write(&page, whole).unwrap();
        }
        assert!(
            found == expected,
            "{} has not today's memories; again: POTAMOI_REFRESH=1 cargo test -p potamoi-units the_table_of_the_book",
            page.display()
        );
    }

    #[test]
    fn memories_of_presets() {
        assert_eq!(
            of("paper"),
            [
                "p_mft_bank: 64 of 512 x 16 1rw1r, p_mft_bank_macro",
                "p_rit_bank: 6 of 128 x 128 1r1w, p_rit_bank_macro",
                "p_feature_fifo: 1 of 4 x 1059 1r1w, -",
                "p_result_fifo: 1 of 3 x 793 1r1w, -",
            ]
        );
        let found = of("feature-major");
        assert!(found.contains(&"p_mft_bank: 32 of 512 x 16 1rw, p_mft_bank_macro".to_owned()));
        assert!(
            found.contains(&"p_lane_slots: 16 of 2 x 16 1r1w, -".to_owned()),
            "{found:?}"
        );
    }
}
