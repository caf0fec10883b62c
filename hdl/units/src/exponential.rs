//! The exponential by itself: one operand a transfer, one power back, in order.
//!
//! It is a vector unit of one lane and one operation behind two plain valid/ready handshakes, so
//! its bits and clocks are the vector unit's. The FIFO of results and the counters come with it.

use std::sync::Arc;

use potamoi_formats::config::{Config, ExpConfig, ExpOutput};
use potamoi_formats::units::OpCode;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Ty};

use crate::vector_unit::vector_unit;

/// Top module of the exponential by itself.
pub const EXPONENTIAL: &str = "exponential";
/// Bits of a lane's operand and of a result in the vector unit.
const WORD: u32 = 32;

/// The configuration that the block is built from: one lane, `exp` alone, the same engine.
#[must_use]
pub fn alone(config: &Config) -> Config {
    let mut own = config.clone();
    own.vu.lanes = 1;
    own.vu.ops = vec![OpCode::Exp];
    own.vu.operands = None;
    own
}

/// Bits of a result: the fraction of alpha, or the word of exponent and mantissa of general.
#[must_use]
pub const fn result_bits(exp: &ExpConfig) -> u32 {
    match exp.output {
        ExpOutput::Alpha => exp.output_bits,
        ExpOutput::General => WORD,
    }
}

/// Builds `exponential` with the engine of a configuration.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub fn exponential(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let config = alone(config);
    let exp = &config.vu.exp;
    let unit = vector_unit(&config)?;
    let mut builder = ModuleBuilder::new(EXPONENTIAL);
    let m = &mut builder;
    m.doc("Exponential by itself: operands in, powers out in the same order.");
    let valid = m.input("x_valid", Ty::bit(), "an operand");
    let format = exp.input;
    let ty = Ty {
        width: format.width(),
        signed: format.is_signed(),
    };
    let data = m.input("x_data", ty, &format!("the operand, {format}"));
    let sink = m.input("y_ready", Ty::bit(), "the power is taken");
    let word = m.extend(data, WORD);
    let word = m.as_unsigned(word);
    let zero = m.lit(0, Ty::u(WORD));
    let operands = m.cat(&[zero, word]);
    let code = m.lit(OpCode::Exp.code(), Ty::u(WORD));
    let instance = m.instance("unit", &unit, &[]);
    for port in unit.ports().iter().filter(|port| !port.output) {
        let width = port.ty.width;
        let fed = match port.name.as_str() {
            "clk" | "rst_n" => continue,
            "s_axis_vec_tvalid" => valid,
            "s_axis_vec_tdata" => operands,
            "s_axis_vec_tuser" => m.truncate(code, width),
            "s_axis_vec_tkeep" => {
                let kept = m.lit(1, Ty::bit());
                m.repeat(kept, width)
            }
            "m_axis_vec_tready" => sink,
            _ => m.lit(0, port.ty),
        };
        m.connect(instance, &port.name, fed);
    }
    let ready = m.out(instance, "s_axis_vec_tready");
    m.output("x_ready", ready, "does not depend on x_valid; low in reset");
    let offered = m.out(instance, "m_axis_vec_tvalid");
    m.output("y_valid", offered, "a power, held until it is taken");
    let result = m.out(instance, "m_axis_vec_tdata");
    let bits = result_bits(exp);
    let power = m.slice(result, 0, bits);
    let doc = match exp.output {
        ExpOutput::Alpha => format!("the power, U0.{bits}; 1 is the largest code"),
        ExpOutput::General => format!(
            "the power: mantissa U1.{} in the low bits, signed exponent above",
            exp.output_bits
        ),
    };
    m.output("y_data", power, &doc);
    builder.finish()
}
