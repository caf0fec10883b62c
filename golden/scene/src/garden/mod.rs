//! The built-in splat scene: a flowering tree on a floating island.
//!
//! Generated from rules and a fixed seed, without a data file, and lit during generation: a sun, a
//! sky, and the shadow of the tree. Spherical harmonics of degree 1 let petals and leaves glow
//! against the sun, and water mirror it. The world is y up, in metres of a small garden.

mod island;
mod light;
mod paint;
mod plants;
mod random;

use glam::DVec3;

use light::Light;
use paint::Painter;
use potamoi_base::camera::Camera;
use potamoi_gaussians::Cloud;
use random::Random;

/// Linear RGB of the sky behind the garden.
pub const BACKGROUND: [f32; 3] = [0.75, 0.875, 0.9375];

/// The Gaussians, about five thousand; the same ones at every call.
#[must_use]
pub fn cloud() -> Cloud {
    let mut random = Random::new(0x5eed_9a2d);
    let crown = plants::crown(&mut random);
    let light = Light::new(crown.iter().map(|b| (b.centre, b.radius)).collect());
    let mut painter = Painter::new(light);
    island::ground(&mut painter, &mut random);
    island::rock(&mut painter, &mut random);
    island::pond(&mut painter, &mut random);
    plants::grass(&mut painter, &mut random);
    plants::flowers(&mut painter, &mut random);
    plants::trunk(&mut painter, &mut random, &crown);
    plants::blossom(&mut painter, &mut random, &crown);
    plants::fallen_petals(&mut painter, &mut random);
    plants::butterflies(&mut painter);
    painter.finish()
}

/// The default view, 400 x 400 pixels.
#[must_use]
pub fn camera() -> Camera {
    Camera::look_at(
        DVec3::new(2.7, 2.0, 4.3),
        DVec3::new(0.0, 0.42, 0.0),
        DVec3::Y,
        50f64.to_radians(),
        400,
        400,
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_splats::{FloatOptions, Profile, View, render_float};

    #[test]
    fn it_is_the_same_garden_every_time() {
        let c = cloud();
        assert_eq!(c, cloud());
        assert!((3000..=6000).contains(&c.len()), "{}", c.len());
        assert!(c.degree() >= 1);
    }

    #[test]
    fn the_camera_sees_nearly_all_of_it_inside_the_frame() {
        let (c, camera) = (cloud(), camera());
        let view = View::new(&c, &camera, Profile::Inria).unwrap();
        assert_eq!(view.splats().len(), c.len());
        let inside = view.splats().iter().filter(|s| {
            let m = s.mean;
            m.min_element() > 0.0 && m.max_element() < 400.0
        });
        assert!(inside.count() * 100 > 99 * c.len());
    }

    #[test]
    fn the_picture_has_sky_leaf_and_blossom() {
        let options = FloatOptions {
            background: BACKGROUND,
            ..FloatOptions::default()
        };
        let camera = camera().resized(100, 100);
        let frame = render_float(&cloud(), &camera, Profile::Inria, &options).unwrap();
        let share = |pick: fn(&[f32; 3]) -> bool| {
            frame.picture.rgb.iter().filter(|p| pick(p)).count() as f64 / 10_000.0
        };
        assert!(share(|p| *p == BACKGROUND) > 0.3);
        assert!(share(|[r, g, b]| g > r && g > b) > 0.05);
        assert!(share(|[r, g, b]| *r > 1.15 * g && *r > 0.4 && b > g) > 0.03);
        // Nothing burns out, nothing is lost in the dark.
        assert!(share(|p| p.iter().any(|v| *v > 1.1)) < 0.01);
    }
}
