//! `potamoi synth --grid` and `--forms`: many units, each a point of one file.

use std::path::Path;

use potamoi_base::outputs as files;
use potamoi_explore::synthesis::{Flow, synthesise_grid};
use potamoi_synth::grid::Point;

use super::SynthArgs;
use crate::failure::Failure;
use crate::progress::{self, Shown};
use crate::stdout::say;

pub(super) fn run(
    args: &SynthArgs,
    flow: &Flow<'_>,
    option: &str,
    points: &[Point],
    path: &Path,
) -> Result<(), Failure> {
    if !args.power.is_wanted() {
        let why = format!("{option} estimates power: name a scene instead of --activity none");
        return Err(Failure::Usage(why));
    }
    let activity = args.power.activity(args.unit)?;
    let bar = progress::bar(0, "steps");
    let of = (args.node, &activity);
    let grid = synthesise_grid(points, args.jobs.into(), of, flow, path, &Shown(&bar));
    bar.finish_and_clear();
    let grid = grid?;
    files::write_json(path, &grid)?;
    say!("{} points: {}", grid.points.len(), path.display());
    Ok(())
}
