//! Rows shared by two records.

use potamoi_formats::config::Config;
use potamoi_netlist::{ModuleBuilder, Signal};

/// Rows with two records each.
pub(super) struct SharedRows {
    /// Row addresses of the ids, without the bit that selects a record.
    pub(super) rows: Signal,
    /// Whether each port requests the upper record.
    pub(super) upper: Signal,
}

impl SharedRows {
    pub(super) fn of(m: &mut ModuleBuilder, config: &Config, two: Signal, ids: Signal) -> Self {
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

/// Selects the requested record of a row into the lower half; the upper half is 0.
pub(super) fn one_record(m: &mut ModuleBuilder, row: Signal, two: Signal, upper: Signal) -> Signal {
    let half = row.width() / 2;
    let (low, high) = (m.slice(row, 0, half), m.slice(row, half, half));
    let moves = m.and(two, upper);
    let lower = m.mux(moves, high, low);
    let whole = m.not(two);
    let mask = m.repeat(whole, half);
    let rest = m.and(high, mask);
    m.cat(&[rest, lower])
}
