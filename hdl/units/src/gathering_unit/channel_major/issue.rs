//! Issue: selects the vertex of M entries that leaves the RIT buffer, and reads its rows.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::{Instance, IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::inputs::Inputs;
use super::mft::mft;
use super::shared_rows::SharedRows;
use crate::circuits::bits_for;
use crate::gathering_unit::rit_buffer::{rit_buffer, weights};

/// Modules connected by the issue.
pub(super) struct Below {
    rit: Arc<Module>,
    mft: Arc<Module>,
}

impl Below {
    pub(super) fn of(config: &Config) -> Result<Self, IrErrors> {
        Ok(Self {
            rit: rit_buffer(config)?,
            mft: mft(config)?,
        })
    }
}

/// The vertex of M entries offered by the RIT buffer.
pub(super) struct Offered {
    pub(super) valid: Signal,
    pub(super) first: Signal,
    pub(super) last: Signal,
    pub(super) end: Signal,
    pub(super) keep: Signal,
    pub(super) row: Signal,
    pub(super) slot: Signal,
    pub(super) weight: Signal,
}

impl Offered {
    fn of(m: &mut ModuleBuilder, config: &Config, rit: Instance) -> Self {
        let mut of_rit = |name: &str| m.out(rit, name);
        let [valid, end, keep] = ["p_valid", "p_end", "p_keep"].map(&mut of_rit);
        let [row, slot] = ["p_row", "p_slot"].map(&mut of_rit);
        let weight = weights(m, config, rit);
        // A cell is the first and the last of its group.
        let [first, last] = match config.is_parity() {
            true => [m.lit(1, Ty::bit()); 2],
            false => ["p_first", "p_last"].map(|name| m.out(rit, name)),
        };
        Self {
            valid,
            first,
            last,
            end,
            keep,
            row,
            slot,
            weight,
        }
    }
}

/// The issued vertex.
pub(super) struct Issue {
    pub(super) rit: Instance,
    pub(super) table: Instance,
    pub(super) offered: Offered,
    /// Groups in flight, issued and not yet accepted by the sink, and whether one more may be
    /// issued.
    pub(super) in_flight: Signal,
    pub(super) credit: Signal,
    /// The MVoxel is loaded.
    pub(super) loaded: Signal,
    /// The vertex requests its rows; without turns the request is always granted.
    pub(super) asks: Signal,
    /// All its rows are read, and it leaves the RIT buffer.
    pub(super) fire: Signal,
    pub(super) group_start: Signal,
    /// Ports whose rows are read, where ports take turns.
    pub(super) granted: Option<Signal>,
    /// Shared rows, where two records share a row.
    pub(super) shared: Option<SharedRows>,
}

impl Issue {
    pub(super) fn build(
        m: &mut ModuleBuilder,
        config: &Config,
        below: &Below,
        inputs: &Inputs,
    ) -> Self {
        m.section("Issue: the vertex that reads the MFT");
        let depth = config.feature_fifo_depth();
        let flight_ty = Ty::u(bits_for(depth));
        let in_flight = m.reg("in_flight", flight_ty, 0);
        m.note(in_flight, "groups issued and not yet taken by the sink");
        let limit = m.param("GROUPS_IN_FLIGHT", depth, flight_ty, "FIFO depth");
        let credit = m.lt(in_flight, limit);
        let credit = m.name(credit, "credit");
        let mut rit_inputs = inputs.rit.clone();
        rit_inputs.extend([
            ("cfg_vertices", inputs.io.vertices),
            ("cfg_segments", inputs.io.segments),
        ]);
        let rit = m.instance("rit", &below.rit, &rit_inputs);
        let table = m.instance("mft", &below.mft, &inputs.mft);
        let offered = Offered::of(m, config, rit);
        let loaded = m.out(table, "is_loaded");
        let wants = may_go(m, config, &offered, credit, loaded);
        let turns = config.table_parts() > 1;
        let (wants, fire, granted) = if turns {
            let fire = m.out(table, "is_read");
            (m.name(wants, "asks"), fire, Some(m.out(table, "granted")))
        } else {
            (wants, wants, None)
        };
        let fire = m.name(fire, "fire");
        m.note(fire, "a vertex is issued");
        let asks = if turns { wants } else { fire };
        let release = m.all_of(&[fire, offered.last, offered.end]);
        let release = m.name(release, "release_table");
        m.connect(rit, "p_take", fire);
        m.connect(table, "read", asks);
        let two = inputs.two_records;
        let shared = two.map(|two| SharedRows::of(m, config, two, offered.row));
        let rows = shared.as_ref().map_or(offered.row, |shared| shared.rows);
        m.connect(table, "read_row", rows);
        m.connect(table, "read_keep", offered.keep);
        m.connect(table, "done", release);
        let group_start = m.and(fire, offered.first);
        let group_start = m.name(group_start, "group_start");
        Self {
            rit,
            table,
            offered,
            in_flight,
            credit,
            loaded,
            asks,
            fire,
            group_start,
            granted,
            shared,
        }
    }
}

/// Whether the offered vertex may be issued.
fn may_go(
    m: &mut ModuleBuilder,
    config: &Config,
    offered: &Offered,
    credit: Signal,
    loaded: Signal,
) -> Signal {
    // A group, once begun, needs no more room: only its first vertex asks.
    let may_start = m.and(credit, loaded);
    let may_start = m.name(may_start, "may_start");
    let may = match config.is_parity() {
        true => may_start,
        false => {
            let goes_on = m.not(offered.first);
            m.or(goes_on, may_start)
        }
    };
    m.and(offered.valid, may)
}
