//! Entries completed by a beat of the RIT stream.

use std::collections::BTreeMap;

use potamoi_formats::rit::Vertices;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::rit_shape::Shape;
use crate::circuits::popcount;

/// Entries completed by a beat, for one entry size.
pub(crate) struct Progress {
    pub(crate) full_groups: Signal,
    pub(crate) all_groups: Signal,
    pub(crate) last_keep: Signal,
    pub(crate) whole: Signal,
}

/// Ends of entries in the row, this beat included. Valid bytes are contiguous from byte 0, so that
/// one bit of `keep` tells whether a halfword is valid: no sum is needed. Entries of several sizes
/// end at common positions.
pub(crate) struct Position {
    phase: Signal,
    lanes: u32,
    /// Whether each halfword of the beat is valid.
    kept: Vec<Signal>,
    phases: u32,
    at_least: BTreeMap<u32, Signal>,
    exactly: BTreeMap<u32, Signal>,
}

impl Position {
    /// `kept` tells whether each halfword of the beat is valid.
    pub(crate) fn new(shape: &Shape, phase: Signal, kept: Vec<Signal>) -> Self {
        Self {
            phase,
            lanes: shape.lanes,
            kept,
            phases: shape.phases,
            at_least: BTreeMap::new(),
            exactly: BTreeMap::new(),
        }
    }

    /// Whether the row holds at least so many halfwords, 1 and up.
    fn reached(&self, m: &mut ModuleBuilder, halfwords: u32) -> Signal {
        let last = halfwords - 1;
        let options: Vec<_> = (0..self.phases)
            .map(|phase| match last.checked_sub(phase * self.lanes) {
                None => m.lit(1, Ty::bit()),
                Some(lane) if lane < self.lanes => self.kept[lane as usize],
                Some(_) => m.lit(0, Ty::bit()),
            })
            .collect();
        m.select(self.phase, &options)
    }

    fn at_least(&mut self, m: &mut ModuleBuilder, halfwords: u32) -> Signal {
        if let Some(known) = self.at_least.get(&halfwords) {
            return *known;
        }
        let reached = self.reached(m, halfwords);
        let reached = m.name(reached, &format!("at_least_{halfwords}"));
        self.at_least.insert(halfwords, reached);
        reached
    }

    fn exactly(&mut self, m: &mut ModuleBuilder, halfwords: u32) -> Signal {
        if let Some(known) = self.exactly.get(&halfwords) {
            return *known;
        }
        let reached = self.at_least(m, halfwords);
        let here = if halfwords == self.phases * self.lanes {
            reached
        } else {
            let next = self.at_least(m, halfwords + 1);
            let ends = m.not(next);
            let here = m.and(reached, ends);
            m.name(here, &format!("exactly_{halfwords}"))
        };
        self.exactly.insert(halfwords, here);
        here
    }
}

/// Entries before `position`, with `vertices` vertices each.
pub(crate) fn progress(
    m: &mut ModuleBuilder,
    shape: &Shape,
    vertices: Vertices,
    position: &mut Position,
) -> Progress {
    let size = shape.entry_halfwords(vertices);
    let groups = shape.groups(vertices);
    let name = |what: &str| format!("{what}_v{}", vertices.count());
    // has[e]: entry e of the row is complete.
    let has: Vec<Signal> = (1..=groups * shape.ports)
        .map(|e| position.at_least(m, size * e))
        .collect();
    let entry = |g: u32, p: u32| has[(g * shape.ports + p) as usize];
    let ends: Vec<_> = (0..groups).map(|g| entry(g, shape.ports - 1)).collect();
    let starts: Vec<_> = (0..groups).map(|g| entry(g, 0)).collect();
    let width = shape.group_ty().width;
    let full_groups = popcount(m, &ends);
    let full_groups = m.extend(full_groups, width);
    let full_groups = m.name(full_groups, &name("full_groups"));
    let all_groups = popcount(m, &starts);
    let all_groups = m.extend(all_groups, width);
    let all_groups = m.name(all_groups, &name("all_groups"));
    let mut keep = vec![];
    for p in (0..shape.ports).rev() {
        let mut any = vec![];
        for g in 0..groups {
            let mut all = vec![entry(g, p)];
            if g + 1 < groups {
                all.push(m.not(entry(g + 1, 0)));
            }
            any.push(m.all_of(&all));
        }
        keep.push(m.any_of(&any));
    }
    let last_keep = m.cat(&keep);
    let last_keep = m.name(last_keep, &name("keep"));
    let exact: Vec<_> = (1..=groups * shape.ports)
        .map(|e| position.exactly(m, size * e))
        .collect();
    let whole = m.any_of(&exact);
    let whole = m.name(whole, &name("whole"));
    Progress {
        full_groups,
        all_groups,
        last_keep,
        whole,
    }
}
