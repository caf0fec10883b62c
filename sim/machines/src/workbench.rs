//! Figures of many machines on scenes; what they have in common is counted once.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use potamoi_explore::{Progress, Setup, Shared};
use potamoi_scene::Scene;
use potamoi_system::system_model::work::{PathOptions, PathParts};
use potamoi_system::system_model::{Frames, GpuOnly, Scenario, Unknown};

use crate::figures::{Figures, Timed, alone};
use crate::machine::{Machine, MachineError};
use crate::quality::{References, identity_of};
use crate::workload::{Fidelity, Workload};

/// Targets of a reference where a machine warps and names no window.
pub const WINDOW: u32 = 16;

/// Figures of machines; threads may share it.
#[derive(Default)]
pub struct Workbench {
    shared: Shared,
    references: References,
    prepared: Mutex<HashMap<(blake3::Hash, String), Scene>>,
}

impl Workbench {
    /// The figures of a machine on a scene.
    ///
    /// # Errors
    /// A scene that the machine cannot render, a variant that the workload's method does not have.
    pub fn figures(
        &self,
        machine: &Machine,
        plain: &Scene,
        workload: &Workload,
        progress: &dyn Progress,
    ) -> Result<Figures, MachineError> {
        let scene = self.prepared(machine, plain)?;
        let hardware = machine.hardware_for(&scene)?;
        let system = &machine.system;
        let variant = machine.path.variant();
        if workload.fidelity == Fidelity::Demand && variant.frames != Frames::Full {
            return Err(MachineError::Demand {
                name: machine.name.clone(),
                variant: variant.name,
            });
        }
        let mut setup = Setup::sharing(hardware, system, scene, machine.syntheses(), &self.shared)?;
        let options = options(machine, workload);
        let (path, _) = setup.count(&options, progress)?;
        let model = setup.model();
        let timed = match workload.fidelity {
            Fidelity::Demand => Timed::by_demand(&model.demand(path.full(0), variant.gathering)),
            Fidelity::Schedule => {
                let (outcome, _) = model
                    .run(&path, variant, Scenario::Local)
                    .map_err(potamoi_explore::ExploreError::from)?;
                Timed::scheduled(&outcome)
            }
        };
        let quality = match workload.quality {
            true => Some(self.references.frame(&setup, plain)?.along(&path, variant)),
            false => None,
        };
        let (clock, area) = (&setup.costs().clock, setup.area());
        Ok(Figures {
            machine: machine.name.clone(),
            preset: setup.preset,
            gpu: system.gpu.device.name.clone(),
            memory: (system.memory.name.clone(), system.memory_channels),
            array: [system.array_rows, system.array_columns],
            buffer_bytes: [system.feature_buffer_bytes, system.weight_buffer_bytes],
            scene: path.scene.clone(),
            algorithm: path.algorithm.clone(),
            size: path.size,
            frames: workload.frames,
            variant: variant.name,
            fidelity: workload.fidelity,
            clock_ghz: clock.ghz,
            clock_origin: clock.origin,
            reached_ghz: clock.reached_ghz,
            clock_bound_by: clock.blocks.first().map(|own| own.block.to_string()),
            frames_per_second: timed.frames_per_second,
            free_units_frames_per_second: timed.free_units,
            gpu_alone_frames_per_second: alone(&GpuOnly::of(&system.gpu.device, &path)),
            bottleneck: timed.bottleneck,
            mj: timed.mj(),
            gpu_mj: timed.gpu_mj(),
            accelerator_mj: timed.accelerator_mj(),
            memory_mj: timed.memory_mj(),
            units_mm2: area.units_mm2,
            mm2: area.total_mm2,
            blocks: area.blocks.clone(),
            unknown: unknown(&setup),
            quality,
        })
    }
}

/// Blocks whose energy or area is not known.
fn unknown(setup: &Setup) -> Vec<Unknown> {
    let mut all = setup.costs().unknown.clone();
    for own in setup.area().blocks.iter().filter(|own| own.mm2().is_none()) {
        let block = own.block.replace('_', " ");
        // Where its energy is not known either, the reason is the same.
        if all.iter().all(|known| known.block != block) {
            let why = format!("its area: {}", own.from);
            all.push(Unknown { block, why });
        }
    }
    all
}

impl Workbench {
    /// What setups share.
    pub(crate) fn shared(&self) -> &Shared {
        &self.shared
    }

    /// Names of the files in the folder for counted work that a machine's figures on a scene are made from.
    /// Machines that share such a file share what is rendered for it.
    ///
    /// # Errors
    /// As [`Workbench::figures`].
    pub fn counted_files(
        &self,
        machine: &Machine,
        plain: &Scene,
        workload: &Workload,
    ) -> Result<Vec<String>, MachineError> {
        let scene = self.prepared(machine, plain)?;
        let hardware = machine.hardware_for(&scene)?;
        let setup = Setup::sharing(
            hardware,
            &machine.system,
            scene,
            machine.syntheses(),
            &self.shared,
        )?;
        let mut files = setup.files_of_count(&options(machine, workload));
        if workload.quality {
            files.push(References::file(&setup, plain));
        }
        Ok(files)
    }

    /// A scene with a machine's render settings. What is found out about a scene is found once for all
    /// machines that render it alike.
    fn prepared(&self, machine: &Machine, plain: &Scene) -> Result<Scene, MachineError> {
        let key = (identity_of(plain), machine.render_key());
        let known = || self.prepared.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known().get(&key) {
            return Ok(found.clone());
        }
        let mut scene = plain.clone();
        machine.prepare(&mut scene)?;
        Ok(known().entry(key).or_insert(scene).clone())
    }
}

/// The options that a machine's path is counted with: no more than its variant uses.
pub(crate) fn options(machine: &Machine, workload: &Workload) -> PathOptions {
    let (system, path) = (&machine.system, &machine.path);
    let parts = match path.variant().frames {
        Frames::Full => PathParts::FullFrames,
        Frames::Warped | Frames::Chained | Frames::Half => PathParts::All,
    };
    PathOptions {
        frames: workload.frames,
        fps: workload.fps,
        window: match parts {
            PathParts::FullFrames => workload.frames,
            PathParts::All => path.window.unwrap_or(WINDOW),
        },
        phi: path.phi,
        profile: path.profile.unwrap_or_default(),
        array: [system.array_rows.into(), system.array_columns.into()],
        is_double_buffered: system.array_double_buffered,
        cache: system.gpu.cache_bytes(),
        parts,
    }
}
