//! Rule sets of other renderers, for reproducing their pictures.

use std::fmt;
use std::str::FromStr;

use potamoi_formats::record::FACTOR;
use thiserror::Error;

use super::transmittance::TRANSMITTANCE;
use potamoi_base::precision::Precision;

/// The renderer whose rules are followed.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize, schemars::JsonSchema,
)]
pub enum Profile {
    /// The reference rasteriser of 3D Gaussian splatting.
    #[default]
    Inria,
    /// gsplat, with the alpha cap of 0.999 of its releases.
    Gsplat,
    /// gsplat, with the alpha cap of 0.99 of its later versions.
    GsplatCap99,
    /// Brush.
    Brush,
}

/// A text that does not name a [`Profile`].
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("profile `{0}` is unknown: expected inria, gsplat, gsplat-cap99 or brush")]
pub struct UnknownProfile(String);

impl Profile {
    /// All profiles.
    pub const ALL: [Self; 4] = [Self::Inria, Self::Gsplat, Self::GsplatCap99, Self::Brush];

    /// The name on the command line and in scene files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Inria => "inria",
            Self::Gsplat => "gsplat",
            Self::GsplatCap99 => "gsplat-cap99",
            Self::Brush => "brush",
        }
    }

    /// The constants and choices of this renderer.
    #[must_use]
    pub const fn rules(self) -> Rules {
        let gsplat = Rules {
            near: 0.01,
            near_is_visible: true,
            guard: 1.3,
            dilation: 0.3,
            pixel_centre: 0.5,
            alpha_cap: 0.999_f32 as f64,
            alpha_min: (1.0_f32 / 255.0) as f64,
            stop_below: 1e-4_f32 as f64,
            stop_at_equal: true,
            extent: Extent::AxisBox,
            transmittance_bits: TRANSMITTANCE.frac_bits(),
            conic_bits: FACTOR.frac_bits(),
        };
        match self {
            Self::Inria => Rules {
                near: 0.2,
                near_is_visible: false,
                pixel_centre: 0.0,
                alpha_cap: 0.99_f32 as f64,
                stop_at_equal: false,
                extent: Extent::Square,
                ..gsplat
            },
            Self::Gsplat => gsplat,
            Self::GsplatCap99 => Rules {
                alpha_cap: 0.99_f32 as f64,
                ..gsplat
            },
            Self::Brush => Rules {
                extent: Extent::Ellipse,
                ..gsplat
            },
        }
    }
}

impl fmt::Display for Profile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Profile {
    type Err = UnknownProfile;

    fn from_str(text: &str) -> Result<Self, UnknownProfile> {
        Self::ALL
            .into_iter()
            .find(|p| p.name() == text)
            .ok_or_else(|| UnknownProfile(text.to_owned()))
    }
}

/// The rule for the tiles in which a Gaussian is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Tiles that touch the square of `ceil(3 sigma)` pixels around the mean, sigma along the
    /// longest axis (variance at least `mid + sqrt(0.1)`).
    Square,
    /// Tiles that touch the box of `ceil(e sigma)` pixels, sigma along x and along y, `e =
    /// min(3.33, sqrt(2 ln(255 o)))`; none below `o = 1/255`.
    AxisBox,
    /// Tiles with a pixel area that the ellipse `alpha = 1/255` reaches.
    Ellipse,
}

/// The constants and choices in which renderers differ.
///
/// Thresholds have the values that 32-bit floats give them. Two samples capped at 0.99 leave a
/// transmittance just below 1e-4 in the reference, but just above it with 64-bit constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Near plane: Gaussians with a smaller view depth are culled.
    pub near: f64,
    /// Whether a depth of exactly `near` is visible.
    pub near_is_visible: bool,
    /// Limit of the position at which the Jacobian is evaluated, in units of `tan(fov / 2)`.
    pub guard: f64,
    /// Added to both variances of the projected covariance, in square pixels.
    pub dilation: f64,
    /// Centre of pixel 0 in the coordinates of projected means: 0.5, or 0 if means are shifted by
    /// half a pixel instead. Affects only tile bounds.
    pub pixel_centre: f64,
    /// Upper limit of alpha.
    pub alpha_cap: f64,
    /// Alpha threshold: smaller alphas are skipped.
    pub alpha_min: f64,
    /// Early-termination threshold: a pixel stops before the Gaussian that would take its
    /// transmittance below this.
    pub stop_below: f64,
    /// Whether a pixel stops at exactly `stop_below`, too.
    pub stop_at_equal: bool,
    /// The rule for the tiles in which a Gaussian is drawn.
    pub extent: Extent,
    /// Fraction bits of transmittances in the hardware's formats.
    pub transmittance_bits: u32,
    /// Fraction bits of the factors of conics in the hardware's records.
    pub conic_bits: u32,
}

impl Rules {
    /// The same rules with the overrides of a precision.
    #[must_use]
    pub fn with(self, precision: &Precision) -> Self {
        Self {
            stop_below: precision.stop_below.unwrap_or(self.stop_below),
            alpha_min: precision.alpha_min.unwrap_or(self.alpha_min),
            transmittance_bits: precision
                .transmittance_bits
                .unwrap_or(self.transmittance_bits),
            conic_bits: precision.conic_bits.unwrap_or(self.conic_bits),
            ..self
        }
    }

    /// Whether a view depth is visible.
    #[must_use]
    pub fn sees(&self, depth: f64) -> bool {
        depth > self.near || (self.near_is_visible && depth == self.near)
    }

    /// Whether a pixel terminates instead of reaching this transmittance.
    #[must_use]
    pub fn stops(&self, transmittance: f64) -> bool {
        transmittance < self.stop_below || (self.stop_at_equal && transmittance == self.stop_below)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for p in Profile::ALL {
            assert_eq!(p.to_string().parse(), Ok(p));
        }
        assert!("Inria".parse::<Profile>().is_err());
    }

    #[test]
    fn limits_belong_where_each_renderer_puts_them() {
        let (inria, gsplat) = (Profile::Inria.rules(), Profile::Gsplat.rules());
        assert!(!inria.sees(0.2) && inria.sees(0.200_000_1));
        assert!(gsplat.sees(0.01) && !gsplat.sees(0.009_999));
        assert!(!inria.stops(inria.stop_below) && inria.stops(0.999e-4));
        assert!(gsplat.stops(gsplat.stop_below) && !gsplat.stops(1.001e-4));
    }
}
