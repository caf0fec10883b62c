//! Classification of a target frame's pixels: warped, void or rendered.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::WarpError;
use super::sampling::Sampling;

/// The source of a target pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Class {
    /// From the reference frame.
    Warped,
    /// The background: the ray is empty.
    Void,
    /// Rendered: disoccluded, the reference does not show it.
    Disoccluded,
    /// Rendered: the reference sees it at too large an angle.
    Angle,
    /// Rendered: the reference shows an edge there, or the pixel is not known to be surface or
    /// void.
    Edge,
    /// Rendered with its whole frame.
    Full,
}

impl Class {
    /// All classes.
    pub const ALL: [Self; 6] = [
        Self::Warped,
        Self::Void,
        Self::Disoccluded,
        Self::Angle,
        Self::Edge,
        Self::Full,
    ];

    /// Whether the model renders such pixels.
    #[must_use]
    pub const fn is_rendered(self) -> bool {
        matches!(
            self,
            Self::Disoccluded | Self::Angle | Self::Edge | Self::Full
        )
    }
}

/// Numbers of pixels by class.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Counts {
    /// Warped from the reference.
    pub warped: u64,
    /// Background.
    pub void: u64,
    /// Rendered because the reference does not show them.
    pub disoccluded: u64,
    /// Rendered because the reference sees them at too large an angle.
    pub angle: u64,
    /// Rendered because the reference shows an edge there.
    pub edge: u64,
    /// Rendered as part of full frames.
    pub full: u64,
}

impl Counts {
    /// Counts the pixels that `counts` selects.
    #[must_use]
    pub fn of(classes: &[Class], counts: impl Fn(usize) -> bool) -> Self {
        let mut all = Self::default();
        for (i, class) in classes.iter().enumerate() {
            if counts(i) {
                *match class {
                    Class::Warped => &mut all.warped,
                    Class::Void => &mut all.void,
                    Class::Disoccluded => &mut all.disoccluded,
                    Class::Angle => &mut all.angle,
                    Class::Edge => &mut all.edge,
                    Class::Full => &mut all.full,
                } += 1;
            }
        }
        all
    }

    /// Total number of pixels.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.warped + self.void + self.disoccluded + self.angle + self.edge + self.full
    }

    /// Number of pixels that the model renders.
    #[must_use]
    pub const fn rendered(&self) -> u64 {
        self.disoccluded + self.angle + self.edge + self.full
    }
}

impl std::ops::Add for Counts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            warped: self.warped + other.warped,
            void: self.void + other.void,
            disoccluded: self.disoccluded + other.disoccluded,
            angle: self.angle + other.angle,
            edge: self.edge + other.edge,
            full: self.full + other.full,
        }
    }
}

/// The angle that is compared with the threshold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Angle {
    /// The angle between the two rays at the point, the paper's theta.
    Subtended,
    /// `atan(half the cameras' distance / depth)`, as in the first authors' program: half the
    /// angle for a point centred in front of both cameras.
    Half,
}

/// What is rendered if an angle is above the threshold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scope {
    /// The pixel.
    Pixel,
    /// The whole frame, as in the paper's control logic.
    Frame,
}

/// The rules of classification.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rule {
    /// A pixel is rendered if its known depth is below this fraction, 0 to 1, of the depth warped
    /// to it. Applies only if the target's depth is known.
    pub nearer: f64,
    /// The largest angle in radians; `None` for no limit.
    pub phi: Option<f64>,
    /// The angle that is compared.
    pub angle: Angle,
    /// What is rendered above the limit.
    pub scope: Scope,
    /// Whether a point warped to a void pixel is kept, as in the first authors' program; otherwise
    /// the pixel is background.
    pub keep_over_void: bool,
    /// Sampling of colours in the reference.
    pub sampling: Sampling,
    /// Whether pixels at edges of the reference are rendered; the paper warps them.
    pub render_edges: bool,
    /// Whether pixels on which no point landed are warped if the reference shows their surface;
    /// the paper renders them.
    pub fill_cracks: bool,
    /// Whether a frame is warped even if its camera equals that of its reference bit by bit. The
    /// frame equals the reference in either case.
    pub warps_still: bool,
}

/// Named sets of rules.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Profile {
    /// Bilinear sampling, filled cracks and rendered edges.
    #[default]
    Potamoi,
    /// The paper's four steps: nearest samples, and only disoccluded pixels are rendered.
    Paper,
    /// As [`Profile::Paper`], with the first authors' half-angle.
    FirstAuthors,
}

impl Profile {
    /// The rules, with the first authors' threshold of 0.995 and no limit of the angle.
    #[must_use]
    pub const fn rule(self) -> Rule {
        let plain = !matches!(self, Self::Potamoi);
        Rule {
            nearer: 0.995,
            phi: None,
            angle: if matches!(self, Self::FirstAuthors) {
                Angle::Half
            } else {
                Angle::Subtended
            },
            scope: Scope::Pixel,
            keep_over_void: true,
            sampling: if plain {
                Sampling::Nearest
            } else {
                Sampling::Bilinear
            },
            render_edges: !plain,
            fill_cracks: !plain,
            warps_still: false,
        }
    }
}

impl Rule {
    /// Checks the ranges.
    ///
    /// # Errors
    /// A number is out of range.
    pub fn check(&self) -> Result<(), WarpError> {
        if !(0.0..=1.0).contains(&self.nearer) {
            return Err(WarpError::Option {
                field: "nearer",
                value: self.nearer.to_string(),
                expected: "0 to 1, a share of the warped depth".to_owned(),
            });
        }
        match self.phi {
            Some(phi) if !(0.0..=std::f64::consts::PI).contains(&phi) => Err(WarpError::Option {
                field: "phi",
                value: format!("{} degrees", phi.to_degrees()),
                expected: "0 to 180 degrees".to_owned(),
            }),
            _ => Ok(()),
        }
    }

    /// Whether a point is seen at too large an angle. `reference` and `target` are the vectors
    /// from the cameras to it, `depth` is its depth along the target's axis. NaN counts as too
    /// large.
    pub(super) fn is_too_far(&self, reference: DVec3, target: DVec3, depth: f64) -> bool {
        let Some(phi) = self.phi else {
            return false;
        };
        let theta = match self.angle {
            Angle::Subtended => subtended(reference, target),
            Angle::Half => ((reference - target).length() / 2.0 / depth).atan(),
        };
        theta > phi || theta.is_nan()
    }
}

/// The angle between two vectors in radians, 0 to pi, to the last few bits even if it is small:
/// the arc cosine of their normalised product loses all bits below 1e-8. A right angle if one has
/// length 0.
pub fn subtended(a: DVec3, b: DVec3) -> f64 {
    if a == DVec3::ZERO || b == DVec3::ZERO {
        return FRAC_PI_2;
    }
    a.cross(b).length().atan2(a.dot(b))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn small_angles_keep_their_bits_where_the_arc_cosine_loses_them() {
        for theta in [1e-12f64, 1e-9, 3e-8, 1e-3, 1.0, 3.0] {
            let (a, b) = (DVec3::X * 3.0, DVec3::new(theta.cos(), theta.sin(), 0.0));
            let error = (subtended(a, b) / theta - 1.0).abs();
            assert!(error < 1e-12, "{theta}: {error}");
        }
        let naive = |a: DVec3, b: DVec3| (a.dot(b) / (a.length() * b.length())).acos();
        let b = DVec3::new(1.0, 1e-9, 0.0);
        assert_eq!(naive(DVec3::X, b), 0.0);
        assert_eq!(subtended(DVec3::X, DVec3::NEG_X), std::f64::consts::PI);
        assert_eq!(subtended(DVec3::X, DVec3::ZERO), FRAC_PI_2);
    }

    #[test]
    fn half_the_angle_is_half_of_it_in_the_middle() {
        let point = DVec3::new(0.0, 0.0, 2.0);
        let eyes = [DVec3::new(-0.1, 0.0, 0.0), DVec3::new(0.1, 0.0, 0.0)];
        let [a, b] = eyes.map(|eye| point - eye);
        let theta = subtended(a, b);
        for (factor, angle) in [(1.0, Angle::Subtended), (0.5, Angle::Half)] {
            let at = |phi| Rule {
                phi: Some(phi),
                angle,
                ..Profile::Paper.rule()
            };
            assert!(!at(theta * factor * 1.001).is_too_far(a, b, 2.0));
            assert!(at(theta * factor * 0.999).is_too_far(a, b, 2.0));
            assert!(at(3.0).is_too_far(DVec3::NAN, b, f64::NAN));
        }
        assert!(!Profile::Paper.rule().is_too_far(a, b, 2.0));
    }

    #[test]
    fn rules_out_of_range_are_refused_by_name() {
        let wrong = Rule {
            phi: Some(4.0),
            ..Profile::Paper.rule()
        };
        assert!(wrong.check().unwrap_err().to_string().contains("phi"));
        let wrong = Rule {
            nearer: f64::NAN,
            ..Profile::Paper.rule()
        };
        assert!(wrong.check().unwrap_err().to_string().contains("nearer"));
        Profile::Paper.rule().check().unwrap();
    }
}
