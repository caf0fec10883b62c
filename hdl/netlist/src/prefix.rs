//! Hierarchies with other module names, so that two configurations meet in one design.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::Module;

impl Module {
    /// A copy of the hierarchy in which `prefix` stands before the name of every module.
    #[must_use]
    pub fn prefixed(self: &Arc<Self>, prefix: &str) -> Arc<Self> {
        copy(self, prefix, &mut BTreeMap::new())
    }
}

/// Copies modules, and keeps them shared: `done` maps addresses to copies.
fn copy(
    module: &Arc<Module>,
    prefix: &str,
    done: &mut BTreeMap<usize, Arc<Module>>,
) -> Arc<Module> {
    let address = Arc::as_ptr(module) as usize;
    if let Some(copy) = done.get(&address) {
        return copy.clone();
    }
    let mut own = Module::clone(module);
    own.name = format!("{prefix}{}", module.name);
    for instance in &mut own.instances {
        instance.module = copy(&instance.module, prefix, done);
    }
    let own = Arc::new(own);
    done.insert(address, own.clone());
    own
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::{Header, ModuleBuilder, Ty, verilog};

    #[test]
    fn every_module_and_instance_has_the_prefix() {
        let mut m = ModuleBuilder::new("low");
        let a = m.input("a", Ty::u(4), "operand");
        m.output("y", a, "result");
        let low = m.finish().unwrap();
        let mut m = ModuleBuilder::new("top");
        let a = m.input("a", Ty::u(4), "operand");
        let part = m.instance("part", &low, &[("a", a)]);
        let y = m.out(part, "y");
        m.output("y", y, "result");
        let top = m.finish().unwrap().prefixed("npu0_");
        let files = verilog(&top, &Header::default());
        let names: Vec<_> = files.keys().map(String::as_str).collect();
        assert_eq!(names, ["npu0_low.v", "npu0_top.v"]);
        assert!(files["npu0_top.v"].contains("npu0_low part ("));
    }
}
