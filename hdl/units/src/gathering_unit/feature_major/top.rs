//! Top module of the feature-major unit: lanes, arbiters, banks.

use std::sync::Arc;

use potamoi_formats::config::{Config, Modes};
use potamoi_formats::timing::{CrossbarStage, Pipeline};
use potamoi_formats::units::GATHERING_UNIT;
use potamoi_netlist::{Instance, IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::arbiter::bank_arbiter;
use super::lane::lane;
use super::loader::Loader;
use super::passes::Settings;
use super::sequencer::Sequencer;
use super::shape::Shape;
use super::table::table;
use crate::circuits::{bits_for, is};
use crate::gathering_unit::rit_buffer::{rit_buffer, weights};
use crate::gathering_unit::shared::idle::{idle, setting_moved};
use crate::gathering_unit::shared::ports::Ports;
use crate::gathering_unit::shared::report::{Stats, Watched, errors, outputs};
use crate::gathering_unit::shared::streams::{Beat, FeatureStream, count_both, rit_stream};
use crate::gathering_unit::shared::unit_checks::environment;
use crate::stream_checks::stable_stream;

/// Builds the feature-major gathering unit for a configuration.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub(in crate::gathering_unit) fn feature_major(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let shape = Shape::of(config);
    let modules = Modules::of(config)?;
    let mut builder = ModuleBuilder::new(GATHERING_UNIT);
    let m = &mut builder;
    m.doc(&format!(
        "reads ray index tables and returns one feature vector an entry. Feature-major: R = {} lanes share \
         B = {} banks of whole vectors over a crossbar. M = {} ports of the ray index table, \
         {}-bit features, U1.{} weights.",
        shape.lanes, shape.banks, config.gu.ports, config.gu.feature_bits, config.gu.weight_bits
    ));
    let below = Below::declare(m, config, &shape, &modules);
    m.section("Loader: entries from the RIT buffer into the lanes");
    let loader = Loader::build(m, config, below.rit);
    m.connect(below.rit, "p_take", loader.take);
    let p = Offered::of(m, config, below.rit);
    let issue = Issue::build(m, config, &shape, &below);
    let lanes = Lanes::build(m, config, &modules, &below, (&loader, &p, &issue));
    let round = Round::build(m, &shape, &modules, &below, &issue, &lanes);
    let read = issue
        .sequencer
        .advance(m, &loader, below.io.vertices, issue.fire, round.done);
    for (i, lane) in lanes.all.iter().enumerate() {
        m.connect(*lane, "read", read.read);
        m.connect(*lane, "read_half", read.half);
        m.connect(*lane, "read_vertex", read.vertex);
        m.connect(*lane, "completes", round.completes);
        let granted = m.bit(round.granted, i as u32);
        m.connect(*lane, "granted", granted);
    }
    let beat = beat(m, &issue, &lanes, round.completes);
    let stream = FeatureStream::build(m, config, &beat, below.io.ready)?;
    let begins = m.and(issue.fire, issue.begins_channel);
    let begins = m.name(begins, "beat_start");
    count_both(m, issue.in_flight, begins, stream.pop);
    let stats = stats(m, &issue, &lanes, round.done);
    let instances = [below.rit, below.table];
    let mut busy = loader.full.to_vec();
    busy.extend(issue.sequencer.busy(m));
    let idle = idle(m, issue.in_flight, instances, &busy);
    let watched = watched(m, &shape, &below, (&loader, &p, &lanes), idle);
    let errors = errors(m, config, &below.io, &watched, instances);
    m.section("Outputs");
    stream.outputs(
        m,
        [
            "features, one channel of R entries a beat",
            "lane 0 lowest",
            "lanes that hold an entry",
        ],
    );
    outputs(m, config, &below.io, &stats, (errors, idle), instances);
    m.begin_checks();
    environment(m, config);
    stable_stream(m, "m_axis_feat", &["tdata", "tkeep", "tlast", "tuser"]);
    builder.finish()
}

/// Submodules of the unit.
struct Modules {
    rit: Arc<Module>,
    table: Arc<Module>,
    lane: Arc<Module>,
    arbiter: Arc<Module>,
}

impl Modules {
    fn of(config: &Config) -> Result<Self, IrErrors> {
        Ok(Self {
            rit: rit_buffer(config)?,
            table: table(config)?,
            lane: lane(config)?,
            arbiter: bank_arbiter(config)?,
        })
    }
}

/// Inputs of the unit, and the buffers of its streams.
struct Below {
    io: Ports,
    settings: Settings,
    rit: Instance,
    table: Instance,
}

impl Below {
    fn declare(m: &mut ModuleBuilder, config: &Config, shape: &Shape, modules: &Modules) -> Self {
        let (bit, banks) = (Ty::bit(), shape.banks);
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
        let of_settings = [
            ("cfg_segments", settings.segments),
            ("cfg_channels", settings.channels),
        ];
        rit_in.extend([("cfg_vertices", vertices), of_settings[0]]);
        let rit = m.instance("rit", &modules.rit, &rit_in);
        let mut table_in = mft_in.to_vec();
        table_in.extend(of_settings);
        let table = m.instance("mft", &modules.table, &table_in);
        Self {
            io: Ports {
                vertices,
                segments: settings.segments,
                clear,
                ready,
            },
            settings,
            rit,
            table,
        }
    }
}

/// The vertex of M entries offered by the RIT buffer.
struct Offered {
    first: Signal,
    last: Signal,
    keep: Signal,
    row: Signal,
    slot: Signal,
    weight: Signal,
}

impl Offered {
    fn of(m: &mut ModuleBuilder, config: &Config, rit: Instance) -> Self {
        let first = m.out(rit, "p_first");
        let [last, keep, row, slot] =
            ["p_last", "p_keep", "p_row", "p_slot"].map(|name| m.out(rit, name));
        Self {
            first,
            last,
            keep,
            row,
            slot,
            weight: weights(m, config, rit),
        }
    }
}

/// The current step of the lanes, and whether a round of it is issued.
struct Issue {
    sequencer: Sequencer,
    /// Beats in flight, begun and not yet accepted by the sink, and whether one more may begin.
    in_flight: Signal,
    credit: Signal,
    /// The MVoxel's segment is loaded.
    loaded: Signal,
    begins_channel: Signal,
    fire: Signal,
}

impl Issue {
    fn build(m: &mut ModuleBuilder, config: &Config, shape: &Shape, below: &Below) -> Self {
        m.section("Steps: one a channel and vertex");
        let depth = config.feature_fifo_depth();
        let sequencer = Sequencer::declare(m, shape, below.settings);
        let step = sequencer.step;
        let in_flight = m.reg("in_flight", Ty::u(bits_for(depth)), 0);
        m.note(in_flight, "beats begun and not yet taken by the sink");
        let limit = m.param("BEATS_IN_FLIGHT", depth, in_flight.ty(), "FIFO depth");
        let credit = m.lt(in_flight, limit);
        let credit = m.name(credit, "credit");
        let loaded = m.out(below.table, "is_loaded");
        // A channel, once begun, is never held up: only its first round asks.
        let may_start = m.and(credit, loaded);
        let may_start = m.name(may_start, "may_start");
        let begins_channel = m.and(step.new, step.first);
        let begins_channel = m.name(begins_channel, "begins_channel");
        let goes_on = m.not(begins_channel);
        let may = m.or(goes_on, may_start);
        let fire = m.and(step.valid, may);
        let fire = m.name(fire, "fire");
        m.note(fire, "a round is issued");
        Self {
            sequencer,
            in_flight,
            credit,
            loaded,
            begins_channel,
            fire,
        }
    }
}

/// The lanes, with the valid signals of stages D and X.
struct Lanes {
    all: Vec<Instance>,
    d_completes: Signal,
    x_completes: Signal,
    /// Whether entries are single ids.
    single: Signal,
}

impl Lanes {
    fn build(
        m: &mut ModuleBuilder,
        config: &Config,
        modules: &Modules,
        below: &Below,
        (loader, p, issue): (&Loader, &Offered, &Issue),
    ) -> Self {
        m.section("Lanes");
        let (gu, slot_bits) = (&config.gu, config.rit.slot_bits);
        let single = is(m, below.io.vertices, 0);
        let single = m.name(single, "single_ids");
        let (rows, words) = (m.out(below.table, "rows"), m.out(below.table, "words"));
        let d_completes = m.reg("d_completes", Ty::bit(), 0);
        let x_completes = m.reg("x_completes", Ty::bit(), 0);
        // A single id has the weight 1.
        let one = m.lit(1u32 << gu.weight_bits, Ty::u(gu.weight_bits + 1));
        let all = (0..gu.lanes)
            .map(|i| {
                let (group, port) = ((i / gu.ports) as usize, i % gu.ports);
                let kept = m.bit(p.keep, port);
                let kept = m.and(kept, loader.writes[group]);
                let row = m.slice(p.row, 16 * port, 16);
                let slot = m.slice(p.slot, slot_bits * port, slot_bits);
                let mut inputs = vec![
                    ("write", loader.writes[group]),
                    ("write_half", loader.half),
                    ("write_vertex", loader.vertex),
                    ("write_kept", kept),
                    ("write_entry", loader.entries[group]),
                    ("row", row),
                    ("slot", slot),
                    ("fire", issue.fire),
                    ("rows", rows),
                    ("words", words),
                    ("d_completes", d_completes),
                    ("x_completes", x_completes),
                ];
                if gu.modes != Modes::Unstructured {
                    let weight = m.slice(p.weight, 16 * port, gu.weight_bits + 1);
                    let weight = m.mux(single, one, weight);
                    inputs.extend([("weight", weight), ("first", issue.sequencer.step.first)]);
                }
                m.instance(&format!("lane{i}"), &modules.lane, &inputs)
            })
            .collect();
        Self {
            all,
            d_completes,
            x_completes,
            single,
        }
    }

    /// An output of every lane.
    fn out(&self, m: &mut ModuleBuilder, port: &str) -> Vec<Signal> {
        self.all.iter().map(|lane| m.out(*lane, port)).collect()
    }
}

/// A round: every bank serves the lanes that request one of its rows.
struct Round {
    /// Lanes served.
    granted: Signal,
    /// No lane is left: the step is complete.
    done: Signal,
    /// Whether the step is a channel's last.
    completes: Signal,
}

impl Round {
    fn build(
        m: &mut ModuleBuilder,
        shape: &Shape,
        modules: &Modules,
        below: &Below,
        issue: &Issue,
        lanes: &Lanes,
    ) -> Self {
        let (wants, lines) = (lanes.out(m, "wants"), lanes.out(m, "line"));
        let pending = lanes.out(m, "is_pending");
        m.section("Arbiters, one a bank");
        let (fire, step) = (issue.fire, issue.sequencer.step);
        let lines = joined(m, &lines);
        let lines = m.name(lines, "lane_lines");
        let (mut busy, mut bank_lines, mut grants) = (vec![], vec![], vec![]);
        for b in 0..shape.banks {
            let of_bank: Vec<_> = wants.iter().map(|w| m.bit(*w, b)).collect();
            let of_bank = joined(m, &of_bank);
            let of_bank = m.name(of_bank, &format!("wants_bank{b}"));
            let inst = m.instance(
                &format!("arbiter{b}"),
                &modules.arbiter,
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
        m.connect(below.table, "read", busy);
        m.connect(below.table, "lines", bank_lines);
        m.connect(below.table, "channel", step.channel);
        let release = m.and(done, step.end);
        let release = m.name(release, "release_table");
        m.connect(below.table, "done", release);
        let completes = m.and(done, step.last);
        Self {
            granted,
            done,
            completes: m.name(completes, "completes"),
        }
    }
}

/// Result of a channel, through stages D, X and S.
fn beat(m: &mut ModuleBuilder, issue: &Issue, lanes: &Lanes, completes: Signal) -> Beat {
    m.section("Results into the FIFO");
    let (bit, step) = (Ty::bit(), issue.sequencer.step);
    m.set_next(lanes.d_completes, completes);
    m.set_next(lanes.x_completes, lanes.d_completes);
    let push = m.reg("s_push", bit, 0);
    m.set_next(push, lanes.x_completes);
    let mut end = step.end;
    let enables = [completes, lanes.d_completes, lanes.x_completes];
    let letters = Pipeline::crossbar();
    let letters = letters.stages().filter_map(CrossbarStage::letter);
    for (letter, enable) in letters.zip(enables) {
        let reg = m.reg(&format!("{}_end", letter.to_ascii_lowercase()), bit, 0);
        m.set_next_if(reg, enable, end);
        end = reg;
    }
    let results: Vec<_> = lanes
        .out(m, "result")
        .into_iter()
        .map(|result| {
            let result = m.as_signed(result);
            let wide = m.extend(result, 16);
            m.as_unsigned(wide)
        })
        .collect();
    let (kept, slots) = (lanes.out(m, "result_kept"), lanes.out(m, "result_slot"));
    Beat {
        push,
        end,
        keep: joined(m, &kept),
        slot: joined(m, &slots),
        data: joined(m, &results),
    }
}

/// Signals observed by the counters.
fn stats(m: &mut ModuleBuilder, issue: &Issue, lanes: &Lanes, done: Signal) -> Stats {
    let (fire, step) = (issue.fire, issue.sequencer.step);
    let kept = lanes.out(m, "kept");
    let kept = joined(m, &kept);
    let kept = m.name(kept, "lanes_kept");
    let later = m.not(step.new);
    Stats {
        fire,
        busy: m.and(fire, step.new),
        bank: Some(m.and(fire, later)),
        group_done: m.and(done, step.last_of_entries),
        keep: kept,
        credit: issue.credit,
        loaded: issue.loaded,
    }
}

/// Signals observed by the flags.
fn watched(
    m: &mut ModuleBuilder,
    shape: &Shape,
    below: &Below,
    (loader, p, lanes): (&Loader, &Offered, &Lanes),
    idle: Signal,
) -> Watched {
    let outside = lanes.out(m, "outside");
    let outside = joined(m, &outside);
    let none = is(m, below.settings.channels, 0);
    let most = m.param("CHANNELS_MOST", shape.banks, Ty::u(7), "");
    let too_many = m.gt(below.settings.channels, most);
    Watched {
        valid: loader.take,
        first: p.first,
        last: p.last,
        keep: p.keep,
        weight: p.weight,
        name: "p",
        single: lanes.single,
        row_not_loaded: m.any(outside),
        bad_settings: vec![none, too_many],
        setting_moved: {
            let Settings { segments, channels } = below.settings;
            setting_moved(m, &[below.io.vertices, segments, channels], idle)
        },
    }
}

/// Concatenates, first lowest.
fn joined(m: &mut ModuleBuilder, parts: &[Signal]) -> Signal {
    let high_first: Vec<_> = parts.iter().rev().copied().collect();
    m.cat(&high_first)
}
