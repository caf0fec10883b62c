//! Pictures of hard cases: small scenes of splats, each made of one case, by the obvious form, in the
//! hardware's formats and in floats.

mod form;
mod naive;
mod scenes;

use glam::DVec3;
use potamoi_base::picture::Picture;
use potamoi_formats::config::Config;
use potamoi_reference::ReferenceUnits;
use potamoi_scene::{Model, Scene, SceneError};

use super::scene::{SceneCheck, beside_floats};

pub use form::Form;
pub use naive::render;
pub use scenes::{FOCAL, Gaussian, HardScene, SIZE, all, camera};

/// The three pictures of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// Name of the scene.
    pub scene: &'static str,
    /// What is hard about it.
    pub case: &'static str,
    /// The obvious form, in words.
    pub form: &'static str,
    /// Its picture, which may hold what is no number.
    pub naive: Picture,
    /// The picture in the hardware's formats.
    pub fixed: Picture,
    /// The picture in 64-bit floating point.
    pub float: Picture,
    /// Whether ours keeps each pixel's bound beside floats.
    pub check: SceneCheck,
}

/// The pictures of all scenes in the formats of a configuration.
///
/// # Errors
/// The configuration cannot render splats.
pub fn shown(config: &Config) -> Result<Vec<Shown>, SceneError> {
    let one = |own: HardScene| {
        let model = Model::Splats(own.cloud()?);
        let scene = Scene::of(own.name, model, camera(), DVec3::Y, [0.0; 3]);
        let fixed = scene.render_fixed(config, &mut ReferenceUnits::new(config))?;
        let float = scene.render_float()?;
        let naive = render(&own.gaussians, own.form);
        let level = match psnr(&naive, &float.picture) {
            None => "no number".to_owned(),
            Some(db) => format!("{db:.0} dB"),
        };
        let form = own.form.text();
        let check = beside_floats(&scene, config, &fixed, &float)?;
        Ok(Shown {
            check: SceneCheck {
                name: own.case,
                ..check.beside(format!("{form}: {level}"))
            },
            scene: own.name,
            case: own.case,
            form,
            naive,
            fixed: fixed.picture,
            float: float.picture,
        })
    };
    all().into_iter().map(one).collect()
}

/// PSNR in dB, peak 1; `None` where one of the pictures holds what is no number. Infinite for equal
/// ones.
#[must_use]
pub fn psnr(a: &Picture, b: &Picture) -> Option<f64> {
    let finite = |p: &Picture| p.rgb.iter().flatten().all(|v| v.is_finite());
    (finite(a) && finite(b)).then(|| a.psnr(b, |_| true))?
}
