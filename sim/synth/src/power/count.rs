//! Counts transitions in a netlist, and their energy.

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_gates::{Flat, Watch};

use super::cell::{CellPower, Class};
use super::static_data::StaticData;

/// Energy classes of the transitions of a kind of cell.
#[derive(Debug, Default)]
struct Kind {
    /// Classes in order of first use; the first has no energy.
    classes: Vec<Class>,
    /// Whether each class is the clock's.
    clock: Vec<bool>,
    /// Class by input pin, then by state.
    input: Vec<u16>,
    /// Class by output, pin and state.
    output: Vec<u16>,
    /// Class by clock edge (rising or not) and state.
    edge: Vec<u16>,
    /// Pin and output (from 1) whose transition and load apply to each class.
    at: Vec<[u8; 2]>,
    states: usize,
    causes: usize,
}

/// Marks classes with the clock's transition.
const CLOCK: u8 = u8::MAX;

impl Kind {
    fn new(cell: &CellPower, inputs: usize, outputs: usize, bits: usize, is_flop: bool) -> Self {
        let states = 1 << bits;
        let causes = if is_flop { 1 } else { inputs };
        let mut kind = Self {
            classes: vec![Class::default()],
            clock: vec![false],
            at: vec![[0, 0]],
            states,
            causes,
            ..Self::default()
        };
        let mut known = BTreeMap::new();
        for pin in 0..inputs {
            for state in 0..states {
                let class = cell.input_class(pin, state);
                let id = kind.class(&mut known, class, [pin as u8, 0], false);
                kind.input.push(id);
            }
        }
        for output in 0..outputs {
            for pin in 0..causes {
                let at = [if is_flop { CLOCK } else { pin as u8 }, output as u8 + 1];
                for state in 0..states {
                    let class = cell.output_class(output, pin, state);
                    let id = kind.class(&mut known, class, at, false);
                    kind.output.push(id);
                }
            }
        }
        for rises in [false, true].into_iter().filter(|_| is_flop) {
            for state in 0..states {
                let class = cell.clock_class(state, rises);
                let id = kind.class(&mut known, class, [CLOCK, 0], true);
                kind.edge.push(id);
            }
        }
        kind
    }

    fn class(
        &mut self,
        known: &mut BTreeMap<(Class, [u8; 2], bool), u16>,
        class: Class,
        at: [u8; 2],
        is_clock: bool,
    ) -> u16 {
        if class.0.iter().all(Vec::is_empty) {
            return 0;
        }
        let next = self.classes.len() as u16;
        let id = *known.entry((class.clone(), at, is_clock)).or_insert(next);
        if id == next {
            self.classes.push(class);
            self.at.push(at);
            self.clock.push(is_clock);
        }
        id
    }
}

/// Counts of transitions, by cell and by net.
pub(super) struct Counter {
    flat: Arc<Flat>,
    kinds: Vec<Kind>,
    /// First count of each cell.
    from: Vec<u32>,
    counts: Vec<u32>,
    toggles: Vec<u32>,
}

/// Energies of all instances of a kind of module, in femtojoules.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Energies {
    pub(super) switching: f64,
    pub(super) internal: f64,
    pub(super) clock: f64,
}

impl Energies {
    pub(super) fn times(self, factor: f64) -> Self {
        Self {
            switching: factor * self.switching,
            internal: factor * self.internal,
            clock: factor * self.clock,
        }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            switching: self.switching + other.switching,
            internal: self.internal + other.internal,
            clock: self.clock + other.clock,
        }
    }

    pub(super) fn total(self) -> f64 {
        self.switching + self.internal + self.clock
    }
}

impl Counter {
    pub(super) fn new(still: &StaticData) -> Self {
        let flat = still.flat.clone();
        let kinds: Vec<Kind> = flat
            .gates
            .iter()
            .zip(&still.cells)
            .map(|(gate, cell)| {
                let (inputs, outputs) = (gate.inputs.len(), gate.outputs.len());
                Kind::new(cell, inputs, outputs, gate.bits(), gate.flop.is_some())
            })
            .collect();
        let mut from = Vec::with_capacity(flat.cells.len());
        let mut next = 0;
        for cell in &flat.cells {
            from.push(next);
            next += kinds[usize::from(cell.gate)].classes.len() as u32;
        }
        Self {
            kinds,
            from,
            counts: vec![0; next as usize],
            toggles: vec![0; flat.nets()],
            flat,
        }
    }

    pub(super) fn clear(&mut self) {
        self.counts.fill(0);
        self.toggles.fill(0);
    }

    /// Transitions of all nets.
    pub(super) fn toggles(&self) -> u64 {
        self.toggles.iter().map(|n| u64::from(*n)).sum()
    }

    #[inline]
    fn kind(&self, cell: u32) -> &Kind {
        &self.kinds[usize::from(self.flat.cells[cell as usize].gate)]
    }

    #[inline]
    fn add(&mut self, cell: u32, class: u16) {
        if class != 0 {
            self.counts[self.from[cell as usize] as usize + usize::from(class)] += 1;
        }
    }

    /// Energies of the counts over `cycles`, by kind of module.
    pub(super) fn energies(&self, still: &StaticData, cycles: u64) -> Vec<Energies> {
        let units = &still.units;
        let mut sums = vec![Energies::default(); self.flat.modules.len()];
        let charge = |load: f64| 0.5 * load * units.load_ff * units.volts * units.volts;
        for (net, toggles) in self.toggles.iter().enumerate() {
            let net = net as u32;
            let energy = f64::from(*toggles) * charge(still.load(net));
            sums[still.module_of_net(net)].switching += energy;
        }
        for cell in 0..self.flat.cells.len() as u32 {
            let (kind, own) = (self.kind(cell), still.cell(cell));
            let sum = &mut sums[usize::from(self.flat.cells[cell as usize].module)];
            let counts = &self.counts[self.from[cell as usize] as usize..];
            for (id, class) in kind.classes.iter().enumerate().skip(1) {
                if counts[id] == 0 {
                    continue;
                }
                let [pin, output] = kind.at[id];
                let transition = match pin {
                    CLOCK => still.clock_transition,
                    pin => still.transition(self.flat.inputs(cell)[usize::from(pin)]),
                };
                let load = match output {
                    0 => 0.0,
                    o => still.far_load(self.flat.outputs(cell)[usize::from(o) - 1]),
                };
                let energy = own.energy(class, transition, load) * units.energy_fj;
                let to = match kind.clock[id] {
                    true => &mut sum.clock,
                    false => &mut sum.internal,
                };
                *to += f64::from(counts[id]) * energy;
            }
            // Up and down once a cycle.
            sum.clock += cycles as f64 * 2.0 * charge(own.clock_load);
        }
        sums
    }
}

impl Watch for Counter {
    #[inline]
    fn net(&mut self, net: u32) {
        self.toggles[net as usize] += 1;
    }

    #[inline]
    fn input(&mut self, cell: u32, pin: u8, state: u16) {
        let kind = self.kind(cell);
        let class = kind.input[usize::from(pin) * kind.states + usize::from(state)];
        self.add(cell, class);
    }

    #[inline]
    fn output(&mut self, cell: u32, output: u8, pin: u8, state: u16) {
        let kind = self.kind(cell);
        let at = usize::from(output) * kind.causes + usize::from(pin);
        let class = kind.output[at * kind.states + usize::from(state)];
        self.add(cell, class);
    }

    #[inline]
    fn clock(&mut self, cell: u32, state: u16, rises: bool) {
        let kind = self.kind(cell);
        let class = kind.edge[usize::from(rises) * kind.states + usize::from(state)];
        self.add(cell, class);
    }
}
