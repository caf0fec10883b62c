//! `potamoi synth --fpga`: the units placed and routed.

use std::path::Path;

use potamoi_explore::synthesis::in_parallel;
use potamoi_formats::config::Config;
use potamoi_synth::{FpgaReport, FpgaTools, Part, place_and_route};

use super::SynthArgs;
use crate::failure::Failure;
use crate::progress::{self, Shown};
use crate::stdout::say;

pub(super) fn run(config: &Config, args: &SynthArgs, cache: &Path) -> Result<(), Failure> {
    let tools = FpgaTools::find()?;
    let bar = progress::bar(0, "steps");
    let (kinds, jobs) = (args.unit.of_configuration()?, args.jobs.into());
    let made = in_parallel(kinds, jobs, 1, &Shown(&bar), |unit, _| {
        place_and_route(config, *unit, &tools, args.seed, cache)
    });
    bar.finish_and_clear();
    let made = made?;
    let units = made.iter().map(|(unit, _)| unit.clone()).collect();
    let report = FpgaReport::new(config, &tools, args.seed, units);
    say!(
        "{}, {}; {}, seed {}",
        report.device,
        tools.yosys,
        tools.nextpnr,
        args.seed
    );
    for (unit, is_cached) in &made {
        let of = |part: Part, what: &str| {
            let share = 100.0 * part.used as f64 / part.available as f64;
            format!("{} of {} {what} ({share:.1} %)", part.used, part.available)
        };
        say!(
            "{}{}: {}, {}, {}, {}; {:.4} GHz placed and routed",
            unit.unit,
            if *is_cached { " (cached)" } else { "" },
            of(unit.luts, "look-up tables"),
            of(unit.flops, "flip-flops"),
            of(unit.multipliers, "multipliers"),
            of(unit.block_rams, "block memories"),
            unit.clock_ghz()
        );
    }
    args.files.write(&report)?;
    Ok(())
}
