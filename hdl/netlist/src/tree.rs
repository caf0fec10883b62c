//! A hierarchy of modules with global node numbers.

use super::Module;
use super::node::Op;

/// A module instance in the hierarchy.
pub(super) struct Unit<'a> {
    pub(super) module: &'a Module,
    /// Parent unit and index of the instance there.
    pub(super) parent: Option<(usize, usize)>,
    pub(super) children: Vec<usize>,
    pub(super) first_node: usize,
    pub(super) first_memory: usize,
}

/// All nodes of a hierarchy, numbered consecutively.
#[derive(Default)]
pub(super) struct Tree<'a> {
    pub(super) units: Vec<Unit<'a>>,
    pub(super) unit_of: Vec<usize>,
    pub(super) memories: usize,
}

impl<'a> Tree<'a> {
    pub(super) fn add(&mut self, module: &'a Module, parent: Option<(usize, usize)>) {
        let index = self.units.len();
        if let Some((parent, _)) = parent {
            self.units[parent].children.push(index);
        }
        self.units.push(Unit {
            module,
            parent,
            children: vec![],
            first_node: self.unit_of.len(),
            first_memory: self.memories,
        });
        let nodes = self.unit_of.len() + module.nodes.len();
        self.unit_of.resize(nodes, index);
        self.memories += module.memories.len();
        for (i, inst) in module.instances.iter().enumerate() {
            self.add(&inst.module, Some((index, i)));
        }
    }

    pub(super) fn find(&self, node: usize) -> (&Unit<'a>, usize) {
        let unit = &self.units[self.unit_of[node]];
        (unit, node - unit.first_node)
    }

    /// Nodes with a combinational path to this one.
    pub(super) fn needs(&self, node: usize) -> Vec<usize> {
        let (unit, id) = self.find(node);
        match &unit.module.nodes[id].op {
            Op::Input => {
                let Some((parent, instance)) = unit.parent else {
                    return vec![];
                };
                let parent = &self.units[parent];
                let inputs = parent.module.instances[instance].inputs.iter();
                let mut here = inputs.filter(|(port, _)| unit.module.ports[*port].node == id);
                here.next()
                    .map(|(_, n)| parent.first_node + n)
                    .into_iter()
                    .collect()
            }
            Op::InstanceOut(instance, port) => {
                let child = &self.units[unit.children[*instance]];
                vec![child.first_node + child.module.ports[*port].node]
            }
            op => {
                let operands = op.operands().into_iter();
                operands.map(|n| unit.first_node + n).collect()
            }
        }
    }
}
