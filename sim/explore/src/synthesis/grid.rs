//! Grids of units: many synthesis points in one file.

use std::path::Path;

use potamoi_synth::grid::{Grid, GridPoint, Point};
use potamoi_synth::path_ends;

use super::activity::{Activity, ActivityScene, ActivityScenes};
use super::flow::Flow;
use super::parallel::in_parallel;
use crate::{ExploreError, Progress};

/// Points of an earlier file that fit this library and these tools.
struct Kept(Vec<GridPoint>);

impl Kept {
    fn of(node: Option<u32>, activity: &Activity, flow: &Flow<'_>, path: &Path) -> Self {
        let is_default = activity.scene == ActivityScene::Default;
        let earlier = Grid::read(path).ok().filter(|_| is_default);
        let own = Grid::new(flow.library, node, flow.tools, vec![]);
        let earlier = earlier.filter(|e| (&e.library, &e.tools) == (&own.library, &own.tools));
        Self(earlier.map_or(vec![], |grid| grid.points))
    }

    /// The cached point, if the netlists of its modules are unchanged.
    fn point(&self, point: &Point) -> Result<Option<GridPoint>, ExploreError> {
        let is_same = |p: &&GridPoint| p.family == point.family && p.config == point.text;
        let Some(earlier) = self.0.iter().find(is_same) else {
            return Ok(None);
        };
        let is_current = earlier.current_netlists()? == earlier.netlists;
        Ok(is_current.then(|| earlier.clone()))
    }
}

/// Synthesises points, `jobs` at once, with their power for an activity, in a library of this node.
/// Current points of an earlier file at `earlier` are reused.
///
/// # Errors
/// A point that cannot be synthesised, or a netlist with wrong results.
pub fn synthesise_grid(
    points: &[Point],
    jobs: usize,
    (node, activity): (Option<u32>, &Activity),
    flow: &Flow<'_>,
    earlier: &Path,
    progress: &dyn Progress,
) -> Result<Grid, ExploreError> {
    let kept = Kept::of(node, activity, flow, earlier);
    let make = |point: &Point, step: &dyn Fn()| {
        if let Some(kept) = kept.point(point)? {
            return Ok(kept);
        }
        let config = point.config()?;
        let unit = point.family.unit();
        let mut made = flow.synthesise(&config, unit, step)?;
        let work = ActivityScenes::open(activity, &[unit])?.work(&config)?;
        activity.add((&config, unit), &mut made, &work, flow, step)?;
        let ends = path_ends(unit, &made, flow.library, flow.tools, flow.cache)?;
        Ok::<_, ExploreError>(GridPoint::new(point, &made.report, ends)?)
    };
    let points = in_parallel(points, jobs, activity.steps(), progress, make)?;
    Ok(Grid::new(flow.library, node, flow.tools, points))
}
