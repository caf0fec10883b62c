//! What merging cells of splats into fuller `MVoxel`s saves.

use potamoi_formats::record::RECORD_CHANNELS;
use potamoi_formats::rit::Vertices;
use potamoi_splats::{Cells, Octree};
use potamoi_system::soc::work::Batch;
use potamoi_system::soc::{Gathering, System};
use serde::Serialize;

use super::ModelArgs;
use super::report::{self, Report};
use crate::args::Common;
use crate::failure::Failure;
use crate::model_context::Setup;
use crate::progress;
use crate::stdout::say;
use crate::tables;

/// A frame with cells merged, or as they are.
#[derive(Serialize)]
struct Side {
    merged: bool,
    mvoxels: usize,
    points_a_mvoxel: f64,
    /// Passes of the array over the model if an MVoxel's points were its columns, none shared
    /// between MVoxels.
    passes: usize,
    tree_bytes: usize,
    /// Nanoseconds of gathering: of the unit's cycles or of its bytes, whichever is more.
    gathering_ns: f64,
    computation_ns: f64,
    frame_ns: f64,
    array_pj: f64,
    computation_pj: f64,
    /// The unit's, its memories', and that of all bytes of memory with the DMA's descriptors.
    gathering_pj: f64,
    /// Share of the array's multipliers that work while it does.
    array_use: f64,
    done: Batch,
}

#[derive(Serialize)]
struct Merging {
    scene: String,
    size: [u32; 2],
    sides: [Side; 2],
}

pub(super) fn run(
    common: &Common,
    args: &ModelArgs,
    system: &System,
    names: &[String],
) -> Result<(), Failure> {
    let bar = progress::bar(2 * names.len() as u64, "counting");
    let mut scenes = vec![];
    for name in names {
        bar.set_message(name.clone());
        let scene = args.scene.open_named(name)?;
        let mut setup = args.setup(common, system, scene)?;
        if setup.octree().is_none() {
            return Err(Failure::Usage(format!(
                "--octree {name}: it has no splats; choose a scene of splats, such as garden"
            )));
        }
        let mut side = |merged: bool| -> Result<Side, Failure> {
            let halvings = args.halvings;
            setup.scene.set_cells(Cells {
                halvings,
                merge: merged,
            });
            let side = Side::new(&setup)?;
            bar.inc(1);
            Ok(side)
        };
        let sides = [side(false)?, side(true)?];
        scenes.push(Merging {
            scene: name.clone(),
            size: [setup.scene.camera().width, setup.scene.camera().height],
            sides,
        });
    }
    bar.finish_and_clear();
    print(&scenes);
    report::write(&Report::new("model --octree", system, scenes), args)
}

impl Setup {
    fn octree(&self) -> Option<Octree> {
        let rows = (self.config).mvoxel_capacity(Vertices::One, RECORD_CHANNELS);
        self.scene.octree(rows as usize)
    }
}

impl Side {
    fn new(setup: &Setup) -> Result<Self, Failure> {
        let (model, work) = (setup.model(), setup.frame()?);
        let frame = model.frame(&work, Gathering::Unit)?;
        let done = work.total();
        let spent = model.costs.of(&done, true, setup.system.array().units())?;
        let merged = setup.scene.cells().merge;
        let tree = setup.octree();
        let mvoxels: &[usize] = match &tree {
            Some(tree) if merged => tree.points(),
            Some(tree) => tree.cells(),
            None => &[],
        };
        let points: usize = mvoxels.iter().sum();
        let columns = setup.system.array_columns as usize;
        let moved = frame.stages.get("gathering").copied().unwrap_or_default();
        let held = setup.system.array().units();
        Ok(Self {
            merged,
            mvoxels: mvoxels.len(),
            points_a_mvoxel: points as f64 / mvoxels.len().max(1) as f64,
            passes: mvoxels.iter().map(|n| n.div_ceil(columns)).sum(),
            tree_bytes: tree.as_ref().filter(|_| merged).map_or(0, Octree::bytes),
            gathering_ns: moved.own_ns + moved.memory_ns,
            computation_ns: done.array_cycles as f64 / model.clock_ghz,
            frame_ns: frame.span_ns,
            array_pj: spent.array_pj,
            computation_pj: spent.array_pj + spent.buffers_pj,
            gathering_pj: spent.gathering_pj
                + spent.gathering_memories_pj
                + frame.spent.memory_pj
                + frame.spent.descriptor_pj,
            array_use: done.macs as f64 / (done.array_cycles.max(1) * held) as f64,
            done,
        })
    }
}

fn print(scenes: &[Merging]) {
    let mut table = tables::plain([
        "without > with merging",
        "points an MVoxel",
        "tree, KB",
        "gathering, us",
        "times",
        "computation, us",
        "times",
        "array's use",
        "an MVoxel's points as columns",
        "computation, uJ",
        "less",
        "gathering with memory, uJ",
        "less",
    ]);
    let less = |of: [f64; 2]| format!("{:.1} %", 100.0 * (1.0 - of[1] / of[0]));
    let pair = |of: [f64; 2], digits: usize| format!("{:.digits$} > {:.digits$}", of[0], of[1]);
    let mut sums = [0.0; 4];
    for Merging { scene, size, sides } in scenes {
        let of = |f: fn(&Side) -> f64| sides.each_ref().map(f);
        let gathering = of(|s| s.gathering_ns);
        let computation = of(|s| s.computation_ns);
        let energy = of(|s| s.computation_pj);
        let gathered = of(|s| s.gathering_pj);
        let used = of(|s| 100.0 * s.array_use);
        for (sum, [a, b]) in sums
            .iter_mut()
            .zip([gathering, computation, energy, gathered])
        {
            *sum += a / b / scenes.len() as f64;
        }
        table.add_row([
            format!("{scene}, {} x {}", size[0], size[1]),
            pair(of(|s| s.points_a_mvoxel), 1),
            format!("{:.1}", sides[1].tree_bytes as f64 * 1e-3),
            pair(gathering.map(|ns| ns * 1e-3), 1),
            format!("{:.2}", gathering[0] / gathering[1]),
            pair(computation.map(|ns| ns * 1e-3), 1),
            format!("{:.2}", computation[0] / computation[1]),
            format!("{} %", pair(used, 1)),
            format!(
                "{:.2} times",
                sides[0].passes as f64 / sides[1].passes as f64
            ),
            pair(energy.map(|pj| pj * 1e-6), 1),
            less(energy),
            pair(gathered.map(|pj| pj * 1e-6), 1),
            less(gathered),
        ]);
    }
    say!("{table}");
    say!(
        "mean: gathering {:.2} times, computation {:.2} times, computation's energy {:.1} % less, gathering's {:.1} % less",
        sums[0],
        sums[1],
        100.0 * (1.0 - 1.0 / sums[2]),
        100.0 * (1.0 - 1.0 / sums[3])
    );
    say!("the paper: 7.2 > 172.8 points, below 200 KB; 1.3 and 3.5 times; 70.1 % and 1 % less");
}
