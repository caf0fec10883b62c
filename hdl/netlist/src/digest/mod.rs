//! Digest of a module's netlist: equal where two modules compute the same from the same nodes,
//! whatever their names and comments.
//!
//! | counts | does not count |
//! |---|---|
//! | ports: name, direction, type; whether there is `clk` and `rst_n` | names of modules, instances, memories and nodes, and aliases of a node |
//! | live nodes: operation, type, operands in order, constants, reset values | comments, sections, notes, and what a constant is called |
//! | memories that a live node reads: depth, width, writes in order | nodes that reach no output and no instance, memories that none reads |
//! | instances: digest of their module, connections by port name | order in which nodes, ports, memories and instances were made |
//! | | arrays, rearranged bits, vectors of values and indexed selections, which are of the text alone |
//! | | declared ranges and exactness, which restrict inputs and not the netlist |
//!
//! Nodes, memories and instances are numbered by a walk that begins at the outputs by name, so that
//! a number says nothing of how the module was built. Two nodes that compute the same remain two
//! nodes, but for constants. Operands of a commutative operator keep their order, since the printed text has it.
//!
//! [`Digest`] is BLAKE3 of an encoding with a tag for each kind and a length before each list. It is
//! the same on every machine and in every run; [`VERSION`] enters it, and rises with the encoding.

mod encoding;
#[cfg(test)]
mod tests;
mod walk;

use std::collections::BTreeMap;
use std::fmt;

use super::Module;
use encoding::Encoding;

/// Version of the encoding.
const VERSION: &str = "potamoi-netlist-digest 1";
/// Hexadecimal digits of a printed digest.
const DIGITS: usize = 16;

/// Digest of a module's netlist, printed as 16 hexadecimal digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Digest(blake3::Hash);

impl Digest {
    /// All 256 bits.
    #[must_use]
    pub const fn hash(self) -> blake3::Hash {
        self.0
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.to_hex()[..DIGITS])
    }
}

impl Module {
    /// Digest of the module's netlist. It depends on the modules below through their digests.
    #[must_use]
    pub fn digest(&self) -> Digest {
        Digests::default().of(self)
    }

    /// Digests of the module and of all modules in its hierarchy, by name.
    #[must_use]
    pub fn digests(&self) -> BTreeMap<String, Digest> {
        let mut digests = Digests::default();
        let mut found = BTreeMap::new();
        digests.of_hierarchy(self, &mut found);
        found
    }
}

/// Digests by address of the module, since instances share modules.
#[derive(Default)]
struct Digests(BTreeMap<usize, Digest>);

impl Digests {
    fn of(&mut self, module: &Module) -> Digest {
        let address = std::ptr::from_ref(module) as usize;
        if let Some(known) = self.0.get(&address) {
            return *known;
        }
        let children: Vec<Digest> = (module.instances.iter())
            .map(|instance| self.of(&instance.module))
            .collect();
        let mut encoding = Encoding::new(VERSION);
        walk::encode(module, &children, &mut encoding);
        let digest = Digest(encoding.finish());
        self.0.insert(address, digest);
        digest
    }

    fn of_hierarchy(&mut self, module: &Module, found: &mut BTreeMap<String, Digest>) {
        if found.contains_key(&module.name) {
            return;
        }
        found.insert(module.name.clone(), self.of(module));
        for instance in &module.instances {
            self.of_hierarchy(&instance.module, found);
        }
    }
}
