//! The fixed renderer against a plain one, bit by bit, and identities between
//! integers.

use potamoi_formats::fixed::{Format, Rounding, round_shift};
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_march::ColourScale;

use super::*;
use potamoi_reference::vector_unit::ReferenceVectorUnit;

/// One ray after the other, one sample after the other, over the whole grid:
/// no MVoxels, no groups, no order but the ray's own.
struct Plain<'a> {
    grid: &'a Grid,
    formats: Formats,
    /// Step in voxel edges.
    step: f64,
    codes: Vec<i64>,
    unit: ReferenceVectorUnit,
}

impl<'a> Plain<'a> {
    fn new(field: &'a StoredField, config: &Config) -> Self {
        let grid = field.grid();
        let formats = Formats::new(grid, config).unwrap();
        let channels = grid.layout().channels();
        let code = |(i, v): (usize, &f32)| {
            let format = if i % channels == 0 {
                formats.density
            } else {
                formats.colour
            };
            let scale = 2f64.powi(Format::frac_bits(format) as i32);
            (f64::from(*v) * scale).round_ties_even() as i64
        };
        Self {
            grid,
            formats,
            step: field.step,
            codes: grid.features().iter().enumerate().map(code).collect(),
            unit: ReferenceVectorUnit::new(&config.vu),
        }
    }

    /// All channels at a position, weights by the split tree.
    fn gather(&self, at: DVec3) -> Vec<i64> {
        let points = self.grid.points();
        let (mut cell, mut u) = ([0; 3], [0; 3]);
        for axis in 0..3 {
            let last = points[axis] as i64 - 1;
            let code = ((at[axis] * 4096.0).round() as i64).clamp(0, last * 4096);
            cell[axis] = (code / 4096).min(last - 1);
            u[axis] = code - cell[axis] * 4096;
        }
        let bits = self.formats.weight_bits;
        let channels = self.grid.layout().channels();
        let mut sums = vec![0i64; channels];
        for corner in 0..8 {
            let far = [0, 1, 2].map(|axis| corner >> axis & 1);
            let mut weight = 1i64 << bits;
            for axis in [2, 1, 0] {
                let high = (weight * u[axis] + 2048) / 4096;
                weight = if far[axis] == 1 { high } else { weight - high };
            }
            let [x, y, z] = [0, 1, 2].map(|axis| (cell[axis] + far[axis]) as usize);
            let vertex = x + points[0] * (y + points[1] * z);
            for (sum, code) in sums.iter_mut().zip(&self.codes[vertex * channels..]) {
                *sum += weight * code;
            }
        }
        let even = |sum: i64| round_shift(sum.into(), bits, Rounding::HalfEven) as i64;
        sums.into_iter().map(even).collect()
    }

    /// The colour towards a direction, after its ReLU.
    fn colour(&self, features: &[i64], direction: DVec3) -> [i64; 3] {
        let d = direction.to_array().map(|v| (v * 16384.0).round() as i64);
        [0, 1, 2].map(|c| match self.grid.layout() {
            Layout::Constant => features[1 + c].max(0),
            Layout::Linear => {
                let f = &features[1 + 4 * c..][..4];
                let sum = f[0] * 16384 + f[1] * d[0] + f[2] * d[1] + f[3] * d[2];
                (round_shift(sum.into(), 14, Rounding::HalfEven) as i64).max(0)
            }
        })
    }

    /// Colour, 32 fraction bits, and transmittance of a pixel.
    fn pixel(&self, ray: &Ray, options: &FixedOptions) -> ([f32; 3], u32) {
        let (mut left, mut colour) = (1i64 << 20, [0i64; 3]);
        let step = (self.step * f64::from(1 << 24)).round() as i64;
        for k in 0..ray.samples {
            let features = self.gather(ray.at(k));
            let depth = (features[0].max(0) * step) >> self.formats.depth_shift();
            let depth = depth.min(i64::from(i32::MAX)) as i32;
            let alpha = self
                .unit
                .element(VectorOp::new(OpCode::OneMinusExp), depth, 0)
                .unwrap();
            let exact = left * (65536 - i64::from(alpha));
            let next = (exact + 32768) / 65536;
            for (sum, c) in colour.iter_mut().zip(self.colour(&features, ray.direction)) {
                let (exact, shift) = (
                    (left - next) * c,
                    ColourScale::of(self.formats.colour.frac_bits()).shift(),
                );
                *sum += round_shift(exact.into(), shift, Rounding::HalfEven) as i64;
            }
            left = next;
            // 1e-3 with 36 fraction bits, rounded up.
            if options.terminate && exact < 68_719_477 {
                break;
            }
        }
        let finished = [0, 1, 2].map(|c| {
            let behind = (f64::from(options.background[c]) * 4096.0).round_ties_even() as i64;
            let up = 32 - self.formats.pixel_bits();
            (((colour[c] << up) + left * behind) as f64 / f64::from(2).powi(32)) as f32
        });
        (finished, left as u32)
    }

    fn agrees(&self, camera: &Camera, options: &FixedOptions, frame: &FixedFrame) {
        for y in 0..camera.height {
            for x in 0..camera.width {
                let origin = self.grid.to_grid(camera.position());
                let (_, direction) = camera.ray(x, y);
                let ray = Ray::new(self.grid.points(), origin, direction, self.step);
                let (rgb, left) = self.pixel(&ray, options);
                let i = (y * camera.width + x) as usize;
                assert_eq!(frame.transmittance[i], left, "{x} {y} {options:?}");
                assert_eq!(frame.picture.rgb[i], rgb, "{x} {y} {options:?}");
            }
        }
    }
}

/// Rays stop exactly where they would alone, whatever they share an MVoxel
/// with: cameras outside, inside, far off, and looking along an axis in a face
/// that two MVoxels share (vertex 7 along x).
#[test]
fn a_plain_renderer_gives_the_same_bits() {
    let points = [15, 16, 22];
    for (layout, text) in [
        (Layout::Constant, ""),
        (Layout::Linear, "[gu]\nfeature_bits = 12\nweight_bits = 9"),
    ] {
        let config = config(text);
        let field = StoredField::new(blob(points, layout), 0.4);
        let plain = Plain::new(&field, &config);
        for (eye, target) in [
            (DVec3::new(1.4, -2.2, 1.1), DVec3::ZERO),
            (DVec3::ZERO, DVec3::new(1.0, 0.2, -0.3)),
            (DVec3::new(0.0, -5.0, 0.0), DVec3::ZERO),
            (DVec3::new(-1e7, 2e6, 0.0), DVec3::ZERO),
        ] {
            // An odd size: the ray in the middle runs along the view.
            let camera = Camera::look_at(eye, target, DVec3::Z, 0.7, 21, 17);
            for (group_side, terminate) in [(Some(1), true), (Some(5), true), (None, false)] {
                let options = FixedOptions {
                    terminate,
                    background: [0.07, 0.5, 2.0],
                    group_side,
                    ..FixedOptions::default()
                };
                let frame = stepped(&field, &config, &camera, &options);
                plain.agrees(&camera, &options, &frame);
            }
        }
    }
}

/// Densities and steps at their limits saturate in the vector unit, not before.
#[test]
fn walls_as_dense_as_formats_allow_are_opaque_at_once() {
    let grid = Grid::bake([9; 3], DVec3::ZERO, 1.0, Layout::Constant, |at, out| {
        let wall = if at.x > 3.0 { 4095.0 } else { -4095.0 };
        out.copy_from_slice(&[wall, 255.0, 1.0, -255.0]);
    })
    .unwrap();
    let config = config("");
    let camera = Camera::look_at(
        DVec3::new(-9.0, 4.1, 3.9),
        DVec3::splat(4.0),
        DVec3::Z,
        0.4,
        9,
        9,
    );
    for step in [1.0 / 64.0, 1.0, 8.0] {
        let field = StoredField::new(grid.clone(), step);
        let plain = Plain::new(&field, &config);
        let options = FixedOptions::default();
        let frame = stepped(&field, &config, &camera, &options);
        plain.agrees(&camera, &options, &frame);
        let [red, green, blue] = frame.picture.rgb[40];
        assert!(red > 254.0 && green > 0.999 && blue == 0.0, "{step}");
    }
}

/// A density at which the exact product T (65536 - alpha) says stop and the
/// same rounded to U1.20 says go on: the ray stops.
#[test]
fn rays_stop_by_the_exact_product() {
    let config = config("");
    let unit = ReferenceVectorUnit::new(&config.vu);
    let limit = 68_719_477;
    let tells = |code: &i32| {
        // Densities have 15 fraction bits, depths 20: no bit is lost.
        let op = VectorOp::new(OpCode::OneMinusExp);
        let alpha = i64::from(unit.element(op, code << 5, 0).unwrap());
        let mut left = 1i64 << 20;
        loop {
            let exact = left * (65536 - alpha);
            left = (exact + 32768) >> 16;
            if exact < limit {
                return left << 16 >= limit;
            }
        }
    };
    let code = (200..4000).find(tells).unwrap();
    let density = code as f32 / 32768.0;
    let grid = Grid::bake(
        [2, 2, 2000],
        DVec3::ZERO,
        1.0,
        Layout::Constant,
        |_, out| {
            out.copy_from_slice(&[density, 0.9, 0.5, 0.1]);
        },
    )
    .unwrap();
    let (field, options) = (StoredField::new(grid, 1.0), FixedOptions::default());
    let frame = stepped(&field, &config, &along(3), &options);
    assert_eq!(frame.stats.stopped, 9);
    Plain::new(&field, &config).agrees(&along(3), &options, &frame);
}

/// The weights T - T' of more than 4,096 samples and what is left sum to
/// exactly 1: grey paint on the same grey is that grey to the bit, as products
/// with the code of 1/2 are exact.
#[test]
fn weights_and_transmittance_sum_to_exactly_one() {
    let points = [2, 2, 1500];
    let grid = Grid::bake(points, DVec3::ZERO, 1.0, Layout::Constant, |_, out| {
        out.copy_from_slice(&[0.002, 0.5, 0.5, 0.5]);
    })
    .unwrap();
    let options = FixedOptions {
        terminate: false,
        background: [0.5; 3],
        ..FixedOptions::default()
    };
    let field = StoredField::new(grid, 0.25);
    let frame = stepped(&field, &config(""), &along(3), &options);
    assert!(
        frame.stats.outcomes.composited > 9 * 4096,
        "{:?}",
        frame.stats
    );
    let left = frame.transmittance[4];
    assert!(left < 1 << 17, "{left}");
    assert!(frame.picture.rgb.iter().all(|p| *p == [0.5; 3]));
    // Weights T alpha that are cut off by themselves fall short.
    let alpha = (65536.0 * -(-0.0005f64).exp_m1()).round() as u64;
    let (mut t, mut sum) = (1u64 << 20, 0);
    for _ in 0..5000 {
        sum += (t * alpha) >> 16;
        t = (t * (65536 - alpha) + 32768) >> 16;
    }
    assert!(sum + t + 2000 < 1 << 20, "{sum} {t}");
}

/// Empty space shows the background to the bit. An alpha taken as 1 less the
/// exponential's result, which saturates below 1, would dim it.
#[test]
fn empty_space_takes_no_light() {
    let points = [2, 2, 1001];
    let grid = Grid::bake(points, DVec3::ZERO, 1.0, Layout::Constant, |_, out| {
        out.copy_from_slice(&[0.0, 1.0, 1.0, 1.0]);
    })
    .unwrap();
    let options = FixedOptions {
        background: [0.25, 0.5, 0.75],
        work: work(false),
        ..FixedOptions::default()
    };
    let field = StoredField::new(grid, 1.0);
    let frame = stepped(&field, &config(""), &along(2), &options);
    assert!(frame.stats.vector_elements[&OpCode::OneMinusExp] >= 4 * 1000);
    assert!(frame.picture.rgb.iter().all(|p| *p == options.background));
    assert!(frame.transmittance.iter().all(|t| *t == 1 << 20));
    let unit = ReferenceVectorUnit::new(&config("").vu);
    let at_zero = |code| unit.element(VectorOp::new(code), 0, 0).unwrap();
    assert_eq!(at_zero(OpCode::OneMinusExp), 0);
    let naive = 65536 - i64::from(at_zero(OpCode::Exp));
    let left = (0..1000).fold(1i64 << 20, |t, _| (t * (65536 - naive) + 32768) >> 16);
    assert!((left as f64 / f64::from(1 << 20) - 0.985).abs() < 1e-3);
    // A grid without any density is not even gathered.
    let skipped = FixedOptions {
        work: work(true),
        ..options
    };
    let frame = stepped(&field, &config(""), &along(2), &skipped);
    assert_eq!((frame.stats.tasks, frame.stats.entries), (0, 0));
    assert!(frame.picture.rgb.iter().all(|p| *p == options.background));
}

/// A camera that looks along z through grids of one cell a layer.
fn along(side: u32) -> Camera {
    let (eye, target) = (DVec3::new(0.5, 0.5, -3.0), DVec3::new(0.5, 0.5, 9.0));
    Camera::look_at(eye, target, DVec3::Y, 2e-4, side, side)
}
