//! The fair bench: one frozen list of inputs, one counted trace a frame, and machines, GPUs and published accelerators
//! as configurations over it.

mod frozen;
mod records;
mod subtiles;
#[cfg(test)]
mod tests;
mod traced;

use potamoi_explore::Progress;
use potamoi_gpu::Device;
use potamoi_rivals::{Check, Estimate, Rival, Trace, Verdict};
use potamoi_scene::Scene;
use potamoi_system::system_model::{AtBounds, GpuOnly};
use schemars::JsonSchema;
use serde::Serialize;

use crate::comparison::Row;
use crate::machine::{Machine, MachineError};
use crate::workbench::Workbench;
use crate::workload::Workload;

pub use frozen::{FrozenInput, FrozenInputs};
pub use traced::Traced;

/// GPUs that publications of rivals stand beside.
const GPUS: [&str; 2] = ["xavier-nx", "3090"];

/// A GPU alone.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct GpuRow {
    /// The device.
    pub device: String,
    /// The program.
    pub program: &'static str,
    /// Frames a second at both bounds of its kernels.
    pub frames_per_second: AtBounds<f64>,
    /// Millijoules a frame at its power limit.
    pub mj: AtBounds<f64>,
}

/// A rival: its time, or why it has none.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RivalRow {
    /// Its name, that of its file.
    pub rival: String,
    /// What it takes.
    pub estimate: Option<Estimate>,
    /// Why it takes nothing.
    pub refused: Option<String>,
}

/// All machines on an input.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Input {
    /// The scene.
    pub scene: String,
    /// Its algorithm.
    pub algorithm: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The counted work of the frame.
    pub trace: Trace,
    /// Its digest.
    pub digest: String,
    /// The digest of the frozen list; none of an input that the user adds.
    pub frozen: Option<String>,
    /// Machines of this project.
    pub machines: Vec<Row>,
    /// GPUs alone.
    pub gpus: Vec<GpuRow>,
    /// Rivals.
    pub rivals: Vec<RivalRow>,
}

impl Input {
    /// Whether the trace is that of the frozen list; true of an input that the user adds.
    #[must_use]
    pub fn is_as_frozen(&self) -> bool {
        self.frozen.as_ref().is_none_or(|own| *own == self.digest)
    }
}

/// A rival with its checks.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Checked {
    /// The rival with all its constants.
    pub rival: Rival,
    /// Its published figures, computed again.
    pub checks: Vec<Check>,
    /// Whether it is validated.
    pub verdict: Verdict,
}

/// The bench with its results.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct FairBench {
    /// Frames of the path whose middle the frame is.
    pub frames: u32,
    /// Rivals.
    pub rivals: Vec<Checked>,
    /// Inputs in order.
    pub inputs: Vec<Input>,
}

/// A scene of the bench, with the digest that its trace is to have.
pub struct BenchScene {
    /// The scene in its size.
    pub scene: Scene,
    /// The digest, of the frozen list.
    pub digest: Option<String>,
}

impl FairBench {
    /// Evaluates machines, GPUs and all rivals on scenes.
    ///
    /// # Errors
    /// A scene that no bench can count; a file of a rival that is not as it has to be.
    pub fn of(
        machines: &[Machine],
        scenes: &[BenchScene],
        frames: u32,
        progress: &dyn Progress,
    ) -> Result<Self, MachineError> {
        let bench = Workbench::default();
        let rivals = checked()?;
        progress.expect((scenes.len() * (machines.len() + 1)) as u64);
        let workload = Workload {
            frames,
            quality: false,
            ..Workload::default()
        };
        let each = scenes.iter().map(|own| {
            progress.now(own.scene.name());
            let traced = bench.traced(&own.scene, &workload)?;
            progress.advance(1);
            let rows = machines.iter().map(|machine| {
                let found = bench.figures(machine, &own.scene, &workload, &());
                progress.advance(1);
                match found {
                    Ok(figures) => Row::Figures(Box::new(figures)),
                    Err(error) => Row::Refused {
                        machine: machine.name.clone(),
                        scene: own.scene.name().to_owned(),
                        refused: error.to_string(),
                    },
                }
            });
            let digest = traced.trace.digest();
            let camera = own.scene.camera();
            Ok(Input {
                scene: own.scene.name().to_owned(),
                algorithm: traced.path.algorithm.clone(),
                size: [camera.width, camera.height],
                machines: rows.collect(),
                gpus: gpus(machines, &traced)?,
                rivals: rivals
                    .iter()
                    .map(|own| row(&own.rival, &traced.trace))
                    .collect(),
                frozen: own.digest.clone(),
                digest,
                trace: traced.trace,
            })
        });
        let inputs = each.collect::<Result<_, MachineError>>()?;
        Ok(Self {
            frames,
            rivals,
            inputs,
        })
    }
}

fn wrong(problem: impl ToString) -> MachineError {
    MachineError::Bench {
        problem: problem.to_string(),
    }
}

/// All rivals with their checks.
fn checked() -> Result<Vec<Checked>, MachineError> {
    let all = Rival::all().map_err(wrong)?;
    let each = all.into_iter().map(|rival| {
        Ok(Checked {
            checks: rival.checks().map_err(wrong)?,
            verdict: rival.verdict().map_err(wrong)?,
            rival,
        })
    });
    each.collect()
}

fn row(rival: &Rival, trace: &Trace) -> RivalRow {
    let found = Estimate::of(rival, trace);
    let (estimate, refused) = match found {
        Ok(own) => (Some(own), None),
        Err(error) => (None, Some(error.to_string())),
    };
    RivalRow {
        rival: rival.name.clone(),
        estimate,
        refused,
    }
}

/// The machines' GPUs alone, and those beside the rivals.
fn gpus(machines: &[Machine], traced: &Traced) -> Result<Vec<GpuRow>, MachineError> {
    let mut devices: Vec<Device> = vec![];
    for machine in machines {
        devices.push(machine.system.gpu.device.clone());
    }
    for name in GPUS {
        devices.push(Device::builtin(name).map_err(wrong)?);
    }
    let mut rows: Vec<GpuRow> = vec![];
    for device in devices {
        if rows.iter().any(|own| own.device == device.name) {
            continue;
        }
        let alone = GpuOnly::of(&device, &traced.path);
        for own in std::iter::once(alone.fused).chain(alone.published) {
            rows.push(GpuRow {
                device: device.name.clone(),
                program: own.program,
                frames_per_second: own.frame_ns.map(|ns| 1e9 / ns),
                mj: own.frame_ns.map(|ns| device.watts * ns * 1e-6),
            });
        }
    }
    Ok(rows)
}
