//! Position of a vertex: its block of 2 x 2 x 2, and its parities there.

use potamoi_netlist::{ModuleBuilder, Signal};

/// Row and parities of a vertex, from its position along z, y and x of `bits` each.
pub(crate) fn block(m: &mut ModuleBuilder, place: Signal, bits: u32) -> (Signal, Signal) {
    let (mut halves, mut parity) = (vec![], vec![]);
    for axis in 0..3 {
        parity.insert(0, m.bit(place, axis * bits));
        if bits > 1 {
            halves.insert(0, m.slice(place, axis * bits + 1, bits - 1));
        }
    }
    if 3 * bits < 16 {
        halves.insert(0, m.slice(place, 3 * bits, 16 - 3 * bits));
    }
    (m.cat(&halves), m.cat(&parity))
}
