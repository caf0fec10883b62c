//! Comparison of Instant-NGP with `NeuRex` and `NGPC`.

use potamoi_explore::system::{Accelerators, NEUREX_SIDE};
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
    let mut scenes = vec![];
    for name in names {
        let scene = args.scene.open_named(name)?;
        if !scene.model().algorithm().starts_with("Instant-NGP") {
            return Err(Failure::Usage(format!(
                "--rivals {name}: it is {}; both accelerators are for Instant-NGP, such as cairn:ngp",
                scene.model().algorithm()
            )));
        }
        let mut setup = args.setup(common, system, scene)?;
        let (path, _) = args.count(&mut setup)?;
        let spinner = progress::spinner("counting");
        scenes.push(Accelerators::of(name, &setup, &path)?);
        spinner.finish_and_clear();
    }
    print(&scenes);
    report::write(&Report::new("model --rivals", system, scenes), args)
}

fn print(scenes: &[Accelerators]) {
    let mut table = tables::plain([
        "speed-up over the baseline",
        "NeuRex",
        "NGPC",
        "Potamoi without SpaRW",
        "beside NeuRex",
        "beside NGPC",
        "Potamoi",
        "beside NeuRex",
        "beside NGPC",
    ]);
    let mut means = [0.0; 4];
    for own in scenes {
        let ratios = own.ratios();
        for (mean, ratio) in means.iter_mut().zip(ratios) {
            *mean += ratio / scenes.len() as f64;
        }
        let shown = |v: f64| format!("{v:.2}");
        table.add_row([
            own.scene.clone(),
            shown(own.neurex),
            shown(own.ngpc),
            shown(own.potamoi_without_sparw),
            shown(ratios[0]),
            shown(ratios[1]),
            shown(own.potamoi),
            shown(ratios[2]),
            shown(ratios[3]),
        ]);
    }
    say!("{table}");
    say!(
        "mean: {:.2} times NeuRex and {:.2} times NGPC without SpaRW, {:.2} and {:.2} with it; the paper: 2.0, about 1, 16.4, 8.2",
        means[0],
        means[1],
        means[2],
        means[3]
    );
    say!(
        "NeuRex: tables in MVoxels as here, banks that hold whole vectors (feature-major, 16 banks, 16 lanes), {NEUREX_SIDE} x {NEUREX_SIDE} multipliers; the paper takes that one's published speed-up instead. NGPC: all tables on chip, a bank a level that gives a vertex a cycle"
    );
}
