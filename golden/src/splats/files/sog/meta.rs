//! The `meta.json` of an SOG file.

use serde::Deserialize;
use serde_json::Value;

use super::super::error::{FileError, Origin};
use super::PALETTE_ROW;
use crate::splats::sh;

/// Entries of a codebook, one for each value of a byte.
const CODES: usize = 256;
/// The largest palette of coefficients.
const LARGEST_PALETTE: usize = 1 << 16;

/// What the images mean. Fields that do not bear on it, the writer's name for
/// one, are read past.
#[derive(Debug, Deserialize)]
pub(super) struct Meta {
    /// Gaussians.
    pub(super) count: usize,
    /// Centres.
    pub(super) means: Means,
    scales: Coded,
    quats: Files<1>,
    sh0: Coded,
    /// Coefficients above the constant.
    #[serde(rename = "shN")]
    pub(super) harmonics: Option<Harmonics>,
}

/// Ranges of `sign(v) ln(|v| + 1)`.
#[derive(Debug, Deserialize)]
pub(super) struct Means {
    /// Smallest value along each axis.
    pub(super) mins: [f64; 3],
    /// Largest value along each axis.
    pub(super) maxs: [f64; 3],
    files: [String; 2],
}

#[derive(Debug, Deserialize)]
struct Coded {
    codebook: Vec<f32>,
    files: [String; 1],
}

#[derive(Debug, Deserialize)]
struct Files<const N: usize>
where
    [String; N]: for<'a> Deserialize<'a>,
{
    files: [String; N],
}

/// The palette of coefficients above the constant.
#[derive(Debug, Deserialize)]
pub(super) struct Harmonics {
    /// Entries, 1 to 65,536.
    pub(super) count: usize,
    bands: usize,
    /// 256 values.
    pub(super) codebook: Vec<f32>,
    files: [String; 2],
}

impl Meta {
    /// Which of [`Self::files`] is the image of the palette.
    pub(super) const CENTROIDS: usize = 5;

    /// Reads the file; everything but the count of Gaussians is in its range.
    pub(super) fn parse(text: &[u8], name: Origin<'_>) -> Result<Self, FileError> {
        let mut value: Value =
            serde_json::from_slice(text).map_err(|e| name.part("meta.json", e))?;
        match value.get("version") {
            Some(Value::Number(n)) if n.as_u64() == Some(2) => {}
            Some(other) => return Err(name.field("version", other, "2")),
            None => return Err(name.field("version", "missing", "2: write it again as SOG 2")),
        }
        repair_codebooks(&mut value);
        let meta: Self = serde_path_to_error::deserialize(value).map_err(|e| {
            let field = format!("meta.json: field `{}`", e.path());
            name.part(field, e.inner())
        })?;
        meta.check(name)?;
        Ok(meta)
    }

    fn check(&self, name: Origin<'_>) -> Result<(), FileError> {
        for (field, range) in [
            ("means.mins", self.means.mins),
            ("means.maxs", self.means.maxs),
        ] {
            // A centre beyond e^88 is infinite in 32-bit floats.
            if let Some(value) = range.iter().find(|v| v.is_nan() || v.abs() > 88.0) {
                return Err(name.field(field, value, "-88 to 88"));
            }
        }
        let harmonics = self.harmonics.as_ref();
        for (field, codebook) in [
            ("scales.codebook", Some(&self.scales.codebook)),
            ("sh0.codebook", Some(&self.sh0.codebook)),
            ("shN.codebook", harmonics.map(|h| &h.codebook)),
        ] {
            let length = codebook.map_or(CODES, Vec::len);
            if length != CODES {
                let field = format!("number of values of `{field}`");
                return Err(name.field(field, length, CODES.to_string()));
            }
        }
        if let Some(h) = harmonics {
            if !(1..=sh::MAX_DEGREE).contains(&h.bands) {
                return Err(name.field("shN.bands", h.bands, "1 to 3"));
            }
            if !(1..=LARGEST_PALETTE).contains(&h.count) {
                let expected = format!("1 to {LARGEST_PALETTE}");
                return Err(name.field("shN.count", h.count, expected));
            }
        }
        Ok(())
    }

    /// Fields that name images, and the names.
    pub(super) fn files(&self) -> Vec<(&'static str, &str)> {
        let mut files = vec![
            ("means.files[0]", self.means.files[0].as_str()),
            ("means.files[1]", &self.means.files[1]),
            ("scales.files[0]", &self.scales.files[0]),
            ("quats.files[0]", &self.quats.files[0]),
            ("sh0.files[0]", &self.sh0.files[0]),
        ];
        if let Some(h) = &self.harmonics {
            files.push(("shN.files[0]", &h.files[0]));
            files.push(("shN.files[1]", &h.files[1]));
        }
        files
    }

    /// Degree of the spherical harmonics, 0 to 3.
    pub(super) fn degree(&self) -> usize {
        self.harmonics.as_ref().map_or(0, |h| h.bands)
    }

    /// Width and least height of the image of the palette.
    pub(super) fn palette_size(&self) -> Option<[u32; 2]> {
        self.harmonics.as_ref().map(|h| {
            let width = PALETTE_ROW * (sh::coefficients(h.bands) - 1);
            [width as u32, h.count.div_ceil(PALETTE_ROW) as u32]
        })
    }

    /// The log scale of a code.
    pub(super) fn scale(&self, code: u8) -> f32 {
        self.scales.codebook[usize::from(code)]
    }

    /// The constant coefficient of a code.
    pub(super) fn constant(&self, code: u8) -> f32 {
        self.sh0.codebook[usize::from(code)]
    }
}

/// Some writers leave `null` for the first of a codebook's values, which
/// ascend; PlayCanvas's own reader puts the mean step below the second.
fn repair_codebooks(value: &mut Value) {
    for part in ["scales", "sh0", "shN"] {
        let codebook = value.get_mut(part).and_then(|v| v.get_mut("codebook"));
        let Some(Value::Array(codes)) = codebook else {
            continue;
        };
        let ends = codes
            .get(1)
            .and_then(Value::as_f64)
            .zip(codes.last().and_then(Value::as_f64));
        if let (Some(first @ Value::Null), Some((second, last))) = (codes.first_mut(), ends) {
            *first = Value::from(second + (second - last) / 255.0);
        }
    }
}
