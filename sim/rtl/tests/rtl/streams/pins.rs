//! A netlist and its ports by name, on the interpreter.

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_netlist::{Interpreter, Module, PortHandle};

pub(crate) struct Pins {
    run: Interpreter,
    ports: BTreeMap<String, PortHandle>,
}

impl Pins {
    /// Inputs at 0, `rst_n` with them; registers hold what the seed says.
    pub(crate) fn new(module: &Arc<Module>, seed: u64) -> Self {
        let run = Interpreter::new(module, seed);
        let names = module.ports().into_iter().map(|p| p.name);
        let names = names.chain(["rst_n".to_owned()]);
        let ports = names.map(|name| (name.clone(), run.port(&name).unwrap()));
        let ports = ports.collect();
        Self { run, ports }
    }

    pub(crate) fn set(&mut self, name: &str, value: u64) {
        self.run.set_u64(self.ports[name], value).unwrap();
    }

    pub(crate) fn set_words(&mut self, name: &str, words: &[u32]) {
        self.run.set_words(self.ports[name], words).unwrap();
    }

    /// As of the last [`Pins::settle`].
    pub(crate) fn get(&self, name: &str) -> u64 {
        self.run.get_u64(self.ports[name]).unwrap()
    }

    pub(crate) fn is(&self, name: &str) -> bool {
        self.get(name) == 1
    }

    pub(crate) fn words(&self, name: &str) -> Vec<u32> {
        self.run.words(self.ports[name]).unwrap()
    }

    pub(crate) fn settle(&mut self) {
        self.run.eval().unwrap();
    }

    pub(crate) fn edge(&mut self) {
        self.run.clock().unwrap();
    }
}
