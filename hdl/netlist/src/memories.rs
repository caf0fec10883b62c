//! Memories of a hierarchy, for memory compilers.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::Module;
use super::node::Op;

/// A module that contains one memory with synchronous read ports and nothing else, so that a
/// compiled macro can replace it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MemoryMacro {
    /// The module's name.
    pub module: String,
    /// Words.
    pub words: u32,
    /// Width of a word in bits.
    pub bits: u32,
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
                    words: memory.depth,
                    bits: memory.width,
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
        let reads = of(|op| matches!(op, Op::ReadSync(..)));
        let others = of(|op| matches!(op, Op::ReadAsync(..) | Op::Reg { .. }));
        (reads > 0 && others == 0 && self.instances.is_empty()).then(|| MemoryMacro {
            module: self.name.clone(),
            words: memory.depth,
            bits: memory.width,
            writes: memory.writes.len() as u32,
            reads: reads as u32,
            count: 0,
        })
    }
}
