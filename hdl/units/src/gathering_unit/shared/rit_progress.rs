//! Entries completed by a beat of the RIT stream.

use num_bigint::BigInt;
use potamoi_formats::rit::Vertices;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::rit_shape::Shape;
use crate::circuits::{is, popcount};

/// Entries completed by a beat, for one entry size.
pub(crate) struct Progress {
    pub(crate) full_groups: Signal,
    pub(crate) all_groups: Signal,
    pub(crate) last_keep: Signal,
    pub(crate) whole: Signal,
}

/// Halfwords of the row that are valid, this beat included. Valid bytes are contiguous from byte 0,
/// so that one bit tells whether the row has at least so many halfwords: no sum is needed.
pub(crate) struct Position {
    /// Whether each halfword of the row is valid.
    kept: Signal,
    /// Whether each halfword is the last valid one.
    last: Signal,
}

impl Position {
    /// `of_beat` tells whether each halfword of the beat is valid.
    pub(crate) fn new(
        m: &mut ModuleBuilder,
        shape: &Shape,
        phase: Signal,
        of_beat: Signal,
    ) -> Self {
        let beats: Vec<_> = (0..shape.phases)
            .rev()
            .map(|beat| {
                let here = is(m, phase, beat);
                let here = m.repeat(here, shape.lanes);
                let mut kept = m.and(of_beat, here);
                if beat + 1 < shape.phases {
                    let own = m.lit(beat, phase.ty());
                    let over = m.gt(phase, own);
                    let over = m.repeat(over, shape.lanes);
                    kept = m.or(kept, over);
                }
                m.name(kept, &format!("kept_of_beat_{beat}"))
            })
            .collect();
        let kept = m.cat(&beats);
        let kept = m.name(kept, "row_kept");
        let none = m.lit(0, Ty::bit());
        let above = m.slice(kept, 1, kept.width() - 1);
        let above = m.cat(&[none, above]);
        let ends = m.not(above);
        let last = m.and(kept, ends);
        Self {
            kept,
            last: m.name(last, "row_last"),
        }
    }

    /// Whether the row has at least so many halfwords, 1 and up.
    fn at_least(&self, m: &mut ModuleBuilder, halfwords: u32) -> Signal {
        m.bit(self.kept, halfwords - 1)
    }

    /// Whether the row has a multiple of so many halfwords, and some.
    fn multiple_of(&self, m: &mut ModuleBuilder, halfwords: u32) -> Signal {
        let width = self.last.width();
        let places = (1..=width / halfwords).map(|n| BigInt::from(1) << (n * halfwords - 1));
        let places = m.lit(places.sum::<BigInt>(), Ty::u(width));
        let whole = m.and(self.last, places);
        m.any(whole)
    }
}

/// Entries before `position`, with `vertices` vertices each.
pub(crate) fn progress(
    m: &mut ModuleBuilder,
    shape: &Shape,
    vertices: Vertices,
    position: &Position,
) -> Progress {
    let size = shape.entry_halfwords(vertices);
    let groups = shape.groups(vertices);
    let name = |what: &str| format!("{what}_v{}", vertices.count());
    // Those of other sizes stand below the first.
    let is_first = shape.vertices.first() == Some(&vertices);
    let note = |m: &mut ModuleBuilder, signal: Signal, text: &str| {
        m.note(signal, if is_first { text } else { "" });
    };
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
    note(
        m,
        full_groups,
        "groups of the row whose last entry has come",
    );
    let all_groups = popcount(m, &starts);
    let all_groups = m.extend(all_groups, width);
    let all_groups = m.name(all_groups, &name("all_groups"));
    note(m, all_groups, "those whose first entry has come");
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
    note(m, last_keep, "entries of the last of these that have come");
    let whole = position.multiple_of(m, size);
    let whole = m.name(whole, &name("whole"));
    note(m, whole, "the row ends with a whole entry");
    Progress {
        full_groups,
        all_groups,
        last_keep,
        whole,
    }
}
