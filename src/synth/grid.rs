//! `potamoi synth --grid` and `--forms`: many units, each a point of one file.

use std::path::Path;

use potamoi_synth::grid::{Grid, GridPoint, Point};
use potamoi_synth::path_ends;

use super::power::Scenes;
use super::{Flow, SynthArgs, in_parallel};
use crate::failure::Failure;
use crate::files;
use crate::stdout::say;

/// Points of the file that is to be written as it is now, of this library and these programs.
struct Kept(Vec<GridPoint>);

impl Kept {
    fn of(args: &SynthArgs, flow: &Flow<'_>, path: &Path) -> Self {
        let earlier = Grid::read(path).ok().filter(|_| args.power.is_default());
        let own = Grid::new(flow.library, args.node, flow.tools, vec![]);
        let earlier = earlier.filter(|e| (&e.library, &e.tools) == (&own.library, &own.tools));
        Self(earlier.map_or(vec![], |grid| grid.points))
    }

    /// The point, if its Verilog is what is generated now.
    fn point(&self, point: &Point) -> Result<Option<GridPoint>, Failure> {
        let is_same = |p: &&GridPoint| p.family == point.family && p.config == point.text;
        let Some(earlier) = self.0.iter().find(is_same) else {
            return Ok(None);
        };
        let is_current = earlier.current_digest()? == earlier.verilog;
        Ok(is_current.then(|| earlier.clone()))
    }
}

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
    let kept = Kept::of(args, flow, path);
    let points = in_parallel(
        points,
        args.jobs.into(),
        args.power.steps(),
        |point, step| {
            if let Some(kept) = kept.point(point)? {
                return Ok(kept);
            }
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
