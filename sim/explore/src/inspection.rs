//! What a model's file says and holds, and what its format costs beside another.

use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;
use potamoi_cycles::effect_meter::EffectMeter;
use potamoi_formats::config::Config;
use potamoi_gaussians::{Cloud, Differences, Facts, differences, sigmoid};
use potamoi_reference::ReferenceUnits;
use potamoi_reference::observer::Observed;
use potamoi_scene::{Kind, Scene};
use schemars::JsonSchema;
use serde::Serialize;

use crate::ExploreError;
use crate::accuracy::ImageQuality;

/// A model as it was read.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Inspected {
    /// Name of the scene.
    pub name: String,
    /// The algorithm that renders it.
    pub algorithm: &'static str,
    /// What its file says of itself; of splats alone.
    pub file: Option<Facts>,
    /// Its Gaussians; `None` for fields.
    pub splats: Option<Splats>,
    /// What was assumed of the files.
    pub assumed: Vec<String>,
    /// What of the files is not used.
    pub not_used: Vec<String>,
}

/// The Gaussians of a model.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Splats {
    /// How many there are.
    pub count: u64,
    /// Degree of the spherical harmonics.
    pub degree: usize,
    /// Whether they were trained with antialiasing (the filter of Mip-Splatting in the plane).
    pub antialiased: bool,
    /// Bytes of all files a Gaussian; `None` where no file was read.
    pub bytes_each: Option<f64>,
    /// Where the file's origin of centres was moved to.
    pub origin: [f64; 3],
    /// Ranges of values.
    pub ranges: Vec<Range>,
}

/// The range of a property's values, after activation and in the axes of clouds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Range {
    /// The property.
    pub what: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The smallest value.
    pub least: f64,
    /// The largest value.
    pub most: f64,
}

impl Inspected {
    /// What a scene's model is.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let splats = match scene.model().kind() {
            Kind::Splats(cloud) => Some(Splats::of(cloud, scene)),
            Kind::Field(_) => None,
        };
        Self {
            name: scene.name().to_owned(),
            algorithm: scene.model().algorithm(),
            file: scene.file_facts().cloned(),
            splats,
            assumed: scene.notes().assumed().to_vec(),
            not_used: scene.notes().not_used().to_vec(),
        }
    }
}

impl Splats {
    fn of(cloud: &Cloud, scene: &Scene) -> Self {
        let bytes = scene
            .file_facts()
            .map(|own| own.bytes)
            .filter(|own| *own > 0);
        Self {
            count: cloud.len() as u64,
            degree: cloud.degree(),
            antialiased: cloud.is_antialiased(),
            bytes_each: bytes.map(|own| own as f64 / cloud.len() as f64),
            origin: scene.origin().to_array(),
            ranges: ranges(cloud),
        }
    }
}

fn ranges(cloud: &Cloud) -> Vec<Range> {
    let all = 0..cloud.len();
    let range = |what, unit, values: &mut dyn Iterator<Item = f64>| {
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        let (least, most) = values.fold(start, |(low, high), v| (low.min(v), high.max(v)));
        Range {
            what,
            unit,
            least,
            most,
        }
    };
    let axis = |k: usize| cloud.means().iter().map(move |own| f64::from(own[k]));
    let sizes = cloud.log_scales().iter().flatten();
    let opacities = cloud.opacity_logits().iter();
    let constants = all.clone().flat_map(|i| cloud.sh(i)[0]);
    let rest = all.flat_map(|i| cloud.sh(i)[1..].as_flattened().iter().copied());
    let colour = |v: f32| f64::from(v) * potamoi_base::sh::CONSTANT + 0.5;
    let mut found = vec![
        range("centre, to the right", "scene units", &mut axis(0)),
        range("centre, down", "scene units", &mut axis(1)),
        range("centre, to the front", "scene units", &mut axis(2)),
        range(
            "size",
            "scene units",
            &mut sizes.map(|v| f64::from(*v).exp()),
        ),
        range(
            "opacity",
            "of 1",
            &mut opacities.map(|v| sigmoid(f64::from(*v))),
        ),
        range("colour", "of 1", &mut constants.map(colour)),
    ];
    if cloud.degree() > 0 {
        found.push(range("other coefficients", "-", &mut rest.map(f64::from)));
    }
    found
}

/// What a model costs beside another.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Beside {
    /// Pictures of both through the same cameras, in floating point.
    pub pictures: Pictures,
    /// Differences of Gaussians; `None` for fields and where one has more.
    pub differences: Option<Differences>,
    /// Why there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_differences: Option<String>,
    /// Work of the units for the first picture, of the model and of the other.
    pub work: [FrameWork; 2],
}

/// The quality of pictures against those of the other model.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Pictures {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// PSNR over all pictures together, linear RGB, peak 1; `None` where all are equal.
    pub db: Option<f64>,
    /// Each picture.
    pub each: Vec<ImageQuality>,
}

/// Work of the units for a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct FrameWork {
    /// Listed pairs of tile and Gaussian; `None` for fields.
    pub tile_pairs: Option<u64>,
    /// Pairs of pixel and Gaussian that are evaluated; `None` for fields.
    pub pixel_pairs: Option<u64>,
    /// Cycles of the gathering unit by the cycle model, with streams always ready.
    pub gather: u64,
    /// Cycles of the vector unit.
    pub vector: u64,
    /// Cycles of the splat unit, if the configuration has one; all jobs one after the other.
    pub splats: u64,
}

impl FrameWork {
    /// Renders a frame in the hardware's formats and counts the units' work.
    ///
    /// # Errors
    /// The scene cannot be rendered with the configuration.
    pub fn of(scene: &Scene, config: &Config) -> Result<Self, ExploreError> {
        let mut meter = EffectMeter::new(config);
        let mut twins = ReferenceUnits::new(config);
        let rendered = {
            let mut units = Observed::new(&mut twins, config).by(&mut meter);
            scene.render_fixed(config, &mut units)?
        };
        let cycles = meter.cycles();
        let splats = rendered.counts.splats;
        Ok(Self {
            tile_pairs: splats.map(|own| own.pairs),
            pixel_pairs: splats.map(|own| own.pairs_evaluated),
            gather: cycles.gather,
            vector: cycles.vector,
            splats: cycles.splats,
        })
    }
}

impl Beside {
    /// Compares a model with another through `cameras` of the model's scene; units are those of `config`.
    ///
    /// # Errors
    /// A scene cannot be rendered.
    pub fn of(
        scene: &Scene,
        other: &Scene,
        cameras: &[Camera],
        config: &Config,
    ) -> Result<Self, ExploreError> {
        let shift = other.origin() - scene.origin();
        let found = match (scene.model().kind(), other.model().kind()) {
            (Kind::Splats(a), Kind::Splats(b)) => differences(a, b, shift)
                .ok_or_else(|| format!("{} Gaussians beside {}", a.len(), b.len())),
            _ => Err("of Gaussians alone".to_owned()),
        };
        let mut each = vec![];
        let mut sum = 0.0;
        let mut work = vec![];
        let mut size = (0, 0);
        for (index, camera) in cameras.iter().enumerate() {
            let both = [(scene, glam::DVec3::ZERO), (other, shift)].map(|(own, shift)| {
                let mut own = own.clone();
                own.set_camera(moved(camera, shift));
                own
            });
            let [a, b] = both.each_ref().map(Scene::render_float);
            let [a, b]: [Picture; 2] = [a?.picture, b?.picture];
            size = (a.width, a.height);
            each.push(ImageQuality::of(&a, &b));
            sum += a.mean_squared_error(&b, |_| true).unwrap_or(0.0);
            if index == 0 {
                for own in &both {
                    work.push(FrameWork::of(own, config)?);
                }
            }
        }
        let work = <[FrameWork; 2]>::try_from(work)
            .map_err(|_| ExploreError::Refused("no camera: expected at least one".to_owned()))?;
        let mean = sum / each.len() as f64;
        Ok(Self {
            pictures: Pictures {
                width: size.0,
                height: size.1,
                db: (mean > 0.0).then(|| -10.0 * mean.log10()),
                each,
            },
            no_differences: found.as_ref().err().cloned(),
            differences: found.ok(),
            work,
        })
    }
}

/// A camera where centres are stored from another origin on.
fn moved(camera: &Camera, shift: glam::DVec3) -> Camera {
    Camera {
        world_to_camera: camera.world_to_camera * glam::DAffine3::from_translation(shift),
        ..*camera
    }
}
