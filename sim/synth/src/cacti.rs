//! Memories by CACTI, an analytical model of memory arrays.

use std::path::{Path, PathBuf};
use std::process::Command;

use potamoi_result_cache as result_cache;
use potamoi_verilated::child;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SynthError;
use super::cache_keys::MemoryInputs;
use super::error::cannot_keep;
use super::scaling::Factors;
use super::tools::{broken, says};
use super::work_folder::WorkFolder;

const PROGRAM: &str = "cacti";
/// The smallest node of CACTI's transistors, wires and cells.
const NODE_NM: u32 = 22;
/// With 16 words CACTI finds no array; with fewer bits, half of the array is periphery.
const LEAST_WORDS: u64 = 32;
const LEAST_BITS: u64 = 1024;
/// Low standby power transistors, as in a mobile system; at 12 nm all memories of the paper's
/// system cycle within 1 ns.
const TRANSISTORS: &str = "itrs-lstp";
/// Temperature, about that of the cell libraries.
const KELVIN: u32 = 300;

/// Words and ports of a memory.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
pub struct Shape {
    /// Words.
    pub words: u64,
    /// Width of a word in bits.
    pub bits: u64,
    /// Read-write ports, one access a cycle each.
    pub read_writes: u64,
    /// Write ports.
    pub writes: u64,
    /// Read ports.
    pub reads: u64,
}

impl Shape {
    fn numbers(&self) -> [u64; 5] {
        // A new field has to be a number.
        let Self {
            words,
            bits,
            read_writes,
            writes,
            reads,
        } = *self;
        [words, bits, read_writes, writes, reads]
    }
}

/// Area, energy and timing of one memory, at 22 nm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Figures {
    /// Area in square micrometres.
    pub area_um2: f64,
    /// Energy of reading a word, in picojoules.
    pub read_pj: f64,
    /// Energy of writing a word, in picojoules.
    pub write_pj: f64,
    /// Leakage in milliwatts.
    pub leakage_mw: f64,
    /// Access time in picoseconds, from the clock edge to the word read.
    pub access_ps: f64,
    /// Cycle time of a port, in picoseconds.
    pub cycle_ps: f64,
}

impl Figures {
    /// Scales to another node.
    #[must_use]
    pub fn scaled(&self, factors: &Factors) -> Self {
        Self {
            area_um2: self.area_um2 * factors.area,
            read_pj: self.read_pj * factors.energy,
            write_pj: self.write_pj * factors.energy,
            leakage_mw: self.leakage_mw * factors.leakage.unwrap_or(1.0),
            access_ps: self.access_ps * factors.delay,
            cycle_ps: self.cycle_ps * factors.delay,
        }
    }
}

/// Settings of the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Settings {
    /// Version of the program, as it reports it.
    pub cacti: String,
    /// Node in nanometres.
    pub node_nm: u32,
    /// Transistors of cells and periphery, by row of the ITRS.
    pub transistors: String,
    /// Temperature in kelvin.
    pub kelvin: u32,
    /// Objective that CACTI minimises.
    pub objective: String,
}

/// An installed CACTI.
#[derive(Debug, Clone)]
pub struct Cacti {
    version: String,
    cache: PathBuf,
}

impl Cacti {
    /// Finds the program; its results are cached in `cache`.
    ///
    /// # Errors
    /// It is missing.
    pub fn find(cache: &Path) -> Result<Self, SynthError> {
        let version = says(PROGRAM, &["--version"])?.filter(|line| line.starts_with("CACTI "));
        match version {
            Some(version) => Ok(Self {
                version,
                cache: cache.to_owned(),
            }),
            None => Err(SynthError::MissingTool {
                tool: PROGRAM,
                disables: "area and energy of memories",
                remedy: "tools/setup memories",
            }),
        }
    }

    /// Settings of its results.
    #[must_use]
    pub fn settings(&self) -> Settings {
        Settings {
            cacti: self.version.clone(),
            node_nm: NODE_NM,
            transistors: TRANSISTORS.to_owned(),
            kelvin: KELVIN,
            objective: "area, of the arrays at most 60 % slower than the fastest".to_owned(),
        }
    }

    /// Models a memory; results are cached.
    ///
    /// # Errors
    /// The memory is too small to be modelled; the program fails or prints output that is not
    /// understood; files cannot be written.
    pub fn model(&self, name: &str, shape: &Shape) -> Result<Figures, SynthError> {
        is_modelled(shape).map_err(|why| SynthError::Memory {
            memory: name.to_owned(),
            why,
        })?;
        let text = configuration(shape);
        let inputs = MemoryInputs {
            cacti: &self.version,
            shape: shape.numbers(),
            configuration: &text,
        };
        std::fs::create_dir_all(&self.cache).map_err(cannot_keep(&self.cache))?;
        let kept = inputs.key().file(&self.cache, "json");
        if let Some(figures) = result_cache::read(&kept) {
            return Ok(figures);
        }
        let folder = WorkFolder::new()?;
        folder.write("memory.cfg", &text)?;
        let input = folder.file("memory.cfg");
        let fail = |said: String| SynthError::Tool {
            tool: PROGRAM,
            unit: name.to_owned(),
            said,
            remedy: "tools/setup memories makes the version that works",
        };
        let mut cacti = Command::new(PROGRAM);
        cacti.args(["-infile".as_ref(), input.as_os_str()]);
        let output =
            child::run(&cacti, child::TO_READ).map_err(|fault| broken(PROGRAM, name, fault))?;
        // It ends well where it refuses, and writes nothing.
        let table = folder.read("memory.cfg.out");
        let table = table.filter(|_| output.status.success());
        let figures = table.as_deref().and_then(read).ok_or_else(|| {
            let text = String::from_utf8_lossy(&output.err);
            let first = text.lines().find(|l| !l.trim().is_empty());
            let said = first.unwrap_or("no array of this size");
            fail(format!("no figures, {}: {said}", output.status))
        })?;
        result_cache::write(&kept, &figures).map_err(cannot_keep(&kept))?;
        Ok(figures)
    }
}

/// Checks that CACTI's results are meaningful for this shape.
pub(super) fn is_modelled(shape: &Shape) -> Result<(), String> {
    let Shape {
        words,
        bits,
        read_writes,
        writes,
        reads,
    } = *shape;
    if words < LEAST_WORDS || words.saturating_mul(bits) < LEAST_BITS {
        return Err(format!(
            "{words} words of {bits} bits: CACTI models {LEAST_WORDS} words and {LEAST_BITS} bits at \
             least"
        ));
    }
    if read_writes + writes == 0 || read_writes + reads == 0 {
        return Err("a memory is both written and read".to_owned());
    }
    Ok(())
}

/// Input of CACTI. Words are rounded up to whole bytes.
fn configuration(shape: &Shape) -> String {
    let bytes = shape.bits.div_ceil(8);
    let mut text = format!(
        "-size (bytes) {}\n\
         -block size (bytes) {bytes}\n\
         -output/input bus width {}\n\
         -read-write port {}\n\
         -exclusive read port {}\n\
         -exclusive write port {}\n\
         -technology (u) {}\n\
         -operating temperature (K) {KELVIN}\n",
        shape.words * bytes,
        8 * bytes,
        shape.read_writes,
        shape.reads,
        shape.writes,
        f64::from(NODE_NM) / 1000.0,
    );
    for part in ["Data", "Tag"] {
        for kind in ["cell", "peripheral"] {
            text += &format!("-{part} array {kind} type - \"{TRANSISTORS}\"\n");
        }
    }
    text + ARRAY + MEMORY_BUS
}

/// A plain array of one bank, without power gating and error correction.
const ARRAY: &str = "\
-single ended read ports 0
-associativity 1
-UCA bank count 1
-cache type \"ram\"
-tag size (b) 0
-page size (bits) 0
-burst length 1
-internal prefetch width 1
-access mode (normal, sequential, fast) - \"normal\"
-design objective (weight delay, dynamic power, leakage power, cycle time, area) 0:0:0:0:100
-deviate (delay, dynamic power, leakage power, cycle time, area) 60:100000:100000:100000:100000
-Optimize ED or ED^2 (ED, ED^2, NONE): \"NONE\"
-Cache model (NUCA, UCA) - \"UCA\"
-NUCA bank count 0
-Wire signaling (fullswing, lowswing, default) - \"Global_30\"
-Wire inside mat - \"semi-global\"
-Wire outside mat - \"semi-global\"
-Interconnect projection - \"conservative\"
-Core count 1
-Add ECC - \"false\"
-Print level (DETAILED, CONCISE) - \"CONCISE\"
-Print input parameters - \"false\"
-Force cache config - \"false\"
-Array Power Gating - \"false\"
-WL Power Gating - \"false\"
-CL Power Gating - \"false\"
-Bitline floating - \"false\"
-Interconnect Power Gating - \"false\"
-Power Gating Performance Loss 0.01
";

/// Bus to memory modules, which no array has; CACTI requires one nevertheless.
const MEMORY_BUS: &str = "\
-dram_type \"DDR3\"
-io state \"WRITE\"
-addr_timing 1.0
-mem_density 4 Gb
-bus_freq 800 MHz
-duty_cycle 1.0
-activity_dq 1.0
-activity_ca 0.5
-num_dq 72
-num_dqs 18
-num_ca 25
-num_clk 2
-num_mem_dq 2
-mem_data_width 8
-rtt_value 10000
-ron_value 34
-tflight_value
-num_bobs 1
-capacity 80
-num_channels_per_bob 1
-first metric \"Cost\"
-second metric \"Bandwidth\"
-third metric \"Energy\"
-DIMM model \"ALL\"
-mirror_in_bob \"F\"
";

/// Reads the table to which CACTI appends a line: names, then values.
fn read(table: &str) -> Option<Figures> {
    let mut lines = table.lines().filter(|l| !l.trim().is_empty());
    let names: Vec<&str> = lines.next()?.split(',').map(str::trim).collect();
    let values: Vec<&str> = lines.next()?.split(',').map(str::trim).collect();
    let value = |name: &str, scale: f64| {
        let at = names.iter().position(|n| *n == name)?;
        let value: f64 = values.get(at)?.parse().ok()?;
        (value.is_finite() && value > 0.0).then_some(value * scale)
    };
    Some(Figures {
        area_um2: value("Area (mm2)", 1e6)?,
        read_pj: value("Dynamic read energy (nJ)", 1e3)?,
        write_pj: value("Dynamic write energy (nJ)", 1e3)?,
        leakage_mw: value("Standby leakage per bank(mW)", 1.0)?,
        access_ps: value("Access time (ns)", 1e3)?,
        cycle_ps: value("Random cycle time (ns)", 1e3)?,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const BANK: Shape = Shape {
        words: 1024,
        bits: 16,
        read_writes: 0,
        writes: 1,
        reads: 2,
    };

    /// Output of CACTI 7.0 for a bank of the paper's unit.
    const TABLE: &str = include_str!("fixtures/mft_bank.cfg.out");

    #[test]
    fn the_table_is_read_by_its_names() {
        let figures = read(TABLE).unwrap();
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
        assert!(near(figures.area_um2, 5634.56), "{figures:?}");
        assert!(near(figures.read_pj, 0.574946), "{figures:?}");
        assert!(near(figures.write_pj, 0.621853), "{figures:?}");
        assert!(near(figures.leakage_mw, 0.000793593), "{figures:?}");
        assert!(near(figures.access_ps, 695.021), "{figures:?}");
        assert!(near(figures.cycle_ps, 540.837), "{figures:?}");
        let names = TABLE.lines().next().unwrap();
        assert_eq!(read(names), None);
        assert_eq!(read(&TABLE.replace("Area (mm2)", "Area")), None);
        assert_eq!(read(&TABLE.replace("0.000574946", "N/A")), None);
        assert_eq!(read(&TABLE.replace("0.000574946", "-1")), None);
        assert_eq!(read(""), None);
    }

    #[test]
    fn what_cannot_be_modelled_is_refused() {
        assert_eq!(is_modelled(&BANK), Ok(()));
        for (shape, said) in [
            (Shape { words: 16, ..BANK }, "16 words of 16 bits"),
            (
                Shape {
                    words: 8,
                    bits: 1059,
                    ..BANK
                },
                "8 words of 1059 bits",
            ),
            (Shape { words: 32, ..BANK }, "1024 bits at least"),
            (Shape { writes: 0, ..BANK }, "both written and read"),
            (Shape { reads: 0, ..BANK }, "both written and read"),
        ] {
            let why = is_modelled(&shape).unwrap_err();
            assert!(why.contains(said), "{why}");
        }
        let one = Shape {
            read_writes: 1,
            writes: 0,
            reads: 0,
            ..BANK
        };
        assert_eq!(is_modelled(&one), Ok(()));
    }

    #[test]
    fn words_are_whole_bytes() {
        let text = configuration(&Shape { bits: 13, ..BANK });
        assert!(
            text.contains("-size (bytes) 2048\n-block size (bytes) 2\n"),
            "{text}"
        );
        assert!(
            text.contains("-exclusive read port 2\n-exclusive write port 1\n"),
            "{text}"
        );
        assert!(text.contains("-technology (u) 0.022\n"), "{text}");
    }
}
