//! `potamoi synth --grid` and `--forms`: many units, each a point of one file.

use std::path::Path;

use potamoi_sim::synth::grid::{Grid, GridPoint, Point};
use potamoi_sim::synth::path_ends;

use super::power::Scenes;
use super::{Flow, SynthArgs, in_parallel};
use crate::failure::Failure;
use crate::files;
use crate::say::say;

pub(super) fn run(
    args: &SynthArgs,
    flow: &Flow<'_>,
    option: &str,
    points: &[Point],
    path: &Path,
) -> Result<(), Failure> {
    if !args.power.is_wanted() {
        let why = format!("{option} estimates power: name a scene in place of --activity none");
        return Err(Failure::Usage(why));
    }
    let points = in_parallel(
        points,
        args.jobs.into(),
        args.power.steps(),
        |point, step| {
            let config = point.config()?;
            let unit = point.family.unit();
            let mut made = flow.synthesise(&config, unit, step)?;
            let work = Scenes::open(&args.power, &[unit])?.work(&config)?;
            args.power
                .add((&config, unit), &mut made, &work, flow, step)?;
            let ends = path_ends(&config, unit, &made, flow.library, flow.tools, flow.cache)?;
            Ok(GridPoint::new(point, &config, &made.report, ends)?)
        },
    )?;
    let grid = Grid::new(flow.library, args.node, flow.tools, points);
    files::write_json(path, &grid)?;
    say!("{} points: {}", grid.points.len(), path.display());
    Ok(())
}
