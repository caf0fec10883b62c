//! Two-valued simulator of a flat netlist, cycle by cycle.
//!
//! Without delays a net changes at most once a cycle. With delays each pin of a cell has its own
//! delay to each output, rising and falling, and a pulse shorter than the delay of its cell is
//! swallowed (inertial delay).
//!
//! The initial contents of flip-flops and memories are drawn from a seed: no comparison may depend
//! on them. There is no unknown value, and so no pessimistic propagation of one.

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_netlist::InterpretError;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::flat::{Driver, Flat};
use super::memory::Memory;
use super::watch::{Delays, Watch};

/// A scheduled value of a net.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Pending {
    /// Version of the latest plan for the net; earlier ones are void.
    version: u32,
    is_open: bool,
}

#[derive(Debug, Clone, Copy)]
struct Event {
    net: u32,
    version: u32,
    pin: u8,
}

/// A simulation of a netlist.
pub struct Simulator<W> {
    /// The netlist.
    pub flat: Arc<Flat>,
    delays: Option<Arc<Delays>>,
    values: Vec<bool>,
    states: Vec<u16>,
    memories: Vec<Memory>,
    /// Inputs to apply in the next cycle, by net.
    set: BTreeMap<u32, bool>,
    /// Flip-flops whose stored bit changed at the last edge.
    turned: Vec<u32>,
    /// Cells to evaluate by level; without delays.
    levels: Vec<Vec<u32>>,
    /// Changed input pins of each cell; without delays.
    changed: Vec<u16>,
    /// Events by time since the edge; with delays.
    events: Vec<Vec<Event>>,
    pending: Vec<Pending>,
    /// Whether the observer is called.
    pub is_watched: bool,
    /// Observer of every transition.
    pub watch: W,
    /// Observed cycles.
    pub cycles: u64,
    /// Latest transition after an edge, in time steps.
    pub longest: usize,
}

impl<W: Watch> Simulator<W> {
    /// Starts with inputs of 0 and stored bits drawn from `seed`.
    ///
    /// # Errors
    /// A memory that cannot be interpreted.
    pub fn new(
        flat: &Arc<Flat>,
        delays: Option<Arc<Delays>>,
        seed: u64,
        watch: W,
    ) -> Result<Self, InterpretError> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let memories = flat
            .memories
            .iter()
            .map(|memory| Memory::new(memory, random.random()))
            .collect::<Result<_, _>>()?;
        let most = flat.levels.iter().max().map_or(0, |level| level + 1);
        let mut simulator = Self {
            values: vec![false; flat.nets()],
            states: vec![0; flat.cells.len()],
            memories,
            set: BTreeMap::new(),
            turned: vec![],
            levels: vec![vec![]; most as usize],
            changed: vec![0; flat.cells.len()],
            events: vec![],
            pending: vec![Pending::default(); flat.nets()],
            is_watched: false,
            watch,
            cycles: 0,
            longest: 0,
            flat: flat.clone(),
            delays,
        };
        simulator.start(&mut random)?;
        Ok(simulator)
    }

    /// Initialises every net.
    fn start(&mut self, random: &mut Pcg64Mcg) -> Result<(), InterpretError> {
        let flat = self.flat.clone();
        self.values[1] = true;
        for memory in &mut self.memories {
            let values = &mut self.values;
            memory.outputs(|net, value| values[net as usize] = value)?;
        }
        for cell in &flat.flops {
            let gate = flat.gate(*cell);
            let held = usize::from(random.random::<bool>()) << gate.inputs.len();
            self.states[*cell as usize] = held as u16;
        }
        // Outputs of flip-flops may depend on what they hold alone; their inputs follow.
        for cell in flat.flops.iter().chain(&flat.order).chain(&flat.flops) {
            let gate = flat.gate(*cell);
            let mut bits = usize::from(self.states[*cell as usize]) & 1 << gate.inputs.len();
            if gate.flop.is_none() {
                bits = 0;
            }
            for (pin, net) in flat.inputs(*cell).iter().enumerate() {
                bits |= usize::from(self.values[*net as usize]) << pin;
            }
            bits |= gate.outputs_of(bits);
            self.states[*cell as usize] = bits as u16;
            for (output, net) in flat.outputs(*cell).iter().enumerate() {
                self.values[*net as usize] = bits >> (gate.variables() + output) & 1 == 1;
            }
        }
        Ok(())
    }

    /// Value of a net.
    #[must_use]
    pub fn value(&self, net: u32) -> bool {
        self.values[net as usize]
    }

    /// Sets an input, effective at the next [`Simulator::settle`].
    pub fn set(&mut self, net: u32, value: bool) {
        self.set.insert(net, value);
    }

    /// Propagates the last edge and the inputs.
    ///
    /// # Errors
    /// The netlist does not settle.
    pub fn settle(&mut self) -> Result<(), InterpretError> {
        let flat = self.flat.clone();
        let delays = self.delays.clone();
        for (net, value) in std::mem::take(&mut self.set) {
            if self.values[net as usize] != value {
                self.change(&flat, delays.as_deref(), net, value, 0);
            }
        }
        let wait = delays.as_ref().map_or(0, |d| d.memory as usize);
        for i in 0..self.memories.len() {
            let mut driven = vec![];
            let values = &self.values;
            self.memories[i].outputs(|net, value| {
                if values[net as usize] != value {
                    driven.push((net, value));
                }
            })?;
            for (net, value) in driven {
                match &delays {
                    None => self.change(&flat, None, net, value, 0),
                    Some(_) => self.plan(net, 0, wait),
                }
            }
        }
        for cell in std::mem::take(&mut self.turned) {
            self.turn(&flat, delays.as_deref(), cell);
        }
        match &delays {
            None => self.sweep(&flat),
            Some(delays) => self.run(&flat, delays),
        }
        if self.is_watched {
            self.cycles += 1;
            for cell in &flat.flops {
                self.watch.clock(*cell, self.states[*cell as usize], false);
            }
        }
        Ok(())
    }

    /// Rising clock edge: stored bits change, but nothing propagates yet.
    ///
    /// # Errors
    /// A memory that cannot be interpreted.
    pub fn edge(&mut self) -> Result<(), InterpretError> {
        let flat = self.flat.clone();
        for memory in &mut self.memories {
            memory.edge(&self.values)?;
        }
        for cell in &flat.flops {
            let gate = flat.gate(*cell);
            let Some(flop) = &gate.flop else { continue };
            let state = self.states[*cell as usize];
            if self.is_watched {
                self.watch.clock(*cell, state, true);
            }
            let held = gate.inputs.len();
            let bits = usize::from(state) & ((1 << gate.variables()) - 1);
            if flop.next.at(bits) != (bits >> held & 1 == 1) {
                self.turned.push(*cell);
            }
        }
        Ok(())
    }

    /// A flip-flop takes its next value.
    fn turn(&mut self, flat: &Flat, delays: Option<&Delays>, cell: u32) {
        let gate = flat.gate(cell);
        let state = &mut self.states[cell as usize];
        *state ^= 1 << gate.inputs.len();
        let bits = usize::from(*state);
        let outputs = gate.outputs_of(bits & ((1 << gate.variables()) - 1));
        for (output, net) in flat.outputs(cell).iter().enumerate() {
            let value = outputs >> (gate.variables() + output) & 1 == 1;
            if value == self.values[*net as usize] {
                continue;
            }
            match delays {
                None => {
                    self.output(flat, cell, output, 0);
                    self.change(flat, None, *net, value, 0);
                }
                Some(delays) => self.plan(*net, 0, delays.of(flat, cell, 0, output, value)),
            }
        }
    }

    /// Inverts an output bit, because of a pin.
    fn output(&mut self, flat: &Flat, cell: u32, output: usize, pin: u8) {
        let state = self.states[cell as usize];
        if self.is_watched {
            self.watch.output(cell, output as u8, pin, state);
        }
        self.states[cell as usize] = state ^ 1 << (flat.gate(cell).variables() + output);
    }

    /// Changes a net and its readers. `now` is the time since the edge.
    fn change(&mut self, flat: &Flat, delays: Option<&Delays>, net: u32, value: bool, now: usize) {
        self.values[net as usize] = value;
        if self.is_watched {
            self.watch.net(net);
        }
        for sink in flat.sinks(net) {
            let cell = sink.cell as usize;
            let is_flop = flat.gate(sink.cell).flop.is_some();
            match delays {
                None if !is_flop => {
                    if self.changed[cell] == 0 {
                        self.levels[flat.levels[cell] as usize].push(sink.cell);
                    }
                    self.changed[cell] ^= 1 << sink.pin;
                }
                _ => {
                    self.input(sink.cell, sink.pin);
                    if let Some(delays) = delays.filter(|_| !is_flop) {
                        self.respond(flat, delays, sink.cell, sink.pin, now);
                    }
                }
            }
        }
    }

    /// Inverts an input bit.
    fn input(&mut self, cell: u32, pin: u8) {
        let state = self.states[cell as usize];
        if self.is_watched {
            self.watch.input(cell, pin, state);
        }
        self.states[cell as usize] = state ^ 1 << pin;
    }

    /// Evaluates changed cells in topological order; without delays.
    fn sweep(&mut self, flat: &Flat) {
        for level in 0..self.levels.len() {
            let mut cells = std::mem::take(&mut self.levels[level]);
            for cell in cells.drain(..) {
                let changed = std::mem::take(&mut self.changed[cell as usize]);
                self.step(flat, cell, changed);
            }
            // Its memory is of use in the next cycle.
            self.levels[level] = cells;
        }
    }

    /// Evaluates a cell; the cause of its output transitions is the last changed pin.
    fn step(&mut self, flat: &Flat, cell: u32, changed: u16) {
        let gate = flat.gate(cell);
        let late = |pin: &u8| match flat.drivers[flat.inputs(cell)[usize::from(*pin)] as usize] {
            Driver::Cell { cell, .. } => (flat.levels[cell as usize] + 1, *pin),
            _ => (0, *pin),
        };
        let pins = (0..gate.inputs.len() as u8).filter(|pin| changed >> pin & 1 == 1);
        let Some(last) = pins.clone().max_by_key(late) else {
            return;
        };
        for pin in pins.filter(|pin| *pin != last).chain([last]) {
            self.input(cell, pin);
        }
        let bits = usize::from(self.states[cell as usize]);
        let outputs = gate.outputs_of(bits & ((1 << gate.variables()) - 1));
        for output in 0..gate.outputs.len() {
            let net = flat.outputs(cell)[output];
            let value = outputs >> (gate.variables() + output) & 1 == 1;
            if value != self.values[net as usize] {
                self.output(flat, cell, output, last);
                self.change(flat, None, net, value, 0);
            }
        }
    }

    /// Reacts to a changed input: schedules or cancels output transitions; with delays.
    fn respond(&mut self, flat: &Flat, delays: &Delays, cell: u32, pin: u8, now: usize) {
        let gate = flat.gate(cell);
        let bits = usize::from(self.states[cell as usize]);
        let outputs = gate.outputs_of(bits & ((1 << gate.variables()) - 1));
        for output in 0..gate.outputs.len() {
            let net = flat.outputs(cell)[output];
            let value = outputs >> (gate.variables() + output) & 1 == 1;
            let pending = &mut self.pending[net as usize];
            if value == self.values[net as usize] {
                if pending.is_open {
                    pending.is_open = false;
                    pending.version = pending.version.wrapping_add(1);
                }
            } else if !pending.is_open {
                let wait = delays.of(flat, cell, pin, output, value);
                self.plan(net, pin, now + wait);
            }
        }
    }

    /// Schedules a transition of a net, caused by a pin of its driver.
    fn plan(&mut self, net: u32, pin: u8, at: usize) {
        let pending = &mut self.pending[net as usize];
        pending.is_open = true;
        pending.version = pending.version.wrapping_add(1);
        let version = pending.version;
        if self.events.len() <= at {
            self.events.resize_with(at + 1, Vec::new);
        }
        self.events[at].push(Event { net, version, pin });
    }

    /// Processes scheduled transitions in order of time; with delays.
    fn run(&mut self, flat: &Flat, delays: &Delays) {
        let mut now = 0;
        while now < self.events.len() {
            let mut events = std::mem::take(&mut self.events[now]);
            for event in events.drain(..) {
                let net = event.net as usize;
                let pending = &mut self.pending[net];
                if !pending.is_open || pending.version != event.version {
                    continue;
                }
                pending.is_open = false;
                self.longest = self.longest.max(now);
                let value = !self.values[net];
                if let Driver::Cell { cell, output } = flat.drivers[net] {
                    self.output(flat, cell, output.into(), event.pin);
                }
                self.change(flat, Some(delays), event.net, value, now);
            }
            // Its memory is of use in the next cycle.
            self.events[now] = events;
            now += 1;
        }
    }
}

#[cfg(test)]
mod tests;
