//! The bench of the SoC top: the jobs of both units at once, driven through the registers.
//!
//! It reads the memories of the units' benches. Offsets and reset values are those of the register
//! table.

use std::fmt::Write as _;

use potamoi_formats::config::Config;
use potamoi_formats::units::NPU_EXT;
use potamoi_soc::npu::registers::{Access, Register, RegisterMap};
use potamoi_soc::npu::{npu_ext, register_map_of};

use super::common::{OPTIONS, cut, declare_memory, list, read_memory};
use super::memory::Memory;
use super::npu_bus;
use super::npu_parts as parts;
use super::ports::Stream;
use super::suite::{Memories, Suite};
use crate::RtlError;

/// A unit's jobs in the bench of the top.
struct Side {
    /// `gu` or `vu`.
    short: &'static str,
    suite: Suite,
    memories: Memories,
}

/// The bench of the top with the jobs of both units.
///
/// # Errors
/// Jobs that the benches cannot hold.
pub(super) fn bench(
    config: &Config,
    module: &str,
    commands: &[String],
    suites: [Suite; 2],
) -> Result<String, RtlError> {
    let map = register_map_of(config)?;
    let mut sides = vec![];
    for (short, suite) in ["gu", "vu"].into_iter().zip(suites) {
        let memories = suite.memories()?;
        sides.push(Side {
            short,
            suite,
            memories,
        });
    }
    let mut text = format!(
        "// Testbench of {NPU_EXT} with golden vectors. Run in the folder of the .hex files:\n"
    );
    for command in commands {
        let _ = writeln!(text, "//   {command}");
    }
    text += parts::BEGIN;
    constants(&mut text, &map);
    for side in &sides {
        side.declare(&mut text);
    }
    instance(&mut text, config, module)?;
    text += npu_bus::TASKS;
    text += parts::STREAMS;
    for side in &sides {
        side.process(&mut text);
    }
    text += "  end\n";
    registers(&mut text, &map);
    for side in &sides {
        side.job(&mut text, &map);
    }
    let inputs = sides.iter().flat_map(|side| &side.suite.ports.inputs);
    let quiet: Vec<_> = inputs
        .map(|stream| format!("{}_at == 0", stream.name))
        .collect();
    text += &parts::MAIN.replace("@WAITING@", &quiet.join(" || "));
    for side in &sides {
        side.breaks(&mut text);
    }
    text += "\n  task break_promises;\n    begin\n";
    for side in &sides {
        side.broken(&mut text);
    }
    text += "    end\n  endtask\n";
    text += OPTIONS;
    text += "    bus_drawn = after(drawn);\n";
    for side in &sides {
        side.files(&mut text);
    }
    text += parts::RUN;
    Ok(text)
}

/// Offsets of all registers, and the bits of commands, state and events.
fn constants(text: &mut String, map: &RegisterMap) {
    for own in &map.registers {
        let _ = writeln!(
            text,
            "  localparam [11:0] {} = 12'h{:03x};",
            own.name, own.offset
        );
    }
    for name in ["CONTROL", "STATUS", "IRQ_STATUS"] {
        for field in map.register(name).iter().flat_map(|own| &own.fields) {
            let _ = writeln!(
                text,
                "  localparam [31:0] {name}_{} = 32'h{:x};",
                field.name,
                field.mask()
            );
        }
    }
}

fn instance(text: &mut String, config: &Config, module: &str) -> Result<(), RtlError> {
    let ports = npu_ext(config)?.ports();
    let names = ports.iter().map(|port| port.name.as_str());
    let links: Vec<_> = ["clk", "rst_n"]
        .into_iter()
        .chain(names)
        .map(|name| format!("    .{name}({name})"))
        .collect();
    let _ = writeln!(text, "\n  {module} unit (\n{}\n  );", links.join(",\n"));
    Ok(())
}

/// A task that holds every register to the table, right after reset.
fn registers(text: &mut String, map: &RegisterMap) {
    *text += "\n  // Every register after reset, what a write changes, and what it must not.\n";
    *text += "  task check_registers;\n    begin\n";
    for own in &map.registers {
        let name = &own.name;
        let _ = writeln!(text, "      check({name}, 32'h{:08x});", own.reset());
        match own.access {
            Access::Constant | Access::Status => {
                let _ = writeln!(text, "      write({name}, 32'hffffffff, 4'hf, SLVERR);");
                let _ = writeln!(text, "      check({name}, 32'h{:08x});", own.reset());
            }
            Access::ReadWrite => read_write(text, own),
            Access::WriteOneToClear | Access::Pulse => {
                let _ = writeln!(text, "      write({name}, 32'hffffffff, 4'h0, OKAY);");
                let _ = writeln!(text, "      check({name}, 32'h{:08x});", own.reset());
            }
        }
    }
    let used = |offset: &u32| map.registers.iter().any(|own| own.offset == *offset);
    let holes: Vec<u32> = (0..0x1000).step_by(4).filter(|at| !used(at)).collect();
    for hole in [holes.first(), holes.last()].into_iter().flatten() {
        let _ = writeln!(
            text,
            "      write(12'h{hole:03x}, 32'hffffffff, 4'hf, SLVERR);"
        );
    }
    *text += "    end\n  endtask\n";
    *text += parts::HOLES;
    for run in holes.chunk_by(|a, b| a + 4 == *b) {
        let (from, to) = (run[0], run[run.len() - 1]);
        let _ = writeln!(text, "      read_hole('h{from:03x}, 'h{to:03x});");
    }
    *text += "    end\n  endtask\n";
}

/// Byte after byte, and back.
fn read_write(text: &mut String, own: &Register) {
    let name = &own.name;
    let mut value = own.reset();
    for byte in 0..4 {
        let mask = 0xffu32 << (8 * byte);
        let data = 0xa5c3_965au32;
        value = (value & !mask | data & mask) & own.mask();
        let strobe = 1 << byte;
        let _ = writeln!(
            text,
            "      write({name}, 32'h{data:08x}, 4'h{strobe:x}, OKAY);"
        );
        let _ = writeln!(text, "      check({name}, 32'h{value:08x});");
    }
    let _ = writeln!(
        text,
        "      write({name}, 32'h{:08x}, 4'hf, OKAY);",
        own.reset()
    );
}

impl Side {
    fn declare(&self, text: &mut String) {
        let short = self.short;
        let (file, memory) = &self.memories.jobs;
        let _ = writeln!(text, "\n  integer {short}_job = 0;");
        let _ = writeln!(
            text,
            "  localparam {}_JOBS = {};",
            short.to_uppercase(),
            self.suite.jobs.len()
        );
        declare_memory(text, &format!("{short}_job"), file, memory);
        let whole = format!("{short}_job_words[{short}_job]");
        cut(text, &format!("{short}_job"), &memory.fields, &whole);
        for (stream, (file, memory)) in self.suite.ports.inputs.iter().zip(&self.memories.inputs) {
            let name = &stream.name;
            declare_memory(text, name, file, memory);
            *text += &of_stream(parts::SOURCE, stream, memory);
            let of = format!("{name}_tvalid ? {name}_word : ~{name}_word");
            cut(text, name, &stream.fields, &of);
        }
        let stream = &self.suite.ports.output;
        let (file, memory) = &self.memories.output;
        let name = &stream.name;
        declare_memory(text, name, file, memory);
        *text += &of_stream(parts::SINK, stream, memory);
        for (field, bits) in &stream.fields {
            let _ = writeln!(text, "  wire [{}:0] {name}_{field};", bits - 1);
        }
        let fields = stream
            .fields
            .iter()
            .map(|(field, _)| format!("{name}_{field}"));
        let fields = list(&fields.collect::<Vec<_>>(), "      ");
        let _ = writeln!(text, "  assign {name}_found = {{\n{fields}\n    }};");
    }

    fn process(&self, text: &mut String) {
        let short = self.short;
        let jobs = &self.memories.jobs.1;
        let place = |stream: &Stream, end: &str| jobs.place_of(&format!("{}_{end}", stream.name));
        for (stream, (_, memory)) in self.suite.ports.inputs.iter().zip(&self.memories.inputs) {
            *text += &of_stream(parts::OFFER, stream, memory)
                .replace("@JOBS@", &format!("{}_JOBS", short.to_uppercase()))
                .replace("@FIRST@", &format!("{short}_first"))
                .replace("@WORDS@", &format!("{short}_job_words"))
                .replace("@FROM@", &place(stream, "from"))
                .replace("@END@", &place(stream, "end"));
        }
        let stream = &self.suite.ports.output;
        let of_job = |end: &str| format!("{short}_job_{}_{end}", stream.name);
        *text += &of_stream(parts::TAKE, stream, &self.memories.output.1)
            .replace("@FROM@", &of_job("from"))
            .replace("@END@", &of_job("end"));
    }

    /// A task for beats that break a promise.
    fn breaks(&self, text: &mut String) {
        let of_input = |stream: &Stream| {
            let name = &stream.name;
            format!("{name}_at != {}_job_{name}_end", self.short)
        };
        let waiting: Vec<_> = self.suite.ports.inputs.iter().map(of_input).collect();
        *text += &parts::BREAK
            .replace("@SHORT@", self.short)
            .replace("@UPPER@", &self.short.to_uppercase())
            .replace("@WAITING@", &waiting.join(" || "));
    }

    /// Statements that run them.
    fn broken(&self, text: &mut String) {
        let first = self.suite.jobs.len();
        for (i, broken) in self.suite.broken.iter().enumerate() {
            let _ = writeln!(
                text,
                "      {}_break({}, 32'h{:x}, 32'h{:x});",
                self.short,
                first + i,
                broken.up,
                broken.down
            );
        }
    }

    fn files(&self, text: &mut String) {
        let (file, memory) = &self.memories.jobs;
        *text += &read_memory(&format!("{}_job", self.short), file, memory);
        for (stream, (file, memory)) in self.suite.ports.inputs.iter().zip(&self.memories.inputs) {
            *text += &read_memory(&stream.name, file, memory);
        }
        let (file, memory) = &self.memories.output;
        *text += &read_memory(&self.suite.ports.output.name, file, memory);
    }

    /// Tasks that begin a job, and that hold its end to what it must be.
    fn job(&self, text: &mut String, map: &RegisterMap) {
        let short = self.short;
        let upper = short.to_uppercase();
        let stream = &self.suite.ports.output;
        let end = format!("{short}_job_{}_end", stream.name);
        let last = {
            // Fields lie highest first.
            let below = stream
                .fields
                .iter()
                .rev()
                .take_while(|(field, _)| field != "tlast");
            below.map(|(_, bits)| bits).sum::<u32>()
        };
        let _ = writeln!(
            text,
            "
  integer {short}_packets;
  integer {short}_beat;
  task {short}_begin;
    begin
      {out}_at = {short}_job_{out}_from;
      // Ends of packets that the job must give.
      {short}_packets = 0;
      for ({short}_beat = {out}_at; {short}_beat < {end}; {short}_beat = {short}_beat + 1)
        if ({out}_words[{short}_beat][{last}]) {short}_packets = {short}_packets + 1;",
            out = stream.name,
        );
        if !self.suite.ports.settings.is_empty() {
            let _ = writeln!(text, "      mode = 32'd0;");
        }
        for (setting, _) in &self.suite.ports.settings {
            let name = setting.trim_start_matches("cfg_").to_uppercase();
            let fields = map.register("GU_MODE").map_or(&[][..], |own| &own.fields);
            for field in fields.iter().filter(|own| own.name == name) {
                let _ = writeln!(
                    text,
                    "      mode[{} +: {}] = {short}_job_{setting};",
                    field.low, field.width
                );
            }
        }
        if !self.suite.ports.settings.is_empty() {
            let _ = writeln!(text, "      write({upper}_MODE, mode, 4'hf, OKAY);");
        }
        let _ = writeln!(
            text,
            "      if (many != 32'd0) {short}_packets = many;
      write({upper}_PACKETS, {short}_packets, 4'hf, OKAY);
      write(CONTROL, CONTROL_{upper}_START, 4'hf, OKAY);"
        );
        if !self.suite.ports.settings.is_empty() {
            *text += "      // Of the next job: the one that runs has its own.\n";
            let _ = writeln!(text, "      write({upper}_MODE, ~mode, 4'hf, OKAY);");
        }
        let _ = writeln!(
            text,
            "    end
  endtask

  task {short}_check;
    begin
      if (!failed && {out}_at != {end}) begin
        $display(\"FAIL: the job is done, and {out} gave %0d of %0d beats\", {out}_at, {end});
        fail;
      end",
            out = stream.name,
        );
        for (stat, bits) in &self.suite.ports.stats {
            let name = stat.trim_start_matches("stat_").to_uppercase();
            let gaps = !self.suite.steady.contains(&&**stat);
            let when = match gaps {
                true => format!("if (gaps == 0 && {short}_job_closed == 0) "),
                false => String::new(),
            };
            let value = format!("{short}_job_{stat}");
            let low = format!("{value}[{}:0]", bits.min(&32) - 1);
            let _ = writeln!(text, "      {when}check({upper}_{name}, {low});");
            if *bits > 32 {
                let high = format!("{value}[{}:32]", bits - 1);
                let _ = writeln!(text, "      {when}check({upper}_{name}_HIGH, {high});");
            }
        }
        *text += "    end\n  endtask\n";
    }
}

fn of_stream(part: &str, stream: &Stream, memory: &Memory) -> String {
    part.replace("@NAME@", &stream.name)
        .replace("@WIDTH@", &memory.width().to_string())
        .replace("@COUNT@", &memory.count.to_string())
}
