//! Sensitivity of the results to figures of the GPUs, and results without a GPU.

use potamoi_explore::system::{CountedScene, Sensitivity, SensitivityRow};
use potamoi_system::system_model::{Scenario, System};

use super::ModelArgs;
use super::bounds::{known, ratio};
use super::report::{self, Report};
use crate::args::Common;
use crate::failure::Failure;
use crate::stdout::say;
use crate::tables;

pub(super) fn run(
    common: &Common,
    args: &ModelArgs,
    system: &System,
    names: &[String],
) -> Result<(), Failure> {
    let mut counted = vec![];
    for name in names {
        let mut setup = args.setup(common, system, args.scene.open_named(name)?)?;
        let path = args.count(&mut setup)?.0;
        counted.push(CountedScene {
            name: name.clone(),
            setup,
            path,
        });
    }
    let scenarios = args.scenario.all();
    let found = Sensitivity::of(&counted, system, &args.variants()?, scenarios)?;
    print(&found, args);
    report::write(
        &Report::new("model --sensitivity", system, vec![found]),
        args,
    )
}

fn print(found: &Sensitivity, args: &ModelArgs) {
    say!(
        "speed-up (energy saving) over the baseline of the same system at both bounds of the GPU's \
         kernels, means of {}",
        found.scenes.join(", ")
    );
    for scenario in args.scenario.all() {
        let of = |row: &SensitivityRow| -> Vec<String> {
            let own = row.means.iter();
            own.filter(|m| m.scenario == *scenario && m.variant != "baseline")
                .map(|m| format!("{} ({})", ratio(&m.speed_up), known(m.saving.as_ref())))
                .collect()
        };
        let names = found.rows.iter().take(1).flat_map(|row| &row.means);
        let names = names.filter(|m| m.scenario == *scenario && m.variant != "baseline");
        let heading = match scenario {
            Scenario::Local => "local rendering",
            Scenario::Remote => "remote rendering",
        };
        let heading = std::iter::once(heading.to_owned());
        let mut table = tables::plain(
            heading
                .chain(names.map(|m| m.variant.to_owned()))
                .collect::<Vec<_>>(),
        );
        for row in &found.rows {
            let figures = of(row);
            if !figures.is_empty() {
                table.add_row([vec![row.change.to_owned()], figures].concat());
            }
        }
        say!("{table}");
    }
}
