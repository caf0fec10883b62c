//! The same hardness in a scene: what of it is there, and how both forms do on it.

use glam::{DMat3, DVec2, DVec3};
use potamoi_base::picture::Picture;
use potamoi_formats::config::Config;
use potamoi_gaussians::{Cloud, rotation};
use potamoi_reference::ReferenceUnits;
use potamoi_scene::{Model, Rendered, Scene, SceneError};
use potamoi_splats::{Footprint, Limits, Projected, RecordForm, Rules, Saturations, View, record};
use schemars::JsonSchema;
use serde::Serialize;

use super::covariance::{DETERMINANT, determinant, in_32_bits};
use super::projection::{ROTATION, normalised_in_32_bits, turned};
use super::{Worst, in_pool_of_one};

/// Most Gaussians that are compared with numbers of 256 bits: those in which a case is hardest.
const MOST: usize = 300;

/// A check of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SceneCheck {
    /// Its name.
    pub name: &'static str,
    /// What was found.
    pub state: CheckState,
    /// Figures for the state, or the reason why the check does not apply.
    pub evidence: String,
    /// How the obvious form does on the same data; `None` where there is no other form.
    pub naive: Option<String>,
}

/// What a check found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CheckState {
    /// It holds.
    Passes,
    /// It does not hold.
    Fails,
    /// The scene has nothing to check.
    DoesNotApply,
}

impl SceneCheck {
    fn new(name: &'static str, holds: bool, evidence: String) -> Self {
        Self {
            name,
            state: match holds {
                true => CheckState::Passes,
                false => CheckState::Fails,
            },
            evidence,
            naive: None,
        }
    }

    fn without(name: &'static str, reason: impl Into<String>) -> Self {
        Self {
            name,
            state: CheckState::DoesNotApply,
            evidence: reason.into(),
            naive: None,
        }
    }

    pub(super) fn beside(self, naive: String) -> Self {
        Self {
            naive: Some(naive),
            ..self
        }
    }
}

/// The checks of a scene under a configuration, and its pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneCases {
    /// The checks.
    pub checks: Vec<SceneCheck>,
    /// The picture in the hardware's formats.
    pub fixed: Picture,
    /// The picture in 64-bit floating point, with the same settings.
    pub float: Picture,
}

/// Checks a scene, seen by its camera, with the formats and the units of a configuration.
///
/// # Errors
/// The configuration cannot render the scene, or an option is out of range.
pub fn of_scene(scene: &Scene, config: &Config) -> Result<SceneCases, SceneError> {
    let mut units = ReferenceUnits::new(config);
    let fixed = scene.render_fixed(config, &mut units)?;
    let float = scene.render_float()?;
    let mut checks = vec![
        beside_floats(scene, config, &fixed, &float)?,
        numbers(&fixed, &float),
        flags(units.gather_flags()),
    ];
    match scene.cloud() {
        None => {
            let others = [NEEDLES, CUT, HELD, NEAR, TURNS];
            checks
                .extend(others.map(|name| SceneCheck::without(name, "the model has no Gaussians")));
        }
        Some(cloud) => {
            let options = scene.splat_options(config);
            let view = View::by(cloud, scene.camera(), scene.profile(), &options.work);
            let seen = Seen {
                scene,
                cloud,
                view: view.map_err(SceneError::from)?,
            };
            let form = RecordForm {
                opacity: options.schedule.opacity,
                ..RecordForm::default()
            };
            checks.extend([
                seen.needles(),
                seen.opacities_at_the_cut(form),
                seen.held(form),
                seen.near(),
                seen.turns(),
            ]);
        }
    }
    checks.push(order(scene, config, &fixed)?);
    Ok(SceneCases {
        checks,
        fixed: fixed.picture,
        float: float.picture,
    })
}

const NEEDLES: &str = "determinants of the longest Gaussians in view";
const CUT: &str = "opacities at the cut, 1/255";
const HELD: &str = "values past the end of a record's formats";
const NEAR: &str = "Gaussians at and behind the camera";
const TURNS: &str = "quaternions of odd lengths";

fn percent(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

/// The hardware's picture, whose pixels keep the bounds that follow from the formats.
pub(super) fn beside_floats(
    scene: &Scene,
    config: &Config,
    fixed: &Rendered,
    float: &Rendered,
) -> Result<SceneCheck, SceneError> {
    let name = "picture beside 64-bit floats, within each pixel's bound";
    let Some(bounds) = scene.error_bounds(config)? else {
        return Ok(SceneCheck::without(
            name,
            "no bound is known for these options (approximate order, or effects left out)",
        ));
    };
    let pixels = fixed
        .picture
        .rgb
        .iter()
        .zip(&float.picture.rgb)
        .zip(&bounds);
    let (mut beyond, mut most, mut near) = (0, Worst::default(), 0f64);
    for ((a, b), bound) in pixels {
        let off = a.iter().zip(b).map(|(a, b)| f64::from(*a) - f64::from(*b));
        let off = Worst::of(off).0;
        beyond += usize::from(off > *bound);
        most.see(off);
        if *bound > 0.0 {
            near = near.max(off / bound);
        }
    }
    let flips = fixed.flips(float).map_or_else(String::new, |flips| {
        match (flips.skip, flips.stop) {
            (0, 0) => String::new(),
            (skips, stops) => format!(
                "; decisions that fall otherwise, which the bounds count: {skips} at the cut, {stops} \
                 stops"
            ),
        }
    });
    let psnr = match fixed.picture.psnr(&float.picture, |_| true) {
        Some(db) if db.is_finite() => format!("{db:.1} dB"),
        _ => "equal".to_owned(),
    };
    let evidence = format!(
        "{beyond} of {} pixels beyond their bound; {psnr}, farthest {:.1e}, at most {:.0} % of a \
         bound{flips}",
        bounds.len(),
        most.0,
        100.0 * near
    );
    Ok(SceneCheck::new(name, beyond == 0, evidence))
}

/// All values of both pictures are numbers.
fn numbers(fixed: &Rendered, float: &Rendered) -> SceneCheck {
    let odd = |own: &Rendered| {
        let values = own.picture.rgb.iter().flatten();
        values.filter(|v| !v.is_finite()).count()
    };
    let [fixed, float] = [fixed, float].map(odd);
    SceneCheck::new(
        "values that are no numbers",
        fixed + float == 0,
        format!("{fixed} of the hardware's picture, {float} of that in floats"),
    )
}

/// No sticky flag of the gathering unit is raised.
fn flags(raised: u8) -> SceneCheck {
    SceneCheck::new(
        "overflow flags of the gathering unit",
        raised == 0,
        match raised {
            0 => "none is raised".to_owned(),
            raised => format!("raised: {raised:#b}"),
        },
    )
}

/// Neither the order of the file nor the number of threads changes a bit.
fn order(scene: &Scene, config: &Config, fixed: &Rendered) -> Result<SceneCheck, SceneError> {
    let reversed = match scene.model() {
        Model::Splats(cloud) => {
            let order: Vec<usize> = (0..cloud.len()).rev().collect();
            let cloud = cloud.select(&order)?;
            Some(scene.clone().with_model(Model::Splats(cloud)))
        }
        _ => None,
    };
    let (name, other) = match &reversed {
        Some(other) => ("the file reversed, on one thread: the same bits", other),
        None => ("one thread: the same bits", scene),
    };
    let again = in_pool_of_one(|| other.render_fixed(config, &mut ReferenceUnits::new(config)))?;
    let pixels = again.picture.rgb.iter().zip(&fixed.picture.rgb);
    let changed = pixels.filter(|(a, b)| a != b).count();
    let check = SceneCheck::new(
        name,
        changed == 0,
        format!("{changed} of {} pixels differ", fixed.picture.rgb.len()),
    );
    let (Some(cloud), Some(_)) = (scene.cloud(), &reversed) else {
        return Ok(check);
    };
    let view = View::by(
        cloud,
        scene.camera(),
        scene.profile(),
        &scene.splat_options(config).work,
    );
    let view = view.map_err(SceneError::from)?;
    let pairs = || view.splats().windows(2);
    let in_floats = pairs().filter(|p| p[0].depth as f32 == p[1].depth as f32);
    let exact = pairs().filter(|p| p[0].depth == p[1].depth).count();
    Ok(check.beside(format!(
        "a stable sort by 32-bit depths: {} neighbours of {} in view, {exact} of them exact ties, \
         come in the order of the file",
        in_floats.count(),
        view.splats().len()
    )))
}

/// The Gaussians that a camera sees.
struct Seen<'a> {
    scene: &'a Scene,
    cloud: &'a Cloud,
    view: View,
}

impl Seen<'_> {
    /// The two rows of a Gaussian's factor on screen, by the equations of the projection.
    fn rows(&self, own: &Projected, rules: &Rules) -> [DVec3; 2] {
        let camera = self.scene.camera();
        let world = DVec3::from(self.cloud.means()[own.index].map(f64::from));
        let view = camera.world_to_camera.transform_point3(world);
        let half =
            DVec2::new(f64::from(camera.width), f64::from(camera.height)) / 2.0 / camera.focal;
        let limit = half * rules.guard;
        let held = (view.truncate() / view.z).clamp(-limit, limit);
        let scale = self.cloud.log_scales()[own.index].map(|s| f64::from(s).exp());
        let axes = camera.world_to_camera.matrix3
            * rotation(self.cloud.rotations()[own.index])
            * DMat3::from_diagonal(DVec3::from(scale));
        let per_depth = camera.focal / view.z;
        [
            per_depth.x * (axes.row(0) - held.x * axes.row(2)),
            per_depth.y * (axes.row(1) - held.y * axes.row(2)),
        ]
    }

    /// The longest Gaussians beside numbers of 256 bits.
    fn needles(&self) -> SceneCheck {
        let elongation = |own: &Projected| {
            let [large, small] = own.footprint.eigenvalues();
            (large / small).sqrt()
        };
        let mut longest: Vec<&Projected> = self.view.splats().iter().collect();
        longest.sort_by(|a, b| elongation(b).total_cmp(&elongation(a)));
        longest.truncate(MOST);
        let Some(first) = longest.first().map(|own| elongation(own)) else {
            return SceneCheck::without(NEEDLES, "no Gaussian is in view");
        };
        let rules = self.view.rules();
        let (mut ours, mut naive) = (Worst::default(), Worst::default());
        let (mut not_positive, mut other) = (0usize, 0usize);
        for own in &longest {
            let rows = self.rows(own, rules);
            other += usize::from(Footprint::new(rows[0], rows[1], rules.dilation) != own.footprint);
            let exact = determinant(rows, rules.dilation);
            ours.see(exact.relative(own.footprint.determinant));
            let [xx, xy, yy] = in_32_bits(rows);
            let plain = xx * yy - xy * xy;
            not_positive += usize::from(plain.is_nan() || plain <= 0.0);
            naive.see(exact.relative(f64::from(plain)));
        }
        let count = longest.len();
        let evidence = format!(
            "the {count} longest of {} in view, up to {first:.0} times as long as wide: off by {:.1e} \
             (relative), at most {DETERMINANT:.1e}",
            self.view.splats().len(),
            ours.0
        );
        SceneCheck::new(NEEDLES, ours.0 <= DETERMINANT && other == 0, evidence).beside(format!(
            "xx yy - xy xy in 32 bits: off by {:.1e}, {not_positive} of {count} not above 0",
            naive.0
        ))
    }

    /// Opacities beside the least alpha that counts, by an exact comparison of integers.
    fn opacities_at_the_cut(&self, form: RecordForm) -> SceneCheck {
        let full = 65_536.0;
        let rules = self.view.rules();
        let least = Limits::new(rules).alpha_min;
        let nearest = (rules.alpha_min * full).round() as i32;
        let (mut near, mut ours, mut naive) = (0usize, 0usize, 0usize);
        for own in self.view.splats() {
            let code = record(own, 0, form, &mut Saturations::default()).opacity;
            let (code, exact) = (i32::from(code), f64::from(code) < rules.alpha_min * full);
            near += usize::from((code - least).abs() <= 1);
            ours += usize::from((code < least) != exact);
            naive += usize::from((code < nearest) != exact);
        }
        SceneCheck::new(
            CUT,
            ours == 0,
            format!("{near} Gaussians in view within a code of it, {ours} decided wrongly"),
        )
        .beside(format!("the nearest code: {naive} decided wrongly"))
    }

    /// Values that records hold at the end of their formats.
    fn held(&self, form: RecordForm) -> SceneCheck {
        let mut held = Saturations::default();
        for own in self.view.splats() {
            let _ = record(own, 0, form, &mut held);
        }
        let Saturations {
            mean,
            factor,
            opacity,
            colour,
        } = held;
        // A mean that far off and an opacity of 1 show as they would.
        SceneCheck::new(
            HELD,
            factor + colour == 0,
            format!(
                "{colour} colour channels of 16 or more, {factor} factors of 2 or more; and, without \
                 harm, {mean} means beyond 2^19 pixels, {opacity} opacities that round to 1"
            ),
        )
        .beside(format!(
            "the codes' low bits: {} values wrap",
            held.total()
        ))
    }

    /// Gaussians before the near plane are culled, and all others are finite.
    fn near(&self) -> SceneCheck {
        let rules = self.view.rules();
        let camera = self.scene.camera();
        let is_odd = |own: &&Projected| {
            let f = &own.footprint;
            let all = f.covariance.iter().chain(&f.factor);
            !(own.mean.is_finite() && f.determinant > 0.0 && all.into_iter().all(|v| v.is_finite()))
        };
        let odd = self.view.splats().iter().filter(is_odd).count();
        let (mut behind, mut mirrored) = (0, 0);
        for mean in self.cloud.means() {
            let world = DVec3::from(mean.map(f64::from));
            let view = camera.world_to_camera.transform_point3(world);
            if rules.sees(view.z) {
                continue;
            }
            behind += 1;
            let at = view.truncate() / view.z * camera.focal + camera.centre;
            let frame = DVec2::new(camera.width.into(), camera.height.into());
            let inside = at.cmpge(DVec2::ZERO).all() && at.cmplt(frame).all();
            mirrored += usize::from(inside || !at.is_finite());
        }
        SceneCheck::new(
            NEAR,
            odd == 0,
            format!(
                "{behind} of {} Gaussians ({:.1} %) lie there and are culled; of those in view {odd} \
                 are not finite",
                self.cloud.len(),
                percent(behind, self.cloud.len())
            ),
        )
        .beside(format!(
            "division by the depth, nothing culled: {mirrored} in the frame, mirrored"
        ))
    }

    /// The quaternions whose lengths are farthest from 1, beside numbers of 256 bits.
    fn turns(&self) -> SceneCheck {
        let length = |q: &[f32; 4]| q.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt();
        let odd = |q: &[f32; 4]| length(q).ln().abs();
        let mut all: Vec<[f32; 4]> = self.cloud.rotations().to_vec();
        all.sort_by(|a, b| odd(b).total_cmp(&odd(a)));
        let none = all.iter().filter(|q| length(q) == 0.0).count();
        all.truncate(MOST);
        let lengths = all.iter().map(length).filter(|l| *l > 0.0);
        let (short, long) = lengths.fold((f64::MAX, 0f64), |(a, b), l| (a.min(l), b.max(l)));
        let (mut ours, mut naive) = (Worst::default(), Worst::default());
        for quaternion in &all {
            let own = rotation(*quaternion).to_cols_array();
            let plain = normalised_in_32_bits(*quaternion);
            for (i, right) in turned(*quaternion).iter().enumerate() {
                ours.see(right.error(own[i]));
                naive.see(right.error(f64::from(plain[i])));
            }
        }
        let naive = match naive.0 {
            f64::INFINITY => "no number".to_owned(),
            off => format!("off by {off:.1e}"),
        };
        let range = match short <= long {
            true => format!("lengths from {short:.3} to {long:.3}"),
            false => "no length".to_owned(),
        };
        SceneCheck::new(
            TURNS,
            ours.0 <= ROTATION,
            format!(
                "{none} of length 0, {range}: rotations off by {:.1e}, at most {ROTATION:.1e}",
                ours.0
            ),
        )
        .beside(format!("normalised in 32 bits: {naive}"))
    }
}
