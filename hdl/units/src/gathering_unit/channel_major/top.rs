//! Top module of the channel-major unit: issue, reducers, output FIFO.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_formats::units::GATHERING_UNIT;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::checks::{Parts, gathering_unit_checks};
use super::inputs::Inputs;
use super::issue::{Below, Issue};
use super::product_stages::{Summed, summed};
use super::reducers::Reducers;
use super::stage_one::StageOne;
use crate::gathering_unit::shared::idle::{idle, setting_moved};
use crate::gathering_unit::shared::report::{Stats, Watched, errors, outputs};
use crate::gathering_unit::shared::streams::{Beat, FeatureStream, count_both};

/// Builds the gathering unit in the channel-major or the parity organisation.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub(in crate::gathering_unit) fn channel_major(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let (below, reducers) = (Below::of(config)?, Reducers::of(config)?);
    let mut builder = ModuleBuilder::new(GATHERING_UNIT);
    let m = &mut builder;
    m.doc(&doc(config));
    let inputs = Inputs::declare(m, config);
    let issue = Issue::build(m, config, &below, &inputs);
    let s1 = StageOne::build(m, config, &issue, inputs.io.vertices);
    let done = summed(m, config, &s1);
    let data = reducers.build(m, &inputs, &issue, &s1, &done);
    let beat = beat(m, config, &done, data);
    let stream = FeatureStream::build(m, config, &beat, inputs.io.ready)?;
    count_both(m, issue.in_flight, issue.group_start, stream.pop);
    let stats = stats(m, config, &issue);
    let below = [issue.rit, issue.table];
    let idle = idle(m, issue.in_flight, below, &[]);
    let mut settings = vec![inputs.io.vertices, inputs.io.segments];
    settings.extend(inputs.two_records);
    let watched = Watched {
        valid: s1.valid,
        first: s1.first,
        last: s1.last,
        keep: s1.keep,
        weight: s1.weight,
        name: "s1",
        single: s1.single,
        row_not_loaded: s1.row_not_loaded(m, config),
        bad_settings: vec![],
        setting_moved: setting_moved(m, &settings, idle),
    };
    let errors = errors(m, config, &inputs.io, &watched, below);
    m.section("Outputs");
    stream.outputs(
        m,
        [
            "features, M entries a beat",
            "port 0 lowest, channel 0 lowest",
            "ports that hold an entry",
        ],
    );
    outputs(m, config, &inputs.io, &stats, (errors, idle), below);
    let parts = Parts {
        rit: issue.rit,
        fifo: stream.fifo,
    };
    gathering_unit_checks(m, config, &parts);
    builder.finish()
}

fn doc(config: &Config) -> String {
    let gu = &config.gu;
    let at_once = match config.is_parity() {
        true => format!(
            " All eight vertices of a cell are read at once, {} channels of each.",
            config.lanes_a_port()
        ),
        false => String::new(),
    };
    format!(
        "reads ray index tables and returns one feature vector an entry. B = {} banks, M = {} ports, \
         {}-bit features, U1.{} weights.{at_once}",
        gu.banks, gu.ports, gu.feature_bits, gu.weight_bits,
    )
}

/// Registers the results of a group with their control signals.
fn beat(m: &mut ModuleBuilder, config: &Config, done: &Summed, data: Signal) -> Beat {
    m.section("Results into the FIFO");
    let bit = Ty::bit();
    let s2_push = m.reg("s2_push", bit, 0);
    let push = m.and(done.valid, done.last);
    let push = m.name(push, "completes");
    m.set_next(s2_push, push);
    let [end, keep, slot] = [
        ("s2_end", done.end, bit),
        ("s2_keep", done.keep, Ty::u(config.gu.ports)),
        ("s2_slot", done.slot, done.slot.ty()),
    ]
    .map(|(name, from, ty)| {
        let reg = m.data_reg(name, ty);
        m.set_next_if(reg, push, from);
        reg
    });
    Beat {
        push: s2_push,
        end,
        keep,
        slot,
        data,
    }
}

/// Signals observed by the counters.
fn stats(m: &mut ModuleBuilder, config: &Config, issue: &Issue) -> Stats {
    let group_done = m.and(issue.fire, issue.offered.last);
    let group_done = m.name(group_done, "group_done");
    let bank = (config.table_parts() > 1).then(|| {
        let some_wait = m.not(issue.fire);
        m.and(issue.asks, some_wait)
    });
    Stats {
        fire: issue.asks,
        busy: issue.fire,
        bank,
        group_done,
        keep: issue.offered.keep,
        credit: issue.credit,
        loaded: issue.loaded,
    }
}
