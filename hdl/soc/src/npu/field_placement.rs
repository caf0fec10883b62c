//! Fields within a register.

use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::registers::{Register, WORD_BITS};

/// The fields at their places, with 0 between them.
pub(super) fn placed(m: &mut ModuleBuilder, own: &Register, values: &[Signal]) -> Signal {
    let mut parts = vec![];
    let mut next = 0;
    for (field, value) in own.fields.iter().zip(values) {
        if field.low > next {
            parts.push(m.lit(0, Ty::u(field.low - next)));
        }
        parts.push(*value);
        next = field.low + field.width;
    }
    if next < WORD_BITS {
        parts.push(m.lit(0, Ty::u(WORD_BITS - next)));
    }
    parts.reverse();
    m.cat(&parts)
}
