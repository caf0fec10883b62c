//! Checks of a unit's side of the top. They read both ends of a connection, within the unit and within
//! the registers, so that the connection is checked, too.

use potamoi_netlist::{Instance, ModuleBuilder, Signal};

use super::checks::taken;
use super::registers::Field;

/// What a side is made of.
pub(super) struct Side<'a> {
    pub(super) short: &'static str,
    pub(super) unit: Instance,
    pub(super) job: Instance,
    pub(super) registers: Instance,
    /// Gates, each with the name of its stream.
    pub(super) gates: &'a [(String, Instance)],
    /// Counters: port of the unit, input of the registers, and its lowest bit.
    pub(super) counters: &'a [(&'static str, String, u32)],
    /// Ports of the unit that take a setting, each with the register's output.
    pub(super) settings: &'a [(&'static str, String)],
    /// Fields of the register of flags.
    pub(super) flags: &'a [Field],
}

impl Side<'_> {
    /// Adds the checks to the top.
    pub(super) fn check(&self, m: &mut ModuleBuilder) {
        m.begin_checks();
        self.counters(m);
        self.packets(m);
        self.settings(m);
        self.flags(m);
    }

    /// The registers show each counter as of the last snapshot.
    fn counters(&self, m: &mut ModuleBuilder) {
        let snapshot = format!("{}_snapshot", self.short);
        m.inside_as(&snapshot, self.registers, "control_snapshot");
        let mut right = vec![];
        for (port, input, low) in self.counters {
            let shown = m.inside_as(&format!("{input}_read"), self.registers, input);
            let counted = m.inside_as(&format!("{input}_counted"), self.unit, port);
            let part = m.slice(counted, *low, shown.width());
            let part = m.name(part, &format!("{input}_part"));
            let asked = m.ghost_reg(&format!("{input}_asked"), shown.width());
            let when = m.named(&snapshot);
            m.set_next_if(asked, when, part);
            right.push(format!("{input}_read == {input}_asked"));
        }
        m.assert(
            &format!("{}_counters_of_snapshot", self.short),
            &right.join(" & "),
            "The registers show each counter of the unit as of the last snapshot.",
        );
    }

    /// The job and the gates are told the packets of the register, and it is told what is left.
    fn packets(&self, m: &mut ModuleBuilder) {
        let short = self.short;
        let ordered = format!("{short}_ordered");
        m.inside_as(&ordered, self.registers, &format!("{short}_packets"));
        let of_job = format!("{short}_of_job");
        m.inside_as(&of_job, self.job, "packets");
        let [left, shown] = ["left_in_job", "left_read"].map(|name| format!("{short}_{name}"));
        m.inside_as(&left, self.job, "packets_left");
        m.inside_as(&shown, self.registers, &format!("{short}_left"));
        let mut right = vec![
            format!("{of_job} == {ordered}"),
            format!("{shown} == {left}"),
        ];
        let mut open = vec![];
        for (stream, gate) in self.gates {
            let of_gate = format!("{stream}_of_gate");
            m.inside_as(&of_gate, *gate, "packets");
            right.push(format!("{of_gate} == {ordered}"));
            open.push(format!("{stream}_gate_is_open"));
        }
        m.assert(
            &format!("{short}_packets_as_ordered"),
            &right.join(" & "),
            "The job and its gates are told the packets that software orders, and software those left.",
        );
        m.assert(
            &format!("{short}_done_is_closed"),
            &format!("{short}_job_done -> ~({})", open.join(" | ")),
            "A job is done when no input has packets to come.",
        );
    }

    /// The unit has the settings that the register had when the job began.
    fn settings(&self, m: &mut ModuleBuilder) {
        if self.settings.is_empty() {
            return;
        }
        let begins = format!("{}_begins", self.short);
        m.inside_as(&begins, self.job, "begins");
        let begun = format!("{}_begun", self.short);
        taken(m, &begun, 1, "1", &format!("{begun} | {begins}"));
        let mut right = vec![];
        for (port, output) in self.settings {
            let [given, asked, ordered] =
                ["given", "asked", "ordered"].map(|end| format!("{port}_{end}"));
            let width = m.inside_as(&given, self.unit, port).width();
            m.inside_as(&asked, self.registers, output);
            taken(m, &ordered, width, &begins, &asked);
            right.push(format!("{given} == {ordered}"));
        }
        m.assert(
            &format!("{}_settings_as_ordered", self.short),
            &format!("{begun} -> {}", right.join(" & ")),
            "The unit has the settings that software had ordered when the job began.",
        );
        let table = self.gates.iter().find(|(stream, _)| stream == "rit");
        if let Some((_, gate)) = table {
            m.inside_as("rit_step", *gate, "step");
            m.assert(
                "rit_step_by_segments",
                "rit_step == if(s_axis_rit_tuser, 1, cfg_segments_given)",
                "An MVoxel whose entries are streamed once stands for all of its segments.",
            );
        }
    }

    /// The register shows every flag of the unit, and one that rises is an event.
    fn flags(&self, m: &mut ModuleBuilder) {
        let short = self.short;
        let raised = format!("{short}_raised");
        let flags = m.inside_as(&raised, self.unit, "stat_errors");
        let mut same: Vec<Signal> = vec![];
        for field in self.flags {
            let input = format!("{short}_errors_{}", field.name.to_ascii_lowercase());
            let shown = m.inside_as(&format!("{input}_read"), self.registers, &input);
            let flag = m.bit(flags, field.low);
            same.push(m.eq(shown, flag));
        }
        let same = m.all_of(&same);
        m.name(same, &format!("{short}_flags_are_read"));
        m.assert(
            &format!("{short}_flags_as_raised"),
            &format!("{short}_flags_are_read"),
            "The register shows each flag of the unit.",
        );
        let past = format!("{short}_errors_past");
        taken(m, &past, flags.width(), "1", &raised);
        let event = format!("{short}_error_event");
        m.inside_as(
            &event,
            self.registers,
            &format!("irq_status_{short}_error_set"),
        );
        m.assert(
            &format!("{short}_error_is_new"),
            &format!("{event} == any({raised} & ~{past})"),
            "A flag that rises is an event.",
        );
    }
}

/// The interrupt is that of the events and enables of the registers.
pub(super) fn interrupt_checks(m: &mut ModuleBuilder, registers: Instance, events: &[String]) {
    m.begin_checks();
    let mut wanted = vec![];
    for name in events {
        let [is_set, is_enabled] = ["is_set", "is_enabled"].map(|end| format!("{name}_{end}"));
        m.inside_as(&is_set, registers, &format!("irq_status_{name}"));
        m.inside_as(&is_enabled, registers, &format!("irq_enable_{name}"));
        wanted.push(format!("{is_set} & {is_enabled}"));
    }
    taken(m, "irq_due", 1, "1", &wanted.join(" | "));
    m.assert(
        "irq_of_events",
        "irq == irq_due",
        "The interrupt follows the events that are enabled, a clock later.",
    );
}
