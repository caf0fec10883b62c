//! What merging cells of splats into fuller `MVoxel`s saves.

use comfy_table::{CellAlignment, Table, presets};
use potamoi_formats::config::Config;
use potamoi_golden::scene::Scene;
use potamoi_sim::soc::work::{Batch, FrameWork};
use potamoi_sim::soc::{Costs, Gathering, Memory, Model, System};
use serde::Serialize;

use super::{ModelArgs, config_for, costs, store};
use crate::common::Common;
use crate::failure::Failure;
use crate::files;
use crate::progress;
use crate::say::say;

/// A frame with cells merged, or as they are.
#[derive(Serialize)]
struct Side {
    merged: bool,
    mvoxels: usize,
    points_a_mvoxel: f64,
    tree_bytes: usize,
    /// Nanoseconds of gathering: of the unit's cycles or of its bytes, whichever is more.
    gathering_ns: f64,
    computation_ns: f64,
    frame_ns: f64,
    array_pj: f64,
    computation_pj: f64,
    gathering_pj: f64,
    done: Batch,
}

#[derive(Serialize)]
struct Merging {
    scene: String,
    sides: [Side; 2],
}

#[derive(Serialize)]
struct Report {
    format_version: u32,
    command: &'static str,
    scenes: Vec<Merging>,
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
        let mut scene = args.scene.open_named(name)?;
        let (config, _) = config_for(common, &scene)?;
        if scene.octree(config.mvoxel.rows as usize).is_none() {
            return Err(Failure::Usage(format!(
                "--octree {name}: it has no splats; choose a scene of splats, such as garden"
            )));
        }
        let costs = costs(&scene, &config, args.synth.as_deref())?;
        let mut side = |merged: bool| -> Result<Side, Failure> {
            scene.set_merges(merged);
            let cache = system.gpu.cache_bytes;
            let (work, _) = store()?.frame(&scene, &config, system.array(), cache)?;
            bar.inc(1);
            Side::new(&scene, &config, system, &costs, &work)
        };
        let sides = [side(false)?, side(true)?];
        scenes.push(Merging {
            scene: name.clone(),
            sides,
        });
    }
    bar.finish_and_clear();
    print(&scenes);
    let report = Report {
        format_version: super::report::FORMAT_VERSION,
        command: "model --octree",
        scenes,
    };
    match &args.json {
        Some(path) => Ok(files::write_json(path, &report)?),
        None => Ok(()),
    }
}

impl Side {
    fn new(
        scene: &Scene,
        config: &Config,
        system: &System,
        costs: &Costs,
        work: &FrameWork,
    ) -> Result<Self, Failure> {
        let memory = Memory::lpddr3(system.memory_channels);
        let clock_ghz = f64::from(config.clock_mhz) * 1e-3;
        let model = Model {
            system,
            memory: &memory,
            costs,
            clock_ghz,
        };
        let frame = model.frame(work, Gathering::Unit)?;
        let done = work.total();
        let spent = costs.of(&done, true)?;
        let tree = scene.octree(config.mvoxel.rows as usize);
        let merged = scene.merges();
        let (mvoxels, points, tree_bytes) = tree.map_or((0, 0, 0), |tree| {
            let points: usize = tree.points().iter().sum();
            let mvoxels = if merged {
                tree.points().len()
            } else {
                tree.cells()
            };
            (mvoxels, points, if merged { tree.bytes() } else { 0 })
        });
        let moved = frame.stages.get("gathering").copied().unwrap_or_default();
        Ok(Self {
            merged,
            mvoxels,
            points_a_mvoxel: points as f64 / mvoxels.max(1) as f64,
            tree_bytes,
            gathering_ns: moved.own_ns + moved.memory_ns,
            computation_ns: done.array_cycles as f64 / clock_ghz,
            frame_ns: frame.span_ns,
            array_pj: spent.array_pj,
            computation_pj: spent.array_pj + spent.buffers_pj,
            gathering_pj: spent.gathering_pj + spent.gathering_memories_pj + frame.spent.memory_pj,
            done,
        })
    }
}

fn print(scenes: &[Merging]) {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header([
        "without > with merging",
        "points an MVoxel",
        "tree, KB",
        "gathering, us",
        "times",
        "computation, us",
        "times",
        "array's use",
        "computation, uJ",
        "less",
        "gathering with memory, uJ",
        "less",
    ]);
    let less = |of: [f64; 2]| format!("{:.1} %", 100.0 * (1.0 - of[1] / of[0]));
    let pair = |of: [f64; 2], digits: usize| format!("{:.digits$} > {:.digits$}", of[0], of[1]);
    let mut sums = [0.0; 4];
    for Merging { scene, sides } in scenes {
        let of = |f: fn(&Side) -> f64| sides.each_ref().map(f);
        let gathering = of(|s| s.gathering_ns);
        let computation = of(|s| s.computation_ns);
        let energy = of(|s| s.computation_pj);
        let gathered = of(|s| s.gathering_pj);
        let used = of(|s| s.done.macs as f64 / (s.done.array_cycles as f64 * 576.0) * 100.0);
        for (sum, [a, b]) in sums
            .iter_mut()
            .zip([gathering, computation, energy, gathered])
        {
            *sum += a / b / scenes.len() as f64;
        }
        table.add_row([
            scene.clone(),
            pair(of(|s| s.points_a_mvoxel), 1),
            format!("{:.0}", sides[1].tree_bytes as f64 * 1e-3),
            pair(gathering.map(|ns| ns * 1e-3), 1),
            format!("{:.2}", gathering[0] / gathering[1]),
            pair(computation.map(|ns| ns * 1e-3), 1),
            format!("{:.2}", computation[0] / computation[1]),
            format!("{} %", pair(used, 1)),
            pair(energy.map(|pj| pj * 1e-6), 1),
            less(energy),
            pair(gathered.map(|pj| pj * 1e-6), 1),
            less(gathered),
        ]);
    }
    table
        .column_iter_mut()
        .skip(1)
        .for_each(|c| c.set_cell_alignment(CellAlignment::Right));
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
