//! `potamoi synth --grid`: configurations that estimates are fitted to.

use std::path::Path;

use potamoi_sim::synth::fitted::{Grid, GridPoint, design};
use potamoi_sim::synth::{Library, Tools, synthesise};

use super::power::Scenes;
use super::{SynthArgs, in_parallel};
use crate::failure::Failure;
use crate::files;
use crate::say::say;

pub(super) fn run(
    args: &SynthArgs,
    library: &Library,
    tools: &Tools,
    cache: &Path,
    path: &Path,
) -> Result<(), Failure> {
    let points = in_parallel(&design(), args.jobs.into(), |point| {
        let config = point.config()?;
        let unit = point.family.unit();
        let mut made = synthesise(&config, unit, library, tools, cache)?;
        if point.has_power {
            let work = Scenes::open(&args.power, &[unit])?.work(&config)?;
            let with = (library, tools, &work);
            args.power.add(&config, unit, &mut made, with, cache)?;
        }
        Ok(GridPoint::new(point, &config, &made.report)?)
    })?;
    let grid = Grid::new(library, args.node, tools, points);
    files::write_json(path, &grid)?;
    say!("{} points: {}", grid.points.len(), path.display());
    Ok(())
}
