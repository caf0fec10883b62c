//! Saving by merging cells of splats into fuller `MVoxel`s.

use potamoi_explore::system::{Merging, Side};
use potamoi_system::system_model::System;

use super::ModelArgs;
use super::report::{self, Report};
use crate::args::Common;
use crate::failure::Failure;
use crate::progress;
use crate::stdout::say;
use crate::tables;

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
        let setup = args.setup(common, system, scene)?;
        let found = Merging::of(name, setup, args.halvings, &|| bar.inc(1))?;
        scenes.push(found.ok_or_else(|| {
            Failure::Usage(format!(
                "--octree {name}: it has no splats; choose a scene of splats, such as garden"
            ))
        })?);
    }
    bar.finish_and_clear();
    print(&scenes);
    report::write(&Report::new("model --octree", system, scenes), args)
}

fn print(scenes: &[Merging]) {
    let mut table = tables::plain([
        "without > with merging",
        "points per MVoxel",
        "tree, KB",
        "gathering, us",
        "speed-up",
        "computation, us",
        "speed-up",
        "array utilisation",
        "MVoxel's points as columns, speed-up",
        "computation, uJ",
        "saving",
        "gathering with memory, uJ",
        "saving",
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
            format!("{:.2}", sides[0].passes as f64 / sides[1].passes as f64),
            pair(energy.map(|pj| pj * 1e-6), 1),
            less(energy),
            pair(gathered.map(|pj| pj * 1e-6), 1),
            less(gathered),
        ]);
    }
    say!("{table}");
    say!(
        "mean speed-up: gathering {:.2}, computation {:.2}; mean energy saving: computation \
         {:.1} %, gathering {:.1} %",
        sums[0],
        sums[1],
        100.0 * (1.0 - 1.0 / sums[2]),
        100.0 * (1.0 - 1.0 / sums[3])
    );
    say!(
        "the paper: 7.2 > 172.8 points, a tree below 200 KB; speed-ups 1.3 and 3.5; savings 70.1 \
         % and 1 %"
    );
}
