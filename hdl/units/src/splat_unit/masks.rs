//! Masks of the 16 pixels of a row, or rows of a tile.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::near::SIDE;

/// Places 0 up to one, as a mask.
pub(super) fn up_to(m: &mut ModuleBuilder, last: Signal) -> Signal {
    let all = m.lit(u16::MAX, Ty::u(SIDE));
    let above = m.not(last);
    m.shr(all, above)
}

/// The lowest set bit of a mask of 16: its place, and the mask without it.
pub(super) fn lowest(m: &mut ModuleBuilder, mask: Signal) -> (Signal, Signal) {
    let mut place = m.lit(15, Ty::u(4));
    for bit in (0..15).rev() {
        let set = m.bit(mask, bit);
        let own = m.lit(bit, Ty::u(4));
        place = m.mux(set, own, place);
    }
    let one = m.lit(1, mask.ty());
    let less = m.sub(mask, one);
    let rest = m.and(mask, less);
    (place, rest)
}
