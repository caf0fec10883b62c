//! Passes over an MVoxel, one for each segment, and their channels.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::shape::Shape;
use crate::circuits::plus_one;

/// Settings; every segment but the last has B channels.
#[derive(Clone, Copy)]
pub(super) struct Settings {
    pub(super) segments: Signal,
    pub(super) channels: Signal,
}

impl Settings {
    pub(super) fn inputs(m: &mut ModuleBuilder) -> Self {
        Self {
            segments: m.input("cfg_segments", Ty::u(7), "channel segments, 1 and up"),
            channels: m.input(
                "cfg_channels",
                Ty::u(7),
                "channels of the last segment, 1 to B; the others have B",
            ),
        }
    }
}

/// Counter of passes.
pub(super) struct Passes {
    segment: Signal,
    next: Signal,
    is_last: Signal,
    /// Last channel of the pass.
    pub(super) top_channel: Signal,
}

impl Passes {
    /// Declares the counter as `name`_segment.
    pub(super) fn declare(
        m: &mut ModuleBuilder,
        name: &str,
        shape: &Shape,
        settings: Settings,
    ) -> Self {
        let segment = m.reg(&format!("{name}_segment"), Ty::u(7), 0);
        let next = plus_one(m, segment);
        let next = m.name(next, &format!("{name}_next_segment"));
        let is_last = m.eq(next, settings.segments);
        let is_last = m.name(is_last, &format!("{name}_in_last_segment"));
        let all = m.lit(shape.banks - 1, Ty::u(shape.bank_bits));
        let channels = m.truncate(settings.channels, shape.bank_bits);
        let one = m.lit(1, channels.ty());
        // B channels are 0 in these bits, and B - 1 is all ones.
        let some = m.sub(channels, one);
        let top_channel = m.mux(is_last, some, all);
        let top_channel = m.name(top_channel, &format!("{name}_top_channel"));
        Self {
            segment,
            next,
            is_last,
            top_channel,
        }
    }

    /// Whether passes over the MVoxel are still to come.
    pub(super) fn amid(&self, m: &mut ModuleBuilder) -> Signal {
        m.any(self.segment)
    }

    /// Advances to the next pass when `ends`.
    pub(super) fn advance(&self, m: &mut ModuleBuilder, ends: Signal) {
        let zero = m.lit(0, self.segment.ty());
        let after = m.mux(self.is_last, zero, self.next);
        m.set_next_if(self.segment, ends, after);
    }
}
