//! A multiply-accumulate unit of the weight-stationary array around the units (paper, Sec.
//! "Experimental Setup": 16-bit inputs, 32-bit sums).
//!
//! The array itself is modelled, not emitted. This unit of it is built to be synthesised, so that
//! its period, area and energy are known.

use std::sync::Arc;

use potamoi_formats::units::ARRAY_MAC;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Ty};

/// Bits of an input and of a weight; sums have twice as many.
const BITS: u32 = 16;

/// Builds `array_mac`: it holds a weight, passes its input on a cycle later, and adds the product of
/// both to the sum from above. Sums wrap around modulo 2^32.
///
/// # Errors
/// The netlist's own checks.
pub fn array_mac() -> Result<Arc<Module>, IrErrors> {
    let mut m = ModuleBuilder::new(ARRAY_MAC);
    m.doc("Multiply-accumulate unit of a weight-stationary array.");
    let load = m.input("load", Ty::bit(), "takes the weight at the clock edge");
    let weight_in = m.input("weight_in", Ty::s(BITS), "weight from above");
    let input = m.input("data_in", Ty::s(BITS), "input from the left");
    let sum_in = m.input("sum_in", Ty::s(2 * BITS), "sum from above");
    let weight = m.reg("weight", Ty::s(BITS), 0);
    m.set_next_if(weight, load, weight_in);
    let passed = m.reg("passed", Ty::s(BITS), 0);
    m.set_next(passed, input);
    let product = m.mul(input, weight);
    let product = m.name(product, "product");
    let total = m.add(sum_in, product);
    let sum = m.reg("sum", Ty::s(2 * BITS), 0);
    m.set_next(sum, total);
    m.output("weight_out", weight, "weight to the row below");
    m.output("data_out", passed, "input to the right, a cycle later");
    m.output("sum_out", sum, "sum to the row below, a cycle later");
    m.finish()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_netlist::Interpreter;
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// A cycle after its operands: the input as it was, and the sum plus the product modulo 2^32,
    /// by the weight of the last load.
    #[test]
    fn it_multiplies_and_adds_a_cycle_later() {
        let mut unit = Interpreter::new(&array_mac().unwrap(), 1);
        let mut random = Pcg64Mcg::seed_from_u64(5);
        let set = |unit: &mut Interpreter, name: &str, value: u64| {
            let port = unit.port(name).unwrap();
            unit.set_u64(port, value).unwrap();
        };
        set(&mut unit, "rst_n", 0);
        unit.clock().unwrap();
        set(&mut unit, "rst_n", 1);
        let mut weight = 0i16;
        for step in 0..2000 {
            let any = |random: &mut Pcg64Mcg| match step % 5 {
                0 => i16::MIN,
                1 => i16::MAX,
                _ => random.random(),
            };
            let (next, data, above): (i16, i16, i32) =
                (any(&mut random), any(&mut random), random.random());
            let loads = random.random_bool(0.3);
            set(&mut unit, "load", loads.into());
            set(&mut unit, "weight_in", u64::from(next as u16));
            set(&mut unit, "data_in", u64::from(data as u16));
            set(&mut unit, "sum_in", u64::from(above as u32));
            unit.clock().unwrap();
            let sum = above.wrapping_add(i32::from(data) * i32::from(weight));
            if loads {
                weight = next;
            }
            unit.eval().unwrap();
            let get = |name: &str| unit.get_u64(unit.port(name).unwrap()).unwrap();
            let found = ["weight_out", "data_out", "sum_out"].map(get);
            let expected: [u64; 3] = [
                (weight as u16).into(),
                (data as u16).into(),
                (sum as u32).into(),
            ];
            assert_eq!(found, expected, "step {step}");
        }
    }
}
