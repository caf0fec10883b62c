//! The standalone bench as a judge.

use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use potamoi_formats::config::Config;
use potamoi_formats::units::{GATHERING_UNIT, NPU_EXT, VECTOR_UNIT};
use potamoi_rtl::bench::{RUNS, standalone};
use potamoi_verilated::child;
use tempfile::TempDir;

use crate::tools::{broken, no_result, succeed, text, write};
use crate::{Design, MutateError};

/// Time limit of one run of the bench.
const LIMIT: Duration = Duration::from_secs(60);

/// The bench of a unit, compiled with all mutants.
pub(crate) struct Bench {
    _folder: TempDir,
    sim: PathBuf,
    program: PathBuf,
    unit: String,
}

impl Bench {
    /// Compiles the bench, and runs it without a fault.
    pub(crate) fn new(config: &Config, design: &Design) -> Result<Self, MutateError> {
        let unit = design.unit.name.clone();
        let folder = tempfile::tempdir().map_err(|error| MutateError::File {
            path: std::env::temp_dir(),
            error,
        })?;
        let sim = folder.path().join("sim");
        // The bench of the SoC top has the jobs of both units.
        let benches: &[&str] = match &*unit {
            NPU_EXT => &[GATHERING_UNIT, VECTOR_UNIT, NPU_EXT],
            own => &[own],
        };
        for (name, text) in standalone(config, benches, "")? {
            write(&sim.join(name), &text)?;
        }
        for (name, text) in design.verilog(0)? {
            write(&folder.path().join(&unit).join(name), &text)?;
        }
        let mut make = Command::new("make");
        make.arg("-C").arg(&sim);
        make.args(["SIM=verilator", "RUNS=0:1"]);
        make.arg(format!("UNITS={unit}"));
        // All modules are in the folder of the unit.
        make.arg(format!("PARTS_{unit}="));
        succeed(&make, "make", &unit)?;
        let program = sim.join(format!("build/{unit}/V{unit}_tb"));
        let bench = Self {
            _folder: folder,
            sim,
            program,
            unit,
        };
        match bench.judge(0)? {
            None => Ok(bench),
            Some([_, said]) => Err(MutateError::Unmutated("bench", bench.unit, said)),
        }
    }

    /// The run in which the bench finds a mutant, and what it says.
    pub(crate) fn judge(&self, mutant: usize) -> Result<Option<[String; 2]>, MutateError> {
        for run in RUNS.split_whitespace() {
            let (gaps, seed) = run.split_once(':').unwrap_or((run, "1"));
            // The model ends by a signal where the bench fails: the shell makes a status of it.
            let mut command = Command::new("sh");
            command.current_dir(&self.sim);
            command
                .args(["-c", "\"$0\" \"$@\"; exit $?"])
                .arg(&self.program);
            command.args(["+verilator+rand+reset+2", "+verilator+seed+1"]);
            command.args([
                format!("+mutant={mutant}"),
                format!("+gaps={gaps}"),
                format!("+seed={seed}"),
            ]);
            let what = format!("{} with mutant {mutant}", self.unit);
            let done = child::run(&command, LIMIT).map_err(|e| broken("the bench", &what, e))?;
            let said = text(&done);
            let fail = said.lines().find(|line| line.contains("FAIL: "));
            match (done.status.success(), fail) {
                (true, None) => {}
                (false, Some(line)) => return Ok(Some([run.to_owned(), line.trim().to_owned()])),
                _ => return Err(no_result("the bench", &what, &said)),
            }
        }
        Ok(None)
    }
}
