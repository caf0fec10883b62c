//! Whole target frames, of scenes whose every ray is known.

#![allow(clippy::unwrap_used)]

use glam::{DAffine3, DVec3};
use proptest::prelude::*;

use super::*;

/// A ball of radius 0.5 before a wall of radius 2 at z = 1, on white, exactly;
/// it keeps how many rays were asked for.
struct Ball {
    rays: std::sync::atomic::AtomicUsize,
    bounds: Option<[DVec3; 2]>,
}

const WHITE: [f32; 3] = [1.0; 3];

impl Ball {
    fn new() -> Self {
        Self {
            rays: 0.into(),
            bounds: Some([DVec3::splat(-2.1), DVec3::splat(2.1)]),
        }
    }

    fn rays(&self) -> usize {
        self.rays.load(std::sync::atomic::Ordering::Relaxed)
    }
}

fn pattern(p: DVec3) -> [f32; 3] {
    [p.x, p.y, p.z].map(|v| (0.5 + 0.3 * (3.0 * v).sin()) as f32)
}

fn hit(origin: DVec3, direction: DVec3) -> Option<f64> {
    let middle = -origin.dot(direction);
    let squared = 0.25 - (origin.length_squared() - middle * middle);
    let ball = (squared >= 0.0).then(|| middle - squared.sqrt());
    let wall = (1.0 - origin.z) / direction.z;
    let on_wall = (origin + direction * wall).truncate().length() < 2.0;
    ball.filter(|t| *t > 0.0)
        .or((wall > 0.0 && on_wall).then_some(wall))
}

impl Renderer for Ball {
    fn background(&self) -> [f32; 3] {
        WHITE
    }

    fn bounds(&self) -> Option<[DVec3; 2]> {
        self.bounds
    }

    fn shade(&self, camera: &Camera, only: Option<&Mask>) -> Result<Shaded, WarpError> {
        let count = (camera.width * camera.height) as usize;
        let mut shaded = Shaded {
            picture: Picture::filled(camera.width, camera.height, WHITE),
            depth: vec![f32::INFINITY; count],
        };
        for i in (0..count).filter(|i| only.is_none_or(|mask| mask.has(*i))) {
            self.rays.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            let pixel = i as u32;
            let (origin, direction) = camera.ray(pixel % camera.width, pixel / camera.width);
            if let Some(t) = hit(origin, direction) {
                shaded.picture.rgb[i] = pattern(origin + direction * t);
                shaded.depth[i] = (t * camera.slant(pixel)) as f32;
            }
        }
        Ok(shaded)
    }
}

impl Geometry for Ball {
    fn depth(&self, camera: &Camera) -> Result<Vec<f32>, WarpError> {
        Ok(Self::new().shade(camera, None)?.depth)
    }
}

/// Around the ball, `turn` radians from before it.
fn around(turn: f64) -> Camera {
    let eye = 3.0 * DVec3::new(turn.sin(), 0.1, -turn.cos());
    Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.8, 90, 70)
}

fn path(frames: u32) -> Vec<Camera> {
    (0..frames).map(|k| around(0.01 * f64::from(k))).collect()
}

fn warper(ball: &Ball, known: bool, rule: Rule) -> Warper<'_> {
    Warper {
        renderer: ball,
        geometry: known.then_some(ball as &dyn Geometry),
        rule,
    }
}

#[test]
fn a_target_is_the_model_but_where_it_was_warped_and_only_those_rays_are_rendered() {
    for known in [false, true] {
        for profile in [Profile::Paper, Profile::Potamoi] {
            let ball = Ball::new();
            let warper = warper(&ball, known, profile.rule());
            let (from, to) = (around(0.0), around(0.06));
            let reference = warper.reference(&from).unwrap();
            let full = warper.reference(&to).unwrap();
            let before = ball.rays();
            let target = warper.target(&reference, &from, &to).unwrap();
            let counts = Counts::of(&target.classes, |_| true);
            assert_eq!((ball.rays() - before) as u64, counts.rendered());
            assert_eq!(counts.total(), 90 * 70);
            for i in 0..target.classes.len() {
                let same = target.shaded.picture.rgb[i] == full.picture.rgb[i];
                match target.classes[i] {
                    Class::Warped => {}
                    Class::Void => assert!(same && is_void(full.depth[i]), "{i}"),
                    _ => assert!(same, "{i}"),
                }
            }
            // Six hundredths of a radian hide little.
            assert!(counts.warped > counts.total() / 2, "{counts:?}");
            assert!(counts.disoccluded > 0, "{counts:?}");
            assert!(counts.rendered() < counts.total() / 3, "{counts:?}");
            let psnr = target.shaded.picture.psnr(&full.picture, |_| true).unwrap();
            let least = if profile == Profile::Potamoi {
                38.0
            } else {
                27.0
            };
            assert!(psnr > least, "{profile:?}, depth known {known}: {psnr}");
        }
    }
}

/// The ball and its wall, nearer or farther than they are shown, less a rim of a
/// pixel.
struct Other {
    scale: f32,
    eroded: bool,
}

impl Geometry for Other {
    fn depth(&self, camera: &Camera) -> Result<Vec<f32>, WarpError> {
        let depth = Ball::new().depth(camera)?;
        let (width, height) = (camera.width as usize, camera.height as usize);
        let beside_void = |i: usize| {
            let (x, y) = (i % width, i / width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            rows.flat_map(|y| (x.saturating_sub(1)..(x + 2).min(width)).map(move |x| (x, y)))
                .any(|(x, y)| is_void(depth[y * width + x]))
        };
        let own = |i: usize| match self.eroded && beside_void(i) {
            true => f32::INFINITY,
            false => depth[i] * self.scale,
        };
        Ok((0..depth.len()).map(own).collect())
    }
}

#[test]
fn what_is_nearer_by_more_than_half_a_percent_is_rendered() {
    let ball = Ball::new();
    let (from, to) = (around(0.0), around(0.02));
    let reference = ball.shade(&from, None).unwrap();
    let rendered = |scale| {
        let nearer = Other {
            scale,
            eroded: false,
        };
        let warper = Warper {
            renderer: &ball,
            geometry: Some(&nearer),
            rule: Profile::Paper.rule(),
        };
        let target = warper.target(&reference, &from, &to).unwrap();
        let counts = Counts::of(&target.classes, |_| true);
        counts.disoccluded as f64 / (counts.disoccluded + counts.warped) as f64
    };
    assert!(rendered(0.999) < 0.2, "{}", rendered(0.999));
    assert!(rendered(0.99) > 0.9, "{}", rendered(0.99));
}

/// A geometry without the outermost pixels of the model: they are rendered, not
/// taken for void.
#[test]
fn the_rim_of_a_geometry_is_rendered() {
    let ball = Ball::new();
    let (from, to) = (around(0.0), around(0.04));
    let geometry = Other {
        scale: 1.0,
        eroded: true,
    };
    let full = ball.shade(&to, None).unwrap();
    let lost = |rule| {
        let warper = Warper {
            renderer: &ball,
            geometry: Some(&geometry),
            rule,
        };
        let reference = warper.reference(&from).unwrap();
        let target = warper.target(&reference, &from, &to).unwrap();
        let classes = target.classes.iter().zip(&full.depth);
        classes
            .filter(|(class, depth)| **class == Class::Void && !is_void(**depth))
            .count()
    };
    assert_eq!(lost(Profile::Potamoi.rule()), 0);
    assert!(lost(Profile::Paper.rule()) > 50);
}

#[test]
fn a_known_depth_uncovers_what_shines_through_a_surface_far_off() {
    // Points of the wall land between those of the ball as the camera comes
    // near: nothing but the depth there tells that they are hidden.
    let ball = Ball::new();
    let mut from = around(0.0);
    let mut to = from;
    from.focal *= 0.5;
    to.focal *= 1.6;
    let blind = warper(&ball, false, Profile::Paper.rule());
    let reference = blind.reference(&from).unwrap();
    to.world_to_camera.translation += DVec3::new(0.3, 0.0, 0.0);
    let wrong = |warper: Warper<'_>| {
        let truth = warper.reference(&to).unwrap();
        let target = warper.target(&reference, &from, &to).unwrap();
        let wrong = (0..truth.depth.len()).filter(|i| {
            target.classes[*i] == Class::Warped && target.shaded.depth[*i] > 1.3 * truth.depth[*i]
        });
        wrong.count()
    };
    let known = warper(&ball, true, Profile::Paper.rule());
    assert!(wrong(blind) > 0);
    assert_eq!(wrong(known), 0);
}

#[test]
fn phi_renders_pixels_or_the_frame() {
    let ball = Ball::new();
    let (from, to) = (around(0.0), around(0.2));
    let at = |phi: f64, scope| {
        let rule = Rule {
            phi: Some(phi),
            scope,
            ..Profile::Paper.rule()
        };
        let warper = warper(&ball, true, rule);
        let reference = warper.reference(&from).unwrap();
        let target = warper.target(&reference, &from, &to).unwrap();
        Counts::of(&target.classes, |_| true)
    };
    // Points before the turn's axis subtend more than the turn, those behind
    // less: between the two, some of each.
    let [small, middle, large] = [0.05, 0.19, 0.5].map(|phi| at(phi, Scope::Pixel));
    assert_eq!(small.warped, 0);
    assert!(middle.angle > 0 && middle.warped > 0, "{middle:?}");
    assert_eq!(large.angle, 0);
    assert_eq!(at(0.19, Scope::Frame).full, 90 * 70);
    assert_eq!(at(0.5, Scope::Frame), large);
}

#[test]
fn depths_that_are_none_are_rendered_where_they_are_needed() {
    let ball = Ball::new();
    let (from, to) = (around(0.0), around(0.01));
    let warper = warper(&ball, false, Profile::Potamoi.rule());
    let mut reference = warper.reference(&from).unwrap();
    let full = warper.reference(&to).unwrap();
    for (i, depth) in reference.depth.iter_mut().enumerate() {
        match i % 11 {
            0 => *depth = 0.0,
            1 => *depth = f32::NAN,
            2 => *depth = -1.0,
            _ => {}
        }
    }
    let target = warper.target(&reference, &from, &to).unwrap();
    assert!(
        target
            .shaded
            .picture
            .rgb
            .iter()
            .flatten()
            .all(|v| v.is_finite())
    );
    for (i, class) in target.classes.iter().enumerate() {
        // A void pixel is void.
        assert!(*class != Class::Void || is_void(full.depth[i]));
    }
    // All of them unknown: all rendered but for what is beside the bounds.
    reference.depth.fill(f32::NAN);
    let target = warper.target(&reference, &from, &to).unwrap();
    assert_eq!(target.shaded.picture, full.picture);
    assert_eq!(Counts::of(&target.classes, |_| true).warped, 0);
}

#[test]
fn half_a_turn_shows_the_other_side_by_rendering_it() {
    let ball = Ball::new();
    let (from, to) = (around(0.0), around(std::f64::consts::PI));
    for known in [false, true] {
        let rule = Rule {
            phi: Some(0.1),
            ..Profile::Potamoi.rule()
        };
        let warper = warper(&ball, known, rule);
        let reference = warper.reference(&from).unwrap();
        let target = warper.target(&reference, &from, &to).unwrap();
        let full = warper.reference(&to).unwrap();
        assert_eq!(target.shaded.picture, full.picture, "{known}");
    }
}

#[test]
fn sequences_show_references_warp_the_rest_and_render_what_was_lost() {
    let ball = Ball::new();
    let path = path(10);
    let options = PlanOptions {
        window: 4,
        reference: ReferenceFrom::First,
        lead: None,
    };
    let plan = Plan::new(&path, &options).unwrap();
    let warper = warper(&ball, false, Profile::Potamoi.rule());
    let frames: Vec<Frame> = Sequence::new(warper, &path, &plan, &[1])
        .map(Result::unwrap)
        .collect();
    assert_eq!(frames.len(), 10);
    for (number, frame) in frames.iter().enumerate() {
        let full = warper.reference(&path[number]).unwrap();
        let lost = (4..8).contains(&number);
        assert_eq!(frame.fell_back(), lost, "{number}");
        assert_eq!(frame.reference.is_none(), number == 0 || number == 8);
        if lost || frame.reference.is_none() {
            assert_eq!(frame.target.shaded.picture, full.picture);
        } else {
            let counts = Counts::of(&frame.target.classes, |_| true);
            assert!(counts.warped > 3000, "{number}: {counts:?}");
        }
    }
}

#[test]
fn errors_add_up_along_a_chain_but_not_from_a_reference() {
    let ball = Ball::new();
    let path = path(17);
    let warper = warper(&ball, false, Profile::Paper.rule());
    let psnr = |frame: &Frame| {
        let full = warper.reference(&path[frame.number]).unwrap();
        frame
            .target
            .shaded
            .picture
            .psnr(&full.picture, |_| true)
            .unwrap()
    };
    let chain: Vec<f64> = Chain::new(warper, &path, 16)
        .map(|f| psnr(&f.unwrap()))
        .collect();
    assert!(chain[0].is_infinite() && chain[16].is_infinite());
    assert!(chain[15] < chain[1] - 3.0, "{chain:?}");
    let options = PlanOptions {
        window: 16,
        reference: ReferenceFrom::First,
        lead: None,
    };
    let plan = Plan::new(&path, &options).unwrap();
    let direct: Vec<f64> = Sequence::new(warper, &path, &plan, &[])
        .map(|f| psnr(&f.unwrap()))
        .collect();
    assert!(direct[15] > chain[15] + 1.0, "{direct:?} {chain:?}");
}

#[test]
fn frames_of_another_size_are_refused_by_name() {
    let ball = Ball::new();
    let warper = warper(&ball, false, Profile::Paper.rule());
    let camera = around(0.0);
    let mut reference = warper.reference(&camera).unwrap();
    let error = warper
        .target(&reference, &camera.resized(45, 35), &camera)
        .unwrap_err();
    assert!(
        error.to_string().contains("a reference has 90 x 70 pixels"),
        "{error}"
    );
    reference.depth.pop();
    assert!(warper.target(&reference, &camera, &camera).is_err());
}

#[test]
fn half_the_resolution_is_near_but_not_the_same() {
    let ball = Ball::new();
    let camera = around(0.0);
    let full = ball.shade(&camera, None).unwrap().picture;
    let half = half_resolution(&ball, &camera).unwrap();
    assert_eq!((half.width, half.height), (90, 70));
    let psnr = half.psnr(&full, |_| true).unwrap();
    assert!((15.0..40.0).contains(&psnr), "{psnr}");
    // A quarter of the rays.
    assert_eq!(ball.rays(), 90 * 70 + 45 * 35);
    // Values above 1 stay.
    struct Bright;
    impl Renderer for Bright {
        fn background(&self) -> [f32; 3] {
            WHITE
        }
        fn bounds(&self) -> Option<[DVec3; 2]> {
            None
        }
        fn shade(&self, camera: &Camera, _: Option<&Mask>) -> Result<Shaded, WarpError> {
            Ok(Shaded {
                picture: Picture::filled(camera.width, camera.height, [3.0, 0.5, 0.0]),
                depth: vec![],
            })
        }
    }
    let bright = half_resolution(&Bright, &camera).unwrap();
    for pixel in &bright.rgb {
        assert!((pixel[0] - 3.0).abs() < 1e-5 && (pixel[1] - 0.5).abs() < 1e-5);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// For any cameras, rendered and void pixels equal those of the model, and every pixel has a
    /// class.
    #[test]
    fn what_is_not_warped_is_right(
        turn in -3.2f64..3.2, shift in prop::array::uniform3(-4.0f64..4.0),
        known in any::<bool>(), bounds in any::<bool>(), potamoi in any::<bool>(),
    ) {
        let mut ball = Ball::new();
        if !bounds {
            ball.bounds = None;
        }
        let rule = if potamoi { Profile::Potamoi } else { Profile::Paper }.rule();
        let from = around(0.0);
        let moved = DAffine3::from_rotation_y(turn) * DAffine3::from_translation(DVec3::from(shift));
        let to = Camera { world_to_camera: moved * from.world_to_camera, ..from };
        let warper = warper(&ball, known, rule);
        let reference = warper.reference(&from).unwrap();
        let full = warper.reference(&to).unwrap();
        let target = warper.target(&reference, &from, &to).unwrap();
        for (i, class) in target.classes.iter().enumerate() {
            let found = target.shaded.picture.rgb[i];
            prop_assert!(found.iter().all(|v| v.is_finite()));
            if *class != Class::Warped {
                prop_assert_eq!(found, full.picture.rgb[i], "pixel {} {:?}", i, class);
            }
        }
    }
}
