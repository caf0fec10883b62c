//! The counted trace of a frame.

use std::collections::BTreeMap;

use potamoi_explore::{ConfigChoice, Setup};
use potamoi_rivals::{Class, Trace};
use potamoi_scene::Scene;
use potamoi_system::system_model::work::{FrameWork, PathOptions, PathWork};

use super::{subtiles, wrong};
use crate::machine::{Machine, MachineError};
use crate::workbench::{Workbench, options};
use crate::workload::Workload;

/// Sides of the arrays whose cycles are counted.
const ARRAYS: [u64; 3] = [24, 32, 64];
/// Preset whose renderer evaluates every live pixel of a Gaussian's tiles.
const SPLATS: &str = "paper";

/// A trace, and the path of its frame.
#[derive(Debug)]
pub struct Traced {
    /// The trace.
    pub trace: Trace,
    /// The path.
    pub path: PathWork,
}

impl Workbench {
    /// Counts the frame that machines render for a workload.
    ///
    /// # Errors
    /// A scene that cannot be counted, or whose algorithm is of no class.
    pub fn traced(&self, scene: &Scene, workload: &Workload) -> Result<Traced, MachineError> {
        let class = class_of(scene)?;
        let machine = match class {
            Class::Splats => Machine::named(SPLATS)?,
            Class::HashGrid | Class::Grid => Machine::for_any_scene()?,
        };
        let hardware: ConfigChoice = machine.hardware_for(scene)?;
        let mut counts = BTreeMap::new();
        let mut found = None;
        for side in ARRAYS {
            let asked = PathOptions {
                array: [side; 2],
                is_double_buffered: true,
                ..options(&machine, workload)
            };
            let mut setup = Setup::sharing(
                hardware.clone(),
                &machine.system,
                scene.clone(),
                machine.syntheses(),
                self.shared(),
            )?;
            let (path, _) = setup.count(&asked, &())?;
            if class != Class::Splats {
                let cycles = path.full(0).total().array_cycles;
                counts.insert(format!("array-cycles-{side}"), cycles as f64);
            }
            found.get_or_insert(path);
            if class == Class::Splats {
                break;
            }
        }
        let path = found.ok_or_else(|| wrong("no path was counted"))?;
        let work = path.full(0);
        counts.insert("pixels".to_owned(), work.pixels as f64);
        match class {
            Class::Splats => of_splats(scene, work, &mut counts)?,
            Class::HashGrid | Class::Grid => of_fields(work, &mut counts),
        }
        let trace = Trace {
            scene: scene.name().to_owned(),
            class,
            counts,
        };
        Ok(Traced { trace, path })
    }
}

fn class_of(scene: &Scene) -> Result<Class, MachineError> {
    let algorithm = scene.model().algorithm();
    match algorithm {
        "3DGS" => Ok(Class::Splats),
        own if own.starts_with("Instant-NGP") => Ok(Class::HashGrid),
        own if scene.model().is_splats() => Err(wrong(format!(
            "{}: {own} is of no class of the bench: expected 3DGS or a field",
            scene.name()
        ))),
        _ => Ok(Class::Grid),
    }
}

fn of_splats(
    scene: &Scene,
    work: &FrameWork,
    counts: &mut BTreeMap<String, f64>,
) -> Result<(), MachineError> {
    let cloud = scene
        .cloud()
        .ok_or_else(|| wrong(format!("{}: no Gaussians", scene.name())))?;
    let met = subtiles::share(scene, cloud).map_err(wrong)?;
    let pairs = work.pixel_pairs.unwrap_or_default();
    let evaluated = pairs.pairs_evaluated as f64;
    let all = [
        ("gaussians", work.gaussians as f64),
        ("visible", work.visible as f64),
        ("pairs", work.pairs.max(work.pairs_tested) as f64),
        ("tile-pixels", evaluated),
        ("subtile-pixels", (evaluated * met).round()),
        ("drawn-pixels", pairs.pairs_drawn as f64),
    ];
    counts.extend(all.map(|(name, value)| (name.to_owned(), value)));
    Ok(())
}

fn of_fields(work: &FrameWork, counts: &mut BTreeMap<String, f64>) {
    let (total, reads) = (work.total(), &work.reads);
    let channels = (reads.bytes as f64 / 2.0 / reads.reads.max(1) as f64).max(1.0);
    let entry_vertices = total.codes_read as f64 / channels;
    // Vectors of a sample in one table.
    let corners = (entry_vertices / total.entries.max(1) as f64).max(1.0);
    let sample_levels = reads.reads as f64 / corners;
    let all = [
        ("looks", work.samples as f64),
        ("samples", sample_levels / reads.tables.max(1) as f64),
        ("sample-levels", sample_levels),
        ("vertices", reads.reads as f64),
        ("entry-vertices", entry_vertices),
        (
            "streamed-bytes",
            (total.row_bytes + total.rit_read_bytes) as f64,
        ),
        ("table-bytes", reads.model_bytes as f64),
    ];
    counts.extend(all.map(|(name, value)| (name.to_owned(), value.round())));
}
