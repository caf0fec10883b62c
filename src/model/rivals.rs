//! Comparison of Instant-NGP with `NeuRex` and `NGPC`.

use potamoi_explore::system::{Accelerators, NEUREX_SIDE};
use potamoi_system::system_model::System;

use super::ModelArgs;
use super::report::Report;
use super::{clock, means};
use crate::args::Common;
use crate::bounds::ratio;
use crate::failure::Failure;
use crate::progress;
use crate::stdout::{prose, say};
use crate::tables;

pub(super) fn run(
    common: &Common,
    args: &ModelArgs,
    system: &System,
    names: &[String],
) -> Result<(), Failure> {
    let mut scenes = vec![];
    for name in names {
        let scene = args.scene.open_named(name, common)?;
        if !scene.model().algorithm().starts_with("Instant-NGP") {
            return Err(Failure::Usage(format!(
                "--rivals {name}: it is {}; both accelerators are for Instant-NGP, such as cairn:ngp",
                scene.model().algorithm()
            )));
        }
        let mut setup = args.setup(common, system, scene)?;
        let (path, _) = args.count(&mut setup, &common.machine()?)?;
        let spinner = progress::spinner("counting");
        scenes.push(Accelerators::of(name, &setup, &path)?);
        spinner.finish_and_clear();
    }
    print(&scenes);
    args.files
        .write(&Report::new("model --rivals", system, scenes))
}

fn print(scenes: &[Accelerators]) {
    let mut table = tables::plain([
        "speed-up over the baseline",
        "GHz",
        "NeuRex",
        "NGPC",
        "Potamoi without SpaRW",
        "beside NeuRex",
        "beside NGPC",
        "Potamoi",
        "beside NeuRex",
        "beside NGPC",
    ]);
    for own in scenes {
        let ratios = own.ratios();
        table.add_row([
            clock::marked(&own.scene, &own.clock),
            format!("{:.2}", own.clock.ghz),
            ratio(&own.neurex),
            ratio(&own.ngpc),
            ratio(&own.potamoi_without_sparw),
            ratio(&ratios[0]),
            ratio(&ratios[1]),
            ratio(&own.potamoi),
            ratio(&ratios[2]),
            ratio(&ratios[3]),
        ]);
    }
    say!("{}", tables::fitted(&table, &[]));
    let all: Vec<_> = scenes.iter().map(Accelerators::ratios).collect();
    let mean = |i: usize| {
        let own: Vec<_> = all.iter().map(|ratios| ratios[i]).collect();
        ratio(&means::mean(&own))
    };
    prose!(
        0,
        "{}: {} times NeuRex and {} times NGPC without SpaRW, {} and {} with it; the paper: 2.0, about 1, 16.4, 8.2",
        clock::marked_mean("mean", scenes.iter().map(|own| &own.clock)),
        mean(0),
        mean(1),
        mean(2),
        mean(3)
    );
    prose!(
        0,
        "NeuRex: tables in MVoxels as here, banks that hold whole vectors (feature-major, 16 banks, 16 lanes), {NEUREX_SIDE} x {NEUREX_SIDE} multipliers; the paper takes that one's published speed-up instead. NGPC: all tables on chip, a bank a level that gives a vertex a cycle"
    );
}
