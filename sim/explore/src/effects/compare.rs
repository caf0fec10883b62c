//! Results with effects forced, and with effects left out.

use potamoi_analysis::{Finding, Hardware};
use potamoi_base::effects::{Choices, Effect};
use potamoi_base::picture::Picture;
use potamoi_cycles::effect_meter::{EffectCycles, EffectMeter};
use potamoi_reference::ReferenceUnits;
use potamoi_reference::observer::Observed;
use potamoi_scene::{Rendered, Scene};
use potamoi_system::call_digest::CallDigest;
use schemars::JsonSchema;
use serde::Serialize;

use super::wall_time::{Pairs, Stopwatch};
use crate::ExploreError;

/// Results of a frame: pictures, trace and cycles.
struct Outcome {
    float: Rendered,
    fixed: Rendered,
    digest: String,
    cycles: EffectCycles,
}

impl Outcome {
    fn of(watch: &Stopwatch<'_>, scene: &Scene) -> Result<Self, ExploreError> {
        let mut twins = ReferenceUnits::new(watch.config);
        let mut meter = EffectMeter::new(watch.config);
        let mut digest = CallDigest::default();
        let mut units = Observed::new(&mut twins, watch.config)
            .by(&mut meter)
            .by(&mut digest);
        let fixed = scene.render_fixed(watch.config, &mut units)?;
        Ok(Self {
            float: scene.render_float()?,
            fixed,
            digest: digest.finish(),
            cycles: meter.cycles(),
        })
    }
}

/// A frame with effects forced, compared with the frame of required effects alone.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Forced {
    /// Forced effects.
    pub effects: Vec<String>,
    /// Whether pictures are equal bit for bit, in floating point and in the hardware's formats.
    pub same_image: bool,
    /// Whether all calls of the units are equal.
    pub same_trace: bool,
    /// Digest of the calls.
    pub trace: String,
    /// Whether modelled cycles are equal, also on the hardware that the scene needs.
    pub same_cycles: bool,
    /// Cycles of the frame without forcing.
    pub cycles: EffectCycles,
    /// Wall time with and without forcing; `None` without timed pairs.
    pub wall: Option<Pairs>,
}

impl Forced {
    pub(super) fn find(
        watch: &Stopwatch<'_>,
        hardware: &Hardware,
        choices: Choices,
        is_remote: bool,
    ) -> Result<Self, ExploreError> {
        let forced = Effect::ALL
            .into_iter()
            .filter(|effect| choices.forces(*effect));
        let effects: Vec<Effect> = forced.collect();
        let own = effects
            .iter()
            .copied()
            .fold(Choices::default(), Choices::force);
        let scene = watch.chosen(own);
        let [plain, all] = [
            Outcome::of(watch, watch.scene)?,
            Outcome::of(watch, &scene)?,
        ];
        // The hardware without what is not called for, by its own cycle model.
        let reduced = {
            let mut twins = ReferenceUnits::new(&hardware.config);
            let mut meter = EffectMeter::new(&hardware.config);
            let mut units = Observed::new(&mut twins, &hardware.config).by(&mut meter);
            watch.scene.render_fixed(watch.config, &mut units)?;
            meter.cycles()
        };
        let warps = own.forces(Effect::Warping) && !is_remote && watch.path.len() > 1;
        let paths = match warps {
            true => watch.warped(watch.scene, false)? == watch.warped(watch.scene, true)?,
            false => true,
        };
        let timed = |with: bool| {
            let scene = if with { &scene } else { watch.scene };
            scene.render_float()?;
            scene.render_fixed(watch.config, &mut ReferenceUnits::new(watch.config))?;
            if warps {
                watch.warped(watch.scene, with)?;
            }
            Ok(())
        };
        let wall = match watch.pairs {
            0 => None,
            _ => watch.in_pairs(timed)?,
        };
        Ok(Self {
            effects: effects.iter().map(ToString::to_string).collect(),
            same_image: plain.float == all.float && plain.fixed == all.fixed && paths,
            same_trace: plain.digest == all.digest,
            trace: plain.digest,
            same_cycles: plain.cycles == all.cycles && plain.cycles == reduced,
            cycles: plain.cycles,
            wall,
        })
    }

    /// Whether forcing changed nothing.
    #[must_use]
    pub const fn is_same(&self) -> bool {
        self.same_image && self.same_trace && self.same_cycles
    }
}

/// A frame without an effect, compared with the frame with it.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Without {
    /// Name of the effect.
    pub name: &'static str,
    /// Degree of spherical harmonics, for that effect.
    pub degree: Option<u8>,
    /// Whether the scene calls for the effect.
    pub called_for: bool,
    /// What was compared: a frame or a path.
    pub of: &'static str,
    /// PSNR in dB in linear RGB, unquantised, peak 1; `None` where pictures are equal.
    pub psnr_db: Option<f64>,
    /// Pixels compared.
    pub pixels: u64,
    /// Pixels in which a channel differs.
    pub pixels_changed: u64,
    /// Largest difference of a channel, linear, peak 1.
    pub largest_difference: f32,
    /// Modelled cycles of all units without the effect minus those with it; `None` for effects of a
    /// path.
    pub cycles_more: Option<i64>,
}

impl Without {
    pub(super) fn find(watch: &Stopwatch<'_>, finding: &Finding) -> Result<Self, ExploreError> {
        let effect = finding.effect;
        let mut own = Self {
            name: effect.name(),
            degree: effect.degree(),
            called_for: finding.is_called_for,
            of: "the frame in the hardware's formats",
            psnr_db: None,
            pixels: 0,
            pixels_changed: 0,
            largest_difference: 0.0,
            cycles_more: None,
        };
        if matches!(effect, Effect::Warping | Effect::Disocclusion) {
            own.of = "the path's frames in floating point";
            let with = watch.warped(watch.scene, false)?;
            let with: Vec<Picture> = with.into_iter().map(|f| f.target.shaded.picture).collect();
            let without = match effect {
                Effect::Warping => watch.full()?,
                _ => {
                    let frames = watch.with_holes()?;
                    frames
                        .into_iter()
                        .map(|f| f.target.shaded.picture)
                        .collect()
                }
            };
            own.compare(&with, &without);
            return Ok(own);
        }
        let with = Outcome::of(watch, watch.scene)?;
        let scene = watch.chosen(Choices::default().leave_out(effect));
        let without = Outcome::of(watch, &scene)?;
        own.compare(&[with.fixed.picture], &[without.fixed.picture]);
        let all = |c: &EffectCycles| (c.gather + c.vector + c.array + c.splats) as i64;
        own.cycles_more = Some(all(&without.cycles) - all(&with.cycles));
        Ok(own)
    }

    fn compare(&mut self, with: &[Picture], without: &[Picture]) {
        let mut squares = 0.0;
        for (a, b) in with.iter().zip(without) {
            self.pixels += a.rgb.len() as u64;
            squares += a.mean_squared_error(b, |_| true).unwrap_or(0.0);
            for (p, q) in a.rgb.iter().zip(&b.rgb) {
                let off = p.iter().zip(q).map(|(p, q)| (p - q).abs());
                let off = off.fold(0f32, f32::max);
                self.pixels_changed += u64::from(off > 0.0);
                self.largest_difference = self.largest_difference.max(off);
            }
        }
        let mean = squares / with.len().max(1) as f64;
        self.psnr_db = (mean > 0.0).then(|| -10.0 * mean.log10());
    }
}
