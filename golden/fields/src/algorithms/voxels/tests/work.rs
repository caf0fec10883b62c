//! Independence of the units' work from threads, and failing units.

use potamoi_formats::units::VectorOp;

use super::*;
use potamoi_reference::observer::Observed;
use potamoi_reference::splat_unit::{Composited, SplatJob};
use potamoi_reference::trace_recorder::{Limits, Recorder};
use potamoi_reference::{Product, UnitError};

/// The gathering tasks of a frame, in order.
fn tasks(grid: &Grid, config: &Config, camera: &Camera, options: &FixedOptions) -> Vec<GatherTask> {
    let (mut twins, mut recorder) = (ReferenceUnits::new(config), Recorder::new(Limits::NONE));
    let mut units = Observed::new(&mut twins, config).by(&mut recorder);
    let field = field(grid);
    through(&field, config, Halo::Shared, camera, options, &mut units).unwrap();
    recorder
        .gathered
        .into_iter()
        .map(|call| call.task)
        .collect()
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let grid = blob([19, 16, 23], Layout::Linear);
    let (config, camera) = (config(""), camera(40, 36));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let options = FixedOptions::default();
            (
                fixed(&grid, &config, &camera, &options),
                float(&grid, &camera, &FloatOptions::default()),
                tasks(&grid, &config, &camera, &options),
            )
        })
    };
    let expected = with(1);
    for threads in [2, 5] {
        assert_eq!(with(threads), expected, "{threads} threads");
    }
}

#[test]
fn every_mvoxel_is_loaded_as_far_as_it_is_used() {
    let grid = blob([19, 16, 23], Layout::Linear);
    let (config, camera) = (config("[mvoxel]\nrows = 216"), camera(40, 36));
    let options = FixedOptions {
        terminate: false,
        group_side: Some(16),
        ..FixedOptions::default()
    };
    let all = tasks(&grid, &config, &camera, &options);
    let frame = fixed(&grid, &config, &camera, &options);
    let entries: usize = all.iter().map(|t| t.entries.len()).sum();
    let stats = &frame.stats;
    assert_eq!((stats.groups, stats.rays), (9, 40 * 36));
    assert_eq!(
        (stats.tasks, stats.entries),
        (all.len() as u64, entries as u64)
    );
    assert_eq!(stats.streams.rit_written, 48 * stats.entries);
    assert_eq!(stats.features, 13 * stats.entries);
    let bytes: usize = all.iter().map(|t| 2 * t.rows.len()).sum();
    assert_eq!(stats.streams.mvoxels_read, bytes as u64);
    assert!(stats.entries < stats.samples && stats.stopped == 0);
    for task in &all {
        let rows = task.rows.len() / 13;
        assert!(rows <= 216 && !task.entries.is_empty());
        let mut last = 0;
        for entry in &task.entries {
            // By ray, and of rows that are loaded; weights sum to 1.
            assert!(entry.slot >= last && entry.slot < 256);
            last = entry.slot;
            assert!(entry.rows.iter().all(|r| usize::from(*r) < rows));
            let sum: u32 = entry.weights.iter().map(|w| u32::from(*w)).sum();
            assert_eq!(sum, 1 << config.gu.weight_bits);
        }
        // No more rows than the last that is used.
        let used = task.entries.iter().flat_map(|e| e.rows).max();
        assert_eq!(used.map(|r| usize::from(r) + 1), Some(rows));
    }
}

/// Units that lose a feature.
struct Broken {
    twins: ReferenceUnits,
}

impl Units for Broken {
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        self.twins.gather(tasks, features)?;
        features.pop();
        Ok(())
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        self.twins.sums(tasks, sums)
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        self.twins.vector(op, a, b, out)
    }

    fn splats(&mut self, job: &SplatJob<'_>) -> Result<Composited, UnitError> {
        self.twins.splats(job)
    }

    fn multiplied(&mut self, product: Product) {
        self.twins.multiplied(product);
    }
}

#[test]
fn units_at_fault_are_found_out() {
    let grid = blob([19, 16, 23], Layout::Constant);
    let config = config("");
    let (field, view) = (field(&grid), camera(9, 9));
    let said = |units: &mut dyn Units| {
        let options = FixedOptions::default();
        let frame = through(&field, &config, Halo::Shared, &view, &options, units);
        frame.unwrap_err().to_string()
    };
    let twins = ReferenceUnits::new(&config);
    let short = said(&mut Broken { twins });
    assert!(short.contains("feature channels, expected"), "{short}");
    // Built for fewer channels than the MVoxels hold.
    let narrow = Config::from_toml("[gu]\nbanks = 2\nsegments = 1", "test").unwrap();
    let refused = said(&mut ReferenceUnits::new(&narrow));
    assert!(refused.contains("a unit failed: task 0"), "{refused}");
}
