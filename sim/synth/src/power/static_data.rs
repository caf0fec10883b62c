//! Static data of a netlist: loads and transition times of nets, delays of cells, leakage.

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_gates::{Delays, Driver, Flat, Simulator, Watch};
use potamoi_rtl::GateEngine;

use super::cell::{CellPower, Timing};
use super::library::{PowerLibrary, Units};
use super::unavailable::Unavailable;
use crate::SynthError;

/// Time step of the simulation, in picoseconds.
const STEP_PS: f64 = 1.0;
/// Longest delay of a cell, in steps.
const MOST_STEPS: f64 = 1e5;

/// Loads of named nets, in the library's unit.
pub(super) fn named_loads(
    library: &PowerLibrary,
    flat: &Flat,
) -> Result<BTreeMap<String, f64>, Unavailable> {
    let loads = loads(library, flat, &library.cells(flat)?);
    let named = flat.named.iter();
    Ok(named
        .map(|(name, net)| (name.clone(), loads[*net as usize]))
        .collect())
}

/// Load of each net: the pins that it drives, and the load of the unit's outputs.
fn loads(library: &PowerLibrary, flat: &Flat, cells: &[CellPower]) -> Vec<f64> {
    let mut loads = vec![0.0; flat.nets()];
    for port in flat.ports.iter().filter(|p| p.output) {
        for net in &port.nets {
            loads[*net as usize] += library.output_load;
        }
    }
    for cell in 0..flat.cells.len() as u32 {
        let own = &cells[usize::from(flat.cells[cell as usize].gate)];
        for (net, load) in flat.inputs(cell).iter().zip(&own.loads) {
            loads[*net as usize] += load;
        }
    }
    loads
}

/// A netlist with its cells' data.
pub(super) struct StaticData {
    pub(super) flat: Arc<Flat>,
    pub(super) cells: Vec<CellPower>,
    pub(super) units: Units,
    /// Load of each net, in the library's unit.
    pub(super) loads: Vec<f64>,
    /// The same loads, except that nets which are larger in the whole unit have their load there;
    /// they set the timing.
    far_loads: Vec<f64>,
    /// Transition time of each net, in the library's unit of time.
    pub(super) transitions: Vec<f64>,
    /// Transition time of the clock.
    pub(super) clock_transition: f64,
    pub(super) delays: Arc<Delays>,
}

impl StaticData {
    /// A netlist that is part of a larger one, where nets named in `loads` have those loads.
    pub(super) fn new(
        library: &PowerLibrary,
        flat: &Arc<Flat>,
        whole: &BTreeMap<String, f64>,
    ) -> Result<Self, Unavailable> {
        let cells = library.cells(flat)?;
        let clock_transition = library.transition()?;
        let loads = loads(library, flat, &cells);
        let mut far_loads = loads.clone();
        for (name, net) in &flat.named {
            if let Some(load) = whole.get(name) {
                far_loads[*net as usize] = *load;
            }
        }
        let mut still = Self {
            flat: flat.clone(),
            cells,
            units: library.units,
            loads,
            far_loads,
            transitions: vec![clock_transition; flat.nets()],
            clock_transition,
            delays: Arc::new(Delays {
                cells: vec![],
                from: vec![],
                memory: 1,
            }),
        };
        still.spread();
        still.delays = Arc::new(still.delays());
        Ok(still)
    }

    pub(super) fn cell(&self, cell: u32) -> &CellPower {
        &self.cells[usize::from(self.flat.cells[cell as usize].gate)]
    }

    /// A simulator of the netlist, with delays or without; state without reset is drawn from the
    /// seed.
    pub(super) fn engine<W: Watch>(
        &self,
        is_delayed: bool,
        seed: u64,
        watch: W,
    ) -> Result<GateEngine<W>, SynthError> {
        let delays = is_delayed.then(|| self.delays.clone());
        let simulator = Simulator::new(&self.flat, delays, seed, watch);
        let simulator = simulator.map_err(|e| SynthError::Rtl(Box::new(e.into())))?;
        Ok(GateEngine { simulator })
    }

    pub(super) const fn step_ps(&self) -> f64 {
        STEP_PS
    }

    /// Load of a net in this netlist, for its energy.
    pub(super) fn load(&self, net: u32) -> f64 {
        self.loads[net as usize]
    }

    /// Load of a net in the whole unit, for timing and internal energy.
    pub(super) fn far_load(&self, net: u32) -> f64 {
        self.far_loads[net as usize]
    }

    pub(super) fn transition(&self, net: u32) -> f64 {
        self.transitions[net as usize]
    }

    /// Transition times of the pins that cause a cell's outputs.
    fn causes(&self, cell: u32) -> Vec<f64> {
        if self.flat.gate(cell).flop.is_some() {
            return vec![self.clock_transition];
        }
        let inputs = self.flat.inputs(cell).iter();
        inputs.map(|net| self.transition(*net)).collect()
    }

    /// Propagates transition times from flip-flops and inputs: each output has the mean over its
    /// inputs.
    fn spread(&mut self) {
        let flat = self.flat.clone();
        for cell in flat.flops.iter().chain(&flat.order) {
            let causes = self.causes(*cell);
            for (output, net) in flat.outputs(*cell).iter().enumerate() {
                let load = self.far_load(*net);
                let timings = &self.cell(*cell).timings[output];
                let (mut sum, mut count) = (0.0, 0);
                for (timings, transition) in timings.iter().zip(&causes) {
                    let all = timings.iter().map(|t| t.transition(*transition, load));
                    sum += all.sum::<f64>();
                    count += timings.len();
                }
                if count > 0 {
                    self.transitions[*net as usize] = (sum / f64::from(count as u32)).max(0.0);
                }
            }
        }
    }

    fn delays(&self) -> Delays {
        let flat = &self.flat;
        let (mut cells, mut from) = (vec![], vec![]);
        let steps = |units: f64| {
            let steps = (units * self.units.time_ps / STEP_PS).round();
            steps.clamp(1.0, MOST_STEPS) as u32
        };
        let mut clocked = 0;
        for cell in 0..flat.cells.len() as u32 {
            from.push(cells.len() as u32);
            let own = self.cell(cell);
            for (pin, transition) in self.causes(cell).into_iter().enumerate() {
                for (output, net) in flat.outputs(cell).iter().enumerate() {
                    let timings = &own.timings[output][pin];
                    let load = self.far_load(*net);
                    for rises in [false, true] {
                        let of = |t: &Timing| t.delay(rises, transition, load);
                        let sum: f64 = timings.iter().map(of).sum();
                        cells.push(steps(sum / timings.len().max(1) as f64));
                    }
                }
            }
            if flat.gate(cell).flop.is_some() {
                let last = cells.iter().rev().take(2).copied().max().unwrap_or(1);
                clocked = clocked.max(last);
            }
        }
        // Memories are as slow as the slowest flip-flop: no library says how slow.
        Delays {
            cells,
            from,
            memory: clocked.max(1),
        }
    }

    /// Leakage of each kind of module, in nanowatts.
    pub(super) fn leakage_nw(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.flat.modules.len()];
        for cell in &self.flat.cells {
            let own = &self.cells[usize::from(cell.gate)];
            sums[usize::from(cell.module)] += own.leakage * self.units.leakage_nw;
        }
        sums
    }

    /// Kind of module to which a net's energy belongs: its driver's, or the top one for a net
    /// driven by an input.
    pub(super) fn module_of_net(&self, net: u32) -> usize {
        match self.flat.drivers[net as usize] {
            Driver::Cell { cell, .. } => self.flat.cells[cell as usize].module.into(),
            Driver::Memory { module } => module.into(),
            Driver::None | Driver::Constant | Driver::Port => 0,
        }
    }
}
