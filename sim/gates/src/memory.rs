//! Memories of a netlist, as interpreted modules.

use potamoi_netlist::{InterpretError, Interpreter, PortHandle};

use super::flat::{FlatMemory, FlatPort};

/// A memory in a simulation.
pub(super) struct Memory {
    unit: Interpreter,
    /// Nets and words of each port.
    inputs: Vec<Port>,
    outputs: Vec<Port>,
}

struct Port {
    handle: PortHandle,
    nets: Vec<u32>,
    words: Vec<u32>,
}

impl Memory {
    /// Initial contents are drawn from the seed.
    pub(super) fn new(memory: &FlatMemory, seed: u64) -> Result<Self, InterpretError> {
        let mut unit = Interpreter::new(&memory.module, seed);
        unit.eval()?;
        let port = |port: &FlatPort| {
            let handle = unit.port(&port.name)?;
            Ok(Port {
                handle,
                nets: port.nets.clone(),
                words: vec![0; handle.words()],
            })
        };
        let of = |output: bool| {
            let ports = memory.ports.iter().filter(move |p| p.output == output);
            ports.map(port).collect::<Result<_, InterpretError>>()
        };
        Ok(Self {
            inputs: of(false)?,
            outputs: of(true)?,
            unit,
        })
    }

    /// Samples the nets' values at the clock's edge.
    pub(super) fn edge(&mut self, values: &[bool]) -> Result<(), InterpretError> {
        for port in &mut self.inputs {
            port.words.fill(0);
            for (i, net) in port.nets.iter().enumerate() {
                port.words[i / 32] |= u32::from(values[*net as usize]) << (i % 32);
            }
            self.unit.set_words(port.handle, &port.words)?;
        }
        self.unit.clock()
    }

    /// Reports its output nets with their values.
    pub(super) fn outputs(
        &mut self,
        mut drive: impl FnMut(u32, bool),
    ) -> Result<(), InterpretError> {
        for port in &mut self.outputs {
            port.words = self.unit.words(port.handle)?;
            for (i, net) in port.nets.iter().enumerate() {
                drive(*net, port.words[i / 32] >> (i % 32) & 1 == 1);
            }
        }
        Ok(())
    }
}
