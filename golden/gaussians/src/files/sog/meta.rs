//! The `meta.json` of an SOG file.

use std::collections::HashSet;

use serde_json::Value;

use super::super::error::{FileError, Origin};
use super::{FORMAT, PALETTE_ROW, entries};
use potamoi_base::file_keys::{FileKeys, Notes};
use potamoi_base::sh;

/// Entries of a codebook, one for each value of a byte.
const CODES: usize = 256;
/// The largest palette of coefficients.
const LARGEST_PALETTE: usize = 1 << 16;
/// The byte order mark that some editors prepend.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The description of the images.
#[derive(Debug)]
pub(super) struct Meta {
    /// Number of Gaussians.
    pub(super) count: usize,
    /// Ranges of the centres.
    pub(super) means: Means,
    scales: Coded,
    quats: [String; 1],
    sh0: Coded,
    /// Coefficients above the constant.
    pub(super) harmonics: Option<Harmonics>,
    /// Whether the cloud was trained with antialiasing.
    pub(super) antialiased: bool,
    /// The program that wrote the file.
    pub(super) generator: Option<String>,
}

/// Ranges of `sign(v) ln(|v| + 1)`.
#[derive(Debug)]
pub(super) struct Means {
    /// Smallest value along each axis.
    pub(super) mins: [f64; 3],
    /// Largest value along each axis.
    pub(super) maxs: [f64; 3],
    files: [String; 2],
}

#[derive(Debug)]
struct Coded {
    codebook: Vec<f32>,
    files: [String; 1],
}

/// The palette of coefficients above the constant.
#[derive(Debug)]
pub(super) struct Harmonics {
    /// Number of entries, 1 to 65,536.
    pub(super) count: usize,
    bands: usize,
    /// The codebook, 256 values.
    pub(super) codebook: Vec<f32>,
    files: [String; 2],
}

impl Meta {
    /// Index of the palette image in [`Self::files`].
    pub(super) const CENTROIDS: usize = 5;
    /// Indices of the images whose alpha holds codes: rotations and colours.
    pub(super) const WITH_ALPHA: [usize; 2] = [3, 4];

    /// Reads the file and checks every range except the number of Gaussians.
    pub(super) fn parse(
        text: &[u8],
        notes: &mut Notes,
        name: Origin<'_>,
    ) -> Result<Self, FileError> {
        let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
        let all = entries::read(text).map_err(|e| {
            let place = format!("line {}, column {}: this is no JSON", e.line(), e.column());
            name.part("meta.json", place)
        })?;
        let Some(all) = all else {
            return Err(name.part("meta.json", "an object in braces is expected"));
        };
        let mut seen = HashSet::new();
        if let Some((twice, _)) = all.iter().find(|(key, _)| !seen.insert(key)) {
            let field = format!("meta.json: field `{twice}`");
            return Err(name.field(field, "given twice", "it once"));
        }
        match all.iter().find(|(key, _)| key == "version") {
            Some((_, value)) if whole(value) == Some(2) => {}
            Some((_, other)) => return Err(name.field("version", other, "2")),
            None => return Err(name.field("version", "missing", "2: write it again as SOG 2")),
        }
        let has_harmonics = all.iter().any(|(key, _)| key.starts_with("shN."));
        let mut fields = Fields {
            record: FileKeys::new(&FORMAT, all),
            notes,
            name,
        };
        fields.record.take("version");
        // It stays listed: it is no part of the picture.
        let generator = fields.record.peek("asset.generator");
        let generator = generator.and_then(Value::as_str).map(str::to_owned);
        let none = fields.record.take("shN").filter(|own| !own.is_null());
        if none.is_some() {
            return Err(fields.wrong(
                "shN",
                none.as_ref(),
                "an object with count, bands, codebook and files, or null",
            ));
        }
        let count = fields.count("count")?;
        let means = Means {
            mins: fields.range("means.mins")?,
            maxs: fields.range("means.maxs")?,
            files: fields.texts("means.files")?,
        };
        for (least, most) in means.mins.iter().zip(means.maxs) {
            if *least > most {
                let expected = format!("at most its `means.maxs`, {most}");
                return Err(name.field("means.mins", least, expected));
            }
        }
        let meta = Self {
            count,
            means,
            scales: fields.coded("scales")?,
            quats: fields.texts("quats.files")?,
            sh0: fields.coded("sh0")?,
            harmonics: match has_harmonics {
                true => Some(fields.harmonics()?),
                false => None,
            },
            antialiased: fields.antialiased()?,
            generator,
        };
        (fields.record.finish(notes)).map_err(|e| name.key(e))?;
        Ok(meta)
    }

    /// Fields that name images, with the names.
    pub(super) fn files(&self) -> Vec<(&'static str, &str)> {
        let mut files = vec![
            ("means.files[0]", self.means.files[0].as_str()),
            ("means.files[1]", &self.means.files[1]),
            ("scales.files[0]", &self.scales.files[0]),
            ("quats.files[0]", &self.quats[0]),
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

    /// Width and minimum height of the palette image.
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

/// The fields of the file that have not been read.
struct Fields<'a> {
    record: FileKeys<Value>,
    notes: &'a mut Notes,
    name: Origin<'a>,
}

impl Fields<'_> {
    fn wrong(&self, key: &str, value: Option<&Value>, expected: &str) -> FileError {
        let field = format!("meta.json: field `{key}`");
        let value = match value {
            None => "missing".to_owned(),
            // Fields of other objects are told one by one.
            Some(Value::Object(_)) => "empty".to_owned(),
            Some(value) => shown(value),
        };
        self.name.field(field, value, expected)
    }

    fn count(&mut self, key: &str) -> Result<usize, FileError> {
        let value = self.record.take(key);
        let count = value.as_ref().and_then(whole);
        count
            .and_then(|own| usize::try_from(own).ok())
            .ok_or_else(|| self.wrong(key, value.as_ref(), "a whole number"))
    }

    fn texts<const N: usize>(&mut self, key: &str) -> Result<[String; N], FileError> {
        let value = self.record.take(key);
        let texts = value.as_ref().and_then(Value::as_array).and_then(|all| {
            let texts = all.iter().map(|own| own.as_str().map(str::to_owned));
            texts.collect::<Option<Vec<String>>>()
        });
        texts
            .and_then(|all| all.try_into().ok())
            .ok_or_else(|| self.wrong(key, value.as_ref(), &format!("names of files, {N} of them")))
    }

    fn numbers(&mut self, key: &str, value: Option<&Value>) -> Result<Vec<f64>, FileError> {
        let numbers = value.and_then(Value::as_array).and_then(|all| {
            let numbers = all
                .iter()
                .map(|own| own.as_f64().filter(|v| (*v as f32).is_finite()));
            numbers.collect::<Option<Vec<f64>>>()
        });
        numbers.ok_or_else(|| self.wrong(key, value, "a list of numbers of 32 bits"))
    }

    /// Limits of a range along three axes. A centre beyond e^88 overflows 32-bit floats.
    fn range(&mut self, key: &str) -> Result<[f64; 3], FileError> {
        let value = self.record.take(key);
        let all = self.numbers(key, value.as_ref())?;
        let Ok(all) = <[f64; 3]>::try_from(all) else {
            return Err(self.wrong(key, value.as_ref(), "three numbers"));
        };
        match all.iter().find(|v| v.abs() > 88.0) {
            Some(value) => Err(self.name.field(key, value, "-88 to 88")),
            None => Ok(all),
        }
    }

    fn codebook(&mut self, key: &str) -> Result<Vec<f32>, FileError> {
        let mut value = self.record.take(key);
        if value.as_mut().is_some_and(repair_codebook) {
            self.notes
                .assume(format!("the first value of {key}, which is null"));
        }
        let all = self.numbers(key, value.as_ref())?;
        if all.len() != CODES {
            let field = format!("number of values of `{key}`");
            return Err(self.name.field(field, all.len(), CODES.to_string()));
        }
        Ok(all.into_iter().map(|v| v as f32).collect())
    }

    fn coded(&mut self, part: &str) -> Result<Coded, FileError> {
        Ok(Coded {
            codebook: self.codebook(&format!("{part}.codebook"))?,
            files: self.texts(&format!("{part}.files"))?,
        })
    }

    fn harmonics(&mut self) -> Result<Harmonics, FileError> {
        let own = Harmonics {
            count: self.count("shN.count")?,
            bands: self.count("shN.bands")?,
            codebook: self.codebook("shN.codebook")?,
            files: self.texts("shN.files")?,
        };
        if !(1..=sh::MAX_DEGREE).contains(&own.bands) {
            return Err(self.name.field("shN.bands", own.bands, "1 to 3"));
        }
        if !(1..=LARGEST_PALETTE).contains(&own.count) {
            let expected = format!("1 to {LARGEST_PALETTE}");
            return Err(self.name.field("shN.count", own.count, expected));
        }
        Ok(own)
    }

    /// The antialiasing flag: a field of its own, or part of the model.
    fn antialiased(&mut self) -> Result<bool, FileError> {
        let flag = match self.record.take("antialias") {
            None | Some(Value::Null) => None,
            Some(Value::Bool(flag)) => Some(flag),
            Some(other) => return Err(self.wrong("antialias", Some(&other), "true or false")),
        };
        let model = match self.record.take("model") {
            None | Some(Value::Null) => None,
            Some(Value::String(model)) if model == "antialiased" => Some(true),
            Some(Value::String(model)) if model == "default" => Some(false),
            Some(other) => {
                return Err(self.wrong("model", Some(&other), "antialiased or default"));
            }
        };
        match (flag, model) {
            (Some(flag), Some(model)) if flag != model => {
                let expected = "what `model` says of it";
                Err(self.wrong("antialias", Some(&Value::Bool(flag)), expected))
            }
            _ => Ok(flag.or(model).unwrap_or(false)),
        }
    }
}

/// A whole number, written with or without a decimal point.
fn whole(value: &Value) -> Option<u64> {
    let float = value.as_f64();
    let float = float.filter(|v| v.fract() == 0.0 && (0.0..9e15).contains(v));
    value.as_u64().or(float.map(|v| v as u64))
}

/// The beginning of a value, for error messages.
fn shown(value: &Value) -> String {
    let text = value.to_string();
    let mut start: String = text.chars().take(60).collect();
    if start.len() < text.len() {
        start.push_str("...");
    }
    start
}

/// Repairs a codebook whose first value is `null`, as some writers leave it. The values ascend;
/// PlayCanvas's reader puts the first one mean step below the second, and so does this one.
/// Returns whether a repair was needed.
fn repair_codebook(value: &mut Value) -> bool {
    let Value::Array(codes) = value else {
        return false;
    };
    let ends = codes
        .get(1)
        .and_then(Value::as_f64)
        .zip(codes.last().and_then(Value::as_f64));
    match (codes.first_mut(), ends) {
        (Some(first @ Value::Null), Some((second, last))) => {
            *first = Value::from(second + (second - last) / 255.0);
            true
        }
        _ => false,
    }
}
