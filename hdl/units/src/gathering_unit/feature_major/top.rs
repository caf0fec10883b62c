//! The feature-major unit's top: lanes, arbiters, banks.

use std::sync::Arc;

use potamoi_formats::config::{Config, Modes};
use potamoi_formats::units::GATHERING_UNIT;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::arbiter::bank_arbiter;
use super::lane::lane;
use super::loader::Loader;
use super::passes::Settings;
use super::sequencer::Sequencer;
use super::shape::Shape;
use super::table::table;
use crate::circuits::{bits_for, is};
use crate::gathering_unit::rit_buffer::{rit_buffer, weights};
use crate::gathering_unit::shared::ports::Ports;
use crate::gathering_unit::shared::report::{Stats, Watched, errors, outputs};
use crate::gathering_unit::shared::streams::{Beat, FeatureStream, count_both, rit_stream};

/// Builds the feature-major gathering unit for a configuration.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub(in crate::gathering_unit) fn feature_major(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let gu = &config.gu;
    let shape = Shape::of(config);
    let (banks, lanes, ports) = (shape.banks, shape.lanes, gu.ports);
    let (rit_module, table_module) = (rit_buffer(config)?, table(config)?);
    let (lane_module, arbiter) = (lane(config)?, bank_arbiter(config)?);
    let mut builder = ModuleBuilder::new(GATHERING_UNIT);
    let m = &mut builder;
    m.doc(&format!(
        "reads ray index tables and returns one feature vector an entry. Feature-major: R = {lanes} lanes share \
         B = {banks} banks of whole vectors over a crossbar. M = {ports} ports of the ray index table, \
         {}-bit features, U1.{} weights.",
        gu.feature_bits, gu.weight_bits
    ));
    let bit = Ty::bit();
    let vertices = m.input(
        "cfg_vertices",
        Ty::u(2),
        "log2 of the vertices an entry; 0 is a single id",
    );
    let settings = Settings::inputs(m);
    let clear = m.input("cfg_clear", bit, "clears counters and flags");
    let mut rit_in = rit_stream(m, config);
    let mft_in = [
        (
            "s_axis_mft_tvalid",
            bit,
            "MVoxel features, one channel of B rows a beat",
        ),
        ("s_axis_mft_tdata", Ty::u(16 * banks), ""),
        ("s_axis_mft_tkeep", Ty::u(2 * banks), "rows that there are"),
        ("s_axis_mft_tlast", bit, "ends the MVoxel's segment"),
    ]
    .map(|(name, ty, doc)| (name, m.input(name, ty, doc)));
    let ready = m.input("m_axis_feat_tready", bit, "");
    let io = Ports {
        vertices,
        segments: settings.segments,
        clear,
        ready,
    };
    let of_settings = [
        ("cfg_segments", settings.segments),
        ("cfg_channels", settings.channels),
    ];
    rit_in.extend([("cfg_vertices", vertices), of_settings[0]]);
    let rit = m.instance("rit", &rit_module, &rit_in);
    let mut table_in = mft_in.to_vec();
    table_in.extend(of_settings);
    let table = m.instance("mft", &table_module, &table_in);

    m.section("Loader: entries from the RIT buffer into the lanes");
    let loader = Loader::build(m, config, rit);
    m.connect(rit, "p_take", loader.take);
    let p_first = m.out(rit, "p_first");
    let [p_last, p_keep, p_row, p_slot] =
        ["p_last", "p_keep", "p_row", "p_slot"].map(|name| m.out(rit, name));
    let p_weight = weights(m, config, rit);

    m.section("Steps: one a channel and vertex");
    let sequencer = Sequencer::declare(m, &shape, settings);
    let step = sequencer.step;
    let in_flight = m.reg("in_flight", Ty::u(bits_for(gu.fifo_depth)), 0);
    m.note(in_flight, "beats begun and not yet taken by the sink");
    let limit = m.param(
        "BEATS_IN_FLIGHT",
        gu.fifo_depth,
        in_flight.ty(),
        "FIFO depth",
    );
    let credit = m.lt(in_flight, limit);
    let credit = m.name(credit, "credit");
    let loaded = m.out(table, "is_loaded");
    // A channel, once begun, is never held up: only its first round asks.
    let may_start = m.and(credit, loaded);
    let may_start = m.name(may_start, "may_start");
    let asks = m.and(step.new, step.first);
    let asks = m.name(asks, "begins_channel");
    let goes_on = m.not(asks);
    let may = m.or(goes_on, may_start);
    let fire = m.and(step.valid, may);
    let fire = m.name(fire, "fire");
    m.note(fire, "a round is issued");

    m.section("Lanes");
    let single = is(m, vertices, 0);
    let single = m.name(single, "single_ids");
    let (rows, words) = (m.out(table, "rows"), m.out(table, "words"));
    let d_completes = m.reg("d_completes", bit, 0);
    let x_completes = m.reg("x_completes", bit, 0);
    let slot_bits = config.rit.slot_bits;
    // A single id has the weight 1.
    let one = m.lit(1u32 << gu.weight_bits, Ty::u(gu.weight_bits + 1));
    let all: Vec<_> = (0..lanes)
        .map(|i| {
            let (group, port) = ((i / ports) as usize, i % ports);
            let kept = m.bit(p_keep, port);
            let kept = m.and(kept, loader.writes[group]);
            let row = m.slice(p_row, 16 * port, 16);
            let slot = m.slice(p_slot, slot_bits * port, slot_bits);
            let mut inputs = vec![
                ("write", loader.writes[group]),
                ("write_half", loader.half),
                ("write_vertex", loader.vertex),
                ("write_kept", kept),
                ("write_entry", loader.entries[group]),
                ("row", row),
                ("slot", slot),
                ("fire", fire),
                ("rows", rows),
                ("words", words),
                ("d_completes", d_completes),
                ("x_completes", x_completes),
            ];
            if gu.modes != Modes::Unstructured {
                let weight = m.slice(p_weight, 16 * port, gu.weight_bits + 1);
                let weight = m.mux(single, one, weight);
                inputs.extend([("weight", weight), ("first", step.first)]);
            }
            m.instance(&format!("lane{i}"), &lane_module, &inputs)
        })
        .collect();
    let of_lanes = |m: &mut ModuleBuilder, port: &str| -> Vec<Signal> {
        all.iter().map(|lane| m.out(*lane, port)).collect()
    };
    let (wants, lines) = (of_lanes(m, "wants"), of_lanes(m, "line"));
    let pending = of_lanes(m, "is_pending");

    m.section("Arbiters, one a bank");
    let lines = joined(m, &lines);
    let lines = m.name(lines, "lane_lines");
    let (mut busy, mut bank_lines, mut grants) = (vec![], vec![], vec![]);
    for b in 0..banks {
        let of_bank: Vec<_> = wants.iter().map(|w| m.bit(*w, b)).collect();
        let of_bank = joined(m, &of_bank);
        let of_bank = m.name(of_bank, &format!("wants_bank{b}"));
        let inst = m.instance(
            &format!("arbiter{b}"),
            &arbiter,
            &[("wants", of_bank), ("lines", lines)],
        );
        let asked = m.out(inst, "busy");
        busy.push(m.and(fire, asked));
        bank_lines.push(m.out(inst, "line"));
        grants.push(m.out(inst, "grants"));
    }
    let mut granted = grants[0];
    for more in &grants[1..] {
        granted = m.or(granted, *more);
    }
    let granted = m.name(granted, "granted");
    let pending = joined(m, &pending);
    let pending = m.name(pending, "pending");
    let waits = m.not(granted);
    let left = m.and(pending, waits);
    let left = m.any(left);
    let left = m.name(left, "lanes_left");
    m.note(left, "another round is needed");
    let no_more = m.not(left);
    let done = m.and(fire, no_more);
    let done = m.name(done, "step_done");
    let busy = joined(m, &busy);
    let bank_lines = joined(m, &bank_lines);
    m.connect(table, "read", busy);
    m.connect(table, "lines", bank_lines);
    m.connect(table, "channel", step.channel);
    let release = m.and(done, step.end);
    let release = m.name(release, "release_table");
    m.connect(table, "done", release);
    let completes = m.and(done, step.last);
    let completes = m.name(completes, "completes");
    let read = sequencer.advance(m, &loader, vertices, fire, done);
    for (i, lane) in all.iter().enumerate() {
        m.connect(*lane, "read", read.read);
        m.connect(*lane, "read_half", read.half);
        m.connect(*lane, "read_vertex", read.vertex);
        m.connect(*lane, "completes", completes);
        let granted = m.bit(granted, i as u32);
        m.connect(*lane, "granted", granted);
    }

    m.section("Results into the FIFO");
    m.set_next(d_completes, completes);
    m.set_next(x_completes, d_completes);
    let push = m.reg("s_push", bit, 0);
    m.set_next(push, x_completes);
    let mut end = step.end;
    for (name, enable) in [
        ("d_end", completes),
        ("x_end", d_completes),
        ("s_end", x_completes),
    ] {
        let reg = m.reg(name, bit, 0);
        m.set_next_if(reg, enable, end);
        end = reg;
    }
    let results: Vec<_> = of_lanes(m, "result")
        .into_iter()
        .map(|result| {
            let result = m.as_signed(result);
            let wide = m.extend(result, 16);
            m.as_unsigned(wide)
        })
        .collect();
    let (kept, slots) = (of_lanes(m, "result_kept"), of_lanes(m, "result_slot"));
    let beat = Beat {
        push,
        end,
        keep: joined(m, &kept),
        slot: joined(m, &slots),
        data: joined(m, &results),
    };
    let stream = FeatureStream::build(m, gu, &beat, io.ready)?;
    let begins = m.and(fire, asks);
    let begins = m.name(begins, "beat_start");
    count_both(m, in_flight, begins, stream.pop);

    let kept = of_lanes(m, "kept");
    let kept = joined(m, &kept);
    let kept = m.name(kept, "lanes_kept");
    let later = m.not(step.new);
    let stats = Stats {
        fire,
        busy: m.and(fire, step.new),
        bank: Some(m.and(fire, later)),
        group_done: m.and(done, step.last_of_entries),
        keep: kept,
        credit,
        loaded,
    };
    let outside = of_lanes(m, "outside");
    let outside = joined(m, &outside);
    let none = is(m, settings.channels, 0);
    let most = m.param("CHANNELS_MOST", banks, Ty::u(7), "");
    let too_many = m.gt(settings.channels, most);
    let watched = Watched {
        valid: loader.take,
        first: p_first,
        last: p_last,
        keep: p_keep,
        weight: p_weight,
        name: "p",
        single,
        row_not_loaded: m.any(outside),
        bad_settings: vec![none, too_many],
    };
    let errors = errors(m, config, &io, &watched, [rit, table]);
    m.section("Outputs");
    stream.outputs(
        m,
        [
            "features, one channel of R entries a beat",
            "lane 0 lowest",
            "lanes that hold an entry",
        ],
    );
    outputs(m, config, &io, &stats, errors, [rit, table]);
    builder.finish()
}

/// Side by side, the first lowest.
fn joined(m: &mut ModuleBuilder, parts: &[Signal]) -> Signal {
    let high_first: Vec<_> = parts.iter().rev().copied().collect();
    m.cat(&high_first)
}
