//! Radix 4: subtracts the largest of three multiples that fits.

use num_bigint::BigInt;
use potamoi_formats::config::{Engine, ExpConfig};
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::constants::ln_two_multiple;
use super::form::{Recurrence, Shift, State, StepInputs, Widths, renamed};

pub(super) struct Radix4;

impl Recurrence for Radix4 {
    fn registers(&self, _: &ExpConfig, engine: &Engine) -> [Ty; 2] {
        let remain = Ty::u(engine.constant_bits + 4);
        [remain, Ty::u(engine.accumulator_bits + 2)]
    }

    fn digits_width(&self, engine: &Engine) -> u32 {
        2 * engine.digits
    }

    fn radix_bits(&self) -> u32 {
        2
    }

    /// Three times a rounded constant would differ from the rounded triple.
    fn bias(&self, z: u32, bits: u32) -> BigInt {
        let digits = (0..16).map(|j| z & (3 << (2 * j)));
        digits
            .filter(|&digit| digit > 0)
            .map(|digit| ln_two_multiple(digit, bits))
            .sum()
    }

    /// Compares with three constants, subtracts the largest that fits, and adds the corresponding
    /// shifted multiple of the accumulator.
    fn step(
        &self,
        m: &mut ModuleBuilder,
        widths: &Widths,
        s: State,
        place: &StepInputs,
        index: u32,
        _: Option<Signal>,
    ) -> State {
        let mut part = m.lit(0, widths.remain);
        let [one, two, three] = [(0, "one"), (1, "two"), (2, "three")].map(|(d, name)| {
            let constant = place.constants[d];
            let take = m.ge(s.remain, constant);
            let take = m.name(take, &format!("take_{name}{index}"));
            part = m.mux(take, constant, part);
            take
        });
        let part = m.name(part, &format!("part{index}"));
        let remain = m.sub(s.remain, part);
        let remain = m.name(remain, &format!("remain{index}"));
        let grown = grown(m, widths, s.accum, place.shift, [one, two, three], index);
        let accum = m.mux(place.digit, s.accum, grown);
        let accum = renamed(m, accum, s.accum, &format!("accum{index}"));
        let rest = m.slice(s.digits, 0, widths.digits.width - 2);
        let not_two = m.not(two);
        let odd = m.and(one, not_two);
        let odd = m.or(odd, three);
        let pushed = m.cat(&[rest, two, odd]);
        let digits = m.mux(place.digit, pushed, s.digits);
        let digits = renamed(m, digits, s.digits, &format!("digits{index}"));
        State {
            remain,
            accum,
            digits,
        }
    }
}

/// `R_accum (1 + d 2^-i)`, rounded with the dropped bit.
fn grown(
    m: &mut ModuleBuilder,
    widths: &Widths,
    accum: Signal,
    shift: Shift,
    [one, two, three]: [Signal; 3],
    index: u32,
) -> Signal {
    let width = widths.accum.width + 2;
    let once = m.extend(accum, width);
    let twice = m.shl_const(once, 1);
    let thrice = m.add(once, twice);
    let none = m.lit(0, once.ty());
    let multiple = m.mux(one, once, none);
    let multiple = m.mux(two, twice, multiple);
    let multiple = m.mux(three, thrice, multiple);
    let multiple = m.name(multiple, &format!("accum_multiple{index}"));
    let more = widths.shifted(m, multiple, shift, index, true);
    more.into_iter().fold(accum, |sum, one| m.add(sum, one))
}
