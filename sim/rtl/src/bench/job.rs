//! A job of a unit: beats, settings, and what must come of them.

use std::collections::BTreeMap;

use super::beat::Beat;

/// Work between two changes of the settings, and what must come of it.
#[derive(Debug, Clone, Default)]
pub(super) struct Job {
    pub(super) title: String,
    /// Values of the settings' ports.
    pub(super) settings: Vec<(&'static str, u64)>,
    /// Beats of the inputs, in the order of the unit's streams.
    pub(super) inputs: Vec<Vec<Beat>>,
    pub(super) output: Vec<Beat>,
    /// Cycles, the first ones, in which the sink takes nothing, where streams do not pause.
    pub(super) closed: u32,
    /// Cycles from the first in which the sources offer a beat to that in which the sink takes the
    /// last one, both included, with sources and, from `closed` on, the sink always ready.
    pub(super) cycles: u64,
    /// Counters and flags afterwards, likewise; none where they are not compared.
    pub(super) stats: BTreeMap<&'static str, u64>,
}
