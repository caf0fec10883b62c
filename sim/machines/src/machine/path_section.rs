//! `[path]`: which frames of a path are rendered in full, and which are warped.

use potamoi_formats::document::{Value, Wrong};
use potamoi_formats::nearest::nearest;
use potamoi_system::system_model::{Frames, Variant};
use potamoi_warp::Profile;
use serde::{Deserialize, Serialize};

use super::MachineError;

/// Variant where a machine names none: each frame in full, gathered by the unit.
const IN_FULL: &str = "fs+gu";
/// Variant where a machine names a window: references in full, gathered by the unit, the rest warped.
const WARPED: &str = "potamoi";

/// How the frames of a path are rendered.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PathSection {
    /// Name of the system's variant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variant: Option<String>,
    /// Targets of a reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window: Option<u32>,
    /// Largest angle between the rays of reference and target at a point, in degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phi: Option<f64>,
    /// Rules that classify pixels as warped or rendered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<Profile>,
}

impl PathSection {
    pub(super) fn of(name: &str, section: &Value) -> Result<Self, MachineError> {
        let wrong = |wrong: Wrong| MachineError::wrong(name, &wrong.under("path"));
        let own: Self = section.read().map_err(wrong)?;
        if let Some(given) = &own.variant
            && Variant::named(given).is_none()
        {
            let names = Variant::ALL.map(|own| own.name);
            let near = nearest(given, names);
            let near = near.map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
            let expected = format!("one of {}{near}", names.join(", "));
            return Err(wrong(
                Wrong::found(format!("\"{given}\""), expected).under("variant"),
            ));
        }
        if own.window == Some(0) {
            return Err(wrong(Wrong::found("0", "1 frame or more").under("window")));
        }
        if let Some(phi) = own.phi.filter(|phi| !(0.0..=180.0).contains(phi)) {
            let expected = "0 to 180 degrees";
            return Err(wrong(Wrong::found(phi, expected).under("phi")));
        }
        let variant = own.variant();
        if matches!(variant.frames, Frames::Full | Frames::Half) {
            let given = [
                ("window", own.window.is_some()),
                ("phi", own.phi.is_some()),
                ("profile", own.profile.is_some()),
            ];
            if let Some((key, _)) = given.into_iter().find(|(_, is)| *is) {
                let problem = format!(
                    "it is for frames that are warped, and variant {} warps none: leave it out",
                    variant.name
                );
                return Err(wrong(Wrong::new(problem).under(key)));
            }
        }
        Ok(own)
    }

    /// The variant: the named one, otherwise `potamoi` with a window, and `fs+gu` without.
    #[must_use]
    pub fn variant(&self) -> Variant {
        let warps = self.window.is_some() || self.phi.is_some() || self.profile.is_some();
        let name = match (&self.variant, warps) {
            (Some(name), _) => name,
            (None, true) => WARPED,
            (None, false) => IN_FULL,
        };
        // Names were checked.
        Variant::named(name).unwrap_or(Variant::ALL[0])
    }
}
