//! A unit in the top: gates before its inputs, its job, settings, counters and flags.

use std::sync::Arc;

use potamoi_netlist::{Instance, IrErrors, Module, ModuleBuilder, PortInfo, Signal, Ty};

use super::job::job;
use super::packet_gate::{STEP_BITS, packet_gate};
use super::registers::{Field, RegisterMap, WORD_BITS, counted, settings};
use super::side_checks::Side;

/// What belongs to a unit.
pub(super) struct UnitSide {
    /// Begin of its signals' and registers' names: `gu`, `vu`.
    short: &'static str,
    ports: Vec<PortInfo>,
    unit: Instance,
    job: Instance,
    registers: Instance,
    /// The gate of every input stream, by its name.
    gates: Vec<(String, Instance)>,
    /// Segments of the job that runs, of the gathering unit.
    segments: Option<Signal>,
    /// Inputs of the top that go to it, by name.
    inputs: Vec<(String, Signal)>,
    outputs: Vec<Output>,
}

/// An output of the top.
struct Output {
    name: String,
    value: Signal,
    doc: String,
    is_ready: bool,
}

/// Modules that both sides use.
pub(super) struct Parts {
    gate: Arc<Module>,
    job: Arc<Module>,
}

impl Parts {
    /// # Errors
    /// The netlist's own checks.
    pub(super) fn new() -> Result<Self, IrErrors> {
        Ok(Self {
            gate: packet_gate()?,
            job: job()?,
        })
    }
}

/// Stream ports that are inputs of a unit.
pub(super) fn stream_inputs(unit: &Module) -> Vec<PortInfo> {
    let mut ports = unit.ports();
    ports.retain(|port| is_of_stream(&port.name) && !port.output);
    ports
}

fn is_of_stream(name: &str) -> bool {
    name.starts_with("s_axis_") || name.starts_with("m_axis_")
}

impl UnitSide {
    /// Instantiates a unit and what lies around it.
    pub(super) fn build(
        m: &mut ModuleBuilder,
        short: &'static str,
        module: &Arc<Module>,
        parts: &Parts,
        inputs: &[(String, Signal)],
        (map, registers): (&RegisterMap, Instance),
    ) -> Self {
        let unit = m.instance(short, module, &[]);
        let job = m.instance(&format!("{short}_job"), &parts.job, &[]);
        let mut side = Self {
            short,
            ports: module.ports(),
            unit,
            job,
            registers,
            gates: vec![],
            segments: None,
            inputs: inputs.to_vec(),
            outputs: vec![],
        };
        side.connect_settings(m, map);
        let open = side.connect_inputs(m, parts);
        side.connect_outputs(m);
        side.connect_job(m, &open);
        side.connect_counters(m);
        side.connect_flags(m, map);
        side
    }

    /// An output of the registers of this unit.
    fn of_software(&self, m: &mut ModuleBuilder, name: &str) -> Signal {
        m.out(self.registers, name)
    }

    fn input(&self, m: &mut ModuleBuilder, name: &str) -> Signal {
        let own = self.inputs.iter().find(|(own, _)| own == name);
        match own {
            Some((_, signal)) => *signal,
            None => m.lit(0, Ty::bit()),
        }
    }

    /// The unit's settings change with the begin of a job alone.
    fn connect_settings(&mut self, m: &mut ModuleBuilder, map: &RegisterMap) {
        let begins = m.out(self.job, "begins");
        let clear = self.of_software(m, "control_clear");
        m.connect(self.unit, "cfg_clear", clear);
        for (port, field) in settings(&self.ports) {
            let name = format!("gu_mode_{}", field.to_ascii_lowercase());
            let next = self.of_software(m, &name);
            let own = fields(map, "GU_MODE").iter().find(|own| own.name == field);
            let reg = m.reg(port, next.ty(), own.map_or(0, |own| own.reset));
            m.set_next_if(reg, begins, next);
            m.connect(self.unit, port, reg);
            if field == "SEGMENTS" {
                self.segments = Some(reg);
            }
        }
    }

    /// Puts a gate before every input; returns whether each is open.
    fn connect_inputs(&mut self, m: &mut ModuleBuilder, parts: &Parts) -> Vec<Signal> {
        let begins = m.out(self.job, "begins");
        let packets = self.of_software(m, &format!("{}_packets", self.short));
        let inputs: Vec<_> = self
            .ports
            .iter()
            .filter(|port| !port.output && is_of_stream(&port.name))
            .map(|port| port.name.clone())
            .collect();
        let mut open = vec![];
        for name in &inputs {
            let Some(stream) = name.strip_suffix("_tvalid") else {
                let signal = self.input(m, name);
                m.connect(self.unit, name, signal);
                continue;
            };
            let short = stream.trim_start_matches("s_axis_");
            let [valid, last] =
                ["tvalid", "tlast"].map(|end| self.input(m, &format!("{stream}_{end}")));
            let ready_name = format!("{stream}_tready");
            let ready = m.out(self.unit, &ready_name);
            let step = self.step(m, stream);
            let gate = m.instance(
                &format!("{short}_gate"),
                &parts.gate,
                &[
                    ("start", begins),
                    ("packets", packets),
                    ("step", step),
                    ("s_tvalid", valid),
                    ("s_tlast", last),
                    ("m_tready", ready),
                ],
            );
            self.gates.push((short.to_owned(), gate));
            let shown = m.out(gate, "m_tvalid");
            m.connect(self.unit, name, shown);
            open.push(m.out(gate, "is_open"));
            let value = m.out(gate, "s_tready");
            self.outputs.push(Output {
                name: ready_name,
                value,
                doc: format!("low outside a job, and after its last packet; {DEPENDS_NOT}"),
                is_ready: true,
            });
        }
        open
    }

    /// Packets of features that the end of a packet stands for: all segments of an MVoxel whose
    /// entries are streamed once.
    fn step(&self, m: &mut ModuleBuilder, stream: &str) -> Signal {
        let one = m.lit(1, Ty::u(STEP_BITS));
        if stream != "s_axis_rit" {
            return one;
        }
        let again = self.input(m, "s_axis_rit_tuser");
        self.segments
            .map_or(one, |segments| m.mux(again, one, segments))
    }

    fn connect_outputs(&mut self, m: &mut ModuleBuilder) {
        let outputs: Vec<_> = self
            .ports
            .iter()
            .filter(|port| port.output && port.name.starts_with("m_axis_"))
            .cloned()
            .collect();
        for port in outputs {
            let value = m.out(self.unit, &port.name);
            self.outputs.push(Output {
                name: port.name,
                value,
                doc: port.doc,
                is_ready: false,
            });
        }
    }

    fn connect_job(&self, m: &mut ModuleBuilder, open: &[Signal]) {
        let short = self.short;
        let sink = self
            .ports
            .iter()
            .find(|port| port.name.starts_with("m_axis_") && port.name.ends_with("_tready"));
        let stream = sink.map_or("", |port| port.name.trim_end_matches("_tready"));
        let offered = m.out(self.unit, &format!("{stream}_tvalid"));
        let last = m.out(self.unit, &format!("{stream}_tlast"));
        let ready = self.input(m, &format!("{stream}_tready"));
        let taken = m.and(offered, ready);
        let open = m.any_of(open);
        let idle = m.out(self.unit, "idle");
        for (port, signal) in [
            ("idle", idle),
            ("is_open", open),
            ("taken", taken),
            ("taken_last", last),
        ] {
            m.connect(self.job, port, signal);
        }
        for (port, from) in [
            ("start", format!("control_{short}_start")),
            ("packets", format!("{short}_packets")),
        ] {
            let signal = self.of_software(m, &from);
            m.connect(self.job, port, signal);
        }
        for (port, to) in [
            ("is_running", format!("status_{short}_running")),
            ("done", format!("irq_status_{short}_done_set")),
            ("refused", format!("irq_status_{short}_refused_set")),
            ("packets_left", format!("{short}_left")),
        ] {
            let signal = m.out(self.job, port);
            m.connect(self.registers, &to, signal);
        }
        m.connect(self.registers, &format!("status_{short}_idle"), idle);
    }

    /// Registers show counters as of the last snapshot.
    fn connect_counters(&self, m: &mut ModuleBuilder) {
        let snapshot = self.of_software(m, "control_snapshot");
        for (port, register) in counted(&self.ports) {
            let count = m.out(self.unit, port);
            let name = register.to_ascii_lowercase();
            let shown = m.reg(&format!("{name}_shown"), count.ty(), 0);
            m.set_next_if(shown, snapshot, count);
            let low = m.slice(shown, 0, count.width().min(WORD_BITS));
            m.connect(self.registers, &name, low);
            if count.width() > WORD_BITS {
                let high = m.slice(shown, WORD_BITS, count.width() - WORD_BITS);
                m.connect(self.registers, &format!("{name}_high"), high);
            }
        }
    }

    /// A flag that rises is an event.
    fn connect_flags(&self, m: &mut ModuleBuilder, map: &RegisterMap) {
        let short = self.short;
        let flags = m.out(self.unit, "stat_errors");
        let register = format!("{}_ERRORS", short.to_ascii_uppercase());
        for field in fields(map, &register) {
            let flag = m.bit(flags, field.low);
            let port = format!("{short}_errors_{}", field.name.to_ascii_lowercase());
            m.connect(self.registers, &port, flag);
        }
        let before = m.reg(&format!("{short}_errors_before"), flags.ty(), 0);
        m.set_next(before, flags);
        let known = m.not(before);
        let new = m.and(flags, known);
        let new = m.any(new);
        let new = m.name(new, &format!("{short}_error_rises"));
        m.connect(
            self.registers,
            &format!("irq_status_{short}_error_set"),
            new,
        );
    }

    /// Declares the outputs of the top.
    pub(super) fn outputs(&self, m: &mut ModuleBuilder) {
        for own in &self.outputs {
            match own.is_ready {
                true => m.output_low_in_reset(&own.name, own.value, &own.doc),
                false => m.output(&own.name, own.value, &own.doc),
            }
        }
    }
}

impl UnitSide {
    /// Checks of what lies around the unit.
    pub(super) fn checks(&self, m: &mut ModuleBuilder, map: &RegisterMap) {
        let mut counters = vec![];
        for (port, register) in counted(&self.ports) {
            let input = register.to_ascii_lowercase();
            let own = self.ports.iter().find(|own| own.name == port);
            if own.is_some_and(|own| own.ty.width > WORD_BITS) {
                counters.push((port, format!("{input}_high"), WORD_BITS));
            }
            counters.push((port, input, 0));
        }
        let settings = settings(&self.ports).into_iter();
        let settings: Vec<_> = settings
            .map(|(port, field)| (port, format!("gu_mode_{}", field.to_ascii_lowercase())))
            .collect();
        let flags = format!("{}_ERRORS", self.short.to_ascii_uppercase());
        let side = Side {
            short: self.short,
            unit: self.unit,
            job: self.job,
            registers: self.registers,
            gates: &self.gates,
            counters: &counters,
            settings: &settings,
            flags: fields(map, &flags),
        };
        side.check(m);
    }
}

fn fields<'a>(map: &'a RegisterMap, register: &str) -> &'a [Field] {
    map.register(register).map_or(&[], |own| &own.fields)
}

const DEPENDS_NOT: &str = "does not depend on tvalid";
