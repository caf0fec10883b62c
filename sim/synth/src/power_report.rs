//! Report of a unit's power.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Power of a unit, or the reason why it is missing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Power {
    /// Estimated from cells and the loads of their pins.
    Estimated(Box<PowerReport>),
    /// It could not be estimated.
    Absent {
        /// The reason.
        absent: String,
    },
}

/// Power of a gate-level unit, without wires, clock tree and memories.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PowerReport {
    /// Clock for milliwatts, in gigahertz: the configuration's, or the one that the netlist reaches
    /// before wires if that is lower.
    pub clock_ghz: f64,
    /// Supply voltage in volts.
    pub volts: f64,
    /// Switching activity.
    pub activity: Activity,
    /// Leakage of all cells in nanowatts, in no particular state.
    pub leakage_nw: f64,
    /// With zero delays: each net changes at most once a cycle.
    pub zero_delay: Figures,
    /// With the library's delays and glitches; pulses shorter than a cell's delay are swallowed.
    pub with_glitches: Figures,
    /// By module, the top one first.
    pub modules: Vec<ModulePower>,
}

/// Switching activity of a netlist, compared with golden values in every output bit and cycle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Activity {
    /// The scene.
    pub scene: String,
    /// Kind and amount of work.
    pub work: String,
    /// Simulated netlists by size; if there are several, the unit is composed of them.
    pub simulated: Vec<String>,
    /// Cycles of a run.
    pub cycles: u64,
    /// Busy cycles of a run.
    pub busy: u64,
    /// Item counted: `sample` or `exponential`.
    pub item: String,
    /// Number of items in the whole unit.
    pub items: u64,
    /// Channels of a sample; 0 for exponentials.
    pub channels: u64,
}

/// Energy and power of the whole unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Figures {
    /// Transitions of a net a cycle, as mean over all nets except the clock, in the largest
    /// simulated netlist.
    pub toggles_a_net: f64,
    /// Switching energy in picojoules a cycle: half of C V^2 a transition.
    pub switching_pj_a_cycle: f64,
    /// Internal energy of cells, in picojoules a cycle.
    pub internal_pj_a_cycle: f64,
    /// Energy of flip-flops' clock pins in picojoules a cycle, internal and of their load.
    pub clock_pj_a_cycle: f64,
    /// Total energy in picojoules a cycle.
    pub pj_a_cycle: f64,
    /// Total energy of an idle cycle after the work, in picojoules.
    pub rest_pj_a_cycle: f64,
    /// Energy of a sample or an exponential, in picojoules.
    pub pj_an_item: f64,
    /// Power in milliwatts at the clock, leakage included.
    pub mw: f64,
}

/// Energy of all modules of one kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModulePower {
    /// Its name.
    pub module: String,
    /// Number of instances in the unit.
    pub count: u64,
    /// Energy of all instances with zero delays, in picojoules a cycle.
    pub zero_delay_pj_a_cycle: f64,
    /// Energy of all instances with glitches, in picojoules a cycle.
    pub with_glitches_pj_a_cycle: f64,
    /// Leakage of all instances, in nanowatts.
    pub leakage_nw: f64,
}
