//! The two factors of the GPU: found from what the paper timed, and tried on what they were not
//! found from.

use potamoi_golden::analytic::Analytic;
use potamoi_sim::soc::work::FrameWork;
use potamoi_sim::soc::{Gpu, System, alone_ns};

use super::{ModelArgs, config_for};
use crate::common::Common;
use crate::failure::Failure;
use crate::progress;
use crate::say::say;

/// Frames a second at 800 x 800 on the mobile GPU alone (paper, Sec. "Introduction").
const DVGO: f64 = 0.8;
const SPLATS: f64 = 5.0;

pub(super) fn run(common: &Common, args: &ModelArgs, system: &System) -> Result<(), Failure> {
    let scenes = Analytic::ALL.map(Analytic::name);
    let bar = progress::bar(2 * scenes.len() as u64, "calibrating");
    let mut works = vec![];
    for kind in ["dvgo", "splats"] {
        let mut own = vec![];
        for scene in scenes {
            let name = format!("{scene}:{kind}");
            bar.set_message(name.clone());
            let mut scene = args.scene.open_named(&name)?;
            if !args.scene.looks_otherwise() {
                scene.set_size(Some(800), Some(800))?;
            }
            let (config, _) = config_for(common, &scene)?;
            let cache = system.gpu.cache_bytes;
            own.push(FrameWork::count(
                &scene,
                &config,
                system.array(),
                cache,
                None,
            )?);
            bar.inc(1);
        }
        works.push(own);
    }
    bar.finish_and_clear();
    let best = Gpu {
        fields_efficiency: 1.0,
        splats_efficiency: 1.0,
        ..system.gpu
    };
    for (own, (what, target)) in works.iter().zip([("fields", DVGO), ("splats", SPLATS)]) {
        let ns = own.iter().map(|work| alone_ns(&best, work)).sum::<f64>() / own.len() as f64;
        say!(
            "{what}: {:.3} ms a frame at best; {:.4} of that reaches {target} frames/s",
            ns * 1e-6,
            ns * 1e-9 * target
        );
    }
    Ok(())
}
