//! `$readmemh` files of a trace with testbenches, for simulators that this crate does not drive.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use potamoi_cycles::{BeatWords, Exponents, GatherWork};
use potamoi_formats::config::Config;
use potamoi_formats::units::{GATHERING_UNIT, VECTOR_UNIT};
use potamoi_reference::trace_recorder::{Computed, Gathered};
use serde::Serialize;

use super::gather_check::Expected;
use super::model::RtlError;
use super::vector_drive::{VectorBatch, Vectors};

/// Description of one memory file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct MemoryFile {
    /// Width of a word in bits.
    pub width: u32,
    /// Number of words.
    pub count: usize,
    /// Fields of a word with their widths, highest first.
    pub fields: Vec<(&'static str, u32)>,
}

/// Generated files.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadmemhFiles {
    /// Text of every file by name: memories and testbenches.
    pub texts: BTreeMap<String, String>,
    /// Description of every memory file by name.
    pub memories: BTreeMap<String, MemoryFile>,
}

/// A memory under construction.
struct Memory {
    fields: Vec<(&'static str, u32)>,
    text: String,
    count: usize,
}

impl Memory {
    fn new(fields: &[(&'static str, u32)]) -> Self {
        Self {
            fields: fields.to_vec(),
            text: String::new(),
            count: 0,
        }
    }

    fn width(&self) -> u32 {
        self.fields.iter().map(|f| f.1).sum()
    }

    /// Appends a word; `values` are the fields' words, low first, highest field first.
    fn push(&mut self, values: &[&[u32]]) {
        let width = self.width();
        let mut word = vec![0u32; width.div_ceil(32) as usize];
        let mut at = width;
        for ((_, bits), value) in self.fields.iter().zip(values) {
            at -= bits;
            for i in 0..*bits {
                let bit = value
                    .get((i / 32) as usize)
                    .map_or(0, |w| w >> (i % 32) & 1);
                word[((at + i) / 32) as usize] |= bit << ((at + i) % 32);
            }
        }
        let digits: String = word.iter().rev().map(|w| format!("{w:08x}")).collect();
        let keep = width.div_ceil(4) as usize;
        self.text.push_str(&digits[digits.len() - keep..]);
        self.text.push('\n');
        self.count += 1;
    }

    fn save(self, name: &str, files: &mut ReadmemhFiles) {
        let file = MemoryFile {
            width: self.width(),
            count: self.count,
            fields: self.fields,
        };
        files.texts.insert(name.to_owned(), self.text);
        files.memories.insert(name.to_owned(), file);
    }
}

/// Streams of a trace and expected outputs, with testbenches. Only gathering tasks of the first
/// one's kind are included.
///
/// # Errors
/// Tasks that the units cannot take.
pub fn readmemh(
    config: &Config,
    gathered: &[Gathered],
    computed: &[Computed],
) -> Result<ReadmemhFiles, RtlError> {
    let mut files = ReadmemhFiles::default();
    if let Some(first) = gathered.first() {
        let kind = |g: &&Gathered| {
            (g.task.vertices, g.task.channels) == (first.task.vertices, first.task.channels)
        };
        let same: Vec<_> = gathered.iter().take_while(kind).collect();
        let tasks: Vec<_> = same.iter().map(|g| g.task.clone()).collect();
        let features: Vec<i32> = same.iter().flat_map(|g| &g.features).copied().collect();
        let work = GatherWork::new(config, &tasks)?;
        work.run().check(config)?;
        gather(config, &work, &features, &mut files)?;
    }
    if !computed.is_empty() {
        vector(config, computed, &mut files)?;
    }
    Ok(files)
}

fn gather(
    config: &Config,
    work: &GatherWork<'_>,
    features: &[i32],
    files: &mut ReadmemhFiles,
) -> Result<(), RtlError> {
    let (width, side) = (work.width() as u32, work.side() as u32);
    let stream = config.rit_stream_bits();
    let run = work.run();
    let mut layout = BeatWords::new(work);
    let mut rit = Memory::new(&[
        ("tuser", 1),
        ("tlast", 1),
        ("tkeep", stream / 8),
        ("tdata", stream),
    ]);
    for piece in run.rit_beats(config) {
        layout.rit(&piece)?;
        let (user, last) = (u32::from(piece.beat.again), u32::from(piece.beat.last));
        rit.push(&[&[user], &[last], &layout.keep, &layout.data]);
    }
    let banks = config.gu.banks;
    let feature_major = work.lane_run().is_some();
    let mut fields = vec![("tlast", 1), ("tdata", 16 * banks)];
    if feature_major {
        fields.insert(1, ("tkeep", 2 * banks));
    }
    let mut mft = Memory::new(&fields);
    for piece in work.mft_pieces(config) {
        layout.mft(&piece);
        let last = [u32::from(piece.last)];
        if feature_major {
            mft.push(&[&last, &layout.row_keep, &layout.row]);
        } else {
            mft.push(&[&last, &layout.row]);
        }
    }
    let slot_bits = config.rit.slot_bits;
    let lane = work.lane_bytes() as u32;
    let mut feat = Memory::new(&[
        ("tlast", 1),
        ("tkeep", lane * width * side),
        ("tuser", slot_bits * side),
        ("tdata", 8 * lane * width * side),
    ]);
    for group in work.groups() {
        let beat = Expected::new(work, features, group);
        let mut user = vec![0u32; (slot_bits * side).div_ceil(32) as usize];
        for port in 0..group.kept {
            let slot = work.tasks()[group.task].entries[group.entry + port].slot;
            if slot_bits == 32 {
                user[port] = slot;
            } else {
                user[port / 2] |= (slot & 0xffff) << (16 * (port % 2));
            }
        }
        let last = u32::from(group.last);
        feat.push(&[&[last], &beat.keep, &user, &beat.data]);
    }
    let mut settings = format!(
        "    .cfg_vertices({}), .cfg_segments({}), .cfg_clear(1'b0),\n",
        sized(2, u64::from(work.vertices().log2())),
        sized(7, work.segments() as u64)
    );
    if config.gu.records_a_row == 2 {
        let two = sized(1, u64::from(work.shares_rows()));
        settings += &format!("    .cfg_two_records({two}),\n");
    }
    if feature_major {
        let channels = sized(7, work.last_channels() as u64);
        settings += &format!("    .cfg_channels({channels}),\n");
    }
    let bench = Bench {
        unit: GATHERING_UNIT,
        inputs: vec![
            ("s_axis_rit", "gather_rit.hex", &rit),
            ("s_axis_mft", "gather_mft.hex", &mft),
        ],
        output: ("m_axis_feat", "gather_feat.hex", &feat),
        lane_bits: 8,
        tag_bits: Some((lane * width, slot_bits)),
        settings,
    };
    let text = bench.text();
    files.texts.insert(format!("{GATHERING_UNIT}_tb.v"), text);
    rit.save("gather_rit.hex", files);
    mft.save("gather_mft.hex", files);
    feat.save("gather_feat.hex", files);
    Ok(())
}

fn vector(
    config: &Config,
    computed: &[Computed],
    files: &mut ReadmemhFiles,
) -> Result<(), RtlError> {
    let lanes = config.vu.lanes;
    let batches: Vec<_> = computed
        .iter()
        .map(|c| VectorBatch {
            op: c.op,
            a: &c.a,
            b: &c.b,
        })
        .collect();
    let results: Vec<i32> = computed.iter().flat_map(|c| c.out.clone()).collect();
    let vectors = Vectors::new(&batches, lanes as usize, &Exponents::of(config))?;
    let mut given = Memory::new(&[
        ("tuser", 12),
        ("tlast", 1),
        ("tkeep", lanes),
        ("tdata", 64 * lanes),
    ]);
    let mut wanted = Memory::new(&[("tlast", 1), ("tkeep", lanes), ("tdata", 32 * lanes)]);
    for v in &vectors.list {
        let mut data = vec![0u32; 2 * lanes as usize];
        let mut keep = vec![0u32; lanes.div_ceil(32) as usize];
        for (i, (a, b)) in v.a.iter().zip(v.b).enumerate() {
            data[2 * i] = *a as u32;
            data[2 * i + 1] = *b as u32;
            keep[i / 32] |= 1 << (i % 32);
        }
        let out = results.get(v.ordinal..v.ordinal + v.a.len());
        let out: Vec<u32> = out.unwrap_or_default().iter().map(|y| *y as u32).collect();
        let last = u32::from(v.last);
        given.push(&[&[u32::from(v.op.field())], &[last], &keep, &data]);
        wanted.push(&[&[last], &keep, &out]);
    }
    let bench = Bench {
        unit: VECTOR_UNIT,
        inputs: vec![("s_axis_vec", "vector_in.hex", &given)],
        output: ("m_axis_vec", "vector_out.hex", &wanted),
        lane_bits: 32,
        tag_bits: None,
        settings: "    .cfg_clear(1'b0),\n".to_owned(),
    };
    let text = bench.text();
    files.texts.insert(format!("{VECTOR_UNIT}_tb.v"), text);
    given.save("vector_in.hex", files);
    wanted.save("vector_out.hex", files);
    Ok(())
}

fn sized(bits: u32, value: u64) -> String {
    format!("{bits}'d{value}")
}

/// A testbench with sources that are always valid and a sink that is always ready.
struct Bench<'a> {
    unit: &'static str,
    inputs: Vec<(&'static str, &'static str, &'a Memory)>,
    output: (&'static str, &'static str, &'a Memory),
    /// Bits of `tdata` for each bit of `tkeep`.
    lane_bits: u32,
    /// Bits of `tkeep` and of `tuser` for each port, if there is a `tuser`.
    tag_bits: Option<(u32, u32)>,
    settings: String,
}

impl Bench<'_> {
    /// The testbench's text.
    fn text(&self) -> String {
        let mut t = String::new();
        let unit = self.unit;
        let _ = writeln!(
            t,
            "// Testbench of {unit}, without any tool but a Verilog-2005 simulator:\n\
             //   potamoi emit --out-dir rtl\n\
             //   iverilog -g2005 -o {unit}_tb {unit}_tb.v rtl/{unit}/*.v && vvp {unit}_tb\n\
             // Run it in the folder of the .hex files. The last line is PASS or FAIL.\n\
             `timescale 1ns/1ps\n`default_nettype none\n\nmodule {unit}_tb;\n  \
             reg clk = 1'b0;\n  always #5 clk = ~clk;\n  reg rst_n = 1'b0;\n  \
             initial begin\n    repeat (3) @(posedge clk);\n    #1 rst_n = 1'b1;\n  end\n  \
             integer cycles = 0;\n  integer errors = 0;\n  integer idle = 0;"
        );
        for (port, file, memory) in self.inputs.iter().chain([&self.output]) {
            let _ = writeln!(
                t,
                "\n  // {port}: {}\n  reg [{}:0] {port}_words [0:{}];\n  initial $readmemh(\"{file}\", {port}_words);\n  \
                 integer {port}_at = 0;",
                memory
                    .fields
                    .iter()
                    .map(|(name, bits)| format!("{name} {bits}"))
                    .collect::<Vec<_>>()
                    .join(", "),
                memory.width() - 1,
                memory.count - 1
            );
        }
        for (port, _, memory) in &self.inputs {
            let _ = writeln!(
                t,
                "  wire {port}_tvalid = rst_n && {port}_at < {};\n  wire {port}_tready;",
                memory.count
            );
            for (name, bits) in &memory.fields {
                let _ = writeln!(t, "  wire [{}:0] {port}_{name};", bits - 1);
            }
            let names: Vec<_> = memory
                .fields
                .iter()
                .map(|f| format!("{port}_{}", f.0))
                .collect();
            let _ = writeln!(
                t,
                "  assign {{{}}} = {port}_words[{port}_at];",
                names.join(", ")
            );
        }
        let (port, _, memory) = &self.output;
        let _ = writeln!(t, "  wire {port}_tvalid;");
        for (name, bits) in &memory.fields {
            let _ = writeln!(
                t,
                "  wire [{}:0] {port}_{name};\n  wire [{}:0] wanted_{name};",
                bits - 1,
                bits - 1
            );
        }
        let names: Vec<_> = memory
            .fields
            .iter()
            .map(|f| format!("wanted_{}", f.0))
            .collect();
        let _ = writeln!(
            t,
            "  assign {{{}}} = {port}_words[{port}_at];",
            names.join(", ")
        );
        let _ = writeln!(t, "\n  {unit} unit (\n    .clk(clk), .rst_n(rst_n),");
        t.push_str(&self.settings);
        for (port, _, memory) in &self.inputs {
            let _ = writeln!(
                t,
                "    .{port}_tvalid({port}_tvalid), .{port}_tready({port}_tready),"
            );
            for (name, _) in &memory.fields {
                let _ = writeln!(t, "    .{port}_{name}({port}_{name}),");
            }
        }
        for (name, _) in &memory.fields {
            let _ = writeln!(t, "    .{port}_{name}({port}_{name}),");
        }
        let _ = writeln!(
            t,
            "    .{port}_tvalid({port}_tvalid), .{port}_tready(rst_n)\n  );\n"
        );
        self.check(&mut t);
        t
    }

    fn check(&self, t: &mut String) {
        let (port, _, memory) = &self.output;
        let lanes = memory
            .fields
            .iter()
            .find(|f| f.0 == "tkeep")
            .map_or(0, |f| f.1);
        let count = memory.count;
        let _ = writeln!(
            t,
            "  integer lane;\n  reg wrong;\n  always @(posedge clk) if (rst_n) begin\n    \
             cycles = cycles + 1;\n    idle = idle + 1;"
        );
        for (input, _, _) in &self.inputs {
            let _ = writeln!(
                t,
                "    if ({input}_tvalid && {input}_tready) begin\n      {input}_at <= {input}_at + 1;\n      idle = 0;\n    end"
            );
        }
        let bits = self.lane_bits;
        let _ = writeln!(
            t,
            "    if ({port}_tvalid === 1'b1) begin\n      idle = 0;\n      \
             wrong = {port}_tlast !== wanted_tlast || {port}_tkeep !== wanted_tkeep;\n      \
             for (lane = 0; lane < {lanes}; lane = lane + 1) if (wanted_tkeep[lane]) begin\n        \
             if ({port}_tdata[{bits}*lane +: {bits}] !== wanted_tdata[{bits}*lane +: {bits}]) wrong = 1'b1;"
        );
        if let Some((keep, tag)) = self.tag_bits {
            let _ = writeln!(
                t,
                "        if ({port}_tuser[{tag}*(lane/{keep}) +: {tag}] !== wanted_tuser[{tag}*(lane/{keep}) +: {tag}]) wrong = 1'b1;"
            );
        }
        let _ = writeln!(
            t,
            "      end\n      if (wrong) begin\n        errors = errors + 1;\n        \
             $display(\"cycle %0d: beat %0d differs\", cycles, {port}_at);\n      end\n      \
             {port}_at <= {port}_at + 1;\n      if ({port}_at == {}) begin\n        \
             if (errors == 0) $display(\"PASS: {count} beats in %0d cycles\", cycles);\n        \
             else $display(\"FAIL: %0d of {count} beats differ\", errors);\n        $finish;\n      \
             end\n    end\n    if (idle > 100000) begin\n      \
             $display(\"FAIL: nothing moved for 100000 cycles after beat %0d\", {port}_at);\n      \
             $finish;\n    end\n  end\nendmodule\n`default_nettype wire",
            count - 1
        );
    }
}
