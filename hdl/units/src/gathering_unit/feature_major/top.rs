//! Top module of the feature-major unit: lanes, arbiters, banks.

use std::sync::Arc;

use potamoi_formats::config::{Config, Modes};
use potamoi_formats::timing::{CrossbarStage, Pipeline};
use potamoi_formats::units::GATHERING_UNIT;
use potamoi_netlist::{Feed, Instance, InstanceArray, IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::arbiter::bank_arbiter;
use super::checks::unit_checks;
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
    for (port, signal) in [
        ("read", read.read),
        ("read_half", read.half),
        ("read_vertex", read.vertex),
        ("completes", round.completes),
    ] {
        m.feed(lanes.all, port, Feed::Shared(signal));
    }
    m.feed(lanes.all, "granted", Feed::Each(round.granted));
    let beat = beat(m, config, &issue, &lanes, round.completes);
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
    unit_checks(m, config, below.rit, stream.fifo);
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

/// Loops over the lanes: groups of M, and the port of the ray index table within a group.
const GROUP: usize = 0;
const PORT: usize = 1;

/// The lanes, with the valid signals of stages D and X.
struct Lanes {
    all: InstanceArray,
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
        let gu = &config.gu;
        let single = is(m, below.io.vertices, 0);
        let single = m.name(single, "single_ids");
        let (rows, words) = (m.out(below.table, "rows"), m.out(below.table, "words"));
        let d_completes = m.reg("d_completes", Ty::bit(), 0);
        let x_completes = m.reg("x_completes", Ty::bit(), 0);
        let mut inputs = vec![
            ("write", Feed::Along(&[GROUP], loader.writes)),
            ("write_half", Feed::Shared(loader.half)),
            ("write_vertex", Feed::Shared(loader.vertex)),
            ("write_kept", Feed::Along(&[PORT], p.keep)),
            ("write_entry", Feed::Along(&[GROUP], loader.entries)),
            ("row", Feed::Along(&[PORT], p.row)),
            ("slot", Feed::Along(&[PORT], p.slot)),
            ("fire", Feed::Shared(issue.fire)),
            ("rows", Feed::Shared(rows)),
            ("words", Feed::Shared(words)),
            ("d_completes", Feed::Shared(d_completes)),
            ("x_completes", Feed::Shared(x_completes)),
        ];
        if gu.modes != Modes::Unstructured {
            // A single id has the weight 1.
            let one = m.lit(1u32 << gu.weight_bits, Ty::u(gu.weight_bits + 1));
            let ones = m.repeat(one, gu.ports);
            let given: Vec<_> = (0..gu.ports)
                .rev()
                .map(|port| m.slice(p.weight, 16 * port, gu.weight_bits + 1))
                .collect();
            let given = m.cat(&given);
            let weight = m.mux(single, ones, given);
            inputs.extend([
                ("weight", Feed::Along(&[PORT], weight)),
                ("first", Feed::Shared(issue.sequencer.step.first)),
            ]);
        }
        let loops = [("group", gu.lanes / gu.ports), ("port", gu.ports)];
        let all = m.array("lane", &modules.lane, &loops, &inputs);
        Self {
            all,
            d_completes,
            x_completes,
            single,
        }
    }

    /// An output of all lanes, lane 0 lowest.
    fn out(&self, m: &mut ModuleBuilder, port: &str) -> Signal {
        m.all_out(self.all, port)
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
        let of_banks = m.transpose(
            "bank_wants",
            wants,
            ("from_lane", shape.lanes),
            ("to_bank", shape.banks),
        );
        let arbiters = m.array(
            "arbiter",
            &modules.arbiter,
            &[("bank", shape.banks)],
            &[
                ("wants", Feed::Each(of_banks)),
                ("lines", Feed::Shared(lines)),
            ],
        );
        let asked = m.all_out(arbiters, "busy");
        let fires = m.repeat(fire, shape.banks);
        let busy = m.and(fires, asked);
        let bank_lines = m.all_out(arbiters, "line");
        let grants = m.all_out(arbiters, "grants");
        let mut granted = m.slice(grants, 0, shape.lanes);
        for bank in 1..shape.banks {
            let more = m.slice(grants, bank * shape.lanes, shape.lanes);
            granted = m.or(granted, more);
        }
        let granted = m.name(granted, "granted");
        let waits = m.not(granted);
        let left = m.and(pending, waits);
        let left = m.any(left);
        let left = m.name(left, "lanes_left");
        m.note(left, "another round is needed");
        let no_more = m.not(left);
        let done = m.and(fire, no_more);
        let done = m.name(done, "step_done");
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
fn beat(
    m: &mut ModuleBuilder,
    config: &Config,
    issue: &Issue,
    lanes: &Lanes,
    completes: Signal,
) -> Beat {
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
        let reg = m.data_reg(&format!("{}_end", letter.to_ascii_lowercase()), bit);
        m.set_next_if(reg, enable, end);
        end = reg;
    }
    let (results, bits) = (lanes.out(m, "result"), config.gu.feature_bits);
    let results: Vec<_> = (0..config.gu.lanes)
        .rev()
        .map(|lane| {
            let result = m.slice(results, bits * lane, bits);
            let result = m.as_signed(result);
            let wide = m.extend(result, 16);
            m.as_unsigned(wide)
        })
        .collect();
    Beat {
        push,
        end,
        keep: lanes.out(m, "result_kept"),
        slot: lanes.out(m, "result_slot"),
        data: m.cat(&results),
    }
}

/// Signals observed by the counters.
fn stats(m: &mut ModuleBuilder, issue: &Issue, lanes: &Lanes, done: Signal) -> Stats {
    let (fire, step) = (issue.fire, issue.sequencer.step);
    let kept = lanes.out(m, "kept");
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
