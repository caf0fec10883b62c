//! Grids of voxels made of one case each: thin fog sampled thousands of times, and a field that is
//! everywhere the same under weights of few bits.

use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_fields::voxels::{Formats, Grid, Layout, STOP_BELOW, StoredField, error_bounds};
use potamoi_fields::{AnyField, FixedField, FixedOptions, render_float};
use potamoi_formats::config::Config;
use potamoi_march::FixedFrame;
use potamoi_reference::bounds::VectorBounds;
use potamoi_reference::{ReferenceUnits, Units};
use potamoi_rtl::RtlUnits;
use potamoi_scene::Model;

use super::modelled::Case;
use super::obvious::{Obvious, ObviousUnits};
use super::sampled::{Shown, farthest};
use potamoi_analysis::hard_cases::pictures::SIZE;

struct Scene {
    name: &'static str,
    case: &'static str,
    form: Obvious,
    field: StoredField,
    config: Config,
    /// In voxel edges.
    step: f64,
}

const POINTS: [usize; 3] = [17, 13, 65];

fn camera([width, height]: [u32; 2]) -> Camera {
    let eye = DVec3::new(8.0, 6.0, -40.0);
    Camera::look_at(eye, eye + DVec3::Z, DVec3::NEG_Y, 0.11, width, height)
}

/// Fog of about one density, which changes from sample to sample: a ray's would all be off to one
/// side otherwise.
fn fog(density: f64) -> Grid {
    Grid::bake(POINTS, DVec3::ZERO, 1.0, Layout::Constant, |at, out| {
        let wave = (0.9 * at.x).sin() * (0.7 * at.y).cos() + (1.9 * at.z).sin();
        out[0] = (density * (1.0 + 0.3 * wave)) as f32;
        for (c, v) in out[1..].iter_mut().enumerate() {
            *v = (0.6 + 0.4 * (0.5 * at.x + c as f64).sin()) as f32;
        }
    })
    .unwrap()
}

fn constant() -> Grid {
    Grid::bake(POINTS, DVec3::ZERO, 1.0, Layout::Constant, |_, out| {
        out.copy_from_slice(&[0.12, 0.9, 0.5, 0.7]);
    })
    .unwrap()
}

fn all() -> [Scene; 3] {
    [
        // Five codes of U0.16 a sample.
        Scene {
            name: "fog",
            case: "1 - exp(-s) where s is a few codes",
            form: Obvious::OpacityFromExp,
            field: StoredField::new(fog(5.0 / 65_536.0 * 16.0), 1.0 / 16.0),
            config: Config::paper(),
            step: 1.0 / 16.0,
        },
        Scene {
            name: "4096",
            case: "4096 samples a ray",
            form: Obvious::WeightsAlone,
            field: StoredField::new(fog(0.05), 1.0 / 64.0),
            config: Config::paper(),
            step: 1.0 / 64.0,
        },
        Scene {
            name: "constant",
            case: "a constant field, weights of 8 bits",
            form: Obvious::RoundedAlone,
            field: StoredField::new(constant(), 0.37),
            config: Config::from_toml("[gu]\nweight_bits = 8", "hard case").unwrap(),
            step: 0.37,
        },
    ]
}

impl Scene {
    fn through(&self, size: [u32; 2], units: &mut dyn Units) -> FixedFrame {
        let made = FixedField::new(&self.field, &self.config).unwrap();
        let options = FixedOptions::default();
        made.render(&camera(size), &options, units).unwrap()
    }
}

/// Of each scene a small picture, to be modelled.
pub(crate) fn cases() -> Vec<Case> {
    let size = [9, 7];
    let one = |scene: Scene| Case {
        name: scene.name,
        camera: camera(size),
        picture: scene
            .through(size, &mut ReferenceUnits::new(&scene.config))
            .picture,
        step: Some(scene.step),
        config: scene.config,
        model: Model::Field(AnyField::new(scene.field)),
    };
    all().into_iter().map(one).collect()
}

/// Of each scene what the obvious form, ours and floats show.
pub(crate) fn shown() -> Vec<Shown> {
    let one = |scene: Scene| {
        let mut twins = ReferenceUnits::new(&scene.config);
        let float = render_float(&scene.field, &camera(SIZE), [0.0; 3]).unwrap();
        let formats = Formats::new(scene.field.grid(), &scene.config).unwrap();
        let exp = &scene.config.vu.exp;
        let bounds = error_bounds(
            &scene.field,
            &formats,
            &VectorBounds::by_formula(exp),
            &camera(SIZE),
            &FixedOptions::default(),
            STOP_BELOW,
        );
        let ours = scene.through(SIZE, &mut twins).picture;
        assert_eq!(twins.gather_flags(), 0, "{}", scene.name);
        let most = bounds.iter().map(|[colour, _]| *colour);
        Shown {
            scene: scene.name,
            case: scene.case,
            form: scene.form.text(),
            naive: scene
                .through(SIZE, &mut ObviousUnits::new(scene.form, &scene.config))
                .picture,
            farthest: farthest(&ours, &float.picture, most.clone()),
            bound: most.fold(0.0, f64::max),
            ours,
            float: float.picture,
        }
    };
    all().into_iter().map(one).collect()
}

#[test]
fn the_hardware_shows_the_same_fog() {
    let size = [5, 4];
    for scene in &all() {
        let mut rtl = RtlUnits::new(&scene.config);
        let expected = scene.through(size, &mut ReferenceUnits::new(&scene.config));
        assert!(expected.stats.samples > 3000, "{:?}", expected.stats);
        assert_eq!(scene.through(size, &mut rtl), expected, "{}", scene.name);
        assert_eq!(rtl.gather_flags(), 0);
    }
}
