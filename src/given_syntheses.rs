//! Syntheses of `--synth` that no machine has a use for.

use std::path::PathBuf;

use potamoi_explore::Syntheses;
use potamoi_machines::Machine;
use potamoi_synth::UnitKind;

use crate::stdout;

/// Names the files of which none of these machines has a unit beside the array's, which all have.
pub(crate) fn say_unused(paths: &[PathBuf], syntheses: &Syntheses, machines: Vec<Machine>) {
    let configs = machines.into_iter().filter_map(|own| own.hardware);
    let configs: Vec<_> = configs.map(|own| own.config).collect();
    for (path, own) in paths.iter().zip(syntheses.all()) {
        let units = [UnitKind::Gathering, UnitKind::Vector, UnitKind::Splat];
        let has = |unit: &UnitKind| {
            own.report.unit(*unit).is_some() && configs.iter().any(|config| own.has(config, *unit))
        };
        if !units.iter().any(has) {
            stdout::remark(format_args!(
                "{}: no machine here has a unit of it, so that it changes no figure",
                path.display()
            ));
        }
    }
}
