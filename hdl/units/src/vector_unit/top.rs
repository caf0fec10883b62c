//! Top module: acceptance, sequencing, lanes, output FIFO, counters.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_formats::timing::Pipeline;
use potamoi_formats::units::VECTOR_UNIT;
use potamoi_netlist::{Instance, IrErrors, Module, ModuleBuilder, Signal};

use super::acceptance::{Acceptance, Inputs};
use super::checks::vector_unit_checks;
use super::exponential::form;
use super::lane::lane;
use super::lanes::{LaneResults, LaneSignals, lanes};
use super::operation_kinds::OperationKinds;
use super::result_control::ResultControl;
use super::sequence::{Sequence, passes, sequence};
use super::timing::Timing;
use crate::circuits::{counter, is, sticky};
use crate::fifo::fifo;

/// Builds the vector unit for a configuration.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub fn vector_unit(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let kinds = OperationKinds::of(config);
    let timing = Timing::of(config, kinds);
    let lane_module = lane(config)?;
    let mut builder = ModuleBuilder::new(VECTOR_UNIT);
    let m = &mut builder;
    let powers = match timing.pipelined {
        true => "pipelined exponentials",
        false => form(&config.vu.exp).describe(),
    };
    let lanes_of = match config.vu.lanes {
        1 => "one lane".to_owned(),
        lanes => format!("{lanes} lanes"),
    };
    m.doc(&format!(
        "{lanes_of} of element-wise operations and {powers}, in lockstep."
    ));
    let inputs = Inputs::declare(m, config.vu.lanes);
    let accepted = Acceptance::build(m, config, kinds, &timing, &inputs);
    m.section("Sequence of an exponential");
    let logistic = accepted.orders(m, kinds, timing.lag);
    let (free, offer) = (accepted.free, accepted.offer());
    let sequence = match accepted.phase {
        Some(phase) if kinds.logistic() => passes(m, config, phase, free, offer, logistic),
        phase => sequence(m, config, phase, free, offer, timing.interval),
    };
    let tag = ResultControl::follow(
        m,
        &sequence,
        accepted.accept,
        &timing,
        [
            accepted.is_exp,
            accepted.one_minus,
            accepted.shift,
            accepted.rounding,
            inputs.keep,
            inputs.last,
        ],
    );
    let told = LaneSignals {
        config,
        kinds,
        pipelined: timing.pipelined,
        lag: (timing.lag > 0).then(|| Pipeline::element_wise(true)),
        accepted: &accepted,
        logistic,
        sequence: &sequence,
        tag: &tag,
    };
    let common = told.inputs(m)?;
    let of_lanes = lanes(m, &lane_module, &told, &common, &inputs);
    if let Some(phase) = accepted.phase {
        sequence.end(m, &config.vu.exp, phase, of_lanes.more);
    }
    let results = Results::build(m, &timing, &inputs, &accepted, &tag, of_lanes.values)?;
    let counted = Counted::build(m, &inputs, &accepted, (&sequence, &tag), &of_lanes);
    m.section("Outputs");
    results.outputs(m, config.vu.lanes, accepted.ready);
    counted.outputs(m);
    vector_unit_checks(m, results.fifo, timing.depth, timing.longest);
    builder.finish()
}

/// The FIFO of results.
struct Results {
    fifo: Instance,
    offered: Signal,
    out: Signal,
}

impl Results {
    fn build(
        m: &mut ModuleBuilder,
        timing: &Timing,
        inputs: &Inputs,
        accepted: &Acceptance,
        tag: &ResultControl,
        joined: Signal,
    ) -> Result<Self, IrErrors> {
        m.section("Results");
        let word = m.cat(&[tag.last, tag.keep, joined]);
        let module = fifo("result_fifo", timing.depth, word.width())?;
        let fifo = m.instance("fifo", &module, &[("push", tag.valid), ("push_data", word)]);
        let offered = m.out(fifo, "valid");
        let pop = m.and(offered, inputs.sink);
        let pop = m.name(pop, "pop");
        m.connect(fifo, "pop", pop);
        let out = m.out(fifo, "data");
        let inside = accepted.inside;
        let one = m.lit(1, inside.ty());
        let (more, less) = (m.add(inside, one), m.sub(inside, one));
        let next = m.mux(accepted.accept, more, less);
        let changes = m.xor(accepted.accept, pop);
        m.set_next_if(inside, changes, next);
        Ok(Self { fifo, offered, out })
    }

    fn outputs(&self, m: &mut ModuleBuilder, lanes: u32, ready: Signal) {
        m.output_low_in_reset("s_axis_vec_tready", ready, "does not depend on tvalid");
        m.output("m_axis_vec_tvalid", self.offered, "results");
        let width = 32 * lanes;
        let values = m.slice(self.out, 0, width);
        m.output(
            "m_axis_vec_tdata",
            values,
            "lane i in bits 32 i + 31 .. 32 i; lanes not kept are 0",
        );
        let kept = m.slice(self.out, width, lanes);
        let kept = m.name(kept, "results_kept");
        let bytes = m.spread("kept_bytes", kept, 4, "each");
        m.output("m_axis_vec_tkeep", bytes, "four bytes a lane");
        let ends = m.bit(self.out, width + lanes);
        m.output("m_axis_vec_tlast", ends, "");
    }
}

/// Counters and sticky flags.
struct Counted {
    vectors: Signal,
    busy: Signal,
    stall: Signal,
    /// The highest bit first.
    flags: Vec<Signal>,
    idle: Signal,
}

impl Counted {
    fn build(
        m: &mut ModuleBuilder,
        inputs: &Inputs,
        accepted: &Acceptance,
        (sequence, tag): (&Sequence, &ResultControl),
        lanes: &LaneResults,
    ) -> Self {
        m.section("Counters and flags");
        let (clear, accept) = (inputs.clear, accepted.accept);
        let vectors = counter(m, "stat_vectors", 32, clear, accept, None);
        let stepped = tag.moving.unwrap_or(sequence.busy);
        let active = m.or(accept, stepped);
        let busy = counter(m, "stat_busy", 32, clear, active, None);
        let no_room = m.not(accepted.room);
        let refused = m.all_of(&[inputs.valid, accepted.free, no_room]);
        let stall = counter(m, "stat_stall_out", 32, clear, refused, None);
        let built = m.any_of(&accepted.built);
        let not_built = m.not(built);
        let unknown = m.and(accept, not_built);
        let unknown = sticky(m, "operation_not_built", clear, unknown);
        let reserved = is(m, accepted.rounding, 3);
        let reserved = m.and(accept, reserved);
        let reserved = sticky(m, "rounding_reserved", clear, reserved);
        let torn = m.and(accept, lanes.torn);
        let torn = sticky(m, "torn_lane", clear, torn);
        let mut flags = vec![torn, reserved, unknown];
        if let Some(beyond) = lanes.beyond {
            let beyond = m.and(accept, beyond);
            flags.insert(0, sticky(m, "operand_beyond", clear, beyond));
        }
        let flying = m.any(accepted.inside);
        Self {
            vectors,
            busy,
            stall,
            flags,
            idle: m.not(flying),
        }
    }

    fn outputs(&self, m: &mut ModuleBuilder) {
        m.output("stat_vectors", self.vectors, "vectors accepted");
        m.output(
            "stat_busy",
            self.busy,
            "cycles in which a vector is accepted or stepped",
        );
        m.output(
            "stat_stall_out",
            self.stall,
            "cycles in which only the lack of room refuses a vector",
        );
        m.output("idle", self.idle, "no vector is in flight");
        let flags = m.cat(&self.flags);
        let doc = "2 torn lane, 1 reserved rounding, 0 not built";
        let doc = match self.flags.len() {
            4.. => format!("sticky: 3 operand beyond its width, {doc}"),
            _ => format!("sticky: {doc}"),
        };
        m.output("stat_errors", flags, &doc);
    }
}
