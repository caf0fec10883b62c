//! Compact-3DGS (Lee, Rho, Sun, Ko, Park: Compact 3D Gaussian Representation for Radiance Field,
//! CVPR 2024): Gaussians whose scales and rotations are sums of codes, and whose colours come from
//! a neural field.
//!
//! For a camera it becomes an ordinary [`Cloud`] of degree 0: the field is evaluated for every
//! Gaussian before anything is drawn, as in its authors' renderer.
//!
//! The file is the plain `.npz` of their `save_npz`. Its codebooks are PyTorch pickles, which are
//! read as data; arrays of numbers, (stages, codes, 3 and 4) in 32 bits, are accepted in their
//! place. The field is computed in 64 bits, whereas the authors round features and layers to 16.

mod codes;
mod npz;
mod shape;
#[cfg(test)]
mod tests;

use std::path::Path;

use glam::DVec3;
use potamoi_formats::config::Config;
use rayon::prelude::*;

use codes::Stages;
use npz::Npz;
use potamoi_base::file_keys::{Fate, FileKeys, Format, Notes, key};
use potamoi_base::sh;
use potamoi_fields::{FieldError, FieldWork, FixedColour, HashedColour};
use potamoi_gaussians::Axes;
use potamoi_gaussians::Cloud;
use potamoi_gaussians::Raw;
use potamoi_gaussians::files::{self, FileError, Origin};
use potamoi_march::FixedStats;
use potamoi_reference::Units;

/// File extension of a model.
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
    /// The Gaussians without colours.
    gaussians: Cloud,
    colour: HashedColour,
    /// Axes of the file, in which colours are evaluated.
    axes: Axes,
}

/// Keys of the format: arrays of the archive.
pub static FORMAT: Format = Format {
    name: "Compact-3DGS",
    files: "`.npz`: arrays of the archive",
    keys: &[
        key("xyz", Fate::Honoured, "centres, f2 (N, 3)"),
        key("opacity", Fate::Honoured, "f2 (N, 1), 0 to 1"),
        key("scale", Fate::Honoured, "codes, u1"),
        key("rotation", Fate::Honoured, "codes, u1"),
        key("hash", Fate::Honoured, "tables of the colours' field, f2"),
        key(
            "mlp*",
            Fate::Whole,
            "matrices of its perceptron, one array, f2 (8192,)",
        ),
        key(
            "codebook_scale",
            Fate::Honoured,
            "a pickle, read as data, or f4 (stages, codes, 3)",
        ),
        key(
            "codebook_rotation",
            Fate::Honoured,
            "a pickle, read as data, or f4 (stages, codes, 4)",
        ),
        key(
            "rvq_info",
            Fate::Honoured,
            "stages and bits of a code, i8 (2,)",
        ),
        key(
            "huftable_*",
            Fate::Refused,
            "Huffman codes of the post-processed variant; expected is the plain one, point_cloud.npz, which is written without --comp",
        ),
        key("comment of *", Fate::Listed, "of the archive"),
        key("bytes before *", Fate::Listed, "what precedes the archive"),
        key("bytes after *", Fate::Listed, "what follows the archive"),
    ],
    others: Fate::Listed,
};

impl Compact {
    /// Loads a model, `.npz`, with its unused parts and assumptions. It is converted from the axes
    /// `asked`, by default right, down and front.
    ///
    /// # Errors
    /// The file cannot be read, is not such a model, or is its post-processed variant.
    pub fn load(path: &Path, asked: Option<Axes>) -> Result<(Self, Notes), FileError> {
        let origin = path.display().to_string();
        Self::parse(&files::whole(path)?, &origin, asked)
    }

    /// Reads a model from a file's bytes; `origin` names it in errors.
    ///
    /// # Errors
    /// Those of [`Compact::load`].
    pub fn parse(
        bytes: &[u8],
        origin: &str,
        asked: Option<Axes>,
    ) -> Result<(Self, Notes), FileError> {
        let name = Origin(origin);
        let mut npz = Npz::open(bytes, name)?;
        let mut record = FileKeys::new(&FORMAT, npz.keys().map(|own| (own, ())));
        for own in ARRAYS {
            record.take(own);
        }
        let mut notes = Notes::default();
        record.finish(&mut notes).map_err(|e| name.key(e))?;
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
        let colour = colour.map_err(|e| name.part("colour", e))?;
        let raw = Raw::new(gaussians.map_err(|e| name.cloud(e))?, notes);
        let axes = asked.unwrap_or(raw.usual);
        let loaded = raw.turned(asked);
        let model = Self {
            gaussians: loaded.cloud,
            colour,
            axes,
        };
        Ok((model, loaded.notes))
    }

    /// Sets the antialiasing flag.
    pub const fn set_antialiased(&mut self, antialiased: bool) {
        self.gaussians.set_antialiased(antialiased);
    }

    /// Centres in the axes of the file, in which colours are evaluated.
    #[must_use]
    pub fn asked_at(&self) -> Vec<[f32; 3]> {
        let means = self.gaussians.means().iter();
        means.map(|own| self.axes.point_of_file(*own)).collect()
    }

    /// The Gaussians, all of the same colour.
    #[must_use]
    pub const fn gaussians(&self) -> &Cloud {
        &self.gaussians
    }

    /// The field of their colours.
    #[must_use]
    pub const fn colour(&self) -> &HashedColour {
        &self.colour
    }

    /// The Gaussians with the colours that a camera at `eye` sees.
    #[must_use]
    pub fn seen_from(&self, eye: DVec3) -> Cloud {
        let means = self.asked_at();
        let eye = self.axes.of_file(eye);
        let colours = means.par_iter().map_init(Vec::new, |scratch, mean| {
            let at = DVec3::from(mean.map(f64::from));
            let direction = (at - eye).normalize_or_zero();
            let colour = self.colour.at(at, direction, scratch);
            colour.to_array().map(|v| v as f32)
        });
        self.gaussians.recoloured(colours.collect())
    }

    /// The Gaussians with fixed-point colours: features are gathered and colours computed through
    /// `units`, which must be those of `config`; `work` selects optional parts. Also returns the
    /// counts.
    ///
    /// # Errors
    /// The configuration's units lack an operation or format, a value fits no format, or a unit
    /// fails.
    pub(crate) fn seen_in_codes(
        &self,
        eye: DVec3,
        config: &Config,
        work: FieldWork,
        units: &mut dyn Units,
    ) -> Result<(Cloud, FixedStats), FieldError> {
        let centres = self.centres();
        let eye = self.axes.of_file(eye);
        let fixed = FixedColour::new(&self.colour, &centres, config)?;
        let mut stats = FixedStats::default();
        let colours = fixed.seen_from(eye, &centres, work, units, &mut stats)?;
        Ok((self.gaussians.recoloured(colours), stats))
    }

    /// Upper bound of the error of a Gaussian's fixed-point colour, seen from `eye`.
    ///
    /// # Errors
    /// The colour field has no fixed-point form for the configuration.
    pub fn colours_off(&self, eye: DVec3, config: &Config) -> Result<f64, FieldError> {
        let off = (self.colour).off(&self.centres(), self.axes.of_file(eye), config)?;
        Ok(sh::basis(DVec3::X)[0] * off)
    }

    fn centres(&self) -> Vec<DVec3> {
        let means = self.asked_at().into_iter();
        means.map(|m| DVec3::from(m.map(f64::from))).collect()
    }
}
