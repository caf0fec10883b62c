//! Instances of other modules.

use std::sync::Arc;

use super::ModuleBuilder;
use crate::Module;
use crate::node::{Inst, Instance, Op, Signal, Ty};

impl ModuleBuilder {
    /// Instantiates a module with inputs connected by port name. Inputs that depend on the
    /// instance's own outputs are connected later, with [`ModuleBuilder::connect`].
    pub fn instance(
        &mut self,
        name: &str,
        module: &Arc<Module>,
        inputs: &[(&str, Signal)],
    ) -> Instance {
        self.module.instances.push(Inst {
            name: name.to_owned(),
            module: module.clone(),
            inputs: vec![],
            at: self.module.nodes.len(),
        });
        let instance = Instance(self.module.instances.len() - 1);
        for (port, s) in inputs {
            self.connect(instance, port, *s);
        }
        instance
    }

    /// Connects an input of an instance.
    pub fn connect(&mut self, instance: Instance, port: &str, s: Signal) {
        let inst = &self.module.instances[instance.0];
        let (name, module) = (inst.name.clone(), inst.module.clone());
        match module
            .ports
            .iter()
            .position(|p| p.name == port && !p.output)
        {
            None => self.fail(
                &name,
                format!("module {} has no input `{port}`", module.name),
            ),
            Some(i) if module.nodes[module.ports[i].node].ty != s.ty => {
                let (want, got) = (module.nodes[module.ports[i].node].ty, self.describe(s));
                self.fail(
                    &name,
                    format!("port `{port}` is {want}, connected to {got}"),
                );
            }
            Some(i)
                if self.module.instances[instance.0]
                    .inputs
                    .iter()
                    .any(|(p, _)| *p == i) =>
            {
                self.fail(&name, format!("port `{port}` is connected twice"));
            }
            Some(i) => self.module.instances[instance.0].inputs.push((i, s.id)),
        }
    }

    /// An output of an instance.
    pub fn out(&mut self, instance: Instance, port: &str) -> Signal {
        let inst = &self.module.instances[instance.0];
        let (name, module) = (inst.name.clone(), inst.module.clone());
        let Some(i) = module.ports.iter().position(|p| p.name == port && p.output) else {
            self.fail(
                &name,
                format!("module {} has no output `{port}`", module.name),
            );
            return self.zero(Ty::bit());
        };
        let known = self
            .module
            .nodes
            .iter()
            .position(|n| matches!(n.op, Op::InstanceOut(a, b) if a == instance.0 && b == i));
        let ty = module.nodes[module.ports[i].node].ty;
        if let Some(id) = known {
            return Signal { id, ty };
        }
        let s = self.node(Op::InstanceOut(instance.0, i), ty);
        self.module.nodes[s.id].name = Some(format!("{name}_{port}"));
        s
    }
}
