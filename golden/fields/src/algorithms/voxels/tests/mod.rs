#![allow(clippy::unwrap_used, clippy::panic)]

mod bound;
mod exact;
mod float;
mod halo;
mod work;

use glam::DVec3;
use potamoi_formats::config::Config;
use proptest::prelude::*;

use super::*;
use crate::volume::{MVoxels, Ray};
use crate::{
    BatchSize, FieldError, FieldFrame, FieldWork, FixedField, FixedOptions, FloatOptions,
    WithEarlyTermination, render_masked,
};
use potamoi_base::camera::Camera;
use potamoi_march::tiling::Halo;
use potamoi_march::{FixedFrame, FixedStats, MarchError};
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
use potamoi_reference::{GatherTask, ReferenceUnits, Units, weights};

/// A blob in a box that is not a whole number of MVoxels on a side.
fn blob(points: [usize; 3], layout: Layout) -> Grid {
    let voxel = 0.1;
    let size = DVec3::from(points.map(|p| (p - 1) as f64)) * voxel;
    Grid::bake(points, -size / 2.0, voxel, layout, |at, out| {
        let inside = 0.8 - at.length() + 0.2 * (7.0 * at.x).sin() * (5.0 * at.y).cos();
        out[0] = (3.0 * inside).clamp(-1.0, 2.0) as f32;
        for (i, v) in out[1..].iter_mut().enumerate() {
            *v = (0.4 + 0.3 * (at.x + at.y * i as f64 + at.z).sin()) as f32;
        }
    })
    .unwrap()
}

fn camera(width: u32, height: u32) -> Camera {
    Camera::look_at(
        DVec3::new(1.4, -2.2, 1.1),
        DVec3::ZERO,
        DVec3::Z,
        0.8,
        width,
        height,
    )
}

fn config(text: &str) -> Config {
    Config::from_toml(text, "test").unwrap()
}

fn field(grid: &Grid) -> StoredField {
    grid.clone().into()
}

fn mvoxels(grid: &Grid, config: &Config) -> Result<MVoxels, MarchError> {
    Ok(field(grid).fixed(config)?.0.mvoxels)
}

fn float(grid: &Grid, camera: &Camera, options: &FloatOptions) -> FieldFrame {
    render_masked(&field(grid), camera, options, None).unwrap()
}

/// Renders through units with a choice of halo.
fn through(
    field: &StoredField,
    config: &Config,
    halo: Halo,
    camera: &Camera,
    options: &FixedOptions,
    units: &mut dyn Units,
) -> Result<FixedFrame, FieldError> {
    FixedField::with_halo(field, config, halo)?.render(camera, options, units)
}

fn stepped(
    field: &StoredField,
    config: &Config,
    camera: &Camera,
    options: &FixedOptions,
) -> FixedFrame {
    let units = &mut ReferenceUnits::new(config);
    through(field, config, Halo::Shared, camera, options, units).unwrap()
}

fn fixed(grid: &Grid, config: &Config, camera: &Camera, options: &FixedOptions) -> FixedFrame {
    stepped(&field(grid), config, camera, options)
}

/// Batches of at most so many entries.
fn batch(entries: usize) -> Option<BatchSize> {
    Some(BatchSize {
        entries,
        ..BatchSize::VOLUME
    })
}

/// All work, with or without the test for empty space.
fn work(void_test: bool) -> FieldWork {
    FieldWork {
        void_test,
        ..FieldWork::ALL
    }
}

#[test]
fn order_of_work_changes_no_bit() {
    let (config, camera) = (config("[mvoxel]\nrows = 216"), camera(40, 36));
    for layout in [Layout::Constant, Layout::Linear] {
        let grid = blob([19, 16, 23], layout);
        let expected = fixed(&grid, &config, &camera, &FixedOptions::default());
        assert!(expected.stats.stopped > 20 && expected.stats.tasks > 20);
        for group_side in [1, 7, 16, 1000] {
            for (entries, void_test) in [(1, true), (1 << 18, true), (300, false)] {
                let options = FixedOptions {
                    group_side: Some(group_side),
                    batch: batch(entries),
                    work: work(void_test),
                    ..FixedOptions::default()
                };
                let found = fixed(&grid, &config, &camera, &options);
                assert_eq!(found.picture, expected.picture, "{options:?}");
                assert_eq!(found.transmittance, expected.transmittance, "{options:?}");
            }
        }
        // Nor does the size of MVoxels.
        for rows in [8, 27, 512] {
            let other = Config::from_toml(&format!("[mvoxel]\nrows = {rows}"), "test").unwrap();
            let found = fixed(&grid, &other, &camera, &FixedOptions::default());
            assert_eq!(found.picture, expected.picture, "{rows} rows");
        }
    }
}

/// Samples on and about the faces of voxels, MVoxels and the volume: one owner,
/// whose rows are the vertices around it.
#[test]
fn every_place_has_one_owner_with_its_vertices() {
    let points = [19, 16, 23];
    let grid = blob(points, Layout::Constant);
    let mvoxels = mvoxels(&grid, &config("")).unwrap();
    let density = Formats::new(&grid, &config("")).unwrap().density;
    assert_eq!(mvoxels.tiling().stride(), [7; 3]);
    let step = 2f64.powi(-12);
    let along = |axis: usize| {
        let last = (points[axis] - 1) as f64;
        let mut all = vec![-0.3, last, last - step, last + 0.2];
        for v in [0.0, 1.0, 6.0, 7.0, 8.0, 13.0, 14.0] {
            all.extend([v - step, v, v + step, v + 0.4]);
        }
        all
    };
    let bits = f64::from(1u32 << 12);
    let mut owners = 0;
    for x in along(0) {
        for y in along(1) {
            for z in along(2) {
                let place = mvoxels.tiling().locate([x, y, z]);
                let (first, extent) = (
                    mvoxels.tiling().first(place.mvoxel),
                    mvoxels.tiling().extent(place.mvoxel),
                );
                for (axis, at) in [x, y, z].into_iter().enumerate() {
                    let held = at.clamp(0.0, (points[axis] - 1) as f64);
                    let vertex = first[axis] + place.local[axis];
                    let fraction = f64::from(place.fraction[axis]) / bits;
                    assert!(
                        (vertex as f64 + fraction - held).abs() <= step / 2.0,
                        "{at}"
                    );
                    // The cell lies wholly in its owner.
                    assert!(place.local[axis] + 1 < extent[axis]);
                    assert!(fraction < 1.0 || at >= (points[axis] - 1) as f64 - step);
                }
                let wide = mvoxels.channels();
                for (corner, row) in mvoxels.tiling().corner_rows(&place).into_iter().enumerate() {
                    let vertex = [0, 1, 2].map(|a| first[a] + place.local[a] + (corner >> a & 1));
                    let index = vertex[0] + points[0] * (vertex[1] + points[1] * vertex[2]);
                    let exact = grid.features()[index * wide];
                    let code = mvoxels.rows(place.mvoxel)[usize::from(row) * wide];
                    let found = density.value(i128::from(code));
                    assert!((found - f64::from(exact)).abs() < 1e-3);
                }
                owners += 1;
            }
        }
    }
    assert!(owners > 10_000);
}

/// Eight vertices hold seven cells a side, so that (8/7)^3 = 1.49 times the
/// vertices are stored in bulk, and less with fewer MVoxels.
#[test]
fn the_halo_stores_shared_faces_twice() {
    for (cells, rows, expected) in [
        ([14, 7, 21], "512", 16.0 / 15.0 * (24.0 / 22.0)),
        // The last MVoxel along x has 2 of its 8 vertices, along y 4.
        ([8, 10, 7], "512", 10.0 / 9.0 * (12.0 / 11.0)),
        ([3, 3, 3], "8", 216.0 / 64.0),
        ([70, 70, 70], "512", (80.0f64 / 71.0).powi(3)),
    ] {
        let points = cells.map(|c| c + 1);
        let values = vec![0.0; points.iter().product::<usize>() * 4];
        let grid = Grid::new(points, DVec3::ZERO, 1.0, Layout::Constant, values).unwrap();
        let config = config(&format!("[mvoxel]\nrows = {rows}"));
        let found = mvoxels(&grid, &config).unwrap().duplication();
        assert!((found - expected).abs() < 1e-12, "{cells:?}: {found}");
    }
}

/// A constant field comes back exactly, since weights sum to exactly 1. Weights that are rounded
/// one by one do not.
#[test]
fn a_constant_field_comes_back_exactly() {
    for (weight_bits, worst_naive) in [(8, 100), (12, 5), (15, 0)] {
        let config = config(&format!("[gu]\nweight_bits = {weight_bits}"));
        let any = Config::from_toml(
            &format!("[gu]\nweight_bits = {weight_bits}\nweights = \"any\""),
            "test",
        )
        .unwrap();
        let gather = |config: &Config, split: bool| {
            let entries = (0..4000u32).map(|i| {
                let fraction =
                    [0, 12, 24].map(|s| (i.wrapping_mul(2_654_435_761) >> s) as u16 & 0xfff);
                let weights = if split {
                    weights::trilinear(fraction, weight_bits)
                } else {
                    let one = f64::from(1u32 << weight_bits);
                    let [x, y, z] = fraction.map(|f| f64::from(f) / 4096.0);
                    let mut w = [0; 8];
                    for (corner, w) in w.iter_mut().enumerate() {
                        let side =
                            |bit: usize, u: f64| if corner >> bit & 1 == 1 { u } else { 1.0 - u };
                        *w = (side(0, x) * side(1, y) * side(2, z) * one).round() as u16;
                    }
                    w
                };
                potamoi_formats::rit::RitEntry {
                    slot: 0,
                    rows: [0, 1, 2, 3, 4, 5, 6, 7],
                    weights,
                }
            });
            let task = GatherTask {
                vertices: potamoi_formats::rit::Vertices::Eight,
                channels: 1,
                rows: vec![32_767; 8],
                entries: entries.collect(),
            };
            let mut features = vec![];
            let flags = ReferenceGatheringUnit::new(config)
                .gather(&task, &mut features)
                .unwrap();
            let off = features.iter().map(|f| 32_767 - i32::from(*f)).max();
            (off.unwrap(), flags)
        };
        assert_eq!(gather(&config, true), (0, 0), "W = {weight_bits}");
        let (off, _) = gather(&any, false);
        assert!(
            off > worst_naive,
            "W = {weight_bits}: naive weights are {off} off"
        );
    }
}

/// Upper bound of the difference between fixed and float: rounding of features, weights,
/// fractions, opacities and sums in each visible sample.
#[test]
fn fixed_is_float_within_its_formats() {
    for layout in [Layout::Constant, Layout::Linear] {
        let grid = blob([19, 16, 23], layout);
        let camera = camera(48, 40);
        let float = float(&grid, &camera, &FloatOptions::default());
        let fine = fixed(&grid, &config(""), &camera, &FixedOptions::default());
        let psnr = fine.picture.psnr(&float.picture, |_| true).unwrap();
        assert!(psnr > 80.0, "{layout:?}: {psnr} dB");
        let coarse = Config::from_toml("[gu]\nfeature_bits = 8\nweight_bits = 4", "test").unwrap();
        let rough = fixed(&grid, &coarse, &camera, &FixedOptions::default());
        let rough = rough.picture.psnr(&float.picture, |_| true).unwrap();
        assert!(
            (25.0..psnr - 20.0).contains(&rough),
            "{layout:?}: {rough} dB"
        );
    }
}

#[test]
fn cameras_inside_behind_and_along_an_axis() {
    let grid = blob([19, 16, 23], Layout::Constant);
    let config = config("");
    for (eye, target) in [
        (DVec3::ZERO, DVec3::X),
        (DVec3::new(0.9, 0.75, 1.1), DVec3::new(0.9, 0.75, -9.0)),
        (DVec3::new(0.0, -5.0, 0.0), DVec3::ZERO),
        (DVec3::new(0.0, -5.0, 0.0), DVec3::new(0.0, -9.0, 0.0)),
        (DVec3::new(0.0, -1e7, 0.0), DVec3::ZERO),
    ] {
        let camera = Camera::look_at(eye, target, DVec3::new(0.1, 0.2, 1.0), 0.7, 17, 17);
        let float = float(&grid, &camera, &FloatOptions::default());
        let fixed = fixed(&grid, &config, &camera, &FixedOptions::default());
        let psnr = fixed.picture.psnr(&float.picture, |_| true).unwrap();
        assert!(psnr > 70.0, "{eye} {target}: {psnr} dB");
        assert!(fixed.picture.rgb.iter().flatten().all(|v| v.is_finite()));
    }
}

#[test]
fn what_cannot_be_rendered_is_refused_by_field() {
    let new = |points, voxel, features: Vec<f32>| {
        Grid::new(points, DVec3::ZERO, voxel, Layout::Constant, features)
    };
    let refused = |result: Result<Grid, MarchError>, field: &str| {
        let error = result.unwrap_err().to_string();
        assert!(error.contains(field), "{error}");
    };
    refused(new([1, 2, 2], 1.0, vec![]), "points");
    refused(new([2048; 3], 1.0, vec![]), "points");
    refused(new([usize::MAX; 3], 1.0, vec![]), "points");
    // Before a value is computed, or memory is taken for it.
    for points in [[2048; 3], [usize::MAX; 3], [2, 2, 0]] {
        let baked = Grid::bake(points, DVec3::ZERO, 1.0, Layout::Linear, |_, _| {
            panic!("a grid that is refused is not baked")
        });
        refused(baked, "points");
    }
    refused(new([2; 3], 1.0, vec![0.0; 31]), "features.len()");
    refused(new([2; 3], 0.0, vec![0.0; 32]), "voxel");
    for bad in [f32::NAN, f32::INFINITY] {
        let mut values = vec![0.0; 32];
        values[13] = bad;
        refused(new([2; 3], 1.0, values), "vertex 3, channel 1");
    }
    let grid = new([2; 3], 1.0, vec![0.0; 32]).unwrap();
    let view = |change: fn(&mut Camera)| {
        let mut camera = camera(4, 4);
        change(&mut camera);
        render_masked(&field(&grid), &camera, &FloatOptions::default(), None)
            .map(|_| ())
            .unwrap_err()
            .to_string()
    };
    assert!(view(|c| c.width = 0).contains("width"));
    assert!(view(|c| c.focal.x = f64::NAN).contains("focal"));
    assert!(view(|c| c.world_to_camera.translation.x = f64::INFINITY).contains("world_to_camera"));
    assert!(view(|c| c.world_to_camera.matrix3.x_axis *= 2.0).contains("world_to_camera"));
    assert!(view(|c| c.centre.y = f64::NAN).contains("centre"));
    assert!(view(|c| c.height = 1 << 31).contains("1 to 67108864"));
    assert!(view(|c| c.world_to_camera.translation.x = 1e12).contains("position"));
    for step in [0.0, -0.5, 9.0, f64::NAN] {
        let stepped = StoredField::new(grid.clone(), step);
        let error = render_masked(&stepped, &camera(4, 4), &FloatOptions::default(), None)
            .unwrap_err()
            .to_string();
        assert!(error.contains("step"), "{error}");
    }
    let option = |step: f64, change: fn(&mut FixedOptions)| {
        let mut options = FixedOptions::default();
        change(&mut options);
        let (field, config) = (StoredField::new(grid.clone(), step), config(""));
        let units = &mut ReferenceUnits::new(&config);
        let frame = through(
            &field,
            &config,
            Halo::Shared,
            &camera(4, 4),
            &options,
            units,
        );
        frame.unwrap_err().to_string()
    };
    assert!(option(STEP, |o| o.batch = batch(0)).contains("batch"));
    assert!(option(STEP, |o| o.group_side = Some(0)).contains("group_side"));
    assert!(option(STEP, |o| o.background[1] = f32::NAN).contains("background"));
    assert!(option(STEP, |o| o.background[2] = -8.0).contains("background"));
    assert!(option(1e-9, |_| ()).contains("step"));
    for (text, field) in [
        ("[mvoxel]\nrows = 4", "mvoxel.rows"),
        ("[gu]\nmodes = \"unstructured\"", "gu.modes"),
        ("[gu]\nvertices = [4, 2]", "`gu.vertices` is [4, 2]"),
        ("[vu]\nops = [\"relu\", \"multiply\"]", "vu.ops"),
        ("[gu]\nbanks = 1\nsegments = 3", "gu.segments"),
    ] {
        let error = mvoxels(&grid, &config(text)).unwrap_err().to_string();
        assert!(error.contains(field), "{error}");
    }
    let bright = new([2; 3], 1.0, vec![300.0; 32]).unwrap();
    let error = mvoxels(&bright, &config("")).unwrap_err().to_string();
    assert!(error.contains("colours below 256"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// A ray meets MVoxels at strictly increasing distances from the camera's,
    /// so that visiting them by distance is front to back for all rays at once.
    #[test]
    fn mvoxels_come_front_to_back(
        eye in prop::array::uniform3(-30.0f64..60.0),
        toward in prop::array::uniform3(-1.0f64..1.0),
        step in 0.1f64..2.0,
    ) {
        let points = [19, 16, 23];
        let grid = blob(points, Layout::Constant);
        let mvoxels = mvoxels(&grid, &Config::paper()).unwrap();
        let direction = DVec3::from(toward);
        prop_assume!(direction.length() > 0.01);
        let ray = Ray::new(points, DVec3::from(eye), direction.normalize(), step);
        let distances = mvoxels.distances(eye);
        let mut last = None;
        for k in 0..ray.samples {
            let owner = mvoxels.tiling().locate(ray.at(k).to_array()).mvoxel;
            if let Some((before, far)) = last
                && before != owner
            {
                prop_assert!(distances[owner] > far, "sample {k}");
            }
            last = Some((owner, distances[owner]));
        }
    }
}
