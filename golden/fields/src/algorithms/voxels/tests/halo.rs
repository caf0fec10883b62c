//! Shared and split halos: the same picture, bit for bit.

use potamoi_formats::config::Sums;

use super::*;

/// Renders with both halos, compares the pictures, and returns the counts of both.
fn same(
    field: &StoredField,
    config: &Config,
    camera: &Camera,
    options: &FixedOptions,
) -> [FixedStats; 2] {
    let [a, b] = [Halo::Shared, Halo::Split].map(|halo| {
        let mut units = ReferenceUnits::new(config);
        let frame = through(field, config, halo, camera, options, &mut units).unwrap();
        let whole = frame.stats.entries - frame.stats.split_entries;
        assert_eq!(units.counts().feature_vectors, whole);
        assert_eq!(
            units.gather_flags() & !potamoi_reference::gathering_unit::FLAG_SUM,
            0
        );
        frame
    });
    assert_eq!(a.picture, b.picture, "{options:?}");
    assert_eq!(a.transmittance, b.transmittance, "{options:?}");
    // A unit that returns the sums of parts itself.
    let mut exact = config.clone();
    exact.gu.sums = Sums::Exact;
    let mut units = ReferenceUnits::new(&exact);
    let c = through(field, &exact, Halo::Split, camera, options, &mut units).unwrap();
    assert_eq!(units.counts().feature_vectors, c.stats.entries);
    assert_eq!(units.gather_flags(), 0);
    assert_eq!((a.picture, a.transmittance), (c.picture, c.transmittance));
    assert_eq!(b.stats.split_entries, c.stats.split_entries);
    [a.stats, b.stats]
}

#[test]
fn split_halos_give_the_picture_of_shared_ones_for_every_ray_group() {
    let points = [23, 16, 26];
    for (layout, text) in [
        (Layout::Constant, "[mvoxel]\nrows = 216"),
        (Layout::Linear, "[gu]\nfeature_bits = 12\nweight_bits = 9"),
    ] {
        let (grid, config) = (blob(points, layout), config(text));
        for (eye, target) in [
            (DVec3::new(1.4, -2.2, 1.1), DVec3::ZERO),
            // Inside, where a later sample can be complete first.
            (DVec3::new(0.02, 0.01, -0.03), DVec3::new(-1.0, -0.4, -0.3)),
        ] {
            let camera = Camera::look_at(eye, target, DVec3::Z, 0.9, 64, 48);
            let mut before: Option<[FixedStats; 2]> = None;
            for side in [16, 17, 24, 32, 48, 64] {
                let options = FixedOptions {
                    group_side: Some(side),
                    batch: batch([1 << 18, 50][side as usize % 2]),
                    ..FixedOptions::default()
                };
                let [shared, split] = same(&field(&grid), &config, &camera, &options);
                assert!(shared.stopped > 20, "{shared:?}");
                assert_eq!(shared.stopped, split.stopped);
                assert_eq!(shared.outcomes.composited, split.outcomes.composited);
                assert_eq!((shared.split_entries, shared.waiting), (0, 0));
                assert!(split.split_entries > split.entries / 4 && split.waiting > 0);
                let sums = split.split_entries * grid.layout().channels() as u64;
                assert_eq!(split.streams.partial_sums, 4 * sums);
                // A group of four needs no more rows than the four.
                if side.is_power_of_two() {
                    if let Some([a, b]) = &before {
                        assert!(a.streams.mvoxels_read >= shared.streams.mvoxels_read);
                        assert!(b.streams.mvoxels_read >= split.streams.mvoxels_read);
                    }
                    before = Some([shared, split]);
                }
            }
        }
    }
}

/// Every vertex once, and every corner of every cell in one of its holders,
/// where it has the codes that it has with shared faces.
#[test]
fn nothing_is_stored_twice_and_every_corner_is_found_once() {
    let points = [9, 16, 11];
    let grid = blob(points, Layout::Constant);
    for rows in [8, 27, 64, 512] {
        let shared = mvoxels(&grid, &config(&format!("[mvoxel]\nrows = {rows}"))).unwrap();
        let split = shared.with_halo(Halo::Split);
        assert!(shared.duplication() > 1.0 && split.duplication() == 1.0);
        assert_eq!(split.with_halo(Halo::Shared), shared);
        let channels = split.channels();
        let code = |m: &MVoxels, mvoxel: usize, row: u16| {
            m.rows(mvoxel)[usize::from(row) * channels..][..channels].to_vec()
        };
        let (mut entries, mut cells) = (0, 0);
        for z in 0..points[2] - 1 {
            for y in 0..points[1] - 1 {
                for x in 0..points[0] - 1 {
                    let at = [x, y, z].map(|v| v as f64 + 0.25);
                    let (here, there) = (shared.tiling().locate(at), split.tiling().locate(at));
                    let expected = shared.tiling().corner_rows(&here);
                    assert_eq!(shared.tiling().holders(&here).count(), 1);
                    assert_eq!(
                        shared.is_cell_occupied(&here),
                        split.is_cell_occupied(&there)
                    );
                    let mut found = 0u8;
                    for holder in split.tiling().holders(&there) {
                        let (own, held) = split.tiling().part_rows(&there, holder);
                        assert_eq!(found & held, 0);
                        found |= held;
                        for corner in (0..8).filter(|c| held >> c & 1 == 1) {
                            assert_eq!(
                                code(&split, holder.mvoxel, own[corner]),
                                code(&shared, here.mvoxel, expected[corner])
                            );
                        }
                        entries += 1;
                    }
                    assert_eq!(found, u8::MAX);
                    cells += 1;
                }
            }
        }
        assert!(entries > cells, "{rows}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Arbitrary small grids, MVoxels of 2 to 8 vertices an edge, and arbitrary cameras.
    #[test]
    fn any_grid_looks_the_same_with_both_halos(
        points in prop::array::uniform3(2usize..12),
        seed in any::<u64>(),
        eye in prop::array::uniform3(-4.0..14.0f64),
        rows in prop::sample::select(vec![8u32, 27, 64, 125, 512]),
        side in 1u32..14,
        step in 0.1..2.0f64,
        entries in prop::sample::select(vec![1usize, 30, 1 << 18]),
        void_test in any::<bool>(),
    ) {
        let mut state = seed | 1;
        let mut random = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 40) as f32 / (1u32 << 24) as f32
        };
        let grid = Grid::bake(points, DVec3::ZERO, 1.0, Layout::Constant, |_, out| {
            out[0] = (4.0 * random() - 2.5).max(-1.0);
            out[1..].fill_with(&mut random);
        }).unwrap();
        let middle = DVec3::from(points.map(|p| (p - 1) as f64 / 2.0));
        let eye = DVec3::from(eye);
        prop_assume!((eye - middle).truncate().length() > 0.1);
        let camera = Camera::look_at(eye, middle, DVec3::Z, 1.2, 13, 11);
        let options = FixedOptions {
            group_side: Some(side),
            batch: batch(entries),
            work: work(void_test),
            background: [0.25, 0.5, 1.0],
            ..FixedOptions::default()
        };
        let config = config(&format!("[mvoxel]\nrows = {rows}"));
        same(&StoredField::new(grid, step), &config, &camera, &options);
    }
}
