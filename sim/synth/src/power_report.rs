//! What is reported of a unit's power.

use serde::{Deserialize, Serialize};

/// A unit's power, or why there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Power {
    /// As far as cells and the loads of their pins go.
    Estimated(Box<PowerReport>),
    /// It could not be estimated.
    Absent {
        /// Why.
        absent: String,
    },
}

/// Power of a unit in cells, without wires, clock tree and memories.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PowerReport {
    /// The configuration's clock, or the one that the netlist reaches before wires if
    /// that is less, in gigahertz: milliwatts are at this clock.
    pub clock_ghz: f64,
    /// Of the supply, in volts.
    pub volts: f64,
    /// What moved the netlist.
    pub activity: Activity,
    /// Nanowatts of all cells, in no particular state.
    pub leakage_nw: f64,
    /// Each net changes at most once a cycle.
    pub zero_delay: Figures,
    /// Cells have the library's delays, and pulses shorter than them are swallowed.
    pub with_glitches: Figures,
    /// By module, the top one first.
    pub modules: Vec<ModulePower>,
}

/// What moved a netlist, compared with golden values in every output bit and cycle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Activity {
    /// The scene.
    pub scene: String,
    /// The work: what, how much.
    pub work: String,
    /// Netlists that were simulated, by their size; of several the unit is composed.
    pub simulated: Vec<String>,
    /// Cycles of a run.
    pub cycles: u64,
    /// Of those, cycles in which the unit was busy.
    pub busy: u64,
    /// What is counted: `sample` or `exponential`.
    pub item: String,
    /// So many, in the whole unit.
    pub items: u64,
    /// Channels of a sample; 0 of exponentials.
    pub channels: u64,
}

/// Energy and power of the whole unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Changes of a net a cycle, the mean of all nets but the clock, of the largest
    /// netlist that was simulated.
    pub toggles_a_net: f64,
    /// Of charging nets, half of C V^2 a change.
    pub switching_pj_a_cycle: f64,
    /// Within cells.
    pub internal_pj_a_cycle: f64,
    /// Of flip-flops' clock pins, within them and of their load.
    pub clock_pj_a_cycle: f64,
    /// All three.
    pub pj_a_cycle: f64,
    /// The same without work, after it.
    pub rest_pj_a_cycle: f64,
    /// Picojoules a sample or an exponential.
    pub pj_an_item: f64,
    /// Milliwatts at the clock, with leakage.
    pub mw: f64,
}

/// Energy of all modules of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModulePower {
    /// Its name.
    pub module: String,
    /// How many there are in the unit.
    pub count: u64,
    /// Picojoules a cycle of all of them, each net changing at most once.
    pub zero_delay_pj_a_cycle: f64,
    /// The same with glitches.
    pub with_glitches_pj_a_cycle: f64,
    /// Nanowatts of all of them.
    pub leakage_nw: f64,
}
