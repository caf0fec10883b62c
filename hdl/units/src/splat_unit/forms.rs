//! A form at a place, and what it counts with.

use potamoi_formats::record::MEAN;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::formats::{EXACT, MAGNITUDE};

/// What a form rounded half to even counts with: its magnitude, and whether it is too large to count. One
/// carry does both: the magnitude of a negative form is the complement of its floor, and one more where
/// that floor is not rounded up. `name` is that of the magnitude before the test.
pub(super) fn magnitude(m: &mut ModuleBuilder, exact: Signal, name: &str) -> (Signal, Signal) {
    let dropped = EXACT - 16;
    let floor = m.slice(exact, dropped, exact.width() - dropped);
    let [odd, guard] = [dropped, dropped - 1].map(|place| m.bit(exact, place));
    let below = m.slice(exact, 0, dropped - 1);
    let below = m.any(below);
    let to_even = m.or(below, odd);
    let up = m.and(guard, to_even);
    let negative = m.bit(exact, exact.width() - 1);
    let flips = m.repeat(negative, floor.width());
    let flipped = m.xor(floor, flips);
    let carry = m.xor(up, negative);
    let carry = m.extend(carry, floor.width());
    let absolute = m.add(flipped, carry);
    let absolute = m.name(absolute, name);
    let high = m.slice(absolute, MAGNITUDE, absolute.width() - MAGNITUDE);
    let beyond = m.any(high);
    (m.slice(absolute, 0, MAGNITUDE), beyond)
}

/// A form where it has grown since its start value. `name` is that of the growth with the start value's
/// fraction bits.
pub(super) fn form_at(
    m: &mut ModuleBuilder,
    [start, grown]: [Signal; 2],
    width: u32,
    name: &str,
) -> Signal {
    let fraction = m.lit(0, Ty::u(MEAN.frac_bits()));
    let grown = m.as_unsigned(grown);
    let grown = m.cat(&[grown, fraction]);
    let grown = m.name(grown, name);
    let grown = m.as_signed(grown);
    let (start, grown) = (m.extend(start, width), m.extend(grown, width));
    m.add(start, grown)
}

#[cfg(test)]
mod rounding {
    #![allow(clippy::unwrap_used)]
    use potamoi_formats::fixed::{Rounding, round_shift};
    use potamoi_netlist::Interpreter;

    use super::super::formats::AT_ROW;
    use super::*;

    /// Forms at ties, next to them and at their largest, of both signs: the magnitude is that of the form
    /// rounded half to even, and what does not fit is beyond.
    #[test]
    fn magnitudes_are_those_of_forms_rounded_half_to_even() {
        let mut m = ModuleBuilder::new("form");
        let exact = m.input("exact", Ty::s(AT_ROW), "");
        let (found, beyond) = magnitude(&mut m, exact, "absolute");
        m.output("magnitude", found, "");
        m.output("beyond", beyond, "");
        let module = m.finish().unwrap();
        let mut run = Interpreter::new(&module, 1);
        let [exact, found, beyond] =
            ["exact", "magnitude", "beyond"].map(|name| run.port(name).unwrap());
        let dropped = EXACT - 16;
        let (tie, most) = (1i64 << (dropped - 1), (1i64 << (AT_ROW - 1)) - 1);
        let wholes = [0, 1, 2, 5, (1 << MAGNITUDE) - 1, 1 << MAGNITUDE, 1 << 23];
        let near = [-1, 0, 1].map(|off| tie + off);
        let forms = wholes
            .iter()
            .flat_map(|whole| near.map(|part| (*whole << dropped) + part))
            .chain(wholes.map(|whole| whole << dropped))
            .chain([most, most - tie])
            .filter(|form| *form <= most);
        for form in forms.flat_map(|form| [form, -form]).chain([-most - 1]) {
            run.set_u64(exact, form as u64 & ((1 << AT_ROW) - 1))
                .unwrap();
            run.eval().unwrap();
            let rounded = round_shift(form.into(), dropped, Rounding::HalfEven).unsigned_abs();
            let fits = rounded < 1 << MAGNITUDE;
            assert_eq!(run.get_u64(beyond).unwrap(), u64::from(!fits), "{form}");
            if fits {
                assert_eq!(u128::from(run.get_u64(found).unwrap()), rounded, "{form}");
            }
        }
    }
}
