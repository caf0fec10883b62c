//! Flattens a netlist.

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_netlist::Module;

use super::flat::{CONSTANTS, Cell, Driver, Flat, FlatMemory, FlatPort, ModuleKind, Sink};
use super::gate::Gate;
use super::verilog::{self, Bit, Text};

/// Largest depth of nested modules; units have four.
const MAX_DEPTH: u32 = 32;
/// The clock's port.
const CLOCK: &str = "clk";

/// Global net of a module's bit, where its bits begin at `first`.
const fn global(bit: Bit, first: u32) -> u32 {
    match bit {
        Bit::Constant(one) => one as u32,
        Bit::Wire(wire) => first + wire,
    }
}

struct Builder<'a> {
    texts: &'a BTreeMap<String, Text>,
    gates: &'a BTreeMap<String, Result<Gate, String>>,
    memories: &'a BTreeMap<String, Arc<Module>>,
    kinds: BTreeMap<&'a str, u16>,
    modules: BTreeMap<&'a str, u16>,
    /// Union-find of connected nets; the lowest represents them.
    parents: Vec<u32>,
    /// Nets of flip-flops' clocks.
    clocks: Vec<u32>,
    flat: Flat,
}

impl Flat {
    /// Flattens the netlist of `top`. `gates` are the library's cells, `memories` the modules
    /// without a netlist.
    ///
    /// # Errors
    /// A fault of the netlist, or why one of its cells cannot be simulated.
    pub fn new(
        netlist: &str,
        top: &str,
        gates: &BTreeMap<String, Result<Gate, String>>,
        memories: &BTreeMap<String, Arc<Module>>,
    ) -> Result<Self, String> {
        Builder::build(netlist, top, gates, memories)
    }
}

impl Builder<'_> {
    /// As [`Flat::new`].
    fn build(
        netlist: &str,
        top: &str,
        gates: &BTreeMap<String, Result<Gate, String>>,
        memories: &BTreeMap<String, Arc<Module>>,
    ) -> Result<Flat, String> {
        let texts = verilog::read(netlist)?;
        let (name, text) = texts
            .get_key_value(top)
            .ok_or_else(|| format!("expected a module {top}, found none"))?;
        let mut builder = Builder {
            texts: &texts,
            gates,
            memories,
            kinds: BTreeMap::new(),
            modules: BTreeMap::new(),
            parents: (0..CONSTANTS).collect(),
            clocks: vec![],
            flat: Flat::default(),
        };
        let nets = builder.place(name, text, 0)?;
        let port = |port: &verilog::Port| FlatPort {
            name: port.name.clone(),
            output: port.output,
            nets: port.bits.iter().map(|bit| global(*bit, nets)).collect(),
        };
        let ports = text.ports.iter().map(port).collect();
        let named = text.named.iter();
        builder.flat.named = named
            .map(|(name, bit)| (name.clone(), global(*bit, nets)))
            .collect();
        builder.finish(ports)
    }
}

impl<'a> Builder<'a> {
    fn root(&mut self, mut net: u32) -> u32 {
        while self.parents[net as usize] != net {
            let up = self.parents[self.parents[net as usize] as usize];
            self.parents[net as usize] = up;
            net = up;
        }
        net
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// Allocates nets; returns the first.
    fn fresh(&mut self, count: u32) -> Result<u32, String> {
        let first = self.parents.len() as u32;
        let end = first.checked_add(count).filter(|end| *end < 1 << 30);
        let end = end.ok_or("more than 2^30 nets")?;
        self.parents.extend(first..end);
        Ok(first)
    }

    /// Instantiates a module and all below it; returns the net of its bit 0.
    fn place(&mut self, name: &'a str, text: &'a Text, depth: u32) -> Result<u32, String> {
        if depth > MAX_DEPTH {
            return Err(format!("module {name} holds itself"));
        }
        let module = self.module(name)?;
        let nets = self.fresh(text.bits)?;
        for (to, from) in &text.assigned {
            self.join(global(*to, nets), global(*from, nets));
        }
        for instance in &text.instances {
            let kind = instance.kind.as_str();
            let pins: Vec<(&str, Vec<u32>)> = instance
                .pins
                .iter()
                .map(|(pin, bits)| {
                    let bits = bits.iter().map(|bit| global(*bit, nets)).collect();
                    (pin.as_str(), bits)
                })
                .collect();
            let wrong = |why: &str| format!("{kind} in module {name}: {why}");
            if let Some(inner) = self.texts.get(kind) {
                let first = self.place(kind, inner, depth + 1)?;
                for port in &inner.ports {
                    let outer = pins.iter().find(|(pin, _)| *pin == port.name);
                    let outer = outer.map_or(&[][..], |(_, nets)| nets);
                    if !outer.is_empty() && outer.len() != port.bits.len() {
                        return Err(wrong(&format!("port {} has other bits", port.name)));
                    }
                    for (bit, net) in port.bits.iter().zip(outer) {
                        self.join(global(*bit, first), *net);
                    }
                }
            } else if let Some(memory) = self.memories.get(kind) {
                self.memory(memory, &pins, module)
                    .map_err(|why| wrong(&why))?;
            } else {
                self.cell(kind, &pins, module).map_err(|why| wrong(&why))?;
            }
        }
        Ok(nets)
    }

    fn module(&mut self, name: &'a str) -> Result<u16, String> {
        let next = u16::try_from(self.modules.len()).map_err(|_| "more than 2^16 modules")?;
        let module = *self.modules.entry(name).or_insert(next);
        if module == next {
            self.flat.modules.push(ModuleKind {
                name: name.to_owned(),
                count: 0,
            });
        }
        self.flat.modules[usize::from(module)].count += 1;
        Ok(module)
    }

    fn memory(
        &mut self,
        memory: &Arc<Module>,
        pins: &[(&str, Vec<u32>)],
        module: u16,
    ) -> Result<(), String> {
        let mut ports = vec![];
        for port in memory.ports() {
            let found = pins.iter().find(|(pin, _)| *pin == port.name);
            let nets = match found {
                Some((_, nets)) if nets.len() == port.ty.width as usize => nets.clone(),
                // Open outputs.
                _ if port.output => {
                    let first = self.fresh(port.ty.width)?;
                    (first..first + port.ty.width).collect()
                }
                _ => return Err(format!("port {} is not connected", port.name)),
            };
            ports.push(FlatPort {
                name: port.name,
                output: port.output,
                nets,
            });
        }
        self.flat.memories.push(FlatMemory {
            module: memory.clone(),
            inside: module,
            ports,
        });
        Ok(())
    }

    fn cell(
        &mut self,
        kind: &'a str,
        pins: &[(&str, Vec<u32>)],
        module: u16,
    ) -> Result<(), String> {
        let gate = match self.gates.get(kind) {
            Some(Ok(gate)) => gate,
            Some(Err(why)) => return Err(format!("the library's cell cannot be simulated: {why}")),
            None => return Err("neither a module, a memory nor a cell of the library".to_owned()),
        };
        let next = u16::try_from(self.kinds.len()).map_err(|_| "more than 2^16 kinds of cell")?;
        let number = *self.kinds.entry(kind).or_insert(next);
        if number == next {
            self.flat.gates.push(gate.clone());
        }
        let net = |name: &str| {
            let found = pins.iter().find(|(pin, _)| *pin == name);
            match found.map(|(_, nets)| &nets[..]) {
                Some([net]) => Some(*net),
                _ => None,
            }
        };
        let first = self.flat.pins.len() as u32;
        for name in &gate.inputs {
            let net = net(name).ok_or_else(|| format!("pin {name} is not connected"))?;
            self.flat.pins.push(net);
        }
        for name in &gate.outputs {
            let net = match net(name) {
                Some(net) => net,
                None => self.fresh(1)?,
            };
            self.flat.pins.push(net);
        }
        let cell = self.flat.cells.len() as u32;
        if let Some(flop) = &gate.flop {
            let name = &flop.clock;
            let net = net(name).ok_or_else(|| format!("pin {name} is not connected"))?;
            self.clocks.push(net);
            self.flat.flops.push(cell);
        }
        self.flat.cells.push(Cell {
            gate: number,
            module,
            first,
        });
        Ok(())
    }
    /// Numbers the nets, finds the driver and the readers of each, and orders the cells.
    fn finish(mut self, mut ports: Vec<FlatPort>) -> Result<Flat, String> {
        let mut numbers = vec![u32::MAX; self.parents.len()];
        let mut count = 0;
        for net in 0..self.parents.len() as u32 {
            let root = self.root(net) as usize;
            if numbers[root] == u32::MAX {
                numbers[root] = count;
                count += 1;
            }
            numbers[net as usize] = numbers[root];
        }
        let mut flat = self.flat;
        let renumber = |nets: &mut [u32]| {
            for net in nets {
                *net = numbers[*net as usize];
            }
        };
        renumber(&mut flat.pins);
        renumber(&mut self.clocks);
        ports.iter_mut().for_each(|p| renumber(&mut p.nets));
        for net in flat.named.values_mut() {
            *net = numbers[*net as usize];
        }
        for memory in &mut flat.memories {
            memory.ports.iter_mut().for_each(|p| renumber(&mut p.nets));
        }
        let clock = ports.iter().find(|p| p.name == CLOCK && !p.output);
        let clock = clock.and_then(|p| p.nets.first().copied());
        if let Some(i) = self.clocks.iter().position(|net| Some(*net) != clock) {
            let cell = flat.flops[i];
            return Err(format!(
                "a {} is clocked by another net than the port {CLOCK}",
                flat.gate(cell).name
            ));
        }
        flat.ports = ports.into_iter().filter(|p| p.name != CLOCK).collect();
        flat.drivers = drivers(&flat, count as usize, clock)?;
        (flat.sinks_from, flat.sinks) = sinks(&flat);
        order(&mut flat)?;
        Ok(flat)
    }
}

/// Driver of each net.
fn drivers(flat: &Flat, nets: usize, clock: Option<u32>) -> Result<Vec<Driver>, String> {
    let mut drivers = vec![Driver::None; nets];
    let mut drive = |net: u32, by: Driver| {
        let driver = &mut drivers[net as usize];
        if *driver == Driver::None {
            *driver = by;
            return Ok(());
        }
        Err(match by {
            Driver::Cell { cell, .. } => {
                format!("a net has two drivers, one a {}", flat.gate(cell).name)
            }
            _ => "a net has two drivers".to_owned(),
        })
    };
    for net in 0..CONSTANTS {
        drive(net, Driver::Constant)?;
    }
    let inputs = flat.ports.iter().filter(|p| !p.output);
    for net in inputs.flat_map(|p| &p.nets).chain(&clock) {
        drive(*net, Driver::Port)?;
    }
    for memory in &flat.memories {
        let outputs = memory.ports.iter().filter(|p| p.output);
        for net in outputs.flat_map(|p| &p.nets) {
            let module = memory.inside;
            drive(*net, Driver::Memory { module })?;
        }
    }
    for cell in 0..flat.cells.len() as u32 {
        for (output, net) in flat.outputs(cell).iter().enumerate() {
            let output = output as u8;
            drive(*net, Driver::Cell { cell, output })?;
        }
    }
    for cell in 0..flat.cells.len() as u32 {
        let open = |net: &&u32| drivers[**net as usize] == Driver::None;
        if flat.inputs(cell).iter().any(|net| open(&net)) {
            return Err(format!(
                "an input of a {} in module {} has no driver",
                flat.gate(cell).name,
                flat.modules[usize::from(flat.cells[cell as usize].module)].name
            ));
        }
    }
    Ok(drivers)
}

/// Start of each net's readers, and the readers.
fn sinks(flat: &Flat) -> (Vec<u32>, Vec<Sink>) {
    let mut from = vec![0; flat.nets() + 1];
    let cells = 0..flat.cells.len() as u32;
    for net in cells.clone().flat_map(|cell| flat.inputs(cell)) {
        from[*net as usize + 1] += 1;
    }
    for net in 0..flat.nets() {
        from[net + 1] += from[net];
    }
    let mut next = from.clone();
    let mut sinks = vec![Sink { cell: 0, pin: 0 }; from[flat.nets()] as usize];
    for cell in cells {
        for (pin, net) in flat.inputs(cell).iter().enumerate() {
            let at = &mut next[*net as usize];
            let pin = pin as u8;
            sinks[*at as usize] = Sink { cell, pin };
            *at += 1;
        }
    }
    (from, sinks)
}

/// Sorts combinational cells topologically.
fn order(flat: &mut Flat) -> Result<(), String> {
    let count = flat.cells.len();
    let is_logic = |cell: u32| flat.gate(cell).flop.is_none();
    let of_logic = |net: u32| match flat.drivers[net as usize] {
        Driver::Cell { cell, .. } => is_logic(cell),
        _ => false,
    };
    let mut waits: Vec<u8> = (0..count as u32)
        .map(|cell| flat.inputs(cell).iter().filter(|n| of_logic(**n)).count() as u8)
        .collect();
    let mut levels = vec![0u32; count];
    let mut order: Vec<u32> = (0..count as u32)
        .filter(|cell| is_logic(*cell) && waits[*cell as usize] == 0)
        .collect();
    let mut at = 0;
    while let Some(&cell) = order.get(at) {
        at += 1;
        for net in flat.outputs(cell) {
            for sink in flat.sinks(*net) {
                let next = sink.cell as usize;
                if !is_logic(sink.cell) {
                    continue;
                }
                levels[next] = levels[next].max(levels[cell as usize] + 1);
                waits[next] -= 1;
                if waits[next] == 0 {
                    order.push(sink.cell);
                }
            }
        }
    }
    if order.len() + flat.flops.len() < count {
        let stuck = (0..count).find(|cell| is_logic(*cell as u32) && waits[*cell] > 0);
        let name = stuck.map_or("", |cell| &flat.gate(cell as u32).name);
        return Err(format!(
            "a {name} depends on its own output without a clock"
        ));
    }
    (flat.order, flat.levels) = (order, levels);
    Ok(())
}
