//! Orders of splats, ray groups and MVoxels, and what is refused.

use std::collections::BTreeSet;

use potamoi_base::camera::Camera;
use potamoi_formats::config::SplatOpacity;
use potamoi_formats::record::SplatRecord;
use potamoi_gaussians::Cloud;
use potamoi_splats::{
    Cells, FixedOptions, FloatOptions, Load, Order, Profile, ScheduleOptions, render_fixed,
    render_float, tasks,
};

use super::{APART, LOG, fixed, small};
use crate::splats_common::PlainUnits;

#[test]
fn the_picture_depends_on_neither_groups_nor_mvoxels() {
    let (cloud, camera) = small();
    let whole = fixed(&cloud, &camera, Profile::Inria, &LOG);
    for (rows, group_tiles, cells) in [
        (512, Some([1, 1]), Cells::MERGED),
        (
            512,
            Some([1, 1]),
            Cells {
                halvings: 2,
                merge: false,
            },
        ),
        (64, Some([4, 3]), Cells::MERGED),
        (64, None, APART),
        (7, None, Cells::MERGED),
        (65536, None, Cells::MERGED),
    ] {
        let options = FixedOptions {
            schedule: ScheduleOptions {
                rows,
                group_tiles,
                cells,
                limits: None,
                opacity: SplatOpacity::Multiplied,
            },
            hold_records: 10,
            ..LOG
        };
        let other = fixed(&cloud, &camera, Profile::Inria, &options);
        assert_eq!(other.picture, whole.picture, "{rows} {group_tiles:?}");
        assert_eq!(other.transmittance, whole.transmittance);
        assert_eq!(other.decisions, whole.decisions);
        assert_eq!(other.stats.gathers, whole.stats.gathers);
        assert_eq!(other.stats.exponentials, whole.stats.exponentials);
        // One MVoxel needs nothing held back.
        assert_eq!(other.stats.hold.spilled > 0, rows != 65536);
    }
}

#[test]
fn any_permutation_gives_the_same_bits_even_in_depth_ties() {
    let (cloud, camera) = small();
    // Every Gaussian twice, the second in another colour: exact depth ties.
    let n = cloud.len();
    let order: Vec<usize> = (0..n).chain(0..n).collect();
    let twice = cloud.select(&order).unwrap();
    let sh = (0..2 * n)
        .flat_map(|i| {
            twice
                .sh(i)
                .iter()
                .map(move |c| c.map(|v| if i < n { v } else { 0.3 - v }))
        })
        .collect();
    let twice = Cloud::new(
        twice.degree(),
        twice.means().to_vec(),
        twice.log_scales().to_vec(),
        twice.rotations().to_vec(),
        twice.opacity_logits().to_vec(),
        sh,
    )
    .unwrap();
    let reversed: Vec<usize> = (0..2 * n).rev().collect();
    let strided: Vec<usize> = (0..2 * n).map(|i| (i * 7919) % (2 * n)).collect();
    assert!(!(2 * n).is_multiple_of(7919));
    for order in [Order::Exact, Order::Approximate] {
        let options = FixedOptions { order, ..LOG };
        let plain = fixed(&twice, &camera, Profile::Inria, &options);
        let float = render_float(&twice, &camera, Profile::Inria, &FloatOptions::default());
        let float = float.unwrap();
        for permutation in [&reversed, &strided] {
            let other = twice.select(permutation).unwrap();
            assert_eq!(fixed(&other, &camera, Profile::Inria, &options), plain);
            let again = render_float(&other, &camera, Profile::Inria, &FloatOptions::default());
            assert_eq!(again.unwrap(), float);
        }
    }
    // The tie-break matters: file order would have shown.
    let naive = |c: &Cloud| {
        let mut depth: Vec<(f32, usize)> = c.means().iter().map(|m| (m[2], 0)).collect();
        depth.iter_mut().enumerate().for_each(|(i, d)| d.1 = i);
        depth.sort_by(|a, b| a.0.total_cmp(&b.0));
        depth.iter().map(|d| c.sh(d.1)[0]).collect::<Vec<_>>()
    };
    assert_ne!(naive(&twice), naive(&twice.select(&reversed).unwrap()));
}

#[test]
fn the_approximate_order_is_counted_and_shows() {
    let (cloud, camera) = small();
    let exact = fixed(&cloud, &camera, Profile::Inria, &LOG);
    let options = FixedOptions {
        order: Order::Approximate,
        ..LOG
    };
    let loose = fixed(&cloud, &camera, Profile::Inria, &options);
    assert_eq!(exact.stats.inversions, 0);
    assert!(loose.stats.inversions > 0);
    assert_eq!(loose.stats.gathers, exact.stats.gathers);
    let psnr = loose.picture.psnr(&exact.picture, |_| true).unwrap();
    assert!(psnr > 15.0 && psnr < 80.0, "{psnr}");
    // With a single MVoxel, arrival is rank order.
    let one = FixedOptions {
        schedule: ScheduleOptions {
            rows: 65536,
            group_tiles: None,
            cells: Cells::MERGED,
            limits: None,
            opacity: SplatOpacity::Multiplied,
        },
        ..options
    };
    let one = fixed(&cloud, &camera, Profile::Inria, &one);
    assert_eq!((one.stats.inversions, one.picture), (0, exact.picture));
}

#[test]
fn tasks_alone_are_what_rendering_gathers() {
    let (cloud, camera) = small();
    let options = ScheduleOptions {
        rows: 100,
        group_tiles: Some([3, 2]),
        cells: Cells::MERGED,
        limits: None,
        opacity: SplatOpacity::Multiplied,
    };
    let groups = tasks(&cloud, &camera, Profile::Inria, &options).unwrap();
    let mut units = PlainUnits::default();
    let fixed_options = FixedOptions {
        schedule: options,
        ..LOG
    };
    let frame = render_fixed(&cloud, &camera, Profile::Inria, &fixed_options, &mut units).unwrap();
    let all: Vec<_> = groups.iter().flat_map(|g| &g.tasks).collect();
    assert_eq!(frame.stats.tasks, all.len() as u64);
    let entries: usize = all.iter().map(|t| t.entries.len()).sum();
    assert_eq!(frame.stats.gathers, entries as u64);
    let rows: Vec<usize> = all.iter().map(|t| t.rows.len() / 16).collect();
    assert_eq!(units.loaded, rows);
    // What the units load is what is counted.
    let loaded = 32 * rows.iter().sum::<usize>() as u64;
    assert_eq!(frame.stats.streams.mvoxels_read, loaded);
    let (mut partly, mut fetched) = (0, 0);
    for group in &groups {
        assert!(group.mvoxels.is_sorted_by_key(|m| m.min_rank));
        for (task, mvoxel) in group.tasks.iter().zip(&group.mvoxels) {
            let rows = task.rows.as_chunks::<16>().0;
            let rank = |row: &[i16; 16]| SplatRecord::from_channels(row).rank;
            assert!(rows.is_sorted_by(|a, b| rank(a) < rank(b)) && rows.len() <= 100);
            let used: BTreeSet<u16> = task.entries.iter().map(|e| e.rows[0]).collect();
            match mvoxel.load {
                Load::Streamed => {
                    assert_eq!(used.last().map(|r| usize::from(*r) + 1), Some(rows.len()));
                    partly += usize::from(used.len() < rows.len());
                }
                Load::Fetched => {
                    assert_eq!(used.len(), rows.len());
                    fetched += 1;
                }
            }
            let first = usize::from(*used.first().unwrap());
            assert_eq!(rank(&rows[first]), mvoxel.min_rank);
            let slots = group.tiles.len();
            assert!(task.entries.iter().all(|e| (e.slot as usize) < slots));
        }
    }
    assert!(partly > 0 && fetched > 0, "{partly} {fetched}");
}

#[test]
fn units_that_return_too_little_are_found_out() {
    struct Forgetful(PlainUnits);
    impl potamoi_reference::Units for Forgetful {
        fn gather(
            &mut self,
            tasks: &[potamoi_reference::GatherTask],
            features: &mut Vec<i16>,
        ) -> Result<(), potamoi_reference::UnitError> {
            self.0.gather(tasks, features)?;
            features.pop();
            Ok(())
        }
        fn sums(
            &mut self,
            tasks: &[potamoi_reference::GatherTask],
            sums: &mut Vec<i32>,
        ) -> Result<(), potamoi_reference::UnitError> {
            self.0.sums(tasks, sums)
        }
        fn vector(
            &mut self,
            op: potamoi_formats::units::VectorOp,
            a: &[i32],
            b: &[i32],
            out: &mut [i32],
        ) -> Result<(), potamoi_reference::UnitError> {
            self.0.vector(op, a, b, out)
        }
        fn splats(
            &mut self,
            job: &potamoi_reference::splat_unit::SplatJob<'_>,
        ) -> Result<potamoi_reference::splat_unit::Composited, potamoi_reference::UnitError>
        {
            self.0.splats(job)
        }
        fn multiplied(&mut self, product: potamoi_reference::Product) {
            self.0.multiplied(product);
        }
    }
    let (cloud, camera) = small();
    let mut units = Forgetful(PlainUnits::default());
    let failed = render_fixed(&cloud, &camera, Profile::Inria, &LOG, &mut units);
    assert!(failed.unwrap_err().to_string().contains("feature channels"));
}

#[test]
fn options_out_of_range_are_refused() {
    let (cloud, camera) = small();
    let refused = |schedule: ScheduleOptions, camera: &Camera| {
        let options = FixedOptions { schedule, ..LOG };
        let r = render_fixed(
            &cloud,
            camera,
            Profile::Inria,
            &options,
            &mut PlainUnits::default(),
        );
        r.unwrap_err().to_string()
    };
    let plain = ScheduleOptions::default();
    assert!(
        refused(
            ScheduleOptions {
                rows: 0,
                ..plain.clone()
            },
            &camera
        )
        .contains("`rows`")
    );
    let none = Some([0, 4]);
    assert!(
        refused(
            ScheduleOptions {
                group_tiles: none,
                ..plain.clone()
            },
            &camera
        )
        .contains("group_tiles")
    );
    let wide = camera.resized(8192, 4096);
    assert!(refused(plain, &wide).contains("131072 tiles"));
}
