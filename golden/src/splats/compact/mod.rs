//! Compact-3DGS (Lee, Rho, Sun, Ko, Park: Compact 3D Gaussian Representation for
//! Radiance Field, CVPR 2024): Gaussians whose scales and rotations are sums of
//! codes, and whose colour is a neural field's.
//!
//! A camera makes an ordinary [`Cloud`] of degree 0 of it: the field is asked
//! for every Gaussian's colour from there before anything is drawn, as its
//! authors' renderer does.
//!
//! Read is the plain `.npz` of their `save_npz`. Its codebooks are pickles of
//! PyTorch, read as data; arrays of numbers, (stages, codes, 3 and 4) in 32
//! bits, are taken in their place. The field is computed in 64 bits: theirs
//! rounds features and layers to 16.

mod codes;
mod npz;
mod shape;
#[cfg(test)]
mod tests;

use std::path::Path;

use glam::DVec3;
use potamoi_formats::config::Config;
use rayon::prelude::*;

use super::Cloud;
use super::files::{self, FileError, Origin};
use super::sh;
use crate::fields::{FieldError, FieldWork, FixedColour, HashedColour};
use crate::units::Units;
use crate::voxels::FixedStats;
use codes::Stages;
use npz::Npz;

/// The ending of a model's name.
pub const ENDING: &str = "npz";

/// The arrays of a model.
const ARRAYS: [&str; 9] = [
    "xyz",
    "opacity",
    "scale",
    "rotation",
    "hash",
    "mlp",
    "codebook_scale",
    "codebook_rotation",
    "rvq_info",
];

/// A Compact-3DGS model.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Compact {
    /// Without colour.
    gaussians: Cloud,
    colour: HashedColour,
}

impl Compact {
    /// Loads a model, `.npz`.
    ///
    /// # Errors
    /// The file cannot be read, is no such model, or its post-processed variant.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        let origin = path.display().to_string();
        Self::parse(&files::whole(path)?, &origin)
    }

    /// Reads a model from a file's bytes; `origin` names it in errors.
    ///
    /// # Errors
    /// As [`Compact::load`].
    pub fn parse(bytes: &[u8], origin: &str) -> Result<Self, FileError> {
        let name = Origin(origin);
        let mut npz = Npz::open(bytes, name)?;
        if let Some(table) = npz.names().find(|n| n.starts_with("huftable")) {
            let field = format!("array `{table}`");
            let expected = "the plain variant, point_cloud.npz, which is written without --comp";
            let found = "there, so this is the post-processed variant with Huffman codes";
            return Err(name.field(field, found, expected));
        }
        npz.require(&ARRAYS)?;
        let xyz = npz.array("xyz")?;
        let right = matches!(xyz.shape[..], [n, 3] if n > 0);
        xyz.shaped(right, "(Gaussians, 3), 1 or more")?;
        let means: Vec<[f32; 3]> = xyz.halves()?.as_chunks().0.to_vec();
        let count = means.len();

        let opacity = npz.array("opacity")?;
        let right = opacity.shape == [count, 1] || opacity.shape == [count];
        opacity.shaped(right, &format!("({count}, 1), one a Gaussian"))?;
        let opacities = opacity.halves()?;
        if let Some(at) = opacities.iter().position(|o| !(0.0..=1.0).contains(o)) {
            let what = format!("element {at}");
            return Err(opacity.wrong(&what, opacities[at], "0 to 1"));
        }
        // Infinite of 0 and 1, which is what those are the sigmoid of.
        let logit = |o: &f32| (f64::from(*o) / (1.0 - f64::from(*o))).ln() as f32;

        let stages = Stages::read(&npz.array("rvq_info")?)?;
        let book = stages.codebooks::<3>(&npz.array("codebook_scale")?, name)?;
        let scales = stages.decode(count, &npz.array("scale")?, &book)?;
        let book = stages.codebooks::<4>(&npz.array("codebook_rotation")?, name)?;
        let rotations = stages.decode(count, &npz.array("rotation")?, &book)?;
        let axes = scales.into_par_iter().zip(rotations).with_min_len(1 << 10);
        let (log_scales, rotations) = axes.map(|(s, r)| shape::axes(s, r)).unzip();

        let grid = npz.array("hash")?.halves()?;
        let network = npz.array("mlp")?.halves()?;
        let colour = HashedColour::new(&grid, &network);
        let gaussians = Cloud::new(
            0,
            means,
            log_scales,
            rotations,
            opacities.iter().map(logit).collect(),
            vec![[0.0; 3]; count],
        );
        Ok(Self {
            gaussians: gaussians.map_err(|e| name.cloud(e))?,
            colour: colour.map_err(|e| name.part("colour", e))?,
        })
    }

    /// Its Gaussians, all of the same colour.
    #[must_use]
    pub const fn gaussians(&self) -> &Cloud {
        &self.gaussians
    }

    /// What gives them their colour.
    #[must_use]
    pub const fn colour(&self) -> &HashedColour {
        &self.colour
    }

    /// The Gaussians in the colours that a camera at `eye` sees them in.
    #[must_use]
    pub fn seen_from(&self, eye: DVec3) -> Cloud {
        let means = self.gaussians.means();
        let colours = means.par_iter().map_init(Vec::new, |scratch, mean| {
            let at = DVec3::from(mean.map(f64::from));
            let direction = (at - eye).normalize_or_zero();
            let colour = self.colour.at(at, direction, scratch);
            colour.to_array().map(|v| v as f32)
        });
        self.gaussians.recoloured(colours.collect())
    }

    /// The same in the hardware's formats: features are gathered and colours
    /// computed through `units`, which are those of `config`; `work` says what is done. With what
    /// was counted.
    ///
    /// # Errors
    /// A configuration whose units lack what it needs, values that no format
    /// holds, or a unit that fails.
    pub fn seen_in_codes(
        &self,
        eye: DVec3,
        config: &Config,
        work: FieldWork,
        units: &mut dyn Units,
    ) -> Result<(Cloud, FixedStats), FieldError> {
        let centres = self.centres();
        let fixed = FixedColour::new(&self.colour, &centres, config)?;
        let mut stats = FixedStats::default();
        let colours = fixed.seen_from(eye, &centres, work, units, &mut stats)?;
        Ok((self.gaussians.recoloured(colours), stats))
    }

    /// What a Gaussian's colour in the hardware's formats may be off by at most, seen from `eye`.
    ///
    /// # Errors
    /// As [`Compact::seen_in_codes`], but for units.
    pub fn colours_off(&self, eye: DVec3, config: &Config) -> Result<f64, FieldError> {
        let off = self.colour.off(&self.centres(), eye, config)?;
        Ok(sh::basis(DVec3::X)[0] * off)
    }

    fn centres(&self) -> Vec<DVec3> {
        let means = self.gaussians.means().iter();
        means.map(|m| DVec3::from(m.map(f64::from))).collect()
    }
}
