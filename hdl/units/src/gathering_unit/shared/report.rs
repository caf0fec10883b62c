//! Counters and error flags of the unit.

use potamoi_formats::config::{Config, EntryKind, Modes, Sums, WeightTrust};
use potamoi_formats::rit::Vertices;
use potamoi_netlist::{Instance, ModuleBuilder, Signal, Ty};

use super::ports::Ports;
use crate::circuits::{counter, is, popcount, sticky, tree_sum};

/// Signals observed by the counters.
pub(crate) struct Stats {
    /// A vertex is issued.
    pub(crate) fire: Signal,
    /// The issue counts as busy.
    pub(crate) busy: Signal,
    /// The issue counts as a bank stall, where banks conflict.
    pub(crate) bank: Option<Signal>,
    pub(crate) group_done: Signal,
    pub(crate) keep: Signal,
    pub(crate) credit: Signal,
    pub(crate) loaded: Signal,
}

/// Entries in flight, and further signals observed by the flags.
pub(crate) struct Watched {
    /// A vertex of a structured entry is present.
    pub(crate) valid: Signal,
    pub(crate) first: Signal,
    pub(crate) last: Signal,
    /// Ports with an entry.
    pub(crate) keep: Signal,
    pub(crate) weight: Signal,
    /// Name of the stage.
    pub(crate) name: &'static str,
    /// Whether entries are single ids.
    pub(crate) single: Signal,
    pub(crate) row_not_loaded: Signal,
    /// Violated settings of this organisation, beyond the common ones.
    pub(crate) bad_settings: Vec<Signal>,
    /// A setting changes while the unit is not idle.
    pub(crate) setting_moved: Signal,
}

/// Stalls are counted as they occur, and shown as of the last issue, so that idle cycles at the end
/// do not count.
fn statistics(m: &mut ModuleBuilder, config: &Config, io: &Ports, stats: &Stats) {
    m.section("Counters; stalls since the last issue are added with the next one");
    let (bits, clear) = (config.gu.counter_bits, io.clear);
    let begun = sticky(m, "begun", clear, stats.fire);
    m.note(begun, "an issue has been, so that stalls count");
    let idle = m.not(stats.fire);
    let stalled = m.and(begun, idle);
    let stalled = m.name(stalled, "stalled");
    let no_credit = m.not(stats.credit);
    let not_loaded = m.not(stats.loaded);
    let fifo = m.and(stalled, no_credit);
    let mft = m.all_of(&[stalled, stats.credit, not_loaded]);
    let rit = m.all_of(&[stalled, stats.credit, stats.loaded]);
    let busy = counter(m, "stat_busy", bits, clear, stats.busy, None);
    let issued = match (stats.bank, config.is_parity()) {
        (Some(_), _) if config.table_parts() == 1 => "first rounds of steps that were issued",
        (Some(_), _) => "cycles in which a vertex was issued",
        (None, true) => "cycles in which whole cells were issued",
        (None, false) => "cycles in which a vertex was issued",
    };
    m.output("stat_busy", busy, issued);
    if let Some(bank) = stats.bank {
        let doc = match config.table_parts() {
            1 => "stalls: lanes wait for a bank",
            _ => "stalls: ports wait for a turn",
        };
        let count = counter(m, "stat_stall_bank", bits, clear, bank, None);
        m.output("stat_stall_bank", count, doc);
    }
    let shows = m.or(clear, stats.fire);
    for (name, cause, doc) in [
        ("fifo", fifo, "stalls up to the last issue: no room"),
        ("mft", mft, "the same: MVoxel not loaded"),
        ("rit", rit, "the same: no entry"),
    ] {
        let running = counter(m, &format!("running_{name}"), bits, clear, cause, None);
        let port = format!("stat_stall_{name}");
        let shown = m.reg(&port, Ty::u(bits), 0);
        let zero = m.lit(0, Ty::u(bits));
        let next = m.mux(clear, zero, running);
        m.set_next_if(shown, shows, next);
        m.output(&port, shown, doc);
    }
    let kept: Vec<_> = (0..stats.keep.width())
        .map(|p| m.bit(stats.keep, p))
        .collect();
    let entries = popcount(m, &kept);
    let entries = m.name(entries, "entries_of_group");
    let entries = m.extend(entries, bits);
    let count = counter(
        m,
        "stat_entries",
        bits,
        clear,
        stats.group_done,
        Some(entries),
    );
    m.output("stat_entries", count, "entries issued");
}

/// Ready outputs of both streams, counters and flags, the same for every organisation.
pub(crate) fn outputs(
    m: &mut ModuleBuilder,
    config: &Config,
    io: &Ports,
    stats: &Stats,
    (errors, idle): (Signal, Signal),
    [rit, table]: [Instance; 2],
) {
    for (instance, name) in [(rit, "s_axis_rit_tready"), (table, "s_axis_mft_tready")] {
        let ready = m.out(instance, name);
        m.output_low_in_reset(name, ready, "");
    }
    statistics(m, config, io, stats);
    m.output(
        "idle",
        idle,
        "nothing is received or in flight: cfg_* may change",
    );
    // With 15 fraction bits no code is above that of 1 by a further bit.
    let above = match config.gu.weight_bits {
        15.. => "1 never here",
        _ => "1 weight above 1",
    };
    let doc = format!(
        "sticky: 8 setting moved, 7 bad setting, 6 row dropped, 5 RIT too large, 4 gap, 3 ragged, \
         2 sum of weights, {above}, 0 row not loaded"
    );
    m.output("stat_errors", errors, &doc);
}

/// Weight errors: above 1, and a sum other than 1.
struct WrongWeights {
    high: Vec<Signal>,
    sums: Vec<Signal>,
}

impl WrongWeights {
    fn of(m: &mut ModuleBuilder, config: &Config, s1: &Watched) -> Self {
        let gu = &config.gu;
        let mut wrong = Self {
            high: vec![],
            sums: vec![],
        };
        let mut one = None;
        let structured = m.not(s1.single);
        let structured = m.name(structured, "structured");
        let groups = config.vertices_a_row();
        // Weights that the unit makes itself are right.
        let given = gu.modes != Modes::Unstructured && config.rit.entry == EntryKind::Paper;
        for p in 0..gu.ports {
            let kept = m.bit(s1.keep, p);
            if !given {
                continue;
            }
            let codes: Vec<_> = (0..groups)
                .map(|g| m.slice(s1.weight, 16 * (p * groups + g), 16))
                .collect();
            if gu.weight_bits < 15 {
                let above: Vec<_> = codes
                    .iter()
                    .map(|code| m.slice(*code, gu.weight_bits + 1, 15 - gu.weight_bits))
                    .collect();
                let above = m.cat(&above);
                let above = m.any(above);
                wrong.high.push(m.all_of(&[kept, structured, above]));
            }
            if gu.weights == WeightTrust::Trusted {
                let sum = weight_sum(m, config, s1, p, &codes);
                let doc = "what an entry's weights sum to";
                let one = *one.get_or_insert_with(|| {
                    m.param("WEIGHT_ONE", 1u32 << gu.weight_bits, sum.ty(), doc)
                });
                let off = match gu.sums {
                    Sums::Rounded => m.ne(sum, one),
                    // The entry may be a part of a cell.
                    Sums::Exact => m.gt(sum, one),
                };
                wrong.sums.push(m.all_of(&[kept, structured, s1.last, off]));
            }
        }
        wrong
    }
}

/// Sum of an entry's weights up to this vertex.
fn weight_sum(
    m: &mut ModuleBuilder,
    config: &Config,
    s1: &Watched,
    port: u32,
    codes: &[Signal],
) -> Signal {
    let weight_bits = config.gu.weight_bits;
    // Eight codes of W + 1 bits.
    let ty = Ty::u(weight_bits + 4);
    let weights: Vec<_> = codes
        .iter()
        .map(|code| {
            let weight = m.slice(*code, 0, weight_bits + 1);
            m.extend(weight, ty.width)
        })
        .collect();
    let weight = tree_sum(m, &weights);
    let weight = m.name(weight, &format!("{}_weight_of_port{port}", s1.name));
    if codes.len() > 1 {
        return weight;
    }
    let total = m.data_reg(&format!("weight_total{port}"), ty);
    let more = m.add(total, weight);
    let sum = m.mux(s1.first, weight, more);
    let sum = m.name(sum, &format!("weight_sum{port}"));
    m.set_next_if(total, s1.valid, sum);
    sum
}

/// Whether the unit does not support the settings.
fn bad_settings(m: &mut ModuleBuilder, config: &Config, io: &Ports, s1: &Watched) -> Signal {
    let supported: Vec<_> = config
        .supported_vertices()
        .into_iter()
        .map(|v| is(m, io.vertices, v.log2()))
        .collect();
    let mut wrong = vec![];
    if supported.len() < Vertices::ALL.len() {
        let built = m.any_of(&supported);
        wrong.push(m.not(built));
    }
    let most = m.param("SEGMENTS_MOST", config.gu.segments, Ty::u(7), "");
    let too_many = m.gt(io.segments, most);
    let none = is(m, io.segments, 0);
    wrong.extend([too_many, none]);
    wrong.extend(&s1.bad_settings);
    let settings = m.any_of(&wrong);
    m.and(s1.valid, settings)
}

/// The sticky flags.
pub(crate) fn errors(
    m: &mut ModuleBuilder,
    config: &Config,
    io: &Ports,
    s1: &Watched,
    below: [Instance; 2],
) -> Signal {
    m.section("Errors");
    let weights = WrongWeights::of(m, config, s1);
    // What cannot happen in this configuration has no register.
    let issued = |m: &mut ModuleBuilder, bits: &[Signal]| {
        let any = m.any_of(bits);
        (!bits.is_empty()).then(|| m.and(s1.valid, any))
    };
    let (high, sums) = (issued(m, &weights.high), issued(m, &weights.sums));
    let rit = m.out(below[0], "errors");
    let (ragged, gap, large) = (m.bit(rit, 0), m.bit(rit, 1), m.bit(rit, 2));
    let overflow = m.out(below[1], "overflow");
    let settings = bad_settings(m, config, io, s1);
    let flags: Vec<_> = [
        ("row_not_loaded", Some(s1.row_not_loaded)),
        ("weight_too_large", high),
        ("weights_off_one", sums),
        ("ragged_entries", Some(ragged)),
        ("gap_in_beat", Some(gap)),
        ("rit_too_large", Some(large)),
        ("mft_row_dropped", Some(overflow)),
        ("bad_setting", Some(settings)),
        ("setting_moved", Some(s1.setting_moved)),
    ]
    .into_iter()
    .map(|(name, set)| match set {
        Some(set) => sticky(m, name, io.clear, set),
        None => m.lit(0, Ty::bit()),
    })
    .rev()
    .collect();
    m.cat(&flags)
}
