//! The floating-point picture of a grid against its definition, bit for bit.

use super::*;
use crate::volume::Rays;

/// Sums of a ray, sample by sample: colour, transmittance, depth along the ray in voxel edges.
fn alone(grid: &Grid, ray: &Ray, options: &FloatOptions) -> (DVec3, f64, f64) {
    let coefficients = grid.layout().coefficients();
    let terms = if options.directions { coefficients } else { 1 };
    let basis = [1.0, ray.direction.x, ray.direction.y, ray.direction.z];
    let mut values = vec![0f64; grid.layout().channels()];
    let (mut colour, mut left) = (DVec3::ZERO, 1.0);
    let (mut weights, mut moments) = (0.0, 0.0);
    for k in 0..ray.samples {
        grid.sample(ray.at(k), &mut values);
        let alpha = -(-values[0].max(0.0) * ray.step).exp_m1();
        if alpha == 0.0 {
            continue;
        }
        for c in 0..3 {
            let own = &values[1 + c * coefficients..][..terms];
            let sum: f64 = own.iter().zip(basis).map(|(v, b)| v * b).sum();
            colour[c] += left * alpha * sum.max(0.0);
        }
        weights += left * alpha;
        moments += left * alpha * ray.distance(k);
        left *= 1.0 - alpha;
        if options.terminate && left < STOP_BELOW {
            break;
        }
    }
    let distance = if weights > 0.0 {
        moments / weights
    } else {
        f64::INFINITY
    };
    (colour, left, distance)
}

/// A grid is rendered by the renderer of all fields, in vertex units, with the same bits as its
/// rays on their own.
#[test]
fn a_grid_on_the_road_of_all_fields_is_its_own_rays() {
    let camera = camera(40, 36);
    let plain = FloatOptions::default();
    let through = FloatOptions {
        terminate: false,
        background: [0.5, 0.25, 1.0],
        directions: false,
        ..FloatOptions::default()
    };
    for layout in [Layout::Constant, Layout::Linear] {
        let grid = blob([19, 16, 23], layout);
        for (step, options) in [(0.5, plain), (0.3, through)] {
            let field = StoredField::new(grid.clone(), step);
            let frame = render_masked(&field, &camera, &options, None).unwrap();
            let rays = Rays::placed(&grid.placement(), &camera, step).unwrap();
            let background = DVec3::from(options.background.map(f64::from));
            let mut seen = 0;
            for number in 0..camera.width * camera.height {
                let ray = rays.ray(number % camera.width, number / camera.width);
                let (colour, left, distance) = alone(&grid, &ray, &options);
                let rgb = (colour + left * background).to_array().map(|v| v as f32);
                let at = number as usize;
                assert_eq!(frame.picture.rgb[at], rgb, "{layout:?}, pixel {number}");
                assert_eq!(frame.transmittance[at].to_bits(), left.to_bits());
                let depth = distance * grid.voxel() * camera.slant(number);
                assert_eq!(frame.depth[at].to_bits(), depth.to_bits());
                seen += u32::from(left < 1.0);
            }
            assert!(seen > 100, "{seen}");
        }
    }
}
