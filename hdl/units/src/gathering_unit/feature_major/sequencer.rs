//! Sequencer of steps: one step for each channel and vertex of R entries.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::loader::Loader;
use super::passes::{Passes, Settings};
use super::shape::Shape;
use crate::circuits::{is, plus_one};

/// The requested step, and the read position of the next one.
pub(super) struct Sequencer {
    half: Signal,
    channel: Signal,
    vertex: Signal,
    passes: Passes,
    pub(super) step: Step,
}

/// The step held by the lanes.
#[derive(Clone, Copy)]
pub(super) struct Step {
    pub(super) valid: Signal,
    /// Whether none of its rounds was issued.
    pub(super) new: Signal,
    /// Whether its vertex is 0, and whether it is V-1.
    pub(super) first: Signal,
    pub(super) last: Signal,
    pub(super) channel: Signal,
    /// Whether it is the last of its entries, and the last of its pass.
    pub(super) last_of_entries: Signal,
    pub(super) end: Signal,
}

/// Read control for the lanes.
pub(super) struct Read {
    pub(super) read: Signal,
    pub(super) half: Signal,
    pub(super) vertex: Signal,
}

impl Sequencer {
    pub(super) fn declare(m: &mut ModuleBuilder, shape: &Shape, settings: Settings) -> Self {
        let bit = Ty::bit();
        let channel = Ty::u(shape.bank_bits);
        let half = m.reg("next_half", bit, 0);
        let next_channel = m.reg("next_channel", channel, 0);
        let vertex = m.reg("next_vertex", Ty::u(3), 0);
        let passes = Passes::declare(m, "step", shape, settings);
        let step = Step {
            valid: m.reg("step_valid", bit, 0),
            new: m.reg("step_new", bit, 0),
            first: m.data_reg("step_first", bit),
            last: m.data_reg("step_last", bit),
            channel: m.data_reg("step_channel", channel),
            last_of_entries: m.data_reg("step_ends_entries", bit),
            end: m.data_reg("step_ends_pass", bit),
        };
        m.note(step.new, "no round of it was issued yet");
        Self {
            half,
            channel: next_channel,
            vertex,
            passes,
            step,
        }
    }

    /// Signs of work: a step to do, or passes that are still to come.
    pub(super) fn busy(&self, m: &mut ModuleBuilder) -> [Signal; 2] {
        [self.step.valid, self.passes.amid(m)]
    }

    /// Reads the next step once the current one, if any, is `done`; `fire` issues a round of it.
    pub(super) fn advance(
        &self,
        m: &mut ModuleBuilder,
        loader: &Loader,
        vertices: Signal,
        fire: Signal,
        done: Signal,
    ) -> Read {
        let (ready, ends) = loader.half(m, self.half);
        let step = &self.step;
        let free = m.not(step.valid);
        let free = m.or(free, done);
        let read = m.and(ready, free);
        let read = m.name(read, "read_step");
        let first = is(m, self.vertex, 0);
        let tops: Vec<_> = [0u32, 1, 3, 7]
            .into_iter()
            .map(|top| m.lit(top, Ty::u(3)))
            .collect();
        let top = m.select(vertices, &tops);
        let top = m.name(top, "top_vertex");
        let last = m.eq(self.vertex, top);
        let last = m.name(last, "next_is_last_vertex");
        let channel_last = m.eq(self.channel, self.passes.top_channel);
        let last_of_entries = m.and(last, channel_last);
        let last_of_entries = m.name(last_of_entries, "next_ends_entries");
        let end = m.and(last_of_entries, ends);
        let end = m.name(end, "next_ends_pass");

        let stays = m.not(done);
        let stays = m.and(step.valid, stays);
        let valid = m.or(read, stays);
        m.set_next(step.valid, valid);
        let idle = m.not(fire);
        let new = m.and(step.new, idle);
        let new = m.or(read, new);
        m.set_next(step.new, new);
        for (reg, value) in [
            (step.first, first),
            (step.last, last),
            (step.channel, self.channel),
            (step.last_of_entries, last_of_entries),
            (step.end, end),
        ] {
            m.set_next_if(reg, read, value);
        }

        let zero_vertex = m.lit(0, self.vertex.ty());
        let more = plus_one(m, self.vertex);
        let after = m.mux(last, zero_vertex, more);
        m.set_next_if(self.vertex, read, after);
        let next_channel = m.and(read, last);
        let zero_channel = m.lit(0, self.channel.ty());
        let more = plus_one(m, self.channel);
        let after = m.mux(channel_last, zero_channel, more);
        m.set_next_if(self.channel, next_channel, after);
        let release = m.and(read, last_of_entries);
        let release = m.name(release, "release_lanes");
        loader.release(m, self.half, release);
        let other = m.not(self.half);
        m.set_next_if(self.half, release, other);
        let pass_ends = m.and(read, end);
        self.passes.advance(m, pass_ends);
        Read {
            read,
            half: self.half,
            vertex: self.vertex,
        }
    }
}
