//! The channel-major unit's top: issue, reducers, output FIFO.

use std::sync::Arc;

use potamoi_formats::config::{Config, Modes};
use potamoi_formats::units::GATHERING_UNIT;

use super::mft::mft;
use super::reducer::reducer;
use super::report::{Stats, Watched, errors, statistics};
use super::rit_buffer::rit_buffer;
use super::streams::{Beat, FeatureStream, count_both, rit_stream};
use crate::ir::{IrErrors, Module, ModuleBuilder, Signal, Ty};
use crate::parts::{bits_for, is};

/// Ports of the top.
pub(super) struct Ports {
    pub(super) vertices: Signal,
    pub(super) segments: Signal,
    pub(super) clear: Signal,
    pub(super) ready: Signal,
}

/// A register stage behind the MFT's read.
pub(super) struct Stage {
    pub(super) valid: Signal,
    pub(super) first: Signal,
    pub(super) last: Signal,
    pub(super) end: Signal,
    pub(super) keep: Signal,
    pub(super) in_range: Signal,
    pub(super) weight: Signal,
    pub(super) slot: Signal,
}

/// Builds the channel-major gathering unit for a configuration.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub(super) fn channel_major(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let gu = &config.gu;
    let (banks, ports, bits) = (gu.banks, gu.ports, gu.feature_bits);
    let (rit_module, mft_module, reducer_module) =
        (rit_buffer(config)?, mft(config)?, reducer(config)?);
    let mut builder = ModuleBuilder::new(GATHERING_UNIT);
    let m = &mut builder;
    m.doc(&format!(
        "reads ray index tables and returns one feature vector an entry. B = {banks} banks, M = {ports} ports, \
         {bits}-bit features, U1.{} weights.",
        gu.weight_bits
    ));
    let bit = Ty::bit();
    let vertices = m.input(
        "cfg_vertices",
        Ty::u(2),
        "log2 of the vertices an entry; 0 is a single id",
    );
    let segments = m.input("cfg_segments", Ty::u(7), "channel segments, 1 and up");
    let clear = m.input("cfg_clear", bit, "clears counters and flags");
    let rit_in = rit_stream(m, config);
    let mft_in = [
        (
            "s_axis_mft_tvalid",
            m.input("s_axis_mft_tvalid", bit, "MVoxel features, a row a beat"),
        ),
        (
            "s_axis_mft_tdata",
            m.input("s_axis_mft_tdata", Ty::u(16 * banks), ""),
        ),
        (
            "s_axis_mft_tlast",
            m.input(
                "s_axis_mft_tlast",
                bit,
                "ends the MVoxel's rows of this segment",
            ),
        ),
    ];
    let ready = m.input("m_axis_feat_tready", bit, "");
    let io = Ports {
        vertices,
        segments,
        clear,
        ready,
    };

    m.section("Issue: registers");
    let flight_ty = Ty::u(bits_for(gu.fifo_depth));
    let in_flight = m.reg("in_flight", flight_ty, 0);
    m.note(in_flight, "groups issued and not yet taken by the sink");
    let limit = m.param("GROUPS_IN_FLIGHT", gu.fifo_depth, flight_ty, "FIFO depth");
    let credit = m.lt(in_flight, limit);
    let credit = m.name(credit, "credit");
    let mut rit_inputs = rit_in;
    rit_inputs.extend([("cfg_vertices", vertices), ("cfg_segments", segments)]);
    let rit = m.instance("rit", &rit_module, &rit_inputs);
    let table = m.instance("mft", &mft_module, &mft_in);
    let mut of_rit = |name: &str| m.out(rit, name);
    let [p_valid, p_first, p_last, p_end, p_keep] =
        ["p_valid", "p_first", "p_last", "p_end", "p_keep"].map(&mut of_rit);
    let [p_row, p_weight, p_slot] = ["p_row", "p_weight", "p_slot"].map(&mut of_rit);
    let loaded = m.out(table, "is_loaded");
    // A group, once begun, is never held up: only its first vertex asks.
    let may_start = m.and(credit, loaded);
    let may_start = m.name(may_start, "may_start");
    let goes_on = m.not(p_first);
    let may = m.or(goes_on, may_start);
    let fire = m.and(p_valid, may);
    let fire = m.name(fire, "fire");
    m.note(fire, "a vertex is issued");
    let release = m.all_of(&[fire, p_last, p_end]);
    let release = m.name(release, "release_table");
    m.connect(rit, "p_take", fire);
    m.connect(table, "read", fire);
    m.connect(table, "read_row", p_row);
    m.connect(table, "read_keep", p_keep);
    m.connect(table, "done", release);
    let group_start = m.and(fire, p_first);
    let group_start = m.name(group_start, "group_start");

    m.section("Stage 1: features of the rows that were read");
    let in_range = m.out(table, "in_range");
    let s1 = Stage {
        valid: m.reg("s1_valid", bit, 0),
        first: m.reg("s1_first", bit, 0),
        last: m.reg("s1_last", bit, 0),
        end: m.reg("s1_end", bit, 0),
        keep: m.reg("s1_keep", Ty::u(ports), 0),
        in_range: m.reg("s1_in_range", Ty::u(ports), 0),
        weight: m.reg("s1_weight", Ty::u(16 * ports), 0),
        slot: m.reg("s1_slot", Ty::u(config.rit.slot_bits * ports), 0),
    };
    m.set_next(s1.valid, fire);
    for (reg, value) in [
        (s1.first, p_first),
        (s1.last, p_last),
        (s1.end, p_end),
        (s1.keep, p_keep),
        (s1.in_range, in_range),
        (s1.weight, p_weight),
        (s1.slot, p_slot),
    ] {
        m.set_next_if(reg, fire, value);
    }
    let single = is(m, vertices, 0);
    let single = m.name(single, "single_ids");

    m.section("Reducers: one a channel and port");
    let mut results = vec![];
    for port in 0..ports {
        let table_out = m.out(table, &format!("feature{port}"));
        let ok = m.bit(s1.in_range, port);
        let mask = m.repeat(ok, bits * banks);
        let features = m.and(table_out, mask);
        let features = m.name(features, &format!("s1_features{port}"));
        let weight = m.slice(s1.weight, 16 * port, gu.weight_bits + 1);
        for b in 0..banks {
            let feature = m.slice(features, b * bits, bits);
            let feature = m.as_signed(feature);
            let mut inputs = vec![("valid", s1.valid), ("feature", feature)];
            if gu.modes != Modes::Unstructured {
                inputs.extend([("first", s1.first), ("weight", weight)]);
            }
            if gu.modes == Modes::Both {
                inputs.push(("skip", single));
            }
            let inst = m.instance(&format!("reducer{port}_{b}"), &reducer_module, &inputs);
            let result = m.out(inst, "result");
            let result = m.as_signed(result);
            let lane = m.extend(result, 16);
            results.push(m.as_unsigned(lane));
        }
    }

    m.section("Stage 2: results into the FIFO");
    let s2_push = m.reg("s2_push", bit, 0);
    let push = m.and(s1.valid, s1.last);
    let push = m.name(push, "s1_completes");
    m.set_next(s2_push, push);
    let tail = [
        ("s2_end", s1.end, bit),
        ("s2_keep", s1.keep, Ty::u(ports)),
        ("s2_slot", s1.slot, s1.slot.ty()),
    ]
    .map(|(name, from, ty)| {
        let reg = m.reg(name, ty, 0);
        m.set_next_if(reg, push, from);
        reg
    });
    results.reverse();
    let data = m.cat(&results);
    let beat = Beat {
        push: s2_push,
        end: tail[0],
        keep: tail[1],
        slot: tail[2],
        data,
    };
    let stream = FeatureStream::build(m, gu.fifo_depth, &beat, io.ready)?;
    count_both(m, in_flight, group_start, stream.pop);

    let group_done = m.and(fire, p_last);
    let group_done = m.name(group_done, "group_done");
    let stats = Stats {
        fire,
        busy: fire,
        bank: None,
        group_done,
        keep: p_keep,
        credit,
        loaded,
    };
    let outside: Vec<_> = (0..ports)
        .map(|p| {
            let kept = m.bit(s1.keep, p);
            let ok = m.bit(s1.in_range, p);
            let outside = m.not(ok);
            m.and(kept, outside)
        })
        .collect();
    let outside = m.any_of(&outside);
    let row_not_loaded = m.and(s1.valid, outside);
    let watched = Watched {
        valid: s1.valid,
        first: s1.first,
        last: s1.last,
        keep: s1.keep,
        weight: s1.weight,
        name: "s1",
        single,
        row_not_loaded,
        bad_settings: vec![],
    };
    let errors = errors(m, config, &io, &watched, [rit, table]);
    m.section("Outputs");
    stream.outputs(
        m,
        [
            "features, M entries a beat",
            "port 0 lowest, channel 0 lowest",
            "ports that hold an entry",
        ],
    );
    let rit_ready = m.out(rit, "s_axis_rit_tready");
    m.output("s_axis_rit_tready", rit_ready, "");
    let mft_ready = m.out(table, "s_axis_mft_tready");
    m.output("s_axis_mft_tready", mft_ready, "");
    statistics(m, config, &io, &stats);
    m.output(
        "stat_errors",
        errors,
        "sticky; docs/gathering-unit.md names the bits",
    );
    builder.finish()
}
