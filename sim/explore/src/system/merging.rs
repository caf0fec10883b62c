//! Saving by merging cells of splats into fuller `MVoxel`s.

use potamoi_cycles::batch::Batch;
use potamoi_formats::record::RECORD_CHANNELS;
use potamoi_formats::rit::Vertices;
use potamoi_splats::{Cells, Octree};
use potamoi_system::system_model::{Clock, Gathering};
use schemars::JsonSchema;
use serde::Serialize;

use crate::{ExploreError, Setup};

/// A frame with or without merged cells.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Side {
    /// Whether cells are merged.
    pub merged: bool,
    /// MVoxels that hold points.
    pub mvoxels: usize,
    /// Mean points of an MVoxel.
    pub points_a_mvoxel: f64,
    /// Passes of the array over the model if an MVoxel's points were its columns, none shared
    /// between MVoxels.
    pub passes: usize,
    /// Bytes of the octree that describes merged cells; 0 without merging.
    pub tree_bytes: usize,
    /// Nanoseconds of gathering: the larger of the unit's cycles and its memory transfers.
    pub gathering_ns: f64,
    /// Nanoseconds of the array.
    pub computation_ns: f64,
    /// Nanoseconds of the frame, the geometric mean of both bounds of the GPU's kernels.
    pub frame_ns: f64,
    /// Picojoules of the array's multipliers; this and the next two `None` where not known.
    pub array_pj: Option<f64>,
    /// Picojoules of the array's multipliers and buffers.
    pub computation_pj: Option<f64>,
    /// Picojoules of gathering: the unit, its memories, and all memory bytes with DMA descriptors.
    pub gathering_pj: Option<f64>,
    /// Utilisation of the array's multipliers while it works, from 0 to 1.
    pub array_use: f64,
    /// The frame's work.
    pub done: Batch,
}

/// A scene's frame without and with merged cells.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Merging {
    /// Name of the scene, as requested.
    pub scene: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Clock of the accelerator.
    pub clock: Clock,
    /// Without merging, then with it.
    pub sides: [Side; 2],
}

impl Merging {
    /// Measures the frame that a setup's camera sees. Cell sides are halved `halvings` times beyond
    /// the coarsest that fit an `MVoxel`; `step` is called after each side. `None` for scenes
    /// without splats.
    ///
    /// # Errors
    /// As [`Setup::frame`].
    pub fn of(
        name: &str,
        mut setup: Setup,
        halvings: u32,
        step: &dyn Fn(),
    ) -> Result<Option<Self>, ExploreError> {
        if octree(&setup).is_none() {
            return Ok(None);
        }
        let mut side = |merge: bool| -> Result<Side, ExploreError> {
            setup.scene.set_cells(Cells { halvings, merge });
            let side = Side::new(&setup)?;
            step();
            Ok(side)
        };
        let sides = [side(false)?, side(true)?];
        Ok(Some(Self {
            scene: name.to_owned(),
            size: [setup.scene.camera().width, setup.scene.camera().height],
            clock: setup.costs().clock.clone(),
            sides,
        }))
    }
}

/// The octree over the cells of splats; `None` for other scenes.
fn octree(setup: &Setup) -> Option<Octree> {
    let rows = (setup.config).mvoxel_capacity(Vertices::One, RECORD_CHANNELS);
    setup.scene.octree(rows as usize)
}

impl Side {
    fn new(setup: &Setup) -> Result<Self, ExploreError> {
        let (model, work) = (setup.model(), setup.frame()?);
        let frame = model.frame(&work, Gathering::Unit)?;
        let done = work.total();
        let spent = model.costs.of(&done, true, setup.system.array().units());
        let merged = setup.scene.cells().merge;
        let tree = octree(setup);
        let mvoxels: &[usize] = match &tree {
            Some(tree) if merged => tree.points(),
            Some(tree) => tree.cells(),
            None => &[],
        };
        let points: usize = mvoxels.iter().sum();
        let columns = setup.system.array_columns as usize;
        // The unit gathers, so that both bounds differ by what waits for the GPU alone.
        let moved = frame.map(|run| {
            let own = run.stages.get("gathering").copied().unwrap_or_default();
            own.own_ns + own.memory_ns
        });
        let spent_pj = frame.max.spent.memory_pj + frame.max.spent.descriptor_pj;
        let held = setup.system.array().units();
        Ok(Self {
            merged,
            mvoxels: mvoxels.len(),
            points_a_mvoxel: points as f64 / mvoxels.len().max(1) as f64,
            passes: mvoxels.iter().map(|n| n.div_ceil(columns)).sum(),
            tree_bytes: tree.as_ref().filter(|_| merged).map_or(0, Octree::bytes),
            gathering_ns: moved.mid(),
            computation_ns: done.array_cycles as f64 / model.clock_ghz,
            frame_ns: frame.span_ns().mid(),
            array_pj: spent.array_pj,
            computation_pj: (spent.array_pj.zip(spent.buffers_pj))
                .map(|(array, buffers)| array + buffers),
            gathering_pj: (spent.gathering_pj.zip(spent.gathering_memories_pj))
                .map(|(logic, memories)| logic + memories + spent_pj),
            array_use: done.macs as f64 / (done.array_cycles.max(1) * held) as f64,
            done,
        })
    }
}
