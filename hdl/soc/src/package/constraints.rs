//! `UNIT.sdc`: clock, I/O delays, and what the reset asks for.

use std::fmt::Write as _;

use potamoi_formats::units::NPU_EXT;

use super::{Package, Unit};

/// Period where the configuration has no clock, in nanoseconds.
const PERIOD_NS: f64 = 1.0;
/// Part of the period that lies outside the unit, at inputs and at outputs.
const OUTSIDE: f64 = 0.3;

const UNIT_S_SETTINGS: &str = "\
# Settings cfg_* change while `idle` is high only, so that their timing seldom matters; cfg_clear is an
# ordinary input.";
const TOP_S_SETTINGS: &str = "\
# Bus, streams and interrupt belong to this clock; a bus of another clock needs a bridge outside. Outputs of
# the bus and irq depend on no input in the same clock, but for ready on rst_n.";

pub(super) fn text(package: &Package, unit: &Unit) -> String {
    let (period, from) = match package.clock_ghz {
        Some(clock) => (1.0 / clock, "clock_ghz of the configuration"),
        None => (
            PERIOD_NS,
            "assumed: the configuration has no clock_ghz; set your own",
        ),
    };
    let ports = |output: bool| {
        let own = unit.ports.iter().filter(|port| port.output == output);
        let own = own.map(|port| match port.ty.width {
            1 => port.name.clone(),
            _ => format!("{}[*]", port.name),
        });
        own.collect::<Vec<_>>().join(" \\\n  ")
    };
    let mut text = package.head("#");
    let _ = write!(
        text,
        "\
# {top}: one clock, rising edge. Times in ns.
#
# rst_n is a synchronous reset, active low, and timed like any other input: no false path. Hold it low for
# one clock edge or more. Release it in step with the clock; an asynchronous source needs a synchroniser
# outside. Memories have no reset.
{settings}

set period {period:.3}  ;# {from}
set outside {OUTSIDE}  ;# part of the period spent outside, at inputs and at outputs (assumed)

create_clock -name clk -period $period [get_ports clk]
set_input_delay [expr {{$outside * $period}}] -clock clk [get_ports {{ \\
  rst_n \\
  {inputs} \\
}}]
set_output_delay [expr {{$outside * $period}}] -clock clk [get_ports {{ \\
  {outputs} \\
}}]
",
        top = unit.top,
        settings = match unit.name {
            NPU_EXT => TOP_S_SETTINGS,
            _ => UNIT_S_SETTINGS,
        },
        inputs = ports(false),
        outputs = ports(true),
    );
    text
}
