//! Memories of a hierarchy, for memory compilers.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::Module;
use super::node::{Node, Op};

/// A memory of a hierarchy. One whose module contains nothing else, and reads at the clock edge, can
/// be replaced by a compiled macro.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MemoryMacro {
    /// The module's name.
    pub module: String,
    /// Whether the text has a place for a macro.
    pub has_hook: bool,
    /// Words.
    pub words: u32,
    /// Width of a word in bits.
    pub bits: u32,
    /// Ports that write or read, one access a clock.
    pub read_writes: u32,
    /// Write ports.
    pub writes: u32,
    /// Read ports.
    pub reads: u32,
    /// Number of instances in the hierarchy.
    pub count: u32,
}

impl Module {
    /// The memory macros of the module and its hierarchy, by name.
    #[must_use]
    pub fn memory_macros(&self) -> Vec<MemoryMacro> {
        let mut found = BTreeMap::new();
        self.count_macros(&mut found);
        found.into_values().collect()
    }

    /// Memories of the module and its hierarchy that no macro can replace: those with combinational
    /// reads, or with other logic in their module. By name, one entry for each memory of a module.
    #[must_use]
    pub fn memories_in_logic(&self) -> Vec<MemoryMacro> {
        let mut found = BTreeMap::new();
        self.count_in_logic(&mut found);
        found.into_values().collect()
    }

    fn count_in_logic(&self, found: &mut BTreeMap<(String, usize), MemoryMacro>) {
        if self.as_macro().is_none() {
            for (at, memory) in self.memories.iter().enumerate() {
                let of_it =
                    |op: &Op| matches!(op, Op::ReadSync(m, ..) | Op::ReadAsync(m, ..) if *m == at);
                let own = MemoryMacro {
                    module: self.name.clone(),
                    has_hook: false,
                    words: memory.depth,
                    bits: memory.width,
                    read_writes: 0,
                    writes: memory.writes.len() as u32,
                    reads: self.nodes.iter().filter(|n| of_it(&n.op)).count() as u32,
                    count: 0,
                };
                found.entry((self.name.clone(), at)).or_insert(own).count += 1;
            }
        }
        for instance in &self.instances {
            instance.module.count_in_logic(found);
        }
    }

    /// The modules of the memory macros in the hierarchy, by name.
    #[must_use]
    pub fn memory_modules(&self) -> BTreeMap<String, Arc<Self>> {
        let mut found = BTreeMap::new();
        for instance in &self.instances {
            let module = &instance.module;
            if module.as_macro().is_some() {
                found.insert(module.name.clone(), module.clone());
            }
            found.extend(module.memory_modules());
        }
        found
    }

    fn count_macros(&self, found: &mut BTreeMap<String, MemoryMacro>) {
        if let Some(own) = self.as_macro() {
            found.entry(self.name.clone()).or_insert(own).count += 1;
        }
        for instance in &self.instances {
            instance.module.count_macros(found);
        }
    }

    fn as_macro(&self) -> Option<MemoryMacro> {
        let [memory] = &self.memories[..] else {
            return None;
        };
        let of = |op: fn(&Op) -> bool| self.nodes.iter().filter(|n| op(&n.op)).count();
        let reads = of(|op| matches!(op, Op::ReadSync(..))) as u32;
        let others = of(|op| matches!(op, Op::ReadAsync(..) | Op::Reg { .. }));
        let writes = memory.writes.len() as u32;
        // A port that writes and reads has one address; others only read.
        let one_address = |(_, address, _): &(usize, usize, usize)| {
            let reads = |n: &Node| matches!(n.op, Op::ReadSync(_, _, from) if from == *address);
            self.nodes.iter().any(reads)
        };
        let shared = writes > 0 && memory.writes.iter().all(one_address);
        let [read_writes, writes, reads_alone] = match shared {
            true => [writes, 0, reads.saturating_sub(writes)],
            false => [0, writes, reads],
        };
        (reads > 0 && others == 0 && self.instances.is_empty()).then(|| MemoryMacro {
            module: self.name.clone(),
            has_hook: self.macro_hook,
            words: memory.depth,
            bits: memory.width,
            read_writes,
            writes,
            reads: reads_alone,
            count: 0,
        })
    }
}
