//! The top: both units, their registers and the bus.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_formats::units::NPU_EXT;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Ty};

use super::axi_lite::{self, axi_lite};
use super::register_file::register_file;
use super::registers::{RegisterMap, register_map};
use super::side_checks::interrupt_checks;
use super::unit_side::{Parts, UnitSide, stream_inputs};
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::vector_unit::vector_unit;

/// The registers of a configuration.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub fn registers(config: &Config) -> Result<RegisterMap, IrErrors> {
    let (gathers, vectors) = (gathering_unit(config)?, vector_unit(config)?);
    Ok(register_map(config, &gathers.ports(), &vectors.ports()))
}

/// Builds the top for a configuration.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub fn npu_ext(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let units = [gathering_unit(config)?, vector_unit(config)?];
    let map = register_map(config, &units[0].ports(), &units[1].ports());
    let mut builder = ModuleBuilder::new(NPU_EXT);
    let m = &mut builder;
    m.doc(
        "gathering unit and vector unit with AXI4-Stream data, AXI4-Lite registers and an interrupt.",
    );
    let bus_inputs =
        axi_lite::INPUTS.map(|(name, bits, doc)| (name, m.input(name, Ty::u(bits), doc)));
    let inputs = units.each_ref().map(|unit| {
        let ports = stream_inputs(unit);
        let own = ports.into_iter().map(|port| {
            let signal = m.input(&port.name, port.ty, &port.doc);
            (port.name, signal)
        });
        own.collect::<Vec<_>>()
    });
    m.section("Signals of the bus and the registers");
    let bus = m.instance("bus", &axi_lite()?, &bus_inputs);
    let registers = m.instance("registers", &register_file(&map)?, &[]);
    for port in [
        "write",
        "write_index",
        "write_data",
        "write_strobe",
        "read_index",
    ] {
        let signal = m.out(bus, port);
        m.connect(registers, port, signal);
    }
    for port in ["write_error", "read_data", "read_error"] {
        let signal = m.out(registers, port);
        m.connect(bus, port, signal);
    }
    let parts = Parts::new()?;
    let titles = [
        ("gu", "Bus, and the side of the gathering unit"),
        ("vu", "Side of the vector unit"),
    ];
    let mut sides = vec![];
    for ((unit, own), (short, title)) in units.iter().zip(&inputs).zip(titles) {
        m.section(title);
        sides.push(UnitSide::build(
            m,
            short,
            unit,
            &parts,
            own,
            (&map, registers),
        ));
    }
    m.section("Registers and interrupt");
    let fields = map.register("IRQ_STATUS");
    let fields = fields.iter().flat_map(|own| &own.fields);
    let events: Vec<_> = fields.map(|own| own.name.to_ascii_lowercase()).collect();
    let mut wanted = vec![];
    for name in &events {
        let event = m.out(registers, &format!("irq_status_{name}"));
        let enable = m.out(registers, &format!("irq_enable_{name}"));
        wanted.push(m.and(event, enable));
    }
    let any = m.any_of(&wanted);
    let irq = m.reg("irq", Ty::bit(), 0);
    m.set_next(irq, any);
    m.section("Outputs");
    for (name, doc, low) in axi_lite::OUTPUTS {
        let value = m.out(bus, name);
        match low {
            true => m.output_low_in_reset(name, value, doc),
            false => m.output(name, value, doc),
        }
    }
    for side in &sides {
        side.outputs(m);
    }
    m.output(
        "irq",
        irq,
        "high while an event that is enabled has not been cleared",
    );
    for side in &sides {
        side.checks(m, &map);
    }
    interrupt_checks(m, registers, &events);
    builder.finish()
}
