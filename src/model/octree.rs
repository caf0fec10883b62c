//! Saving by merging cells of splats into fuller `MVoxel`s.

use potamoi_explore::system::{Merging, Side};
use potamoi_system::system_model::System;

use super::ModelArgs;
use super::clock;
use super::report::Report;
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
        let scene = args.scene.open_named(name, common)?;
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
    args.files
        .write(&Report::new("model --octree", system, scenes))
}

fn print(scenes: &[Merging]) {
    let mut table = tables::plain([
        "without > with merging",
        "GHz",
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
    let known = |of: Option<String>| of.unwrap_or_else(|| "-".to_owned());
    let less = |of: [f64; 2]| format!("{:.1} %", 100.0 * (1.0 - of[1] / of[0]));
    let pair = |of: [f64; 2], digits: usize| format!("{:.digits$} > {:.digits$}", of[0], of[1]);
    let mut sums = [Some(0.0); 4];
    for own in scenes {
        let (size, sides) = (own.size, &own.sides);
        let of = |f: fn(&Side) -> f64| sides.each_ref().map(f);
        let gathering = of(|s| s.gathering_ns);
        let computation = of(|s| s.computation_ns);
        let both = |of: [Option<f64>; 2]| Some([of[0]?, of[1]?]);
        let energy = both(sides.each_ref().map(|s| s.computation_pj));
        let gathered = both(sides.each_ref().map(|s| s.gathering_pj));
        let used = of(|s| 100.0 * s.array_use);
        let all = [Some(gathering), Some(computation), energy, gathered];
        for (sum, of) in sums.iter_mut().zip(all) {
            *sum = sum
                .zip(of)
                .map(|(sum, [a, b])| sum + a / b / scenes.len() as f64);
        }
        table.add_row([
            clock::marked(
                &format!("{}, {} x {}", own.scene, size[0], size[1]),
                &own.clock,
            ),
            format!("{:.2}", own.clock.ghz),
            pair(of(|s| s.points_a_mvoxel), 1),
            format!("{:.1}", sides[1].tree_bytes as f64 * 1e-3),
            pair(gathering.map(|ns| ns * 1e-3), 1),
            format!("{:.2}", gathering[0] / gathering[1]),
            pair(computation.map(|ns| ns * 1e-3), 1),
            format!("{:.2}", computation[0] / computation[1]),
            format!("{} %", pair(used, 1)),
            format!("{:.2}", sides[0].passes as f64 / sides[1].passes as f64),
            known(energy.map(|of| pair(of.map(|pj| pj * 1e-6), 1))),
            known(energy.map(less)),
            known(gathered.map(|of| pair(of.map(|pj| pj * 1e-6), 1))),
            known(gathered.map(less)),
        ]);
    }
    say!("{}", tables::fitted(&table, &[]));
    say!(
        "mean speed-up: gathering {}, computation {}; mean energy saving: computation {}, gathering \
         {}",
        known(sums[0].map(|mean| format!("{mean:.2}"))),
        known(sums[1].map(|mean| format!("{mean:.2}"))),
        known(sums[2].map(|mean| format!("{:.1} %", 100.0 * (1.0 - 1.0 / mean)))),
        known(sums[3].map(|mean| format!("{:.1} %", 100.0 * (1.0 - 1.0 / mean))))
    );
    say!(
        "the paper: 7.2 > 172.8 points, a tree below 200 KB; speed-ups 1.3 and 3.5; savings 70.1 \
         % and 1 %"
    );
}
