//! Pictures by any arithmetic, from the analytic field to the Verilated units.

use potamoi_analysis::Hardware;
use potamoi_base::camera::Camera;
use potamoi_base::effects::{Choices, Effect};
use potamoi_formats::config::Config;
use potamoi_reference::{ReferenceUnits, UnitCounts};
use potamoi_rtl::{RtlCycles, RtlUnits};
use potamoi_scene::{FrameCounts, Rendered, Scene};
use schemars::JsonSchema;
use serde::Serialize;

use crate::ExploreError;

/// Arithmetic that renders a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Numerics {
    /// Ground truth: the analytic field that a built-in model was sampled from.
    Truth,
    /// 64-bit floating point.
    Float,
    /// The hardware's formats, on the reference units.
    Fixed,
    /// The hardware's formats, on the Verilated units.
    Rtl,
}

/// A picture with the units' counts and cycles.
pub struct Shot {
    /// The picture, with the renderer's counts.
    pub picture: Rendered,
    /// Results counted by the units themselves, where units were used.
    pub units: Option<UnitCounts>,
    /// Clock cycles of the Verilated units with streams always ready.
    pub cycles: Option<RtlCycles>,
    /// Whether the Verilated gathering unit, vector unit and splat unit were built.
    pub instantiated: Option<[bool; 3]>,
}

impl Shot {
    /// A picture without units.
    #[must_use]
    pub fn of(picture: Rendered) -> Self {
        Self {
            picture,
            units: None,
            cycles: None,
            instantiated: None,
        }
    }

    /// The frame's counts, where units were used.
    #[must_use]
    pub fn counts(&self) -> Option<&FrameCounts> {
        self.units.is_some().then_some(&self.picture.counts)
    }
}

/// The scene in floating point with no effect left out: what a picture in the hardware's formats is
/// compared with to see the error of the formats alone.
///
/// # Errors
/// A scene that cannot be rendered.
pub fn whole_float(scene: &Scene) -> Result<Rendered, ExploreError> {
    let mut whole = scene.clone();
    whole.set_choices(Choices::default());
    Ok(whole.render_float()?)
}

/// Refuses to leave out effects in floating point, which has no units.
fn refuse_of_units(scene: &Scene) -> Result<(), ExploreError> {
    let of_units = [Effect::Trilinear, Effect::Exponential];
    match of_units
        .iter()
        .find(|own| scene.choices().leaves_out(**own))
    {
        Some(effect) => Err(ExploreError::Refused(format!(
            "--without {effect}: expected --numerics fixed or rtl: the effect is one of the units"
        ))),
        None => Ok(()),
    }
}

/// Renders what the scene's camera sees.
///
/// # Errors
/// A scene that the configuration cannot render, left-out effects that belong to no unit, or
/// Verilog that cannot be built or run or that raises an error flag.
pub fn shoot(scene: &Scene, config: &Config, numerics: Numerics) -> Result<Shot, ExploreError> {
    Ok(match numerics {
        Numerics::Truth => Shot::of(scene.render_truth()?),
        Numerics::Float => {
            refuse_of_units(scene)?;
            Shot::of(scene.render_float()?)
        }
        Numerics::Fixed => {
            let mut twins = ReferenceUnits::new(config);
            let picture = scene.render_fixed(config, &mut twins)?;
            Shot {
                picture,
                units: Some(twins.counts().clone()),
                cycles: None,
                instantiated: None,
            }
        }
        Numerics::Rtl => {
            let choices = scene.choices();
            let mut rtl = if choices == Choices::default() {
                RtlUnits::new(&Hardware::of(scene, config)?.config)
            } else {
                RtlUnits::new(config)
            };
            if [Effect::Trilinear, Effect::Exponential].map(|e| choices.forces(e)) == [true; 2] {
                rtl.instantiate()?;
            }
            let picture = scene.render_fixed(config, &mut rtl)?;
            if rtl.gather_flags() != 0 {
                return Err(ExploreError::Check(format!(
                    "the gathering unit raised flags {:#010b} of stat_errors, which \
                     docs/reference/gathering-unit.md names; no picture is written",
                    rtl.gather_flags()
                )));
            }
            Shot {
                picture,
                units: Some(rtl.counts().clone()),
                cycles: Some(rtl.cycles()),
                instantiated: Some(rtl.instantiated()),
            }
        }
    })
}

/// Items that pictures through these cameras leave unchecked. In floating point nothing outside the
/// units is in question.
#[must_use]
pub fn not_checked(
    scene: &Scene,
    config: &Config,
    numerics: Numerics,
    cameras: &[Camera],
) -> Vec<String> {
    match numerics {
        Numerics::Truth => scene.unseen(cameras).into_iter().collect(),
        Numerics::Float => scene.left_open_along(cameras),
        Numerics::Fixed | Numerics::Rtl => scene.not_checked_along(config, cameras),
    }
}
