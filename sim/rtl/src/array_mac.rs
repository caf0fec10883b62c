//! Runs a multiply-accumulate unit of the array, with the comparison of every output bit and every
//! cycle that other units have.

use potamoi_formats::units::ARRAY_MAC;
use potamoi_gates::Watch;
use serde::Serialize;

use super::engine::Engine;
use super::gate_engine::GateEngine;
use super::model::RtlError;

/// Outputs that are compared.
const OUTPUTS: [&str; 3] = ["weight_out", "data_out", "sum_out"];

/// Products by one weight.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WeightProducts {
    /// The weight.
    pub weight: i16,
    /// Input and sum from above, one pair a cycle.
    pub operands: Vec<(i16, i32)>,
}

impl WeightProducts {
    /// The sum below the unit, modulo 2^32.
    #[must_use]
    pub fn sum(weight: i16, input: i16, above: i32) -> i32 {
        above.wrapping_add(i32::from(input) * i32::from(weight))
    }
}

impl<W: Watch> GateEngine<W> {
    /// Multiplies from reset, weight after weight; each takes a cycle to load. Returns the cycles
    /// with a product.
    ///
    /// # Errors
    /// The first output that differs: weight, input and sum, each a cycle later.
    pub fn multiply(&mut self, all: &[WeightProducts]) -> Result<u64, RtlError> {
        let inputs = ["load", "weight_in", "data_in", "sum_in"];
        let [load, weight, data, sum] = self.ports(inputs)?;
        let outputs = self.ports(OUTPUTS)?;
        for port in [load, weight, data, sum] {
            self.set(port, 0)?;
        }
        self.reset()?;
        let mut products = 0;
        // Outputs are a cycle behind the operands.
        let mut due = None;
        for own in all {
            self.set(load, 1)?;
            self.set(weight, (own.weight as u16).into())?;
            for operands in std::iter::once(None).chain(own.operands.iter().map(Some)) {
                if let Some((input, above)) = operands {
                    self.set(load, 0)?;
                    self.set(data, (*input as u16).into())?;
                    self.set(sum, (*above as u32).into())?;
                    products += 1;
                }
                self.settle()?;
                self.compare(outputs, due.take())?;
                due = operands.map(|operands| (own.weight, *operands));
                self.edge()?;
            }
        }
        self.settle()?;
        self.compare(outputs, due)?;
        Ok(products)
    }

    /// Compares weight, input and sum with those of the operands before, if any.
    fn compare(&self, outputs: [usize; 3], due: Option<(i16, (i16, i32))>) -> Result<(), RtlError> {
        let Some((weight, (input, above))) = due else {
            return Ok(());
        };
        let below = WeightProducts::sum(weight, input, above);
        let expected: [u64; 3] = [
            (weight as u16).into(),
            (input as u16).into(),
            (below as u32).into(),
        ];
        for ((name, port), expected) in OUTPUTS.iter().zip(outputs).zip(expected) {
            let found = self.get(port)?;
            if found != expected {
                return Err(RtlError::Usage(format!(
                    "{ARRAY_MAC}: {input} x {weight} + {above}: {name} is {found:#x}, expected \
                     {expected:#x}"
                )));
            }
        }
        Ok(())
    }

    fn ports<const N: usize>(&self, names: [&str; N]) -> Result<[usize; N], RtlError> {
        let mut found = [0; N];
        for (port, name) in found.iter_mut().zip(names) {
            *port = self.port(name)?;
        }
        Ok(found)
    }
}
