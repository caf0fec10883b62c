//! Many modules side by side in one, over inputs that they share.

use std::sync::Arc;

use potamoi_netlist::{Module, ModuleBuilder, Ty};

use super::generate::{AMOUNTS, WIDTHS};

/// The inputs that the wrapper shares among its modules: their names and types.
pub(crate) fn pool() -> Vec<(String, Ty)> {
    let mut all = vec![];
    for width in WIDTHS {
        for signed in [false, true] {
            for copy in 0..2 {
                let ty = Ty { width, signed };
                all.push((format!("in_{ty}_{copy}"), ty));
            }
        }
    }
    for bits in AMOUNTS.into_iter().flatten() {
        all.push((format!("amount_{bits}"), Ty::u(*bits)));
    }
    all.push(("init".to_owned(), Ty::bit()));
    all.push(("init_row".to_owned(), Ty::u(3)));
    all
}

/// All modules side by side: the inputs are one vector, the outputs one each.
pub(crate) fn wrapper(modules: &[Arc<Module>]) -> Arc<Module> {
    let mut b = ModuleBuilder::new("all_random");
    let pool = pool();
    let inputs: Vec<_> = pool
        .iter()
        .map(|(name, ty)| (name.clone(), b.input(name, *ty, "")))
        .collect();
    for (i, module) in modules.iter().enumerate() {
        let ports = module.ports();
        let given: Vec<_> = ports
            .iter()
            .filter(|p| !p.output)
            .filter_map(|p| inputs.iter().find(|(n, _)| *n == p.name))
            .map(|(n, s)| (n.as_str(), *s))
            .collect();
        let name = format!("m{i}");
        let inst = b.instance(&name, module, &given);
        for port in ports.iter().filter(|p| p.output) {
            let s = b.out(inst, &port.name);
            b.output(&format!("{name}_{}", port.name), s, "");
        }
    }
    for (_, s) in inputs {
        b.unused(s, "shared by random modules");
    }
    b.finish()
        .unwrap_or_else(|e| panic!("the wrapper is refused: {e}"))
}
