//! Instant-NGP beside `NeuRex` and `NGPC`, as their structure is described (paper, Sec. "Compared
//! with Prior Works").

use potamoi_formats::config::{Config, Modes, Organisation};
use potamoi_system::soc::npu::Array;
use potamoi_system::soc::{Gathering, Outcome, Scenario, System, Variant};
use serde::Serialize;

use super::ModelArgs;
use super::report::{self, Report};
use crate::args::Common;
use crate::failure::Failure;
use crate::progress;
use crate::stdout::say;
use crate::tables;

/// Rows and columns of `NeuRex`'s array (paper, ibid.).
const NEUREX_SIDE: u64 = 32;

#[derive(Serialize)]
struct Compared {
    scene: String,
    /// Speed-ups over the baseline, frame by frame in full.
    neurex: f64,
    ngpc: f64,
    potamoi_without_sparw: f64,
    potamoi: f64,
}

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
        let model = setup.model();
        let spinner = progress::spinner("counting");
        // Banks that hold whole vectors, lanes that want them, and a larger array.
        let array = Array {
            rows: NEUREX_SIDE,
            columns: NEUREX_SIDE,
            ..system.array()
        };
        let neurex = setup.frame_of(&feature_major(&setup.config), array)?;
        spinner.finish_and_clear();
        let run = |variant: Variant| -> Result<Outcome, Failure> {
            Ok(model.run(&path, variant, Scenario::Local)?.0)
        };
        let named = |name: &str| Variant::named(name).unwrap_or(Variant::ALL[0]);
        let baseline = run(named("baseline"))?;
        let per_frame = baseline.run.span_ns / baseline.run.frames as f64;
        // One frame, which is the same for all that render each in full.
        let ngpc = model.frame(&path.full(0).with_resident_tables(), Gathering::Unit)?;
        let neurex = model.frame(&neurex, Gathering::Unit)?;
        let ours = run(named("fs+gu"))?;
        let warped = run(named("potamoi"))?;
        scenes.push(Compared {
            scene: name.clone(),
            neurex: per_frame / neurex.span_ns,
            ngpc: per_frame / ngpc.span_ns,
            potamoi_without_sparw: baseline.run.span_ns / ours.run.span_ns,
            potamoi: baseline.run.span_ns / warped.run.span_ns,
        });
    }
    print(&scenes);
    report::write(&Report::new("model --rivals", system, scenes), args)
}

/// The same with banks that hold whole vectors.
fn feature_major(config: &Config) -> Config {
    let mut config = config.clone();
    config.gu.organisation = Organisation::FeatureMajor;
    config.gu.modes = Modes::Both;
    (config.gu.banks, config.gu.lanes, config.gu.ports) = (16, 16, 1);
    config
}

fn print(scenes: &[Compared]) {
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
        let ratios = [
            own.potamoi_without_sparw / own.neurex,
            own.potamoi_without_sparw / own.ngpc,
            own.potamoi / own.neurex,
            own.potamoi / own.ngpc,
        ];
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
