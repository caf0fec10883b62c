//! The text of a bench.

use std::fmt::Write as _;

use super::common;
use super::memory::Memory;
use super::parts;
use super::ports::Stream;
use super::script::is_scripted;
use super::suite::{Memories, Owes, Suite};

/// A bench under construction.
pub(super) struct Bench<'a> {
    unit: &'a str,
    suite: &'a Suite,
    memories: &'a Memories,
    commands: &'a [String],
    text: String,
}

impl<'a> Bench<'a> {
    pub(super) const fn new(
        unit: &'a str,
        suite: &'a Suite,
        memories: &'a Memories,
        commands: &'a [String],
    ) -> Self {
        Self {
            unit,
            suite,
            memories,
            commands,
            text: String::new(),
        }
    }

    /// The bench as Verilog-2005.
    pub(super) fn text(mut self) -> String {
        self.header();
        self.job_words();
        self.script_words();
        let inputs = self.suite.ports.inputs.iter().zip(&self.memories.inputs);
        for (stream, (file, memory)) in inputs {
            self.source(stream, file, memory);
        }
        self.sink();
        self.instance();
        self.files();
        self.tasks();
        self.process();
        self.text
    }

    fn add(&mut self, text: &str) {
        self.text.push_str(text);
    }

    /// Appends a part with the names of this bench in it.
    fn part(&mut self, part: &str, names: &[(&str, &str)]) {
        let mut text = part.replace("@OUT@", &self.suite.ports.output.name);
        text = text.replace("@UNIT@", self.unit);
        for (name, value) in names {
            text = text.replace(&format!("@{name}@"), value);
        }
        self.add(&text);
    }

    fn header(&mut self) {
        let _ = writeln!(
            self.text,
            "// Testbench of {} with golden vectors. Run in the folder of the .hex files:",
            self.unit
        );
        for command in self.commands {
            let _ = writeln!(self.text, "//   {command}");
        }
        self.add(parts::OPTIONS);
        let mut listed = 0;
        let alike = self.suite.jobs.chunk_by(|a, b| a.title == b.title);
        for jobs in alike.take(40) {
            let last = listed + jobs.len() - 1;
            let _ = match jobs.len() {
                1 => writeln!(self.text, "//   {last}: {}", jobs[0].title),
                _ => writeln!(self.text, "//   {listed} to {last}: {}", jobs[0].title),
            };
            listed = last + 1;
        }
        let more = self.suite.jobs.len() - listed;
        if more > 0 {
            let _ = writeln!(self.text, "//   and {more} more");
        }
        let jobs = self.suite.jobs.len().to_string();
        if let Some((file, _)) = &self.memories.script {
            let _ = writeln!(
                self.text,
                "// Then clocks in which promises are broken, from {file}, and what flags must say of them."
            );
        }
        self.part(parts::BEGIN, &[("JOBS", &jobs)]);
    }

    fn memory(&mut self, name: &str, file: &str, memory: &Memory) {
        common::declare_memory(&mut self.text, name, file, memory);
    }

    fn cut(&mut self, before: &str, fields: &[(String, u32)], of: &str) {
        common::cut(&mut self.text, before, fields, of);
    }

    fn job_words(&mut self) {
        let (file, memory) = &self.memories.jobs;
        self.memory("job", file, memory);
        self.cut("job", &memory.fields, "job_words[job]");
        for (setting, bits) in &self.suite.ports.settings {
            let _ = writeln!(self.text, "  reg [{}:0] {setting} = {bits}'d0;", bits - 1);
        }
    }

    /// The words of the script, where there is one.
    fn script_words(&mut self) {
        let Some((file, memory)) = &self.memories.script else {
            return;
        };
        let flags = memory.fields.last().map_or(1, |field| field.1).to_string();
        self.part(parts::SCRIPT, &[("FLAGS", &flags)]);
        self.memory("script", file, memory);
        let word = format!(
            "script_words[script_at < {0} ? script_at : {0} - 1]",
            memory.count
        );
        self.cut("script", &memory.fields, &word);
    }

    fn source(&mut self, stream: &Stream, file: &str, memory: &Memory) {
        let name = &stream.name;
        self.memory(name, file, memory);
        let (width, count) = (memory.width().to_string(), memory.count.to_string());
        let (scripted, choice) = match self.memories.script {
            Some(_) => (
                format!("  reg [{width}-1:0] {name}_scripted;\n"),
                format!("scripted ? {name}_scripted\n    : "),
            ),
            None => (String::new(), String::new()),
        };
        let names = [
            ("SCRIPTED", &*scripted),
            ("CHOICE", &*choice),
            ("IN", &**name),
            ("WIDTH", &width),
            ("COUNT", &count),
        ];
        self.part(parts::SOURCE, &names);
        let of = format!("{name}_tvalid ? {name}_word : ~{name}_word");
        self.cut(name, &stream.fields, &of);
    }

    fn sink(&mut self) {
        let output = &self.suite.ports.output;
        let (file, memory) = &self.memories.output;
        self.memory(&output.name, file, memory);
        let count = memory.count.to_string();
        self.part(parts::SINK, &[("COUNT", &count)]);
        for (field, bits) in &output.fields {
            let _ = writeln!(
                self.text,
                "  wire [{}:0] {}_{field};",
                bits - 1,
                output.name
            );
        }
        let word = format!("{0}_words[{0}_at < {count} ? {0}_at : 0]", output.name);
        self.cut("wanted", &output.fields, &word);
    }

    fn instance(&mut self) {
        let ports = &self.suite.ports;
        let mut names = vec!["clk".to_owned(), "rst_n".to_owned()];
        names.extend(ports.settings.iter().map(|s| s.0.clone()));
        names.extend(ports.clears.then(|| "cfg_clear".to_owned()));
        names.extend(ports.idle.then(|| "idle".to_owned()));
        for stream in ports.inputs.iter().chain([&ports.output]) {
            let handshake = ["tvalid", "tready"].map(|s| format!("{}_{s}", stream.name));
            names.extend(handshake);
            let payload = stream
                .fields
                .iter()
                .map(|f| format!("{}_{}", stream.name, f.0));
            names.extend(payload);
        }
        for (stat, bits) in &ports.stats {
            let _ = writeln!(self.text, "  wire [{}:0] {stat};", bits - 1);
            names.push(stat.clone());
        }
        let links: Vec<_> = names.iter().map(|n| format!("    .{n}({n})")).collect();
        let module = &ports.module;
        let _ = writeln!(
            self.text,
            "\n  {module} unit (\n{}\n  );",
            links.join(",\n")
        );
    }

    fn files(&mut self) {
        let ports = &self.suite.ports;
        let names = ports.inputs.iter().map(|s| &*s.name);
        let names = ["job"]
            .into_iter()
            .chain(names)
            .chain([&*ports.output.name])
            .chain(self.memories.script.iter().map(|_| "script"));
        let memories = [&self.memories.jobs];
        let memories = memories.into_iter().chain(&self.memories.inputs);
        let memories = memories.chain([&self.memories.output]);
        let memories = memories.chain(&self.memories.script);
        self.add(common::OPTIONS);
        for (name, (file, memory)) in names.zip(memories) {
            self.add(&common::read_memory(name, file, memory));
        }
        self.add("  end\n");
    }

    fn tasks(&mut self) {
        let output = &self.suite.ports.output;
        let widest = output.fields.iter().map(|f| f.1).max().unwrap_or(1);
        let widest = (32 * widest.div_ceil(32) - 1).to_string();
        self.part(parts::FAIL, &[("WIDEST", &widest)]);
        self.part(parts::COMPARE, &[]);
        for (field, _) in &output.fields {
            self.part(parts::COMPARE_FIELD, &[("FIELD", field)]);
        }
        self.add("    end\n  endtask\n");
        if self.suite.ports.idle {
            let owed = match self.suite.owes {
                Owes::Packets => {
                    let open = |s: &Stream| format!("{}_open", s.name);
                    let mut open: Vec<_> = self.suite.ports.inputs.iter().map(open).collect();
                    let of_tables = self.suite.ports.input("mft").map(|s| &s.name);
                    open.extend(
                        of_tables.map(|name| format!("{name}_packets != {}_packets", output.name)),
                    );
                    open.join(" || ")
                }
                Owes::Beats => {
                    let given = |s: &Stream| format!("{}_beats", s.name);
                    let given: Vec<_> = self.suite.ports.inputs.iter().map(given).collect();
                    format!("{} != {}_beats", given.join(" + "), output.name)
                }
            };
            self.part(parts::IDLE, &[("OWED", &owed)]);
        }
        self.add(parts::COUNTERS);
        for (stat, _) in &self.suite.ports.stats {
            let steady = self.suite.steady.contains(&&**stat);
            let when = if steady { "" } else { "gaps == 0 && " };
            self.part(parts::COUNTER, &[("STAT", stat), ("WHEN", when)]);
        }
        for stream in &self.suite.ports.inputs {
            let names = [("IN", &*stream.name)];
            self.part(parts::ALL_TAKEN, &names);
        }
        self.add("    end\n  endtask\n");
    }

    fn process(&mut self) {
        let ports = &self.suite.ports;
        self.add(parts::PROCESS);
        self.part(if ports.idle { "    check_idle;\n" } else { "" }, &[]);
        self.part(parts::RESET, &[]);
        for stream in &ports.inputs {
            self.part(parts::RESET_SOURCE, &[("IN", &stream.name)]);
        }
        let stats = ports.stats.iter();
        let fresh: String = stats
            .map(|(stat, _)| parts::FRESH.replace("@STAT@", stat))
            .collect();
        self.part(parts::BEGIN_JOB, &[("FRESH", &fresh)]);
        for (setting, _) in &ports.settings {
            let _ = writeln!(self.text, "          {setting} <= job_{setting};");
        }
        self.add(parts::CLEAR);
        for (stat, _) in &ports.stats {
            self.part(parts::CLEARED, &[("STAT", stat)]);
        }
        let patience = self.suite.patience.to_string();
        self.part(parts::RUN, &[("PATIENCE", &patience)]);
        let last = if ports.idle { parts::IS_IDLE } else { "" };
        let after = match self.memories.script {
            Some(_) => parts::THEN_SCRIPT,
            None => "            pass;\n",
        };
        self.part(parts::DRAIN, &[("IS_IDLE", last), ("AFTER", after)]);
        for stream in &ports.inputs {
            let names = [("IN", &*stream.name)];
            self.part(parts::OFFER, &names);
        }
        self.part(parts::ACCEPT, &[]);
        for stream in &ports.inputs {
            self.part(parts::RESTART_SOURCE, &[("IN", &stream.name)]);
        }
        self.add("    end\n");
        self.script();
        self.add(parts::END);
    }

    /// Checks the flags, and drives the script, where there is one.
    fn script(&mut self) {
        let Some((file, memory)) = &self.memories.script else {
            return;
        };
        let ports = &self.suite.ports;
        let count = memory.count.to_string();
        self.part(parts::RUN_SCRIPT, &[("FILE", file)]);
        for stream in &ports.inputs {
            let names = [("IN", &*stream.name), ("FILE", file)];
            self.part(parts::SCRIPT_TAKEN, &names);
        }
        self.part(parts::SCRIPT_DRIVES, &[("COUNT", &count)]);
        for (setting, _) in &ports.settings {
            let _ = writeln!(self.text, "      {setting} <= script_{setting};");
        }
        for stream in &ports.inputs {
            let name = &stream.name;
            let _ = writeln!(self.text, "      {name}_tvalid <= script_{name}_tvalid;");
            let field = |(field, bits): &(String, u32)| match is_scripted(field) {
                true => format!("script_{name}_{field}"),
                false => format!("{bits}'d0"),
            };
            let fields: Vec<_> = stream.fields.iter().map(field).collect();
            let fields = common::list(&fields, "        ");
            let _ = writeln!(
                self.text,
                "      {name}_scripted <= {{\n{fields}\n      }};"
            );
        }
        self.part(parts::SCRIPT_STEPS, &[("COUNT", &count)]);
    }
}
