//! The channel-major unit's top: issue, reducers, output FIFO.

use std::sync::Arc;

use potamoi_formats::config::{Config, Modes};
use potamoi_formats::units::GATHERING_UNIT;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::mft::mft;
use crate::circuits::{bits_for, is};
use crate::gathering_unit::parity::cell_reducer::cell_reducer;
use crate::gathering_unit::rit_buffer::{rit_buffer, weights};
use crate::gathering_unit::shared::ports::Ports;
use crate::gathering_unit::shared::reducer::{LATER, reducer};
use crate::gathering_unit::shared::report::{Stats, Watched, errors, outputs};
use crate::gathering_unit::shared::streams::{Beat, FeatureStream, count_both, rit_stream};

/// Inputs of a cell's reducer.
const FEATURES: [&str; 8] = [
    "feature0", "feature1", "feature2", "feature3", "feature4", "feature5", "feature6", "feature7",
];
const WEIGHTS: [&str; 8] = [
    "weight0", "weight1", "weight2", "weight3", "weight4", "weight5", "weight6", "weight7",
];

/// The register stage behind the MFT's read.
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

/// What goes with the terms that are summed up.
struct Summed {
    valid: Signal,
    /// Where terms arrive: at all ports with `valid`, or a bit a port where ports
    /// take turns at the table.
    arrives: Signal,
    first: Signal,
    last: Signal,
    end: Signal,
    keep: Signal,
    slot: Signal,
    /// Enables of the stages behind stage 1, by their names at the reducers.
    enables: Vec<(&'static str, Signal)>,
}

/// Stage 1 itself, or the last of the stages behind it where products are
/// registered.
fn summed(m: &mut ModuleBuilder, config: &Config, s1: &Stage, turns: Option<Signal>) -> Summed {
    let whole_cells = config.is_parity();
    let mut stage = Summed {
        valid: s1.valid,
        arrives: turns.unwrap_or(s1.valid),
        first: s1.first,
        last: s1.last,
        end: s1.end,
        keep: s1.keep,
        slot: s1.slot,
        enables: vec![],
    };
    let names = &LATER[LATER.len() - config.product_stages() as usize..];
    for name in names {
        if stage.enables.is_empty() {
            m.section("Stages of the products");
        }
        let valid = m.reg(&format!("{name}_valid"), Ty::bit(), 0);
        m.set_next(valid, stage.valid);
        let (before, arrives) = match turns {
            None => (stage.valid, valid),
            Some(read) => {
                let arrives = m.reg(&format!("{name}_read"), read.ty(), 0);
                m.set_next(arrives, stage.arrives);
                (m.any(stage.arrives), arrives)
            }
        };
        let mut follow = |what: &str, from: Signal| {
            let reg = m.reg(&format!("{name}_{what}"), from.ty(), 0);
            m.set_next_if(reg, before, from);
            reg
        };
        let mut enables = stage.enables;
        enables.push((*name, arrives));
        stage = Summed {
            valid,
            arrives,
            first: if whole_cells {
                stage.first
            } else {
                follow("first", stage.first)
            },
            last: if whole_cells {
                stage.last
            } else {
                follow("last", stage.last)
            },
            end: follow("end", stage.end),
            keep: follow("keep", stage.keep),
            slot: follow("slot", stage.slot),
            enables,
        };
    }
    stage
}

/// Builds the channel-major gathering unit, or the one by parity.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub(in crate::gathering_unit) fn channel_major(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let gu = &config.gu;
    let (banks, ports, bits) = (gu.banks, gu.ports, gu.feature_bits);
    let whole_cells = config.is_parity();
    let groups = config.vertices_a_row();
    let (rit_module, mft_module) = (rit_buffer(config)?, mft(config)?);
    let reducer_module = if whole_cells {
        cell_reducer(config)?
    } else {
        reducer(config)?
    };
    let mut builder = ModuleBuilder::new(GATHERING_UNIT);
    let m = &mut builder;
    m.doc(&format!(
        "reads ray index tables and returns one feature vector an entry. B = {banks} banks, M = {ports} ports, \
         {bits}-bit features, U1.{} weights.{}",
        gu.weight_bits,
        match whole_cells {
            true => format!(
                " All eight vertices of a cell are read at once, {} channels of each.",
                config.lanes_a_port()
            ),
            false => String::new(),
        }
    ));
    let bit = Ty::bit();
    let vertices = m.input(
        "cfg_vertices",
        Ty::u(2),
        "log2 of the vertices an entry; 0 is a single id",
    );
    let segments = m.input("cfg_segments", Ty::u(7), "channel segments, 1 and up");
    let clear = m.input("cfg_clear", bit, "clears counters and flags");
    let two = (gu.records_a_row == 2).then(|| {
        m.input(
            "cfg_two_records",
            bit,
            "two records of B / 2 channels share a row; the id's bit above the row says which",
        )
    });
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
    let [p_valid, p_end, p_keep] = ["p_valid", "p_end", "p_keep"].map(&mut of_rit);
    let [p_row, p_slot] = ["p_row", "p_slot"].map(&mut of_rit);
    let p_weight = weights(m, config, rit);
    // A cell is the first and the last of its group.
    let [p_first, p_last] = match whole_cells {
        true => [m.lit(1, bit); 2],
        false => ["p_first", "p_last"].map(|name| m.out(rit, name)),
    };
    let loaded = m.out(table, "is_loaded");
    // A group, once begun, needs no more room: only its first vertex asks.
    let may_start = m.and(credit, loaded);
    let may_start = m.name(may_start, "may_start");
    let may = match whole_cells {
        true => may_start,
        false => {
            let goes_on = m.not(p_first);
            m.or(goes_on, may_start)
        }
    };
    let asks = m.and(p_valid, may);
    let split = config.table_parts() > 1;
    let (asks, fire, granted) = if split {
        let fire = m.out(table, "is_read");
        (m.name(asks, "asks"), fire, Some(m.out(table, "granted")))
    } else {
        (asks, asks, None)
    };
    let fire = m.name(fire, "fire");
    m.note(fire, "a vertex is issued");
    let asks = if split { asks } else { fire };
    let release = m.all_of(&[fire, p_last, p_end]);
    let release = m.name(release, "release_table");
    m.connect(rit, "p_take", fire);
    m.connect(table, "read", asks);
    let shared = two.map(|two| SharedRows::of(m, config, two, p_row));
    m.connect(table, "read_row", shared.as_ref().map_or(p_row, |s| s.rows));
    m.connect(table, "read_keep", p_keep);
    m.connect(table, "done", release);
    let group_start = m.and(fire, p_first);
    let group_start = m.name(group_start, "group_start");

    m.section("Stage 1: features of the rows that were read");
    let step = |m: &mut ModuleBuilder, name: &str, of_p: Signal| match whole_cells {
        true => of_p,
        false => m.reg(name, bit, 0),
    };
    let in_range = m.out(table, "in_range");
    let s1 = Stage {
        valid: m.reg("s1_valid", bit, 0),
        first: step(m, "s1_first", p_first),
        last: step(m, "s1_last", p_last),
        end: m.reg("s1_end", bit, 0),
        keep: m.reg("s1_keep", Ty::u(ports), 0),
        in_range: m.reg("s1_in_range", Ty::u(ports * groups), 0),
        weight: m.reg("s1_weight", Ty::u(16 * ports * groups), 0),
        slot: m.reg("s1_slot", Ty::u(config.rit.slot_bits * ports), 0),
    };
    m.set_next(s1.valid, fire);
    for (reg, value) in [
        (s1.end, p_end),
        (s1.keep, p_keep),
        (s1.in_range, in_range),
        (s1.slot, p_slot),
    ] {
        m.set_next_if(reg, asks, value);
    }
    if !whole_cells {
        m.set_next_if(s1.first, asks, p_first);
        m.set_next_if(s1.last, asks, p_last);
    }
    let turns = granted.map(|granted| {
        let reg = m.reg("s1_read", granted.ty(), 0);
        m.note(reg, "ports whose rows were read");
        m.set_next(reg, granted);
        reg
    });
    let single = is(m, vertices, 0);
    let single = m.name(single, "single_ids");
    let weight = if gu.modes == Modes::Both {
        let one = m.lit(1u32 << gu.weight_bits, Ty::u(16));
        let ones = vec![one; ports as usize];
        let ones = m.cat(&ones);
        m.mux(single, ones, p_weight)
    } else {
        p_weight
    };
    m.set_next_if(s1.weight, asks, weight);
    let upper = shared.as_ref().map(|shared| {
        let reg = m.reg("s1_upper_record", Ty::u(ports), 0);
        m.set_next_if(reg, asks, shared.upper);
        reg
    });

    let done = summed(m, config, &s1, turns);

    m.section(match gu.modes {
        Modes::Unstructured => "Features, one register a channel and port",
        _ => "Reducers: one a channel and port",
    });
    let (lanes, lane_bits) = (config.lanes_a_port(), config.feature_lane_bits());
    let mut results = vec![];
    for port in 0..ports {
        let table_out = m.out(table, &format!("feature{port}"));
        let masks: Vec<_> = (0..groups)
            .rev()
            .map(|g| {
                let ok = m.bit(s1.in_range, port * groups + g);
                m.repeat(ok, bits * lanes)
            })
            .collect();
        let mask = m.cat(&masks);
        let mut features = m.and(table_out, mask);
        if let (Some(two), Some(upper)) = (two, upper) {
            let upper = m.bit(upper, port);
            features = one_record(m, features, two, upper);
        }
        let features = m.name(features, &format!("s1_features{port}"));
        let weights: Vec<_> = (0..groups)
            .map(|g| m.slice(s1.weight, 16 * (port * groups + g), gu.weight_bits + 1))
            .collect();
        // Its own bit where ports take turns.
        let own = |m: &mut ModuleBuilder, arrives: Signal| match turns {
            None => arrives,
            Some(_) => m.bit(arrives, port),
        };
        let mut enables = vec![("valid", own(m, turns.unwrap_or(s1.valid)))];
        for &(name, arrives) in &done.enables {
            enables.push((name, own(m, arrives)));
        }
        for lane in 0..lanes {
            let feature = |m: &mut ModuleBuilder, g: u32| {
                let feature = m.slice(features, (g * lanes + lane) * bits, bits);
                m.as_signed(feature)
            };
            let mut inputs = enables.clone();
            if whole_cells {
                for g in 0..groups {
                    let at = g as usize;
                    inputs.push((FEATURES[at], feature(m, g)));
                    inputs.push((WEIGHTS[at], weights[at]));
                }
            } else {
                inputs.push(("feature", feature(m, 0)));
                if gu.modes != Modes::Unstructured {
                    inputs.extend([("first", done.first), ("weight", weights[0])]);
                }
            }
            let name = match gu.modes {
                Modes::Unstructured => format!("register{port}_{lane}"),
                _ => format!("reducer{port}_{lane}"),
            };
            let inst = m.instance(&name, &reducer_module, &inputs);
            let result = m.out(inst, "result");
            let result = m.as_signed(result);
            let lane = m.extend(result, lane_bits);
            results.push(m.as_unsigned(lane));
        }
    }

    m.section("Results into the FIFO");
    let s2_push = m.reg("s2_push", bit, 0);
    let push = m.and(done.valid, done.last);
    let push = m.name(push, "completes");
    m.set_next(s2_push, push);
    let tail = [
        ("s2_end", done.end, bit),
        ("s2_keep", done.keep, Ty::u(ports)),
        ("s2_slot", done.slot, done.slot.ty()),
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
    let stream = FeatureStream::build(m, gu, &beat, io.ready)?;
    count_both(m, in_flight, group_start, stream.pop);

    let group_done = m.and(fire, p_last);
    let group_done = m.name(group_done, "group_done");
    let bank = split.then(|| {
        let some_wait = m.not(fire);
        m.and(asks, some_wait)
    });
    let stats = Stats {
        fire: asks,
        busy: fire,
        bank,
        group_done,
        keep: p_keep,
        credit,
        loaded,
    };
    let outside: Vec<_> = (0..ports)
        .map(|p| {
            let kept = m.bit(s1.keep, p);
            let ok = m.slice(s1.in_range, p * groups, groups);
            let ok = m.all(ok);
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
    outputs(m, config, &io, &stats, errors, [rit, table]);
    builder.finish()
}

/// Two records a row.
struct SharedRows {
    /// Rows of the ids, without the bit that picks a record.
    rows: Signal,
    /// Of each port, whether the upper record is asked for.
    upper: Signal,
}

impl SharedRows {
    fn of(m: &mut ModuleBuilder, config: &Config, two: Signal, ids: Signal) -> Self {
        let at = config.row_bits();
        let (mut rows, mut upper) = (vec![], vec![]);
        for port in (0..config.gu.ports).rev() {
            let id = m.slice(ids, 16 * port, 16);
            let picks = m.bit(id, at);
            let low = m.slice(id, 0, at);
            let row = if at < 15 {
                let above = m.slice(id, at + 1, 15 - at);
                m.cat(&[above, low])
            } else {
                low
            };
            let row = m.extend(row, 16);
            let row = m.mux(two, row, id);
            rows.push(m.name(row, &format!("row_of_port{port}")));
            upper.push(picks);
        }
        Self {
            rows: m.cat(&rows),
            upper: m.cat(&upper),
        }
    }
}

/// The record of a row that is asked for, in the lower half; the upper is 0.
fn one_record(m: &mut ModuleBuilder, row: Signal, two: Signal, upper: Signal) -> Signal {
    let half = row.width() / 2;
    let (low, high) = (m.slice(row, 0, half), m.slice(row, half, half));
    let moves = m.and(two, upper);
    let lower = m.mux(moves, high, low);
    let whole = m.not(two);
    let mask = m.repeat(whole, half);
    let rest = m.and(high, mask);
    m.cat(&[rest, lower])
}
