//! What the benches of the units and of the SoC top have in common.

use std::fmt::Write as _;

use super::memory::Memory;

/// Options of a simulation, in a process that goes on with [`read_memory`].
pub(super) const OPTIONS: &str = r#"
  // Options, and memory files that are missing or have too few words.
  integer file;
  reg [8*256-1:0] dump;
  initial begin
    if (!$value$plusargs("gaps=%d", gaps)) gaps = 0;
    if (!$value$plusargs("seed=%d", seed)) seed = 1;
    if (gaps < 0 || gaps > 95) begin
      $display("FAIL: +gaps=%0d: expected 0 to 95", gaps);
      fail;
    end
    drawn = after(32'h9e3779b9 ^ (seed << 4)) | 32'd1;
    if (gaps > 0) cut = 20 + drawn[13:8];
    if ($value$plusargs("dump=%s", dump)) begin
      $dumpfile(dump);
      $dumpvars;
    end else if ($test$plusargs("dump")) begin
      $dumpvars;
    end
"#;

const FILE: &str = r#"    file = $fopen("@FILE@", "r");
    if (file == 0) begin
      if (!failed) $display("FAIL: @FILE@ is missing: run in the folder of the .hex files");
      fail;
    end else begin
      $fclose(file);
      $readmemh("@FILE@", @NAME@_words);
      if (^@NAME@_words[@LAST@] === 1'bx) begin
        if (!failed) $display("FAIL: @FILE@ has fewer words than this bench reads");
        fail;
      end
    end
"#;

/// Statements that read a memory from a file, and end the simulation where it is missing or too short.
pub(super) fn read_memory(name: &str, file: &str, memory: &Memory) -> String {
    FILE.replace("@NAME@", name)
        .replace("@FILE@", file)
        .replace("@LAST@", &(memory.count.max(1) - 1).to_string())
}

/// Declares a memory with a comment that names its fields.
pub(super) fn declare_memory(text: &mut String, name: &str, file: &str, memory: &Memory) {
    let fields: Vec<_> = memory
        .fields
        .iter()
        .map(|(f, w)| format!("{f} {w}"))
        .collect();
    let _ = writeln!(
        text,
        "{}\n  reg [{}:0] {name}_words [0:{}];",
        comment(&format!("{name}, from {file}: {}", fields.join(", "))),
        memory.width() - 1,
        memory.count.max(1) - 1
    );
}

/// Declares a wire for each field, cut from a word.
pub(super) fn cut(text: &mut String, before: &str, fields: &[(String, u32)], of: &str) {
    for (field, bits) in fields {
        let _ = writeln!(text, "  wire [{}:0] {before}_{field};", bits - 1);
    }
    let names: Vec<_> = fields
        .iter()
        .map(|(f, _)| format!("{before}_{f}"))
        .collect();
    let _ = writeln!(
        text,
        "  assign {{\n{}\n    }} = {of};",
        list(&names, "      ")
    );
}

/// A comment of several lines.
pub(super) fn comment(text: &str) -> String {
    let mut lines = vec![String::from("\n  //")];
    for word in text.split(' ') {
        if lines
            .last()
            .is_some_and(|line| line.len() + word.len() > 98)
        {
            lines.push(String::from("  //"));
        }
        if let Some(line) = lines.last_mut() {
            line.push(' ');
            line.push_str(word);
        }
    }
    lines.join("\n")
}

/// Names with commas, several a line.
pub(super) fn list(names: &[String], indent: &str) -> String {
    let mut lines = vec![indent.to_owned()];
    for (i, name) in names.iter().enumerate() {
        let item = format!("{name}{}", if i + 1 < names.len() { ", " } else { "" });
        if lines
            .last()
            .is_some_and(|line| line.len() + item.len() > 98)
        {
            lines.push(indent.to_owned());
        }
        if let Some(line) = lines.last_mut() {
            line.push_str(&item);
        }
    }
    let lines: Vec<_> = lines.iter().map(|line| line.trim_end()).collect();
    lines.join("\n")
}
