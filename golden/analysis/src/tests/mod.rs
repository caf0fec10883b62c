//! Effects, tried on scenes made to call for them.
#![allow(clippy::unwrap_used, clippy::panic)]

mod calls;
mod ending;
mod hardware;
mod skipping;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use glam::{DAffine3, DVec3, dvec3};
use potamoi_formats::config::{Config, Modes, PRESETS};
use potamoi_formats::units::OpCode;
use proptest::prelude::*;

use super::*;
use potamoi_base::camera::Camera;
use potamoi_base::effects::*;
use potamoi_base::precision::Precision;
use potamoi_fields::voxels::{Grid, Layout};
use potamoi_gaussians::Cloud;
use potamoi_reference::ReferenceUnits;
use potamoi_reference::observer::Observed;
use potamoi_reference::trace_recorder::{Limits, Recorder};
use potamoi_scene::{BUILTIN, Model, Rendered, Representation, Scene};
use potamoi_warp::{Plan, PlanOptions, Profile, ReferenceFrom, Sequence, Warper};

fn preset(name: &str) -> Config {
    let (_, text) = PRESETS.iter().find(|(own, _)| *own == name).unwrap();
    Config::from_toml(text, name).unwrap()
}

/// A preset in which a model can be rendered.
fn fitting(scene: &Scene) -> Config {
    preset(scene.model().preset())
}

fn analysed(scene: &Scene, path: &[Camera]) -> Analysis {
    Analysis::of(scene, path, &fitting(scene), Surroundings::default()).unwrap()
}

/// A scene that is opened once in this process: to make a model of an analytic scene takes up to
/// seconds, and copies share it.
fn opened(name: &str, width: u32) -> Scene {
    type Kept = BTreeMap<String, Arc<OnceLock<Scene>>>;
    static KEPT: Mutex<Kept> = Mutex::new(Kept::new());
    let mut all = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    let own = Arc::clone(all.entry(name.to_owned()).or_default());
    drop(all);
    let mut scene = own.get_or_init(|| Scene::open(name).unwrap()).clone();
    scene.set_size(Some(width), None).unwrap();
    scene
}

/// A scene of a model.
fn with_model(model: Model) -> Scene {
    opened("garden", 24).with_model(model)
}

fn calls(scene: &Scene, effect: Effect) -> bool {
    analysed(scene, &[*scene.camera()]).calls_for(effect)
}

/// Everything that a frame gives: pictures in both arithmetics bit by bit, counts, and the trace.
fn everything(scene: &Scene, config: &Config) -> impl PartialEq + use<> {
    let float = scene.render_float().unwrap();
    let mut twins = ReferenceUnits::new(config);
    let mut recorder = Recorder::new(Limits::NONE);
    let mut units = Observed::new(&mut twins, config).by(&mut recorder);
    let fixed = scene.render_fixed(config, &mut units).unwrap();
    let (gathered, computed) = (recorder.gathered, recorder.computed);
    assert!(gathered.len() + computed.len() > 0 || fixed.counts.feature_vectors == 0);
    let bits = |rendered: &Rendered| -> Vec<u32> {
        let rgb = rendered.picture.rgb.iter().flatten();
        rgb.map(|v| v.to_bits()).collect()
    };
    let pictures = (bits(&float), bits(&fixed));
    (pictures, fixed.covered, fixed.counts, gathered, computed)
}

/// A ring of Gaussians with coefficients of degree 3, all 0 above degree 0.
fn ring(count: usize, change: impl Fn(&mut Vec<[f32; 3]>, &mut Vec<f32>)) -> Cloud {
    let means = (0..count).map(|i| {
        let angle = i as f32 * 0.7;
        [0.6 * angle.cos(), 0.6 * angle.sin(), 0.03 * i as f32]
    });
    let mut sh = vec![[0.0; 3]; 16 * count];
    sh.iter_mut()
        .step_by(16)
        .for_each(|c| *c = [0.4, 0.9, -0.3]);
    let mut logits = vec![-2.0; count];
    change(&mut sh, &mut logits);
    Cloud::new(
        3,
        means.collect(),
        vec![[-2.0; 3]; count],
        vec![[1.0, 0.0, 0.0, 0.0]; count],
        logits,
        sh,
    )
    .unwrap()
}

fn splats(cloud: Cloud) -> Scene {
    let mut scene = with_model(Model::Splats(cloud));
    let camera = Camera::look_at(dvec3(4.0, -3.0, 2.0), DVec3::ZERO, DVec3::Z, 0.8, 24, 24);
    scene.set_camera(camera);
    scene
}

/// A grid that is filled everywhere, but where it is changed.
fn block(layout: Layout, change: impl Fn(&mut Vec<f32>)) -> Scene {
    let points = [9, 8, 10];
    let channels = layout.channels();
    let mut features: Vec<f32> = (0..points.iter().product::<usize>() * channels)
        .map(|i| match i % channels {
            0 => 0.05,
            c if (c - 1) % layout.coefficients() == 0 => 0.3 + 0.01 * (i % 37) as f32,
            _ => 0.0,
        })
        .collect();
    change(&mut features);
    let grid = Grid::new(points, DVec3::splat(-0.4), 0.1, layout, features).unwrap();
    let mut scene = with_model(Model::Field(grid.into()));
    let camera = Camera::look_at(dvec3(2.0, -1.5, 1.0), DVec3::ZERO, DVec3::Z, 0.8, 24, 24);
    scene.set_camera(camera);
    scene
}
